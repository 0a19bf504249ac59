//! Years as trees have them: they differ, good ones come together, and young trees grow wider rings. Made from nothing but
//! a seed.

use crate::noise::{unit, value_1d};

/// In the hash: what ring widths are drawn for.
const RING: u64 = 0x52;
/// Width of the innermost rings relative to that of the outermost: young trees grow wider rings.
const INNERMOST_DENSITY: f64 = 0.78;
/// How far the edge of a ring is shifted, in rings: year by year, and over runs of good and bad years.
const YEARLY_SHIFT: f64 = 0.34;
const RUN_SHIFT: f64 = 0.6;
const RUN_YEARS: f64 = 4.0;
/// A number from 0 to 1 that belongs to a year: how marked its latewood is.
pub(crate) fn latewood_strength(seed: u64, ring: i64) -> f64 {
    unit(seed ^ RING, ring - 1, 2, 0)
}

/// Outer edge of a ring, in mean ring widths.
fn year_edge(seed: u64, ring: i64) -> f64 {
    let seed = seed ^ RING;
    ring as f64
        + YEARLY_SHIFT * (unit(seed, ring, 1, 0) - 0.5)
        + RUN_SHIFT * value_1d(seed, ring as f64 / RUN_YEARS)
}

/// Ring coordinates of the outer edges of grown rings; the last is 1.
pub(super) fn grown_edges(count: u16, seed: u64) -> Vec<f64> {
    let count = f64::from(count.max(1));
    // Rings per ring coordinate rise outwards: the count up to ρ is count ρ (a + (1 − a) ρ).
    let (a, b) = (INNERMOST_DENSITY, 1.0 - INNERMOST_DENSITY);
    let coordinate = |t: f64| ((a * a + 4.0 * b * t / count).sqrt() - a) / (2.0 * b);
    let (first, last) = (year_edge(seed, 0), year_edge(seed, count as i64));
    let even = |ring: i64| count * (year_edge(seed, ring) - first) / (last - first);
    let mut edges: Vec<f64> = (1..count as i64)
        .map(|ring| coordinate(even(ring)))
        .collect();
    edges.push(1.0);
    edges
}

/// The length of a cell along the grain that fits a period, and the number of cells in it (0: no period).
pub(crate) fn periodic_cells(length: f64, period: Option<f64>) -> (f64, i64) {
    match period {
        Some(period) if period > 0.0 => {
            let number = (period / length).round().max(1.0);
            (period / number, number as i64)
        }
        _ => (length, 0),
    }
}
