//! The joints that the vertices of a piece follow in the file, with limits for a skin and for a vertex (§3.7.3.3).

use super::merge::{Blend, merge};
use crate::film::Reduction;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Film, SkinnedMesh};

/// What a piece follows.
pub(super) enum Target {
    /// A single joint of the film.
    Joint(u32),
    /// Several joints.
    Skin(Skin),
}

/// The binding of a piece as it is written.
pub(super) struct Skin {
    /// Joints of the film that it refers to.
    pub joints: Vec<u32>,
    starts: Vec<u32>,
    slots: Vec<u16>,
    weights: Vec<f32>,
    /// Largest number of joints that a vertex follows.
    pub max_influences: usize,
}

impl Skin {
    /// The joints that a vertex follows, as indices into [`Self::joints`] with weights, the largest weight first.
    pub fn influences(&self, vertex: usize) -> impl Iterator<Item = (u16, f32)> + '_ {
        let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
        range.map(|k| (self.slots[k], self.weights[k]))
    }
}

/// A piece with the binding that is written.
pub(super) struct BoundPiece {
    /// Number of the piece.
    pub piece: usize,
    /// What it follows in the file.
    pub target: Target,
    /// How the binding differs from that of the film, if it does.
    pub reduction: Option<Reduction>,
}

/// Most joints of a skin and of a vertex.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    pub joints: usize,
    pub influences: usize,
}

/// Binds piece number `number`. `samples` are the maps of the joints in some frames, by which joints are compared if there
/// are too many.
pub(super) fn bind(
    film: &Film,
    number: usize,
    limits: Limits,
    samples: &[Vec<DAffine3>],
) -> BoundPiece {
    let piece = &film.pieces[number];
    let used = piece.binding.used_joints();
    let blends: Vec<Blend> = if used.len() > limits.joints {
        merge(piece, &used, limits.joints, samples)
    } else {
        (0..used.len()).map(|k| [(k, 1.0), (k, 0.0)]).collect()
    };
    let parts = blends.iter().flatten();
    let mut kept: Vec<usize> = parts.filter(|s| s.1 > 0.0).map(|s| s.0).collect();
    kept.sort_unstable();
    kept.dedup();
    let mut slot_of = vec![0_u16; used.len()];
    for (slot, &k) in kept.iter().enumerate() {
        slot_of[k] = slot as u16;
    }
    let (skin, capped) = limited_skin(piece, &used, &blends, &slot_of, limits.influences);
    let joints: Vec<u32> = kept.iter().map(|&k| used[k]).collect();
    let reduction = (kept.len() < used.len() || capped > 0).then(|| Reduction {
        piece: number,
        name: piece.name.clone(),
        joints: [used.len(), kept.len()],
        capped,
        error: 0.0,
        frame: 0,
    });
    let target = match joints.as_slice() {
        [joint] => Target::Joint(*joint),
        _ => Target::Skin(Skin { joints, ..skin }),
    };
    BoundPiece {
        piece: number,
        target,
        reduction,
    }
}

/// Builds a skin without joints. Also returns the number of vertices that lost influences.
fn limited_skin(
    piece: &SkinnedMesh,
    used: &[u32],
    blends: &[Blend],
    slot_of: &[u16],
    max_influences: usize,
) -> (Skin, usize) {
    let mut skin = Skin {
        joints: Vec::new(),
        starts: vec![0],
        slots: Vec::new(),
        weights: Vec::new(),
        max_influences: 0,
    };
    let mut capped = 0;
    let mut own: Vec<(u16, f64)> = Vec::new();
    for v in 0..piece.binding.vertices() {
        own.clear();
        for (joint, weight) in piece.binding.influences(v).filter(|e| e.1 != 0.0) {
            let Ok(k) = used.binary_search(&joint) else {
                continue;
            };
            for (other, share) in blends[k].into_iter().filter(|s| s.1 > 0.0) {
                let slot = slot_of[other];
                match own.iter_mut().find(|e| e.0 == slot) {
                    Some(entry) => entry.1 += weight * share,
                    None => own.push((slot, weight * share)),
                }
            }
        }
        own.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        if own.len() > max_influences {
            capped += 1;
            own.truncate(max_influences);
        }
        let sum: f64 = own.iter().map(|e| e.1).sum();
        let first = skin.weights.len();
        for &(slot, weight) in &own {
            let weight = (weight / sum) as f32;
            if weight > 0.0 {
                skin.slots.push(slot);
                skin.weights.push(weight);
            }
        }
        // The rounding error of single precision goes to the largest weight, so that the sum is 1.
        let written: f64 = skin.weights[first..].iter().map(|&w| f64::from(w)).sum();
        if let Some(largest) = skin.weights.get_mut(first) {
            *largest = (f64::from(*largest) + 1.0 - written) as f32;
        }
        skin.max_influences = skin.max_influences.max(skin.weights.len() - first);
        skin.starts.push(skin.weights.len() as u32);
    }
    (skin, capped)
}

/// Compares the positions of vertices as written with those of the film, in a frame with the given maps. The reduction
/// records the largest error.
pub(super) fn measure(film: &Film, bound: &mut BoundPiece, maps: &[DAffine3], frame: usize) {
    let Some(reduction) = &mut bound.reduction else {
        return;
    };
    let piece = &film.pieces[reduction.piece];
    for (v, &p) in piece.mesh.positions.iter().enumerate() {
        let add =
            |sum: DVec3, (joint, w): (u32, f64)| sum + maps[joint as usize].transform_point3(p) * w;
        let exact = piece.binding.influences(v).fold(DVec3::ZERO, add);
        let written = match &bound.target {
            Target::Joint(joint) => maps[*joint as usize].transform_point3(p),
            Target::Skin(skin) => skin
                .influences(v)
                .map(|(slot, w)| (skin.joints[usize::from(slot)], f64::from(w)))
                .fold(DVec3::ZERO, add),
        };
        let error = exact.distance(written);
        if error > reduction.error {
            (reduction.error, reduction.frame) = (error, frame);
        }
    }
}
