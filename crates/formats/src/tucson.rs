//! Ring widths in the Tucson (decadal) format of the International Tree-Ring Data Bank, `.rwl`.
//!
//! Three lines of header; then for every series lines with its name in columns 1 to 8, the year of the first width in columns
//! 9 to 12, and up to ten widths of six columns to the end of the decade. Widths are in units of 0.001 mm, as the mark after
//! the last one, −9999, says (999 would say 0.01 mm).

use crate::companions::Encoded;
use crate::error::{FormatError, InFile};

/// Columns of a series' name.
const NAME_COLUMNS: usize = 8;
/// Years that fit into four columns.
const YEARS: std::ops::RangeInclusive<i32> = -999..=9999;
/// What follows the last width in units of 0.001 mm.
const STOP: i64 = -9999;
/// Greatest width, in units, that fits into six columns with a space before it.
const MAX_UNITS: i64 = 99_999;
/// Units in a metre.
const UNITS_PER_METRE: f64 = 1e6;
/// Columns of the name of a site, and of a header's site number.
const SITE_NAME_COLUMNS: usize = 52;
const SITE_COLUMNS: usize = 6;

/// The widths of a core's rings.
#[derive(Debug, Clone, PartialEq)]
pub struct RingWidthSeries {
    /// Name: up to eight letters and digits.
    pub name: String,
    /// Year of the first width.
    pub first_year: i32,
    /// Widths, year by year, m.
    pub widths: Vec<f64>,
}

/// The header of a file. Texts longer than their columns are cut off.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TucsonHeader {
    /// Number of the site: six columns.
    pub site: String,
    /// Name of the site.
    pub site_name: String,
    /// Species.
    pub species: String,
    /// Who measured.
    pub investigator: String,
}

/// Writes series as a `.rwl` file.
///
/// ```
/// use greenstick_formats::tucson::{RingWidthSeries, TucsonHeader, write_tucson};
///
/// let series = RingWidthSeries { name: "R000".into(), first_year: 1998, widths: vec![2.1e-3, 1.84e-3, 0.0017] };
/// let file = write_tucson(&TucsonHeader::default(), &[series], "log.rwl")?;
/// let text = String::from_utf8(file.bytes)?;
/// let lines: Vec<&str> = text.lines().skip(3).collect();
/// assert_eq!(lines, ["R000    1998  2100  1840", "R000    2000  1700 -9999"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FormatError::Unwritable`] for a name, a year or a width that does not fit into its columns.
pub fn write_tucson(
    header: &TucsonHeader,
    series: &[RingWidthSeries],
    name: &str,
) -> Result<Encoded, FormatError> {
    let file = InFile(name);
    for one in series {
        check(one, file)?;
    }
    let years = |s: &RingWidthSeries| [s.first_year, s.first_year + s.widths.len() as i32 - 1];
    let first = series.iter().map(|s| years(s)[0]).min().unwrap_or(0);
    let last = series.iter().map(|s| years(s)[1]).max().unwrap_or(0);
    let mut text = header_lines(header, first, last);
    for one in series {
        write_series(&mut text, one);
    }
    Ok(Encoded {
        name: name.to_owned(),
        bytes: text.into_bytes(),
    })
}

fn header_lines(header: &TucsonHeader, first: i32, last: i32) -> String {
    let site = cut(&header.site, SITE_COLUMNS);
    let line = |rest: String| format!("{site:6}   {rest}").trim_end().to_owned() + "\n";
    line(cut(&header.site_name, SITE_NAME_COLUMNS))
        + &line(format!(
            "{:13}{:45}{first:4} {last:4}",
            "",
            cut(&header.species, 18)
        ))
        + &line(cut(&header.investigator, 63))
}

/// The first characters of a text that a reader can have in columns.
fn cut(text: &str, columns: usize) -> String {
    let plain = text
        .chars()
        .map(|c| if c.is_ascii_graphic() { c } else { ' ' });
    plain.take(columns).collect()
}

fn write_series(text: &mut String, series: &RingWidthSeries) {
    let units = series
        .widths
        .iter()
        .map(|w| (w * UNITS_PER_METRE).round() as i64);
    for (year, value) in (series.first_year..).zip(units.chain([STOP])) {
        let is_first = year == series.first_year;
        if is_first || year.rem_euclid(10) == 0 {
            if !is_first {
                text.push('\n');
            }
            *text += &format!("{:8}{year:4}", series.name);
        }
        *text += &format!("{value:6}");
    }
    text.push('\n');
}

fn check(series: &RingWidthSeries, file: InFile) -> Result<(), FormatError> {
    let name = &series.name;
    let plain = name.bytes().all(|b| b.is_ascii_alphanumeric());
    if name.is_empty() || name.len() > NAME_COLUMNS || !plain {
        let found = format!("a series named {name:?}");
        return Err(file.unwritable(found, "one to eight letters and digits"));
    }
    let end = i64::from(series.first_year) + series.widths.len() as i64;
    if !YEARS.contains(&series.first_year) || end > i64::from(*YEARS.end()) {
        let found = format!("series {name} from the year {} to {end}", series.first_year);
        return Err(file.unwritable(found, "years from -999 to 9998"));
    }
    let fits = |w: &f64| (0.0..=MAX_UNITS as f64).contains(&(w * UNITS_PER_METRE).round());
    if let Some(k) = series.widths.iter().position(|w| !fits(w)) {
        let found = format!("a width of {} m in series {name}", series.widths[k]);
        return Err(file.unwritable(found, "widths from 0 to 99.999 mm"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads a file by its columns.
    fn read(text: &str) -> Vec<RingWidthSeries> {
        let mut found: Vec<RingWidthSeries> = Vec::new();
        let mut ended = true;
        for line in text.lines().skip(3) {
            let (name, rest) = line.split_at(8);
            let (year, values) = rest.split_at(4);
            if ended {
                found.push(RingWidthSeries {
                    name: name.trim().to_owned(),
                    first_year: year.trim().parse().unwrap(),
                    widths: Vec::new(),
                });
                ended = false;
            }
            let series = found.last_mut().unwrap();
            let expected = series.first_year + series.widths.len() as i32;
            assert_eq!(year.trim().parse::<i32>().unwrap(), expected);
            for k in 0..values.len() / 6 {
                let value: i64 = values[6 * k..6 * k + 6].trim().parse().unwrap();
                if value == STOP {
                    ended = true;
                } else {
                    series.widths.push(value as f64 / UNITS_PER_METRE);
                }
            }
        }
        assert!(ended);
        found
    }

    #[test]
    fn series_come_back() {
        let series = |name: &str, first_year, count: u32| RingWidthSeries {
            name: name.to_owned(),
            first_year,
            widths: (0..count).map(|k| f64::from(1 + 997 * k) * 1e-6).collect(),
        };
        // From one year to a century; ends within a decade, at its end, and just after it.
        let all = [
            series("R000", 1, 100),
            series("R090", 1990, 10),
            series("R180", 1987, 3),
            series("R270", 2003, 1),
            series("EIGHTCOL", -15, 40),
        ];
        let header = TucsonHeader {
            site_name: "a name of a site that is much longer than its fifty-two columns".into(),
            ..TucsonHeader::default()
        };
        let file = write_tucson(&header, &all, "log.rwl").unwrap();
        let text = String::from_utf8(file.bytes).unwrap();
        let again = read(&text);
        assert_eq!(again.len(), all.len());
        for (a, b) in again.iter().zip(&all) {
            assert_eq!((&a.name, a.first_year), (&b.name, b.first_year));
            let off = a.widths.iter().zip(&b.widths).map(|(x, y)| (x - y).abs());
            assert!(a.widths.len() == b.widths.len() && off.fold(0.0, f64::max) < 1e-9);
        }
        assert!(text.lines().all(|line| line.len() <= 80));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let good = RingWidthSeries {
            name: "R000".into(),
            first_year: 1,
            widths: vec![1e-3],
        };
        for (series, message) in [
            (
                RingWidthSeries {
                    name: "TOO LONG A NAME".into(),
                    ..good.clone()
                },
                "eight letters",
            ),
            (
                RingWidthSeries {
                    first_year: 12_000,
                    ..good.clone()
                },
                "years from",
            ),
            (
                RingWidthSeries {
                    widths: vec![0.2],
                    ..good.clone()
                },
                "99.999 mm",
            ),
            (
                RingWidthSeries {
                    widths: vec![f64::NAN],
                    ..good
                },
                "99.999 mm",
            ),
        ] {
            let error = write_tucson(&TucsonHeader::default(), &[series], "x.rwl").unwrap_err();
            assert!(error.to_string().contains(message), "{error}");
        }
    }
}
