//! `.usdz` archives: ZIP files whose members are not compressed and start at multiples of 64 bytes (*USDZ
//! Specification*).

use crate::companions::Encoded;
use crate::sink::Sink;
use std::io::{Error, Result, SeekFrom};

const ALIGNMENT: u64 = 64;
/// Header ID of the padding before a member, as in OpenUSD.
const PADDING_ID: u16 = 0x1986;
/// 1 January 1980, the first date of ZIP.
const DATE: u16 = 0x21;

/// Writes a member. Returns its length and its checksum.
pub(super) type WriteMember<'f> = &'f mut dyn FnMut(&mut dyn Sink) -> Result<(u64, u32)>;

/// A member of the archive.
struct Member {
    name: String,
    crc: u32,
    length: u32,
    offset: u32,
}

/// An archive under construction.
struct Archive<'a> {
    out: &'a mut dyn Sink,
    base: u64,
    members: Vec<Member>,
}

/// Little-endian bytes of 16-bit words.
fn words(list: &[u16]) -> impl Iterator<Item = u8> + '_ {
    list.iter().flat_map(|w| w.to_le_bytes())
}

/// Little-endian bytes of 32-bit words.
fn longs(list: &[u32]) -> impl Iterator<Item = u8> + '_ {
    list.iter().flat_map(|w| w.to_le_bytes())
}

/// A length in 32 bits.
fn length_32(length: u64) -> Result<u32> {
    u32::try_from(length)
        .map_err(|_| Error::other(format!("{length} bytes exceed the 4 GiB of a USDZ archive")))
}

impl<'a> Archive<'a> {
    /// Starts an archive at the current position of `out`.
    pub fn new(out: &'a mut dyn Sink) -> Result<Self> {
        let base = out.stream_position()?;
        Ok(Archive {
            out,
            base,
            members: Vec::new(),
        })
    }

    /// Adds a member.
    pub fn add(&mut self, name: &str, write: WriteMember) -> Result<()> {
        let offset = self.out.stream_position()? - self.base;
        let before = offset + 30 + name.len() as u64;
        let mut padding = before.next_multiple_of(ALIGNMENT) - before;
        // Padding has a header of 4 bytes.
        if (1..4).contains(&padding) {
            padding += ALIGNMENT;
        }
        let head = |crc: u32, length: u32| {
            let mut head = Vec::with_capacity(padding as usize + 30 + name.len());
            head.extend(b"PK\x03\x04");
            head.extend(words(&[10, 0, 0, 0, DATE]));
            head.extend(longs(&[crc, length, length]));
            head.extend(words(&[name.len() as u16, padding as u16]));
            head.extend(name.bytes());
            if padding > 0 {
                head.extend(words(&[PADDING_ID, padding as u16 - 4]));
                head.resize(head.len() + padding as usize - 4, 0);
            }
            head
        };
        self.out.write_all(&head(0, 0))?;
        let (length, crc) = write(self.out)?;
        let end = self.out.stream_position()?;
        let length = length_32(length)?;
        self.out.seek(SeekFrom::Start(self.base + offset))?;
        self.out.write_all(&head(crc, length))?;
        self.out.seek(SeekFrom::Start(end))?;
        self.members.push(Member {
            name: name.to_owned(),
            crc,
            length,
            offset: length_32(offset)?,
        });
        Ok(())
    }

    /// Finishes the archive. Returns its length.
    pub fn finish(self) -> Result<u64> {
        let offset = self.out.stream_position()? - self.base;
        let mut list = Vec::new();
        for m in &self.members {
            list.extend(b"PK\x01\x02");
            list.extend(words(&[10, 10, 0, 0, 0, DATE]));
            list.extend(longs(&[m.crc, m.length, m.length]));
            list.extend(words(&[m.name.len() as u16, 0, 0, 0, 0]));
            list.extend(longs(&[0, m.offset]));
            list.extend(m.name.bytes());
        }
        let count = self.members.len() as u16;
        let length = list.len() as u32;
        list.extend(b"PK\x05\x06");
        list.extend(words(&[0, 0, count, count]));
        list.extend(longs(&[length, length_32(offset)?]));
        list.extend(words(&[0]));
        self.out.write_all(&list)?;
        self.out.flush()?;
        Ok(offset + list.len() as u64)
    }
}

/// Writes an archive of a layer and its textures. Returns its length.
pub(super) fn write_archive(
    out: &mut dyn Sink,
    layer_name: &str,
    write_layer: WriteMember,
    files: &[Encoded],
) -> Result<u64> {
    let mut archive = Archive::new(out)?;
    archive.add(layer_name, write_layer)?;
    for file in files {
        let mut crc = flate2::Crc::new();
        crc.update(&file.bytes);
        archive.add(&file.name, &mut |out: &mut dyn Sink| {
            out.write_all(&file.bytes)?;
            Ok((file.bytes.len() as u64, crc.sum()))
        })?;
    }
    archive.finish()
}
