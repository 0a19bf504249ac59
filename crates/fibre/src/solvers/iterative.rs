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

use super::direct::touch_block;
use super::lines::Lines;
use super::newton::Problem;
use super::sections::Sections;
use super::wide;
use crate::bundle::Bundle;
use crate::energy::{ElementHessian, framed};
use crate::kernel::{Evaluator, NO_MOTION, Row};
use crate::solver::Touch;
use crate::state::State;
use glam::DVec3;
use rayon::prelude::*;

/// Column of a block.
pub(super) type Column = [f64; 4];
/// Blocks of a vertex with itself and the next two of its rod, as columns.
pub(super) type Blocks<const B: usize> = [[Column; B]; 3];
/// Vertices that one task takes, and that one sum is of.
const GRAIN: usize = 256;
/// Iterations at most.
const MOST: usize = 400;
/// Stiffness of a yielding edge over that of an elastic one: none at all could leave the matrix singular.
const YIELDING: f64 = 2e-2;

/// The matrix of a bundle with `B` freedoms at a vertex, and its preconditioner.
#[derive(Debug, Clone, Default)]
pub(super) struct System<const B: usize> {
    generation: Option<u64>,
    /// What rods, inertia and bodies make of the matrix; bonds are the evaluator's.
    band: Vec<Blocks<B>>,
    /// The same with what bonds and contacts add between vertices of one rod.
    whole: Vec<Blocks<B>>,
    lines: Lines<B>,
    sections: Sections,
    /// Contacts between rods.
    pushes: Vec<Push>,
    free: Vec<Row>,
    iterations: u64,
    room: Room,
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

/// A contact between two rods.
#[derive(Debug, Clone, Copy)]
struct Push {
    /// Vertices of the one and of the other, with their weights.
    shares: [(usize, f64); 4],
    normal: glam::DVec3,
    stiffness: f64,
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
    }

    /// The same, where bonds have lost their stiffness.
    pub fn weakened(&mut self, bundle: &Bundle) {
        self.sections.prepare(bundle);
    }

    /// The step of a problem: `prescribed` where held, else what balances the linearised forces.
    pub fn solve(&mut self, problem: &Problem, evaluator: &mut Evaluator) -> Vec<f64> {
        let n = problem.bundle.vertices();
        let node = |of: &[f64], v: usize| {
            Row(std::array::from_fn(
                |a| {
                    if a < B { of[v * B + a] } else { 0.0 }
                },
            ))
        };
        let free = |v: usize| {
            Row(std::array::from_fn(|a| {
                f64::from(a < B && !problem.held[v * B + a])
            }))
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
            self.multiply(problem.bundle, evaluator, x, q);
            r.iter_mut()
                .zip(&*q)
                .for_each(|(r, q)| (0..4).for_each(|a| r.0[a] -= q.0[a]));
        }
        mask(r, &self.free);
        if problem.fresh {
            self.factor(problem.touches, evaluator);
        }
        self.conjugate_gradients(problem, evaluator, &mut room);
        let step = room.x.iter().flat_map(|x| x.0[..B].iter().copied());
        let step = step.collect();
        self.room = room;
        step
    }

    fn conjugate_gradients(
        &mut self,
        problem: &Problem,
        evaluator: &mut Evaluator,
        room: &mut Room,
    ) {
        let Room { x, r, z, p, q } = room;
        let n = r.len();
        self.precondition(r, z);
        p.copy_from_slice(z);
        let mut rz = dot(r, z);
        let goal = problem.accuracy * problem.accuracy * rz;
        for _ in 0..MOST {
            if rz <= goal || !rz.is_finite() {
                return;
            }
            self.iterations += 1;
            self.multiply(problem.bundle, evaluator, p, q);
            mask(q, &self.free);
            let curvature = dot(p, q);
            if curvature.is_nan() || curvature <= 0.0 {
                return;
            }
            let along = rz / curvature;
            for v in 0..n {
                for a in 0..4 {
                    x[v].0[a] += along * p[v].0[a];
                    r[v].0[a] -= along * q[v].0[a];
                }
            }
            self.precondition(r, z);
            let next = dot(r, z);
            let keep = next / rz;
            rz = next;
            for v in 0..n {
                (0..4).for_each(|a| p[v].0[a] = z[v].0[a] + keep * p[v].0[a]);
            }
        }
    }

    fn precondition(&self, r: &[Row], z: &mut [Row]) {
        let coarse = {
            let (lines, sections) = (&self.lines, &self.sections);
            rayon::join(|| lines.solve(r, z), || sections.solve(r)).1
        };
        self.sections.add(&coarse, z);
        mask(z, &self.free);
    }

    /// `out` = matrix × `x`, but for what is not free.
    fn multiply(&self, bundle: &Bundle, evaluator: &mut Evaluator, x: &[Row], out: &mut [Row]) {
        evaluator.meet(x);
        let (evaluator, band) = (&*evaluator, &self.band);
        out.par_chunks_mut(GRAIN).enumerate().for_each(|(k, out)| {
            let first = k * GRAIN;
            evaluator.gather_met(bundle, first, out);
            wide(
                #[inline(always)]
                || multiply_band(band, x, first, out),
            );
        });
        for push in &self.pushes {
            let along = |of: &[(usize, f64)]| {
                of.iter().fold(0.0, |sum, &(v, w)| {
                    let [x, y, z, _] = x[v].0;
                    sum + w * glam::DVec3::new(x, y, z).dot(push.normal)
                })
            };
            let met = push.stiffness * along(&push.shares);
            for &(v, w) in &push.shares {
                let force = push.normal * (met * w);
                (0..3).for_each(|a| out[v].0[a] += force[a]);
            }
        }
    }

    /// Makes the matrix.
    fn assemble(&mut self, problem: &Problem, evaluator: &mut Evaluator) {
        let bundle = problem.bundle;
        self.band.clear();
        self.band.resize(bundle.vertices(), [[[0.0; 4]; B]; 3]);
        // Parts of whole rods.
        let mut parts = Vec::new();
        let (mut left, mut start) = (&mut self.band[..], 0);
        for &end in &bundle.first[1..] {
            let end = end as usize;
            if end - start >= GRAIN || end == bundle.vertices() {
                let (part, rest) = left.split_at_mut(end - start);
                parts.push((start, part));
                (left, start) = (rest, end);
            }
        }
        rayon::join(
            || {
                parts
                    .into_par_iter()
                    .for_each(|(start, part)| add_rods(problem, start, part));
            },
            || evaluator.linearise(problem.state),
        );
        self.pushes.clear();
        for touch in problem.touches {
            let mut shares = [(0, 0.0); 4];
            let mut count = 0;
            for (to, share) in shares.iter_mut().zip(touch.shares()) {
                *to = share;
                count += 1;
            }
            if count == 4 {
                self.pushes.push(Push {
                    shares,
                    normal: touch.normal,
                    stiffness: touch.stiffness,
                });
            } else {
                add_touch(touch, 1.0, &mut self.band);
            }
        }
    }

    /// Makes the preconditioner.
    fn factor(&mut self, touches: &[Touch], evaluator: &Evaluator) {
        let (band, free) = (&mut self.band, &self.free);
        hold(band, free);
        let (whole, lines, sections) = (&mut self.whole, &mut self.lines, &mut self.sections);
        rayon::join(
            || {
                whole.clone_from(band);
                wide(
                    #[inline(always)]
                    || {
                        evaluator.each_slope(
                            #[inline(always)]
                            |slope| {
                                add_own(&slope.nodes, &slope.length, whole);
                                add_own(&slope.nodes, &slope.cosine, whole);
                            },
                        );
                    },
                );
                // Contacts between rods with twice their blocks on the diagonal, which are never less than they.
                let between = touches.iter().filter(|t| t.other.is_some());
                between.for_each(|t| add_touch(t, 2.0, whole));
                hold(whole, free);
                lines.factor(whole);
            },
            || sections.factor(band, evaluator, free),
        );
    }
}

/// Takes rows and columns that are not free out of the blocks: zero, with 1 on the diagonal.
fn hold<const B: usize>(band: &mut [Blocks<B>], free: &[Row]) {
    let n = band.len();
    let all = |v: usize| v >= n || free[v].0[..B].iter().all(|f| *f == 1.0);
    for v in 0..n {
        if all(v) && all(v + 1) && all(v + 2) {
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

/// Adds rods' blocks × `x` to `out`, whose first vertex is `first`.
#[inline(always)]
fn multiply_band<const B: usize>(band: &[Blocks<B>], x: &[Row], first: usize, out: &mut [Row]) {
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
        // What stands across from the blocks of the two before.
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

/// Adds the elements of the rods whose blocks are `band`, from vertex `start` on, and inertia.
fn add_rods<const B: usize>(problem: &Problem, start: usize, band: &mut [Blocks<B>]) {
    let (bundle, state) = (problem.bundle, problem.state);
    for v in start..start + band.len() {
        if bundle.is_edge(v) {
            let yields = state.plastic_strain[v] != problem.plastic[v];
            add_stretch(bundle, state, v, yields, &mut band[v - start..]);
        }
        if bundle.bend[v] > 0.0 || bundle.twist[v] > 0.0 {
            let band = &mut band[v - 1 - start..];
            if bundle.twisting {
                add_element(&framed::hessian(bundle, state, v), 3, band);
            } else {
                add_bend(bundle, state, v, band);
            }
        }
    }
    for (i, blocks) in band.iter_mut().enumerate() {
        let (v, block) = (start + i, &mut blocks[0]);
        (0..3).for_each(|a| block[a][a] += bundle.mass[v] * problem.inertia);
        if B == 4 {
            // An angle without an edge, or whose edge is free to turn.
            block[3][3] += bundle.inertia[v] * problem.inertia;
            if block[3][3] <= 0.0 {
                block[3][3] = 1.0;
            }
        }
    }
}

/// Adds an edge: k/l t tᵀ, and where it is in tension what stiffens a string. Pressure is left out, as what it softens can
/// be more than there is.
fn add_stretch<const B: usize>(
    bundle: &Bundle,
    state: &State,
    edge: usize,
    yields: bool,
    band: &mut [Blocks<B>],
) {
    let e = state.edge(edge);
    let length = e.length();
    let (k, rest) = (bundle.stretch[edge], bundle.rest_length[edge]);
    let strain = length / rest - 1.0 - state.plastic_strain[edge];
    let taut = if strain > 0.0 && !yields {
        k * strain / length
    } else {
        0.0
    };
    let along = if yields { YIELDING } else { 1.0 } * k / rest - taut;
    let t = (e / length).to_array();
    for b in 0..3 {
        for a in 0..3 {
            let v = along * t[a] * t[b] + if a == b { taut } else { 0.0 };
            band[0][0][b][a] += v;
            band[0][1][b][a] -= v;
            band[1][0][b][a] += v;
        }
    }
}

/// Adds bending without twist: the Gauss–Newton part of [`rod::bend_hessian`], 2 c Gᵀ G with the gradient G of κb by the
/// three vertices.
fn add_bend<const B: usize>(bundle: &Bundle, state: &State, vertex: usize, band: &mut [Blocks<B>]) {
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

/// Adds the Hessian of an element of `count` vertices, whose first has the first blocks.
fn add_element<const B: usize>(hessian: &ElementHessian, count: usize, band: &mut [Blocks<B>]) {
    // Freedoms are those of places by vertex, then angles of the first two edges.
    let of = |f: usize| {
        if f < 3 * count {
            (f / 3, f % 3)
        } else {
            (f - 3 * count, 3)
        }
    };
    for column in 0..hessian.count {
        let (b, beta) = of(column);
        for row in 0..hessian.count {
            let (a, alpha) = of(row);
            if a <= b {
                band[a][b - a][beta][alpha] += hessian.matrix[row][column];
            }
        }
    }
}

/// Adds what g gᵀ of a bond has between vertices of one rod.
#[inline(always)]
fn add_own<const B: usize>(nodes: &[u32; 3], g: &[Column; 3], band: &mut [Blocks<B>]) {
    let [x, y, _] = nodes.map(|v| v as usize);
    for (v, k, left, right) in [(x, 0, 0, 0), (y, 0, 1, 1), (y, 1, 1, 2), (y + 1, 0, 2, 2)] {
        let block = &mut band[v][k];
        for b in 0..3 {
            for a in 0..4 {
                block[b][a] += g[left][a] * g[right][b];
            }
        }
    }
}

/// Adds what a contact has, `by` times, between vertices of one rod.
fn add_touch<const B: usize>(touch: &Touch, by: f64, band: &mut [Blocks<B>]) {
    let parts: Vec<(usize, f64)> = touch.shares().collect();
    for pair in parts.chunks_exact(2) {
        let (first, weights) = (pair[0].0, [pair[0].1, pair[1].1]);
        for (i, k) in [(0, 0), (0, 1), (1, 1)] {
            for column in 0..3 {
                for row in 0..3 {
                    let stiffness = touch_block(touch, touch.normal, row, column);
                    let w = by * weights[i] * weights[k];
                    band[first + i][k - i][column][row] += w * stiffness;
                }
            }
        }
    }
}

fn mask(of: &mut [Row], free: &[Row]) {
    of.iter_mut()
        .zip(free)
        .for_each(|(v, f)| (0..4).for_each(|a| v.0[a] *= f.0[a]));
}

fn dot(a: &[Row], b: &[Row]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.chunks(GRAIN).zip(b.chunks(GRAIN)) {
        let mut lanes = [0.0; 4];
        for (a, b) in a.iter().zip(b) {
            (0..4).for_each(|l| lanes[l] += a.0[l] * b.0[l]);
        }
        sum += (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::{Curvature, rod};
    use crate::{Rod, RodMaterial};

    #[test]
    fn elements_are_those_of_the_energies() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let at = [[0.0, 0.0, 0.0], [0.1, 0.0, 4.0], [0.5, 0.3, 7.9]];
        let place = |scale: f64| at.map(|p| DVec3::from_array(p) * scale);
        let straight = (0..3).map(|i| DVec3::Z * 4e-3 * f64::from(i)).collect();
        let bundle = Bundle::new(&[Rod::new(straight, material)], false).unwrap();
        let mut state = State::at_rest(&bundle);
        for (stretched, kind) in [(1.1e-3, Curvature::Exact), (0.9e-3, Curvature::GaussNewton)] {
            for (v, p) in place(stretched).into_iter().enumerate() {
                state.position.set(v, p);
            }
            let mut band: Vec<Blocks<3>> = vec![[[[0.0; 4]; 3]; 3]; 3];
            add_stretch(&bundle, &state, 0, false, &mut band);
            add_bend(&bundle, &state, 1, &mut band);
            let mut expected = [[0.0; 9]; 9];
            for made in [
                rod::stretch_hessian(&bundle, &state, 0, kind),
                rod::bend_hessian(&bundle, &state, 1, Curvature::GaussNewton),
            ] {
                for r in 0..made.count {
                    for c in 0..made.count {
                        let (row, column) = (made.freedoms[r], made.freedoms[c]);
                        expected[row as usize][column as usize] += made.matrix[r][c];
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
