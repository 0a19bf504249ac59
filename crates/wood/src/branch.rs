//! The built-in branch as a scene.

use crate::primitive::{self, BranchOptions};
use glam::DAffine3;
use greenstick_geometry::{Material, Node, Scene};

/// Name of the material of bark where the input has none.
pub const BARK_MATERIAL_NAME: &str = "bark";

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

/// Returns a branch like the built-in one, of other dimensions, as a scene without materials, as scans come: a break gives
/// it bark.
pub fn branch_scene(options: &BranchOptions) -> Scene {
    let mut mesh = primitive::branch(options);
    mesh.attributes.remove("TEXCOORD_0");
    let node = Node {
        name: "branch".into(),
        transform: DAffine3::IDENTITY,
        mesh: mesh.into(),
        parent: None,
        is_detail: false,
    };
    Scene {
        nodes: vec![node],
        ..Scene::default()
    }
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
