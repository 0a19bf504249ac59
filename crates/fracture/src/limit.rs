//! Placing heights along the stem, within what is free of it and within the wedge that a bend opens.

use crate::height_model::{BreakSite, Heights};
use crate::layout::FibreBundles;
use crate::surface::FractureSurface;
use crate::wedge::{UNLIMITED_SHARE, limited_height};
use glam::DVec2;

/// Height of the edge of a wedge, and of a level face, over the location of the break, in radii. At the location itself the skin has a level of the
/// grain, and a face in that plane would meet the skin in edges instead of crossing it.
const OFF_LEVEL: f64 = 2.3e-4;

/// Part of the heights of a side, from the least on, that keep their proportions where not all have room: those beyond are
/// few enough to look like tips that lie close together.
const KEPT_IN_PROPORTION: f64 = 0.97;

/// How far a face may be moved along the stem so that its heights have room, in radii.
const MAX_MOVE: f64 = 0.93;

/// Maps heights to lengths along the axis and gathers what it finds.
struct HeightPlacer<'a> {
    site: &'a BreakSite,
    /// How far the face is moved up from the location of the break, m.
    moved: f64,
    /// Lengths free below and above it then, m.
    free: (f64, f64),
    /// Factors on heights below and above zero that bring them into what is free.
    scales: (f64, f64),
    /// Greatest heights below and above zero after scaling, m.
    greatest: (f64, f64),
    wanted: (f64, f64),
    range: (f64, f64),
}

impl<'a> HeightPlacer<'a> {
    /// `is_drawn`: whether the heights are drawn, so that they may be moved, not those of a certain place.
    fn new(site: &'a BreakSite, heights: &[f64], is_drawn: bool) -> Self {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let extremes = |(low, high): (f64, f64), &h: &f64| (low.min(h), high.max(h));
        let (lowest, highest) = heights.iter().fold((0.0, 0.0), extremes);
        let reach = (-lowest * site.radius, highest * site.radius);
        let free = (site.place - site.usable.0, site.usable.1 - site.place);
        let below = heights.iter().filter(|&&h| h < 0.0);
        let above = heights.iter().filter(|&&h| h > 0.0);
        let needed = (
            needed(below.map(|h| -h * site.radius), reach.0, free.0),
            needed(above.map(|h| h * site.radius), reach.1, free.1),
        );
        let moved = if is_drawn && site.wedge.is_none() {
            let most = MAX_MOVE * site.radius;
            move_to_room(needed, free).clamp(-most, most)
        } else {
            0.0
        };
        let free = (free.0 + moved, free.1 - moved);
        let scale = |needed: f64, free: f64| (free / needed.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let scales = (scale(needed.0, free.0), scale(needed.1, free.1));
        HeightPlacer {
            site,
            moved,
            free,
            scales,
            greatest: (reach.0 * scales.0, reach.1 * scales.1),
            wanted: none,
            range: none,
        }
    }

    /// Maps a height (radii) over a point of the section to its length along the axis. Returns whether it was limited.
    #[inline]
    fn place(&mut self, height: &mut f64, at: DVec2) -> bool {
        let site = self.site;
        let mut h = *height * site.radius;
        self.wanted = (self.wanted.0.min(h), self.wanted.1.max(h));
        h *= if h < 0.0 {
            self.scales.0
        } else {
            self.scales.1
        };
        if let Some(w) = &site.wedge {
            let far = (at.dot(w.toward) - w.from).max(0.0);
            h = w.within(h, far, self.greatest, site.radius) + OFF_LEVEL * site.radius;
        } else if h == 0.0 {
            h = OFF_LEVEL * site.radius;
        }
        let limited = limited_height(h, self.free.0, self.free.1);
        let height_there = self.moved + limited;
        self.range = (
            self.range.0.min(height_there),
            self.range.1.max(height_there),
        );
        *height = site.place + height_there;
        limited != h
    }
}

/// Returns the length that the heights of one side (m, positive; `reach` the greatest) need, so that limiting leaves all but
/// the highest few alone.
fn needed(heights: impl Iterator<Item = f64>, reach: f64, free: f64) -> f64 {
    if reach <= (UNLIMITED_SHARE * free).max(0.0) {
        return reach / UNLIMITED_SHARE;
    }
    let mut heights: Vec<f64> = heights.collect();
    let i = (KEPT_IN_PROPORTION * (heights.len() - 1) as f64) as usize;
    let (_, high, _) = heights.select_nth_unstable_by(i, f64::total_cmp);
    *high / UNLIMITED_SHARE
}

/// Returns how far up a face is moved so that what it needs below and above fits, or falls short by the same factor.
fn move_to_room(needed: (f64, f64), free: (f64, f64)) -> f64 {
    let missing = (needed.0 - free.0, needed.1 - free.1);
    if missing.0 <= 0.0 && missing.1 <= 0.0 {
        return 0.0;
    }
    let even = (free.1 * needed.0 - free.0 * needed.1) / (needed.0 + needed.1);
    if even < 0.0 {
        even.max(-missing.1)
    } else {
        even.min(missing.0)
    }
}

/// Maps heights (radii) over points of the section (`at`, m) to lengths along the axis. Heights that would leave the stem are
/// scaled and limited, in their order. `corners` are the numbers of the heights at the corners of each facet.
pub(crate) fn place_heights(
    bundles: &FibreBundles,
    mut heights: Vec<f64>,
    at: impl Iterator<Item = DVec2>,
    corners: &[[u32; 3]],
    site: &BreakSite,
    is_drawn: bool,
) -> Heights {
    let mut placed = HeightPlacer::new(site, &heights, is_drawn);
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
        scales: placed.scales,
        moved: placed.moved,
        wanted: placed.wanted,
        range: placed.range,
        thorns: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heights of 0 to 100 mm on a stem with 20 mm free above: they lie over all of it, the longest 3 % close together.
    #[test]
    fn heights_that_have_no_room_keep_their_proportions() {
        let site = BreakSite {
            radius: 0.01,
            place: 0.5,
            usable: (0.0, 0.52),
            pith: DVec2::ZERO,
            wedge: None,
            relief: 1.0,
        };
        let drawn: Vec<f64> = (0..=1000).map(|i| 0.01 * f64::from(i)).collect();
        let mut placer = HeightPlacer::new(&site, &drawn, false);
        let mut placed = drawn.clone();
        let limited = placed
            .iter_mut()
            .filter_map(|h| placer.place(h, DVec2::ZERO).then_some(()));
        assert_eq!(limited.count(), 30);
        assert!(placed.is_sorted_by(|a, b| a < b));
        assert_eq!(placer.scales.0, 1.0);
        let (half, most) = (placed[485] - 0.5, placed[970] - 0.5);
        assert!((most - UNLIMITED_SHARE * 0.02).abs() < 1e-12, "{most}");
        assert!((half / most - 0.5).abs() < 1e-12, "{half}");
        assert!(placed[1000] < 0.52);
        // A drawn face moves down as far as it may, where there is room.
        let moved = HeightPlacer::new(&site, &drawn, true);
        assert!((moved.moved + MAX_MOVE * 0.01).abs() < 1e-15);
        assert!((moved.scales.1 / placer.scales.1 - (1.0 + MAX_MOVE * 0.5)).abs() < 1e-9);
        // What fits is left alone.
        let roomy = BreakSite {
            usable: (0.0, 1.0),
            ..site
        };
        assert_eq!(HeightPlacer::new(&roomy, &drawn, true).scales, (1.0, 1.0));
    }

    #[test]
    fn a_face_is_moved_until_it_fits_or_falls_short_evenly() {
        assert_eq!(move_to_room((1.0, 2.0), (1.0, 2.0)), 0.0);
        assert_eq!(move_to_room((1.0, 2.0), (3.0, 1.5)), -0.5);
        assert_eq!(move_to_room((2.0, 1.0), (1.5, 3.0)), 0.5);
        assert_eq!(move_to_room((2.0, 2.0), (2.0, 1.0)), -0.5);
        assert_eq!(move_to_room((2.0, 2.0), (1.0, 1.0)), 0.0);
    }
}
