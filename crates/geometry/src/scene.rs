//! A scene: placed meshes and the materials they share. What every reader returns and every writer takes.

use crate::{Image, Material, Mesh, Metadata, Texture};
use glam::DAffine3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A mesh placed in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Name, may be empty.
    pub name: String,
    /// Local coordinates to world coordinates in metres. Readers give a file in millimetres the scale 0.001 here, so that
    /// the mesh itself keeps the numbers of the file; [`Scene::move_scale_into_meshes`] takes it away.
    pub transform: DAffine3,
    /// The mesh in local coordinates. Nodes that hold the same `Arc` are instances of one mesh, and files keep them so.
    pub mesh: Arc<Mesh>,
    /// Index of the node that carries this one. `transform` is to the world all the same; only writers of formats
    /// with a hierarchy use it.
    pub parent: Option<usize>,
    /// Whether it only adds to the looks of another node, such as fibres on a surface: it is not part of a solid, and formats that
    /// hold all nodes as one mesh leave it out.
    pub is_detail: bool,
}

impl Node {
    /// A node that nothing carries.
    pub fn new(name: impl Into<String>, transform: DAffine3, mesh: impl Into<Arc<Mesh>>) -> Self {
        Node {
            name: name.into(),
            transform,
            mesh: mesh.into(),
            parent: None,
            is_detail: false,
        }
    }

    /// The mesh, to be changed for this node alone: where other nodes share it, this one gets a copy first.
    pub fn mesh_mut(&mut self) -> &mut Mesh {
        Arc::make_mut(&mut self.mesh)
    }
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
    /// Where it comes from, for writers of formats with a place for it.
    pub metadata: Metadata,
}

impl Scene {
    /// The meshes in world metres, one for each node, without attributes.
    pub fn world_meshes(&self) -> Vec<Mesh> {
        let world = |node: &Node| Mesh {
            positions: (node.mesh.positions.iter())
                .map(|&p| node.transform.transform_point3(p))
                .collect(),
            triangles: node.mesh.triangles.clone(),
            ..Mesh::default()
        };
        self.nodes.iter().map(world).collect()
    }

    /// Takes a scale that all transforms contain, as that of a unit, out of them and into the meshes. Nothing moves.
    pub fn move_scale_into_meshes(&mut self, scale: f64) {
        self.change_meshes(
            |_| true,
            |mesh| mesh.positions.iter_mut().for_each(|p| *p *= scale),
        );
        for node in &mut self.nodes {
            node.transform.matrix3 *= scale.recip();
        }
    }

    /// Changes every mesh that `wants` it, each once: instances of one mesh stay instances.
    pub fn change_meshes(&mut self, wants: impl Fn(&Mesh) -> bool, change: impl Fn(&mut Mesh)) {
        let mut changed: BTreeMap<*const Mesh, Arc<Mesh>> = BTreeMap::new();
        // What is replaced is kept to the end, so that no address is used twice.
        let mut replaced = Vec::new();
        for node in self.nodes.iter_mut().filter(|n| wants(&n.mesh)) {
            if let Some(mesh) = Arc::get_mut(&mut node.mesh) {
                change(mesh);
                continue;
            }
            let new = changed.entry(Arc::as_ptr(&node.mesh)).or_insert_with(|| {
                let mut mesh = (*node.mesh).clone();
                change(&mut mesh);
                Arc::new(mesh)
            });
            replaced.push(std::mem::replace(&mut node.mesh, new.clone()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instances_stay_instances() {
        let shared: Arc<Mesh> = Arc::default();
        let node = |name: &str, mesh: &Arc<Mesh>| Node::new(name, DAffine3::IDENTITY, mesh.clone());
        let mut scene = Scene {
            nodes: vec![
                node("a", &shared),
                node("b", &shared),
                node("own", &Arc::default()),
            ],
            ..Scene::default()
        };
        let same =
            |scene: &Scene, i: usize| Arc::ptr_eq(&scene.nodes[0].mesh, &scene.nodes[i].mesh);
        scene.change_meshes(|_| true, |mesh| mesh.materials.push(1));
        assert!(same(&scene, 1) && !same(&scene, 2));
        assert!(scene.nodes.iter().all(|n| n.mesh.materials == [1]));
        scene.nodes[1].mesh_mut().materials.push(2);
        assert!(!same(&scene, 1));
        assert_eq!(scene.nodes[0].mesh.materials, [1]);
    }
}
