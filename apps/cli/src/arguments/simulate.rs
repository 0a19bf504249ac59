//! Options of `greenstick simulate`.

use super::{Declared, MeshOptions, ReportingOptions};
use clap::Args;
use greenstick::picture::PictureParameters;
use std::path::PathBuf;

const SIMULATE_EXAMPLES: &str = "\
Examples
  greenstick simulate --list
  greenstick simulate three-blocks -o run --seed 2
  greenstick simulate three-blocks -o run --seed 2 --resume    goes on where it was stopped
  greenstick simulate three-blocks -o film.glb                 the run in film.run, and its skin as a film
  greenstick simulate bend pole.ply -o bent                    the scene on a mesh
  greenstick simulate bend --save-scene mine.toml              to change it";

#[derive(Debug, Args)]
#[command(after_help = SIMULATE_EXAMPLES)]
pub struct SimulateOptions {
    /// Scene: a file that ends in .toml, or the name of one that comes with the program
    pub scene: Option<String>,
    #[command(flatten)]
    pub mesh: MeshOptions,
    /// Folder for everything that is written, made where it is not there; or a film (.glb, .usdc, .usdz, .mp4, .webm),
    /// and the folder is named after it, ending in .run
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Go on from the folder's checkpoint
    #[arg(long)]
    pub resume: bool,
    /// List the scenes that come with the program
    #[arg(long)]
    pub list: bool,
    /// Print the reference page of scene files in Markdown
    #[arg(long, conflicts_with_all = ["list", "json"])]
    pub markdown: bool,
    /// Write the scene with all its keys
    #[arg(long, value_name = "FILE.toml")]
    pub save_scene: Option<PathBuf>,

    /// Solver
    #[arg(
        long,
        value_name = "NAME",
        help_heading = "In place of the scene's own"
    )]
    pub solver: Option<String>,
    /// Step of the solver, s; else it chooses
    #[arg(
        long,
        value_name = "SECONDS",
        help_heading = "In place of the scene's own"
    )]
    pub step: Option<f64>,
    /// Which of all the pieces of wood like this
    #[arg(
        long,
        value_name = "NUMBER",
        help_heading = "In place of the scene's own"
    )]
    pub seed: Option<u64>,
    /// How long it lasts, s
    #[arg(
        long,
        value_name = "SECONDS",
        help_heading = "In place of the scene's own"
    )]
    pub duration: Option<f64>,

    /// Take no pictures of the first, middle and last frame
    #[arg(long, help_heading = "Picture")]
    pub no_pictures: bool,
    #[command(flatten)]
    pub picture_parameters: Declared<PictureParameters>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}
