//! Isosurfaces of values at the nodes of a lattice by marching tetrahedra (Doi and Koide 1991). Each cell is divided into
//! six tetrahedra around its diagonal, all cells alike, so that neighbouring tetrahedra share their faces and the surface
//! is a closed manifold.

use super::lattice::Lattice;
use crate::{Cancelled, Context, Mesh};
use glam::DVec3;
use std::collections::HashMap;

/// Vertices stay away from the ends of an edge by this fraction of its length, so that every triangle has an area.
const MIN_EDGE_FRACTION: f64 = 0.02;
/// The corners of the six tetrahedra of a cell: each reaches from its first corner to its last along the axes in this order.
const AXIS_ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// A surface while it is extracted.
struct Extraction<'a> {
    lattice: &'a Lattice,
    values: Vec<f64>,
    mesh: Mesh,
    /// Vertex on the edge between two nodes, the lower number first.
    vertices: HashMap<(usize, usize), u32>,
}

/// Extracts the closed surface around the nodes whose values exceed `level`. It is cut off where `inside` (a signed
/// distance, m) falls below 0; nodes at the border of the lattice count as outside.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub(super) fn surface(
    lattice: &Lattice,
    values: &[f64],
    level: f64,
    inside: impl Fn(DVec3) -> f64,
    context: &Context,
) -> Result<Mesh, Cancelled> {
    let [nx, ny, nz] = lattice.size;
    let strides = lattice.strides();
    let mut above: Vec<f64> = values.iter().map(|v| v - level).collect();
    let scale = above.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    for (i, v) in above.iter_mut().enumerate() {
        let at = [i % nx, i / nx % ny, i / (nx * ny)];
        if (0..3).any(|k| at[k] == 0 || at[k] + 1 == lattice.size[k]) {
            *v = v.min(-1e-3 * scale);
        }
        if at[0] == 0 && at[1] == 0 {
            context.check()?;
        }
        // As steep as the indicator is at its surface.
        *v = v.min(0.5 * scale * inside(lattice.position(i)) / lattice.cell);
    }
    let mut extraction = Extraction {
        lattice,
        values: above,
        mesh: Mesh::default(),
        vertices: HashMap::new(),
    };
    for z in 0..nz - 1 {
        context.check()?;
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let first = x + y * strides[1] + z * strides[2];
                let corner =
                    |c: usize| first + (0..3).map(|k| (c >> k & 1) * strides[k]).sum::<usize>();
                let inside = (0..8)
                    .filter(|c| extraction.values[corner(*c)] > 0.0)
                    .count();
                if inside == 0 || inside == 8 {
                    continue;
                }
                for axes in AXIS_ORDERS {
                    let mut at = first;
                    let mut corners = [at; 4];
                    for (k, axis) in axes.into_iter().enumerate() {
                        at += strides[axis];
                        corners[k + 1] = at;
                    }
                    extraction.add_tetrahedron(corners);
                }
            }
        }
    }
    Ok(extraction.mesh)
}

impl Extraction<'_> {
    /// The vertex on the edge between two nodes.
    fn vertex(&mut self, a: usize, b: usize) -> u32 {
        let key = (a.min(b), a.max(b));
        if let Some(&vertex) = self.vertices.get(&key) {
            return vertex;
        }
        let (u, v) = (self.values[key.0], self.values[key.1]);
        let fraction = (u / (u - v)).clamp(MIN_EDGE_FRACTION, 1.0 - MIN_EDGE_FRACTION);
        let p = self
            .lattice
            .position(key.0)
            .lerp(self.lattice.position(key.1), fraction);
        let vertex = self.mesh.positions.len() as u32;
        self.mesh.positions.push(p);
        self.vertices.insert(key, vertex);
        vertex
    }

    /// Adds the part of the surface in a tetrahedron.
    fn add_tetrahedron(&mut self, corners: [usize; 4]) {
        let (inside, outside): (Vec<usize>, Vec<usize>) =
            corners.into_iter().partition(|c| self.values[*c] > 0.0);
        let mean = |list: &[usize], extraction: &Self| {
            list.iter()
                .map(|c| extraction.lattice.position(*c))
                .sum::<DVec3>()
                / list.len() as f64
        };
        let edges = match (&inside[..], &outside[..]) {
            (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => vec![[a, b], [a, c], [a, d]],
            (&[a, b], &[c, d]) => vec![[a, c], [a, d], [b, d], [b, c]],
            _ => return,
        };
        // The midpoints of the edges lie in a plane and show the orientation.
        let outward = mean(&outside, self) - mean(&inside, self);
        let [p, q, r] = [0, 1, 2].map(|k: usize| mean(&edges[k], self));
        let reversed = (q - p).cross(r - p).dot(outward) < 0.0;
        let ring: Vec<u32> = edges.into_iter().map(|[a, b]| self.vertex(a, b)).collect();
        for k in 1..ring.len() - 1 {
            let [a, b, c] = [ring[0], ring[k], ring[k + 1]];
            let triangle = if reversed { [a, c, b] } else { [a, b, c] };
            self.mesh.triangles.push(triangle);
        }
    }
}
