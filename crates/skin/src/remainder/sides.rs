//! Beyond which end of the rods the triangles of a stem's shell lie.

use super::plane_cut::{CutLoop, CutPlane};
use greenstick_geometry::{Mesh, Unions};
use greenstick_wood::stem::Stem;

/// How far a triangle may lie off the axis, in radii, to be taken for the stem's.
const MAX_AXIS_DISTANCE: f64 = 1.6;

/// Returns, for each triangle that `own` marks, the end that it is beyond; `None` for those between the two loops. Returns
/// `None` where the loops do not split the shell.
pub(super) fn sides_of_loops(
    mesh: &Mesh,
    own: &[bool],
    loops: [&CutLoop; 2],
    planes: &[CutPlane; 2],
) -> Option<Vec<Option<usize>>> {
    let (points, count) = mesh.points();
    // A bit for each loop that a point is on.
    let mut on = vec![0u8; count];
    for (k, cut) in loops.iter().enumerate() {
        for &v in &cut.vertices {
            on[points[v as usize] as usize] |= 1 << k;
        }
    }
    let mut unions = Unions::new(own.len());
    let mut first = vec![u32::MAX; count];
    let adjacency = mesh.adjacency();
    // The triangles at each loop: those inside of it, and those outside.
    let mut at_loop: [[Vec<u32>; 2]; 2] = Default::default();
    for (t, corners) in mesh.triangles.iter().enumerate().filter(|(t, _)| own[*t]) {
        let p = corners.map(|v| points[v as usize]);
        for (k, &point) in p.iter().enumerate() {
            let next = p[(k + 1) % 3];
            let both = on[point as usize] & on[next as usize];
            let other = adjacency.neighbours[t][k];
            if both == 0 && (other as usize) < own.len() {
                unions.join(t as u32, other);
            }
            for l in (0..2).filter(|l| both & (1 << l) != 0) {
                let third = mesh.positions[corners[(k + 2) % 3] as usize];
                let outside = usize::from((planes[l].height(third) > 0.0) == (l == 1));
                at_loop[l][outside].push(t as u32);
            }
            if on[point as usize] == 0 {
                let known = &mut first[point as usize];
                if *known == u32::MAX {
                    *known = t as u32;
                }
                unions.join(*known, t as u32);
            }
        }
    }
    let mut roots = |triangles: &[u32]| {
        let mut roots: Vec<u32> = triangles.iter().map(|&t| unions.root(t)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots
    };
    let inside = roots(&at_loop[0][0]);
    let beyond = [roots(&at_loop[0][1]), roots(&at_loop[1][1])];
    let mixed = beyond.iter().flatten().any(|r| inside.contains(r));
    if inside.len() != 1 || mixed || roots(&at_loop[1][0]) != inside {
        return None;
    }
    let side = |t: usize| {
        let root = unions.root(t as u32);
        (0..2).find(|&k| own[t] && beyond[k].contains(&root))
    };
    Some((0..own.len()).map(side).collect())
}

/// Returns the same by the position of the triangles, for meshes that cannot be cut. The rods lie in `range` along the axis,
/// m.
pub(super) fn sides_by_position(
    mesh: &Mesh,
    own: &[bool],
    stem: &Stem,
    range: [f64; 2],
) -> Vec<Option<usize>> {
    let axis = stem.grain.axis();
    let middle = 0.5 * (range[0] + range[1]);
    (0..own.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            let p = (a + b + c) / 3.0;
            let s = axis.length_at(p);
            let distance = axis.frame(s).origin.distance(p);
            let within = s >= range[0] && s <= range[1];
            let filled = within && distance < MAX_AXIS_DISTANCE * stem.radius * stem.grain.scale(s);
            (own[t] && !filled).then(|| usize::from(s > middle))
        })
        .collect()
}
