//! Extensions that a document may require of its readers.

use crate::error::{FormatError, InFile};

/// Extensions that this reader supports, or can ignore without changing the geometry.
const SUPPORTED: [&str; 9] = [
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_lights_punctual",
];

/// Refuses extensions that a document requires and this reader does not support.
pub(super) fn check_required(required: &[String], file: InFile) -> Result<(), FormatError> {
    for name in required {
        if name == "KHR_draco_mesh_compression" {
            return Err(draco_error(file));
        }
        if !SUPPORTED.contains(&name.as_str()) && !name.starts_with("KHR_materials_") {
            return Err(file.unsupported(format!("the extension {name}"), "export without it"));
        }
    }
    Ok(())
}

/// The error for Draco compression.
pub(super) fn draco_error(file: InFile) -> FormatError {
    file.unsupported(
        "Draco compression (KHR_draco_mesh_compression)",
        "export it again without Draco; meshopt compression is supported",
    )
}
