//! What is wanted of a stem's inside.

use super::error::AnatomyError;
use super::layers::LayerOptions;
use super::limits::{MAX_PARTICLES, RESOLUTION_RANGE};
use super::mensuration::{MeasurementErrors, MensurationParameters, StemMeasures};
use super::model::{Anatomy, AnatomyOptions, RingMethod};
use super::palette::RingColouring;
use super::parameters::RingParameters;
use super::sectors::SectorDivision;
use super::stem_rings::ring_division;
use crate::appearance::WoodAppearance;
use crate::rings::{RingDivision, RingSeriesParameters};
use crate::scan::ScannedReport;
use crate::species::SPECIES_NAME;
use crate::stem::{FoundStem, LOCATION, StemLocation, StemOptions};
use crate::tissue::Proportions;
use greenstick_geometry::{Cancelled, Context, Mesh};
use greenstick_schema::{Kind, Unit, choice, choices, count, list, number, parameters, text};

choices! {
    /// Which coordinates are written.
    pub enum CoordinateChoice {
        /// Those of the work, in which a scan far from the origin is near it.
        Local = "local",
        /// Those of the input.
        Input = "input",
    }
    /// A kind of output.
    pub enum AnatomyOutput {
        /// Pictures of sections: contour, rings and tissues.
        Sections = "sections",
        /// A picture along the pith.
        Longitudinal = "longitudinal",
        /// Voxels with ring, tissue and colour.
        Volume = "volume",
        /// Particles as PLY, VTK, CSV and Parquet.
        Particles = "particles",
        /// The surface reconstructed from particles, coloured by ring and by sector.
        Surface = "surface",
        /// Diameters, shape and volumes along the stem as a table.
        Measures = "measures",
        /// Ring widths along radii.
        Cores = "cores",
        /// Finite elements with the axes of the wood.
        Elements = "elements",
        /// The springs between neighbouring particles as VTK lines, CSV and Parquet.
        Springs = "springs",
        /// Addresses with their points by the continuous and by the published discrete mapping, as a table.
        Mapping = "mapping",
        /// The points of a scan that were left after cleaning, as PLY.
        Cleaned = "cleaned",
    }
}

impl AnatomyOutput {
    /// Number of kinds.
    const COUNT: usize = 11;
    /// Those that are made where none is chosen: all but the springs, of which there are three for each particle, and the
    /// comparison of mappings.
    pub const DEFAULT: [AnatomyOutput; 9] = [
        AnatomyOutput::Sections,
        AnatomyOutput::Longitudinal,
        AnatomyOutput::Volume,
        AnatomyOutput::Particles,
        AnatomyOutput::Surface,
        AnatomyOutput::Measures,
        AnatomyOutput::Cores,
        AnatomyOutput::Elements,
        AnatomyOutput::Cleaned,
    ];
}

/// A kind of output, in lists.
const OUTPUT: Kind = choice(AnatomyOutput::CHOICES).kind;

parameters! {
    /// What is wanted of a stem's inside.
    pub struct AnatomyRequest {
        "Input", "stem" {
            /// Which stem or limb, and where the first pictured section lies: a fraction of the stem's length from its base,
            /// a length, or a point in the world.
            location as "at": StemLocation = StemLocation::Fraction(0.5), text(LOCATION);
            /// Make only these. The numbers (anatomy.json) always are.
            outputs as "only": Vec<AnatomyOutput> = AnatomyOutput::DEFAULT.to_vec(), list(&OUTPUT, 1, AnatomyOutput::COUNT);
        }
        "Output", "report" {
            /// Coordinates of what is written: "local", less the origin in anatomy.json that was subtracted from a scan far
            /// from 0, or "input", those of the input.
            coordinates: CoordinateChoice = CoordinateChoice::Local, choice(CoordinateChoice::CHOICES);
        }
        "How finely", "rings" {
            /// Voxels along each side of a segment, which is slightly longer than the stem is wide.
            resolution: usize = 128, count(*RESOLUTION_RANGE.start() as i128, *RESOLUTION_RANGE.end() as i128);
            /// Annual rings of even width; "auto" makes as many as usual, of widths that differ from year to year. An erosion
            /// makes its own.
            ring_count as "rings": Option<u16> = None, count(1, 1000).auto();
            /// Sectors of every ring; with equal-area bundles, of the outermost.
            sectors: u32 = LayerOptions::default().sectors, count(3, 10_000);
            /// Layers of particles along the stem; "auto" sets them as far apart as the outermost sectors are wide.
            layers: Option<u32> = None, count(2, 1_000_000).auto();
            /// How rings are divided into sectors.
            division as "bundles": SectorDivision = LayerOptions::default().division, choice(SectorDivision::CHOICES);
            /// Smooth the outlines of sections by at most this root mean square distance; "auto" is a scan's error in its cells,
            /// and nothing for a mesh. Areas stay as they are.
            smoothing: Option<f64> = None, number(Unit::Metre, 0.0, 1.0).auto();
            /// Sections that are pictured: one at the place, the others at equal distances.
            sections: u32 = 3, count(1, 1000);
            /// Ring whose surface is reconstructed, from 1 at the pith; "auto" is the outermost.
            surface_ring: Option<u16> = None, count(1, 1000).auto();
        }
        "What it is", "rings" {
            /// Species, by common or scientific name.
            species: Option<String> = None, text(SPECIES_NAME).auto();
            /// Colours of rings.
            colouring as "colours": RingColouring = RingColouring::Wood, choice(RingColouring::CHOICES);
        }
    }
    include {
        /// What is known of the stem.
        stem: StemOptions = StemOptions::default();
        /// Rings that were measured.
        series: RingSeriesParameters = RingSeriesParameters::default();
        /// Where rings come from.
        ring_source: RingParameters = RingParameters::default();
        /// What is measured along the stem.
        mensuration: MensurationParameters = MensurationParameters::default();
    }
    check |p| {
        p.ring_source.check_alone(p.ring_count.map(|_| "rings"), &p.series)?;
        Ok(())
    };
}

impl AnatomyRequest {
    /// Where rings come from.
    pub fn ring_method(&self) -> RingMethod {
        self.ring_source.method()
    }

    /// Whether an output is wanted.
    pub fn wants(&self, output: AnatomyOutput) -> bool {
        self.outputs.contains(&output)
    }

    /// How the stem is divided into particles.
    pub fn layer_options(&self) -> LayerOptions {
        LayerOptions {
            sectors: self.sectors,
            layers: self.layers,
            division: self.division,
        }
    }

    /// Makes the sections and rings of a stem found in `mesh`, which is in world metres. `wood` gives the colours, what is
    /// between rings, and their number where none is requested.
    ///
    /// # Errors
    /// [`AnatomyError`] where no section can be made, or numbers are out of range.
    pub fn anatomy<'a>(
        &self,
        found: &'a FoundStem,
        mesh: &Mesh,
        wood: WoodAppearance,
        proportions: Proportions,
        context: &Context,
    ) -> Result<Anatomy<'a>, AnatomyError> {
        let division = ring_division(self.ring_count, &self.series, &wood);
        let known = match &division {
            RingDivision::Even(count) | RingDivision::Grown { count, .. } => Some(*count),
            RingDivision::Series(_) => None,
        };
        if let (RingMethod::Field, Some(count)) = (self.ring_method(), known) {
            self.check_rings(count)?;
        }
        context.report(0.0)?;
        let options = AnatomyOptions {
            resolution: self.resolution,
            rings: self.ring_method(),
            division,
            colouring: self.colouring,
            proportions,
            smoothing: self.smoothing,
        };
        let anatomy = Anatomy::new(found, mesh, &options, wood, context)?;
        self.check_rings(anatomy.ring_count())?;
        Ok(anatomy)
    }

    /// Measures the stem, with standard errors where it comes from a scan.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn measures(
        &self,
        anatomy: &Anatomy,
        scan: Option<&ScannedReport>,
        context: &Context,
    ) -> Result<StemMeasures, Cancelled> {
        let bark = scan.and_then(|scan| scan.bark.as_ref());
        let errors = bark.and_then(MeasurementErrors::from_scan);
        let pith_is_known = self.stem.pith.is_some();
        StemMeasures::new(anatomy, &self.mensuration, errors, pith_is_known, context)
    }

    /// Refuses a number of rings that is out of range or does not suit the other numbers.
    fn check_rings(&self, rings: u16) -> Result<(), AnatomyError> {
        check_amount("rings", rings, 1, 1000)?;
        let surface_ring = self.surface_ring.unwrap_or(rings);
        check_amount("is the ring of the surface", surface_ring, 1, rings.into())?;
        let layers = u64::from(self.layers.unwrap_or(2));
        let particles = layers * u64::from(rings) * u64::from(self.sectors);
        check_amount("particles", particles, 1, MAX_PARTICLES)
    }
}

fn check_amount(
    what: &'static str,
    found: impl Into<u64>,
    least: u64,
    most: u64,
) -> Result<(), AnatomyError> {
    let found = found.into();
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(AnatomyError::Amount {
        what,
        found,
        least,
        most,
    })
}
