//! The bounding-volume hierarchy for ray tracing. Its nodes have four children, so that their slab tests run in parallel.
//!
//! Coordinates are `f32` relative to the centre of the scene. The intersection test is watertight (Woop, Benthin and Wald
//! 2013): no ray passes between two triangles that share an edge.
//!
//! `greenstick_geometry::bvh::Bvh`, in `f64`, serves queries on boxes and near points instead.

mod bounds;
mod build;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use build::{LEAF, LEAF_SIZE, Node};

/// Nodes that wait in a traversal without memory of their own: 3 for each level of a usual tree. A tree has at most 32 + 31.
const STACK_SIZE: usize = 48;
/// Factor that makes the slab test conservative (Ize 2013).
const SLAB_TOLERANCE: f32 = 1.000_000_5;

/// Smallest magnitude of a component of a direction.
const MIN_DIRECTION: f32 = 1e-18;

/// A ray. Distances are in lengths of `direction`, which need not be 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
    /// Intersections beyond this distance are ignored.
    pub max_distance: f32,
}

/// The intersection of a ray with a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Intersection {
    pub distance: f32,
    /// Index of the triangle in the original list.
    pub triangle: u32,
    /// Barycentric weights of the corners.
    pub weights: [f32; 3],
    /// The corners.
    pub corners: [Vec3; 3],
}

/// The hierarchy over a list of triangles.
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    /// The triangles of each leaf.
    leaves: Vec<Leaf>,
}

/// The triangles of a leaf, side by side, so that a ray is tested with all of them at once.
#[derive(Clone, Copy)]
struct Leaf {
    /// Coordinates of the three corners, by axis; NaN, which no ray meets, where there are fewer triangles than four.
    corners: [[Vec4; 3]; 3],
    /// Index of each triangle in the original list.
    numbers: [u32; LEAF_SIZE],
}

impl Leaf {
    fn new(triangles: &[[Vec3; 3]], numbers: &[u32]) -> Leaf {
        let mut leaf = Leaf {
            corners: [[Vec4::NAN; 3]; 3],
            numbers: [u32::MAX; LEAF_SIZE],
        };
        for (lane, &number) in numbers.iter().enumerate() {
            leaf.numbers[lane] = number;
            for (corner, p) in leaf.corners.iter_mut().zip(triangles[number as usize]) {
                for (axis, coordinate) in corner.iter_mut().zip(p.to_array()) {
                    axis[lane] = coordinate;
                }
            }
        }
        leaf
    }

    fn triangle(&self, lane: usize) -> [Vec3; 3] {
        (self.corners).map(|corner| Vec3::from_array(corner.map(|axis| axis[lane])))
    }
}

impl Bvh {
    /// Builds the hierarchy. Corners must be finite.
    pub fn new(triangles: &[[Vec3; 3]]) -> Bvh {
        let build::Tree {
            nodes,
            leaves,
            order,
        } = build::build(triangles);
        let leaf = |&(first, count): &(u32, u32)| {
            Leaf::new(triangles, &order[first as usize..(first + count) as usize])
        };
        Bvh {
            nodes,
            leaves: leaves.par_iter().map(leaf).collect(),
        }
    }

    /// Finds the nearest intersection.
    pub fn nearest(&self, ray: &Ray) -> Option<Intersection> {
        self.traverse::<false>(ray)
    }

    /// Whether the ray hits any triangle.
    pub fn is_blocked(&self, ray: &Ray) -> bool {
        self.traverse::<true>(ray).is_some()
    }

    /// Finds the nearest intersection, or, with `ANY`, the first one that comes up.
    fn traverse<const ANY: bool>(&self, ray: &Ray) -> Option<Intersection> {
        // Directions along an axis are tilted imperceptibly, because 0 × ∞ is NaN.
        let inverse = ray.direction.to_array().map(|d| {
            1.0 / if d.abs() < MIN_DIRECTION {
                MIN_DIRECTION.copysign(d)
            } else {
                d
            }
        });
        let origin = ray.origin.to_array();
        // Many rays miss everything.
        let (entries, exits) = slabs(&self.nodes[0], origin, inverse, ray.max_distance);
        if !entries.cmple(exits).any() {
            return None;
        }
        let sheared = ShearedRay::new(ray);
        let mut best: Option<Intersection> = None;
        let mut max_distance = ray.max_distance;
        let mut stack = Stack::default();
        stack.push((0, 0.0));
        while let Some((child, entry)) = stack.pop() {
            if entry > max_distance {
                continue;
            }
            if child & LEAF != 0 {
                let leaf = &self.leaves[(child & !LEAF) as usize];
                let (mut met, distances, weights) = sheared.intersect(leaf, max_distance);
                while met != 0 {
                    let lane = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let found = Intersection {
                        distance: distances[lane],
                        triangle: leaf.numbers[lane],
                        weights: weights.map(|w| w[lane]),
                        corners: leaf.triangle(lane),
                    };
                    if ANY {
                        return Some(found);
                    }
                    // Of triangles at the same distance the first in the original list wins, whatever the tree.
                    if best
                        .is_none_or(|b| (found.distance, found.triangle) < (b.distance, b.triangle))
                    {
                        best = Some(found);
                        max_distance = found.distance;
                    }
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let (entries, exits) = slabs(node, origin, inverse, max_distance);
            let mut open = entries.cmple(exits).bitmask();
            let entries = entries.to_array();
            // The nearest child goes on top; for any intersection the order does not matter.
            let mut found = [(0u32, 0f32); 4];
            let mut number = 0;
            while open != 0 {
                let c = open.trailing_zeros() as usize;
                open &= open - 1;
                let mut at = number;
                while !ANY && at > 0 && found[at - 1].1 < entries[c] {
                    found[at] = found[at - 1];
                    at -= 1;
                }
                found[at] = (node.child[c], entries[c]);
                number += 1;
            }
            found[..number].iter().for_each(|&f| stack.push(f));
        }
        best
    }
}

/// The nodes and leaves that a traversal has still to look at, and where it enters them.
struct Stack {
    first: [(u32, f32); STACK_SIZE],
    height: usize,
    /// What does not fit into `first`.
    rest: Vec<(u32, f32)>,
}

impl Default for Stack {
    fn default() -> Self {
        Stack {
            first: [(0, 0.0); STACK_SIZE],
            height: 0,
            rest: Vec::new(),
        }
    }
}

impl Stack {
    #[inline(always)]
    fn push(&mut self, node: (u32, f32)) {
        match self.first.get_mut(self.height) {
            Some(free) => {
                *free = node;
                self.height += 1;
            }
            None => self.rest.push(node),
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<(u32, f32)> {
        if let Some(last) = self.rest.pop() {
            return Some(last);
        }
        self.height = self.height.checked_sub(1)?;
        Some(self.first[self.height])
    }
}

/// Where the ray enters and leaves the boxes of the four children.
#[inline(always)]
fn slabs(node: &Node, origin: [f32; 3], inverse: [f32; 3], max_distance: f32) -> (Vec4, Vec4) {
    let mut entries = Vec4::ZERO;
    let mut exits = Vec4::splat(max_distance);
    for a in 0..3 {
        let (near, far) = if inverse[a] < 0.0 {
            (node.high[a], node.low[a])
        } else {
            (node.low[a], node.high[a])
        };
        let (o, i) = (Vec4::splat(origin[a]), Vec4::splat(inverse[a]));
        entries = ((near - o) * i).max(entries);
        exits = ((far - o) * i * SLAB_TOLERANCE).min(exits);
    }
    (entries, exits)
}

/// A ray in the sheared frame of the watertight test, in which it runs along the third axis.
struct ShearedRay {
    origin: Vec3,
    axes: [usize; 3],
    shear: [f32; 3],
}

impl ShearedRay {
    fn new(ray: &Ray) -> ShearedRay {
        let d = ray.direction.to_array();
        let along = (0..3).fold(0, |m, a| if d[a].abs() > d[m].abs() { a } else { m });
        let mut axes = [(along + 1) % 3, (along + 2) % 3, along];
        if d[along] < 0.0 {
            axes.swap(0, 1);
        }
        let shear = [d[axes[0]] / d[along], d[axes[1]] / d[along], 1.0 / d[along]];
        ShearedRay {
            origin: ray.origin,
            axes,
            shear,
        }
    }

    /// Intersects the ray with the triangles of a leaf, from either side. Returns a bit for each one that it meets, and the distances
    /// and the barycentric weights.
    #[inline(always)]
    fn intersect(&self, leaf: &Leaf, max_distance: f32) -> (u32, Vec4, [Vec4; 3]) {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let origin = self.origin.to_array();
        // Coordinates in the sheared frame, and along the ray. `map` on an array of them would not be inlined.
        let sheared = |corner: &[Vec4; 3]| {
            let from = |axis: usize| corner[axis] - Vec4::splat(origin[axis]);
            let along = from(kz);
            [from(kx) - sx * along, from(ky) - sy * along, along]
        };
        let [first, second, third] = &leaf.corners;
        let (a, b, c) = (sheared(first), sheared(second), sheared(third));
        let mut u = c[0] * b[1] - c[1] * b[0];
        let mut v = a[0] * c[1] - a[1] * c[0];
        let mut w = b[0] * a[1] - b[1] * a[0];
        let zero = Vec4::ZERO;
        let mut on_edge = (u.cmpeq(zero) | v.cmpeq(zero) | w.cmpeq(zero)).bitmask();
        while on_edge != 0 {
            let lane = on_edge.trailing_zeros() as usize;
            on_edge &= on_edge - 1;
            // On an edge to within f32: the products are exact in f64.
            let cross = |p: &[Vec4; 3], q: &[Vec4; 3]| {
                let product = |x: f32, y: f32| f64::from(x) * f64::from(y);
                (product(p[0][lane], q[1][lane]) - product(p[1][lane], q[0][lane])) as f32
            };
            (u[lane], v[lane], w[lane]) = (cross(&c, &b), cross(&a, &c), cross(&b, &a));
        }
        let is_outside = (u.cmplt(zero) | v.cmplt(zero) | w.cmplt(zero))
            & (u.cmpgt(zero) | v.cmpgt(zero) | w.cmpgt(zero));
        if is_outside.all() {
            return (0, zero, [zero; 3]);
        }
        let determinant = u + v + w;
        let inverse = 1.0 / determinant;
        let distance = (u * a[2] + v * b[2] + w * c[2]) * sz * inverse;
        let is_met = !is_outside
            & determinant.cmpne(zero)
            & distance.cmpgt(zero)
            & distance.cmple(Vec4::splat(max_distance));
        (
            is_met.bitmask(),
            distance,
            [u * inverse, v * inverse, w * inverse],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash;

    fn random(seed: u32, i: u32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|a| hash(seed, i * 3 + a) as f32 / u32::MAX as f32 - 0.5))
    }

    /// The intersection test of Möller and Trumbore (1997) in f64.
    fn moller_trumbore(ray: &Ray, corners: &[Vec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (e, f) = (b - a, c - a);
        let p = d.cross(f);
        let s = (o - a) / e.dot(p);
        let (u, q) = (s.dot(p), s.cross(e));
        let (v, t) = (d.dot(q), f.dot(q));
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
    }

    #[test]
    fn traversal_matches_exhaustive_search() {
        // Enough triangles for a parallel build, of mixed sizes, and 40 copies of one, which no plane separates.
        let mut triangles: Vec<[Vec3; 3]> = (0..20_000)
            .map(|i| {
                let size = if i % 50 == 0 { 0.3 } else { 0.02 };
                let middle = random(1, i);
                [2, 3, 4].map(|s| middle + random(s, i) * size)
            })
            .collect();
        triangles.extend([triangles[7]; 40]);
        let bvh = Bvh::new(&triangles);
        let mut met = 0;
        for i in 0..300 {
            let origin = random(5, i) * 3.0;
            let mut direction = random(6, i) - origin;
            if i % 10 == 0 {
                direction = Vec3::from_array([0.0, 0.0, -origin.z.signum()]);
            }
            let ray = Ray {
                origin,
                direction,
                max_distance: f32::INFINITY,
            };
            let expected = triangles
                .iter()
                .filter_map(|t| moller_trumbore(&ray, t))
                .fold(f64::INFINITY, f64::min);
            let found = bvh
                .nearest(&ray)
                .map_or(f64::INFINITY, |m| f64::from(m.distance));
            assert!(
                found == expected || (found - expected).abs() < 1e-5 * expected.abs(),
                "ray {i}: found {found}, expected {expected}"
            );
            met += u32::from(expected.is_finite());
            assert_eq!(bvh.is_blocked(&ray), expected.is_finite());
        }
        assert!(met > 100, "only {met} rays hit a triangle");
    }

    #[test]
    fn no_ray_passes_through_shared_edges_and_corners() {
        // A fan with arbitrary corners; rays towards points on its edges and at its hub.
        let hub = Vec3::new(0.123_4, 0.056_7, 0.9);
        let rim: Vec<Vec3> = (0..24)
            .map(|i| {
                let (y, x) = (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
                Vec3::new(x, y, 1.1 + 0.1 * x)
            })
            .collect();
        let fan: Vec<[Vec3; 3]> = (0..24).map(|i| [hub, rim[i], rim[(i + 1) % 24]]).collect();
        let bvh = Bvh::new(&fan);
        for i in 0..20_000u32 {
            let origin = random(9, i) * 0.4 - Vec3::Z;
            let along = hash(10, i) as f32 / u32::MAX as f32 * 0.99;
            let aim = hub + (rim[i as usize % 24] - hub) * along;
            let ray = Ray {
                origin,
                direction: aim - origin,
                max_distance: f32::INFINITY,
            };
            assert!(bvh.is_blocked(&ray), "ray {i} passed through");
        }
    }
}
