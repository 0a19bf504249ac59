//! What is wanted of a stem's inside.

use crate::Error;
use greenstick_wood::anatomy::{
    LayerOptions, MAX_PARTICLES, RingColouring, RingMethod, SectorDivision,
};
use greenstick_wood::stem::{StemLocation, StemOptions};

/// A kind of output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnatomyOutput {
    /// Pictures of sections: contour, rings and tissues.
    Sections,
    /// A picture along the pith.
    Longitudinal,
    /// Voxels with ring, tissue and colour.
    Volume,
    /// Particles as PLY, VTK, CSV and Parquet.
    Particles,
    /// The surface reconstructed from particles, coloured by ring and by sector.
    Surface,
}

impl AnatomyOutput {
    /// All of them.
    pub const ALL: [AnatomyOutput; 5] = [
        AnatomyOutput::Sections,
        AnatomyOutput::Longitudinal,
        AnatomyOutput::Volume,
        AnatomyOutput::Particles,
        AnatomyOutput::Surface,
    ];
}

/// What is wanted of a stem's inside.
#[derive(Debug, Clone, PartialEq)]
pub struct AnatomyRequest {
    /// Which stem or limb, and where the first pictured section lies.
    pub location: StemLocation,
    /// What is known of the stem.
    pub stem: StemOptions,
    /// Species, by common or scientific name.
    pub species: Option<String>,
    /// Voxels along each side of a segment, 32 to 512.
    pub resolution: usize,
    /// Where rings come from.
    pub ring_method: RingMethod,
    /// Number of rings; by the usual width where absent. Erosion makes its own.
    pub ring_count: Option<u16>,
    /// Sectors of every ring, or of the outermost.
    pub sectors: u32,
    /// Layers of particles along the stem; as far apart as the outermost sectors are wide where absent.
    pub layers: Option<u32>,
    /// How rings are divided into sectors.
    pub division: SectorDivision,
    /// Sections that are pictured.
    pub sections: u32,
    /// Ring whose surface is reconstructed, from 1 at the pith; the outermost where absent.
    pub surface_ring: Option<u16>,
    /// Colours of rings.
    pub colouring: RingColouring,
    /// What is made. The numbers (`anatomy.json`) always are.
    pub outputs: Vec<AnatomyOutput>,
}

impl Default for AnatomyRequest {
    fn default() -> Self {
        let layers = LayerOptions::default();
        AnatomyRequest {
            location: StemLocation::Fraction(0.5),
            stem: StemOptions::default(),
            species: None,
            resolution: 128,
            ring_method: RingMethod::Field,
            ring_count: None,
            sectors: layers.sectors,
            layers: layers.layers,
            division: layers.division,
            sections: 3,
            surface_ring: None,
            colouring: RingColouring::Wood,
            outputs: AnatomyOutput::ALL.to_vec(),
        }
    }
}

impl AnatomyRequest {
    /// Whether an output is wanted.
    pub(super) fn wants(&self, output: AnatomyOutput) -> bool {
        self.outputs.contains(&output)
    }

    /// How the stem is divided into particles.
    pub(super) fn layer_options(&self) -> LayerOptions {
        LayerOptions {
            sectors: self.sectors,
            layers: self.layers,
            division: self.division,
        }
    }

    /// Refuses numbers that are out of range.
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.ring_method != RingMethod::Field && self.ring_count.is_some() {
            return Err(Error::Amount(
                "a number of rings for an erosion, whose schedule makes their number; expected only one of the two"
                    .into(),
            ));
        }
        check_amount("sectors", self.sectors, 3, 10_000)?;
        check_amount("layers", self.layers.unwrap_or(2), 2, 1_000_000)?;
        check_amount("sections", self.sections, 1, 1000)
    }

    /// Refuses a number of rings that is out of range or does not suit the other numbers.
    pub(super) fn check_rings(&self, rings: u16) -> Result<(), Error> {
        check_amount("rings", rings, 1, 1000)?;
        let surface_ring = self.surface_ring.unwrap_or(rings);
        check_amount("is the ring of the surface", surface_ring, 1, rings.into())?;
        let layers = u64::from(self.layers.unwrap_or(2));
        let particles = layers * u64::from(rings) * u64::from(self.sectors);
        check_amount("particles", particles, 1, MAX_PARTICLES)
    }
}

fn check_amount(what: &str, found: impl Into<u64>, least: u64, most: u64) -> Result<(), Error> {
    let found = found.into();
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(Error::Amount(format!(
        "{found} {what}; expected {least} to {most}"
    )))
}
