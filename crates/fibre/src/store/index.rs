//! Frames by number: where each one begins in a frame store.

use super::frames::{FrameReader, fill, header};
use super::{Frame, StoreError};
use std::io::{Read, Seek, SeekFrom};

/// A frame store of which any frame can be read. Frames that a killed run left unfinished are not counted.
pub struct FrameFile<R> {
    from: R,
    /// Where each frame's record begins, and its time (s).
    frames: Vec<(u64, f64)>,
    /// Bytes behind the last whole frame.
    left: u64,
}

impl<R: Read + Seek> FrameFile<R> {
    /// Finds the frames; of each no more than its length and time is read.
    ///
    /// # Errors
    /// [`StoreError`] for what is no frame store, or a newer one.
    pub fn open(mut from: R) -> Result<Self, StoreError> {
        let end = from.seek(SeekFrom::End(0))?;
        from.seek(SeekFrom::Start(0))?;
        let mut at = header(&mut from)?;
        let mut frames = Vec::new();
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
            frames.push((at, f64::from_bits(number(time))));
            at = next;
        }
        Ok(FrameFile {
            from,
            frames,
            left: end - at.min(end),
        })
    }

    /// Number of whole frames.
    pub fn count(&self) -> usize {
        self.frames.len()
    }

    /// Time of frame `number`, s, which must be below [`FrameFile::count`].
    pub fn time(&self, number: usize) -> f64 {
        self.frames[number].1
    }

    /// Bytes behind the last whole frame: more than none where a run was cut short.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Reads frame `number`; none beyond the last.
    ///
    /// # Errors
    /// [`StoreError`] where it is damaged or cannot be read.
    pub fn read(&mut self, number: usize) -> Result<Option<Frame>, StoreError> {
        let Some(&(at, _)) = self.frames.get(number) else {
            return Ok(None);
        };
        self.from.seek(SeekFrom::Start(at))?;
        FrameReader::at(&mut self.from, number).next().transpose()
    }
}
