//! Writing materials, textures, samplers and images (§3.8, §3.9).

use super::builder::Builder;
use crate::check::Surfaces;
use crate::companions::{CompanionNames, image_type};
use crate::uri::escape;
use greenstick_geometry::{Image, ImageSource, Material, Texture, TextureReference};
use serde_json::{Map, Value, json};

/// A JSON number with the shortest decimal digits of an `f32`.
fn number(v: f32) -> Value {
    let shortest = zmij::Buffer::new().format(v).parse::<f64>().unwrap_or(0.0);
    json!(if shortest.is_finite() { shortest } else { 0.0 })
}

fn numbers(values: &[f32]) -> Value {
    values.iter().map(|&v| number(v)).collect()
}

/// The extension by which a texture refers to an image of this type; PNG and JPEG need none.
fn extension_for(media_type: &str) -> Option<&'static str> {
    match media_type {
        "image/webp" => Some("EXT_texture_webp"),
        "image/ktx2" => Some("KHR_texture_basisu"),
        "image/avif" => Some("EXT_texture_avif"),
        _ => None,
    }
}

/// Writes materials, textures, samplers and images. Images become companion files if `names` is given, and are embedded
/// otherwise.
pub(super) fn write(surfaces: Surfaces, builder: &mut Builder, names: Option<CompanionNames>) {
    let media_types = write_images(surfaces.images, builder, names);
    write_textures(surfaces.textures, &media_types, builder);
    for material in surfaces.materials {
        let out = write_material(material, builder);
        builder.push("materials", out);
    }
}

/// Writes images. Returns their media types.
fn write_images(
    images: &[Image],
    builder: &mut Builder,
    mut names: Option<CompanionNames>,
) -> Vec<String> {
    let mut types = Vec::new();
    for (number, image) in images.iter().enumerate() {
        let mut out = Map::new();
        if !image.name.is_empty() {
            out.insert("name".to_owned(), json!(image.name));
        }
        let mut media_type = image.mime_type.clone();
        match (&image.source, &mut names) {
            (ImageSource::Reference(path), _) => {
                out.insert("uri".to_owned(), json!(escape(path)));
            }
            (ImageSource::Bytes(bytes), Some(names)) => {
                let name = names.image(image, number, bytes);
                out.insert("uri".to_owned(), json!(escape(&name)));
                builder.add_companion(name, bytes.clone());
                media_type = image_type(&media_type, bytes);
            }
            (ImageSource::Bytes(bytes), None) => {
                let view = builder.view(bytes, None);
                out.insert("bufferView".to_owned(), json!(view));
                media_type = image_type(&media_type, bytes);
            }
        }
        // Core glTF does not allow the media type of KTX 2; a file extension makes it unnecessary.
        let has_extension = media_type == "image/ktx2"
            && out
                .get("uri")
                .and_then(Value::as_str)
                .is_some_and(|uri| uri.ends_with(".ktx2"));
        if !media_type.is_empty() && !has_extension {
            out.insert("mimeType".to_owned(), json!(media_type));
        }
        types.push(media_type);
        builder.push("images", Value::Object(out));
    }
    types
}

/// Writes textures and their samplers, given the media types of the images.
fn write_textures(textures: &[Texture], media_types: &[String], builder: &mut Builder) {
    let mut samplers = Vec::new();
    for texture in textures {
        let mut out = Map::new();
        if texture.sampler.iter().any(Option::is_some) {
            let known = samplers.iter().position(|s| *s == texture.sampler);
            let index = known.unwrap_or_else(|| {
                samplers.push(texture.sampler);
                let keys = ["magFilter", "minFilter", "wrapS", "wrapT"]
                    .iter()
                    .zip(texture.sampler);
                let set: Map<_, _> = keys
                    .filter_map(|(k, v)| Some(((*k).to_owned(), json!(v?))))
                    .collect();
                builder.push("samplers", Value::Object(set))
            });
            out.insert("sampler".to_owned(), json!(index));
        }
        let mut extensions = Map::new();
        for (name, image) in &texture.alternatives {
            extensions.insert(name.clone(), json!({ "source": image }));
        }
        let media_type = texture
            .image
            .and_then(|i| media_types.get(i))
            .map_or("", String::as_str);
        match (texture.image, extension_for(media_type)) {
            (Some(image), None) => {
                out.insert("source".to_owned(), json!(image));
            }
            (Some(image), Some(name)) if !extensions.contains_key(name) => {
                extensions.insert(name.to_owned(), json!({ "source": image }));
            }
            _ => {}
        }
        for name in extensions.keys() {
            // Without a fallback image, readers must support the extension.
            builder.declare_extension(name, !out.contains_key("source"));
        }
        if !extensions.is_empty() {
            out.insert("extensions".to_owned(), Value::Object(extensions));
        }
        builder.push("textures", Value::Object(out));
    }
}

/// Describes one material.
fn write_material(material: &Material, builder: &mut Builder) -> Value {
    let mut out = Map::new();
    let mut put = |key: &str, value: Value| {
        out.insert(key.to_owned(), value);
    };
    let unit = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
    if !material.name.is_empty() {
        put("name", json!(material.name));
    }
    let mut surface = Map::new();
    let color = material.base_color.map(unit);
    if color != [1.0; 4] {
        surface.insert("baseColorFactor".to_owned(), numbers(&color));
    }
    for (key, value) in [
        ("metallicFactor", material.metallic),
        ("roughnessFactor", material.roughness),
    ] {
        if unit(value) != 1.0 {
            surface.insert(key.to_owned(), number(unit(value)));
        }
    }
    for (key, texture) in [
        ("baseColorTexture", &material.base_color_texture),
        (
            "metallicRoughnessTexture",
            &material.metallic_roughness_texture,
        ),
    ] {
        if let Some(texture) = texture {
            surface.insert(key.to_owned(), reference(texture, None, builder));
        }
    }
    if !surface.is_empty() {
        put("pbrMetallicRoughness", Value::Object(surface));
    }
    for (key, texture, strength) in [
        ("normalTexture", &material.normal_texture, Some("scale")),
        (
            "occlusionTexture",
            &material.occlusion_texture,
            Some("strength"),
        ),
        ("emissiveTexture", &material.emissive_texture, None),
    ] {
        if let Some(texture) = texture {
            put(key, reference(texture, strength, builder));
        }
    }
    let emissive = material.emissive.map(unit);
    if emissive != [0.0; 3] {
        put("emissiveFactor", numbers(&emissive));
    }
    if matches!(material.alpha_mode.as_str(), "MASK" | "BLEND") {
        put("alphaMode", json!(material.alpha_mode));
    }
    if material.alpha_mode == "MASK" {
        put("alphaCutoff", number(material.alpha_cutoff.max(0.0)));
    }
    if material.double_sided {
        put("doubleSided", json!(true));
    }
    let mut extensions = Map::new();
    for (name, text) in &material.extensions {
        match serde_json::from_str::<Value>(text) {
            Ok(value) if name == "extras" => put("extras", value),
            Ok(value) => {
                builder.declare_extension(name, false);
                extensions.insert(name.clone(), value);
            }
            // Text that is not JSON, which no reader produces, cannot be written.
            Err(_) => {}
        }
    }
    if !extensions.is_empty() {
        put("extensions", Value::Object(extensions));
    }
    Value::Object(out)
}

/// Describes the use of a texture; `strength` is the key of its strength.
fn reference(texture: &TextureReference, strength: Option<&str>, builder: &mut Builder) -> Value {
    let mut out = Map::new();
    out.insert("index".to_owned(), json!(texture.texture));
    if texture.coordinates != 0 {
        out.insert("texCoord".to_owned(), json!(texture.coordinates));
    }
    if let Some(key) = strength.filter(|_| texture.strength != 1.0) {
        out.insert(key.to_owned(), number(texture.strength));
    }
    if let Some((offset, rotation, scale)) = &texture.transform {
        builder.declare_extension("KHR_texture_transform", false);
        let transform = json!({
            "offset": numbers(offset), "rotation": number(*rotation), "scale": numbers(scale)
        });
        out.insert(
            "extensions".to_owned(),
            json!({ "KHR_texture_transform": transform }),
        );
    }
    Value::Object(out)
}
