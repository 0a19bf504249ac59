//! What wood or bark looks like at one point.

use glam::DVec3;

/// What wood or bark looks like at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WoodSurface {
    /// Linear colour, each 0 to 1.
    pub color: [f64; 3],
    /// Roughness as in glTF, 0 to 1.
    pub roughness: f64,
    /// Micro relief, m outwards.
    pub height: f64,
    /// Change of `height` along x and y of the section and along the grain, m per m.
    pub slope: DVec3,
}
