//! Mesh simplification in all poses of a moving mesh: edges collapse onto one of their ends, those with the least quadric
//! error (Garland & Heckbert 1997), summed over the poses, first.
//!
//! Vertices that remain keep all their attributes and the joints that they follow. A point is removed only if every
//! corner at it has a corner on the same side of seams at the other end, so that seams and borders of materials remain
//! (normals up to 45° apart and other values within 0.001 form no seam), and only if the surface remains a manifold (Dey
//! et al. 1999, Topology Preserving Edge Contraction), so that a closed mesh stays closed. The volume of a closed mesh
//! changes by at most 1 %.

mod collapse;
mod quadric;

#[cfg(test)]
mod tests;

use crate::{Attribute, Bvh, Cancelled, Context, Mesh};
use collapse::{Collapse, RemainingTriangle};
use glam::DVec3;

/// Steps after which a loop asks whether to stop.
const CHECK_INTERVAL: usize = 4096;

/// The outcome of [`simplify`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Simplified {
    /// The simplified mesh.
    pub mesh: Mesh,
    /// For each of its vertices the vertex of the original mesh, ascending.
    pub original_vertices: Vec<u32>,
    /// Largest distance of an original vertex from the simplified surface, over all poses, m.
    pub error: f64,
}

/// Simplifies `mesh` to `triangles` triangles, or to more if no other edge can collapse. `poses` are further positions of
/// all vertices, each list as long as `mesh.positions`; vertices that coincide must do so in every pose. Surfaces may
/// come to intersect.
///
/// A mesh with indices or coordinates out of range, or with poses of other lengths, is returned unchanged.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub fn simplify(
    mesh: &Mesh,
    poses: &[Vec<DVec3>],
    triangles: usize,
    context: &Context,
) -> Result<Simplified, Cancelled> {
    let count = mesh.positions.len();
    let in_range = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < count);
    let finite = |list: &[DVec3]| list.len() == count && list.iter().all(|p| p.is_finite());
    let sound = mesh.triangles.iter().all(in_range)
        && finite(&mesh.positions)
        && poses.iter().all(|pose| finite(pose));
    if !sound || mesh.triangles.len() <= triangles {
        return Ok(Simplified {
            mesh: mesh.clone(),
            original_vertices: (0..count as u32).collect(),
            error: 0.0,
        });
    }
    let mut collapse = Collapse::new(mesh, poses, context)?;
    collapse.run(triangles, context)?;
    let (simplified, kept) = remaining_mesh(mesh, &collapse.triangles());
    let mut error = 0.0f64;
    for pose in std::iter::once(&mesh.positions).chain(poses) {
        error = error.max(largest_distance(pose, &simplified, &kept, context)?);
    }
    Ok(Simplified {
        mesh: simplified,
        original_vertices: kept,
        error,
    })
}

/// Builds the mesh of the remaining triangles. Also returns the original vertex of each of its vertices.
fn remaining_mesh(mesh: &Mesh, triangles: &[RemainingTriangle]) -> (Mesh, Vec<u32>) {
    let mut kept: Vec<u32> = triangles.iter().flat_map(|t| t.corners).collect();
    kept.sort_unstable();
    kept.dedup();
    let mut numbers = vec![0; mesh.positions.len()];
    for (new, &old) in kept.iter().enumerate() {
        numbers[old as usize] = new as u32;
    }
    let remaining = |attribute: &Attribute| Attribute {
        width: attribute.width,
        data: (kept.iter())
            .flat_map(|&v| attribute.at(v as usize).iter().copied())
            .collect(),
    };
    let attributes = mesh.attributes.iter();
    let materials = triangles.iter().filter(|_| !mesh.materials.is_empty());
    let out = Mesh {
        positions: kept.iter().map(|&v| mesh.positions[v as usize]).collect(),
        triangles: (triangles.iter())
            .map(|t| t.corners.map(|v| numbers[v as usize]))
            .collect(),
        attributes: attributes.map(|(n, a)| (n.clone(), remaining(a))).collect(),
        materials: materials
            .map(|t| mesh.material(t.original as usize))
            .collect(),
    };
    (out, kept)
}

/// The largest distance of points from the surface whose vertices are those with the numbers `kept`.
fn largest_distance(
    points: &[DVec3],
    mesh: &Mesh,
    kept: &[u32],
    context: &Context,
) -> Result<f64, Cancelled> {
    let posed = Mesh {
        positions: kept.iter().map(|&v| points[v as usize]).collect(),
        triangles: mesh.triangles.clone(),
        ..Mesh::default()
    };
    let tree = Bvh::from_mesh(&posed);
    let mut kept = kept.iter().peekable();
    let mut most = 0.0f64;
    for (v, &p) in points.iter().enumerate() {
        if v.is_multiple_of(CHECK_INTERVAL) {
            context.check()?;
        }
        if kept.next_if(|&&k| k as usize == v).is_none() {
            let nearest = tree.nearest_on_mesh(&posed, p, f64::INFINITY);
            most = most.max(nearest.map_or(0.0, |n| n.distance));
        }
    }
    Ok(most)
}
