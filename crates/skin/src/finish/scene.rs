//! The scene of broken pieces and of everything that was not cut.

use super::finished_break::FinishedBreak;
use super::piece::{Piece, PieceRole, Pieces};
use crate::prepared::PreparedStem;
use crate::report::PieceReport;
use crate::stages::BreakStages;
use glam::DAffine3;
use greenstick_geometry::{Mesh, Node, Scene};
use std::sync::Arc;

/// The role of a node in a broken scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodeRole {
    /// A piece of the stem that was broken.
    Piece(PieceRole),
    /// Strands of torn fibre on the broken face of a piece.
    Fuzz(PieceRole),
    /// Wood or leaves that hang beyond the break and move with the upper piece.
    Carried,
    /// Wood that the break did not touch.
    Untouched,
}

/// A scene and the roles of its nodes.
#[derive(Debug, Clone, Default)]
pub struct AssembledBreaks {
    /// The scene.
    pub scene: Scene,
    /// What each of its nodes is.
    pub roles: Vec<NodeRole>,
}

impl AssembledBreaks {
    fn push(&mut self, node: Node, role: NodeRole) {
        self.scene.nodes.push(node);
        self.roles.push(role);
    }
}

/// Returns for each triangle of each node of the scene that was broken whether it is now in another node: in a piece, or
/// carried by the upper piece.
fn moved_triangles(stages: &BreakStages) -> Vec<Vec<bool>> {
    let stem = stages.stem.stem();
    let found = &stem.found;
    let mut moved: Vec<Vec<bool>> = (stem.scene.nodes.iter())
        .map(|n| vec![false; n.mesh.triangles.len()])
        .collect();
    for &t in &found.shell {
        moved[found.node][t as usize] = true;
    }
    for shell in &found.carried {
        for &t in &shell.triangles {
            moved[shell.node][t as usize] = true;
        }
    }
    moved
}

/// Returns the nodes that a break did not touch, and what is left of those from which it took triangles.
fn untouched(stem: &PreparedStem, moved: &[Vec<bool>]) -> Vec<Node> {
    let remaining = |(source, moved): (&Node, &Vec<bool>)| {
        let mesh = if !moved.contains(&true) {
            source.mesh.clone()
        } else if moved.contains(&false) {
            let rest = (0..moved.len()).filter(|&t| !moved[t]);
            source.mesh.submesh(rest).into()
        } else {
            return None;
        };
        Some(Node::new(source.name.clone(), source.transform, mesh))
    };
    let nodes = stem.scene.nodes.iter().zip(moved);
    nodes.filter_map(remaining).collect()
}

/// Returns the scene without what lies beyond a break: breaks nearer to the base are made in it.
pub fn left_at_base(stages: &BreakStages, pieces: &Pieces) -> Scene {
    let stem = stages.stem.stem();
    let lower = pieces.pieces.iter().find(|p| p.role == PieceRole::Lower);
    let lower = lower.map(|p| {
        let name = stem.node().name.clone();
        Node::new(name, *stem.transform(), p.mesh.clone())
    });
    let mut nodes: Vec<Node> = lower.into_iter().collect();
    nodes.extend(untouched(stem, &moved_triangles(stages)));
    Scene {
        nodes,
        notes: Vec::new(),
        ..stem.scene.clone()
    }
}

/// A piece with its motion and its role in the scene.
struct PlacedPiece<'a> {
    piece: &'a Piece,
    report: &'a PieceReport,
    /// The index of its break, in the order in which breaks were made.
    break_index: usize,
    /// Its motion in the world, those of all breaks nearer to the base included.
    motion: DAffine3,
    role: PieceRole,
    /// The strands on its broken faces: one mesh for each face that has any.
    fuzz: Vec<&'a Arc<Mesh>>,
}

/// Orders the pieces of breaks, which are given as they were made: from the base upwards, then splinters.
fn placed<'a>(breaks: &[FinishedBreak<'a>]) -> Vec<PlacedPiece<'a>> {
    let several = breaks.len() > 1;
    let mut below = DAffine3::IDENTITY;
    let (mut segments, mut splinters) = (Vec::<PlacedPiece>::new(), Vec::new());
    for (break_index, one) in breaks.iter().enumerate().rev() {
        let mut beyond = below;
        for (piece, report) in one.pieces.pieces.iter().zip(&one.pieces.reports) {
            let motion = below * piece.motion;
            let placed = |role| PlacedPiece {
                piece,
                report,
                break_index,
                motion,
                role,
                fuzz: piece.fuzz.iter().collect(),
            };
            match piece.role {
                PieceRole::Splinter(_) => splinters.push(placed(piece.role)),
                // Of several breaks the lower piece is that of the one nearest to the base. Of the others it is the far end of
                // the piece below.
                PieceRole::Lower if break_index + 1 < breaks.len() => {
                    if let Some(below) = segments.last_mut() {
                        below.fuzz.extend(&piece.fuzz);
                    }
                }
                _ if several => segments.push(placed(PieceRole::Segment(segments.len()))),
                role => segments.push(placed(role)),
            }
            if piece.role == PieceRole::Upper {
                beyond = motion;
            }
        }
        below = beyond;
    }
    for (number, splinter) in splinters.iter_mut().enumerate() {
        splinter.role = PieceRole::Splinter(number);
    }
    segments.extend(splinters);
    segments
}

/// Returns the reports on the pieces of breaks in the order of the scene's nodes.
pub(super) fn piece_reports(breaks: &[FinishedBreak]) -> Vec<PieceReport> {
    placed(breaks).iter().map(|p| p.report.clone()).collect()
}

/// Replaces the stem by the pieces of breaks, which are given in the order in which they were made.
pub fn assemble(breaks: &[FinishedBreak]) -> AssembledBreaks {
    let mut out = AssembledBreaks::default();
    let Some(last) = breaks.last() else {
        return out;
    };
    let scene = &last.stages.stem.stem().scene;
    out.scene.materials.clone_from(&scene.materials);
    out.scene.textures.clone_from(&scene.textures);
    out.scene.images.clone_from(&scene.images);
    // Node and motion of the piece beyond each break.
    let mut upper = vec![(0, DAffine3::IDENTITY); breaks.len()];
    let mut fuzz = Vec::new();
    for placed in placed(breaks) {
        if placed.piece.role == PieceRole::Upper {
            upper[placed.break_index] = (out.scene.nodes.len(), placed.motion);
        }
        let stem = breaks[placed.break_index].stages.stem.stem();
        let transform = placed.motion * *stem.transform();
        let mesh = placed.piece.mesh.clone();
        let node = Node::new(placed.role.name(), transform, mesh);
        for mesh in placed.fuzz {
            let node = Node {
                parent: Some(out.scene.nodes.len()),
                is_detail: true,
                ..Node::new(format!("{}_fuzz", node.name), transform, mesh.clone())
            };
            fuzz.push((node, placed.role));
        }
        out.push(node, NodeRole::Piece(placed.role));
    }
    for (one, (node, motion)) in breaks.iter().zip(upper) {
        let stem = one.stages.stem.stem();
        for (number, shell) in stem.found.carried.iter().enumerate() {
            let source = &stem.scene.nodes[shell.node];
            let mesh = source
                .mesh
                .submesh(shell.triangles.iter().map(|&t| t as usize));
            let name = format!("{}_with_upper_{number:03}", source.name);
            let carried = Node {
                parent: Some(node),
                ..Node::new(name, motion * source.transform, mesh)
            };
            out.push(carried, NodeRole::Carried);
        }
    }
    for (node, role) in fuzz {
        out.push(node, NodeRole::Fuzz(role));
    }
    let moved = moved_triangles(last.stages);
    for node in untouched(last.stages.stem.stem(), &moved) {
        out.push(node, NodeRole::Untouched);
    }
    out
}
