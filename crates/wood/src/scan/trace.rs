//! Finding a stem or limb in a cloud and following it both ways until it forks or the points thin out.
//!
//! Bark is locally a cylinder: its normals are square to the axis, so that the direction in which they vary least is the
//! axis; where noise spoils normals, the longest direction of the points stands in.

use super::circle::{Circle, Expected, Prior, fit};
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
}

/// Points that are searched for a stem.
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
/// Most points inside a section for each one on it.
const MAX_INSIDE_FIRST: f64 = 0.15;
const MAX_INSIDE: f64 = 0.3;
/// Largest root mean square of the points' distances from a section, in radii: of a first section, and of those that
/// follow. Points scattered evenly over the circle's tolerance have 0.087.
const MAX_RMS_FIRST: f64 = 0.06;
const MAX_RMS: f64 = 0.07;
/// Least share of the girth that shows a section, and least share of the points on it: first and following ones.
const MIN_COVERAGE: f64 = 0.2;
const MIN_ON_SECTION_FIRST: f64 = 0.5;
const MIN_ON_SECTION: f64 = 0.35;
/// Least evidence of a section: one such circle in a thousand crowns is chance.
const MIN_EVIDENCE: f64 = 6.9;
/// Least share of the points of a section ahead of its plane, and behind it: a section is no farther than the cloud.
const MIN_EITHER_SIDE: f64 = 0.1;
/// Steps along a limb, in radii.
const STEP_RADII: f64 = 0.5;
/// Steps without a section before a limb ends: a hole in the scan, a whorl of branches.
const MAX_MISSES: usize = 6;
/// Most steps along a limb.
const MAX_STEPS: usize = 4000;

/// A limb as it was followed.
pub(super) struct Limb {
    /// In order.
    pub rings: Vec<Ring>,
    /// Why it ends at the first and at the last ring.
    pub ends: [String; 2],
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
        StemLocation::Point(p) => cloud.rings_at(*p, 0, context)?,
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
            let score = limb.evidence();
            if limb.rings.len() >= 4 && best.as_ref().is_none_or(|b| score > b.0) {
                best = Some((score, limb));
            }
        }
    }
    // The clumps of a crown make circles of many points, which stand in few places.
    Ok(best
        .map(|(_, limb)| limb)
        .filter(|limb| limb.mean_cell_evidence() > MIN_EVIDENCE))
}

impl Limb {
    /// The evidence that the points are those of a tube and not scattered.
    fn evidence(&self) -> f64 {
        self.rings.iter().map(|r| r.evidence).sum()
    }

    /// Mean evidence of the rings' occupied cells. The first ring has none of its own.
    fn mean_cell_evidence(&self) -> f64 {
        let sum: f64 = self.rings.iter().map(|r| r.cell_evidence).sum();
        sum / self.rings.len().max(1) as f64
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
            let ball = self.tree.within_unordered(at, reach);
            if ball.len() >= MIN_POINTS {
                found.extend(self.ring_of(at, &ball, reach, seed));
            }
            reach *= NEIGHBOURHOOD_GROWTH;
        }
        Ok(found)
    }

    /// The best section of a neighbourhood.
    fn ring_of(&self, at: DVec3, ball: &[u32], reach: f64, seed: u64) -> Option<Ring> {
        let stride = ball.len().div_ceil(MAX_NEIGHBOURHOOD);
        let points: Vec<DVec3> = ball
            .iter()
            .step_by(stride)
            .map(|&i| self.points[i as usize])
            .collect();
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        let own = KdTree::new(&points);
        let by_normals = symmetric_eigen(spread(normals(&points, &own, 10).into_iter()))[0].1;
        let by_length = symmetric_eigen(spread(points.iter().map(|p| *p - mean)))[2].1;
        let mut best: Option<Ring> = None;
        for along in [by_normals, by_length] {
            let (x, y) = along.any_orthonormal_pair();
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
                });
            }
        }
        best
    }

    /// The section near where one is expected, of the points of a slab across it.
    fn section(&self, near: ExpectedSection, seed: u64) -> Option<FoundSection> {
        let ExpectedSection {
            centre,
            along,
            radius,
        } = near;
        let (x, y) = along.any_orthonormal_pair();
        let ball = self.tree.within_unordered(centre, 2.2 * radius);
        for half in [0.25, 0.5, 1.0] {
            let slab: Vec<DVec3> = ball
                .iter()
                .map(|&i| self.points[i as usize] - centre)
                .filter(|d| d.dot(along).abs() <= half * radius)
                .map(|d| DVec3::new(d.dot(x), d.dot(y), d.dot(along)))
                .filter(|d| d.truncate().length() < 2.0 * radius)
                .collect();
            if slab.len() < 20 && half < 1.0 {
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
            let circle = fit(&flat, &expected, seed).filter(|c| {
                c.coverage >= MIN_COVERAGE
                    && c.share >= MIN_ON_SECTION
                    && c.inside < MAX_INSIDE
                    && c.rms < MAX_RMS * c.radius
                    && c.evidence > MIN_EVIDENCE
            });
            return circle.map(|circle| FoundSection {
                circle,
                thickness: 2.0 * half,
            });
        }
        None
    }

    /// Rings from one end to the other through a first one.
    fn follow(&self, start: Ring, context: &Context) -> Result<Limb, Cancelled> {
        let (mut rings, first) = self.march(start, -1.0, context)?;
        let (ahead, last) = self.march(start, 1.0, context)?;
        rings.reverse();
        // The evidence of the first section is that of its neighbours, too.
        rings.push(Ring {
            evidence: 0.0,
            cell_evidence: 0.0,
            ..start
        });
        rings.extend(ahead);
        Ok(Limb {
            rings,
            ends: [first, last],
        })
    }

    /// Rings from a first one on, forwards (`sign` 1) or backwards (−1), and why they end.
    fn march(
        &self,
        start: Ring,
        sign: f64,
        context: &Context,
    ) -> Result<(Vec<Ring>, String), Cancelled> {
        let mut rings: Vec<Ring> = Vec::new();
        let mut at = start;
        let mut along = start.along * sign;
        let (mut misses, mut crowded) = (0, 0);
        let mut trail = vec![start.centre];
        for k in 0..MAX_STEPS {
            context.check()?;
            let step = STEP_RADII * at.radius.max(2.0 * self.spacing);
            at.centre += along * step;
            let near = ExpectedSection {
                centre: at.centre,
                along,
                radius: at.radius,
            };
            let Some(FoundSection { circle, thickness }) = self.section(near, k as u64 + 100)
            else {
                misses += 1;
                if misses > MAX_MISSES {
                    return Ok((rings, format!("the points thin out near {:.3}", at.centre)));
                }
                continue;
            };
            let (x, y) = along.any_orthonormal_pair();
            let centre = at.centre + x * circle.centre.x + y * circle.centre.y;
            // Where other limbs hold most of the points about, the stem has forked or is lost in the crown.
            crowded = if circle.share < 0.5 { crowded + 1 } else { 0 };
            if crowded > MAX_MISSES {
                rings.truncate(rings.len().saturating_sub(crowded - 1));
                return Ok((rings, format!("other limbs surround it near {centre:.3}")));
            }
            misses = 0;
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
            };
            rings.push(Ring {
                radius: circle.radius,
                ..at
            });
        }
        Ok((rings, "it is longer than any limb".to_owned()))
    }
}
