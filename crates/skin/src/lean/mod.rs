//! Leaning splinters: torn wood springs apart, so that every large splinter leans and is bowed in its own way, and gaps open
//! between them.
//!
//! The halves of a break are cut along one surface, on which all splinters stand along the grain. Each half is then bent by
//! itself: its splinters move, the sockets that they left in the other half stay straight. Where splinters would cross, they lean
//! less.

mod bend;
pub(crate) mod place;
mod tree;

pub use bend::SplinterLean;

use crate::fray::push_vertex_between;
use crate::prepared::PreparedStem;
use bend::Leans;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::repair::crossing_pairs;
use greenstick_geometry::{Aabb, Mesh};
use greenstick_wood::noise::smoothstep;
use place::FacetPlaces;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::fmt;
use tree::SplinterTree;

/// Greatest distance between a bowed splinter and the straight edges that show it, radii.
const PRECISION: f64 = 0.012;
/// Height of an edge below which it cannot be farther off, radii.
const LEAST_RISE: f64 = 0.1;
/// How often edges are halved for it.
const HALVINGS: usize = 4;
/// Greatest difference of the displacements at the ends of an edge: over its height, and whatever that is, radii.
const MOST_SHEAR: f64 = 0.6;
const SLACK: f64 = 0.03;
/// Rounds in which splinters that cross lean less.
const ROUNDS: usize = 24;
/// Rounds after which everything about a crossing that is left stays straight.
const PATIENCE: usize = 14;
/// Distances from the section's middle, over its half width, between which other limbs beside the stem stop to move along.
const BESIDE: (f64, f64) = (1.3, 2.5);
/// Leans from which on a splinter counts as leaning, degrees.
const LEANING: f64 = 1.0;

/// How the splinters of a piece lean.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct LeanReport {
    /// Splinters that lean by a degree or more.
    pub splinters: usize,
    /// Splinters that stay straight, as they would cross others.
    pub straight: usize,
    /// Mean and greatest angle between leaning splinters and the grain, degrees.
    pub mean_degrees: f64,
    /// See above.
    pub greatest_degrees: f64,
    /// Median of their lengths, m.
    pub median_length_m: f64,
    /// Volume of the piece while its splinters were straight, m³; none unless it is closed.
    pub straight_volume_m3: Option<f64>,
}

impl fmt::Display for LeanReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{} splinters by {:.1}° on average, {:.1}° at most, {} straight",
            self.splinters, self.mean_degrees, self.greatest_degrees, self.straight
        )
    }
}

/// A piece whose splinters are to lean.
#[derive(Clone, Copy)]
pub struct LeaningPiece<'a> {
    /// The stem.
    pub stem: &'a PreparedStem,
    /// The face.
    pub surface: &'a FractureSurface,
    /// Number of its cells.
    pub cells: usize,
    /// Whether the piece lies beyond the break.
    pub upper: bool,
    /// Mean lean, degrees.
    pub degrees: f64,
    /// Seed of the break.
    pub seed: u64,
}

/// A piece with its splinters leaning.
#[derive(Debug, Clone)]
pub struct LeanedPiece {
    /// Its mesh.
    pub mesh: Mesh,
    /// How they lean.
    pub report: LeanReport,
    /// Each of them.
    pub splinters: Vec<SplinterLean>,
}

/// Where things are while a piece is bent.
struct Map<'a> {
    stem: &'a PreparedStem,
    transform: DAffine3,
    inverse: DAffine3,
    places: FacetPlaces<'a>,
    sign: f64,
    middle: DVec2,
    reach: f64,
}

/// A point of the mesh.
#[derive(Clone, Copy)]
struct Spot {
    grain: DVec3,
    /// Its cell; none where it stays.
    cell: Option<u32>,
    /// How much of the displacement it has.
    share: f64,
}

impl LeaningPiece<'_> {
    /// Bends the splinters of a mesh of the piece. A mesh with triangles that cross when nothing leans keeps them.
    pub fn bend(&self, mesh: &Mesh) -> LeanedPiece {
        let sign = if self.upper { -1.0 } else { 1.0 };
        let radius = self.stem.found.stem.radius;
        let tree = SplinterTree::new(self.surface, sign, self.cells);
        let seed = self.seed + u64::from(self.upper);
        let mut leans = Leans::new(tree, radius, self.degrees, seed);
        let transform = *self.stem.transform();
        let map = Map {
            stem: self.stem,
            inverse: transform.inverse(),
            transform,
            places: FacetPlaces::new(self.surface, sign),
            sign,
            middle: self.stem.square.middle,
            reach: self.stem.square.side / 2.0,
        };
        let foot = leans.foot();
        let mut mesh = mesh.clone();
        let mut spots: Vec<Spot> = Vec::new();
        map.spots(&mesh, foot, &mut spots);
        let mut coarse = FxHashMap::default();
        for _ in 0..HALVINGS {
            if !map.halve(&mut mesh, (&leans, foot), &mut spots, &mut coarse) {
                break;
            }
        }
        let mut bent: Vec<DVec3> = map.bent(&mesh, &spots, &leans);
        let mut done = false;
        let mut crossings = Crossings::new(&mesh, &spots, &bent);
        for round in 0..ROUNDS {
            let torn = map.torn(&mesh, &spots, &leans);
            if crossings.pairs.is_empty() && torn.is_empty() {
                done = true;
                break;
            }
            let mut blamed: Vec<u32> = (crossings.vertices().chain(torn))
                .filter_map(|v| {
                    let spot = spots[v as usize];
                    leans.blame(spot.cell?, sign * spot.grain.z)
                })
                .collect();
            blamed.sort_unstable();
            blamed.dedup();
            if blamed.is_empty() {
                break;
            }
            for _ in 0..=usize::from(round >= PATIENCE) * 3 {
                leans.damp(&blamed);
            }
            let before = std::mem::replace(&mut bent, map.bent(&mesh, &spots, &leans));
            crossings.update(&before, &bent);
        }
        if !done {
            // Whatever it is, it is no longer the lean.
            leans.straighten();
            bent.clone_from(&mesh.positions);
        }
        map.turn_normals(&mut mesh, &spots, &leans);
        mesh.positions = bent;
        let splinters = leans.splinters();
        let report = report(&splinters);
        LeanedPiece {
            mesh,
            report,
            splinters,
        }
    }
}

/// Returns what is reported of leans.
fn report(splinters: &[SplinterLean]) -> LeanReport {
    let leaning = splinters.iter().filter(|s| s.degrees >= LEANING);
    let (degrees, mut lengths): (Vec<f64>, Vec<f64>) =
        leaning.map(|s| (s.degrees, s.length)).unzip();
    lengths.sort_unstable_by(f64::total_cmp);
    LeanReport {
        splinters: degrees.len(),
        straight: splinters.len() - degrees.len(),
        mean_degrees: degrees.iter().sum::<f64>() / degrees.len().max(1) as f64,
        greatest_degrees: degrees.iter().copied().fold(0.0, f64::max),
        median_length_m: lengths.get(lengths.len() / 2).copied().unwrap_or_default(),
        straight_volume_m3: None,
    }
}

/// The triangles of a piece that may cross when splinters lean, and the pairs that do.
struct Crossings {
    triangles: Vec<[u32; 3]>,
    /// Whether each can move.
    moves: Vec<bool>,
    /// Pairs of numbers in `triangles` that cross.
    pairs: Vec<[u32; 2]>,
}

impl Crossings {
    /// Finds them for vertices at `bent`.
    fn new(mesh: &Mesh, spots: &[Spot], bent: &[DVec3]) -> Self {
        let can_move = |t: &[u32; 3]| t.iter().any(|&v| spots[v as usize].cell.is_some());
        let around = |t: &[u32; 3]| {
            let straight = Aabb::around(&t.map(|v| mesh.positions[v as usize]));
            straight.join(&Aabb::around(&t.map(|v| bent[v as usize])))
        };
        let moving = mesh.triangles.iter().filter(|t| can_move(t));
        let reach = moving.fold(Aabb::EMPTY, |reach, t| reach.join(&around(t)));
        let near: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&t| around(&mesh.triangles[t as usize]).overlaps(&reach))
            .collect();
        let triangles: Vec<[u32; 3]> = near.iter().map(|&t| mesh.triangles[t as usize]).collect();
        let mut found = Crossings {
            moves: triangles.iter().map(can_move).collect(),
            pairs: crossing_pairs(bent, &triangles, None),
            triangles,
        };
        found.leave_out_faults_of_the_input();
        found
    }

    fn leave_out_faults_of_the_input(&mut self) {
        let moves = &self.moves;
        self.pairs.retain(|p| p.iter().any(|&t| moves[t as usize]));
    }

    /// Brings the pairs up to date after vertices have moved from the first positions to the second.
    fn update(&mut self, before: &[DVec3], bent: &[DVec3]) {
        let moved = |t: &[u32; 3]| t.iter().any(|&v| bent[v as usize] != before[v as usize]);
        let changed: Vec<u32> = (self.triangles.iter().zip(0..))
            .filter_map(|(t, number)| moved(t).then_some(number))
            .collect();
        let kept = |p: &[u32; 2]| p.iter().all(|t| changed.binary_search(t).is_err());
        self.pairs.retain(kept);
        let found = crossing_pairs(bent, &self.triangles, Some(&changed));
        self.pairs.extend(found);
        self.pairs.sort_unstable();
        self.pairs.dedup();
        self.leave_out_faults_of_the_input();
    }

    /// Vertices of triangles that cross.
    fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        let triangles = self.pairs.iter().flatten();
        triangles.flat_map(|&t| self.triangles[t as usize])
    }
}

impl Map<'_> {
    /// Adds the spots of vertices that have none yet.
    fn spots(&self, mesh: &Mesh, foot: f64, spots: &mut Vec<Spot>) {
        let new = mesh.positions[spots.len()..].iter();
        spots.extend(new.map(|&p| self.spot(p, foot)).collect::<Vec<_>>());
    }

    fn spot(&self, place: DVec3, foot: f64) -> Spot {
        let grain = self
            .stem
            .layers
            .to_grain(self.transform.transform_point3(place));
        let (off, at) = (grain.truncate() - self.middle, grain.truncate());
        let beside = off.length() / self.reach;
        let share = 1.0 - smoothstep(BESIDE.0, BESIDE.1, beside);
        let moves = grain.is_finite() && self.sign * grain.z > foot && share > 0.0;
        // What sticks out of the section goes along with the wood that it grew on.
        let inwards = [1.0, 0.97, 0.94, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5];
        let cell = |at: DVec2| self.places.cell(at, self.sign * grain.z);
        let within = |part: f64| cell(self.middle + off * (part / beside.max(1.0)));
        let cell = moves
            .then(|| cell(at).or_else(|| inwards.into_iter().find_map(within)))
            .flatten();
        Spot { grain, cell, share }
    }

    /// Displacement of a spot in the section, m, and its slope.
    fn displacement(&self, spot: &Spot, leans: &Leans) -> Option<(DVec2, DVec2)> {
        let (by, slope) = leans.at(spot.cell?, self.sign * spot.grain.z);
        let moves = by != DVec2::ZERO || slope != DVec2::ZERO;
        moves.then_some((by * spot.share, slope * (spot.share * self.sign)))
    }

    /// Returns the positions of the vertices with the splinters leaning.
    fn bent(&self, mesh: &Mesh, spots: &[Spot], leans: &Leans) -> Vec<DVec3> {
        let places = mesh.positions.iter().zip(spots);
        let bend = |(&place, spot): (&DVec3, &Spot)| match self.displacement(spot, leans) {
            Some((by, _)) if by != DVec2::ZERO => place + self.across(spot, by),
            _ => place,
        };
        places.map(bend).collect()
    }

    /// Returns the ends of edges that would be drawn out, as where a vertex that was moved by a repair is taken for another
    /// splinter's.
    fn torn(&self, mesh: &Mesh, spots: &[Spot], leans: &Leans) -> Vec<u32> {
        let radius = self.stem.found.stem.radius;
        let by = |spot: &Spot| self.displacement(spot, leans).map_or(DVec2::ZERO, |d| d.0);
        let ways: Vec<DVec2> = spots.iter().map(by).collect();
        let is_torn = |&[v, w]: &[u32; 2]| {
            let [v, w] = [v as usize, w as usize];
            let rise = (spots[v].grain.z - spots[w].grain.z).abs();
            ways[v].distance(ways[w]) > MOST_SHEAR * rise + SLACK * radius
        };
        let edges = (mesh.triangles.iter()).flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.filter(is_torn).flatten().collect()
    }

    /// Returns a way across the section at a spot in the coordinates of the mesh.
    fn across(&self, spot: &Spot, by: DVec2) -> DVec3 {
        let layers = &self.stem.layers;
        let way = layers.to_world(spot.grain + by.extend(0.0)) - layers.to_world(spot.grain);
        self.inverse.transform_vector3(way)
    }

    /// Halves the edges that lie too far off the bowed splinter that they show. Returns whether there were any. `coarse` says of
    /// the edges between points whether they do, as far as that is known.
    fn halve(
        &self,
        mesh: &mut Mesh,
        (leans, foot): (&Leans, f64),
        spots: &mut Vec<Spot>,
        coarse: &mut FxHashMap<[u32; 2], bool>,
    ) -> bool {
        let radius = self.stem.found.stem.radius;
        // Points keep their numbers when vertices are added.
        let (points, _) = mesh.points();
        let by = |spot: &Spot| self.displacement(spot, leans).map_or(DVec2::ZERO, |d| d.0);
        let ways: Vec<DVec2> = spots.iter().map(by).collect();
        // Edges between points, so that both sides of a seam do the same.
        let ordered = |[v, w]: [u32; 2]| {
            if points[v as usize] < points[w as usize] {
                [v, w]
            } else {
                [w, v]
            }
        };
        let mut is_coarse = |edge: [u32; 2]| {
            let [v, w] = ordered(edge);
            let [one, other] = [v, w].map(|v| &spots[v as usize]);
            let rise = (one.grain.z - other.grain.z).abs();
            if one.cell.or(other.cell).is_none() || rise < LEAST_RISE * radius {
                return false;
            }
            let key = [points[v as usize], points[w as usize]];
            *coarse.entry(key).or_insert_with(|| {
                let [p, q] = [v, w].map(|v| mesh.positions[v as usize]);
                let (from, to) = (ways[v as usize], ways[w as usize]);
                [0.25, 0.5, 0.75].into_iter().any(|t| {
                    let way = by(&self.spot(p.lerp(q, t), foot));
                    way.distance(from.lerp(to, t)) > PRECISION * radius
                })
            })
        };
        let marked: Vec<[bool; 3]> = (mesh.triangles.iter())
            .map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(&mut is_coarse))
            .collect();
        if !marked.as_flattened().contains(&true) {
            return false;
        }
        let mut made: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let (mut triangles, mut materials) = (Vec::new(), Vec::new());
        let old = std::mem::take(&mut mesh.triangles);
        for (t, (&[a, b, c], &marks)) in old.iter().zip(&marked).enumerate() {
            let before = triangles.len();
            let mut middle = |v: u32, w: u32| {
                let [v, w] = ordered([v, w]);
                let push = || push_vertex_between(mesh, v, w, 0.5);
                *made.entry([v, w]).or_insert_with(push)
            };
            split(&mut triangles, [a, b, c], marks, &mut middle);
            materials
                .extend((before..triangles.len()).filter_map(|_| mesh.materials.get(t).copied()));
        }
        (mesh.triangles, mesh.materials) = (triangles, materials);
        self.spots(mesh, foot, spots);
        true
    }

    /// Turns normals and tangents as the wood turns; positions are still straight.
    fn turn_normals(&self, mesh: &mut Mesh, spots: &[Spot], leans: &Leans) {
        let stem = &self.stem.found.stem;
        let along = stem.grain.axis().frame(stem.location).tangent;
        let along = self.inverse.transform_vector3(along).normalize_or_zero();
        for (i, spot) in spots.iter().enumerate() {
            let Some((_, slope)) = self.displacement(spot, leans) else {
                continue;
            };
            let unit = self.across(spot, slope);
            let scale = self.transform.matrix3.determinant().abs().cbrt();
            let aside = unit * scale;
            let mut turn = |name: &str, how: &dyn Fn(DVec3) -> DVec3| {
                if let Some(attribute) = mesh.attributes.get_mut(name)
                    && attribute.width >= 3
                {
                    let first = i * attribute.width;
                    let values = &mut attribute.data[first..first + 3];
                    let d = DVec3::new(values[0].into(), values[1].into(), values[2].into());
                    let turned = how(d).normalize_or(d).as_vec3();
                    values.copy_from_slice(&turned.to_array());
                }
            };
            turn("NORMAL", &|n| n - along * aside.dot(n));
            turn("TANGENT", &|t| t + aside * along.dot(t));
        }
    }
}

/// Splits a triangle at the middles of the edges that are marked: those from its first to its second corner, and so on.
fn split(
    triangles: &mut Vec<[u32; 3]>,
    [a, b, c]: [u32; 3],
    marks: [bool; 3],
    middle: &mut impl FnMut(u32, u32) -> u32,
) {
    match marks {
        [false, false, false] => triangles.push([a, b, c]),
        [true, true, true] => {
            let [m, n, o] = [middle(a, b), middle(b, c), middle(c, a)];
            triangles.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]);
        }
        [true, false, false] => {
            let m = middle(a, b);
            triangles.extend([[a, m, c], [m, b, c]]);
        }
        [true, true, false] => {
            let [m, n] = [middle(a, b), middle(b, c)];
            triangles.extend([[m, b, n], [a, m, n], [a, n, c]]);
        }
        [false, ..] => split(triangles, [b, c, a], [marks[1], marks[2], marks[0]], middle),
        [true, false, true] => split(triangles, [c, a, b], [true, true, false], middle),
    }
}
