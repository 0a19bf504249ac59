//! Vectors in space stored as three arrays, so that loops over many of them fill whole SIMD registers.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Vectors as one array for each axis. The three arrays always have the same length.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vectors {
    /// First components.
    pub x: Vec<f64>,
    /// Second components.
    pub y: Vec<f64>,
    /// Third components.
    pub z: Vec<f64>,
}

impl Clone for Vectors {
    fn clone(&self) -> Self {
        Vectors {
            x: self.x.clone(),
            y: self.y.clone(),
            z: self.z.clone(),
        }
    }

    // Solvers copy in every step, and allocate in none.
    fn clone_from(&mut self, source: &Self) {
        self.x.clone_from(&source.x);
        self.y.clone_from(&source.y);
        self.z.clone_from(&source.z);
    }
}

impl Vectors {
    /// Returns `count` zero vectors.
    pub fn zeros(count: usize) -> Self {
        Vectors {
            x: vec![0.0; count],
            y: vec![0.0; count],
            z: vec![0.0; count],
        }
    }

    /// Returns the number of vectors.
    #[inline]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are no vectors.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Returns vector `i`, which must be below [`Vectors::len`].
    #[inline]
    pub fn get(&self, i: usize) -> DVec3 {
        DVec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Sets vector `i`, which must be below [`Vectors::len`].
    #[inline]
    pub fn set(&mut self, i: usize, v: DVec3) {
        self.x[i] = v.x;
        self.y[i] = v.y;
        self.z[i] = v.z;
    }

    /// Adds to vector `i`, which must be below [`Vectors::len`].
    #[inline]
    pub fn add(&mut self, i: usize, v: DVec3) {
        self.x[i] += v.x;
        self.y[i] += v.y;
        self.z[i] += v.z;
    }

    /// Appends a vector.
    pub fn push(&mut self, v: DVec3) {
        self.x.push(v.x);
        self.y.push(v.y);
        self.z.push(v.z);
    }

    /// Sets all vectors to zero and keeps their number.
    pub(crate) fn fill_zero(&mut self) {
        self.x.fill(0.0);
        self.y.fill(0.0);
        self.z.fill(0.0);
    }

    /// Iterates over the vectors in order.
    pub fn iter(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.len()).map(|i| self.get(i))
    }
}

impl FromIterator<DVec3> for Vectors {
    fn from_iter<I: IntoIterator<Item = DVec3>>(iter: I) -> Self {
        let mut vectors = Vectors::default();
        for v in iter {
            vectors.push(v);
        }
        vectors
    }
}
