//! Units of length as options name them.

use clap::ValueEnum;
use greenstick::formats::LengthUnit;

/// Units of length.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum UnitChoice {
    #[value(help = "millimetres")]
    Mm,
    #[value(help = "centimetres")]
    Cm,
    #[value(help = "metres")]
    M,
}

impl From<UnitChoice> for LengthUnit {
    fn from(word: UnitChoice) -> Self {
        match word {
            UnitChoice::Mm => LengthUnit::Millimetre,
            UnitChoice::Cm => LengthUnit::Centimetre,
            UnitChoice::M => LengthUnit::Metre,
        }
    }
}
