//! Fewer triangles for the same shape, in all poses of a mesh that moves: edges collapse onto one of their ends, those
//! first that cost least by quadrics (Garland & Heckbert 1997) added up over the poses.
//!
//! Vertices that stay keep all they have: texture coordinates, normals, what they follow. A point goes only where every
//! corner at it has a corner with the same seam side at the other end, so that seams and borders of materials stay seams
//! and borders (normals up to 45° apart and other values within 0.001 are no seam), and only where the surface stays a surface (Dey et al. 1999), so that what is closed stays closed. The
//! volume of what is closed changes by 1 % at most.

mod quadric;
mod work;

#[cfg(test)]
mod tests;

use crate::{Attribute, Bvh, Cancelled, Context, Mesh};
use glam::DVec3;
use work::Work;

/// A mesh with fewer triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Simplified {
    /// The mesh.
    pub mesh: Mesh,
    /// For each of its vertices that of the mesh before, ascending.
    pub kept: Vec<u32>,
    /// Largest distance of a vertex of the mesh before from the surface, over all poses, m.
    pub error: f64,
}

/// `mesh` with as few as `triangles` triangles, or more where no other edge can go. `poses` are places of all its
/// vertices besides those that it has, each list as long as `mesh.positions`; vertices at one place are so in all of
/// them. Surfaces that pass through each other are not looked for.
///
/// A mesh with indices or numbers out of range, or poses of other lengths, comes back as it is.
///
/// # Errors
/// [`Cancelled`].
pub fn simplify(
    mesh: &Mesh,
    poses: &[Vec<DVec3>],
    triangles: usize,
    context: &Context,
) -> Result<Simplified, Cancelled> {
    let count = mesh.positions.len();
    let named = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < count);
    let finite = |list: &[DVec3]| list.len() == count && list.iter().all(|p| p.is_finite());
    let sound = mesh.triangles.iter().all(named)
        && finite(&mesh.positions)
        && poses.iter().all(|pose| finite(pose));
    if !sound || mesh.triangles.len() <= triangles {
        return Ok(Simplified {
            mesh: mesh.clone(),
            kept: (0..count as u32).collect(),
            error: 0.0,
        });
    }
    let mut work = Work::new(mesh, poses);
    work.run(triangles, context)?;
    let (mesh_after, kept) = pick(mesh, &work.triangles());
    let mut error = 0.0f64;
    for pose in std::iter::once(&mesh.positions).chain(poses) {
        context.report(0.0)?;
        error = error.max(farthest(pose, &mesh_after, &kept));
    }
    Ok(Simplified {
        mesh: mesh_after,
        kept,
        error,
    })
}

/// The mesh of some triangles, given as the corners and the triangle that they are of before.
fn pick(mesh: &Mesh, triangles: &[([u32; 3], u32)]) -> (Mesh, Vec<u32>) {
    let mut kept: Vec<u32> = triangles.iter().flat_map(|t| t.0).collect();
    kept.sort_unstable();
    kept.dedup();
    let mut numbers = vec![0; mesh.positions.len()];
    for (new, &old) in kept.iter().enumerate() {
        numbers[old as usize] = new as u32;
    }
    let some = |attribute: &Attribute| Attribute {
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
            .map(|(corners, _)| corners.map(|v| numbers[v as usize]))
            .collect(),
        attributes: attributes.map(|(n, a)| (n.clone(), some(a))).collect(),
        materials: materials.map(|&(_, t)| mesh.material(t as usize)).collect(),
    };
    (out, kept)
}

/// Largest distance of points from the surface whose vertices are the `kept` ones of them.
fn farthest(points: &[DVec3], mesh: &Mesh, kept: &[u32]) -> f64 {
    let posed = Mesh {
        positions: kept.iter().map(|&v| points[v as usize]).collect(),
        triangles: mesh.triangles.clone(),
        ..Mesh::default()
    };
    let tree = Bvh::of_triangles(&posed);
    let mut kept = kept.iter().peekable();
    let mut most = 0.0f64;
    for (v, &p) in points.iter().enumerate() {
        if kept.next_if(|&&k| k as usize == v).is_none() {
            let nearest = tree.nearest_on(&posed, p, f64::INFINITY);
            most = most.max(nearest.map_or(0.0, |n| n.distance));
        }
    }
    most
}
