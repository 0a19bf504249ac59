//! The header of a PLY file.

use crate::error::{FormatError, InFile};
use crate::text::{number, shown, tokens};

/// How the body is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &[u8]) -> Option<Kind> {
        Some(match name {
            b"char" | b"int8" => Kind::I8,
            b"uchar" | b"uint8" => Kind::U8,
            b"short" | b"int16" => Kind::I16,
            b"ushort" | b"uint16" => Kind::U16,
            b"int" | b"int32" => Kind::I32,
            b"uint" | b"uint32" => Kind::U32,
            b"float" | b"float32" => Kind::F32,
            b"double" | b"float64" => Kind::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }

    /// What an unsigned colour has to be divided by; 1 for floating point ones.
    pub fn full(self) -> f64 {
        match self {
            Kind::U8 => 255.0,
            Kind::U16 => 65535.0,
            _ => 1.0,
        }
    }
}

/// A property of an element.
#[derive(Debug, Clone)]
pub struct Property {
    pub name: String,
    pub kind: Kind,
    /// The type of the length, for lists.
    pub list: Option<Kind>,
}

/// An element: a table with `count` rows.
#[derive(Debug, Clone)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Fewest bytes that one row can take.
    pub fn least_size(&self, encoding: Encoding) -> usize {
        self.properties
            .iter()
            .map(|p| match (encoding, p.list) {
                (Encoding::Text, _) => 2,
                (_, Some(length)) => length.size(),
                (_, None) => p.kind.size(),
            })
            .sum()
    }
}

/// The header and where the body begins.
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    pub comments: Vec<String>,
    pub body: usize,
}

/// Reads the header.
pub fn parse(bytes: &[u8], file: InFile) -> Result<Header, FormatError> {
    let mut header = Header {
        encoding: Encoding::Text,
        elements: Vec::new(),
        comments: Vec::new(),
        body: 0,
    };
    let mut has_encoding = false;
    let mut at = bytes.len() - bytes.trim_ascii_start().len();
    for line_number in 1.. {
        let rest = &bytes[at..];
        let Some(length) = rest.iter().position(|&b| b == b'\n' || b == b'\r') else {
            return Err(file.truncated(
                format!("header, line {line_number}"),
                shown(rest),
                "`end_header` and a line end",
            ));
        };
        let line = &rest[..length];
        // Lines end in LF, CR LF or, from old Macs, CR.
        at += length
            + if rest[length..].starts_with(b"\r\n") {
                2
            } else {
                1
            };
        let wrong =
            |right: &str| file.malformed(format!("header, line {line_number}"), shown(line), right);
        let words: Vec<&[u8]> = tokens(line).collect();
        match words[..] {
            [b"ply"] if line_number == 1 => {}
            _ if line_number == 1 => {
                return Err(FormatError::NotThisFormat {
                    file: file.0.to_owned(),
                    format: "PLY",
                    found: format!("the first line is {}", shown(line)),
                    right: "`ply`".to_owned(),
                });
            }
            [b"format", encoding, _] => {
                has_encoding = true;
                header.encoding = match encoding {
                    b"ascii" => Encoding::Text,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => {
                        return Err(wrong("ascii, binary_little_endian or binary_big_endian"));
                    }
                };
            }
            [b"element", name, count] => header.elements.push(Element {
                name: String::from_utf8_lossy(name).into_owned(),
                count: number(count).ok_or_else(|| wrong("`element`, a name and a count"))?,
                properties: Vec::new(),
            }),
            [b"property", ref rest @ ..] => {
                let property = match *rest {
                    [b"list", length, kind, name] => Kind::named(length)
                        .filter(|k| !matches!(k, Kind::F32 | Kind::F64))
                        .zip(Kind::named(kind))
                        .map(|(length, kind)| (Some(length), kind, name)),
                    [kind, name] => Kind::named(kind).map(|kind| (None, kind, name)),
                    _ => None,
                };
                let Some((list, kind, name)) = property else {
                    return Err(wrong("`property`, a number type and a name"));
                };
                let name = String::from_utf8_lossy(name).into_owned();
                let element = header
                    .elements
                    .last_mut()
                    .ok_or_else(|| wrong("an `element` before its properties"))?;
                element.properties.push(Property { name, kind, list });
            }
            [b"comment" | b"obj_info", ..] => {
                header
                    .comments
                    .push(String::from_utf8_lossy(&line[7..]).trim().to_owned());
            }
            [b"end_header"] => break,
            [] => {}
            _ => {
                return Err(wrong("format, element, property, comment or end_header"));
            }
        }
    }
    if !has_encoding {
        return Err(file.malformed(
            "header",
            "no `format` line",
            "`format ascii 1.0` or the like",
        ));
    }
    header.body = at;
    Ok(header)
}
