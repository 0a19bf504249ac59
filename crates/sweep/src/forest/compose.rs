//! Taking nodes out of a scene with the materials, textures and images that they use, and adding a scene to another, where
//! what both have is kept once.

use greenstick::geometry::mesh::NO_MATERIAL;
use greenstick::geometry::{Material, Mesh, Scene, Texture, TextureReference};
use serde_json::Value;
use std::collections::BTreeMap;

/// Extensions of materials that name no textures: glTF's place for what programs add of their own.
const EXTRAS: &str = "extras";

/// Returns some nodes of a scene, and of the rest only what they use. Parents that are not among them are left out.
pub fn part(scene: &Scene, nodes: &[usize]) -> Scene {
    let mut nodes: Vec<_> = nodes
        .iter()
        .map(|&old| {
            let mut node = scene.nodes[old].clone();
            node.parent = (node.parent).and_then(|parent| nodes.iter().position(|&n| n == parent));
            node
        })
        .collect();
    let used = nodes.iter().flat_map(|node| &node.mesh.materials);
    let materials = numbered(used.filter(|m| **m != NO_MATERIAL).map(|m| *m as usize));
    let mut part = Scene {
        materials: chosen(&scene.materials, &materials),
        ..Scene::default()
    };
    let mut used = Vec::new();
    for material in &mut part.materials {
        each_texture(material, &mut |texture| {
            used.push(texture);
            texture
        });
    }
    let textures = numbered(used.into_iter());
    for material in &mut part.materials {
        each_texture(material, &mut |old| new_number(&textures, old));
    }
    part.textures = chosen(&scene.textures, &textures);
    let images = numbered(part.textures.iter().flat_map(images_of));
    part.images = chosen(&scene.images, &images);
    for texture in &mut part.textures {
        each_image(texture, |old| new_number(&images, old));
    }
    part.nodes.append(&mut nodes);
    renumber_materials(&mut part, |old| new_number(&materials, old));
    part
}

/// Adds a scene to another. Nodes that nothing carries become those of `parent`. Materials, textures and images that are there
/// already are not added again.
pub fn append(scene: &mut Scene, mut other: Scene, parent: Option<usize>) {
    let images = added(&mut scene.images, std::mem::take(&mut other.images));
    for texture in &mut other.textures {
        each_image(texture, |old| images.get(old).copied().unwrap_or(old));
    }
    let textures = added(&mut scene.textures, std::mem::take(&mut other.textures));
    for material in &mut other.materials {
        each_texture(material, &mut |old| {
            textures.get(old).copied().unwrap_or(old)
        });
    }
    let materials = added(&mut scene.materials, std::mem::take(&mut other.materials));
    renumber_materials(&mut other, |old| materials.get(old).copied().unwrap_or(old));
    let first = scene.nodes.len();
    for mut node in other.nodes {
        node.parent = node.parent.map(|own| own + first).or(parent);
        scene.nodes.push(node);
    }
}

/// New numbers of what is used, in the order of the old ones.
fn numbered(used: impl Iterator<Item = usize>) -> BTreeMap<usize, usize> {
    let mut numbers: BTreeMap<usize, usize> = used.map(|old| (old, 0)).collect();
    for (new, number) in numbers.values_mut().enumerate() {
        *number = new;
    }
    numbers
}

/// The new number of what had an old one. What does not exist has none, and stays what it was.
fn new_number(numbers: &BTreeMap<usize, usize>, old: usize) -> usize {
    numbers.get(&old).copied().unwrap_or(old)
}

/// The values that have numbers.
fn chosen<T: Clone>(all: &[T], numbers: &BTreeMap<usize, usize>) -> Vec<T> {
    let values = numbers.keys().filter_map(|&old| all.get(old).cloned());
    values.collect()
}

/// Adds values that are not there yet. Returns where each of them is.
fn added<T: PartialEq>(all: &mut Vec<T>, more: Vec<T>) -> Vec<usize> {
    let place = |value: T| {
        let known = all.iter().position(|other| *other == value);
        known.unwrap_or_else(|| {
            all.push(value);
            all.len() - 1
        })
    };
    more.into_iter().map(place).collect()
}

/// Renumbers the materials of all meshes; instances stay instances.
fn renumber_materials(scene: &mut Scene, number: impl Fn(usize) -> usize) {
    let new = |old: u32| match old {
        NO_MATERIAL => old,
        old => number(old as usize) as u32,
    };
    let changes = |mesh: &Mesh| mesh.materials.iter().any(|&old| new(old) != old);
    scene.change_meshes(changes, |mesh| {
        mesh.materials.iter_mut().for_each(|m| *m = new(*m));
    });
}

/// The images that a texture names.
fn images_of(texture: &Texture) -> impl Iterator<Item = usize> {
    let others = texture.alternatives.iter().map(|other| other.1);
    texture.image.into_iter().chain(others)
}

/// Replaces the number of every image that a texture names.
fn each_image(texture: &mut Texture, number: impl Fn(usize) -> usize) {
    let others = texture.alternatives.iter_mut().map(|other| &mut other.1);
    for image in texture.image.iter_mut().chain(others) {
        *image = number(*image);
    }
}

/// Replaces the number of every texture that a material names, those in its extensions included.
fn each_texture(material: &mut Material, number: &mut dyn FnMut(usize) -> usize) {
    let own: [&mut Option<TextureReference>; 5] = [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.normal_texture,
        &mut material.occlusion_texture,
        &mut material.emissive_texture,
    ];
    for reference in own.into_iter().flatten() {
        reference.texture = number(reference.texture);
    }
    for (name, text) in &mut material.extensions {
        if name == EXTRAS {
            continue;
        }
        if let Ok(mut json) = serde_json::from_str::<Value>(text)
            && in_extension(&mut json, number)
        {
            *text = json.to_string();
        }
    }
}

/// Replaces the numbers of textures in an extension: those under `index` in what is called "…Texture". Returns whether there
/// are any.
fn in_extension(json: &mut Value, number: &mut dyn FnMut(usize) -> usize) -> bool {
    let Value::Object(members) = json else {
        return false;
    };
    let mut found = false;
    for (key, member) in members {
        let index = member.get("index").and_then(Value::as_u64);
        match index.filter(|_| key.ends_with("Texture")) {
            Some(old) => {
                member["index"] = number(old as usize).into();
                found = true;
            }
            None => found |= in_extension(member, number),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::geometry::{Image, ImageSource, Node};
    use std::sync::Arc;

    fn image(name: &str) -> Image {
        Image {
            name: name.to_owned(),
            mime_type: "image/png".to_owned(),
            source: ImageSource::Bytes(name.as_bytes().to_vec()),
        }
    }

    /// Three materials: bark with image 2 in an extension, leaves with image 1, stone with none.
    fn scene() -> Scene {
        let texture = |image| Texture {
            image: Some(image),
            alternatives: Vec::new(),
            sampler: [None; 4],
        };
        let reference = |texture| TextureReference {
            texture,
            coordinates: 0,
            transform: None,
            strength: 1.0,
        };
        let material = |name: &str| Material {
            name: name.to_owned(),
            ..Material::default()
        };
        let extension = r#"{"specularTexture":{"index":2}}"#.to_owned();
        let bark = Material {
            extensions: vec![("KHR_materials_specular".to_owned(), extension)],
            ..material("bark")
        };
        let leaves = Material {
            base_color_texture: Some(reference(1)),
            ..material("leaves")
        };
        let mesh = |material: u32| {
            Arc::new(Mesh {
                positions: vec![point(0.0), point(1.0), point(2.0)],
                triangles: vec![[0, 1, 2], [0, 2, 1]],
                materials: vec![material, NO_MATERIAL],
                ..Mesh::default()
            })
        };
        let node =
            |name: &str, mesh: &Arc<Mesh>| Node::new(name, glam::DAffine3::IDENTITY, mesh.clone());
        let (tree, crown) = (mesh(0), mesh(1));
        let mut nodes = vec![node("rock", &mesh(2)), node("tree", &tree)];
        nodes.extend([node("crown", &crown), node("other", &tree)]);
        nodes[2].parent = Some(1);
        Scene {
            nodes,
            materials: vec![bark, leaves, material("stone")],
            textures: vec![texture(0), texture(1), texture(2)],
            images: vec![image("unused"), image("leaf"), image("gloss")],
            ..Scene::default()
        }
    }

    fn point(x: f64) -> glam::DVec3 {
        glam::DVec3::new(x, x * x, 0.0)
    }

    #[test]
    fn a_part_has_what_it_uses_and_goes_back_to_where_it_was() {
        let whole = scene();
        let part = part(&whole, &[1, 2]);
        assert_eq!(part.materials.len(), 2);
        assert_eq!(part.images, [image("leaf"), image("gloss")]);
        assert_eq!(part.textures[1].image, Some(1));
        let extension = &part.materials[0].extensions[0].1;
        assert_eq!(extension, r#"{"specularTexture":{"index":1}}"#);
        assert_eq!(part.nodes[1].parent, Some(0));
        let mut again = whole.clone();
        again.nodes.truncate(1);
        append(&mut again, part, Some(0));
        let Scene {
            materials,
            textures,
            images,
            ..
        } = &again;
        assert_eq!(
            (materials, textures, images),
            (&whole.materials, &whole.textures, &whole.images)
        );
        let meshes = |scene: &Scene| [1, 2].map(|n| scene.nodes[n].mesh.materials.clone());
        assert_eq!(meshes(&again), meshes(&whole));
        assert_eq!([1, 2].map(|n| again.nodes[n].parent), [Some(0), Some(1)]);
    }
}
