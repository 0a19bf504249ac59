//! Reading a parameter's value from text, with its unit, and what is wrong with a value.

use super::Unit;
use greenstick_wood::spelling::did_you_mean;

/// What is wrong with a parameter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// No parameter of this name.
    #[error("unknown parameter \"{key}\"{}", did_you_mean(nearest))]
    UnknownKey {
        /// The key found.
        key: String,
        /// Up to three keys that are near it.
        nearest: Vec<String>,
    },
    /// A number outside its range, or not a number.
    #[error("{key} is {found}, but it must be from {min} to {max}{}{unit}", if unit.is_empty() { "" } else { " " })]
    OutOfRange {
        /// The parameter.
        key: String,
        /// The value found, in the parameter's unit.
        found: f64,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
        /// Symbol of the unit.
        unit: &'static str,
    },
    /// Not a whole number, or one outside its range.
    #[error("{key} is {found}, but it must be a whole number from {min} to {max}")]
    Whole {
        /// The parameter.
        key: String,
        /// The value found.
        found: String,
        /// Least value.
        min: u64,
        /// Greatest value.
        max: u64,
    },
    /// Text that is no number.
    #[error("{key} is \"{found}\", but it must be a number{}", after(units))]
    NotANumber {
        /// The parameter.
        key: String,
        /// The text found.
        found: String,
        /// Units that may follow the number.
        units: String,
    },
    /// A number with a unit that does not fit.
    #[error("{key} has the unit \"{found}\"; it takes {}", if units.is_empty() { "none" } else { units })]
    WrongUnit {
        /// The parameter.
        key: String,
        /// The unit found.
        found: String,
        /// Units that may follow the number.
        units: String,
    },
    /// A word that is none of the choices.
    #[error("{key} is \"{found}\", but it must be one of {options}")]
    Choice {
        /// The parameter.
        key: String,
        /// The word found.
        found: String,
        /// The words it may be.
        options: String,
    },
    /// Pith, heartwood and phloem take more than the whole radius.
    #[error(
        "pith {pith}, heartwood {heartwood} and phloem {phloem} are together more than 1, the whole radius"
    )]
    Proportions {
        /// ν_pith.
        pith: f64,
        /// ν_heartwood.
        heartwood: f64,
        /// ν_phloem.
        phloem: f64,
    },
    /// Two values that must be in order are not.
    #[error("{lower} is {low} and {upper} is {high}, but the first must not be above the second")]
    Order {
        /// Key of the lower one.
        lower: String,
        /// Its value.
        low: f64,
        /// Key of the upper one.
        upper: String,
        /// Its value.
        high: f64,
    },
}

fn after(units: &str) -> String {
    if units.is_empty() {
        String::new()
    } else {
        format!(", with or without a unit: {units}")
    }
}

/// The suffixes a unit is written with, and what to multiply by to come to the unit itself.
fn suffixes(unit: Unit) -> &'static [(&'static str, f64)] {
    const DEGREES: f64 = 180.0 / std::f64::consts::PI;
    match unit {
        Unit::Radius => &[("radius", 1.0), ("radii", 1.0), ("%", 0.01)],
        Unit::Fraction => &[("%", 0.01)],
        Unit::Centimetre => &[("cm", 1.0), ("mm", 0.1), ("m", 100.0)],
        Unit::Degree => &[("deg", 1.0), ("°", 1.0), ("rad", DEGREES)],
        Unit::DegreePerRadius => &[
            ("deg/radius", 1.0),
            ("°/radius", 1.0),
            ("rad/radius", DEGREES),
        ],
        Unit::PerMetre => &[("1/m", 1.0), ("/m", 1.0), ("/cm", 100.0), ("/mm", 1000.0)],
        Unit::One => &[],
    }
}

/// A number that may carry a unit, in `unit`. NaN and infinities come through and fail the range.
pub(crate) fn parse_number(key: &str, text: &str, unit: Unit) -> Result<f64, ParameterError> {
    let text = text.trim();
    let units = || {
        suffixes(unit)
            .iter()
            .map(|s| s.0)
            .collect::<Vec<_>>()
            .join(", ")
    };
    // The longest beginning that is a number; what follows is the unit ("1/m" after a space begins
    // with a digit, so a space ends the number).
    let head = text.split_whitespace().next().unwrap_or_default();
    let number = (1..=head.len())
        .rev()
        .filter(|&end| head.is_char_boundary(end))
        .find_map(|end| head[..end].parse::<f64>().ok().map(|x| (x, end)));
    let Some((x, end)) = number else {
        return Err(ParameterError::NotANumber {
            key: key.to_owned(),
            found: text.to_owned(),
            units: units(),
        });
    };
    let suffix = text[end..].trim();
    if suffix.is_empty() {
        return Ok(x);
    }
    match suffixes(unit).iter().find(|s| s.0 == suffix) {
        Some((_, factor)) => Ok(x * factor),
        None => Err(ParameterError::WrongUnit {
            key: key.to_owned(),
            found: suffix.to_owned(),
            units: units(),
        }),
    }
}

/// A whole number without sign.
pub(crate) fn parse_whole(text: &str) -> Option<u64> {
    text.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_their_units() {
        let read = |text, unit| parse_number("k", text, unit).unwrap();
        assert_eq!(read("12 mm", Unit::Centimetre), 12.0 * 0.1);
        assert_eq!(read("0.03m", Unit::Centimetre), 3.0);
        assert_eq!(read("1.5", Unit::Centimetre), 1.5);
        assert_eq!(read("-30deg", Unit::Degree), -30.0);
        assert_eq!(read("3.141592653589793 rad", Unit::Degree), 180.0);
        assert_eq!(read("45°", Unit::Degree), 45.0);
        assert_eq!(read("25%", Unit::Fraction), 0.25);
        assert_eq!(read("4.6 /cm", Unit::PerMetre), 4.6 * 100.0);
        assert_eq!(read("460 1/m", Unit::PerMetre), 460.0);
        assert_eq!(read("1e3", Unit::PerMetre), 1000.0);
        assert!(read("nan", Unit::Radius).is_nan());
    }

    #[test]
    fn what_is_no_number_or_has_a_foreign_unit_is_refused() {
        let read = |text, unit| {
            parse_number("diameter", text, unit)
                .unwrap_err()
                .to_string()
        };
        assert!(read("3 deg", Unit::Centimetre).contains("it takes cm, mm, m"));
        assert!(read("thick", Unit::Centimetre).contains("must be a number"));
        assert!(read("", Unit::Centimetre).contains("must be a number"));
        assert!(read("3 cm", Unit::One).contains("it takes none"));
    }
}
