//! glTF 2.0, as JSON with separate buffers and as GLB.
//!
//! Section numbers in this folder refer to the glTF 2.0 specification (Khronos, 2021).

mod accessor;
mod attributes;
mod budget;
mod builder;
mod container;
mod extensions;
mod film;
mod material;
mod meshopt;
mod meshopt_filter;
mod node;
mod primitive;
mod read;
mod schema;
mod write;
mod write_material;
mod write_mesh;
mod write_node;

#[cfg(feature = "usd")]
pub(crate) use attributes::prepared_attributes;
pub(crate) use film::write_film;
pub(crate) use read::read;
pub(crate) use write::write;
