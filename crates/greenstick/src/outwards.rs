//! Triangles that face inwards, as scanners and mirrored nodes leave them, turned over before a stem is cut: what is
//! inside of a skin is told by the side on which it faces.

use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::{Mesh, Node};
use greenstick_wood::stem::FoundStem;

/// Puts a mirrored node's mesh into the world, so that its triangles face there as the file means them to.
pub(crate) fn unmirror(node: &mut Node) {
    if node.transform.matrix3.determinant() < 0.0 {
        node.mesh = node.mesh.transformed(&node.transform).into();
        node.transform = DAffine3::IDENTITY;
    }
}

/// Turns the shell of a stem over where its skin faces inwards. `points` are those of the mesh's vertices and `grain`
/// their grain coordinates.
pub(crate) fn turn_outwards(
    mesh: &mut Mesh,
    points: &[u32],
    grain: &[DVec3],
    found: &mut FoundStem,
) {
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| grain[points[v as usize] as usize]);
    // What is off the middle of the limb flows out through its skin alone, as sections across it let nothing of it
    // through: twice the volume, with its sign, of an open tube, too.
    let count = 3 * found.limb.len().max(1);
    let flat = |p: DVec3| p.truncate();
    let middle: DVec2 = found
        .limb
        .iter()
        .flat_map(|&t| corners(t))
        .map(flat)
        .sum::<DVec2>()
        / count as f64;
    let flow: f64 = found
        .limb
        .iter()
        .map(|&t| {
            let [a, b, c] = corners(t);
            let off = flat(a + b + c) / 3.0 - middle;
            off.dot(flat((b - a).cross(c - a)))
        })
        .sum();
    if flow >= 0.0 || !flow.is_finite() {
        return;
    }
    for &t in &found.shell {
        mesh.triangles[t as usize].swap(1, 2);
    }
    turn_normals(mesh, &found.shell);
    found.notes.push(format!(
        "the mesh was inside out: {} triangles were turned over",
        found.shell.len()
    ));
}

/// Turns the normals of a shell's vertices where they, too, point inwards.
fn turn_normals(mesh: &mut Mesh, shell: &[u32]) {
    let Some(normals) = mesh.attributes.get("NORMAL").filter(|n| n.width >= 3) else {
        return;
    };
    let normal = |v: u32| {
        let n = normals.at(v as usize);
        DVec3::new(n[0].into(), n[1].into(), n[2].into())
    };
    let agreement: f64 = shell
        .iter()
        .map(|&t| {
            let [a, b, c] = mesh.corners(t as usize);
            let sum: DVec3 = mesh.triangles[t as usize].map(normal).into_iter().sum();
            (b - a).cross(c - a).dot(sum)
        })
        .sum();
    if agreement >= 0.0 {
        return;
    }
    let mut own = vec![false; mesh.positions.len()];
    for &t in shell {
        mesh.triangles[t as usize]
            .iter()
            .for_each(|&v| own[v as usize] = true);
    }
    if let Some(normals) = mesh.attributes.get_mut("NORMAL") {
        let width = normals.width;
        for (n, _) in (normals.data.chunks_exact_mut(width).zip(&own)).filter(|n| *n.1) {
            n[..3].iter_mut().for_each(|x| *x = -*x);
        }
    }
}
