//! Files in memory, and the companions of a main file: buffers, materials and textures.

use crate::uri::percent_decoded;
use greenstick_geometry::{Image, ImageSource, Scene};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Reads a companion of the main file (a `.bin`, a `.mtl`), given its reference relative to the main file. The caller
/// decides which references it allows (`../`, absolute paths).
pub type Resolve<'a> = &'a dyn Fn(&str) -> std::io::Result<Vec<u8>>;

/// Why a reference to a companion is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RefusedReference {
    /// An address, or a path from the root of a file system.
    #[error("only references relative to the file are followed")]
    NotRelative,
    /// A reference to a folder.
    #[error("the reference names no file")]
    NoFile,
    /// A reference out of the folder of the file.
    #[error("the reference leaves the folder of the file that names it, which must be allowed")]
    Outside,
}

/// How far references may lead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Into the folder of the file.
    Folder,
    /// Up from that folder, too.
    Outside,
}

/// Returns the path of a companion as [`relative_reference`] does, and refuses those that lead farther than `reach`.
///
/// # Errors
/// [`RefusedReference`].
pub fn reference_within(reference: &str, reach: Reach) -> Result<PathBuf, RefusedReference> {
    let path = relative_reference(reference)?;
    let up = path.components().any(|c| c == Component::ParentDir);
    if up && reach == Reach::Folder {
        return Err(RefusedReference::Outside);
    }
    Ok(path)
}

/// Returns the path of a companion relative to the folder of the main file. References may leave that folder
/// (`../textures/bark.png`) but must be relative and name a file.
///
/// # Errors
/// [`RefusedReference`].
pub fn relative_reference(reference: &str) -> Result<PathBuf, RefusedReference> {
    // Files from Windows have backslashes, which names on other systems hardly ever have.
    let reference = reference.replace('\\', "/");
    let path = Path::new(&reference);
    let drive = reference.as_bytes().get(1) == Some(&b':');
    if reference.contains("://") || drive || path.is_absolute() {
        return Err(RefusedReference::NotRelative);
    }
    if path.components().all(|c| c == Component::CurDir) {
        return Err(RefusedReference::NoFile);
    }
    Ok(path.to_owned())
}

/// A file in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// File name without folders.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl Encoded {
    /// A file of this name and content.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Encoded {
            name: name.into(),
            bytes: bytes.into(),
        }
    }
}

/// The name of a file without folders and extension: `model` for `folder/model.glb`.
pub(crate) fn stem(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    if stem.is_empty() {
        "mesh".to_owned()
    } else {
        stem.to_owned()
    }
}

/// Names of companion files that are valid on every file system and distinct.
pub(crate) struct CompanionNames {
    taken: BTreeSet<String>,
    stem: String,
}

impl CompanionNames {
    /// Starts with the name of the main file.
    pub fn new(main_file: &str) -> Self {
        CompanionNames {
            taken: BTreeSet::new(),
            stem: stem(main_file),
        }
    }

    /// The name of the main file with another extension.
    pub fn with_extension(&mut self, extension: &str) -> String {
        let name = format!("{}.{extension}", self.stem);
        self.taken.insert(name.to_lowercase());
        name
    }

    /// A name for image number `number`.
    pub fn image(&mut self, image: &Image, number: usize, bytes: &[u8]) -> String {
        let safe = |text: &str| -> String {
            let is_safe = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
            text.chars()
                .map(|c| if is_safe(c) { c } else { '_' })
                .collect()
        };
        let extension = image_extension(&image_type(&image.mime_type, bytes));
        let stem = safe(&self.stem);
        let own = image.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let own = own.strip_suffix(&format!(".{extension}")).unwrap_or(own);
        let part = if own.is_empty() {
            format!("image{number}")
        } else {
            safe(own)
        };
        let mut name = format!("{stem}_{part}.{extension}");
        if !self.taken.insert(name.to_lowercase()) {
            name = format!("{stem}_{part}_{number}.{extension}");
            self.taken.insert(name.to_lowercase());
        }
        name
    }
}

/// Returns the paths of all images. Images that are embedded are added to `files`.
pub(crate) fn image_paths(
    images: &[Image],
    names: &mut CompanionNames,
    files: &mut Vec<Encoded>,
) -> Vec<String> {
    images
        .iter()
        .enumerate()
        .map(|(number, image)| match &image.source {
            ImageSource::Reference(path) => path.clone(),
            ImageSource::Bytes(bytes) => {
                let name = names.image(image, number, bytes);
                files.push(Encoded {
                    name: name.clone(),
                    bytes: bytes.clone(),
                });
                name
            }
        })
        .collect()
}

/// The media type of an image: that of its first bytes if they are known, else the stated one.
pub(crate) fn image_type(stated: &str, bytes: &[u8]) -> String {
    let found = if bytes.starts_with(b"\x89PNG") {
        "image/png"
    } else if bytes.starts_with(b"\xff\xd8") {
        "image/jpeg"
    } else if bytes.get(8..12) == Some(b"WEBP") {
        "image/webp"
    } else if bytes.starts_with(b"\xabKTX 20") {
        "image/ktx2"
    } else if stated.is_empty() {
        "image/png"
    } else {
        stated
    };
    found.to_owned()
}

/// The media type of an image that every reader of glTF supports, PNG or JPEG; `None` for others.
fn embeddable_image_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some("image/png")
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else {
        None
    }
}

/// Embeds the images that a scene refers to, as far as `find` has them by the reference as it stands or decoded, so that it can be written
/// anywhere. Others stay references, and a note names each that was not found.
pub fn embed_images(scene: &mut Scene, find: Resolve) {
    for image in &mut scene.images {
        let ImageSource::Reference(reference) = &image.source else {
            continue;
        };
        if reference.is_empty() || reference.starts_with("data:") {
            continue;
        }
        match find(&percent_decoded(reference)).or_else(|_| find(reference)) {
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
                let note = format!(
                    "the texture {reference} could not be read beside the mesh ({error}): what is written refers to it by the same name"
                );
                if !scene.notes.contains(&note) {
                    scene.notes.push(note);
                }
            }
        }
    }
}

/// The file extension of a media type.
fn image_extension(media_type: &str) -> &'static str {
    match media_type {
        "image/jpeg" => "jpg",
        "image/webp" => "webp",
        "image/ktx2" => "ktx2",
        "image/avif" => "avif",
        "image/png" => "png",
        _ => "bin",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_relative_and_name_a_file() {
        for followed in ["bark.png", "../bark.png", "..\\bark.png"] {
            assert!(relative_reference(followed).is_ok(), "{followed}");
        }
        let within = |reference| reference_within(reference, Reach::Folder);
        assert!(within("blocks/block.stl").is_ok());
        assert_eq!(within("a/../../block.stl"), Err(RefusedReference::Outside));
        for refused in ["/bark.png", "file:///bark.png", "C:/bark.png", ".", ""] {
            assert!(relative_reference(refused).is_err(), "{refused}");
        }
    }
}
