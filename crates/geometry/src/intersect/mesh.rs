//! Contacts among the triangles of a mesh, or between those of two meshes.

use super::Contact;
use super::contact::{Plane, contact};
use crate::{Aabb, Bvh, Mesh};
use glam::DVec3;

/// Bound of the rounding error of a rotated coordinate, relative to the largest coordinate.
const ROTATION_ERROR: f64 = 1e-14;

/// Builds a tree of the mesh's triangles for [`self_contacts`], of their boxes in a frame along the direction of most
/// edges. The tree is useless for queries by position.
pub fn contact_tree(mesh: &Mesh) -> Bvh {
    Bvh::new(&contact_boxes(mesh))
}

/// Returns boxes of the mesh's triangles in a frame whose first axis is the direction of most edges, weighted by their
/// length: around long triangles inclined to the axes they are far tighter than axis-aligned ones.
pub(crate) fn contact_boxes(mesh: &Mesh) -> Vec<Aabb> {
    let [x, y, z] = frame(mesh);
    let rotated: Vec<DVec3> = mesh
        .positions
        .iter()
        .map(|&p| DVec3::new(x.dot(p), y.dot(p), z.dot(p)))
        .collect();
    mesh.triangles
        .iter()
        .map(|t| {
            let corners = t.map(|v| rotated[v as usize]);
            let mut bounds = Aabb::around(&corners);
            // Bounds the coordinates in any frame.
            let size = corners.map(|p| p.abs().element_sum());
            let margin = DVec3::splat(ROTATION_ERROR * size[0].max(size[1]).max(size[2]));
            (bounds.low, bounds.high) = (bounds.low - margin, bounds.high + margin);
            bounds
        })
        .collect()
}

/// An orthonormal frame whose first axis is the main direction of the edges, by power iteration.
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

/// Finds the contacts of many pairs among some triangles, whose planes it holds: faster than [`contact`] where most pairs
/// are apart and share no corner.
pub(crate) struct TriangleContacts<'a> {
    positions: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    planes: Vec<Plane>,
}

impl<'a> TriangleContacts<'a> {
    pub(crate) fn new(positions: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let plane = |t: &[u32; 3]| Plane::new(t.map(|v| positions[v as usize]));
        TriangleContacts {
            positions,
            triangles,
            planes: triangles.iter().map(plane).collect(),
        }
    }

    /// Returns the contact of two triangles.
    pub(crate) fn between(&self, s: usize, t: usize) -> Contact {
        if self.is_clearly_beside(s, t) || self.is_clearly_beside(t, s) {
            return Contact::Apart;
        }
        let corners = |t: usize| self.triangles[t].map(|v| self.positions[v as usize]);
        contact(corners(s), corners(t))
    }

    /// Whether triangle `t` lies clearly on one side of triangle `s` but for the corners that they share.
    #[inline]
    fn is_clearly_beside(&self, s: usize, t: usize) -> bool {
        let [a, b, c] = self.triangles[s];
        let corner = |v: u32| {
            let shared = (v == a) | (v == b) | (v == c);
            (self.positions[v as usize], shared)
        };
        self.planes[s].is_clearly_beside_but(self.triangles[t].map(corner))
    }
}

/// Visits every pair of triangles of `mesh` that touch or cross (see [`contact`]), the smaller index first. `tree` must
/// be that of the mesh's triangles.
pub fn self_contacts(mesh: &Mesh, tree: &Bvh, mut visit: impl FnMut(usize, usize, Contact)) {
    self_contacts_while(mesh, tree, usize::MAX, |s, t, found| {
        visit(s, t, found);
        true
    });
}

/// As [`self_contacts`], until `visit` returns false or `most` pairs of boxes were looked at. Returns whether all were.
pub(crate) fn self_contacts_while(
    mesh: &Mesh,
    tree: &Bvh,
    most: usize,
    mut visit: impl FnMut(usize, usize, Contact) -> bool,
) -> bool {
    let contacts = TriangleContacts::new(&mesh.positions, &mesh.triangles);
    let mut left = most;
    let mut complete = true;
    tree.self_pairs_while(|s, t| {
        if left == 0 {
            complete = false;
            return false;
        }
        left -= 1;
        let found = contacts.between(s, t);
        complete = found == Contact::Apart || visit(s, t, found);
        complete
    });
    complete
}
