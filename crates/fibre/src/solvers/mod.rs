//! Solvers that look for equilibrium: of one time step, or of a load step.
//!
//! | module | what is in it |
//! |---|---|
//! | [`matrix`] | sparse symmetric matrices in an envelope, and their Cholesky factors |
//! | `direct` | linear systems with a factor that is kept |
//! | `iterative` | linear systems by conjugate gradients, with rods (`lines`) and sections (`sections`) solved exactly |
//! | `band`, `strings` | rods made linear, as blocks of the matrix and without one |
//! | `grips` | [`Grip`]: springs on the mean displacement of some vertices |
//! | [`newton`] | Newton's method on all energies, loads and inertia, with yielding and grips |
//! | [`implicit`] | [`Implicit`]: time steps of animation at real stiffness |
//! | [`interactive`] | [`Interactive`]: a step a picture |
//! | [`quasi_static`] | [`QuasiStatic`]: load steps to equilibrium, and breaks one by one |

mod band;
mod direct;
mod grips;
pub mod implicit;
pub mod interactive;
mod iterative;
mod lines;
pub mod matrix;
pub mod newton;
pub mod quasi_static;
mod sections;
mod strings;
mod swing;

pub use grips::Grip;
pub use implicit::Implicit;
pub use interactive::Interactive;
pub use quasi_static::QuasiStatic;

use crate::error::SolverError;
use crate::solver::{Advance, Contacts, Solver, World};

/// Work that is compiled for the widest registers there are.
struct Wide<F>(F);

impl<R, F: FnMut() -> R> pulp::WithSimd for Wide<F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) -> R {
        (self.0)()
    }
}

/// Does `work` with the widest registers there are. Only what is always inlined takes part: mark the closure itself too. (A
/// closure that is handed to `pulp` as it is gets called through a function that is compiled for every processor.)
#[inline(always)]
fn wide<R>(work: impl FnMut() -> R) -> R {
    pulp::Arch::new().dispatch(Wide(work))
}

/// Does `work` on a thread of the pool.
pub(crate) fn in_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    rayon::join(work, || ()).0
}

/// A solver that goes from step to step, all of one length.
pub(crate) trait Stepwise: Send {
    /// As of [`Solver::name`].
    const NAME: &'static str;
    /// The step where none is given, s.
    const USUAL: f64;

    /// The step that was given, s.
    fn given(&self) -> Option<f64>;

    /// Takes a step of `dt` seconds and adds to the report what it did.
    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut Advance,
    ) -> Result<(), SolverError>;
}

impl<T: Stepwise> Solver for T {
    fn name(&self) -> &'static str {
        T::NAME
    }

    fn step(&mut self, _: &World) -> Result<f64, SolverError> {
        given_step(self.given(), T::USUAL)
    }

    fn advance(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        duration: f64,
    ) -> Result<Advance, SolverError> {
        let step = self.step(world)?;
        // In the pool from here on: to enter it from outside for each piece of work costs more than the piece.
        in_pool(|| {
            advance_evenly(world, duration, step, |world, dt, report| {
                self.one_step(world, contacts, dt, report)
            })
        })
    }
}

/// Checks a duration to advance by.
fn check_duration(duration: f64) -> Result<(), SolverError> {
    if duration >= 0.0 && duration.is_finite() {
        return Ok(());
    }
    Err(SolverError::Value {
        what: "the time to advance by (s)",
        value: duration,
        right: "0 or more and finite",
    })
}

/// A step that was given, or the usual one, s.
fn given_step(given: Option<f64>, usual: f64) -> Result<f64, SolverError> {
    match given {
        None => Ok(usual),
        Some(given) if given > 0.0 && given.is_finite() => Ok(given),
        Some(given) => Err(SolverError::Value {
            what: "the step (s)",
            value: given,
            right: "above 0 and finite",
        }),
    }
}

/// Advances in whole steps of equal length, no longer than `step`.
fn advance_evenly(
    world: &mut World,
    duration: f64,
    step: f64,
    mut one: impl FnMut(&mut World, f64, &mut Advance) -> Result<(), SolverError>,
) -> Result<Advance, SolverError> {
    check_duration(duration)?;
    world.check()?;
    let mut report = Advance {
        limit: f64::INFINITY,
        ..Advance::default()
    };
    if duration == 0.0 {
        return Ok(report);
    }
    let count = (duration / step - 1e-9).ceil().max(1.0);
    let (start, dt) = (world.state.time, duration / count);
    report.step = dt;
    for k in 1..=count as u64 {
        one(world, dt, &mut report)?;
        world.state.time = start + dt * k as f64;
    }
    world.state.time = start + duration;
    Ok(report)
}
