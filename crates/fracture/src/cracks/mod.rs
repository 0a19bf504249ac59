//! Cracks of drying wood (Yang 2019 §4) as grooves in a height field.
//!
//! [`plan`] draws the cracks, [`grooves`] sinks them into a break surface and [`end_grooves`] into a sawn end. Cutting
//! along the result gives grooves with two walls that meet at their bottom, in a mesh that is closed by construction.
//!
//! With the corrected formulas (`docs`, model, "Cracks") the strain of the wood beside a radial crack is
//! ε = ε_T·w·u·z, with w = 1 in the middle of the crack's course and 0 at its ends, u = (σ − d)/σ at the distance d
//! from the crack along the ring, and z = 1 at the face and 0 at the crack's bottom. What the wood lost has opened the
//! crack: its opening is the integral of the strain over the range on both sides,
//! ∫ ε dd from −σ to σ = ε_T·σ·w·z, where σ is the arc at that ring (ring radius × angle). For a tangential crack it is
//! ε_R·σ·w·z with σ a part of the radius. As z falls evenly, the section of a groove is a V. Its bottom follows half an
//! ellipse from end to end, the front of a crack that runs in from a face: depth = D·√(w(2 − w)).

mod groove;
mod plan;
mod refine;

pub use groove::{EndFace, Grooved, Setting, end_grooves, grooves};
pub use plan::{CrackPlan, PlannedCrack, Way, plan};

/// Which way grooves go from the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// To smaller lengths: the piece below the face cracks.
    Down,
    /// To greater lengths: the piece above the face cracks.
    Up,
}

/// Why cracks could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CrackError {
    /// The radius or the usable range of the stem makes no sense.
    #[error(
        "cracks need a stem with a radius above 0 and a face within its usable length, found a radius of {radius} m and {low} to {high} m usable"
    )]
    Stem {
        /// Radius found, m.
        radius: f64,
        /// Least usable length, m.
        low: f64,
        /// Greatest usable length, m.
        high: f64,
    },
    /// Too little wood beyond the break to saw its end off straight.
    #[error(
        "the far end is no face that cracks can be cut into, and {left:.3} m of wood that can be cut beyond the break are too little to saw it off straight: {needed:.3} m are needed; break nearer to the base, or crack the break itself (crack_groups.end = \"break\")"
    )]
    TooShort {
        /// Length beyond the break that can be cut, m.
        left: f64,
        /// The least length that is needed, m.
        needed: f64,
    },
    /// The end of the stem was not found.
    #[error(
        "the {which} end of the stem has no end face: {found} points of the skin lie there, at least 3 are needed"
    )]
    NoEnd {
        /// "far" or "near".
        which: &'static str,
        /// Points found.
        found: usize,
    },
}

/// Opening over its greatest (at the same ring) at a part `t` of the course, 0 to 1: w of the corrected Eqs. 13 and 21.
/// A crack that is open at its end (at the bark) is widest there.
pub fn opening(t: f64, open: bool) -> f64 {
    let t = t.clamp(0.0, 1.0);
    if open { t } else { 1.0 - (2.0 * t - 1.0).abs() }
}

/// Depth over the greatest where the opening is `w` of the greatest: half an ellipse over the course.
pub fn depth(w: f64) -> f64 {
    let w = w.clamp(0.0, 1.0);
    (w * (2.0 - w)).sqrt()
}
