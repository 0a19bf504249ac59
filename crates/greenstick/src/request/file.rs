//! Request files.

use super::{Break, BreakRequest, MAX_DISTANCE};
use crate::scanning::ScanParameters;
use greenstick_formats::LengthUnit;
use greenstick_fracture::presets::PRESETS;
use greenstick_fracture::recipe::{
    HasRecipe, Recipe, RecipeError, apply_preset, apply_setting, apply_toml,
};
use greenstick_picture::PictureParameters;
use greenstick_schema::{
    FILE_NAME, ParameterError, Parameters, Unit, choice, content_hash, count, document_schema,
    length, parameters, text, write_toml,
};
use greenstick_wood::anatomy::BreakRingParameters;
use greenstick_wood::stem::StemOptions;

/// Why a request is invalid.
pub type RequestFileError = RecipeError;

parameters! {
    /// Everything that decides the outcome of a break: what is read, how it breaks, what is shown. Keys at the top and
    /// tables say what all breaks have in common, and where there is no `[[breaks]]`, the only one.
    pub struct RequestFile {
        "Input", "input" {
            /// The mesh or point cloud that is broken; without it, the branch that comes with the program. A relative name
            /// starts from the folder of the file that it stands in.
            input: Option<String> = None, text(FILE_NAME).auto();
            /// Unit of length in the input, where its format has none; also of the output.
            unit: Option<LengthUnit> = None, choice(LengthUnit::CHOICES).auto();
        }
        "Where", "stem" {
            /// Break it again and again, at every multiple of this length from the stem's base where it is free; the place of
            /// the break then only says which stem.
            every: Option<f64> = None, length(0.0, MAX_DISTANCE).above().auto();
        }
        "What comes out", "finish" {
            /// Width of the baked textures of the wood inside, pixels.
            texture_width as "texture_size": u32 = 1024, count(8, 16_384).step(2).unit(Unit::Pixel).logarithmic();
        }
    }
    include {
        /// How a point cloud becomes the bark of a stem.
        scan: ScanParameters = ScanParameters::default();
        /// What is known of the stem.
        stem: StemOptions = StemOptions::default();
        /// Its annual rings.
        rings: BreakRingParameters = BreakRingParameters::default();
        /// What the breaks have in common, or the only break.
        common: Break = Break::default();
        /// What is asked of a picture.
        picture: PictureParameters = PictureParameters::default();
    }
    lists {
        /// Breaks of one stem; each has all keys of a break and starts from those at the top.
        breaks: Break = |file| file.common.clone();
    }
}

impl HasRecipe for RequestFile {
    fn recipe_mut(&mut self) -> &mut Recipe {
        &mut self.common.recipe
    }
}

impl RequestFile {
    /// Combines the layers of a request, later ones over earlier ones, and checks the whole: defaults, `presets` (if none,
    /// those that the text names), `text` (TOML), `settings` of the form `key=value`.
    ///
    /// # Errors
    /// The first problem, with its line in `text` or its setting.
    ///
    /// ```
    /// use greenstick::RequestFile;
    ///
    /// let text = "preset = 'brash'\nspecies = 'white oak'\npart = '3 cm'\n[[breaks]]\nat = 0.4\n[[breaks]]\nat = '60 cm'\n";
    /// let file = RequestFile::resolve(&[], Some(text), &["seed=7"])?;
    /// let request = file.request();
    /// assert_eq!(request.breaks.len(), 2);
    /// assert_eq!(request.breaks[1].separation, 0.03);
    /// assert_eq!(RequestFile::resolve(&[], Some(&file.to_toml()), &[])?, file);
    /// # Ok::<(), greenstick::RequestFileError>(())
    /// ```
    pub fn resolve(
        presets: &[&str],
        text: Option<&str>,
        settings: &[&str],
    ) -> Result<Self, RequestFileError> {
        let mut file = RequestFile::default();
        for name in presets {
            apply_preset(&mut file, name)?;
        }
        if let Some(text) = text {
            apply_toml(&mut file, text, presets.is_empty())?;
        }
        for setting in settings {
            file.apply_setting(setting)?;
        }
        file.complete()?;
        Ok(file)
    }

    /// Applies a setting, `key=value`, to the file and to every break that has a table of its own.
    ///
    /// # Errors
    /// The problem of the setting.
    pub fn apply_setting(&mut self, setting: &str) -> Result<(), RequestFileError> {
        apply_setting(self, setting)?;
        for one in &mut self.breaks {
            // Keys of the file that breaks do not have were set above.
            if let Err(error) = apply_setting(one, setting)
                && !matches!(
                    error.problem().parameter(),
                    Some(ParameterError::UnknownKey { .. })
                )
            {
                return Err(error);
            }
        }
        Ok(())
    }

    /// Checks everything, and replaces names of species by those in their table.
    ///
    /// # Errors
    /// The first problem.
    pub fn complete(&mut self) -> Result<(), ParameterError> {
        self.check()?;
        self.common.recipe.complete()?;
        self.breaks
            .iter_mut()
            .try_for_each(|one| one.recipe.complete())
    }

    /// Returns the request.
    pub fn request(&self) -> BreakRequest {
        let breaks = match &self.breaks[..] {
            [] => vec![self.common.clone()],
            several => several.to_vec(),
        };
        BreakRequest {
            stem: self.stem.clone(),
            rings: self.rings.clone(),
            breaks,
            every: self.every,
            texture_width: self.texture_width,
        }
    }

    /// Returns this file with what a request asks for: its stem, rings, breaks and textures.
    pub fn with_request(self, request: &BreakRequest) -> Self {
        RequestFile {
            texture_width: request.texture_width,
            every: request.every,
            stem: request.stem.clone(),
            rings: request.rings.clone(),
            breaks: request.breaks.clone(),
            ..self
        }
    }

    /// Writes every parameter, so that the file does not depend on defaults and presets, which may change.
    pub fn to_toml(&self) -> String {
        write_toml(self)
    }

    /// JSON Schema (draft 2020-12) of such files: that of the parameters, and the presets to start from.
    pub fn schema() -> serde_json::Value {
        let mut schema = document_schema("Greenstick recipe", &RequestFile::default());
        let names: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        schema["properties"]["preset"] = serde_json::json!({
            "description": "Presets to start from, later ones over earlier ones.",
            "anyOf": [{ "enum": names }, { "type": "array", "items": { "enum": names } }],
        });
        schema
    }

    /// Returns a hash of all parameters, the same on every machine; not for security.
    pub fn hash(&self) -> String {
        content_hash(&self.to_toml())
    }
}
