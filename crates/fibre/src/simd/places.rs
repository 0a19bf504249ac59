//! Where vertices are and the edges between them, as bonds gather them: several bonds share an edge, whose length is found once.

use super::dispatch::with_widest_registers;
use super::lanes::PaddedVec3;
use crate::vectors::Vectors;
use rayon::prelude::*;

/// Vertices whose edges are found at a time.
const BLOCK: usize = 64;
/// Vertices of one task: a multiple of [`BLOCK`], and enough to make the cost of a task negligible.
const VERTICES_PER_TASK: usize = 96 * BLOCK;

/// Positions and edges of a bundle's vertices.
#[derive(Debug, Clone, Default)]
pub(crate) struct Places {
    /// Per vertex: its position.
    pub(super) position: Vec<PaddedVec3>,
    /// Per vertex: the vector to the next one, and one over its length. Between rods, and behind the last vertex, any.
    pub(super) edge: Vec<PaddedVec3>,
}

impl Places {
    /// Returns those of `vertices` vertices at the origin.
    pub(crate) fn zeros(vertices: usize) -> Self {
        Places {
            position: vec![PaddedVec3::ZERO; vertices],
            edge: vec![PaddedVec3::ZERO; vertices],
        }
    }

    /// Takes over positions.
    pub(crate) fn set(&mut self, from: &Vectors) {
        assert!(from.len() == self.position.len());
        let Places { position, edge } = self;
        if rayon::current_num_threads() > 1 && position.len() > VERTICES_PER_TASK {
            (position.par_chunks_mut(VERTICES_PER_TASK))
                .zip(edge.par_chunks_mut(VERTICES_PER_TASK))
                .enumerate()
                .for_each(|(k, (position, edge))| {
                    set_part(from, k * VERTICES_PER_TASK, position, edge);
                });
        } else {
            set_part(from, 0, position, edge);
        }
    }
}

/// Sets positions and edges of the vertices from `first` on.
fn set_part(from: &Vectors, first: usize, position: &mut [PaddedVec3], edge: &mut [PaddedVec3]) {
    with_widest_registers(
        #[inline(always)]
        || {
            let blocks = position.chunks_mut(BLOCK).zip(edge.chunks_mut(BLOCK));
            for (k, (position, edge)) in blocks.enumerate() {
                let first = first + k * BLOCK;
                let with_next = (position.len() + 1).min(from.len() - first);
                let [x, y, z] = [&from.x, &from.y, &from.z].map(|a| &a[first..][..with_next]);
                for (((to, x), y), z) in position.iter_mut().zip(x).zip(y).zip(z) {
                    to.0 = [*x, *y, *z, 0.0];
                }
                set_edges([x, y, z], edge);
            }
        },
    );
}

/// Sets edges between positions, of which there is one more but at the end.
#[inline(always)]
fn set_edges([x, y, z]: [&[f64]; 3], to: &mut [PaddedVec3]) {
    let edges = x.len() - 1;
    let mut parts = [[0.0; BLOCK]; 4];
    let [ex, ey, ez, by] = &mut parts;
    for k in 0..edges.min(BLOCK) {
        (ex[k], ey[k], ez[k]) = (x[k + 1] - x[k], y[k + 1] - y[k], z[k + 1] - z[k]);
        by[k] = 1.0 / (ex[k] * ex[k] + ey[k] * ey[k] + ez[k] * ez[k]).sqrt();
    }
    let parts = ex.iter().zip(&*ey).zip(&*ez).zip(&*by);
    for (to, (((x, y), z), by)) in to.iter_mut().zip(parts) {
        to.0 = [*x, *y, *z, *by];
    }
}
