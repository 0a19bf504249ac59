//! Errors of the skin of rods.

use greenstick_schema::ParameterError;

/// Why there is no skin.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RodSkinError {
    /// A frame that does not fit the scene's wood.
    #[error(
        "{what} of the frame is not of this scene's wood: {problem}; the frames and the scene must be of one run"
    )]
    OtherBundle {
        /// What does not fit.
        what: &'static str,
        /// How.
        problem: String,
    },
    /// An option that is wrong.
    #[error(transparent)]
    Option(#[from] ParameterError),
    /// More prisms than memory or file formats can hold.
    #[error(
        "the skin would have {prisms} parts ({columns} columns of {slabs} slabs), more than {max}; ask for fewer fibres or slabs"
    )]
    TooLarge {
        /// Number of prisms.
        prisms: usize,
        /// Number of columns.
        columns: usize,
        /// Number of slabs.
        slabs: usize,
        /// Greatest number of prisms.
        max: usize,
    },
}
