//! The hinge of a piece that hangs on: fibres of the compression side that are whole, bent over from one piece to the other, and those
//! beside them that tore while it opened.
//!
//! Like strands they are thin closed meshes beside the pieces. Each follows a curve that leaves both faces along the grain.

use super::draw::between;
use super::options::FuzzOptions;
use super::strand::{Ribbon, RibbonSection, StrandMesh};
use crate::lean::place::FacetPlaces;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::surface::FractureSurface;
use greenstick_wood::noise::{smoothstep, unit};
use greenstick_wood::stem::LayeredGrain;
use greenstick_wood::tissue::Zone;

/// Slabs of the hinge, and straps of inner bark that buckle outside of it.
const SLABS: i64 = 110;
const STRAPS: i64 = 44;
/// Distances from the edge that the piece turned about, radii, between which slabs lie, and between which more and more of them and of
/// the straps are torn: green wood strains by some hundredths before it tears, so that nothing bridges the wide part of the gap.
const REACH: (f64, f64) = (0.03, 0.8);
const TEARS: (f64, f64) = (0.16, 0.45);
/// Widths of slabs and of straps, radii, and thicknesses of both. Most are narrow.
const WIDTH: (f64, f64) = (0.02, 0.3);
const STRAP_WIDTH: (f64, f64) = (0.05, 0.24);
const THICKNESS: (f64, f64) = (0.008, 0.03);
/// The most laths that a slab splits into between its ends, and their least width, radii.
const LATHS: f64 = 4.0;
const LATH_WIDTH: f64 = 0.035;
/// How far into the wood of both pieces slabs reach, radii.
const ROOT: f64 = 0.12;
/// How far the middle of a slab lies beside its straight way, and how far those of its laths differ, over the length of that way.
const SAG: f64 = 0.16;
const PARTED: f64 = 0.14;
/// How far whole laths go on along the grain where they leave the faces, over the length of their straight way: they are taut.
const TAUT: f64 = 0.6;
/// How much of the bend between the pieces a torn lath keeps: it springs back along the grain of the piece that it stands on.
const TORN_BEND: f64 = 0.35;
/// How far straps buckle outwards, radii.
const BUCKLE: (f64, f64) = (0.03, 0.16);
/// Least share of straps and of slabs that are torn.
const TORN_STRAPS: f64 = 0.12;
const TORN: f64 = 0.15;
/// How much narrower and wider a lath is along its way, at most.
const UNEVEN: f64 = 0.3;
/// Sections of a lath between the faces.
const SECTIONS: i32 = 8;
/// Ring coordinate beyond which there are no slabs.
const OUTER_RING: f64 = 0.93;
/// How far straps lie from where the skin is nearest to the edge, radii: within the bark.
const STRAP_DEPTH: f64 = 0.05;
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0x41b6;

/// What a hinge is between.
#[derive(Clone, Copy)]
pub struct HingeOptions<'a> {
    /// Of the strands.
    pub fuzz: FuzzOptions<'a>,
    /// The map between grain space and the world.
    pub layers: &'a LayeredGrain,
    /// Where the node that was cut stands in the world.
    pub transform: DAffine3,
    /// The face.
    pub surface: &'a FractureSurface,
    /// Unit direction across the section from the hinge to the side that opened.
    pub toward: DVec2,
    /// Distance of the hinge from the axis in that direction, m.
    pub from: f64,
    /// Motion of the upper piece in the world.
    pub motion: DAffine3,
}

/// A slab of the hinge, or a strap of inner bark.
struct Slab {
    /// Middle of its root in the section, m, and its ring coordinate.
    at: DVec2,
    ring: f64,
    /// Where it leaves the lower piece, and where it enters the upper.
    ends: [DVec3; 2],
    /// Directions along the grain there.
    along: [DVec3; 2],
    /// Direction of its width at the lower piece.
    beside: DVec3,
    /// Depth of its roots, width and thickness, m.
    root: f64,
    width: f64,
    thickness: f64,
    /// How far its middle lies off the way between its ends, m.
    sag: DVec3,
    /// Height of the lower face at its root, m.
    height: f64,
    /// Probability that a lath of it is torn.
    torn: f64,
}

impl HingeOptions<'_> {
    /// Adds the fibres of the hinge to strands of the lower piece, as long as there are no more triangles than `most`.
    pub(super) fn add(&self, made: &mut StrandMesh, most: usize) {
        let places = FacetPlaces::new(self.surface, 1.0);
        for number in 0..SLABS + STRAPS {
            let slab = if number < STRAPS {
                self.strap(&places, number)
            } else {
                self.slab(&places, number)
            };
            let Some(slab) = slab else {
                continue;
            };
            let random = |k: i64| self.random(number, k);
            let most_laths = (slab.width / (LATH_WIDTH * self.radius())).clamp(1.0, LATHS);
            let laths = (1.0 + (most_laths - 0.5) * random(20)) as i64;
            // Laths of one slab lie beside each other at its ends and take unequal shares of it.
            let weights: Vec<f64> = (0..laths).map(|k| 0.3 + random(30 + k)).collect();
            let sum: f64 = weights.iter().sum();
            let mut from = 0.0;
            for (lath, weight) in (0..).zip(weights) {
                let part = weight / sum;
                let middle = (from + 0.5 * part - 0.5) * slab.width;
                from += part;
                let ribbon = self.lath(&slab, (number, lath), (middle, part * slab.width));
                if made.triangles() + ribbon.triangles() <= most {
                    made.add_ribbon(&ribbon);
                }
            }
        }
    }

    fn radius(&self) -> f64 {
        self.fuzz.stem.radius
    }

    fn random(&self, number: i64, k: i64) -> f64 {
        unit(self.fuzz.seed ^ PURPOSE << 20, number, k, 0)
    }

    /// Draws a slab of wood.
    fn slab(&self, places: &FacetPlaces, number: i64) -> Option<Slab> {
        let radius = self.radius();
        let random = |k: i64| self.random(number, k);
        let far = between(REACH, random(0) * random(0));
        // As broad as the section is at that distance.
        let broad = (1.0 - (1.0 - far) * (1.0 - far)).max(0.0).sqrt();
        let aside = (2.0 * random(1) - 1.0) * broad * radius;
        let at = self.toward * (self.from + far * radius) + self.toward.perp() * aside;
        let (ring, _) = self.fuzz.stem.rings.address(at);
        if ring > OUTER_RING {
            return None;
        }
        let (_, height) = places.highest(at)?;
        let mut slab = self.placed(at, (ring, height), ROOT * (1.0 + random(2)));
        let along = slab.along[0];
        let chord = slab.ends[0].distance(slab.ends[1]);
        slab.sag =
            (slab.beside * (2.0 * random(3) - 1.0) + along * (random(4) - 0.5)) * (SAG * chord);
        slab.width = between(WIDTH, random(8) * random(8) * random(18)) * radius;
        slab.thickness = between(THICKNESS, random(9) * random(9)) * radius;
        slab.torn = torn_at(far).max(TORN);
        Some(slab)
    }

    /// Draws a strap of inner bark: outside of the hinge bark is pushed together and buckles.
    fn strap(&self, places: &FacetPlaces, number: i64) -> Option<Slab> {
        let radius = self.radius();
        let random = |k: i64| self.random(number, k);
        let turn = 1.1 * (2.0 * random(1) - 1.0);
        let (sin, cos) = libm::sincos(turn);
        let rings = &self.fuzz.stem.rings;
        // Outwards from the pith to within the bark.
        let out = self.toward.perp() * sin - self.toward * cos;
        let at = (1..=40)
            .map(|k| rings.pith() + out * (1.3 * radius * f64::from(k) / 40.0))
            .take_while(|&at| rings.address(at).0 < 1.0 - STRAP_DEPTH)
            .last()?;
        let (_, height) = places.highest(at)?;
        let mut slab = self.placed(at, (1.0 - STRAP_DEPTH, height), ROOT * (1.2 + random(2)));
        let outwards = {
            let to = self.layers.to_world((at + out * radius).extend(height));
            (to - slab.ends[0]).normalize_or_zero()
        };
        slab.sag = outwards * (between(BUCKLE, random(3) * random(4)) * radius);
        slab.width = between(STRAP_WIDTH, random(8) * random(8)) * radius;
        slab.thickness = between(THICKNESS, random(9)) * radius;
        let far = (at.dot(self.toward) - self.from) / radius;
        slab.torn = torn_at(far).max(TORN_STRAPS);
        Some(slab)
    }

    /// Returns a slab without a width whose root is at a place of the section on the face with a ring coordinate and a height (m); it
    /// is this deep, radii.
    fn placed(&self, at: DVec2, (ring, height): (f64, f64), root: f64) -> Slab {
        let root = root * self.radius();
        let world = |at: DVec2, height: f64| self.layers.to_world(at.extend(height));
        let start = world(at, height);
        let along = (start - world(at, height - root)).normalize_or_zero();
        // Straps lie around the stem, slabs along the edge.
        let out = at - self.fuzz.stem.rings.pith();
        let across = if ring > OUTER_RING {
            out.perp().normalize_or_zero()
        } else {
            self.toward.perp()
        };
        Slab {
            at,
            ring,
            ends: [start, self.motion.transform_point3(start)],
            along: [along, self.motion.transform_vector3(along)],
            beside: (world(at + across * self.radius(), height) - start).normalize_or_zero(),
            root,
            width: 0.0,
            thickness: 0.0,
            sag: DVec3::ZERO,
            height,
            torn: 0.0,
        }
    }

    /// Makes a lath of a slab: `middle` is its distance from the slab's middle at the ends, both in m.
    fn lath(&self, slab: &Slab, (number, lath): (i64, i64), (middle, width): (f64, f64)) -> Ribbon {
        let random = |k: i64| self.random(number, 100 + 30 * lath + k);
        let [start, end] = slab.ends.map(|p| p + slab.beside * middle);
        let [along, onward] = slab.along;
        let chord = start.distance(end);
        let even = |k: i64| 2.0 * random(k) - 1.0;
        let normal = along.cross(slab.beside);
        let parted = (slab.beside * even(0) + normal * even(1)) * (PARTED * chord);
        // Some are torn off on the way, from either piece.
        let torn = random(5) < slab.torn;
        let turned = torn && random(6) < 0.5;
        let reaches = if torn { 0.2 + 0.55 * random(7) } else { 1.0 };
        let tangents = [along * (TAUT * chord), onward * (TAUT * chord)];
        let curve = |t: f64| {
            let bulge = (slab.sag + parted) * (4.0 * t * (1.0 - t));
            let bent = hermite([start, end], tangents, t) + bulge;
            let straight = match turned {
                true => end - onward * (chord * (1.0 - t)),
                false => start + along * (chord * t),
            };
            match torn {
                true => straight.lerp(bent, TORN_BEND),
                false => bent,
            }
        };
        let way = |i: i32| f64::from(i) / f64::from(SECTIONS - 1) * reaches;
        let along_it = |i| if turned { 1.0 - way(i) } else { way(i) };
        let mut places = vec![if turned {
            end + onward * slab.root
        } else {
            start - along * slab.root
        }];
        places.extend((0..SECTIONS).map(|i| curve(along_it(i))));
        if !torn {
            places.push(end + onward * slab.root);
        }
        let last = places.len() - 1;
        let to_node = self.transform.inverse();
        let section = |(i, place): (usize, &DVec3)| {
            let tangent = places[(i + 1).min(last)] - places[i.saturating_sub(1)];
            let taper = if torn {
                1.0 - 0.9 * i as f64 / last as f64
            } else {
                1.0
            };
            let inner = i > 1 && i + 2 < places.len();
            let uneven = if inner {
                1.0 - UNEVEN * random(10 + i as i64)
            } else {
                1.0
            };
            let flat = (slab.beside
                - tangent * (slab.beside.dot(tangent) / tangent.length_squared()))
            .normalize_or_zero();
            let ridge = tangent.cross(flat).normalize_or_zero();
            let length = slab.height + (i as f64 - 1.0) * slab.root / f64::from(SECTIONS);
            RibbonSection {
                place: to_node.transform_point3(*place),
                flat: to_node.transform_vector3(flat * (0.5 * width * taper * uneven)),
                ridge: to_node.transform_vector3(ridge * (0.5 * slab.thickness * taper)),
                grain: slab.at.extend(length),
            }
        };
        Ribbon {
            ring: slab.ring,
            zone: if slab.ring > OUTER_RING {
                Zone::Phloem
            } else {
                Zone::Sapwood
            },
            sections: places.iter().enumerate().map(section).collect(),
        }
    }
}

/// Returns the share of laths that are torn at a distance from the edge that the piece turned about, radii.
fn torn_at(far: f64) -> f64 {
    smoothstep(TEARS.0, TEARS.1, far)
}

/// Returns a point of the cubic Hermite curve between two points, at a fraction of the way.
fn hermite(points: [DVec3; 2], tangents: [DVec3; 2], t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    points[0] * (2.0 * t3 - 3.0 * t2 + 1.0)
        + tangents[0] * (t3 - 2.0 * t2 + t)
        + points[1] * (3.0 * t2 - 2.0 * t3)
        + tangents[1] * (t3 - t2)
}
