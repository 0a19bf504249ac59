//! Energies that depend on two vectors a and b through p = a·a, q = b·b and r = a·b: their derivatives with respect to the
//! vectors and to the vertices that the vectors join. They are invariant under rotation, so that their forces conserve
//! angular momentum.

use super::hessian::{ElementHessian, MAX_ELEMENT_DOFS};
use glam::{DMat3, DVec3};

/// Value and derivatives of f(p, q, r).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Jet {
    /// f.
    pub value: f64,
    /// ∂f/∂p.
    pub p: f64,
    /// ∂f/∂q.
    pub q: f64,
    /// ∂f/∂r.
    pub r: f64,
    /// ∂²f/∂p².
    pub pp: f64,
    /// ∂²f/∂p∂q.
    pub pq: f64,
    /// ∂²f/∂p∂r.
    pub pr: f64,
    /// ∂²f/∂q².
    pub qq: f64,
    /// ∂²f/∂q∂r.
    pub qr: f64,
    /// ∂²f/∂r².
    pub rr: f64,
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl Jet {
    /// Returns the gradient with respect to a of a function of p alone.
    pub(crate) fn gradient_of_p(&self, a: DVec3) -> DVec3 {
        a * (2.0 * self.p)
    }

    /// Returns the second derivatives with respect to a twice, to a (rows) and b (columns), and to b twice.
    pub(crate) fn hessians(&self, a: DVec3, b: DVec3) -> [DMat3; 3] {
        // Derivatives of f_p, f_q and f_r with respect to a and b.
        let by_a = [
            a * (2.0 * self.pp) + b * self.pr,
            a * (2.0 * self.pq) + b * self.qr,
            a * (2.0 * self.pr) + b * self.rr,
        ];
        let by_b = [
            b * (2.0 * self.pq) + a * self.pr,
            b * (2.0 * self.qq) + a * self.qr,
            b * (2.0 * self.qr) + a * self.rr,
        ];
        let aa = DMat3::from_diagonal(DVec3::splat(2.0 * self.p))
            + outer(a, by_a[0]) * 2.0
            + outer(b, by_a[2]);
        let ab = DMat3::from_diagonal(DVec3::splat(self.r))
            + outer(a, by_b[0]) * 2.0
            + outer(b, by_b[2]);
        let bb = DMat3::from_diagonal(DVec3::splat(2.0 * self.q))
            + outer(b, by_b[1]) * 2.0
            + outer(a, by_b[2]);
        [aa, ab, bb]
    }
}

/// Returns the Hessian over vertices of an element whose vectors are a = Σ `first`ₖ xₖ and b = Σ `second`ₖ xₖ.
pub(super) fn hessian_over_vertices<const N: usize>(
    vertices: [usize; N],
    first: [f64; N],
    second: [f64; N],
    [aa, ab, bb]: [DMat3; 3],
) -> ElementHessian {
    let mut hessian = ElementHessian {
        count: 3 * N,
        dofs: [0; MAX_ELEMENT_DOFS],
        matrix: [[0.0; MAX_ELEMENT_DOFS]; MAX_ELEMENT_DOFS],
    };
    let ba = ab.transpose();
    for u in 0..N {
        for axis in 0..3 {
            hessian.dofs[3 * u + axis] = (3 * vertices[u] + axis) as u32;
        }
        for v in 0..N {
            let block = aa * (first[u] * first[v])
                + ab * (first[u] * second[v])
                + ba * (second[u] * first[v])
                + bb * (second[u] * second[v]);
            for row in 0..3 {
                for column in 0..3 {
                    hessian.matrix[3 * u + row][3 * v + column] = block.col(column)[row];
                }
            }
        }
    }
    hessian
}
