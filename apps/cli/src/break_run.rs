//! `greenstick break --from-run`: the mesh of a run, cut along the faces that the run decided.

use crate::arguments::BreakOptions;
use crate::break_files::{Targets, format_end, recipe_text};
use crate::break_wood::{ResolvedRequest, file_name, resolve_request, use_threads};
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use crate::skin::{self, NamedMesh};
use greenstick::fibre::scene::StemChoice;
use greenstick::files::run::Origin;
use greenstick::geometry::{Context, Provenance};
use greenstick::simulated_faces::{
    PartlyBroken, SimulatedFaceReport, SimulatedFaces, SimulatedFacesError, simulated_faces,
};
use greenstick::skin::film::Run;
use greenstick::{BreakReport, Broken};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Serialize)]
struct FullReport<'a> {
    #[serde(flatten)]
    report: &'a BreakReport,
    /// What each break was made from, from the base of the stem to its tip.
    simulated: &'a [SimulatedFaceReport],
    outputs: &'a [Written],
    provenance: &'a Provenance,
    stages: &'a [StageTime],
}

pub fn run(options: &BreakOptions, folder: &Path) -> Result<ExitCode, Failure> {
    let targets = Targets::new(options)?;
    let request = resolve_request(options)?;
    use_threads(options.reporting.threads)?;
    let progress = Progress::start(options.reporting.quiet);
    let [read, work, write] =
        progress.split([("read", 0.5), ("break", 2.0), ("write", targets.seconds())]);
    let inputs: Vec<PathBuf> = request.input.iter().cloned().collect();
    targets.check(&inputs)?;
    let named = request.input.clone().map(|path| (path, request.file.unit));
    let mesh = named.or(Origin::read(folder).map_err(Failure::request)?.input_file());
    let run = skin::open(folder, mesh.clone(), targets.pieces.as_deref(), &read)?;
    if let Some(input) = &request.input
        && run.scene.stem.kind != StemChoice::Input
    {
        return Err(Failure::request(format!(
            "{}: the run in {} is of a stem that its scene makes, and of no mesh",
            input.display(),
            folder.display()
        ))
        .hint("leave the mesh out, or simulate the scene on it: greenstick simulate SCENE MESH -o FOLDER"));
    }
    let number = skin::frame_number(&run, options.frame.unwrap_or(-1))?;
    let (mut broken, faces) = draw(&run, number, options, &request, &work)?;
    let recipe = match &targets.recipe {
        Some(path) => Some(recipe_of_faces(&request, &faces, mesh, path)?),
        None => None,
    };
    let provenance = provenance(&run, &request);
    broken.scene.metadata = provenance.metadata();
    let shot = request.file.picture.options();
    let outputs = targets.write(
        (&broken.scene, request.file.unit),
        |context| greenstick::picture_of_break(&broken, &shot, context),
        recipe,
        &inputs,
        &write,
    )?;
    let stages = progress.finish();
    if options.reporting.prints_report() {
        let full = FullReport {
            report: &broken.report,
            simulated: &faces.reports,
            outputs: &written(&outputs),
            provenance: &provenance,
            stages: &stages,
        };
        print(&format_report(&full, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Cuts the mesh of a run along the faces that a frame of it decided.
pub fn draw(
    run: &Run,
    number: usize,
    options: &BreakOptions,
    request: &ResolvedRequest,
    context: &Context,
) -> Result<(Broken, SimulatedFaces), DrawError> {
    let [deciding, cutting] = context.split([
        (greenstick::geometry::Stage::new("faces"), 1.0),
        (greenstick::geometry::Stage::new("break"), 3.0),
    ]);
    let mut faces = simulated_faces(run, number, PartlyBroken::Separated, &deciding)?;
    faces.request.texture_width = request.file.texture_width;
    let common = &request.file.common;
    for one in &mut faces.request.breaks {
        (one.separation, one.part_clear) = (common.separation, common.part_clear);
        one.fray = common.fray;
        one.recipe.face.hang = common.recipe.face.hang;
    }
    for setting in &options.set {
        faces
            .apply_setting(setting)
            .map_err(|e| DrawError::Other(Failure::request(format!("--set: {e}"))))?;
    }
    let broken = faces
        .broken(&cutting)
        .map_err(|error| DrawError::Other(error.into()))?;
    Ok((broken, faces))
}

/// Returns the recipe at `path` that breaks `mesh`, which was simulated, along the same faces.
fn recipe_of_faces(
    request: &ResolvedRequest,
    faces: &SimulatedFaces,
    mesh: NamedMesh,
    path: &Path,
) -> Result<String, Failure> {
    let Some((mesh, unit)) = mesh else {
        return Err(Failure::request(
            "--save-recipe: the scene makes a stem of its own, and a recipe breaks the mesh of a file",
        )
        .hint("simulate the scene on a mesh: greenstick simulate SCENE MESH -o FOLDER"));
    };
    let mut file = request.file.clone().with_request(&faces.request);
    file.unit = unit;
    recipe_text(&file, Some(&mesh), path)
}

/// Where the pieces come from: the scene that was simulated.
fn provenance(run: &Run, request: &ResolvedRequest) -> Provenance {
    let input = file_name(request.input.as_deref());
    greenstick::provenance("break --from-run", input.as_deref(), &run.scene)
}

/// Why no face was cut.
pub enum DrawError {
    /// The run decides none.
    Faces(SimulatedFacesError),
    /// It cannot be cut.
    Other(Failure),
}

impl From<SimulatedFacesError> for DrawError {
    fn from(error: SimulatedFacesError) -> Self {
        DrawError::Faces(error)
    }
}

impl From<SimulatedFacesError> for Failure {
    fn from(error: SimulatedFacesError) -> Self {
        match error {
            SimulatedFacesError::Run(error) => error.into(),
            other => Failure::new(other.kind(), &other),
        }
    }
}

impl From<DrawError> for Failure {
    fn from(error: DrawError) -> Self {
        match error {
            DrawError::Faces(error) => error.into(),
            DrawError::Other(failure) => failure,
        }
    }
}

/// Formats the report.
fn format_report(full: &FullReport, json: bool) -> Result<String, Failure> {
    if json {
        return Ok(serde_json::to_string_pretty(full).map_err(Failure::work)? + "\n");
    }
    let mut text = full.report.to_string();
    for report in full.simulated {
        let _ = write!(text, "{report}");
    }
    Ok(text + &format_end(full.outputs, full.stages))
}
