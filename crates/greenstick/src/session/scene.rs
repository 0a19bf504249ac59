//! The scene of broken pieces and of everything that was not cut.

use super::chain::BreakStages;
use super::pieces::{PieceRole, Pieces};
use glam::DAffine3;
use greenstick_geometry::{Node, Scene};

/// What a node of a broken scene is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeRole {
    /// A piece of the stem that was broken.
    Piece(PieceRole),
    /// Wood or leaves that hang beyond the break and move with the upper piece.
    Carried,
    /// What the break did not touch.
    Untouched,
}

/// A scene, and what each of its nodes is.
#[derive(Debug, Clone, Default)]
pub(super) struct Assembled {
    pub scene: Scene,
    pub roles: Vec<NodeRole>,
}

impl Assembled {
    fn push(&mut self, node: Node, role: NodeRole) {
        self.scene.nodes.push(node);
        self.roles.push(role);
    }
}

/// Puts the pieces of a break in place of the stem.
pub(super) fn assemble(stages: &BreakStages, pieces: &Pieces) -> Assembled {
    let stem = stages.stem.stem();
    let (scene, found) = (&stem.scene, &stem.found);
    let mut out = Assembled {
        scene: Scene {
            nodes: Vec::new(),
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
            images: scene.images.clone(),
            notes: Vec::new(),
        },
        roles: Vec::new(),
    };
    let mut upper_motion = DAffine3::IDENTITY;
    let mut upper_node = None;
    for piece in &pieces.pieces {
        if piece.role == PieceRole::Upper {
            (upper_motion, upper_node) = (piece.motion, Some(out.scene.nodes.len()));
        }
        let transform = piece.motion * *stem.transform();
        let node = Node::new(piece.role.name(), transform, piece.mesh.clone());
        out.push(node, NodeRole::Piece(piece.role));
    }
    let mut used: Vec<Vec<bool>> = scene
        .nodes
        .iter()
        .map(|n| vec![false; n.mesh.triangles.len()])
        .collect();
    for &t in &found.shell {
        used[found.node][t as usize] = true;
    }
    for (number, shell) in found.carried.iter().enumerate() {
        for &t in &shell.triangles {
            used[shell.node][t as usize] = true;
        }
        let source = &scene.nodes[shell.node];
        let triangles = shell.triangles.iter().map(|&t| t as usize);
        let mesh = source.mesh.submesh(triangles);
        let name = format!("{}_with_upper_{number:03}", source.name);
        let node = Node {
            parent: upper_node,
            ..Node::new(name, upper_motion * source.transform, mesh)
        };
        out.push(node, NodeRole::Carried);
    }
    for (source, used) in scene.nodes.iter().zip(&used) {
        let mesh = if !used.contains(&true) {
            source.mesh.clone()
        } else if used.contains(&false) {
            let rest = (0..used.len()).filter(|&t| !used[t]);
            source.mesh.submesh(rest).into()
        } else {
            continue;
        };
        let node = Node::new(source.name.clone(), source.transform, mesh);
        out.push(node, NodeRole::Untouched);
    }
    out
}
