//! Solvers that go from step to step, all of one length.

use super::solver::{AdvanceReport, Solver};
use crate::contact::Contacts;
use crate::error::SolverError;
use crate::parallel::in_pool;
use crate::world::World;
use greenstick_geometry::Context;

/// A solver that goes from step to step, all of one length.
pub(crate) trait Stepwise: Send {
    /// The name that [`Solver::name`] returns.
    const NAME: &'static str;
    /// The step where none is given, s.
    const DEFAULT_STEP: f64;

    /// Returns the step that was given, s.
    fn given(&self) -> Option<f64>;

    /// Takes a step of `dt` seconds and adds to the report what it did. Where it fails, world and contacts are as before.
    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut AdvanceReport,
        context: &Context,
    ) -> Result<(), SolverError>;
}

impl<T: Stepwise> Solver for T {
    fn name(&self) -> &'static str {
        T::NAME
    }

    fn step(&mut self, _: &World, _: &Context) -> Result<f64, SolverError> {
        given_step(self.given(), T::DEFAULT_STEP)
    }

    fn advance(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        duration: f64,
        context: &Context,
    ) -> Result<AdvanceReport, SolverError> {
        let step = self.step(world, context)?;
        in_pool(|| {
            check_duration(duration)?;
            world.check()?;
            let mut report = AdvanceReport {
                limit: f64::INFINITY,
                ..AdvanceReport::default()
            };
            if duration == 0.0 {
                return Ok(report);
            }
            let count = (duration / step - 1e-9).ceil().max(1.0);
            let (start, dt) = (world.state.time, duration / count);
            report.step = dt;
            for k in 1..=count as u64 {
                context.report((k - 1) as f64 / count)?;
                self.one_step(world, contacts, dt, &mut report, context)?;
                world.state.time = start + dt * k as f64;
            }
            world.state.time = start + duration;
            Ok(report)
        })
    }
}

/// Checks a duration to advance by.
pub(super) fn check_duration(duration: f64) -> Result<(), SolverError> {
    if duration >= 0.0 && duration.is_finite() {
        return Ok(());
    }
    Err(SolverError::Value {
        what: "the time to advance by (s)",
        value: duration,
        right: "0 or more and finite",
    })
}

/// Returns the given step or the default, s.
pub(super) fn given_step(given: Option<f64>, default: f64) -> Result<f64, SolverError> {
    match given {
        None => Ok(default),
        Some(given) if given > 0.0 && given.is_finite() => Ok(given),
        Some(given) => Err(SolverError::Value {
            what: "the step (s)",
            value: given,
            right: "above 0 and finite",
        }),
    }
}
