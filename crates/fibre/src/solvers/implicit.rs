//! Implicit time steps: real stiffness at the steps of animation.
//!
//! Alexander's two-stage method (1977): singly diagonally implicit, of second order, L-stable. Each stage is an equilibrium
//! with inertia, found by Newton's method. Motion much slower than the step is conserved, vibration faster than it dies out.
//! What the method takes is computed by itself, so that the balance of energy is a check. A Runge–Kutta method with weights bᵢ
//! and coefficients aᵢⱼ changes the kinetic energy by the work of the forces, Σ bᵢ Fᵢ·vᵢ Δt, less ½ Δt² Σ mᵢⱼ Fᵢ M⁻¹ Fⱼ with mᵢⱼ = bᵢ aᵢⱼ + bⱼ aⱼᵢ
//! − bᵢ bⱼ (Hairer, Lubich and Wanner, *Geometric Numerical Integration*, section IV.2); here m₁₂ = 0. The potential falls by the
//! work of its forces in the same sum and a gap. Both together are [`AdvanceReport::dissipated`].

use super::balance::{EquilibriumProblem, Inertia};
use super::newton::{Equilibrium, Newton, NewtonOptions};
use super::solver::AdvanceReport;
use super::stepwise::Stepwise;
use crate::contact::{ContactSpring, Contacts};
use crate::energy::energies;
use crate::error::SolverError;
use crate::failure::breaking::{break_elements, find_softened_bonds, take_damage};
use crate::failure::demand::{Overstressed, find_overstressed};
use crate::failure::yielding::record_yielding;
use crate::forces::Forces;
use crate::state::State;
use crate::vectors::Vectors;
use crate::world::World;
use greenstick_geometry::Context;

/// γ = 1 − √½: both stages have the same matrix, and the method is L-stable.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// m₁₁ and m₂₂: what squares of accelerations take from the kinetic energy.
const KINETIC_LOSS: [f64; 2] = [(1.0 - GAMMA) * (3.0 * GAMMA - 1.0), GAMMA * GAMMA];
/// The step where none is given, s.
pub(crate) const DEFAULT_STEP: f64 = 1.0 / 240.0;
/// A step that does not converge is halved at most this often.
const MAX_HALVINGS: u32 = 8;

/// The implicit solver: Alexander's two-stage method.
#[derive(Debug, Clone)]
pub struct Implicit {
    given: Option<f64>,
    newton: Newton,
    queue: Vec<Overstressed>,
}

/// The end of a stage.
struct Stage {
    state: State,
    velocity: Vectors,
    spin: Vec<f64>,
    springs: Vec<ContactSpring>,
    /// Bonds that are softer than before the step, with their damage.
    softened: Vec<(u32, f64)>,
    /// Power of loads and clamps, W.
    power: f64,
    /// Power of damping, W.
    damping: f64,
    /// Power of rods, bonds and contacts, W.
    internal: f64,
    /// Mass times the square of the acceleration, W/s.
    squared_acceleration: f64,
}

/// What a stage starts from: its acceleration is the change from this velocity over its length.
struct StageStart<'a> {
    inertia: &'a Inertia,
    velocity: &'a Vectors,
    spin: &'a [f64],
}

/// Returns a + `by` b.
fn add_scaled(a: &Vectors, b: &Vectors, by: f64) -> Vectors {
    (0..a.len()).map(|i| a.get(i) + b.get(i) * by).collect()
}

/// Returns a + `by` b.
fn add_scaled_numbers(a: &[f64], b: &[f64], by: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b * by).collect()
}

impl Implicit {
    /// Returns a solver with steps of `step` seconds, or 1/240 s.
    pub fn new(step: Option<f64>) -> Self {
        Implicit {
            given: step,
            newton: Newton::with_options(NewtonOptions::STATELESS),
            queue: Vec::new(),
        }
    }

    fn stage(
        &mut self,
        world: &World,
        base: &State,
        start: &StageStart,
        contacts: &mut dyn Contacts,
        time: f64,
        context: &Context,
    ) -> Result<Stage, SolverError> {
        let World { bundle, loads, .. } = world;
        let inertia = start.inertia;
        let problem = EquilibriumProblem {
            bundle,
            loads,
            yielding: world.failure.rods_yield,
            softening: world.failure.is_cohesive(),
            lost: world.fracture_loss,
            unbalanced_work: world.unbalanced_work,
            start: &world.state,
            base,
            inertia: Some(inertia),
            time,
        };
        let Equilibrium {
            state,
            reaction,
            springs,
            softened,
            ..
        } = self.newton.solve(&problem, base, contacts, context)?;
        let mut velocity = add_scaled(&state.position, &inertia.behind, -1.0);
        for v in [&mut velocity.x, &mut velocity.y, &mut velocity.z] {
            v.iter_mut().for_each(|v| *v /= inertia.h);
        }
        let mut spin = add_scaled_numbers(&state.angle, &inertia.angle_behind, -1.0);
        spin.iter_mut().for_each(|s| *s /= inertia.h);
        let mut own = Forces::zeros(bundle.vertices());
        self.newton.internal_forces(bundle, &state, &mut own);
        for spring in &springs {
            for (v, share) in spring.shares() {
                own.linear.add(v, spring.force * share);
            }
        }
        let mut forces = reaction;
        loads.add_forces(bundle, time, &state.position, &velocity, &mut forces);
        let (mut power, mut internal) = (0.0, 0.0);
        let (mut damping, mut squared_acceleration) = (0.0, 0.0);
        for v in 0..bundle.vertices() {
            let (mass, way) = (bundle.mass[v], velocity.get(v));
            let acceleration = (way - start.velocity.get(v)) / inertia.h;
            power += forces.linear.get(v).dot(way);
            internal += own.linear.get(v).dot(way);
            damping += mass * way.length_squared();
            squared_acceleration += mass * acceleration.length_squared();
            if bundle.twisting {
                let acceleration = (spin[v] - start.spin[v]) / inertia.h;
                power += forces.moment[v] * spin[v];
                internal += own.moment[v] * spin[v];
                damping += bundle.inertia[v] * spin[v] * spin[v];
                squared_acceleration += bundle.inertia[v] * acceleration * acceleration;
            }
        }
        Ok(Stage {
            state,
            velocity,
            spin,
            springs,
            softened,
            power,
            damping: loads.damping * damping,
            internal,
            squared_acceleration,
        })
    }

    /// Solves both stages of a step of `dt`.
    fn stages(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        dt: f64,
        context: &Context,
    ) -> Result<[Stage; 2], SolverError> {
        let (old, h) = (&world.state, GAMMA * dt);
        self.newton.prepare(&world.bundle, &[]);
        let inertia = Inertia {
            h,
            ahead: add_scaled(&old.position, &old.velocity, h),
            behind: old.position.clone(),
            angle_ahead: add_scaled_numbers(&old.angle, &old.spin, h),
            angle_behind: old.angle.clone(),
        };
        let start = StageStart {
            inertia: &inertia,
            velocity: &old.velocity,
            spin: &old.spin,
        };
        let first = self.stage(world, old, &start, contacts, old.time + h, context)?;
        // v₀ + (1 − γ) Δt a₁ with a₁ = (v₁ − v₀)/h.
        let part = (1.0 - GAMMA) / GAMMA;
        let velocity = add_scaled(
            &add_scaled(&old.velocity, &first.velocity, part),
            &old.velocity,
            -part,
        );
        let spin = add_scaled_numbers(
            &add_scaled_numbers(&old.spin, &first.spin, part),
            &old.spin,
            -part,
        );
        let behind = add_scaled(&old.position, &first.velocity, (1.0 - GAMMA) * dt);
        let angle_behind = add_scaled_numbers(&old.angle, &first.spin, (1.0 - GAMMA) * dt);
        let inertia = Inertia {
            h,
            ahead: add_scaled(&behind, &velocity, h),
            angle_ahead: add_scaled_numbers(&angle_behind, &spin, h),
            behind,
            angle_behind,
        };
        let start = StageStart {
            inertia: &inertia,
            velocity: &velocity,
            spin: &spin,
        };
        let (base, end) = (&first.state, old.time + dt);
        let second = self.stage(world, base, &start, contacts, end, context)?;
        Ok([first, second])
    }

    /// Takes a step, or its two halves where it does not converge. Where it fails, world and contacts may be at its middle.
    fn step_or_halves(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        halvings: u32,
        report: &mut AdvanceReport,
        context: &Context,
    ) -> Result<(), SolverError> {
        match self.stages(world, contacts, dt, context) {
            Ok(stages) => {
                self.accept(world, contacts, dt, stages, report);
                Ok(())
            }
            Err(SolverError::NotConverged { .. }) if halvings < MAX_HALVINGS => {
                for _ in 0..2 {
                    let half = 0.5 * dt;
                    self.step_or_halves(world, contacts, half, halvings + 1, report, context)?;
                }
                Ok(())
            }
            Err(other) => Err(other),
        }
    }

    /// Ends a step with the stages found, and lets break what fails.
    fn accept(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        [first, second]: [Stage; 2],
        report: &mut AdvanceReport,
    ) {
        let before = energies(&world.bundle, &world.state).potential() + contacts.stored_energy();
        let old = std::mem::replace(&mut world.state, second.state);
        world.state.velocity = second.velocity;
        world.state.spin = second.spin;
        world.state.time = old.time + dt;
        world.state.step = old.step + 1;
        let lost = record_yielding(world, &old) + take_damage(world, &second.softened);
        world.fracture_loss += lost;
        let over_step = |first: f64, second: f64| dt * ((1.0 - GAMMA) * first + GAMMA * second);
        let given = over_step(first.internal, second.internal);
        let inertia_loss = 0.5
            * (dt * dt)
            * (KINETIC_LOSS[0] * first.squared_acceleration
                + KINETIC_LOSS[1] * second.squared_acceleration);
        let contact = contacts.accept(&old, old.time + dt, &second.springs);
        let after = energies(&world.bundle, &world.state).potential() + contact.stored;
        let gap = before + contact.work - contact.dissipated - lost - after - given;
        report.work += over_step(first.power, second.power);
        report.damped += over_step(first.damping, second.damping);
        report.dissipated += inertia_loss + gap;
        report.steps += 1;
        let interval = u64::from(world.failure.check_interval.max(1));
        if world.state.step.is_multiple_of(interval) {
            let failure = world.failure.sudden();
            find_overstressed(&failure, &world.bundle, &world.state, &mut self.queue);
            find_softened_bonds(world, &mut self.queue);
            if !self.queue.is_empty() {
                break_elements(world, contacts, &self.queue);
            }
        }
    }

    /// Takes a step of `dt` that did not converge as a whole, in halves.
    fn halves(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut AdvanceReport,
        context: &Context,
    ) -> Result<(), SolverError> {
        for _ in 0..2 {
            self.step_or_halves(world, contacts, 0.5 * dt, 1, report, context)?;
        }
        Ok(())
    }
}

impl Stepwise for Implicit {
    const NAME: &'static str = "implicit";
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
        let bodies = contacts.snapshot();
        let result = match self.stages(world, contacts, dt, context) {
            Ok(stages) => {
                self.accept(world, contacts, dt, stages, report);
                return Ok(());
            }
            Err(SolverError::NotConverged { .. }) => {
                let saved = world.clone();
                let result = self.halves(world, contacts, dt, report, context);
                if result.is_err() {
                    *world = saved;
                }
                result
            }
            Err(other) => Err(other),
        };
        if result.is_err() {
            contacts.restore(&bodies, &world.bundle, &world.loads);
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::NoContacts;
    use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
    use crate::solvers::Solver;
    use glam::DVec3;

    /// Lets a rod oscillate in its first mode of stretch, of period T, at steps of T/`steps`. Returns the fraction of its energy
    /// that is lost over a period or a longer step, and checks that the report has the same.
    fn lost(steps: f64) -> f64 {
        let material = RodMaterial::solid(1e-4, 1e7, 1e6, 1000.0);
        let rod = Rod::new(vec![DVec3::ZERO, DVec3::Z * 0.1], material);
        let mut world = World::new(RodBundle::new(&[rod], false).unwrap());
        let (mass, k) = (world.bundle.mass[0], material.stretch / 0.1);
        world.state.position.set(1, DVec3::Z * 0.1001);
        world.state.position.set(0, DVec3::Z * -1e-4);
        let period = std::f64::consts::TAU * (mass / (2.0 * k)).sqrt();
        let before = energies(&world.bundle, &world.state).total();
        let duration = period / steps.min(1.0);
        let report = Implicit::new(Some(period / steps))
            .advance(&mut world, &mut NoContacts, duration, &Context::quiet())
            .unwrap();
        let after = energies(&world.bundle, &world.state).total();
        let off = report.dissipated - (before - after);
        println!(
            "{steps} steps a period: off by {} of the energy",
            off / before
        );
        // By the work of the forces that Newton's method leaves unbalanced: at most 1e-7 of the largest force in each stage.
        assert!(off.abs() < 1e-6 * before);
        (before - after) / before
    }

    #[test]
    fn slow_motion_is_conserved_to_third_order_and_fast_motion_dies_out() {
        // Half the step of a method of second order leaves an eighth of the loss.
        let (coarse, fine) = (lost(20.0), lost(40.0));
        assert!(coarse > 0.0 && coarse < 0.02, "{coarse}");
        assert!((6.5..9.5).contains(&(coarse / fine)), "{}", coarse / fine);
        assert!(lost(0.05) > 0.99);
    }
}
