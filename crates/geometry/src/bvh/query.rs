//! Queries by region, along a ray and by distance.

use super::Aabb;
use super::build::MAX_DEPTH;
use super::tree::Bvh;
use glam::DVec3;

impl Bvh {
    /// Visits every item whose box satisfies `meets`, a condition that holds for a box whenever it holds for a part
    /// of it.
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

    /// Visits every item whose box overlaps or touches `region`.
    pub fn overlapping(&self, region: &Aabb, visit: impl FnMut(usize)) {
        self.visit(|b| b.overlaps(region), visit);
    }

    /// Visits every item whose box meets the plane through `point` with the normal `normal` (of any length).
    pub fn straddling(&self, point: DVec3, normal: DVec3, visit: impl FnMut(usize)) {
        let size = normal.abs();
        self.visit(
            |b| {
                let reach = size.dot(b.half_size());
                let distance = normal.dot(b.centre() - point);
                // Rounding must not lose a box that the plane only touches.
                distance.abs()
                    <= reach + 1e-14 * size.dot(b.low.abs().max(b.high.abs()) + point.abs())
            },
            visit,
        );
    }

    /// Finds the first hit of the ray from `origin` along `direction`. `hit` returns the ray parameter, in lengths of
    /// `direction`, at which an item is hit; the result is the item and its parameter, from 0 to `limit`.
    pub fn first_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        mut hit: impl FnMut(usize) -> Option<f64>,
    ) -> Option<(usize, f64)> {
        let inverse = direction.recip();
        let mut best = None;
        self.search(
            limit,
            |b, limit| b.ray_entry(origin, inverse, limit),
            |item, limit| {
                let parameter = hit(item).filter(|&t| (0.0..=*limit).contains(&t));
                if let Some(t) = parameter.filter(|&t| best.is_none() || t < *limit) {
                    *limit = t;
                    best = Some((item, t));
                }
            },
        );
        best
    }

    /// Finds the item nearest to `point` among those within the distance `limit`. `distance_squared` returns the
    /// squared distance of an item; the result is the item and its squared distance.
    pub fn nearest(
        &self,
        point: DVec3,
        limit: f64,
        mut distance_squared: impl FnMut(usize) -> f64,
    ) -> Option<(usize, f64)> {
        let mut best = None;
        self.search(
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

    /// Searches depth first, the nearer child first. `cost` is a lower bound of what `visit` finds in a box, `None`
    /// beyond the limit, which `visit` lowers.
    fn search(
        &self,
        mut limit: f64,
        cost: impl Fn(&Aabb, f64) -> Option<f64>,
        mut visit: impl FnMut(usize, &mut f64),
    ) {
        if self.nodes.is_empty() {
            return;
        }
        // At most one entry for each level beside the two children just opened.
        let mut stack = [(0u32, 0.0f64); MAX_DEPTH + 2];
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
            // The nearer child is opened first, so it goes on top.
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
}
