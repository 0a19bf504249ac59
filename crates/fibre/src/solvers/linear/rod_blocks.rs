//! Linearised rods as blocks of the matrix: between each vertex and itself, and the next two of its rod.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::problem::LinearProblem;
use crate::contact::ContactSpring;
use crate::energy::bend_twist;
use crate::energy::hessian::ElementHessian;
use crate::rod_bundle::RodBundle;
use crate::simd::lanes::PaddedVec3;
use crate::state::State;
use glam::DVec3;

/// A column of a block.
pub(super) type Column = [f64; 4];
/// Blocks of a vertex with itself and the next two of its rod, as columns.
pub(super) type RodBlocks<const B: usize> = [[Column; B]; 3];
/// Stiffness of a yielding edge over that of an elastic one: without any the matrix could be singular.
pub(super) const YIELDED_STIFFNESS_RATIO: f64 = 2e-2;

/// Removes rows and columns that are not free from the blocks: zero, with 1 on the diagonal.
pub(super) fn remove_held<const B: usize>(band: &mut [RodBlocks<B>], free: &[PaddedVec3]) {
    let n = band.len();
    let is_free = |v: usize| v >= n || free[v].0[..B].iter().all(|f| *f == 1.0);
    for v in 0..n {
        if is_free(v) && is_free(v + 1) && is_free(v + 2) {
            continue;
        }
        for k in (0..3).filter(|k| v + k < n) {
            for b in 0..B {
                (0..4).for_each(|a| band[v][k][b][a] *= free[v].0[a] * free[v + k].0[b]);
            }
        }
        (0..B).for_each(|a| band[v][0][a][a] += 1.0 - free[v].0[a]);
    }
}

/// Adds the product of rods' blocks and `x` to `out`, whose first vertex is `first`.
#[inline(always)]
pub(super) fn multiply_band<const B: usize>(
    band: &[RodBlocks<B>],
    x: &[PaddedVec3],
    first: usize,
    out: &mut [PaddedVec3],
) {
    let n = band.len();
    for (i, out) in out.iter_mut().enumerate() {
        let v = first + i;
        let mut sum = out.0;
        for k in 0..3 {
            if v + k < n {
                let x = &x[v + k].0;
                for b in 0..B {
                    for a in 0..4 {
                        sum[a] += band[v][k][b][a] * x[b];
                    }
                }
            }
        }
        // The transposed blocks of the two vertices before.
        for k in 1..3 {
            if let Some(u) = v.checked_sub(k) {
                let x = &x[u].0;
                for b in 0..B {
                    let column = &band[u][k][b];
                    sum[b] += (column[0] * x[0] + column[2] * x[2])
                        + (column[1] * x[1] + column[3] * x[3]);
                }
            }
        }
        out.0 = sum;
    }
}

/// Adds the elements of the rods whose blocks are `band`, from vertex `start` on, and their inertia.
pub(super) fn add_rods<const B: usize>(
    problem: &LinearProblem,
    start: usize,
    band: &mut [RodBlocks<B>],
) {
    let (bundle, state) = (problem.bundle, problem.state);
    for v in start..start + band.len() {
        if bundle.is_edge(v) {
            let yields = state.plastic_strain[v] != problem.plastic[v];
            add_stretch(bundle, state, v, yields, &mut band[v - start..]);
        }
        if bundle.bend[v] > 0.0 || bundle.twist[v] > 0.0 {
            let band = &mut band[v - 1 - start..];
            if bundle.twisting {
                add_element(&bend_twist::hessian(bundle, state, v), 3, band);
            } else {
                add_bend(bundle, state, v, band);
            }
        }
    }
    for (i, blocks) in band.iter_mut().enumerate() {
        let (v, block) = (start + i, &mut blocks[0]);
        (0..3).for_each(|a| block[a][a] += bundle.mass[v] * problem.inertia);
        if B == 4 {
            // The angle of a gap, or of an edge that is free to turn.
            block[3][3] += bundle.inertia[v] * problem.inertia;
            if block[3][3] <= 0.0 {
                block[3][3] = 1.0;
            }
        }
    }
}

/// Adds an edge: k/l t tᵀ, and where it is in tension the geometric stiffness of a string. That of compression is left out,
/// because it could make the block negative.
fn add_stretch<const B: usize>(
    bundle: &RodBundle,
    state: &State,
    edge: usize,
    yields: bool,
    band: &mut [RodBlocks<B>],
) {
    let e = state.edge(edge);
    let length = e.length();
    let (k, rest) = (bundle.stretch[edge], bundle.rest_length[edge]);
    let strain = length / rest - 1.0 - state.plastic_strain[edge];
    let geometric = if strain > 0.0 && !yields {
        k * strain / length
    } else {
        0.0
    };
    let along = if yields { YIELDED_STIFFNESS_RATIO } else { 1.0 } * k / rest - geometric;
    let t = (e / length).to_array();
    for b in 0..3 {
        for a in 0..3 {
            let v = along * t[a] * t[b] + if a == b { geometric } else { 0.0 };
            band[0][0][b][a] += v;
            band[0][1][b][a] -= v;
            band[1][0][b][a] += v;
        }
    }
}

/// Adds bending without twist: its Gauss–Newton Hessian 2 c Gᵀ G, with the gradient G of κb with respect to the three
/// vertices.
fn add_bend<const B: usize>(
    bundle: &RodBundle,
    state: &State,
    vertex: usize,
    band: &mut [RodBlocks<B>],
) {
    let (a, b) = (state.edge(vertex - 1), state.edge(vertex));
    let (la, lb) = (bundle.rest_length[vertex - 1], bundle.rest_length[vertex]);
    let d = 1.0 / (la * lb + a.dot(b));
    let kb = a.cross(b) * (2.0 * d);
    let root = (2.0 * bundle.bend[vertex] / (la + lb)).sqrt() * d;
    let (two_a, two_b) = (a * (2.0 * root), b * (2.0 * root));
    let (ka, kb) = (a.to_array(), kb * root);
    let kb_by = b.to_array();
    let unit = [DVec3::X, DVec3::Y, DVec3::Z];
    // Columns of ∂κb/∂a and ∂κb/∂b.
    let by_a: [DVec3; 3] = std::array::from_fn(|i| unit[i].cross(two_b) - kb * kb_by[i]);
    let by_b: [DVec3; 3] = std::array::from_fn(|i| two_a.cross(unit[i]) - kb * ka[i]);
    let by: [[DVec3; 3]; 3] = [
        by_a.map(|v| -v),
        std::array::from_fn(|i| by_a[i] - by_b[i]),
        by_b,
    ];
    for u in 0..3 {
        for v in u..3 {
            for column in 0..3 {
                for row in 0..3 {
                    band[u][v - u][column][row] += by[u][row].dot(by[v][column]);
                }
            }
        }
    }
}

/// Adds the Hessian of an element of `count` vertices, whose first vertex has the first blocks.
fn add_element<const B: usize>(hessian: &ElementHessian, count: usize, band: &mut [RodBlocks<B>]) {
    // Positions by vertex, then the angles of the first two edges.
    let block_and_entry = |f: usize| {
        if f < 3 * count {
            (f / 3, f % 3)
        } else {
            (f - 3 * count, 3)
        }
    };
    for column in 0..hessian.count {
        let (b, beta) = block_and_entry(column);
        for row in 0..hessian.count {
            let (a, alpha) = block_and_entry(row);
            if a <= b {
                band[a][b - a][beta][alpha] += hessian.matrix[row][column];
            }
        }
    }
}

/// Adds the stiffness of a contact between vertices of one rod, `factor` times.
pub(super) fn add_contact<const B: usize>(
    spring: &ContactSpring,
    factor: f64,
    band: &mut [RodBlocks<B>],
) {
    let shares: Vec<(usize, f64)> = spring.shares().collect();
    for pair in shares.chunks_exact(2) {
        let (first, weights) = (pair[0].0, [pair[0].1, pair[1].1]);
        for (i, k) in [(0, 0), (0, 1), (1, 1)] {
            for column in 0..3 {
                for row in 0..3 {
                    let stiffness = spring.stiffness(row, column);
                    let w = factor * weights[i] * weights[k];
                    band[first + i][k - i][column][row] += w * stiffness;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::hessian::HessianKind;
    use crate::energy::rod;
    use crate::rod_bundle::{Rod, RodMaterial};

    #[test]
    fn blocks_are_the_hessians_of_the_energies() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let bent = [[0.0, 0.0, 0.0], [0.1, 0.0, 4.0], [0.5, 0.3, 7.9]];
        let positions = |scale: f64| bent.map(|p| DVec3::from_array(p) * scale);
        let straight = (0..3).map(|i| DVec3::Z * 4e-3 * f64::from(i)).collect();
        let bundle = RodBundle::new(&[Rod::new(straight, material)], false).unwrap();
        let mut state = State::at_rest(&bundle);
        for (stretched, kind) in [
            (1.1e-3, HessianKind::Exact),
            (0.9e-3, HessianKind::GaussNewton),
        ] {
            for (v, p) in positions(stretched).into_iter().enumerate() {
                state.position.set(v, p);
            }
            let mut band: Vec<RodBlocks<3>> = vec![[[[0.0; 4]; 3]; 3]; 3];
            add_stretch(&bundle, &state, 0, false, &mut band);
            add_bend(&bundle, &state, 1, &mut band);
            let mut expected = [[0.0; 9]; 9];
            for hessian in [
                rod::stretch_hessian(&bundle, &state, 0, kind),
                rod::bend_hessian(&bundle, &state, 1, HessianKind::GaussNewton),
            ] {
                for r in 0..hessian.count {
                    for c in 0..hessian.count {
                        let (row, column) = (hessian.dofs[r], hessian.dofs[c]);
                        expected[row as usize][column as usize] += hessian.matrix[r][c];
                    }
                }
            }
            let largest = expected[2][2].abs();
            for (row, of) in expected.iter().enumerate() {
                for (column, e) in of.iter().enumerate() {
                    let (u, v) = (row / 3, column / 3);
                    if u <= v {
                        let found = band[u][v - u][column % 3][row % 3];
                        assert!((found - e).abs() < 1e-12 * largest, "{row} {column}");
                    }
                }
            }
        }
    }
}
