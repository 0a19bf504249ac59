//! The film of a run: the mesh that was simulated, cut along the faces that the run decided, or the skin of its rods.

use crate::arguments::FacesChoice;
use crate::failure::Failure;
use greenstick::film::{DrawnFilm, film_of_faces, picture_of_run};
use greenstick::geometry::{Context, Scene, Stage};
use greenstick::picture::{Picture, PictureError, PictureOptions};
use greenstick::simulated_faces::{SimulatedFaceReport, SimulatedFacesError};
use greenstick::skin::WoodField;
use greenstick::skin::film::{FilmOptions, NearbyRods, Run, SkinReport, SkinnedFilm, Still};
use std::ops::Range;

/// Wood of which more than this share of the surface would not be where its rods are is shown by its rods: it is split lengthwise.
const SPLIT_SHARE: f64 = 0.05;

/// What shows a range of frames.
enum Shown {
    /// The faces that the run decided.
    Faces(Box<DrawnFilm>),
    /// Its rods.
    Rods(RodsReason),
}

/// Why rods are shown.
enum RodsReason {
    /// They are asked for, or the wood holds.
    Meant,
    /// Faces would misplace this share of the surface.
    Split(f64),
    /// Faces cannot be cut.
    Uncut(String),
}

impl RodsReason {
    /// Says so in a report.
    fn note(self, report: &mut SkinReport) {
        match self {
            RodsReason::Meant => {}
            RodsReason::Split(share) => {
                report.misplaced_share = Some(share);
                report.rods_because = Some(format!(
                    "the wood is split lengthwise: with drawn faces {:.0} % of its surface would be out of place",
                    100.0 * share
                ));
            }
            RodsReason::Uncut(error) => report.rods_because = Some(error),
        }
    }
}

/// Makes the film of the faces that the run decided, if they are asked for or, where nothing is, show it well.
fn shown(
    run: &mut Run,
    range: Range<usize>,
    faces: Option<FacesChoice>,
    options: &FilmOptions,
    context: &Context,
) -> Result<Shown, Failure> {
    let automatic = match faces {
        Some(FacesChoice::Rods) => return Ok(Shown::Rods(RodsReason::Meant)),
        Some(FacesChoice::Drawn) => false,
        None => true,
    };
    let last = run.frames().saturating_sub(1);
    let has_last = range.end > last;
    let [deciding, making] = context.split([
        (Stage::new("faces"), if has_last { 0.0 } else { 1.0 }),
        (Stage::new("skin"), 1.0),
    ]);
    if automatic && !has_last {
        // The end of the run decides for all frames.
        let options = FilmOptions {
            texture_width: 0,
            ..options.clone()
        };
        if let Err(reason) = drawn(run, last..last + 1, (automatic, true), &options, &deciding)? {
            return Ok(Shown::Rods(reason));
        }
    }
    let made = drawn(run, range, (automatic, has_last), options, &making)?;
    Ok(made.map_or_else(Shown::Rods, Shown::Faces))
}

/// Makes the film of the faces that the run decided, or says why its rods are to be shown: the wood holds, or, where the choice is
/// `automatic`, faces cannot be cut or, as the `last` frame is in the range, would misplace the wood.
fn drawn(
    run: &mut Run,
    range: Range<usize>,
    (automatic, last): (bool, bool),
    options: &FilmOptions,
    context: &Context,
) -> Result<Result<Box<DrawnFilm>, RodsReason>, Failure> {
    let mut film = match film_of_faces(run, range, options, context) {
        Ok(film) => Box::new(film),
        Err(error) if error.wood_holds() => return Ok(Err(RodsReason::Meant)),
        Err(SimulatedFacesError::Cut(error)) if automatic => {
            return Ok(Err(RodsReason::Uncut(error.to_string())));
        }
        Err(error) => return Err(error.into()),
    };
    if automatic && last {
        let share = film.misplaced_share(run).map_err(Failure::from)?;
        if share > SPLIT_SHARE {
            return Ok(Err(RodsReason::Split(share)));
        }
        film.skinned.report.misplaced_share = Some(share);
    }
    Ok(Ok(film))
}

/// A field of the wood that is shown in place of its colours.
struct ShownField {
    field: WoodField,
    near: NearbyRods,
}

impl ShownField {
    fn new(run: &Run, film: &SkinnedFilm, field: WoodField) -> Self {
        ShownField {
            field,
            near: run.nearby_rods(&film.film),
        }
    }

    /// Sets it in the pieces of a film's frame `number` of the run.
    fn set(&self, run: &Run, number: usize, scene: &mut Scene) -> Result<(), Failure> {
        let frame = run.frame(number).map_err(Failure::from)?;
        let values = run.field(self.field, &frame);
        self.near.set_field(self.field, &values, &mut scene.nodes);
        Ok(())
    }
}

/// How a run is shown.
#[derive(Debug, Clone)]
pub struct ShownAs {
    /// Which faces broken wood has; `None` for those that show it best.
    pub faces: Option<FacesChoice>,
    /// The field that pictures and stills have in place of the wood's colours.
    pub field: Option<WoodField>,
    /// How the skin is made.
    pub film: FilmOptions,
}

/// A frame of a run.
pub enum RunStill {
    Film(Box<(RunFilm, Scene)>),
    Rods(Box<Still>),
}

impl RunStill {
    /// Shows a frame. Wood that holds has no faces; it is shown by its rods.
    pub fn new(
        run: &mut Run,
        number: usize,
        how: &ShownAs,
        context: &Context,
    ) -> Result<RunStill, Failure> {
        let range = number..number + 1;
        let shown = shown(run, range.clone(), how.faces, &how.film, context)?;
        let shown = match shown {
            Shown::Rods(reason) if how.field.is_none() => {
                let still = run.still(number, &how.film, context);
                let mut still = still.map_err(Failure::from)?;
                reason.note(&mut still.report);
                return Ok(RunStill::Rods(Box::new(still)));
            }
            shown => shown,
        };
        let mut film = RunFilm::of_shown(run, range, shown, how, context)?;
        let scene = film.at(run, 0)?;
        Ok(RunStill::Film(Box::new((film, scene))))
    }

    /// The frame as a scene.
    pub fn scene(&mut self) -> &mut Scene {
        match self {
            RunStill::Film(shown) => &mut shown.1,
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
            RunStill::Film(shown) => shown.0.picture(run, &shown.1, shot, context),
            RunStill::Rods(still) => picture_of_run(run, &still.scene, still.inner, shot, context),
        }
    }

    /// Returns the report, and what faces were made from.
    pub fn into_report(self) -> (SkinReport, Vec<SimulatedFaceReport>) {
        match self {
            RunStill::Film(shown) => shown.0.into_report(),
            RunStill::Rods(still) => (still.report, Vec::new()),
        }
    }
}

/// A film of a run.
pub struct RunFilm {
    film: Film,
    field: Option<ShownField>,
}

enum Film {
    Drawn(Box<DrawnFilm>),
    Rods(Box<SkinnedFilm>),
}

impl RunFilm {
    /// Makes a film of a range of frames. Wood that holds has no faces; it is shown by its rods.
    pub fn new(
        run: &mut Run,
        range: Range<usize>,
        how: &ShownAs,
        context: &Context,
    ) -> Result<RunFilm, Failure> {
        let shown = shown(run, range.clone(), how.faces, &how.film, context)?;
        RunFilm::of_shown(run, range, shown, how, context)
    }

    fn of_shown(
        run: &mut Run,
        range: Range<usize>,
        shown: Shown,
        how: &ShownAs,
        context: &Context,
    ) -> Result<RunFilm, Failure> {
        let film = match shown {
            Shown::Faces(film) => Film::Drawn(film),
            Shown::Rods(reason) => {
                let mut film = run.film(range, &how.film, context).map_err(Failure::from)?;
                reason.note(&mut film.report);
                Film::Rods(Box::new(film))
            }
        };
        let mut made = RunFilm { film, field: None };
        if let Some(field) = how.field {
            made.field = Some(ShownField::new(run, made.skinned(), field));
        }
        Ok(made)
    }

    /// The film.
    pub fn skinned(&mut self) -> &mut SkinnedFilm {
        match &mut self.film {
            Film::Drawn(film) => &mut film.skinned,
            Film::Rods(film) => film,
        }
    }

    /// Returns frame `number` of the film, with the field that it shows.
    pub fn at(&mut self, run: &Run, number: usize) -> Result<Scene, Failure> {
        let skinned = self.skinned();
        let first = skinned.report.first_frame;
        let mut scene = skinned.at(number).map_err(Failure::from)?;
        if let Some(field) = &self.field {
            field.set(run, first + number, &mut scene)?;
        }
        Ok(scene)
    }

    /// The materials of the wood inside.
    pub fn inner_materials(&self) -> Vec<u32> {
        match &self.film {
            Film::Drawn(film) => film.broken.woods.iter().map(|w| w.material).collect(),
            Film::Rods(film) => vec![film.inner],
        }
    }

    /// Returns the report, and what faces were made from.
    pub fn into_report(self) -> (SkinReport, Vec<SimulatedFaceReport>) {
        match self.film {
            Film::Drawn(film) => (film.skinned.report, film.reports),
            Film::Rods(film) => (film.report, Vec::new()),
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
        match &self.film {
            Film::Drawn(film) => film.picture(frame, shot, context),
            Film::Rods(film) => picture_of_run(run, frame, film.inner, shot, context),
        }
    }
}
