//! PLY: reading text and binary in both byte orders, writing little-endian binary.

mod body;
mod faces;
mod header;
mod points;
mod properties;
mod read;
mod vertices;
mod write;

pub(crate) use points::read_points;
pub(crate) use read::read;
pub(crate) use write::write;
