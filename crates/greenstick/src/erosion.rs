//! Which published erosion makes the rings of a section (Forests 2023 §3.3), and its fronts.

use glam::DVec2;
use greenstick_geometry::Bitmap;
use greenstick_wood::rings::{self, Circle, Kind, Schedule};
use std::fmt;

/// An erosion of sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Erosion {
    /// Its kernels.
    pub schedule: ErosionSchedule,
    /// Radius of a circle about the pith, in mean radii of the section (above 0, below 1), from which a second front runs
    /// outwards: Fig. 7. `None`: only the contour's runs inwards.
    pub inner_circle: Option<f64>,
}

/// An order of kernels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ErosionSchedule {
    /// Every pass takes a pixel: Fig. 5 and Table 1.
    Alternating,
    /// Rings of different widths, from the bark inwards: Fig. 6, made for 256 pixels and widened for twice as many.
    Figure6,
    /// Twice as fast along the section's x and moved along it: Fig. 8, which gives no numbers.
    Eccentric,
    /// Kernels of one's own, in pixels of any resolution.
    Kernels(Schedule),
}

/// An inner circle that is no part of a section.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("an inner circle of {0} mean radii; expected more than 0 and less than 1")]
pub struct InnerCircleError(f64);

/// Resolution for which Fig. 6 gives its kernels.
const FIGURE_6: usize = 256;

impl fmt::Display for Erosion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.schedule {
            ErosionSchedule::Alternating => write!(f, "erosion, alternating")?,
            ErosionSchedule::Figure6 => write!(f, "erosion, figure 6")?,
            ErosionSchedule::Eccentric => write!(f, "erosion, eccentric")?,
            ErosionSchedule::Kernels(schedule) => write!(f, "erosion, kernels {schedule}")?,
        }
        match self.inner_circle {
            Some(share) => write!(f, ", and from a circle of {share} radii"),
            None => Ok(()),
        }
    }
}

impl Erosion {
    /// The fronts at a resolution.
    pub(crate) fn fronts(&self, resolution: usize) -> Result<Fronts, InnerCircleError> {
        let schedule = match &self.schedule {
            ErosionSchedule::Alternating => Schedule::thinnest(),
            ErosionSchedule::Figure6 => {
                let factor = (resolution / FIGURE_6).max(1) as u32;
                Schedule::figure_6().scaled(factor)
            }
            ErosionSchedule::Eccentric => Schedule::thinnest().eccentric(2, (1, 0)),
            ErosionSchedule::Kernels(schedule) => schedule.clone(),
        };
        if let Some(share) = self.inner_circle
            && !(share > 0.0 && share < 1.0)
        {
            return Err(InnerCircleError(share));
        }
        Ok(Fronts {
            outward: self
                .inner_circle
                .map(|share| (schedule.clone().outwards(), share)),
            inward: schedule,
        })
    }
}

/// What runs through a section and leaves rings behind.
pub(crate) struct Fronts {
    inward: Schedule,
    /// From a circle about the pith, whose radius is a share of the section's mean one.
    outward: Option<(Schedule, f64)>,
}

impl Fronts {
    /// The pass of every pixel of a section, row by row, and the kinds of passes 1 to the last. The pith is in pixels, the
    /// middle of pixel (0, 0) at the origin; the mean radius is that of the section, pixels.
    pub fn passes(&self, map: &Bitmap, pith: DVec2, mean_radius: f64) -> (Vec<u16>, Vec<Kind>) {
        let Some((outward, share)) = &self.outward else {
            let passes = rings::passes(map, &self.inward);
            let taken = passes.iter().copied().filter(|&p| p < rings::NEVER);
            let last = usize::from(taken.max().unwrap_or(0));
            let kinds = (1..=last).map(|n| self.inward.pass(n).kind).collect();
            return (passes, kinds);
        };
        let circle = Circle {
            centre: pith,
            radius: share * mean_radius,
        };
        let made = rings::two_sided(map, &self.inward, outward, circle);
        (made.passes, made.kinds)
    }
}
