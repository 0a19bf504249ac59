//! A regular lattice of nodes in space.

use glam::DVec3;

/// A regular lattice of nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// Position of the first node.
    pub low: DVec3,
    /// Distance between neighbouring nodes.
    pub cell: f64,
    /// Nodes along x, y, z.
    pub size: [usize; 3],
}

impl Lattice {
    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.size.iter().product()
    }

    /// Differences between the numbers of neighbouring nodes along x, y, z.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// Position of a node.
    pub fn position(&self, node: usize) -> DVec3 {
        let [nx, ny, _] = self.size;
        let at = [node % nx, node / nx % ny, node / (nx * ny)].map(|k| k as f64);
        self.low + DVec3::from_array(at) * self.cell
    }

    /// The eight nodes around a point, with the weights of trilinear interpolation; with `half`, those of the lattice
    /// shifted by half a cell along that axis.
    pub fn around(&self, p: DVec3, half: Option<usize>) -> [(usize, f64); 8] {
        let mut q = ((p - self.low) / self.cell).to_array();
        if let Some(axis) = half {
            q[axis] -= 0.5;
        }
        let strides = self.strides();
        let mut first = 0;
        let mut fraction = [0.0; 3];
        for k in 0..3 {
            // There is one edge less than there are nodes.
            let last = self.size[k] - 2 - usize::from(half == Some(k));
            let base = q[k].floor().clamp(0.0, last as f64);
            fraction[k] = (q[k] - base).clamp(0.0, 1.0);
            first += base as usize * strides[k];
        }
        std::array::from_fn(|corner| {
            let (mut at, mut weight) = (first, 1.0);
            for k in 0..3 {
                if corner >> k & 1 == 1 {
                    at += strides[k];
                    weight *= fraction[k];
                } else {
                    weight *= 1.0 - fraction[k];
                }
            }
            (at, weight)
        })
    }
}
