//! References to images in scenes that are written to another folder than they were read from.

use super::folder_of;
use super::whole::{companion, read_bytes};
use greenstick_formats::percent_decoded;
use greenstick_geometry::{ImageSource, Scene};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Keeps references to images valid when the scene, read from `source`, is written to `target`: if the folders differ,
/// images that exist are embedded in the scene. Images that do not exist stay references, and a note names each.
pub fn carry_images(scene: &mut Scene, source: &Path, target: &Path) {
    let folder = |path: &Path| fs::canonicalize(folder_of(path)).ok();
    let same = folder(source).is_some() && folder(source) == folder(target);
    carry(scene, source, same);
}

/// Embeds the images that a scene, read from `source`, refers to, as [`carry_images`] does, so that pictures show them.
pub fn embed_images(scene: &mut Scene, source: &Path) {
    carry(scene, source, false);
}

/// Embeds images, or only notes which are missing where the `same` folder has them.
fn carry(scene: &mut Scene, source: &Path, same: bool) {
    greenstick_formats::embed_images(scene, &|reference| {
        let path = companion(source, reference)?;
        if same {
            Ok(Vec::new())
        } else {
            read_bytes(&path)
        }
    });
}

/// Returns the file of an image that a mesh file refers to.
fn image_file(source: &Path, reference: &str) -> io::Result<PathBuf> {
    companion(source, &percent_decoded(reference)).or_else(|_| companion(source, reference))
}

/// Returns the files of the images that a scene refers to, as far as they exist. They are not read, but nothing that is written
/// may take their place.
pub(super) fn image_files(scene: &Scene, source: &Path) -> Vec<PathBuf> {
    let references = scene.images.iter().filter_map(|image| match &image.source {
        ImageSource::Reference(reference) if !reference.starts_with("data:") => Some(reference),
        _ => None,
    });
    references
        .filter_map(|r| image_file(source, r).ok())
        .collect()
}
