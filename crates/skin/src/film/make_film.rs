//! Films of a run: a range of frames with the pieces that the last one leaves.

use super::error::FilmError;
use super::material_numbers::{BODY_MATERIAL, INNER_MATERIAL};
use super::motion::{MovingBehind, MovingParts, RunMotion};
use super::options::FilmOptions;
use super::poses::film_from_skin;
use super::report::SkinReport;
use super::rigid::RIGID_TOLERANCE;
use super::run::Run;
use super::skinned_film::SkinnedFilm;
use crate::rods::rod_skin_over_time;
use crate::rods_scene::{BodyNode, body_nodes};
use greenstick_fibre::store::Frame;
use greenstick_geometry::film::Extra;
use greenstick_geometry::{Context, Film, Joint, Pose, RigidBody, Stage};

impl Run {
    /// Returns all frames of a range as a film, in the pieces that its last frame leaves.
    ///
    /// # Errors
    /// [`FilmError`] where a frame does not exist or cannot be read, an option is out of range, or the caller cancelled.
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
        let history = self.break_history(range.clone(), &breaks)?;
        shape.report(0.0)?;
        let skin = self.with_materials(|wood, materials| {
            rod_skin_over_time(wood, &history, materials, &options.skin)
        })?;
        let materials = self.materials(options, &textures)?;
        let mut report = SkinReport::new(&skin, &self.frames, range.clone());
        let rest = self.carried_parts(&skin, options, &mut report, &shape)?;
        let joints = skin.joints.clone();
        self.track_pieces(&skin, range.clone(), &mut report, &pieces)?;
        let mut film = film_from_skin(skin, &self.scene, &self.placement);
        film.materials = materials.materials;
        film.textures = materials.textures;
        film.images = materials.images;
        let bodies = match options.bodies {
            true => self.add_bodies(&mut film, &first, BODY_MATERIAL),
            false => Vec::new(),
        };
        add_extras(&mut film, &report);
        let carried = rest.add_to_film(&mut film, &self.film_from_stem(), self.wood.stem.radius);
        let motion = RunMotion::new(
            self.source.clone(),
            self.film_times(range.clone()),
            range.start,
            MovingParts {
                joints,
                bodies,
                behind: MovingBehind::Carried(carried),
            },
            self.placement,
        );
        let mut skinned = SkinnedFilm {
            film,
            motion,
            report,
            inner: INNER_MATERIAL,
        };
        skinned.bind_rigid_pieces(RIGID_TOLERANCE * self.wood().spacing(), &rigid)?;
        Ok(skinned)
    }

    /// Adds the bodies of the first frame to a film, of this material, each that moves with a joint of its own. Returns the numbers of those.
    pub(super) fn add_bodies(&self, film: &mut Film, first: &Frame, material: u32) -> Vec<usize> {
        let mut moving = Vec::new();
        for body in body_nodes(first, &self.wood.shapes, material) {
            let BodyNode { mut node, follows } = body;
            node.transform = self.placement.map() * node.transform;
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
                rest: self.placement.pose(rest),
            });
            moving.push(number);
        }
        moving
    }
}

/// Adds the report of each piece to its extras.
pub(super) fn add_extras(film: &mut Film, report: &SkinReport) {
    for (piece, reported) in film.pieces.iter_mut().zip(&report.pieces) {
        let extras = &mut piece.extras;
        extras.insert("gape_m".into(), Extra::Number(reported.gape_m));
        if let Some((time, from)) = &reported.parted {
            extras.insert("parted_s".into(), Extra::Number(*time));
            extras.insert("parted_from".into(), Extra::Text(from.clone()));
        }
    }
}
