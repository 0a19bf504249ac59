//! `greenstick simulate`: from options to a scene, and from a run to pictures and a report.

use crate::arguments::{ReportingOptions, SimulateOptions};
use crate::break_wood::{file_name, use_threads};
use crate::failure::{Failure, print, room_hint};
use crate::outcome::spent;
use crate::progress::{Progress, StageTime};
use crate::skin::{self, FilmPlan, is_film};
use greenstick::fibre::scene::{BUILT_IN, Scene, SceneError, StemChoice};
use greenstick::fibre::{Event, EventKind};
use greenstick::files::run::{Origin, RunFolder, read_body_meshes};
use greenstick::files::{self, FileError, Output};
use greenstick::film::open_run;
use greenstick::formats::{self, Format, LengthUnit, Reach};
use greenstick::geometry::{Context, Metadata, Motion, Provenance, Scene as Mesh, Stage};
use greenstick::provenance;
use greenstick::scanning::ScannedReport;
use greenstick::simulate::{
    RunError, RunSource, SceneMeshes, SimulateError, SimulateReport, SimulateRequest, energy_chart,
    find_break, load_chart, simulate,
};
use greenstick::skin::film::Run;
use greenstick::wood::scan::with_scan;
use greenstick_sweep::Input;
use greenstick_sweep::input::up_axis;
use greenstick_sweep::shown::{RunFilm, ShownAs, film_shot};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(flatten)]
    report: &'a SimulateReport,
    pictures: &'a [String],
    provenance: &'a Provenance,
    stages: &'a [StageTime],
}

#[derive(Serialize)]
struct Listed {
    name: &'static str,
    about: String,
    duration_s: f64,
}

pub fn run(options: &SimulateOptions) -> Result<ExitCode, Failure> {
    if options.list {
        return list(options.reporting.json);
    }
    if options.markdown {
        print(&Scene::reference_markdown())?;
        return Ok(ExitCode::SUCCESS);
    }
    let Some(name) = &options.scene else {
        return Err(Failure::request("no scene is named")
            .hint("`greenstick simulate --list` lists those that come with the program"));
    };
    let (mut scene, beside) = read(name)?;
    change(&mut scene, options)?;
    if let Some(path) = &options.save_scene {
        save(&scene, path)?;
        if options.output.is_none() {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let Some(output) = &options.output else {
        return Err(Failure::request("no folder is named for the results").hint("such as -o run"));
    };
    // A film is made of a run, whose folder is beside it.
    let film = is_film(output).then(|| output.with_extension("run"));
    let folder = film.as_ref().unwrap_or(output);
    if film.is_some() {
        files::check_writable(output)?;
    }
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [read, finding, work, shots, filming] = stages(&progress, options, film.is_some());
    let unit = options.mesh.unit.map(LengthUnit::from);
    let path = options.mesh.input.as_deref();
    let stem = path.map(|path| read_stem(path, &mut scene, options, &read));
    let (input, scan) = stem.transpose()?.map(|s| (s.scene, s.scan)).unzip();
    let bodies = read_body_meshes(&scene, &beside, reach(options.allow_outside))?;
    let meshes = SceneMeshes { input, bodies };
    let (bark, scan) = scan.flatten().unzip();
    let made = with_scan(run_provenance(name, options, &scene), scan.as_ref());
    let origin = Origin::new(path.map(|path| (path, unit)), &beside);
    let mut run = RunFolder::new(folder, origin).made_by(&made);
    if let Some(bark) = bark {
        run = run.of_scan(bark);
    }
    let mut request = SimulateRequest {
        scene,
        meshes,
        // A run that was stopped before its first checkpoint, or never begun, begins.
        resume: options.resume && has_checkpoint(&run)?,
    };
    if options.refine {
        refine(&mut request, &run, &finding)?;
    }
    let mut report = simulate(&request, &mut run, &work).map_err(|e| failure(e, folder))?;
    let notes = scan.map(|scan| scan.notes);
    report.notes.splice(0..0, notes.unwrap_or_default());
    let (opened, pictures) = show(
        run,
        &mut request.meshes,
        options,
        (&made.metadata(), &shots),
    )?;
    let full = FullReport {
        report: &report,
        pictures: &pictures,
        provenance: &made,
        stages: &progress.finish(),
    };
    print_report(&full, &options.reporting)?;
    if let (Some(run), true) = (opened, film.is_some()) {
        make_film(run, options, output, (&progress, &filming))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Opens a run that has ended, if pictures or a film are to be made of it, and takes the pictures.
fn show(
    run: RunFolder,
    meshes: &mut SceneMeshes,
    options: &SimulateOptions,
    (metadata, context): (&Metadata, &Context),
) -> Result<(Option<Run>, Vec<String>), Failure> {
    let film = options.output.as_deref().filter(|path| is_film(path));
    if options.no_pictures && film.is_none() {
        return Ok((None, Vec::new()));
    }
    if let (Some(path), Some(mesh)) = (&options.mesh.input, &mut meshes.input) {
        match film {
            Some(film) if options.no_pictures => files::carry_images(mesh, path, film),
            _ => files::embed_images(mesh, path),
        }
    }
    let [opening, shots] =
        context.split([(Stage::new("read"), 1.0), (Stage::new("pictures"), 9.0)]);
    let source = Arc::new(run);
    let mut run = open_run(source.clone(), meshes, &opening).map_err(Failure::from)?;
    if options.no_pictures {
        return Ok((Some(run), Vec::new()));
    }
    let taken = pictures(&source, &mut run, options, (metadata, &shots)).map_err(|e| {
        e.or_cancelled(format!(
            "stopped; the simulation in {} is complete, and the same command with --resume takes its pictures",
            source.path().display()
        ))
    })?;
    Ok((Some(run), taken))
}

/// Whether there is a checkpoint to go on from.
fn has_checkpoint(run: &RunFolder) -> Result<bool, Failure> {
    let found = run.checkpoint();
    Ok(found.map_err(|e| failure(e.into(), run.path()))?.is_some())
}

/// The parts of the work, each with its weight.
fn stages(progress: &Progress, options: &SimulateOptions, film: bool) -> [Context; 5] {
    progress.split([
        ("read", 0.5),
        ("find the break", if options.refine { 10.0 } else { 0.0 }),
        ("simulate", 30.0),
        ("pictures", if options.no_pictures { 0.0 } else { 20.0 }),
        ("film", if film { 10.0 } else { 0.0 }),
    ])
}

/// What the stem is found in.
struct StemInput {
    scene: Mesh,
    /// Of a scan: its bark as the GLB file that `scene` was read from, and how it was made.
    scan: Option<(Vec<u8>, ScannedReport)>,
}

/// Reads the mesh, or the scan whose bark is one, and places the scene's stem in it.
fn read_stem(
    path: &Path,
    scene: &mut Scene,
    options: &SimulateOptions,
    context: &Context,
) -> Result<StemInput, Failure> {
    let unit = options.mesh.unit.map(LengthUnit::from);
    let loaded = Input::load(path, scene.stem.at, unit, &options.scan.set()?, context)?;
    (scene.stem.kind, scene.stem.at) = (StemChoice::Input, loaded.place);
    scene.stem.up = scene.stem.up.or(up_axis(path));
    let Some(scan) = loaded.scan else {
        return Ok(StemInput {
            scene: loaded.scene,
            scan: None,
        });
    };
    // What is made of the run later reads the file, with its rounding.
    let (name, metre) = ("scan.glb", LengthUnit::Metre);
    let failed = |error| Failure::from(FileError::Content(error));
    let files = formats::write(Format::Glb, &loaded.scene, name, metre).map_err(failed)?;
    let bark = files.into_iter().next().map_or(Vec::new(), |f| f.bytes);
    let none = |_: &str| Err(std::io::Error::other("a scan has no textures"));
    let read = formats::read(Format::Glb, &bark, name, Some(metre), &none).map_err(failed)?;
    Ok(StemInput {
        scene: read,
        scan: Some((bark, scan)),
    })
}

/// Writes a scene with all its keys.
fn save(scene: &Scene, path: &Path) -> Result<(), Failure> {
    let bytes = scene.to_toml().into_bytes();
    let path = path.to_owned();
    Ok(files::write_all(&[Output { path, bytes }])?)
}

/// Sets where the edges of a scene are short: about where it breaks in a coarse run, or as they are in a run that is resumed.
fn refine(
    request: &mut SimulateRequest,
    run: &RunFolder,
    context: &Context,
) -> Result<(), Failure> {
    let fail = |error| failure(error, run.path());
    request.scene.rods.fine = if request.resume {
        run.scene().map_err(|e| fail(e.into()))?.rods.fine
    } else {
        find_break(request, context).map_err(fail)?
    };
    Ok(())
}

/// Where a run comes from: the scene by its name, the mesh, and what is not at its default.
fn run_provenance(name: &str, options: &SimulateOptions, scene: &Scene) -> Provenance {
    let name = file_name(Some(Path::new(name))).unwrap_or_default();
    let input = file_name(options.mesh.input.as_deref());
    provenance(&format!("simulate {name}"), input.as_deref(), scene)
}

fn print_report(full: &FullReport, reporting: &ReportingOptions) -> Result<(), Failure> {
    if !reporting.prints_report() {
        return Ok(());
    }
    let text = if reporting.json {
        let text = serde_json::to_string_pretty(full)
            .map_err(|e| Failure::work(format!("the report cannot be put into JSON: {e}")))?;
        text + "\n"
    } else {
        let mut text = full.report.to_string();
        for file in full.report.files.iter().chain(full.pictures) {
            let _ = writeln!(text, "wrote    {file}");
        }
        let _ = writeln!(text, "took     {} s", spent(full.stages));
        text
    };
    print(&text)
}

/// Makes the skin of a run as a film in the file `output`.
fn make_film(
    run: Run,
    options: &SimulateOptions,
    output: &Path,
    (progress, context): (&Progress, &Context),
) -> Result<(), Failure> {
    let shot = options.picture_parameters.set()?.options();
    let plan = FilmPlan::whole_film(output.to_owned(), run.scene.seed, shot);
    let reporting = ReportingOptions {
        // One report in JSON is enough.
        quiet: options.reporting.quiet || options.reporting.json,
        json: false,
        ..options.reporting.clone()
    };
    skin::run_plan(run, &plan, &reporting, progress, context)
}

fn list(json: bool) -> Result<ExitCode, Failure> {
    let mut listed = Vec::new();
    for built_in in BUILT_IN {
        let scene = built_in.scene().map_err(Failure::work)?;
        listed.push(Listed {
            name: built_in.name,
            about: scene.about,
            duration_s: scene.duration,
        });
    }
    let text = if json {
        serde_json::to_string_pretty(&listed).map_err(Failure::work)? + "\n"
    } else {
        listed.iter().fold(String::new(), |mut text, l| {
            let _ = writeln!(text, "{:<14} {:>4} s  {}", l.name, l.duration_s, l.about);
            text
        })
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// How far the files lie that a scene may name.
pub fn reach(allow_outside: bool) -> Reach {
    if allow_outside {
        Reach::Outside
    } else {
        Reach::Folder
    }
}

/// A scene file, or one that comes with the program; and the folder that its files are named from.
pub fn read(name: &str) -> Result<(Scene, PathBuf), Failure> {
    let path = Path::new(name);
    if path.extension().is_none_or(|e| e != "toml") {
        let scene = Scene::built_in(name).map_err(|e| {
            Failure::request(e)
                .hint("`greenstick simulate --list` lists them; a file ends in .toml")
        })?;
        return Ok((scene, PathBuf::new()));
    }
    let text = files::read_text(path)?;
    let scene = Scene::read(&text).map_err(|e| Failure::request(format!("{name}: {e}")))?;
    Ok((scene, path.parent().unwrap_or(Path::new("")).to_owned()))
}

fn change(scene: &mut Scene, options: &SimulateOptions) -> Result<(), Failure> {
    let solver = scene.solver;
    options.changes.apply(scene, |_, _| Ok(None))?;
    if let Some(path) = &options.rings_from {
        let rings = files::read_rings(path)?;
        scene.rings.series.ring_shares = Some(rings.shares);
        let onset = scene.stem.eccentricity_onset;
        scene.stem.eccentricity_onset = onset.or(rings.eccentricity_onset);
    }
    if scene.solver != solver && options.changes.text("step").is_none() {
        // A step that was given for another solver says nothing about this one's.
        scene.step = None;
    }
    scene.check().map_err(|e: SceneError| Failure::request(e))
}

fn failure(error: SimulateError, folder: &Path) -> Failure {
    let resume = "the same command with --resume continues from the checkpoint";
    match &error {
        SimulateError::Cancelled(_) => {
            Failure::cancelled(format!("stopped; {resume} in {}", folder.display()))
        }
        SimulateError::Run(RunError::Unwritable { source, .. }) => match room_hint(source) {
            Some(room) => Failure::from(error).hint(format!("{room}; then {resume}")),
            None => error.into(),
        },
        SimulateError::Taken { .. } => Failure::from(error).hint(resume),
        _ => error.into(),
    }
}

/// Pictures of the first frame, of one in which the wood breaks and of the last.
fn pictures(
    source: &RunFolder,
    run: &mut Run,
    options: &SimulateOptions,
    (metadata, context): (&Metadata, &Context),
) -> Result<Vec<String>, Failure> {
    let [skinning, framing, drawing] = context.split([
        (Stage::new("skin"), 1.0),
        (Stage::new("frames"), 0.2),
        (Stage::new("pictures"), 9.0),
    ]);
    let folder = source.path();
    let fail = |error: RunError| failure(error.into(), folder);
    // Pictures show the wood by its address and need no textures.
    let how = ShownAs::best(run.scene.seed, 0);
    let all = run.frames();
    let mut film = RunFilm::new(run, 0..all, &how, &skinning)?;
    let events = source.events().map_err(fail)?;
    let mut numbers = vec![0, breaking_frame(&mut film, &events), all.saturating_sub(1)];
    numbers.dedup();
    let view = film.view(&numbers, &framing)?;
    let shot = film_shot(&view, &options.picture_parameters.set()?.options());
    let mut outputs = Vec::new();
    let count = numbers.len();
    for (done, number) in numbers.into_iter().enumerate() {
        let scene = film.at(run, number)?;
        let picture = film.picture(run, &scene, &shot, &drawing.item(done, count))?;
        outputs.push(Output {
            path: folder.join(format!("frame-{number:05}.png")),
            bytes: picture.png_with(metadata),
        });
    }
    let chart = energy_chart(&source.energies().map_err(fail)?);
    outputs.push(Output {
        path: folder.join("energy.png"),
        bytes: chart.png_with(metadata),
    });
    if let Some(chart) = load_chart(&source.forces().map_err(fail)?) {
        outputs.push(Output {
            path: folder.join("load-deflection.png"),
            bytes: chart.png_with(metadata),
        });
    }
    files::write_all(&outputs)?;
    Ok(outputs
        .iter()
        .map(|o| o.path.display().to_string())
        .collect())
}

/// Share of the rods that break which are broken when the wood is shown breaking, and frames by which its faces have opened after that.
const BROKEN: f64 = 0.9;
const OPENING: usize = 2;

/// A frame in which the wood has just broken, or the middle one of wood that holds.
fn breaking_frame(film: &mut RunFilm, events: &[Event]) -> usize {
    let motion = &film.skinned().motion;
    let last = motion.frames().saturating_sub(1);
    let mut times: Vec<f64> = (events.iter())
        .filter(|event| event.kind == EventKind::RodBroke)
        .map(|event| event.time)
        .collect();
    times.sort_by(f64::total_cmp);
    match times.get((BROKEN * times.len() as f64) as usize) {
        Some(&time) => {
            let broken = (0..last).find(|&n| motion.time(n) >= time);
            broken.map_or(last, |n| (n + OPENING).min(last))
        }
        None => motion.frames() / 2,
    }
}
