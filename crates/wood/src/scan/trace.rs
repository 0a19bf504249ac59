//! Finding a stem or limb in a cloud and following it both ways until it forks or the points thin out.
//!
//! Bark is locally a cylinder: its normals are square to the axis, so that the direction in which they vary least is the
//! axis; where noise spoils normals, the longest direction of the points stands in.

use super::circle::{Circle, Expected, fit};
use crate::noise;
use crate::stem::Place;
use glam::{DMat3, DVec2, DVec3};
use greenstick_geometry::cloud::{KdTree, normals};
use greenstick_geometry::symmetric_eigen;
use greenstick_geometry::{Cancelled, Context};
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
    /// The same, of places that are apart instead of points.
    apart: f64,
}

/// Points with what is asked of them.
pub(super) struct Searched<'a> {
    pub points: &'a [DVec3],
    pub tree: &'a KdTree,
    pub spacing: f64,
}

/// Points at which a first section is tried where no point was asked for.
const STARTS: i64 = 128;
/// Neighbourhoods' radii grow by this factor.
const GROWTH: f64 = 1.6;
/// Starts that are followed.
const FOLLOWED: usize = 24;
/// Points of a neighbourhood that are looked at.
const LOOKED_AT: usize = 240;
/// Points inside a section for each one on it, at most: of a first section, and of those that follow.
const HOLLOW: (f64, f64) = (0.15, 0.3);
/// Root of the mean square of the points' distances from a section, in radii, at most: of a first section, and of those
/// that follow. Points strewn evenly over the circle's tolerance have 0.087.
const LOOSE: (f64, f64) = (0.06, 0.07);
/// Evidence of a section, at least: one such circle in a thousand crowns is chance.
const EVIDENT: f64 = 6.9;
/// Points of a section that lie ahead of its plane and behind it, at least: a section is no farther than the cloud.
const EITHER_SIDE: f64 = 0.1;
/// Steps along a limb, in radii.
const STEP: f64 = 0.5;
/// Steps without a section before a limb ends: a hole in the scan, a whorl of branches.
const MISSES: usize = 6;
/// No limb is longer in steps.
const LONGEST: usize = 4000;

/// A limb as rings in order, and why it ends where it does at either end.
pub(super) type Limb = (Vec<Ring>, Vec<String>);

/// The limb at a place.
pub(super) fn limb(
    cloud: &Searched,
    place: &Place,
    context: &Context,
) -> Result<Option<Limb>, Cancelled> {
    let mut starts: Vec<Ring> = match place {
        Place::Point(p) => rings_at(cloud, *p, 0),
        _ => starts(cloud, context)?,
    };
    starts.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let mut chosen: Vec<Ring> = Vec::new();
    for start in starts {
        let same = |t: &Ring| t.centre.distance(start.centre) < 0.5 * (t.radius + start.radius);
        if chosen.len() < FOLLOWED && !chosen.iter().any(same) {
            chosen.push(start);
        }
    }
    let mut best: Option<(f64, Limb)> = None;
    // A few at once, so that the caller can stop between them.
    const AT_ONCE: usize = 4;
    for (k, few) in chosen.chunks(AT_ONCE).enumerate() {
        let done = (k * AT_ONCE) as f64 / chosen.len() as f64;
        context.report(0.5 + 0.5 * done)?;
        let limbs: Vec<Limb> = few.par_iter().map(|s| followed(cloud, *s)).collect();
        for limb in limbs {
            let score = score(&limb.0);
            if limb.0.len() >= 4 && best.as_ref().is_none_or(|b| score > b.0) {
                best = Some((score, limb));
            }
        }
    }
    // The clumps of a crown make circles of many points, which stand in few places.
    Ok(best
        .map(|(_, limb)| limb)
        .filter(|limb| mean_apart(&limb.0) > EVIDENT))
}

/// First sections all over the cloud. Every other one is looked for in the lower half, layer by layer: a standing tree
/// has its stem there and little else, however many points its crown has.
fn starts(cloud: &Searched, context: &Context) -> Result<Vec<Ring>, Cancelled> {
    const LAYERS: usize = 32;
    let layers = lower_layers(cloud.points, LAYERS);
    let mut found = Vec::new();
    const AT_ONCE: i64 = 16;
    for first in (0..STARTS).step_by(AT_ONCE as usize) {
        context.report(0.5 * first as f64 / STARTS as f64)?;
        let some: Vec<Vec<Ring>> = (first..first + AT_ONCE)
            .into_par_iter()
            .map(|k| {
                let layer = &layers[(k / 2) as usize % layers.len().max(1)];
                let chance = noise::unit(11, k, 0, 0);
                let at = |count: usize| ((chance * count as f64) as usize).min(count - 1);
                let i = if k % 2 == 0 || layer.is_empty() {
                    at(cloud.points.len())
                } else {
                    layer[at(layer.len())] as usize
                };
                rings_at(cloud, cloud.points[i], k as u64)
            })
            .collect();
        found.extend(some.into_iter().flatten());
    }
    Ok(found)
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

/// How good a stem rings make: the evidence that their points are of a tube and not strewn.
fn score(rings: &[Ring]) -> f64 {
    rings.iter().map(|r| r.evidence).sum()
}

/// Mean evidence of rings' occupied places. The first ring has none of its own.
fn mean_apart(rings: &[Ring]) -> f64 {
    rings.iter().map(|r| r.apart).sum::<f64>() / rings.len().max(1) as f64
}

/// The best sections of neighbourhoods of a point, of every size.
fn rings_at(cloud: &Searched, at: DVec3, seed: u64) -> Vec<Ring> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in cloud.points {
        (low, high) = (low.min(*p), high.max(*p));
    }
    let largest = 0.6 * low.distance(high);
    let at = cloud
        .tree
        .nearest(at, 1)
        .first()
        .map_or(at, |n| cloud.points[n.1 as usize]);
    let mut found = Vec::new();
    let mut reach = 6.0 * cloud.spacing;
    while reach < largest {
        let ball = cloud.tree.within_unordered(at, reach);
        if ball.len() >= 24 {
            found.extend(ring_of(cloud, at, &ball, reach, seed));
        }
        reach *= GROWTH;
    }
    found
}

fn spread(vectors: impl Iterator<Item = DVec3>) -> DMat3 {
    vectors.fold(DMat3::ZERO, |sum, v| {
        sum + DMat3::from_cols(v * v.x, v * v.y, v * v.z)
    })
}

/// The best section of a neighbourhood.
fn ring_of(cloud: &Searched, at: DVec3, ball: &[u32], reach: f64, seed: u64) -> Option<Ring> {
    let stride = ball.len().div_ceil(LOOKED_AT);
    let points: Vec<DVec3> = ball
        .iter()
        .step_by(stride)
        .map(|&i| cloud.points[i as usize])
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
            radius: (0.08 * reach, 1.2 * reach),
            near: None,
        };
        let Some(c) = fit(&flat, &expected, seed) else {
            continue;
        };
        // Of equal evidence those go first of which more was seen: short arcs lie on many circles.
        let evidence = c.evidence * (1.6 * c.cover).min(1.0);
        if c.share > 0.5
            && c.cover > 0.2
            && c.inside < HOLLOW.0
            && c.rms < LOOSE.0 * c.radius
            && evidence > EVIDENT
            && best.is_none_or(|b| evidence > b.evidence)
        {
            best = Some(Ring {
                centre: at + x * c.centre.x + y * c.centre.y,
                along,
                radius: c.radius,
                evidence,
                apart: c.apart,
            });
        }
    }
    best
}

/// A section near where one is expected, the points of a slab across it taken, and the slab's thickness in radii.
fn section(
    cloud: &Searched,
    centre: DVec3,
    along: DVec3,
    radius: f64,
    seed: u64,
) -> Option<(Circle, f64)> {
    let (x, y) = along.any_orthonormal_pair();
    let near = cloud.tree.within_unordered(centre, 2.2 * radius);
    for half in [0.25, 0.5, 1.0] {
        let slab: Vec<DVec3> = near
            .iter()
            .map(|&i| cloud.points[i as usize] - centre)
            .filter(|d| d.dot(along).abs() <= half * radius)
            .map(|d| DVec3::new(d.dot(x), d.dot(y), d.dot(along)))
            .filter(|d| d.truncate().length() < 2.0 * radius)
            .collect();
        if slab.len() < 20 && half < 1.0 {
            continue;
        }
        let ahead = slab.iter().filter(|d| d.z > 0.0).count() as f64;
        let least = EITHER_SIDE * slab.len() as f64;
        if slab.len() < 8 || ahead < least || slab.len() as f64 - ahead < least {
            return None;
        }
        let flat: Vec<DVec2> = slab.iter().map(|d| d.truncate()).collect();
        let expected = Expected {
            radius: (0.7 * radius, 1.4 * radius),
            near: Some((DVec2::ZERO, 0.5 * radius, radius)),
        };
        let circle = fit(&flat, &expected, seed).filter(|c| {
            c.cover >= 0.2
                && c.share >= 0.35
                && c.inside < HOLLOW.1
                && c.rms < LOOSE.1 * c.radius
                && c.evidence > EVIDENT
        });
        return circle.map(|c| (c, 2.0 * half));
    }
    None
}

/// Rings from one end to the other through a first one.
fn followed(cloud: &Searched, start: Ring) -> (Vec<Ring>, Vec<String>) {
    let (mut back, first) = march(cloud, start, -1.0);
    let (ahead, last) = march(cloud, start, 1.0);
    back.reverse();
    let mut rings = back;
    // What a first section says is said by its neighbours, too.
    rings.push(Ring {
        evidence: 0.0,
        apart: 0.0,
        ..start
    });
    rings.extend(ahead);
    (rings, vec![first, last])
}

fn march(cloud: &Searched, start: Ring, sign: f64) -> (Vec<Ring>, String) {
    let mut rings: Vec<Ring> = Vec::new();
    let mut at = start;
    let mut along = start.along * sign;
    let (mut misses, mut strangers) = (0, 0);
    let mut trail = vec![start.centre];
    for k in 0..LONGEST {
        let step = STEP * at.radius.max(2.0 * cloud.spacing);
        at.centre += along * step;
        let found = section(cloud, at.centre, along, at.radius, k as u64 + 100);
        let Some((c, thickness)) = found else {
            misses += 1;
            if misses > MISSES {
                return (rings, format!("the points thin out near {:.3}", at.centre));
            }
            continue;
        };
        let (x, y) = along.any_orthonormal_pair();
        let centre = at.centre + x * c.centre.x + y * c.centre.y;
        // Where other limbs hold most of the points about, the stem has forked or is lost in the crown.
        strangers = if c.share < 0.5 { strangers + 1 } else { 0 };
        if strangers > MISSES {
            rings.truncate(rings.len().saturating_sub(strangers - 1));
            return (rings, format!("other limbs surround it near {centre:.3}"));
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
            radius: 0.5 * (at.radius + c.radius),
            evidence: c.evidence * STEP / thickness,
            apart: c.apart * STEP / thickness,
        };
        rings.push(Ring {
            radius: c.radius,
            ..at
        });
    }
    (rings, "it is longer than any limb".to_owned())
}
