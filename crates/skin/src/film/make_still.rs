//! Stills of a run: one frame as a scene.

use super::error::FilmError;
use super::material_numbers::{BODY_MATERIAL, INNER_MATERIAL};
use super::options::FilmOptions;
use super::poses::{film_from_skin, posed_pieces};
use super::report::SkinReport;
use super::run::Run;
use crate::remainder::{CarriedParts, pose_followers};
use crate::rods::{RodSkin, frame_poses};
use crate::rods_scene::{BodyNode, body_nodes};
use greenstick_fibre::store::Frame;
use greenstick_geometry::{Context, Pose, Scene, Stage};
use std::sync::Arc;

/// A frame with skin.
pub struct Still {
    /// Pieces, then bodies.
    pub scene: Scene,
    /// The report.
    pub report: SkinReport,
    /// Index of the material of the wood inside.
    pub inner: u32,
}

/// The skin of a frame at rest, with all that goes with it.
pub(super) struct SkinnedFrame {
    pub frame: Arc<Frame>,
    pub skin: RodSkin,
    pub rest: CarriedParts,
    pub report: SkinReport,
    /// Materials.
    pub scene: Scene,
}

impl Run {
    /// Returns the skin of what is broken in frame `number`, at rest.
    pub(super) fn skin_frame(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<SkinnedFrame, FilmError> {
        let [shape, textures] =
            context.split([(Stage::new("skin"), 1.0), (Stage::new("textures"), 1.0)]);
        shape.report(0.0)?;
        let frame = self.frame(number)?;
        let skin = self.skin(&frame, &options.skin)?;
        let mut report = SkinReport::new(&skin, &self.frames, number..number + 1);
        let rest = self.carried_parts(&skin, options, &mut report, &shape)?;
        let scene = self.materials(options, &textures)?;
        Ok(SkinnedFrame {
            frame,
            skin,
            rest,
            report,
            scene,
        })
    }

    /// Returns frame `number` as a scene.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read, an option is out of range, or the caller cancelled.
    pub fn still(
        &mut self,
        number: usize,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Still, FilmError> {
        let SkinnedFrame {
            frame,
            skin,
            rest,
            report,
            mut scene,
        } = self.skin_frame(number, options, context)?;
        let poses = frame_poses(&skin.joints, &frame).into_iter();
        let mut poses: Vec<Pose> = poses.map(|p| self.placement.pose(p)).collect();
        let mut film = film_from_skin(skin, &self.scene, &self.placement);
        let followers = rest.add_to_film(&mut film, &self.film_from_stem(), self.wood.stem.radius);
        poses.resize(film.joints.len(), Pose::IDENTITY);
        pose_followers(&followers, &mut poses);
        scene.nodes = posed_pieces(&film, number, &poses);
        scene.nodes.append(&mut film.fixed);
        if options.bodies {
            for BodyNode { mut node, .. } in body_nodes(&frame, &self.wood.shapes, BODY_MATERIAL) {
                node.transform = self.placement.map() * node.transform;
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
