//! Where a run parted its stem, and at which of its breaks each rod parted there.
//!
//! The stem is parted where one large piece follows another along it. A rod may be broken many times; of the breaks between
//! its part of the one piece and its part of the other, the one that gapes most is in the face, and what lies beyond it is
//! a splinter. Where a piece still hangs together, its fracture is where most of the section broke.

use super::observed::{ObservedRun, RodEnd};
use super::splits::split_roots;
use crate::fit::{BreakOnStem, LengthRange, MAX_GAP, main_range};
use crate::rods::{Pieces, RodPart, Wood};
use std::collections::BTreeSet;

/// Places along the stem at which it is asked which piece has most of the section.
const PLACES: usize = 400;
/// Share of the section that makes a piece the stem at a place.
const MAIN_SHARE: f64 = 0.5;
/// Length of the stem (radii) over which a piece must be it, so that it is no splinter.
const MIN_LENGTH: f64 = 1.0;

/// Distance (radii) from the breaks of a fracture that parts the stem at which other breaks are not of it.
const CLEARANCE: f64 = 2.0;

/// A fracture of the stem of a run.
#[derive(Debug, Clone)]
pub struct SimulatedFracture {
    /// The break of each rod that lies in the fracture; `None` for rods that are whole there.
    pub(super) breaks: Vec<Option<RodEnd>>,
    /// The length along the axis (m) at which a whole rod beside broken ones passes the fracture; `None` for others.
    pub(super) roots: Vec<Option<f64>>,
    /// Whether the stem is in two there.
    pub parted: bool,
    /// Breaks of rods in it that are left out, because the rods broke several times.
    pub further_breaks: usize,
}

/// Returns the pieces that the stem consists of, from its base to its tip.
pub(crate) fn main_pieces(wood: &Wood, run: &ObservedRun, pieces: &Pieces) -> Vec<u32> {
    PieceOrder::new(wood, run, pieces).pieces
}

/// The pieces that the stem consists of, one after the other from its base.
struct PieceOrder {
    pieces: Vec<u32>,
}

impl SimulatedFracture {
    /// Finds the fractures of a run from the base of its stem to its tip; none where no rod broke.
    pub fn find(wood: &Wood, run: &ObservedRun) -> Vec<SimulatedFracture> {
        let pieces = run.state.pieces(wood);
        let order = PieceOrder::new(wood, run, &pieces);
        let mut parted = Vec::new();
        for border in 1..order.pieces.len() {
            let below: BTreeSet<u32> = order.pieces[..border].iter().copied().collect();
            let above: BTreeSet<u32> = order.pieces[border..].iter().copied().collect();
            parted.push(parting(wood, run, &pieces, &below, &above));
        }
        if parted.is_empty() {
            return partial(wood, run, |_| true).into_iter().collect();
        }
        let clear = CLEARANCE * wood.stem.radius;
        let ranges: Vec<LengthRange> = parted.iter().map(SimulatedFracture::range).collect();
        let is_clear = |at: f64| {
            let mut ranges = ranges.iter();
            ranges.all(|r| at < r.low - clear || at > r.high + clear)
        };
        let mut fractures = Vec::new();
        let mut partings = parted.into_iter();
        for &piece in &order.pieces {
            // What broke in a piece and holds all the same.
            let within = |b: &RodEnd| {
                let mut parts = [b.part, b.part + 1].into_iter();
                parts.all(|part| pieces.piece_of(b.rod, part) == piece) && is_clear(b.along)
            };
            fractures.extend(partial(wood, run, within));
            fractures.extend(partings.next());
        }
        fractures
    }

    /// The lengths along the axis between which rods broke in it, m.
    pub(crate) fn range(&self) -> LengthRange {
        let lengths = || self.broken().map(|b| b.along);
        LengthRange {
            low: lengths().fold(f64::INFINITY, f64::min),
            high: lengths().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// The length along the axis (m) at which a rod passes the fracture; `None` for a whole rod among whole ones.
    pub(super) fn length_of_rod(&self, rod: usize) -> Option<f64> {
        self.breaks[rod].map(|b| b.along).or(self.roots[rod])
    }

    /// Returns for each rod the length along the axis (m) at which it passes the fracture; for a whole rod among whole ones
    /// that of the nearest one beside a broken one.
    pub(crate) fn lengths_of_rods(&self, wood: &Wood) -> Vec<f64> {
        let nearest = |rod: usize| {
            let at = wood.cells[rod].centroid;
            let of_kind = |whole: bool| {
                let rods =
                    (0..self.breaks.len()).filter(move |&r| self.breaks[r].is_none() == whole);
                let known = rods.filter_map(|r| Some((r, self.length_of_rod(r)?)));
                let far = |r: &(usize, f64)| wood.cells[r.0].centroid.distance_squared(at);
                known.min_by(|a, b| far(a).total_cmp(&far(b)))
            };
            of_kind(true)
                .or(of_kind(false))
                .map_or(0.0, |known| known.1)
        };
        let rods = 0..self.breaks.len();
        rods.map(|rod| self.length_of_rod(rod).unwrap_or_else(|| nearest(rod)))
            .collect()
    }

    /// Returns the part of each rod before its break in the fracture; `None` for rods that are whole there.
    pub(crate) fn parts_before(&self) -> impl Iterator<Item = Option<RodPart>> + '_ {
        self.breaks.iter().map(|b| b.map(|b| b.part))
    }

    /// Returns the share of the section that broke in it, 0 to 1.
    pub fn broken_share(&self, wood: &Wood) -> f64 {
        let area: f64 = wood.cells.iter().map(|c| c.area).sum();
        let broken: f64 = self.broken().map(|b| wood.cells[b.rod as usize].area).sum();
        broken / area
    }

    /// The rods that broke in it, with their breaks.
    pub(super) fn broken(&self) -> impl Iterator<Item = &RodEnd> {
        self.breaks.iter().flatten()
    }
}

impl PieceOrder {
    fn new(wood: &Wood, run: &ObservedRun, pieces: &Pieces) -> PieceOrder {
        let along = || wood.along.iter().copied();
        let (low, high) = (
            along().fold(f64::INFINITY, f64::min),
            along().fold(f64::NEG_INFINITY, f64::max),
        );
        let section: f64 = wood.cells.iter().map(|c| c.area).sum();
        let mut runs: Vec<(u32, usize)> = Vec::new();
        for place in 0..PLACES {
            let at = low + (high - low) * (place as f64 + 0.5) / PLACES as f64;
            let mut areas = vec![0.0; pieces.count];
            for (rod, cell) in wood.cells.iter().enumerate() {
                let piece = pieces.piece_of(rod as u32, run.part_at(rod, at));
                areas[piece as usize] += cell.area;
            }
            let main = areas.iter().position(|&a| a > MAIN_SHARE * section);
            let Some(main) = main else {
                continue;
            };
            match runs.last_mut() {
                Some(last) if last.0 == main as u32 => last.1 += 1,
                _ => runs.push((main as u32, 1)),
            }
        }
        let least = MIN_LENGTH * wood.stem.radius / (high - low) * PLACES as f64;
        runs.retain(|r| r.1 as f64 >= least);
        // A piece that comes again holds all that lies between.
        let mut order: Vec<u32> = Vec::new();
        for (piece, _) in runs {
            match order.iter().position(|&known| known == piece) {
                Some(known) => order.truncate(known + 1),
                None => order.push(piece),
            }
        }
        PieceOrder { pieces: order }
    }
}

/// The fracture between the pieces `below` and those `above`.
fn parting(
    wood: &Wood,
    run: &ObservedRun,
    pieces: &Pieces,
    below: &BTreeSet<u32>,
    above: &BTreeSet<u32>,
) -> SimulatedFracture {
    let candidates = run.breaks.iter().enumerate().map(|(rod, of_rod)| {
        let is_in = |set: &BTreeSet<u32>, part: usize| {
            set.contains(&pieces.piece_of(rod as u32, part as RodPart))
        };
        let parts = of_rod.len() + 1;
        let last_below = (0..parts).rev().find(|&part| is_in(below, part));
        let first_above = (0..parts).find(|&part| is_in(above, part));
        // Break n lies between parts n and n + 1. Parts may be in no order where wood has slid along itself.
        let from = last_below.unwrap_or(0);
        let to = first_above.unwrap_or(of_rod.len());
        match from < to {
            true => &of_rod[from..to],
            false => &of_rod[..],
        }
    });
    let candidates: Vec<&[RodEnd]> = candidates.collect();
    // A rod that is a splinter all along says nothing of where the others parted: its break is one among theirs.
    let sure = candidates.iter().filter_map(|c| match c {
        [only] => Some(only.along),
        _ => None,
    });
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = sure.fold(none, |(l, h), along| (l.min(along), h.max(along)));
    let chosen = |candidates: &[RodEnd]| {
        let within: Vec<RodEnd> = (candidates.iter())
            .filter(|b| low <= b.along && b.along <= high)
            .copied()
            .collect();
        let off = |b: &RodEnd| (low - b.along).max(b.along - high);
        let nearest = || candidates.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        widest(&within).or_else(|| nearest().copied())
    };
    let breaks: Vec<Option<RodEnd>> = candidates.iter().map(|c| chosen(c)).collect();
    SimulatedFracture {
        roots: split_roots(wood, run, &breaks),
        breaks,
        parted: true,
        further_breaks: candidates.iter().map(|c| c.len().saturating_sub(1)).sum(),
    }
}

/// The fracture of wood that hangs together: the stretch in which most of the section broke, of the breaks that count.
fn partial(
    wood: &Wood,
    run: &ObservedRun,
    counts: impl Fn(&RodEnd) -> bool,
) -> Option<SimulatedFracture> {
    let on_stem = |b: &RodEnd| BreakOnStem {
        rod: b.rod,
        area: wood.cells[b.rod as usize].area,
        along: b.along,
    };
    let all = run.breaks.iter().flatten().filter(|b| counts(b));
    let all: Vec<BreakOnStem> = all.map(on_stem).collect();
    if all.is_empty() {
        return None;
    }
    let LengthRange { low, high } = main_range(&all, MAX_GAP * wood.stem.radius);
    let mut further = 0;
    let breaks = run.breaks.iter().map(|of_rod| {
        let here: Vec<RodEnd> = (of_rod.iter())
            .filter(|b| b.along >= low && b.along <= high && counts(b))
            .copied()
            .collect();
        further += here.len().saturating_sub(1);
        widest(&here)
    });
    let breaks: Vec<Option<RodEnd>> = breaks.collect();
    Some(SimulatedFracture {
        roots: split_roots(wood, run, &breaks),
        breaks,
        parted: false,
        further_breaks: further,
    })
}

/// The break that gapes most; of equals the first.
fn widest(breaks: &[RodEnd]) -> Option<RodEnd> {
    let mut best: Option<RodEnd> = None;
    for b in breaks {
        if best.is_none_or(|known| b.opening > known.opening) {
            best = Some(*b);
        }
    }
    best
}
