//! Symplectic Euler, as published (Sutherland 2012 §4.1): the reference against which other solvers are measured.
//!
//! v ← (v + Δt a(x)) / (1 + c Δt), x ← x + Δt v. The step is a fraction of the stability limit 2/ω_max. Without damping the
//! method conserves a quantity close to the energy for all times: it dissipates nothing.

use super::free_motion::FreeMotion;
use super::solver::{AdvanceReport, Solver};
use super::stability;
use super::stepwise::check_duration;
use crate::contact::{ContactStep, Contacts};
use crate::energy::{self, energies};
use crate::error::SolverError;
use crate::evaluator::{ExplicitStep, ForceEvaluator};
use crate::failure::breaking::{check_after_step, kick};
use crate::failure::demand::FailureDetector;
use crate::forces::Forces;
use crate::loads::Loads;
use crate::material_frame;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use crate::world::{StabilityLimit, World};
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Fraction of the stability limit that is the step where none is given. The limit is that of the state in which it was
/// computed; strains of a few percent change it by as much.
const STEP_SAFETY_FACTOR: f64 = 0.8;
/// After a break the limit is computed anew, but not more often than every so many steps unless edges have become shorter.
const LIMIT_UPDATE_INTERVAL: u64 = 400;
/// The motion has blown up where its kinetic energy is above this multiple of all energy that there can be. Near the limit a
/// stable motion shows 1/(1 − (ω Δt/2)²) times its energy: three times at the fraction of the limit that is used.
pub const BLOW_UP_RATIO: f64 = 16.0;
/// Rounding moves even a bundle at rest. The energy of this strain is never a blow-up.
const ROUNDING_STRAIN: f64 = 1e-9;

/// Energy of a call of advance.
struct Account {
    /// All energy that there can be, J.
    budget: f64,
    report: AdvanceReport,
}

/// What clamps did in a step, J.
#[derive(Default)]
struct ClampEffect {
    work: f64,
    kinetic_change: f64,
}

/// The explicit solver: symplectic Euler.
#[derive(Debug, Clone)]
pub struct Explicit {
    given: Option<f64>,
    /// The step over the stability limit, where none is given.
    safety_factor: f64,
    evaluator: Option<ForceEvaluator>,
    /// The generation of the bundle that all below is for.
    generation: Option<u64>,
    /// Velocities after the step.
    next: Vectors,
    /// The same without contacts.
    free: Vectors,
    /// Positions after the step.
    position: Vectors,
    /// External loads, and with twist the forces in material frames.
    external: Forces,
    /// Loads alone, where there are any.
    loads: Forces,
    inverse_inertia: Vec<f64>,
    sums: Vec<f64>,
    /// Energy of a strain of rounding, J.
    rounding_energy: f64,
    detector: FailureDetector,
    /// What damping does not act on.
    undamped: Option<FreeMotion>,
}

impl Explicit {
    /// Returns a solver that takes steps of `step` seconds, which must be below the stability limit, or chooses them from it.
    pub fn new(step: Option<f64>) -> Self {
        Explicit {
            given: step,
            safety_factor: STEP_SAFETY_FACTOR,
            evaluator: None,
            generation: None,
            next: Vectors::default(),
            free: Vectors::default(),
            position: Vectors::default(),
            external: Forces::default(),
            loads: Forces::default(),
            inverse_inertia: Vec::new(),
            sums: Vec::new(),
            rounding_energy: 0.0,
            detector: FailureDetector::default(),
            undamped: None,
        }
    }

    /// Returns a solver that takes steps of this fraction of the stability limit.
    pub(super) fn with_safety_factor(safety_factor: f64) -> Self {
        Explicit {
            safety_factor,
            ..Explicit::new(None)
        }
    }

    /// Returns the largest stable step: the one that the world has, where it is recent, else computed anew.
    fn limit(&mut self, world: &World, context: &Context) -> Result<StabilityLimit, Cancelled> {
        self.prepare(&world.bundle);
        let recent = |known: &StabilityLimit| {
            known.generation == world.bundle.generation
                || world.state.step < known.step + LIMIT_UPDATE_INTERVAL
        };
        if let Some(known) = world.limit.filter(recent) {
            return Ok(known);
        }
        let limit = match &mut self.evaluator {
            Some(evaluator) => {
                stability::largest_step(&world.bundle, &world.state, evaluator, context)?
            }
            None => 0.0,
        };
        Ok(StabilityLimit {
            limit,
            generation: world.bundle.generation,
            step: world.state.step,
        })
    }

    fn prepare(&mut self, bundle: &RodBundle) {
        let n = bundle.vertices();
        match &mut self.evaluator {
            Some(evaluator) => _ = evaluator.refresh(bundle),
            None => self.evaluator = Some(ForceEvaluator::new(bundle)),
        }
        if self.generation != Some(bundle.generation) {
            self.generation = Some(bundle.generation);
            self.next = Vectors::zeros(n);
            self.free = Vectors::zeros(n);
            self.position = Vectors::zeros(n);
            self.external = Forces::zeros(n);
            self.loads = Forces::zeros(n);
            let inverse = |j: usize| {
                if bundle.is_edge(j) {
                    1.0 / bundle.inertia[j]
                } else {
                    0.0
                }
            };
            self.inverse_inertia = (0..n).map(inverse).collect();
            self.sums = vec![0.0; ForceEvaluator::blocks(n)];
            self.rounding_energy = rounding_energy(bundle);
        }
    }

    /// Takes `rate` (1/s) of the damping back from the motion of parts that nothing holds, as it is now, or no longer does so.
    pub(super) fn leave_undamped(&mut self, world: &World, rate: Option<f64>) {
        self.undamped = rate.map(|rate| {
            let World {
                bundle,
                state,
                loads,
                ..
            } = world;
            FreeMotion::new(bundle, state, loads, rate)
        });
    }

    /// Moves velocities by half a step of `dt` seconds against positions, forwards or, with a negative one, back: between
    /// solvers that have them at the same time and this one, which has them half a step behind.
    pub(super) fn shift_velocities(&mut self, world: &mut World, dt: f64) {
        self.prepare(&world.bundle);
        if let Some(evaluator) = &mut self.evaluator {
            kick(world, evaluator, 0.5 * dt);
        }
    }

    /// Takes a step of `dt` seconds.
    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        account: &mut Account,
        context: &Context,
    ) -> Result<(), SolverError> {
        context.check()?;
        self.prepare(&world.bundle);
        let Some(evaluator) = self.evaluator.as_mut() else {
            return Ok(());
        };
        let World {
            bundle,
            state,
            loads,
            ..
        } = world;
        let loaded = has_forces(loads);
        if let Some(undamped) = self.undamped.as_mut().filter(|u| !u.fits(bundle)) {
            *undamped = FreeMotion::new(bundle, state, loads, undamped.rate());
        }
        let has_external = loaded || bundle.twisting || self.undamped.is_some();
        if has_external {
            self.external.clear();
            let (x, v) = (&state.position, &state.velocity);
            loads.add_forces(bundle, state.time, x, v, &mut self.external);
        }
        if loaded {
            self.loads.clone_from(&self.external);
        }
        if bundle.twisting {
            evaluator.add_bend_twist(bundle, state, &mut self.external);
        }
        if let Some(undamped) = &self.undamped {
            undamped.add_forces(bundle, &mut self.external);
        }
        let damping_factor = 1.0 / (1.0 + loads.damping * dt);
        let step = ExplicitStep {
            external: has_external.then_some(&self.external.linear),
            step: dt,
            damping_factor,
        };
        evaluator.step(
            bundle,
            state,
            &step,
            &mut self.next,
            &mut self.position,
            &mut self.sums,
        );
        let mut kinetic: f64 = self.sums.iter().sum();
        let clamps = self.apply_clamps(world, dt, damping_factor);
        kinetic += clamps.kinetic_change;
        let load_work = if loaded {
            dt * power(&self.loads, &self.next)
        } else {
            0.0
        };
        // The work of −c m v along v Δt.
        account.report.damped += 2.0 * kinetic * (1.0 / damping_factor - 1.0);
        if let Some(undamped) = &self.undamped {
            account.report.damped -= dt * undamped.power(&world.bundle, &self.next);
        }
        account.report.work += clamps.work + load_work;
        account.budget += clamps.work + load_work;
        if !kinetic.is_finite()
            || kinetic > BLOW_UP_RATIO * account.budget.max(self.rounding_energy)
        {
            return Err(self.blow_up(world, dt));
        }
        self.finish_step(world, contacts, dt, account, context)
    }

    /// Sets the velocities of clamped vertices, on which damping had the factor `damping_factor`.
    fn apply_clamps(&mut self, world: &World, dt: f64, damping_factor: f64) -> ClampEffect {
        let World {
            bundle,
            state,
            loads,
            ..
        } = world;
        let mut effect = ClampEffect::default();
        for clamp in &loads.clamps {
            for (k, &v) in clamp.vertices.iter().enumerate() {
                let i = v as usize;
                let prescribed = (clamp.position(k, state.time + dt) - state.position.get(i)) / dt;
                let free = self.next.get(i);
                let mut new = free;
                for a in 0..3 {
                    if clamp.axes[a] {
                        new[a] = prescribed[a];
                    }
                }
                // The clamp's force over the step times the distance.
                effect.work += bundle.mass[i] * (new - free).dot(new) / damping_factor;
                effect.kinetic_change +=
                    0.5 * bundle.mass[i] * (new.length_squared() - free.length_squared());
                self.next.set(i, new);
                self.position.set(i, state.position.get(i) + new * dt);
            }
        }
        effect
    }

    /// Resolves contacts, takes the new positions and velocities, and lets break what fails.
    fn finish_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        account: &mut Account,
        context: &Context,
    ) -> Result<(), SolverError> {
        if !contacts.is_empty() {
            self.resolve_contacts(world, contacts, dt, account, context)?;
        }
        std::mem::swap(&mut world.state.velocity, &mut self.next);
        std::mem::swap(&mut world.state.position, &mut self.position);
        if world.bundle.twisting {
            self.turn_frames(world, dt, account);
        }
        let state = &mut world.state;
        state.time += dt;
        state.step += 1;
        if let Some(evaluator) = &mut self.evaluator {
            check_after_step(world, contacts, dt, evaluator, &mut self.detector);
        }
        Ok(())
    }

    /// Turns the material frames by a step of `dt` seconds at whose end the vertices already are: with the moments on them, and
    /// as clamps prescribe. Moments are `external`, that of loads alone `loads`.
    fn turn_frames(&mut self, world: &mut World, dt: f64, account: &mut Account) {
        let World {
            bundle,
            state,
            loads,
            ..
        } = world;
        let damping_factor = 1.0 / (1.0 + loads.damping * dt);
        let loaded = has_forces(loads);
        for j in 0..bundle.vertices() {
            let change = dt * self.inverse_inertia[j] * self.external.moment[j];
            state.spin[j] = (state.spin[j] + change) * damping_factor;
            state.angle[j] += dt * state.spin[j];
        }
        state.transport_frames(bundle);
        let mut work = apply_clamped_angles(bundle, loads, state, dt);
        if loads.damping > 0.0 {
            // The work of −c I ω along ω Δt.
            let twice_kinetic = (0..bundle.vertices()).fold(0.0, |s, j| {
                s + bundle.inertia[j] * state.spin[j] * state.spin[j]
            });
            account.report.damped += loads.damping * dt * twice_kinetic;
        }
        if let Some(undamped) = &self.undamped {
            account.report.damped -= dt * undamped.turning_power(bundle, &state.spin);
        }
        if loaded {
            let power = self.loads.moment.iter().zip(&state.spin);
            work += dt * power.fold(0.0, |s, (m, w)| s + m * w);
        }
        account.report.work += work;
        account.budget += work;
    }

    fn resolve_contacts(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        dt: f64,
        account: &mut Account,
        context: &Context,
    ) -> Result<(), SolverError> {
        let World {
            bundle,
            state,
            loads,
            ..
        } = world;
        self.free.clone_from(&self.next);
        let before = contacts.snapshot();
        let step = ContactStep {
            bundle,
            state,
            length: dt,
        };
        let given = match contacts.resolve(&step, &mut self.next, context) {
            Ok(given) => given,
            Err(error) => {
                contacts.restore(&before, bundle, loads);
                return Err(error);
            }
        };
        let Some(given) = given else {
            return Ok(());
        };
        account.budget += given.max(0.0);
        if let Some(undamped) = &self.undamped {
            let power = |velocity| undamped.power(bundle, velocity);
            account.report.damped -= dt * (power(&self.next) - power(&self.free));
        }
        let loaded = has_forces(loads);
        for i in 0..bundle.vertices() {
            let (free, new) = (self.free.get(i), self.next.get(i));
            self.position.set(i, state.position.get(i) + new * dt);
            // Damping and loads did their work along the actual path, not along the one without contact.
            if new != free {
                let change = new - free;
                let damped = loads.damping * dt * bundle.mass[i] * free.dot(change);
                account.report.damped += damped;
                if loaded {
                    let force = self.loads.linear.get(i);
                    account.report.work += dt * force.dot(change);
                }
            }
        }
        Ok(())
    }

    /// Finds the rod and the kind of energy that grew most in the step that blew up.
    fn blow_up(&mut self, world: &World, dt: f64) -> SolverError {
        let World { bundle, state, .. } = world;
        let mut after = state.clone();
        for i in 0..bundle.vertices() {
            after.velocity.set(i, self.next.get(i));
            after.position.set(i, self.position.get(i));
        }
        let (mut rod, mut energy, mut growth, mut was) = (0, "kinetic", f64::NEG_INFINITY, 0.0);
        for r in 0..bundle.rods() {
            for kind in [RodEnergy::Kinetic, RodEnergy::Stretch, RodEnergy::Bend] {
                let value = rod_energy(bundle, &after, r, kind);
                let value = if value.is_finite() {
                    value
                } else {
                    f64::INFINITY
                };
                let before = rod_energy(bundle, state, r, kind);
                if value - before > growth {
                    (rod, energy, growth, was) = (r, kind.name(), value - before, before);
                }
            }
        }
        SolverError::BlowUp {
            time: state.time,
            step: dt,
            rod: bundle.parent[rod],
            energy,
            before: was,
            after: was + growth,
        }
    }
}

/// Whether loads exert forces, other than by clamps and damping.
fn has_forces(loads: &Loads) -> bool {
    loads.gravity != DVec3::ZERO
        || !loads.forces.is_empty()
        || !loads.moments.is_empty()
        || loads.wind.is_some()
}

/// Returns the power of the forces on vertices at these velocities, W. That of moments follows when frames turn.
fn power(forces: &Forces, velocity: &Vectors) -> f64 {
    (0..forces.moment.len()).fold(0.0, |s, i| s + forces.linear.get(i).dot(velocity.get(i)))
}

/// Turns the frames of clamped edges as the clamps prescribe. Returns the work that this takes, J: as for vertices, the
/// moment over the step times the angle.
fn apply_clamped_angles(bundle: &RodBundle, loads: &Loads, state: &mut State, dt: f64) -> f64 {
    let mut work = 0.0;
    for clamp in &loads.clamps {
        for (k, &edge) in clamp.edges.iter().enumerate() {
            let j = edge as usize;
            let now = state.material_director(bundle, j);
            let wanted = clamp.director(k, state.time + dt);
            let tangent = state.tangent.get(j);
            let wanted = wanted.reject_from_normalized(tangent);
            let turn = material_frame::signed_angle(now, wanted, tangent);
            if turn.is_finite() {
                let change = turn / dt;
                state.angle[j] += turn;
                state.spin[j] += change;
                let impulse = bundle.inertia[j] * change * (1.0 + loads.damping * dt);
                work += impulse * state.spin[j];
            }
        }
    }
    work
}

/// Returns the energy of a strain of rounding in every edge, J.
fn rounding_energy(bundle: &RodBundle) -> f64 {
    let stiffest = bundle.stretch.iter().fold(0.0f64, |a, k| a.max(*k));
    let longest = bundle.rest_length.iter().fold(0.0f64, |a, l| a.max(*l));
    0.5 * stiffest * longest * bundle.vertices() as f64 * ROUNDING_STRAIN * ROUNDING_STRAIN
}

/// Kinds of a rod's energy.
#[derive(Clone, Copy)]
enum RodEnergy {
    Kinetic,
    Stretch,
    Bend,
}

impl RodEnergy {
    fn name(self) -> &'static str {
        match self {
            RodEnergy::Kinetic => "kinetic",
            RodEnergy::Stretch => "stretch",
            RodEnergy::Bend => "bend",
        }
    }
}

/// Returns the energy of a rod, J; bending energy only without twist.
fn rod_energy(bundle: &RodBundle, state: &State, rod: usize, kind: RodEnergy) -> f64 {
    bundle.rod(rod).fold(0.0, |sum, i| {
        sum + match kind {
            RodEnergy::Kinetic => 0.5 * bundle.mass[i] * state.velocity.get(i).length_squared(),
            RodEnergy::Stretch if bundle.is_edge(i) => {
                energy::rod::stretch_energy(bundle, state, i)
            }
            RodEnergy::Bend if bundle.bend[i] > 0.0 && !bundle.twisting => {
                energy::rod::bend_energy(bundle, state, i)
            }
            _ => 0.0,
        }
    })
}

impl Solver for Explicit {
    fn name(&self) -> &'static str {
        "explicit"
    }

    fn step(&mut self, world: &World, context: &Context) -> Result<f64, SolverError> {
        let limit = self.limit(world, context)?.limit;
        match self.given {
            None => Ok(self.safety_factor * limit),
            Some(given) if !(given > 0.0 && given.is_finite()) => Err(SolverError::Value {
                what: "the step (s)",
                value: given,
                right: "above 0 and finite",
            }),
            Some(given) if given > limit => Err(SolverError::UnstableStep { given, limit }),
            Some(given) => Ok(given),
        }
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
        let mut account = Account {
            budget: energies(&world.bundle, &world.state).total() + contacts.body_energy(),
            report: AdvanceReport::default(),
        };
        let end = world.state.time + duration;
        let mut left = duration;
        while left > 0.0 {
            context.report(1.0 - left / duration)?;
            let known = self.limit(world, context)?;
            world.limit = Some(known);
            account.report.limit = known.limit;
            let step = self.step(world, context)?;
            // Whole steps of equal length; the small difference is rounding.
            let count = (left / step - 1e-9).ceil().max(1.0);
            let dt = left / count;
            account.report.step = dt;
            let steps = (count as u64).min(LIMIT_UPDATE_INTERVAL);
            let mut taken = 0;
            while taken < steps {
                self.one_step(world, contacts, dt, &mut account, context)?;
                account.report.steps += 1;
                taken += 1;
                // A rod that broke between vertices has an edge as short as half of what it was.
                if world.limit.is_none() {
                    break;
                }
            }
            left = if taken as f64 == count {
                0.0
            } else {
                left - dt * taken as f64
            };
        }
        world.state.time = end;
        Ok(account.report)
    }
}
