//! Recipes: a TOML file of parameters, species, moisture, presets and cracks, and the layers they
//! are put in.
//!
//! ```toml
//! preset = "splintering-tension"   # or a list: ["fig17", "fig21"]
//! species = "oak, white"
//! moisture = 12                    # percent of the oven-dry mass
//!
//! [break]
//! slab_height = 1.5
//! diameter = "12 mm"
//! sapwood.perlin_amplitude = 0.1
//!
//! [crack_groups]
//! end = "sawn"
//! large.count = 4
//!
//! [[crack]]
//! kind = "radial"
//! angle = 80
//! ```
//!
//! Layers, later over earlier: defaults, presets, recipe, settings (`key=value`). Cracks in a
//! recipe replace those of a preset.

mod read;

use crate::parameters::{
    BreakParameters, CrackParameters, ParameterError, ParameterInfo, Parameters, Value,
};
use crate::presets::{Preset, UnknownPreset};
use greenstick_wood::moisture::{
    AIR_DRY_PERCENT, FIBRE_SATURATION_PERCENT, MoistureError, WETTEST_PERCENT, drying,
};
use greenstick_wood::species::{Species, UnknownSpecies};
use greenstick_wood::spelling::did_you_mean;
use serde::{Deserialize, Serialize};

/// Total tangential shrinkage, green to oven-dry, where the species is unknown: near the mean of
/// Table 4-3 of the Wood Handbook.
pub const TYPICAL_TANGENTIAL_SHRINKAGE: f64 = 0.08;
/// Total radial shrinkage, likewise.
pub const TYPICAL_RADIAL_SHRINKAGE: f64 = 0.045;

/// What is wrong with a part of a recipe.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// Not TOML.
    #[error("not valid TOML: {0}")]
    Syntax(String),
    /// A parameter.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A preset's name.
    #[error(transparent)]
    Preset(#[from] UnknownPreset),
    /// A species' name.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// A moisture content.
    #[error(transparent)]
    Moisture(#[from] MoistureError),
    /// A key at the top of the file, or a table, that is not known.
    #[error("unknown entry \"{key}\"{}", did_you_mean(nearest))]
    UnknownEntry {
        /// The key found.
        key: String,
        /// Keys that are near it.
        nearest: Vec<String>,
    },
    /// A value of the wrong kind.
    #[error("{key} is {found}, but it must be {expected}")]
    Type {
        /// The key.
        key: String,
        /// The kind found.
        found: &'static str,
        /// The kind that would be right.
        expected: &'static str,
    },
    /// A setting without "=".
    #[error("a setting is written key=value")]
    NotASetting,
}

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecipeError {
    /// In the recipe's text.
    #[error("line {line}, column {column}: {problem}")]
    At {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What is wrong.
        problem: Problem,
    },
    /// In a setting.
    #[error("setting \"{setting}\": {problem}")]
    Setting {
        /// The setting as given.
        setting: String,
        /// What is wrong.
        problem: Problem,
    },
    /// In what the layers give together, or in a preset that was asked for outside the recipe.
    #[error(transparent)]
    Whole(#[from] Problem),
}

/// Everything that a break is made from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Recipe {
    /// Presets that were applied, in order. The parameters hold what they gave.
    pub presets: Vec<String>,
    /// Name of the species, as in its table.
    pub species: Option<String>,
    /// Moisture content, percent of the oven-dry mass.
    pub moisture: Option<f64>,
    /// The broken face.
    #[serde(rename = "break")]
    pub face: BreakParameters,
    /// Drying cracks.
    pub cracks: CrackParameters,
}

/// Shrinkages that cracks open by, as fractions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CrackShrinkage {
    /// Along the rings: opens radial cracks.
    pub tangential: f64,
    /// Across the rings: opens tangential cracks.
    pub radial: f64,
    /// Where the values come from, for a report.
    pub basis: String,
}

impl Recipe {
    /// The recipe of the layers: defaults, then `presets` (the text's own where this is empty),
    /// then `text`, then `settings` of the form `key=value`; checked as a whole.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line in `text` or its setting.
    pub fn resolve(
        presets: &[&str],
        text: Option<&str>,
        settings: &[&str],
    ) -> Result<Recipe, RecipeError> {
        let mut recipe = Recipe::default();
        for name in presets {
            recipe.apply_preset(name)?;
        }
        if let Some(text) = text {
            recipe.apply_text(text, presets.is_empty())?;
        }
        for setting in settings {
            recipe.apply_setting(setting)?;
        }
        recipe.check()?;
        Ok(recipe)
    }

    /// The recipe of a TOML text alone.
    ///
    /// # Errors
    /// As [`Recipe::resolve`].
    pub fn from_toml(text: &str) -> Result<Recipe, RecipeError> {
        Recipe::resolve(&[], Some(text), &[])
    }

    /// Puts a preset over what it is about, as [`Preset::apply`].
    ///
    /// # Errors
    /// A name that is no preset.
    pub fn apply_preset(&mut self, name: &str) -> Result<(), Problem> {
        let preset = Preset::find(name)?;
        preset.apply(&mut self.face, &mut self.cracks)?;
        self.presets.push(preset.name.to_owned());
        Ok(())
    }

    /// Puts a TOML text over the recipe; `with_presets` says whether the presets it names are
    /// applied first.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line.
    pub fn apply_text(&mut self, text: &str, with_presets: bool) -> Result<(), RecipeError> {
        read::apply(self, text, with_presets)
    }

    /// Puts one setting, `key=value`. Keys are those of `[break]`, with or without `break.` before
    /// them, those of `crack_groups.`, `species` and `moisture`.
    ///
    /// # Errors
    /// What is wrong with the setting.
    pub fn apply_setting(&mut self, setting: &str) -> Result<(), RecipeError> {
        let wrong = |problem| RecipeError::Setting {
            setting: setting.to_owned(),
            problem,
        };
        let (key, text) = setting
            .split_once('=')
            .ok_or_else(|| wrong(Problem::NotASetting))?;
        let (key, text) = (key.trim(), text.trim());
        let done = match key {
            "species" => self.set_species(text),
            "moisture" => text
                .trim_end_matches('%')
                .trim()
                .parse()
                .map_err(|_| {
                    Problem::Parameter(ParameterError::NotANumber {
                        key: key.to_owned(),
                        found: text.to_owned(),
                        units: "%".to_owned(),
                    })
                })
                .and_then(|m| self.set_moisture(m)),
            _ => match key.strip_prefix("crack_groups.") {
                Some(key) => self
                    .cracks
                    .settings
                    .set_text(key, text)
                    .map_err(Problem::from),
                None => {
                    let key = key.strip_prefix("break.").unwrap_or(key);
                    self.face.set_text(key, text).map_err(Problem::from)
                }
            },
        };
        done.map_err(wrong)
    }

    /// Sets the species by any of its names.
    ///
    /// # Errors
    /// A name that is no species.
    pub fn set_species(&mut self, name: &str) -> Result<(), Problem> {
        self.species = Some(Species::find(name)?.name.clone());
        Ok(())
    }

    /// Sets the moisture content, percent.
    ///
    /// # Errors
    /// Not above 0 and at most 200.
    pub fn set_moisture(&mut self, percent: f64) -> Result<(), Problem> {
        self.moisture = Some(valid_moisture(percent)?);
        Ok(())
    }

    /// Checks everything, as is needed after fields were written directly.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), Problem> {
        self.face.check()?;
        self.cracks.check()?;
        self.species()?;
        self.moisture.map(valid_moisture).transpose()?;
        Ok(())
    }

    /// The species, where one is named.
    ///
    /// # Errors
    /// A name that is no species.
    pub fn species(&self) -> Result<Option<&'static Species>, UnknownSpecies> {
        self.species.as_deref().map(Species::find).transpose()
    }

    /// Shrinkages at the recipe's moisture (12 % where it names none), of its species, or typical
    /// ones where it names none or the tables have no value.
    ///
    /// # Errors
    /// A name that is no species, or a moisture content out of range.
    pub fn crack_shrinkage(&self) -> Result<CrackShrinkage, Problem> {
        let moisture = self.moisture.unwrap_or(AIR_DRY_PERCENT);
        let part = drying(moisture, FIBRE_SATURATION_PERCENT)?;
        let species = self.species()?;
        let table = species.map(|s| s.shrinkage).unwrap_or_default();
        let missing = table.tangential.is_none() || table.radial.is_none();
        let of = match species {
            Some(s) if !missing => format!("shrinkage of {}", s.name),
            Some(s) => format!("typical shrinkage, as the tables lack that of {}", s.name),
            None => "typical shrinkage, as no species is named".to_owned(),
        };
        Ok(CrackShrinkage {
            tangential: table.tangential.unwrap_or(TYPICAL_TANGENTIAL_SHRINKAGE) * part,
            radial: table.radial.unwrap_or(TYPICAL_RADIAL_SHRINKAGE) * part,
            basis: format!("{of}, dried to {moisture} %"),
        })
    }

    /// The recipe as TOML with every parameter, so that it means the same whatever defaults and
    /// presets become. Presets are a comment in it.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        if !self.presets.is_empty() {
            text.push_str(&format!("# from presets: {}\n", self.presets.join(", ")));
        }
        if let Some(species) = &self.species {
            text.push_str(&format!("species = {}\n", quoted(species)));
        }
        if let Some(moisture) = self.moisture {
            text.push_str(&format!("moisture = {moisture:?}\n"));
        }
        text.push_str("\n[break]\n");
        write_all(&self.face.list(), &mut text);
        text.push_str("\n[crack_groups]\n");
        write_all(&self.cracks.settings.list(), &mut text);
        for crack in &self.cracks.cracks {
            text.push_str(&format!("\n[[crack]]\nkind = {}\n", quoted(crack.kind())));
            write_all(&crack.list(), &mut text);
        }
        text
    }
}

fn valid_moisture(percent: f64) -> Result<f64, MoistureError> {
    if percent > 0.0 && percent <= WETTEST_PERCENT {
        Ok(percent)
    } else {
        Err(MoistureError::OutOfRange(percent))
    }
}

fn write_all(list: &[ParameterInfo], text: &mut String) {
    for p in list {
        let value = match &p.value {
            // {:?} writes a point or an exponent and every digit that is needed to read the same
            // number again.
            Value::Number(x) => format!("{x:?}"),
            Value::Integer(n) => n.to_string(),
            Value::Text(t) => quoted(t),
        };
        text.push_str(&format!("{} = {value}\n", p.key));
    }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests;
