//! Meshes with named attributes, scenes of them, and checks of their soundness; point clouds, tables, films and
//! solids for finite elements.
//!
//! Positions are `f64`; other attributes (normals, texture coordinates, colours) are `f32`, as in files.
#![deny(missing_docs)]

pub mod bitmap;
pub mod bvh;
pub mod check;
pub mod cloud;
pub mod components;
pub mod context;
pub mod convex;
mod eigen;
mod error_kind;
pub mod film;
pub mod intersect;
pub mod material;
pub mod mesh;
pub mod overlap;
pub mod provenance;
pub mod repair;
pub mod scene;
pub mod simplify;
mod solid_model;
pub mod table;
pub mod text;
mod triangle;
pub mod triangulate;
pub mod unions;

pub use bitmap::Bitmap;
pub use bvh::{Aabb, Bvh};
pub use check::{CheckOptions, Report, SelfIntersections};
pub use cloud::PointCloud;
pub use components::{Adjacency, Shells};
pub use context::{CancelToken, Cancelled, Context, Progress, Stage};
pub use convex::{ConvexOptions, ConvexParts, convex_parts};
pub use eigen::symmetric_eigen;
pub use error_kind::ErrorKind;
pub use film::{
    Binding, EarlierBindings, Extra, Film, Joint, Motion, Pose, RigidBody, SkinnedMesh,
};
pub use material::{Image, ImageSource, Material, Pixels, Texture, TextureReference};
pub use mesh::{Attribute, Mesh};
pub use provenance::{Metadata, MetadataEntry, Provenance};
pub use scene::{Node, Scene};
pub use simplify::{Simplified, simplify};
pub use solid_model::{ElementSet, NodeSet, OrthotropicMaterial, SolidModel};
pub use table::{Column, Table, Values};
pub use triangle::closest_point_on_triangle;
pub use unions::Unions;
