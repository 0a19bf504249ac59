//! Meshes with named attributes, scenes of them, and the checks that say whether a mesh is sound.
//!
//! Positions are `f64`; everything that only rides along (normals, texture coordinates, colours) is `f32`,
//! as it comes from and goes to a file.
#![deny(missing_docs)]

pub mod bitmap;
pub mod bvh;
pub mod check;
pub mod cloud;
pub mod components;
pub mod context;
pub mod convex;
pub mod film;
pub mod intersect;
pub mod material;
pub mod mesh;
pub mod repair;
pub mod scene;
pub mod simplify;
pub mod table;
pub mod triangulate;
pub mod unions;

pub use bitmap::Bitmap;
pub use bvh::{Aabb, Bvh};
pub use check::{CheckOptions, Report, SelfIntersections};
pub use cloud::PointCloud;
pub use components::{Adjacency, Shells};
pub use context::{CancelToken, Cancelled, Context, Progress, Stage};
pub use convex::{ConvexOptions, ConvexParts, convex_parts};
pub use film::{Binding, Earlier, Extra, Film, Joint, Motion, Pose, Skinned};
pub use material::{Image, ImageSource, Material, Texture, TextureReference};
pub use mesh::{Attribute, Mesh};
pub use scene::{Node, Scene};
pub use simplify::{Simplified, simplify};
pub use table::{Column, Table, Values};
pub use unions::Unions;
