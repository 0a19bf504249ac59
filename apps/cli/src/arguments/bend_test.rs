//! Options of `greenstick bend-test`.

use super::{Declared, OptionSet, ReportingOptions};
use clap::{Arg, ArgGroup, Args};
use greenstick::bending::{BendSettings, UnitColumn};
use std::path::PathBuf;

const BEND_EXAMPLES: &str = "\
The test is three-point bending as in ASTM D143: a piece of clear wood lies on two supports and is
loaded in the middle until the load has fallen to half. The default is the standard's primary
specimen, 50 x 50 x 760 mm on a span of 710 mm, at 12 % moisture. Where lengths are not given, the
span is 14.2 heights, and the length is the span and one height more.

Stiffness, bending and crushing strength of the species' table determine the wood, by one rule for all
species. Work to maximum load is not used: there the test predicts.

--specimens bends many specimens of one species, each of wood of its own: density varies as that of clear
wood does (Wood Handbook, Table 5-6), stiffness and strength follow it (Table 5-11) with a rest of their
own, and the weakest link of flaws makes large specimens weaker than small ones (--flaws). --measured sets
a table of yours beside them.

Files in the folder of -o
  load-deflection.csv  deflection (m), load (N), stress (Pa), work (J), numbers of failures so far
  load-deflection.png  the same as a chart, with the table's stiffness and maximum load
  events.csv           what yielded and broke, where in the specimen, in order
  bend-test.json       the report
  species.csv, .json   of --all-species in place of these: a row for each species
  specimens.csv, .json of --specimens in place of these: a row for each specimen, and the statistics
  scatter.png          modulus of rupture over density of the specimens, beside measured ones

Examples
  greenstick bend-test --species \"white oak\"
  greenstick bend-test --species \"white oak\" -o oak            with tables and a chart
  greenstick bend-test --species \"Sitka spruce\" --height 2cm --width 4cm --span 30cm
  greenstick bend-test --species \"white ash\" --moisture green --diameter 12mm
  greenstick bend-test --species \"red maple\" --rods 64 --edge 15mm      finer: minutes
  greenstick bend-test --species \"red maple\" --scatter 8 --seed 3       uneven strength
  greenstick bend-test --all-species -o table                  every species: minutes
  greenstick bend-test --species \"yellow birch\" --specimens 200 -o scatter        minutes
  greenstick bend-test --species \"yellow birch\" --specimens 200 --measured birch.csv \\
      --density-column Density:g/cm3 --rupture-column Resistance:MPa -o scatter";

#[derive(Debug, Args)]
#[command(after_help = BEND_EXAMPLES,
    group(ArgGroup::new("wood").required(true).args(["species", "all_species"])))]
pub struct BendTestOptions {
    /// Species, by common or scientific name
    #[arg(long, value_name = "NAME")]
    pub species: Option<String>,
    /// Every species, as a table beside those of the sources
    #[arg(long)]
    pub all_species: bool,
    /// Measured specimens beside those of --specimens: a CSV file with density and modulus of rupture
    #[arg(
        long,
        value_name = "FILE",
        requires = "specimens",
        help_heading = "Scatter"
    )]
    pub measured: Option<PathBuf>,
    /// Column of density in it and its unit [default: density_kg_per_m3:kg/m3]
    #[arg(
        long,
        value_name = "NAME:UNIT",
        requires = "measured",
        help_heading = "Scatter"
    )]
    pub density_column: Option<UnitColumn>,
    /// Column of the modulus of rupture in it and its unit [default: modulus_of_rupture_Pa:Pa]
    #[arg(
        long,
        value_name = "NAME:UNIT",
        requires = "measured",
        help_heading = "Scatter"
    )]
    pub rupture_column: Option<UnitColumn>,
    /// Folder for all files, created if it does not exist; without it no files are written
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub settings: Declared<BendSettings>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

impl OptionSet for BendSettings {
    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "moisture" => option.help_heading(None::<&str>),
            "diameter" => option.conflicts_with_all(["height", "width"]),
            "spacing" => option.conflicts_with("rods"),
            "specimens" => option.conflicts_with_all(["all_species", "scatter"]),
            "flaws" => option.requires("specimens"),
            _ => option,
        }
    }
}
