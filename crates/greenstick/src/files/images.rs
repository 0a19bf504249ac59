//! References to images in scenes that are written to another folder than they were read from.

use super::folder_of;
use super::read::companion;
use greenstick_formats::{embeddable_image_type, percent_decoded};
use greenstick_geometry::{ImageSource, Scene};
use std::fs;
use std::path::Path;

/// Keeps references to images valid when the scene, read from `source`, is written to `target`: if the folders differ,
/// images that exist are embedded in the scene. Images that do not exist stay references, and a note names each.
pub fn carry_images(scene: &mut Scene, source: &Path, target: &Path) {
    let folder = |path: &Path| fs::canonicalize(folder_of(path)).ok();
    let same = folder(source).is_some() && folder(source) == folder(target);
    for image in &mut scene.images {
        let ImageSource::Reference(reference) = &image.source else {
            continue;
        };
        if reference.is_empty() || reference.starts_with("data:") {
            continue;
        }
        let found = companion(source, &percent_decoded(reference))
            .or_else(|_| companion(source, reference));
        match found.and_then(|path| if same { Ok(Vec::new()) } else { fs::read(path) }) {
            Ok(_) if same => {}
            Ok(bytes) => {
                if let Some(mime_type) = embeddable_image_type(&bytes) {
                    image.mime_type = mime_type.to_owned();
                    if image.name.is_empty() {
                        let name = Path::new(reference).file_stem().unwrap_or_default();
                        image.name = name.to_string_lossy().into_owned();
                    }
                    image.source = ImageSource::Bytes(bytes);
                }
            }
            Err(error) => {
                let note = format!("texture {reference} remains a reference: {error}");
                if !scene.notes.contains(&note) {
                    scene.notes.push(note);
                }
            }
        }
    }
}
