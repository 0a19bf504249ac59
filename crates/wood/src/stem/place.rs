//! Where a stem is to be broken, as people write it.

use glam::DVec3;
use std::fmt;
use std::str::FromStr;

/// A place on a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// Fraction of the stem's length from its base, 0 to 1.
    Fraction(f64),
    /// Length along the stem from its base, m.
    Length(f64),
    /// A point in the world, m: the limb nearest to it.
    Point(DVec3),
}

/// A place that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "place {text:?}: {found}; a place is a fraction of the stem from 0 to 1 (0.4), a length from its \
     base (12cm, 120mm, 1.2m) or a point (x,y,z)"
)]
pub struct PlaceError {
    /// What was given.
    pub text: String,
    /// What is wrong with it.
    pub found: String,
}

impl Place {
    /// Reads `0.4`, `12cm`, `120mm`, `1.2m` or `x,y,z`; the numbers of a point are in units of `unit` metres (1 for
    /// metres, 0.001 for a file in millimetres) unless they carry a unit themselves.
    ///
    /// # Errors
    /// [`PlaceError`] where the text is none of these.
    pub fn parse(text: &str, unit: f64) -> Result<Self, PlaceError> {
        let error = |found: String| PlaceError {
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
            return Ok(Place::Point(DVec3::from_array(point)));
        }
        match quantity(text.trim()).map_err(error)? {
            (number, Some(scale)) if number >= 0.0 => Ok(Place::Length(number * scale)),
            (_, Some(_)) => Err(error("the length is negative".to_owned())),
            (number, None) if (0.0..=1.0).contains(&number) => Ok(Place::Fraction(number)),
            (number, None) => Err(error(format!(
                "{number} without a unit is a fraction and must lie between 0 and 1"
            ))),
        }
    }
}

/// A finite number and the metres in its unit, where it has one.
fn quantity(text: &str) -> Result<(f64, Option<f64>), String> {
    const UNITS: [(&str, f64); 4] = [("mm", 1e-3), ("cm", 1e-2), ("%", 0.0), ("m", 1.0)];
    let unit = UNITS.iter().find(|(name, _)| text.ends_with(name));
    let (digits, scale) = match unit {
        Some(("%", _)) => return Err("percent are not read, write a fraction".to_owned()),
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

impl FromStr for Place {
    type Err = PlaceError;

    /// [`Place::parse`] with points in metres.
    fn from_str(text: &str) -> Result<Self, PlaceError> {
        Place::parse(text, 1.0)
    }
}

impl fmt::Display for Place {
    /// The form that [`Place::parse`] reads, points in metres.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Fraction(x) => write!(f, "{x:.4}"),
            Place::Length(x) => write!(f, "{x:.4}m"),
            Place::Point(p) => write!(f, "{:.4},{:.4},{:.4}", p.x, p.y, p.z),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read() {
        assert_eq!("0.4".parse(), Ok(Place::Fraction(0.4)));
        assert_eq!("12 cm".parse(), Ok(Place::Length(0.12)));
        assert_eq!("120mm".parse(), Ok(Place::Length(0.12)));
        let point = DVec3::new(0.1, 2.3, -0.4);
        assert_eq!("0.1, 2.3,-0.4".parse(), Ok(Place::Point(point)));
        assert_eq!(Place::parse("125,2000,-500", 1e-3), "0.125,2,-0.5".parse());
        for place in ["0.4000", "0.1200m", "0.1000,2.3000,-0.4000"] {
            assert_eq!(place.parse::<Place>().unwrap().to_string(), place);
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
            let message = text.parse::<Place>().unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
