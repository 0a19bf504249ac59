//! A scene: placed meshes and the materials they share. What every reader returns and every writer takes.

use crate::{Image, Material, Mesh, Texture};
use glam::DAffine3;

/// A mesh placed in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Name, may be empty.
    pub name: String,
    /// Local coordinates to world coordinates in metres. A file in millimetres has the scale 0.001 here, so that
    /// the mesh itself keeps the numbers of the file.
    pub transform: DAffine3,
    /// The mesh in local coordinates.
    pub mesh: Mesh,
    /// Index of the node that carries this one. `transform` is to the world all the same; only writers of formats
    /// with a hierarchy use it.
    pub parent: Option<usize>,
}

/// Placed meshes with their materials. Node hierarchies are flattened: every transform is to the world.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scene {
    /// Placed meshes.
    pub nodes: Vec<Node>,
    /// Materials; [`Mesh::materials`] indexes them.
    pub materials: Vec<Material>,
    /// Textures of the materials.
    pub textures: Vec<Texture>,
    /// Images of the textures.
    pub images: Vec<Image>,
    /// What the reader left out or repaired, one sentence each (cameras dropped, polygons triangulated …).
    pub notes: Vec<String>,
}
