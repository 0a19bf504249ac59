//! What loose shells hang on: first those that touch the stem, then those that touch these, and so on.

use glam::DVec3;
use greenstick_geometry::{Aabb, Bvh, Cancelled, Context, Mesh};
use rayon::prelude::*;

/// A shell that comes this near to other wood, in radii of the stem, touches it.
const TOUCHING_DISTANCE: f64 = 0.03;
/// A shell that touches nothing hangs on wood within at least as many radii.
const FLOATING_DISTANCE: f64 = 2.0;
/// Largest number of a shell's triangles that are examined.
const MAX_EXAMINED_TRIANGLES: usize = 3000;

/// What a part hangs on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Attachment {
    /// The rods' ends where the stem begins (0), or where it ends (1).
    RodEnd(usize),
    /// The rods nearest to a point, m, in the stem's world.
    Rods(DVec3),
    /// Nothing that moves.
    Nothing,
}

/// Wood that other wood may hang on.
pub(super) struct Wood {
    mesh: Mesh,
    tree: Bvh,
    /// What each triangle hangs on; `None` for the stretch that the rods fill.
    attachments: Vec<Option<Attachment>>,
}

/// How far a shell is from wood, m, and what it would hang on there.
type Contact = (f64, Attachment);

impl Wood {
    pub fn new(mesh: Mesh, attachments: Vec<Option<Attachment>>) -> Self {
        Wood {
            tree: Bvh::from_mesh(&mesh),
            mesh,
            attachments,
        }
    }

    fn attachment(&self, triangle: usize, p: DVec3) -> Attachment {
        self.attachments[triangle].unwrap_or(Attachment::Rods(p))
    }

    /// Returns the contact nearest to some triangles of a mesh, none beyond `limit`, m.
    fn nearest_contact(&self, mesh: &Mesh, triangles: &[u32], limit: f64) -> Option<Contact> {
        let step = triangles.len().div_ceil(MAX_EXAMINED_TRIANGLES).max(1);
        let examined = || {
            let triangles = triangles.iter().step_by(step);
            triangles.map(|&t| mesh.corners(t as usize))
        };
        for corners in examined() {
            if !Aabb::around(&corners).overlaps(&self.tree.bounds()) {
                continue;
            }
            for k in 0..3 {
                let (p, to) = (corners[k], corners[(k + 1) % 3] - corners[k]);
                if let Some((t, at)) = self.tree.first_triangle(&self.mesh, p, to, 1.0) {
                    return Some((0.0, self.attachment(t, p + to * at)));
                }
            }
        }
        let mut best: Option<Contact> = None;
        for p in examined().flatten() {
            let within = best.map_or(limit, |b| b.0);
            if let Some(near) = self.tree.nearest_on_mesh(&self.mesh, p, within)
                && best.is_none_or(|b| near.distance < b.0)
            {
                best = Some((near.distance, self.attachment(near.triangle, near.point)));
            }
        }
        best
    }
}

/// Returns the largest distance at which each shell may hang on other wood, m: its size, or a few radii.
fn contact_limits(
    meshes: &[Mesh],
    loose: &[(usize, Vec<u32>)],
    trunk: &Wood,
    radius: f64,
) -> Vec<f64> {
    let size = |(mesh, triangles): &(usize, Vec<u32>)| {
        let corners = triangles
            .iter()
            .flat_map(|&t| meshes[*mesh].corners(t as usize));
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = corners.fold(none, |(l, h), p| (l.min(p), h.max(p)));
        low.distance(high)
    };
    let bounds = trunk.mesh.bounds();
    let trunk_size = bounds.map_or(0.0, |(low, high)| low.distance(high));
    let limit = |shell| (FLOATING_DISTANCE * radius).max(size(shell).min(trunk_size));
    loose.iter().map(limit).collect()
}

/// Returns what each shell, some triangles of a mesh, hangs on. A shell that touches nothing hangs on the nearest wood, where
/// that is near.
pub(super) fn attach_loose_shells(
    meshes: &[Mesh],
    loose: &[(usize, Vec<u32>)],
    trunk: Wood,
    radius: f64,
    context: &Context,
) -> Result<Vec<Attachment>, Cancelled> {
    let limits = contact_limits(meshes, loose, &trunk, radius);
    let mut best: Vec<Option<Contact>> = vec![None; loose.len()];
    let mut open: Vec<usize> = (0..loose.len()).collect();
    let mut wood = trunk;
    while !open.is_empty() {
        let found: Vec<_> = (open.par_iter())
            .map(|&i| {
                context.check()?;
                let within = best[i].map_or(limits[i], |b| b.0);
                let (mesh, triangles) = &loose[i];
                Ok(wood.nearest_contact(&meshes[*mesh], triangles, within))
            })
            .collect::<Result<_, Cancelled>>()?;
        for (&i, found) in open.iter().zip(found) {
            if let Some(found) = found.filter(|f| best[i].is_none_or(|b| f.0 < b.0)) {
                best[i] = Some(found);
            }
        }
        let touched = |i: usize| best[i].filter(|b| b.0 <= TOUCHING_DISTANCE * radius);
        let (now, later): (Vec<usize>, Vec<usize>) =
            open.iter().partition(|&&i| touched(i).is_some());
        if now.is_empty() {
            break;
        }
        let (mut mesh, mut attachments) = (Mesh::default(), Vec::new());
        for i in now {
            let Some((_, attachment)) = touched(i) else {
                continue;
            };
            let source = &meshes[loose[i].0];
            for &t in &loose[i].1 {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(source.corners(t as usize));
                mesh.triangles.push([first, first + 1, first + 2]);
                attachments.push(Some(attachment));
            }
        }
        wood = Wood::new(mesh, attachments);
        open = later;
    }
    let attachment = |best: Option<Contact>| best.map_or(Attachment::Nothing, |b| b.1);
    Ok(best.into_iter().map(attachment).collect())
}
