//! The inside of a stem as files a scientist can use (Forests 2023): sections, a volume, particles, the surface
//! reconstructed from them, and their numbers.

mod cores;
mod elements;
mod outputs;
mod pictures;
mod springs;
mod stems;
mod volume;

pub use greenstick_wood::anatomy::{AnatomyOutput, AnatomyRequest, StemOutcome};
pub use stems::stems_files;

use crate::Error;
use crate::anatomy::outputs::Outputs;
use crate::scanning::{ScanParameters, ScannedReport, cleaned_table};
use glam::DVec3;
use greenstick_formats::{Encoded, LengthUnit, TableFormat};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::{Context, Mesh, PointCloud, Provenance, Scene, Stage};
use greenstick_schema::{FILE_NAME, Parameters, choice, parameters, text};
use greenstick_wood::anatomy::{
    Anatomy, AnatomyFindings, AnatomyReport, CoordinateChoice, ElementsReport, LimbReport,
    MappingComparison, MassReport, ParticleLayers, SegmentReport, StemMeasures, SurfaceColouring,
    WoodMass, limb_table,
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

/// What the inside is made of: a scene, and what is known of its making.
#[derive(Debug, Clone)]
pub struct AnatomyInput<'a> {
    /// The meshes.
    pub scene: &'a Scene,
    /// The report of the scan that the scene was reconstructed from, where it was.
    pub scan: Option<&'a ScannedReport>,
    /// The points of that scan that were left after cleaning.
    pub cleaned: Option<&'a PointCloud>,
    /// Where it comes from, which every file carries.
    pub provenance: Provenance,
}

impl<'a> From<&'a Scene> for AnatomyInput<'a> {
    /// Meshes that were not made from a scan.
    fn from(scene: &'a Scene) -> Self {
        AnatomyInput {
            scene,
            scan: None,
            cleaned: None,
            provenance: AnatomyFile::default().provenance(None),
        }
    }
}

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
    input: &AnatomyInput,
    request: &AnatomyRequest,
    context: &Context,
) -> Result<AnatomyFiles, Error> {
    let mut files = Vec::new();
    let report = anatomy(input, request, context, |file| -> Result<(), Error> {
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
    input: &AnatomyInput,
    request: &AnatomyRequest,
    context: &Context,
    mut sink: impl FnMut(Encoded) -> Result<(), E>,
) -> Result<AnatomyReport, E> {
    let stages = Stages::new(request, context);
    request.check().map_err(Error::from)?;
    let offset = match request.coordinates {
        CoordinateChoice::Local => DVec3::ZERO,
        CoordinateChoice::Input => DVec3::from(input.provenance.origin_m),
    };
    let mut outputs = Outputs::new(&mut sink, input.provenance.metadata(), offset);
    stages.finding.report(0.0).map_err(Error::from)?;
    let meshes = input.scene.world_meshes();
    let found = find_stem(&meshes, &request.location, &request.stem, &stages.finding)
        .map_err(Error::from)?;
    let mesh = &meshes[found.node];
    let anatomy = model(request, &found, mesh, &stages.dividing)?;
    let mut notes = input.scene.notes.clone();
    // Where a break may be does not matter here.
    let about_breaks = |note: &&String| note.starts_with("the break");
    notes.extend(found.notes.iter().filter(|n| !about_breaks(n)).cloned());

    let made = make_files(&anatomy, input, request, &stages, &mut outputs)?;
    notes.extend(made.notes);
    stages.reporting.report(0.0).map_err(Error::from)?;
    // A scan's surface is that of one stem.
    let left_out = match input.scan {
        Some(_) => None,
        None => find_left_out(mesh, &found, &stages.reporting).map_err(Error::from)?,
    };
    if let (Some(left_out), true) = (&left_out, request.wants(AnatomyOutput::Measures)) {
        let limbs: Vec<LimbReport> = left_out.limbs.iter().map(LimbReport::from).collect();
        outputs.table(limb_table(&limbs), "limbs", TableFormat::Csv)?;
    }
    let findings = AnatomyFindings {
        left_out,
        species: request.species.clone(),
        ring_method: request.ring_method(),
        mesh,
        found: &found,
        anatomy: &anatomy,
        layers: &made.layers,
        measures: made.measures.report(),
        mass: mass(&made.measures, request)?,
        elements: made.elements,
        provenance: input.provenance.clone(),
        segments: made.segments,
        notes,
    };
    outputs.finish()?;
    let mut report = findings.report();
    report.translate(offset);
    Ok(report)
}

/// What the files were made from, and what is to be said of them.
struct Made {
    layers: ParticleLayers,
    segments: Vec<SegmentReport>,
    measures: StemMeasures,
    elements: Option<ElementsReport>,
    notes: Vec<String>,
}

/// Makes the files that are wanted of a stem's sections and rings.
fn make_files<E: From<Error>>(
    anatomy: &Anatomy,
    input: &AnatomyInput,
    request: &AnatomyRequest,
    stages: &Stages,
    outputs: &mut Outputs<E>,
) -> Result<Made, E> {
    let mut notes = Vec::new();
    let layers = ParticleLayers::sample(anatomy, &request.layer_options(), &stages.sampling)
        .map_err(Error::from)?;
    if request.wants(AnatomyOutput::Particles) {
        write_particles(&layers, &stages.encoding, outputs)?;
    }
    if request.wants(AnatomyOutput::Surface) {
        stages.surface.report(0.0).map_err(Error::from)?;
        let ring = request.surface_ring.unwrap_or(anatomy.ring_count());
        notes.extend(write_surfaces(&layers, ring, outputs)?);
    }
    if request.wants(AnatomyOutput::Springs) {
        springs::write(&layers, &stages.joining, outputs)?;
    }
    if request.wants(AnatomyOutput::Mapping) {
        let compared = MappingComparison::new(anatomy, &layers, &stages.mapping);
        let compared = compared.map_err(Error::from)?;
        outputs.table(compared.table(), "mapping", TableFormat::Csv)?;
        notes.push(compared.to_string());
    }
    if let (Some(cloud), true) = (input.cleaned, request.wants(AnatomyOutput::Cleaned)) {
        outputs.table(cleaned_table(cloud), "cleaned", TableFormat::Ply)?;
    }
    let mut segments = Vec::new();
    if request.wants(AnatomyOutput::Volume) {
        segments = volume::write(anatomy, &stages.volume, outputs)?;
    }
    if request.wants(AnatomyOutput::Sections) {
        pictures::sections(anatomy, request, &stages.sections, outputs)?;
    }
    if request.wants(AnatomyOutput::Longitudinal) {
        pictures::longitudinal(anatomy, &stages.longitudinal, outputs)?;
    }
    let measures = request
        .measures(anatomy, input.scan, &stages.measuring)
        .map_err(Error::from)?;
    if request.wants(AnatomyOutput::Measures) {
        outputs.table(measures.table(), "sections", TableFormat::Csv)?;
    }
    if request.wants(AnatomyOutput::Cores) {
        notes.extend(cores::write(anatomy, request, &input.provenance, outputs)?);
    }
    let mut elements = None;
    if request.wants(AnatomyOutput::Elements) {
        let written = elements::write(anatomy, &measures, request, &stages.meshing, outputs)?;
        notes.extend(written.notes);
        elements = written.report;
    }
    Ok(Made {
        layers,
        segments,
        measures,
        elements,
        notes,
    })
}

/// Returns a report as the file `anatomy.json`.
///
/// # Errors
/// [`Error::Report`] where it cannot be converted to JSON.
pub fn report_file(report: &AnatomyReport) -> Result<Encoded, Error> {
    let bytes = report.to_json().map_err(|e| Error::Report(e.to_string()))?;
    Ok(Encoded::new(ANATOMY_FILE, bytes))
}

/// The parts of the work.
struct Stages {
    finding: Context,
    dividing: Context,
    sampling: Context,
    encoding: Context,
    surface: Context,
    joining: Context,
    mapping: Context,
    volume: Context,
    sections: Context,
    longitudinal: Context,
    measuring: Context,
    meshing: Context,
    reporting: Context,
}

impl Stages {
    /// Divides the work among its parts; those that are not wanted take none of it.
    fn new(request: &AnatomyRequest, context: &Context) -> Self {
        let output = |output, name, weight| {
            let weight = if request.wants(output) { weight } else { 0.0 };
            (Stage::new(name), weight)
        };
        let [
            finding,
            dividing,
            sampling,
            encoding,
            surface,
            joining,
            mapping,
            volume,
            sections,
            longitudinal,
            measuring,
            meshing,
            reporting,
        ] = context.split([
            (Stage::new("stem"), 1.0),
            (Stage::new("rings"), 1.0),
            (Stage::new("particles"), 2.0),
            output(AnatomyOutput::Particles, "encode", 1.0),
            output(AnatomyOutput::Surface, "surface", 1.0),
            output(AnatomyOutput::Springs, "springs", 2.0),
            output(AnatomyOutput::Mapping, "mapping", 0.2),
            output(AnatomyOutput::Volume, "volume", 4.0),
            output(AnatomyOutput::Sections, "sections", 4.0),
            output(AnatomyOutput::Longitudinal, "longitudinal", 1.0),
            (Stage::new("measures"), 1.0),
            output(AnatomyOutput::Elements, "elements", 1.0),
            (Stage::new("report"), 0.2),
        ]);
        Stages {
            finding,
            dividing,
            sampling,
            encoding,
            surface,
            joining,
            mapping,
            volume,
            sections,
            longitudinal,
            measuring,
            meshing,
            reporting,
        }
    }
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

/// What the wood of the stem weighs; `None` where no species was named or the tables have no density.
fn mass(measures: &StemMeasures, request: &AnatomyRequest) -> Result<Option<MassReport>, Error> {
    let Some(name) = &request.species else {
        return Ok(None);
    };
    let wood = WoodMass::new(Species::find(name)?, request.mensuration.moisture)?;
    Ok(wood.map(|wood| measures.mass(&wood)))
}

fn write_particles<E: From<Error>>(
    layers: &ParticleLayers,
    context: &Context,
    outputs: &mut Outputs<E>,
) -> Result<(), E> {
    let table = layers.table();
    for (i, &format) in TableFormat::ALL.iter().enumerate() {
        let done = i as f64 / TableFormat::ALL.len() as f64;
        context.report(done).map_err(Error::from)?;
        outputs.table(table.clone(), "particles", format)?;
    }
    Ok(())
}

/// The surface over a ring's particles in two colourings; a note where there is none.
fn write_surfaces<E: From<Error>>(
    layers: &ParticleLayers,
    ring: u16,
    outputs: &mut Outputs<E>,
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
        outputs.scene(scene, name)?;
    }
    Ok(None)
}
