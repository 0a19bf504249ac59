//! What a field of heights says at a bundle, in the place of the parameters' own shape or over it.

use super::{LargeShape, TornRelief};
use crate::ends::TornEnd;
use crate::field::{HeightField, LocalFailure};
use crate::height_model::NoiseSamplers;
use crate::layout::FibreBundle;

/// How much of a field's height a bundle has from the middle of its sliver; the rest is that at its own place. With 1, slivers
/// would be terraces wherever the field slopes; with 0, steps of the field would cut through slivers.
const SLIVER_SHARE: f64 = 0.85;

impl TornRelief<'_> {
    /// Returns a field's height, radii, at a bundle, and how its sliver failed.
    pub(super) fn of_field(
        &self,
        field: &HeightField,
        noises: &mut NoiseSamplers,
        (end, bundle): (&TornEnd, &FibreBundle),
    ) -> (f64, Option<LocalFailure>) {
        // The middle of the sliver, at the angle that wanders to that of its ray.
        let (ring, ray) = self.ends.slivers.middle(end.sliver as usize);
        let ring = ring.min(1.0);
        let ray = 2.0 * ray - self.ends.ray_angle(noises, ring, ray);
        let own = field.at(bundle.rho.min(1.0), bundle.phi);
        let shared = field.at(ring, ray);
        let level = (own + (shared - own) * SLIVER_SHARE) / self.model.site.radius;
        (level, field.failure_at(ring, ray))
    }

    /// Returns a shape with a field added to it.
    pub(super) fn with_added(
        &self,
        shape: LargeShape,
        added: &HeightField,
        noises: &mut NoiseSamplers,
        at: (&TornEnd, &FibreBundle),
    ) -> LargeShape {
        let (level, failure) = self.of_field(added, noises, at);
        let (torn, splintering) = failure.map_or((1.0, 1.0), |f| (f.torn, f.splintering));
        // What splinters farther than the parameters say was not crushed there.
        let freed = (splintering - 1.0).clamp(0.0, 1.0);
        LargeShape {
            level: shape.level + level,
            split: shape.split * (1.0 - freed),
            tilt: shape.tilt,
            torn: (shape.torn + (1.0 - shape.torn) * freed) * torn,
            relief: shape.relief * splintering,
            runs_out: shape.runs_out,
            slabs: shape.slabs,
            thorns: shape.thorns * torn * splintering,
        }
    }
}
