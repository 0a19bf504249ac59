//! The film of a scene that was cut along the faces of a run.

use super::faces::{FacePair, face_pairs, measure_gape};
use super::held::{Held, HeldPiece};
use super::lengths::lengths_along;
use super::rod_faces::RodFaces;
use super::section_joints::SectionJoints;
use super::sections::Sections;
use crate::film::error::FilmError;
use crate::film::make_film::add_extras;
use crate::film::motion::{MovingBehind, MovingParts, RunMotion};
use crate::film::options::FilmOptions;
use crate::film::report::{FilmPiece, SkinReport, count_rods};
use crate::film::rigid::RIGID_TOLERANCE;
use crate::film::run::Run;
use crate::film::separation::SeparationTracker;
use crate::film::skinned_film::SkinnedFilm;
use crate::finish::{NodeRole, PieceRole};
use crate::remainder::add_tangents;
use crate::rods::{BreakHistory, Joints};
use crate::rods_scene::body_material;
use crate::simulated::{ObservedRun, SimulatedFracture};
use glam::{DAffine3, DVec3};
use greenstick_geometry::film::Extra;
use greenstick_geometry::repair::{KnownPositions, resolve_self_intersections, snap_to_f32};
use greenstick_geometry::{
    Binding, Cancelled, Context, Film, Mesh, Node, Pose, Scene, SkinnedMesh, Stage,
};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Parts that no face touched move with the stem where they come this near to its axis, in its radii there.
const ATTACHED: f64 = 2.0;

/// The input of a run, cut along the faces that it decided, all parts where they were.
pub struct DrawnScene<'a> {
    /// Pieces and what else there is.
    pub scene: &'a Scene,
    /// What each node is.
    pub roles: &'a [NodeRole],
    /// The material of the wood inside.
    pub inner: u32,
    /// The fractures along which it was cut, from the base of the stem to its tip.
    pub fractures: &'a [SimulatedFracture],
    /// The frame that decided them.
    pub observed: &'a ObservedRun,
}

/// What a node of the scene does in the film.
enum Part {
    /// The piece of this number, from the base of the stem.
    Piece(usize),
    /// Strands of torn fibre on that piece.
    Strands(usize),
    /// Moves with that piece.
    With(usize),
    /// Moves with whatever is nearest, if anything is near.
    Nearest,
}

impl DrawnScene<'_> {
    fn part(&self, node: usize) -> Part {
        match self.roles[node] {
            NodeRole::Piece(PieceRole::Lower) => Part::Piece(0),
            NodeRole::Piece(PieceRole::Upper) => Part::Piece(1),
            NodeRole::Piece(PieceRole::Segment(number)) => Part::Piece(number),
            NodeRole::Fuzz(_) => self.parent_piece(node).map_or(Part::Nearest, Part::Strands),
            NodeRole::Carried => self.parent_piece(node).map_or(Part::Nearest, Part::With),
            NodeRole::Piece(PieceRole::Splinter(_)) | NodeRole::Untouched => Part::Nearest,
        }
    }

    /// The piece that a node is below, if any.
    fn parent_piece(&self, node: usize) -> Option<usize> {
        match self.part(self.scene.nodes[node].parent?) {
            Part::Piece(piece) | Part::Strands(piece) | Part::With(piece) => Some(piece),
            Part::Nearest => None,
        }
    }

    /// The nodes of the pieces, from the base of the stem.
    fn pieces(&self) -> Vec<usize> {
        let mut nodes: Vec<(usize, usize)> = (0..self.scene.nodes.len())
            .filter_map(|node| match self.part(node) {
                Part::Piece(piece) => Some((piece, node)),
                _ => None,
            })
            .collect();
        nodes.sort_unstable();
        nodes.into_iter().map(|n| n.1).collect()
    }

    fn names(&self, nodes: &[usize]) -> Vec<String> {
        let name = |&node: &usize| self.scene.nodes[node].name.clone();
        nodes.iter().map(name).collect()
    }

    /// The mesh of a piece in the film's coordinates, rounded to the precision of files there, which it was in the input's.
    fn shown_piece(
        &self,
        node: usize,
        film_from_stem: &DAffine3,
        known: &KnownPositions,
        context: &Context,
    ) -> Result<Mesh, Cancelled> {
        let mut mesh = self.mesh(node).transformed(film_from_stem);
        snap_to_f32(&mut mesh, self.inner);
        resolve_self_intersections(&mut mesh, known, context)?;
        Ok(mesh)
    }

    /// The mesh of a node in the stem's world, with tangents for normal maps.
    fn mesh(&self, node: usize) -> Mesh {
        let node = &self.scene.nodes[node];
        let mut mesh = node.mesh.transformed(&node.transform);
        add_tangents(&mut mesh);
        mesh
    }
}

/// What binds meshes to the joints of a film.
struct Binder<'a> {
    run: &'a Run,
    faces: &'a RodFaces<'a>,
    sections: &'a Sections<'a>,
    /// The film's joint that is the first of the sections'.
    first: u32,
}

impl Binder<'_> {
    /// The film's joints that a point of a piece follows at a length along the axis (m), with their weights.
    fn weights(&self, piece: usize, along: f64, held: Held) -> Vec<(u32, f64)> {
        let mut weights = self.sections.weights(piece, along, held);
        weights.iter_mut().for_each(|w| w.0 += self.first);
        weights
    }

    /// How far whole rods decide where a point of a piece in the stem's world goes.
    fn held_at(&self, piece: usize, p: DVec3, along: f64) -> Held {
        let grain = self.run.stem().grain.to_grain_near(p, along);
        self.sections.held_at(piece, grain.truncate(), along)
    }

    /// Returns how far whole rods decide where the vertices of a piece go, whose mesh is in the stem's world.
    fn held(&self, piece: usize, mesh: &Mesh, lengths: &[f64]) -> HeldPiece {
        let vertices: Vec<(DVec3, f64)> = (mesh.positions.iter().copied())
            .zip(lengths.iter().copied())
            .collect();
        let held = vertices.par_iter();
        let held = held.map(|&(p, along)| self.held_at(piece, p, along));
        HeldPiece::spread(mesh, held.collect(), self.run.stem().radius)
    }

    /// Binds a mesh to the joints of a piece.
    fn bind(&self, piece: usize, lengths: &[f64], held: &[Held]) -> Binding {
        let mut binding = Binding::default();
        for (&along, &held) in lengths.iter().zip(held) {
            binding.push(self.weights(piece, along, held));
        }
        binding
    }

    /// The one joint that a whole mesh in the stem's world follows, and how far from the axis the mesh begins, in radii.
    fn joint_of(&self, piece: usize, mesh: &Mesh) -> Option<(u32, f64)> {
        let stem = self.run.stem();
        let axis = stem.grain.axis();
        let nearest = (mesh.positions.iter())
            .map(|&p| {
                let along = axis.length_at(p);
                let radius = stem.radius * stem.grain.scale(along);
                (p, along, p.distance(axis.frame(along).origin) / radius)
            })
            .min_by(|a, b| a.2.total_cmp(&b.2))?;
        let (place, along, off) = nearest;
        let weights = self.weights(piece, along, self.held_at(piece, place, along));
        let joint = weights.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        Some((joint, off))
    }

    /// The piece that has most of the stem at the place nearest to a mesh in the stem's world.
    fn piece_near(&self, mesh: &Mesh) -> usize {
        let axis = self.run.stem().grain.axis();
        let count = mesh.positions.len().max(1) as f64;
        let along = mesh
            .positions
            .iter()
            .map(|&p| axis.length_at(p))
            .sum::<f64>()
            / count;
        let below = |&face: &usize| self.faces.mean_length(face) < along;
        (0..self.faces.count()).filter(below).count()
    }
}

impl Run {
    /// Returns all frames of a range as a film of the pieces of `drawn`. Of the options only bodies count.
    ///
    /// # Errors
    /// [`FilmError`] where a frame does not exist or cannot be read, or the caller cancelled.
    pub fn film_of_faces(
        &mut self,
        range: Range<usize>,
        drawn: &DrawnScene,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<SkinnedFilm, FilmError> {
        let [making, rigid] = context.split([
            (Stage::new("pieces"), 3.0),
            (Stage::new("rigid pieces"), 1.0),
        ]);
        let mut skinned = self.film_that_bends(range, drawn, options, &making)?;
        let spacing = self.wood().spacing();
        skinned.bind_rigid_pieces(RIGID_TOLERANCE * spacing, &rigid)?;
        Ok(skinned)
    }

    /// The same, without asking whether pieces keep their shape in the frames of the range: they may bend in later ones.
    pub(super) fn film_that_bends(
        &mut self,
        range: Range<usize>,
        drawn: &DrawnScene,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<SkinnedFilm, FilmError> {
        let count = self.frames.count();
        if range.is_empty() || range.end > count {
            let number = range.end.saturating_sub(1);
            return Err(FilmError::NoSuchFrame { number, count });
        }
        let [breaks, binding, pieces] = context.split([
            (Stage::new("breaks"), 1.0),
            (Stage::new("skin"), 1.0),
            (Stage::new("pieces"), 1.0),
        ]);
        let history = self.break_history(range.clone(), &breaks)?;
        binding.report(0.0)?;
        let (mut film, bodies) = self.film_without_pieces(range.start, drawn, options)?;
        let film_from_stem = self.film_from_stem();
        let wood = self.wood();
        let joints = Joints::new(&wood, &drawn.observed.state);
        let rest: Vec<Pose> = (joints.rest.iter())
            .map(|&pose| self.placement.pose(pose))
            .collect();
        let faces = RodFaces::new(&wood, drawn.observed, drawn.fractures);
        let nodes = drawn.pieces();
        let names = drawn.names(&nodes);
        let sections =
            Sections::new(&faces, (&joints, &rest), &names, &history).ok_or(FilmError::NoRods)?;
        let binder = Binder {
            run: self,
            faces: &faces,
            sections: &sections,
            first: film.joints.len() as u32,
        };
        let (meshes, held) = self.add_pieces(&mut film, drawn, &nodes, &binder, &binding)?;
        add_others(&mut film, drawn, (&binder, &held), &film_from_stem);
        let moving = add_used_joints(&mut film, &sections.joints);
        let mut report = self.report_on(&film, &sections, &meshes, range.clone());
        self.track_separations(&joints, &sections, range.clone(), &mut report, &pieces)?;
        let spacing = wood.spacing();
        let mut motion = RunMotion::new(
            self.source.clone(),
            self.film_times(range.clone()),
            range.start,
            MovingParts {
                joints,
                bodies,
                behind: MovingBehind::Sections(moving),
            },
            self.placement,
        );
        let pairs = self.all_pairs(&meshes, &faces, &history);
        let times = &self.frames.times[range];
        let (gapes, gape) = measure_gape(&film, &mut motion, pairs, times, spacing)?;
        report.gape = gape;
        for (piece, gape) in report.pieces.iter_mut().zip(gapes) {
            piece.gape_m = gape;
        }
        add_extras(&mut film, &report);
        Ok(SkinnedFilm {
            film,
            motion,
            report,
            inner: drawn.inner,
        })
    }

    /// Returns a film with the materials of a scene and the bodies of a frame, and the numbers of those that move.
    fn film_without_pieces(
        &self,
        frame: usize,
        drawn: &DrawnScene,
        options: &FilmOptions,
    ) -> Result<(Film, Vec<usize>), FilmError> {
        let mut film = Film {
            frames_per_second: self.scene.frames_per_second,
            materials: drawn.scene.materials.clone(),
            textures: drawn.scene.textures.clone(),
            images: drawn.scene.images.clone(),
            ..Film::default()
        };
        let mut bodies = Vec::new();
        if options.bodies {
            let material = film.materials.len() as u32;
            film.materials.push(body_material());
            let first = self.frame(frame)?;
            bodies = self.add_bodies(&mut film, &first, material);
        }
        Ok((film, bodies))
    }

    /// Adds the pieces to a film. Returns their meshes in the stem's world, and how far whole rods decide where they go.
    fn add_pieces(
        &self,
        film: &mut Film,
        drawn: &DrawnScene,
        nodes: &[usize],
        binder: &Binder,
        context: &Context,
    ) -> Result<(Vec<Mesh>, Vec<HeldPiece>), FilmError> {
        let film_from_stem = self.film_from_stem();
        let known = self.known_positions(&film_from_stem);
        let (mut meshes, mut all_held) = (Vec::new(), Vec::new());
        for (number, &node) in nodes.iter().enumerate() {
            context.report(number as f64 / nodes.len() as f64)?;
            let shown = drawn.shown_piece(node, &film_from_stem, &known, context)?;
            let mesh = shown.transformed(&film_from_stem.inverse());
            let lengths = lengths_along(&mesh, self.stem());
            let held = binder.held(number, &mesh, &lengths);
            film.pieces.push(SkinnedMesh {
                name: drawn.scene.nodes[node].name.clone(),
                binding: binder.bind(number, &lengths, &held.held),
                mesh: shown,
                ..SkinnedMesh::default()
            });
            meshes.push(mesh);
            all_held.push(held);
        }
        Ok((meshes, all_held))
    }

    /// Returns the positions of the input's own vertices in the film's coordinates; what crosses among them is left.
    fn known_positions(&self, film_from_stem: &DAffine3) -> KnownPositions {
        let input = &self.wood.input.nodes[self.wood.node];
        let map = *film_from_stem * input.transform;
        KnownPositions::from_mesh(&input.mesh.transformed(&map))
    }

    /// Returns the vertices on both sides of all faces.
    fn all_pairs(
        &self,
        meshes: &[Mesh],
        faces: &RodFaces,
        history: &BreakHistory,
    ) -> Vec<FacePair> {
        let grain = &self.wood.stem.grain;
        let rod_at = |p: DVec3| faces.rod_at(grain.to_grain(p).truncate());
        let pairs = |face: usize| {
            let both = [&meshes[face], &meshes[face + 1]];
            face_pairs((face, both), faces, history, rod_at)
        };
        (0..faces.count()).flat_map(pairs).collect()
    }

    /// Reports when each piece separated, and from which.
    fn track_separations(
        &self,
        joints: &Joints,
        sections: &Sections,
        range: Range<usize>,
        report: &mut SkinReport,
        context: &Context,
    ) -> Result<(), FilmError> {
        let edge = |parts: &Vec<_>| {
            let (rod, part) = *parts.first()?;
            Some(joints.first_edge(rod, part))
        };
        let edges: Option<Vec<u32>> = sections.parts.iter().map(edge).collect();
        let Some(edges) = edges else {
            return Ok(());
        };
        let mut tracker = SeparationTracker::new(edges);
        let frames = range.len() as f64;
        for (done, number) in range.enumerate() {
            context.report(done as f64 / frames)?;
            tracker.push_frame(self.frame(number)?.as_ref());
        }
        let names: Vec<String> = report.pieces.iter().map(|p| p.name.clone()).collect();
        for (piece, separation) in report.pieces.iter_mut().zip(tracker.separations()) {
            piece.parted = separation.map(|s| (s.time, names[s.from].clone()));
        }
        Ok(())
    }

    fn report_on(
        &self,
        film: &Film,
        sections: &Sections,
        meshes: &[Mesh],
        range: Range<usize>,
    ) -> SkinReport {
        let pieces = film.pieces.iter().zip(&sections.parts).zip(meshes);
        let pieces = pieces.map(|((piece, parts), mesh)| FilmPiece {
            name: piece.name.clone(),
            rods: count_rods(parts),
            volume_m3: mesh.volume(),
            parted: None,
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
            gape_m: 0.0,
        });
        let frames = (&self.frames, range);
        SkinReport::of_pieces(pieces.collect(), film.joints.len(), frames)
    }
}

/// Adds those of `joints` to a film that its pieces follow, which number them from the film's own joints on.
fn add_used_joints(film: &mut Film, joints: &SectionJoints) -> SectionJoints {
    let first = film.joints.len() as u32;
    let used = film.pieces.iter().flat_map(|p| p.binding.used_joints());
    let used: BTreeSet<u32> = used.filter_map(|joint| joint.checked_sub(first)).collect();
    let used: Vec<u32> = used.into_iter().collect();
    for piece in &mut film.pieces {
        for joint in &mut piece.binding.joints {
            if let Some(number) = joint.checked_sub(first) {
                *joint = first + used.partition_point(|&u| u < number) as u32;
            }
        }
    }
    let mut moving = joints.clone();
    moving.show_only(used);
    film.joints.extend(moving.film_joints());
    moving
}

/// Adds what is not a piece: it moves with one, or stands still.
fn add_others(
    film: &mut Film,
    drawn: &DrawnScene,
    (binder, held): (&Binder, &[HeldPiece]),
    film_from_stem: &DAffine3,
) {
    for (number, node) in drawn.scene.nodes.iter().enumerate() {
        let mesh = drawn.mesh(number);
        let joint = match drawn.part(number) {
            Part::Piece(_) => continue,
            Part::Strands(piece) => {
                let lengths = lengths_along(&mesh, binder.run.stem());
                let binding = binder.bind(piece, &lengths, &held[piece].of_strands(&mesh));
                film.pieces.push(SkinnedMesh {
                    name: node.name.clone(),
                    mesh: mesh.transformed(film_from_stem),
                    binding,
                    is_detail: true,
                    ..SkinnedMesh::default()
                });
                continue;
            }
            Part::With(piece) => binder.joint_of(piece, &mesh).map(|j| j.0),
            Part::Nearest => {
                let joint = binder.joint_of(binder.piece_near(&mesh), &mesh);
                joint.filter(|j| j.1 <= ATTACHED).map(|j| j.0)
            }
        };
        let mesh = mesh.transformed(film_from_stem);
        match joint {
            None => (film.fixed).push(Node::new(node.name.clone(), DAffine3::IDENTITY, mesh)),
            Some(joint) => film.pieces.push(SkinnedMesh {
                binding: Binding::rigid(mesh.positions.len(), joint),
                name: node.name.clone(),
                mesh,
                extras: BTreeMap::from([("input".into(), Extra::Text(node.name.clone()))]),
                ..SkinnedMesh::default()
            }),
        }
    }
}
