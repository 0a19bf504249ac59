//! What decides a variant: the request of a break, a scene, or a bending test.

use crate::error::SweepError;
use crate::input::up_axis;
use crate::keys;
use crate::plan::{SweepKind, SweepSettings};
use greenstick::bending::BendSettings;
use greenstick::fibre::scene::{Scene, StemChoice};
use greenstick::files;
use greenstick::fracture::recipe::{Problem, RecipeError, apply_preset};
use greenstick::geometry::Provenance;
use greenstick::schema::{
    ParameterError, Parameters, Value, line_and_column, parameters, read_table, text, write_toml,
};
use greenstick::wood::species::SPECIES_NAME;
use greenstick::{RequestFile, provenance};
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Key of the presets in a recipe.
const PRESET: &str = "preset";

parameters! {
    /// A bending test of a species.
    pub struct BendFile {
        "Wood", "bend" {
            /// Species, by common or scientific name.
            species: String = "white oak".to_owned(), text(SPECIES_NAME);
        }
    }
    include {
        /// The moisture of its wood, its scatter, the specimen and its model.
        settings: BendSettings = BendSettings::default();
    }
}

/// What decides a variant.
#[derive(Debug, Clone)]
pub enum Variant {
    /// The request of a break.
    Break(Box<RequestFile>),
    /// A scene that is simulated.
    Scene(Box<Scene>),
    /// A bending test.
    Bend(Box<BendFile>),
}

impl Variant {
    /// Reads what all variants of a sweep have in common: a recipe, the keys of a scene, or those of a bending test. `others` are
    /// the tables of the sweep that are none of it, `folder` is that of the sweep's file.
    ///
    /// # Errors
    /// [`SweepError`]: what is wrong, with its line or key.
    pub fn read(
        settings: &SweepSettings,
        (table, text): (&DeTable, &str),
        others: [&str; 2],
        folder: &Path,
    ) -> Result<Self, SweepError> {
        match settings.kind {
            SweepKind::Break | SweepKind::Forest => {
                let mut file = RequestFile::default();
                presets(&mut file, table, text)?;
                let [first, second] = others;
                read_table(&mut file, table, text, &[PRESET, first, second])
                    .map_err(RecipeError::from)?;
                file.complete().map_err(RecipeError::from)?;
                if let (SweepKind::Forest, Some(input)) = (settings.kind, &file.input) {
                    return Err(SweepError::Forest {
                        path: None,
                        problem: format!(
                            "input = \"{input}\" stands outside [sweep]; expected the scene of a forest in [sweep]"
                        ),
                    });
                }
                Ok(Variant::Break(file.into()))
            }
            SweepKind::Scene => {
                let mut scene = named_scene(settings.scene.as_deref(), folder)?;
                read_table(&mut scene, table, text, &others).map_err(RecipeError::from)?;
                if let Some(input) = &settings.input {
                    scene.stem.kind = StemChoice::Input;
                    scene.stem.up = scene.stem.up.or(up_axis(Path::new(input)));
                }
                scene.check()?;
                Ok(Variant::Scene(scene.into()))
            }
            SweepKind::BendTest => {
                let mut file = BendFile::default();
                read_table(&mut file, table, text, &others).map_err(RecipeError::from)?;
                file.check().map_err(RecipeError::from)?;
                Ok(Variant::Bend(file.into()))
            }
        }
    }

    /// Its parameters.
    pub fn parameters(&self) -> &dyn Parameters {
        match self {
            Variant::Break(file) => file.as_ref(),
            Variant::Scene(scene) => scene.as_ref(),
            Variant::Bend(file) => file.as_ref(),
        }
    }

    /// Sets a parameter.
    ///
    /// # Errors
    /// An unknown key, with the nearest ones; a value of the wrong kind or out of range.
    pub fn set(&mut self, key: &str, value: &Value) -> Result<(), ParameterError> {
        match self {
            Variant::Break(file) => keys::set(file, key, value),
            Variant::Scene(scene) => Parameters::set(scene.as_mut(), key, value),
            Variant::Bend(file) => file.set(key, value),
        }
    }

    /// Completes it and checks the whole after parameters were set.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn complete(&mut self) -> Result<(), String> {
        match self {
            Variant::Break(file) => file.complete().map_err(|e| e.to_string()),
            Variant::Scene(scene) => scene.check().map_err(|e| e.to_string()),
            Variant::Bend(file) => file.check().map_err(|e| e.to_string()),
        }
    }

    /// Its parameters as TOML.
    pub fn to_toml(&self) -> String {
        write_toml(self.parameters())
    }

    /// The seed that all variants have where it does not vary, and its key.
    pub(crate) fn seed(&self) -> (&'static str, u64) {
        match self {
            Variant::Break(file) => ("break.seed", file.common.recipe.face.seed),
            Variant::Scene(scene) => ("seed", scene.seed),
            Variant::Bend(file) => ("seed", file.settings.specimen.seed),
        }
    }

    /// Where the results of a sweep come from whose input has a name.
    pub(crate) fn provenance(&self, input: Option<&str>) -> Provenance {
        let mut made = match self {
            Variant::Break(file) => file.provenance(input, None),
            other => provenance("sweep", input, other.parameters()),
        };
        made.command = "sweep".to_owned();
        made
    }
}

/// The scene that comes with the program under a name, or that in a file; without one, the scene that says nothing.
fn named_scene(name: Option<&str>, folder: &Path) -> Result<Scene, SweepError> {
    let Some(name) = name else {
        return Ok(Scene::default());
    };
    if !name.ends_with(".toml") {
        return Ok(Scene::built_in(name)?);
    }
    let path = folder.join(name);
    let text = files::read_text(&path)?;
    Scene::read(&text).map_err(|error| SweepError::SceneFile {
        path,
        error: error.into(),
    })
}

/// Puts the presets that a recipe names over a request.
fn presets(base: &mut RequestFile, table: &DeTable, text: &str) -> Result<(), RecipeError> {
    let Some(value) = table.get(PRESET) else {
        return Ok(());
    };
    let names: Vec<_> = match value.get_ref() {
        DeValue::Array(list) => list.iter().collect(),
        _ => vec![value],
    };
    for name in names {
        let (line, column) = line_and_column(text, name.span().start);
        let at = |problem: Problem| RecipeError::At {
            line,
            column,
            problem: Box::new(problem),
        };
        let word = name.get_ref().as_str().ok_or_else(|| {
            at(Problem::Parameter(ParameterError::Kind {
                key: PRESET.to_owned(),
                found: "no name in quotes".to_owned(),
                expected: "a name in quotes, or a list of names".to_owned(),
            }))
        })?;
        apply_preset(base, word).map_err(at)?;
    }
    Ok(())
}
