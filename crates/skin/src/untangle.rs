//! Taking out what crosses itself because files hold positions no finer than `f32`.
//!
//! Where a crack closes, its walls come nearer to each other than neighbouring numbers of `f32`, and rounded they cross.
//! There the crack ends instead: the shortest edges of triangles that cross are drawn together, the shortest of all
//! first, with longer ones allowed from round to round, until nothing crosses. Drawing an edge together leaves a closed
//! mesh closed and manifold where its ends have no neighbours in common but those beside it (Dey et al. 1999,
//! Topology Preserving Edge Contraction). Triangles whose corners have come to lie on one line, and edges
//! that have come to lie on each other, go the same way.

use crate::halve::crossing;
use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_geometry::intersect::{Contact, collinear, contact_tree, self_contacts};
use rustc_hash::FxHashSet;

/// Length of the longest edge drawn together in the first round, in parts of the mesh's extent: about the spacing of
/// `f32` there.
const FINEST: f64 = 1e-7;
/// Rounds; from one to the next edges may be twice as long.
const ROUNDS: i32 = 11;

/// What [`untangle`] did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Untangled {
    /// Pairs of triangles that crossed, and triangles without area or at an edge of more than two.
    pub crossed: usize,
    /// Edges drawn together.
    pub drawn: usize,
    /// Length of the longest of these, in the mesh's unit.
    pub longest: f64,
    /// What is left of these.
    pub left: usize,
}

/// Places of points as files hold them.
#[derive(Debug, Clone, Default)]
pub struct Places(FxHashSet<[u32; 3]>);

impl Places {
    /// The points of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        Places(mesh.positions.iter().map(|&p| key(p)).collect())
    }

    fn holds(&self, p: DVec3) -> bool {
        self.0.contains(&key(p))
    }
}

/// The bits of a position, with one zero.
fn key(p: DVec3) -> [u32; 3] {
    (p.as_vec3() + 0.0).to_array().map(f32::to_bits)
}

/// Draws short edges together until no triangle that has a corner at none of the places `known` crosses another such
/// triangle, has no area or shares an edge with more than one other. Positions should be those of files already
/// ([`crate::settle::settle`]).
pub fn untangle(mesh: &mut Mesh, known: &Places) -> Untangled {
    let (low, high) = mesh
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| {
            (l.min(p), h.max(p))
        });
    let extent = (high - low).length();
    let near: Vec<bool> = (0..mesh.triangles.len())
        .map(|t| !mesh.corners(t).iter().all(|&p| known.holds(p)))
        .collect();
    let mut net = Net::new(mesh);
    let mut pairs = crossing_of(mesh, &near);
    let faults = |net: &Net, t: u32| near[t as usize] && (net.is_flat(t) || net.is_pinched(t));
    let all = 0..near.len() as u32;
    pairs.extend(all.filter(|&t| faults(&net, t)).map(|t| [t, t]));
    let mut done = Untangled {
        crossed: pairs.len(),
        left: pairs.len(),
        ..Untangled::default()
    };
    if pairs.is_empty() || !extent.is_finite() {
        return done;
    }
    for round in 0..ROUNDS {
        let most = extent * FINEST * f64::from(1 << round);
        let changed = net.draw_edges(&pairs, most, &|_| false, &mut done);
        if changed.is_empty() {
            continue;
        }
        net.leave(&mut pairs, &changed);
        pairs.extend(crossing(&net.places, &net.triangles, Some(&changed)));
        pairs.retain(|p| {
            p.iter().all(|&t| near[t as usize]) && (p[0] != p[1] || faults(&net, p[0]))
        });
        pairs.extend(
            changed
                .iter()
                .filter(|&&t| faults(&net, t))
                .map(|&t| [t, t]),
        );
        pairs.sort_unstable();
        pairs.dedup();
        if pairs.is_empty() {
            break;
        }
    }
    net.write(mesh);
    done.left = pairs.len();
    done
}

/// Pairs of triangles that cross, of those that are `near`.
fn crossing_of(mesh: &Mesh, near: &[bool]) -> Vec<[u32; 2]> {
    let chosen: Vec<usize> = (0..near.len()).filter(|&t| near[t]).collect();
    let part = Mesh {
        positions: mesh.positions.clone(),
        triangles: chosen.iter().map(|&t| mesh.triangles[t]).collect(),
        ..Mesh::default()
    };
    let mut pairs = Vec::new();
    self_contacts(&part, &contact_tree(&part), |s, t, contact| {
        if contact == Contact::Crossing {
            pairs.push([chosen[s] as u32, chosen[t] as u32]);
        }
    });
    pairs.sort_unstable();
    pairs
}

/// The mesh by points: vertices at one position are one.
pub(crate) struct Net {
    /// Point of every vertex.
    points: Vec<u32>,
    /// The point that each has been drawn to, itself at first.
    drawn_to: Vec<u32>,
    places: Vec<DVec3>,
    /// Points of every triangle; all the same where it is gone.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Triangles about every point.
    around: Vec<Vec<u32>>,
}

impl Net {
    fn new(mesh: &Mesh) -> Self {
        let (points, count) = mesh.points();
        let mut places = vec![DVec3::ZERO; count];
        for (&point, &place) in points.iter().zip(&mesh.positions) {
            places[point as usize] = place;
        }
        let triangles = mesh.triangles.iter();
        let triangles = triangles.map(|t| t.map(|v| points[v as usize])).collect();
        let mut net = Net::of(places, triangles);
        net.points = points;
        net
    }

    /// The net of triangles whose corners are points at `places`.
    pub(crate) fn of(places: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let count = places.len();
        let mut net = Net {
            drawn_to: (0..count as u32).collect(),
            places,
            triangles,
            around: vec![Vec::new(); count],
            points: Vec::new(),
        };
        for (t, corners) in net.triangles.iter().enumerate() {
            corners
                .iter()
                .for_each(|&p| net.around[p as usize].push(t as u32));
        }
        net
    }

    /// Draws those edges of the triangles of `pairs` together that are no longer than `most`, the shortest first, towards
    /// points that `stay` where one of the ends does. Gives the triangles that changed.
    pub(crate) fn draw_edges(
        &mut self,
        pairs: &[[u32; 2]],
        most: f64,
        stay: &dyn Fn(u32) -> bool,
        done: &mut Untangled,
    ) -> Vec<u32> {
        let mut changed: Vec<u32> = Vec::new();
        for (length, a, b) in self.edges_of(pairs) {
            if length > most {
                break;
            }
            let (a, b) = (self.now(a), self.now(b));
            let (a, b) = if stay(b) { (b, a) } else { (a, b) };
            if stay(b) || !self.draw_together(a, b) {
                continue;
            }
            done.drawn += 1;
            done.longest = done.longest.max(length);
            changed.extend(&self.around[a as usize]);
        }
        changed.sort_unstable();
        changed.dedup();
        changed.retain(|&t| !self.is_gone(t as usize));
        changed
    }

    /// Takes the pairs out of which a triangle is gone or has `changed`.
    pub(crate) fn leave(&self, pairs: &mut Vec<[u32; 2]>, changed: &[u32]) {
        let same = |t: u32| {
            let gone = (t as usize) < self.triangles.len() && self.is_gone(t as usize);
            !gone && changed.binary_search(&t).is_err()
        };
        pairs.retain(|p| p.iter().all(|&t| same(t)));
    }

    /// Edges of the triangles of `pairs` with their lengths, the shortest first.
    fn edges_of(&self, pairs: &[[u32; 2]]) -> Vec<(f64, u32, u32)> {
        let mut edges: Vec<(f64, u32, u32)> = pairs
            .iter()
            .flatten()
            .flat_map(|&t| {
                let [a, b, c] = self.triangles[t as usize];
                [[a, b], [b, c], [c, a]]
            })
            .map(|[a, b]| {
                let length = self.places[a as usize].distance(self.places[b as usize]);
                (length, a.min(b), a.max(b))
            })
            .collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        edges.dedup();
        edges
    }

    /// The point that a point was drawn to, itself where it was not.
    fn now(&self, mut point: u32) -> u32 {
        while self.drawn_to[point as usize] != point {
            point = self.drawn_to[point as usize];
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

    /// Draws the second of two joined points to the first; false where that would not leave a manifold.
    fn draw_together(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.now(a), self.now(b));
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
        for gone in [s, t] {
            for p in self.triangles[gone as usize] {
                self.around[p as usize].retain(|&t| t != gone);
            }
            self.triangles[gone as usize] = [a; 3];
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
        self.drawn_to[b as usize] = a;
        true
    }

    /// Whether the corners of a triangle lie on one line.
    fn is_flat(&self, t: u32) -> bool {
        let [a, b, c] = self.triangles[t as usize].map(|p| self.places[p as usize]);
        collinear(a, b, c)
    }

    /// Whether an edge of a triangle is that of more than two.
    fn is_pinched(&self, t: u32) -> bool {
        let corners = self.triangles[t as usize];
        (0..3).any(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let around = self.around[a as usize].iter();
            let holds = |t: &&u32| self.triangles[**t as usize].contains(&b);
            !self.is_gone(t as usize) && around.filter(holds).count() > 2
        })
    }

    /// Whether a triangle was drawn together.
    pub(crate) fn is_gone(&self, t: usize) -> bool {
        self.triangles[t][0] == self.triangles[t][1]
    }

    /// Moves the mesh's vertices to their points' places, and takes out the triangles that are gone.
    fn write(&self, mesh: &mut Mesh) {
        for (position, &point) in mesh.positions.iter_mut().zip(&self.points) {
            let now = self.now(point);
            if now != point {
                *position = self.places[now as usize];
            }
        }
        let stays = |t: usize| !self.is_gone(t);
        if !mesh.materials.is_empty() {
            let mut t = 0;
            mesh.materials.retain(|_| {
                t += 1;
                t > self.triangles.len() || stays(t - 1)
            });
        }
        let mut t = 0;
        mesh.triangles.retain(|_| {
            t += 1;
            stays(t - 1)
        });
    }
}
