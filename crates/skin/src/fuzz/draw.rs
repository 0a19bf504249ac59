//! How strands are drawn: hairs along the sides and edges of splinters, slivers that peel off them, and the ends of bundles on
//! wood that broke across.

use super::face::Frame;
use super::options::FuzzOptions;
use super::strand::{Kink, Root, Strand, StrandKind};
use glam::{DVec2, DVec3};
use greenstick_wood::noise::{gradient_3d, unit};
use greenstick_wood::stem::Stem;

/// Radius of the stem that lengths and widths are those of, m. On thicker ones strands are wider, and farther apart by as much: a
/// picture of all of a log cannot show single fibres.
const REFERENCE_RADIUS: f64 = 0.02;
/// Range of the factor on lengths and widths.
const SIZE_RANGE: (f64, f64) = (0.35, 4.0);
/// Size of tufts across and along the grain, m.
pub(super) const TUFT: (f64, f64) = (2.2e-3, 9e-3);
/// Ring coordinates beyond which no strand of a piece reaches: while the halves of a break lie in each other, and when they were
/// moved apart.
const OUTER_RING: f64 = 0.96;
const OUTER_RING_APART: f64 = 1.1;
const OUTER_RING_OF_STRAPS: f64 = 1.7;
/// Share of hairs that are bundles of fibres, nearly twice as wide as the others.
const BUNDLED: f64 = 0.45;
/// The most laths that a sliver splits into towards its free end.
pub(super) const LATHS: usize = 3;
/// Share of slivers that folded over, between which parts of their length, and by which angles, degrees. Most hang on by a bow.
const FOLDED: f64 = 0.15;
const FOLDS: (f64, f64) = (0.25, 0.65);
const FOLD_ANGLES: (f64, f64) = (10.0, 40.0);
/// Size of the patches in which crushed fibres lean to one side, m, and how much of the direction is that of the patch.
const PATCH: f64 = 2.6e-3;
const PATCHED: f64 = 3.0;
/// Share of crushed ends that are kinked, and angles of kinks, degrees: fibres in compression buckle at 45° to 60° to the grain
/// (Wood Handbook ch. 5).
const KINKED: f64 = 0.07;
const KINKS: (f64, f64) = (25.0, 55.0);
/// Share of ends that are blunt rather than pointed, kinked ones included.
const BLUNT: f64 = 0.5;
/// Range of the roll of ends out of their ring, rad: wood parts along rings.
const STUB_ROLL: f64 = 1.2;
/// Least length of a sliver, m, and depth of a stub within the wood.
const LEAST_SLIVER: f64 = 2.5e-3;
const STUB_DEPTH: f64 = 0.3e-3;
/// In the hash: what random numbers are drawn for.
pub(super) const PURPOSE: u64 = 0xf022;

/// Factor on the lengths and widths of strands on a stem.
pub(super) fn size(stem: &Stem) -> f64 {
    let size = (stem.radius / REFERENCE_RADIUS).sqrt();
    size.clamp(SIZE_RANGE.0, SIZE_RANGE.1)
}

/// Random numbers of a strand on a triangle, and what they are drawn within.
pub(super) struct Draw<'a> {
    pub options: &'a FuzzOptions<'a>,
    /// The triangle, and the number of the strand on it.
    pub place: (usize, usize),
}

impl Draw<'_> {
    pub(super) fn random(&self, k: i64) -> f64 {
        let seed = self.options.seed ^ PURPOSE;
        unit(seed, self.place.0 as i64, self.place.1 as i64, k)
    }

    /// Returns even weights of a triangle's corners, of random numbers `k` and the next.
    pub(super) fn weights(&self, k: i64) -> [f64; 3] {
        let (a, b) = (self.random(k), self.random(k + 1));
        let (a, b) = if a + b > 1.0 {
            (1.0 - a, 1.0 - b)
        } else {
            (a, b)
        };
        [1.0 - a - b, a, b]
    }

    pub(super) fn forward(&self) -> f64 {
        if self.options.upper { -1.0 } else { 1.0 }
    }

    /// Returns two numbers, about −0.5 to 0.5, that strands near each other at a place (m) share.
    pub(super) fn together(&self, place: DVec3, width: f64) -> [f64; 2] {
        let seed = self.options.seed ^ PURPOSE;
        [1, 2].map(|k: u64| gradient_3d(seed ^ k << 40, place / width, 0).0)
    }

    /// Returns a hair or a bundle of a few fibres on a wall; none where it would reach out of the stem.
    pub fn hair(&self, frame: &Frame) -> Option<Strand> {
        let random = |k: i64| self.random(k);
        let forward = self.forward();
        // Most begin near the free end of the wall; some splinter off backwards.
        let choices = [0, 2, 20].map(|k| self.weights(k));
        let ahead = |w: &[f64; 3]| forward * of(*w, frame.grain).z;
        let by_height = |a: &&[f64; 3], b: &&[f64; 3]| ahead(a).total_cmp(&ahead(b));
        let weights = if random(4) < 0.8 {
            *choices.iter().max_by(by_height)?
        } else {
            choices[0]
        };
        let direction = if random(5) < 0.05 { -forward } else { forward };
        let size = size(self.options.stem);
        let long = random(6);
        // Most are short, and lengths differ by a decade.
        let bundle = random(22) < BUNDLED;
        let mut length = size
            * (0.8e-3 + 2.6e-3 * random(7) * random(7) + 11e-3 * long * long * long * long * long);
        // What stands out beyond the edge is short, but for a few hairs.
        let hair = random(17) * random(17) * random(17);
        let beyond = size * (0.6e-3 + 3.2e-3 * random(15) * random(16) + 5e-3 * hair * hair);
        length = length.min(room(frame, weights, direction) + beyond);
        let fine = size * (0.09e-3 + 0.08e-3 * random(8) * random(8));
        let width = if bundle { 1.8 } else { 1.0 } * fine + 0.02 * length * random(9) * random(9);
        // Most lie close, some stand off. Those beside each other bend to one side, so that they hardly cross, and all are bent.
        let loose = random(10);
        let [curl, sway] = self.together(of(weights, frame.grain), TUFT.0 * size);
        self.within(
            frame,
            Strand {
                kind: StrandKind::Hair,
                root: root(frame, weights, direction),
                beside: 0.0,
                sunk: 0.0,
                kink: Kink::default(),
                forward: direction,
                length,
                width,
                thickness: width * (0.14 + 0.18 * random(13)),
                roll: 0.9 * (random(14) - 0.5),
                lift: 0.02 + 0.27 * loose * loose * loose * loose,
                curl: 0.1 + 0.5 * curl + 0.22 * random(11),
                sway: 0.8 * sway + 0.12 * (random(12) - 0.5),
                ends: [1.0; 3],
                ring: 0.0,
            },
        )
    }

    /// Returns the laths of a sliver that peels off a wall: side by side at its root, each with an end of its own.
    pub fn sliver(&self, frame: &Frame) -> Vec<Strand> {
        let random = |k: i64| self.random(k);
        let (forward, size) = (self.forward(), size(self.options.stem));
        let choices = [0, 2].map(|k| self.weights(k));
        let [one, other] = choices.map(|w| forward * of(w, frame.grain).z);
        // What peels off begins below and comes loose from its end on.
        let weights = choices[usize::from((other < one) == (random(4) < 0.75))];
        let long = random(6) * random(6);
        let drawn = size * (4e-3 + 20e-3 * long);
        let beyond = size * (0.5e-3 + 5e-3 * random(15) * random(15));
        let length = drawn.min(room(frame, weights, forward) + beyond);
        if length < LEAST_SLIVER * size {
            return Vec::new();
        }
        let width = (size * (0.35e-3 + 1.1e-3 * random(8) * random(8))).min(0.14 * length);
        let laths = (1.0 + (LATHS as f64 - 0.01) * random(9)) as usize;
        let [curl, sway] = self.together(of(weights, frame.grain), TUFT.0 * size);
        let kink = self.fold();
        let part = 1.0 / laths as f64;
        let lath = |k: usize| {
            let own = |n: i64| random(40 + 10 * k as i64 + n);
            let middle = (k as f64 + 0.5) * part - 0.5;
            let width = width * part * (0.75 + 0.4 * own(0));
            Strand {
                kind: StrandKind::Sliver,
                root: root(frame, weights, forward),
                beside: middle * width * laths as f64,
                sunk: 0.0,
                kink,
                forward,
                length: length * (1.0 - 0.5 * own(1) * own(1)),
                width,
                thickness: (width * (0.22 + 0.2 * own(2))).min(0.2e-3 * size),
                roll: 0.3 * (own(3) - 0.5),
                lift: 0.03 + 0.12 * random(10) * random(10),
                curl: 0.1 + 0.4 * random(11) * random(11) + 0.25 * curl.max(0.0) + 0.1 * own(4),
                sway: 0.5 * sway + 0.35 * middle + 0.08 * (own(5) - 0.5),
                ends: [1.0; 3],
                ring: 0.0,
            }
        };
        (0..laths)
            .filter_map(|k| self.within(frame, lath(k)))
            .collect()
    }

    /// Draws whether a sliver folded over, and how.
    fn fold(&self) -> Kink {
        if self.random(30) >= FOLDED {
            return Kink::default();
        }
        let (random, (least, most)) = (self.random(31), FOLD_ANGLES);
        Kink {
            at: FOLDS.0 + (FOLDS.1 - FOLDS.0) * self.random(32),
            angle: (least + (most - least) * random * random).to_radians(),
            toward: 1.6 * (self.random(33) - 0.5),
        }
    }

    /// Returns the side to which wood at a place in grain space (m) leans when it is crushed.
    pub fn side(&self, place: DVec3) -> DVec2 {
        let [x, y] = self.together(place, PATCH * size(self.options.stem));
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * self.random(0));
        (DVec2::new(x, y) * PATCHED + DVec2::new(cos, sin) * 0.5).normalize_or(DVec2::X)
    }

    /// Returns the end of a bundle on wood that broke across, which is `crushed` (0 to 1); none where it would reach out of the
    /// stem.
    pub fn stub(&self, frame: &Frame, crushed: f64) -> Option<Strand> {
        let random = |k: i64| self.random(k);
        let (forward, size) = (self.forward(), size(self.options.stem));
        let weights = self.weights(2);
        let long = random(4);
        let torn = 1.0 - crushed;
        let length = size
            * (0.3e-3
                + (0.8 + 0.6 * torn) * 1e-3 * long * long
                + (0.9 + 1.6 * torn) * 1e-3 * long.powi(9));
        let width = size * (0.17e-3 + 0.22e-3 * random(5) * random(5)) + 0.05 * length;
        let kind = match random(6) {
            kind if kind < KINKED * crushed => StrandKind::Kinked,
            kind if kind < BLUNT => StrandKind::Chisel,
            _ => StrandKind::Spike,
        };
        let kink = Kink {
            at: 0.3 + 0.35 * random(7),
            angle: (KINKS.0 + (KINKS.1 - KINKS.0) * random(8)).to_radians(),
            toward: 1.2 * (random(9) - 0.5),
        };
        let bent = kind == StrandKind::Kinked;
        self.within(
            frame,
            Strand {
                kind,
                root: root(frame, weights, forward),
                beside: 0.0,
                sunk: STUB_DEPTH * size,
                kink: if bent { kink } else { Kink::default() },
                forward,
                length: length + STUB_DEPTH * size,
                width,
                thickness: width * (0.45 + 0.4 * random(10)),
                roll: self.along_ring(frame) + STUB_ROLL * (random(11) - 0.5),
                lift: 0.02 + 0.3 * random(12) * random(12),
                curl: 0.1 * random(13),
                sway: 0.2 * (random(14) - 0.5),
                ends: [16, 17, 18].map(|k| 1.0 - 0.55 * random(k)),
                ring: 0.0,
            },
        )
    }

    /// Returns the roll by which a strand on an end lies flat on its ring.
    pub(super) fn along_ring(&self, frame: &Frame) -> f64 {
        let rings = &self.options.stem.rings;
        let angle = rings.address(frame.grain[0].truncate()).1;
        let (sin, cos) = libm::sincos(angle);
        let ring = DVec2::new(-sin, cos);
        libm::atan2(ring.dot(frame.across[1]), ring.dot(frame.across[0]))
    }

    /// Returns a strand, straightened or left out where it would reach out of the stem.
    pub(super) fn within(&self, frame: &Frame, mut strand: Strand) -> Option<Strand> {
        let options = self.options;
        strand.ring = options.stem.rings.address(strand.root.grain.truncate()).0;
        let most = if strand.kind == StrandKind::Strap {
            OUTER_RING_OF_STRAPS
        } else if options.apart {
            OUTER_RING_APART
        } else {
            OUTER_RING
        };
        let reaches_out =
            |strand: &Strand| farthest_ring(strand, frame, options) > most.max(strand.ring);
        if reaches_out(&strand) {
            (strand.lift, strand.curl, strand.sway) = (0.02, 0.0, 0.2 * strand.sway);
            strand.kink.angle = 0.0;
            if reaches_out(&strand) {
                return None;
            }
        }
        Some(strand)
    }
}

/// Returns the value at a part of the way from `least` to `most`.
pub(super) fn between((least, most): (f64, f64), part: f64) -> f64 {
    least + (most - least) * part
}

pub(super) fn of(w: [f64; 3], v: [DVec3; 3]) -> DVec3 {
    v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
}

pub(super) fn root(frame: &Frame, weights: [f64; 3], direction: f64) -> Root {
    // Frames of ends point to the free side already.
    let [beside, out, along] = frame.directions;
    Root {
        position: of(weights, frame.corners),
        grain: of(weights, frame.grain),
        directions: [
            beside,
            out,
            along * if frame.is_end { 1.0 } else { direction },
        ],
        across: frame.across,
        zone: frame.zone as f32,
        sector: frame.sector,
    }
}

/// Returns how far it is from a place on a triangle to its end along the grain, m.
fn room(frame: &Frame, weights: [f64; 3], direction: f64) -> f64 {
    let ahead = frame.grain.map(|g| direction * g.z);
    ahead[0].max(ahead[1]).max(ahead[2]) - direction * of(weights, frame.grain).z
}

/// The greatest ring coordinate that a strand reaches. One that curls back reaches farther before its tip.
fn farthest_ring(strand: &Strand, frame: &Frame, options: &FuzzOptions) -> f64 {
    let at = |part: f64| {
        let offset = strand.offset(part);
        let way = strand.forward * offset.z * options.units_per_metre;
        let across = frame.across[0] * offset.x + frame.across[1] * offset.y + frame.lean * way;
        let ring = (options.stem.rings)
            .address(strand.root.grain.truncate() + across)
            .0;
        // It keeps most of its width almost to its tip.
        let tapers = part * part * part * part;
        ring + (1.0 - tapers) * 0.5 * strand.width / options.stem.radius
    };
    [0.25, 0.5, 0.75, 1.0]
        .map(at)
        .into_iter()
        .fold(0.0, f64::max)
}
