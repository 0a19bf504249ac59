//! The address of a point in a stem.

use glam::DVec2;

/// The address of a point in a stem: ring coordinate, angle and length, with the point's place in its section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemAddress {
    /// Ring coordinate ρ: 0 at the pith, 1 at the outside of the bark.
    pub rho: f64,
    /// Angle about the pith, rad.
    pub angle: f64,
    /// Place in the section, m from the pith.
    pub across: DVec2,
    /// Length along the grain, m.
    pub along: f64,
}
