//! What game engines want beside a film: collision shapes, levels of detail, vertex animation textures.

use super::outputs::{ending, in_folder, in_metres};
use super::plan::FilmPlan;
use crate::break_files::check_png;
use crate::failure::Failure;
use greenstick::files::{Batch, Output};
use greenstick::film::FilmError;
use greenstick::formats::film::{VertexTexture, write_glb, write_vertex_texture};
use greenstick::geometry::{Context, Stage};
use greenstick::skin::film::{CollisionPiece, LevelReport, SkinnedFilm, collision, level};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What was made, and the files with their sizes.
#[derive(Default, Serialize)]
pub struct Engines {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    collision: Vec<CollisionPiece>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    levels: Vec<LevelReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertex_texture: Option<VertexTexture>,
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
        for level in &self.levels {
            let [before, after] = level.triangles;
            // Seams and borders hold the others.
            let short = after as f64 > 1.01 * level.share * before as f64;
            let _ = writeln!(
                text,
                "level    {after} of {before} triangles{}; no vertex farther than {:.3} mm off, at rest and in a few frames",
                if short { ", no others could go" } else { "" },
                level.error_m * 1e3
            );
        }
        if let Some(about) = &self.vertex_texture {
            let _ = writeln!(
                text,
                "vertices {} in {} × {} pixels, {} rows a frame; at most {:.4} mm off along each axis",
                about.vertices,
                about.width,
                about.height,
                about.rows_per_frame,
                about.error() * 1e3
            );
        }
    }
}

/// The files that the plan has beside the film, whose own name they are checked with.
pub fn paths(plan: &FilmPlan, film: &Path) -> Result<Vec<PathBuf>, Failure> {
    let engines = &plan.engines;
    let collision = engines.collision.iter().map(|c| c.0.clone());
    let mut paths: Vec<PathBuf> = collision.collect();
    if !engines.levels.is_empty() && ending(film) != "glb" {
        return Err(
            Failure::request(format!("{}: has no levels of detail", film.display()))
                .hint("they are made of a .glb, such as -o film.glb"),
        );
    }
    paths.extend((1..=engines.levels.len()).map(|number| level_path(film, number)));
    if let Some((path, _)) = &engines.vertex_texture {
        check_png(path)?;
        paths.push(path.clone());
        let beside = ["normals.png", "json", "glb"];
        paths.extend(beside.map(|ending| path.with_extension(ending)));
    }
    Ok(paths)
}

fn level_path(film: &Path, number: usize) -> PathBuf {
    let stem = film
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    film.with_file_name(format!("{stem}_lod{number}.glb"))
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |n| n.to_string_lossy().into_owned())
}

/// Makes what the plan has beside the film in file `film`, and writes it with all else of the batch.
pub fn write(
    made: &mut SkinnedFilm,
    plan: &FilmPlan,
    film: &Path,
    batch: &mut Batch,
    context: &Context,
) -> Result<Engines, Failure> {
    let mut engines = Engines::default();
    let [hulls, levels, vertices] = context.split([
        (
            Stage::new("collision shapes"),
            on(plan.engines.collision.is_some()),
        ),
        (
            Stage::new("levels of detail"),
            on(!plan.engines.levels.is_empty()),
        ),
        (
            Stage::new("vertex texture"),
            on(plan.engines.vertex_texture.is_some()),
        ),
    ]);
    if let Some((path, options)) = &plan.engines.collision {
        let collision = collision(&made.film, options, &hulls)?;
        let written = in_metres(&collision.scene, path, batch)?;
        engines.files.extend(written);
        engines.collision = collision.pieces;
    }
    for (number, &share) in plan.engines.levels.iter().enumerate() {
        let path = level_path(film, number + 1);
        let name = name_of(&path);
        let context = levels.item(number, plan.engines.levels.len());
        let (simpler, report) = level(made, share, &context).map_err(Failure::from)?;
        let motion = &mut made.motion;
        let glb = &plan.glb;
        let (report, bytes) = batch
            .stream(&path, |file| -> Result<_, FilmError> {
                let written = write_glb(&simpler, motion, &name, glb, file, &context)?;
                Ok((report, written.bytes as usize))
            })
            .map_err(Failure::from)?;
        engines.levels.push(report);
        engines.files.push((path.display().to_string(), bytes));
    }
    if let Some((path, width)) = &plan.engines.vertex_texture {
        let (film, motion) = (&made.film, &mut made.motion);
        let name = name_of(path);
        let (about, encoded) = write_vertex_texture(film, motion, &name, *width, &vertices)
            .map_err(|error| Failure::from(FilmError::from(error)))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let outputs: Vec<_> = encoded.into_iter().map(|f| in_folder(folder, f)).collect();
        outputs.iter().try_for_each(|output| batch.add(output))?;
        let entry = |o: &Output| (o.path.display().to_string(), o.bytes.len());
        engines.files.extend(outputs.iter().map(entry));
        engines.vertex_texture = Some(about);
    }
    Ok(engines)
}

/// Returns the weight of a stage: 1 if it is requested, otherwise 0.
fn on(requested: bool) -> f64 {
    f64::from(u8::from(requested))
}
