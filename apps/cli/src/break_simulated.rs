//! `greenstick break --simulate`: the still pieces of a break that is simulated, where the input has the wood.

use crate::arguments::BreakOptions;
use crate::break_wood::{ResolvedRequest, resolve_request, size, targets, use_threads};
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use crate::{scan, simulate, values};
use greenstick::fibre::scene::{Scene as Setting, StemWord};
use greenstick::files::{self, Output};
use greenstick::film::{FilmOptions, Run, SkinReport, Still};
use greenstick::formats::LengthUnit;
use greenstick::geometry::{Context, Scene};
use greenstick::scanning::ScannedReport;
use greenstick::schema::Field;
use greenstick::simulate::{Origin, SimulateError, SimulateReport, SimulateRequest};
use greenstick::skin::rods::RodSkinOptions;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a ScannedReport>,
    simulation: &'a SimulateReport,
    #[serde(flatten)]
    pieces: &'a SkinReport,
    hangs_together: bool,
    outputs: &'a [Written],
    stages: &'a [StageTime],
}

/// A folder that goes with its content.
struct Temporary(PathBuf);

impl Temporary {
    fn new() -> Result<Self, Failure> {
        let path = std::env::temp_dir().join(format!("greenstick-break-{}", std::process::id()));
        std::fs::create_dir(&path).map_err(|e| {
            Failure::work(format!(
                "{}: cannot be made for the simulation: {e}",
                path.display()
            ))
        })?;
        Ok(Temporary(path))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // What cannot be removed stays for the system to clear.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn run(options: &BreakOptions, name: &str) -> Result<ExitCode, Failure> {
    let ResolvedRequest { file, input } = resolve_request(options)?;
    let unit = file.unit;
    let targets = targets(options)?;
    let (mut setting, beside) = simulate::read(name)?;
    if options.request.text("break.seed").is_some() {
        setting.seed = file.common.recipe.face.seed;
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
    let inputs: Vec<PathBuf> = input.iter().cloned().collect();
    let at = options.request.text("at");
    targets.check(&inputs)?;
    let mut mesh = None;
    let mut scan = None;
    if let (None, Some(at)) = (&input, at)
        && setting.stem.kind != StemWord::Input
    {
        return Err(Failure::request(format!(
            "--at {at}: the scene makes a stem of its own, and its clamps and bodies say where that breaks"
        ))
        .hint("name a mesh to break: greenstick break pole.ply --simulate scene.toml --at 0.4"));
    }
    if let Some(path) = &input {
        let at = match at {
            Some(_) => file.common.place,
            None => values::place(&setting.stem.at, LengthUnit::Metre).map_err(Failure::request)?,
        };
        let loaded = scan::load(path, at, unit, &file.scan, &read)?;
        setting.stem.at = loaded.place.to_value().to_string();
        scan = loaded.scan;
        let mut scene = loaded.scene;
        if let Some(pieces) = &targets.pieces {
            files::carry_images(&mut scene, path, pieces);
        }
        setting.stem.kind = StemWord::Input;
        mesh = Some(scene);
    }
    // The run reads from the folder, and so is dropped before it.
    let (report, _folder, mut run) = simulated(setting, &beside, mesh.as_ref(), &simulation)?;
    let how = FilmOptions {
        skin: RodSkinOptions {
            seed: run.scene.seed,
            ..RodSkinOptions::default()
        },
        texture_width: file.texture_width,
        bodies: false,
        rest: true,
    };
    let last = run.frames() - 1;
    let mut still = run.at_rest(last, &how, &skin).map_err(Failure::from)?;
    part(&mut still, &run, file.common.separation);
    let mut outputs = Vec::new();
    if let Some(path) = &targets.pieces {
        encode.report(0.0)?;
        outputs.extend(files::encode(&still.scene, path, unit.unwrap_or_default())?);
    }
    if let Some(path) = &targets.picture {
        let shot = file.picture.options();
        let picture = run.picture(&still.scene, still.inner, &shot, &picture)?;
        let (path, bytes) = (path.clone(), picture.png());
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
            stages: &stages,
        };
        print(&format_report(&full, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The part of a simulated break that the simulation takes; opening what it left is the rest.
const SIMULATED: f64 = 0.98;

/// Runs the scene in a folder of its own and opens what it left.
fn simulated(
    scene: Setting,
    beside: &Path,
    mesh: Option<&Scene>,
    context: &Context,
) -> Result<(SimulateReport, Temporary, Run), Failure> {
    let folder = Temporary::new()?;
    let request = SimulateRequest {
        scene,
        origin: Origin::of(None, beside),
        folder: folder.0.clone(),
        resume: false,
    };
    let report = greenstick::simulate::simulate(mesh, &request, &context.part(0.0, SIMULATED))
        .map_err(|error| match error {
            SimulateError::NoInput => Failure::request("the scene is of a mesh, and none is named")
                .hint("name it, such as greenstick break pole.ply --simulate scene.toml"),
            other => other.into(),
        })?;
    let beside = request.origin.beside;
    let run = Run::open(&folder.0, mesh, &beside, &context.part(SIMULATED, 1.0))
        .map_err(Failure::from)?;
    Ok((report, folder, run))
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
