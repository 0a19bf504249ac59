//! Leaning splinters: torn wood springs apart, so that every large splinter leans and is bowed in its own way, and gaps open
//! between them.
//!
//! The halves of a break are cut along one surface, on which all splinters stand along the grain. Each half is then bent by
//! itself: its splinters move, the sockets that they left in the other half stay straight. Where splinters would cross, they lean
//! less.

mod bend;
mod crossings;
mod motion;
pub(crate) mod place;
mod snap;
mod tree;

pub use bend::SplinterLean;

use crate::fray::push_vertex_between;
use crate::prepared::PreparedStem;
use bend::Leans;
use crossings::Crossings;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::{Cancelled, Context, Mesh};
use greenstick_wood::noise::smoothstep;
use motion::{Motion, Spot};
use place::FacetPlaces;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use snap::Snaps;
use std::fmt;
use tree::SplinterTree;

/// Greatest distance between a bowed splinter and the straight edges that show it, radii.
const PRECISION: f64 = 0.022;
/// Height of an edge below which it cannot be farther off, radii.
const LEAST_RISE: f64 = 0.14;
const LEAST_RISE_BENT: f64 = 0.04;
/// Least length of what a slab ends in for it to lean by itself, radii.
const LEAST_PART: f64 = 0.2;
/// How often edges are halved for it.
const HALVINGS: usize = 4;
/// Greatest difference of the displacements at the ends of an edge: over its height, and whatever that is, radii.
const MOST_SHEAR: f64 = 0.7;
/// The same of an edge one end of which is bent over a kink.
const MOST_TURN: f64 = 2.0;
const SLACK: f64 = 0.03;
/// Vertices or triangles whose places in the wood are looked for between two questions whether to stop: some milliseconds.
const PLACES_AT_ONCE: usize = 10_000;
/// Rounds in which splinters that cross lean less.
const ROUNDS: usize = 20;
/// Rounds after which everything about a crossing that is left stays straight.
const PATIENCE: usize = 10;
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
    /// Splinters that snapped on their way and hang to one side.
    pub snapped: usize,
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
            "{} splinters by {:.1}° on average, {:.1}° at most, {} straight, {} snapped",
            self.splinters, self.mean_degrees, self.greatest_degrees, self.straight, self.snapped
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
    /// Share of the slender splinters that snap.
    pub snapped: f64,
    /// Seed of the break.
    pub seed: u64,
    /// Asked whether to stop.
    pub context: &'a Context,
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
    /// Height up to which nothing moves.
    foot: f64,
}

impl LeaningPiece<'_> {
    /// Bends the splinters of a mesh of the piece. A mesh with triangles that cross when nothing leans keeps them.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancelled.
    pub fn bend(&self, mesh: &Mesh) -> Result<LeanedPiece, Cancelled> {
        let sign = if self.upper { -1.0 } else { 1.0 };
        let radius = self.stem.found.stem.radius;
        let mut tree = SplinterTree::new(self.surface, sign, self.cells);
        self.context.check()?;
        tree.divide(LEAST_PART * radius);
        let seed = self.seed + u64::from(self.upper);
        let (low, high) = self.surface.range();
        self.context.check()?;
        let places = FacetPlaces::new(self.surface, sign);
        self.context.check()?;
        let of = (self.surface, sign);
        let snaps = Snaps::new((&tree, &places), of, radius, self.snapped, seed);
        self.context.check()?;
        let middle = self.stem.square.middle;
        let mut motion = Motion {
            leans: Leans::new(tree, (radius, middle), self.degrees, seed),
            snaps,
            sign,
        };
        let transform = *self.stem.transform();
        let map = Map {
            stem: self.stem,
            inverse: transform.inverse(),
            transform,
            places,
            sign,
            middle,
            reach: self.stem.square.side / 2.0,
            foot: if self.upper { -high } else { low },
        };
        let mut mesh = mesh.clone();
        let mut spots: Vec<Spot> = Vec::new();
        map.spots(&mesh, &mut spots, self.context)?;
        let mut coarse = FxHashMap::default();
        for _ in 0..HALVINGS {
            if !map.halve(&mut mesh, &motion, (&mut spots, &mut coarse), self.context)? {
                break;
            }
        }
        let bent = map.resolved(&mesh, &spots, &mut motion, self.context)?;
        self.context.check()?;
        map.turn_normals(&mut mesh, &spots, &motion);
        mesh.positions = bent;
        let splinters = motion.leans.splinters();
        let mut report = report(&splinters);
        report.snapped = motion.snaps.count();
        Ok(LeanedPiece {
            mesh,
            report,
            splinters,
        })
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
        snapped: 0,
        // An empty sum is −0.
        mean_degrees: degrees.iter().sum::<f64>().max(0.0) / degrees.len().max(1) as f64,
        greatest_degrees: degrees.iter().copied().fold(0.0, f64::max),
        median_length_m: lengths.get(lengths.len() / 2).copied().unwrap_or_default(),
        straight_volume_m3: None,
    }
}

impl Map<'_> {
    /// Returns the positions of a piece's vertices when it is bent, with as much motion as leaves no triangles that cross.
    fn resolved(
        &self,
        mesh: &Mesh,
        spots: &[Spot],
        motion: &mut Motion,
        context: &Context,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let mut bent = self.bent(mesh, spots, motion);
        context.check()?;
        let mut crossings = Crossings::new(mesh, spots, &bent, context)?;
        for round in 0..ROUNDS {
            context.check()?;
            let torn = self.torn(mesh, spots, motion);
            context.check()?;
            if crossings.pairs.is_empty() && torn.is_empty() {
                return Ok(bent);
            }
            let of = |vertices: &[u32]| -> Vec<&Spot> {
                vertices.iter().map(|&v| &spots[v as usize]).collect()
            };
            let pairs = crossings.vertices().map(|v| of(&v));
            let faults = pairs.chain(torn.iter().map(|edge| of(edge)));
            let times = if round >= PATIENCE { 4 } else { 1 };
            if !motion.calm(faults, times) {
                break;
            }
            context.check()?;
            let before = std::mem::replace(&mut bent, self.bent(mesh, spots, motion));
            context.check()?;
            crossings.update(&before, &bent, context)?;
        }
        // Whatever it is, it is no longer the motion.
        motion.stop();
        Ok(mesh.positions.clone())
    }

    /// Adds the spots of vertices that have none yet.
    fn spots(
        &self,
        mesh: &Mesh,
        spots: &mut Vec<Spot>,
        context: &Context,
    ) -> Result<(), Cancelled> {
        for new in mesh.positions[spots.len()..].chunks(PLACES_AT_ONCE) {
            context.check()?;
            spots.extend(new.iter().map(|&p| self.spot(p)));
        }
        Ok(())
    }

    fn spot(&self, place: DVec3) -> Spot {
        let grain = self
            .stem
            .layers
            .to_grain(self.transform.transform_point3(place));
        let (off, at) = (grain.truncate() - self.middle, grain.truncate());
        let beside = off.length() / self.reach;
        let share = 1.0 - smoothstep(BESIDE.0, BESIDE.1, beside);
        let moves = grain.is_finite() && self.sign * grain.z > self.foot && share > 0.0;
        // What sticks out of the section goes along with the wood that it grew on.
        let inwards = [1.0, 0.97, 0.94, 0.9, 0.85, 0.8, 0.7, 0.6, 0.5];
        let cell = |at: DVec2| self.places.cell(at, self.sign * grain.z);
        let within = |part: f64| cell(self.middle + off * (part / beside.max(1.0)));
        let cell = moves
            .then(|| cell(at).or_else(|| inwards.into_iter().find_map(within)))
            .flatten();
        Spot { grain, cell, share }
    }

    /// Returns the positions of the vertices when they have moved.
    fn bent(&self, mesh: &Mesh, spots: &[Spot], motion: &Motion) -> Vec<DVec3> {
        let places = mesh.positions.par_iter().zip(spots);
        let bend = |(&place, spot): (&DVec3, &Spot)| match motion.way(spot) {
            DVec3::ZERO => place,
            by => place + self.across(spot, by),
        };
        places.map(bend).collect()
    }

    /// Returns the edges that would be drawn out, as where a vertex that was moved by a repair is taken for another splinter's.
    fn torn(&self, mesh: &Mesh, spots: &[Spot], motion: &Motion) -> Vec<[u32; 2]> {
        let radius = self.stem.found.stem.radius;
        let ways: Vec<DVec3> = spots.par_iter().map(|spot| motion.way(spot)).collect();
        let turned: Vec<Option<u32>> = spots.par_iter().map(|s| motion.snap_of(s)).collect();
        let is_torn = |&[v, w]: &[u32; 2]| {
            let [v, w] = [v as usize, w as usize];
            let most = match (turned[v], turned[w]) {
                (None, None) => MOST_SHEAR,
                (one, other) if one == other => return false,
                _ => MOST_TURN,
            };
            let rise = (spots[v].grain.z - spots[w].grain.z).abs();
            ways[v].distance(ways[w]) > most * rise + SLACK * radius
        };
        let edges = (mesh.triangles.iter()).flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.filter(is_torn).collect()
    }

    /// Returns a way in grain space at a spot in the coordinates of the mesh.
    fn across(&self, spot: &Spot, by: DVec3) -> DVec3 {
        let layers = &self.stem.layers;
        let way = layers.to_world(spot.grain + by) - layers.to_world(spot.grain);
        self.inverse.transform_vector3(way)
    }

    /// Halves the edges that lie too far off the bowed splinter that they show. Returns whether there were any. `coarse` says of
    /// the edges between points whether they do, as far as that is known.
    fn halve(
        &self,
        mesh: &mut Mesh,
        motion: &Motion,
        (spots, coarse): (&mut Vec<Spot>, &mut FxHashMap<[u32; 2], bool>),
        context: &Context,
    ) -> Result<bool, Cancelled> {
        let radius = self.stem.found.stem.radius;
        // Points keep their numbers when vertices are added.
        let (points, _) = mesh.points();
        let ways: Vec<DVec3> = spots.par_iter().map(|spot| motion.way(spot)).collect();
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
            let bent = [one, other].map(|spot| motion.snap_of(spot).is_some());
            let least = if bent.contains(&true) {
                LEAST_RISE_BENT
            } else {
                LEAST_RISE
            };
            if one.cell.or(other.cell).is_none() || rise < least * radius {
                return false;
            }
            let key = [points[v as usize], points[w as usize]];
            *coarse.entry(key).or_insert_with(|| {
                let [p, q] = [v, w].map(|v| mesh.positions[v as usize]);
                let (from, to) = (ways[v as usize], ways[w as usize]);
                [0.25, 0.5, 0.75].into_iter().any(|t| {
                    let way = motion.way(&self.spot(p.lerp(q, t)));
                    way.distance(from.lerp(to, t)) > PRECISION * radius
                })
            })
        };
        let mut marked: Vec<[bool; 3]> = Vec::with_capacity(mesh.triangles.len());
        for triangles in mesh.triangles.chunks(PLACES_AT_ONCE) {
            context.check()?;
            let edges = triangles.iter().map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
            marked.extend(edges.map(|edges| edges.map(&mut is_coarse)));
        }
        if !marked.as_flattened().contains(&true) {
            return Ok(false);
        }
        context.check()?;
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
        self.spots(mesh, spots, context)?;
        Ok(true)
    }

    /// Turns normals and tangents as the wood turns; positions are still straight.
    fn turn_normals(&self, mesh: &mut Mesh, spots: &[Spot], motion: &Motion) {
        let stem = &self.stem.found.stem;
        let along = stem.grain.axis().frame(stem.location).tangent;
        let along = self.inverse.transform_vector3(along).normalize_or_zero();
        let scale = self.transform.matrix3.determinant().abs().cbrt();
        for (i, spot) in spots.iter().enumerate() {
            let Some(moved) = motion.of(spot) else {
                continue;
            };
            let aside = self.across(spot, moved.slope.extend(0.0)) * scale;
            let turn_about = moved.turn.map(|(toward, angle)| {
                let toward = self.across(spot, toward.extend(0.0)).normalize_or_zero();
                DQuat::from_axis_angle((along * self.sign).cross(toward).normalize(), angle)
            });
            let mut turn = |name: &str, how: &dyn Fn(DVec3) -> DVec3| {
                if let Some(attribute) = mesh.attributes.get_mut(name)
                    && attribute.width >= 3
                {
                    let first = i * attribute.width;
                    let values = &mut attribute.data[first..first + 3];
                    let d = DVec3::new(values[0].into(), values[1].into(), values[2].into());
                    let turned = turn_about.map_or_else(|| how(d), |turn| turn * d);
                    let turned = turned.normalize_or(d).as_vec3();
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
