//! The bounding volume hierarchy that rays are traced through: built by binned surface area heuristic (Wald 2007),
//! collapsed to four children per node so that the slab tests of a node run side by side.
//!
//! Coordinates are `f32` relative to the scene's middle. Triangles are met by the watertight test of Woop, Benthin
//! and Wald (2013): no ray slips between two triangles that share an edge.

use glam::{Vec3, Vec4};

/// Triangles in a leaf at most, unless they cannot be told apart.
const LEAF: usize = 4;
/// Bins per axis. More hardly improves the tree; fewer cost rays.
const BINS: usize = 16;
/// Below this many triangles all three axes are tried, above only the widest: there the tree is decided anyway.
const ALL_AXES_BELOW: usize = 16_384;
/// Below this many triangles a subtree is not worth a task.
const TASK: usize = 16_384;
/// Beyond this depth nodes are halved by number, which bounds the depth and with it the traversal's stack.
const HALVE_BELOW_DEPTH: usize = 32;
/// 3 waiting children for each of at most (32 + 31) levels.
const STACK: usize = 192;
/// Relative slack of the slab test that makes it conservative (Ize 2013).
const SLACK: f32 = 1.000_000_5;

/// Components of a direction are taken to be at least this far from zero.
const LEAST_DIRECTION: f32 = 1e-18;

/// A ray; `direction` need not have unit length, distances are in units of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
    /// Hits beyond this distance do not count.
    pub reach: f32,
}

/// Where a ray met a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    pub distance: f32,
    /// Number of the triangle in the order it was given.
    pub triangle: u32,
    /// Weights of the three corners.
    pub weights: [f32; 3],
}

#[derive(Clone, Copy)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const EMPTY: Bounds = Bounds {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    fn join(&mut self, other: &Bounds) {
        for a in 0..3 {
            self.low[a] = lesser(other.low[a], self.low[a]);
            self.high[a] = greater(other.high[a], self.high[a]);
        }
    }

    fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|a| greater(self.high[a] - self.low[a], 0.0));
        x * y + y * z + z * x
    }

    fn middle(&self, axis: usize) -> f32 {
        (self.low[axis] + self.high[axis]) * 0.5
    }
}

// Comparisons instead of `f32::min`: they compile to one instruction, and a NaN in the first argument is dropped.
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[derive(Clone, Copy)]
struct Reference {
    bounds: Bounds,
    triangle: u32,
}

/// A node of the binary tree, in preorder: the left child follows its parent, the right one is `right` further on.
/// Leaves have `count` > 0 triangles from `start`.
struct Binary {
    bounds: Bounds,
    right: u32,
    start: u32,
    count: u32,
}

/// Four children: their boxes by axis, then what they are. `count` 0 is an inner node, else a leaf whose triangles
/// start at `child`. Absent children have empty boxes, which no ray meets.
#[derive(Clone, Copy)]
struct Node {
    low: [Vec4; 3],
    high: [Vec4; 3],
    child: [u32; 4],
    count: [u32; 4],
}

/// The hierarchy over a list of triangles.
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    /// Corners in leaf order.
    corners: Vec<[Vec3; 3]>,
    /// Number of each triangle of `corners` in the list given.
    numbers: Vec<u32>,
}

impl Bvh {
    /// Builds the hierarchy; corners must be finite.
    pub fn build(triangles: &[[Vec3; 3]]) -> Bvh {
        let mut references: Vec<Reference> = triangles
            .iter()
            .enumerate()
            .map(|(i, [a, b, c])| Reference {
                bounds: Bounds {
                    low: a.min(*b).min(*c).to_array(),
                    high: a.max(*b).max(*c).to_array(),
                },
                triangle: i as u32,
            })
            .collect();
        let mut bounds = Bounds::EMPTY;
        references.iter().for_each(|r| bounds.join(&r.bounds));
        let binary = split(&mut references, 0, bounds, 0);
        let mut nodes = Vec::with_capacity(binary.len() / 3 + 1);
        collapse(&binary, 0, &mut nodes);
        let numbers: Vec<u32> = references.iter().map(|r| r.triangle).collect();
        let corners = numbers.iter().map(|&i| triangles[i as usize]).collect();
        Bvh {
            nodes,
            corners,
            numbers,
        }
    }

    /// The nearest triangle the ray meets.
    pub fn nearest(&self, ray: &Ray) -> Option<Meeting> {
        self.traverse::<false>(ray)
    }

    /// Whether the ray meets any triangle.
    pub fn blocks(&self, ray: &Ray) -> bool {
        self.traverse::<true>(ray).is_some()
    }

    fn traverse<const ANY: bool>(&self, ray: &Ray) -> Option<Meeting> {
        // Directions along an axis are tilted by nothing that shows: zero times infinity would be no number.
        let inverse = ray.direction.to_array().map(|d| {
            1.0 / if d.abs() < LEAST_DIRECTION {
                LEAST_DIRECTION.copysign(d)
            } else {
                d
            }
        });
        let origin = ray.origin.to_array();
        let sheared = Sheared::new(ray);
        let mut best: Option<Meeting> = None;
        let mut reach = ray.reach;
        let mut stack = [(0u32, 0u32, 0f32); STACK];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (child, count, entry) = stack[waiting];
            if entry > reach {
                continue;
            }
            if count > 0 {
                for i in child as usize..(child + count) as usize {
                    let Some((distance, weights)) = sheared.meet(&self.corners[i], reach) else {
                        continue;
                    };
                    let triangle = self.numbers[i];
                    if ANY {
                        return Some(Meeting {
                            distance,
                            triangle,
                            weights,
                        });
                    }
                    // Of triangles at the same distance the first in the list given wins, whatever the tree.
                    if best.is_none_or(|b| distance < b.distance || triangle < b.triangle) {
                        best = Some(Meeting {
                            distance,
                            triangle,
                            weights,
                        });
                        reach = distance;
                    }
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let (entries, exits) = slabs(node, origin, inverse, reach);
            let mut open = entries.cmple(exits).bitmask();
            let entries = entries.to_array();
            let first = waiting;
            while open != 0 {
                let c = open.trailing_zeros() as usize;
                open &= open - 1;
                stack[waiting] = (node.child[c], node.count[c], entries[c]);
                // The nearest goes on top; where any will do the order is all the same.
                let mut at = waiting;
                while !ANY && at > first && stack[at - 1].2 < stack[at].2 {
                    stack.swap(at - 1, at);
                    at -= 1;
                }
                waiting += 1;
            }
        }
        best
    }
}

/// Where the ray enters and leaves the four boxes of a node.
#[inline(always)]
fn slabs(node: &Node, origin: [f32; 3], inverse: [f32; 3], reach: f32) -> (Vec4, Vec4) {
    let mut entries = Vec4::ZERO;
    let mut exits = Vec4::splat(reach);
    for a in 0..3 {
        let (near, far) = if inverse[a] < 0.0 {
            (node.high[a], node.low[a])
        } else {
            (node.low[a], node.high[a])
        };
        let (o, i) = (Vec4::splat(origin[a]), Vec4::splat(inverse[a]));
        entries = ((near - o) * i).max(entries);
        exits = ((far - o) * i * SLACK).min(exits);
    }
    (entries, exits)
}

/// A ray in the sheared frame of the watertight test, where it runs along the third axis.
struct Sheared {
    origin: Vec3,
    axes: [usize; 3],
    shear: [f32; 3],
}

impl Sheared {
    fn new(ray: &Ray) -> Sheared {
        let d = ray.direction.to_array();
        let along = (0..3).fold(0, |m, a| if d[a].abs() > d[m].abs() { a } else { m });
        let mut axes = [(along + 1) % 3, (along + 2) % 3, along];
        if d[along] < 0.0 {
            axes.swap(0, 1);
        }
        let shear = [d[axes[0]] / d[along], d[axes[1]] / d[along], 1.0 / d[along]];
        Sheared {
            origin: ray.origin,
            axes,
            shear,
        }
    }

    /// Distance and corner weights where the ray meets the triangle, from either side.
    #[inline(always)]
    fn meet(&self, corners: &[Vec3; 3], reach: f32) -> Option<(f32, [f32; 3])> {
        let [kx, ky, kz] = self.axes;
        let [sx, sy, sz] = self.shear;
        let [a, b, c] = corners.map(|p| (p - self.origin).to_array());
        let (ax, ay) = (a[kx] - sx * a[kz], a[ky] - sy * a[kz]);
        let (bx, by) = (b[kx] - sx * b[kz], b[ky] - sy * b[kz]);
        let (cx, cy) = (c[kx] - sx * c[kz], c[ky] - sy * c[kz]);
        let mut u = cx * by - cy * bx;
        let mut v = ax * cy - ay * cx;
        let mut w = bx * ay - by * ax;
        if u == 0.0 || v == 0.0 || w == 0.0 {
            // On an edge as far as f32 can tell: f64 holds the products exactly.
            let cross = |px: f32, py: f32, qx: f32, qy: f32| {
                (f64::from(px) * f64::from(qy) - f64::from(py) * f64::from(qx)) as f32
            };
            u = cross(cx, cy, bx, by);
            v = cross(ax, ay, cx, cy);
            w = cross(bx, by, ax, ay);
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let distance = (u * a[kz] + v * b[kz] + w * c[kz]) * sz * inverse;
        (distance > 0.0 && distance <= reach)
            .then_some((distance, [u * inverse, v * inverse, w * inverse]))
    }
}

/// Splits a range of triangles, which starts at `start` in the whole list, into a subtree.
fn split(references: &mut [Reference], start: u32, bounds: Bounds, depth: usize) -> Vec<Binary> {
    let mut out = Vec::with_capacity(references.len());
    split_into(references, start, bounds, depth, &mut out);
    out
}

fn split_into(
    references: &mut [Reference],
    start: u32,
    bounds: Bounds,
    depth: usize,
    out: &mut Vec<Binary>,
) {
    let count = references.len();
    let at = out.len();
    out.push(Binary {
        bounds,
        right: 0,
        start,
        count: count as u32,
    });
    if count <= LEAF {
        return;
    }
    let (middle, left, right) = halves(references, depth);
    out[at].count = 0;
    let (first, second) = references.split_at_mut(middle);
    let second_start = start + middle as u32;
    if count > TASK {
        let (a, b) = rayon::join(
            || split(first, start, left, depth + 1),
            || split(second, second_start, right, depth + 1),
        );
        out.extend(a);
        out[at].right = (out.len() - at) as u32;
        out.extend(b);
    } else {
        split_into(first, start, left, depth + 1, out);
        out[at].right = (out.len() - at) as u32;
        split_into(second, second_start, right, depth + 1, out);
    }
}

/// Reorders the triangles into two halves. Returns where the second starts and the bounds of both.
fn halves(references: &mut [Reference], depth: usize) -> (usize, Bounds, Bounds) {
    let mut middles = Bounds::EMPTY;
    for r in references.iter() {
        for a in 0..3 {
            let m = r.bounds.middle(a);
            middles.low[a] = lesser(m, middles.low[a]);
            middles.high[a] = greater(m, middles.high[a]);
        }
    }
    if depth < HALVE_BELOW_DEPTH
        && let Some((axis, bin, left, right)) = best_plane(references, &middles)
    {
        let binning = Binning::new(&middles, axis);
        let (mut i, mut j) = (0, references.len());
        while i < j {
            if binning.of(&references[i]) <= bin {
                i += 1;
            } else {
                j -= 1;
                references.swap(i, j);
            }
        }
        return (i, left, right);
    }
    let middle = references.len() / 2;
    let bounds = |part: &[Reference]| {
        part.iter().fold(Bounds::EMPTY, |mut b, r| {
            b.join(&r.bounds);
            b
        })
    };
    (
        middle,
        bounds(&references[..middle]),
        bounds(&references[middle..]),
    )
}

struct Binning {
    axis: usize,
    low: f32,
    scale: f32,
}

impl Binning {
    fn new(middles: &Bounds, axis: usize) -> Binning {
        let (low, high) = (middles.low[axis], middles.high[axis]);
        Binning {
            axis,
            low,
            scale: BINS as f32 / (high - low),
        }
    }

    fn of(&self, reference: &Reference) -> usize {
        (((reference.bounds.middle(self.axis) - self.low) * self.scale) as usize).min(BINS - 1)
    }
}

/// The plane of least cost: axis, last bin on its left, bounds of both sides. `None` where all middles coincide.
fn best_plane(
    references: &[Reference],
    middles: &Bounds,
) -> Option<(usize, usize, Bounds, Bounds)> {
    let extent = |a: usize| middles.high[a] - middles.low[a];
    let widest = (1..3).fold(0, |m, a| if extent(a) > extent(m) { a } else { m });
    let mut best: Option<(f32, usize, usize, Bounds, Bounds)> = None;
    for axis in 0..3 {
        let binning = Binning::new(middles, axis);
        let skipped = references.len() >= ALL_AXES_BELOW && axis != widest;
        if skipped || !binning.scale.is_finite() {
            continue;
        }
        let mut bins = [(Bounds::EMPTY, 0u32); BINS];
        for r in references {
            let bin = &mut bins[binning.of(r)];
            bin.0.join(&r.bounds);
            bin.1 += 1;
        }
        let mut rights = [(Bounds::EMPTY, 0u32); BINS];
        let mut sum = (Bounds::EMPTY, 0u32);
        for i in (1..BINS).rev() {
            sum.0.join(&bins[i].0);
            sum.1 += bins[i].1;
            rights[i - 1] = sum;
        }
        let mut left = (Bounds::EMPTY, 0u32);
        for i in 0..BINS - 1 {
            left.0.join(&bins[i].0);
            left.1 += bins[i].1;
            let (right, number) = rights[i];
            if left.1 == 0 || number == 0 {
                continue;
            }
            let cost = left.0.half_area() * left.1 as f32 + right.half_area() * number as f32;
            if best.as_ref().is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, i, left.0, right));
            }
        }
    }
    best.map(|(_, axis, bin, left, right)| (axis, bin, left, right))
}

/// Turns the binary subtree at `root` into four-wide nodes; returns the number of its first.
fn collapse(binary: &[Binary], root: usize, nodes: &mut Vec<Node>) -> u32 {
    let mut children = [usize::MAX; 4];
    let mut number = 1;
    children[0] = root;
    while number < 4 {
        // Open the largest inner child.
        let largest = (0..number)
            .filter(|&c| binary[children[c]].count == 0)
            .max_by(|&a, &b| {
                let area = |c: usize| binary[children[c]].bounds.half_area();
                area(a).total_cmp(&area(b))
            });
        let Some(largest) = largest else { break };
        let opened = children[largest];
        children[largest] = opened + 1;
        children[number] = opened + binary[opened].right as usize;
        number += 1;
    }
    let at = nodes.len();
    nodes.push(Node {
        low: [Vec4::INFINITY; 3],
        high: [Vec4::NEG_INFINITY; 3],
        child: [0; 4],
        count: [0; 4],
    });
    for (c, &child) in children[..number].iter().enumerate() {
        let from = &binary[child];
        let below = if from.count > 0 {
            from.start
        } else {
            collapse(binary, child, nodes)
        };
        let node = &mut nodes[at];
        node.child[c] = below;
        node.count[c] = from.count;
        for a in 0..3 {
            node.low[a][c] = from.bounds.low[a];
            node.high[a][c] = from.bounds.high[a];
        }
    }
    at as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash;

    fn random(seed: u32, i: u32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|a| hash(seed, i * 3 + a) as f32 / u32::MAX as f32 - 0.5))
    }

    /// The textbook test of Möller and Trumbore (1997) in f64: another formula than the one in use.
    fn moller(ray: &Ray, corners: &[Vec3; 3]) -> Option<f64> {
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
    fn finds_what_trying_every_triangle_finds() {
        // Enough to be split by tasks, small and large mixed, and 40 copies of one, which no plane can part.
        let mut triangles: Vec<[Vec3; 3]> = (0..20_000)
            .map(|i| {
                let size = if i % 50 == 0 { 0.3 } else { 0.02 };
                let middle = random(1, i);
                [2, 3, 4].map(|s| middle + random(s, i) * size)
            })
            .collect();
        triangles.extend([triangles[7]; 40]);
        let bvh = Bvh::build(&triangles);
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
                reach: f32::INFINITY,
            };
            let expected = triangles
                .iter()
                .filter_map(|t| moller(&ray, t))
                .fold(f64::INFINITY, f64::min);
            let found = bvh
                .nearest(&ray)
                .map_or(f64::INFINITY, |m| f64::from(m.distance));
            assert!(
                found == expected || (found - expected).abs() < 1e-5 * expected.abs(),
                "ray {i}: found {found}, expected {expected}"
            );
            met += u32::from(expected.is_finite());
            assert_eq!(bvh.blocks(&ray), expected.is_finite());
        }
        assert!(met > 100, "only {met} rays met anything");
    }

    #[test]
    fn no_ray_slips_through_shared_edges_and_corners() {
        // A fan whose corners are no round numbers; rays aimed at points on its edges and at its hub.
        let hub = Vec3::new(0.123_4, 0.056_7, 0.9);
        let rim: Vec<Vec3> = (0..24)
            .map(|i| {
                let (y, x) = (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
                Vec3::new(x, y, 1.1 + 0.1 * x)
            })
            .collect();
        let fan: Vec<[Vec3; 3]> = (0..24).map(|i| [hub, rim[i], rim[(i + 1) % 24]]).collect();
        let bvh = Bvh::build(&fan);
        for i in 0..20_000u32 {
            let origin = random(9, i) * 0.4 - Vec3::Z;
            let along = hash(10, i) as f32 / u32::MAX as f32 * 0.99;
            let aim = hub + (rim[i as usize % 24] - hub) * along;
            let ray = Ray {
                origin,
                direction: aim - origin,
                reach: f32::INFINITY,
            };
            assert!(bvh.blocks(&ray), "ray {i} slipped through");
        }
    }
}
