//! Stretch of rods, and their bending without twist (Sutherland 2012 §3.2.2 and §3.2.3, signs corrected).

use super::hessian::{ElementHessian, HessianKind};
use super::quadratic::{Jet, hessian_over_vertices};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::{DMat3, DVec3};

/// Returns the elastic strain of an edge.
pub fn strain(bundle: &RodBundle, state: &State, edge: usize) -> f64 {
    state.edge(edge).length() / bundle.rest_length[edge] - 1.0 - state.plastic_strain[edge]
}

/// Returns the stretching energy ½ k (|e|/|ē| − 1 − ε_p)² |ē| of an edge, as a function of p = e·e.
pub(super) fn stretch(bundle: &RodBundle, state: &State, edge: usize) -> Jet {
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

/// Returns the stretching energy of an edge, J.
pub(crate) fn stretch_energy(bundle: &RodBundle, state: &State, edge: usize) -> f64 {
    stretch(bundle, state, edge).value
}

/// Returns the Hessian of the stretching energy over the edge's two vertices.
pub(crate) fn stretch_hessian(
    bundle: &RodBundle,
    state: &State,
    edge: usize,
    kind: HessianKind,
) -> ElementHessian {
    let mut jet = stretch(bundle, state, edge);
    if kind == HessianKind::GaussNewton {
        let length = state.edge(edge).length();
        jet.p = 0.0;
        jet.pp = bundle.stretch[edge] / bundle.rest_length[edge] / (4.0 * length * length);
    }
    let e = state.edge(edge);
    hessian_over_vertices(
        [edge, edge + 1],
        [-1.0, 1.0],
        [0.0; 2],
        jet.hessians(e, DVec3::ZERO),
    )
}

/// The terms of the bending energy at a vertex.
struct Bend {
    /// e₋ and e₊.
    a: DVec3,
    b: DVec3,
    /// Curvature binormal.
    kb: DVec3,
    /// |ē₋||ē₊| + e₋·e₊, the denominator of κb.
    denominator: f64,
    /// α/l.
    stiffness: f64,
}

fn bend(bundle: &RodBundle, state: &State, vertex: usize) -> Bend {
    let (a, b) = (state.edge(vertex - 1), state.edge(vertex));
    let (la, lb) = (bundle.rest_length[vertex - 1], bundle.rest_length[vertex]);
    let denominator = la * lb + a.dot(b);
    let kb = a.cross(b) * (2.0 / denominator);
    Bend {
        a,
        b,
        kb,
        denominator,
        stiffness: bundle.bend[vertex] / (la + lb),
    }
}

/// Returns the bending energy α |κb|²/l at a vertex, J.
pub(crate) fn bend_energy(bundle: &RodBundle, state: &State, vertex: usize) -> f64 {
    let bend = bend(bundle, state, vertex);
    bend.stiffness * bend.kb.length_squared()
}

/// Returns the gradients of [`bend_energy`] with respect to e₋ and e₊ (Eqs. 3.6 and 3.7).
pub(super) fn bend_gradient(bundle: &RodBundle, state: &State, vertex: usize) -> (DVec3, DVec3) {
    let Bend {
        a,
        b,
        kb,
        denominator,
        stiffness,
    } = bend(bundle, state, vertex);
    let f = 2.0 * stiffness / denominator;
    let square = kb.length_squared();
    (
        (b.cross(kb) * 2.0 - b * square) * f,
        (a.cross(kb) * 2.0 + a * square) * -f,
    )
}

/// Returns the Hessian of [`bend_energy`] over vertices i − 1, i, i + 1.
pub(crate) fn bend_hessian(
    bundle: &RodBundle,
    state: &State,
    vertex: usize,
    kind: HessianKind,
) -> ElementHessian {
    let Bend {
        a,
        b,
        kb,
        denominator: d,
        stiffness: c,
    } = bend(bundle, state, vertex);
    let blocks = match kind {
        HessianKind::Exact => {
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
        HessianKind::GaussNewton => {
            // Columns of ∂κb/∂a and ∂κb/∂b: (2 δa × b − κb (b·δa))/D and (2 a × δb − κb (a·δb))/D.
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
    hessian_over_vertices(
        [vertex - 1, vertex, vertex + 1],
        [-1.0, 1.0, 0.0],
        [0.0, -1.0, 1.0],
        blocks,
    )
}
