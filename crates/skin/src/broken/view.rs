//! What a picture of a break shows: both faces and a stub of stem behind each.

use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::Node;
use greenstick_wood::stem::{Frame, Stem};

/// Length of stem that is shown behind each face: in radii, and as a part of the face's height.
const STUB_RADII: f64 = 0.9;
const STUB_HEIGHT: f64 = 0.08;
/// Ring coordinate from which on the face is near the skin: how far down there it reaches can be seen.
const OUTER_RING: f64 = 0.85;
/// Part of the face near the skin that lies higher than the stub's beginning.
const STUB_QUANTILE: f64 = 0.85;
/// Distance to which the opened upper piece is moved, in widths of the section.
const OPENED_DISTANCE: f64 = 1.2;

/// A break, as a picture shows it.
#[derive(Debug, Clone, Copy)]
pub struct BreakView<'a> {
    /// The stem, placed at the break.
    pub stem: &'a Stem,
    /// Material of the wood inside.
    pub material: u32,
    /// Lowest and highest point of the face, m from the location along the grain.
    pub range: [f64; 2],
    /// Side of the square that holds the section, m.
    pub width: f64,
}

/// A piece in a picture of a break.
#[derive(Debug, Clone, Copy)]
pub struct ViewedPiece<'a> {
    /// Its node where the picture shows it.
    pub node: &'a Node,
    /// Whether it lies beyond the break.
    pub is_upper: bool,
    /// Whether it is a splinter, behind which no stem is shown.
    pub is_splinter: bool,
}

impl BreakView<'_> {
    /// Returns the frame of the stem at the break.
    pub fn frame(&self) -> Frame {
        self.stem.grain.axis().frame(self.stem.location)
    }

    /// Returns the points that a picture of both faces and their stubs has to show, in the world. Before they were moved
    /// apart, all pieces had the transform `at_rest`.
    pub fn points<'a>(
        &self,
        pieces: impl Iterator<Item = ViewedPiece<'a>>,
        at_rest: &DAffine3,
    ) -> Vec<DVec3> {
        let mut points = Vec::new();
        for piece in pieces {
            let depths = self.face_depths(&piece, at_rest, &mut points);
            if !piece.is_splinter {
                points.extend(self.stub_corners(&piece, depths, at_rest));
            }
        }
        points
    }

    /// Adds the points of a piece's face that stand out beyond the location. Returns how far down the outside the break can
    /// be seen, m from the location.
    fn face_depths(
        &self,
        piece: &ViewedPiece,
        at_rest: &DAffine3,
        points: &mut Vec<DVec3>,
    ) -> Vec<f64> {
        let Frame {
            origin, tangent, ..
        } = self.frame();
        let mesh = &piece.node.mesh;
        let rings = mesh.attributes.get("_RING");
        let face = (mesh.triangles.iter().enumerate())
            .filter(|(t, _)| mesh.materials.get(*t) == Some(&self.material))
            .flat_map(|(_, corners)| corners.map(|v| v as usize));
        let mut depths = vec![0.0];
        for v in face {
            let Some(&position) = mesh.positions.get(v) else {
                continue;
            };
            let height = (at_rest.transform_point3(position) - origin).dot(tangent);
            let stands = if piece.is_upper { -height } else { height };
            if rings.is_none_or(|r| f64::from(r.at(v)[0]) > OUTER_RING) {
                depths.push(-stands);
            }
            if stands > 0.0 {
                points.push(piece.node.transform.transform_point3(position));
            }
        }
        depths
    }

    /// Returns the corners of the section where the stub of a piece ends.
    fn stub_corners(
        &self,
        piece: &ViewedPiece,
        mut depths: Vec<f64>,
        at_rest: &DAffine3,
    ) -> [DVec3; 4] {
        let [low, high] = self.range;
        let stub = STUB_RADII * self.stem.radius + STUB_HEIGHT * (high - low);
        let moved = piece.node.transform * at_rest.inverse();
        depths.sort_unstable_by(f64::total_cmp);
        let end = depths[(STUB_QUANTILE * (depths.len() - 1) as f64) as usize].max(0.0) + stub;
        let end = if piece.is_upper { end } else { -end };
        let at = self.stem.grain.axis().frame(self.stem.location + end);
        let reach = 0.5 * self.width;
        [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y]
            .map(|p| moved.transform_point3(at.origin + (at.x * p.x + at.y * p.y) * reach))
    }

    /// Returns the map that turns the upper piece over and sets it beside the lower, so that both faces look up.
    pub fn opened(&self) -> DAffine3 {
        let frame = self.frame();
        let [low, high] = self.range;
        let turn = DAffine3::from_axis_angle(frame.y, std::f64::consts::PI);
        let centre = frame.origin + frame.tangent * ((low + high) / 2.0);
        let aside = frame.x * (OPENED_DISTANCE * self.width);
        DAffine3::from_translation(centre + aside) * turn * DAffine3::from_translation(-centre)
    }
}
