//! Limits Newton steps: no edge turns or stretches by more than a fraction of its length, because the bending energy is
//! singular where a rod folds. Each connected part is limited by itself, so that one splinter that flies off does not slow
//! down the rest.

use crate::rod_bundle::RodBundle;
use glam::DVec3;
use greenstick_geometry::Unions;

/// Largest relative displacement of an edge's vertices in a step, over its length.
const MAX_EDGE_CHANGE: f64 = 0.5;

/// Shortens `step`, of `block` degrees of freedom at a vertex, where it changes an edge too much. Leaves in `prescribed` the
/// displacement of clamps that remains. Clamps move all the way in the last step. Returns the multiple of the step that could be
/// taken within the limit: 1 where anything was shortened.
pub(super) fn limit_step(
    bundle: &RodBundle,
    part: &[usize],
    block: usize,
    last: bool,
    step: &mut [f64],
    prescribed: &mut [f64],
) -> f64 {
    let n = bundle.vertices();
    let displacement = |v: usize| DVec3::from_slice(&step[v * block..]);
    let change = |v: usize| {
        if !bundle.is_edge(v) {
            return 0.0;
        }
        (displacement(v + 1) - displacement(v)).length() / bundle.rest_length[v]
    };
    let changes: Vec<f64> = (0..n).map(change).collect();
    if changes.iter().all(|s| *s <= MAX_EDGE_CHANGE) {
        prescribed.fill(0.0);
        let largest = changes.iter().copied().fold(0.0, f64::max);
        return MAX_EDGE_CHANGE / largest;
    }
    let (mut largest, mut clamped) = (vec![0.0f64; n], vec![false; n]);
    for v in 0..n {
        largest[part[v]] = largest[part[v]].max(changes[v]);
        clamped[part[v]] |= prescribed[v * block..][..block].iter().any(|d| *d != 0.0);
    }
    for v in 0..n {
        let p = part[v];
        let factor = if largest[p] > MAX_EDGE_CHANGE && !(last && clamped[p]) {
            MAX_EDGE_CHANGE / largest[p]
        } else {
            1.0
        };
        for f in v * block..(v + 1) * block {
            step[f] *= factor;
            prescribed[f] *= 1.0 - factor;
        }
    }
    1.0
}

/// Returns for each vertex the smallest vertex that edges and bonds connect with it.
pub(super) fn connected_parts(bundle: &RodBundle) -> Vec<usize> {
    let n = bundle.vertices();
    let mut parts = Unions::new(n);
    for v in (0..n).filter(|&v| bundle.is_edge(v)) {
        parts.join(v as u32, v as u32 + 1);
    }
    for (v, e) in bundle.bonds.with_stiffness() {
        parts.join(v as u32, e as u32);
    }
    (0..n as u32).map(|v| parts.root(v) as usize).collect()
}
