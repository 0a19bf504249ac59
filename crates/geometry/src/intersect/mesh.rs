//! Contacts among all triangles of a mesh, or of two.

use super::{Contact, contact};
use crate::{Bvh, Mesh};

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
