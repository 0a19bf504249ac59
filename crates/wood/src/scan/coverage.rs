//! How much of a stem's girth a scan shows along it, and the part of the stem about a location that it shows well enough.

use super::points::StemPoints;
use super::report::{Coverage, ScanError};
use super::traced::TracedStem;

/// Share of the sections' patches that a ray may meet more than once: bark flakes and stubs are no folds.
pub(super) const MAX_FOLDED_SHARE: f64 = 0.25;
/// Coverage is reported for parts of this length, m.
const PART_LENGTH: f64 = 1.0;
/// Points per sector of a section: so many that chance leaves hardly one empty.
const POINTS_PER_SECTOR: usize = 5;

/// The share of the girth that was seen, part by part.
pub(super) fn coverage(points: &StemPoints, stem: &TracedStem) -> Vec<Coverage> {
    let length = stem.axis.length();
    let slabs = ((length / stem.mean_radius()).round() as usize).clamp(2, 20_000);
    let slab_of = |s: f64| ((s / length * slabs as f64) as usize).min(slabs - 1);
    let mut turns: Vec<Vec<f64>> = vec![Vec::new(); slabs];
    for p in &points.points {
        turns[slab_of(p.s)].push(p.turn);
    }
    let share = |turns: &Vec<f64>| {
        let sectors = (turns.len() / POINTS_PER_SECTOR).clamp(8, 72);
        let mut seen = vec![false; sectors];
        turns
            .iter()
            .for_each(|t| seen[((t * sectors as f64) as usize).min(sectors - 1)] = true);
        seen.iter().filter(|s| **s).count() as f64 / sectors as f64
    };
    let shares: Vec<f64> = turns.iter().map(share).collect();
    let parts = ((length / PART_LENGTH).ceil() as usize).max(1);
    (0..parts)
        .map(|k| {
            let from_m = k as f64 * PART_LENGTH;
            let to_m = ((k + 1) as f64 * PART_LENGTH).min(length);
            let part = &shares[slab_of(from_m)..=slab_of(to_m - 1e-9 * length)];
            Coverage {
                from_m,
                to_m,
                share: part.iter().sum::<f64>() / part.len() as f64,
            }
        })
        .collect()
}

/// The share of the girth that was seen, of a stem `length` m long.
pub(super) fn mean_coverage(coverage: &[Coverage], length: f64) -> f64 {
    let seen = coverage.iter().map(|c| c.share * (c.to_m - c.from_m));
    seen.sum::<f64>() / length
}

/// What a part of the stem must fulfil to be used.
#[derive(Debug, Clone, Copy)]
pub(super) struct Requirements {
    /// Least share of the girth that was seen.
    pub min_coverage: f64,
    /// Largest share of folded patches.
    pub max_folded: f64,
}

/// The parts about the length `at` (m) that fulfil the requirements, as a range of lengths (m).
pub(super) fn usable_span(
    points: &StemPoints,
    coverage: &[Coverage],
    at: f64,
    length: f64,
    required: Requirements,
) -> Result<(f64, f64), ScanError> {
    let here = ((at / PART_LENGTH) as usize).min(coverage.len() - 1);
    let folded = |k: usize| points.folded(coverage[k].from_m, coverage[k].to_m);
    let good = |k: &usize| {
        coverage[*k].share >= required.min_coverage && folded(*k) <= required.max_folded
    };
    if folded(here) > required.max_folded {
        return Err(ScanError::NotStarShaped {
            from: coverage[here].from_m,
            to: coverage[here].to_m,
            share: folded(here),
            max: required.max_folded,
        });
    }
    if !good(&here) {
        return Err(ScanError::LowCoverage {
            coverage: coverage[here],
            required: required.min_coverage,
        });
    }
    let first = (0..=here).rev().take_while(good).last().unwrap_or(here);
    let last = (here..coverage.len())
        .take_while(good)
        .last()
        .unwrap_or(here);
    Ok((coverage[first].from_m, coverage[last].to_m.min(length)))
}
