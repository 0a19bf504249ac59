//! Stills of a run: one frame as a scene.

use super::error::FilmError;
use super::material_numbers::{BODY_MATERIAL, INNER_MATERIAL};
use super::options::FilmOptions;
use super::poses::{film_of, posed, turned, upright};
use super::report::SkinReport;
use super::run::Run;
use crate::remainder::{CarriedParts, pose_followers};
use crate::rods::{RodSkin, frame_poses};
use crate::rods_scene::{BodyNode, body_nodes};
use glam::DAffine3;
use greenstick_fibre::store::Frame;
use greenstick_geometry::{Context, Pose, Scene, Stage};
use std::sync::Arc;

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
pub(super) struct Begun {
    pub frame: Arc<Frame>,
    pub skin: RodSkin,
    pub rest: CarriedParts,
    pub report: SkinReport,
    /// Materials.
    pub scene: Scene,
}

impl Run {
    /// The skin of what is broken in frame `number`, and what goes with it.
    pub(super) fn begin(
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
        let followers = rest.add_to_film(&mut film, &self.film_from_stem(), self.wood.stem.radius);
        poses.resize(film.joints.len(), Pose::IDENTITY);
        pose_followers(&followers, &mut poses);
        scene.nodes = posed(&film, number, &poses);
        scene.nodes.append(&mut film.fixed);
        if options.bodies {
            for BodyNode { mut node, .. } in body_nodes(&frame, &self.wood.shapes, BODY_MATERIAL) {
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
}
