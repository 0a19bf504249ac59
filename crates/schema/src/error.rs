//! What is wrong with a parameter.

use crate::spelling::did_you_mean;

/// What is wrong with a parameter.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// No parameter of this name.
    #[error("unknown parameter \"{key}\"{}", did_you_mean(nearest))]
    UnknownKey {
        /// The key found.
        key: String,
        /// Up to three keys that are near it.
        nearest: Vec<String>,
    },
    /// A number outside its range, or not a number.
    #[error("{key} is {found}, but it must be {range}")]
    OutOfRange {
        /// The parameter.
        key: String,
        /// The value found, in the parameter's unit.
        found: f64,
        /// The range, with its unit.
        range: String,
    },
    /// Not a whole number, or one outside its range.
    #[error("{key} is {found}, but it must be {range}")]
    Whole {
        /// The parameter.
        key: String,
        /// The value found.
        found: String,
        /// The range, with its unit.
        range: String,
    },
    /// Text that is no number, or one without the unit that it needs.
    #[error("{key} is \"{found}\", but it must be a number{}", after(units, *required))]
    NotANumber {
        /// The parameter.
        key: String,
        /// The text found.
        found: String,
        /// Units that may follow the number.
        units: String,
        /// Whether one of them must.
        required: bool,
    },
    /// A number with a unit that does not fit.
    #[error("{key} has the unit \"{found}\"; it takes {}", if units.is_empty() { "none" } else { units })]
    WrongUnit {
        /// The parameter.
        key: String,
        /// The unit found.
        found: String,
        /// Units that may follow the number.
        units: String,
    },
    /// A word that is none of the choices.
    #[error("{key} is \"{found}\", but it must be one of {options}")]
    Choice {
        /// The parameter.
        key: String,
        /// The word found.
        found: String,
        /// The words it may be.
        options: String,
    },
    /// A value of another kind.
    #[error("{key} is {found}, but it must be {expected}")]
    Kind {
        /// The parameter.
        key: String,
        /// The value found.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// Text that is not of the parameter's format.
    #[error("{key}: {problem}")]
    Format {
        /// The parameter.
        key: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// Two values that must be in order are not.
    #[error("{lower} is {low} and {upper} is {high}, but the first must not be above the second")]
    Order {
        /// Key of the lower one.
        lower: String,
        /// Its value.
        low: f64,
        /// Key of the upper one.
        upper: String,
        /// Its value.
        high: f64,
    },
    /// Values that do not go together.
    #[error("{0}")]
    Conflict(String),
}

impl ParameterError {
    /// The key of the parameter, where it is a single one.
    pub fn key(&self) -> Option<&str> {
        match self {
            ParameterError::UnknownKey { key, .. }
            | ParameterError::OutOfRange { key, .. }
            | ParameterError::Whole { key, .. }
            | ParameterError::NotANumber { key, .. }
            | ParameterError::WrongUnit { key, .. }
            | ParameterError::Choice { key, .. }
            | ParameterError::Kind { key, .. }
            | ParameterError::Format { key, .. } => Some(key),
            ParameterError::Order { .. } | ParameterError::Conflict(_) => None,
        }
    }

    /// The same of a parameter in a table or an entry of a list.
    pub fn within(mut self, place: &str) -> Self {
        match &mut self {
            ParameterError::UnknownKey { key, .. }
            | ParameterError::OutOfRange { key, .. }
            | ParameterError::Whole { key, .. }
            | ParameterError::NotANumber { key, .. }
            | ParameterError::WrongUnit { key, .. }
            | ParameterError::Choice { key, .. }
            | ParameterError::Kind { key, .. }
            | ParameterError::Format { key, .. } => *key = format!("{place}.{key}"),
            ParameterError::Order { lower, upper, .. } => {
                *lower = format!("{place}.{lower}");
                *upper = format!("{place}.{upper}");
            }
            ParameterError::Conflict(text) => *text = format!("{place}: {text}"),
        }
        self
    }
}

fn after(units: &str, required: bool) -> String {
    match (units, required) {
        ("", _) => String::new(),
        (_, true) => format!(" with a unit: {units}"),
        (_, false) => format!(", with or without a unit: {units}"),
    }
}
