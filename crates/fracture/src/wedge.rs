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

/// Part of the greatest height from which on the wedge's planes leave heights as they are.
const WHOLE: f64 = 0.5;
/// Heights in a narrow wedge are multiples of this part of the radius: next to its edge all would differ by as good as
/// nothing, and steps finer than a file's precision would cross.
const STEP: f64 = 5e-4;

impl Wedge {
    /// A height (m) at a distance from the edge, brought between the planes. `greatest` are the greatest below and
    /// above zero: where the wedge is too narrow for those, all are less in proportion, so that they do not end on a
    /// plane.
    pub(crate) fn within(&self, h: f64, far: f64, greatest: (f64, f64), radius: f64) -> f64 {
        let (below, above) = (far * self.slopes.0, far * self.slopes.1);
        let (most, greatest) = if h < 0.0 {
            (below, greatest.0)
        } else {
            (above, greatest.1)
        };
        let part = (most / (WHOLE * greatest).max(f64::MIN_POSITIVE)).min(1.0);
        let kept = bent(h * part, below, above);
        if kept == h {
            return h;
        }
        let step = STEP * radius;
        (kept / step).trunc() * step
    }
}

/// Share of the free length within which heights are left alone.
const FREE: f64 = 0.75;
/// Share of the free length that limited heights never pass.
const MOST: f64 = 0.97;

/// A height brought back within `below` and `above` zero (m, positive), its order among others kept.
pub(crate) fn bent(h: f64, below: f64, above: f64) -> f64 {
    let most = if h < 0.0 { below } else { above };
    let over = h.abs() - FREE * most;
    if over > 0.0 {
        let room = (MOST - FREE) * most;
        let part = if room > 0.0 {
            over / (over + room)
        } else {
            0.0
        };
        (FREE * most + room * part).copysign(h)
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
