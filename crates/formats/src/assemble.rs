//! Steps that several formats share: checking scenes, taking meshes apart, placing them in the world.

use crate::error::{FormatError, InFile};
use crate::{Encoded, LengthUnit, stem};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{
    Attribute, Film, Image, ImageSource, Material, Mesh, Node, Scene, Texture, TextureReference,
};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Refuses scenes that break their own rules, so that writers can index freely.
pub(crate) fn check_scene(scene: &Scene, name: &str) -> Result<(), FormatError> {
    let file = InFile(name);
    if scene
        .nodes
        .iter()
        .all(|node| node.mesh.triangles.is_empty())
    {
        return Err(file.unwritable("the scene has no triangles", "at least one triangle"));
    }
    for (number, node) in scene.nodes.iter().enumerate() {
        let place = || format!("node {number} ({})", node.name);
        check_mesh(&node.mesh, &place, file)?;
        check_transform(node, &place, file)?;
    }
    Ok(())
}

/// Refuses a transform that is not finite.
pub(crate) fn check_transform(
    node: &Node,
    place: &dyn Fn() -> String,
    file: InFile,
) -> Result<(), FormatError> {
    if node.transform.is_finite() {
        return Ok(());
    }
    Err(file.unwritable(
        format!("the transform of {} is not finite", place()),
        "finite numbers",
    ))
}

/// Refuses a mesh that breaks its own rules.
pub(crate) fn check_mesh(
    mesh: &Mesh,
    place: &dyn Fn() -> String,
    file: InFile,
) -> Result<(), FormatError> {
    let vertices = mesh.positions.len();
    let outside = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertices);
    if let Some(t) = mesh.triangles.iter().position(outside) {
        return Err(file.unwritable(
            format!("triangle {t} of {} is {:?}", place(), mesh.triangles[t]),
            format!("indices below the {vertices} vertices"),
        ));
    }
    if let Some(v) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(file.unwritable(
            format!("vertex {v} of {} lies at {}", place(), mesh.positions[v]),
            "finite coordinates",
        ));
    }
    for (key, attribute) in &mesh.attributes {
        let right_width = match key.as_str() {
            "NORMAL" => attribute.width == 3,
            "TANGENT" => attribute.width == 4,
            _ => attribute.width > 0,
        };
        if !right_width || attribute.data.len() != attribute.width * vertices {
            return Err(file.unwritable(
                format!(
                    "attribute {key} of {} has {} numbers of width {}",
                    place(),
                    attribute.data.len(),
                    attribute.width
                ),
                format!("one entry for each of the {vertices} vertices"),
            ));
        }
    }
    if !mesh.materials.is_empty() && mesh.materials.len() != mesh.triangles.len() {
        return Err(file.unwritable(
            format!(
                "{} has materials for {} triangles",
                place(),
                mesh.materials.len()
            ),
            format!(
                "one for each of the {} triangles or none",
                mesh.triangles.len()
            ),
        ));
    }
    Ok(())
}

/// How surfaces look: materials with what they need.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<'a> {
    pub materials: &'a [Material],
    pub textures: &'a [Texture],
    pub images: &'a [Image],
}

impl<'a> Surfaces<'a> {
    /// Those of a scene.
    pub fn of(scene: &'a Scene) -> Self {
        Surfaces {
            materials: &scene.materials,
            textures: &scene.textures,
            images: &scene.images,
        }
    }

    /// Those of a film.
    pub fn of_film(film: &'a Film) -> Self {
        Surfaces {
            materials: &film.materials,
            textures: &film.textures,
            images: &film.images,
        }
    }

    /// Refuses indices of materials, textures and images that point nowhere.
    pub fn check<'m>(
        &self,
        meshes: impl Iterator<Item = &'m Mesh>,
        file: InFile,
    ) -> Result<(), FormatError> {
        let mut textures = self.materials.iter().flat_map(textures_of);
        let images = |t: &Texture| {
            let others = t.alternatives.iter().map(|a| a.1);
            t.image.into_iter().chain(others).collect::<Vec<_>>()
        };
        let (count, none) = (self.materials.len(), u32::MAX);
        let mut used = meshes.flat_map(|m| &m.materials);
        let broken = if textures.any(|t| t.texture >= self.textures.len()) {
            "a material names a texture that does not exist"
        } else if self
            .textures
            .iter()
            .flat_map(images)
            .any(|i| i >= self.images.len())
        {
            "a texture names an image that does not exist"
        } else if used.any(|&m| m != none && m as usize >= count) {
            "a triangle names a material that does not exist"
        } else {
            return Ok(());
        };
        Err(file.unwritable(broken, "indices into the scene's own lists"))
    }
}

/// The textures a material uses.
pub(crate) fn textures_of(material: &Material) -> impl Iterator<Item = &TextureReference> {
    [
        &material.base_color_texture,
        &material.metallic_roughness_texture,
        &material.normal_texture,
        &material.occlusion_texture,
        &material.emissive_texture,
    ]
    .into_iter()
    .flatten()
}

/// Replaces numbers that are not finite by zero, with a note.
pub(crate) fn clean_attributes(mesh: &mut Mesh, notes: &mut Vec<String>) {
    for (name, attribute) in &mut mesh.attributes {
        let mut cleaned = 0;
        for v in attribute.data.iter_mut().filter(|v| !v.is_finite()) {
            *v = 0.0;
            cleaned += 1;
        }
        if cleaned > 0 {
            notes.push(format!(
                "{cleaned} values of {name} were not finite and became 0."
            ));
        }
    }
}

/// Vertices that `triangles` use, ascending, and the triangles in those new numbers. `slots` is work space of
/// one `u32::MAX` for each vertex and is left as it was.
pub(crate) fn compact(
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
    slots: &mut [u32],
) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut used = Vec::new();
    for i in triangles.clone().flatten() {
        if slots[i as usize] == u32::MAX {
            slots[i as usize] = 0;
            used.push(i);
        }
    }
    used.sort_unstable();
    for (new, &old) in used.iter().enumerate() {
        slots[old as usize] = new as u32;
    }
    let renumbered = triangles.map(|t| t.map(|i| slots[i as usize])).collect();
    for &old in &used {
        slots[old as usize] = u32::MAX;
    }
    (used, renumbered)
}

/// The values of an attribute at the vertices `used`.
pub(crate) fn gather(attribute: &Attribute, used: &[u32]) -> Vec<f32> {
    let mut data = Vec::with_capacity(used.len() * attribute.width);
    for &i in used {
        data.extend_from_slice(attribute.at(i as usize));
    }
    data
}

/// The part of `mesh` that consists of the given triangles.
pub(crate) fn extract(mesh: &Mesh, triangles: &[u32], slots: &mut [u32]) -> Mesh {
    let (used, renumbered) = compact(triangles.iter().map(|&t| mesh.triangles[t as usize]), slots);
    Mesh {
        positions: used.iter().map(|&i| mesh.positions[i as usize]).collect(),
        triangles: renumbered,
        attributes: mesh
            .attributes
            .iter()
            .map(|(name, a)| {
                (
                    name.clone(),
                    Attribute {
                        width: a.width,
                        data: gather(a, &used),
                    },
                )
            })
            .collect(),
        materials: if mesh.materials.is_empty() {
            Vec::new()
        } else {
            triangles
                .iter()
                .map(|&t| mesh.material(t as usize))
                .collect()
        },
    }
}

/// The node's mesh in the world, in `unit`.
pub(crate) fn in_world(node: &Node, unit: LengthUnit) -> Cow<'_, Mesh> {
    let map = DAffine3::from_scale(DVec3::splat(unit.per_metre())) * node.transform;
    // A file in millimetres that is written in millimetres keeps its numbers: 0.001 · 1000 may miss 1 by an ulp.
    if map.abs_diff_eq(DAffine3::IDENTITY, 1e-14) {
        Cow::Borrowed(&node.mesh)
    } else {
        Cow::Owned(node.mesh.transformed(&map))
    }
}

/// A position as it goes to a file.
pub(crate) fn narrow(p: DVec3, file: InFile) -> Result<[f32; 3], FormatError> {
    let q = p.as_vec3();
    if q.is_finite() {
        return Ok(q.to_array());
    }
    Err(file.unwritable(
        format!("a vertex lies at {p}"),
        "coordinates that fit 32-bit floating point numbers",
    ))
}

/// Names for companion files that are safe on every file system and different from one another.
pub(crate) struct CompanionNames {
    taken: BTreeSet<String>,
    stem: String,
}

impl CompanionNames {
    pub fn new(main_file: &str) -> Self {
        CompanionNames {
            taken: BTreeSet::new(),
            stem: stem(main_file),
        }
    }

    /// The main file's name with another ending.
    pub fn beside(&mut self, ending: &str) -> String {
        let name = format!("{}.{ending}", self.stem);
        self.taken.insert(name.to_lowercase());
        name
    }

    /// A name for image number `number`.
    pub fn image(&mut self, image: &Image, number: usize, bytes: &[u8]) -> String {
        let safe = |text: &str| -> String {
            let keep = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
            text.chars()
                .map(|c| if keep(c) { c } else { '_' })
                .collect()
        };
        let ending = image_ending(&image_type(&image.mime_type, bytes));
        let stem = safe(&self.stem);
        let own = image.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let own = own.strip_suffix(&format!(".{ending}")).unwrap_or(own);
        let part = if own.is_empty() {
            format!("image{number}")
        } else {
            safe(own)
        };
        let mut name = format!("{stem}_{part}.{ending}");
        if !self.taken.insert(name.to_lowercase()) {
            name = format!("{stem}_{part}_{number}.{ending}");
            self.taken.insert(name.to_lowercase());
        }
        name
    }
}

/// References to all images, with the files for those that carry their bytes.
pub(crate) fn externalise(
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

/// The image's media type; where it is not stated, what its first bytes say.
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

fn image_ending(media_type: &str) -> &'static str {
    match media_type {
        "image/jpeg" => "jpg",
        "image/webp" => "webp",
        "image/ktx2" => "ktx2",
        "image/avif" => "avif",
        "image/png" => "png",
        _ => "bin",
    }
}
