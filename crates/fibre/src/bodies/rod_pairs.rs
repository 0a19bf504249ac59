//! Contacts between rods that no bond connects (Sutherland 2012 §6.4): edges as capsules of the rods' diameter, found in a
//! sorted grid of cells.
//!
//! Pairs that a bond connects, or whose edges are neighbours on one rod, are left out. Rods that lie closer at rest than the
//! sum of their radii (cells of wood are not round) touch at their distance at rest.

use super::contact_point::{ContactPoint, SLOP, Side, StepMotion};
use super::displacement::moved_squared;
use super::segments::{Bounds, PackedBounds, Segment, are_far_apart, closest_parameters, distance};
use crate::failure::crumbs::is_crumb;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Fraction of the distance at rest at which rods that were neighbours touch: unbroken wood must not rattle.
const REST_DISTANCE_FRACTION: f64 = 0.9;
/// Margin of the search for pairs, in the thickest rod's radii.
const SEARCH_MARGIN: f64 = 1.0;
/// Where something has moved by half the margin, all that has moved by this fraction of it is searched again.
const MOVED_FRACTION: f64 = 0.25;
/// Edges whose pairs are searched between two checks for cancellation.
const EDGES_PER_CHECK: usize = 1 << 12;

/// Edges that may touch.
#[derive(Clone, Default)]
pub(super) struct RodPairs {
    pairs: Vec<Pair>,
    /// Key of the cell and edge, sorted.
    cells: Vec<(u64, u32)>,
    /// Per edge: the box about all that it may touch before the next search.
    boxes: Vec<Bounds>,
    /// The same in the order of `cells`.
    packed: PackedBounds,
    /// Positions at the last search, and the grid then.
    position: Vectors,
    grid: Grid,
    /// Per edge: the way of its vertices since the last search, and in a step, m.
    approach: Vec<f64>,
    /// How far things may move until a new search, m; 0 for at once.
    margin: f64,
    /// Per edge: present number of bonds on it and on its vertices; and the edges that have lost some since the last search.
    bond_counts: Vec<u32>,
    changed: Vec<u32>,
    /// Per edge of the unbroken bundle: bonds on it and on its vertices.
    unbroken_counts: Vec<u32>,
    /// Per edge: whether it has lost bonds, which kept it apart from others.
    loose: Vec<bool>,
    /// Per edge: whether it is of a crumb that nothing holds. It would be wedged between others, whose equilibrium it bears nothing
    /// of and does not let find.
    crumb: Vec<bool>,
}

/// A cubic grid.
#[derive(Debug, Clone, Copy, Default)]
struct Grid {
    /// Lowest corner, m.
    corner: DVec3,
    /// Side of a cell, m.
    side: f64,
}

/// Returns for each edge the number of bonds on it and on its two vertices.
fn count_bonds(bundle: &RodBundle) -> Vec<u32> {
    let incidence = &bundle.bonds.incidence;
    let own = |v: usize| {
        incidence
            .vertex_offsets
            .get(v + 1)
            .map_or(0, |e| e - incidence.vertex_offsets[v])
    };
    (0..bundle.vertices())
        .map(|j| own(j) + own(j + 1) + incidence.edge_offsets[j + 1] - incidence.edge_offsets[j])
        .collect()
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Pair {
    a: u32,
    b: u32,
    /// Distance at which they touch, m.
    reach: f64,
    /// Distance at the last search, m.
    distance: f64,
}

/// Bits of a cell's coordinate in its key.
const BITS: u32 = 21;

fn key(cell: [i64; 3]) -> u64 {
    let part = |c: i64| (c.clamp(0, (1 << BITS) - 1)) as u64;
    part(cell[2]) << (2 * BITS) | part(cell[1]) << BITS | part(cell[0])
}

impl RodPairs {
    /// Follows a change of the bundle, of which the first is the unbroken one. Bonds keep rods in unbroken wood apart, directly or
    /// through the rods between them; rods collide only where bonds are missing.
    pub fn bundle_changed(&mut self, bundle: &RodBundle) {
        let counts = count_bonds(bundle);
        // Where no rod has broken the numbers are the same, and new pairs arise only at edges that have lost bonds.
        if self.margin > 0.0 && self.bond_counts.len() == counts.len() {
            let edges = self.bond_counts.iter().zip(&counts).enumerate();
            let lost = edges.filter(|(_, (was, now))| was != now);
            self.changed.extend(lost.map(|(j, _)| j as u32));
        } else {
            self.margin = 0.0;
            self.position = Vectors::zeros(bundle.vertices());
        }
        if self.unbroken_counts.is_empty() {
            self.unbroken_counts.clone_from(&counts);
        }
        let mut pieces = vec![0u32; bundle.parent.iter().max().map_or(0, |p| *p as usize + 1)];
        (bundle.parent.iter()).for_each(|p| pieces[*p as usize] += 1);
        let was_loose = std::mem::replace(&mut self.loose, vec![true; bundle.vertices()]);
        self.crumb.clear();
        self.crumb.resize(bundle.vertices(), false);
        for rod in 0..bundle.rods() {
            let broken = pieces[bundle.parent[rod] as usize] > 1;
            for j in bundle.rod(rod) {
                let unbroken = self.unbroken_counts.get(bundle.origin[j] as usize);
                self.loose[j] = broken || counts[j] == 0 || unbroken != Some(&counts[j]);
            }
            let edges = || bundle.rod(rod).filter(|&j| bundle.is_edge(j));
            let free = !bundle.twisting && is_crumb(bundle, rod) && edges().all(|j| counts[j] == 0);
            edges().for_each(|j| self.crumb[j] = free);
        }
        self.bond_counts = counts;
        if self.margin > 0.0 {
            let edges = was_loose.iter().zip(&self.loose).enumerate();
            let loosened = edges.filter(|(_, (was, is))| was != is);
            self.changed.extend(loosened.map(|(j, _)| j as u32));
        }
    }

    /// Follows a change of the bundle's numbering, before [`RodPairs::bundle_changed`]: vertex `i` was vertex `before[i]`. Of the
    /// copies of a vertex the last has the edge.
    pub fn renumber(&mut self, before: &[u32]) {
        if self.margin <= 0.0 {
            return;
        }
        let mut after = vec![0; self.bond_counts.len()];
        for (new, &old) in before.iter().enumerate() {
            after[old as usize] = new as u32;
        }
        let old = |i: &u32| *i as usize;
        self.position = before.iter().map(|i| self.position.get(old(i))).collect();
        self.bond_counts = before.iter().map(|i| self.bond_counts[old(i)]).collect();
        self.loose = before.iter().map(|i| self.loose[old(i)]).collect();
        let renumber = |edge: &mut u32| *edge = after[*edge as usize];
        self.changed.iter_mut().for_each(renumber);
        self.cells.iter_mut().for_each(|(_, edge)| renumber(edge));
        self.boxes = before.iter().map(|i| self.boxes[old(i)]).collect();
        for pair in &mut self.pairs {
            renumber(&mut pair.a);
            renumber(&mut pair.b);
        }
    }

    /// Adds the present contacts; with a `motion` also those that occur within its step.
    pub fn gather(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        radius: &[f64],
        motion: Option<StepMotion>,
        contacts: &mut Vec<ContactPoint>,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let moved = moved_squared(&state.position, &self.position);
        if self.margin <= 0.0 || moved.is_nan() {
            self.search(bundle, state, radius, context)?;
        } else {
            if 4.0 * moved > self.margin * self.margin {
                self.follow(bundle, state, radius);
            }
            if !self.changed.is_empty() {
                self.search_changed(bundle, radius, context)?;
            }
        }
        self.update_approach(state, motion);
        for pair in &self.pairs {
            let (a, b) = (pair.a as usize, pair.b as usize);
            if pair.distance - (self.approach[a] + self.approach[b]) > pair.reach {
                continue;
            }
            let one = (state.position.get(a), state.edge(a));
            let two = (state.position.get(b), state.edge(b));
            let (s, t) = closest_parameters(one, two);
            let (p, q) = (one.0 + one.1 * s, two.0 + two.1 * t);
            let distance = p.distance(q);
            let margin = motion.map_or(0.0, |StepMotion { velocity, step }| {
                let at = |j: usize, t: f64| velocity.get(j).lerp(velocity.get(j + 1), t);
                step * at(a, s).distance(at(b, t))
            });
            if distance < pair.reach + margin
                && let Some(normal) = (p - q).try_normalize()
            {
                contacts.push(ContactPoint {
                    first: Side::Edge { edge: pair.a, t: s },
                    second: Side::Edge { edge: pair.b, t },
                    normal,
                    point: 0.5 * (p + q),
                    depth: pair.reach - distance,
                    slop: SLOP * radius[a],
                    length: pair.reach,
                });
            }
        }
        Ok(())
    }

    /// Finds for each edge how far it has moved since the last search, and moves in a step.
    fn update_approach(&mut self, state: &State, motion: Option<StepMotion>) {
        let n = state.position.len();
        self.approach.resize(n, 0.0);
        let (now, then) = (&state.position, &self.position);
        for v in 0..n {
            let (x, y, z) = (
                now.x[v] - then.x[v],
                now.y[v] - then.y[v],
                now.z[v] - then.z[v],
            );
            self.approach[v] = (x * x + y * y + z * z).sqrt();
        }
        if let Some(StepMotion { velocity, step }) = motion {
            for v in 0..n {
                let (x, y, z) = (velocity.x[v], velocity.y[v], velocity.z[v]);
                self.approach[v] += step * (x * x + y * y + z * z).sqrt();
            }
        }
        for v in 1..n {
            self.approach[v - 1] = self.approach[v - 1].max(self.approach[v]);
        }
    }

    /// Takes the present positions of vertices that have moved far, and marks their edges. A pair remains valid while each of
    /// its edges is nearer than half the margin to where it was searched: the others need not be searched again.
    fn follow(&mut self, bundle: &RodBundle, state: &State, radius: &[f64]) {
        let far = MOVED_FRACTION * self.margin;
        for v in 0..bundle.vertices() {
            let position = state.position.get(v);
            if position.distance_squared(self.position.get(v)) > far * far {
                self.position.set(v, position);
                let edges = v.saturating_sub(1)..=v;
                self.changed
                    .extend(edges.filter(|&j| radius[j] > 0.0).map(|j| j as u32));
            }
        }
        let corner = self.grid.corner;
        let low = (self.position.iter()).fold(corner, |low, p| low.min(p));
        self.grid.corner = low;
        self.sort_into_cells(radius, self.margin);
    }

    /// Sorts all edges by their cells, and makes their boxes.
    fn sort_into_cells(&mut self, radius: &[f64], margin: f64) {
        let mut cells = std::mem::take(&mut self.cells);
        cells.clear();
        let edges = (0..radius.len()).filter(|&j| radius[j] > 0.0);
        cells.extend(edges.map(|j| (key(self.cell(j)), j as u32)));
        cells.sort_unstable();
        self.cells = cells;
        self.boxes.clear();
        self.boxes.resize(radius.len(), Bounds::default());
        for j in (0..radius.len()).filter(|&j| radius[j] > 0.0) {
            let edge = edge_at(&self.position, j);
            // Both edges of a pair have half the margin.
            self.boxes[j] = Bounds::about(edge, radius[j] + 0.5 * margin);
        }
        self.packed.clear();
        let boxes = self.cells.iter().map(|(_, j)| &self.boxes[*j as usize]);
        boxes.for_each(|b| self.packed.push(b));
    }

    /// Searches all pairs anew.
    fn search(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        radius: &[f64],
        context: &Context,
    ) -> Result<(), Cancelled> {
        let edges = || (0..bundle.vertices()).filter(|&j| radius[j] > 0.0);
        let thickest = radius.iter().copied().fold(0.0, f64::max);
        let margin = SEARCH_MARGIN * thickest;
        // Until the search is complete.
        self.margin = 0.0;
        let longest = edges().map(|j| state.edge(j).length()).fold(0.0, f64::max);
        let side = longest + 2.0 * thickest + margin;
        let corner = state
            .position
            .iter()
            .fold(DVec3::INFINITY, |low, p| low.min(p));
        self.position.clone_from(&state.position);
        self.grid = Grid { corner, side };
        self.pairs.clear();
        self.changed.clear();
        if !(side.is_finite() && corner.is_finite()) {
            self.margin = margin;
            return Ok(());
        }
        self.sort_into_cells(radius, margin);
        let mut pairs = std::mem::take(&mut self.pairs);
        let search = PairSearch {
            bundle,
            radius,
            margin,
        };
        for (count, a) in edges().enumerate() {
            if count.is_multiple_of(EDGES_PER_CHECK) {
                context.check()?;
            }
            self.add_pairs_of(&search, a, &mut pairs, |b| b > a);
        }
        self.set_pairs(pairs);
        self.margin = margin;
        Ok(())
    }

    /// Searches the pairs of edges that have lost bonds, at the positions of the last search.
    fn search_changed(
        &mut self,
        bundle: &RodBundle,
        radius: &[f64],
        context: &Context,
    ) -> Result<(), Cancelled> {
        let search = PairSearch {
            bundle,
            radius,
            margin: std::mem::take(&mut self.margin),
        };
        let mut changed = vec![false; bundle.vertices()];
        let mut list = std::mem::take(&mut self.changed);
        list.sort_unstable();
        list.dedup();
        list.iter().for_each(|&j| changed[j as usize] = true);
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.retain(|p| !(changed[p.a as usize] || changed[p.b as usize]));
        let edges = list.iter().filter(|j| radius[**j as usize] > 0.0);
        for (count, &j) in edges.enumerate() {
            if count.is_multiple_of(EDGES_PER_CHECK) {
                context.check()?;
            }
            let a = j as usize;
            self.add_pairs_of(&search, a, &mut pairs, |b| b > a || b < a && !changed[b]);
        }
        self.set_pairs(pairs);
        self.margin = search.margin;
        Ok(())
    }

    fn set_pairs(&mut self, mut pairs: Vec<Pair>) {
        // The order of contacts must not depend on where cells begin.
        pairs.sort_unstable_by_key(|p| (p.a, p.b));
        self.pairs = pairs;
    }

    fn cell(&self, edge: usize) -> [i64; 3] {
        let Grid { corner, side } = self.grid;
        let (start, along) = edge_at(&self.position, edge);
        let middle = start + 0.5 * along;
        ((middle - corner) / side).to_array().map(|c| c as i64 + 1)
    }

    /// Adds the pairs of an edge with others that are `wanted`.
    fn add_pairs_of(
        &self,
        search: &PairSearch,
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
                let end = start + self.cells[start..].partition_point(|c| c.0 <= to);
                (self.packed).for_each_overlap(start..end, &self.boxes[a], |k| {
                    let b = self.cells[k].1 as usize;
                    if wanted(b)
                        && (self.loose[a] || self.loose[b])
                        && !(self.crumb[a] || self.crumb[b])
                        && self.boxes[a].overlaps(&self.boxes[b])
                    {
                        let (a, b) = (a.min(b), a.max(b));
                        pairs.extend(search.pair(&self.position, a, b));
                    }
                });
            }
        }
    }
}

/// What a search for pairs needs.
struct PairSearch<'a> {
    bundle: &'a RodBundle,
    radius: &'a [f64],
    margin: f64,
}

/// Returns the start and the vector of an edge.
fn edge_at(position: &Vectors, edge: usize) -> Segment {
    let start = position.get(edge);
    (start, position.get(edge + 1) - start)
}

impl PairSearch<'_> {
    /// Returns the pair of two edges, where they may touch before the next search.
    fn pair(&self, position: &Vectors, a: usize, b: usize) -> Option<Pair> {
        let bundle = self.bundle;
        let touch = self.radius[a] + self.radius[b];
        let (one, two) = (edge_at(position, a), edge_at(position, b));
        if are_far_apart(one, two, touch + self.margin) {
            return None;
        }
        let apart = distance(one, two);
        let excluded = || are_neighbours_on_rod(bundle, a, b, touch) || are_bonded(bundle, a, b);
        if apart > touch + self.margin || excluded() {
            return None;
        }
        let rest = distance(edge_at(&bundle.rest, a), edge_at(&bundle.rest, b));
        (rest > 0.0).then(|| Pair {
            a: a as u32,
            b: b as u32,
            reach: touch.min(REST_DISTANCE_FRACTION * rest),
            distance: apart,
        })
    }
}

/// Whether two edges lie on what was one rod, so close that bending alone brings them together.
fn are_neighbours_on_rod(bundle: &RodBundle, a: usize, b: usize, touch: f64) -> bool {
    let parent = |j: usize| bundle.parent[bundle.rod_of(j)];
    if parent(a) != parent(b) {
        return false;
    }
    let between = bundle.origin[a].abs_diff(bundle.origin[b]);
    f64::from(between.saturating_sub(1)) * bundle.rest_length[a].min(bundle.rest_length[b])
        < 2.0 * touch
}

/// Whether a bond connects two edges or their neighbours.
fn are_bonded(bundle: &RodBundle, a: usize, b: usize) -> bool {
    let joins = |from: usize, to: usize| {
        (from..=from + 1).any(|v| {
            let mut own = bundle.bonds.incidence.of_vertex(v);
            own.any(|i| bundle.bonds.edge[i].abs_diff(to as u32) <= 1)
        })
    };
    joins(a, b) || joins(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bonds::Bond;
    use crate::loads::Loads;
    use crate::rod_bundle::{Rod, RodMaterial};
    use crate::topology::break_up;
    use greenstick_wood::noise;

    /// Sixteen rods in a square, and bonds between all that are near.
    fn bonded_rods() -> (RodBundle, Vec<Bond>) {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let rods: Vec<Rod> = (0..16)
            .map(|r| {
                let corner = DVec3::new((r % 4) as f64, (r / 4) as f64, 0.0) * 1.1e-3;
                let vertex = |i: usize| corner + DVec3::Z * 4e-3 * i as f64;
                Rod::new((0..9).map(vertex).collect(), material)
            })
            .collect();
        let mut bundle = RodBundle::new(&rods, false).unwrap();
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
            shear_fracture_energy: 1.0,
            damage: 0.0,
        };
        let near = |v: u32, r: u32| v / 9 != r && (v / 9).abs_diff(r) <= 5;
        let all = (0..bundle.vertices() as u32).flat_map(|v| {
            (0..16)
                .filter(move |&r| near(v, r))
                .map(move |r| bond(v, r))
        });
        let bonds: Vec<Bond> = all.collect();
        bundle.set_bonds(bonds.clone()).unwrap();
        (bundle, bonds)
    }

    #[test]
    fn a_crumb_that_nothing_holds_touches_no_rod_and_a_longer_piece_does() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let rods = [0.0, 0.02].map(|x| {
            let vertex = |i: usize| DVec3::new(x, 0.0, 4e-3 * i as f64);
            Rod::new((0..9).map(vertex).collect(), material)
        });
        for (edges, expected) in [(1, 0), (2, 0), (3, 1)] {
            let mut bundle = RodBundle::new(&rods, false).unwrap();
            let mut state = State::at_rest(&bundle);
            let mut pairs = RodPairs::default();
            pairs.bundle_changed(&bundle);
            let mut loads = Loads::default();
            break_up(&mut bundle, &mut state, &mut loads, &[], &[9 + edges]);
            pairs.bundle_changed(&bundle);
            // The piece lies across the first rod.
            for v in bundle.rod(1) {
                let along = 4e-3 * (v - bundle.rod(1).start) as f64;
                state.position.set(v, DVec3::new(1e-3, along, 0.01));
            }
            let radius: Vec<f64> = (0..bundle.vertices())
                .map(|j| if bundle.is_edge(j) { 6e-4 } else { 0.0 })
                .collect();
            let (mut found, context) = (Vec::new(), Context::quiet());
            pairs
                .gather(&bundle, &state, &radius, None, &mut found, &context)
                .unwrap();
            assert_eq!(found.len(), expected, "{edges} edges");
        }
    }

    #[test]
    fn pairs_searched_where_bonds_broke_are_those_of_a_search_everywhere() {
        let (mut bundle, mut bonds) = bonded_rods();
        let radius: Vec<f64> = (0..bundle.vertices())
            .map(|j| if bundle.is_edge(j) { 6e-4 } else { 0.0 })
            .collect();
        let mut state = State::at_rest(&bundle);
        let context = Context::quiet();
        let mut pairs = RodPairs::default();
        pairs.bundle_changed(&bundle);
        pairs
            .gather(&bundle, &state, &radius, None, &mut Vec::new(), &context)
            .unwrap();
        assert!(pairs.pairs.is_empty());
        for round in 0..6 {
            let random = |i: usize| noise::unit(8, i as i64, round, 0);
            let mut i = 0;
            bonds.retain(|_| {
                i += 1;
                random(i) > 0.2
            });
            bundle.set_bonds(bonds.clone()).unwrap();
            for v in 0..bundle.vertices() {
                // Columns of rods approach each other in pairs.
                let way = if v / 9 % 2 == 0 { 2e-5 } else { -2e-5 };
                state.position.add(v, DVec3::X * (way + 1e-5 * random(v)));
            }
            pairs.bundle_changed(&bundle);
            let mut found = Vec::new();
            pairs
                .gather(&bundle, &state, &radius, None, &mut found, &context)
                .unwrap();
            assert!(pairs.changed.is_empty() && pairs.position != state.position);
            // The same pairs from a search of everything at the same positions, and the same contacts from the present ones.
            let mut whole = pairs.clone();
            let old = State {
                position: pairs.position.clone(),
                ..state.clone()
            };
            whole.search(&bundle, &old, &radius, &context).unwrap();
            assert!(whole.pairs == pairs.pairs && !pairs.pairs.is_empty());
            whole.search(&bundle, &state, &radius, &context).unwrap();
            let mut expected = Vec::new();
            whole
                .gather(&bundle, &state, &radius, None, &mut expected, &context)
                .unwrap();
            let points = |of: &[ContactPoint]| -> Vec<(Side, DVec3)> {
                of.iter().map(|c| (c.first, c.point)).collect()
            };
            assert!(round < 5 || found.len() > 10);
            assert_eq!(points(&found), points(&expected));
        }
    }
}
