//! Linear systems of a bundle by conjugate gradients, for solvers that have a picture's time for a step and must not
//! remember anything from one step to the next.
//!
//! The preconditioner knows what is stiff in wood. Each rod is solved exactly along the grain, a band of three blocks,
//! with its bonds to others on the diagonal; and each section moves as a whole, stretches and shears in its plane (nine
//! freedoms for each piece of a section that bonds still hold together: the beam that a stem is). What is left to the
//! iteration is how rods of one section move against each other. The two corrections are added (an additive two-level
//! Schwarz method); no piece is remembered that has broken.
//!
//! Sums run in fixed blocks, so that the number of threads changes no bit.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::band::{Blocks, add_rods, add_touch, hold, multiply_band};
use super::lines::Lines;
use super::newton::Problem;
use super::sections::{Motion, Sections};
use super::strings::Strings;
use super::wide;
use crate::bundle::Bundle;
use crate::kernel::{Evaluator, Lane, NO_MOTION, Own, Row};
use crate::solver::Touch;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Tasks that a pass over all vertices is made of at most, and that a sum is of.
const TASKS: usize = 16;
/// Iterations at most.
const MOST: usize = 400;

/// The matrix of a bundle with `B` freedoms at a vertex, and its preconditioner.
#[derive(Debug, Clone, Default)]
pub(super) struct System<const B: usize> {
    generation: Option<u64>,
    /// What rods and inertia make of the matrix; bonds are the evaluator's. Without twist for the preconditioner alone.
    band: Vec<Blocks<B>>,
    /// What bonds have between vertices of one rod.
    own: Vec<Own>,
    /// The band with that, where the band itself must be kept; and with contacts.
    whole: Vec<Blocks<B>>,
    touched: Vec<Blocks<B>>,
    lines: Lines<B>,
    sections: Sections,
    tasks: Vec<Task>,
    /// Forces on pieces of sections, and their motion.
    motion: Vec<Motion>,
    free: Vec<Row>,
    iterations: u64,
    room: Room,
}

/// Rods that one task takes.
#[derive(Debug, Clone, Default)]
struct Task {
    groups: Range<usize>,
    vertices: Range<usize>,
    strings: Strings,
    lanes: Vec<Lane>,
    motion: Vec<Motion>,
    /// Its part of a dot product.
    product: f64,
}

/// Vectors of the iteration.
#[derive(Debug, Clone, Default)]
struct Room {
    x: Vec<Row>,
    r: Vec<Row>,
    z: Vec<Row>,
    p: Vec<Row>,
    q: Vec<Row>,
}

/// The parts of some vector of vertices that belong to tasks.
fn parts<'a, T>(tasks: &[Range<usize>], of: &'a mut [T]) -> Vec<&'a mut [T]> {
    let mut left = of;
    let mut made = Vec::with_capacity(tasks.len());
    for range in tasks {
        let (own, rest) = left.split_at_mut(range.len());
        made.push(own);
        left = rest;
    }
    made
}

/// Calls `work` for each task with what belongs to it.
fn each<T: Send>(tasks: &mut [Task], with: Vec<T>, work: impl Fn(&mut Task, T) + Sync) {
    if rayon::current_num_threads() > 1 {
        tasks
            .par_iter_mut()
            .zip(with)
            .for_each(|(task, own)| work(task, own));
    } else {
        (tasks.iter_mut().zip(with)).for_each(|(task, own)| work(task, own));
    }
}

impl<const B: usize> System<B> {
    /// Conjugate gradients so far.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Makes everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &Bundle) {
        if self.generation == Some(bundle.generation) {
            return;
        }
        self.generation = Some(bundle.generation);
        self.lines.prepare(bundle);
        self.sections.prepare(bundle);
        let groups = self.lines.groups();
        let count = groups.min(TASKS);
        self.tasks.resize(count, Task::default());
        for (k, task) in self.tasks.iter_mut().enumerate() {
            task.groups = groups * k / count..groups * (k + 1) / count;
            task.vertices = self.lines.vertices(task.groups.clone());
        }
    }

    /// The same, where bonds have lost their stiffness.
    pub fn weakened(&mut self, bundle: &Bundle) {
        self.sections.prepare(bundle);
    }

    fn ranges(&self) -> Vec<Range<usize>> {
        self.tasks.iter().map(|t| t.vertices.clone()).collect()
    }

    /// The step of a problem: `prescribed` where held, else what balances the linearised forces.
    pub fn solve(&mut self, problem: &Problem, evaluator: &mut Evaluator) -> Vec<f64> {
        let n = problem.bundle.vertices();
        let node = |of: &[f64], v: usize| {
            let mut row = NO_MOTION;
            row.0[..B].copy_from_slice(&of[v * B..(v + 1) * B]);
            row
        };
        let free = |v: usize| {
            let mut row = NO_MOTION;
            (0..B).for_each(|a| row.0[a] = f64::from(u8::from(!problem.held[v * B + a])));
            row
        };
        self.free.clear();
        self.free.extend((0..n).map(free));
        self.assemble(problem, evaluator);
        let mut room = std::mem::take(&mut self.room);
        let Room { x, r, z, p, q } = &mut room;
        x.clear();
        x.extend((0..n).map(|v| node(problem.prescribed, v)));
        r.clear();
        r.extend((0..n).map(|v| node(problem.residual, v)));
        [&mut *z, &mut *p, &mut *q]
            .into_iter()
            .for_each(|v| v.resize(n, NO_MOTION));
        if problem.prescribed.iter().any(|d| *d != 0.0) {
            self.multiply(problem, evaluator, x, q);
            (r.iter_mut().zip(&*q)).for_each(|(r, q)| (0..4).for_each(|a| r.0[a] -= q.0[a]));
        }
        mask(r, &self.free);
        if problem.fresh {
            self.factor(problem.bundle, problem.touches, evaluator);
        }
        self.conjugate_gradients(problem, evaluator, &mut room);
        let mut step = Vec::with_capacity(n * B);
        room.x
            .iter()
            .for_each(|x| step.extend_from_slice(&x.0[..B]));
        self.room = room;
        step
    }

    fn conjugate_gradients(
        &mut self,
        problem: &Problem,
        evaluator: &mut Evaluator,
        room: &mut Room,
    ) {
        room.p.fill(NO_MOTION);
        let mut rz = self.precondition(0.0, room);
        self.turn(0.0, room);
        let goal = problem.accuracy * problem.accuracy * rz;
        for _ in 0..MOST {
            if rz <= goal || !rz.is_finite() {
                return;
            }
            self.iterations += 1;
            let curvature = self.multiply(problem, evaluator, &room.p, &mut room.q);
            if curvature.is_nan() || curvature <= 0.0 {
                return;
            }
            let next = self.precondition(rz / curvature, room);
            self.turn(next / rz, room);
            rz = next;
        }
    }

    /// Goes `along` the direction, and solves rods (into z) and sections for the residual there. Returns the product of the
    /// residual and the solution.
    fn precondition(&mut self, along: f64, room: &mut Room) -> f64 {
        let ranges = self.ranges();
        let Room { x, r, z, p, q } = room;
        let own = (parts(&ranges, x).into_iter())
            .zip(parts(&ranges, r))
            .zip(parts(&ranges, z));
        let (lines, sections, p, q) = (&self.lines, &self.sections, &*p, &*q);
        each(&mut self.tasks, own.collect(), |task, ((x, r), z)| {
            let Task {
                groups,
                vertices,
                lanes,
                motion,
                product,
                ..
            } = task;
            let (p, q) = (&p[vertices.clone()], &q[vertices.clone()]);
            motion.clear();
            motion.resize(sections.pieces(), [[0.0; 4]; 3]);
            wide(
                #[inline(always)]
                || {
                    if along != 0.0 {
                        for (x, p) in x.iter_mut().zip(p) {
                            (0..4).for_each(|a| x.0[a] += along * p.0[a]);
                        }
                        for (r, q) in r.iter_mut().zip(q) {
                            (0..4).for_each(|a| r.0[a] -= along * q.0[a]);
                        }
                    }
                    lines.solve(groups.clone(), r, z, lanes);
                    sections.gather(vertices.start, r, motion);
                    *product = dot(r, z);
                },
            );
        });
        self.motion.clear();
        self.motion.resize(sections.pieces(), [[0.0; 4]; 3]);
        for task in &self.tasks {
            for (sum, more) in self.motion.iter_mut().zip(&task.motion) {
                (0..3).for_each(|s| (0..4).for_each(|a| sum[s][a] += more[s][a]));
            }
        }
        let rods = self.tasks.iter().fold(0.0, |sum, t| sum + t.product);
        rods + self.sections.solve(&mut self.motion)
    }

    /// The next direction: the solution, and `keep` of the last.
    fn turn(&mut self, keep: f64, room: &mut Room) {
        let ranges = self.ranges();
        let own = (parts(&ranges, &mut room.z).into_iter()).zip(parts(&ranges, &mut room.p));
        let (sections, motion, free) = (&self.sections, &self.motion, &self.free);
        each(&mut self.tasks, own.collect(), |task, (z, p)| {
            let first = task.vertices.start;
            wide(
                #[inline(always)]
                || {
                    sections.add(motion, first, z);
                    for ((p, z), free) in p.iter_mut().zip(&*z).zip(&free[first..]) {
                        (0..4).for_each(|a| p.0[a] = z.0[a] * free.0[a] + keep * p.0[a]);
                    }
                },
            );
        });
    }

    /// `out` = matrix × `x`, but for what is not free. Returns the product of both.
    fn multiply(
        &mut self,
        problem: &Problem,
        evaluator: &mut Evaluator,
        x: &[Row],
        out: &mut [Row],
    ) -> f64 {
        evaluator.meet(x);
        let ranges = self.ranges();
        let (evaluator, band, free) = (&*evaluator, &self.band, &self.free);
        each(&mut self.tasks, parts(&ranges, out), |task, out| {
            let range = task.vertices.clone();
            evaluator.gather_met(problem.bundle, range.start, out);
            let (strings, product) = (&mut task.strings, &mut task.product);
            wide(
                #[inline(always)]
                || {
                    let own = &x[range.clone()];
                    if B == 3 {
                        strings.multiply(own, out);
                    } else {
                        multiply_band(band, x, range.start, out);
                    }
                    mask(out, &free[range.clone()]);
                    *product = dot(own, out);
                },
            );
        });
        let mut product = self.tasks.iter().fold(0.0, |sum, t| sum + t.product);
        for touch in problem.touches {
            let way = touch.shares().fold(DVec3::ZERO, |sum, (v, w)| {
                let [a, b, c, _] = x[v].0;
                sum + w * DVec3::new(a, b, c)
            });
            let pressed = touch.normal * ((touch.stiffness - touch.hold) * way.dot(touch.normal));
            let force = pressed + way * touch.hold;
            product += force.dot(way);
            for (v, w) in touch.shares() {
                (0..3).for_each(|a| out[v].0[a] += force[a] * w * free[v].0[a]);
            }
        }
        product
    }

    /// Makes the matrix, or what stands for it.
    fn assemble(&mut self, problem: &Problem, evaluator: &mut Evaluator) {
        let banded = B != 3 || problem.fresh;
        if banded {
            self.band.clear();
            (self.band).resize(problem.bundle.vertices(), [[[0.0; 4]; B]; 3]);
        }
        let ranges = self.ranges();
        let own = if banded {
            parts(&ranges, &mut self.band)
        } else {
            self.tasks.iter().map(|_| Default::default()).collect()
        };
        let tasks = &mut self.tasks;
        rayon::join(
            || {
                each(tasks, own, |task, band| {
                    add_rods(problem, task.vertices.start, band);
                    if B == 3 {
                        task.strings.linearise(problem, &task.vertices);
                    }
                });
            },
            || evaluator.linearise(problem.state),
        );
    }

    /// Makes the preconditioner.
    fn factor(&mut self, bundle: &Bundle, touches: &[Touch], evaluator: &Evaluator) {
        let (free, own, band) = (&self.free, &mut self.own, &mut self.band);
        evaluator.own_blocks(bundle, own);
        if B == 3 {
            add_own(own, band);
        } else {
            // The matrix is still multiplied by.
            self.whole.clone_from(band);
            add_own(own, &mut self.whole);
        }
        let whole = if B == 3 { band } else { &mut self.whole };
        hold(whole, free);
        let (whole, touched) = (&*whole, &mut self.touched);
        let (lines, sections) = (&mut self.lines, &mut self.sections);
        rayon::join(
            || {
                if touches.is_empty() {
                    return lines.factor(whole);
                }
                touched.clear();
                touched.extend_from_slice(whole);
                // Contacts between rods with twice their blocks on the diagonal, which are never less than they.
                for touch in touches {
                    let by = if touch.other.is_some() { 2.0 } else { 1.0 };
                    add_touch(touch, by, touched);
                }
                hold(touched, free);
                lines.factor(touched);
            },
            || sections.factor(whole, evaluator, touches, free),
        );
    }
}

/// Adds what bonds have between vertices of one rod.
fn add_own<const B: usize>(own: &[Own], band: &mut [Blocks<B>]) {
    const PLACE: [[usize; 3]; 3] = [[0, 4, 5], [4, 1, 6], [5, 6, 2]];
    let mut last = [0.0; 8];
    for (own, [diagonal, across, _]) in own.iter().zip(band) {
        let mut sum = own.vertex.0;
        for ((sum, start), end) in sum.iter_mut().zip(own.start.0).zip(last) {
            *sum += start + end;
        }
        last = own.end.0;
        let [left, right] = &own.across;
        for b in 0..3 {
            let column = if b < 2 {
                &left.0[4 * b..]
            } else {
                &right.0[..]
            };
            for a in 0..3 {
                diagonal[b][a] += sum[PLACE[a][b]];
                across[b][a] += column[a];
            }
        }
    }
}

#[inline(always)]
fn mask(of: &mut [Row], free: &[Row]) {
    of.iter_mut()
        .zip(free)
        .for_each(|(v, f)| (0..4).for_each(|a| v.0[a] *= f.0[a]));
}

#[inline(always)]
fn dot(a: &[Row], b: &[Row]) -> f64 {
    let mut lanes = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|l| lanes[l] += a.0[l] * b.0[l]);
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
}
