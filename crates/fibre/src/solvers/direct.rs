//! Linear systems of a bundle with a Cholesky factor that is kept from step to step ([`super::matrix`]): conjugate
//! gradients with the last factor, which is made anew where it has become too old. A factor costs as much as some fifty
//! iterations, and between two load steps little of the matrix changes.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::grips::Held;
use super::matrix::{Envelope, conjugate_gradients, order};
use super::newton::Problem;
use crate::bundle::Bundle;
use crate::energy::{Curvature, ElementHessian, bond, framed, rod};
use crate::solver::Touch;
use glam::DVec3;

/// Stiffness of a yielding edge over that of an elastic one, in the matrix only: none at all could leave it singular.
const YIELDING: f64 = 1e-3;
/// Conjugate gradients before a new factor is made.
const PATIENCE: usize = 14;

/// The matrix and its last factor.
#[derive(Debug, Clone, Default)]
pub(super) struct Direct {
    block: usize,
    /// Per vertex: its place in the matrix.
    place: Vec<u32>,
    matrix: Envelope,
    factor: Option<Envelope>,
    /// Factors made so far.
    pub factors: usize,
}

impl Direct {
    /// Makes everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &Bundle, grips: &[Held]) {
        self.block = if bundle.twisting { 4 } else { 3 };
        let n = bundle.vertices();
        let mut pairs = Vec::new();
        for i in 0..n as u32 {
            if bundle.is_edge(i as usize) {
                pairs.push((i, i + 1));
            }
            if bundle.bend[i as usize] > 0.0 {
                pairs.push((i - 1, i + 1));
            }
        }
        for (&v, &e) in bundle.bonds.vertex.iter().zip(&bundle.bonds.edge) {
            pairs.extend([(v, e), (v, e + 1)]);
        }
        for g in grips {
            for (k, a) in g.vertices.iter().enumerate() {
                pairs.extend(g.vertices[..k].iter().map(|b| (a.0, b.0)));
            }
        }
        self.place = vec![0; n];
        for (k, v) in order(n, &pairs).into_iter().enumerate() {
            self.place[v as usize] = k as u32;
        }
        let place = &self.place;
        let moved = pairs
            .iter()
            .map(|&(a, b)| (place[a as usize], place[b as usize]));
        self.matrix = Envelope::zeros(self.block, n, moved);
        self.factor = None;
    }

    /// The step of a problem: `prescribed` where held, else what balances the linearised forces.
    pub fn solve(&mut self, problem: &Problem) -> Vec<f64> {
        let rows = problem.residual.len();
        let block = self.block;
        let at = |f: usize| self.place[f / block] as usize * block + f % block;
        let (mut residual, mut prescribed) = (vec![0.0; rows], vec![0.0; rows]);
        let mut held = vec![false; rows];
        for f in 0..rows {
            residual[at(f)] = problem.residual[f];
            prescribed[at(f)] = problem.prescribed[f];
            held[at(f)] = problem.held[f];
        }
        let step = self.solve_ordered(problem, &residual, &prescribed, &held);
        let at = |f: usize| self.place[f / block] as usize * block + f % block;
        (0..rows).map(|f| step[at(f)]).collect()
    }

    fn solve_ordered(
        &mut self,
        problem: &Problem,
        residual: &[f64],
        prescribed: &[f64],
        held: &[bool],
    ) -> Vec<f64> {
        let rows = residual.len();
        let mut step = vec![0.0; rows];
        for kind in [Curvature::Exact, Curvature::GaussNewton] {
            self.assemble(problem, kind);
            let mut right = residual.to_vec();
            if prescribed.iter().any(|d| *d != 0.0) {
                let mut pushed = vec![0.0; rows];
                self.matrix.multiply(prescribed, &mut pushed);
                right.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= p);
            }
            self.matrix.hold(held);
            for f in 0..rows {
                if held[f] {
                    right[f] = prescribed[f];
                }
            }
            if let Some(factor) = &self.factor {
                let accuracy = problem.accuracy;
                let done = conjugate_gradients(
                    &self.matrix,
                    factor,
                    &right,
                    &mut step,
                    accuracy,
                    PATIENCE,
                );
                if done.is_some() {
                    return step;
                }
            }
            self.factors += 1;
            let mut factor = self.matrix.clone();
            if factor.factor().is_ok() {
                step.copy_from_slice(&right);
                factor.solve(&mut step);
                self.factor = Some(factor);
                return step;
            }
        }
        // Not even what is never negative can be factored: something hangs loose. A little stiffness holds it.
        self.factor = None;
        let most = (0..rows)
            .map(|i| self.matrix.diagonal(i))
            .fold(0.0, f64::max);
        let mut right = residual.to_vec();
        for f in 0..rows {
            if held[f] {
                right[f] = prescribed[f];
            } else {
                self.matrix.add(f, f, 1e-6 * most);
            }
        }
        let mut factor = self.matrix.clone();
        if factor.factor().is_ok() {
            factor.solve(&mut right);
        }
        right
    }

    /// Second derivatives of everything at `state`.
    fn assemble(&mut self, problem: &Problem, kind: Curvature) {
        let (bundle, state) = (problem.bundle, problem.state);
        let n = bundle.vertices();
        let mut matrix = std::mem::take(&mut self.matrix);
        matrix.clear();
        let (place, block) = (&self.place, self.block);
        let row = |freedom: u32| {
            let f = freedom as usize;
            if f < 3 * n {
                place[f / 3] as usize * block + f % 3
            } else {
                place[f - 3 * n] as usize * block + 3
            }
        };
        let mut put = |h: &ElementHessian, by: f64| {
            let mut rows = [0; crate::energy::MOST_FREEDOMS];
            (0..h.count).for_each(|k| rows[k] = row(h.freedoms[k]));
            for u in 0..h.count {
                for v in 0..h.count {
                    if rows[v] <= rows[u] {
                        matrix.add(rows[u], rows[v], by * h.matrix[u][v]);
                    }
                }
            }
        };
        for j in (0..n).filter(|&j| bundle.is_edge(j)) {
            put(&rod::stretch_hessian(bundle, state, j, kind), 1.0);
            if state.plastic_strain[j] != problem.plastic[j] {
                let elastic = rod::stretch_hessian(bundle, state, j, Curvature::GaussNewton);
                put(&elastic, YIELDING - 1.0);
            }
        }
        for i in (0..n).filter(|&i| bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0) {
            if bundle.twisting {
                put(&framed::hessian(bundle, state, i), 1.0);
            } else {
                put(&rod::bend_hessian(bundle, state, i, kind), 1.0);
            }
        }
        for b in 0..bundle.bonds.len() {
            put(&bond::hessian(bundle, state, b, kind), 1.0);
        }
        for g in problem.grips {
            for &(a, wa) in &g.vertices {
                for &(b, wb) in &g.vertices {
                    for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                        let (i, j) = (row(3 * a + r as u32), row(3 * b + c as u32));
                        if j <= i {
                            let along = g.direction[r] * g.direction[c];
                            matrix.add(i, j, g.stiffness * wa * wb * along);
                        }
                    }
                }
            }
        }
        for v in 0..n {
            let p = place[v] as usize * block;
            let by = problem.inertia;
            if by > 0.0 {
                (0..3).for_each(|a| matrix.add(p + a, p + a, bundle.mass[v] * by));
                if block == 4 {
                    matrix.add(p + 3, p + 3, bundle.inertia[v] * by);
                }
            }
        }
        for touch in problem.touches {
            add_touch(&mut matrix, touch, |v, axis| row((3 * v + axis) as u32));
        }
        self.matrix = matrix;
    }
}

/// Adds the stiffness of a contact. What joins two rods in it has no place in the matrix: twice its diagonal blocks are
/// taken in place of the whole, which is never less.
fn add_touch(matrix: &mut Envelope, touch: &Touch, row: impl Fn(usize, usize) -> usize) {
    let normal = touch.normal;
    let parts: Vec<(usize, f64)> = touch.shares().collect();
    let by = if touch.other.is_some() { 2.0 } else { 1.0 };
    for (a, pa) in parts.iter().enumerate() {
        for (_, pb) in parts.iter().enumerate().filter(|(b, _)| a / 2 == b / 2) {
            for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                let (i, j) = (row(pa.0, r), row(pb.0, c));
                if j <= i {
                    matrix.add(i, j, by * pa.1 * pb.1 * touch_block(touch, normal, r, c));
                }
            }
        }
    }
}

/// Stiffness of a contact along axes r and c, N/m.
pub(super) fn touch_block(touch: &Touch, normal: DVec3, r: usize, c: usize) -> f64 {
    let along = normal[r] * normal[c];
    let same = f64::from(u8::from(r == c));
    touch.stiffness * along + touch.hold * (same - along)
}
