//! What is known of a stem beforehand.

use super::StemKind;
use super::location::metres;
use crate::rings::ONSET_RANGE;
use glam::{DVec2, DVec3};
use greenstick_schema::{Unit, choice, number, parameters, text, text_field};

/// Where the pith is, for stems whose pith is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PithPosition {
    /// A point in the world, m; taken along the grain to the section of the break.
    World(DVec3),
    /// In the section of the break, m, from the axis along the frame's x and y; of sawn wood, whose grain slopes, in the section
    /// half-way along it.
    Section(DVec2),
}

impl PithPosition {
    /// Parses `x,y,z` in the world or `x,y` in the section. Coordinates are in units of `unit` metres unless they have a
    /// unit of their own.
    ///
    /// # Errors
    /// [`PithPositionError`] where the text is neither.
    pub fn parse(text: &str, unit: f64) -> Result<Self, PithPositionError> {
        let error = || PithPositionError(text.to_owned());
        let parts: Result<Vec<f64>, _> = text
            .split(',')
            .map(|part| metres(part, unit).map_err(|_| error()))
            .collect();
        match parts?[..] {
            [x, y] => Ok(PithPosition::Section(DVec2::new(x, y))),
            [x, y, z] => Ok(PithPosition::World(DVec3::new(x, y, z))),
            _ => Err(error()),
        }
    }
}

/// A text that is no position of a pith.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no point; expected x,y,z in the world or x,y in the section, from its middle")]
pub struct PithPositionError(pub String);

impl std::str::FromStr for PithPosition {
    type Err = PithPositionError;

    /// [`PithPosition::parse`] in metres.
    fn from_str(text: &str) -> Result<Self, PithPositionError> {
        PithPosition::parse(text, 1.0)
    }
}

text_field! {
    PithPosition, "POINT", |pith| match pith {
        PithPosition::World(p) => format!("{},{},{}", p.x, p.y, p.z),
        PithPosition::Section(p) => format!("{},{}", p.x, p.y),
    };
    /// A position of a pith, in metres.
    pub const PITH
}

parameters! {
    /// What is known of a stem beforehand.
    pub struct StemOptions {
        "What it is", "stem" {
            /// Pith of the stem: x,y,z in the world, or x,y in the section from its middle (of sawn wood, half-way along it); "auto"
            /// estimates it.
            pith: Option<PithPosition> = None, text(PITH).auto();
            /// What the stem is; "auto" tells boards from round stems by their section. A round one has bark, unless it is
            /// straight, of one thickness and without a texture: then it is a dowel, or a pole where it is thicker than 6 cm.
            kind: Option<StemKind> = None, choice(StemKind::CHOICES).auto();
            /// Share of the radius at which a stem that is eccentric began to lean: rings within are round about the pith,
            /// rings beyond are wider on one side, all by the same share. "auto" is the usual one of such an outline; points on
            /// a few rings decide it.
            eccentricity_onset: Option<f64> = None,
                number(Unit::Fraction, *ONSET_RANGE.start(), *ONSET_RANGE.end()).auto();
            /// Slope of grain of sawn wood: how far its fibres run across it per length, on average, with waves about that. 0 is
            /// straight-grained. Flat-sawn faces show it as arches (cathedral figure). That of a round stem follows its bark.
            slope_of_grain: f64 = 0.02, number(Unit::Fraction, 0.0, 0.1);
        }
    }
}
