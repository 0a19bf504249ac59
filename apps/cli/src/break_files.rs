//! The files of a break: their names, the pieces, the picture and the recipe in them, and what a report says of them.

use crate::arguments::BreakOptions;
use crate::failure::Failure;
use crate::outcome::{Written, spent};
use crate::progress::{StageTime, split};
use greenstick::RequestFile;
use greenstick::files::{self, Output};
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Context, Scene};
use greenstick::picture::{Picture, PictureError};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Default name of the pieces' file.
const DEFAULT_OUTPUT: &str = "broken.glb";
/// Default name of the picture.
const DEFAULT_PICTURE: &str = "broken.png";

/// Seconds that encoding and writing take, and those of a picture.
const SECONDS: [f64; 2] = [0.2, 8.0];

/// The files that a break writes.
pub struct Targets {
    pub pieces: Option<PathBuf>,
    pub picture: Option<PathBuf>,
    pub recipe: Option<PathBuf>,
}

impl Targets {
    /// Returns the named files, or pieces and picture under their default names if neither is named.
    pub fn new(options: &BreakOptions) -> Result<Self, Failure> {
        let neither = options.output.is_none() && options.picture.is_none();
        let default = |name: &str| neither.then(|| PathBuf::from(name));
        let targets = Targets {
            pieces: options.output.clone().or_else(|| default(DEFAULT_OUTPUT)),
            picture: options.picture.clone().or_else(|| default(DEFAULT_PICTURE)),
            recipe: options.save_recipe.clone(),
        };
        if let Some(path) = &targets.pieces {
            files::output_format(path)?;
        }
        if let Some(path) = &targets.picture {
            check_png(path)?;
        }
        Ok(targets)
    }

    /// Returns the files of a variant, whose number is added to their names; number 0 is the only one.
    pub fn variant(&self, number: u32) -> Targets {
        let numbered = |path: &Option<PathBuf>| {
            let path = path.clone()?;
            let (Some(stem), true) = (path.file_stem(), number > 0) else {
                return Some(path);
            };
            let mut name = stem.to_os_string();
            name.push(format!("_{number}"));
            if let Some(extension) = path.extension() {
                name.push(".");
                name.push(extension);
            }
            Some(path.with_file_name(name))
        };
        Targets {
            pieces: numbered(&self.pieces),
            picture: numbered(&self.picture),
            recipe: numbered(&self.recipe),
        }
    }

    /// Checks that all files can be written, before any work is done.
    pub fn check(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let all: Vec<&Path> = [&self.pieces, &self.picture, &self.recipe]
            .into_iter()
            .flatten()
            .map(PathBuf::as_path)
            .collect();
        files::check_distinct(&all, inputs)?;
        for path in all {
            files::check_writable(path)?;
        }
        Ok(())
    }

    /// About the seconds that [`Targets::write`] takes.
    pub fn seconds(&self) -> f64 {
        SECONDS[0] + self.picture.as_ref().map_or(0.0, |_| SECONDS[1])
    }

    /// Writes the pieces, the picture, which `draw` draws, and the `recipe`, all or none, and none over an input. Returns
    /// what was written.
    pub fn write(
        &self,
        (scene, unit): (&Scene, Option<LengthUnit>),
        draw: impl FnOnce(&Context) -> Result<Picture, PictureError>,
        recipe: Option<String>,
        inputs: &[PathBuf],
        context: &Context,
    ) -> Result<Vec<Output>, Failure> {
        let [encode, picture, write] = split(
            context,
            [
                ("encode", 0.5 * SECONDS[0]),
                ("picture", self.seconds() - SECONDS[0]),
                ("write", 0.5 * SECONDS[0]),
            ],
        );
        let mut outputs = Vec::new();
        if let Some(path) = &self.pieces {
            encode.report(0.0)?;
            outputs.extend(files::encode(scene, path, unit.unwrap_or_default())?);
        }
        if let Some(path) = &self.picture {
            let bytes = draw(&picture)?.png_with(&scene.metadata);
            let path = path.clone();
            outputs.push(Output { path, bytes });
        }
        if let (Some(path), Some(text)) = (&self.recipe, recipe) {
            let (path, bytes) = (path.clone(), text.into_bytes());
            outputs.push(Output { path, bytes });
        }
        write.report(0.0)?;
        let paths: Vec<&Path> = outputs.iter().map(|o| o.path.as_path()).collect();
        files::check_distinct(&paths, inputs)?;
        files::write_all(&outputs)?;
        Ok(outputs)
    }
}

/// Checks that a picture's name ends in `.png`.
pub fn check_png(path: &Path) -> Result<(), Failure> {
    let png = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if png {
        Ok(())
    } else {
        Err(Failure::request(format!(
            "{}: pictures are PNG files; expected a name that ends in .png",
            path.display()
        )))
    }
}

/// Returns the request as a recipe file at `path`, with the input's path relative to it.
pub fn recipe_text(
    file: &RequestFile,
    input: Option<&Path>,
    path: &Path,
) -> Result<String, Failure> {
    let mut file = file.clone();
    file.input = input
        .map(|input| path_from_folder_of(path, input))
        .transpose()?;
    Ok(file.to_toml())
}

/// Returns the path of `input` relative to the folder of `path`.
fn path_from_folder_of(path: &Path, input: &Path) -> Result<String, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = if folder == Path::new("") || input.is_absolute() {
        input.to_owned()
    } else {
        match input.strip_prefix(folder) {
            Ok(inside) => inside.to_owned(),
            Err(_) => std::path::absolute(input).map_err(Failure::work)?,
        }
    };
    name.to_str().map(str::to_owned).ok_or_else(|| {
        Failure::request(format!(
            "{}: the name is not Unicode, so a recipe cannot contain it; expected another name",
            input.display()
        ))
    })
}

/// Formats the end of a report: the files and the time.
pub fn format_end(outputs: &[Written], stages: &[StageTime]) -> String {
    let mut text = String::new();
    for file in outputs {
        let _ = writeln!(text, "wrote    {}, {}", file.path, size(file.bytes));
    }
    let total: f64 = stages.iter().map(|s| s.seconds).sum();
    let _ = writeln!(text, "time     {total:.2} s: {}", spent(stages));
    text
}

/// Formats a number of bytes.
pub fn size(bytes: usize) -> String {
    match bytes as f64 {
        b if b >= 1e6 => format!("{:.1} MB", b / 1e6),
        b if b >= 1e3 => format!("{:.1} kB", b / 1e3),
        b => format!("{b} bytes"),
    }
}
