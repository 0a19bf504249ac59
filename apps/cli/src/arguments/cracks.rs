//! Options of `greenstick cracks`.

use crate::values;
use clap::Args;
use std::path::PathBuf;

const CRACKS_EXAMPLES: &str = "\
The photograph (.jpg or .png) shows a sawn end from straight above. A section on a plain background is found; else --outline
names a section file (an `outer_contour` in pixels from the upper left corner, and a `pith`), or --pith and --radius
give a circle. Cracks narrower than a pixel are not seen, nor is their depth: they are drawn as deep as they are long.

Examples
  greenstick cracks --from end.png -o cracks.toml
  greenstick break --recipe cracks.toml --picture drawn.png
  greenstick cracks --from end.png --alike -o alike.toml      others with the same statistics
  greenstick cracks --from end.png --pith 812,640 --radius 520 --diameter 24cm";

#[derive(Debug, Args)]
#[command(after_help = CRACKS_EXAMPLES)]
pub struct CracksOptions {
    /// Photograph of a sawn end
    #[arg(long, value_name = "PHOTO")]
    pub from: PathBuf,
    /// Section file with the outline, in pixels of the photograph
    #[arg(long, value_name = "SECTION.json", conflicts_with = "radius")]
    pub outline: Option<PathBuf>,
    /// Where the pith is, pixels from the left and from the top; without it the outline's, else the centroid
    #[arg(long, value_name = "X,Y", value_delimiter = ',')]
    pub pith: Option<Vec<f64>>,
    /// Radius of a round section about the pith, pixels
    #[arg(long, value_name = "PIXELS", requires = "pith")]
    pub radius: Option<f64>,
    /// Mean diameter of the section, so that widths and lengths are also printed in millimetres
    #[arg(long, value_name = "LENGTH", value_parser = values::metres)]
    pub diameter: Option<f64>,
    /// Draw cracks at random with the statistics of the groups, not each where it is
    #[arg(long)]
    pub alike: bool,
    /// File for a recipe that draws the cracks; without it only the report is printed
    #[arg(short, long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Species whose shrinkage opens the cracks
    #[arg(long, value_name = "NAME")]
    pub species: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}
