//! The skin of a simulated run: stills and films of it (Sutherland 2012 §5).
//!
//! [`Run::open`] takes a run that was recorded; [`Run::still`] gives one frame as a scene, in pieces as they are then, and
//! [`Run::film`] all frames as one skinned film, in the pieces that the last frame leaves. Both are in metres with y up.

mod carried;
mod collision;
mod error;
mod level;
mod materials;
mod motion;
mod opening;
mod pieces;
mod report;
mod rest;
mod rigid;
mod series;

pub use carried::{CarriedPiece, RestReport};
pub use collision::{Collision, CollisionPiece, collision};
pub use error::FilmError;
pub use level::{LevelReport, level};
use materials::{BARK_MATERIAL, BODY_MATERIAL, INNER_MATERIAL, OWN_MATERIALS};
pub use motion::RunMotion;
pub use report::{FilmPiece, GapeReport, SkinReport};

use crate::simulate::{
    FilledStem, PositionedBundle, SceneMeshes, body_shapes, fill_scene_stem, position_bundle,
};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use greenstick_fibre::bodies::Shape;
use greenstick_fibre::scene::Scene as Setting;
use greenstick_fibre::store::{Frame, FrameTimes, RunSource};
use greenstick_fibre::{Cause, Event, EventKind, RodBundle};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::film::Extra;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{
    Bvh, Context, Film, Joint, Mesh, Motion, Node, Pose, RigidBody, Scene, Stage,
};
use greenstick_picture::{Picture, PictureError, PictureOptions};
use greenstick_skin::remainder::{CarriedParts, pose_followers};
use greenstick_skin::rods::{
    FractureState, Materials, RodSkin, RodSkinOptions, Wood, frame_poses, rod_skin,
    rod_skin_over_time,
};
use greenstick_skin::rods_scene::{BodyNode, body_nodes};
use greenstick_skin::texture::SectionSquare;
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::species::Species;
use greenstick_wood::stem::StemKind;
use greenstick_wood::tissue::BARK_START;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The texture's square over the section's width.
const ROOM: f64 = 1.02;

/// How a skin is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmOptions {
    /// The skin.
    pub skin: RodSkinOptions,
    /// Width of the baked textures, pixels (even; half as high); 0 for none.
    pub texture_width: u32,
    /// Whether the bodies that act on the wood are shown.
    pub bodies: bool,
    /// Whether the rest of the input is carried along: what lies beyond the rods' ends and what hangs on them.
    pub rest: bool,
}

impl Default for FilmOptions {
    fn default() -> Self {
        FilmOptions {
            skin: RodSkinOptions::default(),
            texture_width: 1024,
            bodies: true,
            rest: true,
        }
    }
}

/// A run that was simulated.
pub struct Run {
    /// Its scene.
    pub scene: Setting,
    grown: FilledStem,
    /// The unbroken bundle in the scene's axes.
    bundle: RodBundle,
    /// The stem's world to the scene's.
    laid: DAffine3,
    shapes: Vec<Shape>,
    source: Arc<dyn RunSource>,
    frames: FrameTimes,
    causes: BTreeMap<u32, Cause>,
    appearance: StemAppearance,
    bark: Mesh,
    tree: Bvh,
    square: SectionSquare,
}

/// A frame with skin.
pub struct Still {
    /// Pieces, then bodies.
    pub scene: Scene,
    /// What was made.
    pub report: SkinReport,
    /// Index of the material of the wood inside.
    pub inner: u32,
}

/// What a frame's skin begins with.
struct Begun {
    frame: Arc<Frame>,
    skin: RodSkin,
    rest: CarriedParts,
    report: SkinReport,
    /// Materials.
    scene: Scene,
}

/// A film with skin.
pub struct SkinnedFilm {
    /// Joints, pieces and bodies.
    pub film: Film,
    /// How the joints move.
    pub motion: RunMotion,
    /// What was made.
    pub report: SkinReport,
    /// Index of the material of the wood inside.
    pub inner: u32,
}

impl SkinnedFilm {
    /// The film's frame `number`, counted from its first, as a scene.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read.
    pub fn at(&mut self, number: usize) -> Result<Scene, FilmError> {
        let film = &self.film;
        let mut poses = vec![Pose::IDENTITY; film.joints.len()];
        self.motion.poses(number, &mut poses)?;
        let mut nodes = posed(film, number, &poses);
        nodes.extend(film.fixed.iter().cloned());
        let mut maps = Vec::new();
        film.joint_maps(&poses, &mut maps);
        nodes.extend(film.bodies.iter().map(|RigidBody { node, joint }| Node {
            transform: maps[*joint as usize] * node.transform,
            ..node.clone()
        }));
        Ok(Scene {
            nodes,
            materials: film.materials.clone(),
            textures: film.textures.clone(),
            images: film.images.clone(),
            notes: Vec::new(),
        })
    }

    /// The corners of the box that holds all joints, and pieces that move as a whole, in all frames, m.
    ///
    /// # Errors
    /// [`FilmError`] where a frame cannot be read.
    pub fn bounds(&mut self) -> Result<Vec<DVec3>, FilmError> {
        let mut poses = vec![Pose::IDENTITY; self.film.joints.len()];
        let mut maps = Vec::new();
        let rigid: Vec<(usize, [DVec3; 8])> = (self.film.pieces.iter())
            .filter_map(|piece| match piece.binding.used_joints()[..] {
                [joint] => Some((joint as usize, corners(piece.mesh.bounds()?))),
                _ => None,
            })
            .collect();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for frame in 0..self.motion.frames() {
            self.motion.poses(frame, &mut poses)?;
            for pose in &poses {
                low = low.min(pose.translation);
                high = high.max(pose.translation);
            }
            self.film.joint_maps(&poses, &mut maps);
            for p in rigid.iter().flat_map(|(joint, corners)| {
                let map = maps[*joint];
                corners.map(move |p| map.transform_point3(p))
            }) {
                (low, high) = (low.min(p), high.max(p));
            }
        }
        Ok(corners((low, high)).to_vec())
    }
}

/// The corners of a box.
fn corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let pick = |axis: usize| [low, high][k >> axis & 1][axis];
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// The pieces of a film in a frame, where its joints have these poses.
fn posed(film: &Film, frame: usize, poses: &[Pose]) -> Vec<Node> {
    let (mut maps, mut normals) = (Vec::new(), Vec::new());
    film.joint_maps(poses, &mut maps);
    let piece = |(number, piece): (usize, &greenstick_geometry::SkinnedMesh)| {
        let mut mesh = piece.mesh.clone();
        film.deform_positions_at(frame, number, &maps, &mut mesh.positions);
        film.deform_normals_at(frame, number, &maps, &mut normals);
        if let Some(attribute) = mesh.attributes.get_mut("TANGENT") {
            let at_rest: Vec<[f32; 3]> = (attribute.data.as_chunks::<4>().0.iter())
                .map(|&[x, y, z, _]| [x, y, z])
                .collect();
            let mut turned = Vec::new();
            film.deform_directions_at(frame, number, &maps, &at_rest, &mut turned);
            for (to, t) in attribute.data.chunks_exact_mut(4).zip(turned) {
                to[..3].copy_from_slice(&t.as_vec3().to_array());
            }
        }
        if let Some(attribute) = mesh.attributes.get_mut("NORMAL") {
            attribute.data = normals
                .iter()
                .flat_map(|n| n.as_vec3().to_array())
                .collect();
        }
        Node::new(piece.name.clone(), DAffine3::IDENTITY, mesh)
    };
    film.pieces.iter().enumerate().map(piece).collect()
}

/// Why vertices of the unbroken rods broke.
fn causes(events: &[Event]) -> BTreeMap<u32, Cause> {
    let broken = events.iter().filter(|e| e.kind == EventKind::RodBroke);
    broken
        .map(|event| {
            let cause = match event.cause {
                Cause::Compression => Cause::Compression,
                _ => Cause::Tension,
            };
            (event.vertex, cause)
        })
        .collect()
}

/// Turns the scene's z up to the y up of files.
fn upright() -> DQuat {
    DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2)
}

impl Run {
    /// Opens a run that was recorded. `meshes` are those that its scene names.
    ///
    /// # Errors
    /// [`FilmError`] where there is no run, or where it is of other meshes.
    pub fn open(
        source: Arc<dyn RunSource>,
        meshes: &SceneMeshes,
        context: &Context,
    ) -> Result<Run, FilmError> {
        let scene = source.scene()?;
        let frames = source.frames()?;
        if frames.count() == 0 {
            return Err(FilmError::NoFrames { run: source.name() });
        }
        let shapes = body_shapes(&scene, meshes)?;
        let grown = fill_scene_stem(&scene, meshes.input.as_ref(), context)?;
        let PositionedBundle {
            bundle,
            scene_from_stem: laid,
        } = position_bundle(&grown, meshes, context)?;
        let causes = causes(&source.events()?);
        let species = Species::find(&scene.wood.species).ok();
        let tissues = BreakParameters::default().proportions();
        let appearance =
            StemAppearance::new(&grown.stem, &tissues, scene.seed, species, BARK_START);
        let node = &grown.scene.nodes[grown.node];
        let shell = grown.shell.iter().map(|&t| t as usize);
        let mut bark = node.mesh.submesh(shell).transformed(&node.transform);
        // Stems that come with the program part their triangles by materials that no scene lists.
        let listed = grown.scene.materials.len();
        let unlisted = bark.materials.iter_mut().filter(|m| **m as usize >= listed);
        unlisted.for_each(|m| *m = NO_MATERIAL);
        let tree = Bvh::from_mesh(&bark);
        let outline = &grown.placed.outline;
        let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = outline
            .iter()
            .copied()
            .fold(DVec2::NEG_INFINITY, DVec2::max);
        Ok(Run {
            square: SectionSquare {
                middle: 0.5 * (low + high),
                side: ROOM * (high - low).max_element(),
            },
            scene,
            grown,
            bundle,
            laid,
            shapes,
            source,
            frames,
            causes,
            appearance,
            bark,
            tree,
        })
    }

    /// Number of whole frames.
    pub fn frames(&self) -> usize {
        self.frames.count()
    }

    /// The appearance of its wood and bark.
    pub fn appearance(&self) -> &StemAppearance {
        &self.appearance
    }

    /// The stem that its rods fill.
    pub fn stem(&self) -> &greenstick_wood::stem::Stem {
        &self.grown.stem
    }

    fn frame(&self, number: usize) -> Result<Arc<Frame>, FilmError> {
        Ok(self.source.frame(number)?)
    }

    /// Returns the map from the stem's world to that of stills and films.
    fn film_from_stem(&self) -> DAffine3 {
        DAffine3::from_quat(upright()) * self.laid
    }

    /// Its wood, unbroken.
    pub fn wood(&self) -> Wood<'_> {
        let wood = &self.grown.wood;
        Wood {
            stem: &self.grown.stem,
            stem_to_rods: self.laid,
            bundle: &self.bundle,
            along: &self.grown.placed.along,
            cells: &self.grown.placed.cells,
            outline: &self.grown.placed.outline,
            bark: Some((&self.bark, &self.tree)),
            pull_out: wood.tension / (4.0 * wood.shear),
        }
    }

    /// The skin of what is broken in `frame`, at rest.
    fn skin(&self, frame: &Frame, options: &RodSkinOptions) -> Result<RodSkin, FilmError> {
        let state = FractureState::from_frame(&self.wood(), frame, &self.causes)?;
        Ok(self.with_materials(|wood, materials| rod_skin(wood, &state, materials, options))?)
    }

    /// What is made of its wood with the materials that it has here.
    fn with_materials<T, E>(
        &self,
        make: impl FnOnce(&Wood, &Materials) -> Result<T, E>,
    ) -> Result<T, E> {
        let proportions = BreakParameters::default().proportions();
        let board = self.grown.stem.kind == StemKind::Board;
        let materials = Materials {
            bark: u32::from(!board) * BARK_MATERIAL,
            bark_mesh_offset: OWN_MATERIALS,
            inner: INNER_MATERIAL,
            square: self.square,
            zone: &|rho| proportions.zone_at(rho, 0.0).code(),
        };
        make(&self.wood(), &materials)
    }

    /// The skin of what is broken in frame `number`, and what goes with it.
    fn begin(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Begun, FilmError> {
        let [shape, textures] =
            context.split([(Stage::new("skin"), 1.0), (Stage::new("textures"), 1.0)]);
        shape.report(0.0)?;
        let frame = self.frame(number)?;
        let skin = self.skin(&frame, &options.skin)?;
        let mut report = SkinReport::of(&skin, &self.frames, number..number + 1);
        let rest = self.carried_parts(&skin, options, &mut report, &shape)?;
        let scene = self.materials(options, &textures)?;
        Ok(Begun {
            frame,
            skin,
            rest,
            report,
            scene,
        })
    }

    /// Frame `number` as a scene.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn still(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Still, FilmError> {
        let Begun {
            frame,
            skin,
            rest,
            report,
            mut scene,
        } = self.begin(number, options, context)?;
        let up = upright();
        let poses = frame_poses(&skin.joints, &frame).into_iter();
        let mut poses: Vec<Pose> = poses.map(|p| turned(p, up)).collect();
        let mut film = film_of(skin, &self.scene);
        let followers = rest.add_to_film(&mut film, &self.film_from_stem(), self.grown.stem.radius);
        poses.resize(film.joints.len(), Pose::IDENTITY);
        pose_followers(&followers, &mut poses);
        scene.nodes = posed(&film, number, &poses);
        scene.nodes.append(&mut film.fixed);
        if options.bodies {
            for BodyNode { mut node, .. } in body_nodes(&frame, &self.shapes, BODY_MATERIAL) {
                node.transform = DAffine3::from_quat(up) * node.transform;
                scene.nodes.push(node);
            }
        }
        Ok(Still {
            scene,
            report,
            inner: INNER_MATERIAL,
        })
    }

    /// A picture of a frame with its skin, whose wood inside has the material `inner`.
    ///
    /// # Errors
    /// As [`greenstick_picture::render`].
    pub fn picture(
        &self,
        scene: &Scene,
        inner: u32,
        options: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        crate::picture_of_skin(
            scene,
            &self.grown.stem,
            &self.appearance,
            inner,
            options,
            context,
        )
    }

    /// All frames of a range as a film, in the pieces that its last frame leaves.
    ///
    /// # Errors
    /// [`FilmError`].
    pub fn film(
        &mut self,
        range: std::ops::Range<usize>,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<SkinnedFilm, FilmError> {
        let count = self.frames.count();
        if range.is_empty() || range.end > count {
            return Err(FilmError::NoSuchFrame {
                number: range.end.saturating_sub(1),
                count,
            });
        }
        let [breaks, shape, textures, pieces, rigid] = context.split([
            (Stage::new("breaks"), 1.0),
            (Stage::new("skin"), 1.0),
            (Stage::new("textures"), 1.0),
            (Stage::new("pieces"), 1.0),
            (Stage::new("rigid pieces"), 1.0),
        ]);
        let first = self.frame(range.start)?;
        let history = self.history(range.clone(), &breaks)?;
        shape.report(0.0)?;
        let skin = self.with_materials(|wood, materials| {
            rod_skin_over_time(wood, &history, materials, &options.skin)
        })?;
        let materials = self.materials(options, &textures)?;
        let mut report = SkinReport::of(&skin, &self.frames, range.clone());
        let rest = self.carried_parts(&skin, options, &mut report, &shape)?;
        let joints = skin.joints.clone();
        self.follow(&skin, range.clone(), &mut report, &pieces)?;
        let mut film = film_of(skin, &self.scene);
        film.materials = materials.materials;
        film.textures = materials.textures;
        film.images = materials.images;
        let moving = match options.bodies {
            true => self.add_bodies(&mut film, &first),
            false => Vec::new(),
        };
        add_extras(&mut film, &report);
        let carried = rest.add_to_film(&mut film, &self.film_from_stem(), self.grown.stem.radius);
        let motion = RunMotion::new(
            self.source.clone(),
            self.frames.times[range.clone()].to_vec(),
            range.start,
            (joints, moving, carried),
            upright(),
        );
        let mut made = SkinnedFilm {
            film,
            motion,
            report,
            inner: INNER_MATERIAL,
        };
        made.stiffen(rigid::TOLERANCE * self.wood().spacing(), &rigid)?;
        Ok(made)
    }

    /// Adds the bodies of the first frame to a film, each that moves with a joint of its own. Returns the numbers of those.
    fn add_bodies(&self, film: &mut Film, first: &Frame) -> Vec<usize> {
        let up = upright();
        let mut moving = Vec::new();
        for body in body_nodes(first, &self.shapes, BODY_MATERIAL) {
            let BodyNode { mut node, follows } = body;
            node.transform = DAffine3::from_quat(up) * node.transform;
            let Some(number) = follows else {
                film.fixed.push(node);
                continue;
            };
            let body = first.bodies[number];
            let named = self.scene.body.get(number);
            node.name = named.map_or(node.name, |b| b.name.clone());
            film.bodies.push(RigidBody {
                node,
                joint: film.joints.len() as u32,
            });
            let rest = Pose {
                translation: body.centre,
                rotation: body.rotation,
            };
            film.joints.push(Joint {
                name: format!("body_{number}"),
                rest: turned(rest, up),
            });
            moving.push(number);
        }
        moving
    }
}

/// Adds what is reported of each piece to it.
fn add_extras(film: &mut Film, report: &SkinReport) {
    for (piece, reported) in film.pieces.iter_mut().zip(&report.pieces) {
        let extras = &mut piece.extras;
        extras.insert("gape_m".into(), Extra::Number(reported.gape_m));
        if let Some((time, from)) = &reported.parted {
            extras.insert("parted_s".into(), Extra::Number(*time));
            extras.insert("parted_from".into(), Extra::Text(from.clone()));
        }
    }
}

fn turned(pose: Pose, by: DQuat) -> Pose {
    Pose {
        translation: by * pose.translation,
        rotation: (by * pose.rotation).normalize(),
    }
}

/// The pieces and joints of a skin as a film with y up, without materials and bodies.
fn film_of(skin: RodSkin, scene: &Setting) -> Film {
    let up = upright();
    let map = DAffine3::from_quat(up);
    let mut film = Film {
        frames_per_second: scene.frames_per_second,
        ..Film::default()
    };
    film.joints = (skin
        .joints
        .rest
        .iter()
        .zip(skin.joints.vertices())
        .enumerate())
    .map(|(joint, (&rest, vertex))| Joint {
        name: format!("vertex_{vertex}_{joint}"),
        rest: turned(rest, up),
    })
    .collect();
    film.pieces = skin.pieces;
    for piece in &mut film.pieces {
        piece.mesh = piece.mesh.transformed(&map);
        let rest = &mut piece.earlier.rest;
        rest.iter_mut().for_each(|p| *p = map.transform_point3(*p));
    }
    film
}
