//! Options of `greenstick simulate`.

use super::{Declared, MeshOptions, OptionSet, ReportingOptions};
use clap::{Arg, Args};
use greenstick::fibre::scene::Scene;
use greenstick::picture::PictureParameters;
use greenstick::scanning::ScanParameters;
use std::path::PathBuf;

const SIMULATE_EXAMPLES: &str = "\
Examples
  greenstick simulate --list
  greenstick simulate three-blocks -o run --seed 2
  greenstick simulate three-blocks -o run --seed 2 --resume    goes on where it was stopped
  greenstick simulate three-blocks -o film.glb                 the run in film.run, and its skin as a film
  greenstick simulate bend pole.ply -o bent                    the scene on a mesh
  greenstick simulate bend tree.laz -o bent                    the scene on the bark of a scan
  greenstick simulate snow tree.glb -o broken --at 3m --species \"white oak\"   at a place on its stem, of another wood
  greenstick simulate bend pole.ply --rings-from inside -o bent   with the rings that `anatomy` found in it
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
    /// Let the scene name files outside of its folder (../block.stl)
    #[arg(long)]
    pub allow_outside: bool,
    /// Go on from the folder's checkpoint
    #[arg(long)]
    pub resume: bool,
    /// Simulate twice: coarsely, to find where the wood breaks, then with edges half as long within three diameters of that
    #[arg(long)]
    pub refine: bool,
    /// List the scenes that come with the program
    #[arg(long)]
    pub list: bool,
    /// Print the reference page of scene files in Markdown
    #[arg(long, conflicts_with_all = ["list", "json"])]
    pub markdown: bool,
    /// Write the scene with all its keys
    #[arg(long, value_name = "FILE.toml")]
    pub save_scene: Option<PathBuf>,

    /// Take the annual rings of another section: a section file with `rings` (.json), or a folder that `anatomy` wrote
    #[arg(
        long,
        value_name = "PATH",
        help_heading = "In place of the scene's own",
        conflicts_with = "ring_shares"
    )]
    pub rings_from: Option<PathBuf>,

    #[command(flatten)]
    pub changes: Declared<Scene>,
    #[command(flatten)]
    pub scan: Declared<ScanParameters>,

    /// Take no pictures of the first frame, one in which the wood has just broken, and the last
    #[arg(long, help_heading = "Picture")]
    pub no_pictures: bool,
    #[command(flatten)]
    pub picture_parameters: Declared<PictureParameters>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

/// The keys of a scene that are options too.
impl OptionSet for Scene {
    const EXCLUDED_KEYS: &'static [&'static str] = &[
        "about",
        "frames_per_second",
        "rows_per_second",
        "for_length",
    ];
    const SHORTCUTS: &'static [&'static str] = &[
        "stem.at",
        "stem.up",
        "stem.inclination",
        "wood.species",
        "wood.moisture",
    ];

    fn adjust(option: Arg) -> Arg {
        // The default is what the scene says.
        let help = option
            .get_help()
            .map(ToString::to_string)
            .unwrap_or_default();
        let help = help
            .split(" [default")
            .next()
            .unwrap_or_default()
            .to_owned();
        option
            .help(help)
            .help_heading("In place of the scene's own")
    }
}
