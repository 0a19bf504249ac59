//! Variants that are simulated or bent.

use crate::figures::{BendFigures, RunFigures};
use crate::making::{CELL, CELL_SAMPLES, Trouble};
use crate::plan::Sweep;
use crate::shown::{RunStill, ShowError, ShownAs};
use crate::variant::BendFile;
use greenstick::bending::{BendRequest, BendingError, SpecimensRequest, bend, bend_specimens};
use greenstick::fibre::scene::Scene as Setting;
use greenstick::files::run::read_body_meshes;
use greenstick::files::{self, Output};
use greenstick::film::open_run;
use greenstick::formats::{LengthUnit, Reach};
use greenstick::geometry::{Context, Scene, Stage};
use greenstick::picture::PictureParameters;
use greenstick::provenance;
use greenstick::simulate::{
    MemoryRun, RunSource, SceneMeshes, SimulateError, SimulateRequest, UP, body_shapes, simulate,
};
use greenstick::skin::film::FilmParameters;
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl From<SimulateError> for Trouble {
    fn from(error: SimulateError) -> Self {
        match error {
            SimulateError::Cancelled(cancelled) => cancelled.into(),
            other => Trouble::Variant(other.to_string()),
        }
    }
}

impl From<ShowError> for Trouble {
    fn from(error: ShowError) -> Self {
        match error {
            ShowError::Cancelled(cancelled) => cancelled.into(),
            other => Trouble::Variant(other.to_string()),
        }
    }
}

impl From<BendingError> for Trouble {
    fn from(error: BendingError) -> Self {
        match error.kind() {
            greenstick::ErrorKind::Cancelled => greenstick::geometry::Cancelled.into(),
            _ => Trouble::Variant(error.to_string()),
        }
    }
}

/// What came of a simulation.
pub struct Simulated {
    /// Its figures.
    pub figures: RunFigures,
    /// What its last frame shows, where files are wanted.
    pub pieces: Vec<Output>,
    /// A small picture of its last frame as PNG, where one is wanted.
    pub cell: Option<Vec<u8>>,
}

/// Simulates scenes. It keeps the mesh that they are of.
#[derive(Debug, Default)]
pub struct Simulator {
    /// The mesh, and the file that it was read from.
    input: Option<(PathBuf, Scene)>,
}

impl Simulator {
    /// Simulates a scene of a sweep. The files of its last frame are those for `target`; a small picture is taken where it is
    /// `shown`.
    pub fn run(
        &mut self,
        sweep: &Sweep,
        scene: Setting,
        (target, shown): (Option<&Path>, bool),
        context: &Context,
    ) -> Result<Simulated, Trouble> {
        let [work, picture, pieces] = context.split([
            (Stage::new("simulate"), 10.0),
            (Stage::new("picture"), f64::from(u8::from(shown))),
            (Stage::new("skin"), f64::from(u8::from(target.is_some()))),
        ]);
        let beside = match &sweep.settings.scene {
            Some(name) => sweep.folder.join(name),
            None => sweep.folder.join("scene.toml"),
        };
        let beside = beside.parent().unwrap_or(&sweep.folder);
        let meshes = SceneMeshes {
            input: self.input(sweep, target)?,
            bodies: read_body_meshes(&scene, beside, Reach::Folder)?,
        };
        let request = SimulateRequest {
            scene,
            meshes,
            resume: false,
        };
        let mut run = MemoryRun::new();
        let report = simulate(&request, &mut run, &work)?;
        let meshes = request.meshes;
        let mut made = Simulated {
            figures: RunFigures::from(&report),
            pieces: Vec::new(),
            cell: None,
        };
        if shown {
            made.cell = cell(&run, &meshes, &picture)?;
        }
        if let Some(target) = target {
            made.pieces = still(run, &meshes, (sweep, target), &pieces)?;
        }
        Ok(made)
    }

    /// The mesh that is simulated, with its images where it goes to `target`.
    fn input(&mut self, sweep: &Sweep, target: Option<&Path>) -> Result<Option<Scene>, Trouble> {
        let Some(path) = sweep
            .settings
            .input
            .as_ref()
            .map(|name| sweep.folder.join(name))
        else {
            return Ok(None);
        };
        if let Some((last, scene)) = &self.input
            && *last == path
        {
            return Ok(Some(scene.clone()));
        }
        let mut scene = files::read(&path, sweep.settings.unit)?;
        if let Some(target) = target {
            files::carry_images(&mut scene, &path, target);
        }
        self.input = Some((path, scene.clone()));
        Ok(Some(scene))
    }
}

/// What the last frame of a run shows, as files.
fn still(
    run: MemoryRun,
    meshes: &SceneMeshes,
    (sweep, target): (&Sweep, &Path),
    context: &Context,
) -> Result<Vec<Output>, Trouble> {
    let mut run = open_run(Arc::new(run), meshes, context).map_err(ShowError::from)?;
    let parameters = FilmParameters {
        texture_size: match sweep.settings.textures {
            true => FilmParameters::default().texture_size,
            false => 0,
        },
        ..FilmParameters::default()
    };
    let how = ShownAs {
        faces: None,
        field: None,
        film: parameters.film_options(run.scene.seed),
    };
    let last = run.frames().saturating_sub(1);
    let mut still = RunStill::new(&mut run, last, &how, context)?;
    still.scene().metadata = provenance("skin", None, &run.scene).metadata();
    Ok(files::encode(still.scene(), target, LengthUnit::Metre)?)
}

/// A small picture of the last frame of a run as PNG; `None` where none can be taken.
fn cell(
    run: &MemoryRun,
    meshes: &SceneMeshes,
    context: &Context,
) -> Result<Option<Vec<u8>>, Trouble> {
    let failed = SimulateError::from;
    let scene = run.scene().map_err(failed)?;
    let last = run.frames().map_err(failed)?.count().saturating_sub(1);
    let frame = run.frame(last).map_err(failed)?;
    let mut options = PictureParameters::default().options();
    [options.width, options.height] = CELL;
    (options.samples, options.up) = (CELL_SAMPLES, UP);
    let rods = greenstick::rods_scene(&frame, &body_shapes(&scene, meshes)?);
    let picture = greenstick::picture_of_scene(&rods, &options, context);
    context.check()?;
    Ok(picture.ok().map(|picture| picture.png()))
}

/// The figures of a bending test.
pub fn bend_figures(file: &BendFile, context: &Context) -> Result<BendFigures, Trouble> {
    let (settings, species) = (&file.settings, file.species.clone());
    let (moisture, test) = (settings.moisture, settings.test());
    let Some(specimens) = settings.specimens else {
        let request = BendRequest {
            species,
            moisture,
            test,
        };
        return Ok(BendFigures::from(&bend(&request, context)?.report));
    };
    let request = SpecimensRequest {
        species,
        moisture,
        specimens,
        flaws: settings.flaws,
        test,
    };
    Ok(BendFigures::from(&bend_specimens(&request, context)?))
}
