//! PLY: text and binary of both byte orders in, binary little endian out.

mod header;
mod points;
mod read;
mod write;

pub(crate) use points::read_points;
pub(crate) use read::read;
pub(crate) use write::write;
