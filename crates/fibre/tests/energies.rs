//! Forces are the negative gradients of the energies, and Hessians those of the forces (`model.md` §5).

mod support;

use glam::DVec3;
use greenstick_fibre::energy::{Curvature, Forces, add_forces, energies, visit_hessians};
use greenstick_fibre::{Bundle, State};
use support::{four_rods, shaken};

fn forces(bundle: &Bundle, state: &State) -> Forces {
    let mut made = Forces::zeros(bundle.vertices());
    add_forces(bundle, state, &mut made);
    made
}

/// The state with one degree of freedom moved, its frames carried along.
fn moved(bundle: &Bundle, state: &State, freedom: usize, by: f64) -> State {
    let mut made = state.clone();
    let n = bundle.vertices();
    if freedom < 3 * n {
        made.position
            .add(freedom / 3, DVec3::AXES[freedom % 3] * by);
        made.carry_frames(bundle);
    } else {
        made.angle[freedom - 3 * n] += by;
    }
    made
}

fn component(forces: &Forces, freedom: usize) -> f64 {
    let n = forces.moment.len();
    if freedom < 3 * n {
        forces.linear.get(freedom / 3)[freedom % 3]
    } else {
        forces.moment[freedom - 3 * n]
    }
}

/// Central difference of fourth order.
fn difference(step: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)
}

fn freedoms(bundle: &Bundle) -> impl Iterator<Item = usize> + '_ {
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
            let all: Vec<usize> = freedoms(&bundle).collect();
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
                        energies(&bundle, &moved(&bundle, &state, f, h)).potential()
                    });
                    let miss = (slope + component(&exact, f)).abs();
                    assert!(
                        miss < 1e-7 * largest,
                        "curved {curved}, freedom {f}: {slope} and {}",
                        component(&exact, f)
                    );
                }
            }
        }
    }
}

/// The assembled Hessian, dense.
fn assembled(bundle: &Bundle, state: &State, kind: Curvature) -> Vec<Vec<f64>> {
    let n = 4 * bundle.vertices();
    let mut matrix = vec![vec![0.0; n]; n];
    visit_hessians(bundle, state, kind, |element| {
        for u in 0..element.count {
            for v in 0..element.count {
                matrix[element.freedoms[u] as usize][element.freedoms[v] as usize] +=
                    element.matrix[u][v];
            }
        }
    });
    matrix
}

fn compare(bundle: &Bundle, state: &State, kind: Curvature, tolerance: f64) {
    let matrix = assembled(bundle, state, kind);
    let angles = 3 * bundle.vertices();
    for f in freedoms(bundle) {
        let step = if f < angles { 1e-6 } else { 1e-4 };
        let at = |h: f64| forces(bundle, &moved(bundle, state, f, h));
        let sides = [at(step), at(-step), at(2.0 * step), at(-2.0 * step)];
        let largest = matrix[f].iter().fold(0.0f64, |a, v| a.max(v.abs()));
        for g in freedoms(bundle) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| component(&sides[k], g));
            let slope = -(8.0 * (a - b) - (c - d)) / (12.0 * step);
            assert!(
                (slope - matrix[f][g]).abs() < tolerance * largest,
                "{kind:?}, freedoms {f} and {g}: {slope} and {}",
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
            Curvature::Exact,
            1e-6,
        );
    }
    // Without strain the Gauss–Newton part is the whole, with material frames too.
    compare(
        &straight,
        &State::at_rest(&straight),
        Curvature::GaussNewton,
        1e-6,
    );
    let curved = four_rods(true);
    compare(
        &curved,
        &State::at_rest(&curved),
        Curvature::GaussNewton,
        1e-6,
    );
}

#[test]
fn a_gauss_newton_hessian_is_never_negative() {
    for curved in [false, true] {
        let bundle = four_rods(curved);
        let state = shaken(&bundle, 7, 0.6);
        let matrix = assembled(&bundle, &state, Curvature::GaussNewton);
        for seed in 0..50 {
            let v: Vec<f64> = (0..matrix.len())
                .map(|i| support::random(seed, i))
                .collect();
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
fn a_bundle_at_rest_feels_nothing_wherever_it_lies() {
    for curved in [false, true] {
        let bundle = four_rods(curved);
        let mut state = State::at_rest(&bundle);
        let scale = component(&forces(&bundle, &shaken(&bundle, 1, 0.1)), 3).abs();
        // Turned in steps, so that the frames are carried through the turn.
        let turn = glam::DQuat::from_rotation_arc(DVec3::Z, DVec3::new(0.1, 0.05, 1.0).normalize());
        for _ in 0..40 {
            for i in 0..bundle.vertices() {
                state
                    .position
                    .set(i, turn * state.position.get(i) + DVec3::X * 0.01);
            }
            state.carry_frames(&bundle);
        }
        // Reference frames are carried without turning about the edges: the rigid turn shows in the angles. What is
        // left is the same for all edges of a rod, and no strain.
        let made = forces(&bundle, &state);
        let largest = freedoms(&bundle)
            .map(|f| component(&made, f).abs())
            .fold(0.0, f64::max);
        if !curved {
            assert!(largest < 1e-10 * scale, "{largest} N");
            assert!(energies(&bundle, &state).potential() < 1e-20);
        }
    }
}
