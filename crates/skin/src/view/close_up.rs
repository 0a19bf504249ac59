//! What a close-up of a frame shows.

use super::wood::{self, SPLINTER_SHARE};
use glam::DVec3;
use greenstick_geometry::{Node, Scene};

/// Distance of a piece's faces from the middle of all of them, over the radius that is shown, from which on the pieces are too far from
/// each other to be shown in one.
const APART: f64 = 0.7;
/// Length of stem (radii) to both sides of the middle of all faces in which those of a piece count: sawn ends are of the same wood.
const FACE: f64 = 2.0;

/// Returns centre and radius (m) of what a close-up of `diameters` diameters of a stem shows, as [`super::close_up`]; of pieces that have
/// come so far apart that it would show what is between them, the face of the largest one.
pub fn close_up_of_frame(scene: &Scene, inner: &[u32], diameters: f64) -> Option<(DVec3, f64)> {
    let (centre, radius) = wood::close_up(scene, inner, diameters)?;
    let stem_radius = radius / diameters;
    let pieces: Vec<(f64, Vec<FacePart>)> = (scene.nodes.iter())
        .filter(|node| !node.is_detail)
        .map(|node| (node.mesh.volume(), parts_of_faces(node, inner)))
        .collect();
    let all = || pieces.iter().flat_map(|piece| &piece.1);
    let area: f64 = all().map(|part| part.area).sum();
    let along = all().map(|part| part.along * part.area).sum::<f64>() / area;
    let pieces = pieces
        .iter()
        .filter_map(|(volume, parts)| Some((*volume, middle(parts, along, FACE * stem_radius)?)));
    let pieces: Vec<(f64, DVec3)> = pieces.collect();
    let whole: f64 = pieces.iter().map(|piece| piece.0).sum();
    let is_far = |&(volume, at): &(f64, DVec3)| {
        volume > SPLINTER_SHARE * whole && at.distance(centre) > APART * radius
    };
    let largest = pieces.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let at = largest.filter(|_| pieces.iter().any(is_far));
    Some((at.map_or(centre, |piece| piece.1), radius))
}

/// A triangle of a face.
struct FacePart {
    /// Its place along the grain, m.
    along: f64,
    /// Twice its area, m².
    area: f64,
    middle: DVec3,
}

/// The triangles of the wood inside that a piece shows.
fn parts_of_faces(node: &Node, inner: &[u32]) -> Vec<FacePart> {
    let mesh = &node.mesh;
    let Some(grain) = mesh.attributes.get("_GRAIN").filter(|g| g.width == 3) else {
        return Vec::new();
    };
    let inside = (0..mesh.triangles.len()).filter(|&t| inner.contains(&mesh.material(t)));
    let part = |t: usize| {
        let corners = mesh.corners(t);
        let [a, b, c] = corners.map(|p| node.transform.transform_point3(p));
        let along = mesh.triangles[t].map(|v| f64::from(grain.data[3 * v as usize + 2]));
        FacePart {
            along: along.iter().sum::<f64>() / 3.0,
            area: (b - a).cross(c - a).length(),
            middle: (a + b + c) / 3.0,
        }
    };
    inside.map(part).collect()
}

/// The middle of those parts that are no farther than `reach` (m) from a place along the grain, m, or of all where there are none.
fn middle(parts: &[FacePart], along: f64, reach: f64) -> Option<DVec3> {
    let mean = |reach: f64| {
        let near = || parts.iter().filter(|p| (p.along - along).abs() <= reach);
        let area: f64 = near().map(|p| p.area).sum();
        (area > 0.0).then(|| near().map(|p| p.middle * p.area).sum::<DVec3>() / area)
    };
    mean(reach).or_else(|| mean(f64::INFINITY))
}
