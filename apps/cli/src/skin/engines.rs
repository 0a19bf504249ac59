//! What game engines want beside a film: collision shapes.

use super::{failure, in_metres};
use crate::arguments::SkinOptions;
use crate::failure::Failure;
use crate::progress::Progress;
use greenstick::film::{CollisionPiece, FilmError, SkinnedFilm, collision};
use greenstick::geometry::ConvexOptions;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// What was made, and the files with their sizes.
#[derive(Default, Serialize)]
pub struct Engines {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    collision: Vec<CollisionPiece>,
    #[serde(skip)]
    pub files: Vec<(String, usize)>,
}

impl Engines {
    /// Lines of the report.
    pub fn words(&self, text: &mut String) {
        if !self.collision.is_empty() {
            let shapes: usize = self.collision.iter().map(|p| p.shapes).sum();
            let off = self.collision.iter().map(|p| p.uncovered_m);
            let _ = writeln!(
                text,
                "shapes   {shapes} convex ones of {} pieces; no vertex farther than {:.3} mm outside",
                self.collision.len(),
                off.fold(0.0, f64::max) * 1e3
            );
        }
    }
}

/// The files that the options name.
pub fn paths(options: &SkinOptions) -> Vec<PathBuf> {
    options.collision.iter().cloned().collect()
}

/// Makes and writes what the options ask for.
pub fn write(
    made: &mut SkinnedFilm,
    options: &SkinOptions,
    progress: &Progress,
) -> Result<Engines, Failure> {
    let mut engines = Engines::default();
    if let Some(path) = &options.collision {
        let how = ConvexOptions {
            shapes: usize::from(options.collision_shapes),
            vertices: usize::from(options.collision_vertices),
            ..ConvexOptions::default()
        };
        let made = progress
            .watch(|context| Ok::<_, FilmError>(collision(&made.film, &how, context)?))
            .map_err(failure)?;
        engines.files.extend(in_metres(&made.scene, path)?);
        engines.collision = made.pieces;
    }
    Ok(engines)
}
