//! An estimate of where the pith of a round section lies: its centroid.
//!
//! The outline shows little of it: it is the sum of all years, and has lost the shape of the first ones. On eleven sections
//! whose pith is known (pine, Douglas fir, a shrub) the centroid errs by 8.6 % of the radius on average. A guess towards the
//! pointed end of the outline, which was fitted to three of them, erred by 8.7 %: better on those three (7.0 for 8.7 %), worse
//! on the other eight (9.4 for 8.6 %). A known pith should be given.

use crate::polygon;
use glam::DVec2;

/// Root mean square distance of the pith from a section's centroid, in radii of the circle of equal area: over eleven
/// sections, where it ranges from 0.02 to 0.20.
pub const PITH_OFFSET_RMS: f64 = 0.10;

/// Estimates the pith of a section with the closed `outline`, in its units: the centroid, whose distance from the pith is
/// [`PITH_OFFSET_RMS`] radii on average. It lies inside, and not close to the outline, where there is such a point.
///
/// ```
/// use glam::DVec2;
/// use greenstick_wood::rings::estimate_pith;
///
/// let outline = [DVec2::ZERO, DVec2::new(2.0, 0.0), DVec2::new(2.0, 2.0), DVec2::new(0.0, 2.0)];
/// assert_eq!(estimate_pith(&outline), DVec2::ONE);
/// ```
pub fn estimate_pith(outline: &[DVec2]) -> DVec2 {
    let (_, centroid) = polygon::area_and_centroid(outline);
    let thin = polygon::thinned(outline, 400);
    let (centre, depth) = polygon::largest_inscribed_circle(outline);
    if polygon::contains(&thin, centroid) && polygon::distance(&thin, centroid) > 0.3 * depth {
        centroid
    } else {
        centre
    }
}
