//! The interface of all solvers.

use crate::contact::Contacts;
use crate::error::SolverError;
use crate::world::World;
use greenstick_geometry::Context;
use serde::{Deserialize, Serialize};

/// The end of a path of stable equilibria.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Buckling {
    /// Time at which the last stable equilibrium was found, s.
    pub time: f64,
    /// The largest force of a clamp then, N.
    pub load: f64,
    /// The vertex that moves most as the wood buckles, by its number in the unbroken bundle.
    pub vertex: u32,
}

/// What a solver did in a call of [`Solver::advance`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct AdvanceReport {
    /// Number of steps taken.
    pub steps: u64,
    /// Length of the last full step, s.
    pub step: f64,
    /// Largest stable step, s; infinite where there is no limit.
    pub limit: f64,
    /// Energy dissipated by damping, J (exact, from its work).
    pub damped: f64,
    /// Energy that the method itself took from the motion, J, as far as it is known; 0 for methods that conserve it.
    pub dissipated: f64,
    /// Work of clamps and loads, J: of forces along ways, and of moments along angles.
    pub work: f64,
    /// Where the wood buckles, at which [`QuasiStatic`](super::QuasiStatic) stops.
    pub buckling: Option<Buckling>,
}

impl AdvanceReport {
    /// A step that could not be taken, because the wood buckles.
    pub(super) fn buckled(buckling: Buckling) -> Self {
        AdvanceReport {
            buckling: Some(buckling),
            ..AdvanceReport::default()
        }
    }

    /// Adds what was done in a part of the time.
    pub(super) fn add(&mut self, part: &AdvanceReport) {
        self.steps += part.steps;
        self.damped += part.damped;
        self.dissipated += part.dissipated;
        self.work += part.work;
        self.buckling = self.buckling.or(part.buckling);
    }
}

/// A method that moves a world through time.
///
/// All solvers pass the suite in `tests/solvers.rs`.
///
/// ```
/// use glam::DVec3;
/// use greenstick_fibre::{Clamp, Explicit, Motion, NoContacts, Rod, RodBundle, RodMaterial, Solver, World};
/// use greenstick_geometry::Context;
///
/// let material = RodMaterial::solid(1e-5, 1e7, 1e6, 600.0);
/// let vertices = (0..=10).map(|i| DVec3::X * (0.01 * f64::from(i))).collect();
/// let mut world = World::new(RodBundle::new(&[Rod::new(vertices, material)], false)?);
/// world.loads.clamps = vec![Clamp::new(&world.bundle, vec![0, 1], Motion::Fixed)];
/// world.loads.gravity = DVec3::Z * -9.81;
/// let report = Explicit::new(None).advance(&mut world, &mut NoContacts, 0.01, &Context::quiet())?;
/// assert!(report.steps > 0 && world.state.position.get(10).z < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Solver: Send {
    /// Returns its name in files and messages.
    fn name(&self) -> &'static str;

    /// Returns the step that it would take now, s.
    ///
    /// # Errors
    /// [`SolverError::UnstableStep`] where a given step is too large, [`SolverError::Cancelled`].
    fn step(&mut self, world: &World, context: &Context) -> Result<f64, SolverError>;

    /// Moves the world by `duration` seconds, in whole steps of equal length no longer than [`Solver::step`], and appends
    /// what breaks to [`World::events`]. Where the report has a [`Buckling`], it stopped there.
    ///
    /// # Errors
    /// [`SolverError`], [`SolverError::Cancelled`] among them. World and contacts are then as after the last complete step.
    fn advance(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        duration: f64,
        context: &Context,
    ) -> Result<AdvanceReport, SolverError>;
}
