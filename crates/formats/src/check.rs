//! Validation of scenes before they are written.

use crate::error::{FormatError, InFile};
use greenstick_geometry::{Film, Image, Material, Mesh, Node, Scene, Texture, TextureReference};

/// Refuses invalid scenes, so that writers can index freely.
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

/// Refuses an invalid mesh.
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
        let valid_width = match key.as_str() {
            "NORMAL" => attribute.width == 3,
            "TANGENT" => attribute.width == 4,
            _ => attribute.width > 0,
        };
        if !valid_width || attribute.data.len() != attribute.width * vertices {
            return Err(file.unwritable(
                format!(
                    "attribute {key} of {} has {} numbers with width {}",
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

/// The appearance of surfaces: materials with their textures and images.
#[derive(Clone, Copy)]
pub(crate) struct Surfaces<'a> {
    pub materials: &'a [Material],
    pub textures: &'a [Texture],
    pub images: &'a [Image],
}

impl<'a> Surfaces<'a> {
    /// The surfaces of a scene.
    pub fn from_scene(scene: &'a Scene) -> Self {
        Surfaces {
            materials: &scene.materials,
            textures: &scene.textures,
            images: &scene.images,
        }
    }

    /// The surfaces of a film.
    pub fn from_film(film: &'a Film) -> Self {
        Surfaces {
            materials: &film.materials,
            textures: &film.textures,
            images: &film.images,
        }
    }

    /// Refuses indices of materials, textures and images that do not exist.
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
        let fault = if textures.any(|t| t.texture >= self.textures.len()) {
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
        Err(file.unwritable(fault, "indices into the lists of the scene"))
    }
}

/// The textures that a material uses.
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
