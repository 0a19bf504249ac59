//! A request as a file holds it.

use super::{Break, BreakRequest};
use crate::scanning::ScanParameters;
use greenstick_formats::LengthUnit;
use greenstick_fracture::recipe::{
    HasRecipe, Recipe, RecipeError, apply_preset, apply_setting, apply_toml,
};
use greenstick_picture::PictureParameters;
use greenstick_schema::{
    FILE_NAME, ParameterError, Parameters, Unit, choice, content_hash, count, parameters, text,
    write_toml,
};
use greenstick_wood::stem::StemOptions;

/// Why a request cannot be put together.
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
        "What comes out", "finish" {
            /// Width of the baked textures, pixels; they are half as high.
            texture_width as "texture_size": u32 = 2048, count(8, 16_384).step(2).unit(Unit::Pixel).logarithmic();
        }
    }
    include {
        /// How a point cloud becomes the bark of a stem.
        scan: ScanParameters = ScanParameters::default();
        /// What is known of the stem.
        stem: StemOptions = StemOptions::default();
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
    /// The request of the layers, later over earlier: defaults, `presets` (the text's own where this is empty), `text`
    /// (TOML), `settings` of the form `key=value`; checked as a whole.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line in `text` or its setting.
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

    /// Puts a setting, `key=value`, over the file: of every break that has a table of its own as well.
    ///
    /// # Errors
    /// What is wrong with the setting.
    pub fn apply_setting(&mut self, setting: &str) -> Result<(), RequestFileError> {
        apply_setting(self, setting)?;
        for one in &mut self.breaks {
            // A key of the file that no break has was put above.
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

    /// Checks everything, and brings species to the names that their table has.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn complete(&mut self) -> Result<(), ParameterError> {
        self.check()?;
        self.common.recipe.complete()?;
        self.breaks
            .iter_mut()
            .try_for_each(|one| one.recipe.complete())
    }

    /// The request.
    pub fn request(&self) -> BreakRequest {
        let breaks = match &self.breaks[..] {
            [] => vec![self.common.clone()],
            several => several.to_vec(),
        };
        BreakRequest {
            stem: self.stem.clone(),
            breaks,
            texture_width: self.texture_width,
        }
    }

    /// The file with every parameter, so that it means the same whatever defaults and presets become.
    pub fn to_toml(&self) -> String {
        write_toml(self)
    }

    /// A hash of everything in it, the same on every machine; not for security.
    pub fn hash(&self) -> String {
        content_hash(&self.to_toml())
    }
}
