//! Why fibres break at once: what a crack band would need, and what energy a breaking rod gives up.
//!
//! A crack band (Bažant and Oh 1983) lets an edge soften from the strength f so that the work to its end is the energy of fracture
//! G, whatever its length ℓ. That needs ℓ < 2 E G/f²: a longer edge stores more than G and snaps back. A rod in wood has a second
//! limit, which shorter edges do not move. Where it breaks, the bonds beside it take over its tension, over a length of about
//! λ = (E a/K)^½ to both sides, K being the stiffness of the bonds in shear per length (Cox 1952). Under a load P = f a each end
//! draws back by P λ/(E a), so that f² λ/E per area is given up, and softening that takes less than that runs away.

use crate::energy::energies;
use crate::loads::{Clamp, Motion, Pose};
use crate::placement::{FacetMaterial, NearestPoint, WoodMaterial};
use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
use crate::solvers::{QuasiStatic, Solver};
use crate::support::straight;
use crate::topology::break_up;
use crate::{Keyframe, NoContacts, World};
use glam::DVec3;
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::species::Species;

/// Critical stress intensities of air-dry Douglas-fir across the grain, with cracks that run tangentially and radially, Pa m^½: 2200
/// and 2450 psi in^½ (Schniewind and Centeno, Wood and Fiber 5 (1973) 152, abstract).
const TOUGHNESS: [f64; 2] = [2200.0 * PSI_ROOT_INCH, 2450.0 * PSI_ROOT_INCH];
const PSI_ROOT_INCH: f64 = 6894.757 * 0.159_374;
/// The shortest edge that a scene of the program has, m.
const SHORTEST_EDGE: f64 = 4e-3;

fn douglas_fir() -> (&'static Species, WoodMaterial) {
    let species = Species::find("Douglas-fir, coast").unwrap();
    let wood = WoodMaterial::from_species(species, 12.0, Fallback::Refuse).unwrap();
    (species, wood)
}

/// Returns the energies of fracture (J/m²) that belong to [`TOUGHNESS`] in an orthotropic body (Sih, Paris and Irwin 1965):
/// G = K² (a₁₁ a₂₂/2)^½ ((a₂₂/a₁₁)^½ + (2 a₁₂ + a₆₆)/(2 a₁₁))^½ with the compliances a along the crack (1) and across it (2).
fn energies_across_the_grain() -> [f64; 2] {
    let wood = douglas_fir()
        .0
        .engineering_constants(12.0, Fallback::Refuse);
    let wood = wood.unwrap();
    let [el, er, et] = wood.moduli;
    let [lr, lt, _] = wood.poisson;
    let planes = [(et, lt, wood.shear[1]), (er, lr, wood.shear[0])];
    std::array::from_fn(|k| {
        let (along, poisson, shear) = planes[k];
        let (a11, a22, a12, a66) = (1.0 / along, 1.0 / el, -poisson / el, 1.0 / shear);
        let shape = (a22 / a11).sqrt() + (2.0 * a12 + a66) / (2.0 * a11);
        TOUGHNESS[k] * TOUGHNESS[k] * (0.5 * a11 * a22 * shape).sqrt()
    })
}

#[test]
fn softening_of_a_fibre_is_shorter_than_edges_resolve() {
    let (_, wood) = douglas_fir();
    let (modulus, strength) = (wood.longitudinal, wood.tension);
    let shear = 0.5 * (wood.shear_radial + wood.shear_tangential);
    for energy in energies_across_the_grain() {
        let edge = 2.0 * modulus * energy / (strength * strength);
        // Four facets as wide as the rods are apart, so that K = 4 G and λ = d (E/4 G)^½.
        let thickness = 0.5 * edge / (modulus / (4.0 * shear)).sqrt();
        println!(
            "{energy:.0} J/m²: edges below {:.2} mm, rods thinner than {:.2} mm; E {:.2} GPa, f {:.1} MPa",
            1e3 * edge,
            1e3 * thickness,
            1e-9 * modulus,
            1e-6 * strength
        );
        assert!((900.0..1500.0).contains(&energy), "{energy} J/m²");
        assert!(edge < SHORTEST_EDGE, "{edge} m");
    }
}

/// A square lattice of rods a millimetre apart with bonds as in wood.
struct Lattice {
    /// Rods along a side, odd.
    side: usize,
    edge: f64,
    /// Stiffness of the rods around the middle one over its own.
    others: f64,
}

const DISTANCE: f64 = 1e-3;
const LENGTH: f64 = 24e-3;

impl Lattice {
    fn world(&self) -> World {
        let (_, wood) = douglas_fir();
        let edges = (LENGTH / self.edge).round() as usize;
        let rods: Vec<Rod> = (0..self.side * self.side)
            .map(|r| {
                let (x, y) = ((r % self.side) as f64, (r / self.side) as f64);
                let area = DISTANCE * DISTANCE;
                let mut material = RodMaterial::solid(area, wood.longitudinal, 0.0, wood.density);
                material.stretch *= if r == self.middle() { 1.0 } else { self.others };
                straight(DVec3::new(x, y, 0.0) * DISTANCE, LENGTH, edges, material)
            })
            .collect();
        let mut bundle = RodBundle::new(&rods, false).unwrap();
        if self.side > 1 {
            let bonds = self.bonds(&bundle, &wood, edges + 1);
            bundle.set_bonds(bonds).unwrap();
        }
        World::new(bundle)
    }

    fn middle(&self) -> usize {
        self.side * self.side / 2
    }

    fn bonds(&self, bundle: &RodBundle, wood: &WoodMaterial, n: usize) -> Vec<crate::Bond> {
        let facet = FacetMaterial::new(wood, 0.5);
        let side = self.side as i64;
        let mut bonds = Vec::new();
        for i in 0..bundle.vertices() {
            let (rod, k) = ((i / n) as i64, i % n);
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (x, y) = (rod % side + dx, rod / side + dy);
                if !(0..side).contains(&x) || !(0..side).contains(&y) {
                    continue;
                }
                let other = (y * side + x) as usize * n;
                let nearest = NearestPoint {
                    edge: other + k.min(n - 2),
                    t: f64::from(u8::from(k == n - 1)),
                    distance: DISTANCE,
                    cosine: 0.0,
                };
                // Both rods of a facet bond to each other.
                let area = DISTANCE * 0.25 * bundle.both_lengths(i);
                bonds.push(facet.bond(i, &nearest, area, 1.0));
            }
        }
        bonds
    }

    /// Draws the lattice to the strain at which the middle rod fails, breaks it there and lets all come to rest between ends that
    /// stay. Returns the energy that is no longer stored, over the area of the rod and f²/E: a length, m.
    fn given_up(&self) -> f64 {
        let (_, wood) = douglas_fir();
        let strain = wood.tension / wood.longitudinal;
        let mut world = self.world();
        let ends = [0.0, LENGTH].map(|z| {
            let rest = &world.bundle.rest;
            let at = |v: &usize| (rest.get(*v).z - z).abs() < 1e-9;
            let held = (0..world.bundle.vertices()).filter(at);
            held.map(|v| v as u32).collect::<Vec<u32>>()
        });
        let [base, end] = ends;
        let drawn = Keyframe {
            time: 1.0,
            pose: Pose {
                translation: DVec3::Z * (strain * LENGTH),
                ..Pose::REST
            },
        };
        let start = Keyframe {
            time: 0.0,
            pose: Pose::REST,
        };
        world.loads.clamps = vec![
            Clamp::new(&world.bundle, base, Motion::Fixed),
            Clamp::new(&world.bundle, end, Motion::Keyframes(vec![start, drawn])),
        ];
        let come_to_rest = |world: &mut World, duration: f64| {
            QuasiStatic::stateless(Some(0.5))
                .advance(world, &mut NoContacts, duration, &Context::quiet())
                .unwrap();
            energies(&world.bundle, &world.state).total()
        };
        let before = come_to_rest(&mut world, 1.0);
        let rod = world.bundle.rod(self.middle());
        let vertex = (rod.start + rod.len() / 2) as u32;
        let World {
            bundle,
            state,
            loads,
            ..
        } = &mut world;
        break_up(bundle, state, loads, &[], &[vertex]);
        let after = come_to_rest(&mut world, 0.5);
        let stress = wood.tension * wood.tension / wood.longitudinal;
        (before - after) / (stress * DISTANCE * DISTANCE)
    }
}

#[test]
fn a_rod_without_bonds_gives_up_what_it_stores() {
    for edge in [4e-3, 1e-3] {
        let lattice = Lattice {
            side: 1,
            edge,
            others: 1.0,
        };
        let length = lattice.given_up();
        assert!((length / (0.5 * LENGTH) - 1.0).abs() < 0.01, "{length}");
    }
}

#[test]
fn the_energy_that_a_bonded_rod_gives_up_hardly_follows_its_edge() {
    let (_, wood) = douglas_fir();
    let shear = 0.5 * (wood.shear_radial + wood.shear_tangential);
    let lag = DISTANCE * (wood.longitudinal / (4.0 * shear)).sqrt();
    let given_up = |edge: f64, others: f64| {
        let lattice = Lattice {
            side: 7,
            edge,
            others,
        };
        let length = lattice.given_up();
        println!("others {others}, edge {edge} m: {length} m, λ {lag} m");
        length
    };
    // Neighbours that do not give way are those of the closed form.
    let closed = given_up(0.5e-3, 1e4) / lag - 1.0;
    assert!(closed.abs() < 0.01, "{closed}");
    // What an edge of 4 mm stores is eight times what one of 0.5 mm does.
    let fine = given_up(0.5e-3, 1.0);
    assert!((1.0..1.1).contains(&(fine / lag)), "{fine}");
    for (edge, less) in [(1e-3, 0.03), (2e-3, 0.1), (4e-3, 0.3)] {
        let ratio = given_up(edge, 1.0) / fine;
        assert!((1.0 - less..1.0).contains(&ratio), "{edge} m: {ratio}");
    }
}
