//! Vertices on both sides of a face, and how far they gape before it opens there.

use super::rod_faces::RodFaces;
use crate::film::error::FilmError;
use crate::film::motion::RunMotion;
use crate::film::report::GapeReport;
use crate::rods::BreakHistory;
use glam::DVec3;
use greenstick_geometry::{Film, Mesh, Motion, Pose};
use std::collections::BTreeMap;

/// A vertex of one piece and one of the next that are in the same place at rest.
pub(super) struct FacePair {
    /// The pieces.
    pub pieces: [usize; 2],
    /// Their vertices.
    pub vertices: [u32; 2],
    /// The first frame in which the rod there is broken.
    pub until: u32,
}

/// What points have in common that are in the same place.
fn place_key(p: DVec3) -> [u64; 3] {
    // Zero has two signs.
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// Returns the pairs of vertices of `lower` and `upper`, in the stem's world, that a face separated. `rod_at` gives the rod at
/// a vertex of the lower one.
pub(super) fn face_pairs(
    (face, meshes): (usize, [&Mesh; 2]),
    faces: &RodFaces,
    history: &BreakHistory,
    rod_at: impl Fn(DVec3) -> usize,
) -> Vec<FacePair> {
    let mut places: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
    for (v, p) in meshes[1].positions.iter().enumerate() {
        places.entry(place_key(*p)).or_default().push(v as u32);
    }
    let mut pairs = Vec::new();
    let mut until: BTreeMap<usize, u32> = BTreeMap::new();
    for (v, &p) in meshes[0].positions.iter().enumerate() {
        for &other in places.get(&place_key(p)).into_iter().flatten() {
            let rod = rod_at(p);
            let until = *until.entry(rod).or_insert_with(|| {
                let vertex = faces.broken_vertex(face, rod);
                vertex.map_or(u32::MAX, |v| history.break_frame(v))
            });
            pairs.push(FacePair {
                pieces: [face, face + 1],
                vertices: [v as u32, other],
                until,
            });
        }
    }
    pairs
}

/// Measures how far pairs gape whose rod is whole. Those that are farther apart than rods lie (`spacing`, m) count as open
/// from then on: the wood is split along the rod. `times` are those of the run's frames, s. Returns the greatest distance for each piece, m, and of all.
pub(super) fn measure_gape(
    film: &Film,
    motion: &mut RunMotion,
    mut pairs: Vec<FacePair>,
    times: &[f64],
    spacing: f64,
) -> Result<(Vec<f64>, Option<GapeReport>), FilmError> {
    let mut gapes = vec![0.0; film.pieces.len()];
    let mut widest: Option<GapeReport> = None;
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let mut maps = Vec::new();
    for (frame, &time) in times.iter().enumerate() {
        motion.poses(frame, &mut poses)?;
        film.joint_maps(&poses, &mut maps);
        let place = |piece: usize, vertex: u32| {
            let piece = &film.pieces[piece];
            let p = piece.mesh.positions[vertex as usize];
            let moved = piece.binding.influences(vertex as usize);
            moved.fold(DVec3::ZERO, |sum, (joint, weight)| {
                sum + maps[joint as usize].transform_point3(p) * weight
            })
        };
        let closed = pairs.iter_mut().filter(|p| frame < p.until as usize);
        for pair in closed {
            let [a, b] = [0, 1].map(|side| place(pair.pieces[side], pair.vertices[side]));
            let gape = a.distance(b);
            if gape > spacing {
                pair.until = frame as u32;
                continue;
            }
            for piece in pair.pieces {
                gapes[piece] = f64::max(gapes[piece], gape);
            }
            if gape > widest.map_or(0.0, |w| w.gape_m) {
                widest = Some(GapeReport {
                    gape_m: gape,
                    of_spacing: gape / spacing,
                    time_s: time,
                });
            }
        }
    }
    Ok((gapes, widest))
}
