//! Hexahedra of a stem for finite elements, whatever their layout, with their volumes.

use crate::tissue::Zone;
use glam::DVec3;
use greenstick_geometry::Cancelled;

/// How much longer than wide cells are.
pub(super) const SLENDERNESS: f64 = 2.0;
/// Most elements.
pub(super) const MAX_ELEMENTS: f64 = 4e6;

/// An element and its wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemElement {
    /// Nodes: four around the lower face, then those above them.
    pub corners: [u32; 8],
    /// Directions along the grain, across the rings and along them (unit vectors at right angles).
    pub axes: [DVec3; 3],
    /// Tissue.
    pub tissue: Zone,
    /// Ring, counted from 1 at the pith.
    pub ring: u16,
    /// Volume, m³.
    pub volume: f64,
}

/// A stem as hexahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct StemElements {
    /// Nodes in the world, m, section by section from the butt.
    pub nodes: Vec<DVec3>,
    /// Elements, slab by slab from the butt.
    pub elements: Vec<StemElement>,
    /// Numbers of nodes in the section at the butt, which are the first, and in that at the top, which are the last.
    pub end_nodes: [usize; 2],
}

/// Why a stem cannot be divided into elements.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElementError {
    /// Too many elements.
    #[error(
        "elements of {edge:.6} m would be {count:.0}; expected at most 4000000, by longer edges"
    )]
    TooMany {
        /// Their edge, m.
        edge: f64,
        /// Their number.
        count: f64,
    },
    /// A section whose rings do not surround its pith.
    #[error("the section at {0:.3} m has no rings about its pith; expected a whole section")]
    Section(f64),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl StemElements {
    /// Elements with those of the `nodes` that they have; there were `per_section` nodes in each section.
    pub(super) fn of_used_nodes(
        nodes: Vec<DVec3>,
        mut elements: Vec<StemElement>,
        per_section: usize,
    ) -> Self {
        let mut used = vec![false; nodes.len()];
        for corner in elements.iter().flat_map(|e| e.corners) {
            used[corner as usize] = true;
        }
        let count = |of: &[bool]| of.iter().filter(|u| **u).count();
        let end_nodes = [
            count(&used[..per_section]),
            count(&used[nodes.len() - per_section..]),
        ];
        let mut kept = Vec::with_capacity(nodes.len());
        let mut numbers = vec![0; nodes.len()];
        for (k, node) in nodes.into_iter().enumerate().filter(|(k, _)| used[*k]) {
            numbers[k] = kept.len() as u32;
            kept.push(node);
        }
        for element in &mut elements {
            element.corners = element.corners.map(|c| numbers[c as usize]);
        }
        let mut stem = StemElements {
            nodes: kept,
            elements,
            end_nodes,
        };
        stem.measure();
        stem
    }

    /// Sets the volumes of all elements.
    pub(super) fn measure(&mut self) {
        for k in 0..self.elements.len() {
            self.elements[k].volume = self.volume_of(self.elements[k].corners);
        }
    }

    /// Volume of a hexahedron with these corners, m³: that of the trilinear map of a cube, for which two Gauss points along
    /// each axis are exact.
    fn volume_of(&self, corners: [u32; 8]) -> f64 {
        let p = corners.map(|c| self.nodes[c as usize]);
        let points = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        let mut sum = 0.0;
        for u in points {
            for v in points {
                for w in points {
                    let across = |a: usize, b: usize, c: usize, d: usize, t: f64, r: f64| {
                        (p[b] - p[a]) * ((1.0 - t) * (1.0 - r))
                            + (p[c] - p[d]) * (t * (1.0 - r))
                            + (p[b + 4] - p[a + 4]) * ((1.0 - t) * r)
                            + (p[c + 4] - p[d + 4]) * (t * r)
                    };
                    let x = across(0, 1, 2, 3, v, w);
                    let y = across(0, 3, 2, 1, u, w);
                    let lower = p[0] * ((1.0 - u) * (1.0 - v))
                        + p[1] * (u * (1.0 - v))
                        + p[2] * (u * v)
                        + p[3] * ((1.0 - u) * v);
                    let upper = p[4] * ((1.0 - u) * (1.0 - v))
                        + p[5] * (u * (1.0 - v))
                        + p[6] * (u * v)
                        + p[7] * ((1.0 - u) * v);
                    sum += x.cross(y).dot(upper - lower) / 8.0;
                }
            }
        }
        sum
    }

    /// Volume of all elements that fulfil a condition, m³.
    pub fn volume(&self, wanted: impl Fn(&StemElement) -> bool) -> f64 {
        let wanted = self.elements.iter().filter(|e| wanted(e));
        wanted.map(|e| e.volume).sum()
    }
}
