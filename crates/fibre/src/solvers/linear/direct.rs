//! Linear systems with a Cholesky factor that is retained from step to step ([`super::envelope`]): conjugate gradients with
//! the last factor, which is made anew where it has become too old. A factor costs as much as some fifty iterations, and
//! between two load steps little of the matrix changes.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::envelope::{Accuracy, EnvelopeMatrix, FactorError, conjugate_gradients};
use super::ordering::reverse_cuthill_mckee;
use super::problem::LinearProblem;
use crate::contact::ContactSpring;
use crate::energy::bond::{BondSpring, BondTangent};
use crate::energy::hessian::{ElementHessian, HessianKind, MAX_ELEMENT_DOFS};
use crate::energy::{bend_twist, bond, rod};
use crate::failure::cohesion::softening_tangent;
use crate::rod_bundle::RodBundle;
use crate::solvers::grip::ResolvedGrip;
use greenstick_geometry::{Cancelled, Context};

/// Stiffness of a yielding edge over that of an elastic one, in the matrix only: without any it could be singular.
const YIELDED_STIFFNESS_RATIO: f64 = 1e-3;
/// Parts of the softening of bonds that are tried where with all of it the matrix is not positive: a crack that runs ahead by
/// itself moves slowly in steps that know little of it.
const REDUCED_SOFTENING: [f64; 2] = [0.98, 0.8];
/// Conjugate gradient iterations before a new factor is made.
const MAX_ITERATIONS_WITH_OLD_FACTOR: usize = 14;

/// Stiffness that holds loose parts, over the largest entry on the diagonal.
const LOOSE_PART_STIFFNESS: f64 = 1e-6;
/// Elements that are assembled between two checks for cancellation.
const ELEMENTS_PER_CHECK: usize = 1 << 14;

/// The matrix and its last factor.
#[derive(Debug, Clone, Default)]
pub(crate) struct DirectSolver {
    block: usize,
    /// Per vertex: its number in the matrix.
    number: Vec<u32>,
    matrix: EnvelopeMatrix,
    factor: Option<EnvelopeMatrix>,
    factorisations: usize,
}

impl DirectSolver {
    /// Returns the number of factors made so far.
    pub fn factorisations(&self) -> usize {
        self.factorisations
    }

    /// Derives everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &RodBundle, grips: &[ResolvedGrip]) {
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
                pairs.extend(g.vertices[..k].iter().map(|b| (a.vertex, b.vertex)));
            }
        }
        self.number = vec![0; n];
        for (k, v) in reverse_cuthill_mckee(n, &pairs).into_iter().enumerate() {
            self.number[v as usize] = k as u32;
        }
        let number = &self.number;
        let numbered = pairs
            .iter()
            .map(|&(a, b)| (number[a as usize], number[b as usize]));
        self.matrix = EnvelopeMatrix::zeros(self.block, n, numbered);
        self.factor = None;
    }

    /// Returns the step that balances the linearised forces; where clamps hold, it is the prescribed one.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    pub fn solve(
        &mut self,
        problem: &LinearProblem,
        context: &Context,
    ) -> Result<Vec<f64>, Cancelled> {
        let rows = problem.residual.len();
        let block = self.block;
        let at = |f: usize| self.number[f / block] as usize * block + f % block;
        let (mut residual, mut prescribed) = (vec![0.0; rows], vec![0.0; rows]);
        let mut held = vec![false; rows];
        for f in 0..rows {
            residual[at(f)] = problem.residual[f];
            prescribed[at(f)] = problem.prescribed[f];
            held[at(f)] = problem.held[f];
        }
        let step = self.solve_numbered(problem, &residual, &prescribed, &held, context)?;
        let at = |f: usize| self.number[f / block] as usize * block + f % block;
        Ok((0..rows).map(|f| step[at(f)]).collect())
    }

    fn solve_numbered(
        &mut self,
        problem: &LinearProblem,
        residual: &[f64],
        prescribed: &[f64],
        held: &[bool],
        context: &Context,
    ) -> Result<Vec<f64>, Cancelled> {
        let softens = !problem.softened.is_empty();
        let reduced = REDUCED_SOFTENING.map(|softening| (HessianKind::Exact, softening));
        let trials = [(HessianKind::Exact, 1.0)].into_iter();
        let trials = trials.chain(reduced.into_iter().filter(|_| softens));
        for (kind, softening) in trials.chain([(HessianKind::GaussNewton, 0.0)]) {
            self.assemble(problem, kind, context)?;
            self.add_softening(problem, kind, softening);
            let mut right = residual.to_vec();
            self.apply_prescribed(prescribed, held, &mut right, context)?;
            if let Some(step) = self.solve_with_old_factor(problem, &right, context)? {
                return Ok(step);
            }
            self.factorisations += 1;
            let mut factor = self.matrix.copy(context)?;
            match factor.factor(context) {
                Ok(()) => {
                    factor.solve_large(&mut right, context)?;
                    self.factor = Some(factor);
                    return Ok(right);
                }
                Err(FactorError::NotPositive { .. }) => {}
                Err(FactorError::Cancelled) => return Err(Cancelled),
            }
        }
        self.solve_with_loose_parts_held(residual, prescribed, held, context)
    }

    /// Removes held degrees of freedom from the matrix, and moves what their prescribed displacement causes to the right side.
    fn apply_prescribed(
        &mut self,
        prescribed: &[f64],
        held: &[bool],
        right: &mut [f64],
        context: &Context,
    ) -> Result<(), Cancelled> {
        if prescribed.iter().any(|d| *d != 0.0) {
            let mut forces = vec![0.0; right.len()];
            self.matrix.multiply(prescribed, &mut forces, context)?;
            right.iter_mut().zip(&forces).for_each(|(r, f)| *r -= f);
        }
        self.matrix.remove_held(held, context)?;
        for f in 0..right.len() {
            if held[f] {
                right[f] = prescribed[f];
            }
        }
        Ok(())
    }

    fn solve_with_old_factor(
        &self,
        problem: &LinearProblem,
        right: &[f64],
        context: &Context,
    ) -> Result<Option<Vec<f64>>, Cancelled> {
        let Some(factor) = &self.factor else {
            return Ok(None);
        };
        let accuracy = Accuracy {
            tolerance: problem.tolerance,
            max_iterations: MAX_ITERATIONS_WITH_OLD_FACTOR,
        };
        let mut step = vec![0.0; right.len()];
        let done = conjugate_gradients(&self.matrix, factor, right, &mut step, accuracy, context)?;
        Ok(done.then_some(step))
    }

    /// Solves where not even the Gauss–Newton matrix has a factor, because something hangs loose: a little stiffness holds it.
    fn solve_with_loose_parts_held(
        &mut self,
        residual: &[f64],
        prescribed: &[f64],
        held: &[bool],
        context: &Context,
    ) -> Result<Vec<f64>, Cancelled> {
        self.factor = None;
        let rows = residual.len();
        let largest = (0..rows)
            .map(|i| self.matrix.diagonal(i))
            .fold(0.0, f64::max);
        let mut right = residual.to_vec();
        for f in 0..rows {
            if held[f] {
                right[f] = prescribed[f];
            } else {
                self.matrix.add(f, f, LOOSE_PART_STIFFNESS * largest);
            }
        }
        let mut factor = self.matrix.copy(context)?;
        match factor.factor(context) {
            Ok(()) => factor.solve_large(&mut right, context)?,
            Err(FactorError::NotPositive { .. }) => {}
            Err(FactorError::Cancelled) => return Err(Cancelled),
        }
        Ok(right)
    }

    /// Assembles the second derivatives of everything at the problem's state.
    fn assemble(
        &mut self,
        problem: &LinearProblem,
        kind: HessianKind,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let (bundle, state) = (problem.bundle, problem.state);
        let n = bundle.vertices();
        self.matrix.clear(context)?;
        for start in (0..n).step_by(ELEMENTS_PER_CHECK) {
            context.check()?;
            for j in (start..n.min(start + ELEMENTS_PER_CHECK)).filter(|&j| bundle.is_edge(j)) {
                self.add(&rod::stretch_hessian(bundle, state, j, kind), n, 1.0);
                if state.plastic_strain[j] != problem.plastic[j] {
                    let elastic = rod::stretch_hessian(bundle, state, j, HessianKind::GaussNewton);
                    self.add(&elastic, n, YIELDED_STIFFNESS_RATIO - 1.0);
                }
            }
        }
        for start in (0..n).step_by(ELEMENTS_PER_CHECK) {
            context.check()?;
            for i in start..n.min(start + ELEMENTS_PER_CHECK) {
                if bundle.bend[i] <= 0.0 && bundle.twist[i] <= 0.0 {
                    continue;
                }
                let hessian = if bundle.twisting {
                    bend_twist::hessian(bundle, state, i)
                } else {
                    rod::bend_hessian(bundle, state, i, kind)
                };
                self.add(&hessian, n, 1.0);
            }
        }
        let bonds = bundle.bonds.len();
        for start in (0..bonds).step_by(ELEMENTS_PER_CHECK) {
            context.check()?;
            for b in start..bonds.min(start + ELEMENTS_PER_CHECK) {
                self.add(&bond::hessian(bundle, state, b, kind), n, 1.0);
            }
        }
        for grip in problem.grips {
            self.add_grip(grip);
        }
        self.add_inertia(problem);
        for spring in problem.springs {
            self.add_contact(spring);
        }
        Ok(())
    }

    /// Replaces the stiffness of bonds that soften at the problem's state: `softening` times their tangent, and for the rest the
    /// stiffness with which they would unload.
    fn add_softening(&mut self, problem: &LinearProblem, kind: HessianKind, softening: f64) {
        let (bundle, state) = (problem.bundle, problem.state);
        let n = bundle.vertices();
        for &(number, damage) in problem.softened {
            let number = number as usize;
            let spring = BondSpring::intact(bundle, number).damaged(damage);
            let (e, d) = bond::vectors(bundle, state, number);
            let unloading = BondTangent::elastic(&spring, spring.strain(e, d));
            let tangent =
                unloading.mixed_with(&softening_tangent(bundle, state, number), softening);
            self.add(&bond::hessian(bundle, state, number, kind), n, -1.0);
            let hessian = bond::hessian_of_tangent(bundle, state, number, &tangent, kind);
            self.add(&hessian, n, 1.0);
        }
    }

    /// Returns the row of a vertex's degree of freedom.
    fn row(&self, vertex: usize, axis: usize) -> usize {
        self.number[vertex] as usize * self.block + axis
    }

    /// Adds an element of a bundle of `vertices` vertices, `factor` times.
    fn add(&mut self, element: &ElementHessian, vertices: usize, factor: f64) {
        let mut rows = [0; MAX_ELEMENT_DOFS];
        for (row, dof) in rows.iter_mut().zip(element.dofs).take(element.count) {
            let f = dof as usize;
            *row = if f < 3 * vertices {
                self.row(f / 3, f % 3)
            } else {
                self.row(f - 3 * vertices, 3)
            };
        }
        for u in 0..element.count {
            for v in 0..element.count {
                if rows[v] <= rows[u] {
                    let entry = factor * element.matrix[u][v];
                    self.matrix.add(rows[u], rows[v], entry);
                }
            }
        }
    }

    fn add_grip(&mut self, grip: &ResolvedGrip) {
        for a in &grip.vertices {
            for b in &grip.vertices {
                for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                    let i = self.row(a.vertex as usize, r);
                    let j = self.row(b.vertex as usize, c);
                    if j <= i {
                        let entry = grip.stiffness * a.weight[r] * b.weight[c];
                        self.matrix.add(i, j, entry);
                    }
                }
            }
        }
    }

    fn add_inertia(&mut self, problem: &LinearProblem) {
        let (bundle, by) = (problem.bundle, problem.inertia);
        if by <= 0.0 {
            return;
        }
        for v in 0..bundle.vertices() {
            let p = self.row(v, 0);
            (0..3).for_each(|a| self.matrix.add(p + a, p + a, bundle.mass[v] * by));
            if self.block == 4 {
                self.matrix.add(p + 3, p + 3, bundle.inertia[v] * by);
            }
        }
    }

    /// Adds the stiffness of a contact. The envelope has no entries between two rods in contact: twice the diagonal blocks
    /// stand for the whole, and are never less.
    fn add_contact(&mut self, spring: &ContactSpring) {
        let shares: Vec<(usize, f64)> = spring.shares().collect();
        let by = if spring.other.is_some() { 2.0 } else { 1.0 };
        for (a, left) in shares.iter().enumerate() {
            for (_, right) in shares.iter().enumerate().filter(|(b, _)| a / 2 == b / 2) {
                for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                    let (i, j) = (self.row(left.0, r), self.row(right.0, c));
                    if j <= i {
                        let entry = by * left.1 * right.1 * spring.stiffness(r, c);
                        self.matrix.add(i, j, entry);
                    }
                }
            }
        }
    }
}
