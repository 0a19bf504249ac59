//! Chips of torn wood that lie on the floor about the opened pieces of a picture.

use super::broken::BreakView;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::{Attribute, Mesh, Node};
use greenstick_wood::noise::unit;
use std::f64::consts::TAU;

/// Chips about each piece.
const COUNT: i64 = 150;
/// Least length and what the longest has more, m, on a stem of the reference radius; most are short.
const LENGTHS: (f64, f64) = (0.8e-3, 13e-3);
/// Radius (m) of the stem on which chips have these lengths, and the range of the factor on them on others.
const REFERENCE_RADIUS: f64 = 0.02;
const SIZE_RANGE: (f64, f64) = (0.35, 4.0);
/// Widths of slivers as a part of their length, and thicknesses as a part of their width.
const WIDTHS: (f64, f64) = (0.035, 0.17);
const THICKNESSES: (f64, f64) = (0.12, 0.4);
/// Least width, m on a stem of the reference radius.
const LEAST_WIDTH: f64 = 0.25e-3;
/// How far from a piece's middle chips lie, in half its widths: from the piece's outside, most of them near.
const DISTANCES: (f64, f64) = (1.02, 2.6);
/// Heaps that chips lie in, how far they spread about those, rad, and the share of chips that lie anywhere.
const HEAPS: f64 = 5.0;
const HEAP_SPREAD: f64 = 0.9;
const SCATTERED: f64 = 0.35;
/// How much of the length a chip is bowed up at its ends.
const BOW: f64 = 0.06;
/// How far from the pith the wood of chips grew, radii: that of bark is dark.
const OUTERMOST: f64 = 0.85;
/// Parts of the length at which a chip has a section, and its width there: both ends are torn.
const SECTIONS: [(f64, f64); 4] = [(0.0, 0.55), (0.3, 0.95), (0.72, 1.0), (1.0, 0.3)];
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0xc419;

impl BreakView<'_> {
    /// Returns chips of the wood inside that lie about both pieces of an opened break, whose upper piece had a motion from where it
    /// grew, of another about the lower one, on the floor through the lowest of the points that the picture shows; none where there
    /// are no such points.
    pub fn chips(&self, shown: &[DVec3], up: DVec3, motion: Option<&DAffine3>) -> Node {
        let level = shown
            .iter()
            .map(|p| p.dot(up))
            .fold(f64::INFINITY, f64::min);
        let mut fallen = Fallen {
            view: self,
            up,
            right: up.any_orthonormal_vector(),
            mesh: Mesh::default(),
            grain: Vec::new(),
        };
        let on_floor = |middle: DVec3| middle + up * (level - middle.dot(up));
        let middles = self.piece_middles(motion.unwrap_or(&DAffine3::IDENTITY));
        let middles = middles.map(on_floor);
        let count = if shown.is_empty() { 0 } else { COUNT };
        for piece in 0..if motion.is_some() { 2 } else { 1 } {
            let other = motion.map(|_| middles[1 - piece]);
            for number in 0..count {
                let random = |k: i64| unit(PURPOSE, piece as i64, number, k);
                fallen.add(middles[piece], other, random);
            }
        }
        Node::new("chips", DAffine3::IDENTITY, fallen.finish())
    }
}

/// Draws the angle (rad) at which a chip lies about a piece.
fn side(random: &impl Fn(i64) -> f64) -> f64 {
    if random(21) < SCATTERED {
        return TAU * random(1);
    }
    let heap = (HEAPS * random(1)).floor();
    let middle = TAU * unit(PURPOSE, heap as i64, -1, 0);
    middle + HEAP_SPREAD * (random(22) + random(23) - 1.0)
}

/// Chips on a floor.
struct Fallen<'a> {
    view: &'a BreakView<'a>,
    up: DVec3,
    /// A direction along the floor.
    right: DVec3,
    mesh: Mesh,
    grain: Vec<f32>,
}

impl Fallen<'_> {
    /// Adds a chip beside a piece whose middle on the floor is given, and that of the other piece, if any, in which none lies.
    fn add(&mut self, middle: DVec3, other: Option<DVec3>, random: impl Fn(i64) -> f64) {
        let radius = self.view.stem.radius;
        let size = (radius / REFERENCE_RADIUS).sqrt();
        let size = size.clamp(SIZE_RANGE.0, SIZE_RANGE.1);
        let between = |(low, high): (f64, f64), part: f64| low + (high - low) * part;
        let far = random(0) * random(20);
        let distance = between(DISTANCES, far) * 0.5 * self.view.width;
        let place = middle + self.direction(side(&random)) * distance;
        let nearest = DISTANCES.0 * 0.5 * self.view.width;
        if other.is_some_and(|other| place.distance(other) < nearest) {
            return;
        }
        let long = random(2) * random(2) * random(3);
        let length = size * (LENGTHS.0 + LENGTHS.1 * long);
        let width =
            (length * between(WIDTHS, random(4))).max(size * LEAST_WIDTH * (0.5 + random(5)));
        let thickness = width * between(THICKNESSES, random(6));
        let turn = TAU * random(7);
        let (along, beside) = (self.direction(turn), self.direction(turn + 0.25 * TAU));
        // The wood that it was.
        let (sin, cos) = libm::sincos(TAU * random(8));
        let grown = DVec2::new(cos, sin) * (OUTERMOST * radius * random(9).sqrt());
        let grown = grown.extend(self.view.stem.location + 0.5 * length * (random(10) - 0.5));
        let first = self.mesh.positions.len() as u32;
        for (part, swell) in SECTIONS {
            let off_middle = 2.0 * part - 1.0;
            let height = BOW * length * off_middle * off_middle * random(11);
            // Neither edge is straight.
            let aside = 0.3 * width * (random(12 + (part * 4.0) as i64) - 0.5);
            for (side, above) in [(-0.5, 0.0), (0.5, 0.0), (0.4, 1.0), (-0.4, 1.0)] {
                let across = side * width * swell + aside;
                let raised = height + above * thickness * swell.max(0.4);
                (self.mesh.positions).push(
                    place + along * (length * (part - 0.5)) + beside * across + self.up * raised,
                );
                let at = grown + DVec3::new(across, above * thickness, length * part);
                self.grain.extend(at.as_vec3().to_array());
            }
        }
        let corner = |section: usize, side: usize| first + (4 * section + side % 4) as u32;
        let last = SECTIONS.len() - 1;
        let ends = [[0, 1, 2], [0, 2, 3]];
        (self.mesh.triangles).extend(ends.map(|[a, b, c]| [a, c, b].map(|k| corner(0, k))));
        (self.mesh.triangles).extend(ends.map(|t| t.map(|k| corner(last, k))));
        for section in 0..last {
            for side in 0..4 {
                let [a, b] = [corner(section, side), corner(section, side + 1)];
                let [c, d] = [corner(section + 1, side), corner(section + 1, side + 1)];
                self.mesh.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }

    /// The direction along the floor at an angle, rad.
    fn direction(&self, angle: f64) -> DVec3 {
        let (sin, cos) = libm::sincos(angle);
        self.right * cos + self.up.cross(self.right) * sin
    }

    fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        mesh.materials = vec![self.view.material; mesh.triangles.len()];
        let grain = Attribute {
            width: 3,
            data: self.grain,
        };
        mesh.attributes.insert("_GRAIN".to_owned(), grain);
        mesh
    }
}
