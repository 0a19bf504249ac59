//! What is broken in a frame, as the wood was before it moved.

use super::{Begun, FilmError, FilmOptions, INNER_MATERIAL, Run, SkinReport, Still};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Context, Mesh, Node, Scene};
use greenstick_skin::rods::Parting;

/// What is nearer to the end of the wood than this part of its length reaches the end.
const END: f64 = 0.05;

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
    /// one node `whole`, and so is wood that still hangs together from end to end while others came off. What the rods do
    /// not fill follows, each part below the piece that carries it. No bodies are among them.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn at_rest(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Still, FilmError> {
        let Begun {
            skin,
            rest,
            mut report,
            mut scene,
            ..
        } = self.begin(number, options, context)?;
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
        let swapped = self.name(&mut nodes, &mut report);
        nodes.extend(rest.parts.into_iter().map(|part| Node {
            name: part.name,
            transform: DAffine3::IDENTITY,
            mesh: part.mesh,
            parent: part.by.map(|by| match rest.carriers[by].1 {
                piece @ 0..2 if swapped => 1 - piece,
                piece => piece,
            }),
        }));
        for part in &mut report.rest.pieces {
            let node = nodes.iter().find(|n| n.name == part.name);
            let by = node.and_then(|n| n.parent).map(|p| nodes[p].name.clone());
            part.carried_by = by;
        }
        scene.nodes = nodes;
        Ok(Still {
            scene,
            report,
            inner: INNER_MATERIAL,
        })
    }

    /// Names the pieces, which come with the one with the most wood first, and puts the lower one first;
    /// whether that changed their order.
    fn name(&self, nodes: &mut [Node], report: &mut SkinReport) -> bool {
        let axis = self.grown.stem.grain.axis();
        let reach = |node: &Node| {
            let along = node.mesh.positions.iter().map(|&p| axis.length_at(p));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| {
                (a.min(s), b.max(s))
            })
        };
        let reaches: Vec<(f64, f64)> = nodes.iter().take(2).map(reach).collect();
        let ends = reach_of(&self.grown.placed.along);
        let near = END * (ends.1 - ends.0);
        // From end to end; two such pieces are wood that is split lengthwise.
        let spans: Vec<bool> = reaches
            .iter()
            .map(|r| r.0 <= ends.0 + near && r.1 >= ends.1 - near)
            .collect();
        let (mut halves, mut swapped) = (2, false);
        if matches!(spans[..], [_] | [true, false]) {
            nodes[0].name = "whole".into();
            halves = 1;
        } else if let [a, b, ..] = nodes {
            let middle = |node: &Node| axis.length_at(centre(&node.mesh));
            if middle(a) > middle(b) {
                std::mem::swap(a, b);
                report.pieces.swap(0, 1);
                swapped = true;
            }
            (a.name, b.name) = ("lower".into(), "upper".into());
        }
        for (n, node) in nodes.iter_mut().skip(halves).enumerate() {
            node.name = format!("splinter_{n:03}");
        }
        for (piece, node) in report.pieces.iter_mut().zip(nodes) {
            piece.name.clone_from(&node.name);
        }
        swapped
    }
}

fn reach_of(along: &[f64]) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    along.iter().fold(none, |(a, b), &s| (a.min(s), b.max(s)))
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
