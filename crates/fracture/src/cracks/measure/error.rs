//! Errors of measuring cracks.

/// Mean radius of the smallest section that is measured, pixels.
pub(super) const MIN_RADIUS: f64 = 40.0;

/// Why cracks cannot be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// The pixels are not as many as the size says.
    #[error("a photograph of {width} × {height} pixels has {found} values, expected {}", width * height)]
    Size {
        /// Width, pixels.
        width: usize,
        /// Height, pixels.
        height: usize,
        /// Values found.
        found: usize,
    },
    /// The section does not stand out from its background.
    #[error(
        "no section was found in the photograph: {problem}; give its outline, or the pith and a radius around it"
    )]
    NoSection {
        /// What was found instead.
        problem: String,
    },
    /// The outline makes no section.
    #[error(
        "{problem}; expected an outline around the pith ({x:.1}, {y:.1}), within the photograph"
    )]
    Outline {
        /// What is wrong.
        problem: String,
        /// Pith, pixels from the left.
        x: f64,
        /// Pith, pixels from the top.
        y: f64,
    },
    /// The section has too few pixels.
    #[error(
        "the section is {radius:.0} pixels in radius; at least {} are needed for cracks to be seen",
        MIN_RADIUS
    )]
    Small {
        /// Mean radius, pixels.
        radius: f64,
    },
}
