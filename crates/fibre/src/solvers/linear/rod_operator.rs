//! The linearised rods without twist as a matrix-free operator: the change of edges and curvatures by a small displacement,
//! and the forces that it causes. As in [`super::rod_blocks`] only the part of the second derivatives that is never negative
//! is used: for an edge k/l t tᵀ and the geometric stiffness of a string in tension; for bending 2 c Gᵀ G with the gradient G
//! of κb. With A and B the two edges times their factors in G, G δ = δa × B + A × δb − ½κb (B·δa + A·δb): nine numbers at a
//! vertex stand for its blocks of the matrix.
//!
//! Numbers are rounded to single precision; the operator is still symmetric, never negative, and zero for translations.

// Several arrays are indexed alike.
#![allow(clippy::needless_range_loop)]

use super::problem::LinearProblem;
use super::rod_blocks::YIELDED_STIFFNESS_RATIO;
use crate::simd::dispatch::with_widest_registers;
use crate::simd::lanes::PaddedVec3;
use std::ops::Range;

/// Linearised edges and bending of whole rods.
#[derive(Debug, Clone, Default)]
pub(super) struct RodOperator {
    /// Per edge: its direction times the square root of its stiffness; and its geometric stiffness, tension over length.
    along: [Vec<f32>; 3],
    geometric: Vec<f32>,
    /// Per vertex: A, B and ½κb.
    before: [Vec<f32>; 3],
    behind: [Vec<f32>; 3],
    curvature: [Vec<f32>; 3],
    /// Per vertex: stiffness of its inertia.
    inertia: Vec<f64>,
    /// Buffers: the change of edges, the forces on edges, and those of the bending at the end of each.
    buffers: [[Vec<f64>; 3]; 3],
}

type Three<'a> = [&'a [f64]; 3];

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Slices three arrays to a common length.
#[inline(always)]
fn slices(of: &[Vec<f32>; 3], count: usize) -> [&[f32]; 3] {
    [&of[0][..count], &of[1][..count], &of[2][..count]]
}

#[inline(always)]
fn at(of: [&[f32]; 3], i: usize) -> [f64; 3] {
    [of[0][i].into(), of[1][i].into(), of[2][i].into()]
}

impl RodOperator {
    fn resize(&mut self, count: usize) {
        let RodOperator {
            along,
            geometric,
            before,
            behind,
            curvature,
            inertia,
            buffers,
        } = self;
        for of in [along, before, behind, curvature].into_iter().flatten() {
            of.resize(count, 0.0);
        }
        geometric.resize(count, 0.0);
        inertia.resize(count, 0.0);
        for of in buffers.iter_mut().flatten() {
            of.clear();
            of.resize(count + 1, 0.0);
        }
    }

    /// Linearises the whole rods whose vertices are `range`.
    pub fn linearise(&mut self, problem: &LinearProblem, range: &Range<usize>) {
        let (n, part) = (range.len(), range.clone());
        self.resize(n);
        let (bundle, state) = (problem.bundle, problem.state);
        let position = &state.position;
        let positions = [
            &position.x[part.clone()],
            &position.y[part.clone()],
            &position.z[part.clone()],
        ];
        let stretch = &bundle.stretch[part.clone()];
        let rest = &bundle.rest_length[part.clone()];
        let bend = &bundle.bend[part.clone()];
        let plastic = [
            &state.plastic_strain[part.clone()],
            &problem.plastic[part.clone()],
        ];
        let mass = &bundle.mass[part];
        with_widest_registers(
            #[inline(always)]
            || {
                self.linearise_edges(positions, stretch, rest, plastic);
                self.linearise_bending(bend, rest);
                for (to, m) in self.inertia.iter_mut().zip(mass) {
                    *to = m * problem.inertia;
                }
            },
        );
    }

    #[inline(always)]
    fn linearise_edges(
        &mut self,
        positions: Three,
        stretch: &[f64],
        rest: &[f64],
        plastic: [&[f64]; 2],
    ) {
        let n = stretch.len();
        let [edge, ..] = &mut self.buffers;
        for a in 0..3 {
            let (to, x) = (&mut edge[a][..n], &positions[a][..n]);
            for i in 1..n {
                to[i - 1] = x[i] - x[i - 1];
            }
            to[n - 1] = 0.0;
        }
        let [x, y, z] = [&edge[0][..n], &edge[1][..n], &edge[2][..n]];
        let [tx, ty, tz] = &mut self.along;
        let (tx, ty, tz, geometric) = (
            &mut tx[..n],
            &mut ty[..n],
            &mut tz[..n],
            &mut self.geometric[..n],
        );
        let (rest, now, old) = (&rest[..n], &plastic[0][..n], &plastic[1][..n]);
        for i in 0..n {
            let length = (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt();
            let k = stretch[i];
            let inverse = if k > 0.0 { 1.0 / length } else { 0.0 };
            let yields = now[i] != old[i];
            let strain = length / rest[i] - 1.0 - now[i];
            let tension = if strain > 0.0 {
                k * strain * inverse
            } else {
                0.0
            };
            let string = if yields { 0.0 } else { tension };
            let ratio = if yields { YIELDED_STIFFNESS_RATIO } else { 1.0 };
            let by = (ratio * k / rest[i] - string).max(0.0).sqrt() * inverse;
            (tx[i], ty[i], tz[i]) = ((x[i] * by) as f32, (y[i] * by) as f32, (z[i] * by) as f32);
            geometric[i] = string as f32;
        }
    }

    #[inline(always)]
    fn linearise_bending(&mut self, bend: &[f64], rest: &[f64]) {
        let n = bend.len();
        let [edge, ..] = &self.buffers;
        let [x, y, z] = [&edge[0][..n], &edge[1][..n], &edge[2][..n]];
        let [ax, ay, az] = &mut self.before;
        let [bx, by, bz] = &mut self.behind;
        let [cx, cy, cz] = &mut self.curvature;
        let (ax, ay, az) = (&mut ax[..n], &mut ay[..n], &mut az[..n]);
        let (bx, by, bz) = (&mut bx[..n], &mut by[..n], &mut bz[..n]);
        let (cx, cy, cz) = (&mut cx[..n], &mut cy[..n], &mut cz[..n]);
        let rest = &rest[..n];
        for i in 1..n {
            let (a, b) = ([x[i - 1], y[i - 1], z[i - 1]], [x[i], y[i], z[i]]);
            let (la, lb) = (rest[i - 1], rest[i]);
            // Zero without bending: at a gap there may be no edge.
            let d = if bend[i] > 0.0 {
                1.0 / (la * lb + dot(a, b))
            } else {
                0.0
            };
            let twice = 2.0 * d * (2.0 * bend[i] / (la + lb)).sqrt();
            let half = cross(a, b);
            (ax[i], ay[i], az[i]) = (
                (a[0] * twice) as f32,
                (a[1] * twice) as f32,
                (a[2] * twice) as f32,
            );
            (bx[i], by[i], bz[i]) = (
                (b[0] * twice) as f32,
                (b[1] * twice) as f32,
                (b[2] * twice) as f32,
            );
            (cx[i], cy[i], cz[i]) = (
                (half[0] * d) as f32,
                (half[1] * d) as f32,
                (half[2] * d) as f32,
            );
        }
    }

    /// Adds the restoring forces of the rods to the displacement `x` of their vertices to `out`, with those of inertia.
    #[inline(always)]
    pub fn multiply(&mut self, x: &[PaddedVec3], out: &mut [PaddedVec3]) {
        let n = out.len();
        let RodOperator {
            along,
            geometric,
            before,
            behind,
            curvature,
            inertia,
            buffers: [edge, force, bend],
        } = self;
        let x = &x[..n];
        {
            let [ex, ey, ez] = edge;
            let (ex, ey, ez) = (&mut ex[..n], &mut ey[..n], &mut ez[..n]);
            for i in 0..n - 1 {
                let (p, q) = (&x[i].0, &x[i + 1].0);
                (ex[i], ey[i], ez[i]) = (q[0] - p[0], q[1] - p[1], q[2] - p[2]);
            }
        }
        let [ex, ey, ez] = [&edge[0][..n], &edge[1][..n], &edge[2][..n]];
        let [fx, fy, fz] = force;
        let (fx, fy, fz) = (&mut fx[..n], &mut fy[..n], &mut fz[..n]);
        let (t, geometric) = (slices(along, n), &geometric[..n]);
        for i in 0..n {
            let (e, t, s) = ([ex[i], ey[i], ez[i]], at(t, i), f64::from(geometric[i]));
            let longer = dot(t, e);
            fx[i] = t[0] * longer + s * e[0];
            fy[i] = t[1] * longer + s * e[1];
            fz[i] = t[2] * longer + s * e[2];
        }
        let [gx, gy, gz] = bend;
        let (gx, gy, gz) = (&mut gx[..n], &mut gy[..n], &mut gz[..n]);
        let (a, b, c) = (slices(before, n), slices(behind, n), slices(curvature, n));
        for i in 1..n {
            let (da, db) = ([ex[i - 1], ey[i - 1], ez[i - 1]], [ex[i], ey[i], ez[i]]);
            let (a, b, c) = (at(a, i), at(b, i), at(c, i));
            let (left, right) = (cross(da, b), cross(a, db));
            let less = dot(b, da) + dot(a, db);
            let m = [
                left[0] + right[0] - c[0] * less,
                left[1] + right[1] - c[1] * less,
                left[2] + right[2] - c[2] * less,
            ];
            let turned = dot(c, m);
            let (on_a, on_b) = (cross(b, m), cross(m, a));
            fx[i] += on_b[0] - a[0] * turned;
            fy[i] += on_b[1] - a[1] * turned;
            fz[i] += on_b[2] - a[2] * turned;
            gx[i - 1] = on_a[0] - b[0] * turned;
            gy[i - 1] = on_a[1] - b[1] * turned;
            gz[i - 1] = on_a[2] - b[2] * turned;
        }
        let [fx, fy, fz] = [&*fx, &*fy, &*fz];
        let inertia = &inertia[..n];
        let mut last = [0.0; 3];
        for i in 0..n {
            let next = [fx[i] + gx[i], fy[i] + gy[i], fz[i] + gz[i]];
            let (m, x, out) = (inertia[i], &x[i].0, &mut out[i].0);
            for k in 0..3 {
                out[k] += (last[k] - next[k]) + m * x[k];
            }
            last = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rod_blocks::{RodBlocks, add_rods, multiply_band};
    use super::*;
    use crate::rod_bundle::{Rod, RodBundle, RodMaterial};
    use crate::state::State;
    use glam::DVec3;
    use greenstick_wood::noise::unit;

    #[test]
    fn products_are_those_of_the_blocks() {
        let material = RodMaterial::solid(1e-6, 1e10, 1e9, 600.0);
        let random =
            |i: usize, k: i64| DVec3::from_array([0, 1, 2].map(|c| unit(4, i as i64, k, c) - 0.5));
        // Of different lengths, down to one edge.
        let rods: Vec<Rod> = [12, 2, 3, 7]
            .into_iter()
            .enumerate()
            .map(|(r, count)| {
                let vertex = |i: usize| DVec3::new(r as f64, 0.0, 4.0 * i as f64) * 1e-3;
                Rod::new((0..count).map(vertex).collect(), material)
            })
            .collect();
        let bundle = RodBundle::new(&rods, false).unwrap();
        let n = bundle.vertices();
        let mut state = State::at_rest(&bundle);
        for v in 0..n {
            state.position.add(v, random(v, 0) * 2e-3);
        }
        state.plastic_strain[3] = -0.01;
        let problem = LinearProblem {
            bundle: &bundle,
            state: &state,
            plastic: &vec![0.0; n],
            softened: &[],
            springs: &[],
            grips: &[],
            inertia: 900.0,
            residual: &[],
            held: &[],
            prescribed: &[],
            tolerance: 0.1,
            update_preconditioner: true,
        };
        let mut band: Vec<RodBlocks<3>> = vec![[[[0.0; 4]; 3]; 3]; n];
        add_rods(&problem, 0, &mut band);
        let x: Vec<PaddedVec3> = (0..n)
            .map(|v| PaddedVec3(random(v, 1).extend(0.0).to_array()))
            .collect();
        let (mut expected, mut found) = (vec![PaddedVec3::ZERO; n], vec![PaddedVec3::ZERO; n]);
        multiply_band(&band, &x, 0, &mut expected);
        let mut operator = RodOperator::default();
        operator.linearise(&problem, &(0..n));
        operator.multiply(&x, &mut found);
        let largest = expected
            .iter()
            .flat_map(|r| r.0)
            .fold(0.0, |a: f64, v| a.max(v.abs()));
        for (e, f) in expected.iter().zip(&found) {
            // Numbers are rounded to single precision.
            (0..3).for_each(|a| assert!((e.0[a] - f.0[a]).abs() < 1e-6 * largest));
        }
        // Only inertia resists a translation.
        let whole = vec![PaddedVec3([1.0, -2.0, 0.5, 0.0]); n];
        let mut found = vec![PaddedVec3::ZERO; n];
        operator.multiply(&whole, &mut found);
        for (v, f) in found.iter().enumerate() {
            let inertia = 900.0 * bundle.mass[v];
            (0..3).for_each(|a| assert!((f.0[a] - inertia * whole[v].0[a]).abs() < 1e-15));
        }
    }
}
