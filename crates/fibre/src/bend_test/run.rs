//! The bending test itself.

use super::error::BendError;
use super::flaws::Flaws;
use super::outcome::{BendOutcome, BendPoint, Evaluation};
use super::rig::Rig;
use super::specimen::BendTest;
use crate::error::SolverError;
use crate::placement::WoodMaterial;
use greenstick_geometry::Context;
use greenstick_wood::species::{Species, nominal_bending_strength};

/// Load steps up to the deflection at which a linear beam would have the stress of rupture.
const STEPS_TO_RUPTURE: f64 = 10.0;
/// The test ends at this multiple of the deflection of the linear beam at rupture.
const MAX_DEFLECTION_RATIO: f64 = 12.0;
/// Fraction of the work that is done at the first break. It serves only the progress.
const PROGRESS_AT_FIRST_BREAK: f64 = 0.5;

impl BendTest {
    /// Runs the test on `wood` that is everywhere alike.
    ///
    /// # Errors
    /// [`BendError`].
    pub fn run(&self, wood: &WoodMaterial, context: &Context) -> Result<BendOutcome, BendError> {
        self.run_on((wood, None), None, context)
    }

    /// Runs the test on `wood`, which has the annual rings of a species where one is given, and flaws where there are such.
    pub(super) fn run_on(
        &self,
        (wood, species): (&WoodMaterial, Option<&Species>),
        flaws: Option<&Flaws>,
        context: &Context,
    ) -> Result<BendOutcome, BendError> {
        self.check()?;
        let wood = &wood.at_grain_angle(self.grain_angle);
        let mut rig = Rig::new(self, (wood, species), flaws, &context.silenced())?;
        let strength = nominal_bending_strength(wood.tension, wood.compression);
        let height = self.section.height();
        let linear = strength * self.span * self.span / (6.0 * wood.longitudinal * height);
        let expected = expected_deflection_at_break(wood, linear);
        let mut points = vec![BendPoint::default()];
        let (mut last, mut peak, mut came_apart) = (points[0], 0.0f64, false);
        loop {
            let done = if last.broken() == 0 {
                PROGRESS_AT_FIRST_BREAK * (last.deflection / expected).min(1.0)
            } else {
                let fallen = (1.0 - last.load / peak) / (1.0 - self.end);
                let rest = 1.0 - PROGRESS_AT_FIRST_BREAK;
                PROGRESS_AT_FIRST_BREAK + rest * fallen.clamp(0.0, 1.0)
            };
            context.report(done)?;
            let target = rig.world.state.time + linear / STEPS_TO_RUPTURE;
            last = match rig.advance(&last, target, context) {
                Ok(point) => point,
                // Parts that nothing holds any more have no equilibrium, or none that can be found.
                Err(SolverError::NotConverged { .. }) if last.broken() > 0 => {
                    came_apart = true;
                    break;
                }
                Err(other) => return Err(other.into()),
            };
            points.push(last);
            peak = peak.max(last.load);
            if last.load < self.end * peak || last.deflection > MAX_DEFLECTION_RATIO * linear {
                break;
            }
        }
        let evaluation = Evaluation::new(self, &points, strength);
        Ok(BendOutcome {
            points,
            modulus_of_elasticity: evaluation.modulus_of_elasticity,
            modulus_of_rupture: evaluation.modulus_of_rupture,
            work_to_maximum_load: evaluation.work_to_maximum_load,
            stress_at_first_break: evaluation.stress_at_first_break,
            maximum: evaluation.maximum,
            events: rig.events,
            came_apart,
            rods: rig.rods,
            edge: rig.edge,
        })
    }
}

/// Estimates the deflection at the first break from that of a linear beam at rupture, by the curvatures at the middle of the
/// span, of which the yielded part is a third. It serves only the progress.
fn expected_deflection_at_break(wood: &WoodMaterial, linear: f64) -> f64 {
    const YIELDED_FRACTION: f64 = 1.0 / 3.0;
    let m = (wood.tension / wood.compression).max(1.0);
    // Curvature at rupture, f_t/(E x_t) with x_t = 2 m h/(m + 1)², over that of the linear beam, 2 MOR/(E h).
    let last = wood.compression * (m + 1.0) * (m + 1.0) / 2.0;
    let even = 2.0 * nominal_bending_strength(wood.tension, wood.compression);
    linear * (1.0 + YIELDED_FRACTION * (last / even - 1.0).max(0.0))
}
