//! LAS 1.0 to 1.4 and LAZ (ASPRS LAS specification 1.4 R15). Of a point the coordinates, the colour and the marks
//! `withheld` and `noise` are read.

use super::CloudFile;
use crate::error::{FormatError, InFile};
use glam::DVec3;
use laz::{LasZipDecompressor, LazVlr};
use std::io::{Cursor, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Bytes of the header that every version has.
const LEAST_HEADER: usize = 227;
/// Bytes of the header of version 1.4, whose counts have 64 bits.
const WIDE_HEADER: usize = 375;
/// Bytes before the content of a variable length record.
const RECORD_HEADER: usize = 54;
/// Points decompressed at once.
const BATCH: usize = 8192;

/// What the header says.
struct Header {
    compressed: bool,
    format: u8,
    record: usize,
    count: u64,
    start: usize,
    header_size: usize,
    records: u32,
    scale: DVec3,
    offset: DVec3,
}

/// Whether the header of a LAS file says that its points are compressed.
pub(crate) fn is_compressed(bytes: &[u8]) -> bool {
    bytes.get(104).is_some_and(|f| f & 0xc0 != 0)
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let mut out = [0; N];
    if let Some(part) = at.checked_add(N).and_then(|end| bytes.get(at..end)) {
        out.copy_from_slice(part);
    }
    out
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(array(bytes, at))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array(bytes, at))
}

fn vector_at(bytes: &[u8], at: usize) -> DVec3 {
    let number = |k: usize| f64::from_le_bytes(array(bytes, at + 8 * k));
    DVec3::new(number(0), number(1), number(2))
}

fn header(bytes: &[u8], file: InFile) -> Result<Header, FormatError> {
    if !bytes.starts_with(b"LASF") {
        return Err(FormatError::NotThisFormat {
            file: file.0.to_owned(),
            format: "LAS",
            found: "the first four bytes are others".to_owned(),
            right: "`LASF`".to_owned(),
        });
    }
    if bytes.len() < LEAST_HEADER {
        let found = format!("{} bytes", bytes.len());
        return Err(file.truncated("header", found, format!("{LEAST_HEADER} bytes at least")));
    }
    let version = (bytes[24], bytes[25]);
    if version.0 != 1 || version.1 > 4 {
        let found = format!("LAS version {}.{}", version.0, version.1);
        return Err(file.unsupported(found, "save it as LAS 1.2 or 1.4"));
    }
    let wide = version.1 == 4 && bytes.len() >= WIDE_HEADER;
    let format = bytes[104] & 0x3f;
    let header = Header {
        compressed: is_compressed(bytes),
        format,
        record: usize::from(u16_at(bytes, 105)),
        count: match u32_at(bytes, 107) {
            0 if wide => u64::from_le_bytes(array(bytes, 247)),
            legacy => u64::from(legacy),
        },
        start: u32_at(bytes, 96) as usize,
        header_size: usize::from(u16_at(bytes, 94)),
        records: u32_at(bytes, 100),
        scale: vector_at(bytes, 131),
        offset: vector_at(bytes, 155),
    };
    if header.format > 10 {
        let found = format!("point format {format}");
        return Err(file.unsupported(found, "save it with point format 0 to 10"));
    }
    let least = least_record(header.format);
    if header.record < least {
        return Err(file.malformed(
            "header",
            format!("records of {} bytes", header.record),
            format!("at least {least} for point format {format}"),
        ));
    }
    if !header.scale.is_finite() || !header.offset.is_finite() || header.scale.min_element() <= 0.0
    {
        return Err(file.malformed(
            "header",
            format!("scale {} and offset {}", header.scale, header.offset),
            "finite numbers, the scale above 0",
        ));
    }
    if header.header_size < LEAST_HEADER || header.start < header.header_size {
        return Err(file.malformed(
            "header",
            format!(
                "a size of {} bytes and points from byte {}",
                header.header_size, header.start
            ),
            "points after the header",
        ));
    }
    if header.start > bytes.len() {
        let found = format!("points from byte {} of {}", header.start, bytes.len());
        return Err(file.truncated("header", found, "a start inside the file"));
    }
    Ok(header)
}

/// Bytes of a point in each format.
fn least_record(format: u8) -> usize {
    [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67][usize::from(format.min(10))]
}

/// Where the colour of a point is.
fn colour_at(format: u8) -> Option<usize> {
    match format {
        2 => Some(20),
        3 | 5 => Some(28),
        7 | 8 | 10 => Some(30),
        _ => None,
    }
}

/// Reads LAS and LAZ.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<CloudFile, FormatError> {
    let file = InFile(name);
    let header = header(bytes, file)?;
    if header.count == 0 {
        return Err(FormatError::Empty {
            file: name.to_owned(),
            format: "LAS",
        });
    }
    let mut points = Points::new(&header);
    if header.compressed {
        decompress(bytes, &header, &mut points, file)?;
    } else {
        let body = &bytes[header.start..];
        let count = usize::try_from(header.count).unwrap_or(usize::MAX);
        file.check_count("points", count, header.record, body.len())?;
        body.chunks_exact(header.record)
            .take(count)
            .for_each(|record| points.push(record));
    }
    Ok(points.finish(name))
}

/// Points as they come out of the records.
struct Points<'a> {
    header: &'a Header,
    colour: Option<usize>,
    points: Vec<DVec3>,
    colours: Vec<[u16; 3]>,
    marked: usize,
}

impl<'a> Points<'a> {
    fn new(header: &'a Header) -> Self {
        Points {
            header,
            colour: colour_at(header.format),
            points: Vec::new(),
            colours: Vec::new(),
            marked: 0,
        }
    }

    fn push(&mut self, record: &[u8]) {
        // Classes 7 and 18 are noise; the mark `withheld` is a bit beside or within the class.
        let (class, withheld) = if self.header.format < 6 {
            (record[15] & 0x1f, record[15] & 0x80 != 0)
        } else {
            (record[16], record[15] & 0x04 != 0)
        };
        if withheld || class == 7 || (class == 18 && self.header.format >= 6) {
            self.marked += 1;
            return;
        }
        let whole = |at: usize| f64::from(i32::from_le_bytes(array(record, at)));
        let stored = DVec3::new(whole(0), whole(4), whole(8));
        self.points
            .push(stored * self.header.scale + self.header.offset);
        if let Some(at) = self.colour {
            self.colours.push([0, 2, 4].map(|k| u16_at(record, at + k)));
        }
    }

    fn finish(self, name: &str) -> CloudFile {
        let mut out = CloudFile::default();
        out.cloud.points = self.points;
        let most = self.colours.iter().flatten().copied().max().unwrap_or(0);
        if most > 0 {
            // The standard asks for 16 bits; many programs store 8.
            let shift = if most > 255 { 8 } else { 0 };
            let byte = |v: u16| (v >> shift) as u8;
            out.cloud.colours = self.colours.iter().map(|c| c.map(byte)).collect();
        }
        if self.marked > 0 {
            out.notes.push(format!(
                "{name}: {} points that the file marks as withheld or noise were dropped.",
                self.marked
            ));
        }
        out
    }
}

/// The content of the record that says how points are compressed.
fn compression<'a>(
    bytes: &'a [u8],
    header: &Header,
    file: InFile,
) -> Result<&'a [u8], FormatError> {
    let mut at = header.header_size;
    for number in 0..header.records {
        let end = at + RECORD_HEADER;
        if end > header.start {
            let found = format!("record {number} beyond byte {}", header.start);
            let right = format!("{} records before the points", header.records);
            return Err(file.malformed("variable length records", found, right));
        }
        let length = usize::from(u16_at(bytes, at + 20));
        let ours = bytes[at + 2..at + 18].starts_with(b"laszip encoded");
        if ours && u16_at(bytes, at + 18) == 22204 {
            return bytes.get(end..end + length).ok_or_else(|| {
                let found = format!("record {number} of {length} bytes");
                file.truncated("variable length records", found, "all of it")
            });
        }
        at = end + length;
    }
    Err(file.malformed(
        "variable length records",
        "none of `laszip encoded`",
        "the one that says how points are compressed",
    ))
}

/// Refuses a table of chunks that claims more of them than there are points: the decompressor would take it at its word.
fn check_chunks(bytes: &[u8], header: &Header, file: InFile) -> Result<(), FormatError> {
    let mut table = i64::from_le_bytes(array(bytes, header.start));
    if table == -1 && bytes.len() >= 8 {
        table = i64::from_le_bytes(array(bytes, bytes.len() - 8));
    }
    let Some(at) = usize::try_from(table).ok().filter(|at| *at < bytes.len()) else {
        return Ok(());
    };
    let claimed = u32_at(bytes, at.saturating_add(4)) as usize;
    let possible = usize::try_from(header.count).unwrap_or(usize::MAX);
    // No chunk takes less than a byte.
    file.check_count("chunk table", claimed, 1, possible.min(bytes.len()))
}

fn decompress(
    bytes: &[u8],
    header: &Header,
    points: &mut Points,
    file: InFile,
) -> Result<(), FormatError> {
    let damaged =
        |found: String| file.malformed("compressed points", found, "undamaged LASzip data");
    let vlr = LazVlr::from_buffer(compression(bytes, header, file)?)
        .map_err(|e| damaged(e.to_string()))?;
    if vlr.items().is_empty() || vlr.items_size() != header.record as u64 {
        let found = format!("items of {} bytes", vlr.items_size());
        let right = format!("{}, as the header says of a point", header.record);
        return Err(file.malformed("record `laszip encoded`", found, right));
    }
    check_chunks(bytes, header, file)?;
    // The decompressor trusts its input here and there and panics where that is damaged.
    let done = catch_unwind(AssertUnwindSafe(|| {
        let mut source = Cursor::new(bytes);
        source
            .seek(SeekFrom::Start(header.start as u64))
            .map_err(|e| damaged(e.to_string()))?;
        let mut decompressor =
            LasZipDecompressor::new(source, vlr).map_err(|e| damaged(e.to_string()))?;
        let mut buffer = vec![0; BATCH * header.record];
        let mut left = header.count;
        while left > 0 {
            let now = left.min(BATCH as u64) as usize;
            let part = &mut buffer[..now * header.record];
            decompressor.decompress_many(part).map_err(|e| {
                let found = format!("{e} within points {} and on", header.count - left);
                file.truncated(
                    "compressed points",
                    found,
                    format!("{} points", header.count),
                )
            })?;
            part.chunks_exact(header.record)
                .for_each(|record| points.push(record));
            left -= now as u64;
        }
        Ok(())
    }));
    done.unwrap_or_else(|_| Err(damaged("data that contradict themselves".to_owned())))
}
