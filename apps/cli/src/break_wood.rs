//! `greenstick break`: from options to a request, and from what the library returns to files and a report.

use crate::arguments::{BreakOptions, Shot, UnitWord};
use crate::failure::{Failure, print};
use crate::outcome::{Written, spent, written};
use crate::progress::{Progress, StageTime};
use crate::scan::{self, Loaded};
use crate::values;
use greenstick::files::{self, Output};
use greenstick::formats::{Format, InputFormat, LengthUnit};
use greenstick::fracture::recipe::{Recipe, RecipeError};
use greenstick::geometry::Context;
use greenstick::picture::{PictureOptions, View};
use greenstick::wood::stem::StemLocation;
use greenstick::{Break, BreakReport, BreakRequest};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const OUTPUT: &str = "broken.glb";
const PICTURE: &str = "broken.png";
/// Where it is broken.
const AT: &str = "0.5";

/// Where everything goes.
pub struct Targets {
    pub pieces: Option<PathBuf>,
    pub picture: Option<PathBuf>,
    recipe: Option<PathBuf>,
}

/// The library's report, the files and the time.
#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(flatten)]
    report: &'a BreakReport,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

pub fn run(options: &BreakOptions) -> Result<ExitCode, Failure> {
    let unit = options.unit.map(LengthUnit::from);
    let targets = targets(options)?;
    let mut request = request(options, unit.unwrap_or_default())?;
    use_threads(options.telling.threads)?;
    let progress = Progress::start(options.telling.quiet);
    let [read, work, encode, picture, write] = progress.split([
        ("read", 0.5),
        ("break", 2.0),
        ("encode", 0.1),
        ("picture", if targets.picture.is_some() { 8.0 } else { 0.0 }),
        ("write", 0.1),
    ]);
    let source = load(options, request.breaks[0].place, unit, &read)?;
    targets.check(&source.files)?;
    request.breaks[0].place = source.place;
    let mut scene = source.scene;
    if let (Some(input), Some(pieces)) = (&options.input, &targets.pieces) {
        files::carry_images(&mut scene, input, pieces);
    }
    let mut broken = greenstick::break_scene(scene, &request, &work)?;
    broken.report.scan = source.scan;
    let doubt = doubt_about_unit(
        options.input.as_deref(),
        options.unit,
        broken.report.place.stem_length_m,
    );
    doubt.into_iter().for_each(|note| broken.note(note));
    let mut outputs = Vec::new();
    if let Some(path) = &targets.pieces {
        encode.report(0.0)?;
        outputs.extend(files::encode(
            &broken.scene,
            path,
            unit.unwrap_or_default(),
        )?);
    }
    if let Some(path) = &targets.picture {
        let how = picture_options(&options.shot);
        let picture = greenstick::picture_of_break(&broken, &how, &picture)?;
        outputs.push(Output {
            path: path.clone(),
            bytes: picture.png(),
        });
    }
    if let Some(path) = &targets.recipe {
        outputs.push(Output {
            path: path.clone(),
            bytes: request.breaks[0].recipe.to_toml().into_bytes(),
        });
    }
    write.report(0.0)?;
    let paths: Vec<&Path> = outputs.iter().map(|o| o.path.as_path()).collect();
    files::check_distinct(&paths, &source.files)?;
    files::write_all(&outputs)?;
    let stages = progress.finish();
    if options.telling.reports() {
        let written = written(&outputs);
        print(&told(
            &broken.report,
            &written,
            &stages,
            options.telling.json,
        )?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// With neither file named both are written under their usual names; with one named, only that.
pub fn targets(options: &BreakOptions) -> Result<Targets, Failure> {
    let neither = options.output.is_none() && options.picture.is_none();
    let usual = |name: &str| neither.then(|| PathBuf::from(name));
    let targets = Targets {
        pieces: options.output.clone().or_else(|| usual(OUTPUT)),
        picture: options.picture.clone().or_else(|| usual(PICTURE)),
        recipe: options.save_recipe.clone(),
    };
    if let Some(path) = &targets.pieces
        && Format::of_path(path).is_none()
    {
        let (path, expected) = (path.clone(), files::mesh_endings());
        return Err(files::FileError::UnknownEnding { path, expected }.into());
    }
    if let Some(path) = &targets.picture {
        check_png(path)?;
    }
    Ok(targets)
}

/// Refuses pictures that would be named as what they are not.
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

impl Targets {
    /// Whether all of it can be written, before any work is done.
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
}

fn load(
    options: &BreakOptions,
    place: StemLocation,
    unit: Option<LengthUnit>,
    context: &Context,
) -> Result<Loaded, Failure> {
    context.report(0.0)?;
    match &options.input {
        Some(path) => scan::load(path, place, unit, &options.scan, context),
        None => Ok(Loaded {
            scene: greenstick::built_in_branch(),
            place,
            scan: None,
            files: Vec::new(),
        }),
    }
}

/// Metres. No tree is longer; the tallest known is 116 m high.
const LONGEST: f64 = 120.0;

/// What to say of a stem that is as long as none, where the file does not tell its unit and nobody else has.
pub fn doubt_about_unit(
    input: Option<&Path>,
    unit: Option<UnitWord>,
    length: f64,
) -> Option<String> {
    let format = input.and_then(InputFormat::of_path)?;
    let doubtful = unit.is_none() && !format.is_in_metres() && length > LONGEST;
    doubtful.then(|| {
        format!(
            "{} files do not say their unit; read in metres the stem is {length:.0} m long: if it is in millimetres, \
             say --unit mm",
            format.name()
        )
    })
}

fn request(options: &BreakOptions, unit: LengthUnit) -> Result<BreakRequest, Failure> {
    let at = options.at.as_deref().unwrap_or(AT);
    let place = values::place(at, unit).map_err(Failure::request)?;
    Ok(BreakRequest {
        stem: options.stem.options(unit)?,
        texture_width: options.texture_size,
        ..BreakRequest::single(Break {
            place,
            recipe: recipe(options)?,
            separation: options.part,
            fray: options.fray,
            ..Break::default()
        })
    })
}

fn recipe(options: &BreakOptions) -> Result<Recipe, Failure> {
    let text = options
        .recipe
        .as_ref()
        .map(|path| {
            std::fs::read_to_string(path).map_err(|e| {
                Failure::request(format!("{}: cannot be read: {e}", path.display()))
                    .hint("--save-recipe FILE.toml writes a recipe to start from")
            })
        })
        .transpose()?;
    let presets: Vec<&str> = options.preset.iter().map(String::as_str).collect();
    let own: Vec<String> = [
        ("species", &options.species),
        ("moisture", &options.moisture),
        ("seed", &options.seed),
        ("hang", &options.hang),
    ]
    .into_iter()
    .filter_map(|(key, value)| value.as_ref().map(|v| format!("{key}={v}")))
    .collect();
    let settings: Vec<&str> = options.set.iter().chain(&own).map(String::as_str).collect();
    Recipe::resolve(&presets, text.as_deref(), &settings).map_err(|error| {
        let message = match (&error, &options.recipe) {
            (RecipeError::At { .. }, Some(path)) => format!("{}: {error}", path.display()),
            (RecipeError::Setting { setting, problem }, _) => {
                let key = own.contains(setting).then(|| setting.split('=').next());
                format!("--{}: {problem}", key.flatten().unwrap_or("set"))
            }
            _ => error.to_string(),
        };
        Failure::request(message).hint(hint(&error))
    })
}

/// Where what is right can be looked up.
fn hint(error: &RecipeError) -> &'static str {
    use greenstick::fracture::recipe::Problem;
    let (RecipeError::At { problem, .. }
    | RecipeError::Setting { problem, .. }
    | RecipeError::Whole(problem)) = error;
    match problem {
        Problem::Preset(_) => "`greenstick presets` lists them",
        Problem::Species(_) => "`greenstick species` lists them",
        Problem::NotASetting => "such as --set high.height=2",
        Problem::Moisture(_) => "12 is air-dry, 30 and more is green",
        _ => "`greenstick parameters` lists keys, units and ranges",
    }
}

/// Gives the work so many threads.
pub fn use_threads(threads: Option<u16>) -> Result<(), Failure> {
    let Some(threads) = threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(threads))
        .build_global()
        .map_err(|e| Failure::work(format!("cannot start {threads} threads: {e}")))
}

/// A shot as the picture crate takes it.
pub fn picture_options(shot: &Shot) -> PictureOptions {
    let view = match shot.view {
        Some((azimuth, elevation)) => View::Direction { azimuth, elevation },
        None => View::Automatic,
    };
    PictureOptions {
        width: shot.picture_size.0,
        height: shot.picture_size.1,
        samples: shot.samples,
        view,
        ..PictureOptions::default()
    }
}

fn told(
    report: &BreakReport,
    outputs: &[Written],
    stages: &[StageTime],
    json: bool,
) -> Result<String, Failure> {
    if json {
        let full = FullReport {
            report,
            outputs,
            stages,
        };
        let text = serde_json::to_string_pretty(&full)
            .map_err(|e| Failure::work(format!("the report cannot be put into JSON: {e}")))?;
        return Ok(text + "\n");
    }
    let mut text = report.to_string();
    for file in outputs {
        let _ = writeln!(text, "wrote    {}, {}", file.path, size(file.bytes));
    }
    let total: f64 = stages.iter().map(|s| s.seconds).sum();
    let _ = writeln!(text, "time     {total:.2} s: {}", spent(stages));
    Ok(text)
}

/// A number of bytes in the unit that suits it.
pub fn size(bytes: usize) -> String {
    match bytes as f64 {
        b if b >= 1e6 => format!("{:.1} MB", b / 1e6),
        b if b >= 1e3 => format!("{:.1} kB", b / 1e3),
        b => format!("{b} bytes"),
    }
}
