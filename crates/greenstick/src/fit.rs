//! Fitting the parameters of a drawn break to a break that a run simulated.
//!
//! [`fit`] reads a run; [`fit_fracture_state`] takes the wood and its state of fracture. The algorithm is that of
//! [`greenstick_skin::fit`]; here it meets the run and the chain that draws a break.

use crate::film::FilmError;
use crate::{Break, BreakRequest, BreakSession, Error};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::{Cancelled, Context, ErrorKind, Scene, Stage};
use greenstick_skin::film::Run;
use greenstick_skin::fit::BreakFit;
pub use greenstick_skin::fit::{FitReport, FittedValue, TissueBreaks, UnfittedKeys};
use greenstick_skin::rods::{FractureState, Wood};
use greenstick_wood::stem::{StemError, StemLocation, StemOptions};

/// Why nothing is fitted.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The run cannot be read.
    #[error(transparent)]
    Run(#[from] FilmError),
    /// Nothing broke.
    #[error(
        "no rod is broken at {time:.4} s, so there is no break to fit; take a later frame, or simulate longer or harder"
    )]
    NoBreak {
        /// Time of the frame, s.
        time: f64,
    },
    /// No break can be drawn where the rods broke.
    #[error("the rods broke at {at} of the stem, where no break can be drawn: {error}")]
    Location {
        /// The location.
        at: StemLocation,
        /// Why.
        error: Box<Error>,
    },
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl FitError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            FitError::Cancelled(_) => ErrorKind::Cancelled,
            FitError::Run(error) => error.kind(),
            FitError::NoBreak { .. } => ErrorKind::Request,
            FitError::Location { .. } => ErrorKind::Work,
        }
    }
}

/// Parameters of a break as a run had it.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The recipe.
    pub recipe: Recipe,
    /// The location along the stem: a point where the run is of the limb at a point, else a fraction of the length.
    pub location: StemLocation,
    /// What was fitted.
    pub report: FitReport,
}

/// The scene and frame that a break is fitted in.
#[derive(Clone, Copy)]
pub struct FitSource<'a> {
    /// The scene that the wood's stem was found in.
    pub scene: &'a Scene,
    /// Whether the stem is known by a point on it, and not as the main one.
    pub by_point: bool,
    /// Seed of the recipe.
    pub seed: u64,
    /// Time of the frame, s.
    pub time: f64,
}

/// Fits the break in frame `number` of a run.
///
/// # Errors
/// [`FitError`].
pub fn fit(run: &mut Run, number: usize, context: &Context) -> Result<Fit, FitError> {
    context.report(0.0)?;
    let (state, time) = run.fracture_state(number).map_err(FilmError::from)?;
    let source = FitSource {
        scene: run.input(),
        by_point: matches!(run.scene.stem.at, StemLocation::Point(_)),
        seed: run.scene.seed,
        time,
    };
    fit_fracture_state(&run.wood(), &state, &source, context)
}

const SEARCH: Stage = Stage::new("fit");
const STEM: Stage = Stage::new("stem");
const RELIEF: Stage = Stage::new("heights");

/// Fits the break of `wood` in a state of fracture.
///
/// # Errors
/// [`FitError`].
pub fn fit_fracture_state(
    wood: &Wood,
    state: &FractureState,
    source: &FitSource,
    context: &Context,
) -> Result<Fit, FitError> {
    let [search, locating, matching] = context.split([(SEARCH, 0.3), (STEM, 0.3), (RELIEF, 0.4)]);
    search.report(0.0)?;
    let Some(found) = BreakFit::new(wood, state, source.seed) else {
        return Err(FitError::NoBreak { time: source.time });
    };
    let place = found.location(source.by_point);
    let request = BreakRequest {
        stem: StemOptions {
            kind: Some(wood.stem.kind),
            ..StemOptions::default()
        },
        ..BreakRequest::single(Break {
            place,
            ..Break::default()
        })
    };
    let refused = |error| match error {
        Error::Cancelled(cancelled) | Error::Stem(StemError::Cancelled(cancelled)) => {
            FitError::Cancelled(cancelled)
        }
        error => FitError::Location {
            at: place,
            error: Box::new(error),
        },
    };
    let mut session = BreakSession::new(source.scene.clone());
    let prepared = session.stem(&request, &locating).map_err(refused)?.sound;
    matching.report(0.0)?;
    let to_grain = |p| prepared.layers.to_grain(p);
    let mut fitted = found.face(&place, &prepared.found.stem, &to_grain);
    let quiet = matching.silenced();
    fitted
        .match_relief(|face| {
            let mut request = request.clone();
            request.breaks[0].recipe.face = face.clone();
            session.relief_range(&request, &quiet)
        })
        .map_err(refused)?;
    matching.report(1.0)?;
    let (face, report) = fitted.finish();
    let recipe = Recipe {
        face,
        ..Recipe::default()
    };
    Ok(Fit {
        recipe,
        location: place,
        report,
    })
}
