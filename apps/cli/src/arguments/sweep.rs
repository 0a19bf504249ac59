//! The options of `greenstick sweep`.

use super::ReportingOptions;
use clap::Args;
use std::path::PathBuf;

const SWEEP_EXAMPLES: &str = "\
A sweep is a recipe with two tables more. `[vary]` has the keys that vary, each with a list, steps, or two values to draw between;
`[sweep]` says how they are drawn and what is written (samples, sampling, seed, file, textures, sheet):

  species = \"white oak\"
  texture_size = 512
  [sweep]
  samples = 100
  [vary]
  seed = { from = 1, to = 5 }
  inclination = [0, 15, 30]
  high.height = { between = [0.5, 2] }

A sweep that was stopped or killed goes on with what is missing when the same command runs again.

Examples
  greenstick sweep sweep.toml -o variants
  greenstick sweep sweep.toml --show 17 > variant.toml     then: greenstick break --recipe variant.toml";

#[derive(Debug, Args)]
#[command(after_help = SWEEP_EXAMPLES)]
pub struct SweepOptions {
    /// The sweep (.toml)
    #[arg(required_unless_present = "markdown")]
    pub sweep: Option<PathBuf>,
    /// Folder for the pieces, the table (variants.parquet), the contact sheet (sheet.png) and the journal
    #[arg(short, long, value_name = "DIR", required_unless_present_any = ["show", "markdown"])]
    pub output: Option<PathBuf>,
    /// Go on without asking, however many variants there are
    #[arg(short, long)]
    pub yes: bool,
    /// Print the recipe of one variant and do nothing else
    #[arg(long, value_name = "NUMBER", conflicts_with = "output")]
    pub show: Option<u64>,
    /// Print the reference page of the table `[sweep]` in Markdown
    #[arg(long, conflicts_with_all = ["sweep", "output"])]
    pub markdown: bool,
    #[command(flatten)]
    pub reporting: ReportingOptions,
}
