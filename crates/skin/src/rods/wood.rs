//! The wood that a bundle of rods stands for.

use super::columns::BondedRods;
use glam::{DAffine3, DVec2};
use greenstick_fibre::RodBundle;
use greenstick_fibre::placement::VoronoiCell;
use greenstick_geometry::{Bvh, Mesh};
use greenstick_wood::stem::Stem;

/// The wood that rods stand for.
#[derive(Clone, Copy)]
pub struct Wood<'a> {
    /// The stem.
    pub stem: &'a Stem,
    /// Maps the stem's world to that of the rods.
    pub stem_to_rods: DAffine3,
    /// The unbroken bundle at rest.
    pub bundle: &'a RodBundle,
    /// Length along the axis of each of its vertices, m.
    pub along: &'a [f64],
    /// Cell of each rod in the section at the stem's location, grain coordinates, m.
    pub cells: &'a [VoronoiCell],
    /// Outline of that section, m, counter-clockwise.
    pub outline: &'a [DVec2],
    /// The bark: a mesh in the stem's world, whose texture coordinates, colours and materials the outside takes over, and
    /// the tree over its triangles. Where it is `None`, the outline is scaled along the stem.
    pub bark: Option<(&'a Mesh, &'a Bvh)>,
    /// Tensile strength along the grain over four times the shear strength: the length over which a fibre bundle pulls
    /// out, in its widths (shear lag, `ℓ = f_t0 d / 4 f_v`).
    pub pull_out: f64,
}

impl Wood<'_> {
    /// Returns the rod of each vertex.
    pub(crate) fn rods_of_vertices(&self) -> Vec<u32> {
        let mut rod_of = vec![0; self.bundle.vertices()];
        for rod in 0..self.bundle.rods() {
            rod_of[self.bundle.rod(rod)].fill(rod as u32);
        }
        rod_of
    }

    /// Returns the mean distance between rods, m.
    pub fn spacing(&self) -> f64 {
        let area: f64 = self.cells.iter().map(|c| c.area).sum();
        (area / self.cells.len().max(1) as f64).sqrt()
    }

    /// Returns the pairs of rods that are bonded in the unbroken bundle.
    pub fn bonded_rods(&self) -> BondedRods {
        let rod_of = self.rods_of_vertices();
        let bonds = self.bundle.bonds.vertex.iter().zip(&self.bundle.bonds.edge);
        bonds
            .map(|(&v, &e)| (rod_of[v as usize], rod_of[e as usize]))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect()
    }
}
