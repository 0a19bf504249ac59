//! Detection of mesh formats by content.

use crate::format::Format;
use crate::{off, stl};

/// The mesh format that the first bytes prove, if any.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    let text = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    if bytes.starts_with(b"glTF") {
        Some(Format::Glb)
    } else if text.starts_with(b"{") && !stl::is_binary(bytes) {
        Some(Format::Gltf)
    } else if text.starts_with(b"ply\n") || text.starts_with(b"ply\r") {
        Some(Format::Ply)
    } else if stl::is_text(bytes) {
        Some(Format::Stl)
    } else if off::is_off(text) {
        Some(Format::Off)
    } else {
        None
    }
}
