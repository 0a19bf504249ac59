//! Parameters as they are fitted, each with what it comes from.

use greenstick_fracture::parameters::BreakParameters;
use greenstick_schema::{Parameters, Value};
use serde::Serialize;

/// A parameter that a run told.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedValue {
    /// Its key.
    pub key: &'static str,
    /// The value, in the parameter's unit.
    pub value: f64,
    /// How many breaks it comes from.
    pub breaks: usize,
    /// What it is, in words.
    pub basis: String,
}

/// What a run did not tell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Untold {
    /// Which parameters.
    pub keys: &'static str,
    /// Why.
    pub why: String,
}

/// The parameters of a broken face as far as they are known.
#[derive(Debug, Clone, Default)]
pub(super) struct Sheet {
    pub face: BreakParameters,
    pub values: Vec<FittedValue>,
    pub untold: Vec<Untold>,
}

/// No value is known better.
const ROUNDED: f64 = 1e3;

impl Sheet {
    /// Sets a parameter to the nearest value in its range.
    pub fn put(&mut self, key: &'static str, value: f64, breaks: usize, basis: impl Into<String>) {
        let table = BreakParameters::table();
        let range = table.iter().find(|p| p.key == key);
        let Some((least, most)) = range.and_then(|p| p.min().zip(p.max())) else {
            return self.leave(key, "it is no number");
        };
        let mut basis = basis.into();
        let inside = value.clamp(least, most);
        if inside != value {
            basis += &format!(", {value:.3} brought into its range");
        }
        let rounded = (inside * ROUNDED).round() / ROUNDED;
        if let Err(error) = self.face.set(key, &Value::Number(rounded)) {
            return self.leave(key, error.to_string());
        }
        self.values.retain(|v| v.key != key);
        self.values.push(FittedValue {
            key,
            value: rounded,
            breaks,
            basis,
        });
    }

    /// Says why parameters stay as they are.
    pub fn leave(&mut self, keys: &'static str, why: impl Into<String>) {
        let why = why.into();
        self.untold.push(Untold { keys, why });
    }
}
