//! What other shells of a model are attached to, and which of them move with the upper piece of the broken stem.

use super::shells::{Shell, WeldedMesh};
use super::surface::Surface;
use glam::DVec3;
use greenstick_geometry::Unions;

/// Most points of a shell that are tested to find what it is attached to.
const MAX_SAMPLES: usize = 24;
/// A shell that is inside no other is attached to the nearest within this part of its own size.
const MAX_GAP_OVER_SIZE: f64 = 0.1;

/// A shell that others may be attached to.
pub(crate) struct Carrier<'a> {
    /// Index of the shell.
    pub shell: usize,
    pub surface: Surface<'a>,
}

/// What a shell is attached to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attachment {
    /// Index of the shell that carries it.
    pub carrier: usize,
    /// About where, m.
    pub at: DVec3,
}

/// Points that show where a shell is fixed: those of its border, or, for a closed shell, any.
fn fixing_points(mesh: &WeldedMesh, shell: &Shell) -> Vec<DVec3> {
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for &t in &shell.triangles {
        let t = mesh.triangles[t as usize];
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if a != b {
                edges.push((a.min(b), a.max(b)));
            }
        }
    }
    edges.sort_unstable();
    let mut corners: Vec<u32> = edges
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() == 1)
        .map(|same| same[0].0)
        .collect();
    if corners.is_empty() {
        corners = edges.iter().map(|e| e.0).collect();
    }
    corners.dedup();
    let count = corners.len().min(MAX_SAMPLES);
    (0..count)
        .map(|k| mesh.positions[corners[k * corners.len() / count] as usize])
        .collect()
}

/// What shell number `shell` is attached to: of the `carriers` the one that contains most of its fixing points, else the
/// nearest one that is close.
pub(crate) fn find_attachment(
    mesh: &WeldedMesh,
    shells: &[Shell],
    shell: usize,
    carriers: &[Carrier],
) -> Option<Attachment> {
    let own = &shells[shell];
    let max_gap = MAX_GAP_OVER_SIZE * own.diagonal();
    let fixed = fixing_points(mesh, own);
    let mut best: Option<(usize, f64, Attachment)> = None;
    let mut nearest: Option<(f64, Attachment)> = None;
    for Carrier {
        shell: carrier,
        surface,
    } in carriers
    {
        let carrier = *carrier;
        if carrier == shell || !shells[carrier].meets(own, max_gap) {
            continue;
        }
        let inside: Vec<DVec3> = fixed
            .iter()
            .copied()
            .filter(|&p| surface.contains(p))
            .collect();
        let size = shells[carrier].diagonal();
        if !inside.is_empty() {
            let at = inside.iter().sum::<DVec3>() / inside.len() as f64;
            if best
                .as_ref()
                .is_none_or(|b| (inside.len(), size) > (b.0, b.1))
            {
                best = Some((inside.len(), size, Attachment { carrier, at }));
            }
        }
        // Larger things are not attached to smaller ones that merely lie close.
        if best.is_none() && size > own.diagonal() {
            for &p in &fixed {
                let Some((_, q)) = surface.nearest(p) else {
                    continue;
                };
                let gap = p.distance(q);
                if gap <= max_gap && nearest.as_ref().is_none_or(|n| gap < n.0) {
                    nearest = Some((gap, Attachment { carrier, at: p }));
                }
            }
        }
    }
    best.map(|b| b.2).or(nearest.map(|n| n.1))
}

/// A plane across the stem.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutPlane {
    pub origin: DVec3,
    /// Towards the upper piece (unit).
    pub along: DVec3,
}

/// Returns for every point of the cut shell whether it lies beyond the plane: `barrier` are the triangles under the section.
/// `None` where both sides are connected another way.
pub(crate) fn upper_side(
    mesh: &WeldedMesh,
    shell: &Shell,
    barrier: &[u32],
    plane: CutPlane,
) -> Option<impl FnMut(u32) -> bool> {
    let mut sets = Unions::new(mesh.positions.len());
    let mut sorted = barrier.to_vec();
    sorted.sort_unstable();
    for &t in &shell.triangles {
        if sorted.binary_search(&t).is_err() {
            let [a, b, c] = mesh.triangles[t as usize];
            sets.join(a, b);
            sets.join(a, c);
        }
    }
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for &t in &sorted {
        for c in mesh.triangles[t as usize] {
            let root = sets.root(c);
            let high = (mesh.positions[c as usize] - plane.origin).dot(plane.along) > 0.0;
            if high {
                above.push(root)
            } else {
                below.push(root)
            }
        }
    }
    above.sort_unstable();
    if below.iter().any(|b| above.binary_search(b).is_ok()) {
        return None;
    }
    Some(move |point: u32| above.binary_search(&sets.root(point)).is_ok())
}
