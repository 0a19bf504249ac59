//! Random access to the frames of a store.

use super::error::StoreError;
use super::frames::{Frame, fill, header, read_frame};
use std::io::{Read, Seek, SeekFrom};

/// Where a frame's record begins, and its time.
#[derive(Debug, Clone, Copy)]
struct Record {
    offset: u64,
    /// s.
    time: f64,
}

/// A frame store of which any frame can be read. Frames that a killed run left incomplete are not counted.
pub struct IndexedFrames<R> {
    from: R,
    records: Vec<Record>,
    /// Bytes behind the last complete frame.
    trailing_bytes: u64,
}

impl<R: Read + Seek> IndexedFrames<R> {
    /// Finds the frames. Of each only its length and time is read.
    ///
    /// # Errors
    /// [`StoreError`] for bytes that are no frame store, or one of a newer version.
    pub fn open(mut from: R) -> Result<Self, StoreError> {
        let end = from.seek(SeekFrom::End(0))?;
        from.seek(SeekFrom::Start(0))?;
        let mut at = header(&mut from)?;
        let mut records = Vec::new();
        loop {
            from.seek(SeekFrom::Start(at))?;
            let mut head = [0; 16];
            if fill(&mut from, &mut head)? < 16 {
                break;
            }
            let (length, time) = head.split_at(8);
            let number = |b: &[u8]| b.try_into().map(u64::from_le_bytes).unwrap_or(0);
            let next = at
                .checked_add(number(length))
                .and_then(|n| n.checked_add(16));
            let Some(next) = next.filter(|&n| n <= end) else {
                break;
            };
            records.push(Record {
                offset: at,
                time: f64::from_bits(number(time)),
            });
            at = next;
        }
        Ok(IndexedFrames {
            from,
            records,
            trailing_bytes: end - at.min(end),
        })
    }

    /// Returns the number of complete frames.
    pub fn count(&self) -> usize {
        self.records.len()
    }

    /// Returns the time (s) of frame `number`, which must be below [`IndexedFrames::count`].
    pub fn time(&self, number: usize) -> f64 {
        self.records[number].time
    }

    /// Returns the number of bytes behind the last complete frame; above 0 where a run was cut short.
    pub fn trailing_bytes(&self) -> u64 {
        self.trailing_bytes
    }

    /// Reads frame `number`; `None` beyond the last.
    ///
    /// # Errors
    /// [`StoreError`] where it is damaged or cannot be read.
    pub fn read(&mut self, number: usize) -> Result<Option<Frame>, StoreError> {
        let Some(record) = self.records.get(number) else {
            return Ok(None);
        };
        self.from.seek(SeekFrom::Start(record.offset))?;
        read_frame(&mut self.from, number)
    }
}
