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
use greenstick::simulate::{MemoryRun, SceneMeshes, SimulateError, SimulateRequest, simulate};
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
        let is_skinned = shown || target.is_some();
        let [work, showing] = context.split([
            (Stage::new("simulate"), 10.0),
            (Stage::new("skin"), f64::from(u8::from(is_skinned))),
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
        if is_skinned {
            let of = (sweep, target, shown);
            (made.cell, made.pieces) = last_frame(run, &meshes, of, &showing)?;
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
        match target {
            Some(target) => files::carry_images(&mut scene, &path, target),
            None => files::embed_images(&mut scene, &path),
        }
        self.input = Some((path, scene.clone()));
        Ok(Some(scene))
    }
}

/// The last frame of a run: a small picture as PNG, where it is `shown` and one can be taken, and its files, where there is a target.
fn last_frame(
    run: MemoryRun,
    meshes: &SceneMeshes,
    (sweep, target, shown): (&Sweep, Option<&Path>, bool),
    context: &Context,
) -> Result<(Option<Vec<u8>>, Vec<Output>), Trouble> {
    let [skinning, drawing] = context.split([
        (Stage::new("skin"), 1.0),
        (Stage::new("picture"), f64::from(u8::from(shown))),
    ]);
    let mut run = open_run(Arc::new(run), meshes, &skinning).map_err(ShowError::from)?;
    let textures = match target {
        Some(_) if sweep.settings.textures => FilmParameters::default().texture_size,
        _ => 0,
    };
    let how = ShownAs::best(run.scene.seed, textures);
    let last = run.frames().saturating_sub(1);
    let mut still = RunStill::new(&mut run, last, &how, &skinning)?;
    let mut cell = None;
    if shown {
        let mut options = PictureParameters::default().options();
        [options.width, options.height] = CELL;
        options.samples = CELL_SAMPLES;
        let picture = still.picture(&run, &options, &drawing);
        drawing.check()?;
        cell = picture.ok().map(|picture| picture.png());
    }
    let Some(target) = target else {
        return Ok((cell, Vec::new()));
    };
    still.scene().metadata = provenance("skin", None, &run.scene).metadata();
    let files = files::encode(still.scene(), target, LengthUnit::Metre)?;
    Ok((cell, files))
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
