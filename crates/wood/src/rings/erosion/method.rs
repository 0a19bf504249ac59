//! Which published erosion makes the rings of a section (Forests 2023 §3.3), and its fronts at a resolution.

use super::both_sides::{ErodedPasses, PixelCircle, erode_from_both_sides};
use super::passes::{NOT_ERODED, erosion_passes};
use super::schedule::KernelSchedule;
use glam::DVec2;
use greenstick_geometry::{Bitmap, Cancelled, Context};
use std::fmt;

/// An erosion of sections.
#[derive(Debug, Clone, PartialEq)]
pub struct Erosion {
    /// Its kernels.
    pub schedule: ErosionSchedule,
    /// Radius of a circle about the pith, in mean radii of the section (above 0, below 1), from which a second front runs
    /// outwards: Fig. 7. `None`: only the front from the contour runs inwards.
    pub inner_circle: Option<f64>,
}

/// An order of kernels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ErosionSchedule {
    /// Every pass takes a pixel: Fig. 5 and Table 1.
    Alternating,
    /// Rings of different widths, from the bark inwards: Fig. 6, made for 256 pixels and widened for twice as many.
    Figure6,
    /// Faster from the side of positive x than from the other: Fig. 8, which gives no numbers. Made for 256 pixels as well.
    Eccentric,
    /// A custom list of kernels, in pixels of any resolution.
    Kernels(KernelSchedule),
}

/// An inner circle that does not lie inside the section.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("an inner circle of {0} mean radii; expected more than 0 and less than 1")]
pub struct InnerCircleError(f64);

/// Resolution for which Fig. 6 gives its kernels, and for which those of Fig. 8 are chosen.
const SCHEDULE_RESOLUTION: usize = 256;

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
    /// The fronts of this erosion in bitmaps of `resolution` × `resolution` pixels.
    ///
    /// # Errors
    /// [`InnerCircleError`] where the inner circle is out of range.
    pub fn fronts(&self, resolution: usize) -> Result<ErosionFronts, InnerCircleError> {
        let factor = (resolution / SCHEDULE_RESOLUTION).max(1) as u32;
        let schedule = match &self.schedule {
            ErosionSchedule::Alternating => KernelSchedule::one_pixel_per_pass(),
            ErosionSchedule::Figure6 => KernelSchedule::figure_6().scaled(factor),
            ErosionSchedule::Eccentric => KernelSchedule::eccentric().scaled(factor),
            ErosionSchedule::Kernels(schedule) => schedule.clone(),
        };
        if let Some(share) = self.inner_circle
            && !(share > 0.0 && share < 1.0)
        {
            return Err(InnerCircleError(share));
        }
        Ok(ErosionFronts {
            outward: self.inner_circle.map(|share| OutwardFront {
                schedule: schedule.clone().for_outward_front(),
                circle_share: share,
            }),
            inward: schedule,
        })
    }
}

/// The fronts that run through a section and leave rings behind.
#[derive(Debug, Clone, PartialEq)]
pub struct ErosionFronts {
    inward: KernelSchedule,
    outward: Option<OutwardFront>,
}

/// The front from a circle about the pith.
#[derive(Debug, Clone, PartialEq)]
struct OutwardFront {
    schedule: KernelSchedule,
    /// Radius of the circle over the section's mean one.
    circle_share: f64,
}

impl ErosionFronts {
    /// Erodes a section. The pith is in pixels, the middle of pixel (0, 0) at the origin; `mean_radius` is that of the
    /// section, in pixels.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn passes(
        &self,
        map: &Bitmap,
        pith: DVec2,
        mean_radius: f64,
        context: &Context,
    ) -> Result<ErodedPasses, Cancelled> {
        let Some(outward) = &self.outward else {
            let passes = erosion_passes(map, &self.inward, context)?;
            let taken = passes.iter().copied().filter(|&p| p < NOT_ERODED);
            let last = usize::from(taken.max().unwrap_or(0));
            let parts = (1..=last).map(|n| self.inward.pass(n).part).collect();
            return Ok(ErodedPasses { passes, parts });
        };
        let circle = PixelCircle {
            centre: pith,
            radius: outward.circle_share * mean_radius,
        };
        erode_from_both_sides(map, &self.inward, &outward.schedule, circle, context)
    }
}
