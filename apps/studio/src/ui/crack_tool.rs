//! What the tool that places drying cracks holds.

use crate::model::placed_cracks::{CrackEndPoint, CrackFace, Polar};
use greenstick::fracture::parameters::CrackEnd;
use std::sync::Arc;

/// What the pointer holds.
#[derive(Debug, Clone)]
pub(super) enum Held {
    /// A crack that is being drawn: where it began on the piece below, and the height there over the break's, m. Its number,
    /// once it is there.
    New(Polar, f32, Option<usize>),
    /// A part of a crack, at a height over the break's, m.
    Part(usize, CrackEndPoint, f32),
}

/// A face, by the number of what is drawn and the break; none where there is no such face.
pub(super) type KnownFace = (u64, usize, Option<Arc<CrackFace>>);

/// The tool that places cracks.
#[derive(Default)]
pub struct CrackTool {
    /// Whether it is on.
    pub on: bool,
    pub(super) selected: Option<usize>,
    pub(super) held: Option<Held>,
    /// Where the first crack is being placed.
    pub(super) at: Option<CrackEnd>,
    /// The ends at the base and at the tip, by the number of what is drawn and the break.
    pub(super) ends: [Option<KnownFace>; 2],
    /// The face that cracks are drawn on, by the number of what is drawn and the break.
    pub(super) face: Option<KnownFace>,
}
