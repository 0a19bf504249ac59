//! Units of parameters, and reading numbers that carry them.

use crate::error::ParameterError;
use serde::{Deserialize, Serialize};

/// The unit that a number is held in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// No unit.
    One,
    /// A ratio to the stem's radius.
    Radius,
    /// A part of a whole, 0 to 1.
    Fraction,
    /// Percent.
    Percent,
    /// Metres. Text must say the unit, so that nobody's centimetres are read as metres.
    Metre,
    /// Centimetres.
    Centimetre,
    /// Pixels.
    Pixel,
    /// Degrees.
    Degree,
    /// Degrees per height of one radius.
    DegreePerRadius,
    /// Degrees per second.
    DegreePerSecond,
    /// Cycles per metre.
    PerMetre,
    /// Seconds.
    Second,
    /// Per second.
    PerSecond,
    /// Metres per second.
    MetrePerSecond,
    /// Metres per second squared.
    MetrePerSecondSquared,
    /// Newtons.
    Newton,
    /// Newton metres.
    NewtonMetre,
    /// Newtons per metre.
    NewtonPerMetre,
    /// Joules.
    Joule,
    /// Kilograms per cubic metre.
    KilogramPerCubicMetre,
}

/// How a number with a suffix is brought to the unit it is held in.
#[derive(Clone, Copy)]
enum Conversion {
    /// Multiply by this.
    Times(f64),
    /// Divide by this: 7 cm is then the number next to 0.07.
    Over(f64),
}

use Conversion::{Over, Times};

const SAME: Conversion = Times(1.0);
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Longer suffixes first, so that none is taken for the end of another.
const LENGTHS: [(&str, Conversion); 3] = [("mm", Over(1000.0)), ("cm", Over(100.0)), ("m", SAME)];

impl Conversion {
    fn apply(self, x: f64) -> f64 {
        match self {
            Times(factor) => x * factor,
            Over(divisor) => x / divisor,
        }
    }
}

impl Unit {
    /// Symbol as written after a number; empty for [`Unit::One`] and [`Unit::Fraction`].
    pub const fn symbol(self) -> &'static str {
        match self {
            Unit::One | Unit::Fraction => "",
            Unit::Radius => "radius",
            Unit::Percent => "%",
            Unit::Metre => "m",
            Unit::Centimetre => "cm",
            Unit::Pixel => "pixels",
            Unit::Degree => "°",
            Unit::DegreePerRadius => "°/radius",
            Unit::DegreePerSecond => "°/s",
            Unit::PerMetre => "1/m",
            Unit::Second => "s",
            Unit::PerSecond => "1/s",
            Unit::MetrePerSecond => "m/s",
            Unit::MetrePerSecondSquared => "m/s²",
            Unit::Newton => "N",
            Unit::NewtonMetre => "N m",
            Unit::NewtonPerMetre => "N/m",
            Unit::Joule => "J",
            Unit::KilogramPerCubicMetre => "kg/m³",
        }
    }

    /// Whether text must say the unit of any number but 0.
    pub const fn is_required(self) -> bool {
        matches!(self, Unit::Metre)
    }

    /// The suffixes that it may be written with.
    fn suffixes(self) -> &'static [(&'static str, Conversion)] {
        match self {
            Unit::One => &[],
            Unit::Radius => &[("radius", SAME), ("radii", SAME), ("%", Over(100.0))],
            Unit::Fraction => &[("%", Over(100.0))],
            Unit::Percent => &[("%", SAME)],
            Unit::Metre => &LENGTHS,
            Unit::Centimetre => &[("cm", SAME), ("mm", Over(10.0)), ("m", Times(100.0))],
            Unit::Pixel => &[("px", SAME), ("pixels", SAME)],
            Unit::Degree => &[("deg", SAME), ("°", SAME), ("rad", Times(DEGREES))],
            Unit::DegreePerRadius => &[
                ("deg/radius", SAME),
                ("°/radius", SAME),
                ("rad/radius", Times(DEGREES)),
            ],
            Unit::DegreePerSecond => &[("deg/s", SAME), ("°/s", SAME), ("rad/s", Times(DEGREES))],
            Unit::PerMetre => &[
                ("1/m", SAME),
                ("/m", SAME),
                ("/cm", Times(100.0)),
                ("/mm", Times(1000.0)),
            ],
            Unit::Second => &[("s", SAME), ("ms", Over(1000.0))],
            Unit::PerSecond => &[("1/s", SAME), ("/s", SAME)],
            Unit::MetrePerSecond => &[("m/s", SAME)],
            Unit::MetrePerSecondSquared => &[("m/s²", SAME), ("m/s2", SAME)],
            Unit::Newton => &[("N", SAME), ("kN", Times(1000.0))],
            Unit::NewtonMetre => &[("N m", SAME), ("Nm", SAME)],
            Unit::NewtonPerMetre => &[("N/m", SAME)],
            Unit::Joule => &[("J", SAME), ("mJ", Over(1000.0))],
            Unit::KilogramPerCubicMetre => &[("kg/m³", SAME), ("kg/m3", SAME)],
        }
    }

    /// The suffixes as a list for messages.
    pub(crate) fn names(self) -> String {
        let names: Vec<&str> = self.suffixes().iter().map(|s| s.0).collect();
        names.join(", ")
    }

    /// The conversion of a suffix.
    fn conversion(self, suffix: &str) -> Option<Conversion> {
        let mut all = self.suffixes().iter();
        all.find(|s| s.0 == suffix).map(|s| s.1)
    }

    /// A number that may carry a unit, in this unit. NaN and infinities are read and fail the range.
    ///
    /// # Errors
    /// Text that is no number, a unit that does not fit, or none where one is needed. `key` is named in the message.
    pub(crate) fn parse(self, key: &str, text: &str) -> Result<f64, ParameterError> {
        let (number, suffix) = split(text).ok_or_else(|| self.not_a_number(key, text))?;
        if suffix.is_empty() {
            return if self.is_required() && number != 0.0 {
                Err(self.not_a_number(key, text))
            } else {
                Ok(number)
            };
        }
        match self.conversion(suffix) {
            Some(conversion) => Ok(conversion.apply(number)),
            None => Err(self.wrong_unit(key, suffix)),
        }
    }

    /// Numbers with commas between them; a unit after the last holds for all that carry none.
    ///
    /// # Errors
    /// As [`Unit::parse`].
    pub(crate) fn parse_all(self, key: &str, text: &str) -> Result<Vec<f64>, ParameterError> {
        let parts: Vec<&str> = text.split(',').collect();
        let last = parts.last().and_then(|p| split(p)).map_or("", |s| s.1);
        let one = |part: &&str| match split(part) {
            Some((_, "")) => self.parse(key, &format!("{part} {last}")),
            _ => self.parse(key, part),
        };
        parts.iter().map(one).collect()
    }

    fn not_a_number(self, key: &str, text: &str) -> ParameterError {
        ParameterError::NotANumber {
            key: key.to_owned(),
            found: text.trim().to_owned(),
            units: self.names(),
            required: self.is_required(),
        }
    }

    fn wrong_unit(self, key: &str, suffix: &str) -> ParameterError {
        ParameterError::WrongUnit {
            key: key.to_owned(),
            found: suffix.to_owned(),
            units: self.names(),
        }
    }
}

/// The longest beginning of a text that is a number, and what follows it. "1/m" after a space begins with a digit, so a
/// space ends the number.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let head = text.split_whitespace().next().unwrap_or_default();
    (1..=head.len())
        .rev()
        .filter(|&end| head.is_char_boundary(end))
        .find_map(|end| Some((head[..end].parse().ok()?, text[end..].trim())))
}

/// Why a text is no length.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LengthError {
    /// Not a number.
    #[error("{0:?} is not a number")]
    NotANumber(String),
    /// NaN or an infinity.
    #[error("{0:?} is not a finite number")]
    NotFinite(String),
    /// A unit that is no length.
    #[error("{0:?} is no unit of length; expected mm, cm or m")]
    Unit(String),
}

/// A finite length such as "12 cm", in metres, and whether it carried a unit; without one the number is returned as it
/// is.
///
/// # Errors
/// [`LengthError`] where the text is no finite number with or without mm, cm or m.
///
/// ```
/// assert_eq!(greenstick_schema::parse_length("12 cm"), Ok((0.12, true)));
/// assert_eq!(greenstick_schema::parse_length("12"), Ok((12.0, false)));
/// ```
pub fn parse_length(text: &str) -> Result<(f64, bool), LengthError> {
    let text = text.trim();
    let (number, suffix) = split(text).ok_or_else(|| LengthError::NotANumber(text.to_owned()))?;
    if !number.is_finite() {
        return Err(LengthError::NotFinite(text.to_owned()));
    }
    match Unit::Metre.conversion(suffix) {
        Some(conversion) => Ok((conversion.apply(number), true)),
        None if suffix.is_empty() => Ok((number, false)),
        None => Err(LengthError::Unit(suffix.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_their_units() {
        let read = |text, unit: Unit| unit.parse("k", text).unwrap();
        assert_eq!(read("12 mm", Unit::Centimetre), 1.2);
        assert_eq!(read("0.03m", Unit::Centimetre), 3.0);
        assert_eq!(read("1.5", Unit::Centimetre), 1.5);
        assert_eq!(read("7cm", Unit::Metre), 0.07);
        assert_eq!(read("0", Unit::Metre), 0.0);
        assert_eq!(read("-30deg", Unit::Degree), -30.0);
        assert_eq!(read("3.141592653589793 rad", Unit::Degree), 180.0);
        assert_eq!(read("45°", Unit::Degree), 45.0);
        assert_eq!(read("25%", Unit::Fraction), 0.25);
        assert_eq!(read("7%", Unit::Fraction), 0.07);
        assert_eq!(read("4.6 /cm", Unit::PerMetre), 4.6 * 100.0);
        assert_eq!(read("460 1/m", Unit::PerMetre), 460.0);
        assert_eq!(read("1e3", Unit::PerMetre), 1000.0);
        assert!(read("nan", Unit::Radius).is_nan());
    }

    #[test]
    fn one_unit_holds_for_all_numbers_of_a_list() {
        let read = |text| Unit::Metre.parse_all("k", text);
        assert_eq!(read("0, -7.5, 2 cm"), Ok(vec![0.0, -0.075, 0.02]));
        assert_eq!(read("1 m, 5 mm"), Ok(vec![1.0, 0.005]));
        assert!(read("1, 2, 3").is_err());
    }

    #[test]
    fn what_is_no_number_or_has_a_foreign_unit_is_refused() {
        let read = |text, unit: Unit| unit.parse("diameter", text).unwrap_err().to_string();
        assert!(read("3 deg", Unit::Centimetre).contains("it takes cm, mm, m"));
        assert!(read("thick", Unit::Centimetre).contains("must be a number"));
        assert!(read("", Unit::Centimetre).contains("must be a number"));
        assert!(read("3 cm", Unit::One).contains("it takes none"));
        let message = read("3", Unit::Metre);
        assert_eq!(
            message,
            "diameter is \"3\", but it must be a number with a unit: mm, cm, m"
        );
    }

    #[test]
    fn lengths_say_whether_they_carry_a_unit() {
        assert_eq!(parse_length(" 1.5 m "), Ok((1.5, true)));
        assert_eq!(parse_length("3mm"), Ok((0.003, true)));
        for bad in ["", "m", "NaN", "inf m", "3 km", "3 %"] {
            assert!(parse_length(bad).is_err(), "{bad}");
        }
    }
}
