//! Fibre bundles of a section.

use super::skin_depth::SkinDepth;
use crate::surface::SectionLayout;
use glam::DVec2;
use std::sync::Arc;

/// Options of a layout.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutOptions {
    /// Number of rings N_ring.
    pub rings: usize,
    /// Number of sectors N_sec; in the fibrous layout those of the outermost ring.
    pub sectors: usize,
    /// Ring coordinates that the layout covers, so that it holds all of the section and its relief.
    pub reach: (f64, f64),
    /// Distance from the pith up to which it reaches, m.
    pub radius: f64,
    /// Angles (rad) between which the section lies, where the pith is outside of it (a board); `None` for all around.
    pub arc: Option<(f64, f64)>,
    /// Ring coordinate at which the bark begins (fibrous layout); `None` where there is none (a board).
    pub bark: Option<f64>,
    /// Greatest ring coordinate at which the bark may begin, in the middles of sectors of equal width from the angle −π on, so that no wood
    /// is bare where the skin dips (fibrous layout). Empty where it begins at `bark` all around.
    pub bark_below: Vec<f64>,
    /// Ring coordinates of the annual rings' outer edges, ascending (fibrous layout): bundles part at them. Empty where the
    /// rings are not known.
    pub ring_edges: Vec<f64>,
    /// Seed of the irregularity.
    pub seed: u64,
}

/// A fibre bundle of a layout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FibreBundle {
    /// Number of its ring, 0 at the pith.
    pub ring: u32,
    /// Number of its sector in that ring.
    pub sector: u32,
    /// Ring coordinate of its middle.
    pub rho: f64,
    /// Angle of its middle, rad.
    pub phi: f64,
    /// Half its width along the ring, rad.
    pub half_width: f64,
    /// Whether it is bark.
    pub bark: bool,
}

/// The fibre bundles of a section: a layout, with the bundles that its cells stand for and the addresses of its nodes.
#[derive(Debug, Clone, Default)]
pub struct FibreBundles {
    /// The triangulation.
    pub layout: Arc<SectionLayout>,
    /// Fibre bundles; [`SectionLayout::cells`] indexes them.
    pub bundles: Vec<FibreBundle>,
    /// Ring coordinate and angle (rad) of every node.
    pub addresses: Vec<(f64, f64)>,
    /// Cosine and sine of the angle of every node.
    pub directions: Vec<DVec2>,
    /// For each bundle the node within it that carries its tip, or [`crate::surface::NONE`].
    pub tips: Vec<u32>,
    /// How deep the skin lies that thorns of a smooth face stay below; `None` where it is not known.
    pub skin: Option<Arc<SkinDepth>>,
}
