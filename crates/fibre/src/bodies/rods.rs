//! Rods that collide with each other once no bond joins them (model.md §3; Sutherland 2012 §6.4): edges as capsules of
//! the rods' diameter, found by a grid of cells, sorted.
//!
//! Pairs that a bond joins, or whose edges lie next to each other on one rod, are left out. Rods that lie closer at rest
//! than their diameters add up to (cells of wood are not round) touch at their distance at rest.

use super::contact::{Contact, Other};
use super::{SLOP, moved_squared};
use crate::bundle::Bundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;

/// Part of the distance at rest at which rods that were neighbours touch: whole wood must not rattle.
const AT_REST: f64 = 0.9;
/// How much wider than touching pairs are looked for, in the thickest rod's radii.
const MARGIN: f64 = 1.0;

/// Edges that may touch.
#[derive(Clone, Default)]
pub(super) struct RodPairs {
    pairs: Vec<Pair>,
    /// Cell and edge, sorted.
    cells: Vec<(u64, u32)>,
    /// Where vertices were when pairs were looked for, and the cells' corner and side then.
    position: Vectors,
    grid: (DVec3, f64),
    slack: f64,
    /// Per edge: bonds on it and on its vertices now; and the edges that have lost some since pairs were looked for.
    counts: Vec<u32>,
    changed: Vec<u32>,
    /// Per edge of the unbroken bundle: bonds on it and on its vertices.
    whole: Vec<u32>,
    /// Per edge: whether it has lost what kept it from others.
    loose: Vec<bool>,
}

/// Per edge: bonds on it and on its two vertices.
fn bond_counts(bundle: &Bundle) -> Vec<u32> {
    let incidence = &bundle.bonds.incidence;
    let own = |v: usize| incidence.own.get(v + 1).map_or(0, |e| e - incidence.own[v]);
    (0..bundle.vertices())
        .map(|j| own(j) + own(j + 1) + incidence.first[j + 1] - incidence.first[j])
        .collect()
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Pair {
    a: u32,
    b: u32,
    /// Distance at which they touch, m.
    reach: f64,
    /// Distance when pairs were looked for, m.
    apart: f64,
}

/// Bits of a cell's coordinate in its key.
const BITS: u32 = 21;

fn key(cell: [i64; 3]) -> u64 {
    let part = |c: i64| (c.clamp(0, (1 << BITS) - 1)) as u64;
    part(cell[2]) << (2 * BITS) | part(cell[1]) << BITS | part(cell[0])
}

impl RodPairs {
    /// Something has broken: forgets everything where numbers have changed. The first bundle is the unbroken one. Rods in whole wood are kept apart by
    /// their bonds, if not to each other then to those between them: only where bonds are missing do they collide.
    pub fn forget(&mut self, bundle: &Bundle) {
        let counts = bond_counts(bundle);
        // Where no rod has broken numbers are what they were, and pairs are new only at edges that have lost bonds.
        if self.slack > 0.0 && self.counts.len() == counts.len() {
            let edges = self.counts.iter().zip(&counts).enumerate();
            let lost = edges.filter(|(_, (was, now))| was != now);
            self.changed.extend(lost.map(|(j, _)| j as u32));
        } else {
            self.slack = 0.0;
            self.position = Vectors::zeros(bundle.vertices());
        }
        if self.whole.is_empty() {
            self.whole.clone_from(&counts);
        }
        let mut pieces = vec![0u32; bundle.parent.iter().max().map_or(0, |p| *p as usize + 1)];
        (bundle.parent.iter()).for_each(|p| pieces[*p as usize] += 1);
        self.loose = vec![true; bundle.vertices()];
        for rod in 0..bundle.rods() {
            let broken = pieces[bundle.parent[rod] as usize] > 1;
            for j in bundle.rod(rod) {
                let whole = self.whole.get(bundle.origin[j] as usize).copied();
                self.loose[j] = broken || counts[j] == 0 || whole != Some(counts[j]);
            }
        }
        self.counts = counts;
    }

    /// Adds the contacts of now, and with velocities those that are to be within a step (s).
    pub fn gather(
        &mut self,
        bundle: &Bundle,
        state: &State,
        radius: &[f64],
        ahead: Option<(&Vectors, f64)>,
        contacts: &mut Vec<Contact>,
    ) {
        let moved = moved_squared(&state.position, &self.position);
        if self.slack <= 0.0 || moved.is_nan() || 4.0 * moved > self.slack * self.slack {
            self.look(bundle, state, radius);
        } else if !self.changed.is_empty() {
            self.look_again(bundle, radius);
        }
        let nearer = 2.0 * moved_squared(&state.position, &self.position).sqrt();
        for pair in &self.pairs {
            let (a, b) = (pair.a as usize, pair.b as usize);
            if ahead.is_none() && pair.apart - nearer > pair.reach {
                continue;
            }
            let one = (state.position.get(a), state.edge(a));
            let two = (state.position.get(b), state.edge(b));
            let (s, t) = closest(one, two);
            let (p, q) = (one.0 + one.1 * s, two.0 + two.1 * t);
            let distance = p.distance(q);
            let margin = ahead.map_or(0.0, |(velocity, step)| {
                let at = |j: usize, t: f64| velocity.get(j).lerp(velocity.get(j + 1), t);
                step * at(a, s).distance(at(b, t))
            });
            if distance < pair.reach + margin
                && let Some(normal) = (p - q).try_normalize()
            {
                contacts.push(Contact {
                    edge: pair.a,
                    t: s,
                    other: Other::Edge(pair.b, t),
                    normal,
                    place: 0.5 * (p + q),
                    depth: pair.reach - distance,
                    slop: SLOP * radius[a],
                    share: pair.reach,
                });
            }
        }
    }

    /// Looks for pairs anew.
    fn look(&mut self, bundle: &Bundle, state: &State, radius: &[f64]) {
        let edges = || (0..bundle.vertices()).filter(|&j| radius[j] > 0.0);
        let thickest = radius.iter().copied().fold(0.0, f64::max);
        self.slack = MARGIN * thickest;
        let longest = edges().map(|j| state.edge(j).length()).fold(0.0, f64::max);
        let side = longest + 2.0 * thickest + self.slack;
        let low = state
            .position
            .iter()
            .fold(DVec3::INFINITY, |low, p| low.min(p));
        self.position.clone_from(&state.position);
        self.grid = (low, side);
        self.pairs.clear();
        self.changed.clear();
        if !(side.is_finite() && low.is_finite()) {
            return;
        }
        let mut cells = std::mem::take(&mut self.cells);
        cells.clear();
        cells.extend(edges().map(|j| (key(self.cell(j)), j as u32)));
        cells.sort_unstable();
        self.cells = cells;
        let mut pairs = std::mem::take(&mut self.pairs);
        for a in edges() {
            self.add_near(bundle, radius, a, &mut pairs, |b| b > a);
        }
        self.keep(pairs);
    }

    /// Looks for the pairs of edges that have lost bonds, from where all were when pairs were last looked for.
    fn look_again(&mut self, bundle: &Bundle, radius: &[f64]) {
        let mut changed = vec![false; bundle.vertices()];
        let mut list = std::mem::take(&mut self.changed);
        list.sort_unstable();
        list.dedup();
        list.iter().for_each(|&j| changed[j as usize] = true);
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.retain(|p| !(changed[p.a as usize] || changed[p.b as usize]));
        for &j in list.iter().filter(|j| radius[**j as usize] > 0.0) {
            let a = j as usize;
            self.add_near(bundle, radius, a, &mut pairs, |b| {
                b > a || b < a && !changed[b]
            });
        }
        self.keep(pairs);
    }

    fn keep(&mut self, mut pairs: Vec<Pair>) {
        // The order of contacts must not depend on where cells begin.
        pairs.sort_unstable_by_key(|p| (p.a, p.b));
        self.pairs = pairs;
    }

    fn cell(&self, edge: usize) -> [i64; 3] {
        let (low, side) = self.grid;
        let (start, along) = edge_at(&self.position, edge);
        let middle = start + 0.5 * along;
        ((middle - low) / side).to_array().map(|c| c as i64 + 1)
    }

    /// Adds the pairs of an edge with others that are `wanted`.
    fn add_near(
        &self,
        bundle: &Bundle,
        radius: &[f64],
        a: usize,
        pairs: &mut Vec<Pair>,
        wanted: impl Fn(usize) -> bool,
    ) {
        let [x, y, z] = self.cell(a);
        for dz in -1..=1 {
            for dy in -1..=1 {
                let from = key([x - 1, y + dy, z + dz]);
                let to = key([x + 1, y + dy, z + dz]);
                let start = self.cells.partition_point(|c| c.0 < from);
                for &(k, b) in &self.cells[start..] {
                    if k > to {
                        break;
                    }
                    let b = b as usize;
                    if wanted(b) && (self.loose[a] || self.loose[b]) {
                        let (a, b) = (a.min(b), a.max(b));
                        let pair = may_touch(bundle, &self.position, radius, a, b, self.slack);
                        pairs.extend(pair);
                    }
                }
            }
        }
    }
}

/// Start and vector of an edge.
fn edge_at(position: &Vectors, edge: usize) -> (DVec3, DVec3) {
    let start = position.get(edge);
    (start, position.get(edge + 1) - start)
}

fn may_touch(
    bundle: &Bundle,
    position: &Vectors,
    radius: &[f64],
    a: usize,
    b: usize,
    slack: f64,
) -> Option<Pair> {
    let touch = radius[a] + radius[b];
    let (one, two) = (edge_at(position, a), edge_at(position, b));
    if passes_by(one, two, touch + slack) {
        return None;
    }
    let apart = distance(one, two);
    if apart > touch + slack || next_on_rod(bundle, a, b, touch) || bonded(bundle, a, b) {
        return None;
    }
    let rest = distance(edge_at(&bundle.rest, a), edge_at(&bundle.rest, b));
    (rest > 0.0).then(|| Pair {
        a: a as u32,
        b: b as u32,
        reach: touch.min(AT_REST * rest),
        apart,
    })
}

/// Whether two edges lie on what was one rod, so close that bending alone brings them together.
fn next_on_rod(bundle: &Bundle, a: usize, b: usize, touch: f64) -> bool {
    let parent = |j: usize| bundle.parent[bundle.rod_of(j)];
    if parent(a) != parent(b) {
        return false;
    }
    let between = bundle.origin[a].abs_diff(bundle.origin[b]);
    f64::from(between.saturating_sub(1)) * bundle.rest_length[a].min(bundle.rest_length[b])
        < 2.0 * touch
}

/// Whether a bond joins two edges or those next to them.
fn bonded(bundle: &Bundle, a: usize, b: usize) -> bool {
    let joins = |from: usize, to: usize| {
        (from..=from + 1).any(|v| {
            let own = &bundle.bonds.incidence.own;
            (own[v] as usize..own[v + 1] as usize)
                .any(|i| bundle.bonds.edge[i].abs_diff(to as u32) <= 1)
        })
    };
    joins(a, b) || joins(b, a)
}

/// Whether two edges are surely farther apart than `reach`: seen along the first, the second passes it by. Most pairs of a
/// stem are found out by that, as rods lie side by side.
fn passes_by((p, d): (DVec3, DVec3), (q, e): (DVec3, DVec3), reach: f64) -> bool {
    let Some(along) = d.try_normalize() else {
        return false;
    };
    let middle = (q + 0.5 * e) - p;
    let side = middle.reject_from_normalized(along).length();
    side > reach + 0.5 * e.reject_from_normalized(along).length()
}

fn distance(one: (DVec3, DVec3), two: (DVec3, DVec3)) -> f64 {
    let (s, t) = closest(one, two);
    (one.0 + one.1 * s).distance(two.0 + two.1 * t)
}

/// Places on two segments, each a start and a vector, that are closest to each other (Ericson, *Real-Time Collision
/// Detection*, 5.1.9). Parallel ones meet in the middle of where they lie side by side.
fn closest((p, d): (DVec3, DVec3), (q, e): (DVec3, DVec3)) -> (f64, f64) {
    let r = p - q;
    let (dd, ee, de, dr, er) = (d.dot(d), e.dot(e), d.dot(e), d.dot(r), e.dot(r));
    if dd <= 0.0 || ee <= 0.0 {
        return (0.0, 0.0);
    }
    let determinant = dd * ee - de * de;
    let s = if determinant > 1e-14 * dd * ee {
        ((de * er - dr * ee) / determinant).clamp(0.0, 1.0)
    } else {
        let (a, b) = (-dr / dd, (de - dr) / dd);
        (a.clamp(0.0, 1.0) + b.clamp(0.0, 1.0)) / 2.0
    };
    let t = (de * s + er) / ee;
    if (0.0..=1.0).contains(&t) {
        return (s, t);
    }
    let t = t.clamp(0.0, 1.0);
    (((de * t - dr) / dd).clamp(0.0, 1.0), t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bonds::Bond;
    use crate::{Rod, RodMaterial};
    use greenstick_wood::noise;

    #[test]
    fn pairs_looked_for_where_bonds_broke_are_those_of_looking_everywhere() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let rods: Vec<Rod> = (0..16)
            .map(|r| {
                let corner = DVec3::new((r % 4) as f64, (r / 4) as f64, 0.0) * 1.1e-3;
                let at = |i: usize| corner + DVec3::Z * 4e-3 * i as f64;
                Rod::new((0..9).map(at).collect(), material)
            })
            .collect();
        let mut bundle = Bundle::new(&rods, false).unwrap();
        let bond = |v: u32, r: u32| Bond {
            vertex: v,
            edge: 9 * r + v % 8,
            t: 0.5,
            distance: 1.1e-3,
            rest_cosine: 0.0,
            transverse: 1.0,
            shear: 1.0,
            area: 1e-6,
            tension_strength: 1.0,
            shear_strength: 1.0,
            fracture_energy: 1.0,
        };
        let near = |v: u32, r: u32| v / 9 != r && (v / 9).abs_diff(r) <= 5;
        let all = (0..bundle.vertices() as u32).flat_map(|v| {
            (0..16)
                .filter(move |&r| near(v, r))
                .map(move |r| bond(v, r))
        });
        let mut bonds: Vec<Bond> = all.collect();
        bundle.set_bonds(bonds.clone()).unwrap();
        let radius: Vec<f64> = (0..bundle.vertices())
            .map(|j| if bundle.is_edge(j) { 6e-4 } else { 0.0 })
            .collect();
        let mut state = State::at_rest(&bundle);
        let mut pairs = RodPairs::default();
        pairs.forget(&bundle);
        pairs.gather(&bundle, &state, &radius, None, &mut Vec::new());
        assert!(pairs.pairs.is_empty());
        for round in 0..6 {
            let chance = |i: usize| noise::unit(8, i as i64, round, 0);
            let mut i = 0;
            bonds.retain(|_| {
                i += 1;
                chance(i) > 0.2
            });
            bundle.set_bonds(bonds.clone()).unwrap();
            for v in 0..bundle.vertices() {
                // Columns of rods come nearer to each other, two by two.
                let way = if v / 9 % 2 == 0 { 2e-5 } else { -2e-5 };
                state.position.add(v, DVec3::X * (way + 1e-5 * chance(v)));
            }
            pairs.forget(&bundle);
            let mut found = Vec::new();
            pairs.gather(&bundle, &state, &radius, None, &mut found);
            assert!(pairs.changed.is_empty() && pairs.position != state.position);
            // The same from the same places, all at once; and the same contacts from where things are now.
            let mut whole = pairs.clone();
            let old = State {
                position: pairs.position.clone(),
                ..state.clone()
            };
            whole.look(&bundle, &old, &radius);
            assert!(whole.pairs == pairs.pairs && !pairs.pairs.is_empty());
            whole.look(&bundle, &state, &radius);
            let mut expected = Vec::new();
            whole.gather(&bundle, &state, &radius, None, &mut expected);
            let places = |of: &[Contact]| -> Vec<(u32, DVec3)> {
                of.iter().map(|c| (c.edge, c.place)).collect()
            };
            assert!(round < 5 || found.len() > 10);
            assert_eq!(places(&found), places(&expected));
        }
    }

    #[test]
    fn the_closest_places_are_those_of_a_fine_search() {
        let vector = |i: i64, k: i64| {
            DVec3::from_array([0, 1, 2].map(|c| 2.0 * noise::unit(5, i, k, c) - 1.0))
        };
        for i in 0..60 {
            let one = (vector(i, 0), vector(i, 1));
            // A third are parallel or nearly so.
            let e = if i % 3 == 0 {
                one.1 * 0.7 + vector(i, 3) * 1e-9 * f64::from((i % 2) as u8)
            } else {
                vector(i, 3)
            };
            let two = (vector(i, 2), e);
            let found = distance(one, two);
            let mut least = f64::INFINITY;
            for a in 0..=400 {
                for b in 0..=400 {
                    let p = one.0 + one.1 * (f64::from(a) / 400.0);
                    let q = two.0 + two.1 * (f64::from(b) / 400.0);
                    least = least.min(p.distance(q));
                }
            }
            assert!(
                found <= least + 1e-8 && least < found + 0.01,
                "{i}: {found} {least}"
            );
        }
    }
}
