//! What does not change with a break but is not needed for drawing one: measured when it is first asked for, then kept.

use greenstick_fracture::layout::SkinDepth;
use greenstick_geometry::repair::KnownPositions;
use greenstick_wood::appearance::EndSection;
use std::sync::{Arc, OnceLock};

/// Measures of a stem that were asked for so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Measured {
    pub ends: OnceLock<Vec<EndSection>>,
    pub closed_volume: OnceLock<(bool, Option<f64>)>,
    pub positions: OnceLock<KnownPositions>,
    pub skin_depth: OnceLock<Arc<SkinDepth>>,
}
