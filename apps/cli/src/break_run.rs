//! `greenstick break --from-run`: the mesh of a run, cut along the faces that the run decided.

use crate::arguments::BreakOptions;
use crate::break_files::{Targets, format_end, recipe_text};
use crate::break_wood::{ResolvedRequest, file_name, resolve_request, use_threads};
use crate::failure::{Failure, print};
use crate::outcome::{Written, written};
use crate::progress::{Progress, StageTime};
use crate::skin::{self, MeshImages, NamedMesh};
use greenstick::fibre::scene::StemChoice;
use greenstick::files::run::Origin;
use greenstick::fracture::recipe::apply_setting;
use greenstick::geometry::{Context, Node, Provenance, Scene, Stage};
use greenstick::picture::{Picture, PictureError, PictureOptions};
use greenstick::simulated_faces::{
    PartlyBroken, SimulatedFaceReport, SimulatedFaces, SimulatedFacesError, simulated_faces,
};
use greenstick::skin::film::{FilmError, FilmOptions, Run};
use greenstick::{BreakReport, Broken, picture_of_break, picture_of_moved_break};
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
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
    let images = (targets.pieces.as_deref()).map_or(MeshImages::Embedded, MeshImages::Carried);
    let mut run = skin::open(folder, mesh.clone(), images, &read)?;
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
    let mut made = draw(&mut run, number, options, &request, &work)?;
    let recipe = match &targets.recipe {
        Some(path) => Some(recipe_of_faces(&request, &made.faces, mesh, path)?),
        None => None,
    };
    let provenance = provenance(&run, &request);
    made.broken.scene.metadata = provenance.metadata();
    let shot = request.file.picture.options();
    let outputs = targets.write(
        (&made.broken.scene, request.file.unit),
        |context| made.picture(&shot, context),
        recipe,
        &inputs,
        &write,
    )?;
    let stages = progress.finish();
    if options.reporting.prints_report() {
        let full = FullReport {
            report: &made.broken.report,
            simulated: &made.faces.reports,
            outputs: &written(&outputs),
            provenance: &provenance,
            stages: &stages,
        };
        print(&format_report(&full, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What a frame of a run left of the mesh.
pub struct Drawn {
    /// The pieces: moved apart, or where the frame has them if the wood holds.
    pub broken: Broken,
    /// The faces.
    pub faces: SimulatedFaces,
    /// The frame as a film shows it, if the wood holds.
    held: Option<Scene>,
}

/// How many diameters of the stem a picture of wood that holds shows about the break.
const HELD_CLOSE_UP: f64 = 8.0;

impl Drawn {
    /// Takes a picture of the pieces.
    pub fn picture(
        &self,
        shot: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        let Some(frame) = &self.held else {
            return picture_of_break(&self.broken, shot, context);
        };
        let mut shot = shot.clone();
        if shot.zoom.is_none() {
            shot.close_up.get_or_insert(HELD_CLOSE_UP);
        }
        picture_of_moved_break(frame, &self.broken.woods, &shot, context)
    }
}

/// Cuts the mesh of a run along the faces that a frame of it decided. Wood that holds stays together at what is whole, as it is in
/// that frame, unless its pieces are to be moved apart or to hang.
pub fn draw(
    run: &mut Run,
    number: usize,
    options: &BreakOptions,
    request: &ResolvedRequest,
    context: &Context,
) -> Result<Drawn, DrawError> {
    let [deciding, cutting] =
        context.split([(Stage::new("faces"), 1.0), (Stage::new("break"), 3.0)]);
    let common = &request.file.common;
    let hang = common.recipe.face.hang;
    let is_opened = common.separation > 0.0 || hang > 0.0;
    let partly = match is_opened {
        true => PartlyBroken::Separated,
        false => PartlyBroken::Hinged,
    };
    let mut faces = simulated_faces(run, number, partly, &deciding)?;
    faces.request.texture_width = request.file.texture_width;
    for one in &mut faces.request.breaks {
        (one.separation, one.part_clear) = (common.separation, common.part_clear);
        one.fray = common.fray;
        one.recipe.face.hang = hang;
        for setting in &options.set {
            apply_setting(one, setting)
                .map_err(|e| DrawError::Other(Failure::request(format!("--set: {e}"))))?;
        }
    }
    if !is_opened && faces.reports.iter().all(|face| !face.parted) {
        return held(run, number, faces, &cutting);
    }
    let broken = faces
        .broken(&cutting)
        .map_err(|error| DrawError::Other(error.into()))?;
    Ok(Drawn {
        broken,
        faces,
        held: None,
    })
}

/// Cuts the mesh along faces that do not part it, and bends it as in frame `number`.
fn held(
    run: &mut Run,
    number: usize,
    mut faces: SimulatedFaces,
    context: &Context,
) -> Result<Drawn, DrawError> {
    let options = FilmOptions {
        bodies: false,
        ..FilmOptions::default()
    };
    let mut film = faces.film(run, number..number + 1, &options, context)?;
    let failed = |error: FilmError| SimulatedFacesError::Run(error.into());
    let frame = film.skinned.at(0).map_err(failed)?;
    let nodes = film.skinned.on_its_base(0, &run.film_from_stem());
    let mut broken = film.broken;
    place(&mut broken, nodes.map_err(failed)?);
    broken.note(format!(
        "the wood holds: it is bent as it is at {:.3} s, about what is whole; --part moves the pieces apart",
        faces.observed.time
    ));
    Ok(Drawn {
        broken,
        faces,
        held: Some(frame),
    })
}

/// Puts the nodes of a broken scene where nodes of the same names are.
fn place(broken: &mut Broken, nodes: Vec<Node>) {
    let mut moved: BTreeMap<String, VecDeque<Node>> = BTreeMap::new();
    for node in nodes {
        moved.entry(node.name.clone()).or_default().push_back(node);
    }
    for node in &mut broken.scene.nodes {
        if let Some(moved) = moved.get_mut(&node.name).and_then(VecDeque::pop_front) {
            (node.mesh, node.transform) = (moved.mesh, moved.transform);
        }
    }
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
