//! `greenstick break`: from options to a request, and from what the library returns to files and a report.

use crate::arguments::{BreakOptions, Declared};
use crate::break_files::{Targets, format_end, recipe_text};
use crate::failure::{Failure, parameter_hint, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use crate::values;
use greenstick::files;
use greenstick::formats::{InputFormat, LengthUnit, OutputFormat};
use greenstick::geometry::Provenance;
use greenstick::schema::{Field, ParameterError, Parameters};
use greenstick::{Break, BreakReport, RequestFile, RequestFileError};
use greenstick_sweep::Input;
use serde::Serialize;
use std::hash::{BuildHasher, RandomState};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The library's report, the files and the time.
#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(flatten)]
    report: &'a BreakReport,
    /// Stable hash of the request.
    request_hash: String,
    provenance: &'a Provenance,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

pub fn run(options: &BreakOptions) -> Result<ExitCode, Failure> {
    let targets = Targets::new(options)?;
    let (options, random) = with_random_seed(options);
    let request = resolve_request(&options)?;
    use_threads(options.reporting.threads)?;
    let seeds = options.variants.map_or(0..=0, |count| 1..=count);
    for number in seeds {
        break_once(&options, &targets, &request, number, random)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Key of the seed, and the word for one at random.
const SEED: &str = "break.seed";
const RANDOM_SEED: &str = "random";
/// Seeds at random are below this: short enough to be typed again.
const RANDOM_SEEDS: u64 = 1_000_000;

/// Returns the options with the seed that is taken where one at random is asked for, and that seed.
fn with_random_seed(options: &BreakOptions) -> (BreakOptions, Option<u64>) {
    let mut options = options.clone();
    if options.request.text(SEED) != Some(RANDOM_SEED) {
        return (options, None);
    }
    // The standard library has no other source of chance.
    let seed = RandomState::new().hash_one(RANDOM_SEED) % RANDOM_SEEDS;
    options.request.replace(SEED, &seed.to_string());
    (options, Some(seed))
}

/// Breaks once; a variant's `number` counts from 1.
fn break_once(
    options: &BreakOptions,
    targets: &Targets,
    ResolvedRequest { file, input }: &ResolvedRequest,
    number: u32,
    random: Option<u64>,
) -> Result<(), Failure> {
    let (targets, mut file) = (targets.variant(number), file.clone());
    let next = u64::from(number.saturating_sub(1));
    for one in file.breaks.iter_mut().chain([&mut file.common]) {
        let seed = &mut one.recipe.face.seed;
        *seed = seed.saturating_add(next).min(i64::MAX as u64);
    }
    let file = &file;
    let unit = file.unit;
    let recipe = match &targets.recipe {
        Some(path) => Some(recipe_text(file, input.as_deref(), path)?),
        None => None,
    };
    let progress = Progress::start(options.reporting.quiet);
    let [read, work, write] =
        progress.split([("read", 0.5), ("break", 2.0), ("write", targets.seconds())]);
    let mut source = Input::of_request(file, input.as_deref(), &read)?;
    targets.check(&source.files)?;
    let mut request = source.request(file);
    request.texture_width =
        OutputFormat::texture_width(targets.pieces.as_deref(), request.texture_width);
    let mut scene = std::mem::take(&mut source.scene);
    if let (Some(input), Some(pieces)) = (input, &targets.pieces) {
        files::carry_images(&mut scene, input, pieces);
    }
    let mut broken = greenstick::break_scene(scene, &request, &work)?;
    source.note_origin(&mut broken, file, input.as_deref());
    let provenance = file.provenance(file_name(input.as_deref()).as_deref(), source.scan.as_ref());
    let warning = unit_warning(input.as_deref(), unit, broken.report.place.stem_length_m);
    warning.into_iter().for_each(|note| broken.note(note));
    if random.is_some() || number > 0 {
        let seed = file.common.recipe.face.seed;
        let chosen = random.map_or("", |_| ", chosen at random");
        broken.note(format!("the seed is {seed}{chosen}"));
    }
    let outputs = targets.write(
        (&broken.scene, unit),
        |context| {
            let mut shown = broken.clone();
            if let Some(input) = &input {
                files::embed_images(&mut shown.scene, input);
            }
            greenstick::picture_of_break(&shown, &file.picture.options(), context)
        },
        recipe,
        &source.files,
        &write,
    )?;
    let stages = progress.finish();
    if options.reporting.prints_report() {
        let full = FullReport {
            report: &broken.report,
            request_hash: hash(file, input.as_deref()),
            provenance: &provenance,
            outputs: &written(&outputs),
            stages: &stages,
        };
        print(&format_report(&full, options.reporting.json)?)?;
    }
    Ok(())
}

/// The hash of a request, whatever folder its input lies in.
fn hash(file: &RequestFile, input: Option<&Path>) -> String {
    let mut file = file.clone();
    file.input = file_name(input);
    file.hash()
}

/// The name of a file without its folder.
pub fn file_name(path: Option<&Path>) -> Option<String> {
    let name = path.and_then(Path::file_name)?;
    Some(name.to_string_lossy().into_owned())
}

/// Length of a stem above which its unit is doubtful, m: the tallest tree known is 116 m high.
const MAX_PLAUSIBLE_LENGTH: f64 = 120.0;

/// Warns of a stem that is longer than any tree, if neither its file nor the request says the unit.
pub fn unit_warning(input: Option<&Path>, unit: Option<LengthUnit>, length: f64) -> Option<String> {
    let format = input.and_then(InputFormat::from_path)?;
    let doubtful = unit.is_none() && !format.is_in_metres() && length > MAX_PLAUSIBLE_LENGTH;
    doubtful.then(|| {
        format!(
            "{} files do not say their unit; read in metres the stem is {length:.0} m long: if it is in millimetres, \
             say --unit mm",
            format.name()
        )
    })
}

/// The request of all layers.
pub struct ResolvedRequest {
    /// Everything that decides the outcome.
    pub file: RequestFile,
    /// The input, relative to the working directory.
    pub input: Option<PathBuf>,
}

/// Combines all layers of a request: presets, recipe, settings, options.
pub fn resolve_request(options: &BreakOptions) -> Result<ResolvedRequest, Failure> {
    let text = options
        .recipe
        .as_ref()
        .map(|path| {
            files::read_text(path).map_err(|e| {
                Failure::from(e).hint("--save-recipe FILE.toml writes a recipe to start from")
            })
        })
        .transpose()?;
    let presets: Vec<&str> = options.preset.iter().map(String::as_str).collect();
    let settings: Vec<&str> = options.set.iter().map(String::as_str).collect();
    let resolved = RequestFile::resolve(&presets, text.as_deref(), &settings);
    let mut file = resolved.map_err(|error| {
        let message = match (&error, &options.recipe) {
            (RequestFileError::At { .. }, Some(path)) => format!("{}: {error}", path.display()),
            (RequestFileError::Setting { problem, .. }, _) => format!("--set: {problem}"),
            _ => error.to_string(),
        };
        Failure::request(message).hint(hint(&error))
    })?;
    apply_options(&mut file, &options.request)?;
    if let Some(path) = &options.rings_from {
        let rings = files::read_rings(path)?;
        file.rings.series.ring_shares = Some(rings.shares);
        file.stem.eccentricity_onset = file.stem.eccentricity_onset.or(rings.eccentricity_onset);
    }
    file.complete()
        .map_err(|error| Failure::request(&error).hint(parameter_hint(&error)))?;
    let folder = options.recipe.as_ref().and_then(|path| path.parent());
    let input = match (&options.input, &file.input) {
        (Some(given), _) => Some(given.clone()),
        (None, Some(name)) => Some(folder.unwrap_or(Path::new("")).join(name)),
        (None, None) => None,
    };
    Ok(ResolvedRequest { file, input })
}

/// Applies options to a request, and to every break if there are several. Points are in the unit of the file.
fn apply_options(file: &mut RequestFile, options: &Declared<RequestFile>) -> Result<(), Failure> {
    if let Some(word) = options.text("unit") {
        file.set_text("unit", word).map_err(Failure::request)?;
    }
    let unit = file.unit.unwrap_or_default();
    if options.text("at").is_some() && !file.breaks.is_empty() {
        return Err(Failure::request(format!(
            "--at: the recipe says where its {} breaks are",
            file.breaks.len()
        ))
        .hint("change their places in the recipe, under [[breaks]]"));
    }
    let rewrite = |key: &str, text: &str| match key {
        "at" => values::place(text, unit).map(|p| Some(p.to_value().to_string())),
        "pith" => values::pith(text, unit).map(|p| Some(p.to_value().to_string())),
        _ => Ok(None),
    };
    options.apply(file, |key, text| {
        rewrite(key, text).map_err(Failure::request)
    })?;
    let places = options.texts("at");
    if places.len() > 1 {
        for text in places {
            let place = values::place(text, unit).map_err(Failure::request)?;
            file.breaks.push(Break {
                place,
                ..file.common.clone()
            });
        }
        return Ok(());
    }
    for one in &mut file.breaks {
        options.apply_known(one)?;
    }
    Ok(())
}

/// Converts options that are points in the unit of the file to metres.
pub fn in_metres(key: &str, text: &str, unit: LengthUnit) -> Result<Option<String>, Failure> {
    match key {
        "at" => values::place(text, unit).map(|p| Some(p.to_value().to_string())),
        "pith" => values::pith(text, unit).map(|p| Some(p.to_value().to_string())),
        _ => Ok(None),
    }
    .map_err(Failure::request)
}

/// Returns where the right values are listed.
fn hint(error: &RequestFileError) -> &'static str {
    use greenstick::fracture::recipe::Problem;
    match error.problem() {
        Problem::Preset(_) => "`greenstick presets` lists them",
        Problem::NotASetting => "such as --set high.height=2",
        problem => match problem.parameter() {
            Some(
                error @ (ParameterError::Format { .. }
                | ParameterError::NotANumber { required: true, .. }),
            ) => parameter_hint(error),
            _ => "`greenstick parameters` lists keys, units and ranges",
        },
    }
}

/// Sets the number of threads.
pub fn use_threads(threads: Option<u16>) -> Result<(), Failure> {
    let Some(threads) = threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(threads))
        .build_global()
        .map_err(|e| Failure::work(format!("cannot start {threads} threads: {e}")))
}

/// Formats the report.
fn format_report(full: &FullReport, json: bool) -> Result<String, Failure> {
    if json {
        let text = serde_json::to_string_pretty(full)
            .map_err(|e| Failure::work(format!("the report cannot be put into JSON: {e}")))?;
        return Ok(text + "\n");
    }
    Ok(full.report.to_string() + &format_end(full.outputs, full.stages))
}
