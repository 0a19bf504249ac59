//! Parsing of option values: lengths, locations, piths, sizes. Errors say what would be right; clap puts the option's
//! name before them.

use greenstick::formats::LengthUnit;
use greenstick::wood::stem::{PithPosition, StemLocation};

/// Parses a length such as `3cm`, `12mm`, `0.1m` or `0`; returns metres.
pub fn distance(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let wrong = || "expected a length with its unit: 3cm, 12mm or 0.1m".to_owned();
    let (digits, scale) = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)]
        .iter()
        .find_map(|(unit, scale)| text.strip_suffix(unit).map(|d| (d.trim_end(), *scale)))
        .unwrap_or((text, f64::NAN));
    let number: f64 = digits.parse().map_err(|_| wrong())?;
    match number * scale {
        _ if number == 0.0 => Ok(0.0),
        metres if metres.is_finite() && metres > 0.0 => Ok(metres),
        metres if metres < 0.0 => Err("the length is negative; expected 0 or more".to_owned()),
        _ => Err(wrong()),
    }
}

/// Parses a number from 0 to 1.
pub fn amount(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if (0.0..=1.0).contains(&x) => Ok(x),
        _ => Err(
            "expected a number from 0 to 1; where a file name follows, write --fray=0.5".to_owned(),
        ),
    }
}

/// Parses a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// Parses a moisture content, percent; `green` is wood at or above fibre saturation.
pub fn moisture(text: &str) -> Result<f64, String> {
    use greenstick::wood::moisture::{FIBRE_SATURATION_PERCENT, WETTEST_PERCENT};
    let text = text.trim();
    if text.eq_ignore_ascii_case("green") {
        return Ok(FIBRE_SATURATION_PERCENT);
    }
    let digits = text.strip_suffix('%').unwrap_or(text);
    match digits.trim_end().parse::<f64>() {
        Ok(x) if x > 0.0 && x <= WETTEST_PERCENT => Ok(x),
        _ => Err(format!(
            "expected a percentage above 0 and up to {WETTEST_PERCENT}, such as 12, or `green`"
        )),
    }
}

/// Parses a seed.
pub fn seed(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

/// Parses a location, in the unit of the file.
pub fn place(text: &str, unit: LengthUnit) -> Result<StemLocation, String> {
    StemLocation::parse(text, unit.metres()).map_err(|e| format!("--at: {e}"))
}

/// Parses a pith: `x,y,z` in the world or `x,y` in the section, in the unit of the file.
pub fn pith(text: &str, unit: LengthUnit) -> Result<PithPosition, String> {
    PithPosition::parse(text, unit.metres()).map_err(|e| format!("--pith: {e}"))
}

/// Parses the width of the baked textures, pixels: even, 8 to 16384.
pub fn texture_size(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(x) if (8..=16_384).contains(&x) && x % 2 == 0 => Ok(x),
        _ => Err("expected an even number of pixels from 8 to 16384".to_owned()),
    }
}

/// Parses a number of voxels along the side of a segment, or of pixels along the side of a section: 32 to 512.
pub fn resolution(text: &str) -> Result<usize, String> {
    let range = greenstick::wood::anatomy::RESOLUTION_RANGE;
    match text.parse::<usize>() {
        Ok(x) if range.contains(&x) => Ok(x),
        _ => Err(format!(
            "expected a number from {} to {}",
            range.start(),
            range.end()
        )),
    }
}

/// Parses two whole numbers with `..` between them, the first below the second.
pub fn range(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once("..").and_then(|(from, to)| {
        let from = if from.is_empty() {
            0
        } else {
            from.parse().ok()?
        };
        Some((from, to.parse().ok()?))
    });
    match parts {
        Some((from, to)) if from < to => Ok((from, to)),
        _ => Err("expected two whole numbers, the first below the second, such as 30..60".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_in_metres_and_radians() {
        assert!((distance("3cm").unwrap() - 0.03).abs() < 1e-15);
        assert_eq!(distance("0"), Ok(0.0));
        assert_eq!(distance("1.5 m"), Ok(1.5));
        for wrong in ["3", "-3cm", "NaNm", "infm", "cm", "3km", ""] {
            assert!(distance(wrong).is_err(), "{wrong}");
        }
        let section = pith("1,-2", LengthUnit::Millimetre).unwrap();
        assert!(matches!(section, PithPosition::Section(p) if (p.y + 0.002).abs() < 1e-12));
        assert!(pith("1cm", LengthUnit::Metre).is_err());
        assert!(texture_size("7").is_err() && texture_size("512") == Ok(512));
        assert_eq!((moisture("12 %"), moisture("Green")), (Ok(12.0), Ok(30.0)));
        assert!(
            ["0", "-1", "NaN", "201", "wet", ""]
                .iter()
                .all(|t| moisture(t).is_err())
        );
        assert!(seed("-1").is_err() && seed("1.5").is_err() && seed("7") == Ok(7));
        assert!(amount("1.1").is_err() && amount("NaN").is_err());
    }
}
