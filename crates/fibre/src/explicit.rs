//! Symplectic Euler, as published (Sutherland 2012 §4.1): the reference that other solvers are measured against.
//!
//! v ← (v + Δt a(x)) / (1 + c Δt), x ← x + Δt v. The step is a part of the stability limit 2/ω_max. Without damping the
//! method keeps a quantity near the energy for all times: it dissipates nothing.

use crate::bundle::Bundle;
use crate::energy::{Forces, energies, rod};
use crate::error::SolverError;
use crate::failure;
use crate::kernel::{Evaluator, Step};
use crate::solver::{Advance, Contacts, KnownLimit, Solver, World};
use crate::stability;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;

/// Part of the stability limit that is taken where no step is given. The limit is that of the state it was found in;
/// strains of a few percent change it by as much.
const SAFETY: f64 = 0.8;
/// After something has broken the limit is found again, but not more often than every so many steps.
const LIMIT_INTERVAL: u64 = 400;
/// The motion has blown up where its kinetic energy is above this many times all energy that there can be. Near the limit
/// a stable motion shows 1/(1 − (ω Δt/2)²) times its energy: three times at the part of it that is taken.
pub const BLOW_UP: f64 = 16.0;
/// Rounding moves even a bundle at rest: strain of rounding, whose energy is never a blow-up.
const ROUNDING_STRAIN: f64 = 1e-9;

/// The explicit solver.
#[derive(Debug, Clone)]
pub struct Explicit {
    given: Option<f64>,
    evaluator: Option<Evaluator>,
    /// Velocities after the step.
    next: Vectors,
    /// The same before contacts.
    free: Vectors,
    /// Positions after the step.
    place: Vectors,
    /// Loads, and with twist the forces in material frames.
    outside: Forces,
    /// Loads alone.
    loads: Forces,
    inverse_inertia: Vec<f64>,
    sums: Vec<f64>,
    /// Energy of a strain of rounding, J.
    rounding: f64,
    breaks: failure::Room,
}

impl Explicit {
    /// A solver that chooses its step from the stability limit, or takes the step given (s) where it is below it.
    pub fn new(step: Option<f64>) -> Self {
        Explicit {
            given: step,
            evaluator: None,
            next: Vectors::default(),
            free: Vectors::default(),
            place: Vectors::default(),
            outside: Forces::default(),
            loads: Forces::default(),
            inverse_inertia: Vec::new(),
            sums: Vec::new(),
            rounding: 0.0,
            breaks: failure::Room::default(),
        }
    }

    /// The largest stable step, as known to the world or found for it.
    fn limit(&mut self, world: &World) -> KnownLimit {
        self.prepare(&world.bundle);
        let current = |known: &KnownLimit| {
            known.generation == world.bundle.generation
                || world.state.step < known.step + LIMIT_INTERVAL
        };
        match (world.limit.filter(current), &mut self.evaluator) {
            (None, Some(evaluator)) => KnownLimit {
                limit: stability::limit(&world.bundle, &world.state, evaluator),
                generation: world.bundle.generation,
                step: world.state.step,
            },
            (known, _) => known.unwrap_or(KnownLimit {
                limit: 0.0,
                generation: 0,
                step: 0,
            }),
        }
    }

    fn prepare(&mut self, bundle: &Bundle) {
        let n = bundle.vertices();
        let changed = match &mut self.evaluator {
            Some(evaluator) => evaluator.refresh(bundle),
            None => {
                self.evaluator = Some(Evaluator::new(bundle));
                true
            }
        };
        if changed {
            self.next = Vectors::zeros(n);
            self.free = Vectors::zeros(n);
            self.place = Vectors::zeros(n);
            self.outside = Forces::zeros(n);
            self.loads = Forces::zeros(n);
            let inverse = |j: usize| {
                if bundle.is_edge(j) {
                    1.0 / bundle.inertia[j]
                } else {
                    0.0
                }
            };
            self.inverse_inertia = (0..n).map(inverse).collect();
            self.sums = vec![0.0; Evaluator::blocks(n)];
            self.rounding = rounding(bundle);
        }
    }

    /// One step of `dt` seconds. `budget` is all energy that there can be, J.
    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        budget: &mut f64,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
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
        let plain = loads.forces.is_empty()
            && loads.moments.is_empty()
            && loads.wind.is_none()
            && loads.snow == 0.0;
        let weightless = loads.gravity == DVec3::ZERO;
        let acts = !plain || !weightless;
        let outside = acts || bundle.twisting;
        let mut loaded = 0.0;
        if outside {
            self.outside.clear();
            let Forces { linear, moment } = &mut self.outside;
            loads.add_forces(
                bundle,
                state.time,
                &state.position,
                &state.velocity,
                linear,
                moment,
            );
        }
        if bundle.twisting {
            if acts {
                self.loads.clone_from(&self.outside);
            }
            evaluator.add_framed(bundle, state, &mut self.outside);
        }
        let keep = 1.0 / (1.0 + loads.damping * dt);
        let step = Step {
            outside: outside.then_some(&self.outside.linear),
            step: dt,
            keep,
        };
        evaluator.step(
            bundle,
            state,
            &step,
            &mut self.next,
            &mut self.place,
            &mut self.sums,
        );
        let mut kinetic: f64 = self.sums.iter().sum();
        let held = self.hold(world, dt, keep);
        kinetic += held.1;
        if acts {
            let from = if world.bundle.twisting {
                &self.loads
            } else {
                &self.outside
            };
            loaded = dt * power(from, &self.next, &world.state.spin);
        }
        // The work of −c m v along v Δt.
        report.damped += 2.0 * kinetic * (1.0 / keep - 1.0);
        report.work += held.0 + loaded;
        *budget += held.0 + loaded;
        if !kinetic.is_finite() || kinetic > BLOW_UP * budget.max(self.rounding) {
            return Err(self.blow_up(world, dt));
        }
        self.finish_step(world, contacts, dt, acts, budget, report)
    }

    /// Sets the velocities of clamped vertices, of which damping has kept the part `keep`; returns the clamps' work and the change of kinetic energy, J.
    fn hold(&mut self, world: &World, dt: f64, keep: f64) -> (f64, f64) {
        let World {
            bundle,
            state,
            loads,
            ..
        } = world;
        let (mut work, mut change) = (0.0, 0.0);
        for clamp in &loads.clamps {
            for (k, &v) in clamp.vertices.iter().enumerate() {
                let i = v as usize;
                let wanted = (clamp.place(k, state.time + dt) - state.position.get(i)) / dt;
                let free = self.next.get(i);
                let mut new = free;
                for a in 0..3 {
                    if clamp.axes[a] {
                        new[a] = wanted[a];
                    }
                }
                // The clamp's force over the step times the way.
                work += bundle.mass[i] * (new - free).dot(new) / keep;
                change += 0.5 * bundle.mass[i] * (new.length_squared() - free.length_squared());
                self.next.set(i, new);
                self.place.set(i, state.position.get(i) + new * dt);
            }
        }
        (work, change)
    }

    fn finish_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        acts: bool,
        budget: &mut f64,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
        let World {
            bundle,
            state,
            loads,
            ..
        } = world;
        if !contacts.is_empty() {
            self.free.clone_from(&self.next);
            if let Some(given) = contacts.resolve(bundle, state, &mut self.next, dt)? {
                *budget += given.max(0.0);
                let from = match bundle.twisting {
                    true => &self.loads.linear,
                    false => &self.outside.linear,
                };
                for i in 0..bundle.vertices() {
                    let (free, new) = (self.free.get(i), self.next.get(i));
                    self.place.set(i, state.position.get(i) + new * dt);
                    // Damping and loads did their work on the way that was gone, not on the one that was free.
                    if new != free {
                        let change = new - free;
                        report.damped += loads.damping * dt * bundle.mass[i] * free.dot(change);
                        if acts {
                            report.work += dt * from.get(i).dot(change);
                        }
                    }
                }
            }
        }
        std::mem::swap(&mut state.velocity, &mut self.next);
        std::mem::swap(&mut state.position, &mut self.place);
        if bundle.twisting {
            let keep = 1.0 / (1.0 + loads.damping * dt);
            for j in 0..bundle.vertices() {
                let push = dt * self.inverse_inertia[j] * self.outside.moment[j];
                state.spin[j] = (state.spin[j] + push) * keep;
                state.angle[j] += dt * state.spin[j];
            }
            state.carry_frames(bundle);
            hold_angles(bundle, loads, state, dt);
        }
        state.time += dt;
        state.step += 1;
        if let Some(evaluator) = &mut self.evaluator {
            failure::after_step(world, contacts, evaluator, &mut self.breaks);
        }
        Ok(())
    }

    /// Which rod has the most of which energy, after the step that blew up.
    fn blow_up(&mut self, world: &World, dt: f64) -> SolverError {
        let World { bundle, state, .. } = world;
        let mut after = state.clone();
        for i in 0..bundle.vertices() {
            after.velocity.set(i, self.next.get(i));
            after.position.set(i, self.place.get(i));
        }
        let (mut rod, mut energy, mut most, mut was) = (0, "kinetic", f64::NEG_INFINITY, 0.0);
        for r in 0..bundle.rods() {
            for (kind, name) in ["kinetic", "stretch", "bend"].into_iter().enumerate() {
                let value = rod_energy(bundle, &after, r, kind);
                let value = if value.is_finite() {
                    value
                } else {
                    f64::INFINITY
                };
                let before = rod_energy(bundle, state, r, kind);
                if value - before > most {
                    (rod, energy, most, was) = (r, name, value - before, before);
                }
            }
        }
        SolverError::BlowUp {
            time: state.time,
            step: dt,
            rod: bundle.parent[rod],
            energy,
            before: was,
            after: was + most,
        }
    }
}

/// Power of forces and moments at velocities, W.
fn power(forces: &Forces, velocity: &Vectors, spin: &[f64]) -> f64 {
    let linear =
        (0..forces.moment.len()).fold(0.0, |s, i| s + forces.linear.get(i).dot(velocity.get(i)));
    forces
        .moment
        .iter()
        .zip(spin)
        .fold(linear, |s, (m, w)| s + m * w)
}

/// Turns the frames of clamped edges to where the clamps have them.
fn hold_angles(bundle: &Bundle, loads: &crate::loads::Loads, state: &mut State, dt: f64) {
    for clamp in &loads.clamps {
        for (k, &edge) in clamp.edges.iter().enumerate() {
            let j = edge as usize;
            let now = state.material_director(bundle, j);
            let wanted = clamp.director(k, state.time + dt);
            let tangent = state.tangent.get(j);
            let wanted = wanted.reject_from_normalized(tangent);
            let turn = crate::frames::angle_about(now, wanted, tangent);
            if turn.is_finite() {
                state.angle[j] += turn;
                state.spin[j] = 0.0;
            }
        }
    }
}

/// Energy of a strain of rounding in every edge, J.
fn rounding(bundle: &Bundle) -> f64 {
    let stiffest = bundle.stretch.iter().fold(0.0f64, |a, k| a.max(*k));
    let longest = bundle.rest_length.iter().fold(0.0f64, |a, l| a.max(*l));
    0.5 * stiffest * longest * bundle.vertices() as f64 * ROUNDING_STRAIN * ROUNDING_STRAIN
}

/// Kinetic (0), stretch (1) or plain bending energy (2) of a rod, J.
fn rod_energy(bundle: &Bundle, state: &State, rod: usize, kind: usize) -> f64 {
    bundle.rod(rod).fold(0.0, |sum, i| {
        sum + match kind {
            0 => 0.5 * bundle.mass[i] * state.velocity.get(i).length_squared(),
            1 if bundle.is_edge(i) => rod::stretch(bundle, state, i).value,
            2 if bundle.bend[i] > 0.0 && !bundle.twisting => rod::bend_energy(bundle, state, i),
            _ => 0.0,
        }
    })
}

impl Solver for Explicit {
    fn name(&self) -> &'static str {
        "explicit"
    }

    fn step(&mut self, world: &World) -> Result<f64, SolverError> {
        let limit = self.limit(world).limit;
        match self.given {
            None => Ok(SAFETY * limit),
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
    ) -> Result<Advance, SolverError> {
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(SolverError::Value {
                what: "the time to advance by (s)",
                value: duration,
                right: "0 or more and finite",
            });
        }
        world.check()?;
        let mut report = Advance::default();
        let mut budget = energies(&world.bundle, &world.state).total() + contacts.energy();
        let end = world.state.time + duration;
        let mut left = duration;
        while left > 0.0 {
            let known = self.limit(world);
            world.limit = Some(known);
            report.limit = known.limit;
            let step = self.step(world)?;
            // Whole steps of equal length; a hair over is rounding.
            let count = (left / step - 1e-9).ceil().max(1.0);
            let dt = left / count;
            report.step = dt;
            let steps = (count as u64).min(LIMIT_INTERVAL);
            for _ in 0..steps {
                self.one_step(world, contacts, dt, &mut budget, &mut report)?;
                report.steps += 1;
            }
            left = if steps as f64 == count {
                0.0
            } else {
                left - dt * steps as f64
            };
        }
        world.state.time = end;
        Ok(report)
    }
}
