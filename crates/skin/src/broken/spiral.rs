//! Removing the self-intersections of a broken face in spiral grain.
//!
//! The map from spiral grain to the world is curved between levels, so that what was cut apart in grain space may cross
//! in the world, by as little as straight triangles are off curved ones. Triangles of the face that cross are bisected
//! and their new corners placed by the curved map. What still crosses is finer than the skin is off its own curve; there
//! short edges of the face are collapsed. The face is changed before the pieces are made of it, so both have the same.

use crate::source::Source;
use glam::{DAffine3, DVec3};
use greenstick_fracture::cut::{Cut, Host, Side, Skin};
use greenstick_fracture::surface::NONE;
use greenstick_geometry::Aabb;
use greenstick_geometry::repair::{
    Collapsed, EdgeBisector, EdgeCollapser, crossing_pairs, crossing_pairs_within,
};
use greenstick_wood::stem::LayeredGrain;

/// Rounds of bisection: from one to the next, triangles are half as long.
const BISECTIONS: u32 = 3;
/// Rounds of collapsing edges; from one to the next, edges may be twice as long.
const COLLAPSES: i32 = 5;
/// Longest edge collapsed in the first round, as part of the face's extent.
const FIRST_LENGTH: f64 = 8e-5;

/// What was done to a broken face in spiral grain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpiralRepair {
    /// Pairs of triangles that crossed.
    pub crossed: usize,
    /// Edges bisected.
    pub bisected: usize,
    /// Edges collapsed.
    pub collapsed: usize,
    /// Length of the longest of these, in the mesh's unit.
    pub longest: f64,
    /// Pairs that still cross.
    pub remaining: usize,
}

/// A cut in the node's coordinates: its face first, then the skin about it.
struct Face<'a> {
    cut: &'a mut Cut,
    /// Position and true grain coordinates of every vertex.
    positions: Vec<DVec3>,
    grain: Vec<DVec3>,
    skin: Vec<[u32; 3]>,
}

/// Removes the self-intersections of the face of `cut`. `skin` is the sorted skin that was cut; `layers` are those of the
/// stem, to whose world `transform` leads.
pub fn repair_spiral_face(
    source: &Source,
    cut: &mut Cut,
    skin: &Skin,
    layers: &LayeredGrain,
    transform: &DAffine3,
) -> SpiralRepair {
    let to_grain = |p| layers.to_grain(transform.transform_point3(p));
    let mut face = Face::new(source, cut, skin, &to_grain);
    let mut done = SpiralRepair::default();
    let mut pairs = face.crossing(layers);
    done.crossed = pairs.len();
    if !pairs.is_empty() {
        pairs = face.bisect(source, pairs, &mut done);
    }
    if !pairs.is_empty() {
        pairs = face.collapse(pairs, &mut done);
    }
    done.remaining = pairs.len();
    done
}

impl<'a> Face<'a> {
    fn new(
        source: &Source,
        cut: &'a mut Cut,
        skin: &Skin,
        to_grain: &dyn Fn(DVec3) -> DVec3,
    ) -> Self {
        let point = |p: u32| source.mesh.positions[source.vertices[p as usize] as usize];
        let mut positions: Vec<DVec3> = (0..cut.points as u32).map(point).collect();
        positions.extend(cut.vertices.iter().map(|v| match v.host {
            Host::Edge { ends: [a, b], t } => point(a).lerp(point(b), t),
            Host::Face {
                triangle,
                weights: w,
            } => {
                let [a, b, c] = source.mesh.corners(triangle as usize);
                a * w[0] + b * w[1] + c * w[2]
            }
            Host::Point(p) => point(p),
            Host::Inside => source.chart.to_world(v.grain),
        }));
        // The skin is straight in the world, so that the grain coordinates it was cut with are not quite its own.
        let mut grain = source.grain[..cut.points].to_vec();
        grain.extend(positions[cut.points..].iter().map(|&p| to_grain(p)));
        positions.extend(cut.inside.iter().map(|&g| source.chart.to_world(g)));
        grain.extend(cut.inside.iter().copied());
        let whole = cut.sides.between.iter().enumerate();
        let whole = whole.filter(|(_, side)| matches!(side, Side::Lower | Side::Upper));
        let whole = whole.map(|(i, _)| {
            let t = skin.order[cut.sides.below + i] as usize;
            source.mesh.triangles[t].map(|v| source.points[v as usize])
        });
        let skin = (cut.skin.iter().map(|s| s.corners)).chain(whole).collect();
        Face {
            cut,
            positions,
            grain,
            skin,
        }
    }

    fn with_skin(&self, face: &[[u32; 3]]) -> Vec<[u32; 3]> {
        face.iter().chain(&self.skin).copied().collect()
    }

    /// The pairs of triangles that cross, at least one of which is of the face.
    ///
    /// In the world the long triangles along the grain lean in all directions, and so many of their boxes overlap; in
    /// grain space they stand upright.
    fn crossing(&self, layers: &LayeredGrain) -> Vec<[u32; 2]> {
        let (all, count) = (self.with_skin(&self.cut.cap), self.cut.cap.len());
        let grain = |t: &[u32; 3]| t.map(|v| self.grain[v as usize]);
        // Skin off the limb has no grain.
        let has_grain = |&n: &u32| grain(&all[n as usize]).iter().all(|g| !g.is_nan());
        let (limb, off_limb): (Vec<u32>, Vec<u32>) = (0..all.len() as u32).partition(has_grain);
        let triangles: Vec<[u32; 3]> = limb.iter().map(|&n| all[n as usize]).collect();
        let bounds = |t: &[u32; 3]| {
            let (low, high) = layers.triangle_bounds(grain(t));
            Aabb { low, high }
        };
        let boxes: Vec<Aabb> = triangles.iter().map(bounds).collect();
        let mut pairs = crossing_pairs_within(&self.positions, &triangles, count, &boxes);
        if !off_limb.is_empty() {
            for n in pairs.iter_mut().flatten() {
                *n = limb[*n as usize];
            }
            let others = crossing_pairs(&self.positions, &all, Some(&off_limb));
            pairs.extend(self.of_face(others, count));
            pairs.sort_unstable();
        }
        pairs
    }

    /// Those pairs one of which at least is among the first `count` triangles, the face.
    fn of_face(&self, mut pairs: Vec<[u32; 2]>, count: usize) -> Vec<[u32; 2]> {
        pairs.retain(|p| (p[0] as usize) < count);
        pairs
    }

    /// Bisects what crosses; returns the pairs that remain.
    fn bisect(
        &mut self,
        source: &Source,
        mut pairs: Vec<[u32; 2]>,
        done: &mut SpiralRepair,
    ) -> Vec<[u32; 2]> {
        let ids = (0..self.positions.len() as u32).collect();
        let mut bisector = EdgeBisector::new(
            std::mem::take(&mut self.cut.cap),
            ids,
            self.positions.len() as u32,
        );
        for _ in 0..BISECTIONS {
            let before = bisector.triangles.len();
            let mut changed = vec![false; before];
            let mut list = Vec::new();
            for t in pairs.iter().flatten().copied() {
                if t as usize >= before || changed[t as usize] {
                    continue;
                }
                let first = self.positions.len() as u32;
                let mut made = Vec::new();
                let (positions, grain) = (&self.positions, &self.grain);
                let length = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
                let four = bisector.bisect(t, &length, &mut |a, b| {
                    made.push((grain[a as usize] + grain[b as usize]) / 2.0);
                    first + made.len() as u32 - 1
                });
                for g in made {
                    self.positions.push(source.chart.to_world(g));
                    self.grain.push(g);
                    self.cut.inside.push(g);
                    self.cut.nodes.push(NONE);
                }
                if let Some(four) = four {
                    done.bisected += 1;
                    changed.resize(bisector.triangles.len(), true);
                    for t in four {
                        changed[t as usize] = true;
                    }
                    list.extend(four);
                }
            }
            if list.is_empty() {
                break;
            }
            list.sort_unstable();
            list.dedup();
            let count = bisector.triangles.len();
            let all = self.with_skin(&bisector.triangles);
            // Numbers of the skin's triangles move up.
            let shift = (count - before) as u32;
            let unchanged = pairs
                .iter()
                .map(|p| p.map(|t| if t as usize >= before { t + shift } else { t }));
            let kept = unchanged.filter(|p| p.iter().all(|&t| list.binary_search(&t).is_err()));
            let mut now: Vec<[u32; 2]> = kept.collect();
            now.extend(crossing_pairs(&self.positions, &all, Some(&list)));
            now.sort_unstable();
            now.dedup();
            pairs = self.of_face(now, count);
            if pairs.is_empty() {
                break;
            }
        }
        self.take(&bisector, &mut pairs);
        pairs
    }

    /// Takes over the triangles of `bisector`, in the order of those they are parts of.
    fn take(&mut self, bisector: &EdgeBisector, pairs: &mut [[u32; 2]]) {
        let count = bisector.triangles.len();
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.sort_by_key(|&t| (bisector.origins[t as usize], t));
        let mut place = vec![0; count];
        for (i, &t) in order.iter().enumerate() {
            place[t as usize] = i as u32;
        }
        for t in pairs
            .iter_mut()
            .flatten()
            .filter(|t| (**t as usize) < count)
        {
            *t = place[*t as usize];
        }
        let cut = &mut *self.cut;
        cut.cap = order
            .iter()
            .map(|&t| bisector.triangles[t as usize])
            .collect();
        cut.faces = (order.iter())
            .map(|&t| cut.faces[bisector.origins[t as usize] as usize])
            .collect();
        for wall in &mut cut.walls {
            let first = order.partition_point(|&t| bisector.origins[t as usize] < *wall);
            *wall = first as u32;
        }
    }

    /// Collapses short edges of the face until nothing crosses; returns the pairs that remain.
    fn collapse(&mut self, mut pairs: Vec<[u32; 2]>, done: &mut SpiralRepair) -> Vec<[u32; 2]> {
        let rim = (self.cut.points + self.cut.vertices.len()) as u32;
        let used = || {
            self.cut
                .cap
                .iter()
                .flatten()
                .map(|&v| self.positions[v as usize])
        };
        let low = used().fold(DVec3::INFINITY, DVec3::min);
        let extent = (used().fold(DVec3::NEG_INFINITY, DVec3::max) - low).length();
        let count = self.cut.cap.len();
        let cap = std::mem::take(&mut self.cut.cap);
        let mut collapser = EdgeCollapser::new(self.positions.clone(), cap);
        let mut collapsed = Collapsed::default();
        for round in 0..COLLAPSES {
            let longest = extent * FIRST_LENGTH * f64::from(1 << round);
            let of_face: Vec<[u32; 2]> = (pairs.iter())
                .map(|p| {
                    if (p[1] as usize) < count {
                        *p
                    } else {
                        [p[0]; 2]
                    }
                })
                .collect();
            // What lies on the skin stays there.
            let changed = collapser.collapse_edges(&of_face, longest, &|v| v < rim, &mut collapsed);
            if changed.is_empty() {
                continue;
            }
            let mut now = pairs.clone();
            collapser.retain_unchanged(&mut now, &changed);
            now.extend(crossing_pairs(
                &self.positions,
                &self.with_skin(&collapser.triangles),
                Some(&changed),
            ));
            now.sort_unstable();
            now.dedup();
            pairs = self.of_face(now, count);
            if pairs.is_empty() {
                break;
            }
        }
        (done.collapsed, done.longest) = (collapsed.edges, collapsed.longest);
        let kept: Vec<bool> = (0..count).map(|t| !collapser.is_collapsed(t)).collect();
        let mut before = vec![0u32];
        for k in &kept {
            before.push(before[before.len() - 1] + u32::from(*k));
        }
        let cut = &mut *self.cut;
        cut.walls.iter_mut().for_each(|w| *w = before[*w as usize]);
        let mut keep = kept.iter();
        cut.faces.retain(|_| *keep.next().unwrap_or(&true));
        cut.cap = collapser.triangles;
        let mut keep = kept.iter();
        cut.cap.retain(|_| *keep.next().unwrap_or(&true));
        pairs
    }
}
