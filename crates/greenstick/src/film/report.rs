//! What a skin is made of, and how far a film strays from what it shows.

use super::FilmError;
use greenstick_fibre::store::FrameFile;
use greenstick_geometry::film::Extra;
use greenstick_geometry::{Context, Film, Motion, Pose};
use greenstick_skin::rods::RodSkin;
use serde::Serialize;
use std::fmt;
use std::io::{Read, Seek};
use std::ops::Range;

/// A piece.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilmPiece {
    /// Its name.
    pub name: String,
    /// Rods that it has a part of.
    pub rods: usize,
    /// Volume at rest, m³.
    pub volume_m3: f64,
    /// Vertices and triangles.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
}

/// What was made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SkinReport {
    /// Number of frames, the first one, and times of the first and last, s.
    pub frames: usize,
    /// The first frame, of the run's.
    pub first_frame: usize,
    /// Times of the first and the last, s.
    pub time_s: [f64; 2],
    /// Bytes behind the last whole frame: the run was cut short where there are any.
    pub bytes_left: u64,
    /// Joints.
    pub joints: usize,
    /// Edges and vertices in which several sheets of skin met, and were parted.
    pub parted: [usize; 2],
    /// The pieces, the one with the most wood first.
    pub pieces: Vec<FilmPiece>,
    /// Largest distance between two joints of one broken vertex before it breaks, m, none in a still.
    pub largest_move_m: Option<f64>,
}

impl SkinReport {
    pub(super) fn of<R: Read + Seek>(
        skin: &RodSkin,
        frames: &FrameFile<R>,
        range: Range<usize>,
    ) -> Self {
        let pieces = skin
            .pieces
            .iter()
            .zip(&skin.rods)
            .map(|(p, &rods)| FilmPiece {
                name: p.name.clone(),
                rods,
                volume_m3: match p.extras.get("volume_m3") {
                    Some(Extra::Number(v)) => *v,
                    _ => p.mesh.volume(),
                },
                vertices: p.mesh.positions.len(),
                triangles: p.mesh.triangles.len(),
            });
        SkinReport {
            frames: range.len(),
            first_frame: range.start,
            time_s: [frames.time(range.start), frames.time(range.end - 1)],
            bytes_left: frames.left(),
            joints: skin.joints.count(),
            parted: [skin.mended.0, skin.mended.1],
            pieces: pieces.collect(),
            largest_move_m: None,
        }
    }

    /// Follows the film once, to see that every frame can be had and how far anything moves.
    pub(super) fn follow<M: Motion<Error = FilmError>>(
        &mut self,
        film: &Film,
        motion: &mut M,
        context: &Context,
    ) -> Result<(), FilmError> {
        let mut poses = vec![Pose::IDENTITY; film.joints.len()];
        let mut most = 0.0f64;
        for frame in 0..motion.frames() {
            context.step("skin", frame as f64 / motion.frames() as f64)?;
            motion.poses(frame, &mut poses)?;
            for (joint, pose) in film.joints.iter().zip(&poses) {
                most = most.max(joint.rest.translation.distance(pose.translation));
            }
        }
        self.largest_move_m = Some(most);
        Ok(())
    }
}

impl fmt::Display for SkinReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count =
            |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let vertices: usize = self.pieces.iter().map(|p| p.vertices).sum();
        let triangles: usize = self.pieces.iter().map(|p| p.triangles).sum();
        writeln!(
            f,
            "frames   {} from {:.3} to {:.3} s",
            self.frames, self.time_s[0], self.time_s[1]
        )?;
        if self.bytes_left > 0 {
            writeln!(
                f,
                "note     the run was cut short: {} bytes behind its last whole frame are left out",
                self.bytes_left
            )?;
        }
        writeln!(
            f,
            "skin     {}, {}, {vertices} vertices, {triangles} triangles",
            count(self.pieces.len(), "piece", "pieces"),
            count(self.joints, "joint", "joints"),
        )?;
        const SHOWN: usize = 5;
        for piece in self.pieces.iter().take(SHOWN) {
            writeln!(
                f,
                "piece    {}: {}, {:.2} cm³",
                piece.name,
                count(piece.rods, "rod", "rods"),
                piece.volume_m3 * 1e6
            )?;
        }
        if self.pieces.len() > SHOWN {
            writeln!(f, "piece    and {} smaller ones", self.pieces.len() - SHOWN)?;
        }
        Ok(())
    }
}
