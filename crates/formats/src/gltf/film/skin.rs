//! Which joints the vertices of a piece follow in the file: at most so many in a skin and for a vertex (§3.7.3.3).

use super::merge::{Shares, merge};
use crate::film::Reduction;
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Film, SkinnedMesh};

/// What a piece follows.
pub enum Follow {
    /// One joint of the film.
    One(u32),
    /// Several.
    Skin(Skin),
}

/// A piece's binding as it is written.
pub struct Skin {
    /// Joints of the film that it names.
    pub joints: Vec<u32>,
    starts: Vec<u32>,
    slots: Vec<u16>,
    weights: Vec<f32>,
    /// Most influences of a vertex.
    pub influences: usize,
}

impl Skin {
    /// Place in [`Self::joints`] and weight of what a vertex follows, the heaviest first.
    pub fn of(&self, vertex: usize) -> impl Iterator<Item = (u16, f32)> + '_ {
        let range = self.starts[vertex] as usize..self.starts[vertex + 1] as usize;
        range.map(|k| (self.slots[k], self.weights[k]))
    }
}

/// A piece with the binding that is written, and how that differs from the film's.
pub struct Bound {
    /// What it follows in the file.
    pub follow: Follow,
    /// What was lost, where something was.
    pub reduction: Option<Reduction>,
}

/// Most joints of a skin, and of a vertex.
#[derive(Clone, Copy)]
pub struct Limits {
    pub joints: usize,
    pub influences: usize,
}

/// Binds piece number `number`. `samples` are the joints' maps in some frames, by which joints are compared where there
/// are too many.
pub fn bind(film: &Film, number: usize, limits: Limits, samples: &[Vec<DAffine3>]) -> Bound {
    let piece = &film.pieces[number];
    let used = piece.binding.used_joints();
    let stands_for: Vec<Shares> = if used.len() > limits.joints {
        merge(piece, &used, limits.joints, samples)
    } else {
        (0..used.len()).map(|k| [(k, 1.0), (k, 0.0)]).collect()
    };
    let shares = stands_for.iter().flatten();
    let mut kept: Vec<usize> = shares.filter(|s| s.1 > 0.0).map(|s| s.0).collect();
    kept.sort_unstable();
    kept.dedup();
    let mut slot_of = vec![0_u16; used.len()];
    for (slot, &k) in kept.iter().enumerate() {
        slot_of[k] = slot as u16;
    }
    let (skin, capped) = entries(piece, &used, &stands_for, &slot_of, limits.influences);
    let joints: Vec<u32> = kept.iter().map(|&k| used[k]).collect();
    let reduction = (kept.len() < used.len() || capped > 0).then(|| Reduction {
        piece: number,
        name: piece.name.clone(),
        joints: [used.len(), kept.len()],
        capped,
        error: 0.0,
        frame: 0,
    });
    let follow = match joints.as_slice() {
        [one] => Follow::One(*one),
        _ => Follow::Skin(Skin { joints, ..skin }),
    };
    Bound { follow, reduction }
}

/// The entries of all vertices, and how many vertices lost some.
fn entries(
    piece: &SkinnedMesh,
    used: &[u32],
    stands_for: &[Shares],
    slot_of: &[u16],
    most: usize,
) -> (Skin, usize) {
    let mut skin = Skin {
        joints: Vec::new(),
        starts: vec![0],
        slots: Vec::new(),
        weights: Vec::new(),
        influences: 0,
    };
    let mut capped = 0;
    let mut own: Vec<(u16, f64)> = Vec::new();
    for v in 0..piece.binding.vertices() {
        own.clear();
        for (joint, weight) in piece.binding.influences(v).filter(|e| e.1 != 0.0) {
            let Ok(k) = used.binary_search(&joint) else {
                continue;
            };
            for (other, share) in stands_for[k].into_iter().filter(|s| s.1 > 0.0) {
                let slot = slot_of[other];
                match own.iter_mut().find(|e| e.0 == slot) {
                    Some(entry) => entry.1 += weight * share,
                    None => own.push((slot, weight * share)),
                }
            }
        }
        own.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        if own.len() > most {
            capped += 1;
            own.truncate(most);
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
        // What rounding to 32 bits took goes to the heaviest, so that the sum is 1.
        let written: f64 = skin.weights[first..].iter().map(|&w| f64::from(w)).sum();
        if let Some(heaviest) = skin.weights.get_mut(first) {
            *heaviest = (f64::from(*heaviest) + 1.0 - written) as f32;
        }
        skin.influences = skin.influences.max(skin.weights.len() - first);
        skin.starts.push(skin.weights.len() as u32);
    }
    (skin, capped)
}

/// Compares what is written with what should be, in a frame with these maps; where it is worse than before, the reduction
/// says so.
pub fn measure(film: &Film, bound: &mut Bound, maps: &[DAffine3], frame: usize) {
    let Some(reduction) = &mut bound.reduction else {
        return;
    };
    let piece = &film.pieces[reduction.piece];
    for (v, &p) in piece.mesh.positions.iter().enumerate() {
        let place =
            |sum: DVec3, (joint, w): (u32, f64)| sum + maps[joint as usize].transform_point3(p) * w;
        let right = piece.binding.influences(v).fold(DVec3::ZERO, place);
        let written = match &bound.follow {
            Follow::One(joint) => maps[*joint as usize].transform_point3(p),
            Follow::Skin(skin) => skin
                .of(v)
                .map(|(slot, w)| (skin.joints[usize::from(slot)], f64::from(w)))
                .fold(DVec3::ZERO, place),
        };
        let error = right.distance(written);
        if error > reduction.error {
            (reduction.error, reduction.frame) = (error, frame);
        }
    }
}
