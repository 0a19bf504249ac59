//! PLY: text and binary of both byte orders in, binary little endian out.

mod header;
mod read;
mod write;

pub(crate) use read::read;
pub(crate) use write::write;
