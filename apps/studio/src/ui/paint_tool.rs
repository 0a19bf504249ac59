//! What the tool that paints on the broken face holds.

use crate::model::painted::{Brush, BrushKind};
use crate::model::placed_cracks::Polar;
use eframe::egui::Pos2;

/// A place of the section, and a height over the break's, m.
pub(super) type WoodPlace = (Polar, f32);

/// A stroke that is being painted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    /// Where its last dab was, and the height there over the break's, m.
    pub(super) last: WoodPlace,
    /// The height where it began, m over the break's.
    pub(super) began: f32,
}

/// The tool that paints.
#[derive(Debug)]
pub struct PaintTool {
    /// Whether it is on.
    pub on: bool,
    /// Its brush.
    pub brush: Brush,
    pub(super) stroke: Option<Stroke>,
    /// Where the pointer was last, on which scene, and what of the wood is there.
    pub(super) under: Option<(Pos2, u64, Option<WoodPlace>)>,
}

impl Default for PaintTool {
    fn default() -> Self {
        PaintTool {
            on: false,
            brush: Brush {
                kind: BrushKind::Stay,
                size: 0.4,
                strength: 0.5,
            },
            stroke: None,
            under: None,
        }
    }
}
