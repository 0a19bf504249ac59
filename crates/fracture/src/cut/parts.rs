//! What goes into a cut, a mesh by its points, and what comes out: vertices, triangles and faces.

use glam::DVec3;

/// Where a vertex of a cut lies, so that positions and attributes can be taken from the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Host {
    /// A point of the mesh.
    Point(u32),
    /// On the edge between two points, the smaller number first, at fraction `t` from it.
    Edge {
        /// The edge's points.
        ends: [u32; 2],
        /// Fraction from the first to the second, 0 to 1.
        t: f64,
    },
    /// Inside a triangle of the mesh, with barycentric weights.
    Face {
        /// The triangle.
        triangle: u32,
        /// Weights of its corners; their sum is 1.
        weights: [f64; 3],
    },
    /// Inside the wood, placed by its grain coordinates.
    Inside,
}

/// A vertex made by a cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutVertex {
    /// Grain coordinates (x, y, s), m.
    pub grain: DVec3,
    /// Where it lies.
    pub host: Host,
}

/// What a triangle of the broken face belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CapFace {
    /// Cell (fibre bundle) of the surface's layout; for a wall the one that stands higher.
    pub cell: u32,
    /// True for the top of a cell, false for a wall along the grain.
    pub top: bool,
}

/// A part of a cut triangle of the skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkinTriangle {
    /// The triangle of the mesh it is a part of.
    pub source: u32,
    /// Vertices, numbered as in [`Cut`](super::Cut).
    pub corners: [u32; 3],
    /// Whether it belongs to the upper piece.
    pub upper: bool,
}

/// Which piece a whole triangle of the mesh goes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Not part of the shell that was cut.
    Elsewhere,
    /// Unchanged in the lower piece.
    Lower,
    /// Unchanged in the upper piece.
    Upper,
    /// Cut into [`Cut::skin`](super::Cut::skin).
    Split,
}

/// A mesh to cut. Topology is by points: vertices at equal positions have one number.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    /// Point numbers of each triangle's corners.
    pub triangles: &'a [[u32; 3]],
    /// Grain coordinates of each point; NaN for points off the limb.
    pub points: &'a [DVec3],
    /// The triangles of the shell to cut.
    pub shell: &'a [u32],
    /// Those of the shell that the surface may meet; all their points have grain coordinates.
    pub limb: &'a [u32],
}
