//! Removing the self-intersections of a broken face in spiral grain.
//!
//! The map from spiral grain to the world is curved between levels, so that what was cut apart in grain space may cross
//! in the world, by as little as straight triangles are off curved ones. So vertices of the outline that files hold at one
//! position are parted ([`outline`]), vertices near the skin are moved with it ([`placement`]), edges that run closely below
//! it from outline to outline get a vertex that can lie below it, and what still crosses is bisected and its vertices moved,
//! round after round, as little as it takes. All this is done at the positions that files hold. The face is changed before
//! the pieces are made of it, so both have the same. What no round frees has walls too high and too close to each other:
//! there the surface itself is levelled ([`levelled`]), cut and repaired again.

mod levelled;
mod outline;
mod placement;

use crate::source::Source;
use glam::{DAffine3, DVec3};
use greenstick_fracture::cut::{Cut, Host, Side, Skin};
use greenstick_fracture::surface::{FractureSurface, NONE};
use greenstick_geometry::repair::{
    Collapsed, EdgeBisector, EdgeCollapser, Untangler, crossing_pairs, crossing_pairs_within,
};
use greenstick_geometry::{Aabb, Cancelled, Context};
use greenstick_wood::stem::LayeredGrain;
use outline::{part_equal_positions, rounded};
use placement::Placement;
use std::collections::BTreeSet;

/// Rounds in which what crosses is bisected and moved.
const ROUNDS: usize = 8;
/// Depth below the skin that vertices within the wood lie at least at, in radii and in spacings of the positions that files hold,
/// whichever is more: so that wood between the two stays, and less than the depth at which neighbours of a vertex would have to be
/// moved too.
const LEAST_DEPTH_RADII: f64 = 5e-4;
const LEAST_DEPTH_SPACINGS: f64 = 400.0;
/// The greatest depth below the skin that a vertex in the middle of an edge is moved to for its own sake, as a part of the edge's
/// length: deeper ones would stand out as spikes, and cross those beside them.
const MOST_DEPTH_PER_LENGTH: f64 = 0.03;
/// The shortest edges from outline to outline that are bisected, in spacings of the positions that files hold.
const SHORTEST_CHORD: f64 = 8.0;
/// An attempt is given up after a round that leaves more than this part of the pairs that crossed before it: bisecting again what
/// moving has not freed makes ever more, ever smaller triangles. Attempts that succeed leave a fifth in most rounds.
const MOST_LEFT: f64 = 0.6;
/// Pairs that cross, as a part of the triangles of the face, above which moving vertices is not tried: each move is judged by
/// all that crosses about it, which takes minutes there, and levelling frees most.
const MAX_TANGLED: f64 = 0.02;
/// The greatest distance that a vertex is moved, radii.
const MAX_MOVE_RADII: f64 = 5e-3;
/// By how much positions in `f32` may lie off, radii: those of stems 10 radii long and more.
const ROUNDING_RADII: f64 = 1e-6;

/// What was done to a broken face in spiral grain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpiralRepair {
    /// Pairs of triangles that crossed.
    pub crossed: usize,
    /// Edges bisected.
    pub bisected: usize,
    /// Vertices moved.
    pub moved: usize,
    /// The farthest that one was moved, in the mesh's unit.
    pub longest: f64,
    /// Fibre bundles whose heights were levelled.
    pub levelled: usize,
    /// Pairs that still cross.
    pub remaining: usize,
}

/// How many cells around what crosses are levelled, each time that something still does.
const LEVELLED_AROUND: [usize; 4] = [1, 2, 4, 8];

/// A cut of a surface, what was done to its face, and the cells about what still crosses.
type Attempt<T> = (T, SpiralRepair, Vec<u32>);

/// Cuts a stem along `surface` by `cut_along`, which also repairs the face and returns the cells about what still crosses, and levels
/// the surface there until nothing does. Returns the best of the cuts.
///
/// # Errors
/// Those of `cut_along` with the surface as it is; one that fails once it is levelled is left out.
pub fn cut_and_level<T, E>(
    surface: &FractureSurface,
    mut cut_along: impl FnMut(&FractureSurface) -> Result<Attempt<T>, E>,
) -> Result<(T, SpiralRepair), E> {
    let (mut best, mut done, mut crossing) = cut_along(surface)?;
    let mut cells = BTreeSet::new();
    for around in LEVELLED_AROUND {
        if done.remaining == 0 {
            break;
        }
        let mut about: BTreeSet<u32> = crossing.into_iter().collect();
        for _ in 0..around {
            levelled::grow(&surface.layout, &mut about);
        }
        cells.extend(about);
        let level = levelled::levelled(surface, &cells);
        let Ok((other, repair, cells_about)) = cut_along(&level) else {
            break;
        };
        crossing = cells_about;
        if repair.remaining < done.remaining {
            best = other;
            done = SpiralRepair {
                levelled: cells.len(),
                ..repair
            };
        }
    }
    Ok((best, done))
}

/// A cut in the node's coordinates: its face first, then the skin about it.
struct Face<'a> {
    cut: &'a mut Cut,
    /// Position of every vertex, and its grain coordinates there.
    positions: Vec<DVec3>,
    grain: Vec<DVec3>,
    /// The grain coordinates that every vertex was cut with, in which the skin is straight.
    straight: Vec<DVec3>,
    skin: Vec<[u32; 3]>,
    placement: Placement<'a>,
    to_grain: &'a dyn Fn(DVec3) -> DVec3,
    /// Number of the first vertex within the wood.
    rim: u32,
    /// By how much rounded positions may lie off their grain coordinates, m.
    margin: f64,
    /// How far apart neighbouring positions in files are, at most, in the mesh's unit.
    spacing: f64,
}

/// Removes the self-intersections of the face of `cut`. `skin` is the sorted skin that was cut; `layers` are those of the
/// stem, whose radius is given in m and to whose world `transform` leads. Also returns the cells of what still crosses.
///
/// # Errors
/// [`Cancelled`] where the caller cancelled.
pub fn repair_spiral_face(
    source: &Source,
    cut: &mut Cut,
    skin: &Skin,
    (layers, radius): (&LayeredGrain, f64),
    transform: &DAffine3,
    context: &Context,
) -> Result<(SpiralRepair, Vec<u32>), Cancelled> {
    let to_grain = |p| layers.to_grain(transform.transform_point3(p));
    let points = (source.vertices[..cut.points].iter()).map(|&v| source.mesh.positions[v as usize]);
    let corners = |triangle: u32| source.mesh.corners(triangle as usize);
    part_equal_positions(&points.collect::<Vec<_>>(), &corners, &mut cut.vertices);
    let farthest = (cut.vertices.iter())
        .map(|v| {
            transform
                .inverse()
                .transform_point3(layers.to_world(v.grain))
        })
        .fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    let spacing = f64::from(f32::EPSILON) * farthest;
    let depth = (LEAST_DEPTH_RADII * radius).max(LEAST_DEPTH_SPACINGS * spacing);
    let lengths = (radius, depth, spacing);
    Face::new(source, cut, skin, lengths, &to_grain).repair(layers, radius, context)
}

impl<'a> Face<'a> {
    fn new(
        source: &Source<'a>,
        cut: &'a mut Cut,
        skin: &Skin,
        (radius, least_depth, spacing): (f64, f64, f64),
        to_grain: &'a dyn Fn(DVec3) -> DVec3,
    ) -> Self {
        let placement = Placement::new(*source, cut, skin, (radius, least_depth));
        let point = |p: u32| source.mesh.positions[source.vertices[p as usize] as usize];
        let mut positions: Vec<DVec3> = (0..cut.points as u32).map(point).collect();
        positions.extend(cut.vertices.iter().map(|v| match v.host {
            Host::Edge { ends: [a, b], t } => point(a).lerp(point(b), t),
            Host::Face {
                triangle,
                weights: w,
            } => {
                let [a, b, c] = source.mesh.corners(triangle as usize);
                a * w[0] + b * w[1] + c * w[2]
            }
            Host::Point(p) => point(p),
            Host::Inside => source.chart.to_world(v.grain),
        }));
        let rim = positions.len() as u32;
        positions.iter_mut().for_each(|p| *p = rounded(*p));
        // The skin is straight in the world, so that the grain coordinates it was cut with are not quite its own.
        let mut grain = source.grain[..cut.points].to_vec();
        grain.extend(positions[cut.points..].iter().map(|&p| to_grain(p)));
        let mut straight = source.grain[..cut.points].to_vec();
        straight.extend(cut.vertices.iter().map(|v| v.grain));
        straight.extend(cut.inside.iter().copied());
        for &g in &cut.inside {
            let (place, at) = placed(placement.place(g, f64::INFINITY), to_grain);
            positions.push(place);
            grain.push(at);
        }
        let whole = cut.sides.between.iter().enumerate();
        let whole = whole.filter(|(_, side)| matches!(side, Side::Lower | Side::Upper));
        let whole = whole.map(|(i, _)| {
            let t = skin.order[cut.sides.below + i] as usize;
            source.mesh.triangles[t].map(|v| source.points[v as usize])
        });
        let skin = (cut.skin.iter().map(|s| s.corners)).chain(whole).collect();
        Face {
            cut,
            positions,
            grain,
            straight,
            skin,
            placement,
            to_grain,
            rim,
            margin: ROUNDING_RADII * radius,
            spacing,
        }
    }

    /// Bisects and moves what crosses, round after round. Also returns the cells of what still does.
    fn repair(
        &mut self,
        layers: &LayeredGrain,
        radius: f64,
        context: &Context,
    ) -> Result<(SpiralRepair, Vec<u32>), Cancelled> {
        let mut done = SpiralRepair::default();
        self.merge_equal_positions(context)?;
        self.bisect_chords(&mut done);
        let mut pairs = self.crossing(layers, context)?;
        done.crossed = pairs.len();
        for _ in 0..ROUNDS {
            let tangled = pairs.len() as f64 > MAX_TANGLED * self.cut.cap.len() as f64;
            if pairs.is_empty() || tangled {
                break;
            }
            let most = (MOST_LEFT * pairs.len() as f64) as usize;
            pairs = self.bisect(pairs, &mut done, context)?;
            self.untangle(&mut pairs, MAX_MOVE_RADII * radius, &mut done, context)?;
            if pairs.len() > most {
                break;
            }
        }
        self.store();
        done.remaining = pairs.len();
        let faces = &self.cut.faces;
        let of_face = pairs
            .iter()
            .flatten()
            .filter_map(|&t| faces.get(t as usize));
        Ok((done, of_face.map(|face| face.cell).collect()))
    }

    /// Adds a vertex within the wood, in the middle of an edge of the given length, at grain coordinates in which the skin is straight.
    fn push(&mut self, straight: DVec3, length: f64) {
        let most = MOST_DEPTH_PER_LENGTH * length;
        let (place, grain) = placed(self.placement.place(straight, most), self.to_grain);
        self.positions.push(place);
        self.grain.push(grain);
        self.straight.push(straight);
        self.cut.inside.push(straight);
        self.cut.nodes.push(NONE);
    }

    /// Moves vertices until nothing crosses, or no move helps.
    fn untangle(
        &mut self,
        pairs: &mut Vec<[u32; 2]>,
        reach: f64,
        done: &mut SpiralRepair,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let all = self.with_skin(&self.cut.cap);
        let rim = self.rim;
        let mut untangler = Untangler {
            positions: &mut self.positions,
            triangles: &all,
            is_free: &|v| v >= rim,
            reach,
            context,
        };
        let untangled = untangler.untangle(pairs);
        context.check()?;
        done.moved += untangled.moved.len();
        done.longest = done.longest.max(untangled.farthest);
        for &v in &untangled.moved {
            let place = self.positions[v as usize];
            let (place, grain) = placed(place, self.to_grain);
            self.positions[v as usize] = place;
            self.grain[v as usize] = grain;
        }
        Ok(())
    }

    /// Gives the vertices of the cut within the wood the grain coordinates of their places.
    fn store(&mut self) {
        let inside = &mut self.cut.inside;
        inside.copy_from_slice(&self.grain[self.rim as usize..]);
    }

    fn with_skin(&self, face: &[[u32; 3]]) -> Vec<[u32; 3]> {
        face.iter().chain(&self.skin).copied().collect()
    }

    /// The pairs of triangles that cross, at least one of which is of the face.
    ///
    /// In the world the long triangles along the grain lean in all directions, and so many of their boxes overlap; in
    /// grain space they stand upright.
    fn crossing(
        &self,
        layers: &LayeredGrain,
        context: &Context,
    ) -> Result<Vec<[u32; 2]>, Cancelled> {
        let (all, count) = (self.with_skin(&self.cut.cap), self.cut.cap.len());
        let grain = |t: &[u32; 3]| t.map(|v| self.grain[v as usize]);
        // Skin off the limb has no grain.
        let has_grain = |&n: &u32| grain(&all[n as usize]).iter().all(|g| !g.is_nan());
        let (limb, off_limb): (Vec<u32>, Vec<u32>) = (0..all.len() as u32).partition(has_grain);
        let triangles: Vec<[u32; 3]> = limb.iter().map(|&n| all[n as usize]).collect();
        let bounds = |t: &[u32; 3]| {
            let (low, high) = layers.triangle_bounds(grain(t));
            Aabb { low, high }.grown(self.margin)
        };
        let boxes: Vec<Aabb> = triangles.iter().map(bounds).collect();
        let positions = &self.positions;
        let mut pairs = crossing_pairs_within(positions, &triangles, count, &boxes, context)?;
        if !off_limb.is_empty() {
            for n in pairs.iter_mut().flatten() {
                *n = limb[*n as usize];
            }
            let others = crossing_pairs(&self.positions, &all, Some(&off_limb), context)?;
            pairs.extend(self.of_face(others, count));
            pairs.sort_unstable();
        }
        Ok(pairs)
    }

    /// Those pairs one of which at least is among the first `count` triangles, the face.
    fn of_face(&self, mut pairs: Vec<[u32; 2]>, count: usize) -> Vec<[u32; 2]> {
        pairs.retain(|p| (p[0] as usize) < count);
        pairs
    }

    /// Bisects what crosses; returns the pairs that remain.
    fn bisect(
        &mut self,
        mut pairs: Vec<[u32; 2]>,
        done: &mut SpiralRepair,
        context: &Context,
    ) -> Result<Vec<[u32; 2]>, Cancelled> {
        let ids = (0..self.positions.len() as u32).collect();
        let mut bisector = EdgeBisector::new(
            std::mem::take(&mut self.cut.cap),
            ids,
            self.positions.len() as u32,
        );
        let before = bisector.triangles.len();
        let mut changed = vec![false; before];
        let mut list = Vec::new();
        for t in pairs.iter().flatten().copied() {
            if t as usize >= before || changed[t as usize] {
                continue;
            }
            let first = self.positions.len() as u32;
            let mut made = Vec::new();
            let (positions, straight, rim) = (&self.positions, &self.straight, self.rim);
            // An edge from outline to outline has no vertex that could be moved.
            let length = |a: u32, b: u32| {
                let stuck = if a < rim && b < rim { 1e3 } else { 1.0 };
                stuck * positions[a as usize].distance(positions[b as usize])
            };
            let four = bisector.bisect(t, &length, &mut |a, b| {
                let length = positions[a as usize].distance(positions[b as usize]);
                made.push(((straight[a as usize] + straight[b as usize]) / 2.0, length));
                first + made.len() as u32 - 1
            });
            made.into_iter().for_each(|(g, l)| self.push(g, l));
            if let Some(four) = four {
                done.bisected += 1;
                changed.resize(bisector.triangles.len(), true);
                for t in four {
                    changed[t as usize] = true;
                }
                list.extend(four);
            }
        }
        list.sort_unstable();
        list.dedup();
        let count = bisector.triangles.len();
        let all = self.with_skin(&bisector.triangles);
        // Numbers of the skin's triangles move up.
        let shift = (count - before) as u32;
        let unchanged = pairs
            .iter()
            .map(|p| p.map(|t| if t as usize >= before { t + shift } else { t }));
        let kept = unchanged.filter(|p| p.iter().all(|&t| list.binary_search(&t).is_err()));
        let mut now: Vec<[u32; 2]> = kept.collect();
        now.extend(crossing_pairs(&self.positions, &all, Some(&list), context)?);
        now.sort_unstable();
        now.dedup();
        pairs = self.of_face(now, count);
        self.take(&bisector, &mut pairs);
        Ok(pairs)
    }

    /// Bisects edges of the face from outline to outline that run closely below the skin, where they have no vertex that
    /// keeps them below it.
    fn bisect_chords(&mut self, done: &mut SpiralRepair) {
        let ids = (0..self.positions.len() as u32).collect();
        let count = self.positions.len() as u32;
        let mut bisector = EdgeBisector::new(std::mem::take(&mut self.cut.cap), ids, count);
        let mut stack: Vec<u32> = (0..bisector.triangles.len() as u32).collect();
        while let Some(t) = stack.pop() {
            let first = self.positions.len() as u32;
            let (straight, placement, rim) = (&self.straight, &self.placement, self.rim);
            let middle = |a: u32, b: u32| (straight[a as usize] + straight[b as usize]) / 2.0;
            let positions = &self.positions;
            let length = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
            let least = SHORTEST_CHORD * self.spacing;
            let is_chord = |a: u32, b: u32| {
                a < rim && b < rim && length(a, b) > least && placement.is_shallow(middle(a, b))
            };
            if !bisector.has_shared_edge(t, &is_chord) {
                continue;
            }
            let mut made = Vec::new();
            let chords_first = |a: u32, b: u32| f64::from(u8::from(is_chord(a, b)));
            let four = bisector.bisect(t, &chords_first, &mut |a, b| {
                made.push((middle(a, b), length(a, b)));
                first + made.len() as u32 - 1
            });
            made.into_iter().for_each(|(g, l)| self.push(g, l));
            if let Some(four) = four {
                done.bisected += 1;
                stack.extend(four);
            }
        }
        self.take(&bisector, &mut []);
    }

    /// Collapses edges whose ends files hold at one position: a vertex that is moved would part from the others there.
    fn merge_equal_positions(&mut self, context: &Context) -> Result<(), Cancelled> {
        let has_equal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            a == b || b == c || c == a
        };
        let cap = self.cut.cap.iter().enumerate();
        let short: Vec<[u32; 2]> = (cap.filter(|(_, t)| has_equal(t)))
            .map(|(i, _)| [i as u32; 2])
            .collect();
        let cap = std::mem::take(&mut self.cut.cap);
        let mut collapser = EdgeCollapser::new(self.positions.clone(), cap);
        let is_fixed = |v: u32| v < self.rim;
        let mut done = Collapsed::default();
        collapser.collapse_edges(&short, 0.0, &is_fixed, &mut done, context)?;
        let kept: Vec<bool> = (0..collapser.triangles.len())
            .map(|t| !collapser.is_collapsed(t))
            .collect();
        let mut before = vec![0u32];
        for k in &kept {
            before.push(before[before.len() - 1] + u32::from(*k));
        }
        let cut = &mut *self.cut;
        cut.walls.iter_mut().for_each(|w| *w = before[*w as usize]);
        let retain = |t: usize| kept[t];
        cut.faces = (0..kept.len())
            .filter(|&t| retain(t))
            .map(|t| cut.faces[t])
            .collect();
        cut.cap = (0..kept.len())
            .filter(|&t| retain(t))
            .map(|t| collapser.triangles[t])
            .collect();
        Ok(())
    }

    /// Takes over the triangles of `bisector`, in the order of those they are parts of.
    fn take(&mut self, bisector: &EdgeBisector, pairs: &mut [[u32; 2]]) {
        let count = bisector.triangles.len();
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.sort_by_key(|&t| (bisector.origins[t as usize], t));
        let mut place = vec![0; count];
        for (i, &t) in order.iter().enumerate() {
            place[t as usize] = i as u32;
        }
        for t in pairs
            .iter_mut()
            .flatten()
            .filter(|t| (**t as usize) < count)
        {
            *t = place[*t as usize];
        }
        let cut = &mut *self.cut;
        cut.cap = order
            .iter()
            .map(|&t| bisector.triangles[t as usize])
            .collect();
        cut.faces = (order.iter())
            .map(|&t| cut.faces[bisector.origins[t as usize] as usize])
            .collect();
        for wall in &mut cut.walls {
            let first = order.partition_point(|&t| bisector.origins[t as usize] < *wall);
            *wall = first as u32;
        }
    }
}

/// The position nearest to `place` that a file holds, so that what is found not to cross there does not in files, and its
/// grain coordinates.
fn placed(place: DVec3, to_grain: &dyn Fn(DVec3) -> DVec3) -> (DVec3, DVec3) {
    let place = rounded(place);
    (place, to_grain(place))
}
