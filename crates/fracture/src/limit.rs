//! Placing heights along the stem, within what is free of it and within the wedge that a bend opens.

use crate::heights::{Heights, Setting};
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

/// What placing heights finds out.
struct Placed<'a> {
    setting: &'a Setting,
    /// Lengths free below and above the place, m.
    free: (f64, f64),
    /// Greatest heights below and above zero, m; only of use in a wedge.
    greatest: (f64, f64),
    wanted: (f64, f64),
    range: (f64, f64),
}

impl<'a> Placed<'a> {
    fn new(setting: &'a Setting, heights: impl Iterator<Item = f64>) -> Self {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut lowest, mut highest) = (0.0f64, 0.0f64);
        if setting.wedge.is_some() {
            for h in heights {
                (lowest, highest) = (lowest.min(h), highest.max(h));
            }
        }
        Placed {
            setting,
            free: (
                setting.place - setting.usable.0,
                setting.usable.1 - setting.place,
            ),
            greatest: (-lowest * setting.radius, highest * setting.radius),
            wanted: none,
            range: none,
        }
    }

    /// Places a height (in radii) over a place of the section; whether it had to be limited.
    #[inline]
    fn place(&mut self, height: &mut f64, at: DVec2) -> bool {
        let setting = self.setting;
        let mut h = *height * setting.radius;
        if let Some(w) = &setting.wedge {
            let far = (at.dot(w.toward) - w.from).max(0.0);
            h = w.within(h, far, self.greatest, setting.radius) + OFF_LEVEL * setting.radius;
        }
        self.wanted = (self.wanted.0.min(h), self.wanted.1.max(h));
        let kept = bent(h, self.free.0, self.free.1);
        self.range = (self.range.0.min(kept), self.range.1.max(kept));
        *height = setting.place + kept;
        kept != h
    }
}

/// Places heights (in radii) over places of the section (`at`, m) along the axis and bends those that would leave the
/// stem back into it, keeping their order. `corners` are the numbers of the heights at the corners of each facet.
pub(crate) fn place(
    bundles: &Bundles,
    mut heights: Vec<f64>,
    at: impl Iterator<Item = DVec2>,
    corners: &[[u32; 3]],
    setting: &Setting,
) -> Heights {
    let mut placed = Placed::new(setting, heights.iter().copied());
    let mut bent = Vec::new();
    for (i, (height, at)) in heights.iter_mut().zip(at).enumerate() {
        if placed.place(height, at) {
            bent.push(i as u32);
        }
    }
    let limited = if bent.is_empty() {
        0
    } else {
        let numbers = corners.iter().flatten();
        numbers.filter(|&n| bent.binary_search(n).is_ok()).count()
    };
    Heights {
        surface: Surface {
            layout: bundles.layout.clone(),
            heights: corners
                .iter()
                .map(|f| f.map(|n| heights[n as usize]))
                .collect(),
        },
        limited,
        wanted: placed.wanted,
        range: placed.range,
        thorns: Vec::new(),
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
