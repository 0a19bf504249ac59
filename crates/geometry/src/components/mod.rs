//! Connectivity: shells of triangles that share points, and neighbours across edges.
//!
//! Triangles with an index out of range or with two corners at one point do not connect anything: they have no
//! neighbours, and each is a shell of its own if none of its points is used elsewhere.

mod edges;
mod points;
mod topology;

pub(crate) use edges::{Edges, Use};
pub(crate) use points::{corner_points, number_keys, number_points};
pub(crate) use topology::Topology;

use crate::Mesh;

/// "No triangle" in [`Adjacency::neighbours`], "no shell" in [`Shells::of_triangle`].
pub const NONE: u32 = u32::MAX;

/// The shells of a mesh: sets of triangles joined by shared points.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Shells {
    /// Shell of each triangle, counted from 0 in order of first appearance; [`NONE`] for a triangle with an index out
    /// of range.
    pub of_triangle: Vec<u32>,
    /// Number of shells.
    pub count: usize,
}

/// Neighbours of triangles across the edges of points.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// For each triangle the neighbours across its edges; edge `k` runs from corner `k` to corner `k + 1`.
    /// [`NONE`] at a boundary and at an edge with more than two triangles.
    pub neighbours: Vec<[u32; 3]>,
    /// Every edge with more than two triangles.
    pub non_manifold: Vec<NonManifoldEdge>,
}

/// An edge with more than two triangles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NonManifoldEdge {
    /// Its points, numbered as by [`Mesh::points`].
    pub points: [u32; 2],
    /// Its triangles.
    pub triangles: Vec<u32>,
}

impl Mesh {
    /// Finds the shells of the mesh: triangles that share a point, even a single one, belong to one shell.
    pub fn shells(&self) -> Shells {
        let (points, count) = number_points(&self.positions);
        shells(&self.triangles, &points, count)
    }

    /// Finds the neighbours of every triangle across its edges.
    pub fn adjacency(&self) -> Adjacency {
        let (points, count) = number_points(&self.positions);
        let edges = Edges::new(&self.triangles, &points, count);
        let mut adjacency = Adjacency {
            neighbours: vec![[NONE; 3]; self.triangles.len()],
            non_manifold: Vec::new(),
        };
        edges.each(|low, uses| match *uses {
            [a, b] => {
                adjacency.neighbours[a.triangle()][a.edge()] = b.triangle() as u32;
                adjacency.neighbours[b.triangle()][b.edge()] = a.triangle() as u32;
            }
            [first, _, _, ..] => {
                let triangles = uses.iter().map(|u| u.triangle() as u32).collect();
                adjacency.non_manifold.push(NonManifoldEdge {
                    points: [low, first.high()],
                    triangles,
                });
            }
            _ => {}
        });
        adjacency
    }
}

/// [`Mesh::shells`] for points that are numbered already.
pub(crate) fn shells(triangles: &[[u32; 3]], points: &[u32], count: usize) -> Shells {
    let mut unions = crate::Unions::new(count);
    for &t in triangles {
        if let Some([a, b, c]) = corner_points(t, points) {
            unions.join(a, b);
            unions.join(b, c);
        }
    }
    let mut number = vec![NONE; count];
    let mut next = 0;
    let of_triangle = triangles
        .iter()
        .map(|&t| match corner_points(t, points) {
            None => NONE,
            Some([a, ..]) => {
                let root = &mut number[unions.root(a) as usize];
                if *root == NONE {
                    *root = next;
                    next += 1;
                }
                *root
            }
        })
        .collect();
    Shells {
        of_triangle,
        count: next as usize,
    }
}

#[cfg(test)]
mod tests;
