//! Forces on the vertices and moments on the edges of a bundle.

use crate::vectors::Vectors;

/// Forces on vertices (N) and, with twist, moments on the angles of edges (N m).
#[derive(Debug, Default, PartialEq)]
pub struct Forces {
    /// Per vertex, N.
    pub linear: Vectors,
    /// Per edge, N m.
    pub moment: Vec<f64>,
}

impl Clone for Forces {
    fn clone(&self) -> Self {
        Forces {
            linear: self.linear.clone(),
            moment: self.moment.clone(),
        }
    }

    // Solvers copy in every step, and allocate in none.
    fn clone_from(&mut self, source: &Self) {
        self.linear.clone_from(&source.linear);
        self.moment.clone_from(&source.moment);
    }
}

impl Forces {
    /// Returns zero forces for `vertices` vertices.
    pub fn zeros(vertices: usize) -> Self {
        Forces {
            linear: Vectors::zeros(vertices),
            moment: vec![0.0; vertices],
        }
    }

    /// Sets all forces and moments to zero.
    pub fn clear(&mut self) {
        self.linear.fill_zero();
        self.moment.fill(0.0);
    }
}
