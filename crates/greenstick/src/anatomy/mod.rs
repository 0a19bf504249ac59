//! The inside of a stem as files a scientist can use (Forests 2023): sections, a volume, particles, the surface
//! reconstructed from them, and their numbers.

mod pictures;
mod springs;
mod volume;

pub use greenstick_wood::anatomy::{AnatomyOutput, AnatomyRequest};

use crate::Error;
use crate::scanning::ScanParameters;
use greenstick_formats::{Encoded, Format, LengthUnit, TableFormat};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::{Context, Mesh, Scene, Stage};
use greenstick_schema::{FILE_NAME, Parameters, choice, parameters, text};
use greenstick_wood::anatomy::{
    Anatomy, AnatomyFindings, AnatomyReport, ParticleLayers, SurfaceColouring,
};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{FoundStem, find_left_out, find_stem};

parameters! {
    /// Everything that decides what is made of a stem's inside.
    pub struct AnatomyFile {
        "Input", "input" {
            /// The mesh or point cloud; without it, the branch that comes with the program.
            input: Option<String> = None, text(FILE_NAME).auto();
            /// Unit of length in the input, where its format has none.
            unit: Option<LengthUnit> = None, choice(LengthUnit::CHOICES).auto();
        }
    }
    include {
        /// What is wanted.
        request: AnatomyRequest = AnatomyRequest::default();
        /// How a point cloud becomes the bark of a stem.
        scan: ScanParameters = ScanParameters::default();
    }
}

/// Name of the file of numbers.
pub const ANATOMY_FILE: &str = "anatomy.json";
/// Ring coordinate at which bark begins in pictures.
const BARK: f64 = 0.95;

/// The inside of a stem, all files at once.
#[derive(Debug, Clone)]
pub struct AnatomyFiles {
    /// The numbers.
    pub report: AnatomyReport,
    /// All files, `anatomy.json` last.
    pub files: Vec<Encoded>,
}

/// Makes the inside of the stem at a location, with all files in memory.
///
/// # Errors
/// [`Error`] where there is no stem at the location, a number is out of range, or the caller cancelled.
pub fn anatomy_files(
    scene: &Scene,
    request: &AnatomyRequest,
    context: &Context,
) -> Result<AnatomyFiles, Error> {
    let mut files = Vec::new();
    let report = anatomy(scene, request, context, |file| -> Result<(), Error> {
        files.push(file);
        Ok(())
    })?;
    files.push(report_file(&report)?);
    Ok(AnatomyFiles { report, files })
}

/// Makes the inside of the stem at a location. Each file is handed to `sink` as soon as it is ready, and none is held; the
/// last, [`report_file`], is left to the caller, who may have something to add.
///
/// # Errors
/// Those of `sink`, and [`Error`] where there is no stem at the location, a number is out of range, or the caller
/// cancelled.
pub fn anatomy<E: From<Error>>(
    scene: &Scene,
    request: &AnatomyRequest,
    context: &Context,
    mut sink: impl FnMut(Encoded) -> Result<(), E>,
) -> Result<AnatomyReport, E> {
    let [
        finding,
        dividing,
        sampling,
        encoding,
        surface,
        joining,
        volume,
        sections,
        longitudinal,
        reporting,
    ] = stages(request, context);
    request.check().map_err(Error::from)?;
    finding.report(0.0).map_err(Error::from)?;
    let meshes = scene.world_meshes();
    let found =
        find_stem(&meshes, &request.location, &request.stem, &finding).map_err(Error::from)?;
    let mesh = &meshes[found.node];
    let anatomy = model(request, &found, mesh, &dividing)?;
    let mut notes = scene.notes.clone();
    // Where a break may be does not matter here.
    let about_breaks = |note: &&String| note.starts_with("the break");
    notes.extend(found.notes.iter().filter(|n| !about_breaks(n)).cloned());

    let layers = ParticleLayers::sample(&anatomy, &request.layer_options(), &sampling)
        .map_err(Error::from)?;
    if request.wants(AnatomyOutput::Particles) {
        write_particles(&layers, &encoding, &mut sink)?;
    }
    if request.wants(AnatomyOutput::Surface) {
        surface.report(0.0).map_err(Error::from)?;
        let ring = request.surface_ring.unwrap_or(anatomy.ring_count());
        notes.extend(write_surfaces(&layers, ring, &mut sink)?);
    }
    if request.wants(AnatomyOutput::Springs) {
        springs::write(&layers, &joining, &mut sink)?;
    }
    let mut segments = Vec::new();
    if request.wants(AnatomyOutput::Volume) {
        segments = volume::write(&anatomy, &volume, &mut sink)?;
    }
    if request.wants(AnatomyOutput::Sections) {
        pictures::sections(&anatomy, request, &sections, &mut sink)?;
    }
    if request.wants(AnatomyOutput::Longitudinal) {
        sink(pictures::longitudinal(&anatomy, &longitudinal)?)?;
    }
    reporting.report(0.0).map_err(Error::from)?;
    let left_out = find_left_out(mesh, &found, &reporting).map_err(Error::from)?;
    let findings = AnatomyFindings {
        left_out,
        species: request.species.clone(),
        ring_method: request.ring_method(),
        mesh,
        found: &found,
        anatomy: &anatomy,
        layers: &layers,
        segments,
        notes,
    };
    Ok(findings.report())
}

/// Returns a report as the file `anatomy.json`.
///
/// # Errors
/// [`Error::Report`] where it cannot be converted to JSON.
pub fn report_file(report: &AnatomyReport) -> Result<Encoded, Error> {
    let bytes = report.to_json().map_err(|e| Error::Report(e.to_string()))?;
    Ok(Encoded::new(ANATOMY_FILE, bytes))
}

/// Returns the contexts of the stages, in their order: stem, rings, particles, encode, surface, springs, volume, sections,
/// longitudinal, report.
fn stages(request: &AnatomyRequest, context: &Context) -> [Context; 10] {
    let output = |output, name, weight| {
        let weight = if request.wants(output) { weight } else { 0.0 };
        (Stage::new(name), weight)
    };
    context.split([
        (Stage::new("stem"), 1.0),
        (Stage::new("rings"), 1.0),
        (Stage::new("particles"), 2.0),
        output(AnatomyOutput::Particles, "encode", 1.0),
        output(AnatomyOutput::Surface, "surface", 1.0),
        output(AnatomyOutput::Springs, "springs", 2.0),
        output(AnatomyOutput::Volume, "volume", 4.0),
        output(AnatomyOutput::Sections, "sections", 4.0),
        output(AnatomyOutput::Longitudinal, "longitudinal", 1.0),
        (Stage::new("report"), 0.2),
    ])
}

/// The stem's sections and rings.
fn model<'a>(
    request: &AnatomyRequest,
    found: &'a FoundStem,
    mesh: &Mesh,
    context: &Context,
) -> Result<Anatomy<'a>, Error> {
    let species = request.species.as_deref().map(Species::find).transpose()?;
    let parameters = BreakParameters::default();
    let proportions = parameters.proportions();
    let seed = parameters.seed;
    let wood = WoodAppearance::of_stem(&found.stem, &proportions, seed, species, BARK);
    Ok(request.anatomy(found, mesh, wood, proportions, context)?)
}

fn write_particles<E: From<Error>>(
    layers: &ParticleLayers,
    context: &Context,
    sink: &mut dyn FnMut(Encoded) -> Result<(), E>,
) -> Result<(), E> {
    let table = layers.table();
    for (i, &format) in TableFormat::ALL.iter().enumerate() {
        let done = i as f64 / TableFormat::ALL.len() as f64;
        context.report(done).map_err(Error::from)?;
        let name = format!("particles.{}", format.extension());
        let file = greenstick_formats::write_table(format, &table, &name);
        sink(file.map_err(Error::from)?)?;
    }
    Ok(())
}

/// The surface over a ring's particles in two colourings; a note where there is none.
fn write_surfaces<E: From<Error>>(
    layers: &ParticleLayers,
    ring: u16,
    sink: &mut dyn FnMut(Encoded) -> Result<(), E>,
) -> Result<Option<String>, E> {
    for (colouring, name) in [
        (SurfaceColouring::Ring, "surface_rings.glb"),
        (SurfaceColouring::Sector, "surface_sectors.glb"),
    ] {
        let Some(scene) = layers.surface_scene(ring, colouring) else {
            return Ok(Some(
                "no surface was rebuilt: that takes a round stem, two layers, and a ring of three sectors that is whole in each"
                    .to_owned(),
            ));
        };
        let files = greenstick_formats::write(Format::Glb, &scene, name, LengthUnit::Metre);
        files
            .map_err(Error::from)?
            .into_iter()
            .try_for_each(&mut *sink)?;
    }
    Ok(None)
}
