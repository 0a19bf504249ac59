//! Errors of scenes.

use crate::bodies::BodyError;
use crate::error::LoadError;
use greenstick_geometry::Cancelled;
use greenstick_schema::{DocumentError, ParameterError, did_you_mean};

/// Why a scene cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A part of the file that is wrong.
    #[error(transparent)]
    Document(Box<DocumentError>),
    /// A value that is wrong.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// There is no scene of this name.
    #[error("there is no scene \"{name}\"{}", did_you_mean(nearest))]
    UnknownScene {
        /// The name.
        name: String,
        /// Similar names.
        nearest: Vec<String>,
    },
    /// A clamp that holds no vertex.
    #[error(
        "clamp {clamp} holds nothing: no vertex lies from {from} to {to} of the length; vertices are up to {apart} apart there"
    )]
    EmptyClamp {
        /// Number of the clamp, from 0.
        clamp: usize,
        /// Start of its range, of the length.
        from: f64,
        /// End of its range.
        to: f64,
        /// Largest distance between vertices, of the length.
        apart: f64,
    },
    /// Key frames out of order.
    #[error("key frames of {what} must follow each other in time; {time} s does not")]
    Keys {
        /// The clamp or body.
        what: String,
        /// The time that is out of order, s.
        time: f64,
    },
    /// A clamp that cannot preserve the wood's length.
    #[error("clamp {clamp} has arc = true: {problem}")]
    Arc {
        /// Number of the clamp, from 0.
        clamp: usize,
        /// Why it cannot.
        problem: String,
    },
    /// A body that misses the stem.
    #[error(
        "body {body} never touches the stem when it comes from ({x}, {y}, {z}); change `touch`, `at` or `place`"
    )]
    Misses {
        /// Number of the body.
        body: usize,
        /// Direction from which it comes, x.
        x: f64,
        /// The same, y.
        y: f64,
        /// The same, z.
        z: f64,
    },
    /// A body without its mesh.
    #[error("body {body} is a {shape}, which needs the name of a mesh file: file = \"block.stl\"")]
    NoMesh {
        /// Number of the body.
        body: usize,
        /// Its shape.
        shape: &'static str,
    },
    /// A solver that cannot run the scene.
    #[error("the {solver} solver cannot be used here: {problem}; choose {right}")]
    Solver {
        /// The solver.
        solver: &'static str,
        /// Why it cannot.
        problem: String,
        /// Solvers that can.
        right: &'static str,
    },
    /// A body does not fit.
    #[error(transparent)]
    Body(BodyError),
    /// A load does not fit.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<BodyError> for SceneError {
    fn from(error: BodyError) -> Self {
        match error {
            BodyError::Cancelled(cancelled) => SceneError::Cancelled(cancelled),
            other => SceneError::Body(other),
        }
    }
}

impl From<DocumentError> for SceneError {
    fn from(error: DocumentError) -> Self {
        SceneError::Document(Box::new(error))
    }
}
