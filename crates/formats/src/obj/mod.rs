//! Wavefront OBJ with its MTL files.

mod material;
mod read;
mod unify;
mod write;

pub(crate) use read::read;
pub(crate) use write::write;
