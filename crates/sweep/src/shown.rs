//! A recorded run as it is shown: the mesh that was simulated, cut along the faces that the run decided, or the skin of its
//! rods, whichever shows it better.

use greenstick::ErrorKind;
use greenstick::film::{DrawnFilm, FilmError, film_of_faces, picture_of_run};
use greenstick::geometry::{Cancelled, Context, Scene, Stage};
use greenstick::picture::{Picture, PictureError, PictureOptions, Sphere};
use greenstick::simulated_faces::{SimulatedFaceReport, SimulatedFacesError};
use greenstick::skin::WoodField;
use greenstick::skin::film::{
    self, FilmOptions, FilmParameters, NearbyRods, Run, SkinReport, SkinnedFilm, Still,
};
use greenstick::skin::view::FilmView;
use std::ops::Range;

/// Keys that only the skin of rods has.
const RODS_ONLY: [&str; 6] = [
    "fibres",
    "splinters",
    "slabs",
    "keep_inner",
    "outline",
    "only_rods",
];

/// What the faces of broken wood are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Faces {
    /// Cut into the mesh itself where rods broke, in fibres finer than rods.
    Drawn,
    /// Prisms about the rods.
    Rods,
}

impl Faces {
    /// Returns which faces are meant where some keys are given: one that only the skin of rods has asks for that.
    ///
    /// # Errors
    /// The key that drawn faces do not have, where they are asked for.
    ///
    /// ```
    /// use greenstick_sweep::shown::Faces;
    ///
    /// assert_eq!(Faces::meant(None, |key| key == "slabs"), Ok(Some(Faces::Rods)));
    /// assert_eq!(Faces::meant(None, |_| false), Ok(None));
    /// assert_eq!(Faces::meant(Some(Faces::Drawn), |key| key == "slabs"), Err("slabs"));
    /// ```
    pub fn meant(
        asked: Option<Faces>,
        is_given: impl Fn(&str) -> bool,
    ) -> Result<Option<Faces>, &'static str> {
        match (asked, RODS_ONLY.into_iter().find(|key| is_given(key))) {
            (Some(Faces::Drawn), Some(key)) => Err(key),
            (None, Some(_)) => Ok(Some(Faces::Rods)),
            (asked, _) => Ok(asked),
        }
    }
}

/// Why a run cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum ShowError {
    /// The run cannot be read, or no still or film can be made of it.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// Faces cannot be cut.
    #[error(transparent)]
    Faces(#[from] SimulatedFacesError),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ShowError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            ShowError::Film(error) => error.kind(),
            ShowError::Faces(error) => error.kind(),
            ShowError::Cancelled(_) => ErrorKind::Cancelled,
        }
    }
}

impl From<film::FilmError> for ShowError {
    fn from(error: film::FilmError) -> Self {
        FilmError::from(error).into()
    }
}

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
    faces: Option<Faces>,
    options: &FilmOptions,
    context: &Context,
) -> Result<Shown, ShowError> {
    let automatic = match faces {
        Some(Faces::Rods) => return Ok(Shown::Rods(RodsReason::Meant)),
        Some(Faces::Drawn) => false,
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
) -> Result<Result<Box<DrawnFilm>, RodsReason>, ShowError> {
    let mut film = match film_of_faces(run, range, options, context) {
        Ok(film) => Box::new(film),
        Err(error) if error.wood_holds() => return Ok(Err(RodsReason::Meant)),
        Err(SimulatedFacesError::Cut(error)) if automatic => {
            return Ok(Err(RodsReason::Uncut(error.to_string())));
        }
        Err(error) => return Err(error.into()),
    };
    if automatic && last {
        let share = film.misplaced_share(run)?;
        let in_two = film.reports.iter().any(|report| report.parted);
        if !film::shows_well(share, in_two) {
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
    fn set(&self, run: &Run, number: usize, scene: &mut Scene) -> Result<(), ShowError> {
        let frame = run.frame(number)?;
        let values = run.field(self.field, &frame);
        self.near.set_field(self.field, &values, &mut scene.nodes);
        Ok(())
    }
}

/// How a run is shown.
#[derive(Debug, Clone)]
pub struct ShownAs {
    /// Which faces broken wood has; `None` for those that show it best.
    pub faces: Option<Faces>,
    /// The field that pictures and stills have in place of the wood's colours.
    pub field: Option<WoodField>,
    /// How the skin is made.
    pub film: FilmOptions,
}

impl ShownAs {
    /// As it shows best, with the wood of this seed and the usual parameters but for the width of baked textures, pixels.
    pub fn best(seed: u64, texture_size: u32) -> Self {
        let parameters = FilmParameters {
            texture_size,
            ..FilmParameters::default()
        };
        ShownAs {
            faces: None,
            field: None,
            film: parameters.film_options(seed),
        }
    }
}

/// A frame of a run.
pub enum RunStill {
    /// A frame of a film.
    Film(Box<(RunFilm, Scene)>),
    /// The skin of its rods.
    Rods(Box<Still>),
}

impl RunStill {
    /// Shows a frame. Wood that holds has no faces; it is shown by its rods.
    ///
    /// # Errors
    /// [`ShowError`].
    pub fn new(
        run: &mut Run,
        number: usize,
        how: &ShownAs,
        context: &Context,
    ) -> Result<RunStill, ShowError> {
        let range = number..number + 1;
        let shown = shown(run, range.clone(), how.faces, &how.film, context)?;
        let shown = match shown {
            Shown::Rods(reason) if how.field.is_none() => {
                let still = run.still(number, &how.film, context);
                let mut still = still?;
                reason.note(&mut still.report);
                return Ok(RunStill::Rods(Box::new(still)));
            }
            shown => shown,
        };
        let mut film = RunFilm::of_shown(run, range, shown, how, context)?;
        let scene = film.at(run, 0)?;
        Ok(RunStill::Film(Box::new((film, scene))))
    }

    /// The frame as a scene, which metadata may be added to.
    pub fn scene(&mut self) -> &mut Scene {
        match self {
            RunStill::Film(shown) => &mut shown.1,
            RunStill::Rods(still) => &mut still.scene,
        }
    }

    /// Takes a picture of it.
    ///
    /// # Errors
    /// As [`greenstick::picture::render`].
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
    pub fn report(&self) -> (&SkinReport, &[SimulatedFaceReport]) {
        match self {
            RunStill::Film(shown) => shown.0.report(),
            RunStill::Rods(still) => (&still.report, &[]),
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
    ///
    /// # Errors
    /// [`ShowError`].
    pub fn new(
        run: &mut Run,
        range: Range<usize>,
        how: &ShownAs,
        context: &Context,
    ) -> Result<RunFilm, ShowError> {
        let shown = shown(run, range.clone(), how.faces, &how.film, context)?;
        RunFilm::of_shown(run, range, shown, how, context)
    }

    fn of_shown(
        run: &mut Run,
        range: Range<usize>,
        shown: Shown,
        how: &ShownAs,
        context: &Context,
    ) -> Result<RunFilm, ShowError> {
        let film = match shown {
            Shown::Faces(film) => Film::Drawn(film),
            Shown::Rods(reason) => {
                let mut film = run.film(range, &how.film, context)?;
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
    ///
    /// # Errors
    /// [`ShowError`].
    pub fn at(&mut self, run: &Run, number: usize) -> Result<Scene, ShowError> {
        let skinned = self.skinned();
        let first = skinned.report.first_frame;
        let mut scene = skinned.at(number)?;
        if let Some(field) = &self.field {
            field.set(run, first + number, &mut scene)?;
        }
        Ok(scene)
    }

    /// Returns what pictures of some frames show, for [`film_shot`].
    ///
    /// # Errors
    /// [`ShowError`] where a frame cannot be read, or the caller cancelled.
    pub fn view(&mut self, frames: &[usize], context: &Context) -> Result<FilmView, ShowError> {
        let inner = self.inner_materials();
        let skinned = self.skinned();
        let mut view = FilmView::default();
        for (done, &number) in frames.iter().enumerate() {
            context.report(done as f64 / frames.len() as f64)?;
            view.add(&skinned.at(number)?, &inner);
        }
        Ok(view)
    }

    /// The materials of the wood inside.
    fn inner_materials(&self) -> Vec<u32> {
        match &self.film {
            Film::Drawn(film) => film.broken.woods.iter().map(|w| w.material).collect(),
            Film::Rods(film) => vec![film.inner],
        }
    }

    /// Returns the report, and what faces were made from.
    pub fn report(&self) -> (&SkinReport, &[SimulatedFaceReport]) {
        match &self.film {
            Film::Drawn(film) => (&film.skinned.report, &film.reports),
            Film::Rods(film) => (&film.report, &[]),
        }
    }

    /// Takes a picture of a frame of it.
    ///
    /// # Errors
    /// As [`greenstick::picture::render`].
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

/// Returns the options of pictures that are frames of one film: what `shot` leaves open is the same in all of them, and the camera and the
/// ground stay where they are. A close-up shows where the break is in all of them.
pub fn film_shot(view: &FilmView, shot: &PictureOptions) -> PictureOptions {
    let near = view.close_up(shot.close_up);
    let near = near.map(|(centre, radius)| Sphere { centre, radius });
    PictureOptions {
        zoom: shot.zoom.or(near),
        close_up: None,
        ground_origin: view.middle(),
        shown: view.points.clone(),
        ..shot.clone()
    }
}
