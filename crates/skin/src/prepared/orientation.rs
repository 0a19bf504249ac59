//! Turning triangles outwards. Scanners and mirrored nodes leave triangles that face inwards, but the side on which a
//! skin faces decides where its wood is.

use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::{Mesh, Node};
use greenstick_wood::stem::FoundStem;

/// Moves the mesh of a mirrored node into the world, so that its triangles face there as the file means them to.
pub fn unmirror(node: &mut Node) {
    if node.transform.matrix3.determinant() < 0.0 {
        node.mesh = node.mesh.transformed(&node.transform).into();
        node.transform = DAffine3::IDENTITY;
    }
}

/// Reverses the shell of a stem whose skin faces inwards. `points` are those of the mesh's vertices and `grain` their
/// grain coordinates.
pub(super) fn orient_outwards(
    mesh: &mut Mesh,
    points: &[u32],
    grain: &[DVec3],
    found: &mut FoundStem,
) {
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| grain[points[v as usize] as usize]);
    // The flow of the field (p − middle) across the grain leaves the limb through its skin alone, as it is parallel to
    // all sections across the grain: twice the volume with its sign, even of an open tube.
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
    reverse_normals(mesh, &found.shell);
    found.notes.push(format!(
        "the mesh was inside out: {} triangles were turned over",
        found.shell.len()
    ));
}

/// Reverses the normals of a shell's vertices where they, too, point inwards.
fn reverse_normals(mesh: &mut Mesh, shell: &[u32]) {
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
    let mut of_shell = vec![false; mesh.positions.len()];
    for &t in shell {
        mesh.triangles[t as usize]
            .iter()
            .for_each(|&v| of_shell[v as usize] = true);
    }
    if let Some(normals) = mesh.attributes.get_mut("NORMAL") {
        let width = normals.width;
        let pairs = normals.data.chunks_exact_mut(width).zip(&of_shell);
        for (n, _) in pairs.filter(|n| *n.1) {
            n[..3].iter_mut().for_each(|x| *x = -*x);
        }
    }
}
