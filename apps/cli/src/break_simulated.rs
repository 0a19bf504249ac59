//! `greenstick break --simulate`: the still pieces of a break that is simulated, where the input has the wood.

use crate::arguments::{BreakOptions, FacesChoice};
use crate::break_files::{Targets, format_end};
use crate::break_run::{self, DrawError, Drawn};
use crate::break_wood::{ResolvedRequest, file_name, resolve_request, use_threads};
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use crate::simulate;
use greenstick::BreakReport;
use greenstick::fibre::scene::{Scene as Setting, StemChoice};
use greenstick::files;
use greenstick::files::run::read_body_meshes;
use greenstick::film::{open_run, picture_of_run};
use greenstick::geometry::{Context, Provenance, Scene};
use greenstick::picture::{Picture, PictureError, PictureOptions};
use greenstick::scanning::ScannedReport;
use greenstick::simulate::{
    MemoryRun, SceneMeshes, SimulateError, SimulateReport, SimulateRequest,
    simulate as simulate_scene,
};
use greenstick::simulated_faces::SimulatedFaceReport;
use greenstick::skin::film::{FilmOptions, FilmParameters, Run, SkinReport, Still};
use greenstick::skin::finish::Separation;
use greenstick_sweep::Input;
use greenstick_sweep::input::up_axis;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a ScannedReport>,
    simulation: &'a SimulateReport,
    #[serde(flatten)]
    pieces: PiecesReport<'a>,
    hangs_together: bool,
    outputs: &'a [Written],
    provenance: &'a Provenance,
    stages: &'a [StageTime],
}

/// The report on the pieces.
#[derive(Serialize)]
#[serde(untagged)]
enum PiecesReport<'a> {
    Drawn {
        #[serde(flatten)]
        report: &'a BreakReport,
        /// What each break was made from, from the base of the stem to its tip.
        simulated: &'a [SimulatedFaceReport],
    },
    Rods(&'a SkinReport),
}

/// The pieces.
enum Made {
    Drawn(Box<Drawn>),
    Rods(Box<Still>),
}

impl Made {
    fn scene(&self) -> &Scene {
        match self {
            Made::Drawn(made) => &made.broken.scene,
            Made::Rods(still) => &still.scene,
        }
    }

    fn scene_mut(&mut self) -> &mut Scene {
        match self {
            Made::Drawn(made) => &mut made.broken.scene,
            Made::Rods(still) => &mut still.scene,
        }
    }

    fn hangs_together(&self) -> bool {
        match self {
            Made::Drawn(made) => made.faces.reports.iter().any(|r| !r.parted),
            Made::Rods(still) => still.scene.nodes.iter().any(|n| n.name == "whole"),
        }
    }

    fn report(&self) -> PiecesReport<'_> {
        match self {
            Made::Drawn(made) => PiecesReport::Drawn {
                report: &made.broken.report,
                simulated: &made.faces.reports,
            },
            Made::Rods(still) => PiecesReport::Rods(&still.report),
        }
    }

    fn picture(
        &self,
        run: &Run,
        shot: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        match self {
            Made::Drawn(made) => made.picture(shot, context),
            Made::Rods(still) => picture_of_run(run, &still.scene, still.inner, shot, context),
        }
    }
}

/// Cuts the mesh along the faces that the run decided; wood that holds is left whole.
fn drawn(
    run: &mut Run,
    options: &BreakOptions,
    request: &ResolvedRequest,
    context: &Context,
) -> Result<Made, Failure> {
    let last = run.frames() - 1;
    match break_run::draw(run, last, options, request, context) {
        Ok(made) => Ok(Made::Drawn(Box::new(made))),
        Err(DrawError::Faces(error)) if error.wood_holds() => rods(run, request, context),
        Err(error) => Err(error.into()),
    }
}

/// Takes the pieces of the rods' skin.
fn rods(run: &mut Run, request: &ResolvedRequest, context: &Context) -> Result<Made, Failure> {
    let how = FilmOptions {
        texture_width: request.file.texture_width,
        bodies: false,
        ..FilmParameters::default().film_options(run.scene.seed)
    };
    let last = run.frames() - 1;
    let mut still = run.at_rest(last, &how, context).map_err(Failure::from)?;
    let common = &request.file.common;
    let by = Separation::new(common.separation, common.part_clear);
    run.part(&mut still, last, by, context)
        .map_err(Failure::from)?;
    Ok(Made::Rods(Box::new(still)))
}

pub fn run(options: &BreakOptions, name: &str) -> Result<ExitCode, Failure> {
    let request = resolve_request(options)?;
    if options.faces == FacesChoice::Rods {
        check_rods(options)?;
    }
    let unit = request.file.unit;
    let targets = Targets::new(options)?;
    let (mut setting, beside) = simulate::read(name)?;
    if options.request.text("break.seed").is_some() {
        setting.seed = request.file.common.recipe.face.seed;
    }
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [read, simulation, skin, write] = progress.split([
        ("read", 0.5),
        ("simulate", 30.0),
        ("skin", 3.0),
        ("write", targets.seconds()),
    ]);
    read.report(0.0)?;
    let inputs: Vec<PathBuf> = request.input.iter().cloned().collect();
    targets.check(&inputs)?;
    let (mesh, scan) = read_mesh(options, &request, &mut setting, &targets, &read)?;
    let meshes = SceneMeshes {
        input: mesh,
        bodies: read_body_meshes(&setting, &beside, simulate::reach(options.allow_outside))?,
    };
    let (report, mut run) = simulate_in_memory(setting, meshes, &simulation)?;
    let mut made = match options.faces {
        FacesChoice::Drawn => drawn(&mut run, options, &request, &skin)?,
        FacesChoice::Rods => rods(&mut run, &request, &skin)?,
    };
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
    made.scene_mut().metadata = provenance.metadata();
    let shot = request.file.picture.options();
    let outputs = targets.write(
        (made.scene(), unit),
        |context| made.picture(&run, &shot, context),
        None,
        &inputs,
        &write,
    )?;
    let stages = progress.finish();
    if options.reporting.prints_report() {
        let full = FullReport {
            scan: scan.as_ref(),
            simulation: &report,
            hangs_together: made.hangs_together(),
            pieces: made.report(),
            outputs: &written(&outputs),
            provenance: &provenance,
            stages: &stages,
        };
        print(&format_report(&full, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Refuses what only drawn faces have.
fn check_rods(options: &BreakOptions) -> Result<(), Failure> {
    let given = [
        ("--set", !options.set.is_empty()),
        ("--hang", options.request.text("break.hang").is_some()),
        ("--fray", options.request.text("fray").is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Failure::request(format!(
            "{name}: faces of rods have no relief to change; it goes with --faces drawn"
        ))),
        None => Ok(()),
    }
}

/// Reads the mesh to break, and sets in the scene where. Returns the mesh, and the report of a scan.
fn read_mesh(
    options: &BreakOptions,
    request: &ResolvedRequest,
    setting: &mut Setting,
    targets: &Targets,
    context: &Context,
) -> Result<(Option<Scene>, Option<ScannedReport>), Failure> {
    let places = options.request.texts("at");
    if places.len() > 1 {
        let count = places.len();
        return Err(Failure::request(format!(
            "--at: {count} places; a simulation breaks at one, and where the wood is weakest"
        )));
    }
    let at = places.first();
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
    let loaded = Input::load(path, at, request.file.unit, &request.file.scan, context)?;
    setting.stem.at = loaded.place;
    setting.stem.kind = StemChoice::Input;
    setting.stem.up = setting.stem.up.or(up_axis(path));
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

/// Formats the report.
fn format_report(full: &FullReport, json: bool) -> Result<String, Failure> {
    if json {
        return Ok(serde_json::to_string_pretty(full).map_err(Failure::work)? + "\n");
    }
    let mut text = full.scan.map_or_else(String::new, ToString::to_string);
    let _ = write!(text, "{}", full.simulation);
    match &full.pieces {
        PiecesReport::Drawn { report, simulated } => {
            let _ = write!(text, "{report}");
            for face in *simulated {
                let _ = write!(text, "{face}");
            }
        }
        PiecesReport::Rods(report) => {
            let _ = write!(text, "{report}");
            if full.hangs_together {
                text += "note     the wood still hangs together from end to end: it is one piece, `whole`; more load, more \
                         time or another scene may part it\n";
            }
        }
    }
    Ok(text + &format_end(full.outputs, full.stages))
}
