//! The outline of a cut on the skin, with the vertices and triangles that the cut makes there.

use super::super::parts::{CutVertex, Host, SkinTriangle};
use crate::surface::FractureSurface;
use glam::DVec3;
use greenstick_geometry::triangulate::Triangulator;
use rustc_hash::FxHashMap;

/// A point where the surface cuts an edge of a clipped polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeCut {
    /// Fraction of the edge from the vertex with the smaller number.
    pub fraction: f64,
    pub id: u32,
    /// Heights of the edge's ends above the surface, as bits.
    pub above: [u64; 2],
    /// The next one on the same edge, or [`NONE`].
    pub next: u32,
}

/// The outline of the cut and everything found on the way. Vertex numbers below `points.len()` are the skin's points,
/// the others index `vertices`.
pub(in super::super) struct Overlay<'a> {
    pub(super) surface: &'a FractureSurface,
    /// Whether facets may have different heights at a node.
    pub(super) stepped: bool,
    /// Grain coordinates of the skin's points.
    pub(super) points: &'a [DVec3],
    /// Vertices made by the cut.
    pub vertices: Vec<CutVertex>,
    /// Outline on the top of a facet, directed as the upper skin has it: (facet, [from, to]).
    pub tops: Vec<(u32, [u32; 2])>,
    /// Outline on the wall over an edge: (edge, [from, to]).
    pub walls: Vec<(u32, [u32; 2])>,
    /// Outline points on the top rim of a wall: (edge, which of its facets), fraction of the edge, vertex; see
    /// [`Overlay::sort`].
    pub rails: Vec<((u32, u8), f64, u32)>,
    /// Where the line along the grain over a node pierces the skin: node, length, vertex; see [`Overlay::sort`].
    pub uprights: Vec<(u32, f64, u32)>,
    /// New triangles of the skin.
    pub skin: Vec<SkinTriangle>,
    /// Number of each of [`Clips::vertices`] in this cut, or [`NONE`].
    pub(super) made: Vec<u32>,
    /// First of `cuts` on the edge between two vertices.
    pub(super) first_cuts: FxHashMap<(u32, u32), u32>,
    pub(super) cuts: Vec<EdgeCut>,
    pub(super) triangulator: Triangulator,
}

impl<'a> Overlay<'a> {
    /// Returns an empty overlay with capacity for `vertices` on the skin.
    pub fn new(
        (surface, stepped): (&'a FractureSurface, bool),
        points: &'a [DVec3],
        vertices: usize,
    ) -> Self {
        Overlay {
            surface,
            stepped,
            points,
            vertices: Vec::with_capacity(vertices),
            tops: Vec::with_capacity(vertices),
            walls: Vec::new(),
            rails: Vec::with_capacity(vertices),
            uprights: Vec::new(),
            skin: Vec::with_capacity(2 * vertices),
            made: Vec::new(),
            first_cuts: FxHashMap::with_capacity_and_hasher(vertices, Default::default()),
            cuts: Vec::with_capacity(vertices),
            triangulator: Triangulator::default(),
        }
    }

    /// Number of the skin's points.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// Grain coordinates of a vertex.
    pub fn grain(&self, id: u32) -> DVec3 {
        match (id as usize).checked_sub(self.points.len()) {
            None => self.points[id as usize],
            Some(i) => self.vertices[i].grain,
        }
    }

    /// Adds a vertex; returns its number.
    pub fn add(&mut self, grain: DVec3, host: Host) -> u32 {
        self.vertices.push(CutVertex { grain, host });
        (self.points.len() + self.vertices.len() - 1) as u32
    }

    /// Sorts what was found by where it lies; to be done before [`Overlay::rail`] and [`Overlay::upright`].
    pub fn sort(&mut self) {
        self.rails
            .sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        self.rails.dedup();
        self.uprights
            .sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }

    /// Outline points on the rim of a wall, by rising fraction.
    pub fn rail(&self, edge: u32, which: u8) -> impl DoubleEndedIterator<Item = (f64, u32)> {
        let from = self.rails.partition_point(|r| r.0 < (edge, which));
        let count = self.rails[from..].partition_point(|r| r.0 == (edge, which));
        self.rails[from..from + count].iter().map(|r| (r.1, r.2))
    }

    /// Where the line along the grain over a node pierces the skin, by rising length.
    pub fn upright(&self, node: u32) -> impl Iterator<Item = (f64, u32)> {
        let from = self.uprights.partition_point(|r| r.0 < node);
        let count = self.uprights[from..].partition_point(|r| r.0 == node);
        self.uprights[from..from + count].iter().map(|r| (r.1, r.2))
    }

    /// Barycentric weights of a vertex in the triangle with the points `corners`.
    pub fn weights(&self, id: u32, corners: [u32; 3]) -> [f64; 3] {
        let unit = |p: u32| [0, 1, 2].map(|i| f64::from(u8::from(corners[i] == p)));
        let Some(i) = (id as usize).checked_sub(self.points.len()) else {
            return unit(id);
        };
        match self.vertices[i].host {
            Host::Point(p) => unit(p),
            Host::Edge { ends, t } => {
                let (u, v) = (unit(ends[0]), unit(ends[1]));
                [0, 1, 2].map(|i| u[i] * (1.0 - t) + v[i] * t)
            }
            Host::Face { weights, .. } => weights,
            Host::Inside => [f64::NAN; 3],
        }
    }
}
