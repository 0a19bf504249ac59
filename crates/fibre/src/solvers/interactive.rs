//! One step per frame, at real stiffness, and short ones while wood breaks.
//!
//! Each step is an equilibrium with inertia at its end (implicit Euler), found by Newton's method ([`super::newton`]), but
//! only as accurately as a frame needs, and with linear systems solved anew each time by conjugate gradients that know rods
//! and cross-sections ([`super::linear`]): a factor of the matrix, which would have to be made anew whenever something
//! breaks, costs as much as many frames. Methods that go from vertex to vertex (vertex block descent, position-based
//! dynamics) do not carry a bending moment through a slender stem in any number of sweeps for which a frame has time.
//!
//! A step at whose end a rod is stressed far beyond its strength is cut to where it just fails. What then follows takes
//! microseconds: explicit steps follow the crack until it is at rest ([`super::crack`]). Cohesive bonds soften within the
//! equilibrium. A step that does not balance is divided until it does. Implicit Euler lets vibration that is fast against the
//! step die out, which is reported as [`AdvanceReport::dissipated`] ([`super::step_energy`]).

use super::balance::{EquilibriumProblem, Inertia};
use super::crack::{self, Crack, Span};
use super::explicit::Explicit;
use super::newton::{Equilibrium, Newton, NewtonOptions};
use super::prediction::predict;
use super::solver::AdvanceReport;
use super::step_energy::StepEnergy;
use super::stepwise::Stepwise;
use crate::bodies::state::ContactsState;
use crate::contact::Contacts;
use crate::error::SolverError;
use crate::failure::breaking::{break_elements, find_softened_bonds};
use crate::failure::crumbs::find_peeled_bonds;
use crate::failure::demand::{Overstressed, largest_demand};
use crate::loads::Loads;
use crate::reactions::clamp_forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use crate::world::{Onset, World};
use greenstick_geometry::Context;

/// The step where none is given, s.
pub(crate) const DEFAULT_STEP: f64 = 1.0 / 30.0;
/// A step after which a rod bears more than this multiple of its strength is cut.
const MAX_ONSET_DEMAND: f64 = 1.05;
/// The demand at which a cut step shall end.
const ONSET_DEMAND: f64 = 1.02;
/// A step longer than this fraction of the time that is left takes all of it: the rest would not be worth a step of its own.
const REST_FRACTION: f64 = 0.7;
/// Bounds of a cut, as fractions of the step.
const CUT_FRACTIONS: (f64, f64) = (0.05, 0.7);
// A step that is cut by less would be lengthened to what was cut, again and again.
const _: () = assert!(CUT_FRACTIONS.1 <= REST_FRACTION);
/// The shortest step, s. What neither is cut nor balances then is followed as a crack.
const SHORTEST_STEP: f64 = 2e-4;
/// The first step after a crack has come to rest, s.
const STEP_AFTER_CRACK: f64 = 2e-3;
/// Time that explicit steps follow what does not balance, s.
const TIME_UNBALANCED: f64 = 5e-4;
/// Fraction of a step that is tried where the whole does not balance.
const DIVISION: f64 = 0.3;
/// Steps grow and shrink by these factors after so few and so many Newton iterations, and for so many steps after they have
/// become shorter they do not grow.
const GROWTH: f64 = 3.0;
const FEW_ITERATIONS: usize = 8;
const SHRINKAGE: f64 = 0.7;
const MANY_ITERATIONS: usize = 20;
const STEPS_BEFORE_GROWTH: u32 = 2;
/// Fraction of a frame that is rounding.
const TIME_ROUNDING: f64 = 1e-9;
/// Accuracy of a step: forces at break differ from those of the other solvers by far less.
const OPTIONS: NewtonOptions = NewtonOptions {
    stateless: true,
    tolerance: 1e-2,
    min_iterations: 1,
    max_iterations: 16,
    linear_tolerance: 0.1,
    preconditioner_iterations: 4,
    work_tolerance: 1e-4,
    lengthen_steps: true,
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
    onsets: usize,
    fracture_loss: f64,
    unbalanced_work: f64,
    next_step: Option<f64>,
    /// What breaking changes.
    unbroken: Option<(RodBundle, Loads)>,
}

impl Saved {
    fn new(world: &World, contacts: &dyn Contacts) -> Self {
        Saved {
            state: world.state.clone(),
            contacts: contacts.snapshot(),
            events: world.events.len(),
            onsets: world.onsets.len(),
            fracture_loss: world.fracture_loss,
            unbalanced_work: world.unbalanced_work,
            next_step: world.next_step,
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
        world.onsets.truncate(self.onsets);
        world.fracture_loss = self.fracture_loss;
        world.unbalanced_work = self.unbalanced_work;
        world.next_step = self.next_step;
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
            explicit: Explicit::with_safety_factor(crack::STEP_SAFETY_FACTOR),
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
            start: old,
            base: old,
            inertia: Some(&inertia),
            ..EquilibriumProblem::at_rest(world, old.time + dt)
        };
        let first = predict(&world.bundle, &self.newton.balance.parts, old, dt);
        let found = self
            .newton
            .solve_predicted(&problem, first, contacts, context)?;
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
        let mut step = world.next_step.take().unwrap_or(dt).min(dt);
        // Time in which explicit steps go on where equilibria were not found.
        let mut unbalanced = 0.0;
        // Steps in which it does not grow.
        let mut patience = 0;
        while end - world.state.time > TIME_ROUNDING * dt {
            if step == 0.0 {
                saved.keep_unbroken(world);
                let least = world.state.time + std::mem::take(&mut unbalanced);
                let span = Span { least, end };
                let (crack, taken) =
                    crack::run(&mut self.explicit, world, contacts, span, context)?;
                energy += taken;
                self.queue.clear();
                self.let_go(world, contacts);
                step = match crack {
                    Crack::Running => 0.0,
                    Crack::AtRest => STEP_AFTER_CRACK.min(dt),
                };
                continue;
            }
            let left = end - world.state.time;
            let length = with_rest(step, left);
            let mut found = match self.equilibrium(world, contacts, length, context) {
                Err(SolverError::NotConverged { .. }) => {
                    patience = STEPS_BEFORE_GROWTH;
                    step = if length > SHORTEST_STEP {
                        DIVISION * length
                    } else {
                        unbalanced = TIME_UNBALANCED;
                        0.0
                    };
                    continue;
                }
                found => found?,
            };
            let demand = self.find_breaks(world, &found);
            if demand > MAX_ONSET_DEMAND && length > SHORTEST_STEP {
                step = cut(world, demand, length);
                continue;
            }
            saved.keep_unbroken(world);
            let (iterations, motion) = (found.iterations, found.unbalanced_motion.take());
            world.unbalanced_work += found.unbalanced_work;
            energy += StepEnergy::accept(world, contacts, &mut self.newton, found, length);
            if let Some(motion) = motion {
                let World { bundle, state, .. } = &mut *world;
                energy.dissipated -= motion.add_impulse(bundle, length, &mut state.velocity);
            }
            if iterations >= MANY_ITERATIONS {
                step *= SHRINKAGE;
                patience = STEPS_BEFORE_GROWTH;
            } else if patience > 0 {
                patience -= 1;
            } else if iterations <= FEW_ITERATIONS {
                step *= GROWTH;
            }
            if !self.queue.is_empty() {
                step = 0.0;
                let onset = Onset {
                    time: world.state.time,
                    clamps: clamp_forces(world),
                };
                world.onsets.push(onset);
            }
            self.let_go(world, contacts);
        }
        world.next_step = Some(step).filter(|s| *s < dt);
        Ok(energy)
    }

    /// Lets go what is in the queue, and all bonds that hold nothing any more.
    fn let_go(&mut self, world: &mut World, contacts: &mut dyn Contacts) {
        find_softened_bonds(world, &mut self.queue);
        find_peeled_bonds(world, &mut self.queue);
        if !self.queue.is_empty() {
            break_elements(world, contacts, &self.queue);
        }
    }

    /// Puts into the queue what lets go at once in an equilibrium. Returns the greatest demand there, or 0 where nothing does.
    fn find_breaks(&mut self, world: &World, found: &Equilibrium) -> f64 {
        let failure = world.failure.sudden();
        let broken = self.newton.detect(&failure, &world.bundle, &found.state);
        self.queue.clear();
        self.queue.extend_from_slice(broken);
        broken.first().map_or(0.0, |o| o.demand)
    }
}

/// Returns the length of a step of which so much time is left.
fn with_rest(step: f64, left: f64) -> f64 {
    if step > REST_FRACTION * left {
        left
    } else {
        step
    }
}

/// The part of a step that ends about where the first element fails; after the whole of it the greatest demand is `demand`.
fn cut(world: &World, demand: f64, step: f64) -> f64 {
    let failure = world.failure.sudden();
    let before = largest_demand(&failure, &world.bundle, &world.state);
    let fraction = (ONSET_DEMAND - before) / (demand - before);
    let (least, most) = CUT_FRACTIONS;
    let fraction = if fraction.is_finite() {
        fraction.clamp(least, most)
    } else {
        least
    };
    (fraction * step).max(SHORTEST_STEP)
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
