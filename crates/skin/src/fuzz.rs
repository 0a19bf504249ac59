//! Fuzz: what torn fibres stand out of a broken face, along the sides of its splinters, on their edges and at their ends.
//!
//! Torn wood carries bundles of fibres 0.1 to 0.5 mm wide and 2 to 20 mm long, densely where it was torn (Hoadley, *Understanding
//! Wood*), slivers that came half off their splinters, and short, leaning ends of bundles where it was crushed or broke across. They
//! are too thin for the cells of a face. Each is a closed solid of the wood that it stands on: it begins within that wood and runs
//! along the grain, or is kinked; hairs and slivers lift towards their free ends. Together they are a mesh of their own beside the piece, so that the
//! piece stays one closed solid.

mod bark;
mod draw;
mod face;
mod flap;
mod hinge;
mod options;
mod strand;

pub use hinge::HingeOptions;
pub use options::FuzzOptions;

use bark::BARK;
use draw::{Draw, PURPOSE, TUFT, size};
use face::{SIDE_GRAIN, TornFace, slope};
use flap::add_flaps;
use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_wood::noise::{gradient_3d, smoothstep, unit};
use greenstick_wood::tissue::Zone;
use strand::StrandMesh;

/// Strands on each square metre with a fuzz of 1, on wood of the reference radius: hairs and slivers on torn side grain, and stubs
/// where wood was crushed and where it was torn.
const HAIRS: f64 = 7.5e5;
const SLIVERS: f64 = 1.6e5;
const CRUSHED_STUBS: f64 = 1.3e6;
const TORN_STUBS: f64 = 5.0e5;
/// The same of straps at the torn edge of bark.
const STRAPS: f64 = 1.3e6;
/// Share of straps that bark which broke short lacks, and the part of the height of its walls that counts.
const FEWER_STRAPS: f64 = 0.95;
const SHORT_BARK: f64 = 0.7;
/// Triangles of fuzz over those of the broken face, at most, with a fuzz of 1: of hairs, and of each kind where pieces are apart.
const MAX_SHARE: f64 = 0.6;
const MAX_SHARES_APART: [f64; 4] = [0.2, 0.14, 0.3, 0.12];
/// The same of flaps of bark.
const MAX_SHARE_OF_FLAPS: f64 = 0.2;
/// Mean number of triangles of each kind of strand (of a sliver, of all its laths), by which they are thinned out where they would be
/// too many.
const MEAN_TRIANGLES: [f64; 4] = [12.5, 18.0, 6.5, 20.0];
/// Heights of a wall of the face between which it counts as torn, m: lower ones are the steps of crushed and of brash wood.
const TORN_HEIGHT: (f64, f64) = (0.8e-3, 3.5e-3);
/// Heights of a wall between which it has slivers: those peel off the sides of slabs and of long splinters.
const PEELED_HEIGHT: (f64, f64) = (2.5e-3, 9e-3);
/// Greatest square of the slope of the length along a face that is an end.
const END_GRAIN: f64 = 0.85;
/// Size of the places where ends are few, so that the wood below them shows, m.
const BARE: f64 = 3.5e-3;
/// Number of the outermost tissue that slivers peel off and that breaks across in ends.
const SAPWOOD: usize = 2;
/// Density on pith, heartwood, sapwood, phloem and bark.
const DENSITY_OF_ZONES: [f64; 5] = [0.3, 0.9, 1.0, 1.2, 0.06];

/// Numbers from which on slivers and stubs of a triangle count, so that they share no random numbers with hairs.
const SLIVER_NUMBERS: usize = 1 << 20;
const STUB_NUMBERS: usize = 2 << 20;
const STRAP_NUMBERS: usize = 3 << 20;

/// A triangle that carries strands.
struct TornTriangle {
    triangle: usize,
    /// Expected numbers of hairs, slivers, stubs and straps of bark.
    strands: [f64; 4],
    /// How crushed the wood is, 0 to 1.
    crushed: f64,
    /// Whether it lies along the grain.
    is_wall: bool,
}

/// Makes the fuzz of a piece, which has the attributes of a broken face. It is empty where the face is not torn.
/// With a `hinge`, it has the fibres of that, too.
pub fn fuzz(piece: &Mesh, options: &FuzzOptions, hinge: Option<&HingeOptions>) -> Mesh {
    let mut made = StrandMesh::new(options);
    if let Some(hinge) = hinge {
        hinge.add(&mut made, options.most_triangles);
    }
    let Some(face) = TornFace::of(piece) else {
        return made.finish();
    };
    let heights = options
        .apart
        .then(|| TornHeights::of(piece, &face, options));
    let mut torn = torn_triangles(piece, &face, heights.as_ref(), options);
    let on_face = |&t: &usize| piece.material(t) == options.material;
    let of_face = (0..piece.triangles.len()).filter(on_face).count();
    let shares = if options.apart {
        MAX_SHARES_APART
    } else {
        [MAX_SHARE, 0.0, 0.0, 0.0]
    };
    let mut most = 0.0;
    for (k, share) in shares.into_iter().enumerate() {
        let expected = torn.iter().map(|t| t.strands[k]).sum::<f64>() * MEAN_TRIANGLES[k];
        let room = share * options.amount * of_face as f64;
        most += room;
        if expected > room {
            let part = room / expected;
            torn.iter_mut().for_each(|t| t.strands[k] *= part);
        }
    }
    let most = (most as usize + made.triangles()).min(options.most_triangles);
    for on in &torn {
        let random = |k: usize| unit(options.seed ^ PURPOSE, on.triangle as i64, -1, k as i64);
        let counts = [0, 1, 2, 3].map(|k| (on.strands[k] + random(k)) as usize);
        add_strands(&mut made, &face, on, counts, most);
    }
    if let Some(heights) = &heights {
        let torn = |point: u32| heights.torn(heights.highest[point as usize]);
        let room = MAX_SHARE_OF_FLAPS * options.amount * of_face as f64;
        add_flaps(&mut made, piece, &face, (&heights.points, torn), room);
    }
    made.finish()
}

/// How high the walls of a face are.
struct TornHeights {
    /// The point of each vertex.
    points: Vec<u32>,
    /// The height of the highest wall about each point, m.
    highest: Vec<f64>,
    /// Heights of a wall between which it counts as torn, m.
    torn_from: (f64, f64),
}

impl TornHeights {
    fn of(piece: &Mesh, face: &TornFace, options: &FuzzOptions) -> Self {
        let (points, count) = piece.points();
        let mut highest = vec![0.0f64; count];
        for t in (0..piece.triangles.len()).filter(|&t| piece.material(t) == options.material) {
            let height = rise(face, t);
            for v in piece.triangles[t] {
                let known = &mut highest[points[v as usize] as usize];
                *known = known.max(height);
            }
        }
        TornHeights {
            points,
            highest,
            torn_from: torn_from(options),
        }
    }

    /// How much a wall of a height (m) is torn, 0 to 1.
    fn torn(&self, height: f64) -> f64 {
        smoothstep(self.torn_from.0, self.torn_from.1, height)
    }

    /// The height of the highest wall about the corners of a triangle.
    fn beside(&self, corners: [u32; 3]) -> f64 {
        let about = corners.map(|v| self.highest[self.points[v as usize] as usize]);
        about.into_iter().fold(0.0, f64::max)
    }
}

/// Heights of a wall between which it counts as torn, m.
fn torn_from(options: &FuzzOptions) -> (f64, f64) {
    let size = size(options.stem);
    (TORN_HEIGHT.0 * size, TORN_HEIGHT.1 * size)
}

/// How far a triangle reaches along the grain, m.
fn rise(face: &TornFace, t: usize) -> f64 {
    let [a, b, c] = face.grain(t).map(|g| g.z);
    a.max(b).max(c) - a.min(b).min(c)
}

/// Adds numbers of hairs, slivers, stubs and straps that a triangle carries, as long as there are no more triangles than `most`.
fn add_strands(
    made: &mut StrandMesh,
    face: &TornFace,
    on: &TornTriangle,
    [hairs, slivers, stubs, straps]: [usize; 4],
    most: usize,
) {
    let options = made.options();
    let draw = |number: usize| Draw {
        options,
        place: (on.triangle, number),
    };
    let mut strands = Vec::new();
    // Most triangles have none.
    if hairs + slivers > 0
        && let Some(frame) = face.frame(on.triangle)
    {
        strands.extend((0..hairs).filter_map(|n| draw(n).hair(&frame)));
        strands.extend((0..slivers).flat_map(|n| draw(SLIVER_NUMBERS + n).sliver(&frame)));
    }
    for number in 0..stubs {
        let draw = draw(STUB_NUMBERS + number);
        let side = draw.side(face.grain(on.triangle)[0]);
        let forward = if options.upper { -1.0 } else { 1.0 };
        let frame = face.end_frame(on.triangle, side, forward);
        strands.extend(frame.and_then(|frame| draw.stub(&frame, on.crushed)));
    }
    for number in 0..straps {
        let draw = draw(STRAP_NUMBERS + number);
        let frame = match on.is_wall {
            true => face.frame(on.triangle),
            false => {
                let from_pith = face.grain(on.triangle)[0].truncate() - options.stem.rings.pith();
                let forward = if options.upper { -1.0 } else { 1.0 };
                face.end_frame(on.triangle, draw.outwards(from_pith), forward)
            }
        };
        strands.extend(frame.iter().flat_map(|frame| draw.strap(frame)));
    }
    for strand in strands {
        if made.triangles() + strand.triangles() <= most {
            made.add(&strand);
        }
    }
}

/// Finds the triangles of a piece that carry strands, with the numbers that each should have. `heights` are those of a piece that was
/// moved apart: an end is torn where a wall beside it is high.
fn torn_triangles(
    piece: &Mesh,
    face: &TornFace,
    heights: Option<&TornHeights>,
    options: &FuzzOptions,
) -> Vec<TornTriangle> {
    let size = size(options.stem);
    let density = options.amount / (size * size);
    let area_unit = options.units_per_metre * options.units_per_metre;
    let triangles = (0..piece.triangles.len()).filter(|&t| piece.material(t) == options.material);
    let torn_from = torn_from(options);
    let torn_at = |height: f64| smoothstep(torn_from.0, torn_from.1, height);
    let highest_beside = |t: usize| heights.map_or(0.0, |h| h.beside(piece.triangles[t]));
    let on = |triangle: usize| {
        let height = rise(face, triangle);
        let torn = torn_at(height);
        // Most of crushed and of brash wood is told apart by this alone.
        if torn == 0.0 && heights.is_none() {
            return None;
        }
        let [a, b, c] = piece.corners(triangle);
        let grain = face.grain(triangle);
        let (_, steepness) = slope([b - a, c - a], [grain[1] - grain[0], grain[2] - grain[0]])?;
        let area = 0.5 * (b - a).cross(c - a).length() / area_unit;
        let middle = (grain[0] + grain[1] + grain[2]) / 3.0;
        let of_wood = f64::from(u8::from(face.zone(triangle) <= SAPWOOD));
        let zone = DENSITY_OF_ZONES[face.zone(triangle).min(Zone::ALL.len() - 1)];
        let per_area = density * area * zone;
        let mut made = TornTriangle {
            triangle,
            strands: [0.0; 4],
            crushed: 0.0,
            is_wall: steepness >= SIDE_GRAIN,
        };
        if options.apart && face.zone(triangle) == BARK {
            // Where it broke short, hardly a string hangs on.
            let short = 1.0 - torn_at(SHORT_BARK * highest_beside(triangle));
            made.strands[3] = STRAPS * density * area * (1.0 - FEWER_STRAPS * short);
        }
        if steepness >= SIDE_GRAIN && torn > 0.0 {
            let tufts = DVec3::new(1.0 / TUFT.0, 1.0 / TUFT.0, 1.0 / TUFT.1) / size;
            let tuft = gradient_3d(options.seed ^ PURPOSE, middle * tufts, 0).0;
            let clumped = 0.15 + 1.7 * smoothstep(-0.25, 0.45, tuft);
            made.strands[0] = HAIRS * per_area * torn * clumped;
            if options.apart {
                let (low, high) = PEELED_HEIGHT;
                made.strands[1] =
                    SLIVERS * per_area * of_wood * smoothstep(low * size, high * size, height);
            }
        }
        if steepness < END_GRAIN && heights.is_some() {
            let torn = torn_at(highest_beside(triangle));
            made.crushed = 1.0 - torn;
            let tuft = gradient_3d(options.seed ^ PURPOSE, middle / (BARE * size), 0).0;
            let clumped = 0.2 + 0.8 * smoothstep(-0.3, 0.15, tuft);
            made.strands[2] =
                of_wood * clumped * (TORN_STUBS * torn + CRUSHED_STUBS * made.crushed) * per_area;
        }
        made.strands.iter().any(|&n| n > 0.0).then_some(made)
    };
    triangles.filter_map(on).collect()
}
