//! `greenstick skin`: from a run's folder to a frame or a film of its skin.

mod engines;
mod outputs;
mod plan;

use crate::arguments::{MeshOptions, ReportingOptions, SkinOptions};
use crate::break_files::{check_png, size};
use crate::break_wood::use_threads;
use crate::failure::{Failure, print};
use crate::outcome::spent;
use crate::progress::{Progress, StageTime};
use crate::video::{Scratch, check_ffmpeg, encode, is_video, pictures};
use engines::Engines;
use greenstick::files::run::{Origin, RunFolder, read_body_meshes};
use greenstick::files::{self, Batch, Output};
use greenstick::film::{FilmError, open_run, write_series};
use greenstick::formats::film::{FilmReport, write_glb, write_usd};
use greenstick::formats::usd::UsdFormat;
use greenstick::formats::{Encoded, LengthUnit, Reach};
use greenstick::geometry::{Context, Provenance, Stage};
use greenstick::provenance;
use greenstick::simulate::{RunSource, SceneMeshes};
use greenstick::simulated_faces::SimulatedFaceReport;
use greenstick::skin::film::{Run, SkinReport};
use greenstick_sweep::shown::{RunFilm, RunStill};
use outputs::{ending, in_folder};
pub use plan::FilmPlan;
use serde::Serialize;
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(flatten)]
    skin: Option<&'a SkinReport>,
    /// What each face was made from, from the base of the stem to its tip.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    simulated: &'a [SimulatedFaceReport],
    film: Option<FilmPart>,
    #[serde(flatten)]
    engines: &'a Engines,
    files: &'a [(String, usize)],
    stages: &'a [StageTime],
}

/// What a film's file holds.
#[derive(Serialize)]
struct FilmPart {
    skinned: usize,
    rigid: usize,
    joints: usize,
    largest_error_m: f64,
}

/// Whether an ending is that of a film of the skin.
pub fn is_film(path: &Path) -> bool {
    matches!(ending(path).as_str(), "glb" | "usdc" | "usdz") || is_video(&ending(path))
}

pub fn run(options: &SkinOptions) -> Result<ExitCode, Failure> {
    if options.output.is_none() && options.picture.is_none() && options.pictures.is_none() {
        return Err(Failure::request("no file is named for the skin")
            .hint("such as -o film.glb, or --frame -1 --picture broken.png"));
    }
    if let Some(path) = &options.picture {
        check_png(path)?;
    }
    let frame = options.parameters.set()?.frame;
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [read, work] = progress.split([("read", 1.0), ("skin", 9.0)]);
    let images = match &options.output {
        Some(output) if options.picture.is_none() && options.pictures.is_none() => {
            MeshImages::Carried(output)
        }
        _ => MeshImages::Embedded,
    };
    let run = open(&options.run, named(&options.mesh), images, &read)?;
    let plan = FilmPlan::from_options(options, run.scene.seed)?;
    let made = match frame {
        Some(number) => still(run, number, options, &plan, &work)?,
        None => film(run, &plan, &work)?,
    };
    report(made, &options.reporting, &progress.finish())?;
    Ok(ExitCode::SUCCESS)
}

/// Makes the film of a plan, and prints its report.
pub fn run_plan(
    run: Run,
    plan: &FilmPlan,
    reporting: &ReportingOptions,
    progress: &Progress,
    context: &Context,
) -> Result<(), Failure> {
    let made = film(run, plan, context)?;
    report(made, reporting, &progress.finish())
}

/// Prints what was made.
fn report(made: Made, reporting: &ReportingOptions, stages: &[StageTime]) -> Result<(), Failure> {
    if !reporting.prints_report() {
        return Ok(());
    }
    let Made {
        skin,
        film,
        mut files,
        engines,
    } = made;
    let (skin, faces) = skin.unzip();
    let faces = faces.unwrap_or_default();
    files.extend(engines.files.iter().cloned());
    let text = if reporting.json {
        let film = film.map(|f| FilmPart {
            skinned: f.skinned,
            rigid: f.rigid,
            joints: f.joints,
            largest_error_m: f.error(),
        });
        let full = FullReport {
            skin: skin.as_ref(),
            simulated: &faces,
            film,
            engines: &engines,
            files: &files,
            stages,
        };
        serde_json::to_string_pretty(&full).map_err(Failure::work)? + "\n"
    } else {
        words(
            (skin.as_ref(), &faces),
            film.as_ref(),
            &engines,
            &files,
            stages,
        )
    };
    print(&text)
}

/// Returns the mesh that options name, with its unit.
pub fn named(mesh: &MeshOptions) -> NamedMesh {
    let unit = mesh.unit.map(LengthUnit::from);
    mesh.input.as_ref().map(|path| (path.clone(), unit))
}

/// A mesh that is named in place of the one that a run remembers, with its unit.
pub type NamedMesh = Option<(PathBuf, Option<LengthUnit>)>;

/// Returns the number of a frame that is counted from 0, or from −1 backwards.
pub fn frame_number(run: &Run, number: i64) -> Result<usize, Failure> {
    let count = run.frames() as i64;
    let number = if number < 0 { count + number } else { number };
    usize::try_from(number).map_err(|_| {
        Failure::request(format!(
            "there are {count} frames, counted from 0 or from −1 backwards"
        ))
    })
}

/// What becomes of the images that a run's mesh refers to.
#[derive(Debug, Clone, Copy)]
pub enum MeshImages<'a> {
    /// They are not looked at.
    Left,
    /// They are read, so that pictures show them.
    Embedded,
    /// References to them hold in this file.
    Carried(&'a Path),
}

/// Opens the run with the mesh that it was of.
pub fn open(
    folder: &Path,
    named: NamedMesh,
    images: MeshImages,
    context: &Context,
) -> Result<Run, Failure> {
    context.report(0.0)?;
    let origin = Origin::read(folder).map_err(Failure::request)?;
    let input = named.or(origin.input_file());
    let input = match &input {
        Some((path, unit)) => {
            let mut scene = files::read(path, *unit)?;
            match images {
                MeshImages::Left => {}
                MeshImages::Embedded => files::embed_images(&mut scene, path),
                MeshImages::Carried(output) => files::carry_images(&mut scene, path, output),
            }
            Some(scene)
        }
        None => None,
    };
    let beside = origin.beside.clone();
    let run = RunFolder::new(folder, origin);
    let scene = run.scene().map_err(|e| Failure::from(FilmError::from(e)))?;
    let meshes = SceneMeshes {
        input,
        // What it may read was decided when it was simulated.
        bodies: read_body_meshes(&scene, &beside, Reach::Outside)?,
    };
    open_run(Arc::new(run), &meshes, context).map_err(Failure::from)
}

/// What was made of a run.
#[derive(Default)]
struct Made {
    /// The skin, and what faces were made from.
    skin: Option<(SkinReport, Vec<SimulatedFaceReport>)>,
    /// The film's file.
    film: Option<FilmReport>,
    /// The files with their sizes in bytes.
    files: Vec<(String, usize)>,
    /// What engines want.
    engines: Engines,
}

/// The report of a skin, and what its faces were made from.
fn owned(
    (skin, faces): (&SkinReport, &[SimulatedFaceReport]),
) -> (SkinReport, Vec<SimulatedFaceReport>) {
    (skin.clone(), faces.to_vec())
}

fn still(
    mut run: Run,
    number: i64,
    options: &SkinOptions,
    plan: &FilmPlan,
    context: &Context,
) -> Result<Made, Failure> {
    let [skin, picture, write] = context.split([
        (Stage::new("skin"), 1.0),
        (
            Stage::new("picture"),
            if options.picture.is_some() { 8.0 } else { 0.0 },
        ),
        (Stage::new("write"), 0.3),
    ]);
    let number = frame_number(&run, number)?;
    let mut still = RunStill::new(&mut run, number, &plan.shown, &skin)?;
    still.scene().metadata = run_provenance(&run).metadata();
    let mut outputs = Vec::new();
    if let Some(path) = &options.picture {
        let picture = still.picture(&run, &plan.shot, &picture)?;
        outputs.push(Output {
            path: path.clone(),
            bytes: picture.png_with(&still.scene().metadata),
        });
    }
    write.report(0.0)?;
    if let Some(path) = &options.output {
        let unit = options
            .mesh
            .unit
            .map_or(LengthUnit::Metre, LengthUnit::from);
        outputs.extend(files::encode(still.scene(), path, unit)?);
    }
    files::write_all(&outputs)?;
    let files = outputs
        .iter()
        .map(|o| (o.path.display().to_string(), o.bytes.len()));
    Ok(Made {
        skin: Some(owned(still.report())),
        files: files.collect(),
        ..Made::default()
    })
}

fn film(mut run: Run, plan: &FilmPlan, context: &Context) -> Result<Made, Failure> {
    let [skin, shots, video, write, extras] = context.split(film_stages(plan));
    let frames = plan.frames.clone().unwrap_or(0..run.frames());
    let Some(path) = &plan.output else {
        let mut made = RunFilm::new(&mut run, frames, &plan.shown, &skin)?;
        made.skinned().film.metadata = run_provenance(&run).metadata();
        let files = frame_pictures(&run, &mut made, plan, &shots)?;
        return Ok(Made {
            skin: Some(owned(made.report())),
            files,
            ..Made::default()
        });
    };
    let ending = ending(path);
    let usd = UsdFormat::from_path(path).filter(|&f| f != UsdFormat::Usda);
    if usd.is_none() && ending != "glb" && ending != "pvd" && !is_video(&ending) {
        return Err(Failure::request(format!(
            "{}: a film is written as .glb, .usdc, .usdz, .mp4, .webm or, for ParaView, .pvd",
            path.display()
        ))
        .hint("a single frame, as --frame 10, can be written in every mesh format"));
    }
    let beside = engines::paths(plan, path)?;
    let mut outputs = vec![path.as_path()];
    outputs.extend(beside.iter().map(PathBuf::as_path));
    files::check_distinct(&outputs, &[])?;
    if ending == "pvd" {
        if let Some(beside) = beside.first() {
            return Err(Failure::request(format!(
                "{}: a series for ParaView is of rods and has no pieces",
                beside.display()
            ))
            .hint("name a film, such as -o film.glb"));
        }
        return series(run, frames, path, context);
    }
    if is_video(&ending) {
        check_ffmpeg()?;
    }
    let mut made = RunFilm::new(&mut run, frames, &plan.shown, &skin)?;
    made.skinned().film.metadata = run_provenance(&run).metadata();
    let mut shown = frame_pictures(&run, &mut made, plan, &shots)?;
    if is_video(&ending) {
        let scratch = Scratch::beside(path)?;
        let folder = match &plan.pictures {
            Some(folder) => folder.clone(),
            None => {
                pictures(&run, &mut made, &scratch.0, &plan.shot, &shots)?;
                scratch.0.clone()
            }
        };
        video.report(0.0)?;
        let bytes = encode(&folder, run.scene.frames_per_second, path, &ending)?;
        shown.push((path.display().to_string(), bytes));
        return Ok(Made {
            skin: Some(owned(made.report())),
            files: shown,
            ..Made::default()
        });
    }
    write_film(made, shown, plan, (path, usd), [&write, &extras])
}

/// Writes a film, and all that the plan has beside it. `shown` lists what was written of it before.
fn write_film(
    mut made: RunFilm,
    mut shown: Vec<(String, usize)>,
    plan: &FilmPlan,
    (path, usd): (&Path, Option<UsdFormat>),
    [write, extras]: [&Context; 2],
) -> Result<Made, Failure> {
    write.report(0.0)?;
    let name = path
        .file_name()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    // All of it or nothing.
    let mut batch = Batch::default();
    let skinned = made.skinned();
    let (film, motion) = (&skinned.film, &mut skinned.motion);
    let (written, beside) = batch
        .stream(path, |file| -> Result<_, FilmError> {
            Ok(match usd {
                Some(format) => write_usd(format, film, motion, &name, file, write)?,
                None => (
                    write_glb(film, motion, &name, &plan.glb, file, write)?,
                    Vec::new(),
                ),
            })
        })
        .map_err(Failure::from)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let beside: Vec<Output> = beside.into_iter().map(|f| in_folder(folder, f)).collect();
    beside.iter().try_for_each(|output| batch.add(output))?;
    let mut files = vec![(path.display().to_string(), written.bytes as usize)];
    files.extend(
        beside
            .iter()
            .map(|o| (o.path.display().to_string(), o.bytes.len())),
    );
    files.append(&mut shown);
    let engines = engines::write(made.skinned(), plan, path, &mut batch, extras)?;
    batch.finish()?;
    Ok(Made {
        skin: Some(owned(made.report())),
        film: Some(written),
        files,
        engines,
    })
}

/// The stages of a film, by the seconds that they take.
fn film_stages(plan: &FilmPlan) -> [(Stage, f64); 5] {
    let video = plan
        .output
        .as_deref()
        .is_some_and(|path| is_video(&ending(path)));
    let on = |requested: bool, weight: f64| if requested { weight } else { 0.0 };
    [
        (Stage::new("skin"), 1.0),
        (
            Stage::new("pictures"),
            on(video || plan.pictures.is_some(), 100.0),
        ),
        (Stage::new("video"), on(video, 2.0)),
        (Stage::new("write"), on(!video, 1.0)),
        (Stage::new("for engines"), on(!video, 1.0)),
    ]
}

/// Renders all frames, if pictures of them are requested.
fn frame_pictures(
    run: &Run,
    made: &mut RunFilm,
    plan: &FilmPlan,
    context: &Context,
) -> Result<Vec<(String, usize)>, Failure> {
    let Some(folder) = &plan.pictures else {
        return Ok(Vec::new());
    };
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::work(format!("{}: cannot be made: {e}", folder.display())))?;
    let all = pictures(run, made, folder, &plan.shot, context)?;
    let bytes = all.iter().map(|f| f.1).sum();
    Ok(vec![(
        format!("{} pictures in {}", all.len(), folder.display()),
        bytes,
    )])
}

/// Where what is made of a run comes from: the scene that was simulated.
fn run_provenance(run: &Run) -> Provenance {
    provenance("skin", None, &run.scene)
}

/// Rods and bonds as a series of VTK files beside `path`.
fn series(run: Run, range: Range<usize>, path: &Path, context: &Context) -> Result<Made, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path
        .file_stem()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let mut bytes = 0;
    let put = |file: Encoded| {
        bytes += file.bytes.len();
        Ok(files::write_all(&[in_folder(folder, file)])?)
    };
    let count = write_series(&run, range, (&name, &run_provenance(&run)), put, context)
        .map_err(Failure::from)?;
    let written = format!(
        "{} with the {} files that it lists",
        path.display(),
        count - 1
    );
    Ok(Made {
        files: vec![(written, bytes)],
        ..Made::default()
    })
}

fn words(
    (skin, faces): (Option<&SkinReport>, &[SimulatedFaceReport]),
    film: Option<&FilmReport>,
    engines: &Engines,
    files: &[(String, usize)],
    stages: &[StageTime],
) -> String {
    let mut text = skin.map_or_else(String::new, ToString::to_string);
    for face in faces {
        let _ = write!(text, "{face}");
    }
    if let Some(film) = film {
        let _ = writeln!(
            text,
            "film     {} skinned pieces, {} that move as a whole; at most {:.3} mm off the skin of all joints",
            film.skinned,
            film.rigid,
            film.error() * 1e3
        );
    }
    engines.words(&mut text);
    for (file, bytes) in files {
        let _ = writeln!(text, "wrote    {file}, {}", size(*bytes));
    }
    let _ = writeln!(text, "took     {} s", spent(stages));
    text
}
