//! Load steps to equilibrium, for mechanical tests (issue "Solvers" 4): clamps and grips move, everything comes to rest,
//! the most overstressed breaks, everything comes to rest again, event by event. Loads are displacements, so the load
//! may fall: the solver passes the peak.
//!
//! Time is only a name for how far loads have gone. A step in which something would be overstressed by more than
//! `OVERSHOOT` is done again, shorter, so that the load at a break does not depend on the steps.

use super::grips::Grip;
use super::newton::{EXACT, Found, Goal, Inertia, Newton};
use crate::energy::{energies, rod};
use crate::error::SolverError;
use crate::event::{Cause, Event, EventKind};
use crate::failure::{self, Break};
use crate::solver::{Advance, Contacts, Solver, World};
use crate::state::State;

/// Steps of a call of advance where none is given.
const STEPS: f64 = 32.0;
/// A step that does not settle is halved, and one that overstresses shortened, this often.
const TRIES: i32 = 12;
/// Overstress that is let pass: demand over strength less 1.
const OVERSHOOT: f64 = 5e-3;

/// Most steps in which what Newton's method cannot settle at once creeps to rest.
const CREEPS: usize = 60;
/// The first of them, in periods of the quickest edge over 2π.
const FIRST_CREEP: f64 = 100.0;
/// What takes fewer iterations than the first number makes the next step longer by the second.
const LONGER: [(usize, f64); 4] = [(8, 4.0), (16, 2.0), (28, 1.0), (usize::MAX, 0.5)];
/// A step that fails is tried shorter by this.
const SHORTER: f64 = 0.25;
/// Where steps have become longer than the first by this, mass hardly slows any more and the equilibrium is tried anew.
const REST: f64 = 64.0;

/// The quasi-static solver.
#[derive(Debug, Clone, Default)]
pub struct QuasiStatic {
    given: Option<f64>,
    grips: Vec<Grip>,
    newton: Newton,
    queue: Vec<Break>,
    iterations: u64,
}

impl QuasiStatic {
    /// A solver with load steps of `step` seconds, or a thirty-second of what it is asked to advance by.
    pub fn new(step: Option<f64>) -> Self {
        QuasiStatic {
            given: step,
            ..QuasiStatic::default()
        }
    }

    /// The same, remembering nothing from one load step to the next, so that a run can be resumed in the same bytes. It
    /// takes no grips.
    pub fn forgetful(step: Option<f64>) -> Self {
        QuasiStatic {
            given: step,
            newton: Newton::in_manner(EXACT),
            ..QuasiStatic::default()
        }
    }

    /// The same with grips.
    #[must_use]
    pub fn with_grips(mut self, grips: Vec<Grip>) -> Self {
        self.grips = grips;
        self
    }

    /// Forces of the grips on the world as it is, N.
    pub fn grip_forces(&mut self, world: &World) -> Vec<f64> {
        self.newton.prepare(&world.bundle, &self.grips);
        self.newton
            .grip_forces(&world.bundle, &world.state, world.state.time)
    }

    /// Mean displacements of what the grips hold, m.
    pub fn grip_displacements(&mut self, world: &World) -> Vec<f64> {
        self.newton.prepare(&world.bundle, &self.grips);
        self.newton.grip_displacements(&world.bundle, &world.state)
    }

    /// Newton iterations and factors of matrices so far.
    pub fn effort(&self) -> (u64, usize) {
        (self.iterations, self.newton.factors())
    }

    fn equilibrium(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        time: f64,
    ) -> Result<Found, SolverError> {
        self.newton.prepare(&world.bundle, &self.grips);
        let goal = Goal {
            bundle: &world.bundle,
            loads: &world.loads,
            yielding: world.failure.rods_yield,
            from: &world.state,
            inertia: None,
            time,
        };
        let (newton, state) = (&mut self.newton, &world.state);
        let found = match newton.solve(&goal, state, state, contacts) {
            // Loads that go on may go less far; what a break let go has nowhere to go back to.
            Err(SolverError::NotConverged { .. }) if time == world.state.time => {
                self.creep(&goal, world, contacts)?
            }
            other => other?,
        };
        self.iterations += found.iterations as u64;
        Ok(found)
    }

    /// Comes to rest after a break by backward Euler steps without velocity: what has snapped loose moves to a new
    /// equilibrium as through honey, and edges may yield on the way.
    fn creep(
        &mut self,
        goal: &Goal,
        world: &World,
        contacts: &mut dyn Contacts,
    ) -> Result<Found, SolverError> {
        let bundle = goal.bundle;
        let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
        let quickest = edges.fold(f64::INFINITY, |least, j| {
            let mass = bundle.mass[j].min(bundle.mass[j + 1]);
            least.min((mass * bundle.rest_length[j] / bundle.stretch[j]).sqrt())
        });
        let first = FIRST_CREEP * quickest;
        let mut h = first;
        let mut state = world.state.clone();
        let mut iterations = 0;
        for _ in 0..CREEPS {
            let inertia = Inertia {
                h,
                ahead: state.position.clone(),
                behind: state.position.clone(),
                angle_ahead: state.angle.clone(),
                angle_behind: state.angle.clone(),
            };
            let slowed = Goal {
                inertia: Some(&inertia),
                ..*goal
            };
            let found = match self.newton.solve(&slowed, &state, &state, contacts) {
                Ok(found) => found,
                Err(SolverError::NotConverged { .. }) => {
                    h *= SHORTER;
                    continue;
                }
                Err(other) => return Err(other),
            };
            state = found.state;
            iterations += found.iterations;
            if h >= REST * first {
                match self.newton.solve(goal, &state, &state, contacts) {
                    Ok(rest) => {
                        return Ok(Found {
                            iterations: rest.iterations + iterations,
                            ..rest
                        });
                    }
                    Err(SolverError::NotConverged { .. }) => {}
                    Err(other) => return Err(other),
                }
            }
            let longer = LONGER.iter().find(|l| found.iterations < l.0);
            h *= longer.map_or(1.0, |l| l.1);
        }
        self.newton.solve(goal, &state, &state, contacts)
    }

    /// Goes to the next equilibrium on the way to `time` (s): what is most overstressed breaks, and where nothing is the
    /// loads go on, to `time` or to where the first thing breaks.
    ///
    /// # Errors
    /// [`SolverError`]; the world is then as it was.
    pub fn next_equilibrium(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        time: f64,
    ) -> Result<Advance, SolverError> {
        let mut report = Advance {
            limit: f64::INFINITY,
            step: time - world.state.time,
            ..Advance::default()
        };
        let one = failure::Failure {
            at_once: 1,
            ..world.failure
        };
        failure::detect(&one, &world.bundle, &world.state, &mut self.queue);
        if !self.queue.is_empty() {
            let now = world.state.time;
            let saved = world.clone();
            failure::apply(world, contacts, &self.queue);
            let settled = self.equilibrium(world, contacts, now);
            let accepted =
                settled.and_then(|found| self.accept(world, contacts, found, now, &mut report));
            if let Err(error) = accepted {
                *world = saved;
                return Err(error);
            }
            return Ok(report);
        }
        let start = world.state.time;
        let before = most_overstressed(world, &world.state);
        let (mut aim, mut tried) = (time, 0);
        let found = loop {
            tried += 1;
            match self.equilibrium(world, contacts, aim) {
                Ok(found) => {
                    let after = most_overstressed(world, &found.state);
                    if after <= 1.0 + OVERSHOOT || tried > TRIES {
                        break found;
                    }
                    // A hair beyond, so that it breaks.
                    let part = (1.0 + 0.5 * OVERSHOOT - before) / (after - before);
                    aim = start + (aim - start) * part.clamp(0.02, 0.98);
                }
                Err(SolverError::NotConverged { .. }) if tried <= TRIES => {
                    aim = start + 0.5 * (aim - start);
                }
                Err(other) => return Err(other),
            }
        };
        self.accept(world, contacts, found, aim, &mut report)?;
        Ok(report)
    }

    fn accept(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        found: Found,
        time: f64,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
        let stored = energies(&world.bundle, &world.state).potential() + contacts.stored();
        let old = std::mem::replace(&mut world.state, found.state);
        let step = time - old.time;
        world.state.time = time;
        world.state.step += 1;
        let lost = commit_yield(world, &old);
        world.fracture_loss += lost;
        let mut work = 0.0;
        for v in 0..world.bundle.vertices() {
            let way = world.state.position.get(v) - old.position.get(v);
            work += found.reaction.get(v).dot(way);
        }
        let grips = self.newton.grip_forces(&world.bundle, &world.state, time);
        for (g, force) in self.grips.iter().zip(grips) {
            work += force * g.speed * step;
        }
        report.work += work;
        let book = contacts.accept(&old, time, &found.touches);
        let now = energies(&world.bundle, &world.state).potential() + book.stored;
        if step == 0.0 {
            // What a break lets go at standing clamps would have become motion and heat.
            report.dissipated += (stored - now - lost).max(0.0);
        }
        world.state.velocity.clear_to_zero();
        world.state.spin.fill(0.0);
        report.steps += 1;
        Ok(())
    }
}

/// The largest demand over strength in a state.
pub(super) fn most_overstressed(world: &World, state: &State) -> f64 {
    let (bundle, failure) = (&world.bundle, &world.failure);
    let mut most = 0.0f64;
    if failure.rods_break {
        for r in 0..bundle.rods() {
            for v in bundle.rod(r) {
                most = most.max(failure::rod_demand(bundle, state, v, bundle.diameter[r]));
            }
        }
    }
    if failure.bonds != failure::BondCriterion::Never {
        for b in 0..bundle.bonds.len() {
            most = most.max(failure::bond_demand(failure.bonds, bundle, state, b));
        }
    }
    most
}

/// Notes what has begun to yield since `old`; returns the energy that yielding took, J.
pub(super) fn commit_yield(world: &mut World, old: &State) -> f64 {
    let World {
        bundle,
        state,
        events,
        ..
    } = world;
    let mut taken = 0.0;
    for j in 0..bundle.vertices() {
        let more = old.plastic_strain[j] - state.plastic_strain[j];
        if !bundle.is_edge(j) || more == 0.0 {
            continue;
        }
        let limit = bundle.yield_strain[j];
        let energy = bundle.stretch[j] * limit * more * bundle.rest_length[j];
        taken += energy;
        if old.plastic_strain[j] == 0.0 {
            events.push(Event {
                time: state.time,
                kind: EventKind::RodYielded,
                rod: bundle.parent[bundle.rod_of(j)],
                vertex: bundle.origin[j],
                other: None,
                place: state.position.get(j).midpoint(state.position.get(j + 1)),
                cause: Cause::Compression,
                demand: (more - rod::strain(bundle, state, j)) / limit,
                energy,
            });
        }
    }
    taken
}

impl Solver for QuasiStatic {
    fn name(&self) -> &'static str {
        "quasi-static"
    }

    fn step(&mut self, _: &World) -> Result<f64, SolverError> {
        super::given_step(self.given, f64::INFINITY)
    }

    fn advance(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        duration: f64,
    ) -> Result<Advance, SolverError> {
        super::check_duration(duration)?;
        world.check()?;
        let full = self.step(world)?.min(duration / STEPS);
        let full = self.given.unwrap_or(full);
        let end = world.state.time + duration;
        let mut report = Advance {
            limit: f64::INFINITY,
            step: full,
            ..Advance::default()
        };
        while world.state.time < end || most_overstressed(world, &world.state) >= 1.0 {
            let mut time = world.state.time + full;
            if time > end - 1e-9 * full {
                time = end;
            }
            let one = self.next_equilibrium(world, contacts, time)?;
            report.steps += one.steps;
            report.work += one.work;
            report.dissipated += one.dissipated;
        }
        Ok(report)
    }
}
