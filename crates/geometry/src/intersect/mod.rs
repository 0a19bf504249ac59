//! Contacts between triangles: whether they meet, and whether they cross or only touch, decided exactly.
//!
//! All decisions are signs of Shewchuk's adaptive predicates (1997, Adaptive Precision Floating-Point Arithmetic), so
//! there is no tolerance. The intervals in which two triangles meet the intersection line of their planes (Möller 1997,
//! A Fast Triangle-Triangle Intersection Test) are compared by the same predicates, not by computed numbers.

mod box_pairs;
mod contact;
mod coplanar;
mod mesh;
mod predicates;
mod projection;

pub(crate) use box_pairs::overlapping_pairs;
pub(crate) use contact::Plane;
pub use contact::contact;
pub(crate) use mesh::TriangleContacts;
pub(crate) use mesh::{contact_boxes, self_contacts_while};
pub use mesh::{contact_tree, self_contacts};
pub use predicates::{orient2d, orient3d};
pub use projection::collinear;

/// How two triangles meet, apart from the vertex or edge that they share as neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Contact {
    /// They do not meet, or only in the vertex or the edge that they share.
    Apart,
    /// They meet in a point or along a line, but neither passes through the other.
    Touching,
    /// Their interiors meet: one passes through the other, or both lie in one plane and overlap.
    Crossing,
}

#[cfg(test)]
mod tests;
