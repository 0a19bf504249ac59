//! What a picture of a break shows: both faces and a stub of stem behind each.

use crate::cracks::EndOfStem;
use crate::finish::{NodeRole, PieceRole};
use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::{Node, Scene};
use greenstick_wood::stem::{Frame, Stem};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Length of stem that is shown behind each face: in radii, and as a part of the face's height.
const STUB_RADII: f64 = 1.6;
const STUB_HEIGHT: f64 = 0.08;
/// Ring coordinate from which on the face is near the skin: how far down there it reaches can be seen.
const OUTER_RING: f64 = 0.85;
/// Part of the face near the skin that lies higher than the stub's beginning.
const STUB_QUANTILE: f64 = 0.85;
/// Ratio of the face's height to the section's width up to which a face is flat, and from which on it is long.
const FACE_RATIOS: (f64, f64) = (0.3, 2.0);
/// How far the lower and the upper piece of an opened break are turned towards the camera, rad, where the face is flat and where it
/// is long: splinters show from the side.
const LOWER_TURNS: (f64, f64) = (0.95, 0.5);
const UPPER_TURNS: (f64, f64) = (1.0, 0.85);
/// How much farther from the camera the upper piece lies, likewise, and the gap between the pieces, in widths of the section.
const UPPER_AWAY: (f64, f64) = (0.1, 0.9);
const GAP: f64 = 0.05;
/// How far behind the location pieces must be clear of each other, in widths of the section, and cells to the width where they are
/// compared.
const CLEAR_LENGTH: f64 = 2.0;
const CLEAR_CELLS: f64 = 16.0;
/// How steeply an opened break is looked down on, rad.
const ELEVATION: f64 = 0.5;
/// Ratio of the sides of a section from which on it is flat.
const FLAT: f64 = 2.2;
/// How steeply the opened break of a flat stem, which lies on its broad side, is looked down on, and how far its lower and upper
/// piece are turned towards the camera, rad: both its thickness and the figure of its broad side are seen.
const FLAT_ELEVATION: f64 = 0.6;
const FLAT_TURNS: (f64, f64) = (0.65, 0.55);
/// How much farther from the camera its upper piece lies, in widths of the section.
const FLAT_AWAY: f64 = 0.7;

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
    /// Direction of the long side of a flat section, as that of a board.
    pub long_side: Option<DVec3>,
}

/// Returns the direction of the long side of the section of a broken stem with wood of a material inside, if it is flat. The nodes
/// of the scene have these roles.
pub fn long_side(stem: &Stem, material: u32, broken: &Scene, roles: &[NodeRole]) -> Option<DVec3> {
    let lower = NodeRole::Piece(PieceRole::Lower);
    let node = &broken.nodes[roles.iter().position(|&role| role == lower)?];
    let frame = stem.grain.axis().frame(stem.location);
    let mesh = &node.mesh;
    let corners = (mesh.triangles.iter().enumerate())
        .filter(|(t, _)| mesh.materials.get(*t) == Some(&material))
        .flat_map(|(_, corners)| corners);
    let flat: Vec<DVec2> = corners
        .map(|&v| {
            let off = node.transform.transform_point3(mesh.positions[v as usize]) - frame.origin;
            DVec2::new(off.dot(frame.x), off.dot(frame.y))
        })
        .collect();
    let count = flat.len().max(1) as f64;
    let middle = flat.iter().sum::<DVec2>() / count;
    // Second moments and the direction of the greater of the two principal ones.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for off in flat.iter().map(|&p| p - middle) {
        (xx, xy, yy) = (xx + off.x * off.x, xy + off.x * off.y, yy + off.y * off.y);
    }
    let half = (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
    let (most, least) = (0.5 * (xx + yy) + half, 0.5 * (xx + yy) - half);
    if most < FLAT * FLAT * least || most <= 0.0 {
        return None;
    }
    let (sin, cos) = libm::sincos(0.5 * libm::atan2(2.0 * xy, xx - yy));
    Some(frame.x * cos + frame.y * sin)
}

/// A piece in a picture of a break.
#[derive(Debug, Clone, Copy)]
struct ViewedPiece<'a> {
    /// Its node where the picture shows it.
    node: &'a Node,
    /// Whether it lies beyond the break.
    is_upper: bool,
    /// Whether it is a splinter, behind which no stem is shown.
    is_splinter: bool,
}

/// How a camera looks at a break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// What is up in the picture.
    pub up: DVec3,
    /// The direction it looks in, seen from above.
    pub direction: DVec3,
    /// How steeply it looks down, rad.
    pub elevation: f64,
}

impl BreakView<'_> {
    /// Returns the frame of the stem at the break.
    fn frame(&self) -> Frame {
        self.stem.grain.axis().frame(self.stem.location)
    }

    /// Returns the points of `scene` that a picture of both faces and their stubs has to show, in the world; `None` where there
    /// is no lower piece. The nodes are those of the `broken` scene, in which the lower piece is where it was before the
    /// break, and have these roles.
    pub fn points(&self, scene: &Scene, broken: &Scene, roles: &[NodeRole]) -> Option<Vec<DVec3>> {
        let lower = NodeRole::Piece(PieceRole::Lower);
        let at = roles.iter().position(|&role| role == lower)?;
        let at_rest = &broken.nodes[at].transform;
        let nodes = scene.nodes.iter().zip(roles);
        let pieces = nodes.filter_map(|(node, role)| match role {
            NodeRole::Piece(role) => Some(ViewedPiece {
                node,
                is_upper: *role == PieceRole::Upper,
                is_splinter: matches!(role, PieceRole::Splinter(_)),
            }),
            NodeRole::Fuzz(_) | NodeRole::Carried | NodeRole::Untouched => None,
        });
        let mut points = Vec::new();
        for piece in pieces {
            let depths = self.face_depths(&piece, at_rest, &mut points);
            if !piece.is_splinter {
                points.extend(self.stub_corners(&piece, depths, at_rest));
            }
        }
        Some(points)
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
        let sides = match self.long_side {
            Some(long) => self.flat_sides(piece, at_rest, long),
            None => [at.x, at.y, -at.x, -at.y].map(|side| side * (0.5 * self.width)),
        };
        sides.map(|side| moved.transform_point3(at.origin + side))
    }

    /// Returns the way from the axis to the corners of the section of a flat piece, whose long side has a direction.
    fn flat_sides(&self, piece: &ViewedPiece, at_rest: &DAffine3, long: DVec3) -> [DVec3; 4] {
        let origin = self.frame().origin;
        let short = self.frame().tangent.cross(long);
        let mesh = &piece.node.mesh;
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let face = (mesh.triangles.iter().enumerate())
            .filter(|(t, _)| mesh.materials.get(*t) == Some(&self.material))
            .flat_map(|(_, corners)| corners);
        for &v in face {
            let off = at_rest.transform_point3(mesh.positions[v as usize]) - origin;
            let off = DVec2::new(off.dot(long), off.dot(short));
            (low, high) = (low.min(off), high.max(off));
        }
        if low.x > high.x {
            return [DVec3::ZERO; 4];
        }
        [
            (low.x, low.y),
            (high.x, low.y),
            (high.x, high.y),
            (low.x, high.y),
        ]
        .map(|(x, y)| long * x + short * y)
    }

    /// Returns how a camera looks at the opened break, or at one whose upper piece hangs on a hinge of this direction in the broken
    /// scene, whose nodes have these roles.
    pub fn sight(&self, hinge: Option<DVec3>, broken: &Scene, roles: &[NodeRole]) -> Sight {
        let tangent = self.frame().tangent;
        let (up, direction, elevation) = match (hinge, self.long_side) {
            // Both pieces lie on the floor, bent in it; the break opens towards the camera.
            (Some(axis), _) => {
                let upper = upper_motion(broken, roles).transform_vector3(tangent);
                let between = (upper - tangent).reject_from(axis).try_normalize();
                (axis, between.unwrap_or(-tangent), ELEVATION)
            }
            (None, long) => {
                let lying = self.lying();
                let elevation = long.map_or(ELEVATION, |_| FLAT_ELEVATION);
                (lying.up, lying.away, elevation)
            }
        };
        Sight {
            up,
            direction,
            elevation,
        }
    }

    /// Returns how both pieces of an opened break lie on the floor, with their faces towards the camera.
    fn lying(&self) -> Lying {
        let Frame { tangent, y, .. } = self.frame();
        let [low, high] = self.range;
        let ratio = (high - low) / self.width.max(f64::MIN_POSITIVE);
        let (flat, long) = FACE_RATIOS;
        let part = ((ratio - flat) / (long - flat)).clamp(0.0, 1.0);
        let between = |(flat, long): (f64, f64)| flat + (long - flat) * part;
        // A flat stem lies on its broad side.
        let (up, lower_turn, upper_turn, upper_away) = match self.long_side {
            Some(long) => (tangent.cross(long), FLAT_TURNS.0, FLAT_TURNS.1, FLAT_AWAY),
            None => (
                y,
                between(LOWER_TURNS),
                between(UPPER_TURNS),
                between(UPPER_AWAY),
            ),
        };
        let (sin, cos) = libm::sincos(lower_turn);
        let away = up.cross(tangent) * cos - tangent * sin;
        Lying {
            up,
            away,
            right: away.cross(up),
            turn: lower_turn + upper_turn,
            aside: away * (upper_away * self.width),
        }
    }

    /// Returns the motion of the upper piece of a broken scene, whose nodes have these roles, from where it grew to where it lies in
    /// a picture of both faces: beside the lower one, clear of it.
    pub fn opening(&self, broken: &Scene, roles: &[NodeRole]) -> DAffine3 {
        let origin = self.frame().origin;
        let lying = self.lying();
        let turn = DAffine3::from_axis_angle(lying.up, lying.turn);
        let turned = DAffine3::from_translation(origin + lying.aside)
            * turn
            * DAffine3::from_translation(-origin);
        let grown = upper_motion(broken, roles).inverse();
        let mut lower = Outline::new(self, &lying);
        let mut upper = Outline::new(self, &lying);
        for (node, role) in broken.nodes.iter().zip(roles) {
            match role {
                NodeRole::Piece(PieceRole::Lower) => {
                    lower.add(node, [DAffine3::IDENTITY; 2], 1.0);
                }
                NodeRole::Piece(PieceRole::Upper) => upper.add(node, [grown, turned], -1.0),
                _ => {}
            }
        }
        let gap = GAP * self.width;
        DAffine3::from_translation(lying.right * (lower.overlap(&upper) + gap)) * turned
    }

    /// Returns a broken scene, whose nodes have these roles, with the upper piece where a motion from where it grew takes it,
    /// however far it was moved.
    pub fn opened(&self, broken: &Scene, roles: &[NodeRole], motion: &DAffine3) -> Scene {
        let about = *motion * upper_motion(broken, roles).inverse();
        let mut scene = broken.clone();
        for (node, role) in scene.nodes.iter_mut().zip(roles) {
            match role {
                NodeRole::Piece(PieceRole::Upper)
                | NodeRole::Fuzz(PieceRole::Upper)
                | NodeRole::Carried => {
                    node.transform = about * node.transform;
                }
                NodeRole::Piece(_) | NodeRole::Fuzz(_) => {}
                // It would hide the faces.
                NodeRole::Untouched => node.mesh = Arc::default(),
            }
        }
        scene
    }

    /// The middles of the sections at the location of the lower piece, and of the upper one after a motion.
    pub(super) fn piece_middles(&self, motion: &DAffine3) -> [DVec3; 2] {
        let middle = self.frame().origin;
        [middle, motion.transform_point3(middle)]
    }
}

/// How the pieces of an opened break lie in a picture: its directions, by what angle (rad) the upper piece is turned about the
/// upward one, and how far it lies behind the lower.
#[derive(Debug, Clone, Copy)]
struct Lying {
    up: DVec3,
    away: DVec3,
    right: DVec3,
    turn: f64,
    aside: DVec3,
}

/// How far pieces reach to the right, and to the left, in cells of a grid across that direction.
struct Outline<'a> {
    view: &'a BreakView<'a>,
    lying: &'a Lying,
    reach: BTreeMap<[i64; 2], [f64; 2]>,
}

impl<'a> Outline<'a> {
    fn new(view: &'a BreakView<'a>, lying: &'a Lying) -> Self {
        Outline {
            view,
            lying,
            reach: BTreeMap::new(),
        }
    }

    /// Adds a node of a piece near the face, moved to where it grew and from there to where it is shown; the piece's face looks along
    /// the grain or against it, by `sign`.
    fn add(&mut self, node: &Node, [grown, shown]: [DAffine3; 2], sign: f64) {
        let Frame {
            origin, tangent, ..
        } = self.view.frame();
        let width = self.view.width;
        let to_grown = grown * node.transform;
        for &position in &node.mesh.positions {
            let at = to_grown.transform_point3(position);
            if sign * (at - origin).dot(tangent) < -CLEAR_LENGTH * width {
                continue;
            }
            let off = shown.transform_point3(at) - origin;
            let cell = [self.lying.away, self.lying.up]
                .map(|axis| (off.dot(axis) * CLEAR_CELLS / width).floor() as i64);
            let right = off.dot(self.lying.right);
            let reach = self.reach.entry(cell).or_insert([right; 2]);
            *reach = [reach[0].min(right), reach[1].max(right)];
        }
    }

    /// Returns how far the other pieces must be moved to the right to be clear of these, m.
    fn overlap(&self, other: &Outline) -> f64 {
        let mut most: f64 = f64::NEG_INFINITY;
        for ([x, y], [_, right]) in &self.reach {
            let around = (-1..=1).flat_map(|a| (-1..=1).map(move |b| [x + a, y + b]));
            for [left, _] in around.filter_map(|cell| other.reach.get(&cell)) {
                most = most.max(right - left);
            }
        }
        if most.is_finite() { most } else { 0.0 }
    }
}

/// Returns the motion of the upper piece of a broken scene, whose nodes have these roles, from where it grew.
fn upper_motion(broken: &Scene, roles: &[NodeRole]) -> DAffine3 {
    let transform = |role| {
        let at = roles.iter().position(|&r| r == NodeRole::Piece(role))?;
        Some(broken.nodes[at].transform)
    };
    let both = transform(PieceRole::Lower).zip(transform(PieceRole::Upper));
    both.map_or(DAffine3::IDENTITY, |(lower, upper)| upper * lower.inverse())
}

/// Returns where the end of the upper piece of a broken scene lies, whose nodes have these roles.
pub fn moved_end(broken: &Scene, roles: &[NodeRole], end: EndOfStem) -> EndOfStem {
    let motion = upper_motion(broken, roles);
    EndOfStem {
        middle: motion.transform_point3(end.middle),
        outward: motion.transform_vector3(end.outward),
        ..end
    }
}
