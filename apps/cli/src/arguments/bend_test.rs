//! Options of `greenstick bend-test`.

use super::ReportingOptions;
use crate::values;
use clap::{ArgGroup, Args};
use std::path::PathBuf;

const BEND_EXAMPLES: &str = "\
The test is three-point bending as in ASTM D143: a piece of clear wood lies on two supports and is
loaded in the middle until the load has fallen to half. The default is the standard's primary
specimen, 50 x 50 x 760 mm on a span of 710 mm, at 12 % moisture. Where lengths are not given, the
span is 14.2 heights, and the length is the span and one height more.

Stiffness, bending and crushing strength of the species' table determine the wood, by one rule for all
species. Work to maximum load is not used: there the test predicts.

Files in the folder of -o
  load-deflection.csv  deflection (m), load (N), stress (Pa), work (J), numbers of failures so far
  load-deflection.png  the same as a chart, with the table's stiffness and maximum load
  events.csv           what yielded and broke, where in the specimen, in order
  bend-test.json       the report
  species.csv, .json   of --all-species in place of these: a row for each species

Examples
  greenstick bend-test --species \"white oak\"
  greenstick bend-test --species \"white oak\" -o oak            with tables and a chart
  greenstick bend-test --species \"Sitka spruce\" --height 2cm --width 4cm --span 30cm
  greenstick bend-test --species \"white ash\" --moisture green --diameter 12mm
  greenstick bend-test --species \"red maple\" --rods 64 --edge 15mm      finer: minutes
  greenstick bend-test --species \"red maple\" --scatter 8 --seed 3       uneven strength
  greenstick bend-test --all-species -o table                  the Wood Handbook: minutes";

#[derive(Debug, Args)]
#[command(after_help = BEND_EXAMPLES,
    group(ArgGroup::new("wood").required(true).args(["species", "all_species"])))]
pub struct BendTestOptions {
    /// Species, by common or scientific name
    #[arg(long, value_name = "NAME")]
    pub species: Option<String>,
    /// Every species of the Wood Handbook, as a table beside the handbook's
    #[arg(long)]
    pub all_species: bool,
    /// Moisture content, percent of the oven-dry mass, or `green`
    #[arg(long, value_name = "PERCENT", default_value = "12", value_parser = values::moisture,
        allow_hyphen_values = true)]
    pub moisture: f64,
    /// Folder for all files, created if it does not exist; without it no files are written
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,

    /// Height of the section along the load, such as 5cm [default: 5cm, or the width]
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        help_heading = "Specimen")]
    pub height: Option<f64>,
    /// Width of the section [default: the height]
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        help_heading = "Specimen")]
    pub width: Option<f64>,
    /// Diameter of a round section, in place of height and width
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        conflicts_with_all = ["height", "width"], help_heading = "Specimen")]
    pub diameter: Option<f64>,
    /// Length of the specimen [default: the span and one height]
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        help_heading = "Specimen")]
    pub length: Option<f64>,
    /// Distance of the supports [default: 14.2 heights]
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        help_heading = "Specimen")]
    pub span: Option<f64>,

    /// Number of rods in the section
    #[arg(long, value_name = "NUMBER", default_value = "25",
        value_parser = clap::value_parser!(u32).range(1..), help_heading = "Model")]
    pub rods: u32,
    /// Distance between rods, in place of their number
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        conflicts_with = "rods", help_heading = "Model")]
    pub spacing: Option<f64>,
    /// Longest edge of rods [default: a 36th of the span]
    #[arg(long, value_name = "LENGTH", value_parser = values::distance, allow_hyphen_values = true,
        help_heading = "Model")]
    pub edge: Option<f64>,
    /// Seed of the placement of rods and of the scatter of their strength
    #[arg(
        long,
        value_name = "NUMBER",
        default_value = "1", value_parser = values::seed, allow_hyphen_values = true, help_heading = "Model")]
    pub seed: u64,
    /// Weibull modulus of the scatter of strength, 1 or more; the smaller, the wider the scatter [default: no scatter]
    #[arg(
        long,
        value_name = "NUMBER",
        allow_hyphen_values = true,
        help_heading = "Model"
    )]
    pub scatter: Option<f64>,
    /// Fraction of the maximum load at which the test ends after the load has fallen, 0 to below 1 [default: 0.5; with
    /// --all-species, whose tests end at the maximum load, 0.95]
    #[arg(
        long,
        value_name = "PART",
        allow_hyphen_values = true,
        help_heading = "Model"
    )]
    pub end: Option<f64>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}
