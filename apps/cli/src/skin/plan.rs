//! What is made of a run, in the terms of the libraries: from the options of `greenstick skin`, or for the film of a
//! simulation.

use crate::arguments::SkinOptions;
use crate::failure::Failure;
use greenstick::formats::film::GlbOptions;
use greenstick::geometry::ConvexOptions;
use greenstick::picture::PictureOptions;
use greenstick::skin::{WoodField, film::FilmParameters};
use greenstick_sweep::shown::{Faces, ShownAs};
use std::ops::Range;
use std::path::PathBuf;

/// What is made of a run.
#[derive(Debug, Clone)]
pub struct FilmPlan {
    /// File of the film or the frame.
    pub output: Option<PathBuf>,
    /// The range of frames in the film; `None` for all.
    pub frames: Option<Range<usize>>,
    /// How the run is shown.
    pub shown: ShownAs,
    /// How a glTF film is written.
    pub glb: GlbOptions,
    /// Files for game engines.
    pub engines: EnginePlan,
    /// Folder for a picture of every frame.
    pub pictures: Option<PathBuf>,
    /// How pictures and videos are taken.
    pub shot: PictureOptions,
}

/// Which files for game engines are made beside a film.
#[derive(Debug, Clone, Default)]
pub struct EnginePlan {
    /// File and options of the collision shapes.
    pub collision: Option<(PathBuf, ConvexOptions)>,
    /// Share of the triangles in each level of detail.
    pub levels: Vec<f64>,
    /// File of the vertex animation texture, and its greatest width, pixels.
    pub vertex_texture: Option<(PathBuf, usize)>,
}

/// Returns which faces are meant: an option that only the skin of rods has asks for that.
fn faces(options: &SkinOptions) -> Result<Option<Faces>, Failure> {
    let is_given = |key: &str| options.parameters.text(key).is_some();
    Faces::meant(options.faces.map(Faces::from), is_given).map_err(|key| {
        Failure::request(format!(
            "--{} applies to the skin of the rods, and --faces asks for drawn faces",
            key.replace('_', "-")
        ))
        .hint("leave it out, or take --faces rods")
    })
}

impl FilmPlan {
    /// Returns the plan of a film of all frames, in the file `output`, with the wood of this seed.
    pub fn whole_film(output: PathBuf, seed: u64, shot: PictureOptions) -> Self {
        let parameters = FilmParameters::default();
        FilmPlan {
            output: Some(output),
            frames: None,
            shown: ShownAs::best(seed, parameters.texture_size),
            glb: glb_options(&parameters),
            engines: EnginePlan::default(),
            pictures: None,
            shot,
        }
    }

    /// Returns the plan that options ask for, with the wood of this seed.
    pub fn from_options(options: &SkinOptions, seed: u64) -> Result<Self, Failure> {
        let parameters = options.parameters.set()?;
        Ok(FilmPlan {
            output: options.output.clone(),
            frames: parameters.frames.map(Range::from),
            shown: ShownAs {
                faces: faces(options)?,
                field: options.show.map(WoodField::from),
                film: parameters.film_options(seed),
            },
            glb: glb_options(&parameters),
            engines: EnginePlan {
                collision: (options.collision.clone())
                    .map(|path| (path, parameters.convex_options())),
                levels: parameters.lod.clone(),
                vertex_texture: (options.vat.clone())
                    .map(|path| (path, parameters.vat_width as usize)),
            },
            pictures: options.pictures.clone(),
            shot: options.picture_parameters.set()?.options(),
        })
    }
}

/// The options of a film in a GLB file.
fn glb_options(parameters: &FilmParameters) -> GlbOptions {
    GlbOptions {
        max_joints: parameters.max_joints.map(|n| n as usize),
        max_influences: parameters.influences as usize,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arguments::{Arguments, Command};
    use clap::Parser;

    #[test]
    fn the_film_of_a_simulation_is_that_of_the_default_options() {
        let words = ["greenstick", "skin", "-o", "film.glb", "run"];
        let Command::Skin(options) = Arguments::try_parse_from(words).unwrap().command else {
            panic!("another command");
        };
        let shot = options.picture_parameters.set().unwrap().options();
        let plan = FilmPlan::whole_film("film.glb".into(), 7, shot);
        let of_options = FilmPlan::from_options(&options, 7).unwrap();
        assert_eq!(format!("{plan:?}"), format!("{of_options:?}"));
    }
}
