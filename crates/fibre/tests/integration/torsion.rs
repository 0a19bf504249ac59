//! Rods that break in torsion (Sutherland 2012 §6.1): at the torque of the textbook, with an energy that balances.

use crate::support::{soft, straight};
use glam::DVec3;
use greenstick_fibre::energy::energies;
use greenstick_fibre::{
    AdvanceReport, Cause, Clamp, EventKind, Explicit, FailureCriteria, Implicit, Interactive,
    Keyframe, Motion, NoContacts, Pose, QuasiStatic, RodBundle, RodMaterial, Solver, WoodMaterial,
    World,
};
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::species::Species;
use std::f64::consts::PI;

const EDGES: usize = 20;
/// The vertex that is weaker than the others, and its strength relative to theirs: so much that the wave of the break, which
/// clamps throw back, breaks nothing else.
const WEAK: usize = 8;
const RELATIVE_STRENGTH: f64 = 0.6;

/// A round bar of a length (m) with a weak vertex. One end is clamped, the other is pulled by `stretch` (m) until `begin` (s),
/// and turned at `rate` (rad/s) from then on.
fn bar(material: RodMaterial, length: f64, stretch: f64, begin: f64, rate: f64) -> World {
    let mut rod = straight(DVec3::ZERO, length, EDGES, material);
    rod.relative_strength = vec![1.0; EDGES + 1];
    rod.relative_strength[WEAK] = RELATIVE_STRENGTH;
    let mut world = World::new(RodBundle::new(&[rod], true).unwrap());
    world.failure = FailureCriteria {
        rods_break: true,
        ..FailureCriteria::default()
    };
    let pulled = Pose {
        translation: DVec3::Z * stretch,
        ..Pose::REST
    };
    let turned = |k: u32| Pose {
        rotation: glam::DQuat::from_rotation_z(f64::from(k)),
        ..pulled
    };
    let mut keys = vec![Keyframe {
        time: 0.0,
        pose: Pose::REST,
    }];
    keys.extend((0..30).map(|k| Keyframe {
        time: begin + f64::from(k) / rate,
        pose: turned(k),
    }));
    if begin == 0.0 {
        keys.remove(0);
    }
    let last = EDGES as u32;
    world.loads.clamps = vec![
        Clamp::new(&world.bundle, vec![0, 1], Motion::Fixed),
        Clamp::new(&world.bundle, vec![last - 1, last], Motion::Keyframes(keys)),
    ];
    world
}

fn advance(solver: &mut dyn Solver, world: &mut World, time: f64) -> AdvanceReport {
    solver
        .advance(world, &mut NoContacts, time, &Context::quiet())
        .unwrap()
}

/// Returns the torque at which a round bar breaks whose surface bears the shear stress `strength` (Pa), τ π r³/2, N m.
fn torque_at_break(material: &RodMaterial, strength: f64) -> f64 {
    strength * PI * (0.5 * material.diameter).powi(3) / 2.0
}

#[test]
fn a_round_bar_breaks_at_the_torque_of_the_textbook() {
    let (length, shear, rate) = (0.1, 1e6, 1.0);
    let material = RodMaterial {
        shear_limit: 0.05,
        ..soft()
    };
    let free = length - length / EDGES as f64;
    let strength = RELATIVE_STRENGTH * shear * material.shear_limit;
    let torque = torque_at_break(&material, strength);
    let solvers: [Box<dyn Solver>; 4] = [
        Box::new(Explicit::new(None)),
        Box::new(Implicit::new(Some(5e-3))),
        Box::new(Interactive::new(Some(5e-3))),
        Box::new(QuasiStatic::new(Some(0.05))),
    ];
    for mut solver in solvers {
        let mut world = bar(material, length, 0.0, 0.0, rate);
        world.loads.damping = 50.0;
        let report = advance(&mut *solver, &mut world, 3.0);
        let name = solver.name();
        assert_eq!(world.events.len(), 1, "{name}: {:?}", world.events);
        let event = world.events[0];
        assert_eq!(
            (event.kind, event.cause, event.vertex),
            (EventKind::RodBroke, Cause::Torsion, WEAK as u32)
        );
        let found = material.twist * rate * event.time / free;
        let off = found / torque - 1.0;
        println!("{name}: breaks at {found} N m for {torque} N m, off by {off:e}");
        assert!(off.abs() < 5e-3, "{name}: {found} for {torque}");
        // The energy of twist over the vertex's share of the length.
        let own = 0.5 * torque * torque / material.twist * length / EDGES as f64;
        assert!(
            (event.energy / own - 1.0).abs() < 0.02,
            "{name}: {}",
            event.energy
        );
        assert!((world.fracture_loss / event.energy - 1.0).abs() < 1e-12);
        let stored = energies(&world.bundle, &world.state).total();
        let balance = stored + report.damped + report.dissipated + world.fracture_loss;
        assert!(
            report.dissipated >= -1e-6 * report.work,
            "{name}: {} J",
            report.dissipated
        );
        println!("{name}: {balance} J of {} J", report.work);
        assert!(
            (balance / report.work - 1.0).abs() < 2e-3,
            "{name}: {balance}"
        );
    }
}

#[test]
fn tension_and_torsion_break_a_bar_together() {
    let length = 0.1;
    let material = RodMaterial {
        shear_limit: 0.05,
        tension_limit: 0.05,
        ..soft()
    };
    let free = length - length / EDGES as f64;
    // 0.6 of the tension that the weak vertex bears; the clamps hold the outermost edges' lengths.
    let stretch =
        0.6 * RELATIVE_STRENGTH * material.tension_limit * (length - 2.0 * length / EDGES as f64);
    let mut world = bar(material, length, stretch, 0.1, 1.0);
    advance(&mut QuasiStatic::new(Some(0.02)), &mut world, 3.0);
    assert_eq!(world.events.len(), 1, "{:?}", world.events);
    let event = world.events[0];
    assert_eq!((event.cause, event.vertex), (Cause::Torsion, WEAK as u32));
    let shear = 0.5 * material.diameter * (event.time - 0.1) / free;
    let demand = shear / (RELATIVE_STRENGTH * material.shear_limit);
    assert!((demand / 0.8 - 1.0).abs() < 0.01, "{demand}");
}

#[test]
fn a_bar_of_ash_breaks_long_before_two_turns() {
    let ash = Species::find("white ash").unwrap();
    let wood = WoodMaterial::from_species(ash, 12.0, Fallback::Refuse).unwrap();
    let (length, diameter) = (0.3, 0.01);
    let shear = 0.5 * (wood.shear_radial + wood.shear_tangential);
    let area = 0.25 * PI * diameter * diameter;
    let material = RodMaterial {
        tension_limit: wood.tension / wood.longitudinal,
        shear_limit: wood.shear / shear,
        ..RodMaterial::solid(area, wood.longitudinal, shear, wood.density)
    };
    let mut world = bar(material, length, 0.0, 0.0, 1.0);
    let turns = 4.0 * PI;
    let report = advance(&mut QuasiStatic::new(Some(0.05)), &mut world, turns);
    assert_eq!(world.events.len(), 1, "{:?}", world.events);
    let (event, angle) = (world.events[0], world.events[0].time);
    let torque = torque_at_break(&material, RELATIVE_STRENGTH * wood.shear);
    let free = length - length / EDGES as f64;
    let expected = torque * free / material.twist;
    println!(
        "breaks at {:.1}° and {torque:.3} N m, {:.3} J",
        angle.to_degrees(),
        report.work
    );
    assert!(
        (angle / expected - 1.0).abs() < 5e-3,
        "{angle} for {expected}"
    );
    assert!(angle < 0.1 * turns);
    assert_eq!(event.cause, Cause::Torsion);
    let most = 0.5 * torque * expected;
    assert!(
        (report.work / most - 1.0).abs() < 0.01,
        "{} {most}",
        report.work
    );
    assert!(energies(&world.bundle, &world.state).total() < 1e-6 * most);
}
