//! Edges as segments: their closest points and their bounds.

use glam::DVec3;

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
}
