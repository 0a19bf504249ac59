//! A crack followed at its true speed, by bursts of explicit steps.
//!
//! A crack runs through wood in about a millisecond. In that time it breaks fibre after fibre, each of which unloads its
//! neighbours on one side and overloads those on the other, so that equilibria after each break would be as many as breaks,
//! and each of them as costly as hundreds of explicit steps. The burst ends when the wood loses little energy, or
//! no more than loads and clamps put in: what still softens then does so at the pace of the load or of the whole stem's motion,
//! which equilibria follow.
//!
//! A crack that is released at once rings: without inner friction its waves break several times as much wood. Friction is that
//! of [`DAMPING`] on velocities: all of what clamps hold, those beside the rigid motion of what flies or falls.

use super::explicit::Explicit;
use super::solver::Solver;
use super::step_energy::StepEnergy;
use crate::contact::Contacts;
use crate::energy::energies;
use crate::error::SolverError;
use crate::world::World;
use greenstick_geometry::Context;

/// Time after which it is seen whether the crack still runs, s.
const INTERVAL: f64 = 5e-5;
/// A crack runs where the wood loses more than this fraction of its stored energy in an interval, and more than this multiple of
/// the work of loads and clamps. Slower cracks are those of which equilibria with inertia follow each step at less cost.
const RUNNING_LOSS: f64 = 1e-2;
const RUNNING_LOSS_OVER_WORK: f64 = 2.0;
/// Damping of velocities, 1/s. The loss factor of a vibration at the angular frequency ω is this over ω: 0.02 at 8 kHz, where
/// crack-borne bending waves of a few centimetres lie, and about that of wood, 0.01 to 0.03 (Wood Handbook, chapter 5, "Vibration
/// properties").
const DAMPING: f64 = 1000.0;
/// Steps over the largest stable one. The energy of the fastest vibrations, which a crack sets off, is off by a quarter of the
/// square of twice this, a sixth here: with half as many steps the balance of `pull` is ten times as far off.
pub(super) const STEP_SAFETY_FACTOR: f64 = 0.4;
/// Explicit steps between two checks for failure, in which a wave goes a few edges far.
const CHECK_INTERVAL: u32 = 4;

/// Whether a crack has come to rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Crack {
    /// It still runs at the time until which it was to be followed.
    Running,
    /// It does not.
    AtRest,
}

/// Times between which a crack is followed, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// The time to which it is followed even where it is at rest.
    pub least: f64,
    /// The time beyond which it is not.
    pub end: f64,
}

/// Follows a crack with the solver `explicit` until it is at rest, within a span of time.
///
/// # Errors
/// Those of [`Solver::advance`].
pub(super) fn run(
    explicit: &mut Explicit,
    world: &mut World,
    contacts: &mut dyn Contacts,
    span: Span,
    context: &Context,
) -> Result<(Crack, StepEnergy), SolverError> {
    let (loads, failure) = (&mut world.loads, &mut world.failure);
    let damping = loads.damping;
    loads.damping = damping.max(DAMPING);
    let interval = std::mem::replace(&mut failure.check_interval, CHECK_INTERVAL);
    // Edges that are cut short would need shorter steps.
    let between_vertices = std::mem::replace(&mut failure.between_vertices, false);
    let undamped = world.loads.damping - damping;
    let result = follow(explicit, world, contacts, (span, undamped), context);
    explicit.leave_undamped(world, None);
    world.loads.damping = damping;
    world.failure.check_interval = interval;
    world.failure.between_vertices = between_vertices;
    // Damage has changed, which other solvers' data do not know.
    world.bundle.generation += 1;
    result
}

fn follow(
    explicit: &mut Explicit,
    world: &mut World,
    contacts: &mut dyn Contacts,
    (Span { least, end }, undamped): (Span, f64),
    context: &Context,
) -> Result<(Crack, StepEnergy), SolverError> {
    let mut energy = StepEnergy::default();
    let step = explicit.step(world, context)?;
    explicit.shift_velocities(world, -step);
    let mut crack = Crack::Running;
    while (crack == Crack::Running || world.state.time < least) && world.state.time < end {
        let duration = INTERVAL.min(end - world.state.time);
        let loss = world.fracture_loss;
        explicit.leave_undamped(world, Some(undamped));
        let done = explicit.advance(world, contacts, duration, &context.silenced())?;
        energy.work += done.work;
        energy.damped += done.damped;
        let lost = world.fracture_loss - loss;
        let stored = energies(&world.bundle, &world.state).potential();
        let running =
            lost > RUNNING_LOSS * stored && lost > RUNNING_LOSS_OVER_WORK * done.work.abs();
        crack = if running {
            Crack::Running
        } else {
            Crack::AtRest
        };
    }
    explicit.shift_velocities(world, step);
    Ok((crack, energy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::NoContacts;
    use crate::loads::Loads;
    use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
    use glam::DVec3;

    /// A rod that flies, turns and vibrates.
    fn world(damping: f64) -> World {
        let material = RodMaterial::solid(1e-5, 1e10, 1e9, 600.0);
        let vertices = (0..7).map(|i| DVec3::new(0.0, 0.0, 5e-3 * f64::from(i)));
        let bundle = RodBundle::new(&[Rod::new(vertices.collect(), material)], false).unwrap();
        let mut world = World::new(bundle);
        world.loads = Loads {
            damping,
            gravity: DVec3::new(0.0, 0.0, -10.0),
            ..Loads::default()
        };
        for v in 0..7 {
            let arm = world.state.position.get(v) - DVec3::new(0.0, 0.0, 0.015);
            let turn = DVec3::new(30.0, 40.0, 0.0).cross(arm);
            let vibration = DVec3::new(0.5 * f64::from((v as i32 % 2) * 2 - 1), 0.0, 0.0);
            world
                .state
                .velocity
                .set(v, DVec3::new(20.0, 0.0, -3.0) + turn + vibration);
        }
        world
    }

    fn momentum(world: &World) -> (DVec3, DVec3) {
        let (bundle, state) = (&world.bundle, &world.state);
        let sum = |of: &dyn Fn(usize) -> DVec3| {
            (0..bundle.vertices()).fold(DVec3::ZERO, |s, v| s + of(v) * bundle.mass[v])
        };
        let mass: f64 = bundle.mass.iter().sum();
        let centre = sum(&|v| state.position.get(v)) / mass;
        let velocity = sum(&|v| state.velocity.get(v)) / mass;
        let spin =
            sum(&|v| (state.position.get(v) - centre).cross(state.velocity.get(v) - velocity));
        (velocity * mass, spin)
    }

    #[test]
    fn what_flies_is_not_braked_and_what_vibrates_in_it_is() {
        let (mut world, context) = (world(1000.0), Context::quiet());
        let mut explicit = Explicit::new(None);
        let (linear, angular) = momentum(&world);
        let kinetic = |w: &World| crate::energy::energies(&w.bundle, &w.state).kinetic;
        let start = kinetic(&world);
        let (mut damped, mut work) = (0.0, 0.0);
        for _ in 0..100 {
            explicit.leave_undamped(&world, Some(1000.0));
            let done = explicit
                .advance(&mut world, &mut NoContacts, 5e-5, &context)
                .unwrap();
            (damped, work) = (damped + done.damped, work + done.work);
        }
        let mass: f64 = world.bundle.mass.iter().sum();
        let (after, turning) = momentum(&world);
        // Of what gravity adds within 50 µs, damping takes a twentieth half of that time.
        let fallen = DVec3::new(0.0, 0.0, -10.0 * 5e-3 * mass);
        assert!((after - linear - fallen).length() < 0.03 * fallen.length());
        assert!(
            (turning - angular).length() < 0.01 * angular.length(),
            "{angular} {turning}"
        );
        // Half of 7 · 0.25 kg m²/s² a kilogram of vertices, less what of it was rigid motion.
        let rigid = start - damped + work;
        assert!(
            (kinetic(&world) / rigid - 1.0).abs() < 1e-3,
            "{} {rigid}",
            kinetic(&world)
        );
        assert!(damped > 0.8 * 0.125 * mass, "{damped}");
    }
}
