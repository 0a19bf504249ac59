//! Linear systems by conjugate gradients, for solvers that have one frame's time for a step and may retain nothing from one
//! step to the next.
//!
//! The preconditioner knows what is stiff in wood. On the fine level each rod is solved exactly along the grain, as a band of
//! three blocks, with its bonds to others on the diagonal. On the coarse level each cross-section moves as a whole,
//! stretches and shears in its plane (nine degrees of freedom for each piece of a cross-section that bonds still connect:
//! the beam that a stem is). The iteration is left with how rods of one cross-section move against each other. The two
//! corrections are added (an additive two-level Schwarz method).
//!
//! Sums run in fixed blocks, so that the number of threads changes no bit.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::banded_preconditioner::BandedPreconditioner;
use super::coarse_space::{CoarseSpace, PieceVector};
use super::problem::LinearProblem;
use super::rod_blocks::{RodBlocks, add_contact, add_rods, multiply_band, remove_held};
use super::rod_operator::RodOperator;
use crate::contact::ContactSpring;
use crate::evaluator::ForceEvaluator;
use crate::rod_bundle::RodBundle;
use crate::simd::banded_cholesky::Lane;
use crate::simd::dispatch::with_widest_registers;
use crate::simd::lanes::PaddedVec3;
use crate::simd::same_rod_blocks::SameRodBlocks;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;
use std::ops::Range;

/// Largest number of tasks of a pass over all vertices, and of parts of a sum.
const MAX_TASKS: usize = 16;
const MAX_ITERATIONS: usize = 400;

/// The matrix of a bundle with `B` degrees of freedom at a vertex, and its preconditioner.
#[derive(Debug, Clone, Default)]
pub(crate) struct IterativeSolver<const B: usize> {
    generation: Option<u64>,
    /// Blocks of rods and inertia; the evaluator has the bonds. Without twist only the preconditioner needs them.
    band: Vec<RodBlocks<B>>,
    /// Blocks of bonds between vertices of one rod.
    same_rod: Vec<SameRodBlocks>,
    /// The sum of both, where the band itself is still needed; and that with contacts.
    with_bonds: Vec<RodBlocks<B>>,
    with_contacts: Vec<RodBlocks<B>>,
    rods: BandedPreconditioner<B>,
    coarse: CoarseSpace,
    tasks: Vec<Task>,
    /// Forces on pieces of cross-sections, then their displacements.
    pieces: Vec<PieceVector>,
    /// Per vertex: 1 for degrees of freedom that no clamp holds, else 0.
    pub(super) free: Vec<PaddedVec3>,
    pub(super) iterations: u64,
    pub(super) buffers: Buffers,
}

/// Rods of one task.
#[derive(Debug, Clone, Default)]
struct Task {
    groups: Range<usize>,
    vertices: Range<usize>,
    operator: RodOperator,
    lanes: Vec<Lane>,
    pieces: Vec<PieceVector>,
    /// Its part of a dot product.
    product: f64,
}

/// Sets the second vector to a matrix times the first, and returns their scalar product.
pub(super) type Product<'a, S> = dyn FnMut(&mut S, &[PaddedVec3], &mut [PaddedVec3]) -> f64 + 'a;

/// Vectors of the iteration: solution, residual, preconditioned residual, direction, and matrix × direction.
#[derive(Debug, Clone, Default)]
pub(super) struct Buffers {
    pub(super) x: Vec<PaddedVec3>,
    r: Vec<PaddedVec3>,
    z: Vec<PaddedVec3>,
    pub(super) p: Vec<PaddedVec3>,
    pub(super) q: Vec<PaddedVec3>,
}

/// Splits an array over vertices into those of the tasks.
fn split<'a, T>(tasks: &[Range<usize>], array: &'a mut [T]) -> Vec<&'a mut [T]> {
    let mut left = array;
    let mut parts = Vec::with_capacity(tasks.len());
    for range in tasks {
        let (own, rest) = left.split_at_mut(range.len());
        parts.push(own);
        left = rest;
    }
    parts
}

/// Calls `work` for each task with its own part.
fn for_each_task<T: Send>(tasks: &mut [Task], with: Vec<T>, work: impl Fn(&mut Task, T) + Sync) {
    if rayon::current_num_threads() > 1 {
        tasks
            .par_iter_mut()
            .zip(with)
            .for_each(|(task, own)| work(task, own));
    } else {
        (tasks.iter_mut().zip(with)).for_each(|(task, own)| work(task, own));
    }
}

impl<const B: usize> IterativeSolver<B> {
    /// Returns the number of iterations so far.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Derives everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &RodBundle) {
        if self.generation == Some(bundle.generation) {
            return;
        }
        self.generation = Some(bundle.generation);
        self.rods.prepare(bundle);
        self.coarse.prepare(bundle);
        let groups = self.rods.groups();
        let count = groups.min(MAX_TASKS);
        self.tasks.resize(count, Task::default());
        for (k, task) in self.tasks.iter_mut().enumerate() {
            task.groups = groups * k / count..groups * (k + 1) / count;
            task.vertices = self.rods.vertices(task.groups.clone());
        }
    }

    fn ranges(&self) -> Vec<Range<usize>> {
        self.tasks.iter().map(|t| t.vertices.clone()).collect()
    }

    /// Returns the step that balances the linearised forces; where clamps hold, it is the prescribed one.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    pub fn solve(
        &mut self,
        problem: &LinearProblem,
        evaluator: &mut ForceEvaluator,
        context: &Context,
    ) -> Result<Vec<f64>, Cancelled> {
        let mut buffers = std::mem::take(&mut self.buffers);
        self.begin(problem, evaluator, &mut buffers, context)?;
        let mut product = |solver: &mut Self, p: &[PaddedVec3], q: &mut [PaddedVec3]| {
            solver.multiply(problem, evaluator, p, q)
        };
        self.conjugate_gradients(problem.tolerance, &mut product, &mut buffers, context)?;
        let mut step = Vec::with_capacity(buffers.x.len() * B);
        buffers
            .x
            .iter()
            .for_each(|x| step.extend_from_slice(&x.0[..B]));
        self.buffers = buffers;
        Ok(step)
    }

    /// Linearises everything, makes the preconditioner where it is to be made anew, and begins with the prescribed displacements
    /// and the forces that they leave.
    pub(super) fn begin(
        &mut self,
        problem: &LinearProblem,
        evaluator: &mut ForceEvaluator,
        buffers: &mut Buffers,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let n = problem.bundle.vertices();
        let padded = |dofs: &[f64], v: usize| {
            let mut vector = PaddedVec3::ZERO;
            vector.0[..B].copy_from_slice(&dofs[v * B..(v + 1) * B]);
            vector
        };
        let free = |v: usize| {
            let mut vector = PaddedVec3::ZERO;
            (0..B).for_each(|a| vector.0[a] = f64::from(u8::from(!problem.held[v * B + a])));
            vector
        };
        self.free.clear();
        self.free.extend((0..n).map(free));
        self.assemble(problem, evaluator);
        let Buffers { x, r, z, p, q } = buffers;
        x.clear();
        x.extend((0..n).map(|v| padded(problem.prescribed, v)));
        r.clear();
        r.extend((0..n).map(|v| padded(problem.residual, v)));
        [&mut *z, &mut *p, &mut *q]
            .into_iter()
            .for_each(|v| v.resize(n, PaddedVec3::ZERO));
        if problem.prescribed.iter().any(|d| *d != 0.0) {
            self.multiply(problem, evaluator, x, q);
            (r.iter_mut().zip(&*q)).for_each(|(r, q)| (0..4).for_each(|a| r.0[a] -= q.0[a]));
        }
        mask(r, &self.free);
        if problem.update_preconditioner {
            self.factor(problem, evaluator, context)?;
        }
        Ok(())
    }

    /// Solves for the residual by conjugate gradients, with the product of the matrix and a direction that `multiply` sets and
    /// whose scalar product with the direction it returns. Returns the curvature of a direction, which `p` then is, where it is
    /// not positive.
    pub(super) fn conjugate_gradients(
        &mut self,
        tolerance: f64,
        multiply: &mut Product<Self>,
        buffers: &mut Buffers,
        context: &Context,
    ) -> Result<Option<f64>, Cancelled> {
        buffers.p.fill(PaddedVec3::ZERO);
        let mut rz = self.precondition(0.0, buffers);
        self.update_direction(0.0, buffers);
        let goal = tolerance * tolerance * rz;
        for _ in 0..MAX_ITERATIONS {
            context.check()?;
            if rz <= goal || !rz.is_finite() {
                break;
            }
            self.iterations += 1;
            let curvature = multiply(self, &buffers.p, &mut buffers.q);
            if curvature.is_nan() || curvature <= 0.0 {
                return Ok(Some(curvature));
            }
            let next = self.precondition(rz / curvature, buffers);
            self.update_direction(next / rz, buffers);
            rz = next;
        }
        Ok(None)
    }

    /// Moves `length` along the direction, and applies both levels of the preconditioner to the residual there: rods into z,
    /// cross-sections into the pieces. Returns the product of the residual and the preconditioned residual.
    pub(super) fn precondition(&mut self, length: f64, buffers: &mut Buffers) -> f64 {
        let ranges = self.ranges();
        let Buffers { x, r, z, p, q } = buffers;
        let own = (split(&ranges, x).into_iter())
            .zip(split(&ranges, r))
            .zip(split(&ranges, z));
        let (rods, coarse, p, q) = (&self.rods, &self.coarse, &*p, &*q);
        for_each_task(&mut self.tasks, own.collect(), |task, ((x, r), z)| {
            let Task {
                groups,
                vertices,
                lanes,
                pieces,
                product,
                ..
            } = task;
            let (p, q) = (&p[vertices.clone()], &q[vertices.clone()]);
            pieces.clear();
            pieces.resize(coarse.pieces(), [[0.0; 4]; 3]);
            with_widest_registers(
                #[inline(always)]
                || {
                    if length != 0.0 {
                        for (x, p) in x.iter_mut().zip(p) {
                            (0..4).for_each(|a| x.0[a] += length * p.0[a]);
                        }
                        for (r, q) in r.iter_mut().zip(q) {
                            (0..4).for_each(|a| r.0[a] -= length * q.0[a]);
                        }
                    }
                    rods.solve(groups.clone(), r, z, lanes);
                    coarse.restrict(vertices.start, r, pieces);
                    *product = dot(r, z);
                },
            );
        });
        self.pieces.clear();
        self.pieces.resize(coarse.pieces(), [[0.0; 4]; 3]);
        for task in &self.tasks {
            for (sum, more) in self.pieces.iter_mut().zip(&task.pieces) {
                (0..3).for_each(|s| (0..4).for_each(|a| sum[s][a] += more[s][a]));
            }
        }
        let rods = self.tasks.iter().fold(0.0, |sum, t| sum + t.product);
        rods + self.coarse.solve(&mut self.pieces)
    }

    /// Sets the next direction: the preconditioned residual, and `factor` times the last direction.
    pub(super) fn update_direction(&mut self, factor: f64, buffers: &mut Buffers) {
        let ranges = self.ranges();
        let own = (split(&ranges, &mut buffers.z).into_iter()).zip(split(&ranges, &mut buffers.p));
        let (coarse, pieces, free) = (&self.coarse, &self.pieces, &self.free);
        for_each_task(&mut self.tasks, own.collect(), |task, (z, p)| {
            let first = task.vertices.start;
            with_widest_registers(
                #[inline(always)]
                || {
                    coarse.prolong(pieces, first, z);
                    for ((p, z), free) in p.iter_mut().zip(&*z).zip(&free[first..]) {
                        (0..4).for_each(|a| p.0[a] = z.0[a] * free.0[a] + factor * p.0[a]);
                    }
                },
            );
        });
    }

    /// Sets `out` to matrix × `x`, with zeros for held degrees of freedom. Returns the product of both.
    pub(super) fn multiply(
        &mut self,
        problem: &LinearProblem,
        evaluator: &mut ForceEvaluator,
        x: &[PaddedVec3],
        out: &mut [PaddedVec3],
    ) -> f64 {
        evaluator.multiply_bonds(x);
        let ranges = self.ranges();
        let (evaluator, band, free) = (&*evaluator, &self.band, &self.free);
        for_each_task(&mut self.tasks, split(&ranges, out), |task, out| {
            let range = task.vertices.clone();
            evaluator.gather_bond_product(problem.bundle, range.start, out);
            let (operator, product) = (&mut task.operator, &mut task.product);
            with_widest_registers(
                #[inline(always)]
                || {
                    let own = &x[range.clone()];
                    if B == 3 {
                        operator.multiply(own, out);
                    } else {
                        multiply_band(band, x, range.start, out);
                    }
                    mask(out, &free[range.clone()]);
                    *product = dot(own, out);
                },
            );
        });
        let mut product = self.tasks.iter().fold(0.0, |sum, t| sum + t.product);
        for spring in problem.springs {
            let displacement = spring.shares().fold(DVec3::ZERO, |sum, (v, w)| {
                let [a, b, c, _] = x[v].0;
                sum + w * DVec3::new(a, b, c)
            });
            let (normal, tangential) = (spring.normal, spring.tangential_stiffness);
            let pressure = (spring.normal_stiffness - tangential) * displacement.dot(normal);
            let force = normal * pressure + displacement * tangential;
            product += force.dot(displacement);
            for (v, w) in spring.shares() {
                (0..3).for_each(|a| out[v].0[a] += force[a] * w * free[v].0[a]);
            }
        }
        product
    }

    /// Linearises rods and bonds.
    fn assemble(&mut self, problem: &LinearProblem, evaluator: &mut ForceEvaluator) {
        let banded = B != 3 || problem.update_preconditioner;
        if banded {
            self.band.clear();
            (self.band).resize(problem.bundle.vertices(), [[[0.0; 4]; B]; 3]);
        }
        let ranges = self.ranges();
        let own = if banded {
            split(&ranges, &mut self.band)
        } else {
            self.tasks.iter().map(|_| Default::default()).collect()
        };
        let tasks = &mut self.tasks;
        rayon::join(
            || {
                for_each_task(tasks, own, |task, band| {
                    add_rods(problem, task.vertices.start, band);
                    if B == 3 {
                        task.operator.linearise(problem, &task.vertices);
                    }
                });
            },
            || evaluator.linearise_bonds(problem.state),
        );
    }

    /// Factors both levels of the preconditioner.
    fn factor(
        &mut self,
        problem: &LinearProblem,
        evaluator: &ForceEvaluator,
        context: &Context,
    ) -> Result<(), Cancelled> {
        context.check()?;
        let (free, same_rod, band) = (&self.free, &mut self.same_rod, &mut self.band);
        evaluator.same_rod_blocks(problem.bundle, same_rod);
        let blocks = if B == 3 {
            band
        } else {
            // Products still need the band itself.
            self.with_bonds.clone_from(band);
            &mut self.with_bonds
        };
        add_same_rod(same_rod, blocks);
        remove_held(blocks, free);
        let (blocks, with_contacts) = (&*blocks, &mut self.with_contacts);
        let (rods, coarse, springs) = (&mut self.rods, &mut self.coarse, problem.springs);
        let ((), factored) = rayon::join(
            || {
                if springs.is_empty() {
                    return rods.factor(blocks);
                }
                with_contacts.clear();
                with_contacts.extend_from_slice(blocks);
                add_contacts(springs, with_contacts);
                remove_held(with_contacts, free);
                rods.factor(with_contacts);
            },
            || coarse.factor(blocks, evaluator, springs, free, context),
        );
        factored
    }
}

/// Adds contacts: those between rods with twice their blocks on the diagonal, which are never less than the whole.
fn add_contacts<const B: usize>(springs: &[ContactSpring], band: &mut [RodBlocks<B>]) {
    for spring in springs {
        let factor = if spring.other.is_some() { 2.0 } else { 1.0 };
        add_contact(spring, factor, band);
    }
}

/// Adds the blocks of bonds between vertices of one rod.
fn add_same_rod<const B: usize>(same_rod: &[SameRodBlocks], band: &mut [RodBlocks<B>]) {
    const ENTRY: [[usize; 3]; 3] = [[0, 4, 5], [4, 1, 6], [5, 6, 2]];
    let mut last = [0.0; 8];
    for (blocks, [diagonal, across, _]) in same_rod.iter().zip(band) {
        let mut sum = blocks.vertex.0;
        for ((sum, start), end) in sum.iter_mut().zip(blocks.start.0).zip(last) {
            *sum += start + end;
        }
        last = blocks.end.0;
        let [left, right] = &blocks.across;
        for b in 0..3 {
            let column = if b < 2 {
                &left.0[4 * b..]
            } else {
                &right.0[..]
            };
            for a in 0..3 {
                diagonal[b][a] += sum[ENTRY[a][b]];
                across[b][a] += column[a];
            }
        }
    }
}

#[inline(always)]
pub(super) fn mask(vectors: &mut [PaddedVec3], free: &[PaddedVec3]) {
    vectors
        .iter_mut()
        .zip(free)
        .for_each(|(v, f)| (0..4).for_each(|a| v.0[a] *= f.0[a]));
}

#[inline(always)]
pub(super) fn dot(a: &[PaddedVec3], b: &[PaddedVec3]) -> f64 {
    let mut lanes = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|l| lanes[l] += a.0[l] * b.0[l]);
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
}
