//! A location on a stem, as people write it.

use glam::DVec3;
use greenstick_schema::{LengthError, parse_length, text_field};
use std::fmt;
use std::str::FromStr;

/// A location on a stem.
///
/// ```
/// use greenstick_wood::stem::StemLocation;
///
/// assert_eq!("0.4".parse(), Ok(StemLocation::Fraction(0.4)));
/// assert_eq!("12cm".parse(), Ok(StemLocation::Length(0.12)));
/// assert!("0.3,2.1,-0.4".parse::<StemLocation>().is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StemLocation {
    /// Fraction of the stem's length from its base, 0 to 1.
    Fraction(f64),
    /// Length along the stem from its base, m.
    Length(f64),
    /// A point in the world, m: the limb nearest to it.
    Point(DVec3),
}

/// A text that is no location.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "place {text:?}: {found}; a place is a fraction of the stem from 0 to 1 (0.4), a length from its \
     base (12cm, 120mm, 1.2m) or a point (x,y,z)"
)]
pub struct StemLocationError {
    /// The text.
    pub text: String,
    /// What is wrong with it.
    pub found: String,
}

impl StemLocation {
    /// Parses `0.4`, `12cm`, `120mm`, `1.2m` or `x,y,z`. The coordinates of a point are in units of `unit` metres (1 for
    /// metres, 0.001 for a file in millimetres) unless they have a unit of their own.
    ///
    /// # Errors
    /// [`StemLocationError`] where the text is none of these.
    pub fn parse(text: &str, unit: f64) -> Result<Self, StemLocationError> {
        let error = |found: String| StemLocationError {
            text: text.to_owned(),
            found,
        };
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        if parts.len() > 1 {
            if parts.len() != 3 {
                return Err(error(format!(
                    "{} coordinates instead of three",
                    parts.len()
                )));
            }
            let mut point = [0.0; 3];
            for (value, part) in point.iter_mut().zip(&parts) {
                *value = metres(part, unit).map_err(|e| error(e.to_string()))?;
            }
            return Ok(StemLocation::Point(DVec3::from_array(point)));
        }
        if text.trim_end().ends_with('%') {
            return Err(error(
                "percentages are not supported; write a fraction".to_owned(),
            ));
        }
        match parse_length(text).map_err(|e| error(e.to_string()))? {
            (length, true) if length >= 0.0 => Ok(StemLocation::Length(length)),
            (_, true) => Err(error("the length is negative".to_owned())),
            (number, false) if (0.0..=1.0).contains(&number) => Ok(StemLocation::Fraction(number)),
            (number, false) => Err(error(format!(
                "{number} without a unit is a fraction and must lie between 0 and 1"
            ))),
        }
    }
}

/// A finite number of metres; without a unit of its own it is in units of `unit` metres.
pub(super) fn metres(text: &str, unit: f64) -> Result<f64, LengthError> {
    let (length, has_unit) = parse_length(text)?;
    Ok(if has_unit { length } else { length * unit })
}

impl FromStr for StemLocation {
    type Err = StemLocationError;

    /// [`StemLocation::parse`] with points in metres.
    fn from_str(text: &str) -> Result<Self, StemLocationError> {
        StemLocation::parse(text, 1.0)
    }
}

text_field! {
    StemLocation, "PLACE", |location| match location {
        StemLocation::Fraction(x) => x.to_string(),
        StemLocation::Length(x) => format!("{x} m"),
        StemLocation::Point(p) => format!("{},{},{}", p.x, p.y, p.z),
    };
    /// A location on a stem, points in metres.
    pub const LOCATION
}

impl fmt::Display for StemLocation {
    /// The form that [`StemLocation::parse`] reads, with points in metres.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StemLocation::Fraction(x) => write!(f, "{x:.4}"),
            StemLocation::Length(x) => write!(f, "{x:.4}m"),
            StemLocation::Point(p) => write!(f, "{:.4},{:.4},{:.4}", p.x, p.y, p.z),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_schema::Field;

    #[test]
    fn locations_are_parsed() {
        assert_eq!("0.4".parse(), Ok(StemLocation::Fraction(0.4)));
        assert_eq!("12 cm".parse(), Ok(StemLocation::Length(0.12)));
        assert_eq!("120mm".parse(), Ok(StemLocation::Length(0.12)));
        let point = DVec3::new(0.1, 2.3, -0.4);
        assert_eq!("0.1, 2.3,-0.4".parse(), Ok(StemLocation::Point(point)));
        assert_eq!(
            StemLocation::parse("125,2000,-500", 1e-3),
            "0.125,2,-0.5".parse()
        );
        for exact in [
            StemLocation::Fraction(0.1 + 0.2),
            StemLocation::Length(1.0 / 3.0),
            StemLocation::Point(point / 3.0),
        ] {
            assert_eq!(StemLocation::from_value(&exact.to_value()), Some(exact));
        }
        for text in ["0.4000", "0.1200m", "0.1000,2.3000,-0.4000"] {
            assert_eq!(text.parse::<StemLocation>().unwrap().to_string(), text);
        }
        for (text, part) in [
            ("1.2", "between 0 and 1"),
            ("", "not a number"),
            ("cm", "not a number"),
            ("a", "not a number"),
            ("1,2", "2 coordinates"),
            ("NaN", "finite"),
            ("-3cm", "negative"),
            ("40%", "fraction"),
        ] {
            let message = text.parse::<StemLocation>().unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
