//! Options of `greenstick skin`.

use super::{Declared, MeshOptions, ReportingOptions};
use crate::values;
use clap::Args;
use greenstick::picture::PictureParameters;
use std::path::PathBuf;

const SKIN_EXAMPLES: &str = "\
A film is one .glb of skinned pieces with an animation, or a .usdc or .usdz with points over time: the pieces that its
last frame leaves. As .pvd it is the rods and bonds, a series for ParaView; as .mp4 or .webm it is a video, made by ffmpeg
where that is installed. A single frame can be written in every mesh format and as .usda, in pieces as they are then.

Examples
  greenstick simulate three-blocks -o run
  greenstick skin run -o film.glb                      all frames
  greenstick skin run -o film.glb --frames 30..60      some of them
  greenstick skin run --pictures frames --picture-size 640x480 --samples 8
  greenstick skin run -o broken.glb --frame -1         the last frame as a still
  greenstick skin run --picture broken.png --frame 45
  greenstick skin run pole.ply -o film.glb             where it was simulated on a mesh
  greenstick skin run -o film.glb --collision film.collision.glb --lod 0.5,0.25
  greenstick skin run -o film.glb --vat film.vat.png   for shaders that move vertices";

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
    /// One frame, counted from 0; negative from the end
    #[arg(
        long,
        value_name = "NUMBER",
        allow_hyphen_values = true,
        conflicts_with = "frames"
    )]
    pub frame: Option<i64>,
    /// Frames of the film, from the first to before the last [default: all]
    #[arg(long, value_name = "FROM..TO", value_parser = values::range)]
    pub frames: Option<(usize, usize)>,

    /// Fibre bundles that each rod is split into, 1 to 1000
    #[arg(long, value_name = "NUMBER", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=1000),
        help_heading = "Skin")]
    pub fibres: u32,
    /// Length of splinters over what shear lag gives; 0 for flat ends
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = values::amount, help_heading = "Skin")]
    pub splinters: f64,
    /// Slabs along the grain for each edge of a rod
    #[arg(long, value_name = "NUMBER", default_value = "2", value_parser = values::positive, help_heading = "Skin")]
    pub slabs: f64,
    /// Keep the faces between rods that hold together, so that every rod is closed by itself
    #[arg(long, help_heading = "Skin")]
    pub keep_inner: bool,
    /// What bounds the section
    #[arg(long, value_enum, default_value = "contour", help_heading = "Skin")]
    pub outline: OutlineChoice,
    /// Leave out the bodies that act on the wood
    #[arg(long, help_heading = "Skin")]
    pub no_bodies: bool,
    /// Leave out what the rods do not fill: the mesh beyond their ends, and twigs that hang on them
    #[arg(long, help_heading = "Skin")]
    pub only_rods: bool,
    /// Width of the baked textures, pixels
    #[arg(long, value_name = "PIXELS", default_value = "1024", value_parser = values::texture_size,
        help_heading = "Skin")]
    pub texture_size: u32,
    /// Most joints of a piece in a film [default: as many as there are]; the report says what error that makes
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Film")]
    pub max_joints: Option<u32>,
    /// Most joints that a vertex of a film follows, 1 to 8; many viewers know no more than 4
    #[arg(long, value_name = "NUMBER", default_value = "4", value_parser = clap::value_parser!(u8).range(1..=8),
        help_heading = "Film")]
    pub influences: u8,

    /// Convex collision shapes of the pieces at rest, as meshes UCX_piece_000_00 and so on, in a mesh file
    #[arg(
        long,
        value_name = "FILE.glb",
        conflicts_with = "frame",
        help_heading = "For engines"
    )]
    pub collision: Option<PathBuf>,
    /// Most convex shapes of a piece
    #[arg(long, value_name = "NUMBER", default_value = "16", requires = "collision",
        value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = "For engines")]
    pub collision_shapes: u16,
    /// Most vertices of a convex shape
    #[arg(long, value_name = "NUMBER", default_value = "32", requires = "collision",
        value_parser = clap::value_parser!(u16).range(4..=255), help_heading = "For engines")]
    pub collision_vertices: u16,

    /// Levels of detail: shares of the triangles, in files beside the film, film_lod1.glb and so on
    #[arg(
        long,
        value_name = "SHARE,SHARE",
        value_delimiter = ',',
        value_parser = share,
        conflicts_with = "frame",
        help_heading = "For engines"
    )]
    pub lod: Vec<f64>,
    /// Vertex animation texture: positions and normals in each frame as 16-bit pictures, with the mesh that they move as
    /// FILE.glb and how to read them as FILE.json
    #[arg(
        long,
        value_name = "FILE.png",
        conflicts_with = "frame",
        help_heading = "For engines"
    )]
    pub vat: Option<PathBuf>,
    /// Most pixels in a row of such a picture
    #[arg(long, value_name = "PIXELS", default_value = "8192", requires = "vat",
        value_parser = clap::value_parser!(u16).range(1..=16384), help_heading = "For engines")]
    pub vat_width: u16,

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
    #[command(flatten)]
    pub picture_parameters: Declared<PictureParameters>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

/// A share of triangles: above 0, up to 1.
fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x > 0.0 && x <= 1.0 => Ok(x),
        _ => Err("expected shares above 0 and up to 1 with commas between them: 0.5,0.25".into()),
    }
}

/// The outline of a skin's section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum OutlineChoice {
    /// The stem's own contour, with the bark of its mesh
    Contour,
    /// The convex hull of the rods, as in Sutherland's thesis
    Hull,
}

impl From<OutlineChoice> for greenstick::skin::rods::Outline {
    fn from(word: OutlineChoice) -> Self {
        match word {
            OutlineChoice::Contour => Self::Contour,
            OutlineChoice::Hull => Self::Hull,
        }
    }
}
