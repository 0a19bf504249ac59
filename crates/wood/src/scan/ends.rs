//! How far a limb is certain: as far as halves of its points agree.
//!
//! A limb is followed again through random halves of its points, and taken as far as most of them show it (stability
//! selection, Meinshausen and Bühlmann 2010). The spread of the halves is the standard error (balanced half-samples,
//! McCarthy 1969; Wolter 2007, Introduction to Variance Estimation, chapter 3).

use super::trace::{Limb, Ring, Searched};
use crate::noise;
use glam::DVec3;
use greenstick_geometry::cloud::KdTree;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;

/// Random halves of the points, each with its complement.
const HALVES: u64 = 8;
/// Points about a limb that its halves are taken from, in radii.
const HALVED_REACH_RADII: f64 = 4.0;

/// Standard errors of what was followed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LimbErrors {
    /// Of the length, m.
    pub length: f64,
    /// Of the mean radius, m.
    pub radius: f64,
}

/// A limb's extent on both sides of the ring at which it was begun, and its mean radius, m.
#[derive(Debug, Clone, Copy)]
struct Extent {
    reach: [f64; 2],
    radius: f64,
}

impl Extent {
    fn new(limb: &Limb) -> Self {
        let length = |rings: &[Ring]| -> f64 {
            let pairs = rings.windows(2);
            pairs.map(|p| p[0].centre.distance(p[1].centre)).sum()
        };
        let sum: f64 = limb.rings.iter().map(|r| r.radius).sum();
        Extent {
            reach: [
                length(&limb.rings[..=limb.start]),
                length(&limb.rings[limb.start..]),
            ],
            radius: sum / limb.rings.len() as f64,
        }
    }
}

/// Cuts a limb off where most halves of its points show it no more. Returns its standard errors.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn confirm(
    cloud: &Searched,
    limb: &mut Limb,
    context: &Context,
) -> Result<LimbErrors, Cancelled> {
    let start = limb.rings[limb.start];
    let near = near(cloud, limb, context)?;
    let halves: Vec<Extent> = (0..HALVES)
        .into_par_iter()
        .map(|k| {
            let first = |i: u32| noise::unit(31 + k / 2, i64::from(i), 0, 0) < 0.5;
            let points: Vec<DVec3> = near
                .iter()
                .filter(|&&i| first(i) == k.is_multiple_of(2))
                .map(|&i| cloud.points[i as usize])
                .collect();
            let half = Searched {
                points: &points,
                tree: &KdTree::try_new(&points, context)?,
                spacing: cloud.spacing,
            };
            Ok(Extent::new(&half.follow(start, context)?))
        })
        .collect::<Result<_, Cancelled>>()?;
    for side in 0..2 {
        let mut reach: Vec<f64> = halves.iter().map(|h| h.reach[side]).collect();
        reach.sort_by(f64::total_cmp);
        let middle = reach.len() / 2;
        limb.cut(side, 0.5 * (reach[middle - 1] + reach[middle]));
    }
    let whole = Extent::new(limb);
    let error = |of: fn(&Extent) -> f64| {
        let squares = halves.iter().map(|h| (of(h) - of(&whole)).powi(2));
        (squares.sum::<f64>() / halves.len() as f64).sqrt()
    };
    let length = error(|e| e.reach[0] + e.reach[1]);
    let ends = [0, 1].map(|side| extend(cloud, limb, side));
    Ok(LimbErrors {
        length: length.hypot(ends[0]).hypot(ends[1]),
        radius: error(|e| e.radius),
    })
}

/// Gap between points along a limb, in their mean spacing, that ends it: between scattered points one in three thousand is
/// as wide.
const END_GAP_SPACINGS: f64 = 8.0;
/// The same in radii: of very many points some leave a wider gap by chance.
const END_GAP_RADII: f64 = 0.1;
/// Distance from the bark, in radii, of the points that show how far it goes.
const END_TOLERANCE_RADII: f64 = 0.15;

/// Moves the last ring of a side to where the bark's points end, two radii farther at most. Returns the error of that
/// place: the points' spacing along the limb, m.
fn extend(cloud: &Searched, limb: &mut Limb, side: usize) -> f64 {
    let (end, sign) = if side == 0 {
        (0, -1.0)
    } else {
        (limb.rings.len() - 1, 1.0)
    };
    let ring = limb.rings[end];
    let (along, radius) = (ring.along * sign, ring.radius);
    let mut lengths: Vec<f64> = cloud
        .tree
        .within_unordered(ring.centre, 2.4 * radius)
        .into_iter()
        .map(|i| cloud.points[i as usize] - ring.centre)
        .filter(|d| {
            let off = d.reject_from_normalized(along).length() - radius;
            off.abs() < END_TOLERANCE_RADII * radius
        })
        .map(|d| d.dot(along))
        .filter(|s| (-radius..2.0 * radius).contains(s))
        .collect();
    lengths.sort_by(f64::total_cmp);
    let ahead = lengths.partition_point(|s| *s <= 0.0);
    let spacing = radius / ahead.max(1) as f64;
    let gap = (END_GAP_SPACINGS * spacing).max(END_GAP_RADII * radius);
    let reach = lengths[ahead..]
        .iter()
        .fold(0.0, |reach, s| if s - reach < gap { *s } else { reach });
    limb.rings[end].centre += along * reach;
    spacing.min(radius)
}

/// Numbers of the points about a limb and beyond its ends.
fn near(cloud: &Searched, limb: &Limb, context: &Context) -> Result<Vec<u32>, Cancelled> {
    let mut is_near = vec![false; cloud.points.len()];
    let last = limb.rings.len() - 1;
    for (k, ring) in limb.rings.iter().enumerate() {
        context.check()?;
        // The halves of the points may be followed beyond the ends.
        let factor = if k == 0 || k == last { 6.0 } else { 1.0 };
        let reach = factor * HALVED_REACH_RADII * ring.radius;
        for i in cloud.tree.within_unordered(ring.centre, reach) {
            is_near[i as usize] = true;
        }
    }
    let numbers = is_near.iter().zip(0..);
    Ok(numbers.filter(|n| *n.0).map(|n| n.1).collect())
}
