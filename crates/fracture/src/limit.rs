//! Placing heights along the stem, within what is free of it and within the wedge that a bend opens.

use crate::height_model::{Heights, Setting};
use crate::layout::FibreBundles;
use crate::surface::FractureSurface;
use crate::wedge::bent;
use glam::DVec2;

/// How far above the place of the break, in radii, the edge of a wedge lies: at the place itself the skin has a level of
/// the grain, and a face in that plane would meet it in edges instead of crossing it.
const OFF_LEVEL: f64 = 2.3e-4;

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
    bundles: &FibreBundles,
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
        surface: FractureSurface {
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
