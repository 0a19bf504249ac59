//! Reading glTF documents.

use super::accessor::Source;
use super::extensions::check_required;
use super::schema::Document;
use super::{budget, container, material, node};
use crate::companions::Resolve;
use crate::error::{FormatError, InFile};
use greenstick_geometry::Scene;

/// Reads glTF, as JSON or GLB.
pub(crate) fn read(bytes: &[u8], name: &str, resolve: Resolve) -> Result<Scene, FormatError> {
    let file = InFile(name);
    let (json, binary) = container::split(bytes, file)?;
    budget::check_json(json, file)?;
    let document: Document = serde_json::from_slice(json).map_err(|e| match e.classify() {
        serde_json::error::Category::Eof => {
            file.truncated("JSON", e.to_string(), "a complete glTF document")
        }
        serde_json::error::Category::Data => {
            file.malformed("JSON", e.to_string(), "a glTF 2.0 document")
        }
        _ => FormatError::NotThisFormat {
            file: name.to_owned(),
            format: "glTF",
            found: format!("the content is not JSON ({e})"),
            right: "JSON in UTF-8, or a GLB".to_owned(),
        },
    })?;
    check_version(&document, file)?;
    check_required(&document.extensions_required, file)?;
    let mut scene = Scene::default();
    let source = Source::new(file, &document, binary, resolve);
    budget::check(&source, bytes.len())?;
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

/// Refuses other versions than 2.
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
    Ok(())
}
