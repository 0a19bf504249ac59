//! Load steps to equilibrium, for mechanical tests: clamps and grips move, everything comes to rest, the most overstressed
//! element breaks, everything comes to rest again, event by event. Loads are displacements, so that the force may fall: the
//! solver passes the peak.
//!
//! Time only measures how far loads have gone. A step in which something would be overstressed by more than
//! [`MAX_OVERSTRESS`] is repeated with a shorter length, so that the load at a break does not depend on the steps.
//!
//! Work is that along the path of equilibria, by the trapezoidal rule. What the potential falls more than its forces work by the
//! same rule is reported as [`AdvanceReport::dissipated`]: hardly anything from one equilibrium to the next, and where a step
//! starts out of balance, after a break or under a load that is suddenly there, what would have become motion and heat. The
//! balance of energy is a check: what is left of it is the work of forces that are not balanced at the end of a step.

use super::balance::{EquilibriumProblem, Inertia};
use super::grip::Grip;
use super::newton::{Equilibrium, Newton, NewtonOptions};
use super::solver::{AdvanceReport, Solver};
use super::step_energy::{contact_work, work_between};
use super::stepwise::{check_duration, given_step};
use crate::contact::Contacts;
use crate::energy::energies;
use crate::error::SolverError;
use crate::failure::breaking::{break_elements, find_softened_bonds, take_damage};
use crate::failure::criteria::FailureCriteria;
use crate::failure::demand::{Overstressed, find_overstressed, largest_demand};
use crate::failure::yielding::record_yielding;
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::world::World;
use greenstick_geometry::{Cancelled, Context};

/// Load steps of a call of advance where none are given.
const DEFAULT_STEPS: f64 = 32.0;
/// A step that does not converge is halved, and one that overstresses shortened, at most this often.
const MAX_TRIALS: i32 = 12;
/// Overstress that is accepted: demand over strength less 1.
const MAX_OVERSTRESS: f64 = 5e-3;

/// Largest number of viscous steps in which a state without a direct way to equilibrium comes to rest.
const MAX_VISCOUS_STEPS: usize = 60;
/// The first of them, in periods of the fastest edge over 2π.
const FIRST_VISCOUS_STEP: f64 = 100.0;
/// A step that takes fewer iterations than the first number makes the next one longer by the second.
const VISCOUS_STEP_GROWTH: [(usize, f64); 4] = [(8, 4.0), (16, 2.0), (28, 1.0), (usize::MAX, 0.5)];
/// A step that does not converge is tried shorter by this factor.
const VISCOUS_STEP_REDUCTION: f64 = 0.25;
/// Where steps have become longer than the first by this factor, mass hardly slows the motion any more, and the equilibrium
/// itself is tried anew.
const NEARLY_STATIC_RATIO: f64 = 64.0;

/// The quasi-static solver.
#[derive(Debug, Clone, Default)]
pub struct QuasiStatic {
    given: Option<f64>,
    grips: Vec<Grip>,
    pub(super) newton: Newton,
    queue: Vec<Overstressed>,
    iterations: u64,
    /// Load steps in a row that hardly advanced ([`super::buckling`]).
    pub(super) short_steps: u32,
}

/// A step from the world's state to an equilibrium.
struct LoadStep {
    /// Forces of clamps at the start.
    reaction: Forces,
    end: Equilibrium,
    /// Time at the end, s.
    time: f64,
}

/// The work of a quasi-static solver so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct QuasiStaticEffort {
    /// Newton iterations.
    pub newton_iterations: u64,
    /// Cholesky factors.
    pub factorisations: usize,
}

impl QuasiStatic {
    /// Returns a solver with load steps of `step` seconds, or a thirty-second of each duration.
    pub fn new(step: Option<f64>) -> Self {
        QuasiStatic {
            given: step,
            ..QuasiStatic::default()
        }
    }

    /// Returns a solver that retains nothing from one load step to the next, so that a resumed run gives the same bytes. It
    /// takes no grips.
    pub fn stateless(step: Option<f64>) -> Self {
        QuasiStatic {
            given: step,
            newton: Newton::with_options(NewtonOptions::STATELESS),
            ..QuasiStatic::default()
        }
    }

    /// Returns the same solver with grips.
    #[must_use]
    pub(crate) fn with_grips(mut self, grips: Vec<Grip>) -> Self {
        self.grips = grips;
        self
    }

    /// Returns the forces of the grips on the world as it is, N.
    pub(crate) fn grip_forces(&mut self, world: &World) -> Vec<f64> {
        self.newton.prepare(&world.bundle, &self.grips);
        self.newton
            .grip_forces(&world.bundle, &world.state, world.state.time)
    }

    /// Returns the displacements on which the grips act, m.
    pub(crate) fn grip_displacements(&mut self, world: &World) -> Vec<f64> {
        self.newton.prepare(&world.bundle, &self.grips);
        self.newton.grip_displacements(&world.bundle, &world.state)
    }

    /// Returns the work done so far.
    pub fn effort(&self) -> QuasiStaticEffort {
        QuasiStaticEffort {
            newton_iterations: self.iterations,
            factorisations: self.newton.factorisations(),
        }
    }

    /// Finds the equilibrium at `time` from the world's state.
    fn equilibrium(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        time: f64,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        self.newton.prepare(&world.bundle, &self.grips);
        let problem = EquilibriumProblem::at_rest(world, time);
        let found = match self.newton.solve(&problem, &world.state, contacts, context) {
            // A load step may be shortened; after a break there is no shorter step.
            Err(SolverError::NotConverged { .. }) if time == world.state.time => {
                self.relax(&problem, contacts, context)?
            }
            Err(SolverError::NotConverged { .. }) if world.is_elastic() => {
                self.solve_far(&problem, contacts, context)?
            }
            other => other?,
        };
        self.iterations += found.iterations as u64;
        Ok(found)
    }

    /// Solves with steps that may be longer than the linear systems give. These leave out what makes wood under pressure softer,
    /// so that near the critical load of a column they would come to rest only after hundreds of iterations.
    fn solve_far(
        &mut self,
        problem: &EquilibriumProblem,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        let options = self.newton.options;
        self.newton.options.lengthen_steps = true;
        let found = self.newton.solve(problem, problem.start, contacts, context);
        self.newton.options = options;
        found
    }

    /// Comes to rest after a break by backward Euler steps that start without velocity: what has snapped loose moves to a new
    /// equilibrium as through honey, and edges may yield on the way.
    fn relax(
        &mut self,
        problem: &EquilibriumProblem,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        let first_step = FIRST_VISCOUS_STEP * fastest_edge(problem);
        let mut h = first_step;
        let mut state = problem.start.clone();
        let mut iterations = 0;
        for _ in 0..MAX_VISCOUS_STEPS {
            let inertia = Inertia {
                h,
                ahead: state.position.clone(),
                behind: state.position.clone(),
                angle_ahead: state.angle.clone(),
                angle_behind: state.angle.clone(),
            };
            let slowed = EquilibriumProblem {
                inertia: Some(&inertia),
                base: &state,
                ..*problem
            };
            let found = match self.newton.solve(&slowed, &state, contacts, context) {
                Ok(found) => found,
                Err(SolverError::NotConverged { .. }) => {
                    h *= VISCOUS_STEP_REDUCTION;
                    continue;
                }
                Err(other) => return Err(other),
            };
            state = found.state;
            iterations += found.iterations;
            if h >= NEARLY_STATIC_RATIO * first_step {
                match self.solve_from(problem, &state, contacts, context) {
                    Ok(rest) => {
                        return Ok(Equilibrium {
                            iterations: rest.iterations + iterations,
                            ..rest
                        });
                    }
                    Err(SolverError::NotConverged { .. }) => {}
                    Err(other) => return Err(other),
                }
            }
            let growth = VISCOUS_STEP_GROWTH.iter();
            let growth = growth.copied().find(|(most, _)| found.iterations < *most);
            h *= growth.map_or(1.0, |(_, factor)| factor);
        }
        self.solve_from(problem, &state, contacts, context)
    }

    /// Solves the problem itself from a state, whose plastic strain it takes over.
    fn solve_from(
        &mut self,
        problem: &EquilibriumProblem,
        state: &State,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        let problem = EquilibriumProblem {
            base: state,
            ..*problem
        };
        self.newton.solve(&problem, state, contacts, context)
    }

    /// Goes to the next equilibrium on the way to `time` (s). The most overstressed element breaks; where nothing is
    /// overstressed the loads advance, to `time` or to where the first element breaks.
    ///
    /// # Errors
    /// [`SolverError`]. World and contacts are then as they were.
    pub(crate) fn next_equilibrium(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        time: f64,
        context: &Context,
    ) -> Result<AdvanceReport, SolverError> {
        let mut report = AdvanceReport {
            limit: f64::INFINITY,
            step: time - world.state.time,
            ..AdvanceReport::default()
        };
        let bodies = contacts.snapshot();
        let one = FailureCriteria {
            max_breaks: 1,
            ..world.failure.sudden()
        };
        find_overstressed(&one, &world.bundle, &world.state, &mut self.queue);
        find_softened_bonds(world, &mut self.queue);
        let result = if self.queue.is_empty() {
            self.advance_loads(world, contacts, time, context)
        } else {
            self.break_one(world, contacts, context)
        };
        match result {
            Ok(found) => {
                self.accept(world, contacts, found, &mut report);
                Ok(report)
            }
            Err(error) => {
                contacts.restore(&bodies, &world.bundle, &world.loads);
                Err(error)
            }
        }
    }

    /// Breaks what is in the queue. Returns the equilibrium after it.
    fn break_one(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<LoadStep, SolverError> {
        let time = world.state.time;
        let saved = world.clone();
        break_elements(world, contacts, &self.queue);
        match self.equilibrium(world, contacts, time, context) {
            Ok(end) => Ok(LoadStep {
                // Clamps do not move, whatever their forces were.
                reaction: Forces::zeros(world.bundle.vertices()),
                end,
                time,
            }),
            Err(error) => {
                *world = saved;
                Err(error)
            }
        }
    }

    /// Advances the loads to `time`, or to where the first element breaks. Returns the equilibrium there.
    fn advance_loads(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        time: f64,
        context: &Context,
    ) -> Result<LoadStep, SolverError> {
        let reaction = self.reaction_at_start(world, contacts, context)?;
        let start = world.state.time;
        let failure = world.failure.sudden();
        let demand = |state: &State| largest_demand(&failure, &world.bundle, state);
        let before = demand(&world.state);
        let (mut target, mut trials) = (time, 0);
        loop {
            trials += 1;
            match self.equilibrium(world, contacts, target, context) {
                Ok(end) => {
                    let after = demand(&end.state);
                    if after <= 1.0 + MAX_OVERSTRESS || trials > MAX_TRIALS {
                        return Ok(LoadStep {
                            reaction,
                            end,
                            time: target,
                        });
                    }
                    // Slightly beyond the strength, so that the element breaks.
                    let part = (1.0 + 0.5 * MAX_OVERSTRESS - before) / (after - before);
                    target = start + (target - start) * part.clamp(0.02, 0.98);
                }
                Err(SolverError::NotConverged { .. }) if trials <= MAX_TRIALS => {
                    target = start + 0.5 * (target - start);
                }
                Err(other) => return Err(other),
            }
        }
    }

    /// Finds the forces of clamps in the world as it is.
    fn reaction_at_start(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Forces, Cancelled> {
        self.newton.prepare(&world.bundle, &self.grips);
        let problem = EquilibriumProblem::at_rest(world, world.state.time);
        self.newton.reaction_at_start(&problem, contacts, context)
    }

    fn accept(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        LoadStep {
            reaction,
            end,
            time,
        }: LoadStep,
        report: &mut AdvanceReport,
    ) {
        let stored = energies(&world.bundle, &world.state).potential() + contacts.stored_energy();
        let mut internal = Forces::zeros(world.bundle.vertices());
        (self.newton).internal_forces(&world.bundle, &end.state, &mut internal);
        let old = std::mem::replace(&mut world.state, end.state);
        world.state.time = time;
        world.state.step += 1;
        world.state.velocity.fill_zero();
        world.state.spin.fill(0.0);
        let lost = record_yielding(world, &old) + take_damage(world, &end.softened);
        world.fracture_loss += lost;
        let before = external_work(world, &old, &old, reaction);
        let after = external_work(world, &old, &world.state, end.reaction);
        report.work += before + after;
        let (drawn, held) = self.grip_work(world, &old);
        report.work += drawn;
        let mut own = half_work(&world.bundle, [&old, &world.state], &internal);
        own += 0.5 * contact_work(&old, &world.state, &end.springs);
        let contact = contacts.accept(&old, time, &end.springs);
        let now = energies(&world.bundle, &world.state).potential() + contact.stored;
        let given = contact.work - contact.dissipated;
        // At the start, forces of the wood are taken as those of loads and clamps, with which they were balanced or will be.
        report.dissipated += stored + given - now - lost - own + before + held;
        report.steps += 1;
    }

    /// Returns the work with which grips are moved on the way from `old` to the world's state, and half of the work that they do on
    /// the wood with their forces at its start, J.
    fn grip_work(&self, world: &World, old: &State) -> (f64, f64) {
        let World { bundle, state, .. } = world;
        let forces = [old, state].map(|s| self.newton.grip_forces(bundle, s, s.time));
        let places = [old, state].map(|s| self.newton.grip_displacements(bundle, s));
        let step = state.time - old.time;
        let (mut drawn, mut held) = (0.0, 0.0);
        for (k, grip) in self.grips.iter().enumerate() {
            drawn += 0.5 * (forces[0][k] + forces[1][k]) * grip.speed * step;
            held += 0.5 * forces[0][k] * (places[1][k] - places[0][k]);
        }
        (drawn, held)
    }
}

/// Returns half of the work of loads and clamps with their forces in the state `at` on the way from `old` to the world's state,
/// J.
fn external_work(world: &World, old: &State, at: &State, reaction: Forces) -> f64 {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let mut forces = reaction;
    let (x, v) = (&at.position, &at.velocity);
    loads.add_forces(bundle, at.time, x, v, &mut forces);
    half_work(bundle, [old, state], &forces)
}

/// Returns half of the work of forces on the way from one state to another, J: their part of the trapezoidal rule, which is
/// exact along a straight path of a linear system.
fn half_work(bundle: &RodBundle, [from, to]: [&State; 2], forces: &Forces) -> f64 {
    0.5 * work_between(bundle, from, to, forces)
}

/// Returns the shortest period of an edge over 2π, s.
fn fastest_edge(problem: &EquilibriumProblem) -> f64 {
    let bundle = problem.bundle;
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    edges.fold(f64::INFINITY, |least, j| {
        let mass = bundle.mass[j].min(bundle.mass[j + 1]);
        least.min((mass * bundle.rest_length[j] / bundle.stretch[j]).sqrt())
    })
}

impl Solver for QuasiStatic {
    fn name(&self) -> &'static str {
        "quasi-static"
    }

    fn step(&mut self, _: &World, _: &Context) -> Result<f64, SolverError> {
        given_step(self.given, f64::INFINITY)
    }

    fn advance(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        duration: f64,
        context: &Context,
    ) -> Result<AdvanceReport, SolverError> {
        check_duration(duration)?;
        world.check()?;
        let full = self.step(world, context)?.min(duration / DEFAULT_STEPS);
        let full = self.given.unwrap_or(full);
        let (start, end) = (world.state.time, world.state.time + duration);
        let mut report = AdvanceReport {
            limit: f64::INFINITY,
            step: full,
            ..AdvanceReport::default()
        };
        while world.state.time < end
            || largest_demand(&world.failure.sudden(), &world.bundle, &world.state) >= 1.0
        {
            if duration > 0.0 {
                context.report((world.state.time - start) / duration)?;
            }
            let mut time = world.state.time + full;
            if time > end - 1e-9 * full {
                time = end;
            }
            let one = self.next_stable(world, contacts, time, context)?;
            report.add(&one);
            if report.buckling.is_some() {
                break;
            }
        }
        Ok(report)
    }
}
