//! The built-in branch with its bark.

use glam::DAffine3;
use greenstick_geometry::{Image, ImageSource, Material, Node, Scene, Texture, TextureReference};
use greenstick_picture::Picture;
use greenstick_wood::primitive::{self, BranchOptions};
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Name of the material that stands for bark where the input has none.
pub(crate) const OWN_BARK: &str = "bark";

/// Colour factor of the branch's bark; its texture holds what is left. Viewers without textures show this alone.
const FACTOR: [f32; 3] = [0.34, 0.27, 0.2];
/// Pixels of the bark's texture around the branch.
const AROUND: u32 = 192;

/// The built-in branch as a scene.
pub fn built_in_branch() -> Scene {
    branch(&BranchOptions::default())
}

/// A branch like the built-in one, of other dimensions.
pub(crate) fn branch(options: &BranchOptions) -> Scene {
    let turns = options.length / (0.5 * TAU * options.diameter);
    let node = Node {
        name: "branch".into(),
        transform: DAffine3::IDENTITY,
        mesh: primitive::branch(options).into(),
        parent: None,
    };
    // It takes longer than the rest, and most branches are the built-in one.
    static BAKED: OnceLock<Vec<u8>> = OnceLock::new();
    let png = if *options == BranchOptions::default() {
        BAKED.get_or_init(|| bake(options, turns)).clone()
    } else {
        bake(options, turns)
    };
    let bark = Material {
        name: OWN_BARK.into(),
        base_color: [FACTOR[0], FACTOR[1], FACTOR[2], 1.0],
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

/// The bark as a picture: around the branch in a row, along it from row to row.
fn bake(options: &BranchOptions, turns: f64) -> Vec<u8> {
    let height = (f64::from(AROUND) * turns).round().max(1.0) as u32;
    let mut rgb = Vec::with_capacity((AROUND * height * 3) as usize);
    for y in 0..height {
        let along = (f64::from(y) + 0.5) / f64::from(height);
        for x in 0..AROUND {
            let turn = (f64::from(x) + 0.5) / f64::from(AROUND);
            let color = primitive::bark_color(options, along, turn);
            rgb.extend((color.iter().zip(FACTOR)).map(|(&c, f)| encoded(c / f64::from(f))));
        }
    }
    let picture = Picture {
        width: AROUND,
        height,
        rgb,
    };
    picture.png()
}

/// A linear number as 8-bit sRGB.
fn encoded(v: f64) -> u8 {
    let v = v.clamp(0.0, 1.0);
    let curved = if v <= 0.003_130_8 {
        12.92 * v
    } else {
        1.055 * libm::pow(v, 1.0 / 2.4) - 0.055
    };
    (255.0 * curved + 0.5) as u8
}

/// Bark as one colour, for meshes that come without a material.
pub(crate) fn bark_material() -> Material {
    Material {
        name: OWN_BARK.into(),
        base_color: [0.18, 0.125, 0.085, 1.0],
        roughness: 0.95,
        ..Material::default()
    }
}
