//! Finding a stem or limb in a cloud and following it both ways until it forks or the points thin out.
//!
//! Bark is locally a cylinder: its normals are square to the axis, so that the direction in which they vary least is the
//! axis; where noise spoils normals, the longest direction of the points stands in.

use super::circle::{Circle, Expected, fit};
use crate::noise;
use crate::stem::Place;
use glam::{DMat3, DVec2, DVec3};
use greenstick_geometry::cloud::{Neighbours, eigen, normals};
use greenstick_geometry::{Cancelled, Context};

/// A section of a limb as a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ring {
    pub centre: DVec3,
    /// Along the limb (unit).
    pub along: DVec3,
    pub radius: f64,
    /// How well the points lie on it, and how much of it they cover.
    merit: f64,
}

/// Points with what is asked of them.
pub(super) struct Searched<'a> {
    pub points: &'a [DVec3],
    pub tree: &'a Neighbours,
    pub spacing: f64,
}

/// Points at which a first section is tried where no point was asked for.
const STARTS: i64 = 96;
/// Neighbourhoods' radii grow by this factor.
const GROWTH: f64 = 1.6;
/// Starts that are followed.
const FOLLOWED: usize = 10;
/// Points of a neighbourhood that are looked at.
const LOOKED_AT: usize = 240;
/// Points inside a section for each one on it, at most: of a first section, and of those that follow.
const HOLLOW: (f64, f64) = (0.15, 0.3);
/// Root of the mean square of the points' distances from a section, in radii, at most: of a first section, and of those
/// that follow. Points strewn evenly over the circle's tolerance have 0.087.
const LOOSE: (f64, f64) = (0.06, 0.07);
/// Steps along a limb, in radii.
const STEP: f64 = 0.5;
/// Steps without a section before a limb ends: a hole in the scan, a whorl of branches.
const MISSES: usize = 6;
/// No limb is longer in steps.
const LONGEST: usize = 4000;

/// The limb at a place as rings in order, and why it ends where it does.
pub(super) fn limb(
    cloud: &Searched,
    place: &Place,
    context: &Context,
) -> Result<Option<(Vec<Ring>, Vec<String>)>, Cancelled> {
    let mut starts: Vec<Ring> = Vec::new();
    match place {
        Place::Point(p) => starts.extend(rings_at(cloud, *p, 0)),
        _ => {
            let all: Vec<u32> = (0..cloud.points.len() as u32).collect();
            let low = lowest(cloud.points);
            for k in 0..STARTS {
                context.step("find stem", 0.5 * k as f64 / STARTS as f64)?;
                // Every other start lies low, where a standing tree has its stem and nothing else.
                let among = if k % 2 == 0 { &all } else { &low };
                let i = (noise::unit(11, k, 0, 0) * among.len() as f64) as usize;
                let at = cloud.points[among[i.min(among.len() - 1)] as usize];
                starts.extend(rings_at(cloud, at, k as u64).map(|mut ring| {
                    ring.merit *= ring.merit * ring.radius;
                    ring
                }));
            }
        }
    }
    starts.sort_by(|a, b| b.merit.total_cmp(&a.merit));
    let mut best: Option<(f64, Vec<Ring>, Vec<String>)> = None;
    let mut tried: Vec<Ring> = Vec::new();
    for start in starts {
        let same = |t: &Ring| t.centre.distance(start.centre) < 0.5 * (t.radius + start.radius);
        if tried.iter().any(same) {
            continue;
        }
        context.step(
            "find stem",
            0.5 + 0.5 * tried.len() as f64 / FOLLOWED as f64,
        )?;
        tried.push(start);
        let (rings, ends) = followed(cloud, start);
        let score = score(&rings);
        if rings.len() >= 4 && best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, rings, ends));
        }
        if tried.len() == FOLLOWED {
            break;
        }
    }
    Ok(best.map(|(_, rings, ends)| (rings, ends)))
}

/// Numbers of the points in the lowest part of the cloud's height.
fn lowest(points: &[DVec3]) -> Vec<u32> {
    const PART: f64 = 0.25;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in points {
        (low, high) = (low.min(p.z), high.max(p.z));
    }
    let limit = low + PART * (high - low);
    (0..points.len() as u32)
        .filter(|&i| points[i as usize].z <= limit)
        .collect()
}

/// Slenderness (length over radius) from which on nobody doubts a stem.
const SLENDER: f64 = 8.0;

/// How good a stem rings make: their volume, each weighed by how well the points lie on it, and less where they are no
/// longer than wide, as what is fitted to a crown.
fn score(rings: &[Ring]) -> f64 {
    let (mut volume, mut slenderness) = (0.0, 0.0);
    for pair in rings.windows(2) {
        let step = pair[0].centre.distance(pair[1].centre);
        let [r, merit] = [pair[0].radius, pair[0].merit];
        volume += step * r * r * merit.powi(4);
        slenderness += step / r;
    }
    volume * (slenderness / SLENDER).min(1.0).powi(2)
}

/// The best sections of neighbourhoods of a point, of every size.
fn rings_at(cloud: &Searched, at: DVec3, seed: u64) -> impl Iterator<Item = Ring> + use<> {
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
        let ball = cloud.tree.within(at, reach);
        if ball.len() >= 24 {
            found.extend(ring_of(cloud, at, &ball, reach, seed));
        }
        reach *= GROWTH;
    }
    found.into_iter()
}

fn spread(vectors: impl Iterator<Item = DVec3>) -> DMat3 {
    vectors.fold(DMat3::ZERO, |sum, v| {
        sum + DMat3::from_cols(v * v.x, v * v.y, v * v.z)
    })
}

/// 1 for points on a line, nearly 0 for points strewn evenly over the circle's tolerance.
fn tightness(c: &Circle) -> f64 {
    (1.0 - c.rms / (0.087 * c.radius)).max(0.02)
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
    let own = Neighbours::new(&points);
    let by_normals = eigen(spread(normals(&points, &own, 10).into_iter()))[0].1;
    let by_length = eigen(spread(points.iter().map(|p| *p - mean)))[2].1;
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
        let merit = c.share * (1.6 * c.cover).min(1.0) * tightness(&c);
        if c.share > 0.5
            && c.cover > 0.2
            && c.inside < HOLLOW.0
            && c.rms < LOOSE.0 * c.radius
            && best.is_none_or(|b| merit > b.merit)
        {
            best = Some(Ring {
                centre: at + x * c.centre.x + y * c.centre.y,
                along,
                radius: c.radius,
                merit,
            });
        }
    }
    best
}

/// A section near where one is expected, the points of a slab across it taken.
fn section(
    cloud: &Searched,
    centre: DVec3,
    along: DVec3,
    radius: f64,
    seed: u64,
) -> Option<Circle> {
    let (x, y) = along.any_orthonormal_pair();
    let near = cloud.tree.within(centre, 2.2 * radius);
    for half in [0.25, 0.5, 1.0] {
        let flat: Vec<DVec2> = near
            .iter()
            .map(|&i| cloud.points[i as usize] - centre)
            .filter(|d| d.dot(along).abs() <= half * radius)
            .map(|d| DVec2::new(d.dot(x), d.dot(y)))
            .filter(|d| d.length() < 2.0 * radius)
            .collect();
        if flat.len() < 20 && half < 1.0 {
            continue;
        }
        let expected = Expected {
            radius: (0.6 * radius, 1.5 * radius),
            near: Some((DVec2::ZERO, 0.6 * radius, radius)),
        };
        return fit(&flat, &expected, seed).filter(|c| {
            c.cover >= 0.2
                && c.share >= 0.35
                && c.inside < HOLLOW.1
                && c.rms < LOOSE.1 * c.radius
                && flat.len() >= 8
        });
    }
    None
}

/// Rings from one end to the other through a first one.
fn followed(cloud: &Searched, start: Ring) -> (Vec<Ring>, Vec<String>) {
    let (mut back, first) = march(cloud, start, -1.0);
    let (ahead, last) = march(cloud, start, 1.0);
    back.reverse();
    let mut rings = back;
    rings.push(start);
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
        let Some(c) = found else {
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
            merit: c.share * c.cover * tightness(&c),
        };
        rings.push(Ring {
            radius: c.radius,
            ..at
        });
    }
    (rings, "it is longer than any limb".to_owned())
}
