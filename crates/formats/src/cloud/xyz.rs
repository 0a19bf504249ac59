//! XYZ: lines of numbers, whose columns are identified by a header line or by their values.

use super::file::CloudFile;
use crate::error::{FormatError, InFile};
use crate::text::{lines, number, quote};
use glam::DVec3;

/// Rows by which normals and colours are recognised.
const SAMPLE_ROWS: usize = 2000;

/// The meaning of columns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Columns {
    points: [usize; 3],
    normals: Option<[usize; 3]>,
    colours: Option<[usize; 3]>,
}

/// The numbers of a file, row by row.
struct Rows {
    /// Numbers in a row.
    width: usize,
    values: Vec<f64>,
    /// Names of the columns.
    header: Option<Vec<String>>,
}

/// Reads XYZ.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<CloudFile, FormatError> {
    let file = InFile(name);
    let table = read_rows(bytes, file)?;
    let rows = table.values.chunks_exact(table.width);
    let named = table.header.as_deref().and_then(from_header);
    let columns = named.unwrap_or_else(|| guess(&table));
    let mut out = CloudFile::default();
    let triple = |row: &[f64], at: [usize; 3]| DVec3::from_array(at.map(|k| row[k]));
    out.cloud.points = rows.clone().map(|r| triple(r, columns.points)).collect();
    if let Some(at) = columns.normals {
        let unit = |r| triple(r, at).normalize_or_zero();
        out.cloud.normals = rows.clone().map(unit).collect();
    }
    if let Some(at) = columns.colours {
        // Colours range from 0 to 1 if none exceeds 1, otherwise to 255, from some programs to 65535.
        let largest = rows
            .clone()
            .flat_map(|r| at.map(|k| r[k]))
            .fold(0.0, f64::max);
        let scale = match largest {
            m if m <= 1.0 => 255.0,
            m if m <= 255.0 => 1.0,
            _ => 255.0 / 65535.0,
        };
        let byte = |v: f64| (v * scale).round().clamp(0.0, 255.0) as u8;
        out.cloud.colours = rows.map(|r| at.map(|k| byte(r[k]))).collect();
    }
    out.notes
        .push(interpretation(&columns, table.width, named.is_some(), name));
    Ok(out)
}

/// Describes how the columns were interpreted.
fn interpretation(columns: &Columns, width: usize, named: bool, name: &str) -> String {
    let from_one = |at: [usize; 3]| at.map(|k| (k + 1).to_string()).join(", ");
    let mut text = format!(
        "{name}: columns {} are coordinates",
        from_one(columns.points)
    );
    let mut used = columns.points.to_vec();
    for (kind, at) in [("normals", columns.normals), ("colours", columns.colours)] {
        if let Some(at) = at {
            text += &format!(", {} {kind}", from_one(at));
            used.extend(at);
        }
    }
    let rest: Vec<String> = (0..width)
        .filter(|k| !used.contains(k))
        .map(|k| (k + 1).to_string())
        .collect();
    if !rest.is_empty() {
        text += &format!(", {} were dropped", rest.join(", "));
    }
    text + if named {
        ", as the header says."
    } else {
        ", by their values."
    }
}

/// Whether a line is a comment.
fn is_comment(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.starts_with(b"//") || line.starts_with(b"%")
}

/// The words of a line. Commas are separators, unless there are semicolons: then they are decimal points.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let semicolons = line.contains(&b';');
    line.split(move |b| b.is_ascii_whitespace() || *b == b';' || (*b == b',' && !semicolons))
        .filter(|w| !w.is_empty())
}

/// Parses a number, possibly with a decimal comma.
fn value(word: &[u8]) -> Option<f64> {
    if word.contains(&b',') {
        let point: Vec<u8> = word
            .iter()
            .map(|&b| if b == b',' { b'.' } else { b })
            .collect();
        return number(&point);
    }
    number(word)
}

/// The names of columns, if the line contains `x`, `y` and `z`.
fn header_names(line: &[u8]) -> Option<Vec<String>> {
    let bare: &[u8] = line.trim_ascii();
    let start = bare.iter().position(|b| !b"#/%".contains(b))?;
    let names: Vec<String> = words(&bare[start..])
        .map(|w| {
            String::from_utf8_lossy(w)
                .trim_matches('"')
                .to_ascii_lowercase()
        })
        .collect();
    let has = |name: &str| names.iter().any(|n| n == name);
    (has("x") && has("y") && has("z")).then_some(names)
}

/// Reads all lines.
fn read_rows(bytes: &[u8], file: InFile) -> Result<Rows, FormatError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut table = Rows {
        width: 0,
        values: Vec::new(),
        header: None,
    };
    let mut first = 0;
    let mut declared: Option<DeclaredCount> = None;
    let last = lines(bytes)
        .filter(|(_, l)| !l.trim_ascii().is_empty())
        .last()
        .map_or(0, |(at, _)| at);
    for (at, line) in lines(bytes) {
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        if table.width == 0
            && let Some(names) = header_names(line)
        {
            table.header = Some(names);
            continue;
        }
        if is_comment(line) {
            continue;
        }
        let before = table.values.len();
        for word in words(line) {
            let Some(v) = value(word) else {
                return Err(not_a_number(table.width == 0, at, word, file));
            };
            table.values.push(v);
        }
        let width = table.values.len() - before;
        if table.width == 0 && width == 1 && declared.is_none() {
            // PTS files start with the number of points.
            let claimed = table.values.pop().unwrap_or_default();
            if !(claimed >= 0.0 && claimed.fract() == 0.0) {
                return Err(file.malformed(
                    format_args!("line {at}"),
                    quote(line),
                    "three coordinates, or the number of points",
                ));
            }
            declared = Some(DeclaredCount {
                line: at,
                count: claimed as usize,
            });
        } else if table.width == 0 {
            if width < 3 {
                let place = format_args!("line {at}");
                return Err(file.malformed(place, quote(line), "at least x, y and z"));
            }
            (table.width, first) = (width, at);
        } else if width != table.width {
            let right = format!("{} as in line {first}", table.width);
            let found = format!("{width} numbers, {}", quote(line));
            return Err(if at == last && width < table.width {
                file.truncated(format_args!("line {at}"), found, right)
            } else {
                file.malformed(format_args!("line {at}"), found, right)
            });
        }
    }
    finish(table, declared, file)
}

/// The error for a word that is not a number.
fn not_a_number(is_first: bool, at: usize, word: &[u8], file: InFile) -> FormatError {
    if is_first {
        return FormatError::NotThisFormat {
            file: file.0.to_owned(),
            format: "XYZ",
            found: format!("line {at} holds {}", quote(word)),
            right: "lines of numbers, x y z first".to_owned(),
        };
    }
    file.malformed(format_args!("line {at}"), quote(word), "a number")
}

/// The number of points that a file declares.
#[derive(Clone, Copy)]
struct DeclaredCount {
    line: usize,
    count: usize,
}

/// Checks the complete table.
fn finish(table: Rows, declared: Option<DeclaredCount>, file: InFile) -> Result<Rows, FormatError> {
    if table.width == 0 {
        return Err(file.malformed("file", "no line with a point", "lines of x, y and z"));
    }
    let rows = table.values.len() / table.width;
    if let Some(DeclaredCount { line, count }) = declared
        && count != rows
    {
        let found = format!("a count of {count}");
        let right = format!("{rows}, the number of lines that follow");
        return Err(if count > rows {
            file.truncated(format_args!("line {line}"), found, right)
        } else {
            file.malformed(format_args!("line {line}"), found, right)
        });
    }
    if let Some(names) = &table.header
        && names.len() != table.width
    {
        return Err(file.malformed(
            "header",
            format!("{} names of columns", names.len()),
            format!("{}, one for each number in a line", table.width),
        ));
    }
    Ok(table)
}

/// Identifies columns by their names.
fn from_header(names: &[String]) -> Option<Columns> {
    let at = |wanted: &[&str]| names.iter().position(|n| wanted.contains(&n.as_str()));
    let triple = |wanted: [&[&str]; 3]| -> Option<[usize; 3]> {
        Some([at(wanted[0])?, at(wanted[1])?, at(wanted[2])?])
    };
    Some(Columns {
        points: triple([&["x"], &["y"], &["z"]])?,
        normals: triple([
            &["nx", "normal_x", "normalx"],
            &["ny", "normal_y", "normaly"],
            &["nz", "normal_z", "normalz"],
        ]),
        colours: triple([&["r", "red"], &["g", "green"], &["b", "blue"]]),
    })
}

/// Identifies columns by their values: normals have length 1, colours are integers from 0 to 255 or fractions from 0 to 1.
fn guess(table: &Rows) -> Columns {
    let mut columns = Columns {
        points: [0, 1, 2],
        ..Columns::default()
    };
    let rows = || table.values.chunks_exact(table.width).take(SAMPLE_ROWS);
    let mut at = 3;
    while at + 3 <= table.width {
        let triples = || rows().map(|r| DVec3::new(r[at], r[at + 1], r[at + 2]));
        let total = triples().count();
        let count = |test: &dyn Fn(DVec3) -> bool| triples().filter(|v| test(*v)).count();
        let units = count(&|v| (v.length_squared() - 1.0).abs() < 0.02);
        let is_integer =
            |v: DVec3| v == v.round() && v.min_element() >= 0.0 && v.max_element() <= 255.0;
        let is_fraction = |v: DVec3| v.min_element() >= 0.0 && v.max_element() <= 1.0;
        let here = [at, at + 1, at + 2];
        // One in ten may be missing (zero) or damaged.
        if columns.normals.is_none() && units * 10 >= total * 9 {
            columns.normals = Some(here);
        } else if columns.colours.is_none()
            && (count(&is_integer) == total || count(&is_fraction) == total)
        {
            columns.colours = Some(here);
        } else {
            at += 1;
            continue;
        }
        at += 3;
    }
    columns
}
