//! When a stem began to be eccentric, from points on its rings.

use super::field::RingField;
use super::section::SectionRingError;
use glam::DVec2;
use greenstick_geometry::Context;
use std::ops::RangeInclusive;

/// Onsets of eccentricity that are tried, as ring coordinates.
pub const ONSET_RANGE: RangeInclusive<f64> = 0.0..=0.9;
/// Spread of onsets from tree to tree about the usual one, as a standard deviation: that of eleven annotated sections.
const ONSET_SPREAD: f64 = 0.2;
/// Standard deviation of a point from the model's ring, as a share of its radius: what bumps and wedges leave.
const POINT_ERROR: f64 = 0.03;
/// Points of a ring beyond this number tell nothing new: their deviations are those of the same few bumps.
const INDEPENDENT_POINTS: f64 = 6.0;
/// Onsets tried over the whole range, and halvings of that step about the best.
const TRIALS: usize = 24;
const HALVINGS: usize = 5;

impl RingField {
    /// Fits the onset of eccentricity to points on `rings` of a section: the points of one ring should have one ring
    /// coordinate. Returns the most probable one (maximum a posteriori), which is the usual one of such an outline where the points
    /// do not decide, as on a stem that is hardly eccentric; `None` where no ring has two points.
    ///
    /// # Errors
    /// [`SectionRingError`] where the outline or the pith is not sound, or the caller cancelled.
    pub fn fit_eccentricity_onset(
        outline: &[DVec2],
        pith: DVec2,
        rings: &[&[DVec2]],
        context: &Context,
    ) -> Result<Option<f64>, SectionRingError> {
        if rings.iter().all(|ring| ring.len() < 2) {
            return Ok(None);
        }
        let field = |onset| RingField::with_eccentricity_onset(outline, pith, onset);
        let usual = field(None)?.eccentricity_onset().unwrap_or_default();
        let misfit = |onset: f64| -> Result<f64, SectionRingError> {
            context.check()?;
            let field = field(Some(onset))?;
            let unusual = (onset - usual) / ONSET_SPREAD;
            let missed: f64 = rings.iter().map(|ring| field.spread(ring)).sum();
            Ok(missed / (POINT_ERROR * POINT_ERROR) + unusual * unusual)
        };
        let (low, high) = (*ONSET_RANGE.start(), *ONSET_RANGE.end());
        let mut step = (high - low) / TRIALS as f64;
        let mut best = (f64::INFINITY, low);
        for i in 0..=TRIALS {
            let at = low + step * i as f64;
            let here = misfit(at)?;
            if here < best.0 {
                best = (here, at);
            }
        }
        for _ in 0..HALVINGS {
            step /= 2.0;
            for at in [best.1 - step, best.1 + step] {
                let at = at.clamp(low, high);
                let here = misfit(at)?;
                if here < best.0 {
                    best = (here, at);
                }
            }
        }
        Ok(Some(best.1))
    }

    /// Sum of squares of the differences between the ring coordinates of points and their mean, in shares of the mean; of
    /// many points as much as if they were [`INDEPENDENT_POINTS`].
    fn spread(&self, ring: &[DVec2]) -> f64 {
        if ring.len() < 2 {
            return 0.0;
        }
        let count = ring.len() as f64;
        let coordinates: Vec<f64> = ring.iter().map(|&p| self.address(p).0).collect();
        let mean = coordinates.iter().sum::<f64>() / count;
        let squares = coordinates
            .iter()
            .map(|c| (c / mean.max(1e-9) - 1.0).powi(2));
        squares.sum::<f64>() / count * count.min(INDEPENDENT_POINTS)
    }
}
