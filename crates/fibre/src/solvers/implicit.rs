//! Implicit time steps for real stiffness at the steps of animation.
//!
//! Alexander's two-stage method (1977): singly diagonally implicit, of second order, L-stable. Each stage is an
//! equilibrium with inertia, found by Newton's method; motion much slower than the step is kept, vibration faster than it
//! dies out. What dies is measured: [`Advance::dissipated`] is the energy before the step, with the work of loads and
//! clamps as the method itself integrates them, less damping, yielding and the energy after.

use super::Stepwise;
use super::newton::{EXACT, Found, Goal, Inertia, Newton};
use super::quasi_static::commit_yield;
use crate::energy::{Forces, energies};
use crate::error::SolverError;
use crate::failure::{self, Break};
use crate::solver::{Advance, Contacts, Touch, World};
use crate::state::State;
use crate::vectors::Vectors;

/// γ = 1 − √½: both stages have the same matrix, and the method is L-stable.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// The step where none is given, s.
pub const STEP: f64 = 1.0 / 240.0;
/// A step that does not settle is halved this often.
const HALVINGS: u32 = 8;

/// The implicit solver.
#[derive(Debug, Clone)]
pub struct Implicit {
    given: Option<f64>,
    newton: Newton,
    queue: Vec<Break>,
}

/// A stage at its end.
struct Stage {
    state: State,
    velocity: Vectors,
    spin: Vec<f64>,
    touches: Vec<Touch>,
    /// Power of loads and clamps, and of damping, W.
    power: f64,
    damping: f64,
}

fn plus(a: &Vectors, b: &Vectors, by: f64) -> Vectors {
    (0..a.len()).map(|i| a.get(i) + b.get(i) * by).collect()
}

fn plus_numbers(a: &[f64], b: &[f64], by: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b * by).collect()
}

impl Implicit {
    /// A solver with steps of `step` seconds, or 1/240 s.
    pub fn new(step: Option<f64>) -> Self {
        Implicit {
            given: step,
            newton: Newton::in_manner(EXACT),
            queue: Vec::new(),
        }
    }

    fn stage(
        &mut self,
        world: &World,
        base: &State,
        inertia: &Inertia,
        contacts: &mut dyn Contacts,
        time: f64,
    ) -> Result<Stage, SolverError> {
        let World { bundle, loads, .. } = world;
        let goal = Goal {
            bundle,
            loads,
            yielding: world.failure.rods_yield,
            from: &world.state,
            inertia: Some(inertia),
            time,
        };
        let Found {
            state,
            reaction,
            touches,
            ..
        } = self.newton.solve(&goal, base, base, contacts)?;
        let mut velocity = plus(&state.position, &inertia.behind, -1.0);
        for v in [&mut velocity.x, &mut velocity.y, &mut velocity.z] {
            v.iter_mut().for_each(|v| *v /= inertia.h);
        }
        let mut spin = plus_numbers(&state.angle, &inertia.angle_behind, -1.0);
        spin.iter_mut().for_each(|s| *s /= inertia.h);
        let mut acting = Forces::zeros(bundle.vertices());
        let Forces { linear, moment } = &mut acting;
        loads.add_forces(bundle, time, &state.position, &velocity, linear, moment);
        let (mut power, mut damping) = (0.0, 0.0);
        for v in 0..bundle.vertices() {
            power += (linear.get(v) + reaction.get(v)).dot(velocity.get(v));
            damping += bundle.mass[v] * velocity.get(v).length_squared();
            if bundle.twisting {
                power += moment[v] * spin[v];
                damping += bundle.inertia[v] * spin[v] * spin[v];
            }
        }
        Ok(Stage {
            state,
            velocity,
            spin,
            touches,
            power,
            damping: loads.damping * damping,
        })
    }

    /// Both stages of a step of `dt`.
    fn stages(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        dt: f64,
    ) -> Result<[Stage; 2], SolverError> {
        let (old, h) = (&world.state, GAMMA * dt);
        self.newton.prepare(&world.bundle, &[]);
        let inertia = Inertia {
            h,
            ahead: plus(&old.position, &old.velocity, h),
            behind: old.position.clone(),
            angle_ahead: plus_numbers(&old.angle, &old.spin, h),
            angle_behind: old.angle.clone(),
        };
        let first = self.stage(world, old, &inertia, contacts, old.time + h)?;
        // v₀ + (1 − γ) Δt a₁ with a₁ = (v₁ − v₀)/h.
        let part = (1.0 - GAMMA) / GAMMA;
        let pushed = plus(
            &plus(&old.velocity, &first.velocity, part),
            &old.velocity,
            -part,
        );
        let turned = plus_numbers(
            &plus_numbers(&old.spin, &first.spin, part),
            &old.spin,
            -part,
        );
        let behind = plus(&old.position, &first.velocity, (1.0 - GAMMA) * dt);
        let angle_behind = plus_numbers(&old.angle, &first.spin, (1.0 - GAMMA) * dt);
        let inertia = Inertia {
            h,
            ahead: plus(&behind, &pushed, h),
            angle_ahead: plus_numbers(&angle_behind, &turned, h),
            behind,
            angle_behind,
        };
        let second = self.stage(world, &first.state, &inertia, contacts, old.time + dt)?;
        Ok([first, second])
    }

    /// A step, or its halves where it does not settle.
    fn step_or_halves(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        halved: u32,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
        let [first, second] = match self.stages(world, contacts, dt) {
            Ok(stages) => stages,
            Err(SolverError::NotConverged { .. }) if halved < HALVINGS => {
                let saved = world.clone();
                for _ in 0..2 {
                    if let Err(error) =
                        self.step_or_halves(world, contacts, 0.5 * dt, halved + 1, report)
                    {
                        *world = saved;
                        return Err(error);
                    }
                }
                return Ok(());
            }
            Err(other) => return Err(other),
        };
        let before = energies(&world.bundle, &world.state).total() + contacts.stored();
        let old = std::mem::replace(&mut world.state, second.state);
        world.state.velocity = second.velocity;
        world.state.spin = second.spin;
        world.state.time = old.time + dt;
        world.state.step = old.step + 1;
        let lost = commit_yield(world, &old);
        world.fracture_loss += lost;
        let work = dt * ((1.0 - GAMMA) * first.power + GAMMA * second.power);
        let damped = dt * ((1.0 - GAMMA) * first.damping + GAMMA * second.damping);
        let book = contacts.accept(&old, old.time + dt, &second.touches);
        let after = energies(&world.bundle, &world.state).total() + book.stored;
        report.work += work;
        report.damped += damped;
        report.dissipated += before + work + book.work - book.lost - damped - lost - after;
        report.steps += 1;
        let interval = u64::from(world.failure.interval.max(1));
        if world.state.step.is_multiple_of(interval) {
            failure::detect(&world.failure, &world.bundle, &world.state, &mut self.queue);
            if !self.queue.is_empty() {
                failure::apply(world, contacts, &self.queue);
            }
        }
        Ok(())
    }
}

impl Stepwise for Implicit {
    const NAME: &'static str = "implicit";
    const USUAL: f64 = STEP;

    fn given(&self) -> Option<f64> {
        self.given
    }

    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
        self.step_or_halves(world, contacts, dt, 0, report)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bundle, NoContacts, Rod, RodMaterial, Solver};
    use glam::DVec3;

    /// A rod that swings in its first mode of stretch, of period T, at steps of T/`steps`: the part of its energy that is
    /// lost over a period or a longer step, and whether the report says so.
    fn lost(steps: f64) -> f64 {
        let material = RodMaterial::solid(1e-4, 1e7, 1e6, 1000.0);
        let rod = Rod::new(vec![DVec3::ZERO, DVec3::Z * 0.1], material);
        let mut world = World::new(Bundle::new(&[rod], false).unwrap());
        let (mass, k) = (world.bundle.mass[0], material.stretch / 0.1);
        world.state.position.set(1, DVec3::Z * 0.1001);
        world.state.position.set(0, DVec3::Z * -1e-4);
        let period = std::f64::consts::TAU * (mass / (2.0 * k)).sqrt();
        let before = energies(&world.bundle, &world.state).total();
        let told = Implicit::new(Some(period / steps))
            .advance(&mut world, &mut NoContacts, period / steps.min(1.0))
            .unwrap();
        let after = energies(&world.bundle, &world.state).total();
        assert!((told.dissipated - (before - after)).abs() < 1e-9 * before);
        (before - after) / before
    }

    #[test]
    fn slow_motion_is_kept_to_third_order_and_fast_motion_dies() {
        // Halving the step of a method of second order leaves an eighth of the loss.
        let (coarse, fine) = (lost(20.0), lost(40.0));
        assert!(coarse > 0.0 && coarse < 0.02, "{coarse}");
        assert!((6.5..9.5).contains(&(coarse / fine)), "{}", coarse / fine);
        assert!(lost(0.05) > 0.99);
    }
}
