//! Energies that depend on two vectors a, b through p = a·a, q = b·b, r = a·b, and their derivatives by the vectors and
//! by the vertices that the vectors join. Invariant under rotation, so forces made here keep angular momentum.

use super::{ElementHessian, MOST_FREEDOMS};
use glam::{DMat3, DVec3};

/// Value and derivatives of f(p, q, r).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Jet {
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
    /// Gradient by a, of a function of p alone.
    pub fn along_first(&self, a: DVec3) -> DVec3 {
        a * (2.0 * self.p)
    }

    /// Gradients by a and by b.
    pub fn gradients(&self, a: DVec3, b: DVec3) -> (DVec3, DVec3) {
        (
            a * (2.0 * self.p) + b * self.r,
            b * (2.0 * self.q) + a * self.r,
        )
    }

    /// Second derivatives: by a twice, by a and b (rows a, columns b), by b twice.
    pub fn hessians(&self, a: DVec3, b: DVec3) -> [DMat3; 3] {
        // How f_p, f_q, f_r change with a and with b.
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

/// The Hessian over vertices of an element whose vectors are a = Σ `first`ₖ xₖ and b = Σ `second`ₖ xₖ.
pub(super) fn over_vertices<const N: usize>(
    vertices: [usize; N],
    first: [f64; N],
    second: [f64; N],
    [aa, ab, bb]: [DMat3; 3],
) -> ElementHessian {
    let mut made = ElementHessian {
        count: 3 * N,
        freedoms: [0; MOST_FREEDOMS],
        matrix: [[0.0; MOST_FREEDOMS]; MOST_FREEDOMS],
    };
    let ba = ab.transpose();
    for u in 0..N {
        for axis in 0..3 {
            made.freedoms[3 * u + axis] = (3 * vertices[u] + axis) as u32;
        }
        for v in 0..N {
            let block = aa * (first[u] * first[v])
                + ab * (first[u] * second[v])
                + ba * (second[u] * first[v])
                + bb * (second[u] * second[v]);
            for row in 0..3 {
                for column in 0..3 {
                    made.matrix[3 * u + row][3 * v + column] = block.col(column)[row];
                }
            }
        }
    }
    made
}
