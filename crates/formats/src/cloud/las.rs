//! LAS 1.0 to 1.4 and LAZ (ASPRS LAS specification 1.4 R15). Coordinates, colours and the marks `withheld` and `noise` of
//! the points are read.

use super::CloudFile;
#[cfg(feature = "laz")]
use super::laz::{self, CompressedPoints, Damage, Description};
use crate::error::{FormatError, InFile};
use glam::DVec3;

/// Bytes of the header that every version has.
const MIN_HEADER_SIZE: usize = 227;
/// Bytes of the header of version 1.4, which has counts of 64 bits.
const HEADER_SIZE_1_4: usize = 375;
/// Bytes before the content of a variable length record.
#[cfg(feature = "laz")]
const VARIABLE_RECORD_HEADER_SIZE: usize = 54;
/// Number of the variable length record that describes the compression.
#[cfg(feature = "laz")]
const LASZIP_RECORD: u16 = 22204;
/// Bit of the flags of formats 0 to 5 that withholds a point; they share a byte with the classification.
const WITHHELD: u8 = 0x80;
/// Bit of the flags of formats 6 to 10 that withholds a point.
const WITHHELD_FROM_6: u8 = 0x04;
/// Class of noise.
const LOW_NOISE: u8 = 7;
/// Class of noise of formats 6 to 10.
const HIGH_NOISE: u8 = 18;

/// The content of the header.
struct Header {
    compressed: bool,
    point_format: u8,
    /// Bytes of a point.
    record_size: usize,
    count: u64,
    /// Where the points start.
    start: usize,
    size: usize,
    #[cfg(feature = "laz")]
    variable_records: u32,
    scale: DVec3,
    offset: DVec3,
}

/// Whether the points of a LAS file are compressed.
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

fn read_header(bytes: &[u8], file: InFile) -> Result<Header, FormatError> {
    if !bytes.starts_with(b"LASF") {
        return Err(FormatError::NotThisFormat {
            file: file.0.to_owned(),
            format: "LAS",
            found: "other bytes at the start".to_owned(),
            right: "`LASF`".to_owned(),
        });
    }
    if bytes.len() < MIN_HEADER_SIZE {
        let found = format!("{} bytes", bytes.len());
        return Err(file.truncated("header", found, format!("at least {MIN_HEADER_SIZE} bytes")));
    }
    let version = (bytes[24], bytes[25]);
    if version.0 != 1 || version.1 > 4 {
        let found = format!("LAS version {}.{}", version.0, version.1);
        return Err(file.unsupported(found, "save it as LAS 1.2 or 1.4"));
    }
    let wide_counts = version.1 == 4 && bytes.len() >= HEADER_SIZE_1_4;
    let point_format = bytes[104] & 0x3f;
    let header = Header {
        compressed: is_compressed(bytes),
        point_format,
        record_size: usize::from(u16_at(bytes, 105)),
        count: match u32_at(bytes, 107) {
            0 if wide_counts => u64::from_le_bytes(array(bytes, 247)),
            legacy => u64::from(legacy),
        },
        start: u32_at(bytes, 96) as usize,
        size: usize::from(u16_at(bytes, 94)),
        #[cfg(feature = "laz")]
        variable_records: u32_at(bytes, 100),
        scale: vector_at(bytes, 131),
        offset: vector_at(bytes, 155),
    };
    if point_format > 10 {
        let found = format!("point format {point_format}");
        return Err(file.unsupported(found, "save it with point format 0 to 10"));
    }
    let least = min_record_size(point_format);
    if header.record_size < least {
        return Err(file.malformed(
            "header",
            format!("records of {} bytes", header.record_size),
            format!("at least {least} for point format {point_format}"),
        ));
    }
    if !header.scale.is_finite() || !header.offset.is_finite() || header.scale.min_element() <= 0.0
    {
        return Err(file.malformed(
            "header",
            format!(
                "scale {} and offset {}",
                short(header.scale),
                short(header.offset)
            ),
            "finite numbers, and a scale above 0",
        ));
    }
    if header.size < MIN_HEADER_SIZE || header.start < header.size {
        return Err(file.malformed(
            "header",
            format!(
                "a size of {} bytes and points from byte {}",
                header.size, header.start
            ),
            "points after the header",
        ));
    }
    if header.start > bytes.len() {
        let found = format!("points from byte {} of {}", header.start, bytes.len());
        return Err(file.truncated("header", found, "a start within the file"));
    }
    Ok(header)
}

/// Bytes of a point of a format; records may be longer.
fn min_record_size(point_format: u8) -> usize {
    [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67][usize::from(point_format.min(10))]
}

/// Where the colour of a point is.
fn colour_offset(point_format: u8) -> Option<usize> {
    match point_format {
        2 => Some(20),
        3 | 5 => Some(28),
        7 | 8 | 10 => Some(30),
        _ => None,
    }
}

/// Reads LAS and LAZ.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<CloudFile, FormatError> {
    let file = InFile(name);
    let header = read_header(bytes, file)?;
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
        file.check_count("points", count, header.record_size, body.len())?;
        body.chunks_exact(header.record_size)
            .take(count)
            .for_each(|record| points.push(record));
    }
    Ok(points.finish(name))
}

/// Collects points from their records.
struct Points<'a> {
    header: &'a Header,
    /// Where the colour is in a record.
    colour_offset: Option<usize>,
    points: Vec<DVec3>,
    colours: Vec<[u16; 3]>,
    /// Number of points marked as withheld or noise, which are left out.
    dropped: usize,
}

impl<'a> Points<'a> {
    fn new(header: &'a Header) -> Self {
        Points {
            header,
            colour_offset: colour_offset(header.point_format),
            points: Vec::new(),
            colours: Vec::new(),
            dropped: 0,
        }
    }

    fn push(&mut self, record: &[u8]) {
        let from_6 = self.header.point_format >= 6;
        let is_dropped = if from_6 {
            record[15] & WITHHELD_FROM_6 != 0 || [LOW_NOISE, HIGH_NOISE].contains(&record[16])
        } else {
            record[15] & WITHHELD != 0 || record[15] & 0x1f == LOW_NOISE
        };
        if is_dropped {
            self.dropped += 1;
            return;
        }
        let integer = |at: usize| f64::from(i32::from_le_bytes(array(record, at)));
        let stored = DVec3::new(integer(0), integer(4), integer(8));
        self.points
            .push(stored * self.header.scale + self.header.offset);
        if let Some(at) = self.colour_offset {
            self.colours.push([0, 2, 4].map(|k| u16_at(record, at + k)));
        }
    }

    fn finish(self, name: &str) -> CloudFile {
        let mut out = CloudFile::default();
        out.cloud.points = self.points;
        let largest = self.colours.iter().flatten().copied().max().unwrap_or(0);
        if largest > 0 {
            // The specification requires 16 bits; many programs store 8.
            let shift = if largest > 255 { 8 } else { 0 };
            let byte = |v: u16| (v >> shift) as u8;
            out.cloud.colours = self.colours.iter().map(|c| c.map(byte)).collect();
        }
        if self.dropped > 0 {
            out.notes.push(format!(
                "{name}: {} points marked as withheld or noise were dropped.",
                self.dropped
            ));
        }
        out
    }
}

/// The content of the record that describes the compression.
#[cfg(feature = "laz")]
fn compression<'a>(
    bytes: &'a [u8],
    header: &Header,
    file: InFile,
) -> Result<&'a [u8], FormatError> {
    let mut at = header.size;
    for number in 0..header.variable_records {
        let end = at + VARIABLE_RECORD_HEADER_SIZE;
        if end > header.start {
            let found = format!("record {number} beyond byte {}", header.start);
            let right = format!("{} records before the points", header.variable_records);
            return Err(file.malformed("variable length records", found, right));
        }
        let length = usize::from(u16_at(bytes, at + 20));
        let of_laszip = bytes[at + 2..at + 18].starts_with(b"laszip encoded");
        if of_laszip && u16_at(bytes, at + 18) == LASZIP_RECORD {
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
        "one that describes the compression",
    ))
}

#[cfg(feature = "laz")]
fn decompress(
    bytes: &[u8],
    header: &Header,
    points: &mut Points,
    file: InFile,
) -> Result<(), FormatError> {
    let content = compression(bytes, header, file)?;
    let description = Description::read(content, header.record_size)
        .map_err(|e| file.malformed("record `laszip encoded`", e.found, e.right))?;
    let compressed = CompressedPoints {
        data: bytes,
        start: header.start,
        count: header.count,
        record_size: header.record_size,
    };
    laz::decompress(&compressed, &description, &mut |record| points.push(record)).map_err(|e| {
        let found = format!("{} at point {}", e.damage, e.point);
        let right = format!("{} points", header.count);
        match e.damage {
            Damage::Truncated => file.truncated("compressed points", found, right),
            Damage::Contradictory => {
                file.malformed("compressed points", found, "undamaged LASzip data")
            }
        }
    })
}

#[cfg(not(feature = "laz"))]
fn decompress(_: &[u8], _: &Header, _: &mut Points, file: InFile) -> Result<(), FormatError> {
    Err(file.unsupported("compressed points", "save it as LAS without compression"))
}

/// Writes a damaged vector, whose numbers may have hundreds of digits.
fn short(v: DVec3) -> String {
    format!("[{:e}, {:e}, {:e}]", v.x, v.y, v.z)
}
