//! Stretch and, without twist, bending of rods (Sutherland 2012 §3.2.2 and §3.2.3, signs corrected).

use super::pair::{Jet, over_vertices};
use super::{Curvature, ElementHessian};
use crate::bundle::Bundle;
use crate::state::State;
use glam::{DMat3, DVec3};

/// Strain of an edge without its permanent part.
pub fn strain(bundle: &Bundle, state: &State, edge: usize) -> f64 {
    state.edge(edge).length() / bundle.rest_length[edge] - 1.0 - state.plastic_strain[edge]
}

/// ½ k (|e|/|ē| − 1 − ε_p)² |ē| of an edge, as a function of p = e·e.
pub fn stretch(bundle: &Bundle, state: &State, edge: usize) -> Jet {
    let rest = bundle.rest_length[edge];
    let length = state.edge(edge).length();
    let strain = length / rest - 1.0 - state.plastic_strain[edge];
    let k = bundle.stretch[edge];
    let slope = k * strain;
    Jet {
        value: 0.5 * k * strain * strain * rest,
        p: slope / (2.0 * length),
        pp: (k / rest - slope / length) / (4.0 * length * length),
        ..Jet::default()
    }
}

/// Hessian of [`stretch`] over the edge's two vertices.
pub fn stretch_hessian(
    bundle: &Bundle,
    state: &State,
    edge: usize,
    kind: Curvature,
) -> ElementHessian {
    let mut jet = stretch(bundle, state, edge);
    if kind == Curvature::GaussNewton {
        let length = state.edge(edge).length();
        jet.p = 0.0;
        jet.pp = bundle.stretch[edge] / bundle.rest_length[edge] / (4.0 * length * length);
    }
    let e = state.edge(edge);
    over_vertices(
        [edge, edge + 1],
        [-1.0, 1.0],
        [0.0; 2],
        jet.hessians(e, DVec3::ZERO),
    )
}

/// What bending at a vertex is made of: e₋, e₊, the curvature binormal κb, its denominator, and α/l.
fn parts(bundle: &Bundle, state: &State, vertex: usize) -> (DVec3, DVec3, DVec3, f64, f64) {
    let (a, b) = (state.edge(vertex - 1), state.edge(vertex));
    let (la, lb) = (bundle.rest_length[vertex - 1], bundle.rest_length[vertex]);
    let denominator = la * lb + a.dot(b);
    let kb = a.cross(b) * (2.0 / denominator);
    (a, b, kb, denominator, bundle.bend[vertex] / (la + lb))
}

/// α |κb|²/l at a vertex, J.
pub fn bend_energy(bundle: &Bundle, state: &State, vertex: usize) -> f64 {
    let (_, _, kb, _, c) = parts(bundle, state, vertex);
    c * kb.length_squared()
}

/// Gradients of [`bend_energy`] by e₋ and e₊ (Eqs. 3.6 and 3.7).
pub fn bend_gradient(bundle: &Bundle, state: &State, vertex: usize) -> (DVec3, DVec3) {
    let (a, b, kb, denominator, c) = parts(bundle, state, vertex);
    let f = 2.0 * c / denominator;
    let square = kb.length_squared();
    (
        (b.cross(kb) * 2.0 - b * square) * f,
        (a.cross(kb) * 2.0 + a * square) * -f,
    )
}

/// Hessian of [`bend_energy`] over vertices i − 1, i, i + 1.
pub fn bend_hessian(
    bundle: &Bundle,
    state: &State,
    vertex: usize,
    kind: Curvature,
) -> ElementHessian {
    let (a, b, kb, d, c) = parts(bundle, state, vertex);
    let blocks = match kind {
        Curvature::Exact => {
            let (p, q, r) = (a.length_squared(), b.length_squared(), a.dot(b));
            let n = a.cross(b).length_squared();
            let f = 4.0 * c / (d * d);
            Jet {
                value: f * n,
                p: f * q,
                q: f * p,
                r: -2.0 * f * (r + n / d),
                pq: f,
                pr: -2.0 * f * q / d,
                qr: -2.0 * f * p / d,
                rr: f * (-2.0 + 8.0 * r / d + 6.0 * n / (d * d)),
                ..Jet::default()
            }
            .hessians(a, b)
        }
        Curvature::GaussNewton => {
            // Rows of ∂κb/∂a and ∂κb/∂b: (2 δa × b − κb (b·δa))/D and (2 a × δb − κb (a·δb))/D.
            let by_a = DMat3::from_cols(
                (DVec3::X.cross(b) * 2.0 - kb * b.x) / d,
                (DVec3::Y.cross(b) * 2.0 - kb * b.y) / d,
                (DVec3::Z.cross(b) * 2.0 - kb * b.z) / d,
            );
            let by_b = DMat3::from_cols(
                (a.cross(DVec3::X) * 2.0 - kb * a.x) / d,
                (a.cross(DVec3::Y) * 2.0 - kb * a.y) / d,
                (a.cross(DVec3::Z) * 2.0 - kb * a.z) / d,
            );
            let f = 2.0 * c;
            [
                by_a.transpose() * by_a * f,
                by_a.transpose() * by_b * f,
                by_b.transpose() * by_b * f,
            ]
        }
    };
    over_vertices(
        [vertex - 1, vertex, vertex + 1],
        [-1.0, 1.0, 0.0],
        [0.0, -1.0, 1.0],
        blocks,
    )
}
