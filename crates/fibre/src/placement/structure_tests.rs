//! Sections whose rods differ as the wood does return the species' table.

use super::fill::{PlacedRods, fill_structured_stem};
use super::material::WoodMaterial;
use super::options::{PlacementOptions, RodCount};
use super::section_moment::{
    Element, EvenWood, bending_directions, moment_capacity, solid_moment_capacity,
};
use super::section_wood::RodWood;
use super::voronoi::VoronoiCell;
use glam::DVec2;
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::{board, cylinder};
use greenstick_wood::rings::{ConcentricRings, StemRings};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemKind, StemOptions, find_stem};
use greenstick_wood::structure::{TissueBoundaries, WoodStructure};
use greenstick_wood::tissue::{Proportions, Zone};
use std::f64::consts::TAU;

const BARKED: TissueBoundaries = TissueBoundaries {
    pith: 0.05,
    heartwood: 0.45,
    phloem: 0.89,
    bark: 0.94,
};

struct Filled {
    placed: PlacedRods,
    wood: WoodMaterial,
}

fn stem(round: bool) -> Stem {
    let mesh = if round {
        cylinder(0.05, 0.3, 96)
    } else {
        board(0.3, 0.05, 0.05)
    };
    let (at, options) = ("0.5".parse().unwrap(), StemOptions::default());
    find_stem(&[mesh], &at, &options, &Context::quiet())
        .unwrap()
        .stem
}

fn filled(name: &str, round: bool, tissues: TissueBoundaries, rings: u16, rods: u32) -> Filled {
    let species = Species::find(name).unwrap();
    let wood = WoodMaterial::from_species(species, 12.0, Fallback::Estimate).unwrap();
    let rings = StemRings::new(ConcentricRings::grown(rings, 3, &Proportions::USUAL));
    let structure = WoodStructure::new(species, 12.0, rings, tissues);
    let options = PlacementOptions {
        rods: RodCount::Number(rods),
        ..PlacementOptions::default()
    };
    let context = Context::quiet();
    let placed = fill_structured_stem(&stem(round), &wood, &structure, &options, &context);
    Filled {
        placed: placed.unwrap(),
        wood,
    }
}

/// Returns Σ f A and Σ f (A r² + A²/2π) about the centre of f, for a value f of each rod.
fn moments(placed: &PlacedRods, value: impl Fn(&WoodMaterial) -> f64) -> [f64; 2] {
    let each = || {
        let pairs = placed.wood.iter().zip(&placed.cells);
        pairs.map(|(w, c)| (c.area * value(&w.material), c))
    };
    let whole: f64 = each().map(|(f, _)| f).sum();
    let centre = each().fold(DVec2::ZERO, |sum, (f, c)| sum + c.centroid * (f / whole));
    let second = each().map(|(f, c)| f * (c.centroid.distance_squared(centre) + c.area / TAU));
    [whole, second.sum()]
}

#[test]
fn a_section_returns_the_modulus_and_the_mass_of_its_species() {
    for name in ["Douglas-fir, coast", "white oak", "sugar maple"] {
        for (round, rods) in [(true, 60), (true, 150), (false, 60)] {
            let sapwood = TissueBoundaries::SAPWOOD;
            let Filled { placed, wood } = filled(name, round, sapwood, 30, rods);
            let [area, inertia] = moments(&placed, |_| 1.0);
            let [stretch, bend] = moments(&placed, |w| w.longitudinal / wood.longitudinal);
            let [mass, _] = moments(&placed, |w| w.density / wood.density);
            assert!(
                (bend / inertia - 1.0).abs() < 1e-9,
                "{name}: E I {}",
                bend / inertia
            );
            assert!(
                (mass / area - 1.0).abs() < 1e-9,
                "{name}: mass {}",
                mass / area
            );
            // Juvenile wood makes a round section stiffer in bending than in tension.
            let tension = stretch / area;
            let range = if round { 0.85..1.0 } else { 0.9..1.05 };
            assert!(range.contains(&tension), "{name}: E A {tension}");
        }
    }
}

#[test]
fn stiffness_in_tension_of_a_juvenile_core_is_as_integrated() {
    // Thirty even rings of a conifer, the first fifteen of which rise from half to all of the mature modulus, evenly mixed
    // earlywood and latewood: E(r) = e(r) in 30 steps. E A over E I, against the sums over many fine rings.
    let Filled { placed, wood } = {
        let species = Species::find("Sitka spruce").unwrap();
        let wood = WoodMaterial::from_species(species, 12.0, Fallback::Refuse).unwrap();
        let rings = StemRings::new(ConcentricRings::even(30, &Proportions::USUAL));
        let structure = WoodStructure::new(species, 12.0, rings, TissueBoundaries::SAPWOOD);
        let options = PlacementOptions {
            rods: RodCount::Number(150),
            ..PlacementOptions::default()
        };
        let context = Context::quiet();
        let placed = fill_structured_stem(&stem(true), &wood, &structure, &options, &context);
        Filled {
            placed: placed.unwrap(),
            wood,
        }
    };
    let [area, _] = moments(&placed, |_| 1.0);
    let [stretch, _] = moments(&placed, |w| w.longitudinal / wood.longitudinal);
    let local = |r: f64| {
        let (ring, within) = ((30.0 * r).floor(), (30.0 * r).fract());
        let latewood: f64 = if within > 0.7 { 2.0 } else { 1.0 };
        latewood * (0.5 + 0.5 * (ring / 14.0).min(1.0))
    };
    const STEPS: usize = 30_000;
    let integral = |power: i32, f: &dyn Fn(f64) -> f64| -> f64 {
        let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
        (0..STEPS).map(|k| f(at(k)) * at(k).powi(power)).sum()
    };
    let one = |_: f64| 1.0;
    let expected =
        (integral(1, &local) / integral(1, &one)) / (integral(3, &local) / integral(3, &one));
    let found = stretch / area;
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

#[test]
fn a_section_bears_the_moment_of_a_solid_one_and_is_crushed_like_it() {
    for name in ["Douglas-fir, coast", "white ash"] {
        let sapwood = TissueBoundaries::SAPWOOD;
        let Filled { placed, wood } = filled(name, true, sapwood, 12, 60);
        let element = |(own, cell): (&RodWood, &VoronoiCell)| Element {
            position: cell.centroid,
            area: cell.area,
            radius: Element::rod_radius(cell.area),
            modulus: own.material.longitudinal,
            tension: own.material.tension,
            compression: own.material.compression,
        };
        let rods: Vec<Element> = placed.wood.iter().zip(&placed.cells).map(element).collect();
        let solid: Vec<(&VoronoiCell, f64)> = placed.cells.iter().map(|c| (c, 1.0)).collect();
        let even = EvenWood {
            modulus: wood.longitudinal,
            tension: wood.tension,
            compression: wood.compression,
        };
        let around = bending_directions(StemKind::Round, &placed.outline);
        let ratio = moment_capacity(&rods, &around) / solid_moment_capacity(&solid, &around, even);
        assert!((ratio - 1.0).abs() < 1e-6, "{name}: {ratio}");
        let [area, _] = moments(&placed, |_| 1.0);
        let [crushing, _] = moments(&placed, |w| w.compression / wood.compression);
        assert!((crushing / area - 1.0).abs() < 1e-9, "{name}: {crushing}");
    }
}

#[test]
fn bark_is_no_wood_and_leaves_the_wood_as_it_is() {
    let Filled { placed, wood } = filled("white oak", true, BARKED, 20, 150);
    let of = |zone: Zone| {
        let rods: Vec<&WoodMaterial> = (placed.wood.iter())
            .filter(|w| w.tissue == zone)
            .map(|w| &w.material)
            .collect();
        assert!(!rods.is_empty(), "{zone}");
        rods.iter().map(|m| m.longitudinal).sum::<f64>() / rods.len() as f64 / wood.longitudinal
    };
    // A rod of the bark holds a little wood.
    assert!(of(Zone::Bark) < 0.5 * of(Zone::Sapwood));
    assert!(of(Zone::Heartwood) < of(Zone::Sapwood));
    // The bending stiffness is that of the wood within the cambium and a little bark: I falls with the fourth power.
    let [_, inertia] = moments(&placed, |_| 1.0);
    let [_, bend] = moments(&placed, |w| w.longitudinal / wood.longitudinal);
    let inside = 0.89f64.powi(4);
    let expected = inside + 0.1 * (0.94f64.powi(4) - inside) + 0.05 * (1.0 - 0.94f64.powi(4));
    assert!(
        (bend / inertia / expected - 1.0).abs() < 0.02,
        "{}",
        bend / inertia / expected
    );
}

#[test]
fn weak_planes_leave_the_mean_across_the_grain() {
    let Filled { placed, wood } = filled(
        "Douglas-fir, coast",
        true,
        TissueBoundaries::SAPWOOD,
        12,
        200,
    );
    let bonds = &placed.bundle.bonds;
    let area: f64 = bonds.area.iter().sum();
    let mean = |sums: &[f64]| sums.iter().sum::<f64>() / area;
    for (found, table) in [
        (mean(&bonds.tension_strength), wood.tension_across),
        (mean(&bonds.shear_strength), wood.shear),
        // A crack runs along 4/π of its plane's area.
        (
            mean(&bonds.fracture_energy) * 4.0 / std::f64::consts::PI,
            wood.fracture_energy,
        ),
    ] {
        // Ends and the reach of bonds give facets other weights.
        assert!((found / table - 1.0).abs() < 0.02, "{}", found / table);
    }
    let strengths = || (0..bonds.len()).map(|b| bonds.tension_strength[b] / bonds.area[b]);
    let weakest = strengths().fold(f64::INFINITY, f64::min);
    let strongest = strengths().fold(0.0, f64::max);
    assert!(weakest < 0.8 * wood.tension_across && strongest > 1.3 * wood.tension_across);
}
