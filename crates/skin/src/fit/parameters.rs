//! Fitted parameters, each with what it comes from.

use greenstick_fracture::parameters::BreakParameters;
use greenstick_schema::{Parameters, Value};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A parameter that was fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedValue {
    /// Its key.
    pub key: Cow<'static, str>,
    /// The value, in the parameter's unit.
    pub value: f64,
    /// Number of breaks that it comes from.
    pub breaks: usize,
    /// What it comes from, in words.
    pub basis: String,
}

/// Parameters that were not fitted and keep their defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnfittedKeys {
    /// Which parameters.
    pub keys: Cow<'static, str>,
    /// Why.
    pub why: String,
}

/// The parameters of a broken face as far as they are fitted.
#[derive(Debug, Clone, Default)]
pub(super) struct FittedParameters {
    pub face: BreakParameters,
    pub values: Vec<FittedValue>,
    pub unfitted: Vec<UnfittedKeys>,
}

/// Values are rounded to one over this: no fit is more precise.
const DECIMALS: f64 = 1e3;

/// Parameters that no run decides, with the reason.
const NEVER_FITTED: [(&str, &str); 6] = [
    (
        "pith_proportion, heartwood_proportion, phloem_proportion, *.thorn_length and *.thorn_probability of tissues",
        "rods have no tissue; thorns are fitted for the ductile and the brittle zone",
    ),
    (
        "slab_count, sliver_count, bundle_aspect, fibre_height, step_height, thorn_shaft",
        "they are finer than rods",
    ),
    (
        "bark_offset, bark_height, bark_strips",
        "the bark breaks with the rods under it",
    ),
    (
        "split, hang, spiral_angle",
        "the fit does not look for them",
    ),
    (
        "diameter, rings, sectors, *.white_noise_amplitude, *_octaves, *.perlin_frequency",
        "they decide how a face is drawn",
    ),
    (
        "species, moisture",
        "they would scale the fitted heights; a species in the recipe does so",
    ),
];

impl FittedParameters {
    /// Sets a parameter to the nearest value in its range. A later value for a key replaces the earlier one.
    pub fn set(
        &mut self,
        key: impl Into<Cow<'static, str>>,
        value: f64,
        breaks: usize,
        basis: impl Into<String>,
    ) {
        let key = key.into();
        let table = BreakParameters::table();
        let range = table.iter().find(|p| p.key == key);
        let Some((least, most)) = range.and_then(|p| p.min().zip(p.max())) else {
            return self.leave(key, "it is no number");
        };
        let mut basis = basis.into();
        let inside = value.clamp(least, most);
        if inside != value {
            basis += &format!(", {value:.3} limited to the parameter's range");
        }
        let rounded = (inside * DECIMALS).round() / DECIMALS;
        if let Err(error) = self.face.set(&key, &Value::Number(rounded)) {
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

    /// Leaves parameters at their defaults, and says why.
    pub fn leave(&mut self, keys: impl Into<Cow<'static, str>>, why: impl Into<String>) {
        let why = why.into();
        self.unfitted.push(UnfittedKeys {
            keys: keys.into(),
            why,
        });
    }

    /// Leaves the parameters that no run decides at their defaults.
    pub fn leave_others(&mut self) {
        for (keys, why) in NEVER_FITTED {
            self.leave(keys, why);
        }
    }
}
