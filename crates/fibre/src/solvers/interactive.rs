//! One step per frame, at real stiffness, and short ones while wood breaks.
//!
//! Each step is an equilibrium with inertia at its end (implicit Euler), found by Newton's method ([`super::newton`]), but
//! only as accurately as a frame needs, and with linear systems solved anew each time by conjugate gradients that know rods
//! and cross-sections ([`super::linear`]): a factor of the matrix, which would have to be made anew whenever something
//! breaks, costs as much as many frames. Methods that go from vertex to vertex (vertex block descent, position-based
//! dynamics) do not carry a bending moment through a slender stem in any number of sweeps for which a frame has time.
//!
//! A step at whose end something is stressed far beyond its strength is cut to where it just fails. What fails then breaks,
//! and steps of [`CRACK_STEP`] follow, each of which breaks what it overstresses, until nothing is and the crack has come
//! to rest; then steps grow again. A step that does not balance is divided until it does. Implicit Euler lets vibration that
//! is fast against the step die out, which is reported as [`AdvanceReport::dissipated`] ([`super::step_energy`]).

use super::balance::{EquilibriumProblem, Inertia};
use super::explicit::Explicit;
use super::newton::{Equilibrium, Newton, NewtonOptions};
use super::solver::{AdvanceReport, Solver};
use super::step_energy::StepEnergy;
use super::stepwise::Stepwise;
use crate::bodies::state::ContactsState;
use crate::contact::Contacts;
use crate::energy::energies;
use crate::error::SolverError;
use crate::failure::breaking::break_elements;
use crate::failure::cohesion::FAILED;
use crate::failure::criteria::BondCriterion;
use crate::failure::demand::{Element, Overstressed, largest_demand, rods_in};
use crate::loads::Loads;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use crate::world::World;
use greenstick_geometry::Context;

/// The step where none is given, s.
pub(crate) const DEFAULT_STEP: f64 = 1.0 / 30.0;
/// Length of the steps in which a crack runs, s: some ten times what a wave of shear, at about 1000 m/s, takes across a section
/// of 1 cm, so that the stress about a crack is redistributed within a step and the rest of the stem hardly moves.
const CRACK_STEP: f64 = 1e-4;
/// A step after which something bears more than this multiple of its strength is cut, unless a crack is running.
const MAX_ONSET_DEMAND: f64 = 1.15;
/// The demand at which a cut step shall end.
const ONSET_DEMAND: f64 = 1.05;
/// Bounds of a cut, as fractions of the step.
const CUT_FRACTIONS: (f64, f64) = (0.05, 0.8);
/// Factor by which steps grow when a crack has come to rest.
const STEP_GROWTH: f64 = 4.0;
/// Fraction of a step that is tried where the whole does not balance, and the shortest step that is tried, s.
const DIVISION: f64 = 0.4;
const SHORTEST_STEP: f64 = 1e-4;
/// Largest distance that the prediction moves a vertex, in shortest edges.
const MAX_PREDICTION: f64 = 0.5;
/// Accuracy of a step: forces at break differ from those of the other solvers by far less.
const OPTIONS: NewtonOptions = NewtonOptions {
    stateless: true,
    tolerance: 1e-2,
    min_iterations: 1,
    max_iterations: 8,
    linear_tolerance: 0.1,
    reuse_preconditioner: true,
};

/// The interactive solver: implicit Euler, one step per frame while nothing breaks.
#[derive(Debug, Clone)]
pub struct Interactive {
    given: Option<f64>,
    newton: Newton,
    explicit: Explicit,
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

/// What a frame's step began with, for the case that it fails.
struct Saved {
    state: State,
    contacts: ContactsState,
    events: usize,
    fracture_loss: f64,
    /// What breaking changes.
    unbroken: Option<(RodBundle, Loads)>,
}

impl Saved {
    fn new(world: &World, contacts: &dyn Contacts) -> Self {
        Saved {
            state: world.state.clone(),
            contacts: contacts.snapshot(),
            events: world.events.len(),
            fracture_loss: world.fracture_loss,
            unbroken: None,
        }
    }

    /// Saves what breaking changes.
    fn keep_unbroken(&mut self, world: &World) {
        self.unbroken
            .get_or_insert_with(|| (world.bundle.clone(), world.loads.clone()));
    }

    fn restore(self, world: &mut World, contacts: &mut dyn Contacts) {
        world.state = self.state;
        world.events.truncate(self.events);
        world.fracture_loss = self.fracture_loss;
        if let Some((bundle, loads)) = self.unbroken {
            (world.bundle, world.loads) = (bundle, loads);
        }
        contacts.restore(&self.contacts, &world.bundle, &world.loads);
    }
}

impl Interactive {
    /// Returns a solver with steps of `step` seconds, or 1/30 s.
    pub fn new(step: Option<f64>) -> Self {
        Interactive {
            given: step,
            newton: Newton::with_options(OPTIONS),
            explicit: Explicit::new(None),
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

    /// Finds the equilibrium at the end of a step of `dt` from the world's state.
    fn equilibrium(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        dt: f64,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        self.newton.prepare(&world.bundle, &[]);
        self.newton.renew_preconditioner();
        let old = &world.state;
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
            softening: world.failure.bonds == BondCriterion::Cohesive,
            start: old,
            base: old,
            inertia: Some(&inertia),
            time: old.time + dt,
        };
        let first = predict(&world.bundle, old, dt);
        let found = self.newton.solve(&problem, &first, contacts, context)?;
        self.newton_iterations += found.iterations as u64;
        self.equilibria += 1;
        Ok(found)
    }

    /// Goes on by `dt`, in one step or in those that breaking needs.
    fn go_on(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        saved: &mut Saved,
        context: &Context,
    ) -> Result<StepEnergy, SolverError> {
        let end = world.state.time + dt;
        let mut energy = StepEnergy::default();
        let mut step = world.next_step.unwrap_or(dt).min(dt);
        let mut hold = 0u32;
        while end - world.state.time > 1e-9 * dt {
            let left = end - world.state.time;
            // What is left after a step is worth a step of its own.
            let planned = step;
            step = if step > 0.7 * left { left } else { step };
            let t0 = std::time::Instant::now();
            let tot = |w: &World, c: &dyn Contacts| {
                energies(&w.bundle, &w.state).total()
                    + c.stored_energy()
                    + w.fracture_loss
                    + {
                        let l = c.snapshot().bodies.ledger;
                        l.dissipated - l.work
                    }
                    + c.body_energy()
            };
            let e0 = tot(world, contacts);
            let found = self.equilibrium(world, contacts, step, context);
            if std::env::var("CRK").is_ok() {
                eprintln!(
                    "t {:.6} step {:.3e} it {} cg {} ev {} ok {} {:.3} s",
                    world.state.time,
                    step,
                    self.newton_iterations,
                    self.newton.conjugate_gradients(),
                    world.events.len(),
                    found.is_ok(),
                    t0.elapsed().as_secs_f64()
                );
            }
            let found = match found {
                Err(SolverError::NotConverged { .. }) => {
                    hold = 3;
                    if step > SHORTEST_STEP {
                        step *= DIVISION;
                    } else {
                        saved.keep_unbroken(world);
                        energy += self.run_crack(world, contacts, end, context)?;
                        step = dt;
                    }
                    continue;
                }
                found => found?,
            };
            let its = found.iterations;
            let demand = self.find_breaks(world, &found);
            if demand > MAX_ONSET_DEMAND && step > 2.0 * CRACK_STEP {
                step = cut(world, demand, step);
                continue;
            }
            saved.keep_unbroken(world);
            let one = StepEnergy::accept(world, contacts, &mut self.newton, found, step);
            if std::env::var("CRK").is_ok() {
                eprintln!(
                    "BAL step {:+.5}",
                    tot(world, contacts) - e0 - one.work + one.damped + one.dissipated
                );
            }
            energy += one;
            step = planned.max(step);
            if its > 5 {
                step *= 0.7;
                hold = 2;
            } else if hold > 0 {
                hold -= 1;
            } else if its <= 3 {
                step *= 1.7;
            }
            if !self.queue.is_empty() {
                let splits = !rods_in(&self.queue).is_empty();
                let e0 = tot(world, contacts);
                break_elements(world, contacts, &self.queue);
                let e1 = tot(world, contacts);
                if splits {
                    let one = self.run_crack(world, contacts, end, context)?;
                    if std::env::var("CRK").is_ok() {
                        eprintln!(
                            "BAL break {:+.5} burst {:+.5}",
                            e1 - e0,
                            tot(world, contacts) - e1 - one.work + one.damped
                        );
                    }
                    energy += one;
                    step = dt;
                }
            }
        }
        world.next_step = Some(step).filter(|s| *s < dt);
        Ok(energy)
    }

    /// Follows a crack by explicit steps until nothing has broken for a while, or until the time `end`.
    fn run_crack(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        end: f64,
        context: &Context,
    ) -> Result<StepEnergy, SolverError> {
        let var = |n: &str, d: f64| {
            std::env::var(n)
                .ok()
                .and_then(|s| s.parse().ok())
                .unwrap_or(d)
        };
        let (chunk, quiet_time) = (var("CHUNK", 5e-5), var("QUIET", 2e-4));
        let damping = world.loads.damping;
        let interval =
            std::mem::replace(&mut world.failure.check_interval, var("EVERY", 4.0) as u32);
        let loss0 = world.fracture_loss;
        let between = std::mem::replace(&mut world.failure.between_vertices, false);
        world.loads.damping = var("DAMP", 1000.0);
        let mut quiet = 0.0;
        let mut energy = StepEnergy::default();
        let start = world.state.time;
        let explicit_step = self.explicit.step(world, context)?;
        self.explicit.shift_velocities(world, -explicit_step);
        let (ev, t0) = (world.events.len(), std::time::Instant::now());
        while quiet < quiet_time && world.state.time < end {
            let before = (world.events.len(), world.fracture_loss);
            let duration = chunk.min(end - world.state.time);
            let done = self
                .explicit
                .advance(world, contacts, duration, &context.silenced())?;
            energy.work += done.work;
            energy.damped += done.damped;
            let stored = energies(&world.bundle, &world.state).potential();
            let lost = world.fracture_loss - before.1;
            let busy = lost > 2.0 * done.work.abs() && lost > var("REL", 1e-4) * stored;
            quiet = if busy { 0.0 } else { quiet + duration };
        }
        self.explicit.shift_velocities(world, explicit_step);
        world.loads.damping = damping;
        world.failure.check_interval = interval;
        world.failure.between_vertices = between;
        world.bundle.generation += 1;
        if std::env::var("CRK").is_ok() {
            let e = energies(&world.bundle, &world.state);
            eprintln!(
                "burst {:.6} +{:.2e}: {} events, loss {:.4}, kinetic {:.4} potential {:.4} in {:.2} s",
                start,
                world.state.time - start,
                world.events.len() - ev,
                world.fracture_loss - loss0,
                e.kinetic,
                e.potential(),
                t0.elapsed().as_secs_f64()
            );
        }
        Ok(energy)
    }

    /// Puts into the queue what breaks in an equilibrium. Returns the greatest demand on rods there, or 0 where none breaks.
    fn find_breaks(&mut self, world: &World, found: &Equilibrium) -> f64 {
        let (bundle, state) = (&world.bundle, &found.state);
        let mut failure = world.failure;
        if failure.bonds == BondCriterion::Cohesive {
            failure.bonds = BondCriterion::Never;
        }
        let broken = self.newton.detect(&failure, bundle, state);
        self.queue.clear();
        self.queue.extend_from_slice(broken);
        for &(bond, damage) in &found.softened {
            if damage >= FAILED {
                // Its traction is the law's at all times.
                self.queue.push(Overstressed {
                    demand: 1.0,
                    element: Element::Bond(bond),
                });
            }
        }
        broken.first().map_or(0.0, |o| o.demand)
    }
}

/// The part of a step that ends about where the first element fails; after the whole of it the greatest demand is `demand`.
fn cut(world: &World, demand: f64, step: f64) -> f64 {
    let mut failure = world.failure;
    failure.bonds = BondCriterion::Never;
    let before = largest_demand(&failure, &world.bundle, &world.state);
    let fraction = (ONSET_DEMAND - before) / (demand - before);
    let (least, most) = CUT_FRACTIONS;
    let fraction = if fraction.is_finite() {
        fraction.clamp(least, most)
    } else {
        least
    };
    (fraction * step).max(CRACK_STEP)
}

/// The state with everything moved on with its velocity: where equilibria follow each other smoothly, the next one is near
/// there. It is the state itself where something flies, which would fold.
fn predict(bundle: &RodBundle, state: &State, dt: f64) -> State {
    let mut predicted = state.clone();
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    let shortest = edges.fold(f64::INFINITY, |a, j| a.min(bundle.rest_length[j]));
    let fastest = (state.velocity.iter()).fold(0.0, |a: f64, v| a.max(v.length_squared()));
    let limit = MAX_PREDICTION * shortest / dt;
    if fastest.is_nan() || fastest > limit * limit {
        return predicted;
    }
    for v in 0..bundle.vertices() {
        predicted.position.add(v, state.velocity.get(v) * dt);
        predicted.angle[v] += state.spin[v] * dt;
    }
    predicted.transport_frames(bundle);
    predicted
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
        let mut saved = Saved::new(world, contacts);
        match self.go_on(world, contacts, dt, &mut saved, context) {
            Ok(energy) => {
                report.work += energy.work;
                report.damped += energy.damped;
                report.dissipated += energy.dissipated;
                report.steps += 1;
                Ok(())
            }
            Err(error) => {
                if saved.unbroken.is_some() {
                    // The solver's data are those of the broken bundle.
                    self.newton = Newton::with_options(OPTIONS);
                }
                saved.restore(world, contacts);
                Err(error)
            }
        }
    }
}
