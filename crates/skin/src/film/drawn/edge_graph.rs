//! The shortest ways from some points of a mesh to all others along its edges (Dijkstra 1959).

use glam::DVec3;
use greenstick_geometry::Mesh;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The edges between the points of a mesh.
pub(super) struct EdgeGraph {
    /// The point of each vertex.
    pub points: Vec<u32>,
    places: Vec<DVec3>,
    neighbours: Vec<Vec<u32>>,
}

/// A distance that can be ordered, m; never NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// How a point is reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reached {
    /// Distance along the edges, m, beside that at which the way began.
    pub distance: f64,
    /// The vertex at which the way began.
    pub from: u32,
}

impl EdgeGraph {
    pub fn new(mesh: &Mesh) -> Self {
        let (points, count) = mesh.points();
        let mut graph = EdgeGraph {
            places: vec![DVec3::ZERO; count],
            neighbours: vec![Vec::new(); count],
            points,
        };
        for (&point, &position) in graph.points.iter().zip(&mesh.positions) {
            graph.places[point as usize] = position;
        }
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| graph.points[v as usize]);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                graph.neighbours[p as usize].push(q);
                graph.neighbours[q as usize].push(p);
            }
        }
        graph
    }

    /// Returns how each point is reached first from some vertices, which have distances (m) to begin with, up to a distance of
    /// `limit` (m); `None` for those that are farther or that no edges lead to.
    pub fn reach(
        &self,
        starts: impl Iterator<Item = (u32, f64)>,
        limit: f64,
    ) -> Vec<Option<Reached>> {
        let mut reached: Vec<Option<Reached>> = vec![None; self.places.len()];
        let mut queue: BinaryHeap<_> = starts
            .map(|(v, far)| Reverse((Distance(far), self.points[v as usize], v)))
            .collect();
        while let Some(Reverse((Distance(distance), point, from))) = queue.pop() {
            let known = &mut reached[point as usize];
            if known.is_some() || distance > limit {
                continue;
            }
            *known = Some(Reached { distance, from });
            for &n in &self.neighbours[point as usize] {
                if reached[n as usize].is_none() {
                    let [p, q] = [point, n].map(|v| self.places[v as usize]);
                    queue.push(Reverse((Distance(distance + p.distance(q)), n, from)));
                }
            }
        }
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_reached_along_the_edges_and_across_seams() {
        // A strip of squares of 1 m whose third is joined by vertices of its own.
        let at = |x: u32, y: u32| DVec3::new(f64::from(x), f64::from(y), 0.0);
        let positions = (0..4).flat_map(|x| [at(x, 0), at(x, 1)]);
        let mut mesh = Mesh {
            positions: positions.chain([at(2, 0), at(2, 1)]).collect(),
            triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
            ..Mesh::default()
        };
        mesh.triangles.extend([[8, 6, 7], [8, 7, 9]]);
        let graph = EdgeGraph::new(&mesh);
        let reach = |limit: f64| graph.reach([(0, 0.5), (1, 0.0)].into_iter(), limit);
        let of = |v: usize, reached: &[Option<Reached>]| reached[graph.points[v] as usize];
        let all = reach(f64::INFINITY);
        // Along y = 1 from vertex 1, and to the lower corners by the diagonals from vertex 0 or straight from the upper ones.
        let expected = [(7, 3.0, 1), (5, 2.0, 1), (4, 2.5, 0), (2, 1.5, 0)];
        for (v, distance, from) in expected {
            assert_eq!(of(v, &all), Some(Reached { distance, from }), "{v}");
        }
        assert_eq!(of(8, &all), of(4, &all));
        assert!(of(7, &reach(2.9)).is_none() && of(5, &reach(2.9)).is_some());
    }
}
