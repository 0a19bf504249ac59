//! The fast forces and products are those of the energies, with the same bits on every processor and any number of
//! threads.

use super::ForceEvaluator;
use crate::bonds::Bond;
use crate::contact::NoContacts;
use crate::energy::hessian::{ElementHessian, HessianKind};
use crate::energy::{add_forces, bond, energies};
use crate::forces::Forces;
use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
use crate::simd::SimdLevel;
use crate::simd::lanes::PaddedVec3;
use crate::solvers::{Explicit, Solver};
use crate::state::State;
use crate::support::{bond_all, four_rods, shaken, soft, straight};
use crate::world::World;
use glam::DVec3;
use greenstick_geometry::Context;
use greenstick_wood::noise::unit;

const LEVELS: [SimdLevel; 3] = [SimdLevel::Scalar, SimdLevel::Avx2, SimdLevel::Avx512];

/// Many rods in a square grid, of different numbers of edges.
fn grid(side: usize, edges: usize) -> RodBundle {
    let rods: Vec<Rod> = (0..side * side)
        .map(|r| {
            let corner = DVec3::new((r % side) as f64, (r / side) as f64, 0.0) * 5e-3;
            straight(corner, 0.06, edges + r % 5, soft())
        })
        .collect();
    let mut bundle = RodBundle::new(&rods, false).unwrap();
    bond_all(&mut bundle, 6e-3, 40.0, 2e-3);
    bundle
}

#[test]
fn fast_forces_are_the_gradients_on_every_level() {
    for bundle in [four_rods(false), four_rods(true), grid(5, 11)] {
        let mut state = shaken(&bundle, 5, 0.3);
        state.plastic_strain[4] = -0.02;
        let mut exact = Forces::zeros(bundle.vertices());
        add_forces(&bundle, &state, &mut exact);
        let largest = exact.linear.iter().map(|f| f.length()).fold(0.0, f64::max);
        let mut first: Option<Forces> = None;
        for level in LEVELS {
            let mut fast = Forces::zeros(bundle.vertices());
            ForceEvaluator::with_level(&bundle, level).forces(&bundle, &state, &mut fast);
            for i in 0..bundle.vertices() {
                let error = fast.linear.get(i).distance(exact.linear.get(i));
                assert!(error < 1e-12 * largest, "{level:?}, vertex {i}: {error}");
                assert!((fast.moment[i] - exact.moment[i]).abs() < 1e-12);
            }
            let same = first.get_or_insert_with(|| fast.clone());
            assert_eq!(*same, fast, "{level:?}");
        }
    }
}

#[test]
fn fast_energies_have_the_bits_of_the_energies_on_every_level() {
    for mut bundle in [four_rods(false), four_rods(true), grid(5, 11)] {
        bundle.bonds.damage[1] = 0.3;
        let mut state = shaken(&bundle, 5, 0.3);
        state.plastic_strain[4] = -0.02;
        let exact = energies(&bundle, &state);
        assert!(exact.bond_transverse > 0.0 && exact.bond_shear > 0.0);
        for level in LEVELS {
            let mut evaluator = ForceEvaluator::with_level(&bundle, level);
            // The damage of a trial is not that of the bundle.
            evaluator.set_bond_damage(&bundle, 2, 0.7);
            assert_eq!(evaluator.energies(&bundle, &state), exact, "{level:?}");
        }
    }
}

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let bundle = grid(20, 12);
    assert!(bundle.vertices() > 4000 && bundle.bonds.len() > 8192);
    let run = |threads: usize| {
        let mut world = World::new(bundle.clone());
        world.state = shaken(&bundle, 3, 0.02);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut solver = Explicit::new(None);
            solver.advance(&mut world, &mut NoContacts, 2e-3, &Context::quiet())
        })
        .unwrap();
        world
    };
    let (one, two) = (run(1), run(2));
    assert!(one.state.step > 10);
    assert_eq!(
        serde_json::to_string(&one).unwrap(),
        serde_json::to_string(&two).unwrap()
    );
}

/// A bundle whose every vertex is bonded to all other rods, out of its position at rest, and a displacement of it.
struct Sheared {
    bundle: RodBundle,
    state: State,
    displacement: Vec<PaddedVec3>,
}

impl Sheared {
    /// Bonds that have softened, and their damage.
    const SOFTENED: [u32; 3] = [3, 50, 51];
    const DAMAGE: f64 = 0.9;

    fn new() -> Self {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let rods: Vec<Rod> = (0..9)
            .map(|r| {
                let corner = DVec3::new((r % 3) as f64, (r / 3) as f64, 0.0) * 1e-3;
                let vertex = |i: usize| corner + DVec3::Z * 4e-3 * i as f64;
                Rod::new((0..9).map(vertex).collect(), material)
            })
            .collect();
        let mut bundle = RodBundle::new(&rods, false).unwrap();
        let others = |v: u32| (0..9u32).filter(move |r| *r != v / 9);
        let bonds =
            (0..bundle.vertices() as u32).flat_map(|v| others(v).map(move |r| bond_of(v, r)));
        bundle.set_bonds(bonds.collect()).unwrap();
        for b in Self::SOFTENED {
            bundle.bonds.damage[b as usize] = Self::DAMAGE;
        }
        let random =
            |i: usize, k: i64| DVec3::from_array([0, 1, 2].map(|c| unit(9, i as i64, k, c) - 0.5));
        let mut state = State::at_rest(&bundle);
        for v in 0..bundle.vertices() {
            state.position.add(v, random(v, 0) * 4e-4);
        }
        let displacement = (0..bundle.vertices())
            .map(|v| PaddedVec3(random(v, 1).extend(0.0).to_array()))
            .collect();
        Sheared {
            bundle,
            state,
            displacement,
        }
    }

    fn evaluator(&self, level: SimdLevel) -> ForceEvaluator {
        let mut intact = self.bundle.clone();
        intact.bonds.damage.fill(0.0);
        let mut evaluator = ForceEvaluator::with_level(&intact, level);
        for b in Self::SOFTENED {
            evaluator.set_bond_damage(&intact, b, Self::DAMAGE);
        }
        evaluator.linearise_bonds(&self.state);
        evaluator
    }

    /// The Gauss–Newton Hessians of the bonds.
    fn hessians(&self) -> impl Iterator<Item = ElementHessian> + '_ {
        (0..self.bundle.bonds.len())
            .map(|b| bond::hessian(&self.bundle, &self.state, b, HessianKind::GaussNewton))
    }

    /// The product of the Hessian and the displacement.
    fn product(&self) -> Vec<f64> {
        let mut product = vec![0.0; 3 * self.bundle.vertices()];
        for hessian in self.hessians() {
            for r in 0..hessian.count {
                for c in 0..hessian.count {
                    let dof = hessian.dofs[c] as usize;
                    let x = self.displacement[dof / 3].0[dof % 3];
                    product[hessian.dofs[r] as usize] += hessian.matrix[r][c] * x;
                }
            }
        }
        product
    }
}

fn bond_of(vertex: u32, rod: u32) -> Bond {
    Bond {
        vertex,
        edge: 9 * rod + vertex % 8,
        t: unit(3, i64::from(vertex), i64::from(rod), 0),
        distance: 1.1e-3,
        rest_cosine: 0.1,
        transverse: 40.0,
        shear: 2e-3,
        area: 1e-6,
        tension_strength: 1.0,
        shear_strength: 1.0,
        fracture_energy: 1.0,
        shear_fracture_energy: 1.0,
        damage: 0.0,
    }
}

fn largest(of: &[f64]) -> f64 {
    of.iter().fold(0.0f64, |a, v| a.max(v.abs()))
}

#[test]
fn products_with_linearised_bonds_are_those_of_the_hessian_on_every_level() {
    let example = Sheared::new();
    let expected = example.product();
    let scale = largest(&expected);
    let mut first: Option<Vec<[f64; 4]>> = None;
    for level in LEVELS {
        let mut evaluator = example.evaluator(level);
        evaluator.multiply_bonds(&example.displacement);
        let mut out = vec![PaddedVec3::ZERO; example.bundle.vertices()];
        evaluator.gather_bond_product(&example.bundle, 0, &mut out);
        for (dof, e) in expected.iter().enumerate() {
            // Gradients are rounded to single precision.
            assert!((out[dof / 3].0[dof % 3] - e).abs() < 1e-5 * scale);
        }
        let bits: Vec<[f64; 4]> = out.iter().map(|r| r.0).collect();
        assert_eq!(*first.get_or_insert_with(|| bits.clone()), bits);
    }
}

#[test]
fn gradients_one_by_one_have_the_product_of_all() {
    let example = Sheared::new();
    let x = &example.displacement;
    let mut evaluator = example.evaluator(SimdLevel::best());
    evaluator.multiply_bonds(x);
    let mut out = vec![PaddedVec3::ZERO; example.bundle.vertices()];
    evaluator.gather_bond_product(&example.bundle, 0, &mut out);
    let mut sum = vec![0.0; 3 * out.len()];
    evaluator.for_each_gradient(0, 1, |bond| {
        for gradient in [&bond.opening, &bond.slip] {
            let mut change = 0.0;
            for (g, v) in gradient.iter().zip(bond.vertices) {
                (0..3).for_each(|a| change += g[a] * x[v as usize].0[a]);
            }
            for (g, v) in gradient.iter().zip(bond.vertices) {
                (0..3).for_each(|a| sum[3 * v as usize + a] += change * g[a]);
            }
        }
    });
    let scale = largest(&example.product());
    for (dof, s) in sum.iter().enumerate() {
        assert!((s - out[dof / 3].0[dof % 3]).abs() < 1e-12 * scale);
    }
}

#[test]
fn blocks_between_vertices_of_one_rod_are_sums_over_gradients() {
    let example = Sheared::new();
    let scale = largest(&example.product()) / 1e-4;
    for level in LEVELS {
        let evaluator = example.evaluator(level);
        let mut blocks = Vec::new();
        evaluator.same_rod_blocks(&example.bundle, &mut blocks);
        // Per vertex: its own six entries, those of the edge's start and end, and xz, yz, zz between them.
        let mut expected = vec![[0.0; 21]; blocks.len()];
        evaluator.for_each_gradient(0, 1, |bond| {
            let [v, y, _] = bond.vertices.map(|v| v as usize);
            for g in [&bond.opening, &bond.slip] {
                let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
                for (k, (a, b)) in pairs.into_iter().enumerate() {
                    expected[v][k] += g[0][a] * g[0][b];
                    expected[y][6 + k] += g[1][a] * g[1][b];
                    expected[y][12 + k] += g[2][a] * g[2][b];
                }
                (0..3).for_each(|a| expected[y][18 + a] += g[1][a] * g[2][2]);
            }
        });
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * scale);
        for (found, expected) in blocks.iter().zip(&expected) {
            for k in 0..6 {
                let at = k + usize::from(k > 2);
                close(found.vertex.0[at], expected[k]);
                close(found.start.0[at], expected[6 + k]);
                close(found.end.0[at], expected[12 + k]);
            }
            (0..3).for_each(|a| close(found.across[1].0[a], expected[18 + a]));
        }
    }
}
