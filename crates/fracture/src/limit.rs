//! Placing heights along the stem, within what is free of it and within the wedge that a bend opens.

use crate::height_model::{BreakSite, Heights};
use crate::layout::FibreBundles;
use crate::surface::FractureSurface;
use crate::wedge::limited_height;
use glam::DVec2;

/// Height of the edge of a wedge, and of a level face, over the location of the break, in radii. At the location itself the skin has a level of the
/// grain, and a face in that plane would meet the skin in edges instead of crossing it.
const OFF_LEVEL: f64 = 2.3e-4;

/// Maps heights to lengths along the axis and gathers what it finds.
struct HeightPlacer<'a> {
    site: &'a BreakSite,
    /// Lengths free below and above the location of the break, m.
    free: (f64, f64),
    /// Greatest heights below and above zero, m; needed in a wedge only.
    greatest: (f64, f64),
    wanted: (f64, f64),
    range: (f64, f64),
}

impl<'a> HeightPlacer<'a> {
    fn new(site: &'a BreakSite, heights: impl Iterator<Item = f64>) -> Self {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut lowest, mut highest) = (0.0f64, 0.0f64);
        if site.wedge.is_some() {
            for h in heights {
                (lowest, highest) = (lowest.min(h), highest.max(h));
            }
        }
        HeightPlacer {
            site,
            free: (site.place - site.usable.0, site.usable.1 - site.place),
            greatest: (-lowest * site.radius, highest * site.radius),
            wanted: none,
            range: none,
        }
    }

    /// Maps a height (radii) over a point of the section to its length along the axis. Returns whether it was limited.
    #[inline]
    fn place(&mut self, height: &mut f64, at: DVec2) -> bool {
        let site = self.site;
        let mut h = *height * site.radius;
        if let Some(w) = &site.wedge {
            let far = (at.dot(w.toward) - w.from).max(0.0);
            h = w.within(h, far, self.greatest, site.radius) + OFF_LEVEL * site.radius;
        } else if h == 0.0 {
            h = OFF_LEVEL * site.radius;
        }
        self.wanted = (self.wanted.0.min(h), self.wanted.1.max(h));
        let limited = limited_height(h, self.free.0, self.free.1);
        self.range = (self.range.0.min(limited), self.range.1.max(limited));
        *height = site.place + limited;
        limited != h
    }
}

/// Maps heights (radii) over points of the section (`at`, m) to lengths along the axis. Heights that would leave the stem are
/// brought back into it in their order. `corners` are the numbers of the heights at the corners of each facet.
pub(crate) fn place_heights(
    bundles: &FibreBundles,
    mut heights: Vec<f64>,
    at: impl Iterator<Item = DVec2>,
    corners: &[[u32; 3]],
    site: &BreakSite,
) -> Heights {
    let mut placed = HeightPlacer::new(site, heights.iter().copied());
    let mut limited_heights = Vec::new();
    for (i, (height, at)) in heights.iter_mut().zip(at).enumerate() {
        if placed.place(height, at) {
            limited_heights.push(i as u32);
        }
    }
    let limited = if limited_heights.is_empty() {
        0
    } else {
        let numbers = corners.iter().flatten();
        numbers
            .filter(|&n| limited_heights.binary_search(n).is_ok())
            .count()
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
