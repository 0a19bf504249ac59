//! Chips of torn wood that lie on the floor about the opened pieces of a picture.

use super::broken::BreakView;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_geometry::{Attribute, Mesh, Node};
use greenstick_wood::noise::{hash, unit};
use std::f64::consts::TAU;

/// Chips about each piece, and between two pieces, where most of them fall.
const COUNT: i64 = 110;
const COUNT_BETWEEN: i64 = 1500;
/// Least length and what the longest has more, m, on a stem of the reference radius, of slivers, of crumbs, and of flakes of bark; most are
/// short.
const SLIVER_LENGTHS: (f64, f64) = (0.8e-3, 19e-3);
const CRUMB_LENGTHS: (f64, f64) = (0.2e-3, 4.5e-3);
const FLAKE_LENGTHS: (f64, f64) = (0.4e-3, 6.5e-3);
/// Radius (m) of the stem on which chips have these lengths, and the range of the factor on them on others.
const REFERENCE_RADIUS: f64 = 0.02;
const SIZE_RANGE: (f64, f64) = (0.35, 4.0);
/// Widths of slivers, crumbs and flakes as a part of their length, and thicknesses as a part of their width.
const SLIVER_WIDTHS: (f64, f64) = (0.03, 0.16);
const CRUMB_WIDTHS: (f64, f64) = (0.04, 0.22);
const FLAKE_WIDTHS: (f64, f64) = (0.3, 0.8);
const THICKNESSES: (f64, f64) = (0.25, 0.9);
/// Width of the laths that a wide chip is torn from, m on a stem of the reference radius; how many it has at most; their thickness as a
/// part of their width; and by how much of the length an end of one may lie short of the chip's.
const LATH_WIDTH: f64 = 0.7e-3;
const MOST_LATHS: f64 = 9.0;
const LATH_THICKNESSES: (f64, f64) = (0.5, 1.1);
const LATHS_TORN: f64 = 0.42;
/// How far a lath reaches into its neighbours, in its widths.
const LATH_OVERLAP: f64 = 0.22;
/// Laths of a flake of bark, their thickness and how far their ends lie apart, likewise.
const FLAKE_LATHS: f64 = 2.0;
const FLAKE_THICKNESSES: (f64, f64) = (0.1, 0.4);
const FLAKES_TORN: f64 = 0.5;
/// Least width, m on a stem of the reference radius.
const LEAST_WIDTH: f64 = 0.13e-3;
/// How far from a piece's middle chips lie, in half its widths: from the piece's outside, most of them near.
const DISTANCES: (f64, f64) = (1.02, 2.6);
/// How far chips between the pieces lie from the middle between them at most, and from the middle of each at least, in widths of the
/// section.
const REACH_BETWEEN: f64 = 2.3;
const CLEAR_OF_PIECES: f64 = 0.52;
/// Heaps that chips lie in, how far they spread about those, rad, and the share of chips that lie anywhere.
const HEAPS: f64 = 5.0;
const HEAP_SPREAD: f64 = 0.9;
const SCATTERED: f64 = 0.35;
/// Share of the chips between pieces that lie in heaps, how many those are, and how far they spread, widths of the section: what is torn
/// out together falls together.
const HEAPED: f64 = 0.7;
const HEAPS_BETWEEN: f64 = 7.0;
const HEAP_RADIUS: f64 = 0.45;
/// Share of chips that are crumbs rather than slivers, in heaps and elsewhere, and of those that are bark: what lies by itself is small.
const CRUMBS: f64 = 0.8;
const CRUMBS_ALONE: f64 = 0.93;
const BARK: f64 = 0.05;
/// How much of the length a chip is bowed up at its ends.
const BOW: f64 = 0.08;
/// Share of chips that lie on others or on sand, and how much of the length their higher end is raised at most.
const RAISED: f64 = 0.5;
const RAISED_END: f64 = 0.22;
/// How far from the pith the wood of chips grew at most, and the bark of others, radii.
const OUTERMOST: f64 = 0.85;
const BARK_GROWN: f64 = 0.999;
/// Parts of the length at which a chip has a section, and its width in the middle; both ends are torn, some to a point and some nearly
/// square.
const SECTIONS: [f64; 4] = [0.0, 0.3, 0.72, 1.0];
const MIDDLE: f64 = 0.95;
const ENDS: (f64, f64) = (0.08, 1.15);
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0xc419;
/// The number of the place between the pieces, after those of the pieces.
const BETWEEN: i64 = 2;

impl BreakView<'_> {
    /// Returns chips of the wood inside that lie about both pieces of an opened break, whose upper piece had a motion from where it
    /// grew, of another about the lower one, on the floor through the lowest of the points that the picture shows; none where there
    /// are no such points.
    pub fn chips(&self, shown: &[DVec3], up: DVec3, motion: Option<&DAffine3>) -> Node {
        let level = shown
            .iter()
            .map(|p| p.dot(up))
            .fold(f64::INFINITY, f64::min);
        let [low, high] = self.range;
        let mut fallen = Fallen {
            view: self,
            up,
            right: up.any_orthonormal_vector(),
            seed: PURPOSE ^ hash(PURPOSE, low.to_bits() as i64, high.to_bits() as i64, 0),
            mesh: Mesh::default(),
            grain: Vec::new(),
        };
        if !shown.is_empty() {
            let on_floor = |middle: DVec3| middle + up * (level - middle.dot(up));
            let middles = self.piece_middles(motion.unwrap_or(&DAffine3::IDENTITY));
            fallen.scatter(middles.map(on_floor), motion.is_some());
        }
        Node::new("chips", DAffine3::IDENTITY, fallen.finish())
    }
}

/// Whether a chip about a piece lies anywhere, in no heap.
fn is_scattered(random: &impl Fn(i64) -> f64) -> bool {
    random(21) < SCATTERED
}

/// Draws the angle (rad) at which a chip lies about a piece.
fn side(seed: u64, random: &impl Fn(i64) -> f64) -> f64 {
    if is_scattered(random) {
        return TAU * random(1);
    }
    let heap = (HEAPS * random(1)).floor();
    let middle = TAU * unit(seed, heap as i64, -1, 0);
    middle + HEAP_SPREAD * (random(22) + random(23) - 1.0)
}

/// A number of a range, `part` of the way through it, of which the second is the extent.
fn within((least, extent): (f64, f64), part: f64) -> f64 {
    least + extent * part
}

/// A number between two, `part` of the way.
fn between((low, high): (f64, f64), part: f64) -> f64 {
    within((low, high - low), part)
}

/// A chip, as it lies and as it grew.
struct Chip {
    /// Its middle on the floor.
    place: DVec3,
    /// Unit directions along its grain and beside it, along the floor.
    along: DVec3,
    beside: DVec3,
    /// Where its middle grew, m from the pith, and where it begins along the grain, m.
    grown: DVec2,
    foot: f64,
    length: f64,
    /// How far its ends are bowed up, and how far its far end is raised above the other, m.
    bow: f64,
    raised: f64,
}

/// Chips on a floor.
struct Fallen<'a> {
    view: &'a BreakView<'a>,
    up: DVec3,
    /// A direction along the floor.
    right: DVec3,
    /// Of what is random: no two breaks have the same chips.
    seed: u64,
    mesh: Mesh,
    grain: Vec<f32>,
}

impl Fallen<'_> {
    /// Adds the chips about pieces whose middles on the floor are these; the first lies alone where the other is not `opened`.
    fn scatter(&mut self, middles: [DVec3; 2], opened: bool) {
        let width = self.view.width;
        for piece in 0..if opened { 2 } else { 1 } {
            for number in 0..COUNT {
                let seed = self.seed;
                let random = |k: i64| unit(seed, piece as i64, number, k);
                let (least, most) = DISTANCES;
                let distance = within((least, most - least), random(0) * random(20));
                let place =
                    middles[piece] + self.direction(side(seed, &random)) * (0.5 * width * distance);
                let other = middles[1 - piece];
                if !opened || place.distance(other) > 0.5 * width * least {
                    let is_alone = is_scattered(&random);
                    self.add(place, is_alone, random);
                }
            }
        }
        // Pieces of a board lie flat on the floor.
        if !opened || self.view.long_side.is_some() {
            return;
        }
        let middle = 0.5 * (middles[0] + middles[1]);
        for number in 0..COUNT_BETWEEN {
            let seed = self.seed;
            let random = |k: i64| unit(seed, BETWEEN, number, k);
            let is_alone = random(29) >= HEAPED;
            let place = if !is_alone {
                let heap = (HEAPS_BETWEEN * random(30)) as i64;
                let of_heap = |k: i64| unit(seed, heap, -2, k);
                let off = 0.5 * REACH_BETWEEN * width * of_heap(0).sqrt();
                let spread =
                    HEAP_RADIUS * width * (0.3 + of_heap(2)) * random(0).max(0.3 * random(20));
                middle
                    + self.direction(TAU * of_heap(1)) * off
                    + self.direction(TAU * random(1)) * spread
            } else {
                let distance = REACH_BETWEEN * width * random(0) * random(20);
                middle + self.direction(TAU * random(1)) * distance
            };
            let clear = CLEAR_OF_PIECES * width;
            if middles.iter().all(|m| place.distance(*m) > clear) {
                self.add(place, is_alone, random);
            }
        }
    }

    /// Adds a chip at a place of the floor, in a heap or by itself.
    fn add(&mut self, place: DVec3, is_alone: bool, random: impl Fn(i64) -> f64) {
        let radius = self.view.stem.radius;
        let size = (radius / REFERENCE_RADIUS).sqrt();
        let size = size.clamp(SIZE_RANGE.0, SIZE_RANGE.1);
        let is_bark = self.view.stem.kind.has_bark() && random(25) < BARK;
        let crumbs = if is_alone { CRUMBS_ALONE } else { CRUMBS };
        let (lengths, widths) = match random(24) < crumbs {
            _ if is_bark => (FLAKE_LENGTHS, FLAKE_WIDTHS),
            true => (CRUMB_LENGTHS, CRUMB_WIDTHS),
            false => (SLIVER_LENGTHS, SLIVER_WIDTHS),
        };
        let length = size * within(lengths, random(2) * random(2) * random(3));
        let width =
            (length * between(widths, random(4))).max(size * LEAST_WIDTH * (0.5 + random(5)));
        let turn = TAU * random(7);
        // The wood that it was.
        let (sin, cos) = libm::sincos(TAU * random(8));
        let part = match is_bark {
            true => BARK_GROWN,
            false => OUTERMOST * random(9).sqrt(),
        };
        let chip = Chip {
            place,
            along: self.direction(turn),
            beside: self.direction(turn + 0.25 * TAU),
            grown: DVec2::new(cos, sin) * (part * radius),
            foot: self.view.stem.location + 0.5 * length * (random(10) - 0.5),
            length,
            bow: BOW * length * random(11),
            raised: match random(12) < RAISED {
                true => RAISED_END * length * random(13) * random(14),
                false => 0.0,
            },
        };
        // A wide chip is of laths side by side, none of which is torn where its neighbour is.
        let laths = (width / (size * LATH_WIDTH)).ceil();
        let count = laths.clamp(1.0, if is_bark { FLAKE_LATHS } else { MOST_LATHS }) as i64;
        let mut edge = -0.5 * width;
        for lath in 0..count {
            let random = |k: i64| random(40 + 20 * lath + k);
            let wide = width / count as f64;
            let thickness = match count {
                _ if is_bark => wide * between(FLAKE_THICKNESSES, random(6)),
                1 => wide * between(THICKNESSES, random(6)),
                _ => wide * between(LATH_THICKNESSES, random(6)),
            };
            let torn = match count {
                1 => 0.0,
                _ if is_bark => FLAKES_TORN,
                _ => LATHS_TORN,
            };
            let ends = [
                torn * random(0) * random(1),
                1.0 - torn * random(2) * random(3),
            ];
            let over = if count == 1 { 0.0 } else { LATH_OVERLAP * wide };
            let edges = [edge - over, edge + wide + over];
            self.add_lath(&chip, edges, ends, (thickness, &random));
            edge += wide;
        }
    }

    /// Adds a lath of a chip between two edges, m beside its axis, and two ends, parts of its length, with a thickness (m).
    fn add_lath(
        &mut self,
        chip: &Chip,
        [left, right]: [f64; 2],
        [start, end]: [f64; 2],
        (thickness, random): (f64, &impl Fn(i64) -> f64),
    ) {
        let first = self.mesh.positions.len() as u32;
        let outward = chip.grown.normalize_or(DVec2::X);
        let swells = [
            between(ENDS, random(7)),
            MIDDLE,
            1.0,
            between(ENDS, random(8).min(random(9))),
        ];
        for (section, swell) in SECTIONS.into_iter().zip(swells) {
            let part = start + (end - start) * section;
            let off_middle = 2.0 * part - 1.0;
            let height = chip.bow * off_middle * off_middle + chip.raised * part;
            // Neither edge is straight.
            let aside = 0.45 * (right - left) * (random(10 + (section * 4.0) as i64) - 0.5);
            for (side, above) in [(-0.5, 0.0), (0.5, 0.0), (0.4, 1.0), (-0.4, 1.0)] {
                let across = 0.5 * (left + right) + side * (right - left) * swell + aside;
                let raised = height + above * thickness * swell.max(0.4);
                (self.mesh.positions).push(
                    chip.place
                        + chip.along * (chip.length * (part - 0.5))
                        + chip.beside * across
                        + self.up * raised,
                );
                // Wide along the ring, as flakes of bark are.
                let at = chip.grown + outward.perp() * across - outward * (above * thickness);
                let at = at.extend(chip.foot + chip.length * part);
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
