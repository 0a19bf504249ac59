//! What a check looks for and what it found.

use serde::{Deserialize, Serialize};

/// Most places that a report lists for each kind of defect.
pub(super) const MAX_PLACES: usize = 8;

/// What [`Mesh::check_with`](crate::Mesh::check_with) looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CheckOptions {
    /// Whether to look for triangles that touch or cross, which takes most of the time.
    pub self_intersections: bool,
}

impl Default for CheckOptions {
    fn default() -> Self {
        CheckOptions {
            self_intersections: true,
        }
    }
}

/// The result of a check. Edges and vertices are those of points: vertices at equal positions count as one. Triangles
/// with an index out of range, a corner that is not finite, or two corners at one point are counted as such and
/// otherwise ignored.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Distinct positions of vertices.
    pub points: usize,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Shells: sets of triangles that share points.
    pub components: usize,
    /// Whether there are triangles and every edge has exactly two of them.
    pub closed: bool,
    /// Edges with one triangle.
    pub boundary_edges: usize,
    /// Connected sets of boundary edges: the rims of holes.
    pub boundary_loops: usize,
    /// A point of each of the first few boundary loops.
    pub boundary_places: Vec<[f64; 3]>,
    /// Whether the triangles at every edge use it equally often in both directions, boundaries aside. In a mesh that is
    /// also closed that is once in each direction.
    pub oriented: bool,
    /// Edges that are used more often in one direction than in the other, boundaries aside.
    pub misoriented_edges: usize,
    /// Midpoints of the first few of these edges.
    pub misoriented_places: Vec<[f64; 3]>,
    /// Edges with more than two triangles.
    pub non_manifold_edges: usize,
    /// Midpoints of the first few of these edges.
    pub non_manifold_edge_places: Vec<[f64; 3]>,
    /// Points whose triangles form several fans that share no edge there.
    pub non_manifold_vertices: usize,
    /// The first few of these points.
    pub non_manifold_vertex_places: Vec<[f64; 3]>,
    /// Triangles with two corners at one point, or with all three corners exactly on a line.
    pub degenerate_triangles: usize,
    /// Centres of the first few of these triangles.
    pub degenerate_places: Vec<[f64; 3]>,
    /// Triangles with the same three points as an earlier one, in either orientation.
    pub duplicate_triangles: usize,
    /// Vertices with a coordinate that is infinite or not a number.
    pub non_finite_positions: usize,
    /// Triangles with an index beyond the last vertex.
    pub indices_out_of_range: usize,
    /// Area of all triangles, m² where positions are in metres.
    pub area_m2: f64,
    /// Volume, m³ where positions are in metres, negative where the surface is inside out; `None` unless the mesh is
    /// closed and oriented.
    pub volume_m3: Option<f64>,
    /// Triangles that touch or cross; `None` where they were not looked for.
    pub self_intersections: Option<SelfIntersections>,
}

/// Most pairs of triangles that meet which are counted: in a mesh of arbitrary triangles their number grows with the square
/// of that of the triangles.
pub const MAX_CONTACTS: usize = 1_000_000;

/// Pairs of triangles that meet elsewhere than in a shared vertex or edge (see [`crate::intersect::contact`]).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SelfIntersections {
    /// Pairs of triangles that pass through each other or overlap in one plane.
    pub crossing: usize,
    /// Pairs that touch without crossing.
    pub touching: usize,
    /// Places of the first few crossing pairs.
    pub crossing_places: Vec<[f64; 3]>,
    /// Places of the first few touching pairs.
    pub touching_places: Vec<[f64; 3]>,
    /// Whether the search ended before all pairs were looked at, at [`MAX_CONTACTS`] or because far too many triangles lie
    /// beside each other.
    #[serde(default)]
    pub incomplete: bool,
}

impl Report {
    /// Whether the mesh bounds a solid: closed, oriented, manifold, positive in volume, and free of every defect
    /// looked for. Touching is allowed.
    pub fn is_solid(&self) -> bool {
        self.closed
            && self.oriented
            && self.volume_m3.is_some_and(|v| v > 0.0)
            && self.non_manifold_vertices == 0
            && self.degenerate_triangles == 0
            && self.duplicate_triangles == 0
            && self.non_finite_positions == 0
            && self.indices_out_of_range == 0
            && self
                .self_intersections
                .as_ref()
                .is_none_or(|s| s.crossing == 0 && !s.incomplete)
    }
}
