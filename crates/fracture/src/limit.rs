//! Placing heights along the stem, within what is free of it and within the wedge that a bend opens.

use crate::heights::{Heights, Setting, Thorn};
use crate::layout::Bundles;
use crate::surface::Surface;
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

/// How far above the place of the break, in radii, the edge of a wedge lies: at the place itself the skin has a level of
/// the grain, and a face in that plane would meet it in edges instead of crossing it.
const OFF_LEVEL: f64 = 2.3e-4;

impl Wedge {
    /// A height (m) at a distance from the edge, brought between the planes. `greatest` are the greatest below and
    /// above zero: where the wedge is too narrow for those, all are less in proportion, so that they do not end on a
    /// plane.
    fn within(&self, h: f64, far: f64, greatest: (f64, f64), radius: f64) -> f64 {
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
fn bent(h: f64, below: f64, above: f64) -> f64 {
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

/// Places heights (in radii) along the axis and bends those that would leave the stem back into it, keeping their order.
pub(crate) fn place(
    bundles: &Bundles,
    mut corners: Vec<[f64; 3]>,
    setting: &Setting,
    thorns: Vec<Thorn>,
) -> Heights {
    let relief_range = relief_range(&corners) * setting.radius;
    let (below, above) = (
        setting.place - setting.usable.0,
        setting.usable.1 - setting.place,
    );
    let (mut wanted, mut range) = (
        [f64::INFINITY, f64::NEG_INFINITY],
        [f64::INFINITY, f64::NEG_INFINITY],
    );
    let mut limited = 0;
    let (lowest, highest) = extremes(&corners);
    let greatest = (lowest * setting.radius, highest * setting.radius);
    for (facet, heights) in bundles.layout.facets.iter().zip(&mut corners) {
        for (&node, height) in facet.iter().zip(heights) {
            let mut h = *height * setting.radius;
            if let Some(w) = &setting.wedge {
                let at = bundles.layout.nodes[node as usize];
                let far = (at.dot(w.toward) - w.from).max(0.0);
                h = w.within(h, far, greatest, setting.radius) + OFF_LEVEL * setting.radius;
            }
            wanted = [wanted[0].min(h), wanted[1].max(h)];
            let kept = bent(h, below, above);
            limited += usize::from(kept != h);
            range = [range[0].min(kept), range[1].max(kept)];
            *height = setting.place + kept;
        }
    }
    Heights {
        surface: Surface {
            layout: bundles.layout.clone(),
            heights: corners,
        },
        limited,
        wanted: (wanted[0], wanted[1]),
        range: (range[0], range[1]),
        relief_range,
        thorns,
    }
}

/// Greatest height below zero and above it.
fn extremes(corners: &[[f64; 3]]) -> (f64, f64) {
    let all = || corners.iter().flatten().copied();
    (-all().fold(0.0, f64::min), all().fold(0.0, f64::max))
}

/// Height between the 5th and the 95th hundredth of the corners.
fn relief_range(corners: &[[f64; 3]]) -> f64 {
    let mut sorted: Vec<f64> = corners.iter().flatten().copied().collect();
    if sorted.is_empty() {
        return 0.0;
    }
    let mut hundredth = |part: f64| {
        let i = (part * (sorted.len() - 1) as f64) as usize;
        sorted.select_nth_unstable_by(i, f64::total_cmp);
        sorted[i]
    };
    let low = hundredth(0.05);
    hundredth(0.95) - low
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
