//! Options of `greenstick skin`.

use super::faces::FacesChoice;
use super::{Declared, MeshOptions, OptionSet, ReportingOptions};
use clap::{Arg, Args, ValueEnum};
use greenstick::picture::PictureParameters;
use greenstick::skin::{WoodField, film::FilmParameters};
use std::path::PathBuf;

const SKIN_EXAMPLES: &str = "\
A film is one .glb of skinned pieces with an animation, or a .usdc or .usdz with points over time: the mesh that was
simulated, cut along the faces that the run decided; with --faces rods, the skin of the rods in pieces. As .pvd it is the rods and bonds, a series for ParaView; as .mp4 or .webm it is a video, made by ffmpeg
where that is installed. A single frame can be written in every mesh format and as .usda, in pieces as they are then.

Examples
  greenstick simulate three-blocks -o run
  greenstick skin run -o film.glb                      all frames
  greenstick skin run -o film.glb --frames 30..60      some of them
  greenstick skin run --pictures frames --picture-size 640x480 --samples 8
  greenstick skin run -o broken.glb --frame -1         the last frame as a still
  greenstick skin run --picture broken.png --frame 45
  greenstick skin run -o near.mp4 --close-up 6         six diameters of the stem around the break
  greenstick skin run -o strain.mp4 --show strain      red where fibres tear, blue where they are crushed
  greenstick skin run pole.ply -o film.glb             where it was simulated on a mesh
  greenstick skin run -o film.glb --collision film.collision.glb --lod 0.5,0.25
  greenstick skin run -o film.glb --vat film.vat.png   for shaders that move vertices";

/// A field of the wood.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum FieldChoice {
    /// Strain along the grain over that at failure: red in tension, blue in compression
    Strain,
    /// Share of the bonds that are broken: red
    Damage,
}

impl From<FieldChoice> for WoodField {
    fn from(choice: FieldChoice) -> Self {
        match choice {
            FieldChoice::Strain => WoodField::Strain,
            FieldChoice::Damage => WoodField::Damage,
        }
    }
}

#[derive(Debug, Args)]
#[command(after_help = SKIN_EXAMPLES)]
pub struct SkinOptions {
    /// Folder of a run, as `greenstick simulate` leaves it
    pub run: PathBuf,
    #[command(flatten)]
    pub mesh: MeshOptions,
    /// File for the film or the frame
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Faces of broken wood; wood that holds is shown by its rods [default: drawn, or rods with options of their skin]
    #[arg(long, value_enum, value_name = "FACES")]
    pub faces: Option<FacesChoice>,

    #[command(flatten)]
    pub parameters: Declared<FilmParameters>,

    /// Convex collision shapes of the pieces at rest, as meshes UCX_piece_000_00 and so on, in a mesh file
    #[arg(
        long,
        value_name = "FILE.glb",
        conflicts_with = "frame",
        help_heading = "For engines"
    )]
    pub collision: Option<PathBuf>,
    /// Vertex animation texture: positions and normals in each frame as 16-bit pictures, with the mesh that they move as
    /// FILE.glb and how to read them as FILE.json
    #[arg(
        long,
        value_name = "FILE.png",
        conflicts_with = "frame",
        help_heading = "For engines"
    )]
    pub vat: Option<PathBuf>,
    /// Folder for a picture of every frame of a film; made where it is not there
    #[arg(
        long,
        value_name = "FOLDER",
        conflicts_with = "frame",
        help_heading = "Picture"
    )]
    pub pictures: Option<PathBuf>,
    /// Picture of the frame
    #[arg(
        long,
        value_name = "FILE.png",
        requires = "frame",
        help_heading = "Picture"
    )]
    pub picture: Option<PathBuf>,
    /// Colours of pictures, videos and stills in place of the wood's own
    #[arg(long, value_enum, value_name = "FIELD", help_heading = "Picture")]
    pub show: Option<FieldChoice>,
    #[command(flatten)]
    pub picture_parameters: Declared<PictureParameters>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

impl OptionSet for FilmParameters {
    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "frame" => option.conflicts_with("frames"),
            "lod" => option.value_name("SHARE,SHARE").conflicts_with("frame"),
            "collision_shapes" | "collision_vertices" => option.requires("collision"),
            "vat_width" => option.requires("vat"),
            _ => option,
        }
    }
}
