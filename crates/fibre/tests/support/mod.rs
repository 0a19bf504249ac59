//! Bundles for tests, of this crate's unit tests too.
#![allow(dead_code)]

use glam::DVec3;
use greenstick_fibre::{Bond, Rod, RodBundle, RodMaterial, State};
use greenstick_wood::noise::unit;

/// A random number from −1 to 1 for a position in a sequence.
pub fn random(seed: u64, i: usize) -> f64 {
    2.0 * unit(seed, i as i64, 0, 0) - 1.0
}

pub fn random_vector(seed: u64, i: usize) -> DVec3 {
    DVec3::new(
        random(seed, 3 * i),
        random(seed, 3 * i + 1),
        random(seed, 3 * i + 2),
    )
}

/// A straight rod along z with equal edges.
pub fn straight(start: DVec3, length: f64, edges: usize, material: RodMaterial) -> Rod {
    Rod::new(
        (0..=edges)
            .map(|i| start + DVec3::Z * (length * i as f64 / edges as f64))
            .collect(),
        material,
    )
}

/// A soft round rod, 4 mm thick: E = 10 MPa, G = 1 MPa, 600 kg/m³.
pub fn soft() -> RodMaterial {
    RodMaterial {
        // JSON has no infinity.
        tension_limit: 1e9,
        shear_limit: 1e9,
        yield_strain: 1e9,
        ..RodMaterial::solid(1.25e-5, 1e7, 1e6, 600.0)
    }
}

/// Bonds from every vertex to the nearest point of each rod nearer than `reach`, all with the same stiffness.
pub fn bond_all(bundle: &mut RodBundle, reach: f64, transverse: f64, shear: f64) {
    let mut bonds = Vec::new();
    for i in 0..bundle.vertices() {
        let x = bundle.rest.get(i);
        for rod in (0..bundle.rods()).filter(|&r| r != bundle.rod_of(i)) {
            let nearest = bundle
                .rod(rod)
                .filter(|&j| bundle.is_edge(j))
                .map(|j| {
                    let (a, b) = (bundle.rest.get(j), bundle.rest.get(j + 1));
                    let t = ((x - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                    (x.distance(a.lerp(b, t)), j, t)
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((distance, j, t)) = nearest.filter(|n| n.0 < reach) else {
                continue;
            };
            let e = (bundle.rest.get(j + 1) - bundle.rest.get(j)).normalize();
            let c = bundle.rest.get(j).lerp(bundle.rest.get(j + 1), t);
            bonds.push(Bond {
                vertex: i as u32,
                edge: j as u32,
                t,
                distance,
                rest_cosine: e.dot((x - c).normalize()),
                transverse,
                shear,
                area: 1e-5,
                tension_strength: 1.0,
                shear_strength: 1.0,
                fracture_energy: 1e-3,
                shear_fracture_energy: 3e-3,
                damage: 0.0,
            });
        }
    }
    bundle.set_bonds(bonds).unwrap();
}

/// Four bonded rods at the corners of a square, of different numbers of edges. With `curved` they are helices.
pub fn four_rods(curved: bool) -> RodBundle {
    let rods: Vec<Rod> = (0..4)
        .map(|r| {
            let corner = DVec3::new((r % 2) as f64, (r / 2) as f64, 0.0) * 5e-3;
            let edges = 6 + r;
            let mut rod = straight(corner, 0.06, edges, soft());
            if curved {
                for v in &mut rod.vertices {
                    let a = 20.0 * v.z;
                    *v += DVec3::new(a.cos(), a.sin(), 0.0) * 4e-3;
                }
            }
            rod
        })
        .collect();
    let mut bundle = RodBundle::new(&rods, curved).unwrap();
    bond_all(&mut bundle, 8e-3, 40.0, 2e-3);
    bundle
}

/// The bundle with random displacements of up to `by` edge lengths, and random velocities and angles.
pub fn shaken(bundle: &RodBundle, seed: u64, by: f64) -> State {
    let mut state = State::at_rest(bundle);
    for i in 0..bundle.vertices() {
        let move_by = random_vector(seed, i) * by * bundle.rest_length[0];
        state.position.add(i, move_by);
        state.velocity.set(i, random_vector(seed + 1, i) * 0.3);
        if bundle.twisting && bundle.is_edge(i) {
            state.angle[i] = 0.7 * random(seed + 2, i);
            state.spin[i] = 5.0 * random(seed + 3, i);
        }
    }
    state.transport_frames(bundle);
    state
}
