//! The inside of a stem as files a scientist can use (forests-2023): sections, a volume, particles, the surface rebuilt
//! from them, and their numbers.

mod drawn;
mod paint;
mod particles;
mod report;
mod volume;

pub use crate::erosion::{Erosion, ErosionSchedule, InnerCircleError};
pub use drawn::RingsBy;
pub use report::{AnatomyReport, RingRows, SectionReport, SegmentReport};

use crate::Error;
use crate::erosion::Fronts;
use crate::session::appearance::looks;
use drawn::Look;
use greenstick_formats::{Encoded, Format, LengthUnit, TableFormat};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::{Context, Mesh, Node, Scene, Stage, Table};
use greenstick_wood::anatomy::{
    Anatomy, AnatomyOptions, Bundles, RingNumbers, Section, SurfaceColours,
};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Place, StemKind, StemOptions, find};
use greenstick_wood::tissue::Zone;

/// A kind of output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Pictures of sections: contour, rings and zones.
    Sections,
    /// A picture along the pith.
    Longitudinal,
    /// Voxels with ring, zone and colour.
    Volume,
    /// Particles as PLY, VTK, CSV and Parquet.
    Particles,
    /// The surface rebuilt from particles, coloured by ring and by sector.
    Surface,
}

impl Part {
    /// All of them.
    pub const ALL: [Part; 5] = [
        Part::Sections,
        Part::Longitudinal,
        Part::Volume,
        Part::Particles,
        Part::Surface,
    ];
}

/// Colours of rings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RingColours {
    /// Those of the species' wood, tissue by tissue.
    #[default]
    Wood,
    /// The two browns of forests-2023 §3.3.
    Published,
}

/// What is wanted of a stem's inside.
#[derive(Debug, Clone, PartialEq)]
pub struct AnatomyRequest {
    /// Which stem or limb, and where the first pictured section lies.
    pub place: Place,
    /// What is known of the stem.
    pub stem: StemOptions,
    /// Species, by common or scientific name.
    pub species: Option<String>,
    /// Voxels along each side of a segment, 32 to 512.
    pub resolution: usize,
    /// Where rings come from.
    pub rings_by: RingsBy,
    /// Number of rings; by the width that is usual where absent. Erosion makes its own.
    pub rings: Option<u16>,
    /// Sectors of every ring, or of the outermost.
    pub sectors: u32,
    /// Layers of particles along the stem; as far apart as the outermost sectors are wide where absent.
    pub layers: Option<u32>,
    /// How rings are parted into sectors.
    pub bundles: Bundles,
    /// Sections that are pictured.
    pub sections: u32,
    /// Ring whose surface is rebuilt, from 1 at the pith; the outermost where absent.
    pub surface_ring: Option<u16>,
    /// Colours of rings.
    pub colours: RingColours,
    /// What is made. The numbers (`anatomy.json`) always are.
    pub parts: Vec<Part>,
}

impl Default for AnatomyRequest {
    fn default() -> Self {
        AnatomyRequest {
            place: Place::Fraction(0.5),
            stem: StemOptions::default(),
            species: None,
            resolution: 128,
            rings_by: RingsBy::Field,
            rings: None,
            sectors: 40,
            layers: None,
            bundles: Bundles::Fixed,
            sections: 3,
            surface_ring: None,
            colours: RingColours::Wood,
            parts: Part::ALL.to_vec(),
        }
    }
}

/// The inside of a stem.
#[derive(Debug, Clone)]
pub struct Inside {
    /// The numbers.
    pub report: AnatomyReport,
    /// The particles.
    pub particles: Table,
    /// All files, `anatomy.json` last.
    pub files: Vec<Encoded>,
}

impl Inside {
    /// Adds a note to the numbers and to their file.
    ///
    /// # Errors
    /// [`Error::Report`] where the numbers cannot be put into JSON.
    pub fn note(&mut self, note: String) -> Result<(), Error> {
        self.report.notes.push(note);
        self.files.pop();
        self.files.push(numbers_file(&self.report)?);
        Ok(())
    }
}

fn numbers_file(report: &AnatomyReport) -> Result<Encoded, Error> {
    Ok(Encoded {
        name: "anatomy.json".to_owned(),
        bytes: serde_json::to_vec(report).map_err(|e| Error::Report(e.to_string()))?,
    })
}

/// More particles than this are a slip of the hand.
const MOST_PARTICLES: u64 = 50_000_000;
/// Layers where nobody says how many.
const USUAL_LAYERS: (f64, f64) = (16.0, 4096.0);
/// Ring coordinate at which bark begins in pictures.
const BARK: f64 = 0.95;

/// One stem with everything that its outputs share.
struct Work<'a> {
    anatomy: &'a Anatomy<'a>,
    request: &'a AnatomyRequest,
    look: Look,
    /// The erosion that rings come from, where they come from one.
    erosion: Option<Fronts>,
    /// Of rings by the field.
    numbers: RingNumbers,
    /// Colour of each pass, sRGB.
    palette: Vec<[u8; 3]>,
}

impl Work<'_> {
    fn is_board(&self) -> bool {
        self.anatomy.stem().kind == StemKind::Board
    }
}

/// Makes the inside of the stem at a place.
///
/// # Errors
/// [`Error`] where there is no stem at the place, a number asked for is out of range, or the caller cancelled.
pub fn anatomy(
    scene: &Scene,
    request: &AnatomyRequest,
    context: &Context,
) -> Result<Inside, Error> {
    let species = request.species.as_deref().map(Species::find).transpose()?;
    let part = |part, weight| {
        if request.parts.contains(&part) {
            weight
        } else {
            0.0
        }
    };
    let [
        stem,
        ring,
        particle,
        encode,
        surface,
        volume,
        sections,
        longitudinal,
        last,
    ] = context.split([
        (Stage::new("stem"), 1.0),
        (Stage::new("rings"), 1.0),
        (Stage::new("particles"), 2.0),
        (Stage::new("encode"), part(Part::Particles, 1.0)),
        (Stage::new("surface"), part(Part::Surface, 1.0)),
        (Stage::new("volume"), part(Part::Volume, 4.0)),
        (Stage::new("sections"), part(Part::Sections, 4.0)),
        (Stage::new("longitudinal"), part(Part::Longitudinal, 1.0)),
        (Stage::new("report"), 0.2),
    ]);
    stem.report(0.0)?;
    let meshes: Vec<Mesh> = scene.nodes.iter().map(in_world).collect();
    let found = find(&meshes, &request.place, &request.stem, &stem)?;
    let mesh = &meshes[found.node];
    let parameters = BreakParameters::default();
    let mut look = looks(&found.stem, &parameters, species, BARK).wood;
    let erosion = request.rings_by.fronts(request.resolution)?;
    if erosion.is_some() && request.rings.is_some() {
        return Err(Error::Amount(
            "a number of rings for an erosion, whose schedule makes their number; expected only one of the two".into(),
        ));
    }
    let rings = request.rings.unwrap_or(look.rings.round() as u16);
    check(request, rings)?;
    // Rings are those of the data: the look's own would lie elsewhere.
    look.rings = 0.0;
    let options = AnatomyOptions {
        resolution: request.resolution,
        rings,
    };
    let mut made = Anatomy::new(&found, mesh, &options)?;
    if let Some(fronts) = &erosion {
        ring.report(0.0)?;
        made.rings = drawn::count_rings(&made, fronts)?;
        check(request, made.rings)?;
    }
    let rings = made.rings;
    let tissue = parameters.proportions();
    let mut numbers = RingNumbers::alternating(2 * rings, &tissue);
    if found.stem.kind == StemKind::Board {
        // A board is sawn from the wood between pith and bark.
        numbers.zone.fill(Zone::Sapwood);
    }
    let look = Look {
        wood: look,
        tissue,
        colours: request.colours,
    };
    let palette = paint::palette(&look, &numbers);
    let work = Work {
        anatomy: &made,
        request,
        look,
        erosion,
        numbers,
        palette,
    };
    let wants = |part| request.parts.contains(&part);
    let mut files = Vec::new();
    let mut notes = scene.notes.clone();
    // What is said of where a break may be does not matter here.
    notes.extend(
        found
            .notes
            .iter()
            .filter(|n| !n.starts_with("the break"))
            .cloned(),
    );
    let layers = particles::layers(&work, &particle)?;
    let table = layers.table();
    if wants(Part::Particles) {
        for (i, format) in TableFormat::ALL.into_iter().enumerate() {
            encode.report(i as f64 / 4.0)?;
            let name = format!("particles.{}", format.ending());
            files.push(greenstick_formats::write_table(format, &table, &name)?);
        }
    }
    if wants(Part::Surface) {
        surface.report(0.0)?;
        let ring = request.surface_ring.unwrap_or(rings);
        for (colours, name) in [
            (SurfaceColours::Ring, "surface_rings.glb"),
            (SurfaceColours::Sector, "surface_sectors.glb"),
        ] {
            match layers.surface(&work, ring, colours) {
                Some(scene) => files.extend(greenstick_formats::write(
                    Format::Glb,
                    &scene,
                    name,
                    LengthUnit::Metre,
                )?),
                None if colours == SurfaceColours::Ring => notes.push(
                    "no surface was rebuilt: that takes a round stem, two layers, and a ring of three sectors that is whole in each"
                        .to_owned(),
                ),
                None => {}
            }
        }
    }
    let mut segments = Vec::new();
    if wants(Part::Volume) {
        let (made, reports) = volume::volume(&work, &volume)?;
        files.extend(made);
        segments = reports;
    }
    if wants(Part::Sections) {
        files.extend(paint::sections(&work, &sections)?);
    }
    if wants(Part::Longitudinal) {
        files.push(paint::longitudinal(&work, &longitudinal)?);
    }
    last.report(0.0)?;
    let report = report::report(&work, &layers, (mesh, &found), segments, notes);
    files.push(numbers_file(&report)?);
    Ok(Inside {
        report,
        particles: table,
        files,
    })
}

fn check(request: &AnatomyRequest, rings: u16) -> Result<(), Error> {
    let refuse = |what: &str, found: u64, low: u64, high: u64| {
        if (low..=high).contains(&found) {
            return Ok(());
        }
        Err(Error::Amount(format!(
            "{found} {what}; expected {low} to {high}"
        )))
    };
    refuse("rings", rings.into(), 1, 1000)?;
    refuse("sectors", request.sectors.into(), 3, 10_000)?;
    refuse("layers", request.layers.unwrap_or(2).into(), 2, 1_000_000)?;
    refuse("sections", request.sections.into(), 1, 1000)?;
    let ring = request.surface_ring.unwrap_or(rings);
    refuse("is the ring of the surface", ring.into(), 1, rings.into())?;
    let particles =
        u64::from(request.layers.unwrap_or(2)) * u64::from(rings) * u64::from(request.sectors);
    refuse("particles", particles, 1, MOST_PARTICLES)
}

/// A node's mesh in the world, without what rides along.
fn in_world(node: &Node) -> Mesh {
    Mesh {
        positions: node
            .mesh
            .positions
            .iter()
            .map(|&p| node.transform.transform_point3(p))
            .collect(),
        triangles: node.mesh.triangles.clone(),
        ..Mesh::default()
    }
}

/// The sections at `lengths` on as many threads as there are; those that miss the stem are left out.
fn sections_at(work: &Work, lengths: &[f64]) -> Vec<Section> {
    use rayon::prelude::*;
    lengths
        .par_iter()
        .filter_map(|&s| work.anatomy.section(s))
        .collect()
}
