//! A crack as it was measured.

use crate::parameters::CrackKind;
use serde::Serialize;

/// A crack as it was measured. Widths are in radii of the section, as everything but angles.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredCrack {
    /// Its kind.
    pub kind: CrackKind,
    /// Direction about the pith, degrees counter-clockwise from the right of the photograph; for a crack along a ring that of
    /// its beginning.
    pub angle: f64,
    /// Ring coordinate at which a radial crack begins; that of a crack along a ring.
    pub begin: f64,
    /// Ring coordinate at which a radial crack ends, 1 where it is open at the bark; for a crack along a ring the direction
    /// of its end, degrees.
    pub end: f64,
    /// Whether a radial crack is widest at the bark, instead of in its middle.
    pub open_at_bark: bool,
    /// Greatest opening along its course.
    pub width: f64,
    /// Opening over the distance from the pith where that is greatest: shrinkage times range of a radial crack (rad); the
    /// greatest opening of a crack along a ring.
    pub opening: f64,
    /// Root mean square distance of a radial crack from a straight line.
    pub wander: f64,
    /// Root mean square difference of its opening from the model's, over the greatest.
    pub residual: f64,
}

impl MeasuredCrack {
    /// Returns its length, radii.
    pub fn length(&self) -> f64 {
        match self.kind {
            CrackKind::Radial => self.end - self.begin,
            CrackKind::Tangential => {
                (self.end - self.angle).rem_euclid(360.0).to_radians() * self.begin
            }
        }
    }
}
