//! What is wanted of the rings of one section: their number or measured series, the pith, and a picture.

use super::limits::RESOLUTION_RANGE;
use super::model::RingMethod;
use super::parameters::RingParameters;
use crate::rings::{MAX_RINGS, ONSET_RANGE, RingSeries, SectionRingMethod};
use greenstick_schema::{Kind, ParameterError, Unit, count, list, number, parameters};

/// Number of rings where nothing says it.
const DEFAULT_RINGS: usize = 20;
/// Pixels along each side of the bitmap that is eroded where nothing says it.
const DEFAULT_RESOLUTION: usize = 512;
/// Greatest coordinate and radius, in the units of a section's file.
const MAX_COORDINATE: f64 = 1e9;

/// A coordinate in the units of a section's file.
const COORDINATE: Kind = number(Unit::One, -MAX_COORDINATE, MAX_COORDINATE).kind;
/// A radius or width in these units.
const RING_SIZE: Kind = number(Unit::One, 0.0, MAX_COORDINATE).above().kind;

parameters! {
    /// What is wanted of the rings of one section. Lengths are in the units of its file.
    pub struct SectionRingSettings {
        "Annual rings", "rings" {
            /// Number of rings, all of the same mean width; "auto" is 20.
            rings: Option<usize> = None, count(1, MAX_RINGS as i128).auto();
            /// Mean radii from the pith outwards, in the file's units.
            radii: Option<Vec<f64>> = None, list(&RING_SIZE, 1, MAX_RINGS).auto();
            /// Mean widths from the pith outwards, in the file's units.
            widths: Option<Vec<f64>> = None, list(&RING_SIZE, 1, MAX_RINGS).auto();
            /// Where the pith is, x and y in the file's coordinates; "auto" is the file's, or else a guess from the outline.
            pith: Option<Vec<f64>> = None, list(&COORDINATE, 2, 2).auto();
            /// Share of the radius at which the stem began to lean to one side; "auto" is the usual one of such an outline.
            eccentricity_onset: Option<f64> = None,
                number(Unit::One, *ONSET_RANGE.start(), *ONSET_RANGE.end()).auto();
        }
        "Picture", "picture" {
            /// Width and height of the picture, pixels.
            picture_size: u32 = 900, count(16, 8192);
        }
        "Where rings come from", "rings" {
            /// Pixels along each side of the picture that is eroded; "auto" is 512.
            resolution: Option<usize> = None, count(*RESOLUTION_RANGE.start() as i128, *RESOLUTION_RANGE.end() as i128).auto();
        }
    }
    include {
        /// Where rings come from.
        source: RingParameters = RingParameters::default();
    }
    check |p| {
        let given = [
            ("rings", p.rings.is_some()),
            ("radii", p.radii.is_some()),
            ("widths", p.widths.is_some()),
        ];
        let mut given = given.into_iter().filter(|g| g.1).map(|g| g.0);
        let (first, second) = (given.next(), given.next());
        if let (Some(first), Some(second)) = (first, second) {
            return Err(ParameterError::Conflict(format!(
                "{first} and {second} are both given; expected one of them"
            )));
        }
        match (p.source.method(), first, p.resolution) {
            (RingMethod::Erosion(_), Some(first), _) => Err(ParameterError::Conflict(format!(
                "{first}: an erosion makes its own number of rings, by its kernels and the resolution; expected only one of the two"
            ))),
            (RingMethod::Field, _, Some(_)) => Err(ParameterError::Conflict(
                "resolution belongs to an erosion, but rings_by is \"field\"; expected rings_by \"erosion\" with it".to_owned(),
            )),
            _ => Ok(()),
        }
    };
}

impl SectionRingSettings {
    /// The method that makes the rings.
    pub fn method(&self) -> SectionRingMethod {
        match self.source.method() {
            RingMethod::Field => SectionRingMethod::Field(match (&self.radii, &self.widths) {
                (Some(radii), _) => RingSeries::Radii(radii.clone()),
                (_, Some(widths)) => RingSeries::Widths(widths.clone()),
                _ => RingSeries::Number(self.rings.unwrap_or(DEFAULT_RINGS)),
            }),
            RingMethod::Erosion(erosion) => SectionRingMethod::Erosion {
                erosion,
                resolution: self.resolution.unwrap_or(DEFAULT_RESOLUTION),
            },
        }
    }

    /// The pith, where it is given.
    pub fn pith_point(&self) -> Option<[f64; 2]> {
        match self.pith.as_deref() {
            Some(&[x, y]) => Some([x, y]),
            _ => None,
        }
    }
}
