//! The header of a PLY file.

use crate::error::{FormatError, InFile};
use crate::text::{number, quote, tokens};

/// The encoding of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl NumberType {
    fn from_name(name: &[u8]) -> Option<NumberType> {
        Some(match name {
            b"char" | b"int8" => NumberType::I8,
            b"uchar" | b"uint8" => NumberType::U8,
            b"short" | b"int16" => NumberType::I16,
            b"ushort" | b"uint16" => NumberType::U16,
            b"int" | b"int32" => NumberType::I32,
            b"uint" | b"uint32" => NumberType::U32,
            b"float" | b"float32" => NumberType::F32,
            b"double" | b"float64" => NumberType::F64,
            _ => return None,
        })
    }

    /// Size in a binary file, bytes.
    pub fn size(self) -> usize {
        match self {
            NumberType::I8 | NumberType::U8 => 1,
            NumberType::I16 | NumberType::U16 => 2,
            NumberType::I32 | NumberType::U32 | NumberType::F32 => 4,
            NumberType::F64 => 8,
        }
    }

    /// The value of a colour component at full intensity.
    pub fn full_intensity(self) -> f64 {
        match self {
            NumberType::U8 => 255.0,
            NumberType::U16 => 65535.0,
            _ => 1.0,
        }
    }
}

/// A property of an element.
#[derive(Debug, Clone)]
pub(super) struct Property {
    pub name: String,
    /// Type of the value, or of the items of a list.
    pub number_type: NumberType,
    /// Type of the length of a list; `None` for a single value.
    pub list: Option<NumberType>,
}

/// An element: a table with `count` rows.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Smallest size of a row, bytes.
    pub fn min_row_size(&self, encoding: Encoding) -> usize {
        self.properties
            .iter()
            .map(|p| match (encoding, p.list) {
                (Encoding::Text, _) => 2,
                (_, Some(length)) => length.size(),
                (_, None) => p.number_type.size(),
            })
            .sum()
    }
}

/// The header of a file.
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    pub comments: Vec<String>,
    /// Start of the body, byte.
    pub body: usize,
}

/// Parses the header.
pub(super) fn parse(bytes: &[u8], file: InFile) -> Result<Header, FormatError> {
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut comments = Vec::new();
    let mut lines = Lines {
        bytes,
        at: bytes.len() - bytes.trim_ascii_start().len(),
        number: 0,
        file,
    };
    check_first_line(lines.next()?, file)?;
    loop {
        let line = lines.next()?;
        let words: Vec<&[u8]> = tokens(line).collect();
        match words[..] {
            [b"format", name, _] => encoding = Some(lines.encoding(name, line)?),
            [b"element", name, count] => elements.push(Element {
                name: String::from_utf8_lossy(name).into_owned(),
                count: number(count)
                    .ok_or_else(|| lines.malformed(line, "`element`, a name and a count"))?,
                properties: Vec::new(),
            }),
            [b"property", ref rest @ ..] => {
                let property = property(rest)
                    .ok_or_else(|| lines.malformed(line, "`property`, a number type and a name"))?;
                let element = elements
                    .last_mut()
                    .ok_or_else(|| lines.malformed(line, "an `element` before its properties"))?;
                element.properties.push(property);
            }
            [b"comment" | b"obj_info", ..] => {
                comments.push(String::from_utf8_lossy(&line[7..]).trim().to_owned());
            }
            [b"end_header"] => break,
            [] => {}
            _ => {
                let right = "format, element, property, comment or end_header";
                return Err(lines.malformed(line, right));
            }
        }
    }
    let Some(encoding) = encoding else {
        let right = "a line such as `format ascii 1.0`";
        return Err(file.malformed("header", "no `format` line", right));
    };
    Ok(Header {
        encoding,
        elements,
        comments,
        body: lines.at,
    })
}

/// The lines of the header, one after another.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Number of the last line.
    number: usize,
    file: InFile<'a>,
}

impl<'a> Lines<'a> {
    /// Reads the next line.
    fn next(&mut self) -> Result<&'a [u8], FormatError> {
        self.number += 1;
        let rest = &self.bytes[self.at..];
        let Some(length) = rest.iter().position(|&b| b == b'\n' || b == b'\r') else {
            return Err(self.file.truncated(
                format!("header, line {}", self.number),
                quote(rest),
                "`end_header` and a line ending",
            ));
        };
        // Lines end with LF, CR LF, or, from old Macs, CR.
        let is_pair = rest[length..].starts_with(b"\r\n");
        self.at += length + if is_pair { 2 } else { 1 };
        Ok(&rest[..length])
    }

    /// The error for the last line.
    fn malformed(&self, line: &[u8], right: &str) -> FormatError {
        let place = format!("header, line {}", self.number);
        self.file.malformed(place, quote(line), right)
    }

    fn encoding(&self, name: &[u8], line: &[u8]) -> Result<Encoding, FormatError> {
        match name {
            b"ascii" => Ok(Encoding::Text),
            b"binary_little_endian" => Ok(Encoding::LittleEndian),
            b"binary_big_endian" => Ok(Encoding::BigEndian),
            _ => {
                let right = "ascii, binary_little_endian or binary_big_endian";
                Err(self.malformed(line, right))
            }
        }
    }
}

/// Refuses files that do not start with `ply`.
fn check_first_line(line: &[u8], file: InFile) -> Result<(), FormatError> {
    if tokens(line).eq([b"ply"]) {
        return Ok(());
    }
    Err(FormatError::NotThisFormat {
        file: file.0.to_owned(),
        format: "PLY",
        found: format!("the first line is {}", quote(line)),
        right: "`ply`".to_owned(),
    })
}

/// Parses the words after `property`.
fn property(words: &[&[u8]]) -> Option<Property> {
    let (list, number_type, name) = match *words {
        [b"list", length, items, name] => {
            let length = NumberType::from_name(length)
                .filter(|k| !matches!(k, NumberType::F32 | NumberType::F64))?;
            (Some(length), items, name)
        }
        [number_type, name] => (None, number_type, name),
        _ => return None,
    };
    Some(Property {
        name: String::from_utf8_lossy(name).into_owned(),
        number_type: NumberType::from_name(number_type)?,
        list,
    })
}
