//! Files in memory, and the companions of a main file: buffers, materials and textures.

use greenstick_geometry::{Image, ImageSource};
use std::collections::BTreeSet;

/// Reads a companion of the main file (a `.bin`, a `.mtl`), given its reference relative to the main file. The caller
/// decides which references it allows (`../`, absolute paths).
pub type Resolve<'a> = &'a dyn Fn(&str) -> std::io::Result<Vec<u8>>;

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
pub fn embeddable_image_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some("image/png")
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else {
        None
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
