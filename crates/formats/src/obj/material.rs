//! MTL: materials of OBJ files in the Phong model, with the extension for metalness and roughness (`Pm`, `Pr`).
//!
//! Statements without equivalent in a [`Material`] (`Ka`, `Ks`, `Ns` …) are preserved as `extras.mtl`.

use crate::text::{lines, number, push_number, tokens};
use greenstick_geometry::{Image, ImageSource, Material, Scene, Texture, TextureReference};
use serde_json::{Map, Value, json};

/// Statements that are preserved verbatim.
const PRESERVED: [&str; 10] = [
    "Ka", "Ks", "Ns", "Ni", "illum", "Tf", "map_Ka", "map_Ks", "map_Ns", "map_d",
];

/// Name that stands for no material, unless a library defines it.
pub(super) const NO_MATERIAL_NAME: &str = "none";

/// The numbers at the start of some words.
fn floats(words: &[&[u8]]) -> Vec<f32> {
    words
        .iter()
        .map_while(|w| number(w))
        .filter(|v: &f32| v.is_finite())
        .collect()
}

/// Adds the materials of an MTL file to the scene.
pub(super) fn read(bytes: &[u8], scene: &mut Scene) {
    let mut preserved: Map<String, Value> = Map::new();
    let mut material: Option<Material> = None;
    for (_, line) in lines(bytes) {
        let words: Vec<&[u8]> = tokens(line).collect();
        let Some((keyword, rest)) = words.split_first() else {
            continue;
        };
        let text = String::from_utf8_lossy(&rest.join(&b' ')).into_owned();
        if *keyword == b"newmtl" {
            finish(
                material.replace(default_material(text)),
                &mut preserved,
                scene,
            );
            continue;
        }
        let Some(m) = material.as_mut() else { continue };
        let values = floats(rest);
        match (*keyword, values.as_slice()) {
            (b"Kd", &[r, g, b, ..]) => m.base_color[..3].copy_from_slice(&[r, g, b]),
            (b"Ke", &[r, g, b, ..]) => m.emissive = [r, g, b],
            (b"d", &[d, ..]) => m.base_color[3] = d,
            (b"Tr", &[t, ..]) => m.base_color[3] = 1.0 - t,
            (b"Pr", &[v, ..]) => m.roughness = v,
            (b"Pm", &[v, ..]) => m.metallic = v,
            (b"map_Kd", _) => m.base_color_texture = texture(rest, scene),
            (b"map_Ke", _) => m.emissive_texture = texture(rest, scene),
            (b"map_Pr", _) => m.metallic_roughness_texture = texture(rest, scene),
            (b"norm" | b"map_Bump" | b"map_bump" | b"bump", _) => {
                m.normal_texture = texture(rest, scene);
            }
            _ => {
                let keyword = String::from_utf8_lossy(keyword).into_owned();
                if PRESERVED.contains(&keyword.as_str()) {
                    preserved.insert(keyword, json!(text));
                }
            }
        }
        if let (b"Ns", &[shininess, ..]) = (*keyword, values.as_slice()) {
            // Matches the width of the highlight (Walter et al. 2007, the relation α² = 2/(Ns + 2) between Beckmann and Phong);
            // roughness is √α by §B.3 of glTF. A `Pr` that follows takes precedence.
            m.roughness = (2.0 / (shininess.max(0.0) + 2.0)).powf(0.25);
        }
    }
    finish(material, &mut preserved, scene);
}

/// A material without any statement. The default of MTL is grey.
pub(super) fn default_material(name: String) -> Material {
    Material {
        name,
        base_color: [0.8, 0.8, 0.8, 1.0],
        ..Material::default()
    }
}

/// Adds a material with its preserved statements to the scene.
fn finish(material: Option<Material>, preserved: &mut Map<String, Value>, scene: &mut Scene) {
    let Some(mut material) = material else { return };
    if material.base_color[3] < 1.0 {
        material.alpha_mode = "BLEND".to_owned();
    }
    if !preserved.is_empty() {
        let extras = json!({ "mtl": std::mem::take(preserved) });
        material
            .extensions
            .push(("extras".to_owned(), extras.to_string()));
    }
    scene.materials.push(material);
}

/// Parses a texture statement: options, then a path that may contain spaces.
fn texture(words: &[&[u8]], scene: &mut Scene) -> Option<TextureReference> {
    let mut rest = words;
    let mut strength = 1.0;
    let (mut scale, mut offset) = ([1.0, 1.0], [0.0, 0.0]);
    let mut has_transform = false;
    while let Some((option, after)) = rest.split_first().filter(|(w, _)| w.starts_with(b"-")) {
        let values = floats(&after[..after.len().min(3)]);
        let used = match *option {
            b"-s" | b"-o" => {
                has_transform = true;
                let target = if *option == b"-s" {
                    &mut scale
                } else {
                    &mut offset
                };
                for (slot, value) in target.iter_mut().zip(&values) {
                    *slot = *value;
                }
                values.len()
            }
            b"-bm" => {
                strength = values.first().copied().unwrap_or(1.0);
                1
            }
            b"-mm" => 2,
            b"-t" => values.len(),
            _ => 1,
        };
        // The last word is the path, however many values the options take.
        rest = &after[used.min(after.len().saturating_sub(1))..];
    }
    let path = String::from_utf8_lossy(&rest.join(&b' ')).into_owned();
    if path.is_empty() {
        return None;
    }
    let reference = ImageSource::Reference(path);
    let image = scene
        .images
        .iter()
        .position(|i| i.source == reference)
        .unwrap_or_else(|| {
            let empty = String::new();
            scene.images.push(Image {
                name: empty.clone(),
                mime_type: empty,
                source: reference,
            });
            scene.images.len() - 1
        });
    let texture = scene
        .textures
        .iter()
        .position(|t| t.image == Some(image))
        .unwrap_or_else(|| {
            let alternatives = Vec::new();
            scene.textures.push(Texture {
                image: Some(image),
                alternatives,
                sampler: [None; 4],
            });
            scene.textures.len() - 1
        });
    // v points up in OBJ and down in glTF: 1 − v′ = s·(1 − v) + o.
    let transform = has_transform.then_some(([offset[0], 1.0 - scale[1] - offset[1]], 0.0, scale));
    Some(TextureReference {
        texture,
        coordinates: 0,
        transform,
        strength,
    })
}

/// The names under which materials are written: not empty, distinct, and without spaces.
pub(super) fn names(scene: &Scene) -> Vec<String> {
    let mut taken = std::collections::BTreeSet::new();
    let mut out = Vec::with_capacity(scene.materials.len());
    for (number, material) in scene.materials.iter().enumerate() {
        let is_space = |c: char| c.is_whitespace() || c.is_control();
        let mut name = material.name.replace(is_space, "_");
        if name.is_empty() || !taken.insert(name.clone()) {
            name = format!("{name}_{number}");
            taken.insert(name.clone());
        }
        out.push(name);
    }
    out
}

/// Writes the MTL file; `paths` are those of the images.
pub(super) fn write(scene: &Scene, names: &[String], paths: &[String]) -> Vec<u8> {
    let mut out = b"# by Greenstick\n".to_vec();
    let mut buffer = zmij::Buffer::new();
    let mut put = |out: &mut Vec<u8>, keyword: &str, values: &[f32]| {
        out.extend_from_slice(keyword.as_bytes());
        for &v in values {
            out.push(b' ');
            push_number(out, &mut buffer, if v.is_finite() { v } else { 0.0 });
        }
        out.push(b'\n');
    };
    for (material, name) in scene.materials.iter().zip(names) {
        out.extend_from_slice(format!("\nnewmtl {name}\n").as_bytes());
        for Statement { keyword, text } in preserved_statements(material) {
            out.extend_from_slice(format!("{keyword} {text}\n").as_bytes());
        }
        put(&mut out, "Kd", &material.base_color[..3]);
        put(&mut out, "d", &material.base_color[3..]);
        put(&mut out, "Pr", &[material.roughness]);
        put(&mut out, "Pm", &[material.metallic]);
        if material.emissive != [0.0; 3] {
            put(&mut out, "Ke", &material.emissive);
        }
        for (keyword, texture) in [
            ("map_Kd", &material.base_color_texture),
            ("map_Pr", &material.metallic_roughness_texture),
            ("norm", &material.normal_texture),
            ("map_Ke", &material.emissive_texture),
        ] {
            let Some(reference) = texture else { continue };
            let Some(texture) = scene.textures.get(reference.texture) else {
                continue;
            };
            let image = texture.image.or(texture.alternatives.first().map(|a| a.1));
            let Some(path) = image.and_then(|i| paths.get(i)) else {
                continue;
            };
            let mut options = String::new();
            if keyword == "norm" && reference.strength != 1.0 {
                options += &format!("-bm {} ", reference.strength);
            }
            if let Some((offset, _, scale)) = reference.transform {
                let up = 1.0 - scale[1] - offset[1];
                options += &format!("-s {} {} 1 -o {} {up} 0 ", scale[0], scale[1], offset[0]);
            }
            let path = path.replace(char::is_control, "_");
            out.extend_from_slice(format!("{keyword} {options}{path}\n").as_bytes());
        }
    }
    out
}

/// A statement that is preserved verbatim.
struct Statement {
    keyword: String,
    text: String,
}

/// The preserved statements of a material.
fn preserved_statements(material: &Material) -> Vec<Statement> {
    let extras = material
        .extensions
        .iter()
        .find(|(name, _)| name == "extras");
    let value: Value = extras
        .and_then(|(_, t)| serde_json::from_str(t).ok())
        .unwrap_or_default();
    let Some(statements) = value["mtl"].as_object() else {
        return Vec::new();
    };
    statements
        .iter()
        .filter(|(keyword, _)| PRESERVED.contains(&keyword.as_str()))
        .filter_map(|(keyword, value)| {
            Some(Statement {
                keyword: keyword.clone(),
                text: value.as_str()?.replace(char::is_control, " "),
            })
        })
        .collect()
}
