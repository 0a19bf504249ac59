//! The hinge of a piece that hangs on: fibres of the compression side that are whole, bent over from one piece to the other, and those
//! beside them that tore while it opened.
//!
//! Like strands they are thin closed meshes beside the pieces. Each follows a curve that leaves both faces along the grain.

use super::options::FuzzOptions;
use super::strand::{Ribbon, RibbonSection, StrandMesh};
use crate::lean::place::FacetPlaces;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::surface::FractureSurface;
use greenstick_wood::noise::unit;
use greenstick_wood::stem::LayeredGrain;

/// Bundles of fibres in the hinge.
const BUNDLES: i64 = 150;
/// Distances from the edge that the piece turned about, radii, between which bundles lie, and beyond which they are torn.
const REACH: (f64, f64) = (0.03, 0.6);
const WHOLE: f64 = 0.36;
/// Widths and thicknesses, radii.
const WIDTH: (f64, f64) = (0.03, 0.17);
const THICKNESS: (f64, f64) = (0.008, 0.022);
/// How far bundles reach into the wood of both pieces, radii.
const ROOT: f64 = 0.12;
/// How far the middle of a bundle lies beside its straight way, radii.
const SAG: f64 = 0.05;
/// Sections of a bundle between the faces.
const SECTIONS: i32 = 7;
/// Ring coordinate beyond which there are none.
const OUTER_RING: f64 = 0.93;
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

impl HingeOptions<'_> {
    /// Adds the fibres of the hinge to strands of the lower piece, as long as there are no more triangles than `most`.
    pub(super) fn add(&self, made: &mut StrandMesh, most: usize) {
        let places = FacetPlaces::new(self.surface, 1.0);
        for number in 0..BUNDLES {
            let ribbon = self.bundle(&places, number);
            if let Some(ribbon) = ribbon.filter(|r| made.triangles() + r.triangles() <= most) {
                made.add_ribbon(&ribbon);
            }
        }
    }

    fn bundle(&self, places: &FacetPlaces, number: i64) -> Option<Ribbon> {
        let stem = self.fuzz.stem;
        let radius = stem.radius;
        let random = |k: i64| unit(self.fuzz.seed ^ PURPOSE << 20, number, k, 0);
        let part = random(0);
        let far = REACH.0 + (REACH.1 - REACH.0) * part * part;
        // As broad as the section is at that distance.
        let broad = (1.0 - (1.0 - far) * (1.0 - far)).max(0.0).sqrt();
        let aside = (2.0 * random(1) - 1.0) * broad * radius;
        let at = self.toward * (self.from + far * radius) + self.toward.perp() * aside;
        let (ring, _) = stem.rings.address(at);
        if ring > OUTER_RING {
            return None;
        }
        let (_, height) = places.highest(at)?;
        let world = |height: f64| self.layers.to_world(at.extend(height));
        let root = ROOT * radius * (1.0 + random(2));
        let (start, along) = (
            world(height),
            (world(height) - world(height - root)).normalize_or_zero(),
        );
        let [end, onward] = [
            self.motion.transform_point3(start),
            self.motion.transform_vector3(along),
        ];
        let chord = start.distance(end);
        let beside = {
            let q = self.toward.perp().extend(0.0) * radius;
            (self.layers.to_world(at.extend(height) + q) - start).normalize_or_zero()
        };
        let sag = (beside * (2.0 * random(3) - 1.0) + along * (random(4) - 0.5)) * (SAG * radius);
        // Some are torn off on the way, from either piece.
        let torn = random(5) < 0.15 + (far - WHOLE) / (REACH.1 - WHOLE);
        let from_lower = random(6) < 0.5;
        let reaches = if torn { 0.25 + 0.5 * random(7) } else { 1.0 };
        let curve = |t: f64| {
            let tangents = [along * chord, onward * chord];
            hermite([start, end], tangents, t) + sag * (4.0 * t * (1.0 - t))
        };
        let mut places = vec![start - along * root];
        let way = |i: i32| f64::from(i) / f64::from(SECTIONS - 1) * reaches;
        let turned = torn && !from_lower;
        let along_it = |i| if turned { 1.0 - way(i) } else { way(i) };
        places.extend((0..SECTIONS).map(|i| curve(along_it(i))));
        if turned {
            places[0] = end + onward * root;
        }
        if !torn {
            places.push(end + onward * root);
        }
        let of = |range: (f64, f64), random: f64| {
            (range.0 + (range.1 - range.0) * random * random) * radius
        };
        let (width, thickness) = (of(WIDTH, random(8)), of(THICKNESS, random(9)));
        let last = places.len() - 1;
        let to_node = self.transform.inverse();
        let section = |(i, place): (usize, &DVec3)| {
            let tangent = places[(i + 1).min(last)] - places[i.saturating_sub(1)];
            let taper = if torn {
                1.0 - 0.85 * i as f64 / last as f64
            } else {
                1.0
            };
            let flat = (beside - tangent * (beside.dot(tangent) / tangent.length_squared()))
                .normalize_or_zero();
            let ridge = tangent.cross(flat).normalize_or_zero();
            let length = height + (i as f64 - 1.0) * root / SECTIONS as f64;
            RibbonSection {
                place: to_node.transform_point3(*place),
                flat: to_node.transform_vector3(flat * (0.5 * width * taper)),
                ridge: to_node.transform_vector3(ridge * (0.5 * thickness * taper)),
                grain: at.extend(length),
            }
        };
        Some(Ribbon {
            ring,
            sections: places.iter().enumerate().map(section).collect(),
        })
    }
}

/// Returns a point of the cubic Hermite curve between two points, at a fraction of the way.
fn hermite(points: [DVec3; 2], tangents: [DVec3; 2], t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    points[0] * (2.0 * t3 - 3.0 * t2 + 1.0)
        + tangents[0] * (t3 - 2.0 * t2 + t)
        + points[1] * (3.0 * t2 - 2.0 * t3)
        + tangents[1] * (t3 - t2)
}
