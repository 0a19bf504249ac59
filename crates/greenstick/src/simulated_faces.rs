//! Faces that a run decided, cut into the mesh that was simulated.
//!
//! [`simulated_faces`] reads where and how a run parted its wood, and returns the request that breaks the run's input there,
//! which a [`BreakSession`] takes like any other. The algorithm is that of
//! [`greenstick_skin::simulated`]; here it meets the run and the chain that draws a break.

use crate::film::FilmError;
use crate::{Break, BreakRequest, BreakSession, Broken, Error};
use greenstick_fibre::scene::Scene as Setting;
use greenstick_fracture::heights::{HeightFieldError, HeightSource};
use greenstick_fracture::recipe::{RecipeError, apply_setting};
use greenstick_geometry::{Cancelled, Context, ErrorKind, Scene};
use greenstick_skin::film::Run;
use greenstick_skin::rods::Wood;
use greenstick_skin::simulated::SimulatedFracture;
pub use greenstick_skin::simulated::{ModeShare, ObservedRun, SimulatedFaceReport};
use greenstick_wood::stem::{StemError, StemLocation, StemOptions};
use std::sync::Arc;

/// Why there is no face.
#[derive(Debug, thiserror::Error)]
pub enum SimulatedFacesError {
    /// The run cannot be read.
    #[error(transparent)]
    Run(#[from] FilmError),
    /// Nothing broke.
    #[error(
        "no rod is broken at {time:.4} s, so there is no face to draw; take a later frame, or simulate longer or harder"
    )]
    NoBreak {
        /// Time of the frame, s.
        time: f64,
    },
    /// Too little broke: the wood holds.
    #[error(
        "only {:.0} % of the section is broken at {time:.4} s and the wood holds, so there is no face to draw; it takes half of \
         the section: take a later frame, or simulate longer or harder",
        100.0 * share
    )]
    Holds {
        /// Share of the section that is broken, 0 to 1.
        share: f64,
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
    /// The heights are no numbers.
    #[error(transparent)]
    Heights(#[from] HeightFieldError),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SimulatedFacesError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SimulatedFacesError::Cancelled(_) => ErrorKind::Cancelled,
            SimulatedFacesError::Run(error) => error.kind(),
            SimulatedFacesError::NoBreak { .. } | SimulatedFacesError::Holds { .. } => {
                ErrorKind::Request
            }
            SimulatedFacesError::Location { .. } | SimulatedFacesError::Heights(_) => {
                ErrorKind::Work
            }
        }
    }
}

/// The faces of a run.
#[derive(Debug)]
pub struct SimulatedFaces {
    /// A session of the run's input, in which its stem is found already.
    pub session: BreakSession,
    /// The request that breaks it along the faces.
    pub request: BreakRequest,
    /// What each was made from, in the order of the request's breaks.
    pub reports: Vec<SimulatedFaceReport>,
}

impl SimulatedFaces {
    /// Returns the input broken along the faces.
    ///
    /// # Errors
    /// As [`BreakSession::broken`].
    pub fn broken(&mut self, context: &Context) -> Result<Broken, Error> {
        self.session.broken(&self.request, context)
    }

    /// Applies a setting of a recipe, `key=value`, to all breaks.
    ///
    /// # Errors
    /// What is wrong with the setting.
    pub fn apply_setting(&mut self, setting: &str) -> Result<(), RecipeError> {
        let mut breaks = self.request.breaks.iter_mut();
        breaks.try_for_each(|one| apply_setting(one, setting))
    }
}

/// Least share of the section that is broken where wood that still hangs together is drawn as broken.
const MIN_BROKEN_SHARE: f64 = 0.5;

/// Returns the faces of the wood in frame `number` of a run, from the base of the stem to its tip.
///
/// # Errors
/// [`SimulatedFacesError`].
pub fn simulated_faces(
    run: &Run,
    number: usize,
    context: &Context,
) -> Result<SimulatedFaces, SimulatedFacesError> {
    context.report(0.0)?;
    let observed = run.observed(number).map_err(FilmError::from)?;
    faces_of_wood((&run.wood(), &observed), run.input(), &run.scene, context)
}

/// Returns the faces of `wood` with these breaks, from the base of its stem to its tip. `input` is the scene that the stem
/// was found in, `setting` the scene that was simulated.
///
/// # Errors
/// [`SimulatedFacesError`].
pub fn faces_of_wood(
    (wood, observed): (&Wood, &ObservedRun),
    input: &Scene,
    setting: &Setting,
    context: &Context,
) -> Result<SimulatedFaces, SimulatedFacesError> {
    let fractures = drawable_fractures(wood, observed)?;
    let by_point = matches!(setting.stem.at, StemLocation::Point(_));
    let mut request = BreakRequest {
        stem: StemOptions {
            kind: Some(wood.stem.kind),
            eccentricity_onset: setting.stem.eccentricity_onset,
            ..StemOptions::default()
        },
        rings: setting.rings.clone(),
        breaks: Vec::new(),
        ..BreakRequest::default()
    };
    let mut reports = Vec::new();
    let mut session = BreakSession::new(input.clone());
    for (at, fracture) in fractures.iter().enumerate() {
        let place = fracture.location(wood, by_point);
        let mut one = Break {
            place,
            ..Break::default()
        };
        one.recipe.species = Some(setting.wood.species.clone());
        one.recipe.moisture = Some(setting.wood.moisture);
        let alone = BreakRequest {
            breaks: vec![one.clone()],
            ..request.clone()
        };
        let context = context.item(at, fractures.len());
        let stem = session
            .stem(&alone, &context)
            .map_err(|error| refused(error, place))?
            .sound;
        let to_grain = |p| stem.layers.to_grain(p);
        let found = &stem.found.stem;
        let face = fracture.face((wood, observed), &place, found, &to_grain, setting.seed)?;
        one.recipe.face = face.parameters;
        one.heights = HeightSource::Field(Arc::new(face.field));
        request.breaks.push(one);
        reports.push(face.report);
    }
    Ok(SimulatedFaces {
        session,
        request,
        reports,
    })
}

/// Returns the fractures that faces are drawn for.
fn drawable_fractures(
    wood: &Wood,
    observed: &ObservedRun,
) -> Result<Vec<SimulatedFracture>, SimulatedFacesError> {
    let fractures = SimulatedFracture::find(wood, observed);
    let time = observed.time;
    let Some(first) = fractures.first() else {
        return Err(SimulatedFacesError::NoBreak { time });
    };
    let share = first.broken_share(wood);
    if !first.parted && share < MIN_BROKEN_SHARE {
        return Err(SimulatedFacesError::Holds { share, time });
    }
    Ok(fractures)
}

/// The error of a stem that cannot be broken at a place.
fn refused(error: Error, at: StemLocation) -> SimulatedFacesError {
    match error {
        Error::Cancelled(cancelled) | Error::Stem(StemError::Cancelled(cancelled)) => {
            SimulatedFacesError::Cancelled(cancelled)
        }
        error => SimulatedFacesError::Location {
            at,
            error: Box::new(error),
        },
    }
}
