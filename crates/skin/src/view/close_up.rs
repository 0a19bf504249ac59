//! What a close-up of a frame shows.

use super::wood::{self, SPLINTER_SHARE};
use glam::DVec3;
use greenstick_geometry::{Node, Scene};

/// Distance of a piece's faces from the middle of all of them, over the radius that is shown, from which on the pieces are too far from
/// each other to be shown in one.
const APART: f64 = 0.7;
/// Length of stem (radii) to both sides of the middle of all faces in which those of a piece count: sawn ends are of the same wood.
const FACE: f64 = 2.0;

/// Diameters of a stem that are shown about a break where nothing is asked for and everything is much more.
const USUAL_DIAMETERS: f64 = 9.0;
/// Distance of what is shown of everything from the middle of a break, over the radius of its close-up, from which on the break would be
/// too small to be seen.
const MUCH_WIDER: f64 = 2.0;
/// Share of the radius of a close-up that is shown of the wood about faces at the ends of their way.
const ABOUT_MOVED: f64 = 0.6;

/// Whether a close-up shows much less than everything.
fn is_much_wider(points: &[DVec3], (centre, radius): (DVec3, f64)) -> bool {
    let reach = points
        .iter()
        .map(|p| p.distance(centre))
        .fold(0.0, f64::max);
    reach > MUCH_WIDER * radius
}

/// What pictures of the frames of a film show.
#[derive(Debug, Clone, Default)]
pub struct FilmView {
    /// The outermost points of the wood and the bodies in all frames, without splinters, m.
    pub points: Vec<DVec3>,
    /// Radius of the stem, m; `None` before a frame that has faces.
    stem_radius: Option<f64>,
    /// Middles of the faces of all pieces in all frames, m.
    faces: Vec<DVec3>,
}

impl FilmView {
    /// Adds a frame. `inner` as for [`super::close_up`].
    pub fn add(&mut self, scene: &Scene, inner: &[u32]) {
        self.points.extend(wood::outermost_without_splinters(scene));
        if let Some((_, stem_radius)) = wood::close_up(scene, inner, 1.0) {
            self.stem_radius.get_or_insert(stem_radius);
            let faces = middles_of_faces(scene, inner, stem_radius);
            self.faces.extend(faces.into_iter().map(|piece| piece.1));
        }
    }

    /// Returns centre and radius (m) of a sphere in which all faces are seen in all frames, at least as large as a close-up of so many
    /// diameters of the stem. `None` for as many as suit: then there is none unless the break would be too small to be seen in a
    /// picture of everything.
    pub fn close_up(&self, diameters: Option<f64>) -> Option<(DVec3, f64)> {
        let (low, high) = corners(&self.faces)?;
        let radius = diameters.unwrap_or(USUAL_DIAMETERS) * self.stem_radius?;
        let way = 0.5 * low.distance(high);
        let near = (0.5 * (low + high), radius.max(way + ABOUT_MOVED * radius));
        (diameters.is_some() || is_much_wider(&self.points, near)).then_some(near)
    }

    /// The middle of the box about everything, m.
    pub fn middle(&self) -> Option<DVec3> {
        corners(&self.points).map(|(low, high)| 0.5 * (low + high))
    }
}

/// The least and the greatest coordinates of points.
fn corners(points: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let &first = points.first()?;
    let wider = |(low, high): (DVec3, DVec3), &p: &DVec3| (low.min(p), high.max(p));
    Some(points.iter().fold((first, first), wider))
}

/// Returns centre and radius (m) of what a close-up of `diameters` diameters of a stem shows, as [`super::close_up`]; of pieces that have
/// come so far apart that it would show what is between them, the face of the largest one.
pub fn close_up_of_frame(scene: &Scene, inner: &[u32], diameters: f64) -> Option<(DVec3, f64)> {
    let (centre, radius) = wood::close_up(scene, inner, diameters)?;
    let pieces = middles_of_faces(scene, inner, radius / diameters);
    let is_far = |&(_, at): &(f64, DVec3)| at.distance(centre) > APART * radius;
    let largest = pieces.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let at = largest.filter(|_| pieces.iter().any(is_far));
    Some((at.map_or(centre, |piece| piece.1), radius))
}

/// Volume and middle of the faces of all pieces that are no splinters and have faces near the middle of all.
fn middles_of_faces(scene: &Scene, inner: &[u32], stem_radius: f64) -> Vec<(f64, DVec3)> {
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
    let is_large = |&(volume, _): &(f64, DVec3)| volume > SPLINTER_SHARE * whole;
    pieces.into_iter().filter(is_large).collect()
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
