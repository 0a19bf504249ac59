//! Faces that a run decided, cut into the mesh that was simulated.
//!
//! [`simulated_faces`] reads where and how a run parted its wood ([`greenstick_skin::simulated`]), and returns the request that
//! breaks the run's input there, which a [`BreakSession`] takes like any other.

use crate::film::FilmError;
use crate::{Break, BreakRequest, BreakSession, Broken, Error};
use greenstick_fibre::scene::Scene as Setting;
use greenstick_fracture::height_grid::HeightGrid;
use greenstick_fracture::heights::HeightFieldError;
use greenstick_geometry::{Cancelled, Context, ErrorKind, Scene};
use greenstick_skin::film::Run;
use greenstick_skin::rods::Wood;
pub use greenstick_skin::simulated::{
    ModeShare, ObservedRun, PartlyBroken, SimulatedFaceReport, SimulatedFracture, WoodHolds,
};
use greenstick_wood::stem::{StemError, StemLocation, StemOptions};

/// Why there is no face.
#[derive(Debug, thiserror::Error)]
pub enum SimulatedFacesError {
    /// The run cannot be read.
    #[error(transparent)]
    Run(#[from] FilmError),
    /// The wood holds together.
    #[error(transparent)]
    Holds(#[from] WoodHolds),
    /// No break can be drawn where the rods broke.
    #[error("the rods broke at {at} of the stem, where no break can be drawn: {error}")]
    Location {
        /// The location.
        at: StemLocation,
        /// Why.
        error: Box<Error>,
    },
    /// The input cannot be cut there.
    #[error(transparent)]
    Cut(Box<Error>),
    /// The heights are no numbers.
    #[error(transparent)]
    Heights(#[from] HeightFieldError),
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SimulatedFacesError {
    /// Whether there is no face because the wood holds together.
    pub fn wood_holds(&self) -> bool {
        matches!(self, SimulatedFacesError::Holds(_))
    }

    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SimulatedFacesError::Cancelled(_) => ErrorKind::Cancelled,
            SimulatedFacesError::Run(error) => error.kind(),
            SimulatedFacesError::Holds(_) => ErrorKind::Request,
            SimulatedFacesError::Cut(error) => error.kind(),
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
    /// The fractures, in the same order.
    pub fractures: Vec<SimulatedFracture>,
    /// The frame that decided them.
    pub observed: ObservedRun,
}

impl SimulatedFaces {
    /// Returns the input broken along the faces.
    ///
    /// # Errors
    /// As [`BreakSession::broken`].
    pub fn broken(&mut self, context: &Context) -> Result<Broken, Error> {
        self.session.broken(&self.request, context)
    }
}

/// Returns the faces of the wood in frame `number` of a run, from the base of the stem to its tip.
///
/// # Errors
/// [`SimulatedFacesError`].
pub fn simulated_faces(
    run: &Run,
    number: usize,
    partly: PartlyBroken,
    context: &Context,
) -> Result<SimulatedFaces, SimulatedFacesError> {
    context.report(0.0)?;
    let observed = run.observed(number).map_err(FilmError::from)?;
    let source = (run.input(), &run.scene);
    faces_of_wood((&run.wood(), observed), source, partly, context)
}

/// Returns the faces of `wood` with these breaks. `input` is the scene that its stem is of, `setting` the one that was simulated.
///
/// # Errors
/// [`SimulatedFacesError`].
pub fn faces_of_wood(
    (wood, observed): (&Wood, ObservedRun),
    (input, setting): (&Scene, &Setting),
    partly: PartlyBroken,
    context: &Context,
) -> Result<SimulatedFaces, SimulatedFacesError> {
    let fractures = SimulatedFracture::find_drawable(wood, &observed, partly)?;
    let by_point = matches!(setting.stem.at, StemLocation::Point(_));
    let mut request = BreakRequest {
        stem: StemOptions {
            kind: Some(wood.stem.kind),
            eccentricity_onset: setting.stem.eccentricity_onset,
            slope_of_grain: 0.0,
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
        let face = fracture.face((wood, &observed), &place, found, &to_grain, setting.seed)?;
        one.recipe.face = face.parameters;
        one.heights = HeightGrid::from(&face.field);
        request.breaks.push(one);
        reports.push(face.report);
    }
    Ok(SimulatedFaces {
        session,
        request,
        reports,
        fractures,
        observed,
    })
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
