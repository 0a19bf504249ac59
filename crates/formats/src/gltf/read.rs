//! Reading glTF: the document, what it requires, and the default scene's nodes.

use super::accessor::Source;
use super::schema::Document;
use super::{container, material, node};
use crate::Resolve;
use crate::error::{FormatError, InFile};
use greenstick_geometry::Scene;

/// Extensions that may be required of a reader and that this one knows, or can leave out without changing geometry.
const KNOWN: [&str; 9] = [
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

/// Reads glTF, as JSON or as GLB.
pub(crate) fn read(bytes: &[u8], name: &str, resolve: Resolve) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let (json, binary) = container::split(bytes, file)?;
    let document: Document = serde_json::from_slice(json).map_err(|e| match e.classify() {
        serde_json::error::Category::Eof => {
            file.truncated("JSON", e.to_string(), "a whole glTF document")
        }
        serde_json::error::Category::Data => {
            file.malformed("JSON", e.to_string(), "a glTF 2.0 document")
        }
        _ => FormatError::NotThisFormat {
            file: name.to_owned(),
            format: "glTF",
            found: format!("no JSON ({e})"),
            right: "JSON in UTF-8, or a GLB".to_owned(),
        },
    })?;
    check_version(&document, file)?;
    let mut scene = Scene::default();
    let source = Source::new(file, &document, binary, resolve);
    material::read(&source, &mut scene)?;
    node::read(&source, &mut scene)?;
    if !document.animations.is_empty() {
        scene.notes.push(format!(
            "{} animations were dropped.",
            document.animations.len()
        ));
    }
    Ok(scene)
}

fn check_version(document: &Document, file: InFile) -> Result<(), FormatError> {
    let Some(asset) = &document.asset else {
        return Err(FormatError::NotThisFormat {
            file: file.0.to_owned(),
            format: "glTF",
            found: "JSON without `asset`".to_owned(),
            right: "`\"asset\": {\"version\": \"2.0\"}`".to_owned(),
        });
    };
    if !asset.version.starts_with("2.") {
        let feature = format!("glTF version {}", asset.version);
        return Err(file.unsupported(feature, "save it as glTF 2.0"));
    }
    for name in &document.extensions_required {
        if name == "KHR_draco_mesh_compression" {
            return Err(draco(file));
        }
        if !KNOWN.contains(&name.as_str()) && !name.starts_with("KHR_materials_") {
            return Err(file.unsupported(format!("the extension {name}"), "export without it"));
        }
    }
    Ok(())
}

/// The error for Draco compression.
pub fn draco(file: InFile) -> FormatError {
    file.unsupported(
        "Draco compression (KHR_draco_mesh_compression)",
        "export it again without Draco; meshopt compression is read",
    )
}
