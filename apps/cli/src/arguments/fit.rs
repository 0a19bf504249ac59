//! Options of `greenstick fit`.

use super::MeshOptions;
use clap::Args;
use std::path::PathBuf;

const FIT_EXAMPLES: &str = "\
Where every rod of the run broke, how high and why, gives the ductile zone, inclination, layers, thorns and relief of a
drawn break. The report says how many breaks each value comes from, and what the run does not determine.

Examples
  greenstick simulate bend pole.ply -o run
  greenstick fit run -o recipe.toml                    prints where the break is: --at
  greenstick break pole.ply --at 0.4871 --recipe recipe.toml";

#[derive(Debug, Args)]
#[command(after_help = FIT_EXAMPLES)]
pub struct FitOptions {
    /// Folder of a run, as `greenstick simulate` leaves it
    pub run: PathBuf,
    #[command(flatten)]
    pub mesh: MeshOptions,
    /// File for the recipe; without it only the report is printed
    #[arg(short, long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// The frame, counted from 0; negative from the end
    #[arg(
        long,
        value_name = "NUMBER",
        default_value = "-1",
        allow_hyphen_values = true
    )]
    pub frame: i64,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}
