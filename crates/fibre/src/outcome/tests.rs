//! What became of the wood, on bundles whose outcome is known.

use super::mode::{Damage, Elements};
use super::*;
use crate::contact::NoContacts;
use crate::event::{Cause, EventKind};
use crate::failure::BondCriterion;
use crate::failure::breaking::break_elements;
use crate::failure::demand::{Element, Overstressed};
use crate::rod_bundle::{Rod, RodMaterial};
use crate::support::{bond_all, straight};
use crate::world::World;
use glam::DVec3;

/// Edges of a rod.
const EDGES: usize = 10;
/// Tensile strength of a rod and shear strength of a bond, N.
const ROD: f64 = 125.0;
const BOND: f64 = 1.0;

/// Two bonded rods, side by side.
fn two_rods() -> World {
    let material = RodMaterial {
        tension_limit: 1.0,
        ..RodMaterial::solid(1.25e-5, 1e7, 1e6, 600.0)
    };
    let rods: Vec<Rod> = (0..2)
        .map(|r| straight(DVec3::X * 4e-3 * f64::from(r), 0.1, EDGES, material))
        .collect();
    let mut bundle = RodBundle::new(&rods, false).unwrap();
    // Each vertex of either rod has a bond to the other.
    bond_all(&mut bundle, 5e-3, 40.0, 2e-3);
    World::new(bundle)
}

fn fractions() -> Vec<f64> {
    (0..2 * (EDGES + 1))
        .map(|v| (v % (EDGES + 1)) as f64 / EDGES as f64)
        .collect()
}

fn break_rods(world: &mut World, vertices: &[u32]) {
    let queue: Vec<Overstressed> = vertices
        .iter()
        .map(|&v| Overstressed {
            demand: 1.0,
            element: Element::Rod(v),
        })
        .collect();
    break_elements(world, &mut NoContacts, &queue);
}

fn outcome(wood: &WoodAtStart, world: &World) -> Outcome {
    let records = OutcomeRecords {
        events: &world.events,
        energies: &[],
        forces: &[],
    };
    wood.outcome(&world.bundle, &world.state, &records)
}

#[test]
fn what_is_left_is_what_rods_and_bonds_can_carry() {
    let mut world = two_rods();
    let wood = WoodAtStart::new(&world.bundle, &fractions(), 0.1);
    assert!((wood.capacity.unwrap() / (2.0 * ROD) - 1.0).abs() < 1e-6);
    let whole = outcome(&wood, &world);
    assert_eq!(
        (whole.mode, whole.parted, whole.pieces.len()),
        (Mode::Whole, false, 1)
    );
    // One of two rods: half is left, and what the two halves of its last bond pass on past the break.
    break_rods(&mut world, &[3]);
    let half = outcome(&wood, &world);
    assert_eq!((half.mode, half.rods_broken), (Mode::Greenstick, 1));
    let left = half.tension_left.unwrap();
    assert!((0.5..0.5 + BOND / ROD).contains(&left), "{left}");
    assert!((half.place_m.unwrap() - 0.03).abs() < 1e-12);
    // Both, five edges apart: the overlap slips when its bonds fail. Rod 1's vertex 8 is vertex 20 of the bundle by now.
    break_rods(&mut world, &[20]);
    let parted = outcome(&wood, &world);
    // Bonds of the four sections between the breaks, one from each rod, and the halves at the breaks themselves.
    let left = parted.tension_left.unwrap() * 2.0 * ROD;
    assert!((8.0 * BOND..=12.0 * BOND).contains(&left), "{left}");
    assert!(
        parted.parted && parted.mode == Mode::SplinteringTension,
        "{parted:?}"
    );
    // The cut goes along the overlap: each piece keeps its splinter.
    let shares: Vec<f64> = parted.pieces.iter().map(|p| p.share).collect();
    assert_eq!(shares.len(), 2);
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!((shares[0] - 0.55).abs() < 0.051, "{shares:?}");
}

#[test]
fn shares_of_volume_are_those_of_mass_of_even_wood_alone() {
    // Both rods break at the same place, 3 of 10 edges from their base.
    let mut world = two_rods();
    let wood = WoodAtStart::new(&world.bundle, &fractions(), 0.1);
    // One is twice as dense.
    for v in world.bundle.rod(1) {
        world.bundle.mass[v] *= 2.0;
        world.bundle.edge_mass[v] *= 2.0;
    }
    break_rods(&mut world, &[3]);
    break_rods(&mut world, &[3 + 2 + EDGES as u32]);
    world.bundle.bonds = Default::default();
    let parted = outcome(&wood, &world);
    let volumes: Vec<f64> = parted.pieces.iter().map(|p| p.volume_share).collect();
    assert!((volumes.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    // Without bonds each part of a rod is a piece: 3 and 7 of 20 edges each, the heaviest first.
    for (found, expected) in volumes.iter().zip([0.35, 0.35, 0.15, 0.15]) {
        assert!((found - expected).abs() < 1e-12, "{volumes:?}");
    }
    for (piece, expected) in parted.pieces.iter().zip([1.4 / 3.0, 0.7 / 3.0, 0.2, 0.1]) {
        assert!(
            (piece.share - expected).abs() < 1e-12,
            "{:?}",
            parted.pieces
        );
    }
}

#[test]
fn what_never_fails_stays_whole() {
    let mut world = two_rods();
    world.bundle.tension_limit.fill(f64::INFINITY);
    let wood = WoodAtStart::new(&world.bundle, &fractions(), 0.1);
    let outcome = outcome(&wood, &world);
    assert_eq!(outcome.tension_left, Some(1.0));
    assert!(!outcome.parted);
}

#[test]
fn breaks_away_from_the_face_do_not_make_it_ragged() {
    // Both rods break five edges from their base, and one of them again near its tip: a stub of one edge hangs on by its bonds.
    let mut world = two_rods();
    let wood = WoodAtStart::new(&world.bundle, &fractions(), 0.1);
    let other = EDGES as u32 + 1;
    break_rods(&mut world, &[5, 9, other + 5]);
    let bonds = &world.bundle.bonds;
    let is_across = |bond: usize| {
        let [a, b] = [bonds.vertex[bond], bonds.edge[bond]]
            .map(|v| wood.fraction[world.bundle.origin[v as usize] as usize]);
        (a - 0.5).abs() < 0.11 && (b - 0.5).abs() < 0.11
    };
    let across: Vec<u32> = (0..bonds.len() as u32)
        .filter(|&b| is_across(b as usize))
        .collect();
    let World {
        bundle,
        state,
        loads,
        ..
    } = &mut world;
    crate::topology::break_up(bundle, state, loads, &across, &[]);
    let parted = outcome(&wood, &world);
    assert_eq!(
        (parted.mode, parted.rods_broken, parted.further_breaks),
        (Mode::BrashTension, 2, 1),
        "{parted:?}"
    );
    assert!((parted.place_m.unwrap() - 0.05).abs() < 1e-12);
    assert!(parted.spread_m.unwrap() < 1e-12);
}

#[test]
fn a_break_lies_where_the_rod_was_moved_to() {
    let mut world = two_rods();
    let wood = WoodAtStart::new(&world.bundle, &fractions(), 0.1);
    // The vertex at 3 cm is moved by 4 mm, as before a rod breaks between its vertices.
    world.bundle.rest_length[2] += 4e-3;
    world.bundle.rest_length[3] -= 4e-3;
    break_rods(&mut world, &[3]);
    let place = outcome(&wood, &world).place_m.unwrap();
    assert!((place - 0.034).abs() < 1e-12, "{place}");
}

#[test]
fn a_bond_that_slid_is_told_from_one_that_opened() {
    // The second rod has moved along the grain, or away from the first one.
    for (way, cause) in [(DVec3::Z, Cause::Shear), (DVec3::X, Cause::Cohesive)] {
        let mut world = two_rods();
        world.failure.bonds = BondCriterion::Cohesive;
        for v in world.bundle.rod(1) {
            world.state.position.add(v, way * 1e-3);
        }
        let bond = Overstressed {
            demand: 1.0,
            element: Element::Bond(0),
        };
        break_elements(&mut world, &mut NoContacts, &[bond]);
        assert_eq!(world.events[0].cause, cause, "{way}");
    }
}

/// The mode of four rods and bonds of which these events happened.
fn mode_of(events: &[(EventKind, Cause, u32)], torque: bool) -> Mode {
    let event = |&(kind, cause, rod): &(EventKind, Cause, u32)| Event {
        time: 0.0,
        kind,
        rod,
        vertex: rod,
        other: None,
        position: DVec3::ZERO,
        cause,
        demand: 1.0,
        energy: 0.0,
    };
    let events: Vec<Event> = events.iter().map(event).collect();
    let elements = Elements {
        rods: 4,
        edges: 40,
        bonds: 40,
    };
    Mode::new(&Damage::count(&events), elements, (0.0, false, torque))
}

#[test]
fn along_the_grain_wood_is_split_sheared_twisted_or_crushed() {
    let opened = (EventKind::BondBroke, Cause::Cohesive, 0);
    let slid = (EventKind::BondBroke, Cause::Shear, 0);
    let crushed = (EventKind::RodYielded, Cause::Compression, 1);
    let twisted = (EventKind::RodBroke, Cause::Torsion, 2);
    let torn = (EventKind::RodBroke, Cause::Tension, 2);
    for (events, torque, mode) in [
        (&[][..], false, Mode::Whole),
        (&[opened, opened, slid], false, Mode::Split),
        (&[opened, slid, slid], false, Mode::HorizontalShear),
        (&[opened, slid, slid], true, Mode::Torsion),
        (&[opened, opened, slid], true, Mode::Split),
        (&[crushed], false, Mode::Compression),
        (&[crushed, crushed, opened], false, Mode::Compression),
        (&[crushed, slid, slid], false, Mode::HorizontalShear),
        (&[twisted, opened], false, Mode::Torsion),
        (&[torn, crushed, slid], false, Mode::Greenstick),
        // Torn where the fibre was crushed: rod 1's vertex is 1, too.
        (
            &[crushed, (EventKind::RodBroke, Cause::Tension, 1)],
            false,
            Mode::Compression,
        ),
        (
            &[(EventKind::RodBroke, Cause::Tension, 1), crushed],
            false,
            Mode::Greenstick,
        ),
    ] {
        assert_eq!(mode_of(events, torque), mode, "{events:?} {torque}");
    }
}
