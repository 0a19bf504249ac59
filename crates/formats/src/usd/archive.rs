//! A `.usdz` archive: a ZIP file whose members are not packed and begin at multiples of 64 bytes (USDZ specification).

use crate::film::Sink;
use std::io::{Error, Result, SeekFrom};

const ALIGNMENT: u64 = 64;
/// Mark of the room before a member, as OpenUSD writes it.
const ROOM: u16 = 0x1986;
/// 1 January 1980, the first day that ZIP knows.
const DAY: u16 = 0x21;

/// Writes a member; gives the length and the checksum of what it wrote.
pub type Fill<'f> = &'f mut dyn FnMut(&mut dyn Sink) -> Result<(u64, u32)>;

struct Member {
    name: String,
    crc: u32,
    length: u32,
    place: u32,
}

/// An archive under construction.
pub struct Archive<'a> {
    out: &'a mut dyn Sink,
    base: u64,
    members: Vec<Member>,
}

fn words(list: &[u16]) -> impl Iterator<Item = u8> + '_ {
    list.iter().flat_map(|w| w.to_le_bytes())
}

fn longs(list: &[u32]) -> impl Iterator<Item = u8> + '_ {
    list.iter().flat_map(|w| w.to_le_bytes())
}

fn small(length: u64) -> Result<u32> {
    u32::try_from(length)
        .map_err(|_| Error::other(format!("{length} bytes are more than the 4 GiB of a USDZ")))
}

impl<'a> Archive<'a> {
    /// Begins an archive where `out` stands.
    pub fn new(out: &'a mut dyn Sink) -> Result<Self> {
        let base = out.stream_position()?;
        Ok(Archive {
            out,
            base,
            members: Vec::new(),
        })
    }

    /// Adds a member.
    pub fn add(&mut self, name: &str, fill: Fill) -> Result<()> {
        let place = self.out.stream_position()? - self.base;
        let before = place + 30 + name.len() as u64;
        let mut room = before.next_multiple_of(ALIGNMENT) - before;
        // Room has a head of 4 bytes.
        if (1..4).contains(&room) {
            room += ALIGNMENT;
        }
        let head = |crc: u32, length: u32| {
            let mut head = Vec::with_capacity(room as usize + 30 + name.len());
            head.extend(b"PK\x03\x04");
            head.extend(words(&[10, 0, 0, 0, DAY]));
            head.extend(longs(&[crc, length, length]));
            head.extend(words(&[name.len() as u16, room as u16]));
            head.extend(name.bytes());
            if room > 0 {
                head.extend(words(&[ROOM, room as u16 - 4]));
                head.resize(head.len() + room as usize - 4, 0);
            }
            head
        };
        self.out.write_all(&head(0, 0))?;
        let (length, crc) = fill(self.out)?;
        let end = self.out.stream_position()?;
        let length = small(length)?;
        self.out.seek(SeekFrom::Start(self.base + place))?;
        self.out.write_all(&head(crc, length))?;
        self.out.seek(SeekFrom::Start(end))?;
        self.members.push(Member {
            name: name.to_owned(),
            crc,
            length,
            place: small(place)?,
        });
        Ok(())
    }

    /// Ends the archive; gives its length.
    pub fn finish(self) -> Result<u64> {
        let place = self.out.stream_position()? - self.base;
        let mut list = Vec::new();
        for m in &self.members {
            list.extend(b"PK\x01\x02");
            list.extend(words(&[10, 10, 0, 0, 0, DAY]));
            list.extend(longs(&[m.crc, m.length, m.length]));
            list.extend(words(&[m.name.len() as u16, 0, 0, 0, 0]));
            list.extend(longs(&[0, m.place]));
            list.extend(m.name.bytes());
        }
        let count = self.members.len() as u16;
        let length = list.len() as u32;
        list.extend(b"PK\x05\x06");
        list.extend(words(&[0, 0, count, count]));
        list.extend(longs(&[length, small(place)?]));
        list.extend(words(&[0]));
        self.out.write_all(&list)?;
        self.out.flush()?;
        Ok(place + list.len() as u64)
    }
}
