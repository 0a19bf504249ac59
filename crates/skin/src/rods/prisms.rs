//! Prisms and their joints: which faces lie open, and which corners of prisms are one vertex.

use super::columns::{Columns, OUTSIDE};
use super::error::RodSkinError;
use super::fracture_state::{FractureState, RodPart};
use super::history::{BreakHistory, NEVER};
use super::options::RodSkinOptions;
use super::wood::Wood;
use glam::DVec2;
use greenstick_fibre::Cause;
use greenstick_geometry::Unions;
use greenstick_wood::noise::{gradient_2d, unit};
use std::collections::BTreeMap;

/// Greatest number of prisms.
const MAX_PRISMS: usize = 1 << 26;
/// Greatest distance of corners from the plane of their station, in slabs: without it planes across the grain would show.
const STATION_JITTER: f64 = 0.35;
/// Distances of the breaks of fibre bundles from that of their rod, in lengths of pull-out: one that a whole ring shares, one
/// that a layer (a sector of the ring) shares, and one of each bundle.
const BREAK_SCATTER: [f64; 3] = [1.0, 1.5, 2.5];
/// Width of a layer across the rings and along them, in distances between fibre bundles.
const LAYER_WIDTH: [f64; 2] = [1.2, 6.0];
/// Such a distance where a rod was crushed, in widths of the bundle.
const CRUSHED_LENGTH: f64 = 0.5;

/// The prisms of a section: columns times slabs.
pub(super) struct PrismComplex<'a> {
    pub columns: &'a Columns,
    /// Length along the axis of each station between slabs, m.
    pub stations: Vec<f64>,
    /// The part of its rod that each prism belongs to.
    pub parts: Vec<RodPart>,
    /// Whether each side of each prism is joined to the prism beyond it.
    joined: Vec<bool>,
    /// Whether each prism is joined to the next one of its column.
    onward: Vec<bool>,
    /// Number of the first side of each column; the number of all sides at the end.
    first_side: Vec<usize>,
    /// The bonds between each two rods.
    bonds_between: BondsBetween,
    /// The rod of each vertex of the bundle.
    rod_of: Vec<u32>,
    /// The vertex of each bond.
    bond_vertex: &'a [u32],
    seed: u64,
}

/// A corner of a prism: corner `corner` of column `column`, at station `station`, of the slab below or above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PrismCorner {
    pub column: usize,
    pub corner: usize,
    pub station: usize,
    pub above: bool,
}

impl<'a> PrismComplex<'a> {
    pub fn new(
        wood: &Wood<'a>,
        columns: &'a Columns,
        state: &FractureState,
        options: &RodSkinOptions,
    ) -> Result<Self, RodSkinError> {
        let stations = stations(wood, options)?;
        let slabs = stations.len() - 1;
        let count = columns.columns.len();
        if count.saturating_mul(slabs) > MAX_PRISMS {
            return Err(RodSkinError::TooLarge {
                prisms: count.saturating_mul(slabs),
                columns: count,
                slabs,
                max: MAX_PRISMS,
            });
        }
        let mut first_side = vec![0];
        for column in &columns.columns {
            first_side.push(first_side.last().copied().unwrap_or(0) + column.corners.len());
        }
        let mut complex = PrismComplex {
            columns,
            parts: Vec::with_capacity(count * slabs),
            joined: vec![false; first_side[count] * slabs],
            onward: vec![false; count * slabs],
            first_side,
            stations,
            bonds_between: bonds_between(wood),
            rod_of: wood.rods_of_vertices(),
            bond_vertex: &wood.bundle.bonds.vertex,
            seed: options.seed,
        };
        complex.assign_parts(wood, state, options);
        complex.join(state);
        Ok(complex)
    }

    /// Returns the number of slabs.
    pub fn slabs(&self) -> usize {
        self.stations.len() - 1
    }

    /// Returns the number of a prism.
    pub fn prism(&self, column: usize, slab: usize) -> usize {
        column * self.slabs() + slab
    }

    fn side(&self, column: usize, side: usize, slab: usize) -> usize {
        (self.first_side[column] + side) * self.slabs() + slab
    }

    /// Whether the side of a prism is joined to the prism beyond it.
    pub fn is_joined(&self, column: usize, side: usize, slab: usize) -> bool {
        self.joined[self.side(column, side, slab)]
    }

    /// Whether the prisms below and above a station are joined.
    pub fn is_whole(&self, column: usize, station: usize) -> bool {
        station > 0 && station < self.slabs() && self.onward[self.prism(column, station - 1)]
    }

    /// Returns the length along the axis of a corner at a station, m.
    pub fn length(&self, corner: u32, station: usize) -> f64 {
        let s = self.stations[station];
        if station == 0 || station == self.slabs() {
            return s;
        }
        let slab = self.stations[1] - self.stations[0];
        // Similar for corners near each other, so that no side of a column is steep.
        let at = self.columns.corners[corner as usize] / self.columns.spacing;
        s + STATION_JITTER * slab * gradient_2d(self.seed ^ 0x5e7 ^ ((station as u64) << 32), at)
    }

    /// Assigns every prism to a part of its rod. Each column breaks where its rod does, but at a length of its own.
    fn assign_parts(&mut self, wood: &Wood, state: &FractureState, options: &RodSkinOptions) {
        let slabs = self.slabs();
        let slab = self.stations[1] - self.stations[0];
        let start = self.stations[0];
        for (number, column) in self.columns.columns.iter().enumerate() {
            let breaks = &state.breaks[column.rod as usize];
            let layer = layer(column.centre - wood.stem.rings.pith(), self.columns.spacing);
            let mut at: Vec<usize> = Vec::new();
            for (k, broken) in breaks.iter().enumerate() {
                let s = wood.along[broken.vertex as usize];
                let reach = break_reach(wood, column.width(), broken.cause) * options.splinters;
                let random = |what: u64, x: i64, y: i64| {
                    2.0 * unit(options.seed ^ what, x, y, k as i64) - 1.0
                };
                let (ring, sector) = layer;
                // Most bundles break near the others of their layer, and a few far from them.
                let own = random(0x0f1b, number as i64, 0);
                let off = reach
                    * (BREAK_SCATTER[0] * random(0x70d, ring, 0)
                        + BREAK_SCATTER[1] * random(0x70e, ring, sector)
                        + BREAK_SCATTER[2] * own * own.abs());
                // No farther than half way to the rod's next break or end.
                let vertices = wood.bundle.rod(column.rod as usize);
                let before = if k > 0 {
                    breaks[k - 1].vertex as usize
                } else {
                    vertices.start
                };
                let behind = breaks
                    .get(k + 1)
                    .map_or(vertices.end - 1, |b| b.vertex as usize);
                let (low, high) = (
                    0.5 * (wood.along[before] + s),
                    0.5 * (s + wood.along[behind]),
                );
                let station = (((s + off).clamp(low, high) - start) / slab).round() as usize;
                at.push(station.clamp(1, slabs.max(2) - 1));
            }
            for k in 0..slabs {
                // Prism k lies above all stations up to k.
                let part = at.iter().filter(|&&b| b <= k).count();
                self.parts.push(part as RodPart);
            }
        }
    }

    /// Joins prisms of one part of a rod, and those of rods that a bond holds together there.
    fn join(&mut self, state: &FractureState) {
        let slabs = self.slabs();
        let columns = self.columns;
        for (a, column) in columns.columns.iter().enumerate() {
            for k in 0..slabs.saturating_sub(1) {
                let prism = self.prism(a, k);
                self.onward[prism] = self.parts[prism] == self.parts[prism + 1];
            }
            for (side, &b) in column.beyond.iter().enumerate() {
                if b == OUTSIDE {
                    continue;
                }
                let b = b as usize;
                let (rod, other) = (column.rod, columns.columns[b].rod);
                for k in 0..slabs {
                    let parts = (self.parts[self.prism(a, k)], self.parts[self.prism(b, k)]);
                    let joined = if rod == other {
                        parts.0 == parts.1
                    } else {
                        (self.bond(rod, other, k)).is_some_and(|(bond, own)| {
                            let wanted = if own { parts } else { (parts.1, parts.0) };
                            state.bonded_parts[bond as usize].contains(&Some(wanted))
                        })
                    };
                    let number = self.side(a, side, k);
                    self.joined[number] = joined;
                }
            }
        }
    }

    /// Returns the bond that decides whether two rods hold together at a slab, the one nearest to its middle, and whether its
    /// vertex belongs to the first rod.
    fn bond(&self, rod: u32, other: u32, slab: usize) -> Option<(u32, bool)> {
        let between = self.bonds_between.get(&(rod.min(other), rod.max(other)))?;
        let s = 0.5 * (self.stations[slab] + self.stations[slab + 1]);
        let k = between.partition_point(|b| b.0 < s);
        let neighbours = [k.checked_sub(1), Some(k)].into_iter().flatten();
        let nearest = neighbours
            .filter_map(|k| between.get(k))
            .min_by(|a, b| (a.0 - s).abs().total_cmp(&(b.0 - s).abs()));
        nearest.map(|&(_, bond)| {
            let vertex = self.bond_vertex[bond as usize] as usize;
            (bond, self.rod_of[vertex] == rod)
        })
    }

    /// Returns the first frame in which a side of a prism is open.
    pub fn opening_frame(
        &self,
        column: usize,
        side: usize,
        slab: usize,
        history: &BreakHistory,
    ) -> u32 {
        if self.is_joined(column, side, slab) {
            return NEVER;
        }
        let columns = &self.columns.columns;
        let beyond = columns[column].beyond[side] as usize;
        let Some(other) = columns.get(beyond) else {
            return 0;
        };
        let (rod, breaks) = (columns[column].rod, &history.last_state().breaks);
        let parts = [column, beyond].map(|c| self.parts[self.prism(c, slab)]);
        let own = breaks[rod as usize].as_slice();
        if rod == other.rod {
            return history.split_frame(own, parts[0], parts[1]);
        }
        let beyond = breaks[other.rod as usize].as_slice();
        match self.bond(rod, other.rod, slab) {
            Some((bond, true)) => history.release_frame(bond, [own, beyond], (parts[0], parts[1])),
            Some((bond, false)) => history.release_frame(bond, [beyond, own], (parts[1], parts[0])),
            None => 0,
        }
    }

    /// Returns the corner of a prism that has a number.
    pub fn corner(&self, number: u32) -> PrismCorner {
        let (line, at) = (
            number as usize / 2 / (self.slabs() + 1),
            number as usize / 2 % (self.slabs() + 1),
        );
        let column = self.first_side.partition_point(|&f| f <= line) - 1;
        PrismCorner {
            column,
            corner: line - self.first_side[column],
            station: at,
            above: number % 2 == 1,
        }
    }

    /// Returns the number of corners of prisms, which [`PrismComplex::number`] numbers.
    fn corner_count(&self) -> usize {
        2 * self.first_side[self.columns.columns.len()] * (self.slabs() + 1)
    }

    /// Returns the number of a corner of a prism.
    pub fn number(&self, corner: PrismCorner) -> u32 {
        let line = self.first_side[corner.column] + corner.corner;
        (2 * (line * (self.slabs() + 1) + corner.station) + usize::from(corner.above)) as u32
    }

    /// Returns the sets of corners that are one vertex: those that prisms share by joined faces. With `rods_apart` faces
    /// between rods do not count.
    pub fn vertex_sets(&self, rods_apart: bool) -> Unions {
        let mut unions = Unions::new(self.corner_count());
        for (a, column) in self.columns.columns.iter().enumerate() {
            let n = column.corners.len();
            for station in 1..self.slabs() {
                if self.is_whole(a, station) {
                    for corner in 0..n {
                        let at = |above| {
                            self.number(PrismCorner {
                                column: a,
                                corner,
                                station,
                                above,
                            })
                        };
                        unions.join(at(false), at(true));
                    }
                }
            }
            for (side, &b) in column.beyond.iter().enumerate() {
                // Each pair once.
                if b == OUTSIDE || (b as usize) < a {
                    continue;
                }
                let other = &self.columns.columns[b as usize];
                if rods_apart && other.rod != column.rod {
                    continue;
                }
                let ends = [column.corners[side], column.corners[(side + 1) % n]];
                let there = ends.map(|c| other.corners.iter().position(|&o| o == c));
                for slab in (0..self.slabs()).filter(|&k| self.is_joined(a, side, k)) {
                    for (k, there) in there.iter().enumerate() {
                        let Some(there) = *there else { continue };
                        for (station, above) in [(slab, true), (slab + 1, false)] {
                            let here = PrismCorner {
                                column: a,
                                corner: (side + k) % n,
                                station,
                                above,
                            };
                            let beyond = PrismCorner {
                                column: b as usize,
                                corner: there,
                                ..here
                            };
                            unions.join(self.number(here), self.number(beyond));
                        }
                    }
                }
            }
        }
        unions
    }

    /// Joins faces whose corners are the vertices of the face beyond: a crack that is held all around cannot open.
    pub fn close_held(&mut self, vertices: &mut Unions) {
        let (mut sides, mut ends) = (Vec::new(), Vec::new());
        for a in 0..self.columns.columns.len() {
            let column = &self.columns.columns[a];
            for (side, &b) in column.beyond.iter().enumerate() {
                if b == OUTSIDE {
                    continue;
                }
                for slab in (0..self.slabs()).filter(|&k| !self.is_joined(a, side, k)) {
                    if self
                        .corners_of_side(a, side, slab)
                        .iter()
                        .all(|&(here, beyond)| {
                            beyond.is_some_and(|b| vertices.root(here) == vertices.root(b))
                        })
                    {
                        sides.push(self.side(a, side, slab));
                    }
                }
            }
            for station in (1..self.slabs()).filter(|&s| !self.is_whole(a, s)) {
                let held = (0..column.corners.len()).all(|corner| {
                    let at = |above| {
                        self.number(PrismCorner {
                            column: a,
                            corner,
                            station,
                            above,
                        })
                    };
                    vertices.root(at(false)) == vertices.root(at(true))
                });
                if held {
                    ends.push(self.prism(a, station - 1));
                }
            }
        }
        sides.iter().for_each(|&s| self.joined[s] = true);
        ends.iter().for_each(|&e| self.onward[e] = true);
    }

    /// Returns the four corners of a prism's side, each with the coincident corner of the prism beyond: low first and low
    /// second, high second and high first.
    pub fn corners_of_side(
        &self,
        column: usize,
        side: usize,
        slab: usize,
    ) -> [(u32, Option<u32>); 4] {
        let own = &self.columns.columns[column];
        let n = own.corners.len();
        let beyond = own.beyond[side];
        [
            (0, slab, true),
            (1, slab, true),
            (1, slab + 1, false),
            (0, slab + 1, false),
        ]
        .map(|(k, station, above)| {
            let corner = (side + k) % n;
            let here = PrismCorner {
                column,
                corner,
                station,
                above,
            };
            let there = self.columns.columns.get(beyond as usize).and_then(|other| {
                let corner = other
                    .corners
                    .iter()
                    .position(|&c| c == own.corners[corner])?;
                Some(self.number(PrismCorner {
                    column: beyond as usize,
                    corner,
                    ..here
                }))
            });
            (self.number(here), there)
        })
    }
}

/// Returns how far a fibre bundle's break may lie from that of its rod, m: the length over which the bundle pulls out, or the
/// crushed length.
pub(super) fn break_reach(wood: &Wood, width: f64, cause: Cause) -> f64 {
    match cause {
        Cause::Compression => CRUSHED_LENGTH * width,
        _ => wood.pull_out * width,
    }
}

/// Returns ring and sector of the layer at a position relative to the pith. Layers of neighbouring rings end at different
/// angles.
fn layer(from_pith: DVec2, spacing: f64) -> (i64, i64) {
    let r = from_pith.length();
    let ring = (r / (LAYER_WIDTH[0] * spacing)).floor();
    let middle = (ring + 0.5) * LAYER_WIDTH[0] * spacing;
    let turn = libm::atan2(from_pith.y, from_pith.x) / std::f64::consts::TAU;
    let sectors = (std::f64::consts::TAU * middle / (LAYER_WIDTH[1] * spacing))
        .round()
        .max(1.0);
    let start = unit(0x5ec, ring as i64, 0, 0);
    let sector = ((turn + 1.0 + start).fract() * sectors).floor();
    (ring as i64, sector as i64)
}

/// Returns the lengths along the axis of the even planes between slabs, m.
fn stations(wood: &Wood, options: &RodSkinOptions) -> Result<Vec<f64>, RodSkinError> {
    let low = wood.along.iter().copied().fold(f64::INFINITY, f64::min);
    let high = wood.along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let edges = wood.bundle.vertices() as f64 / wood.bundle.rods() as f64 - 1.0;
    let count = (edges * options.slabs).round().clamp(2.0, 1e6);
    let at = |k: usize| low + (high - low) * (k as f64 / count);
    Ok((0..=count as usize).map(at).collect())
}

/// The bonds between each two rods, sorted along the axis: length along it (m) and number.
type BondsBetween = BTreeMap<(u32, u32), Vec<(f64, u32)>>;

fn bonds_between(wood: &Wood) -> BondsBetween {
    let bundle = wood.bundle;
    let rod_of = wood.rods_of_vertices();
    let mut between = BondsBetween::new();
    let bonds = bundle.bonds.vertex.iter().zip(&bundle.bonds.edge);
    for (number, (&v, &e)) in bonds.enumerate() {
        let (a, b) = (rod_of[v as usize], rod_of[e as usize]);
        let list = between.entry((a.min(b), a.max(b))).or_default();
        list.push((wood.along[v as usize], number as u32));
    }
    for list in between.values_mut() {
        list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    between
}
