//! The broken wood of a frame at rest, as it was before it moved.

use super::error::FilmError;
use super::make_still::{SkinnedFrame, Still};
use super::material_numbers::INNER_MATERIAL;
use super::options::FilmOptions;
use super::report::SkinReport;
use super::run::Run;
use crate::rods::{FractureState, RodPart};
use crate::simulated::ObservedRun;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Context, Mesh, Node, Scene};

/// Least part of the rods at an end of the wood that a piece must have to hold that end; with fewer it has a splinter of it.
const HELD_SHARE: f64 = 0.25;

impl Run {
    /// Returns the state of fracture in frame `number`, and its time, s.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read or is of other wood.
    pub fn fracture_state(&mut self, number: usize) -> Result<(FractureState, f64), FilmError> {
        let frame = self.frame(number)?;
        let state = FractureState::from_frame(&self.wood(), &frame, &self.causes)?;
        Ok((state, frame.time))
    }

    /// Returns where rods are broken in frame `number`, and why.
    ///
    /// # Errors
    /// [`FilmError`] where the frame or the events cannot be read, or are of other wood.
    pub fn observed(&self, number: usize) -> Result<ObservedRun, FilmError> {
        let frame = self.frame(number)?;
        let events = self.source.events()?;
        Ok(ObservedRun::new(&self.wood(), &frame, &events)?)
    }

    /// Returns the scene that its stem was found in.
    pub fn input(&self) -> &Scene {
        &self.wood.input
    }

    /// Returns the pieces of frame `number` at rest, where the input has the wood: they fit each other. The two largest are
    /// `lower` and `upper`, in their order along the stem, further ones `splinter_000` and so on. Wood in one piece is
    /// one node `whole`, and so is wood that still hangs together from end to end while others came off. What the rods do
    /// not fill follows, each part below the piece that carries it. No bodies are among them.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read, an option is out of range, or the caller cancelled.
    pub fn at_rest(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Still, FilmError> {
        let SkinnedFrame {
            skin,
            rest,
            mut report,
            mut scene,
            ..
        } = self.skin_frame(number, options, context)?;
        let back: DAffine3 = self.wood.scene_from_stem.inverse();
        let mut nodes: Vec<Node> = skin
            .pieces
            .into_iter()
            .map(|piece| Node {
                name: piece.name,
                transform: DAffine3::IDENTITY,
                mesh: piece.mesh.transformed(&back).into(),
                parent: None,
                is_detail: false,
            })
            .collect();
        let swapped = self.name_pieces(&mut nodes, &skin.parts, &mut report);
        nodes.extend(rest.parts.into_iter().map(|part| {
            Node {
                name: part.name,
                transform: DAffine3::IDENTITY,
                mesh: part.mesh.into(),
                is_detail: false,
                parent: part
                    .carrier
                    .map(|carrier| match rest.carriers[carrier].piece {
                        piece @ 0..2 if swapped => 1 - piece,
                        piece => piece,
                    }),
            }
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

    /// Names the pieces, which are sorted by volume, and puts the lower one first. Returns whether that changed their order.
    fn name_pieces(
        &self,
        nodes: &mut [Node],
        parts: &[Vec<(u32, RodPart)>],
        report: &mut SkinReport,
    ) -> bool {
        let axis = self.wood.stem.grain.axis();
        // From end to end; two such pieces are wood that is split lengthwise.
        let ends = held_ends(parts, self.wood.bundle.rods());
        let whole = |held: &[f64; 2]| held.iter().all(|h| *h >= HELD_SHARE);
        let spans: Vec<bool> = ends.iter().take(2).map(whole).collect();
        let (mut halves, mut swapped) = (2, false);
        if matches!(spans[..], [_] | [true, false]) {
            nodes[0].name = "whole".into();
            halves = 1;
        } else if let [a, b, ..] = nodes {
            let middle = |node: &Node| axis.length_at(centre_of_mass(&node.mesh));
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

/// Returns for each piece the parts of all rods whose beginnings and whose ends it has.
fn held_ends(parts: &[Vec<(u32, RodPart)>], rods: usize) -> Vec<[f64; 2]> {
    let mut last: Vec<RodPart> = vec![0; rods];
    for &(rod, part) in parts.iter().flatten() {
        let known = &mut last[rod as usize];
        *known = part.max(*known);
    }
    let share = |piece: &Vec<(u32, RodPart)>| {
        let count = |end: usize| {
            let there = |&&(rod, part): &&(u32, RodPart)| part == [0, last[rod as usize]][end];
            piece.iter().filter(there).count() as f64 / rods as f64
        };
        [count(0), count(1)]
    };
    parts.iter().map(share).collect()
}

/// Returns the centre of mass of a closed mesh.
fn centre_of_mass(mesh: &Mesh) -> DVec3 {
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
