//! The hierarchy as it is stored.

use super::Aabb;

/// A node of the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub bounds: Aabb,
    /// First node after this one's subtree.
    pub end: u32,
    /// First item of a leaf in [`Bvh::order`].
    pub first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    pub count: u32,
}

/// A bounding-volume hierarchy. Items are the boxes it was built from and are identified by their index.
///
/// ```
/// use glam::DVec3;
/// use greenstick_geometry::{Aabb, Bvh};
///
/// let boxes: Vec<Aabb> = (0..100)
///     .map(|i| Aabb::around(&[DVec3::splat(f64::from(i)), DVec3::splat(f64::from(i) + 0.5)]))
///     .collect();
/// let tree = Bvh::new(&boxes);
/// let mut found = Vec::new();
/// tree.overlapping(&Aabb::around(&[DVec3::splat(7.2), DVec3::splat(8.1)]), |item| found.push(item));
/// assert_eq!(found, [7, 8]);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bvh {
    pub(super) nodes: Vec<Node>,
    /// Items in the order of the leaves.
    pub(super) order: Vec<u32>,
    /// Boxes in the order of the leaves.
    pub(super) boxes: Vec<Aabb>,
}

impl Bvh {
    /// Number of items.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// The box around everything; [`Aabb::EMPTY`] for a tree without items.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |n| n.bounds)
    }
}
