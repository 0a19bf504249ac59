//! Reading materials, textures, samplers and images (§3.8, §3.9).

use super::accessor::Source;
use super::container;
use super::schema::{Material as MaterialJson, TextureInfo, Transform};
use crate::error::FormatError;
use greenstick_geometry::{Image, ImageSource, Material, Scene, Texture, TextureReference};

/// Reads materials, textures, samplers and images, in the order of the file.
pub(super) fn read(source: &Source, scene: &mut Scene) -> Result<(), FormatError> {
    let document = source.document;
    for (index, image) in document.images.iter().enumerate() {
        let mut mime_type = image.mime_type.clone().unwrap_or_default();
        let data = match (&image.uri, image.buffer_view) {
            (_, Some(view)) => {
                let (bytes, _) = source.view(view)?;
                source.charge(bytes.len(), &format!("images[{index}]"))?;
                ImageSource::Bytes(bytes.to_vec())
            }
            (Some(uri), _) => match container::data_uri(uri) {
                Some(Ok((stated, bytes))) => {
                    mime_type = if mime_type.is_empty() {
                        stated
                    } else {
                        mime_type
                    };
                    ImageSource::Bytes(bytes)
                }
                Some(Err(found)) => {
                    let place = format!("images[{index}]");
                    return Err(source.file.malformed(place, found, "base64"));
                }
                None => {
                    if mime_type.is_empty() && uri.ends_with(".ktx2") {
                        mime_type = "image/ktx2".to_owned();
                    }
                    ImageSource::Reference(uri.clone())
                }
            },
            (None, None) => ImageSource::Reference(String::new()),
        };
        scene.images.push(Image {
            name: image.name.clone(),
            mime_type,
            source: data,
        });
    }
    let images = scene.images.len();
    for (index, texture) in document.textures.iter().enumerate() {
        let place = || format!("textures[{index}]");
        let check = |image: usize| {
            if image < images {
                return Ok(image);
            }
            let right = format!("a number below {images}");
            Err(source
                .file
                .malformed(place(), format!("image {image}"), right))
        };
        let mut alternatives = Vec::new();
        for (name, extension) in &texture.extensions {
            if let Some(image) = extension.get("source").and_then(serde_json::Value::as_u64) {
                alternatives.push((name.clone(), check(image as usize)?));
            }
        }
        let sampler = match texture.sampler.map(|s| document.samplers.get(s)) {
            Some(None) => {
                let right = format!("a number below {}", document.samplers.len());
                return Err(source.file.malformed(
                    place(),
                    "it refers to a sampler that does not exist",
                    right,
                ));
            }
            Some(Some(s)) => [s.mag_filter, s.min_filter, s.wrap_s, s.wrap_t],
            None => [None; 4],
        };
        let image = texture.source.map(check).transpose()?;
        scene.textures.push(Texture {
            image,
            alternatives,
            sampler,
        });
    }
    for (index, json) in document.materials.iter().enumerate() {
        scene.materials.push(read_material(source, json, index)?);
    }
    Ok(())
}

/// Reads one material.
fn read_material(
    source: &Source,
    json: &MaterialJson,
    index: usize,
) -> Result<Material, FormatError> {
    let reference = |info: &Option<TextureInfo>| -> Result<Option<TextureReference>, FormatError> {
        let Some(info) = info else { return Ok(None) };
        let textures = source.document.textures.len();
        if info.index >= textures {
            let place = format!("materials[{index}]");
            let right = format!("a number below {textures}");
            return Err(source
                .file
                .malformed(place, format!("texture {}", info.index), right));
        }
        let transform = info
            .extensions
            .get("KHR_texture_transform")
            .and_then(|v| serde_json::from_value::<Transform>(v.clone()).ok());
        Ok(Some(TextureReference {
            texture: info.index,
            coordinates: transform
                .as_ref()
                .and_then(|t| t.tex_coord)
                .unwrap_or(info.tex_coord),
            transform: transform.map(|t| {
                let scale = t.scale.unwrap_or([1.0, 1.0]);
                (
                    t.offset.unwrap_or_default(),
                    t.rotation.unwrap_or(0.0),
                    scale,
                )
            }),
            strength: info.scale.or(info.strength).unwrap_or(1.0),
        }))
    };
    let surface = &json.pbr_metallic_roughness;
    let mut extensions: Vec<(String, String)> = json
        .extensions
        .iter()
        .map(|(name, value)| (name.clone(), value.to_string()))
        .collect();
    extensions.extend(
        json.extras
            .iter()
            .map(|value| ("extras".to_owned(), value.to_string())),
    );
    Ok(Material {
        name: json.name.clone(),
        base_color: surface.base_color_factor.unwrap_or([1.0; 4]),
        metallic: surface.metallic_factor.unwrap_or(1.0),
        roughness: surface.roughness_factor.unwrap_or(1.0),
        emissive: json.emissive_factor,
        base_color_texture: reference(&surface.base_color_texture)?,
        metallic_roughness_texture: reference(&surface.metallic_roughness_texture)?,
        normal_texture: reference(&json.normal_texture)?,
        occlusion_texture: reference(&json.occlusion_texture)?,
        emissive_texture: reference(&json.emissive_texture)?,
        double_sided: json.double_sided,
        alpha_mode: json
            .alpha_mode
            .clone()
            .unwrap_or_else(|| "OPAQUE".to_owned()),
        alpha_cutoff: json.alpha_cutoff.unwrap_or(0.5),
        extensions,
    })
}
