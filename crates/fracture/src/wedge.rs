//! The wedge that a bend opens, and compressing heights into the length that is free.

use glam::DVec2;

/// Two planes through a line across the section that the face keeps between. One piece can turn about that line by the
/// angle between the planes, away from the other, and they never overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wedge {
    /// Unit direction across the section, away from the line.
    pub toward: DVec2,
    /// Distance of the line from the axis in that direction, m.
    pub from: f64,
    /// Slopes (m per m) of the planes, the lower one's downwards.
    pub slopes: (f64, f64),
}

/// Part of the greatest height above which the wedge leaves heights as they are.
const UNSCALED_SHARE: f64 = 0.85;
/// Heights in a narrow wedge are multiples of this part of the radius. Next to the edge they would differ by next to nothing,
/// and steps finer than a file's precision would cross.
const HEIGHT_STEP: f64 = 5e-4;

impl Wedge {
    /// Returns a height (m) at a distance `far` (m) from the edge, brought between the planes. `greatest` are the greatest
    /// heights below and above zero: where the wedge is too narrow for them, all heights are scaled, so that they do not end
    /// on a plane.
    pub(crate) fn within(&self, h: f64, far: f64, greatest: (f64, f64), radius: f64) -> f64 {
        let (below, above) = (far * self.slopes.0, far * self.slopes.1);
        let (most, greatest) = if h < 0.0 {
            (below, greatest.0)
        } else {
            (above, greatest.1)
        };
        let part = (most / (UNSCALED_SHARE * greatest).max(f64::MIN_POSITIVE)).min(1.0);
        let limited = limited_height(h * part, below, above);
        if limited == h {
            return h;
        }
        let step = HEIGHT_STEP * radius;
        (limited / step).trunc() * step
    }
}

/// Share of the free length within which heights are left alone.
pub(crate) const UNLIMITED_SHARE: f64 = 0.75;
/// Share of the free length that limited heights never pass.
const MAX_SHARE: f64 = 0.97;

/// Returns a height brought back within `below` and `above` zero (m, positive). The order of heights stays.
pub(crate) fn limited_height(h: f64, below: f64, above: f64) -> f64 {
    let most = if h < 0.0 { below } else { above };
    let over = h.abs() - UNLIMITED_SHARE * most;
    if over > 0.0 {
        let clearance = (MAX_SHARE - UNLIMITED_SHARE) * most;
        let part = if clearance > 0.0 {
            over / (over + clearance)
        } else {
            0.0
        };
        (UNLIMITED_SHARE * most + clearance * part).copysign(h)
    } else {
        h
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_in_a_wedge_lie_between_its_planes_in_their_order() {
        let wedge = Wedge {
            toward: DVec2::X,
            from: 0.0,
            slopes: (0.3, 1.4),
        };
        let greatest = (0.05, 0.12);
        for far in [0.0, 1e-4, 3e-3, 0.02, 0.04] {
            let mut last = f64::NEG_INFINITY;
            for i in -50..=120 {
                let h = wedge.within(f64::from(i) * 1e-3, far, greatest, 0.02);
                assert!((-0.3 * far..=1.4 * far).contains(&h), "{h} at {far}");
                assert!(h >= last);
                last = h;
            }
        }
        // Where there is room nothing changes.
        assert_eq!(wedge.within(0.05, 1.0, greatest, 0.02), 0.05);
    }
}
