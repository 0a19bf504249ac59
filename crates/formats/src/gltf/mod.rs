//! glTF 2.0, as JSON with separate buffers and as GLB.
//!
//! Section numbers in this folder are those of the glTF 2.0 specification (Khronos, 2021).

mod accessor;
mod container;
mod film;
mod material;
mod meshopt;
mod meshopt_filter;
mod node;
mod primitive;
mod read;
mod schema;
mod vertices;
mod write;
mod write_material;

pub(crate) use film::write_film;
pub(crate) use read::read;
pub(crate) use vertices::attributes as ready_attributes;
pub(crate) use write::write;
