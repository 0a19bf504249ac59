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

use crate::parameters::{BreakParameters, CrackParameters};
use crate::presets::{Preset, UnknownPreset};
use greenstick_schema::{
    DocumentError, ParameterError, Parameters, Unit, closest_names, number, parameters, read_table,
    text, write_toml,
};
use greenstick_wood::appearance::WoodColours;
use greenstick_wood::moisture::{
    AIR_DRY_PERCENT, FIBRE_SATURATION_PERCENT, MOISTURE_WORDS, MoistureError, WETTEST_PERCENT,
    drying,
};
use greenstick_wood::species::{SPECIES_NAME, Species, UnknownSpecies};
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue};

/// Total tangential shrinkage, green to oven-dry, where the species is unknown: near the mean of
/// Table 4-3 of the Wood Handbook.
pub const TYPICAL_TANGENTIAL_SHRINKAGE: f64 = 0.08;
/// Total radial shrinkage, likewise.
pub const TYPICAL_RADIAL_SHRINKAGE: f64 = 0.045;

/// What the keys of the broken face begin with.
const BREAK: &str = "break.";
/// Key of the presets in a file.
const PRESET: &str = "preset";

/// What is wrong with a part of a recipe.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// A parameter, or the syntax of a file.
    #[error(transparent)]
    File(#[from] greenstick_schema::Problem),
    /// A parameter of a setting, or what the layers give together.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A preset's name.
    #[error(transparent)]
    Preset(#[from] UnknownPreset),
    /// A setting without "=".
    #[error("a setting is written key=value")]
    NotASetting,
}

impl Problem {
    /// The parameter that is wrong, where it is one.
    pub fn parameter(&self) -> Option<&ParameterError> {
        match self {
            Problem::File(greenstick_schema::Problem::Parameter(error))
            | Problem::Parameter(error) => Some(error),
            _ => None,
        }
    }
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
        problem: Box<Problem>,
    },
    /// In a setting.
    #[error("setting \"{setting}\": {problem}")]
    Setting {
        /// The setting as given.
        setting: String,
        /// What is wrong.
        problem: Box<Problem>,
    },
    /// In what the layers give together, or in a preset that was asked for outside the recipe.
    #[error(transparent)]
    Whole(Box<Problem>),
}

impl From<DocumentError> for RecipeError {
    fn from(error: DocumentError) -> Self {
        RecipeError::At {
            line: error.line,
            column: error.column,
            problem: Box::new(error.problem.into()),
        }
    }
}

impl From<ParameterError> for RecipeError {
    fn from(error: ParameterError) -> Self {
        Problem::from(error).into()
    }
}

impl From<Problem> for RecipeError {
    fn from(problem: Problem) -> Self {
        RecipeError::Whole(Box::new(problem))
    }
}

impl RecipeError {
    /// What is wrong.
    pub fn problem(&self) -> &Problem {
        match self {
            RecipeError::At { problem, .. }
            | RecipeError::Setting { problem, .. }
            | RecipeError::Whole(problem) => problem,
        }
    }
}

parameters! {
    /// The wood that breaks and how it breaks.
    pub struct Recipe {
        "wood", "heights" {
            /// Species, by common or scientific name. It decides the height of the broken face and the shrinkage that
            /// cracks open by.
            species: Option<String> = None, text(SPECIES_NAME).auto();
            /// Moisture content, percent of the oven-dry mass: 12 is air-dry, 30 and more is green.
            moisture: Option<f64> = None,
                number(Unit::Percent, 0.0, WETTEST_PERCENT).above().auto().words(MOISTURE_WORDS);
        }
    }
    include {
        /// Drying cracks.
        cracks: CrackParameters = CrackParameters::default();
        /// Colours of wood and bark.
        colours: WoodColours = WoodColours::default();
    }
    tables {
        /// The broken face.
        face as "break": BreakParameters = BreakParameters::default();
    }
}

/// Why there is no shrinkage for cracks to open by.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShrinkageError {
    /// A name that is no species.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// A moisture content out of range.
    #[error(transparent)]
    Moisture(#[from] MoistureError),
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

/// A set of parameters that holds a recipe, or is one: what presets and settings are put over.
pub trait HasRecipe: Parameters {
    /// The recipe.
    fn recipe_mut(&mut self) -> &mut Recipe;
}

impl HasRecipe for Recipe {
    fn recipe_mut(&mut self) -> &mut Recipe {
        self
    }
}

/// Puts a preset over what it is about, as [`Preset::apply`].
///
/// # Errors
/// A name that is no preset.
pub fn apply_preset(target: &mut impl HasRecipe, name: &str) -> Result<(), Problem> {
    let preset = Preset::find(name)?;
    let recipe = target.recipe_mut();
    preset.apply(&mut recipe.face, &mut recipe.cracks)?;
    Ok(())
}

/// Puts a TOML text over a set of parameters; `with_presets` says whether the presets it names are applied first.
///
/// # Errors
/// The first thing that is wrong, with its line. The set may then be changed in part.
pub fn apply_toml(
    target: &mut impl HasRecipe,
    text: &str,
    with_presets: bool,
) -> Result<(), RecipeError> {
    let document = DeTable::parse(text).map_err(|e| greenstick_schema::syntax_error(text, &e))?;
    let table = document.get_ref();
    if let Some(value) = table.get(PRESET) {
        let names: Vec<_> = match value.get_ref() {
            DeValue::Array(list) => list.iter().collect(),
            _ => vec![value],
        };
        for name in names {
            let at = |problem: Problem| {
                let (line, column) = greenstick_schema::line_and_column(text, name.span().start);
                RecipeError::At {
                    line,
                    column,
                    problem: Box::new(problem),
                }
            };
            let Some(word) = name.get_ref().as_str() else {
                return Err(at(Problem::Parameter(ParameterError::Kind {
                    key: PRESET.to_owned(),
                    found: "no name in quotes".to_owned(),
                    expected: "a name in quotes, or a list of names".to_owned(),
                })));
            };
            let preset = Preset::find(word).map_err(|e| at(e.into()))?;
            if with_presets {
                apply_preset(target, preset.name).map_err(at)?;
            }
        }
    }
    read_table(target, table, text, &[PRESET])?;
    Ok(())
}

/// Puts one setting, `key=value`. Keys are those of files, tables and keys with a dot between them; those of the table
/// `break` may stand alone.
///
/// # Errors
/// What is wrong with the setting.
pub fn apply_setting(target: &mut impl HasRecipe, setting: &str) -> Result<(), RecipeError> {
    let wrong = |problem| RecipeError::Setting {
        setting: setting.to_owned(),
        problem: Box::new(problem),
    };
    let (key, text) = setting
        .split_once('=')
        .ok_or_else(|| wrong(Problem::NotASetting))?;
    let (key, text) = (key.trim(), text.trim());
    let short = |p: &str| p.strip_prefix(BREAK).unwrap_or(p).to_owned();
    let keys: Vec<String> = target.list().iter().map(|p| p.key.clone()).collect();
    if keys.iter().any(|k| k == key) && !key.starts_with(BREAK) {
        return target.set_text(key, text).map_err(|e| wrong(e.into()));
    }
    let face = &mut target.recipe_mut().face;
    let done = face.set_text(&short(key), text).map_err(|e| match e {
        ParameterError::UnknownKey { .. } => {
            let all: Vec<String> = keys.iter().map(|k| short(k)).collect();
            ParameterError::UnknownKey {
                key: key.to_owned(),
                nearest: closest_names(&short(key), all.iter().map(String::as_str)),
            }
        }
        other => other,
    });
    done.map_err(|e| wrong(e.into()))
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
            apply_preset(&mut recipe, name)?;
        }
        if let Some(text) = text {
            apply_toml(&mut recipe, text, presets.is_empty())?;
        }
        for setting in settings {
            apply_setting(&mut recipe, setting)?;
        }
        recipe.complete()?;
        Ok(recipe)
    }

    /// The recipe of a TOML text alone.
    ///
    /// # Errors
    /// As [`Recipe::resolve`].
    ///
    /// ```
    /// use greenstick_fracture::recipe::Recipe;
    ///
    /// let recipe = Recipe::from_toml("preset = \"twist\"\n[break]\nslab_height = 1.5\n")?;
    /// assert_eq!(recipe.face.slab_height, 1.5);
    /// assert!(recipe.face.spiral_angle != 0.0);
    /// # Ok::<(), greenstick_fracture::recipe::RecipeError>(())
    /// ```
    pub fn from_toml(text: &str) -> Result<Recipe, RecipeError> {
        Recipe::resolve(&[], Some(text), &[])
    }

    /// Checks everything, and brings the species to the name that its table has.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn complete(&mut self) -> Result<(), ParameterError> {
        self.check()?;
        let species = self.species().ok().flatten();
        self.species = species.map(|s| s.name.clone());
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
    pub fn crack_shrinkage(&self) -> Result<CrackShrinkage, ShrinkageError> {
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

    /// The recipe as TOML with every parameter, so that it means the same whatever defaults and presets become.
    pub fn to_toml(&self) -> String {
        write_toml(self)
    }
}

#[cfg(test)]
mod tests;
