//! Collapses short edges of triangles that cross.
//!
//! Collapsing an edge leaves a closed mesh closed and manifold where its ends have no neighbours in common but those
//! beside it (T. K. Dey, H. Edelsbrunner, S. Guha and D. V. Nekhayev, *Topology preserving edge contraction*, 1999).

use crate::intersect::collinear;
use crate::{Cancelled, Context, Mesh};
use glam::DVec3;

/// Edges that are collapsed between two checks for cancellation.
const CHECK_INTERVAL: usize = 1 << 6;

/// The outcome of [`super::resolve_self_intersections`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Collapsed {
    /// Faults found initially: pairs of triangles that crossed, triangles without area, and triangles at an edge with
    /// more than two.
    pub faults: usize,
    /// Edges collapsed.
    pub edges: usize,
    /// Length of the longest of these, in the unit of the mesh.
    pub longest: f64,
    /// Faults that remain.
    pub remaining: usize,
}

/// The end of an edge that it is collapsed to, by the order of its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CollapseTo {
    /// The point with the lower number.
    First,
    /// The other.
    Second,
}

/// The triangles of a mesh on its points; vertices at one position share a point.
pub struct EdgeCollapser {
    /// Point of every vertex.
    points: Vec<u32>,
    /// The point that each point was merged into, itself at first.
    merged_into: Vec<u32>,
    /// Position of every point.
    pub(super) positions: Vec<DVec3>,
    /// Points of every triangle; they are all equal once it has collapsed.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles at every point.
    around: Vec<Vec<u32>>,
    /// Where edges are collapsed to whose ends are both free.
    to: CollapseTo,
}

impl EdgeCollapser {
    /// Prepares a mesh.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let (points, count) = mesh.points();
        let mut positions = vec![DVec3::ZERO; count];
        for (&point, &position) in points.iter().zip(&mesh.positions) {
            positions[point as usize] = position;
        }
        let triangles = mesh.triangles.iter();
        let triangles = triangles.map(|t| t.map(|v| points[v as usize])).collect();
        let mut collapser = EdgeCollapser::new(positions, triangles);
        collapser.points = points;
        collapser
    }

    /// Prepares triangles whose corners are indices into `positions`, no two of which are equal.
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let count = positions.len();
        let mut collapser = EdgeCollapser {
            merged_into: (0..count as u32).collect(),
            positions,
            triangles,
            around: vec![Vec::new(); count],
            points: Vec::new(),
            to: CollapseTo::First,
        };
        for (t, corners) in collapser.triangles.iter().enumerate() {
            corners
                .iter()
                .for_each(|&p| collapser.around[p as usize].push(t as u32));
        }
        collapser
    }

    /// Sets the end that edges are collapsed to where both are free.
    pub(super) fn collapse_to(&mut self, end: CollapseTo) {
        self.to = end;
    }

    /// Collapses the edges of the triangles in `pairs` that are no longer than `longest`, the shortest first. If one end
    /// `is_fixed`, the other moves to it; if both are, the edge stays. Returns the changed triangles, ascending.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancelled; some edges have been collapsed then.
    pub fn collapse_edges(
        &mut self,
        pairs: &[[u32; 2]],
        longest: f64,
        is_fixed: &dyn Fn(u32) -> bool,
        done: &mut Collapsed,
        context: &Context,
    ) -> Result<Vec<u32>, Cancelled> {
        let mut changed: Vec<u32> = Vec::new();
        for (i, (length, a, b)) in self.edges_of(pairs).into_iter().enumerate() {
            if length > longest {
                break;
            }
            if i % CHECK_INTERVAL == 0 {
                context.check()?;
            }
            let (a, b) = (self.current(a), self.current(b));
            let (a, b) = match self.to {
                CollapseTo::First => (a, b),
                CollapseTo::Second => (b, a),
            };
            let (a, b) = if is_fixed(b) { (b, a) } else { (a, b) };
            if is_fixed(b) || !self.merge(a, b) {
                continue;
            }
            done.edges += 1;
            done.longest = done.longest.max(length);
            changed.extend(&self.around[a as usize]);
        }
        changed.sort_unstable();
        changed.dedup();
        changed.retain(|&t| !self.is_collapsed(t as usize));
        Ok(changed)
    }

    /// Removes the pairs with a triangle that has collapsed or is among `changed` (ascending).
    pub fn retain_unchanged(&self, pairs: &mut Vec<[u32; 2]>, changed: &[u32]) {
        let is_unchanged = |t: u32| {
            let collapsed = (t as usize) < self.triangles.len() && self.is_collapsed(t as usize);
            !collapsed && changed.binary_search(&t).is_err()
        };
        pairs.retain(|p| p.iter().all(|&t| is_unchanged(t)));
    }

    /// Returns the edges of the triangles in `pairs` with their lengths, the shortest first.
    fn edges_of(&self, pairs: &[[u32; 2]]) -> Vec<(f64, u32, u32)> {
        let mut edges: Vec<(f64, u32, u32)> = pairs
            .iter()
            .flatten()
            .flat_map(|&t| {
                let [a, b, c] = self.triangles[t as usize];
                [[a, b], [b, c], [c, a]]
            })
            .map(|[a, b]| {
                let length = self.positions[a as usize].distance(self.positions[b as usize]);
                (length, a.min(b), a.max(b))
            })
            .collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        edges.dedup();
        edges
    }

    /// The point that a point was merged into, itself where it was not.
    fn current(&self, mut point: u32) -> u32 {
        while self.merged_into[point as usize] != point {
            point = self.merged_into[point as usize];
        }
        point
    }

    fn neighbours(&self, point: u32) -> Vec<u32> {
        let mut all: Vec<u32> = (self.around[point as usize].iter())
            .flat_map(|&t| self.triangles[t as usize])
            .filter(|&p| p != point)
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Merges the second of two adjacent points into the first. Returns false, and changes nothing, if the result would not
    /// be a manifold.
    fn merge(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.current(a), self.current(b));
        if a == b {
            return false;
        }
        let beside: Vec<u32> = (self.around[b as usize].iter().copied())
            .filter(|&t| self.triangles[t as usize].contains(&a))
            .collect();
        let [s, t] = beside[..] else {
            return false;
        };
        let (of_a, of_b) = (self.neighbours(a), self.neighbours(b));
        let common = of_b.iter().filter(|p| of_a.binary_search(p).is_ok());
        if common.count() != 2 || of_a.len() + of_b.len() <= 7 {
            return false;
        }
        for collapsed in [s, t] {
            for p in self.triangles[collapsed as usize] {
                self.around[p as usize].retain(|&t| t != collapsed);
            }
            self.triangles[collapsed as usize] = [a; 3];
        }
        let moved = std::mem::take(&mut self.around[b as usize]);
        for &t in &moved {
            for p in &mut self.triangles[t as usize] {
                if *p == b {
                    *p = a;
                }
            }
        }
        self.around[a as usize].extend(moved);
        self.merged_into[b as usize] = a;
        true
    }

    /// Whether the corners of a triangle lie on one line.
    pub(super) fn is_degenerate(&self, t: u32) -> bool {
        let [a, b, c] = self.triangles[t as usize].map(|p| self.positions[p as usize]);
        collinear(a, b, c)
    }

    /// Whether more than two triangles share an edge of a triangle.
    pub(super) fn is_non_manifold(&self, t: u32) -> bool {
        let corners = self.triangles[t as usize];
        (0..3).any(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let around = self.around[a as usize].iter();
            let contains_b = |t: &&u32| self.triangles[**t as usize].contains(&b);
            !self.is_collapsed(t as usize) && around.filter(contains_b).count() > 2
        })
    }

    /// Whether a triangle has collapsed.
    pub fn is_collapsed(&self, t: usize) -> bool {
        self.triangles[t][0] == self.triangles[t][1]
    }

    /// Moves the vertices of the mesh to the positions of their points and removes the collapsed triangles.
    pub(super) fn write_back(&self, mesh: &mut Mesh) {
        for (position, &point) in mesh.positions.iter_mut().zip(&self.points) {
            let current = self.current(point);
            if current != point {
                *position = self.positions[current as usize];
            }
        }
        let mut t = 0;
        mesh.materials.retain(|_| {
            t += 1;
            t > self.triangles.len() || !self.is_collapsed(t - 1)
        });
        let mut t = 0;
        mesh.triangles.retain(|_| {
            t += 1;
            !self.is_collapsed(t - 1)
        });
    }
}
