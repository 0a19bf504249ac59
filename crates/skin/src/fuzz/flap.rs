//! Flaps: plates of bark that tore farther out than the bark beside them and lifted off the wood. Outside they are the bark of the piece
//! that they stand on, with its material and texture, inside they show the bast that they tore off with.

use super::draw::{PURPOSE, between, size};
use super::face::{Frame, SIDE_GRAIN, TornFace, dual_basis};
use super::options::FuzzOptions;
use super::strand::{StrandMesh, StrandVertex};
use glam::{DVec2, DVec3};
use greenstick_geometry::Mesh;
use greenstick_wood::noise::unit;
use greenstick_wood::tissue::Zone;
use std::f64::consts::TAU;

/// Parts of the edge of the bark around a stem that may have a flap each, the share of them that has one where the bark was torn, and the
/// part of that which has one where it broke short, beside torn bark.
const PLACES: i64 = 37;
const SHARE: f64 = 0.95;
const LEAST_TORN: f64 = 0.45;
/// The fuzz from which on there are as many.
const ALL_FROM: f64 = 0.5;
/// Widths of flaps, and lengths over their widths, m: bark tears along its furrows.
const WIDTH: (f64, f64) = (1.6e-3, 9.0e-3);
const SLENDERNESS: (f64, f64) = (0.7, 2.3);
const LONGEST: f64 = 15e-3;
/// Depth of their roots below the edge of the bark, and how far they are sunk into it there, thicknesses.
const ROOT: f64 = 1.6e-3;
const SUNK: f64 = 0.4;
/// Slopes at which they leave the stem, and by how much they are bent away from it up to their ends, rad. Few are bent far.
const LIFT: (f64, f64) = (0.04, 0.4);
const CURL: (f64, f64) = (0.04, 0.7);
/// By how much one side is bent farther than the other, rad.
const WARP: f64 = 0.5;
/// Thickness over the distance from the pith, and what is left of it at the end.
const THICKNESS: (f64, f64) = (0.035, 0.06);
const THIN_END: f64 = 0.75;
/// How much narrower the end is, at most, and how much shorter parts of its width are.
const NARROWER: f64 = 0.22;
const RAGGED: f64 = 0.5;
/// By how much nodes at its sides lie off them, over its width, and those inside off its inner side, thicknesses: bark is crumbly.
const CRUMBLED: f64 = 0.09;
const UNEVEN: f64 = 0.45;
/// Part of the distance from the pith at which the bast lies that it tore off with.
const BAST: f64 = 0.918;
/// Parts of a flap across and along it.
const ACROSS: usize = 5;
const ALONG: usize = 5;
/// Least cosine between the outside of a triangle and the direction away from the pith of bark that has flaps.
const OUTWARDS: f64 = 0.5;
/// In the hash: random numbers of flaps, beside those of the strands of triangles.
const FLAPS: i64 = -7;

/// A triangle of the skin at the edge of torn bark.
struct Edge {
    triangle: usize,
    /// The corner at which the bark tore.
    corner: usize,
    /// Angle about the pith, rad.
    angle: f64,
    /// How torn the wood is there, 0 to 1.
    torn: f64,
}

/// Adds the flaps of a piece, about as many as have `room` triangles, as long as its fuzz has no more than it may. `torn` says of each point
/// of the piece how torn the wood is there, 0 to 1; `points` are the points of its vertices.
pub(super) fn add_flaps(
    made: &mut StrandMesh,
    piece: &Mesh,
    face: &TornFace,
    (points, torn): (&[u32], impl Fn(u32) -> f64),
    room: f64,
) {
    let options = made.options();
    if !options.stem.kind.has_bark() {
        return;
    }
    let edges = edges(piece, face, points, torn, options);
    let random = |place: i64, k: i64| flap_random(options, place, k);
    // Bark that broke short has none.
    let most_torn = |edges: &mut dyn Iterator<Item = &Edge>| {
        edges.fold(0.0, |most: f64, edge| most.max(edge.torn))
    };
    let most_of_all = most_torn(&mut edges.iter());
    let thinned = room / (SHARE * (PLACES as usize * Flap::TRIANGLES) as f64);
    let share = SHARE * (options.amount / ALL_FROM).min(thinned).min(1.0);
    for place in 0..PLACES {
        let middle = TAU * (place as f64 + 0.2 + 0.6 * random(place, -1)) / PLACES as f64;
        let off = |edge: &&Edge| {
            let off = (edge.angle - middle) / TAU;
            (off - off.round()).abs()
        };
        let Some(edge) = (edges.iter()).min_by(|a, b| off(a).total_cmp(&off(b))) else {
            return;
        };
        let is_near = |edge: &&Edge| off(edge) * (PLACES as f64) < 0.5;
        let here = most_torn(&mut edges.iter().filter(is_near));
        let torn = LEAST_TORN * most_of_all + (1.0 - LEAST_TORN) * here;
        if !is_near(&edge) || random(place, -2) >= share * torn {
            continue;
        }
        let Some(flap) = Flap::new(piece, face, edge, options, place) else {
            continue;
        };
        if made.triangles() + Flap::TRIANGLES <= options.most_triangles {
            flap.add_to(made);
        }
    }
}

/// Finds the triangles of the skin at the edge of torn bark.
fn edges(
    piece: &Mesh,
    face: &TornFace,
    points: &[u32],
    torn: impl Fn(u32) -> f64,
    options: &FuzzOptions,
) -> Vec<Edge> {
    let mut is_torn_bark = vec![false; points.iter().max().map_or(0, |&p| p as usize + 1)];
    let is_inside = |t: usize| piece.material(t) == options.material;
    for t in (0..piece.triangles.len()).filter(|&t| is_inside(t)) {
        for v in piece.triangles[t] {
            if face.zone_of(v) >= usize::from(Zone::Phloem.code()) {
                is_torn_bark[points[v as usize] as usize] = true;
            }
        }
    }
    let mut edges = Vec::new();
    for t in (0..piece.triangles.len()).filter(|&t| !is_inside(t)) {
        let corners = piece.triangles[t];
        let at_edge = |k: &usize| is_torn_bark[points[corners[*k] as usize] as usize];
        let Some(corner) = (0..3).find(at_edge) else {
            continue;
        };
        let from_pith = face.grain(t)[corner].truncate() - options.stem.rings.pith();
        let Some(frame) = face.frame(t) else {
            continue;
        };
        let outwards = frame.across[1].dot(from_pith.normalize_or_zero());
        if outwards < OUTWARDS || frame.steepness < SIDE_GRAIN {
            continue;
        }
        edges.push(Edge {
            triangle: t,
            corner,
            angle: libm::atan2(from_pith.y, from_pith.x),
            torn: torn(points[corners[corner] as usize]),
        });
    }
    edges
}

/// A flap.
struct Flap<'a> {
    piece: &'a Mesh,
    frame: Frame,
    edge: &'a Edge,
    options: &'a FuzzOptions<'a>,
    /// Distance from the pith, m.
    radius: f64,
    width: f64,
    /// Lengths of its parts across, m.
    lengths: [f64; ACROSS + 1],
    thickness: f64,
    narrower: f64,
    /// To which side it narrows, −0.5 to 0.5.
    toward: f64,
    lift: f64,
    curl: f64,
    warp: f64,
    /// In the hash.
    number: i64,
}

/// A place on a flap.
struct Place {
    /// Beside its root, out of the bark there and along the grain, m.
    at: DVec3,
    /// Unit normal of its outside, likewise.
    normal: DVec3,
    /// The same place before it was torn off.
    flat: DVec3,
    thickness: f64,
}

impl<'a> Flap<'a> {
    /// Number of the triangles of one: both sides and all around.
    const TRIANGLES: usize = 2 * 2 * ACROSS * ALONG + 2 * 2 * (ACROSS + ALONG);

    fn new(
        piece: &'a Mesh,
        face: &TornFace,
        edge: &'a Edge,
        options: &'a FuzzOptions<'a>,
        number: i64,
    ) -> Option<Self> {
        let random = |k: i64| flap_random(options, number, k);
        let size = size(options.stem);
        let frame = face.frame(edge.triangle)?;
        let from_pith = frame.grain[edge.corner].truncate() - options.stem.rings.pith();
        let radius = from_pith.length();
        // Most are small.
        let width = size * between(WIDTH, (random(0) * random(1)).powf(1.5));
        let length = (width * between(SLENDERNESS, random(2))).min(LONGEST * size);
        // One side is the longer, and its edge is ragged.
        let slant = random(3) - 0.5;
        let lengths = std::array::from_fn(|k| {
            let across = k as f64 / ACROSS as f64 - 0.5;
            length * (1.0 - RAGGED * (random(20 + k as i64) + slant * across))
        });
        Some(Flap {
            piece,
            frame,
            edge,
            options,
            radius,
            width,
            lengths,
            thickness: radius * between(THICKNESS, random(4)),
            narrower: NARROWER * random(5),
            toward: random(6) - 0.5,
            lift: between(LIFT, random(7) * random(8)),
            curl: between(CURL, random(9) * random(10)),
            warp: WARP * (random(11) - 0.5),
            number,
        })
    }

    fn random(&self, k: i64) -> f64 {
        flap_random(self.options, self.number, k)
    }

    /// The place of a node of the flap, counted across it and along it.
    fn place(&self, across: usize, along: usize) -> Place {
        let is_side = across == 0 || across == ACROSS;
        let own = |k: i64| self.random(100 + (along * (ACROSS + 1) + across) as i64 * 2 + k) - 0.5;
        let part = along as f64 / ALONG as f64;
        let length = self.lengths[across];
        let root = ROOT * size(self.options.stem);
        let s = part * (length + root) - root;
        let beyond = s.max(0.0);
        let narrow = 1.0 - self.narrower * (beyond / length).powi(2);
        let across = across as f64 / ACROSS as f64 - 0.5;
        let crumbled = if is_side { CRUMBLED * own(0) } else { 0.0 };
        let x = self.width * (across * narrow + self.toward * (1.0 - narrow) + crumbled);
        // It is bent to an arc beyond the edge.
        let most = self.curl + self.warp * across;
        let bent = most * beyond / length;
        let (start, end) = (self.lift, self.lift + bent);
        let chord = 0.5 * (start + end);
        let (sin, cos) = libm::sincos(chord);
        // The chord of an arc is shorter than the arc.
        let shorter = 1.0 - bent * bent / 24.0;
        let round = -0.5 * x * x / self.radius;
        let sunk = SUNK * self.thickness * (-s / root).clamp(0.0, 1.0);
        let out = sin * shorter * beyond + round - sunk;
        let z = if s > 0.0 { cos * shorter * beyond } else { s };
        let (sin, cos) = libm::sincos(if s > 0.0 { end } else { 0.0 });
        Place {
            at: DVec3::new(x, out, z),
            normal: DVec3::new(x / self.radius, cos, -sin).normalize(),
            flat: DVec3::new(x, round, s),
            thickness: self.thickness * (1.0 - (1.0 - THIN_END) * part) * (1.0 + UNEVEN * own(1)),
        }
    }

    fn add_to(&self, made: &mut StrandMesh) {
        let bark = self.piece.material(self.edge.triangle);
        let nodes: Vec<Place> = (0..=ALONG)
            .flat_map(|j| (0..=ACROSS).map(move |i| (i, j)))
            .map(|(i, j)| self.place(i, j))
            .collect();
        let node = |i: usize, j: usize| j * (ACROSS + 1) + i;
        let first = made.vertices();
        let outside = |n: usize| first + n as u32;
        let inside = |n: usize| first + (nodes.len() + n) as u32;
        for place in &nodes {
            made.push(StrandVertex {
                coordinates: self.skin_coordinates(place),
                ..self.vertex(place, 0.0, place.normal)
            });
        }
        for place in &nodes {
            made.push(self.vertex(place, 1.0, -place.normal));
        }
        let inner = self.options.material;
        for j in 0..ALONG {
            for i in 0..ACROSS {
                let [a, b] = [node(i, j), node(i + 1, j)];
                let [c, d] = [node(i, j + 1), node(i + 1, j + 1)];
                for [x, y, z] in [[a, b, d], [a, d, c]] {
                    self.triangle(made, [x, y, z].map(outside), bark);
                    self.triangle(made, [x, z, y].map(inside), inner);
                }
            }
        }
        // All around it.
        let right = (0..ALONG).map(|j| node(ACROSS, j));
        let end = (1..=ACROSS).rev().map(|i| node(i, ALONG));
        let left = (1..=ALONG).rev().map(|j| node(0, j));
        let around: Vec<usize> = ((0..ACROSS).map(|i| node(i, 0)))
            .chain(right)
            .chain(end)
            .chain(left)
            .collect();
        let start = made.vertices();
        let count = around.len();
        for (k, &n) in around.iter().enumerate() {
            let way = nodes[around[(k + 1) % count]].at - nodes[around[(k + count - 1) % count]].at;
            let normal = (nodes[n].normal.cross(way)).normalize_or(nodes[n].normal);
            for depth in [0.0, 1.0] {
                made.push(self.vertex(&nodes[n], depth, normal));
            }
        }
        for k in 0..count {
            let [a, b] = [k, (k + 1) % count].map(|k| start + 2 * k as u32);
            self.triangle(made, [a, b + 1, b], inner);
            self.triangle(made, [a, a + 1, b + 1], inner);
        }
    }

    /// Adds a triangle, which runs to the right as seen from outside where the third direction is along the grain.
    fn triangle(&self, made: &mut StrandMesh, [a, b, c]: [u32; 3], material: u32) {
        let turned = if self.forward() > 0.0 {
            [a, c, b]
        } else {
            [a, b, c]
        };
        made.triangle(turned, material);
    }

    fn forward(&self) -> f64 {
        if self.options.upper { -1.0 } else { 1.0 }
    }

    /// The vertex at a place, at a depth of 0 outside to 1 inside, with a normal in the coordinates of places.
    fn vertex(&self, place: &Place, depth: f64, normal: DVec3) -> StrandVertex {
        let Frame {
            corners,
            grain,
            directions: [beside, out, along],
            across,
            ..
        } = &self.frame;
        let options = self.options;
        let along = *along * self.forward();
        let to_piece = |v: DVec3| *beside * v.x + *out * v.y + along * v.z;
        let at = place.at - place.normal * (depth * place.thickness);
        let corner = self.edge.corner;
        let position = corners[corner] + to_piece(at) * options.units_per_metre;
        // The bark that it was.
        let pith = options.stem.rings.pith();
        let section =
            grain[corner].truncate() + across[0] * place.flat.x + across[1] * place.flat.y;
        let section = pith + (section - pith) * (1.0 + (BAST - 1.0) * depth);
        let grain = section.extend(grain[corner].z + self.forward() * place.flat.z);
        let ring = options.stem.rings.address(section).0;
        let inside = options.square.side_grain(ring, 0.0, grain.z);
        StrandVertex {
            position,
            normal: to_piece(normal).normalize_or(*out),
            coordinates: inside.as_vec2().to_array(),
            ring,
            sector: self.frame.sector,
            zone: f32::from(Zone::Bark.code()),
            grain,
        }
    }

    /// Texture coordinates of the bark of the piece at a place, as those of its triangle at the edge go on.
    fn skin_coordinates(&self, place: &Place) -> [f32; 2] {
        let Some(known) = self.piece.attributes.get("TEXCOORD_0") else {
            return [0.0; 2];
        };
        let of = |k: usize| {
            let at = known.at(self.piece.triangles[self.edge.triangle][k] as usize);
            DVec2::new(f64::from(at[0]), f64::from(at[1]))
        };
        let [a, b, c] = self.frame.corners;
        let [beside, _, along] = self.frame.directions;
        let way = beside * place.flat.x + along * (self.forward() * place.flat.z);
        let way = way * self.options.units_per_metre;
        let weights = dual_basis([b - a, c - a]).map(|of_edge| of_edge.dot(way));
        let here = of(self.edge.corner);
        let moved = (of(1) - of(0)) * weights[0] + (of(2) - of(0)) * weights[1];
        (here + moved).as_vec2().to_array()
    }
}

/// A random number of a flap.
fn flap_random(options: &FuzzOptions, number: i64, k: i64) -> f64 {
    unit(options.seed ^ PURPOSE, number, FLAPS, k)
}
