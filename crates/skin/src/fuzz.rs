//! Fuzz: strands of torn fibre that stand out of a broken face, along the sides of its splinters and on their edges.
//!
//! Torn wood carries bundles of fibres 0.1 to 0.5 mm wide and 2 to 20 mm long, densely where it was torn and hardly where it was
//! crushed or broke brash (Hoadley, *Understanding Wood*). They are too thin for the cells of a face. Each is a closed
//! three-sided blade of the wood that it is peeled off: it begins within that wood, lies along the grain, and lifts towards its
//! free end. Together they are a mesh of their own beside the piece, so that the piece stays one closed solid.

mod hinge;
mod options;
mod strand;

pub use hinge::HingeOptions;
pub use options::FuzzOptions;

use glam::{DVec2, DVec3, Vec3};
use greenstick_geometry::Mesh;
use greenstick_wood::noise::{gradient_3d, smoothstep, unit};
use greenstick_wood::stem::Stem;
use greenstick_wood::tissue::Zone;
use strand::{Root, Strand, StrandMesh};

/// Strands on each square metre of torn side grain with a fuzz of 1, on wood of the reference radius.
const DENSITY: f64 = 7.5e5;
/// Triangles of fuzz over those of the broken face, at most, with a fuzz of 1.
const MAX_SHARE: f64 = 0.6;
/// Mean number of triangles of a strand, by which strands are thinned out where they would be too many.
const MEAN_TRIANGLES: f64 = 12.5;
/// Radius of the stem that lengths and widths are those of, m. On thicker ones strands are wider, and farther apart by as much: a
/// picture of all of a log cannot show single fibres.
const REFERENCE_RADIUS: f64 = 0.02;
/// Range of the factor on lengths and widths.
const SIZE_RANGE: (f64, f64) = (0.35, 4.0);
/// Heights of a wall of the face between which it counts as torn, m: lower ones are the steps of crushed and of brash wood.
const TORN_HEIGHT: (f64, f64) = (0.8e-3, 3.5e-3);
/// Least square of the slope of the length along a face that is side grain.
const SIDE_GRAIN: f64 = 0.6;
/// Size of tufts across and along the grain, m.
const TUFT: (f64, f64) = (2.2e-3, 9e-3);
/// Density on pith, heartwood, sapwood, phloem and bark.
const DENSITY_OF_ZONES: [f64; 5] = [0.3, 0.9, 1.0, 1.2, 0.06];
/// Ring coordinate beyond which no strand of a piece reaches: the halves of a break lie in each other before they are opened.
const OUTER_RING: f64 = 0.975;
/// In the hash: what random numbers are drawn for.
const PURPOSE: u64 = 0xf022;

/// A triangle of side grain.
struct Wall {
    triangle: usize,
    /// Expected number of strands.
    strands: f64,
}

/// Makes the fuzz of a piece, which has the attributes of a broken face. It is empty where the face is not torn.
/// With a `hinge`, it has the fibres of that, too.
pub fn fuzz(piece: &Mesh, options: &FuzzOptions, hinge: Option<&HingeOptions>) -> Mesh {
    let mut walls = walls(piece, options);
    let wanted: f64 = walls.iter().map(|wall| wall.strands).sum();
    let on_face = |&t: &usize| piece.material(t) == options.material;
    let face = (0..piece.triangles.len()).filter(on_face).count();
    let share = (MAX_SHARE * options.amount * face as f64) as usize;
    let most = share.min(options.most_triangles);
    let expected = wanted * MEAN_TRIANGLES;
    if expected > most as f64 {
        let part = most as f64 / expected;
        walls.iter_mut().for_each(|wall| wall.strands *= part);
    }
    let mut made = StrandMesh::new(options);
    if let Some(hinge) = hinge {
        hinge.add(&mut made, options.most_triangles);
    }
    let most = (most + made.triangles()).min(options.most_triangles);
    let Some(face) = TornFace::of(piece) else {
        return made.finish();
    };
    for wall in &walls {
        let random = |k: i64| unit(options.seed ^ PURPOSE, wall.triangle as i64, -1, k);
        let here = (wall.strands + random(0)) as usize;
        // Most walls have none.
        if here == 0 {
            continue;
        }
        let Some(frame) = face.frame(wall.triangle) else {
            continue;
        };
        for number in 0..here {
            let strand = strand_on(&frame, (wall.triangle, number), options);
            if let Some(strand) = strand.filter(|s| made.triangles() + s.triangles() <= most) {
                made.add(&strand);
            }
        }
    }
    made.finish()
}

/// The values at the corners of a triangle, and the directions of the grain there.
struct Frame {
    corners: [DVec3; 3],
    /// Grain coordinates of the corners, m.
    grain: [DVec3; 3],
    /// Unit directions in the piece: beside the grain in the face, out of the face, along the grain.
    directions: [DVec3; 3],
    /// The first two in the section.
    across: [DVec2; 2],
    /// How far the face leans: the way in the section, m, of a unit of the piece's coordinates along the last direction.
    lean: DVec2,
    /// Tissue.
    zone: usize,
    /// Sector.
    sector: f32,
}

/// A piece with the attributes of a broken face.
struct TornFace<'a> {
    piece: &'a Mesh,
    grain: &'a [[f32; 3]],
    zones: &'a [f32],
    sectors: &'a [f32],
}

impl<'a> TornFace<'a> {
    /// The face of a piece; none where it lacks one of these attributes.
    fn of(piece: &'a Mesh) -> Option<Self> {
        let values = |name: &str, width: usize| {
            let attribute = piece.attributes.get(name).filter(|a| a.width == width);
            attribute.map(|a| a.data.as_slice())
        };
        Some(TornFace {
            piece,
            grain: values("_GRAIN", 3)?.as_chunks().0,
            zones: values("_ZONE", 1)?,
            sectors: values("_SECTOR", 1)?,
        })
    }

    /// Grain coordinates of the corners of a triangle, m.
    fn grain(&self, t: usize) -> [DVec3; 3] {
        let at = |v: u32| Vec3::from_array(self.grain[v as usize]).as_dvec3();
        self.piece.triangles[t].map(at)
    }

    /// Tissue of a triangle.
    fn zone(&self, t: usize) -> usize {
        self.zones[self.piece.triangles[t][0] as usize] as usize
    }

    /// The frame of a triangle; none where it has no area.
    fn frame(&self, t: usize) -> Option<Frame> {
        let (corners, grain) = (self.piece.corners(t), self.grain(t));
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let normal = e.cross(f);
        let square = normal.length_squared();
        let (ge, gf) = (grain[1] - grain[0], grain[2] - grain[0]);
        let across = ge.cross(gf).truncate();
        let (rise, _) = slope([e, f], [ge, gf])?;
        let out = across.normalize();
        let along = rise.normalize_or_zero();
        let lean =
            ge * (along.dot(f.cross(normal)) / square) + gf * (along.dot(normal.cross(e)) / square);
        let normal = normal / square.sqrt();
        Some(Frame {
            corners,
            grain,
            directions: [normal.cross(along), normal, along],
            across: [-out.perp(), out],
            lean: lean.truncate(),
            zone: self.zone(t),
            sector: self.sectors[self.piece.triangles[t][0] as usize],
        })
    }
}

/// Returns the gradient of the length in the piece, and the square of its slope along the face, by two edges of a triangle and the
/// same edges in grain coordinates; none where it has no area.
fn slope([e, f]: [DVec3; 2], [ge, gf]: [DVec3; 2]) -> Option<(DVec3, f64)> {
    let normal = e.cross(f);
    let square = normal.length_squared();
    if square <= 0.0 || ge.cross(gf).truncate() == DVec2::ZERO {
        return None;
    }
    // By the dual basis of the edges.
    let rise = f.cross(normal) * (ge.z / square) + normal.cross(e) * (gf.z / square);
    let scale = |grain: DVec3, edge: DVec3| grain.length_squared() / edge.length_squared();
    Some((rise, rise.length_squared() / scale(ge, e).max(scale(gf, f))))
}

/// Finds the torn walls of a piece, with the number of strands that each should have.
fn walls(piece: &Mesh, options: &FuzzOptions) -> Vec<Wall> {
    let size = size(options.stem);
    let density = DENSITY * options.amount / (size * size);
    let area_unit = options.units_per_metre * options.units_per_metre;
    let Some(face) = TornFace::of(piece) else {
        return Vec::new();
    };
    let triangles = (0..piece.triangles.len()).filter(|&t| piece.material(t) == options.material);
    let wall = |triangle: usize| {
        // Most of crushed and of brash wood is told apart by this alone.
        let [a, b, c] = face.grain(triangle).map(|g| g.z);
        let height = a.max(b).max(c) - a.min(b).min(c);
        let (low, high) = TORN_HEIGHT;
        let torn = smoothstep(low * size, high * size, height);
        if torn == 0.0 {
            return None;
        }
        let [a, b, c] = piece.corners(triangle);
        let grain = face.grain(triangle);
        let (_, steepness) = slope([b - a, c - a], [grain[1] - grain[0], grain[2] - grain[0]])?;
        if steepness < SIDE_GRAIN {
            return None;
        }
        let area = 0.5 * (b - a).cross(c - a).length() / area_unit;
        let middle = (grain[0] + grain[1] + grain[2]) / 3.0;
        let tufts = DVec3::new(1.0 / TUFT.0, 1.0 / TUFT.0, 1.0 / TUFT.1) / size;
        let tuft = gradient_3d(options.seed ^ PURPOSE, middle * tufts, 0).0;
        let clumped = 0.15 + 1.7 * smoothstep(-0.25, 0.45, tuft);
        let zone = face.zone(triangle);
        let zone = DENSITY_OF_ZONES[zone.min(Zone::ALL.len() - 1)];
        let strands = density * area * torn * clumped * zone;
        (strands > 0.0).then_some(Wall { triangle, strands })
    };
    triangles.filter_map(wall).collect()
}

/// Factor on the lengths and widths of strands on a stem.
fn size(stem: &Stem) -> f64 {
    let size = (stem.radius / REFERENCE_RADIUS).sqrt();
    size.clamp(SIZE_RANGE.0, SIZE_RANGE.1)
}

/// Draws a strand on a wall; none where it would reach out of the stem.
fn strand_on(
    frame: &Frame,
    (triangle, number): (usize, usize),
    options: &FuzzOptions,
) -> Option<Strand> {
    let random = |k: i64| unit(options.seed ^ PURPOSE, triangle as i64, number as i64, k);
    let place = |k: i64| {
        let (a, b) = (random(k), random(k + 1));
        let (a, b) = if a + b > 1.0 {
            (1.0 - a, 1.0 - b)
        } else {
            (a, b)
        };
        [1.0 - a - b, a, b]
    };
    let of = |w: [f64; 3], v: [DVec3; 3]| v[0] * w[0] + v[1] * w[1] + v[2] * w[2];
    let forward = if options.upper { -1.0 } else { 1.0 };
    // Most begin near the free end of the wall; some splinter off backwards.
    let (one, other) = (place(0), place(2));
    let ahead = forward * (of(one, frame.grain).z - of(other, frame.grain).z) > 0.0;
    let weights = if ahead == (random(4) < 0.85) {
        one
    } else {
        other
    };
    let direction = if random(5) < 0.05 { -forward } else { forward };
    let size = size(options.stem);
    let long = random(6);
    // Most are short, and lengths differ by a decade.
    let mut length =
        size * (0.5e-3 + 2.2e-3 * random(7) * random(7) + 10e-3 * long * long * long * long * long);
    // What stands out beyond the edge is short, but for a few hairs.
    let ahead = frame.grain.map(|g| direction * g.z);
    let edge = ahead[0].max(ahead[1]).max(ahead[2]) - direction * of(weights, frame.grain).z;
    let hair = random(17) * random(17) * random(17);
    let beyond = size * (0.6e-3 + 3.2e-3 * random(15) * random(16) + 6e-3 * hair * hair);
    length = length.min(edge + beyond);
    let width =
        size * (0.045e-3 + 0.08e-3 * random(8) * random(8)) + 0.02 * length * random(9) * random(9);
    // Most lie close, some stand off. Those beside each other bend to one side, so that they hardly cross, and all are bent.
    let loose = random(10);
    let lift = 0.02 + 0.27 * loose * loose * loose * loose;
    let place = of(weights, frame.grain) / (TUFT.0 * size);
    let together = |k: u64| gradient_3d(options.seed ^ PURPOSE ^ k << 40, place, 0).0;
    let curl = 0.1 + 0.5 * together(1) + 0.22 * random(11);
    let sway = 0.8 * together(2) + 0.12 * (random(12) - 0.5);
    let mut strand = Strand {
        root: Root {
            position: of(weights, frame.corners),
            grain: of(weights, frame.grain),
            directions: [
                frame.directions[0],
                frame.directions[1],
                frame.directions[2] * direction,
            ],
            zone: frame.zone as f32,
            sector: frame.sector,
        },
        forward: direction,
        length,
        width,
        thickness: width * (0.14 + 0.18 * random(13)),
        roll: 0.9 * (random(14) - 0.5),
        lift,
        curl,
        sway,
        ring: 0.0,
    };
    strand.ring = options.stem.rings.address(strand.root.grain.truncate()).0;
    if farthest_ring(&strand, frame, options) > OUTER_RING.max(strand.ring) {
        (strand.lift, strand.curl, strand.sway) = (0.02, 0.0, 0.2 * strand.sway);
        if farthest_ring(&strand, frame, options) > OUTER_RING.max(strand.ring) {
            return None;
        }
    }
    Some(strand)
}

/// The greatest ring coordinate that a strand reaches. One that curls back reaches farther before its tip.
fn farthest_ring(strand: &Strand, frame: &Frame, options: &FuzzOptions) -> f64 {
    let at = |part: f64| {
        let [beside, out] = strand.offset(part);
        let way = strand.forward * strand.length * part * options.units_per_metre;
        let across = frame.across[0] * beside + frame.across[1] * out + frame.lean * way;
        let ring = (options.stem.rings)
            .address(strand.root.grain.truncate() + across)
            .0;
        ring + (1.0 - part) * 0.5 * strand.width / options.stem.radius
    };
    [0.25, 0.5, 0.75, 1.0]
        .map(at)
        .into_iter()
        .fold(0.0, f64::max)
}
