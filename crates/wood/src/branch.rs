//! The built-in branch as a scene, with its bark.

use crate::primitive::{self, BranchOptions};
use glam::DAffine3;
use greenstick_geometry::{Image, ImageSource, Material, Node, Scene, Texture, TextureReference};
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Name of the material of bark where the input has none.
pub const BARK_MATERIAL_NAME: &str = "bark";

/// Linear colour by which the texture of the branch's bark is multiplied. Viewers without textures show this alone.
const BASE_COLOR: [f32; 3] = [0.34, 0.27, 0.2];
/// Pixels of the bark's texture around the branch.
const PIXELS_AROUND: u32 = 192;

/// Returns the built-in branch as a scene.
///
/// ```
/// use greenstick_wood::branch::built_in_branch;
///
/// let scene = built_in_branch();
/// assert!(scene.nodes[0].mesh.volume() > 0.0);
/// ```
pub fn built_in_branch() -> Scene {
    branch_scene(&BranchOptions::default())
}

/// Returns a branch like the built-in one, of other dimensions, as a scene.
pub fn branch_scene(options: &BranchOptions) -> Scene {
    let turns = options.length / (0.5 * TAU * options.diameter);
    let node = Node {
        name: "branch".into(),
        transform: DAffine3::IDENTITY,
        mesh: primitive::branch(options).into(),
        parent: None,
        is_detail: false,
    };
    // Baking takes longer than the rest, and most branches are the built-in one.
    static BAKED: OnceLock<Vec<u8>> = OnceLock::new();
    let png = if *options == BranchOptions::default() {
        BAKED.get_or_init(|| bake(options, turns)).clone()
    } else {
        bake(options, turns)
    };
    let bark = Material {
        name: BARK_MATERIAL_NAME.into(),
        base_color: [BASE_COLOR[0], BASE_COLOR[1], BASE_COLOR[2], 1.0],
        roughness: 0.95,
        base_color_texture: Some(TextureReference {
            texture: 0,
            coordinates: 0,
            transform: Some(([0.0, 0.0], 0.0, [1.0, (1.0 / turns) as f32])),
            strength: 1.0,
        }),
        ..Material::default()
    };
    Scene {
        nodes: vec![node],
        materials: vec![bark],
        textures: vec![Texture {
            image: Some(0),
            alternatives: Vec::new(),
            // Linear filtering with mipmaps; repeating around, clamped at the ends.
            sampler: [Some(9729), Some(9987), Some(10497), Some(33071)],
        }],
        images: vec![Image {
            name: "bark_color".into(),
            mime_type: "image/png".into(),
            source: ImageSource::Bytes(png),
        }],
        ..Scene::default()
    }
}

/// Paints the bark as a PNG file.
fn bake(options: &BranchOptions, turns: f64) -> Vec<u8> {
    let height = (f64::from(PIXELS_AROUND) * turns).round().max(1.0) as u32;
    primitive::paint_bark(options, PIXELS_AROUND, height, BASE_COLOR).png()
}

/// Returns bark as one colour, for meshes that come without a material.
pub fn bark_material() -> Material {
    Material {
        name: BARK_MATERIAL_NAME.into(),
        base_color: [0.18, 0.125, 0.085, 1.0],
        roughness: 0.95,
        ..Material::default()
    }
}
