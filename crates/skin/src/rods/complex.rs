//! Prisms and what joins them: which faces lie open, and which corners of prisms are one vertex.

use super::history::{History, NEVER};
use super::parting::{Part, Parting};
use super::section::{Columns, OUTSIDE};
use super::{RodSkinError, RodSkinOptions, Wood};
use glam::DVec2;
use greenstick_fibre::Cause;
use greenstick_geometry::Unions;
use greenstick_wood::noise::{gradient_2d, unit};
use std::collections::BTreeMap;

/// The most prisms.
const MOST: usize = 1 << 26;
/// Corners lie up to this part of a slab off its plane, so that no plane across the grain shows.
const JITTER: f64 = 0.35;
/// How far breaks of a rod's fibre bundles lie from the rod's, in lengths of pull-out: with all of their ring, with those
/// of their layer, which is a sector of it, and each by itself.
const SCATTER: [f64; 3] = [1.0, 1.5, 2.5];
/// Width of a layer across the rings and along them, in distances of fibre bundles.
const LAYER: [f64; 2] = [1.2, 6.0];
/// The same in widths where a rod was crushed.
const CRUSHED: f64 = 0.5;

/// Columns times slabs.
pub(super) struct Complex<'a> {
    pub columns: &'a Columns,
    /// Length along the axis of each station between slabs, m.
    pub stations: Vec<f64>,
    /// Part of its rod that each prism is of.
    pub parts: Vec<Part>,
    /// Whether each side of each prism is joined to the prism beyond it.
    joined: Vec<bool>,
    /// Whether each prism is joined to the next one of its column.
    onward: Vec<bool>,
    /// First side of each column, and their number at the end.
    first: Vec<usize>,
    /// The bonds between each two rods.
    between: Between,
    /// The rod of each vertex of the bundle.
    rod_of: Vec<u32>,
    /// The vertex with which each bond begins.
    bond_vertex: &'a [u32],
    seed: u64,
}

/// One corner of a prism, as a number: side `corner` of column `column`, at the station `station`, seen from the slab
/// below it or above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub column: usize,
    pub corner: usize,
    pub station: usize,
    pub above: bool,
}

impl<'a> Complex<'a> {
    pub fn new(
        wood: &Wood<'a>,
        columns: &'a Columns,
        parting: &Parting,
        options: &RodSkinOptions,
    ) -> Result<Self, RodSkinError> {
        let stations = stations(wood, options)?;
        let slabs = stations.len() - 1;
        let count = columns.columns.len();
        if count.saturating_mul(slabs) > MOST {
            return Err(RodSkinError::TooLarge {
                prisms: count.saturating_mul(slabs),
                columns: count,
                slabs,
                most: MOST,
            });
        }
        let mut first = vec![0];
        for column in &columns.columns {
            first.push(first.last().copied().unwrap_or(0) + column.corners.len());
        }
        let mut complex = Complex {
            columns,
            parts: Vec::with_capacity(count * slabs),
            joined: vec![false; first[count] * slabs],
            onward: vec![false; count * slabs],
            first,
            stations,
            between: bonds_between(wood),
            rod_of: wood.rods_of_vertices(),
            bond_vertex: &wood.bundle.bonds.vertex,
            seed: options.seed,
        };
        complex.put_parts(wood, parting, options);
        complex.join(parting);
        Ok(complex)
    }

    /// Number of slabs.
    pub fn slabs(&self) -> usize {
        self.stations.len() - 1
    }

    /// Number of a prism.
    pub fn prism(&self, column: usize, slab: usize) -> usize {
        column * self.slabs() + slab
    }

    fn side(&self, column: usize, side: usize, slab: usize) -> usize {
        (self.first[column] + side) * self.slabs() + slab
    }

    /// Whether the side of a prism is joined to the prism beyond it.
    pub fn is_joined(&self, column: usize, side: usize, slab: usize) -> bool {
        self.joined[self.side(column, side, slab)]
    }

    /// Whether the prisms below and above a station are joined.
    pub fn is_whole(&self, column: usize, station: usize) -> bool {
        station > 0 && station < self.slabs() && self.onward[self.prism(column, station - 1)]
    }

    /// Length along the axis of a corner at a station, m.
    pub fn length(&self, corner: u32, station: usize) -> f64 {
        let s = self.stations[station];
        if station == 0 || station == self.slabs() {
            return s;
        }
        let slab = self.stations[1] - self.stations[0];
        // Alike for corners that lie near each other, so that no side of a column is steep.
        let at = self.columns.corners[corner as usize] / self.columns.spacing;
        s + JITTER * slab * gradient_2d(self.seed ^ 0x5e7 ^ ((station as u64) << 32), at)
    }

    /// Gives every prism the part of its rod: each column breaks where its rod does, but at a length of its own.
    fn put_parts(&mut self, wood: &Wood, parting: &Parting, options: &RodSkinOptions) {
        let slabs = self.slabs();
        let slab = self.stations[1] - self.stations[0];
        let start = self.stations[0];
        for (number, column) in self.columns.columns.iter().enumerate() {
            let breaks = &parting.breaks[column.rod as usize];
            let layer = layer(column.centre - wood.stem.rings.pith(), self.columns.spacing);
            let mut at: Vec<usize> = Vec::new();
            for (k, broken) in breaks.iter().enumerate() {
                let s = wood.along[broken.vertex as usize];
                let reach = reach(wood, column.width(), broken.cause) * options.splinters;
                let random = |what: u64, x: i64, y: i64| {
                    2.0 * unit(options.seed ^ what, x, y, k as i64) - 1.0
                };
                let (ring, sector) = layer;
                // Most bundles break near the others of their layer, a few far off.
                let own = random(0x0f1b, number as i64, 0);
                let off = reach
                    * (SCATTER[0] * random(0x70d, ring, 0)
                        + SCATTER[1] * random(0x70e, ring, sector)
                        + SCATTER[2] * own * own.abs());
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
                self.parts.push(part as Part);
            }
        }
    }

    /// Joins prisms of one part of a rod, and those of rods that a bond holds together there.
    fn join(&mut self, parting: &Parting) {
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
                            parting.holds[bond as usize].contains(&Some(wanted))
                        })
                    };
                    let place = self.side(a, side, k);
                    self.joined[place] = joined;
                }
            }
        }
    }

    /// The bond that decides whether two rods hold together at a slab: the one next to its middle, and whether its vertex
    /// is of the first rod.
    fn bond(&self, rod: u32, other: u32, slab: usize) -> Option<(u32, bool)> {
        let between = self.between.get(&(rod.min(other), rod.max(other)))?;
        let s = 0.5 * (self.stations[slab] + self.stations[slab + 1]);
        let k = between.partition_point(|b| b.0 < s);
        let near = [k.checked_sub(1), Some(k)].into_iter().flatten();
        let next = near
            .filter_map(|k| between.get(k))
            .min_by(|a, b| (a.0 - s).abs().total_cmp(&(b.0 - s).abs()));
        next.map(|&(_, bond)| {
            let vertex = self.bond_vertex[bond as usize] as usize;
            (bond, self.rod_of[vertex] == rod)
        })
    }

    /// The first frame in which a side of a prism is open.
    pub fn opens(&self, column: usize, side: usize, slab: usize, history: &History) -> u32 {
        if self.is_joined(column, side, slab) {
            return NEVER;
        }
        let columns = &self.columns.columns;
        let beyond = columns[column].beyond[side] as usize;
        let Some(other) = columns.get(beyond) else {
            return 0;
        };
        let (rod, breaks) = (columns[column].rod, &history.last().breaks);
        let parts = [column, beyond].map(|c| self.parts[self.prism(c, slab)]);
        let own = breaks[rod as usize].as_slice();
        if rod == other.rod {
            return history.parted(own, parts[0], parts[1]);
        }
        let beyond = breaks[other.rod as usize].as_slice();
        match self.bond(rod, other.rod, slab) {
            Some((bond, true)) => history.let_go(bond, [own, beyond], (parts[0], parts[1])),
            Some((bond, false)) => history.let_go(bond, [beyond, own], (parts[1], parts[0])),
            None => 0,
        }
    }

    /// The corner of a prism with a number.
    pub fn place(&self, number: u32) -> Place {
        let (line, at) = (
            number as usize / 2 / (self.slabs() + 1),
            number as usize / 2 % (self.slabs() + 1),
        );
        let column = self.first.partition_point(|&f| f <= line) - 1;
        Place {
            column,
            corner: line - self.first[column],
            station: at,
            above: number % 2 == 1,
        }
    }

    /// How many corners of prisms there are; [`Complex::number`] numbers them.
    pub fn corner_count(&self) -> usize {
        2 * self.first[self.columns.columns.len()] * (self.slabs() + 1)
    }

    /// Number of a corner of a prism.
    pub fn number(&self, place: Place) -> u32 {
        let line = self.first[place.column] + place.corner;
        (2 * (line * (self.slabs() + 1) + place.station) + usize::from(place.above)) as u32
    }

    /// Which corners of prisms are one vertex: those that prisms share by joined faces. With `rods_apart` faces between
    /// rods do not count.
    pub fn vertices(&self, rods_apart: bool) -> Unions {
        let mut unions = Unions::new(self.corner_count());
        for (a, column) in self.columns.columns.iter().enumerate() {
            let n = column.corners.len();
            for station in 1..self.slabs() {
                if self.is_whole(a, station) {
                    for corner in 0..n {
                        let at = |above| {
                            self.number(Place {
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
                            let here = Place {
                                column: a,
                                corner: (side + k) % n,
                                station,
                                above,
                            };
                            let beyond = Place {
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

    /// Joins faces whose corners are all one vertex with those of the face they lie on: a crack that is held all around
    /// cannot open. Returns how many.
    pub fn close_held(&mut self, vertices: &mut Unions) -> usize {
        let (mut sides, mut caps) = (Vec::new(), Vec::new());
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
                        self.number(Place {
                            column: a,
                            corner,
                            station,
                            above,
                        })
                    };
                    vertices.root(at(false)) == vertices.root(at(true))
                });
                if held {
                    caps.push(self.prism(a, station - 1));
                }
            }
        }
        sides.iter().for_each(|&s| self.joined[s] = true);
        caps.iter().for_each(|&c| self.onward[c] = true);
        sides.len() + caps.len()
    }

    /// The four corners of a prism's side, each with the one of the prism beyond that lies there: low first and low
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
            let here = Place {
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
                Some(self.number(Place {
                    column: beyond as usize,
                    corner,
                    ..here
                }))
            });
            (self.number(here), there)
        })
    }
}

/// How far a fibre bundle's break may lie from its rod's, m: the length over which it pulls out, or what crushing does.
pub(super) fn reach(wood: &Wood, width: f64, cause: Cause) -> f64 {
    match cause {
        Cause::Compression => CRUSHED * width,
        _ => wood.pull_out * width,
    }
}

/// Ring and sector of the layer that a place lies in, seen from the pith. Layers of one ring end elsewhere than those of
/// the next.
fn layer(from_pith: DVec2, spacing: f64) -> (i64, i64) {
    let r = from_pith.length();
    let ring = (r / (LAYER[0] * spacing)).floor();
    let middle = (ring + 0.5) * LAYER[0] * spacing;
    let turn = libm::atan2(from_pith.y, from_pith.x) / std::f64::consts::TAU;
    let sectors = (std::f64::consts::TAU * middle / (LAYER[1] * spacing))
        .round()
        .max(1.0);
    let start = unit(0x5ec, ring as i64, 0, 0);
    let sector = ((turn + 1.0 + start).fract() * sectors).floor();
    (ring as i64, sector as i64)
}

/// Lengths along the axis between slabs, even.
fn stations(wood: &Wood, options: &RodSkinOptions) -> Result<Vec<f64>, RodSkinError> {
    if !(options.slabs >= 0.25 && options.slabs <= 64.0) {
        return Err(RodSkinError::Value {
            what: "the number of slabs for each edge",
            value: options.slabs,
            right: "from 0.25 to 64",
        });
    }
    if !(options.splinters >= 0.0 && options.splinters <= 100.0) {
        return Err(RodSkinError::Value {
            what: "the length of splinters",
            value: options.splinters,
            right: "from 0 to 100",
        });
    }
    let low = wood.along.iter().copied().fold(f64::INFINITY, f64::min);
    let high = wood.along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let edges = wood.bundle.vertices() as f64 / wood.bundle.rods() as f64 - 1.0;
    let count = (edges * options.slabs).round().clamp(2.0, 1e6);
    let at = |k: usize| low + (high - low) * (k as f64 / count);
    Ok((0..=count as usize).map(at).collect())
}

/// The bonds between each two rods: length along the axis (m) and number, along it.
type Between = BTreeMap<(u32, u32), Vec<(f64, u32)>>;

fn bonds_between(wood: &Wood) -> Between {
    let bundle = wood.bundle;
    let rod_of = wood.rods_of_vertices();
    let mut between = Between::new();
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
