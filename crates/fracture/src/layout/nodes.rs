//! Nodes of a layout while they are made.

use super::bundles::LayoutOptions;
use glam::DVec2;
use greenstick_wood::rings::RingField;

/// Nodes of a layout while they are made.
pub(super) struct NodeBuilder<'a> {
    pub field: &'a RingField,
    pub nodes: Vec<DVec2>,
    pub addresses: Vec<(f64, f64)>,
}

impl NodeBuilder<'_> {
    /// Adds a node beyond the skin, so far out that a chord to the next node, at the angle `gap` (rad), stays there too.
    pub fn beyond(&mut self, options: &LayoutOptions, phi: f64, gap: f64) -> u32 {
        let (sin, cos) = libm::sincos(phi);
        let radius = 1.02 * options.radius / libm::cos((gap / 2.0).min(1.2));
        self.nodes
            .push(self.field.pith() + DVec2::new(cos, sin) * radius);
        self.addresses.push((options.reach.1, phi));
        self.nodes.len() as u32 - 1
    }

    pub fn node(&mut self, rho: f64, phi: f64) -> u32 {
        self.nodes.push(self.field.point(rho, phi));
        self.addresses.push((rho, phi));
        self.nodes.len() as u32 - 1
    }
}

pub(super) fn directions(addresses: &[(f64, f64)]) -> Vec<DVec2> {
    let direction = |&(_, phi): &(f64, f64)| {
        let (sin, cos) = libm::sincos(phi);
        DVec2::new(cos, sin)
    };
    addresses.iter().map(direction).collect()
}

/// An irrational angle (rad) by which rays are offset, so that none runs exactly through a vertex of a symmetrical mesh.
pub(super) const RAY_OFFSET: f64 = 0.011_318_29;
