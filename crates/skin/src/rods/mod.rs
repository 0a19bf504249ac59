//! The skin of a bundle of rods: closed meshes that follow the rods, split where they broke (Sutherland 2012 §5).
//!
//! The wood is parted into **prisms**: columns in the section (the rods' Voronoi cells, each of several fibre bundles)
//! times slabs along the grain. Two prisms that meet are joined where a bond holds their rods together there, or where
//! they are of one rod that is whole there. The skin is every face between prisms that are not joined. So it is closed
//! and oriented whatever breaks, faces inside whole wood are not made at all, and the two sides of a break are the same
//! faces. Pieces are what bonds hold together: the connected components of the bond graph.
//!
//! A vertex follows the rods of all prisms that are joined around it, each at the vertex's place along it: the thesis's
//! associations (vertex–edge with λ, vertex–vertex where λ is 0), of which the mean is what its averaging iterations
//! tend to. It is linear in the rods' frames, so the skin is linear blend skinning with one joint for each vertex of a
//! rod. An association goes with its bond, as the prisms then are no longer joined.

mod bark;
mod complex;
mod earlier;
mod faces;
mod gape;
mod history;
mod hull;
mod joints;
mod kerf;
mod mend;
mod meshes;
mod parting;
mod section;
mod tips;

pub use gape::{Gape, Gapes};
pub use history::History;
pub use joints::{Joints, frame_poses};
pub use meshes::{Materials, RodSkin, rod_skin, rod_skin_over_time};
pub use parting::{Part, Parting, Pieces, RodBreak};
pub use section::{Bonded, Column, Columns, OUTSIDE, columns};

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
    /// The stem's world to that of the rods.
    pub laid: DAffine3,
    /// The unbroken bundle at rest.
    pub bundle: &'a RodBundle,
    /// Length along the axis of each of its vertices, m.
    pub along: &'a [f64],
    /// Cell of each rod in the section of the stem's place, grain coordinates, m.
    pub cells: &'a [VoronoiCell],
    /// Outline of that section, m, counter-clockwise.
    pub outline: &'a [DVec2],
    /// Its bark: a mesh in the stem's world, whose texture coordinates, colours and materials the outside keeps, and the
    /// tree over its triangles; the outline scaled where `None`.
    pub bark: Option<(&'a Mesh, &'a Bvh)>,
    /// Tensile strength along the grain over four times the shear strength: how many of its widths a fibre bundle pulls
    /// out (shear lag, `ℓ = f_t0 d / 4 f_v`).
    pub pull_out: f64,
}

impl Wood<'_> {
    /// The rod of each vertex.
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

    /// The pairs of rods that are bonded.
    pub fn bonded(&self) -> Bonded {
        let rod_of = self.rods_of_vertices();
        let bonds = self.bundle.bonds.vertex.iter().zip(&self.bundle.bonds.edge);
        bonds
            .map(|(&v, &e)| (rod_of[v as usize], rod_of[e as usize]))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect()
    }
}

/// How the skin is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodSkinOptions {
    /// Fibre bundles that a rod's cell is parted into, about; 1 for the cell itself.
    pub fibres: u32,
    /// Length of splinters over that of shear lag; 0 for flat ends at the broken vertices, as in the thesis.
    pub splinters: f64,
    /// Slabs for each edge of a rod.
    pub slabs: f64,
    /// Whether faces between bonded rods are kept, so that every rod's mesh is closed by itself.
    pub keep_inner: bool,
    /// What bounds the section.
    pub outline: Outline,
    /// Seed of what is random.
    pub seed: u64,
}

/// What bounds the section of a skin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Outline {
    /// The stem's own contour, on the bark of its mesh.
    #[default]
    Contour,
    /// The convex hull of the rods, as far outside of the outer ones as half the distance between rods: Sutherland's (2012
    /// §5.1.1).
    Hull,
}

impl Default for RodSkinOptions {
    fn default() -> Self {
        RodSkinOptions {
            fibres: 4,
            splinters: 1.0,
            slabs: 2.0,
            keep_inner: false,
            outline: Outline::Contour,
            seed: 1,
        }
    }
}

/// Why there is no skin.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RodSkinError {
    /// A frame that does not fit the scene's wood.
    #[error(
        "{what} of the frame is not of this scene's wood: {problem}; the frames and the scene must be of one run"
    )]
    OtherBundle {
        /// What does not fit.
        what: &'static str,
        /// How.
        problem: String,
    },
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which.
        what: &'static str,
        /// The value found.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// More faces than memory or file formats have room for.
    #[error(
        "the skin would have {prisms} parts ({columns} columns of {slabs} slabs), more than {most}; ask for fewer fibres or slabs"
    )]
    TooLarge {
        /// Parts.
        prisms: usize,
        /// Columns.
        columns: usize,
        /// Slabs.
        slabs: usize,
        /// The most that are made.
        most: usize,
    },
}
