//! One step per frame, at real stiffness, faster than the time it shows.
//!
//! Each step is an equilibrium with inertia at its end (implicit Euler), found by Newton's method ([`super::newton`]), but
//! only as accurately as a frame needs, and with linear systems solved anew each time by conjugate gradients that know rods
//! and cross-sections ([`super::linear`]): a factor of the matrix, which would have to be made anew whenever something
//! breaks, costs as much as many frames. Methods that go from vertex to vertex (vertex block descent, position-based
//! dynamics) do not carry a bending moment through a slender stem in any number of sweeps for which a frame has time.
//!
//! What is overstressed at the end of a step breaks, and the same step is repeated from there; what would still break then
//! breaks in the next step. A crack that runs in microseconds therefore takes a few frames. Bonds that break lose their
//! stiffness until the step ends, so that vertices are renumbered only where a rod breaks. Implicit Euler lets vibration
//! that is fast against the frame die out, which is reported as [`AdvanceReport::dissipated`].

use super::balance::{EquilibriumProblem, Inertia};
use super::newton::{Equilibrium, Newton, NewtonOptions};
use super::solver::AdvanceReport;
use super::stepwise::Stepwise;
use crate::contact::Contacts;
use crate::energy::energies;
use crate::error::SolverError;
use crate::failure::break_place::move_state;
use crate::failure::breaking::{place_breaks, record_breaks, remove_elements};
use crate::failure::demand::{Element, Overstressed, bonds_in, rods_in};
use crate::failure::yielding::record_yielding;
use crate::forces::Forces;
use crate::loads::Loads;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::topology;
use crate::vectors::Vectors;
use crate::world::World;
use greenstick_geometry::Context;

/// The step where none is given, s.
pub(crate) const DEFAULT_STEP: f64 = 1.0 / 30.0;
/// Number of times that a step is repeated after breaks.
const BREAK_ROUNDS: usize = 1;
/// Elements break together with the most overstressed one from this fraction of its demand.
const SIMULTANEOUS_BREAK_FRACTION: f64 = 0.7;
/// From this demand an element breaks in any case: a load that grows faster than steps follow must not outrun it.
const CERTAIN_BREAK_DEMAND: f64 = 1.3;
/// The same where forces are not balanced yet. Without it one small bond under great strain would keep everything else whole.
const CERTAIN_BREAK_DEMAND_UNBALANCED: f64 = 2.0;
/// Where the breaking elements hold less than this fraction of all stored energy, the step is not repeated; the next one
/// follows.
const NEGLIGIBLE_ENERGY_FRACTION: f64 = 1e-2;
/// Largest distance that the prediction moves a vertex, in shortest edges.
const MAX_PREDICTION: f64 = 0.5;
/// Accuracy of a step: forces at break differ from those of the other solvers by far less.
const OPTIONS: NewtonOptions = NewtonOptions {
    stateless: true,
    tolerance: 1e-2,
    max_iterations: 3,
    linear_tolerance: 0.1,
    accept_unconverged: true,
    reuse_preconditioner: true,
};

/// The interactive solver: implicit Euler, one step per frame.
#[derive(Debug, Clone)]
pub struct Interactive {
    given: Option<f64>,
    newton: Newton,
    queue: Vec<Overstressed>,
    newton_iterations: u64,
    equilibria: u64,
}

/// The work of an interactive solver so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct InteractiveEffort {
    /// Equilibria.
    pub equilibria: u64,
    /// Newton iterations.
    pub newton_iterations: u64,
    /// Conjugate gradient iterations.
    pub conjugate_gradients: u64,
}

/// What a step began with, for the case that it fails after something has broken.
struct Saved {
    bundle: RodBundle,
    state: State,
    loads: Loads,
}

impl Interactive {
    /// Returns a solver with steps of `step` seconds, or 1/30 s.
    pub fn new(step: Option<f64>) -> Self {
        Interactive {
            given: step,
            newton: Newton::with_options(OPTIONS),
            queue: Vec::new(),
            newton_iterations: 0,
            equilibria: 0,
        }
    }

    /// Returns the work done so far.
    pub fn effort(&self) -> InteractiveEffort {
        InteractiveEffort {
            equilibria: self.equilibria,
            newton_iterations: self.newton_iterations,
            conjugate_gradients: self.newton.conjugate_gradients(),
        }
    }

    /// Finds the equilibrium at the end of a step of `dt` from `old`, starting the search from the world's state.
    fn equilibrium(
        &mut self,
        world: &World,
        old: &State,
        contacts: &mut dyn Contacts,
        dt: f64,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        self.newton.prepare(&world.bundle, &[]);
        let plus = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| a + b * dt).collect()
        };
        let (x, v) = (&old.position, &old.velocity);
        let inertia = Inertia {
            h: dt,
            ahead: Vectors {
                x: plus(&x.x, &v.x),
                y: plus(&x.y, &v.y),
                z: plus(&x.z, &v.z),
            },
            behind: old.position.clone(),
            angle_ahead: plus(&old.angle, &old.spin),
            angle_behind: old.angle.clone(),
        };
        let problem = EquilibriumProblem {
            bundle: &world.bundle,
            loads: &world.loads,
            yielding: world.failure.rods_yield,
            start: old,
            base: old,
            inertia: Some(&inertia),
            time: old.time + dt,
        };
        let found = self
            .newton
            .solve(&problem, &world.state, contacts, context)?;
        self.newton_iterations += found.iterations as u64;
        self.equilibria += 1;
        Ok(found)
    }

    /// Takes a step. Where it fails, `saved` has what of the world must be restored.
    fn take_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        saved: &mut Option<Saved>,
        context: &Context,
    ) -> Result<StepEnergy, SolverError> {
        let stored = energies(&world.bundle, &world.state).total() + contacts.stored_energy();
        let fracture_loss = world.fracture_loss;
        let mut old = world.state.clone();
        predict(world, dt);
        self.newton.renew_preconditioner();
        // Bonds without stiffness, which are removed at the end or with the next rod that breaks.
        let mut weakened = Vec::new();
        let mut start = WorkStart {
            state: old.clone(),
            work: 0.0,
        };
        // Vertices at which rods break when the step has ended.
        let mut late_splits = Vec::new();
        let mut round = 0;
        let found = loop {
            let mut found = match self.equilibrium(world, &old, contacts, dt, context) {
                Ok(found) => found,
                Err(error) => {
                    if saved.is_none() {
                        world.state = old;
                    }
                    return Err(error);
                }
            };
            if round == BREAK_ROUNDS || !self.find_breaks(world, &found) {
                break found;
            }
            round += 1;
            std::mem::swap(&mut world.state, &mut found.state);
            let before = world.fracture_loss;
            record_breaks(world, &self.queue);
            let released = world.fracture_loss - before;
            if found.converged && released < NEGLIGIBLE_ENERGY_FRACTION * stored {
                std::mem::swap(&mut world.state, &mut found.state);
                weakened.extend(bonds_in(&self.queue));
                late_splits = rods_in(&self.queue);
                break found;
            }
            saved.get_or_insert_with(|| Saved {
                bundle: world.bundle.clone(),
                state: old.clone(),
                loads: world.loads.clone(),
            });
            start.work += work(world, &start.state, &found.reaction, old.time + dt);
            if let Some(before) = self.break_queue(world, &mut old, contacts, &mut weakened) {
                topology::split_state(&mut old, &before);
            }
            start.state.clone_from(&world.state);
        };
        world.state = old;
        let mut energy = accept(world, contacts, found, &start, dt);
        if !(weakened.is_empty() && late_splits.is_empty()) {
            let placed = place_breaks(world, weakened, &late_splits);
            remove_elements(world, contacts, placed.bonds, late_splits);
        }
        let after = energies(&world.bundle, &world.state).total() + contacts.stored_energy();
        let fractured = world.fracture_loss - fracture_loss;
        energy.dissipated =
            stored + energy.work + energy.contact - energy.damped - fractured - after;
        Ok(energy)
    }

    /// Breaks the elements of the queue. Bonds lose their stiffness, and are removed with the next rod that breaks. Returns
    /// for each vertex its number before, where that changes. `old` is the start of the step.
    fn break_queue(
        &mut self,
        world: &mut World,
        old: &mut State,
        contacts: &mut dyn Contacts,
        weakened: &mut Vec<u32>,
    ) -> Option<Vec<u32>> {
        let (bonds, splits) = (bonds_in(&self.queue), rods_in(&self.queue));
        for &b in &bonds {
            world.bundle.bonds.transverse[b as usize] = 0.0;
            world.bundle.bonds.shear[b as usize] = 0.0;
        }
        self.newton.remove_bond_stiffness(&world.bundle, &bonds);
        weakened.extend(bonds);
        if splits.is_empty() {
            return None;
        }
        let placed = place_breaks(world, std::mem::take(weakened), &splits);
        move_state(old, &world.bundle, &placed.places);
        Some(remove_elements(world, contacts, placed.bonds, splits))
    }

    /// Puts into the queue what breaks at the end of a step. Where forces are not balanced yet, overstress may come from that
    /// alone: it must be greater, and rods break only where the forces on their own vertices are balanced.
    fn find_breaks(&mut self, world: &World, found: &Equilibrium) -> bool {
        let (bundle, state) = (&world.bundle, &found.state);
        let mut queue = std::mem::take(&mut self.queue);
        queue.clear();
        queue.extend_from_slice(self.newton.detect(&world.failure, bundle, state));
        let newton = &self.newton;
        queue.retain(|o| match o.element {
            Element::Bond(_) => true,
            Element::Rod(vertex) => {
                found.converged || newton.is_balanced_at(bundle, state, vertex as usize)
            }
        });
        let simultaneous = SIMULTANEOUS_BREAK_FRACTION * queue.first().map_or(0.0, |o| o.demand);
        let certain = if found.converged {
            CERTAIN_BREAK_DEMAND
        } else {
            CERTAIN_BREAK_DEMAND_UNBALANCED
        };
        queue.retain(|o| o.demand >= simultaneous.min(certain));
        self.queue = queue;
        !self.queue.is_empty()
    }
}

/// From where the work of the rest of a step counts: its start, or the state in which something broke, from which loads and
/// clamps do the rest of their work on what is left.
struct WorkStart {
    state: State,
    /// The work up to there, J.
    work: f64,
}

/// Energy of a step, J.
#[derive(Debug, Clone, Copy, Default)]
struct StepEnergy {
    work: f64,
    damped: f64,
    /// Work of bodies less friction.
    contact: f64,
    dissipated: f64,
}

/// Ends a step of `dt` from the world's state with the equilibrium found.
fn accept(
    world: &mut World,
    contacts: &mut dyn Contacts,
    found: Equilibrium,
    start: &WorkStart,
    dt: f64,
) -> StepEnergy {
    let old = std::mem::replace(&mut world.state, found.state);
    for v in 0..world.bundle.vertices() {
        let way = world.state.position.get(v) - old.position.get(v);
        world.state.velocity.set(v, way / dt);
        world.state.spin[v] = (world.state.angle[v] - old.angle[v]) / dt;
    }
    world.state.time = old.time + dt;
    world.state.step = old.step + 1;
    let yielded = record_yielding(world, &old);
    world.fracture_loss += yielded;
    let contact = contacts.accept(&old, old.time + dt, &found.springs);
    StepEnergy {
        work: start.work + work(world, &start.state, &found.reaction, world.state.time),
        damped: damping_power(world) * dt,
        contact: contact.work - contact.dissipated,
        ..StepEnergy::default()
    }
}

/// Moves everything on with its velocity: where equilibria follow each other smoothly, the next one is near there. It leaves
/// the state alone where something flies, which would fold.
fn predict(world: &mut World, dt: f64) {
    let World { bundle, state, .. } = world;
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    let shortest = edges.fold(f64::INFINITY, |a, j| a.min(bundle.rest_length[j]));
    let fastest = (state.velocity.iter()).fold(0.0, |a: f64, v| a.max(v.length_squared()));
    let limit = MAX_PREDICTION * shortest / dt;
    if fastest.is_nan() || fastest > limit * limit {
        return;
    }
    for v in 0..bundle.vertices() {
        state.position.add(v, state.velocity.get(v) * dt);
        state.angle[v] += state.spin[v] * dt;
    }
    state.transport_frames(bundle);
}

/// Returns the work of loads and of clamps from a state to that of the world, J. Forces are those at its end, as the method
/// has them; those of clamps are `reaction`, loads are those at `time` (s).
fn work(world: &World, from: &State, reaction: &Forces, time: f64) -> f64 {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let mut forces = Forces::zeros(bundle.vertices());
    loads.add_forces(bundle, time, &state.position, &state.velocity, &mut forces);
    let mut work = 0.0;
    for v in 0..bundle.vertices() {
        let way = state.position.get(v) - from.position.get(v);
        work += (forces.linear.get(v) + reaction.linear.get(v)).dot(way);
        if bundle.twisting {
            let turn = state.angle[v] - from.angle[v];
            work += (forces.moment[v] + reaction.moment[v]) * turn;
        }
    }
    work
}

/// Returns the power of damping, W.
fn damping_power(world: &World) -> f64 {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let twice_kinetic = (0..bundle.vertices()).fold(0.0, |sum, v| {
        let linear = bundle.mass[v] * state.velocity.get(v).length_squared();
        let spin = if bundle.twisting {
            bundle.inertia[v] * state.spin[v] * state.spin[v]
        } else {
            0.0
        };
        sum + linear + spin
    });
    loads.damping * twice_kinetic
}

impl Stepwise for Interactive {
    const NAME: &'static str = "interactive";
    const DEFAULT_STEP: f64 = DEFAULT_STEP;

    fn given(&self) -> Option<f64> {
        self.given
    }

    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut AdvanceReport,
        context: &Context,
    ) -> Result<(), SolverError> {
        let (bodies, events) = (contacts.snapshot(), world.events.len());
        let fracture_loss = world.fracture_loss;
        let mut saved = None;
        match self.take_step(world, contacts, dt, &mut saved, context) {
            Ok(energy) => {
                report.work += energy.work;
                report.damped += energy.damped;
                report.dissipated += energy.dissipated;
                report.steps += 1;
                Ok(())
            }
            Err(error) => {
                if let Some(saved) = saved {
                    world.bundle = saved.bundle;
                    world.state = saved.state;
                    world.loads = saved.loads;
                    // The solver's data are those of the broken bundle.
                    self.newton = Newton::with_options(OPTIONS);
                }
                world.events.truncate(events);
                world.fracture_loss = fracture_loss;
                contacts.restore(&bodies, &world.bundle, &world.loads);
                Err(error)
            }
        }
    }
}
