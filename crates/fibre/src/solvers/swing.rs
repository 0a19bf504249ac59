//! How far a Newton step goes: no edge is turned or stretched by more than a part of its length, as beyond a fold its bending
//! energy is singular. What nothing joins to the rest is limited by itself, so that one splinter that flies off holds up
//! nothing else.

use super::sections::live_bonds;
use crate::bundle::Bundle;
use glam::DVec3;
use greenstick_geometry::Unions;

/// Most that a step swings an edge, in its lengths.
const SWING: f64 = 0.5;

/// Shortens `step`, of `block` freedoms a vertex, where it swings an edge too far, and leaves of `prescribed` what clamps
/// still have before them. What clamps hold goes all the way if the step is the last. Whether anything was shortened.
pub(super) fn shorten(
    bundle: &Bundle,
    block: usize,
    last: bool,
    step: &mut [f64],
    prescribed: &mut [f64],
) -> bool {
    let n = bundle.vertices();
    let place = |v: usize| DVec3::from_slice(&step[v * block..]);
    let swing = |v: usize| {
        if !bundle.is_edge(v) {
            return 0.0;
        }
        (place(v + 1) - place(v)).length() / bundle.rest_length[v]
    };
    let swings: Vec<f64> = (0..n).map(swing).collect();
    if swings.iter().all(|s| *s <= SWING) {
        prescribed.fill(0.0);
        return false;
    }
    let mut pieces = Unions::new(n);
    for v in (0..n).filter(|&v| bundle.is_edge(v)) {
        pieces.join(v as u32, v as u32 + 1);
    }
    for (v, e) in live_bonds(bundle) {
        pieces.join(v as u32, e as u32);
    }
    let piece: Vec<usize> = (0..n as u32).map(|v| pieces.root(v) as usize).collect();
    let (mut worst, mut clamped) = (vec![0.0f64; n], vec![false; n]);
    for v in 0..n {
        worst[piece[v]] = worst[piece[v]].max(swings[v]);
        clamped[piece[v]] |= prescribed[v * block..][..block].iter().any(|d| *d != 0.0);
    }
    for v in 0..n {
        let p = piece[v];
        let part = if worst[p] > SWING && !(last && clamped[p]) {
            SWING / worst[p]
        } else {
            1.0
        };
        for f in v * block..(v + 1) * block {
            step[f] *= part;
            prescribed[f] *= 1.0 - part;
        }
    }
    true
}
