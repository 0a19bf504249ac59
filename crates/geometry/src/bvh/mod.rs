//! A bounding-volume hierarchy over boxes, most often those of a mesh's triangles, and its queries.
//!
//! Nodes lie in depth-first order and store the end of their subtree, so that a query by region is one loop without a
//! stack: step to the next node where the region meets the box, jump to the end of the subtree where it does not.
//! The same boxes give the same tree and the same order of visits on every machine.

mod aabb;
mod build;
mod mesh;
mod pairs;
mod query;
mod tree;

pub use aabb::Aabb;
pub use mesh::NearestPoint;
pub use tree::Bvh;

#[cfg(test)]
mod tests;
