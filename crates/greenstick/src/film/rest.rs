//! What is broken in a frame, as the wood was before it moved.

use super::{FilmError, FilmOptions, INNER_MATERIAL, Run, SkinReport, Still};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Context, Mesh, Node, Scene};
use greenstick_skin::rods::Parting;

impl Run {
    /// What is broken in frame `number`, and its time, s.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn parting(&mut self, number: usize) -> Result<(Parting, f64), FilmError> {
        let frame = self.frame(number)?;
        let parting = Parting::of(&self.wood(), &frame, &self.causes)?;
        Ok((parting, frame.time))
    }

    /// The scene that its stem was found in.
    pub fn input(&self) -> &Scene {
        &self.grown.scene
    }

    /// The pieces of frame `number` at rest, where the input has the wood: they fit each other. The two largest are
    /// `lower` and `upper`, in their order along the stem, further ones `splinter_000` and so on. Wood in one piece is
    /// one node `whole`. No bodies are among them.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn at_rest(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Still, FilmError> {
        context.step("skin", 0.0)?;
        let frame = self.frame(number)?;
        let skin = self.skin(&frame, &options.skin)?;
        let mut report = SkinReport::of(&skin, &self.frames, number..number + 1);
        let mut scene = self.materials(options, context)?;
        let back: DAffine3 = self.laid.inverse();
        let mut nodes: Vec<Node> = skin
            .pieces
            .into_iter()
            .map(|piece| Node {
                name: piece.name,
                transform: DAffine3::IDENTITY,
                mesh: piece.mesh.transformed(&back),
                parent: None,
            })
            .collect();
        // Pieces come with the one with the most wood first.
        if let [only] = nodes.as_mut_slice() {
            only.name = "whole".into();
        } else if nodes.len() > 1 {
            let axis = self.grown.stem.grain.axis();
            let middle = |node: &Node| axis.length_at(centre(&node.mesh));
            let names = if middle(&nodes[0]) <= middle(&nodes[1]) {
                ["lower", "upper"]
            } else {
                ["upper", "lower"]
            };
            for (node, name) in nodes.iter_mut().zip(names) {
                node.name = name.into();
            }
            for (n, node) in nodes.iter_mut().skip(2).enumerate() {
                node.name = format!("splinter_{n:03}");
            }
            for (piece, node) in report.pieces.iter_mut().zip(&nodes) {
                piece.name.clone_from(&node.name);
            }
            if names[0] == "upper" {
                nodes.swap(0, 1);
                report.pieces.swap(0, 1);
            }
        }
        scene.nodes = nodes;
        Ok(Still {
            scene,
            report,
            inner: INNER_MATERIAL,
        })
    }
}

/// The centre of a closed mesh's mass.
fn centre(mesh: &Mesh) -> DVec3 {
    let origin = mesh.positions.first().copied().unwrap_or_default();
    let (mut volume, mut sum) = (0.0, DVec3::ZERO);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        let part = a.dot(b.cross(c));
        volume += part;
        sum += (a + b + c) * (0.25 * part);
    }
    if volume == 0.0 {
        origin
    } else {
        origin + sum / volume
    }
}
