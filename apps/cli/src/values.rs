//! Parsing of option values: locations, piths, lengths. Errors say what would be right; clap puts the option's name before
//! them.

use greenstick::formats::LengthUnit;
use greenstick::wood::stem::{PithPosition, StemLocation};

/// Parses a location, in the unit of the file.
pub fn place(text: &str, unit: LengthUnit) -> Result<StemLocation, String> {
    StemLocation::parse(text, unit.metres()).map_err(|e| format!("--at: {e}"))
}

/// Parses a pith: `x,y,z` in the world or `x,y` in the section, in the unit of the file.
pub fn pith(text: &str, unit: LengthUnit) -> Result<PithPosition, String> {
    PithPosition::parse(text, unit.metres()).map_err(|e| format!("--pith: {e}"))
}

/// Parses a length above 0 with its unit, as metres.
pub fn metres(text: &str) -> Result<f64, String> {
    match greenstick::schema::parse_length(text) {
        Ok((length, true)) if length > 0.0 => Ok(length),
        Ok(_) => Err("expected a length above 0 with its unit, such as 24cm".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn piths_are_read() {
        let section = pith("1,-2", LengthUnit::Millimetre).unwrap();
        assert!(matches!(section, PithPosition::Section(p) if (p.y + 0.002).abs() < 1e-12));
        assert!(pith("1cm", LengthUnit::Metre).is_err());
    }
}
