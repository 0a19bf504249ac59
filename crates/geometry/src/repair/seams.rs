//! Closing of seams: borders that lie on each other but for the last digits, as where texture coordinates end and begin again
//! and either side worked out its positions by itself. Sine and cosine of 0 and of a whole turn differ so.

use crate::{Mesh, Scene, Unions};
use glam::DVec3;
use rustc_hash::FxHashSet;

/// How far the sides of a seam may be apart, as a part of the mesh's diagonal: some steps of single precision, and far below
/// what a mesh shows.
pub const SEAM_TOLERANCE: f64 = 1e-6;

/// Moves vertices at borders of a mesh onto those of another border that lie within [`SEAM_TOLERANCE`] of its size. Vertices
/// stay apart, with attributes of their own; triangles keep their area. Returns how many vertices were moved, and the distance
/// (in the mesh's unit) within which.
pub fn close_seams(mesh: &mut Mesh) -> (usize, f64) {
    let tolerance = mesh
        .bounds()
        .map_or(0.0, |(low, high)| SEAM_TOLERANCE * low.distance(high));
    let (points, count) = mesh.points();
    let mut places = vec![DVec3::ZERO; count];
    for (v, &p) in points.iter().enumerate() {
        places[p as usize] = mesh.positions[v];
    }
    let sides: Vec<[u32; 2]> = (mesh.triangles.iter())
        .map(|t| t.map(|v| points[v as usize]))
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    let mut sorted = sides.clone();
    sorted.sort_unstable();
    let lone = sorted.chunk_by(|a, b| a == b).filter(|e| e.len() == 1);
    let mut border: Vec<u32> = lone.flat_map(|e| e[0]).collect();
    border.sort_unstable();
    border.dedup();
    let mut joined = Unions::new(count);
    // Along one axis, so that only few others come into question.
    border.sort_by(|a, b| places[*a as usize].x.total_cmp(&places[*b as usize].x));
    let mut any = false;
    for (i, &a) in border.iter().enumerate() {
        let at = places[a as usize];
        let near = border[i + 1..]
            .iter()
            .take_while(|b| places[**b as usize].x - at.x <= tolerance);
        for &b in near.filter(|b| places[**b as usize].distance(at) <= tolerance) {
            any |= joined.join(a, b);
        }
    }
    if !any {
        return (0, tolerance);
    }
    // Nothing is moved where a side of a triangle would vanish.
    let sides = sides.iter().filter(|[a, b]| a != b);
    let vanishing: FxHashSet<u32> = sides
        .filter_map(|[a, b]| Some(joined.root(*a)).filter(|r| *r == joined.root(*b)))
        .collect();
    let mut moved = 0;
    for (v, &p) in points.iter().enumerate() {
        let root = joined.root(p);
        if root != p && !vanishing.contains(&root) {
            mesh.positions[v] = places[root as usize];
            moved += 1;
        }
    }
    (moved, tolerance)
}

/// Closes the seams of all meshes of a scene. Returns a note on each mesh that had one.
pub fn close_seams_of_scene(scene: &mut Scene) -> Vec<String> {
    let mut notes = Vec::new();
    for node in &mut scene.nodes {
        let mut mesh = Mesh::clone(&node.mesh);
        let (moved, within) = close_seams(&mut mesh);
        if moved > 0 {
            node.mesh = mesh.into();
            let within = within * node.transform.matrix3.determinant().abs().cbrt();
            notes.push(format!(
                "sides of seams of \"{}\" lay apart: {moved} vertices were moved onto others within {within:.1e} m",
                node.name
            ));
        }
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side, the second one `gap` off the first.
    fn squares(gap: f64) -> Mesh {
        let square = |x: f64| [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(u, v)| (x + u, v));
        Mesh {
            positions: [square(0.0), square(1.0 + gap)]
                .concat()
                .into_iter()
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Mesh::default()
        }
    }

    #[test]
    fn sides_within_the_tolerance_meet() {
        let mut near = squares(1e-9);
        assert_eq!(close_seams(&mut near).0, 2);
        assert_eq!(near.points().1, 6);
        let mut far = squares(1e-4);
        assert_eq!(close_seams(&mut far).0, 0);
        assert_eq!(far, squares(1e-4));
    }

    #[test]
    fn slivers_keep_their_corners() {
        let mut sliver = Mesh {
            positions: [(0., 0.), (1e-9, 0.), (0., 1.)]
                .map(|(x, y)| DVec3::new(x, y, 0.0))
                .to_vec(),
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        assert_eq!(close_seams(&mut sliver).0, 0);
    }
}
