//! The commands and options of the program, with their help.

mod anatomy;
mod bend_test;
mod cracks;
mod declared;
mod faces;
mod fit;
mod fracture_test;
mod shared;
mod simulate;
mod skin;
mod sweep;
mod unit;

pub use anatomy::AnatomyOptions;
pub use bend_test::BendTestOptions;
pub use cracks::CracksOptions;
pub use declared::{Declared, OptionSet};
pub use faces::FacesChoice;
pub use fit::FitOptions;
pub use fracture_test::FractureTestOptions;
pub use shared::{MeshOptions, ReportingOptions};
pub use simulate::SimulateOptions;
pub use skin::SkinOptions;
pub use sweep::SweepOptions;
pub use unit::UnitChoice;

use clap::{Arg, ArgAction, Args, Parser, Subcommand};
use greenstick::RequestFile;
use greenstick::SectionRingSettings;
use greenstick::picture::PictureParameters;
use greenstick::scanning::ScanParameters;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples
  greenstick break                                     a branch that comes with the program
  greenstick break pole.ply --at 0.4                   at two fifths of its length
  greenstick break tree.glb --at 0.3,2.1,-0.4          the limb at a point, the rest of the tree stays
  greenstick break beam.stl --unit mm --at 120cm       STL, OBJ, PLY and OFF do not say their unit
  greenstick break --preset splintering-tension --species \"white oak\" --seed 7
  greenstick sweep sweep.toml -o variants              many breaks, and a table of them
  greenstick simulate three-blocks -o run              bonded fibres, moved and broken
  greenstick skin run -o film.glb                      its skin, as a film
  greenstick bend-test --species \"white oak\"           strength of a species in bending
  greenstick fracture-test --species \"white oak\"       its energy of fracture along the grain
  greenstick presets                                   ways in which wood breaks
  greenstick parameters                                everything that --set takes
  greenstick anatomy pole.ply --unit mm -o inside      rings, voxels and particles of a scan
  greenstick check broken.glb                          whether a mesh is closed and sound

Exit codes
  0    done
  1    the work failed: no stem that can be cut, a place that cannot be written
  2    the request was wrong: an option, a name, an input that is no sound mesh
  130  stopped with Ctrl-C; nothing was written";

const BREAK_EXAMPLES: &str = "\
Places (--at)
  0.4           a fraction of the stem's length from its base
  12cm          a length from its base
  0.3,2.1,-0.4  a point in the world, in the file's unit; picks the limb that is nearest
  --at may be given several times; --every 50cm breaks it at every multiple of a length

What comes first gives way to what comes later
  defaults, --preset, --recipe, --set, then --species, --moisture and --seed

Examples
  greenstick break
  greenstick break pole.ply -o halves.glb --part 3cm --picture halves.png
  greenstick break tree.obj --at 0.3,2.1,-0.4 -o broken.obj
  greenstick break trunk.glb --at 0.2 --at 0.5 --at 3m       in four pieces
  greenstick break trunk.glb --every 50cm --part 5cm         in pieces half a metre long
  greenstick break board.gltf --kind board --pith 0,-4cm --preset brash
  greenstick break --variants 5 -o twigs.glb           twigs_1.glb to twigs_5.glb, no two alike
  greenstick break --set high.height=2 --set sapwood.perlin_amplitude=0.3 --set seed=9
  greenstick break --preset twist --save-recipe twist.toml
  greenstick break --recipe twist.toml --json > report.json
  greenstick break pole.ply --simulate bend -o halves.glb   moved as bonded fibres until it breaks
  greenstick break --from-run bent -o halves.glb       where and as the run in bent/ broke its mesh
  greenstick break tree.laz --at 3m -o halves.glb      a point cloud: the bark of its stem is made first
  greenstick break broken_branch.ply --bark-only       a scan of a broken branch, its fracture left out";

/// Breaks wood: a mesh of a branch, trunk, log or board goes in, halves that fit come out.
#[derive(Debug, Parser)]
#[command(name = "greenstick", version, after_help = EXAMPLES, max_term_width = 110)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Break a mesh, or the branch that comes with the program
    Break(Box<BreakOptions>),
    /// Break wood many times, with parameters that vary, and list what came of it
    Sweep(SweepOptions),
    /// Show the inside of a stem: sections, rings, voxels, particles
    Anatomy(Box<AnatomyOptions>),
    /// Say whether meshes are closed, oriented, manifold and free of crossings
    Check(CheckOptions),
    /// Take a picture of a mesh
    Picture(PictureOptions),
    /// Move wood as bonded fibres until it breaks
    Simulate(Box<SimulateOptions>),
    /// Give a simulated run its skin: a frame as meshes, or all of them as a film
    Skin(Box<SkinOptions>),
    /// Set the parameters of a drawn break from a simulated one
    Fit(FitOptions),
    /// Test wood in three-point bending, beside the Wood Handbook's tables
    BendTest(Box<BendTestOptions>),
    /// Test how tough wood is along the grain: a crack in opening or sliding, beside the energy that was put in
    FractureTest(Box<FractureTestOptions>),
    /// List the parameters that --set and recipes take
    Parameters(ParametersOptions),
    /// Print the JSON Schema of the files that hold parameters
    Schema(SchemaOptions),
    /// List the presets
    Presets(PresetsOptions),
    /// List the species, or everything that is known of one
    Species(SpeciesOptions),
    /// Draw the annual rings into the outline of a section
    Rings(RingsOptions),
    /// Measure the drying cracks on a photograph of a sawn end, and write a recipe that draws them
    Cracks(CracksOptions),
    /// Print a script with which a shell completes commands and options
    Completions(CompletionsOptions),
    /// Write the manual pages
    Manual(ManualOptions),
}

const RINGS_EXAMPLES: &str = "\
The section is a JSON file with an `outer_contour` [[x, y], ...] and, if known, a `pith` [x, y]; `y_axis` (\"down\" or
\"up\") and `units` (\"px\") say how it is meant. Its own `rings` are used by --compare only.

Examples
  greenstick rings section.json --rings 24 -o rings.json --picture rings.png
  greenstick rings section.json --widths 4.1,3.8,3.9,2.7 -o rings.json
  greenstick rings section.json --pith 878,901 --compare
  greenstick rings section.json --fit --compare
  greenstick rings section.json --rings-by erosion --inner-circle 0.4 --picture rings.png
  greenstick rings section.json --rings-by erosion --kernels 4*3/5,3/9 --resolution 256 -o rings.json";

#[derive(Debug, Args)]
#[command(after_help = RINGS_EXAMPLES)]
pub struct RingsOptions {
    /// The section (.json)
    pub section: PathBuf,
    /// Where to write the rings (.json)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Print how far the file's own rings are from the model's
    #[arg(long)]
    pub compare: bool,
    /// Fit the model to the file's own rings, of which a few points are enough: when the stem began to lean
    #[arg(long, conflicts_with_all = ["eccentricity_onset", "rings_by"])]
    pub fit: bool,
    /// Where to write a picture of the rings (.png)
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// Draw outline, rings and pith over this photograph (.jpg or .png), whose pixels are the file's coordinates, as the picture
    #[arg(
        long,
        value_name = "FILE",
        requires = "picture",
        conflicts_with = "picture_size"
    )]
    pub photo: Option<PathBuf>,
    #[command(flatten)]
    pub settings: Declared<SectionRingSettings>,
}

#[derive(Debug, Clone, Args)]
#[command(after_help = BREAK_EXAMPLES)]
pub struct BreakOptions {
    /// Mesh to break (.glb, .gltf, .obj, .ply, .stl or .off), or a point cloud (.ply, .xyz, .txt, .asc, .pts, .las or
    /// .laz) whose bark is made first; without it, a branch that comes with the program
    pub input: Option<PathBuf>,
    /// File for the pieces, in the format of its ending (.glb, .gltf, .obj, .ply, .stl, .off, .usda, .usdc or .usdz)
    /// [default: broken.glb, without --picture]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// File for a picture of the break [default: broken.png, without --output]
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// Preset to start from; several may be given, later ones over earlier ones
    #[arg(long, value_name = "NAME", help_heading = "How it breaks")]
    pub preset: Vec<String>,
    /// Recipe file to read
    #[arg(long, value_name = "FILE.toml", help_heading = "How it breaks")]
    pub recipe: Option<PathBuf>,
    /// Set a parameter; `greenstick parameters` lists them
    #[arg(
        long,
        value_name = "KEY=VALUE",
        allow_hyphen_values = true,
        help_heading = "How it breaks"
    )]
    pub set: Vec<String>,
    /// Write everything that decides the outcome; `--recipe` then makes the same again, byte for byte
    #[arg(long, value_name = "FILE.toml", help_heading = "How it breaks")]
    pub save_recipe: Option<PathBuf>,

    /// Break it by simulation: a scene that comes with the program, or a scene file; takes minutes
    #[arg(long, value_name = "SCENE", help_heading = "How it breaks",
        conflicts_with_all = ["preset", "recipe", "species", "moisture", "save_recipe", "pith", "kind", "every"])]
    pub simulate: Option<String>,
    /// Faces of a simulated break
    #[arg(long, value_enum, value_name = "FACES", help_heading = "How it breaks", requires = "simulate", default_value_t = FacesChoice::Drawn)]
    pub faces: FacesChoice,

    /// Let the scene name files outside of its folder (../block.stl)
    #[arg(long, help_heading = "How it breaks", requires = "simulate")]
    pub allow_outside: bool,

    /// Break it where and as a run of `greenstick simulate` did, in its folder; the input is the mesh of the run
    #[arg(long, value_name = "RUN", help_heading = "How it breaks",
        conflicts_with_all = ["simulate", "preset", "recipe", "species", "moisture", "pith", "kind", "at", "every"])]
    pub from_run: Option<PathBuf>,
    /// The frame of the run, counted from 0; negative from the end [default: -1]
    #[arg(
        long,
        value_name = "NUMBER",
        help_heading = "How it breaks",
        allow_hyphen_values = true,
        requires = "from_run"
    )]
    pub frame: Option<i64>,

    /// Take the annual rings of another section: a section file with `rings` (.json), or a folder that `anatomy` wrote
    #[arg(long, value_name = "PATH", help_heading = "Annual rings", conflicts_with_all = ["simulate", "from_run", "ring_shares"])]
    pub rings_from: Option<PathBuf>,

    /// Break it so many times, each with the next seed; a number is added to the names of the files
    #[arg(long, value_name = "NUMBER", help_heading = "How it breaks",
        conflicts_with_all = ["simulate", "from_run", "json"], value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub variants: Option<u32>,

    #[command(flatten)]
    pub request: Declared<RequestFile>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

impl OptionSet for RequestFile {
    const EXCLUDED_KEYS: &'static [&'static str] = &["input"];
    const SHORTCUTS: &'static [&'static str] = &["break.seed", "break.hang"];

    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            // The input may follow it.
            "fray" => option.num_args(0..=1).default_missing_value("0.5").help(
                "Bend thorns and tear some loose: 0 not at all, 1 badly [0.5 without an amount]",
            ),
            "hang" => option.help_heading("What comes out"),
            // Listed with the input and the output.
            "at" => option.help_heading(None::<&str>).action(ArgAction::Append).help(
                "Where to break it: see Places below; given several times, it breaks at each [default: 0.5]",
            ),
            "every" | "unit" => option.help_heading(None::<&str>),
            "seed" => option
                .help_heading("How it breaks")
                .help("Seed of everything irregular: a number, or `random`, which the report says [default: 1]"),
            "species" | "moisture" => option.help_heading("How it breaks"),
            "picture_size" => PictureParameters::adjust(option),
            _ => ScanParameters::adjust(option),
        }
    }
}

impl OptionSet for PictureParameters {
    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "picture_size" => option.visible_alias("size"),
            _ => option,
        }
    }
}

impl OptionSet for SectionRingSettings {
    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "schedule" => option.conflicts_with("kernels"),
            "rings" => option.conflicts_with_all(["radii", "widths"]),
            "radii" => option.conflicts_with("widths"),
            _ => option,
        }
    }
}

impl OptionSet for ScanParameters {
    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "outliers" => option.conflicts_with("no_outliers"),
            "isolated" => option.conflicts_with("no_isolated"),
            _ => option,
        }
    }
}

#[derive(Debug, Args)]
pub struct CheckOptions {
    /// Meshes to check
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Unit of length in the files, where their format has none
    #[arg(long)]
    pub unit: Option<UnitChoice>,
    /// Exit with code 1 if a mesh is not a sound solid; otherwise the code is 0 once the report is printed
    #[arg(long)]
    pub strict: bool,
    /// Do not look for triangles that cross, which takes most of the time
    #[arg(long)]
    pub fast: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Materials are shown in their plain colours; their textures are not.")]
pub struct PictureOptions {
    /// Mesh to show
    pub file: PathBuf,
    /// File for the picture
    #[arg(short, long, value_name = "FILE.png", default_value = "picture.png")]
    pub output: PathBuf,
    /// Unit of length in the file, where its format has none
    #[arg(long)]
    pub unit: Option<UnitChoice>,
    #[command(flatten)]
    pub picture_parameters: Declared<PictureParameters>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Threads to use [default: as many as the machine offers]; the picture is the same
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

#[derive(Debug, Args)]
pub struct ParametersOptions {
    /// Only this parameter, or those of this group (`sapwood`)
    pub key: Option<String>,
    /// Print them as JSON
    #[arg(long, conflicts_with_all = ["markdown", "schema"])]
    pub json: bool,
    /// Print the reference page in Markdown
    #[arg(long, conflicts_with_all = ["schema", "key"])]
    pub markdown: bool,
    /// Print a JSON schema of recipes, for editors
    #[arg(long, conflicts_with = "key")]
    pub schema: bool,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples
  greenstick completions bash > ~/.local/share/bash-completion/completions/greenstick
  greenstick completions zsh > ~/.zfunc/_greenstick          a folder in $fpath
  greenstick completions fish > ~/.config/fish/completions/greenstick.fish";

#[derive(Debug, Args)]
#[command(after_help = COMPLETIONS_EXAMPLES)]
pub struct CompletionsOptions {
    /// The shell
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub struct ManualOptions {
    /// Folder for the pages, greenstick.1 and one for each command
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

#[derive(Debug, Args)]
pub struct SchemaOptions {
    /// Only one of them: break, anatomy, rings, scene
    pub name: Option<String>,
}

#[derive(Debug, Args)]
pub struct PresetsOptions {
    /// Print the recipe of this preset
    pub name: Option<String>,
    /// Print the list as JSON
    #[arg(long, conflicts_with = "markdown")]
    pub json: bool,
    /// Print the reference page in Markdown
    #[arg(long, conflicts_with = "name")]
    pub markdown: bool,
}

#[derive(Debug, Args)]
pub struct SpeciesOptions {
    /// Common or scientific name
    pub name: Option<String>,
    /// Print as JSON, in SI units
    #[arg(long, conflicts_with = "markdown")]
    pub json: bool,
    /// Print the reference page in Markdown
    #[arg(long, conflicts_with = "name")]
    pub markdown: bool,
}
