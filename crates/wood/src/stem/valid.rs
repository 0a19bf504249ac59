//! What the meshes of a model must fulfil before a stem is looked for in them, and why there is none in open ones.

use super::error::StemError;
use super::shells::WeldedMesh;
use crate::EXTENT_RANGE;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context, Mesh, Unions};
use std::collections::BTreeMap;

/// A border that reaches farther than this, in diagonals of the model, runs along a stem and does not close about its end.
const LONG_BORDER: f64 = 0.8;

/// Refuses meshes with coordinates that are not finite, with triangles that refer to vertices that do not exist, without
/// triangles, or of which no tree has the size. Returns the diagonal of the model, m.
pub(super) fn valid_size(meshes: &[Mesh]) -> Result<f64, StemError> {
    for (node, mesh) in meshes.iter().enumerate() {
        let count = mesh.positions.len();
        if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
            let found = format!(
                "vertex {i} is {}; coordinates must be finite",
                mesh.positions[i]
            );
            return Err(StemError::Invalid { node, found });
        }
        let missing = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= count);
        if let Some(t) = mesh.triangles.iter().position(missing) {
            let found = format!("triangle {t} refers to a vertex beyond the {count} of the mesh");
            return Err(StemError::Invalid { node, found });
        }
    }
    if meshes.iter().all(|m| m.triangles.is_empty()) {
        return Err(StemError::Empty);
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut farthest = (0.0, 0, 0);
    for (node, mesh) in meshes.iter().enumerate() {
        for (vertex, p) in mesh.positions.iter().enumerate() {
            (low, high) = (low.min(*p), high.max(*p));
            let far = p.abs().max_element();
            if far > farthest.0 {
                farthest = (far, node, vertex);
            }
        }
    }
    let extent = (high - low).max_element();
    if !(EXTENT_RANGE.0..=EXTENT_RANGE.1).contains(&extent) {
        let (_, node, vertex) = farthest;
        return Err(StemError::Extent {
            extent,
            node,
            vertex,
        });
    }
    Ok(low.distance(high))
}

/// The number of edges of borders (with a triangle on one side only) that run along the model.
pub(super) fn long_borders(meshes: &[Mesh], context: &Context) -> Result<Option<usize>, Cancelled> {
    let mut whole = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut borders: Vec<(usize, f64)> = Vec::new();
    for mesh in meshes {
        let welded = WeldedMesh::new(mesh, 0.0, context)?;
        for p in &welded.positions {
            whole = (whole.0.min(*p), whole.1.max(*p));
        }
        let corners = welded.triangles.iter();
        let mut edges: Vec<[u32; 2]> = corners
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        let lone: Vec<[u32; 2]> = edges
            .chunk_by(|a, b| a == b)
            .filter(|equal| equal.len() == 1)
            .map(|equal| equal[0])
            .collect();
        let mut joined = Unions::new(welded.positions.len());
        for [a, b] in &lone {
            joined.join(*a, *b);
        }
        let mut loops: BTreeMap<u32, (usize, DVec3, DVec3)> = BTreeMap::new();
        for edge in &lone {
            let of = loops.entry(joined.root(edge[0]));
            let of = of.or_insert((0, DVec3::INFINITY, DVec3::NEG_INFINITY));
            of.0 += 1;
            for p in edge.map(|v| welded.positions[v as usize]) {
                (of.1, of.2) = (of.1.min(p), of.2.max(p));
            }
        }
        borders.extend(
            loops
                .values()
                .map(|(n, low, high)| (*n, low.distance(*high))),
        );
    }
    let long = LONG_BORDER * whole.0.distance(whole.1);
    let edges = borders.iter().filter(|b| b.1 > long).map(|b| b.0).sum();
    Ok((edges > 0).then_some(edges))
}
