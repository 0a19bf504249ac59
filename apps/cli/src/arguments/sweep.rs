//! The options of `greenstick sweep`.

use super::ReportingOptions;
use clap::Args;
use greenstick_sweep::Part;
use greenstick_sweep::job::MAX_PARTS;
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

With `kind = 'forest'`, `input = 'forest.glb'` and `nodes = 'Tree_*'` in `[sweep]`, the trees of one scene are the variants: each
draws its own values, and forest.glb in the folder has the pieces of those that broke.

A sweep that was stopped or killed goes on with what is missing when the same command runs again.

Examples
  greenstick sweep sweep.toml -o variants
  greenstick sweep sweep.toml --show 17 > variant.toml     then: greenstick break --recipe variant.toml
  greenstick sweep sweep.toml -o variants --part 2/4       one of four machines that share a folder
  greenstick sweep sweep.toml --job job --parts 64         then: openjd run job/template.json --step Variants";

#[derive(Debug, Args)]
#[command(after_help = SWEEP_EXAMPLES)]
pub struct SweepOptions {
    /// The sweep (.toml)
    #[arg(required_unless_present = "markdown")]
    pub sweep: Option<PathBuf>,
    /// Folder for the pieces, the table (variants.parquet), the contact sheet (sheet.png) and the journal
    #[arg(short, long, value_name = "DIR", required_unless_present_any = ["show", "job", "markdown"])]
    pub output: Option<PathBuf>,
    /// Make one part of the variants only, such as 1/8, and no table; the command without it takes over what parts have made
    #[arg(long, value_name = "NUMBER/ALL", conflicts_with_all = ["show", "job"])]
    pub part: Option<Part>,
    /// Write a job of the Open Job Description, which render farms run, into a folder and do nothing else
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "show"])]
    pub job: Option<PathBuf>,
    /// Parts of that job, each a task of its own
    #[arg(long, value_name = "NUMBER", default_value_t = 16, value_parser = clap::value_parser!(u64).range(1..=MAX_PARTS), requires = "job")]
    pub parts: u64,
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
