//! Writing materials, textures, samplers and images (§3.8, §3.9).

use super::container::escape;
use super::write::Builder;
use crate::assemble::{CompanionNames, Surfaces, image_type};
use greenstick_geometry::{ImageSource, Material, TextureReference};
use serde_json::{Map, Value, json};

/// A JSON number that shows an `f32` by its shortest decimal.
fn number(v: f32) -> Value {
    let shortest = zmij::Buffer::new().format(v).parse::<f64>().unwrap_or(0.0);
    json!(if shortest.is_finite() { shortest } else { 0.0 })
}

fn numbers(values: &[f32]) -> Value {
    values.iter().map(|&v| number(v)).collect()
}

/// Extensions by which a texture names an image of this type; PNG and JPEG need none.
fn extension_for(media_type: &str) -> Option<&'static str> {
    match media_type {
        "image/webp" => Some("EXT_texture_webp"),
        "image/ktx2" => Some("KHR_texture_basisu"),
        "image/avif" => Some("EXT_texture_avif"),
        _ => None,
    }
}

/// Writes all of them; `names` where images are to be files of their own.
pub fn write(surfaces: Surfaces, builder: &mut Builder, mut names: Option<CompanionNames>) {
    let mut types = Vec::new();
    for (number, image) in surfaces.images.iter().enumerate() {
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
                builder.companion(name, bytes.clone());
                media_type = image_type(&media_type, bytes);
            }
            (ImageSource::Bytes(bytes), None) => {
                let view = builder.view(bytes, None);
                out.insert("bufferView".to_owned(), json!(view));
                media_type = image_type(&media_type, bytes);
            }
        }
        // The core of glTF knows no KTX 2; beside a file's ending the type is not needed.
        let from_ending = media_type == "image/ktx2"
            && out
                .get("uri")
                .and_then(Value::as_str)
                .is_some_and(|uri| uri.ends_with(".ktx2"));
        if !media_type.is_empty() && !from_ending {
            out.insert("mimeType".to_owned(), json!(media_type));
        }
        types.push(media_type);
        builder.push("images", Value::Object(out));
    }
    let mut samplers = Vec::new();
    for texture in surfaces.textures {
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
            .and_then(|i| types.get(i))
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
            // Without a plain image to fall back on, a reader has to know the extension.
            builder.uses(name, !out.contains_key("source"));
        }
        if !extensions.is_empty() {
            out.insert("extensions".to_owned(), Value::Object(extensions));
        }
        builder.push("textures", Value::Object(out));
    }
    for material in surfaces.materials {
        let out = write_material(material, builder);
        builder.push("materials", out);
    }
}

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
                builder.uses(name, false);
                extensions.insert(name.clone(), value);
            }
            // Only other code than the reader's can have put text here that is no JSON; it cannot be written.
            Err(_) => {}
        }
    }
    if !extensions.is_empty() {
        put("extensions", Value::Object(extensions));
    }
    Value::Object(out)
}

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
        builder.uses("KHR_texture_transform", false);
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
