//! Contacts among all triangles of a mesh, or of two.

use super::{Contact, contact};
use crate::{Aabb, Bvh, Mesh};
use glam::DVec3;

/// Rounding error of a turned coordinate over the largest coordinate, several times over.
const TURNING: f64 = 1e-14;

/// A tree of the mesh's triangles for [`self_contacts`], whose boxes stand along the direction that most of its edges
/// take, weighted by their length: about long triangles that are inclined to the axes they are far tighter than boxes
/// along those. Of no use for queries by place.
pub fn contact_tree(mesh: &Mesh) -> Bvh {
    let [x, y, z] = frame(mesh);
    let turned: Vec<DVec3> = mesh
        .positions
        .iter()
        .map(|&p| DVec3::new(x.dot(p), y.dot(p), z.dot(p)))
        .collect();
    let boxes: Vec<Aabb> = mesh
        .triangles
        .iter()
        .map(|t| {
            let corners = t.map(|v| turned[v as usize]);
            let mut bounds = Aabb::around(&corners);
            // A bound for the coordinates of any point as far from the origin.
            let size = corners.map(|p| p.abs().element_sum());
            let margin = DVec3::splat(TURNING * size[0].max(size[1]).max(size[2]));
            (bounds.low, bounds.high) = (bounds.low - margin, bounds.high + margin);
            bounds
        })
        .collect();
    Bvh::new(&boxes)
}

/// Directions at right angles, the first of them that of most edges: the axis of greatest inertia, by iteration.
fn frame(mesh: &Mesh) -> [DVec3; 3] {
    let mut sums = [DVec3::ZERO; 3];
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        for e in [b - a, c - b, a - c] {
            if e.is_finite() {
                sums[0] += e * e.x;
                sums[1] += e * e.y;
                sums[2] += e * e.z;
            }
        }
    }
    let mut x = DVec3::new(1.0, 0.9, 0.8);
    for _ in 0..32 {
        let next = sums[0] * x.x + sums[1] * x.y + sums[2] * x.z;
        match next.try_normalize() {
            Some(next) => x = next,
            None => break,
        }
    }
    let x = x.normalize();
    let (y, z) = x.any_orthonormal_pair();
    [x, y, z]
}

/// Visits every pair of triangles of `mesh`, of whose triangles `tree` is the tree, that touch or cross (see
/// [`contact`]), the smaller index first.
pub fn self_contacts(mesh: &Mesh, tree: &Bvh, mut visit: impl FnMut(usize, usize, Contact)) {
    tree.self_pairs(|s, t| {
        let found = contact(mesh.corners(s), mesh.corners(t));
        if found != Contact::Apart {
            visit(s, t, found);
        }
    });
}

/// Visits every pair of a triangle of `first` and one of `second` that touch or cross (see [`contact`]). Each tree is
/// that of the mesh's triangles.
pub fn contacts_between(
    (first, first_tree): (&Mesh, &Bvh),
    (second, second_tree): (&Mesh, &Bvh),
    mut visit: impl FnMut(usize, usize, Contact),
) {
    first_tree.pairs(second_tree, |s, t| {
        let found = contact(first.corners(s), second.corners(t));
        if found != Contact::Apart {
            visit(s, t, found);
        }
    });
}
