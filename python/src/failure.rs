//! Errors of the library as exceptions of `greenstick.errors`: one class for each, the message unchanged.

use greenstick::files::FileError;
use greenstick::formats::FormatError;
use greenstick::geometry::Cancelled;
use greenstick::picture::PictureError;
use greenstick::schema::ParameterError;
use greenstick::wood::species::UnknownSpecies;
use greenstick::{Error, ErrorKind, RequestFileError};
use greenstick_sweep::InputError;
use pyo3::prelude::*;
use std::path::Path;

/// An error on its way to Python.
#[derive(Debug)]
pub struct Failure {
    class: &'static str,
    kind: ErrorKind,
    message: String,
}

impl Failure {
    /// An error that is an exception of the class `class` of `greenstick.errors`.
    pub fn new(class: &'static str, kind: ErrorKind, message: impl ToString) -> Self {
        Failure {
            class,
            kind,
            message: message.to_string(),
        }
    }

    /// A request that is wrong in a way that only Python knows, such as an array of another shape.
    pub fn value(message: impl ToString) -> Self {
        Failure::new("InputError", ErrorKind::Request, message)
    }

    /// A report that cannot be turned into JSON.
    pub fn report(error: serde_json::Error) -> Self {
        Failure::new("ReportError", ErrorKind::Work, error)
    }

    /// Puts the name of a file before the message.
    pub fn about(self, file: &Path) -> Self {
        Failure {
            message: format!("{}: {}", file.display(), self.message),
            ..self
        }
    }
}

/// The word for a kind, the attribute `kind` of an exception.
fn kind_word(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::Cancelled => "cancelled",
        ErrorKind::Request => "request",
        ErrorKind::Work => "work",
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> PyErr {
        Python::attach(|py| {
            let class = match failure.kind {
                ErrorKind::Cancelled => "Cancelled",
                _ => failure.class,
            };
            let made = py
                .import("greenstick.errors")
                .and_then(|module| module.getattr(class))
                .and_then(|class| class.call1((&failure.message, kind_word(failure.kind))));
            made.map_or_else(|error| error, PyErr::from_value)
        })
    }
}

/// Turns errors that have a kind into failures of a class.
macro_rules! failures {
    ($($error:ty => $class:literal,)*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Failure::new($class, error.kind(), error)
            }
        })*
    };
}
failures! {
    FileError => "FileError",
    PictureError => "PictureError",
}

/// Turns errors that always mean a wrong request into failures of a class.
macro_rules! request_failures {
    ($($error:ty => $class:literal,)*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Failure::new($class, ErrorKind::Request, error)
            }
        })*
    };
}
request_failures! {
    ParameterError => "ParameterError",
    RequestFileError => "ParameterError",
    UnknownSpecies => "SpeciesError",
}

impl From<Cancelled> for Failure {
    fn from(error: Cancelled) -> Self {
        Failure::new("Cancelled", ErrorKind::Cancelled, error)
    }
}

impl From<FormatError> for Failure {
    fn from(error: FormatError) -> Self {
        Failure::new("FormatError", ErrorKind::Work, error)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        let class = match &error {
            Error::Stem(_) | Error::Places(_) => "StemError",
            Error::Cut { .. } => "CutError",
            Error::Recipe(_) | Error::Parameter(_) | Error::Amount(_) => "ParameterError",
            Error::Species(_) => "SpeciesError",
            Error::Moisture(_) => "MoistureError",
            Error::Texture(_) => "TextureError",
            Error::Crack(_) => "CrackError",
            Error::Scan(_) => "ScanError",
            Error::Anatomy(_) => "AnatomyError",
            Error::Format(_) => "FormatError",
            Error::Report(_) => "ReportError",
            Error::Cancelled(_) => "Cancelled",
        };
        Failure::new(class, error.kind(), error)
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        let class = match &error {
            InputError::File(_) => "FileError",
            InputError::Scan { .. } => "ScanError",
            InputError::Cancelled(_) => "Cancelled",
        };
        Failure::new(class, error.kind(), error)
    }
}
