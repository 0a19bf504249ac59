//! Options of `greenstick anatomy`.

use super::{Declared, OptionSet, ReportingOptions};
use clap::{Arg, Args};
use greenstick::anatomy::AnatomyFile;
use greenstick::scanning::ScanParameters;
use std::path::PathBuf;

const ANATOMY_EXAMPLES: &str = "\
What is written (--only takes a list of the first words; all but springs and mapping by default)
  sections      section_LENGTH_contour.png, ..._rings.png and ..._zones.png
  longitudinal  longitudinal.png, the stem cut in half along its pith, straightened, in strips from the base on
  volume        volume.vti, or volume.vtm with a volume_NNN.vti for each segment: ring, zone, colour of every voxel
  particles     particles.ply, .vtp, .csv and .parquet: place, ring, sector, layer, zone, colour, bundle area
  surface       surface_rings.glb and surface_sectors.glb, rebuilt from the particles
  measures      sections.csv: diameters, ovality, pith and volumes over and under bark along the stem, with errors
  cores         ring_widths.csv, rings.rwl and rings_inwards.rwl: ring widths along radii
  elements      stem.vtu and stem.inp: hexahedra with the axes of the wood
  springs       springs.vtp, .csv and .parquet: each particle to its neighbours, with rest length, direction and zone
  mapping       mapping.csv: addresses with their points by the continuous and by the discrete mapping
  cleaned       cleaned.ply: the points of a scan that were left after cleaning
  and always    anatomy.json: centreline, pith, girth and rings of every layer

Examples
  greenstick anatomy -o inside
  greenstick anatomy pole.ply --unit mm -o inside --resolution 512 --rings 30
  greenstick anatomy pole.ply --unit mm -o inside --rings-by erosion --schedule eccentric --inner-circle 0.4
  greenstick anatomy pole.ply --unit mm -o inside --rings-by erosion --kernels 4*3/5,5x3+1+0/7
  greenstick anatomy plot/*.laz -o stems --only measures
  greenstick anatomy tree.glb --at 0.3,2.1,-0.4 -o limb --only particles,surface --bundles equal-area";

#[derive(Debug, Args)]
#[command(after_help = ANATOMY_EXAMPLES)]
pub struct AnatomyOptions {
    /// Meshes of stems (.glb, .gltf, .obj, .ply, .stl or .off) or point clouds (.ply, .xyz, .las or .laz); without any, a
    /// branch that comes with the program
    pub inputs: Vec<PathBuf>,
    /// Folder for the files; created if it does not exist. Of several inputs each has a folder in it, and `stems.csv` a row
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Take the annual rings of another section: a section file with `rings` (.json), or a folder that `anatomy` wrote
    #[arg(
        long,
        value_name = "PATH",
        help_heading = "Annual rings",
        conflicts_with = "ring_shares"
    )]
    pub rings_from: Option<PathBuf>,

    #[command(flatten)]
    pub request: Declared<AnatomyFile>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

impl OptionSet for AnatomyFile {
    const EXCLUDED_KEYS: &'static [&'static str] = &["input"];

    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "at" | "unit" | "only" => option.help_heading(None::<&str>),
            "colours" => option.alias("colors"),
            "schedule" => option.conflicts_with("kernels"),
            _ => ScanParameters::adjust(option),
        }
    }
}
