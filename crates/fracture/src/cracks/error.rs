//! Errors of cracks.

use greenstick_geometry::Cancelled;

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
        "the {which} end is no face that cracks can be cut into, and {left:.3} m of wood that can be cut beyond the break are too little to saw it off straight: {needed:.3} m are needed; break farther from that end, or crack the break itself (crack_groups.end = \"break\")"
    )]
    TooShort {
        /// "far" or "near".
        which: &'static str,
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
    /// The stem grows out of other wood at its base.
    #[error(
        "the stem has no end at its base that cracks could be cut into: it grows out of other wood there; crack its tip (crack_groups.end = \"sawn\"), or the break itself (crack_groups.end = \"break\")"
    )]
    GrowsOn,
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
