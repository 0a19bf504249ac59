//! Reading of comma-separated values (RFC 4180) as text.

use crate::error::{FormatError, InFile};
use std::iter::Peekable;
use std::str::Chars;

const FORMAT: &str = "CSV";

/// A row of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextRow {
    /// The line of the file that it begins in, from 1.
    pub line: usize,
    /// Its cells, as many as there are columns.
    pub cells: Vec<String>,
}

/// Comma-separated values: named columns of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextTable {
    /// Names of the columns, from the first line.
    pub columns: Vec<String>,
    /// The rows after it; lines without text are left out.
    pub rows: Vec<TextRow>,
}

/// Reads comma-separated values with a header line. Cells may be quoted, and quoted ones may hold commas, line breaks and
/// doubled quotes.
///
/// ```
/// use greenstick_formats::read_csv;
///
/// let table = read_csv(b"tree,\"density, g/cm3\"\n7,0.51\n", "birch.csv")?;
/// assert_eq!(table.columns, ["tree", "density, g/cm3"]);
/// assert_eq!(table.rows[0].cells, ["7", "0.51"]);
/// # Ok::<(), greenstick_formats::FormatError>(())
/// ```
///
/// # Errors
/// [`FormatError`] if the file is no UTF-8 text or has no header, a quote is not closed, or a row has another number of cells
/// than the header.
pub fn read_csv(bytes: &[u8], name: &str) -> Result<TextTable, FormatError> {
    let file = InFile(name);
    let text = std::str::from_utf8(bytes).map_err(|_| FormatError::NotThisFormat {
        file: name.to_owned(),
        format: FORMAT,
        found: "bytes that are no UTF-8 text".to_owned(),
        right: "text in UTF-8".to_owned(),
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut rows = split(text, &file)?.into_iter();
    let Some(header) = rows.next() else {
        return Err(FormatError::NotThisFormat {
            file: name.to_owned(),
            format: FORMAT,
            found: "no text".to_owned(),
            right: "a line with the names of columns".to_owned(),
        });
    };
    let table = TextTable {
        columns: header.cells,
        rows: rows.collect(),
    };
    let wide = table.columns.len();
    match table.rows.iter().find(|row| row.cells.len() != wide) {
        Some(row) => Err(file.malformed(
            format!("line {}", row.line),
            format!("{} cells", row.cells.len()),
            format!("{wide}, as many as the first line has names"),
        )),
        None => Ok(table),
    }
}

/// Splits text into rows with their cells, trimmed unless quoted.
fn split(text: &str, file: &InFile) -> Result<Vec<TextRow>, FormatError> {
    let mut reader = Reader {
        characters: text.chars().peekable(),
        line: 1,
    };
    let mut rows = Vec::new();
    while reader.characters.peek().is_some() {
        let line = reader.line;
        let mut cells = Vec::new();
        loop {
            let (cell, end) = reader.cell(file)?;
            cells.push(cell);
            if end != Some(',') {
                break;
            }
        }
        if cells.len() > 1 || !cells[0].is_empty() {
            rows.push(TextRow { line, cells });
        }
    }
    Ok(rows)
}

/// Reads cell after cell.
struct Reader<'a> {
    characters: Peekable<Chars<'a>>,
    line: usize,
}

impl Reader<'_> {
    /// Returns the next cell and what ended it: a comma, a line break, or nothing at the end of the text.
    fn cell(&mut self, file: &InFile) -> Result<(String, Option<char>), FormatError> {
        let (mut cell, mut quoted) = (String::new(), false);
        loop {
            match self.characters.next() {
                Some('"') if !quoted && cell.trim().is_empty() => {
                    (cell, quoted) = (self.quoted_text(file)?, true);
                }
                // Spaces around quotes, and carriage returns, mean nothing.
                Some(c) if quoted && c != '\n' && c.is_whitespace() => {}
                Some(c) if c != ',' && c != '\n' => cell.push(c),
                end => {
                    self.line += usize::from(end == Some('\n'));
                    let cell = if quoted { cell } else { cell.trim().to_owned() };
                    return Ok((cell, end));
                }
            }
        }
    }

    /// Returns the text up to the quote that closes it.
    fn quoted_text(&mut self, file: &InFile) -> Result<String, FormatError> {
        let opened = self.line;
        let mut text = String::new();
        loop {
            match self.characters.next() {
                Some('"') if self.characters.peek() != Some(&'"') => return Ok(text),
                Some('"') => {
                    self.characters.next();
                    text.push('"');
                }
                Some(c) => {
                    self.line += usize::from(c == '\n');
                    text.push(c);
                }
                None => {
                    let place = format!("line {opened}");
                    let right = "another quote behind the text";
                    return Err(file.malformed(place, "a quote that is not closed", right));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_line_breaks_and_empty_lines() {
        let text = "\u{feff}a, \"b \"\"x\"\"\" ,c\r\n1,\"two\nlines\",\r\n\r\n 3 ,,x";
        let table = read_csv(text.as_bytes(), "t.csv").unwrap();
        assert_eq!(table.columns, ["a", "b \"x\"", "c"]);
        let row = |line: usize, cells: [&str; 3]| TextRow {
            line,
            cells: cells.map(str::to_owned).to_vec(),
        };
        assert_eq!(
            table.rows,
            [row(2, ["1", "two\nlines", ""]), row(5, ["3", "", "x"])]
        );
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (bytes, parts) in [
            (&b"a,b\n1,2\n3\n"[..], ["line 3", "1 cells", "2, as many"]),
            (b"a,b\n1,\"2\n", ["line 2", "not closed", "another quote"]),
            (b"", ["not a CSV file", "no text", "names of columns"]),
            (b"\xff\xfe", ["not a CSV file", "UTF-8", "text"]),
        ] {
            let text = read_csv(bytes, "t.csv").unwrap_err().to_string();
            assert!(parts.iter().all(|p| text.contains(p)), "{text}");
        }
    }
}
