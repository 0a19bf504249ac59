//! Groups of cracks by size, and their statistics: large, medium and small ones (Yang 2019 §5).

use super::crack::MeasuredCrack;
use crate::parameters::{CrackGroup, CrackKind};
use serde::Serialize;

/// Groups that a section has at most.
const MAX_GROUPS: usize = 3;
/// Cracks stand in a part of the section if the widest gap between them is so many times the mean of the others.
const WIDE_GAP: f64 = 3.0;

/// Statistics of a group of radial cracks. Lengths are in radii of the section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CrackStatistics {
    /// Number of cracks.
    pub count: usize,
    /// Direction of the first one, degrees.
    pub direction: f64,
    /// Mean angle from one to the next, degrees.
    pub spacing: f64,
    /// Root mean square by which angles are off even spacing, degrees.
    pub angle_deviation: f64,
    /// Least and greatest ring coordinate of the beginnings.
    pub begin: [f64; 2],
    /// Least and greatest length.
    pub length: [f64; 2],
    /// Least and greatest opening over the distance from the pith, rad.
    pub opening: [f64; 2],
    /// Least and greatest width.
    pub width: [f64; 2],
    /// Number of cracks that are open at the bark.
    pub open_at_bark: usize,
}

/// Returns the groups of radial cracks, the largest first.
pub(super) fn groups(cracks: &[MeasuredCrack]) -> Vec<CrackStatistics> {
    let mut radial: Vec<&MeasuredCrack> = cracks
        .iter()
        .filter(|c| c.kind == CrackKind::Radial)
        .collect();
    radial.sort_by(|a, b| b.length().total_cmp(&a.length()));
    let lengths: Vec<f64> = radial.iter().map(|c| c.length()).collect();
    let mut rest = &radial[..];
    let mut statistics = Vec::new();
    for count in natural_breaks(&lengths) {
        let (group, others) = rest.split_at(count);
        rest = others;
        statistics.push(CrackStatistics::new(group));
    }
    statistics
}

/// Splits descending values into at most three groups with the least sum of squares about their means (Jenks 1967).
/// Returns the size of each.
fn natural_breaks(values: &[f64]) -> Vec<usize> {
    let n = values.len();
    let squares = |from: usize, to: usize| {
        let part = &values[from..to];
        let mean = part.iter().sum::<f64>() / part.len().max(1) as f64;
        part.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()
    };
    match n.min(MAX_GROUPS) {
        0 => Vec::new(),
        1 => vec![1],
        2 => vec![1, 1],
        _ => {
            let pairs = (1..n - 1).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
            let cost = |&(a, b): &(usize, usize)| squares(0, a) + squares(a, b) + squares(b, n);
            let best = pairs.min_by(|x, y| cost(x).total_cmp(&cost(y)));
            best.map_or(vec![n], |(a, b)| vec![a, b - a, n - b])
        }
    }
}

impl CrackStatistics {
    fn new(cracks: &[&MeasuredCrack]) -> Self {
        let range = |of: fn(&MeasuredCrack) -> f64| {
            let values = cracks.iter().map(|c| of(c));
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            })
        };
        let (direction, spacing, angle_deviation) = directions(cracks);
        CrackStatistics {
            count: cracks.len(),
            direction,
            spacing,
            angle_deviation,
            begin: range(|c| c.begin),
            length: range(|c| c.length()),
            opening: range(|c| c.opening),
            width: range(|c| c.width),
            open_at_bark: cracks.iter().filter(|c| c.open_at_bark).count(),
        }
    }

    /// Returns the parameters of a group with these statistics, opened by a shrinkage along the rings. Cracks are as deep as
    /// they are long.
    pub(super) fn parameters(&self, shrinkage: f64) -> CrackGroup {
        let range = self
            .opening
            .map(|o| (o / shrinkage).to_degrees().clamp(0.1, 180.0));
        let depth = self.length.map(|l| l.max(0.01));
        let jitter = if self.spacing > 0.0 {
            // An even distribution is √12 times as wide as its root mean square.
            (self.angle_deviation * 12f64.sqrt() / self.spacing).min(1.0)
        } else {
            0.0
        };
        CrackGroup {
            count: self.count as u32,
            direction: self.direction,
            spacing: self.spacing,
            jitter,
            begin_min: self.begin[0],
            begin_max: self.begin[1],
            length_min: self.length[0],
            length_max: self.length[1],
            depth_min: depth[0],
            depth_max: depth[1],
            range_min: range[0],
            range_max: range[1],
            shrinkage: None,
        }
    }
}

/// Direction of the first crack, mean angle to the next, and root mean square deviation, degrees.
fn directions(cracks: &[&MeasuredCrack]) -> (f64, f64, f64) {
    let mut angles: Vec<f64> = cracks.iter().map(|c| c.angle).collect();
    angles.sort_by(f64::total_cmp);
    let n = angles.len();
    if n < 2 {
        return (angles.first().copied().unwrap_or(0.0), 360.0, 0.0);
    }
    let gap = |i: usize| (angles[(i + 1) % n] - angles[i]).rem_euclid(360.0);
    let widest = (0..n)
        .max_by(|&a, &b| gap(a).total_cmp(&gap(b)))
        .unwrap_or(0);
    let others = (360.0 - gap(widest)) / (n - 1) as f64;
    let first = (widest + 1) % n;
    let spacing = if n > 2 && gap(widest) > WIDE_GAP * others {
        others
    } else {
        360.0 / n as f64
    };
    let on = |i: usize| (angles[(first + i) % n] - angles[first]).rem_euclid(360.0);
    let off = |i: usize| on(i) - spacing * i as f64;
    let mean = (0..n).map(off).sum::<f64>() / n as f64;
    let square = (0..n)
        .map(|i| (off(i) - mean) * (off(i) - mean))
        .sum::<f64>()
        / n as f64;
    (
        (angles[first] + mean).rem_euclid(360.0),
        spacing,
        square.sqrt(),
    )
}
