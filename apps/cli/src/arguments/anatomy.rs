//! Options of `greenstick anatomy`.

use super::{Declared, RingSource, Telling, UnitWord};
use crate::values;
use clap::{Args, ValueEnum};
use greenstick::anatomy::{AnatomyOutput, RingColouring};
use greenstick::scanning::ScanParameters;
use greenstick::wood::anatomy::SectorDivision;
use greenstick::wood::stem::StemOptions;
use std::path::PathBuf;

const ANATOMY_EXAMPLES: &str = "\
What is written (--only takes a list of the first words; all by default)
  sections      section_LENGTH_contour.png, ..._rings.png and ..._zones.png
  longitudinal  longitudinal.png, the stem cut in half along its pith, laid straight
  volume        volume.vti, or volume.vtm with a volume_NNN.vti for each segment: ring, zone, colour of every voxel
  particles     particles.ply, .vtp, .csv and .parquet: place, ring, sector, layer, zone, colour, bundle area
  surface       surface_rings.glb and surface_sectors.glb, rebuilt from the particles
  and always    anatomy.json: centreline, pith, girth and rings of every layer

Examples
  greenstick anatomy -o inside
  greenstick anatomy pole.ply --unit mm -o inside --resolution 512 --rings 30
  greenstick anatomy pole.ply --unit mm -o inside --rings-by erosion --schedule eccentric --inner-circle 0.4
  greenstick anatomy pole.ply --unit mm -o inside --rings-by erosion --kernels 4*3/5,5x3+1+0/7
  greenstick anatomy tree.glb --at 0.3,2.1,-0.4 -o limb --only particles,surface --bundles equal-area";

#[derive(Debug, Args)]
#[command(after_help = ANATOMY_EXAMPLES)]
pub struct AnatomyOptions {
    /// Mesh of a stem (.glb, .gltf, .obj, .ply, .stl or .off) or point cloud (.ply, .xyz, .las or .laz); without it, a
    /// branch that comes with the program
    pub input: Option<PathBuf>,
    /// Folder for the files; made where it is not there
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Which stem, and where the first pictured section lies: a fraction, a length, or a point
    #[arg(
        long,
        value_name = "PLACE",
        default_value = "0.5",
        allow_hyphen_values = true
    )]
    pub at: String,
    /// Unit of length in the input, where its format has none
    #[arg(long)]
    pub unit: Option<UnitWord>,
    /// Make only these
    #[arg(long, value_name = "PARTS", value_delimiter = ',', default_values_t = PartWord::ALL, hide_default_value = true)]
    pub only: Vec<PartWord>,
    #[command(flatten)]
    pub scan: Declared<ScanParameters>,

    /// Voxels along each side of a segment, which is slightly longer than the stem is wide: 32 to 512
    #[arg(long, value_name = "NUMBER", default_value = "128", help_heading = "How finely",
        value_parser = values::resolution)]
    pub resolution: usize,
    /// Annual rings; as many as make rings of the usual width where absent. An erosion makes its own number
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=1000), help_heading = "How finely")]
    pub rings: Option<u16>,
    /// Sectors of every ring; with equal-area bundles, of the outermost
    #[arg(long, value_name = "NUMBER", default_value = "40", value_parser = clap::value_parser!(u32).range(3..=10_000),
        help_heading = "How finely")]
    pub sectors: u32,
    /// Layers of particles along the stem; as far apart as the outermost sectors are wide where absent
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(2..=1_000_000), help_heading = "How finely")]
    pub layers: Option<u32>,
    /// How rings are parted into sectors
    #[arg(long, default_value = "fixed", help_heading = "How finely")]
    pub bundles: BundlesWord,
    /// Sections that are pictured: one at the place, the others at equal distances
    #[arg(long, value_name = "NUMBER", default_value = "3", value_parser = clap::value_parser!(u32).range(1..=1000),
        help_heading = "How finely")]
    pub sections: u32,
    /// Ring whose surface is rebuilt, from 1 at the pith; the outermost where absent
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=1000), help_heading = "How finely")]
    pub surface_ring: Option<u16>,

    /// Species, by common or scientific name
    #[arg(long, value_name = "NAME", help_heading = "What it is")]
    pub species: Option<String>,
    #[command(flatten)]
    pub stem: Declared<StemOptions>,
    /// Colours of rings
    #[arg(
        long,
        alias = "colors",
        default_value = "wood",
        help_heading = "What it is"
    )]
    pub colours: ColoursWord,
    #[command(flatten)]
    pub source: RingSource,
    #[command(flatten)]
    pub telling: Telling,
}

/// Parts of a stem's inside.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum PartWord {
    Sections,
    Longitudinal,
    Volume,
    Particles,
    Surface,
}

impl PartWord {
    const ALL: [PartWord; 5] = [
        PartWord::Sections,
        PartWord::Longitudinal,
        PartWord::Volume,
        PartWord::Particles,
        PartWord::Surface,
    ];
}

impl std::fmt::Display for PartWord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |v| v.get_name()))
    }
}

impl From<PartWord> for AnatomyOutput {
    fn from(word: PartWord) -> Self {
        match word {
            PartWord::Sections => AnatomyOutput::Sections,
            PartWord::Longitudinal => AnatomyOutput::Longitudinal,
            PartWord::Volume => AnatomyOutput::Volume,
            PartWord::Particles => AnatomyOutput::Particles,
            PartWord::Surface => AnatomyOutput::Surface,
        }
    }
}

/// How rings are parted.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum BundlesWord {
    #[value(help = "the same number of sectors in every ring, as published")]
    Fixed,
    #[value(help = "as many sectors as make bundles of equal area")]
    EqualArea,
}

impl From<BundlesWord> for SectorDivision {
    fn from(word: BundlesWord) -> Self {
        match word {
            BundlesWord::Fixed => SectorDivision::EqualAngle,
            BundlesWord::EqualArea => SectorDivision::EqualArea,
        }
    }
}

/// Colours of rings.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ColoursWord {
    #[value(help = "those of the species' wood, tissue by tissue")]
    Wood,
    #[value(help = "the two browns of the publication")]
    Published,
}

impl From<ColoursWord> for RingColouring {
    fn from(word: ColoursWord) -> Self {
        match word {
            ColoursWord::Wood => RingColouring::Wood,
            ColoursWord::Published => RingColouring::Published,
        }
    }
}
