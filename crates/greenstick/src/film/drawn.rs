//! Films of the faces that a run decided.

use super::error::FilmError;
use crate::Error;
use crate::pictures::picture_of_moved_break;
use crate::session::Broken;
use crate::simulated_faces::{
    PartlyBroken, SimulatedFaceReport, SimulatedFaces, SimulatedFacesError, simulated_faces,
};
use greenstick_geometry::{Context, Scene, Stage};
use greenstick_picture::{Picture, PictureError, PictureOptions};
use greenstick_skin::film::{DrawnScene, FilmOptions, Run, SkinnedFilm};
use std::ops::Range;

/// A film of the input of a run, cut along the faces that the run decided.
pub struct DrawnFilm {
    /// The film.
    pub skinned: SkinnedFilm,
    /// The pieces where they fit each other.
    pub broken: Broken,
    /// What each face was made from, from the base of the stem to its tip.
    pub reports: Vec<SimulatedFaceReport>,
}

/// Returns all frames of a range as a film of the faces that the run's last frame decided. Of the options texture width and bodies count.
///
/// # Errors
/// [`SimulatedFacesError`].
pub fn film_of_faces(
    run: &mut Run,
    range: Range<usize>,
    options: &FilmOptions,
    context: &Context,
) -> Result<DrawnFilm, SimulatedFacesError> {
    let [deciding, making] = context.split([(Stage::new("faces"), 1.0), (Stage::new("film"), 4.0)]);
    let last = run.frames().saturating_sub(1);
    let mut faces = simulated_faces(run, last, PartlyBroken::Hinged, &deciding)?;
    faces.request.texture_width = options.texture_width;
    faces.film(run, range, options, &making)
}

impl SimulatedFaces {
    /// Returns all frames of a range of the run as a film of the faces. Of the options only bodies count.
    ///
    /// # Errors
    /// [`SimulatedFacesError`].
    pub fn film(
        &mut self,
        run: &mut Run,
        range: Range<usize>,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<DrawnFilm, SimulatedFacesError> {
        let [cutting, moving] =
            context.split([(Stage::new("break"), 1.0), (Stage::new("skin"), 1.0)]);
        for one in &mut self.request.breaks {
            // Pieces are where they were before anything moved.
            (one.separation, one.fray) = (0.0, 0.0);
            let face = &mut one.recipe.face;
            (face.hang, face.splinter_lean, face.splinter_snap) = (0.0, Some(0.0), Some(0.0));
        }
        let broken = self.broken(&cutting).map_err(|error| match error {
            Error::Cancelled(cancelled) => SimulatedFacesError::Cancelled(cancelled),
            error => SimulatedFacesError::Cut(Box::new(error)),
        })?;
        let drawn = DrawnScene {
            scene: &broken.scene,
            roles: &broken.roles,
            inner: broken.woods.first().map_or(0, |wood| wood.material),
            fractures: &self.fractures,
            observed: &self.observed,
        };
        let skinned = run
            .film_of_faces(range, &drawn, options, &moving)
            .map_err(FilmError::from)?;
        Ok(DrawnFilm {
            skinned,
            broken,
            reports: self.reports.clone(),
        })
    }
}

impl DrawnFilm {
    /// Returns which share of the wood's surface is not where its rods are in the film's last frame: wood that is split lengthwise
    /// without a face between.
    ///
    /// # Errors
    /// [`FilmError`] where the frame cannot be read.
    pub fn misplaced_share(&mut self, run: &Run) -> Result<f64, FilmError> {
        let last = self.skinned.report.frames.saturating_sub(1);
        let shown = self.skinned.at(last)?;
        let frame = run.frame(self.skinned.report.first_frame + last)?;
        Ok(run.misplaced_share(&self.skinned.film, &frame, &shown.nodes))
    }

    /// Takes a picture of a frame of the film.
    ///
    /// # Errors
    /// As [`greenstick_picture::render`].
    pub fn picture(
        &self,
        frame: &Scene,
        options: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        picture_of_moved_break(frame, &self.broken.woods, options, context)
    }
}
