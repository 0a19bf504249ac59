//! What hangs together: shells of triangles that share points, and neighbours across edges.
//!
//! Triangles with an index out of range or with two corners at one point take no part: they have no neighbours, and
//! each is a shell of its own where none of its points is used elsewhere.

mod edges;
mod points;

pub(crate) use edges::{Edges, Use};
pub(crate) use points::number_points;

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

/// Neighbours of triangles across their edges, by points.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// For each triangle the neighbours across its edges, the edge `k` running from corner `k` to corner `k + 1`.
    /// [`NONE`] at a boundary and at an edge of more than two triangles.
    pub neighbours: Vec<[u32; 3]>,
    /// Every edge of more than two triangles: its points (numbered as by [`Mesh::points`]) and its triangles.
    pub non_manifold: Vec<([u32; 2], Vec<u32>)>,
}

/// Corners as points; `None` for a triangle with an index out of range.
pub(crate) fn corner_points(triangle: [u32; 3], points: &[u32]) -> Option<[u32; 3]> {
    let point = |i: u32| points.get(i as usize).copied();
    Some([
        point(triangle[0])?,
        point(triangle[1])?,
        point(triangle[2])?,
    ])
}

impl Mesh {
    /// The shells of the mesh: triangles that share a point, be it only one, are of one shell.
    pub fn shells(&self) -> Shells {
        let (points, count) = number_points(&self.positions);
        shells(&self.triangles, &points, count)
    }

    /// The neighbours of every triangle across its edges.
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
                adjacency.non_manifold.push(([low, first.high], triangles));
            }
            _ => {}
        });
        adjacency
    }
}

/// [`Mesh::shells`] for points numbered before.
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
