//! Bisects the edges of triangles that cross after a curved map has moved their corners.
//!
//! A one-to-one map takes a surface that does not cross itself to another such surface; the straight triangles between
//! the mapped corners may still cross. The smaller a triangle, the nearer it lies to the curved one that it approximates,
//! so the longest edges of crossing triangles are bisected, in both triangles beside each (M.-C. Rivara, *Algorithms for
//! refining triangular grids suitable for adaptive and multigrid techniques*, 1984), until nothing crosses.

use crate::intersect::{Contact, TriangleContacts, contact, contact_boxes, overlapping_pairs};
use crate::{Aabb, Bvh, Cancelled, Context, Mesh};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// "No triangle".
const NONE: u32 = u32::MAX;
/// An edge with more than two triangles.
const NON_MANIFOLD: u32 = u32::MAX - 1;

/// Triangles whose edges can be bisected.
pub struct EdgeBisector {
    /// Vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The original triangle that each triangle is a part of.
    pub origins: Vec<u32>,
    /// Point of each vertex: vertices at one position share one.
    points: Vec<u32>,
    point_count: u32,
    /// The two triangles at each edge; the key of an edge is its two points.
    edges: FxHashMap<[u32; 2], [u32; 2]>,
}

fn edge_key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl EdgeBisector {
    /// Prepares `triangles` for bisection. `points` holds the point of each vertex, all less than `point_count`.
    pub fn new(triangles: Vec<[u32; 3]>, points: Vec<u32>, point_count: u32) -> Self {
        let mut bisector = EdgeBisector {
            origins: (0..triangles.len() as u32).collect(),
            edges: FxHashMap::default(),
            triangles: Vec::new(),
            points,
            point_count,
        };
        bisector.edges.reserve(triangles.len() * 3 / 2);
        for (t, &corners) in triangles.iter().enumerate() {
            let at = corners.map(|v| bisector.points[v as usize]);
            for k in 0..3 {
                let sides = bisector
                    .edges
                    .entry(edge_key(at[k], at[(k + 1) % 3]))
                    .or_insert([NONE; 2]);
                match sides {
                    [first, _] if *first == NONE => *first = t as u32,
                    [_, second] if *second == NONE => *second = t as u32,
                    _ => *sides = [NON_MANIFOLD; 2],
                }
            }
        }
        bisector.triangles = triangles;
        bisector
    }

    fn replace_side(&mut self, a: u32, b: u32, old: u32, new: u32) {
        if let Some(sides) = self.edges.get_mut(&edge_key(a, b)) {
            for side in sides.iter_mut().filter(|s| **s == old) {
                *side = new;
            }
        }
    }

    /// Finds the longest edge of triangle `t` that exactly two triangles share. Returns its index in the triangle, and the
    /// other triangle.
    fn longest_shared_edge(
        &self,
        t: u32,
        length: &dyn Fn(u32, u32) -> f64,
    ) -> Option<(usize, u32)> {
        let corners = self.triangles[t as usize];
        let mut best: Option<(f64, usize, u32)> = None;
        for k in 0..3 {
            let (u, v) = (corners[k], corners[(k + 1) % 3]);
            let ends = edge_key(self.points[u as usize], self.points[v as usize]);
            let sides = self.edges.get(&ends).copied().unwrap_or([NON_MANIFOLD; 2]);
            if sides[1] == NONE || sides[0] == NON_MANIFOLD || sides[0] == sides[1] {
                continue;
            }
            let other = if sides[0] == t { sides[1] } else { sides[0] };
            let l = length(u, v);
            if best.is_none_or(|b| l > b.0) {
                best = Some((l, k, other));
            }
        }
        best.map(|(_, k, other)| (k, other))
    }

    /// Whether an edge of triangle `t` that exactly two triangles share is a `chosen` one.
    pub fn has_shared_edge(&self, t: u32, chosen: &dyn Fn(u32, u32) -> bool) -> bool {
        let length = |a: u32, b: u32| if chosen(a, b) { 1.0 } else { 0.0 };
        self.longest_shared_edge(t, &length).is_some_and(|(k, _)| {
            let corners = self.triangles[t as usize];
            chosen(corners[k], corners[(k + 1) % 3])
        })
    }

    /// Bisects the longest edge of triangle `t` that exactly two triangles share. Returns the four resulting triangles, or
    /// `None` if there is no such edge. `length` returns the length of the edge between two vertices; `midpoint` adds the
    /// vertex in the middle of two and returns its index.
    pub fn bisect(
        &mut self,
        t: u32,
        length: &dyn Fn(u32, u32) -> f64,
        midpoint: &mut dyn FnMut(u32, u32) -> u32,
    ) -> Option<[u32; 4]> {
        let corners = self.triangles[t as usize];
        let (k, other) = self.longest_shared_edge(t, length)?;
        let (u, v, w) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let (p, q) = (self.points[u as usize], self.points[v as usize]);
        let beside = self.triangles[other as usize];
        let j = (0..3).find(|&j| {
            let ends = [beside[j], beside[(j + 1) % 3]].map(|x| self.points[x as usize]);
            ends == [q, p]
        })?;
        let (x, y, z) = (beside[j], beside[(j + 1) % 3], beside[(j + 2) % 3]);
        let middle = midpoint(u, v);
        let point = self.point_count;
        self.point_count += 1;
        self.points.push(point);
        let middle_beside = if [x, y] == [v, u] {
            middle
        } else {
            self.points.push(point);
            midpoint(y, x)
        };
        let (first, second) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
        self.triangles[t as usize] = [u, middle, w];
        self.triangles.push([middle, v, w]);
        self.triangles[other as usize] = [x, middle_beside, z];
        self.triangles.push([middle_beside, y, z]);
        let (of_t, of_other) = (self.origins[t as usize], self.origins[other as usize]);
        self.origins.extend([of_t, of_other]);
        let (r, s) = (self.points[w as usize], self.points[z as usize]);
        self.replace_side(q, r, t, first);
        self.replace_side(p, s, other, second);
        self.edges.remove(&edge_key(p, q));
        self.edges.insert(edge_key(p, point), [t, second]);
        self.edges.insert(edge_key(point, q), [first, other]);
        self.edges.insert(edge_key(point, r), [t, first]);
        self.edges.insert(edge_key(point, s), [other, second]);
        Some([t, first, other, second])
    }
}

/// Returns the pairs of triangles that cross, ascending; with `changed`, only pairs with at least one of these.
///
/// # Errors
/// [`Cancelled`] where the caller cancelled.
pub fn crossing_pairs(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    changed: Option<&[u32]>,
    context: &Context,
) -> Result<Vec<[u32; 2]>, Cancelled> {
    let Some(changed) = changed else {
        let all = Mesh {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            ..Mesh::default()
        };
        context.check()?;
        let (count, boxes) = (triangles.len(), contact_boxes(&all));
        return crossing_pairs_within(positions, triangles, count, &boxes, context);
    };
    let mut pairs = Vec::new();
    // Few have changed, mostly: a tree of those alone is quickly built.
    let corners = |t: u32| triangles[t as usize].map(|v| positions[v as usize]);
    let boxes: Vec<Aabb> = changed.iter().map(|&t| Aabb::around(&corners(t))).collect();
    context.check()?;
    let tree = Bvh::new(&boxes);
    for t in 0..triangles.len() as u32 {
        context.check()?;
        let place = corners(t);
        tree.overlapping(&Aabb::around(&place), |i| {
            let s = changed[i];
            if s != t && contact(corners(s), place) == Contact::Crossing {
                pairs.push([s.min(t), s.max(t)]);
            }
        });
    }
    context.check()?;
    pairs.sort_unstable();
    pairs.dedup();
    Ok(pairs)
}

/// Returns the pairs of triangles that cross and at least one of which is among the first `count`, ascending. `boxes` has
/// a box for each triangle, in any coordinates in which the boxes of triangles that cross overlap: the tighter they
/// are, the fewer pairs have to be looked at.
///
/// # Errors
/// [`Cancelled`] where the caller cancelled.
pub fn crossing_pairs_within(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    count: usize,
    boxes: &[Aabb],
    context: &Context,
) -> Result<Vec<[u32; 2]>, Cancelled> {
    context.check()?;
    let contacts = TriangleContacts::new(positions, triangles);
    context.check()?;
    let crosses = |s, t| contacts.between(s, t) == Contact::Crossing;
    overlapping_pairs(boxes, count, crosses, context)
}
