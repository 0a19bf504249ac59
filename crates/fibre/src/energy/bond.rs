//! Bonds between rods: a transverse spring and a shear spring (Sutherland 2012 §3.3.2). Forces are the exact gradients and
//! therefore sum to zero, which the thesis's do not.

use super::hessian::{ElementHessian, HessianKind};
use super::quadratic::{Jet, hessian_over_vertices};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;

/// Returns the edge e = y₁ − y₀ and d = x − c of a bond.
pub(crate) fn vectors(bundle: &RodBundle, state: &State, bond: usize) -> (DVec3, DVec3) {
    let j = bundle.bonds.edge[bond] as usize;
    let (y0, e) = (state.position.get(j), state.edge(j));
    let x = state.position.get(bundle.bonds.vertex[bond] as usize);
    (e, x - (y0 + e * bundle.bonds.t[bond]))
}

/// Returns the transverse and the shear energy of a bond, J.
pub(crate) fn energy(bundle: &RodBundle, state: &State, bond: usize) -> (f64, f64) {
    let (e, d) = vectors(bundle, state, bond);
    let b = &bundle.bonds;
    let length = d.length();
    let strain = length / b.distance[bond] - 1.0;
    let off = e.dot(d) / (e.length() * length) - b.rest_cosine[bond];
    (
        0.5 * b.transverse[bond] * strain * strain * b.distance[bond],
        b.shear[bond] * off * off,
    )
}

/// Returns the forces on x, y₀ and y₁, N.
pub(super) fn forces(bundle: &RodBundle, state: &State, bond: usize) -> (DVec3, DVec3, DVec3) {
    let (e, d) = vectors(bundle, state, bond);
    let b = &bundle.bonds;
    let (le, ld) = (e.length(), d.length());
    let (e, d) = (e / le, d / ld);
    let cosine = e.dot(d);
    let shear = 2.0 * b.shear[bond] * (cosine - b.rest_cosine[bond]);
    let pull = b.transverse[bond] * (ld / b.distance[bond] - 1.0);
    let on_vertex = (e - d * cosine) * (-shear / ld) - d * pull;
    let turn = (d - e * cosine) * (-shear / le);
    let t = b.t[bond];
    (
        on_vertex,
        on_vertex * (t - 1.0) - turn,
        on_vertex * -t + turn,
    )
}

/// Returns the Hessian over x, y₀ and y₁.
pub(crate) fn hessian(
    bundle: &RodBundle,
    state: &State,
    bond: usize,
    kind: HessianKind,
) -> ElementHessian {
    let (e, d) = vectors(bundle, state, bond);
    let b = &bundle.bonds;
    let (p, q, r) = (e.length_squared(), d.length_squared(), e.dot(d));
    let (length, m) = (q.sqrt(), 1.0 / (p * q).sqrt());
    let cosine = r * m;
    let exact = kind == HessianKind::Exact;
    let off = if exact {
        cosine - b.rest_cosine[bond]
    } else {
        0.0
    };
    let slope = if exact {
        b.transverse[bond] * (length / b.distance[bond] - 1.0)
    } else {
        0.0
    };
    let s = 2.0 * b.shear[bond];
    let (cp, cq) = (-cosine / (2.0 * p), -cosine / (2.0 * q));
    let jet = Jet {
        value: 0.0,
        p: s * off * cp,
        q: s * off * cq + slope / (2.0 * length),
        r: s * off * m,
        pp: s * (cp * cp + off * 0.75 * cosine / (p * p)),
        pq: s * (cp * cq + off * 0.25 * cosine / (p * q)),
        pr: s * (cp * m - off * m / (2.0 * p)),
        qq: s * (cq * cq + off * 0.75 * cosine / (q * q))
            + (b.transverse[bond] / b.distance[bond] - slope / length) / (4.0 * q),
        qr: s * (cq * m - off * m / (2.0 * q)),
        rr: s * m * m,
    };
    let (x, j, t) = (b.vertex[bond] as usize, b.edge[bond] as usize, b.t[bond]);
    hessian_over_vertices(
        [x, j, j + 1],
        [0.0, -1.0, 1.0],
        [1.0, t - 1.0, -t],
        jet.hessians(e, d),
    )
}
