//! Finding a stem or limb in a cloud and following it both ways until it forks or the points thin out.
//!
//! Bark is locally a cylinder: its normals are square to the axis, so that the direction in which they vary least is the
//! axis; where noise spoils normals, the longest direction of the points stands in.

use super::circle::{Circle, Expected, Prior, fit};
use super::merit::Merit;
use crate::noise;
use crate::stem::StemLocation;
use glam::{DMat3, DVec2, DVec3};
use greenstick_geometry::cloud::{KdTree, normals};
use greenstick_geometry::{Cancelled, Context, symmetric_eigen};
use rayon::prelude::*;

/// A section of a limb as a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ring {
    pub centre: DVec3,
    /// Along the limb (unit).
    pub along: DVec3,
    pub radius: f64,
    /// The evidence that it is one, of the points of one step.
    evidence: f64,
    /// The same of occupied cells instead of points.
    cell_evidence: f64,
    /// Information of one of its points, in nats.
    information: f64,
    /// Standard error of the radius from the residual and the coverage of the circle, m.
    pub radius_error: f64,
}

/// Points that are searched for a stem, in a random order: the first of a neighbourhood stand for all of it, and one point
/// more or less changes no other.
pub(super) struct Searched<'a> {
    pub points: &'a [DVec3],
    pub tree: &'a KdTree,
    pub spacing: f64,
}

/// Points at which a first section is tried where the location is no point.
const STARTS: i64 = 128;
/// Factor from the radius of one neighbourhood to that of the next.
const NEIGHBOURHOOD_GROWTH: f64 = 1.6;
/// Most starts that are followed.
const MAX_FOLLOWED: usize = 24;
/// Most points of a neighbourhood that are used.
const MAX_NEIGHBOURHOOD: usize = 240;
/// The first of so many parts of the cloud is searched for the points of a large neighbourhood.
const FIRST_PART: usize = 16;
/// Most points inside a section for each one on it.
const MAX_INSIDE_FIRST: f64 = 0.15;
const MAX_INSIDE: f64 = 0.3;
/// Largest root mean square of the points' distances from a first section, in radii. Points scattered evenly over the
/// circle's tolerance have 0.087.
const MAX_RMS_FIRST: f64 = 0.06;
/// Least share of the girth that shows a section, and least share of the points on a first one.
const MIN_COVERAGE: f64 = 0.2;
const MIN_ON_SECTION_FIRST: f64 = 0.5;
/// Least evidence of a section: one such circle in a thousand crowns is chance.
const MIN_EVIDENCE: f64 = 6.9;
/// Least evidence of a whole limb. In crowns that show no stem, tubes with half of it turn up.
const MIN_LIMB_EVIDENCE: f64 = 200.0;
/// A point as location may be this far from the middle of a section, in radii.
const MAX_DISTANCE_RADII: f64 = 2.0;
/// Least share of the points of a section ahead of its plane, and behind it: a section is no farther than the cloud.
const MIN_EITHER_SIDE: f64 = 0.1;
/// Steps along a limb, in radii.
const STEP_RADII: f64 = 0.5;
/// Fewest rings of a limb.
const MIN_RINGS: usize = 4;
/// Rings on each side of one that say how clearly a limb shows there.
const CLARITY_RINGS: usize = 6;
/// Most steps along a limb.
const MAX_STEPS: usize = 4000;

/// A limb as it was followed.
pub(super) struct Limb {
    /// In order.
    pub rings: Vec<Ring>,
    /// The ring from which it was followed both ways.
    pub start: usize,
}

/// The limb at a location.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn limb(
    cloud: &Searched,
    location: &StemLocation,
    context: &Context,
) -> Result<Option<Limb>, Cancelled> {
    let mut starts: Vec<Ring> = match location {
        StemLocation::Point(p) => cloud.starts_near(*p, context)?,
        _ => cloud.starts(&context.part(0.0, 0.5))?,
    };
    starts.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let mut chosen: Vec<Ring> = Vec::new();
    for start in starts {
        let same = |t: &Ring| t.centre.distance(start.centre) < 0.5 * (t.radius + start.radius);
        if chosen.len() < MAX_FOLLOWED && !chosen.iter().any(same) {
            chosen.push(start);
        }
    }
    let mut best: Option<(f64, Limb)> = None;
    // A few at once, so that progress is reported between them.
    const AT_ONCE: usize = 4;
    for (k, few) in chosen.chunks(AT_ONCE).enumerate() {
        let done = (k * AT_ONCE) as f64 / chosen.len() as f64;
        context.report(0.5 + 0.5 * done)?;
        let limbs: Vec<Limb> = few
            .par_iter()
            .map(|start| cloud.follow(*start, context))
            .collect::<Result<_, _>>()?;
        for limb in limbs {
            let here = match location {
                StemLocation::Point(p) => limb.passes(*p),
                _ => true,
            };
            let score = if here { limb.cell_evidence() } else { 0.0 };
            if limb.is_tube() && best.as_ref().is_none_or(|b| score > b.0) {
                best = Some((score, limb));
            }
        }
    }
    let Some((_, best)) = best else {
        return Ok(None);
    };
    // Again from where it shows best: what is found does not depend on where it was come upon.
    Ok(Some(cloud.follow(best.clearest(), context)?))
}

impl Limb {
    /// The ring about which its sections are clearest.
    fn clearest(&self) -> Ring {
        let count = self.rings.len();
        let clarity = |k: usize| -> f64 {
            let near = k.saturating_sub(CLARITY_RINGS)..(k + CLARITY_RINGS + 1).min(count);
            self.rings[near].iter().map(|r| r.information).sum()
        };
        let best = (0..count).max_by(|a, b| clarity(*a).total_cmp(&clarity(*b)));
        self.rings[best.unwrap_or(0)]
    }

    /// Cuts off what is farther than `reach` (m) from the start towards the first (`side` 0) or the last ring (1).
    pub fn cut(&mut self, side: usize, reach: f64) {
        let mut length = 0.0;
        let mut retained = 1;
        let side_rings: Vec<&Ring> = if side == 0 {
            self.rings[..=self.start].iter().rev().collect()
        } else {
            self.rings[self.start..].iter().collect()
        };
        for pair in side_rings.windows(2) {
            length += pair[0].centre.distance(pair[1].centre);
            if length > reach {
                break;
            }
            retained += 1;
        }
        if retained == side_rings.len() {
            return;
        }
        if side == 0 {
            self.rings.drain(..=self.start - retained);
            self.start = retained - 1;
        } else {
            self.rings.truncate(self.start + retained);
        }
    }

    /// The evidence of the rings' occupied cells that the points are those of a tube and not scattered. The clumps of a crown
    /// make circles of many points, which stand in few places.
    fn cell_evidence(&self) -> f64 {
        self.rings.iter().map(|r| r.cell_evidence).sum()
    }

    /// Whether a point lies in the limb or close to it.
    fn passes(&self, p: DVec3) -> bool {
        let mut rings = self.rings.iter();
        rings.any(|r| r.centre.distance(p) < MAX_DISTANCE_RADII * r.radius)
    }

    /// Whether the points are surely those of a tube.
    pub fn is_certain(&self) -> bool {
        self.is_tube() && self.cell_evidence() > MIN_LIMB_EVIDENCE
    }

    /// Whether there are rings enough, and their mean evidence suffices. The first ring has none of its own.
    fn is_tube(&self) -> bool {
        let mean = self.cell_evidence() / self.rings.len().max(1) as f64;
        self.rings.len() >= MIN_RINGS && mean > MIN_EVIDENCE
    }
}

/// Numbers of the points in layers of equal height of the cloud's lower half.
fn lower_layers(points: &[DVec3], count: usize) -> Vec<Vec<u32>> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in points {
        (low, high) = (low.min(p.z), high.max(p.z));
    }
    let mut layers = vec![Vec::new(); count];
    let thickness = 0.5 * (high - low) / count as f64;
    for (p, i) in points.iter().zip(0..) {
        if let Some(layer) = layers.get_mut(((p.z - low) / thickness) as usize) {
            layer.push(i);
        }
    }
    layers
}

/// The `count` least of some numbers, ascending.
fn least(mut numbers: Vec<u32>, count: usize) -> Vec<u32> {
    if numbers.len() > count {
        numbers.select_nth_unstable(count);
        numbers.truncate(count);
    }
    numbers.sort_unstable();
    numbers
}

/// Sum of the outer products of vectors with themselves.
fn spread(vectors: impl Iterator<Item = DVec3>) -> DMat3 {
    vectors.fold(DMat3::ZERO, |sum, v| {
        sum + DMat3::from_cols(v * v.x, v * v.y, v * v.z)
    })
}

/// Where the next section of a limb is expected.
#[derive(Debug, Clone, Copy)]
struct ExpectedSection {
    centre: DVec3,
    along: DVec3,
    radius: f64,
}

/// A section that was found where it was expected.
struct FoundSection {
    /// In the plane across the limb, about the expected centre.
    circle: Circle,
    /// Thickness of the slab whose points show it, in radii.
    thickness: f64,
}

impl Searched<'_> {
    /// First sections all over the cloud. Every other one is looked for in the lower half, layer by layer: a standing tree
    /// has its stem there and little else, however many points its crown has.
    fn starts(&self, context: &Context) -> Result<Vec<Ring>, Cancelled> {
        const LAYERS: usize = 32;
        const AT_ONCE: i64 = 16;
        let layers = lower_layers(self.points, LAYERS);
        let mut found = Vec::new();
        for first in (0..STARTS).step_by(AT_ONCE as usize) {
            context.report(first as f64 / STARTS as f64)?;
            let some: Vec<Vec<Ring>> = (first..first + AT_ONCE)
                .into_par_iter()
                .map(|k| {
                    let layer = &layers[(k / 2) as usize % layers.len().max(1)];
                    let chance = noise::unit(11, k, 0, 0);
                    let at = |count: usize| ((chance * count as f64) as usize).min(count - 1);
                    let i = if k % 2 == 0 || layer.is_empty() {
                        at(self.points.len())
                    } else {
                        layer[at(layer.len())] as usize
                    };
                    self.rings_at(self.points[i], k as u64, context)
                })
                .collect::<Result<_, _>>()?;
            found.extend(some.into_iter().flatten());
        }
        Ok(found)
    }

    /// First sections about a point: of its own neighbourhoods and of those of points near it.
    fn starts_near(&self, at: DVec3, context: &Context) -> Result<Vec<Ring>, Cancelled> {
        const NEIGHBOURS: usize = 128;
        const EVERY: usize = 16;
        let near = self.tree.nearest(at, NEIGHBOURS);
        let starts: Vec<Vec<Ring>> = near
            .par_iter()
            .step_by(EVERY)
            .enumerate()
            .map(|(k, (_, i))| self.rings_at(self.points[*i as usize], k as u64, context))
            .collect::<Result<_, _>>()?;
        Ok(starts.concat())
    }

    /// The best sections of neighbourhoods of a point, of every size.
    fn rings_at(&self, at: DVec3, seed: u64, context: &Context) -> Result<Vec<Ring>, Cancelled> {
        const MIN_POINTS: usize = 24;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in self.points {
            (low, high) = (low.min(*p), high.max(*p));
        }
        let largest = 0.6 * low.distance(high);
        let at = self
            .tree
            .nearest(at, 1)
            .first()
            .map_or(at, |n| self.points[n.1 as usize]);
        let mut found = Vec::new();
        let mut reach = 6.0 * self.spacing;
        while reach < largest {
            context.check()?;
            let ball = self.first_within(at, reach);
            if ball.len() >= MIN_POINTS {
                found.extend(self.ring_of(at, ball, reach, seed));
            }
            reach *= NEIGHBOURHOOD_GROWTH;
        }
        Ok(found)
    }

    /// Numbers of the first points of a neighbourhood, ascending: no more than are used.
    fn first_within(&self, at: DVec3, reach: f64) -> Vec<u32> {
        // A large neighbourhood has them among the first points of the cloud, and is slow to collect.
        let first = &self.points[..self.points.len() / FIRST_PART];
        let inside = |p: &DVec3| p.distance_squared(at) <= reach * reach;
        let numbered = first.iter().zip(0..).filter(|(p, _)| inside(p));
        let few: Vec<u32> = numbered.map(|(_, i)| i).take(MAX_NEIGHBOURHOOD).collect();
        if few.len() == MAX_NEIGHBOURHOOD {
            return few;
        }
        least(self.tree.within_unordered(at, reach), MAX_NEIGHBOURHOOD)
    }

    /// The best section of a neighbourhood, given by its first points.
    fn ring_of(&self, at: DVec3, ball: Vec<u32>, reach: f64, seed: u64) -> Option<Ring> {
        let points: Vec<DVec3> = ball.iter().map(|&i| self.points[i as usize]).collect();
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let own = KdTree::new(&points);
        let by_normals = symmetric_eigen(spread(normals(&points, &own, 10).into_iter()))[0].1;
        let by_length = symmetric_eigen(spread(points.iter().map(|p| *p - mean)))[2].1;
        let mut best: Option<Ring> = None;
        for along in [by_normals, by_length] {
            let (x, y) = self.across(at, along);
            let flat: Vec<DVec2> = points
                .iter()
                .map(|p| DVec2::new((*p - at).dot(x), (*p - at).dot(y)))
                .collect();
            let expected = Expected {
                min_radius: 0.08 * reach,
                max_radius: 1.2 * reach,
                prior: None,
            };
            let Some(c) = fit(&flat, &expected, seed) else {
                continue;
            };
            // Of equal evidence those go first of which more was seen: short arcs lie on many circles.
            let evidence = c.evidence * (1.6 * c.coverage).min(1.0);
            if c.share > MIN_ON_SECTION_FIRST
                && c.coverage > MIN_COVERAGE
                && c.inside < MAX_INSIDE_FIRST
                && c.rms < MAX_RMS_FIRST * c.radius
                && evidence > MIN_EVIDENCE
                && best.is_none_or(|b| evidence > b.evidence)
            {
                best = Some(Ring {
                    centre: at + x * c.centre.x + y * c.centre.y,
                    along,
                    radius: c.radius,
                    evidence,
                    cell_evidence: c.cell_evidence,
                    information: c.information,
                    radius_error: c.radius_error,
                });
            }
        }
        best
    }

    /// Directions across a limb that turn with the points: towards the first of them, and square to it.
    fn across(&self, centre: DVec3, along: DVec3) -> (DVec3, DVec3) {
        let ends = [0, self.points.len() - 1].map(|i| self.points[i] - centre);
        let square = ends.map(|d| d.reject_from_normalized(along));
        let towards = if square[0].length() > 0.1 * ends[0].length() {
            square[0]
        } else {
            square[1]
        };
        match towards.try_normalize() {
            Some(x) => (x, along.cross(x)),
            None => along.any_orthonormal_pair(),
        }
    }

    /// The section near where one is expected, of the points of a slab across it.
    fn section(&self, near: ExpectedSection) -> Option<FoundSection> {
        let ExpectedSection {
            centre,
            along,
            radius,
        } = near;
        let (x, y) = self.across(centre, along);
        let ball = self.tree.within(centre, 2.9 * radius);
        for half in [0.25, 0.5, 1.0, 2.0] {
            let slab: Vec<DVec3> = ball
                .iter()
                .map(|&i| self.points[i as usize] - centre)
                .filter(|d| d.dot(along).abs() <= half * radius)
                .map(|d| DVec3::new(d.dot(x), d.dot(y), d.dot(along)))
                .filter(|d| d.truncate().length() < 2.0 * radius)
                .collect();
            if slab.len() < 20 && half < 2.0 {
                continue;
            }
            let ahead = slab.iter().filter(|d| d.z > 0.0).count() as f64;
            let least = MIN_EITHER_SIDE * slab.len() as f64;
            if slab.len() < 8 || ahead < least || slab.len() as f64 - ahead < least {
                return None;
            }
            let flat: Vec<DVec2> = slab.iter().map(|d| d.truncate()).collect();
            let expected = Expected {
                min_radius: 0.7 * radius,
                max_radius: 1.4 * radius,
                prior: Some(Prior {
                    centre: DVec2::ZERO,
                    radius,
                    max_offset: 0.5 * radius,
                }),
            };
            let circle = fit(&flat, &expected, 0)
                .filter(|c| c.coverage >= MIN_COVERAGE && c.inside < MAX_INSIDE);
            return circle.map(|circle| FoundSection {
                circle,
                thickness: 2.0 * half,
            });
        }
        None
    }

    /// Rings from one end to the other through a first one.
    pub fn follow(&self, start: Ring, context: &Context) -> Result<Limb, Cancelled> {
        let mut rings = self.march(start, -1.0, context)?;
        let ahead = self.march(start, 1.0, context)?;
        rings.reverse();
        let begun = rings.len();
        // The evidence of the first section is that of its neighbours, too.
        rings.push(Ring {
            evidence: 0.0,
            cell_evidence: 0.0,
            ..start
        });
        rings.extend(ahead);
        Ok(Limb {
            rings,
            start: begun,
        })
    }

    /// Rings from a first one on, forwards (`sign` 1) or backwards (−1).
    fn march(&self, start: Ring, sign: f64, context: &Context) -> Result<Vec<Ring>, Cancelled> {
        let mut rings: Vec<Ring> = Vec::new();
        let mut at = start;
        let mut along = start.along * sign;
        let mut trail = vec![start.centre];
        let mut merit = Merit::default();
        for _ in 0..MAX_STEPS {
            context.check()?;
            at.centre += along * (STEP_RADII * at.radius);
            let near = ExpectedSection {
                centre: at.centre,
                along,
                radius: at.radius,
            };
            let Some(found) = self.section(near) else {
                if merit.add(None, rings.len()) {
                    break;
                }
                continue;
            };
            let FoundSection { circle, thickness } = found;
            let (x, y) = self.across(at.centre, along);
            let centre = at.centre + x * circle.centre.x + y * circle.centre.y;
            trail.push(centre);
            let from = trail[trail.len().saturating_sub(7)];
            let towards = (centre - from).try_normalize().unwrap_or(along);
            if towards.dot(along) > 0.5 {
                along = (along * 2.0 + towards).normalize();
            }
            at = Ring {
                centre,
                along: along * sign,
                radius: 0.5 * (at.radius + circle.radius),
                evidence: circle.evidence * STEP_RADII / thickness,
                cell_evidence: circle.cell_evidence * STEP_RADII / thickness,
                information: circle.information,
                radius_error: circle.radius_error,
            };
            rings.push(Ring {
                radius: circle.radius,
                ..at
            });
            if merit.add(Some(circle.information), rings.len()) {
                break;
            }
        }
        rings.truncate(merit.rings);
        Ok(rings)
    }
}
