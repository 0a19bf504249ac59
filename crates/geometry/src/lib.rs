//! Meshes with named attributes, scenes of them, and the checks that say whether a mesh is sound.
//!
//! Positions are `f64`; everything that only rides along (normals, texture coordinates, colours) is `f32`,
//! as it comes from and goes to a file.
#![deny(missing_docs)]

pub mod context;
pub mod material;
pub mod mesh;
pub mod scene;

pub use context::{Cancelled, Context};
pub use material::{Image, ImageSource, Material, Texture, TextureReference};
pub use mesh::{Attribute, Mesh};
pub use scene::{Node, Scene};
