//! The body of a PLY file, read number by number.

use super::header::{Element, Encoding, NumberType, Property};
use crate::error::{FormatError, InFile};
use crate::text::{number, quote};

/// The rest of the body.
pub(super) struct Body<'a> {
    pub bytes: &'a [u8],
    pub encoding: Encoding,
    pub file: InFile<'a>,
}

/// The row that is being read, for messages.
pub(super) struct Row<'a> {
    pub element: &'a Element,
    pub number: usize,
}

impl Row<'_> {
    fn place(&self) -> String {
        format!("{}, row {}", self.element.name, self.number)
    }
}

impl<'a> Body<'a> {
    /// Reads the bytes of a binary number, in little-endian order.
    fn take<const N: usize>(&mut self, row: &Row) -> Result<[u8; N], FormatError> {
        match self.bytes.split_first_chunk::<N>() {
            Some((head, rest)) => {
                self.bytes = rest;
                let mut bytes = *head;
                if self.encoding == Encoding::BigEndian {
                    bytes.reverse();
                }
                Ok(bytes)
            }
            None => Err(self.truncated(row)),
        }
    }

    fn truncated(&self, row: &Row) -> FormatError {
        let element = row.element;
        let found = format!("with {} bytes left in row {}", self.bytes.len(), row.number);
        self.file
            .truncated(&element.name, found, format!("{} rows", element.count))
    }

    /// Reads a token of text.
    fn token(&mut self, row: &Row) -> Result<&'a [u8], FormatError> {
        let rest = self.bytes.trim_ascii_start();
        if rest.is_empty() {
            return Err(self.truncated(row));
        }
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        let (token, rest) = rest.split_at(length);
        self.bytes = rest;
        Ok(token)
    }

    /// Reads a number.
    #[inline]
    pub fn number(&mut self, number_type: NumberType, row: &Row) -> Result<f64, FormatError> {
        if self.encoding == Encoding::Text {
            let token = self.token(row)?;
            return number(token)
                .ok_or_else(|| self.file.malformed(row.place(), quote(token), "a number"));
        }
        Ok(match number_type {
            NumberType::I8 => i8::from_le_bytes(self.take(row)?).into(),
            NumberType::U8 => u8::from_le_bytes(self.take(row)?).into(),
            NumberType::I16 => i16::from_le_bytes(self.take(row)?).into(),
            NumberType::U16 => u16::from_le_bytes(self.take(row)?).into(),
            NumberType::I32 => i32::from_le_bytes(self.take(row)?).into(),
            NumberType::U32 => u32::from_le_bytes(self.take(row)?).into(),
            NumberType::F32 => f32::from_le_bytes(self.take(row)?).into(),
            NumberType::F64 => f64::from_le_bytes(self.take(row)?),
        })
    }

    /// Reads the length of a list. A length that the rest of the body cannot hold is an error.
    pub fn list_length(
        &mut self,
        length_type: NumberType,
        item_type: NumberType,
        row: &Row,
    ) -> Result<usize, FormatError> {
        let length = self.number(length_type, row)?;
        if length < 0.0 || length.fract() != 0.0 {
            let right = "the length of a list";
            return Err(self.file.malformed(row.place(), length, right));
        }
        let item_size = if self.encoding == Encoding::Text {
            2
        } else {
            item_type.size()
        };
        if length as usize > (self.bytes.len() + 1) / item_size {
            let element = format!("the list in row {} of {}", row.number, row.element.name);
            self.file
                .check_count(&element, length as usize, item_size, self.bytes.len() + 1)?;
        }
        Ok(length as usize)
    }

    /// Skips a property.
    pub fn skip(&mut self, property: &Property, row: &Row) -> Result<(), FormatError> {
        let count = match property.list {
            Some(list) => self.list_length(list, property.number_type, row)?,
            None => 1,
        };
        for _ in 0..count {
            self.number(property.number_type, row)?;
        }
        Ok(())
    }

    /// Skips an element.
    pub fn skip_element(&mut self, element: &Element) -> Result<(), FormatError> {
        for number in 0..element.count {
            for property in &element.properties {
                self.skip(property, &Row { element, number })?;
            }
        }
        Ok(())
    }
}
