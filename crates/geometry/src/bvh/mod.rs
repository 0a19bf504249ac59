//! A bounding-volume hierarchy over boxes, most often those of a mesh's triangles, and its queries.
//!
//! Nodes lie in depth-first order and name the end of their subtree, so that a query by region is one loop without a
//! stack: go on to the next node where the region meets the box, jump to the end of the subtree where it does not.
//! The same boxes give the same tree and the same order of visits on every machine.

mod aabb;
mod build;
mod mesh;

pub use aabb::Aabb;
pub use mesh::{Nearest, closest_point_on_triangle, ray_triangle};

use glam::DVec3;

/// A node of the tree: its box, where its subtree ends, and its items where it is a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    bounds: Aabb,
    /// First node after this one's subtree.
    end: u32,
    /// First item of a leaf in [`Bvh::order`].
    first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    count: u32,
}

/// A bounding-volume hierarchy. Items are the boxes it was built from and are named by their index.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// Items in the order of the leaves.
    order: Vec<u32>,
    /// Boxes in the order of the leaves.
    boxes: Vec<Aabb>,
}

impl Bvh {
    /// The tree over `boxes`; empty boxes and boxes that are not numbers are never found.
    pub fn new(boxes: &[Aabb]) -> Self {
        build::build(boxes)
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The box around everything; [`Aabb::EMPTY`] where there is nothing.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |n| n.bounds)
    }

    /// Visits every item whose box fulfils `meets`, a condition that holds for a box if it holds for a part of it.
    pub fn visit(&self, meets: impl Fn(&Aabb) -> bool, mut visit: impl FnMut(usize)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !meets(&node.bounds) {
                at = node.end as usize;
                continue;
            }
            for i in node.first as usize..(node.first + node.count) as usize {
                if meets(&self.boxes[i]) {
                    visit(self.order[i] as usize);
                }
            }
            at += 1;
        }
    }

    /// Visits every item whose box meets `region`, touching included.
    pub fn overlapping(&self, region: &Aabb, visit: impl FnMut(usize)) {
        self.visit(|b| b.overlaps(region), visit);
    }

    /// Visits every item whose box meets the plane through `point` across `normal` (of any length).
    pub fn straddling(&self, point: DVec3, normal: DVec3, visit: impl FnMut(usize)) {
        let size = normal.abs();
        self.visit(
            |b| {
                let reach = size.dot(b.half_size());
                let distance = normal.dot(b.centre() - point);
                // Rounding may not lose a box that the plane only touches.
                distance.abs()
                    <= reach + 1e-14 * size.dot(b.low.abs().max(b.high.abs()) + point.abs())
            },
            visit,
        );
    }

    /// Visits every item whose box meets the ray from `origin` along `direction` up to `limit` times its length.
    pub fn along_ray(&self, origin: DVec3, direction: DVec3, limit: f64, visit: impl FnMut(usize)) {
        let inverse = direction.recip();
        self.visit(|b| b.ray_entry(origin, inverse, limit).is_some(), visit);
    }

    /// The first hit of the ray from `origin` along `direction`. `hit` gives the place on the ray, in lengths of
    /// `direction`, at which an item is hit; the result is the item and that place, 0 to `limit`.
    pub fn first_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        mut hit: impl FnMut(usize) -> Option<f64>,
    ) -> Option<(usize, f64)> {
        let inverse = direction.recip();
        let mut best = None;
        self.descend(
            limit,
            |b, limit| b.ray_entry(origin, inverse, limit),
            |item, limit| {
                let place = hit(item).filter(|&t| (0.0..=*limit).contains(&t));
                if let Some(t) = place.filter(|&t| best.is_none() || t < *limit) {
                    *limit = t;
                    best = Some((item, t));
                }
            },
        );
        best
    }

    /// The item nearest to `point` among those within `limit`. `distance_squared` gives an item's squared distance;
    /// the result is the item and its squared distance.
    pub fn nearest(
        &self,
        point: DVec3,
        limit: f64,
        mut distance_squared: impl FnMut(usize) -> f64,
    ) -> Option<(usize, f64)> {
        let mut best = None;
        self.descend(
            limit * limit,
            |b, limit| Some(b.distance_squared(point)).filter(|&d| d <= limit),
            |item, limit| {
                let d = distance_squared(item);
                if d < *limit || (best.is_none() && d <= *limit) {
                    *limit = d;
                    best = Some((item, d));
                }
            },
        );
        best
    }

    /// Best-first search: `cost` bounds from below what `visit` finds in a box, `None` where that is beyond the
    /// limit, which `visit` lowers.
    fn descend(
        &self,
        mut limit: f64,
        cost: impl Fn(&Aabb, f64) -> Option<f64>,
        mut visit: impl FnMut(usize, &mut f64),
    ) {
        if self.nodes.is_empty() {
            return;
        }
        // One entry for each level at most, beside the two just opened.
        let mut stack = [(0u32, 0.0f64); build::DEPTH + 2];
        let mut height = 0;
        if let Some(c) = cost(&self.nodes[0].bounds, limit) {
            stack[0] = (0, c);
            height = 1;
        }
        while height > 0 {
            height -= 1;
            let (at, lower) = stack[height];
            if lower > limit {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                for i in node.first as usize..(node.first + node.count) as usize {
                    if cost(&self.boxes[i], limit).is_some() {
                        visit(self.order[i] as usize, &mut limit);
                    }
                }
                continue;
            }
            let left = at + 1;
            let right = self.nodes[left as usize].end;
            let [l, r] =
                [left, right].map(|n| cost(&self.nodes[n as usize].bounds, limit).map(|c| (n, c)));
            // The nearer one is opened first, so it goes on top.
            let (far, near) = match (l, r) {
                (Some(a), Some(b)) if a.1 <= b.1 => (r, l),
                _ => (l, r),
            };
            for entry in [far, near].into_iter().flatten() {
                stack[height] = entry;
                height += 1;
            }
        }
    }

    /// Visits every pair of different items whose boxes meet, each pair once, the smaller item first.
    pub fn self_pairs(&self, mut visit: impl FnMut(usize, usize)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = vec![(0usize, 0usize)];
        while let Some((a, b)) = stack.pop() {
            let (na, nb) = (&self.nodes[a], &self.nodes[b]);
            if a == b {
                if na.count > 0 {
                    let items = na.first as usize..(na.first + na.count) as usize;
                    for i in items.clone() {
                        for j in i + 1..items.end {
                            self.meet(self, i, j, &mut |x, y| visit(x.min(y), x.max(y)));
                        }
                    }
                } else {
                    let right = self.nodes[a + 1].end as usize;
                    stack.extend([(a + 1, right), (right, right), (a + 1, a + 1)]);
                }
            } else if na.bounds.overlaps(&nb.bounds) {
                self.split(self, a, b, &mut stack, &mut |x, y| {
                    visit(x.min(y), x.max(y))
                });
            }
        }
    }

    /// Visits every pair of an item of this tree and an item of the other whose boxes meet.
    pub fn pairs(&self, other: &Bvh, mut visit: impl FnMut(usize, usize)) {
        if self.nodes.is_empty() || other.nodes.is_empty() {
            return;
        }
        let mut stack = vec![(0usize, 0usize)];
        while let Some((a, b)) = stack.pop() {
            if self.nodes[a].bounds.overlaps(&other.nodes[b].bounds) {
                self.split(other, a, b, &mut stack, &mut visit);
            }
        }
    }

    /// Opens the larger of two nodes, or compares the items of two leaves.
    fn split(
        &self,
        other: &Bvh,
        a: usize,
        b: usize,
        stack: &mut Vec<(usize, usize)>,
        visit: &mut impl FnMut(usize, usize),
    ) {
        let (na, nb) = (&self.nodes[a], &other.nodes[b]);
        let open_first = nb.count > 0 || na.bounds.surface() >= nb.bounds.surface();
        if na.count > 0 && nb.count > 0 {
            for i in na.first as usize..(na.first + na.count) as usize {
                if self.boxes[i].overlaps(&nb.bounds) {
                    for j in nb.first as usize..(nb.first + nb.count) as usize {
                        self.meet(other, i, j, visit);
                    }
                }
            }
        } else if na.count == 0 && open_first {
            let right = self.nodes[a + 1].end as usize;
            stack.extend([(right, b), (a + 1, b)]);
        } else {
            let right = other.nodes[b + 1].end as usize;
            stack.extend([(a, right), (a, b + 1)]);
        }
    }

    fn meet(&self, other: &Bvh, i: usize, j: usize, visit: &mut impl FnMut(usize, usize)) {
        if self.boxes[i].overlaps(&other.boxes[j]) {
            visit(self.order[i] as usize, other.order[j] as usize);
        }
    }
}

#[cfg(test)]
mod tests;
