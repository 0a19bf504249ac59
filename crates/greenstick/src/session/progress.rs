//! The stages in which a session reports its progress.

use crate::request::BreakStage;
use greenstick_geometry::Stage;

pub(super) const STEM: Stage = Stage::new(BreakStage::Stem.name());
pub(super) const LAYOUT: Stage = Stage::new(BreakStage::Layout.name());
pub(super) const HEIGHTS: Stage = Stage::new(BreakStage::Heights.name());
pub(super) const CUT: Stage = Stage::new(BreakStage::Cut.name());
pub(super) const FINISH: Stage = Stage::new(BreakStage::Finish.name());
/// Baking, the part of the finish that takes longest.
pub(super) const TEXTURES: Stage = Stage::new("textures");
