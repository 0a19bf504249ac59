//! Forces are the negative gradients of the energies, and Hessians the negative gradients of the forces.

use super::hessian::{ElementHessian, HessianKind};
use super::{add_forces, bend_twist, bond, energies, rod};
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::support::{four_rods, random, shaken};
use glam::DVec3;

fn forces(bundle: &RodBundle, state: &State) -> Forces {
    let mut forces = Forces::zeros(bundle.vertices());
    add_forces(bundle, state, &mut forces);
    forces
}

/// Returns the state with one degree of freedom displaced and its frames transported.
fn displaced(bundle: &RodBundle, state: &State, dof: usize, by: f64) -> State {
    let mut displaced = state.clone();
    let n = bundle.vertices();
    if dof < 3 * n {
        displaced.position.add(dof / 3, DVec3::AXES[dof % 3] * by);
        displaced.transport_frames(bundle);
    } else {
        displaced.angle[dof - 3 * n] += by;
    }
    displaced
}

fn component(forces: &Forces, dof: usize) -> f64 {
    let n = forces.moment.len();
    if dof < 3 * n {
        forces.linear.get(dof / 3)[dof % 3]
    } else {
        forces.moment[dof - 3 * n]
    }
}

/// The central difference of fourth order.
fn difference(step: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)
}

fn dofs(bundle: &RodBundle) -> impl Iterator<Item = usize> + '_ {
    let n = bundle.vertices();
    (0..3 * n).chain(
        (0..n)
            .filter(|&j| bundle.twisting && bundle.is_edge(j))
            .map(move |j| 3 * n + j),
    )
}

#[test]
fn forces_are_the_negative_gradient_of_the_energy() {
    for curved in [false, true] {
        let bundle = four_rods(curved);
        for seed in 0..4 {
            let mut state = shaken(&bundle, 10 * seed, 0.25);
            state.plastic_strain[2] = -0.01;
            let exact = forces(&bundle, &state);
            let all: Vec<usize> = dofs(&bundle).collect();
            let angles = 3 * bundle.vertices();
            for part in
                [&|f: usize| f < angles, &|f: usize| f >= angles] as [&dyn Fn(usize) -> bool; 2]
            {
                let chosen = all.iter().copied().filter(|&f| part(f));
                let largest = chosen
                    .clone()
                    .map(|f| component(&exact, f).abs())
                    .fold(0.0, f64::max);
                for f in chosen {
                    let step = if f < angles { 2e-6 } else { 2e-4 };
                    let slope = difference(step, |h| {
                        energies(&bundle, &displaced(&bundle, &state, f, h)).potential()
                    });
                    let error = (slope + component(&exact, f)).abs();
                    assert!(
                        error < 1e-7 * largest,
                        "curved {curved}, dof {f}: {slope} and {}",
                        component(&exact, f)
                    );
                }
            }
        }
    }
}

/// Calls `visit` for the Hessian of every edge, every vertex with bending, and every bond.
fn for_each_hessian(
    bundle: &RodBundle,
    state: &State,
    kind: HessianKind,
    mut visit: impl FnMut(&ElementHessian),
) {
    for j in (0..bundle.vertices()).filter(|&j| bundle.is_edge(j)) {
        visit(&rod::stretch_hessian(bundle, state, j, kind));
    }
    for i in (0..bundle.vertices()).filter(|&i| bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0) {
        if bundle.twisting {
            visit(&bend_twist::hessian(bundle, state, i));
        } else {
            visit(&rod::bend_hessian(bundle, state, i, kind));
        }
    }
    for b in 0..bundle.bonds.len() {
        visit(&bond::hessian(bundle, state, b, kind));
    }
}

/// The assembled Hessian as a dense matrix.
fn assembled(bundle: &RodBundle, state: &State, kind: HessianKind) -> Vec<Vec<f64>> {
    let n = 4 * bundle.vertices();
    let mut matrix = vec![vec![0.0; n]; n];
    for_each_hessian(bundle, state, kind, |element| {
        for u in 0..element.count {
            for v in 0..element.count {
                matrix[element.dofs[u] as usize][element.dofs[v] as usize] += element.matrix[u][v];
            }
        }
    });
    matrix
}

fn compare(bundle: &RodBundle, state: &State, kind: HessianKind, tolerance: f64) {
    let matrix = assembled(bundle, state, kind);
    let angles = 3 * bundle.vertices();
    for f in dofs(bundle) {
        let step = if f < angles { 1e-6 } else { 1e-4 };
        let at = |h: f64| forces(bundle, &displaced(bundle, state, f, h));
        let sides = [at(step), at(-step), at(2.0 * step), at(-2.0 * step)];
        let largest = matrix[f].iter().fold(0.0f64, |a, v| a.max(v.abs()));
        for g in dofs(bundle) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| component(&sides[k], g));
            let slope = -(8.0 * (a - b) - (c - d)) / (12.0 * step);
            assert!(
                (slope - matrix[f][g]).abs() < tolerance * largest,
                "{kind:?}, dofs {f} and {g}: {slope} and {}",
                matrix[f][g]
            );
        }
    }
}

#[test]
fn hessians_are_the_gradient_of_the_forces() {
    let straight = four_rods(false);
    for seed in 0..3 {
        compare(
            &straight,
            &shaken(&straight, 100 + seed, 0.25),
            HessianKind::Exact,
            1e-6,
        );
    }
    // Without strain the Gauss–Newton part is the whole Hessian, with material frames too.
    compare(
        &straight,
        &State::at_rest(&straight),
        HessianKind::GaussNewton,
        1e-6,
    );
    let curved = four_rods(true);
    compare(
        &curved,
        &State::at_rest(&curved),
        HessianKind::GaussNewton,
        1e-6,
    );
}

#[test]
fn a_gauss_newton_hessian_is_never_negative() {
    for curved in [false, true] {
        let bundle = four_rods(curved);
        let state = shaken(&bundle, 7, 0.6);
        let matrix = assembled(&bundle, &state, HessianKind::GaussNewton);
        for seed in 0..50 {
            let v: Vec<f64> = (0..matrix.len()).map(|i| random(seed, i)).collect();
            let form: f64 = matrix
                .iter()
                .zip(&v)
                .map(|(row, a)| a * row.iter().zip(&v).map(|(m, b)| m * b).sum::<f64>())
                .sum();
            assert!(form > 0.0, "{form}");
        }
    }
}

#[test]
fn a_straight_bundle_at_rest_has_no_forces_in_any_position() {
    let bundle = four_rods(false);
    let mut state = State::at_rest(&bundle);
    let scale = component(&forces(&bundle, &shaken(&bundle, 1, 0.1)), 3).abs();
    let turn = glam::DQuat::from_rotation_arc(DVec3::Z, DVec3::new(0.6, 0.5, -0.4).normalize());
    for i in 0..bundle.vertices() {
        let position = turn * state.position.get(i) + DVec3::new(0.4, -2.0, 1.0);
        state.position.set(i, position);
    }
    let found = forces(&bundle, &state);
    let largest = dofs(&bundle)
        .map(|f| component(&found, f).abs())
        .fold(0.0, f64::max);
    assert!(largest < 1e-8 * scale, "{largest} N of {scale} N");
    assert!(energies(&bundle, &state).potential() < 1e-20);
}
