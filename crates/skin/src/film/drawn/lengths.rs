//! Which length of the stem every vertex of a piece belongs to. What is near the axis belongs where it is; side branches and
//! the rest of a tree belong where they grow out of what is near.

use super::edge_graph::EdgeGraph;
use greenstick_geometry::Mesh;
use greenstick_wood::stem::Stem;

/// What is no farther from the axis than this many radii of the stem is part of it.
const NEAR: f64 = 1.6;

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
    let graph = EdgeGraph::new(mesh);
    let starts = (0..along.len()).filter(|&v| near[v]);
    let reached = graph.reach(starts.map(|v| (v as u32, 0.0)), f64::INFINITY);
    let length = |v: usize| match (near[v], reached[graph.points[v] as usize]) {
        (false, Some(reached)) => along[reached.from as usize],
        _ => along[v],
    };
    (0..along.len()).map(length).collect()
}
