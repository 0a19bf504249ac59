//! Edges as segments: their closest points and their bounds.

use crate::simd::dispatch::with_widest_registers;
use glam::DVec3;
use std::ops::Range;

/// A segment: its start and its vector, m.
pub(super) type Segment = (DVec3, DVec3);

/// A box along the axes, m.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    /// Returns the box about a segment, with a margin.
    pub fn about((start, along): Segment, margin: f64) -> Self {
        let end = start + along;
        Bounds {
            low: start.min(end) - DVec3::splat(margin),
            high: start.max(end) + DVec3::splat(margin),
        }
    }

    pub fn overlaps(&self, other: &Bounds) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// Boxes of which many are compared with one at a time: in single precision, rounded outwards.
#[derive(Debug, Clone, Default)]
pub(super) struct PackedBounds {
    low: [Vec<f32>; 3],
    high: [Vec<f32>; 3],
}

impl PackedBounds {
    /// Boxes that are compared before those that overlap are told.
    const BLOCK: usize = 64;

    /// Removes all boxes.
    pub fn clear(&mut self) {
        self.low
            .iter_mut()
            .chain(&mut self.high)
            .for_each(Vec::clear);
    }

    /// Adds a box.
    pub fn push(&mut self, bounds: &Bounds) {
        let ([low, high], of) = (PackedBounds::rounded(bounds), self);
        for a in 0..3 {
            of.low[a].push(low[a]);
            of.high[a].push(high[a]);
        }
    }

    fn rounded(bounds: &Bounds) -> [[f32; 3]; 2] {
        [
            bounds.low.to_array().map(|v| (v as f32).next_down()),
            bounds.high.to_array().map(|v| (v as f32).next_up()),
        ]
    }

    /// Calls `found` with the numbers in a range of all boxes that overlap with this one, and of few others, ascending.
    pub fn for_each_overlap(
        &self,
        range: Range<usize>,
        with: &Bounds,
        mut found: impl FnMut(usize),
    ) {
        let [low, high] = PackedBounds::rounded(with);
        let mut first = range.start;
        while first < range.end {
            let count = Self::BLOCK.min(range.end - first);
            let mut overlaps = [0u8; Self::BLOCK];
            with_widest_registers(
                #[inline(always)]
                || {
                    let [x, y, z] = [0, 1, 2].map(|a| &self.low[a][first..][..count]);
                    let [u, v, w] = [0, 1, 2].map(|a| &self.high[a][first..][..count]);
                    for (k, out) in overlaps[..count].iter_mut().enumerate() {
                        let below = (x[k] <= high[0]) & (y[k] <= high[1]) & (z[k] <= high[2]);
                        let above = (u[k] >= low[0]) & (v[k] >= low[1]) & (w[k] >= low[2]);
                        *out = u8::from(below & above);
                    }
                },
            );
            for (k, eight) in overlaps.as_chunks::<8>().0.iter().enumerate() {
                let mut bits = u64::from_le_bytes(*eight);
                while bits != 0 {
                    let lane = bits.trailing_zeros() as usize / 8;
                    found(first + 8 * k + lane);
                    bits &= bits - 1;
                }
            }
            first += count;
        }
    }
}

/// Whether two segments are certainly farther apart than `reach`, from their distance seen along the first. It excludes most
/// pairs of a stem, where rods lie side by side.
pub(super) fn are_far_apart((p, d): Segment, (q, e): Segment, reach: f64) -> bool {
    let Some(along) = d.try_normalize() else {
        return false;
    };
    let middle = (q + 0.5 * e) - p;
    let side = middle.reject_from_normalized(along).length();
    side > reach + 0.5 * e.reject_from_normalized(along).length()
}

/// Returns the distance of two segments.
pub(super) fn distance(one: Segment, two: Segment) -> f64 {
    let (s, t) = closest_parameters(one, two);
    (one.0 + one.1 * s).distance(two.0 + two.1 * t)
}

/// Returns the parameters of the closest points of two segments (Ericson, *Real-Time Collision
/// Detection*, 5.1.9). For parallel segments it is the middle of where they lie side by side.
pub(super) fn closest_parameters((p, d): Segment, (q, e): Segment) -> (f64, f64) {
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
    use greenstick_wood::noise;

    #[test]
    fn the_closest_points_are_those_of_a_fine_search() {
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

    #[test]
    fn packed_boxes_find_all_that_overlap_and_hardly_others() {
        let random = |i: usize, k: i64| {
            DVec3::from_array([0, 1, 2].map(|a| noise::unit(3, i as i64, k, a))) * 2.0 - DVec3::ONE
        };
        let bounds = |i: usize| Bounds::about((random(i, 0), 0.2 * random(i, 1)), 0.05);
        let mut packed = PackedBounds::default();
        let count = 300;
        (0..count).for_each(|i| packed.push(&bounds(i)));
        let (mut exact, mut all) = (0, 0);
        for i in 0..count {
            let range = i / 2..count - i / 3;
            let mut found = Vec::new();
            packed.for_each_overlap(range.clone(), &bounds(i), |k| found.push(k));
            assert!(found.is_sorted());
            for k in range {
                let overlaps = bounds(i).overlaps(&bounds(k));
                assert!(!overlaps || found.contains(&k), "{i} {k}");
                exact += usize::from(overlaps);
            }
            all += found.len();
        }
        assert!(
            exact > 300 && all <= exact + exact / 1000,
            "{all} for {exact}"
        );
        // Boxes that touch overlap.
        let cube = |x: f64| Bounds::about((DVec3::X * x, DVec3::ZERO), 0.1);
        packed.clear();
        packed.push(&cube(0.2));
        let mut found = 0;
        packed.for_each_overlap(0..1, &cube(0.0), |_| found += 1);
        assert!(found == 1 && cube(0.0).overlaps(&cube(0.2)));
    }
}
