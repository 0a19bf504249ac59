//! Errors of the skin of rods.

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
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which.
        what: &'static str,
        /// The value found.
        value: f64,
        /// The range allowed.
        right: &'static str,
    },
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
