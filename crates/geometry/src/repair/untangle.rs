//! Moves vertices of triangles that cross until they no longer do.
//!
//! A vertex is moved where that lessens the length along which the triangles about it cross others: towards the mean of its
//! neighbours, or along the normals of the triangles that are crossed. The length, unlike the number of pairs, falls before
//! the last of a bundle of triangles has come free, so that vertices can be moved one after another. They are moved to
//! positions that `f32` holds, so that files keep what was found, and never to the position of another vertex, which would
//! join what lies apart.

use super::bisection::crossing_pairs;
use crate::intersect::{Contact, Plane, contact};
use crate::{Aabb, Bvh, Context};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// Rounds over all vertices of triangles that cross.
const ROUNDS: usize = 8;
/// Steps along normals, as parts of the greatest distance a vertex may be moved.
const STEPS: [f64; 5] = [1.0, 0.25, 0.0625, 0.016, 0.004];
/// Steps towards the mean of the neighbours, as parts of the way there.
const TO_MEAN: [f64; 3] = [1.0, 0.5, 0.2];
/// Normals along which one vertex is tried: those of so many triangles that are crossed.
const MOST_NORMALS: usize = 4;
/// A move is made where it lessens the length of crossings by more than this part of it, so that rounding moves nothing.
const LEAST_GAIN: f64 = 1e-6;
/// More than the rounding errors of positions in files and of rotated coordinates, relative to the largest coordinate.
const ROUNDING: f64 = 1e-6;

/// Triangles of which some cross, with the vertices that may be moved.
pub struct Untangler<'a> {
    /// Positions of the vertices.
    pub positions: &'a mut [DVec3],
    /// All triangles, those that stay where they are included.
    pub triangles: &'a [[u32; 3]],
    /// Whether a vertex may be moved.
    pub is_free: &'a dyn Fn(u32) -> bool,
    /// The greatest distance that a vertex is moved.
    pub reach: f64,
    /// Once the caller cancels in it, no further vertex is moved.
    pub context: &'a Context,
}

/// What moving vertices has led to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Untangled {
    /// Vertices moved, ascending.
    pub moved: Vec<u32>,
    /// The greatest distance that one was moved.
    pub farthest: f64,
}

/// A frame about a vertex, along the longest edge there: long triangles beside each other lie apart in its boxes.
struct Frame {
    axes: [DVec3; 3],
    /// Bound of the rounding errors of positions and of rotated coordinates.
    margin: f64,
}

impl Frame {
    fn along(direction: DVec3, near: DVec3) -> Frame {
        let x = direction.try_normalize().unwrap_or(DVec3::X);
        let (y, z) = x.any_orthonormal_pair();
        Frame {
            axes: [x, y, z],
            margin: ROUNDING * (near.abs().element_sum() + direction.length()),
        }
    }

    fn rotated(&self, p: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        DVec3::new(x.dot(p), y.dot(p), z.dot(p))
    }

    fn bounds(&self, corners: [DVec3; 3]) -> Aabb {
        Aabb::around(&corners.map(|p| self.rotated(p))).grown(self.margin)
    }
}

/// A triangle where it is, with what is asked of it over and over.
struct Placed {
    vertices: [u32; 3],
    corners: [DVec3; 3],
    /// In the frame of the vertex.
    bounds: Aabb,
    plane: Plane,
}

impl Placed {
    fn new(frame: &Frame, vertices: [u32; 3], corners: [DVec3; 3]) -> Placed {
        Placed {
            vertices,
            corners,
            bounds: frame.bounds(corners),
            plane: Plane::new(corners),
        }
    }

    fn crosses(&self, other: &Placed) -> bool {
        self.bounds.overlaps(&other.bounds)
            && !self.is_clearly_beside(other)
            && !other.is_clearly_beside(self)
            && contact(self.corners, other.corners) == Contact::Crossing
    }

    /// Whether this triangle lies clearly on one side of another but for the corners that they share.
    fn is_clearly_beside(&self, other: &Placed) -> bool {
        let corner = |k: usize| {
            let is_shared = other.vertices.contains(&self.vertices[k]);
            (self.corners[k], is_shared)
        };
        other.plane.is_clearly_beside_but([0, 1, 2].map(corner))
    }
}

/// What lies about one vertex.
struct Surroundings {
    frame: Frame,
    /// Triangles at the vertex first, then others whose boxes they may come to overlap.
    placed: Vec<Placed>,
    /// How many are at the vertex.
    own: usize,
    /// All pairs of which the first is at the vertex, each once. Those that were found to cross last come first, as they
    /// are likeliest to cross again.
    pairs: Vec<[u32; 2]>,
}

impl Surroundings {
    fn new(frame: Frame, placed: Vec<Placed>, own: usize) -> Surroundings {
        let (first, count) = (own as u32, placed.len() as u32);
        let pairs = (0..first)
            .flat_map(|s| (s + 1..count).map(move |t| [s, t]))
            .collect();
        Surroundings {
            frame,
            placed,
            own,
            pairs,
        }
    }

    /// Moves the vertex.
    fn move_to(&mut self, v: u32, place: DVec3) {
        for t in &mut self.placed[..self.own] {
            let corner = |k: usize| match t.vertices[k] == v {
                true => place,
                false => t.corners[k],
            };
            *t = Placed::new(&self.frame, t.vertices, [0, 1, 2].map(corner));
        }
    }

    /// The length along which the triangles at the vertex cross each other and others, and the number of pairs that cross, which are
    /// the first now; summing ends beyond `limit`.
    fn length(&mut self, limit: f64) -> (f64, usize) {
        let (mut sum, mut crossing) = (0.0, 0);
        for i in 0..self.pairs.len() {
            let [s, t] = self.pairs[i].map(|n| &self.placed[n as usize]);
            if s.crosses(t) {
                sum += crossing_length(s.corners, t.corners);
                self.pairs.swap(crossing, i);
                crossing += 1;
                if sum > limit {
                    break;
                }
            }
        }
        (sum, crossing)
    }

    /// Unit normals of the triangles in the first pairs, which cross.
    fn normals(&self, crossing: usize) -> Vec<DVec3> {
        let mut crossed: Vec<u32> = self.pairs[..crossing].iter().flatten().copied().collect();
        crossed.sort_unstable();
        crossed.dedup();
        let mut normals = Vec::new();
        for t in crossed {
            let [a, b, c] = self.placed[t as usize].corners;
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let near = |n: &DVec3| n.dot(normal).abs() > 0.99;
            if normal != DVec3::ZERO && !normals.iter().any(near) {
                normals.push(normal);
            }
            if normals.len() == MOST_NORMALS {
                break;
            }
        }
        normals
    }
}

impl Untangler<'_> {
    /// Moves vertices of the triangles in `pairs`, which cross, until none does or no move helps. `pairs` then has those that
    /// are left.
    pub fn untangle(&mut self, pairs: &mut Vec<[u32; 2]>) -> Untangled {
        let mut done = Untangled::default();
        if pairs.is_empty() {
            return done;
        }
        let boxes: Vec<Aabb> = (self.triangles.iter())
            .map(|t| Aabb::around(&t.map(|v| self.positions[v as usize])).grown(self.reach))
            .collect();
        let tree = Bvh::new(&boxes);
        let around = self.around();
        let first = self.positions.to_vec();
        let mut taken: FxHashSet<[u64; 3]> = first.iter().copied().map(position_key).collect();
        // How many vertices had been tried when a triangle was last changed, and when a vertex was last tried without success.
        let mut changed_at = vec![0; self.triangles.len()];
        let mut failed_at: FxHashMap<u32, u32> = FxHashMap::default();
        let mut tried = 0;
        for _ in 0..ROUNDS {
            let mut changed: Vec<u32> = Vec::new();
            for v in self.vertices_of(pairs) {
                if self.context.check().is_err() {
                    break;
                }
                tried += 1;
                let own = &around[v as usize];
                let region = (own.iter()).fold(Aabb::EMPTY, |all, &t| all.join(&boxes[t as usize]));
                let mut near = Vec::new();
                tree.overlapping(&region, |t| near.push(t as u32));
                // What failed among the same triangles would fail again.
                let is_older = |t: &u32, then: u32| changed_at[*t as usize] <= then;
                if (failed_at.get(&v)).is_some_and(|&then| near.iter().all(|t| is_older(t, then))) {
                    continue;
                }
                let from = self.positions[v as usize];
                if self.improve(v, own, first[v as usize], near, &taken) {
                    taken.remove(&position_key(from));
                    taken.insert(position_key(self.positions[v as usize]));
                    own.iter().for_each(|&t| changed_at[t as usize] = tried);
                    changed.extend(own);
                    done.moved.push(v);
                } else {
                    failed_at.insert(v, tried);
                }
            }
            if changed.is_empty() {
                break;
            }
            changed.sort_unstable();
            changed.dedup();
            pairs.retain(|p| p.iter().all(|t| changed.binary_search(t).is_err()));
            let now = crossing_pairs(self.positions, self.triangles, Some(&changed), self.context);
            let Ok(now) = now else {
                break;
            };
            pairs.extend(now);
            pairs.sort_unstable();
            pairs.dedup();
            if pairs.is_empty() {
                break;
            }
        }
        done.moved.sort_unstable();
        done.moved.dedup();
        let distance = |&v: &u32| self.positions[v as usize].distance(first[v as usize]);
        done.farthest = done.moved.iter().map(distance).fold(0.0, f64::max);
        done
    }

    /// Triangles at every vertex.
    fn around(&self) -> Vec<Vec<u32>> {
        let mut around = vec![Vec::new(); self.positions.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            for &v in corners {
                around[v as usize].push(t as u32);
            }
        }
        around
    }

    /// The vertices of the triangles in `pairs` that may be moved, ascending.
    fn vertices_of(&self, pairs: &[[u32; 2]]) -> Vec<u32> {
        let all = pairs.iter().flatten();
        let mut vertices: Vec<u32> = all
            .flat_map(|&t| self.triangles[t as usize])
            .filter(|&v| (self.is_free)(v))
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Moves a vertex, first at `origin`, whose triangles are `own`, to the best of the places tried; returns false where none is
    /// better than its own. `near` are the triangles that those may come to touch.
    fn improve(
        &mut self,
        v: u32,
        own: &[u32],
        origin: DVec3,
        near: Vec<u32>,
        taken: &FxHashSet<[u64; 3]>,
    ) -> bool {
        let from = self.positions[v as usize];
        let mut about = self.surroundings(own, origin, near);
        let (length, crossing) = about.length(f64::INFINITY);
        let mut best = (length, from);
        if crossing == 0 {
            return false;
        }
        // Rounding to `f32` may lengthen the way by less than this.
        let rounding = f64::from(f32::EPSILON) * (origin.abs().max_element() + self.reach);
        let reach = (self.reach - rounding).max(0.0);
        for place in self.places(v, &about, crossing) {
            let place = origin + (place - origin).clamp_length_max(reach);
            let place = place.as_vec3().as_dvec3();
            if taken.contains(&position_key(place)) {
                continue;
            }
            about.move_to(v, place);
            let (length, _) = about.length(best.0);
            if length < best.0 * (1.0 - LEAST_GAIN) {
                best = (length, place);
                if length == 0.0 {
                    break;
                }
            }
        }
        self.positions[v as usize] = best.1;
        best.1 != from
    }

    /// What lies about the vertex whose triangles are `own`, wherever it is moved from its first place, `origin`; `near` holds all of it,
    /// and more.
    fn surroundings(&self, own: &[u32], origin: DVec3, mut near: Vec<u32>) -> Surroundings {
        let edges = own.iter().flat_map(|&t| {
            let [a, b, c] = self.corners(t);
            [b - a, c - b, a - c]
        });
        let longest = edges.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let frame = Frame::along(longest.unwrap_or_default(), origin);
        let placed = |t: u32| Placed::new(&frame, self.triangles[t as usize], self.corners(t));
        let mut all: Vec<Placed> = own.iter().map(|&t| placed(t)).collect();
        let reached = Aabb::around(&[frame.rotated(origin)]).grown(self.reach + frame.margin);
        let reached = (all.iter()).fold(reached, |all, t| all.join(&t.bounds));
        near.sort_unstable();
        near.retain(|t| {
            let bounds = frame.bounds(self.corners(*t));
            bounds.overlaps(&reached) && own.binary_search(t).is_err()
        });
        all.extend(near.into_iter().map(placed));
        Surroundings::new(frame, all, own.len())
    }

    /// The places to try for a vertex.
    fn places(&self, v: u32, about: &Surroundings, crossing: usize) -> Vec<DVec3> {
        let from = self.positions[v as usize];
        let mut places = Vec::new();
        let neighbours = (about.placed[..about.own].iter())
            .flat_map(|t| t.vertices)
            .filter(|&w| w != v);
        let (sum, count) = neighbours.fold((DVec3::ZERO, 0), |(sum, n), w| {
            (sum + self.positions[w as usize], n + 1)
        });
        let mean = sum / f64::from(count.max(1));
        places.extend(TO_MEAN.map(|part| from.lerp(mean, part)));
        for normal in about.normals(crossing) {
            for step in STEPS {
                places.push(from + normal * (step * self.reach));
                places.push(from - normal * (step * self.reach));
            }
        }
        places
    }

    fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.positions[v as usize])
    }
}

/// The bits of a position; both zeros have the same.
fn position_key(p: DVec3) -> [u64; 3] {
    (p + 0.0).to_array().map(f64::to_bits)
}

/// The length of the line along which two triangles that cross meet; for triangles in one plane, that of the shorter of
/// their longest edges. It is more than 0.
fn crossing_length(a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    let normal = |t: [DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]);
    let (na, nb) = (normal(a), normal(b));
    let line = na.cross(nb).normalize_or_zero();
    let (of_a, of_b) = (interval(a, nb, b[0], line), interval(b, na, a[0], line));
    let edge = |t: [DVec3; 3]| {
        (0..3)
            .map(|k| t[k].distance(t[(k + 1) % 3]))
            .fold(0.0, f64::max)
    };
    let whole = edge(a).min(edge(b));
    match (of_a, of_b) {
        (Some(a), Some(b)) => (a.1.min(b.1) - a.0.max(b.0)).clamp(f64::MIN_POSITIVE, whole),
        _ => whole,
    }
}

/// The interval in which a triangle meets a plane, along `line` in that plane.
fn interval(t: [DVec3; 3], normal: DVec3, origin: DVec3, line: DVec3) -> Option<(f64, f64)> {
    if line == DVec3::ZERO {
        return None;
    }
    let height = t.map(|p| (p - origin).dot(normal));
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..3 {
        let (p, q, h, i) = (t[k], t[(k + 1) % 3], height[k], height[(k + 1) % 3]);
        if (h <= 0.0) != (i <= 0.0) {
            let at = (p + (q - p) * (h / (h - i)) - origin).dot(line);
            range = (range.0.min(at), range.1.max(at));
        }
    }
    (range.0 <= range.1).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two square grids of 4 × 4 cells, `gap` apart, and the number of vertices of the lower one.
    fn two_sheets(gap: f64) -> (Vec<DVec3>, Vec<[u32; 3]>, u32) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for z in [0.0, gap] {
            let first = positions.len() as u32;
            for i in 0..25 {
                positions.push(DVec3::new(f64::from(i % 5), f64::from(i / 5), z));
            }
            for (i, j) in (0..16).map(|c| (c % 4, c / 4)) {
                let a = first + j * 5 + i;
                triangles.push([a, a + 1, a + 6]);
                triangles.push([a, a + 6, a + 5]);
            }
        }
        (positions, triangles, 25)
    }

    #[test]
    fn a_vertex_pushed_through_another_sheet_comes_back() {
        let (mut positions, triangles, upper) = two_sheets(0.125);
        let spike = 12;
        positions[spike].z = 0.25;
        let mut pairs = crossing_pairs(&positions, &triangles, None, &Context::quiet()).unwrap();
        assert!(!pairs.is_empty());
        let before = positions.clone();
        let done = Untangler {
            positions: &mut positions,
            triangles: &triangles,
            is_free: &|v| v < upper,
            reach: 0.5,
            context: &Context::quiet(),
        }
        .untangle(&mut pairs);
        assert!(pairs.is_empty(), "{pairs:?}");
        assert!(
            crossing_pairs(&positions, &triangles, None, &Context::quiet())
                .unwrap()
                .is_empty()
        );
        assert!(done.farthest > 0.0 && done.farthest <= 0.5);
        for (v, (now, then)) in positions.iter().zip(&before).enumerate() {
            let moved = done.moved.binary_search(&(v as u32)).is_ok();
            assert_eq!(moved, now != then, "vertex {v}");
            assert!(!moved || (v as u32) < upper, "vertex {v} was not free");
            assert_eq!(now.as_vec3().as_dvec3(), *now, "vertex {v} is in `f32`");
        }
    }

    #[test]
    fn a_vertex_is_not_moved_onto_another() {
        let (mut positions, mut triangles, upper) = two_sheets(0.125);
        let spike = 12;
        positions[spike].z = 0.25;
        // Where the spike would go first, another part of the wood has a vertex.
        positions.push(DVec3::new(2.0, 2.0, 0.0));
        positions.extend([DVec3::new(2.0, 2.0, -1.0), DVec3::new(3.0, 2.0, -1.0)]);
        triangles.push([50, 51, 52]);
        let mut pairs = crossing_pairs(&positions, &triangles, None, &Context::quiet()).unwrap();
        Untangler {
            positions: &mut positions,
            triangles: &triangles,
            is_free: &|v| v < upper,
            reach: 0.5,
            context: &Context::quiet(),
        }
        .untangle(&mut pairs);
        assert!(pairs.is_empty(), "{pairs:?}");
        let mut keys: Vec<[u64; 3]> = positions.iter().map(|&p| position_key(p)).collect();
        keys.sort_unstable();
        assert!(keys.windows(2).all(|w| w[0] != w[1]));
    }

    #[test]
    fn crossings_of_what_is_not_free_are_left() {
        let (mut positions, triangles, _) = two_sheets(0.125);
        positions[12].z = 0.25;
        let mut pairs = crossing_pairs(&positions, &triangles, None, &Context::quiet()).unwrap();
        let (before, found) = (positions.clone(), pairs.clone());
        let done = Untangler {
            positions: &mut positions,
            triangles: &triangles,
            is_free: &|_| false,
            reach: 0.5,
            context: &Context::quiet(),
        }
        .untangle(&mut pairs);
        assert_eq!(
            (done, pairs, positions),
            (Untangled::default(), found, before)
        );
    }
}
