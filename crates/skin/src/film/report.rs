//! Reports of stills and films: the pieces of the skin, and its deviations.

use crate::rods::{RodPart, RodSkin};
use greenstick_fibre::store::FrameTimes;
use greenstick_geometry::film::Extra;
use serde::Serialize;
use std::fmt;
use std::ops::Range;

/// Pieces that are listed one by one.
const MAX_LISTED_PIECES: usize = 5;

/// A piece.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilmPiece {
    /// Its name.
    pub name: String,
    /// Rods that it has a part of.
    pub rods: usize,
    /// Volume at rest, m³.
    pub volume_m3: f64,
    /// When it separated from every larger piece, s, and the piece it separated from; `None` where it never was part of one.
    pub parted: Option<(f64, String)>,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Greatest distance between both sides of one of its cracks before it opens, m, in a file whose weights are fixed.
    pub gape_m: f64,
}

/// A part of the input that the rods do not fill.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CarriedPiece {
    /// Its name.
    pub name: String,
    /// The input's mesh that it is of.
    pub input: String,
    /// The piece of the skin whose rods carry it; none for what hangs on nothing and stands still.
    pub carried_by: Option<String>,
    /// Number of triangles.
    pub triangles: usize,
    /// Whether it is closed; what is open in the input stays open.
    pub closed: bool,
}

/// The rest of an input.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RestReport {
    /// Its parts.
    pub pieces: Vec<CarriedPiece>,
    /// Volume of the stem's real ends beyond the rods' ends, which is left out, m³.
    pub left_out_m3: f64,
    /// What could not be done as it should, a sentence each.
    pub notes: Vec<String>,
}

/// The crack opening before the break in a film whose weights are fixed, as those of glTF are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GapeReport {
    /// Greatest distance of both sides, m.
    pub gape_m: f64,
    /// The same over the mean distance of rods.
    pub of_spacing: f64,
    /// When, s.
    pub time_s: f64,
}

/// The skin of a still or film.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SkinReport {
    /// Number of frames.
    pub frames: usize,
    /// The first frame, of the run's.
    pub first_frame: usize,
    /// Times of the first and the last, s.
    pub time_s: [f64; 2],
    /// Bytes behind the last whole frame: the run was cut short where there are any.
    pub bytes_left: u64,
    /// Joints.
    pub joints: usize,
    /// Non-manifold edges and vertices of the skin that were split.
    pub parted: [usize; 2],
    /// The crack opening before the break in a film whose weights are fixed; `None` where there is none.
    pub gape: Option<GapeReport>,
    /// Share of the surface that is not where its rods are with drawn faces, where somebody looked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub misplaced_share: Option<f64>,
    /// Why rods are shown where drawn faces would have been the choice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rods_because: Option<String>,
    /// How far pieces at rest were moved apart, where that is not as far as was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parting: Option<String>,
    /// The pieces, the one with the most wood first.
    pub pieces: Vec<FilmPiece>,
    /// What the rods do not fill, where it is carried along.
    pub rest: RestReport,
}

/// Returns the number of rods that parts belong to; those of one rod follow each other.
pub(super) fn count_rods(parts: &[(u32, RodPart)]) -> usize {
    let mut rods: Vec<u32> = parts.iter().map(|p| p.0).collect();
    rods.dedup();
    rods.len()
}

impl SkinReport {
    /// Returns the report of a skin of a range of frames.
    pub(super) fn new(skin: &RodSkin, frames: &FrameTimes, range: Range<usize>) -> Self {
        let pieces = skin
            .pieces
            .iter()
            .zip(&skin.parts)
            .map(|(p, parts)| FilmPiece {
                name: p.name.clone(),
                rods: count_rods(parts),
                parted: None,
                gape_m: 0.0,
                volume_m3: match p.extras.get("volume_m3") {
                    Some(Extra::Number(v)) => *v,
                    _ => p.mesh.volume(),
                },
                vertices: p.mesh.positions.len(),
                triangles: p.mesh.triangles.len(),
            });
        SkinReport {
            parted: [
                skin.nonmanifold_splits.edges,
                skin.nonmanifold_splits.vertices,
            ],
            ..SkinReport::of_pieces(pieces.collect(), skin.joints.count(), (frames, range))
        }
    }

    /// Returns the report of pieces that follow so many joints in a range of frames.
    pub(super) fn of_pieces(
        pieces: Vec<FilmPiece>,
        joints: usize,
        (frames, range): (&FrameTimes, Range<usize>),
    ) -> Self {
        SkinReport {
            frames: range.len(),
            first_frame: range.start,
            time_s: [frames.times[range.start], frames.times[range.end - 1]],
            bytes_left: frames.trailing_bytes,
            joints,
            parted: [0; 2],
            gape: None,
            misplaced_share: None,
            rods_because: None,
            parting: None,
            pieces,
            rest: RestReport::default(),
        }
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
                "note     the run was cut short, or its frames are damaged: {} bytes behind the last whole one are left out",
                self.bytes_left
            )?;
        }
        writeln!(
            f,
            "skin     {}, {}, {vertices} vertices, {triangles} triangles",
            count(self.pieces.len(), "piece", "pieces"),
            count(self.joints, "joint", "joints"),
        )?;
        if let Some(gape) = &self.gape {
            writeln!(
                f,
                "gape     at most {:.3} mm ({:.1} % of the rods' distance, at {:.3} s) between sides of cracks that open later, with fixed weights, as in glTF",
                gape.gape_m * 1e3,
                gape.of_spacing * 1e2,
                gape.time_s
            )?;
        }
        if let Some(reason) = &self.rods_because {
            writeln!(f, "note     shown by its rods: {reason}")?;
        }
        if let Some(note) = &self.parting {
            writeln!(f, "note     {note}")?;
        }
        for piece in self.pieces.iter().take(MAX_LISTED_PIECES) {
            writeln!(
                f,
                "piece    {}: {}, {:.2} cm³{}",
                piece.name,
                count(piece.rods, "rod", "rods"),
                piece.volume_m3 * 1e6,
                match &piece.parted {
                    Some((time, from)) => format!(", parted from {from} at {time:.3} s"),
                    None => String::new(),
                }
            )?;
        }
        if self.pieces.len() > MAX_LISTED_PIECES {
            writeln!(
                f,
                "piece    and {} smaller ones",
                self.pieces.len() - MAX_LISTED_PIECES
            )?;
        }
        self.rest.fmt(f)
    }
}

impl fmt::Display for RestReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.pieces.is_empty() {
            let still = self.pieces.iter().filter(|p| p.carried_by.is_none());
            let (still, open) = (still.count(), self.pieces.iter().filter(|p| !p.closed));
            let triangles: usize = self.pieces.iter().map(|p| p.triangles).sum();
            writeln!(
                f,
                "rest     {} parts of the input that the rods do not fill, {triangles} triangles; {still} hang on nothing \
                 and stand still, {} are open",
                self.pieces.len(),
                open.count()
            )?;
        }
        if self.left_out_m3 > 0.0 {
            writeln!(
                f,
                "note     {:.2} cm³ at the stem's ends are left out: the rods end there, and have ends of their own",
                self.left_out_m3 * 1e6
            )?;
        }
        for note in &self.notes {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}
