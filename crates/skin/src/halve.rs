//! Halving the triangles that cross once a curved map has carried their corners.
//!
//! A map that is one to one takes a surface that does not cross itself to another; straight triangles between the
//! mapped corners may cross all the same. The smaller a triangle, the less it is off the curved one it stands for, so
//! the longest edges of triangles that cross are halved, in both triangles beside each (Rivara 1984, Algorithms for
//! Refining Triangular Grids), until nothing crosses.

use glam::DVec3;
use greenstick_geometry::intersect::{
    Contact, TriangleTree, contact_tree, contacts_between, self_contacts,
};
use greenstick_geometry::{Bvh, Mesh};
use rustc_hash::FxHashMap;

/// "No triangle".
const NONE: u32 = u32::MAX;
/// An edge of more than two triangles.
const MANY: u32 = u32::MAX - 1;

/// Triangles whose edges can be halved.
pub struct Halver {
    /// Vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the one of the first it is a part of.
    pub origins: Vec<u32>,
    /// Point of each vertex: vertices at one position have one.
    points: Vec<u32>,
    count: u32,
    /// Triangles on both sides of every edge, named by its points.
    edges: FxHashMap<[u32; 2], [u32; 2]>,
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Halver {
    /// Makes ready `triangles` whose vertices lie at `points`, which are fewer than `count`.
    pub fn new(triangles: Vec<[u32; 3]>, points: Vec<u32>, count: u32) -> Self {
        let mut made = Halver {
            origins: (0..triangles.len() as u32).collect(),
            edges: FxHashMap::default(),
            triangles: Vec::new(),
            points,
            count,
        };
        made.edges.reserve(triangles.len() * 3 / 2);
        for (t, &corners) in triangles.iter().enumerate() {
            let at = corners.map(|v| made.points[v as usize]);
            for k in 0..3 {
                let sides = made
                    .edges
                    .entry(key(at[k], at[(k + 1) % 3]))
                    .or_insert([NONE; 2]);
                match sides {
                    [first, _] if *first == NONE => *first = t as u32,
                    [_, second] if *second == NONE => *second = t as u32,
                    _ => *sides = [MANY; 2],
                }
            }
        }
        made.triangles = triangles;
        made
    }

    fn replace(&mut self, a: u32, b: u32, old: u32, new: u32) {
        if let Some(sides) = self.edges.get_mut(&key(a, b)) {
            for side in sides.iter_mut().filter(|s| **s == old) {
                *side = new;
            }
        }
    }

    /// Halves the longest edge of triangle `t` that two triangles share. `length` is that of an edge between vertices;
    /// `make` makes the vertex in the middle of two. Gives the four triangles that come of it.
    pub fn halve(
        &mut self,
        t: u32,
        length: &dyn Fn(u32, u32) -> f64,
        make: &mut dyn FnMut(u32, u32) -> u32,
    ) -> Option<[u32; 4]> {
        let corners = self.triangles[t as usize];
        let mut best: Option<(f64, usize, u32)> = None;
        for k in 0..3 {
            let (u, v) = (corners[k], corners[(k + 1) % 3]);
            let ends = key(self.points[u as usize], self.points[v as usize]);
            let sides = self.edges.get(&ends).copied().unwrap_or([MANY; 2]);
            if sides[1] == NONE || sides[0] == MANY || sides[0] == sides[1] {
                continue;
            }
            let other = if sides[0] == t { sides[1] } else { sides[0] };
            let l = length(u, v);
            if best.is_none_or(|b| l > b.0) {
                best = Some((l, k, other));
            }
        }
        let (_, k, other) = best?;
        let (u, v, w) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let (p, q) = (self.points[u as usize], self.points[v as usize]);
        let beside = self.triangles[other as usize];
        let j = (0..3).find(|&j| {
            let ends = [beside[j], beside[(j + 1) % 3]].map(|x| self.points[x as usize]);
            ends == [q, p]
        })?;
        let (x, y, z) = (beside[j], beside[(j + 1) % 3], beside[(j + 2) % 3]);
        let middle = make(u, v);
        let point = self.count;
        self.count += 1;
        self.points.push(point);
        let middle_beside = if [x, y] == [v, u] {
            middle
        } else {
            self.points.push(point);
            make(y, x)
        };
        let (first, second) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
        self.triangles[t as usize] = [u, middle, w];
        self.triangles.push([middle, v, w]);
        self.triangles[other as usize] = [x, middle_beside, z];
        self.triangles.push([middle_beside, y, z]);
        let (of_t, of_other) = (self.origins[t as usize], self.origins[other as usize]);
        self.origins.extend([of_t, of_other]);
        let (r, s) = (self.points[w as usize], self.points[z as usize]);
        self.replace(q, r, t, first);
        self.replace(p, s, other, second);
        self.edges.remove(&key(p, q));
        self.edges.insert(key(p, point), [t, second]);
        self.edges.insert(key(point, q), [first, other]);
        self.edges.insert(key(point, r), [t, first]);
        self.edges.insert(key(point, s), [other, second]);
        Some([t, first, other, second])
    }
}

/// Pairs of triangles that cross of which one at least is among `changed` (`None` for all triangles), ascending.
pub fn crossing(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    changed: Option<&[u32]>,
) -> Vec<[u32; 2]> {
    let part = |triangles: Vec<[u32; 3]>| Mesh {
        positions: positions.to_vec(),
        triangles,
        ..Mesh::default()
    };
    let all = part(triangles.to_vec());
    let mut pairs = Vec::new();
    let mut found = |s: u32, t: u32, contact: Contact| {
        if contact == Contact::Crossing && s != t {
            pairs.push([s.min(t), s.max(t)]);
        }
    };
    match changed {
        None => self_contacts(&all, &contact_tree(&all), |s, t, c| {
            found(s as u32, t as u32, c);
        }),
        Some(changed) => {
            let some = part(changed.iter().map(|&t| triangles[t as usize]).collect());
            let trees = [Bvh::from_mesh(&some), Bvh::from_mesh(&all)];
            contacts_between(
                TriangleTree {
                    mesh: &some,
                    tree: &trees[0],
                },
                TriangleTree {
                    mesh: &all,
                    tree: &trees[1],
                },
                |s, t, c| {
                    found(changed[s], t as u32, c);
                },
            );
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
