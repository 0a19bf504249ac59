//! `greenstick break --simulate`: the still pieces of a break that is simulated, where the input has the wood.

use crate::arguments::BreakOptions;
use crate::break_wood::{
    ResolvedRequest, Targets, file_name, resolve_request, size, targets, use_threads,
};
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use crate::{scan, simulate};
use greenstick::fibre::scene::{Scene as Setting, StemChoice};
use greenstick::files::run::read_body_meshes;
use greenstick::files::{self, Output};
use greenstick::film::{open_run, picture_of_run};
use greenstick::geometry::{Context, Provenance, Scene};
use greenstick::scanning::ScannedReport;
use greenstick::simulate::{
    MemoryRun, SceneMeshes, SimulateError, SimulateReport, SimulateRequest,
    simulate as simulate_scene,
};
use greenstick::skin::film::{FilmOptions, FilmParameters, Run, SkinReport, Still};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a ScannedReport>,
    simulation: &'a SimulateReport,
    #[serde(flatten)]
    pieces: &'a SkinReport,
    hangs_together: bool,
    outputs: &'a [Written],
    provenance: &'a Provenance,
    stages: &'a [StageTime],
}

pub fn run(options: &BreakOptions, name: &str) -> Result<ExitCode, Failure> {
    let request = resolve_request(options)?;
    let unit = request.file.unit;
    let targets = targets(options)?;
    let (mut setting, beside) = simulate::read(name)?;
    if options.request.text("break.seed").is_some() {
        setting.seed = request.file.common.recipe.face.seed;
    }
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [read, simulation, skin, encode, picture, write] = progress.split([
        ("read", 0.5),
        ("simulate", 30.0),
        ("skin", 3.0),
        ("encode", 0.1),
        ("picture", if targets.picture.is_some() { 8.0 } else { 0.0 }),
        ("write", 0.1),
    ]);
    read.report(0.0)?;
    let inputs: Vec<PathBuf> = request.input.iter().cloned().collect();
    targets.check(&inputs)?;
    let (mesh, scan) = read_mesh(options, &request, &mut setting, &targets, &read)?;
    let meshes = SceneMeshes {
        input: mesh,
        bodies: read_body_meshes(&setting, &beside)?,
    };
    let (report, mut run) = simulate_in_memory(setting, meshes, &simulation)?;
    let how = FilmOptions {
        texture_width: request.file.texture_width,
        bodies: false,
        ..FilmParameters::default().film_options(run.scene.seed)
    };
    let last = run.frames() - 1;
    let mut still = run.at_rest(last, &how, &skin).map_err(Failure::from)?;
    part(&mut still, &run, request.file.common.separation);
    let input = file_name(request.input.as_deref());
    let mut provenance = request.file.provenance(input.as_deref(), scan.as_ref());
    let simulated = greenstick::provenance("break --simulate", None, &run.scene);
    provenance.command = simulated.command;
    provenance.seed = simulated.seed;
    let settings = simulated
        .parameters
        .into_iter()
        .map(|p| format!("scene.{p}"));
    provenance.parameters.extend(settings);
    still.scene.metadata = provenance.metadata();
    let mut outputs = Vec::new();
    if let Some(path) = &targets.pieces {
        encode.report(0.0)?;
        outputs.extend(files::encode(&still.scene, path, unit.unwrap_or_default())?);
    }
    if let Some(path) = &targets.picture {
        let shot = request.file.picture.options();
        let picture = picture_of_run(&run, &still.scene, still.inner, &shot, &picture)?;
        let (path, bytes) = (path.clone(), picture.png_with(&still.scene.metadata));
        outputs.push(Output { path, bytes });
    }
    write.report(0.0)?;
    let paths: Vec<&Path> = outputs.iter().map(|o| o.path.as_path()).collect();
    files::check_distinct(&paths, &inputs)?;
    files::write_all(&outputs)?;
    let stages = progress.finish();
    if options.reporting.prints_report() {
        let full = FullReport {
            scan: scan.as_ref(),
            simulation: &report,
            pieces: &still.report,
            hangs_together: still.scene.nodes.iter().any(|n| n.name == "whole"),
            outputs: &written(&outputs),
            provenance: &provenance,
            stages: &stages,
        };
        print(&format_report(&full, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Reads the mesh to break, and sets in the scene where. Returns the mesh, and the report of a scan.
fn read_mesh(
    options: &BreakOptions,
    request: &ResolvedRequest,
    setting: &mut Setting,
    targets: &Targets,
    context: &Context,
) -> Result<(Option<Scene>, Option<ScannedReport>), Failure> {
    let at = options.request.text("at");
    let Some(path) = &request.input else {
        return match at {
            Some(at) if setting.stem.kind != StemChoice::Input => Err(Failure::request(format!(
                "--at {at}: the scene makes a stem of its own, and its clamps and bodies say where that breaks"
            ))
            .hint("name a mesh to break: greenstick break pole.ply --simulate scene.toml --at 0.4")),
            _ => Ok((None, None)),
        };
    };
    let at = match at {
        Some(_) => request.file.common.place,
        None => setting.stem.at,
    };
    let loaded = scan::load(path, at, request.file.unit, &request.file.scan, context)?;
    setting.stem.at = loaded.place;
    setting.stem.kind = StemChoice::Input;
    let mut scene = loaded.scene;
    if let Some(pieces) = &targets.pieces {
        files::carry_images(&mut scene, path, pieces);
    }
    Ok((Some(scene), loaded.scan))
}

/// The fraction of a simulated break that the simulation takes; the rest is opening the run.
const SIMULATED: f64 = 0.98;

/// Runs the scene in memory, and opens the run.
fn simulate_in_memory(
    scene: Setting,
    meshes: SceneMeshes,
    context: &Context,
) -> Result<(SimulateReport, Run), Failure> {
    let request = SimulateRequest {
        scene,
        meshes,
        resume: false,
    };
    let mut store = MemoryRun::new();
    let simulated = simulate_scene(&request, &mut store, &context.part(0.0, SIMULATED));
    let report = simulated.map_err(|error| match error {
        SimulateError::NoInput => Failure::request("the scene is of a mesh, and none is named")
            .hint("name it, such as greenstick break pole.ply --simulate scene.toml"),
        other => other.into(),
    })?;
    let opening = context.part(SIMULATED, 1.0);
    let run = open_run(Arc::new(store), &request.meshes, &opening).map_err(Failure::from)?;
    Ok((report, run))
}

/// Moves what lies beyond the break apart from the lower piece, with all that it carries.
fn part(still: &mut Still, run: &Run, by: f64) {
    let stem = run.stem();
    let along = stem.grain.axis().frame(stem.location).tangent;
    let nodes = &mut still.scene.nodes;
    let upper = nodes.iter().position(|n| n.name == "upper");
    for (number, node) in nodes.iter_mut().enumerate() {
        if upper.is_some_and(|u| u == number || node.parent == Some(u)) {
            node.transform.translation += along * by;
        }
    }
}

/// Formats the report.
fn format_report(full: &FullReport, json: bool) -> Result<String, Failure> {
    if json {
        return Ok(serde_json::to_string_pretty(full).map_err(Failure::work)? + "\n");
    }
    let mut text = full.scan.map_or_else(String::new, ToString::to_string);
    let _ = write!(text, "{}{}", full.simulation, full.pieces);
    if full.hangs_together {
        text += "note     the wood still hangs together from end to end: it is one piece, `whole`; more load, more time or \
                 another scene may part it\n";
    }
    for file in full.outputs {
        let _ = writeln!(text, "wrote    {}, {}", file.path, size(file.bytes));
    }
    let total: f64 = full.stages.iter().map(|s| s.seconds).sum();
    let _ = writeln!(text, "time     {total:.2} s");
    Ok(text)
}
