//! The test itself.

use super::error::FractureError;
use super::outcome::{Evaluation, FractureOutcome, FracturePoint};
use super::rig::Rig;
use super::specimen::{FractureTest, FractureTestKind};
use super::theory::BeamTheory;
use crate::placement::WoodMaterial;
use greenstick_geometry::Context;

/// Load steps up to the deflection at which the crack of beam theory begins to grow, as long as nothing softens.
const STEPS_TO_GROWTH: f64 = 20.0;
/// The test ends at this multiple of beam theory's deflection at the end of the growth.
const MAX_DEFLECTION_RATIO: f64 = 3.0;
/// A notched beam is broken through when it bears this fraction of its largest load. It is given up at this multiple of the
/// deflection at which the crack of beam theory begins to grow.
const REST_LOAD: f64 = 0.01;
const MAX_NOTCHED_DEFLECTION_RATIO: f64 = 60.0;
/// Fraction of the work that is done when the crack begins to grow. It serves only the progress.
const PROGRESS_AT_GROWTH: f64 = 0.3;

impl FractureTest {
    /// Runs the test on `wood`, which is everywhere alike.
    ///
    /// # Errors
    /// [`FractureError`].
    pub fn run(
        &self,
        wood: &WoodMaterial,
        context: &Context,
    ) -> Result<FractureOutcome, FractureError> {
        self.check()?;
        let mut rig = Rig::new(self, wood, &context.silenced())?;
        let theory = BeamTheory::new(self, wood);
        let put_in = self.energy_put_in(wood);
        let deflection = |crack: f64| theory.load(put_in, crack) * theory.compliance(crack);
        let (start, edge) = (rig.division.crack(), rig.division.edge);
        let onset = deflection(start);
        let elastic_step = onset / STEPS_TO_GROWTH;
        let growth_step = elastic_step.min(onset * self.steady_step() * edge / start);
        let farthest = match self.kind {
            FractureTestKind::SingleEdgeNotchedBeam => MAX_NOTCHED_DEFLECTION_RATIO * onset,
            _ => MAX_DEFLECTION_RATIO * deflection(start + self.growth).max(onset),
        };
        let mut last = FracturePoint {
            crack: start,
            zone_end: start,
            ..FracturePoint::default()
        };
        let (mut points, mut maximum) = (vec![last], last);
        while !self.is_over(&last, &maximum, start) && last.deflection < farthest {
            let grown = ((last.crack - start) / self.growth).min(1.0);
            let loaded = (last.deflection / onset).min(1.0);
            let rest = 1.0 - PROGRESS_AT_GROWTH;
            context.report(PROGRESS_AT_GROWTH * loaded + rest * grown)?;
            let softens = last.zone_end > start;
            let step = if softens { growth_step } else { elastic_step };
            let target = rig.world.state.time + step;
            last = rig.advance(&last, target, context)?;
            points.push(last);
            if last.load > maximum.load {
                maximum = last;
            }
        }
        let evaluation = Evaluation::new(self, &theory, &points, start)?;
        Ok(FractureOutcome {
            points,
            put_in,
            roughness: rig.section.roughness(),
            energy_by_work: evaluation.energy_by_work,
            steady: evaluation.steady,
            compliance: evaluation.compliance,
            maximum: evaluation.maximum,
            process_zone: evaluation.process_zone,
            dissipated_beside: rig.dissipated_beside() / last.dissipated_by_bonds,
            rods: rig.section.rods.len(),
            slice: rig.section.width,
            edge,
        })
    }

    /// Whether the test is over at the last point of those of which one has the largest load. `start` is the crack at the start, m.
    pub(super) fn is_over(
        &self,
        last: &FracturePoint,
        maximum: &FracturePoint,
        start: f64,
    ) -> bool {
        match self.kind {
            FractureTestKind::SingleEdgeNotchedBeam => {
                last.crack > start && last.load <= REST_LOAD * maximum.load
            }
            _ => last.crack >= start + self.growth,
        }
    }

    /// Returns the relative change of deflection that lets the crack grow by about half of its relative change.
    fn steady_step(&self) -> f64 {
        match self.kind {
            // The deflection grows with the square of the crack.
            FractureTestKind::DoubleCantileverBeam => 1.0,
            // It hardly grows where the crack begins to be stable.
            FractureTestKind::EndNotchedFlexure => 0.4,
            FractureTestKind::SingleEdgeNotchedBeam => 1.0,
        }
    }

    /// Returns the energy of fracture that the wood has in the mode of the test, J/m².
    fn energy_put_in(&self, wood: &WoodMaterial) -> f64 {
        match self.kind {
            FractureTestKind::EndNotchedFlexure => wood.shear_fracture_energy(),
            _ => wood.fracture_energy,
        }
    }
}
