//! The broken face: of the breaks of all rods, those between the two sides that came apart.
//!
//! A rod may break many times: a splinter that is bent further breaks again, and brash wood breaks in several places along its
//! length. How ragged a face is follows from the breaks in it alone.

use super::pieces::{Pieces, SPLINTER_SHARE};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use std::ops::Range;

/// Where rods broke.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Face {
    /// The place of the break of each rod that broke in it, along the stem, m, ascending.
    pub places: Vec<f64>,
    /// Breaks of rods that are not in it.
    pub further: usize,
}

/// A break of a rod.
#[derive(Debug, Clone, Copy)]
struct RodBreak {
    /// Along the stem, m.
    place: f64,
    /// Distance of its two ends, m.
    opening: f64,
}

impl Face {
    /// Returns the face of a bundle, between what lies at the base's side of the cut (`at_base`, per vertex) and the next piece
    /// that is no splinter. Where nothing has parted it has the break of each rod that gapes most. `place` is that along the stem
    /// (m) of a vertex of the unbroken bundle.
    pub fn new(
        (bundle, state): (&RodBundle, &State),
        place: impl Fn(usize) -> f64,
        (pieces, at_base): (&Pieces, Option<&[bool]>),
    ) -> Self {
        let mut all = 0;
        let mut of_rods: Vec<Vec<RodBreak>> = Vec::new();
        for parts in rods_of_one(bundle) {
            let breaks: Vec<RodBreak> = (parts.start + 1..parts.end)
                .map(|part| {
                    let after = bundle.rod(part).start;
                    let [a, b] = [after - 1, after].map(|v| state.position.get(v));
                    RodBreak {
                        place: break_place(bundle, &place, after),
                        opening: a.distance(b),
                    }
                })
                .collect();
            all += breaks.len();
            let between = at_base.map(|side| between_sides(bundle, parts, (pieces, side)));
            of_rods.push(match between {
                Some(between) => breaks[between].to_vec(),
                None => breaks,
            });
        }
        let mut places = choose(&of_rods);
        places.sort_by(f64::total_cmp);
        Face {
            further: all - places.len(),
            places,
        }
    }

    /// Median and standard deviation of the places, m; `None` where no rod broke.
    pub fn median_and_spread(&self) -> Option<(f64, f64)> {
        let median = *self.places.get(self.places.len() / 2)?;
        let count = self.places.len() as f64;
        let mean = self.places.iter().sum::<f64>() / count;
        let variance = self.places.iter().map(|p| (p - mean) * (p - mean));
        Some((median, (variance.sum::<f64>() / count).sqrt()))
    }
}

/// Returns the place (m) of the break between the vertices `after − 1` and `after`, which were one. That vertex was moved along
/// the rod to where it broke, by half an edge at most: its place follows from the edges beside it.
fn break_place(bundle: &RodBundle, place: &impl Fn(usize) -> f64, after: usize) -> f64 {
    let vertex = bundle.origin[after] as usize;
    let [before, own, beyond] = [vertex - 1, vertex, vertex + 1].map(place);
    // Both parts have an edge at least.
    let [a, b] = [after - 2, after].map(|edge| bundle.rest_length[edge]);
    let moved = before + (beyond - before) * a / (a + b);
    moved.clamp(
        0.5 * (before + own).min(own + beyond),
        0.5 * (before + own).max(own + beyond),
    )
}

/// Returns for each rod of the unbroken bundle its parts, in their order along it.
fn rods_of_one(bundle: &RodBundle) -> Vec<Range<usize>> {
    let mut rods: Vec<Range<usize>> = Vec::new();
    for rod in 0..bundle.rods() {
        match rods.last_mut() {
            Some(last) if bundle.parent[last.start] == bundle.parent[rod] => last.end = rod + 1,
            _ => rods.push(rod..rod + 1),
        }
    }
    rods
}

/// Returns which breaks of a rod lie between its last part on the base's side and the next one that is of a piece on the
/// other. Break n lies between parts n and n + 1.
fn between_sides(
    bundle: &RodBundle,
    parts: Range<usize>,
    (pieces, at_base): (&Pieces, &[bool]),
) -> Range<usize> {
    let is_beyond = |v: usize| !at_base[v] && pieces.of(v).share >= SPLINTER_SHARE;
    let numbered = parts.clone().map(|part| bundle.rod(part));
    let last = parts.len() - 1;
    let from = numbered
        .clone()
        .rposition(|mut part| part.any(|v| at_base[v]))
        .unwrap_or(0);
    let to = numbered
        .skip(from)
        .position(|mut part| part.any(is_beyond))
        .map_or(last, |further| from + further);
    from..to
}

/// Chooses one break of each rod. A rod with several says nothing of where the others parted: its break is that which is nearest to
/// the median of theirs, and of equally near ones that which gapes most.
fn choose(of_rods: &[Vec<RodBreak>]) -> Vec<f64> {
    let sure = of_rods.iter().filter(|breaks| breaks.len() == 1).flatten();
    let mut known: Vec<f64> = sure.map(|b| b.place).collect();
    if known.is_empty() {
        known = of_rods.iter().flatten().map(|b| b.place).collect();
    }
    known.sort_by(f64::total_cmp);
    let Some(&median) = known.get(known.len() / 2) else {
        return known;
    };
    let off = |b: &RodBreak| (b.place - median).abs();
    let better = |a: &RodBreak, b: &RodBreak| {
        let nearer = off(b).total_cmp(&off(a));
        nearer.then(a.opening.total_cmp(&b.opening))
    };
    let best = |breaks: &Vec<RodBreak>| breaks.iter().copied().max_by(better);
    of_rods.iter().filter_map(best).map(|b| b.place).collect()
}
