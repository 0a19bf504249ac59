//! The surface on which values at a lattice's nodes have one level, cut out of tetrahedra (Doi and Koide 1991). Each cell is
//! six of them about its diagonal, all cells alike, so that tetrahedra beside each other share their faces and the surface
//! is closed and a manifold.

use super::poisson::Lattice;
use crate::Mesh;
use glam::DVec3;
use std::collections::HashMap;

/// Part of an edge's length that the surface stays away from its ends: no triangle is without area.
const CLEAR: f64 = 0.02;
/// Steps from a cell's first corner to its last, by which each tetrahedron walks.
const WALKS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

struct Cutter<'a> {
    lattice: &'a Lattice,
    values: Vec<f64>,
    mesh: Mesh,
    /// Vertex on the edge between two nodes, the lower number first.
    on: HashMap<(usize, usize), u32>,
}

/// The closed surface about the nodes whose values exceed `level`, cut off where `inside` (a distance, m) falls below 0; nodes at
/// the lattice's border count as outside.
pub(super) fn surface(
    lattice: &Lattice,
    values: &[f64],
    level: f64,
    inside: impl Fn(DVec3) -> f64,
) -> Mesh {
    let [nx, ny, nz] = lattice.size;
    let strides = lattice.strides();
    let mut above: Vec<f64> = values.iter().map(|v| v - level).collect();
    let scale = above.iter().fold(0.0f64, |a, v| a.max(v.abs()));
    for (i, v) in above.iter_mut().enumerate() {
        let at = [i % nx, i / nx % ny, i / (nx * ny)];
        if (0..3).any(|k| at[k] == 0 || at[k] + 1 == lattice.size[k]) {
            *v = v.min(-1e-3 * scale);
        }
        let place = lattice.low + DVec3::from_array(at.map(|k| k as f64)) * lattice.cell;
        // As steep as the indicator is at its surface.
        *v = v.min(0.5 * scale * inside(place) / lattice.cell);
    }
    let mut cutter = Cutter {
        lattice,
        values: above,
        mesh: Mesh::default(),
        on: HashMap::new(),
    };
    for z in 0..nz - 1 {
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let first = x + y * strides[1] + z * strides[2];
                let corner =
                    |c: usize| first + (0..3).map(|k| (c >> k & 1) * strides[k]).sum::<usize>();
                let inside = (0..8).filter(|c| cutter.values[corner(*c)] > 0.0).count();
                if inside == 0 || inside == 8 {
                    continue;
                }
                for walk in WALKS {
                    let mut at = first;
                    let mut corners = [at; 4];
                    for (k, axis) in walk.into_iter().enumerate() {
                        at += strides[axis];
                        corners[k + 1] = at;
                    }
                    cutter.cut(corners);
                }
            }
        }
    }
    cutter.mesh
}

impl Cutter<'_> {
    fn place(&self, node: usize) -> DVec3 {
        let [nx, ny, _] = self.lattice.size;
        let at = [node % nx, node / nx % ny, node / (nx * ny)].map(|k| k as f64);
        self.lattice.low + DVec3::from_array(at) * self.lattice.cell
    }

    fn vertex(&mut self, a: usize, b: usize) -> u32 {
        let key = (a.min(b), a.max(b));
        if let Some(&vertex) = self.on.get(&key) {
            return vertex;
        }
        let (u, v) = (self.values[key.0], self.values[key.1]);
        let part = (u / (u - v)).clamp(CLEAR, 1.0 - CLEAR);
        let p = self.place(key.0).lerp(self.place(key.1), part);
        let vertex = self.mesh.positions.len() as u32;
        self.mesh.positions.push(p);
        self.on.insert(key, vertex);
        vertex
    }

    fn cut(&mut self, corners: [usize; 4]) {
        let (inside, outside): (Vec<usize>, Vec<usize>) =
            corners.into_iter().partition(|c| self.values[*c] > 0.0);
        let mean = |list: &[usize], cutter: &Self| {
            list.iter().map(|c| cutter.place(*c)).sum::<DVec3>() / list.len() as f64
        };
        let ring = match (&inside[..], &outside[..]) {
            (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => vec![[a, b], [a, c], [a, d]],
            (&[a, b], &[c, d]) => vec![[a, c], [a, d], [b, d], [b, c]],
            _ => return,
        };
        // Which way round is told by the middles of the edges, which lie in a plane.
        let outward = mean(&outside, self) - mean(&inside, self);
        let [p, q, r] = [0, 1, 2].map(|k: usize| mean(&ring[k], self));
        let turned = (q - p).cross(r - p).dot(outward) < 0.0;
        let ring: Vec<u32> = ring.into_iter().map(|[a, b]| self.vertex(a, b)).collect();
        for k in 1..ring.len() - 1 {
            let [a, b, c] = [ring[0], ring[k], ring[k + 1]];
            let triangle = if turned { [a, c, b] } else { [a, b, c] };
            self.mesh.triangles.push(triangle);
        }
    }
}
