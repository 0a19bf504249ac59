//! The film of a run: the mesh that was simulated, cut along the faces that the run decided, or the skin of its rods.

use crate::arguments::FacesChoice;
use crate::failure::Failure;
use greenstick::film::{DrawnFilm, film_of_faces, picture_of_run};
use greenstick::geometry::{Context, Scene};
use greenstick::picture::{Picture, PictureError, PictureOptions};
use greenstick::simulated_faces::SimulatedFaceReport;
use greenstick::skin::film::{FilmOptions, Run, SkinReport, SkinnedFilm, Still};
use std::ops::Range;

/// Makes the film of the faces that the run decided; none of wood that holds.
fn drawn(
    run: &mut Run,
    range: Range<usize>,
    options: &FilmOptions,
    context: &Context,
) -> Result<Option<Box<DrawnFilm>>, Failure> {
    match film_of_faces(run, range, options, context) {
        Ok(film) => Ok(Some(Box::new(film))),
        Err(error) if error.wood_holds() => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// A frame of a run.
pub enum RunStill {
    Drawn(Box<(DrawnFilm, Scene)>),
    Rods(Box<Still>),
}

impl RunStill {
    /// Shows a frame. Wood that holds has no faces; it is shown by its rods.
    pub fn new(
        run: &mut Run,
        number: usize,
        faces: FacesChoice,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<RunStill, Failure> {
        if faces == FacesChoice::Drawn
            && let Some(mut film) = drawn(run, number..number + 1, options, context)?
        {
            let scene = film.skinned.at(0).map_err(Failure::from)?;
            return Ok(RunStill::Drawn(Box::new((*film, scene))));
        }
        let still = run.still(number, options, context).map_err(Failure::from)?;
        Ok(RunStill::Rods(Box::new(still)))
    }

    /// The frame as a scene.
    pub fn scene(&mut self) -> &mut Scene {
        match self {
            RunStill::Drawn(shown) => &mut shown.1,
            RunStill::Rods(still) => &mut still.scene,
        }
    }

    /// Takes a picture of it.
    pub fn picture(
        &self,
        run: &Run,
        shot: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        match self {
            RunStill::Drawn(shown) => shown.0.picture(&shown.1, shot, context),
            RunStill::Rods(still) => picture_of_run(run, &still.scene, still.inner, shot, context),
        }
    }

    /// Returns the report, and what faces were made from.
    pub fn into_report(self) -> (SkinReport, Vec<SimulatedFaceReport>) {
        match self {
            RunStill::Drawn(shown) => (shown.0.skinned.report, shown.0.reports),
            RunStill::Rods(still) => (still.report, Vec::new()),
        }
    }
}

/// A film of a run.
pub enum RunFilm {
    Drawn(Box<DrawnFilm>),
    Rods(Box<SkinnedFilm>),
}

impl RunFilm {
    /// Makes a film of a range of frames. Wood that holds has no faces; it is shown by its rods.
    pub fn new(
        run: &mut Run,
        range: Range<usize>,
        faces: FacesChoice,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<RunFilm, Failure> {
        if faces == FacesChoice::Drawn
            && let Some(film) = drawn(run, range.clone(), options, context)?
        {
            return Ok(RunFilm::Drawn(film));
        }
        let film = run.film(range, options, context).map_err(Failure::from)?;
        Ok(RunFilm::Rods(Box::new(film)))
    }

    /// The film.
    pub fn skinned(&mut self) -> &mut SkinnedFilm {
        match self {
            RunFilm::Drawn(film) => &mut film.skinned,
            RunFilm::Rods(film) => film,
        }
    }

    /// Returns the report, and what faces were made from.
    pub fn into_report(self) -> (SkinReport, Vec<SimulatedFaceReport>) {
        match self {
            RunFilm::Drawn(film) => (film.skinned.report, film.reports),
            RunFilm::Rods(film) => (film.report, Vec::new()),
        }
    }

    /// Takes a picture of a frame of it.
    pub fn picture(
        &self,
        run: &Run,
        frame: &Scene,
        shot: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        match self {
            RunFilm::Drawn(film) => film.picture(frame, shot, context),
            RunFilm::Rods(film) => picture_of_run(run, frame, film.inner, shot, context),
        }
    }
}
