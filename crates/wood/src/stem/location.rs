//! A location on a stem, as people write it.

use glam::DVec3;
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
                let (number, scale) = quantity(part).map_err(error)?;
                *value = number * scale.unwrap_or(unit);
            }
            return Ok(StemLocation::Point(DVec3::from_array(point)));
        }
        match quantity(text.trim()).map_err(error)? {
            (number, Some(scale)) if number >= 0.0 => Ok(StemLocation::Length(number * scale)),
            (_, Some(_)) => Err(error("the length is negative".to_owned())),
            (number, None) if (0.0..=1.0).contains(&number) => Ok(StemLocation::Fraction(number)),
            (number, None) => Err(error(format!(
                "{number} without a unit is a fraction and must lie between 0 and 1"
            ))),
        }
    }
}

/// Splits a text into a finite number and the metres in its unit, where it has one.
fn quantity(text: &str) -> Result<(f64, Option<f64>), String> {
    const UNITS: [(&str, f64); 4] = [("mm", 1e-3), ("cm", 1e-2), ("%", 0.0), ("m", 1.0)];
    let unit = UNITS.iter().find(|(name, _)| text.ends_with(name));
    let (digits, scale) = match unit {
        Some(("%", _)) => return Err("percentages are not supported; write a fraction".to_owned()),
        Some((name, scale)) => (text[..text.len() - name.len()].trim_end(), Some(*scale)),
        None => (text, None),
    };
    match digits.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((number, scale)),
        Ok(_) => Err(format!("{digits:?} is not a finite number")),
        Err(_) if digits.is_empty() => Err("a number is missing".to_owned()),
        Err(_) => Err(format!("{digits:?} is not a number")),
    }
}

impl FromStr for StemLocation {
    type Err = StemLocationError;

    /// [`StemLocation::parse`] with points in metres.
    fn from_str(text: &str) -> Result<Self, StemLocationError> {
        StemLocation::parse(text, 1.0)
    }
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
        for text in ["0.4000", "0.1200m", "0.1000,2.3000,-0.4000"] {
            assert_eq!(text.parse::<StemLocation>().unwrap().to_string(), text);
        }
        for (text, part) in [
            ("1.2", "between 0 and 1"),
            ("", "missing"),
            ("cm", "missing"),
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
