//! Which length of the stem every vertex of a piece belongs to. What is near the axis belongs where it is; side branches and
//! the rest of a tree belong where they grow out of what is near.

use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_wood::stem::Stem;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What is no farther from the axis than this many radii of the stem is part of it.
const NEAR: f64 = 1.6;

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

/// Returns for each vertex of a mesh in the stem's world the length along the axis (m) that it belongs to.
pub(super) fn lengths_along(mesh: &Mesh, stem: &Stem) -> Vec<f64> {
    let axis = stem.grain.axis();
    let along: Vec<f64> = mesh.positions.iter().map(|&p| axis.length_at(p)).collect();
    let is_near = |v: usize| {
        let off = mesh.positions[v].distance(axis.frame(along[v]).origin);
        off <= NEAR * stem.radius * stem.grain.scale(along[v])
    };
    let near: Vec<bool> = (0..along.len()).map(is_near).collect();
    if near.iter().all(|&n| n) || !near.contains(&true) {
        return along;
    }
    spread(mesh, &along, &near)
}

/// Gives what is not near the length of the nearest vertex that is, along the edges of the mesh; what no edges lead to keeps
/// its own.
fn spread(mesh: &Mesh, along: &[f64], near: &[bool]) -> Vec<f64> {
    let (points, count) = mesh.points();
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
    let mut places = vec![DVec3::ZERO; count];
    for (&point, &position) in points.iter().zip(&mesh.positions) {
        places[point as usize] = position;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| points[v as usize]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            neighbours[p as usize].push(q);
            neighbours[q as usize].push(p);
        }
    }
    let mut source: Vec<Option<u32>> = vec![None; count];
    let mut queue = BinaryHeap::new();
    for v in (0..along.len()).filter(|&v| near[v]) {
        queue.push(Reverse((Distance(0.0), points[v], v as u32)));
    }
    while let Some(Reverse((Distance(far), v, from))) = queue.pop() {
        if source[v as usize].is_some() {
            continue;
        }
        source[v as usize] = Some(from);
        for &n in &neighbours[v as usize] {
            if source[n as usize].is_none() {
                let [p, q] = [v, n].map(|v| places[v as usize]);
                queue.push(Reverse((Distance(far + p.distance(q)), n, from)));
            }
        }
    }
    let length = |v: usize| match (near[v], source[points[v] as usize]) {
        (false, Some(from)) => along[from as usize],
        _ => along[v],
    };
    (0..along.len()).map(length).collect()
}
