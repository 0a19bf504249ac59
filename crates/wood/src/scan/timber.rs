//! Squared timber in a cloud: one straight piece with four flat sides in two directions, recognised by its normals.
//!
//! Normals of such a piece run along two directions square to the grain, and along the grain only where it is cut off.
//! Sides are fitted to the points whose normals are theirs; where the four hold the bulk of the points, it is timber.

use super::shape::SectionShape;
use super::traced::{RadiusAt, TracedStem};
use crate::stem::Axis;
use glam::{DMat3, DVec2, DVec3};
use greenstick_geometry::cloud::{KdTree, normals};
use greenstick_geometry::{PointCloud, symmetric_eigen};

/// Most points that are used.
const MAX_POINTS: usize = 20_000;
/// Neighbours that a normal is estimated from: more than usual, as sides are flat and scanners noisy.
const NORMAL_NEIGHBOURS: usize = 24;
/// Cosine of the angle within which a normal is a side's: 15 degrees.
const PARALLEL_COSINE: f64 = 0.966;
/// Sine of the angle within which a normal is square to the grain: 15 degrees.
const SQUARE_SINE: f64 = 0.259;
/// Least share of the normals across the grain that are a side's. On round wood a third are.
const MIN_SIDE_NORMALS: f64 = 0.7;
/// Least share of the points, but for those whose normals run along the grain, that lie on the sides.
const MIN_POINTS_ON_SIDES: f64 = 0.7;
/// Distance from a side, in halves of the thickness, up to which a point lies on it.
const ON_SIDE_TOLERANCE: f64 = 0.1;
/// Distance from the outermost points of a side, in distances of opposite sides, up to which others may be part of it.
const SIDE_DEPTH: f64 = 0.15;
/// Least length over width.
const MIN_LENGTH_OVER_WIDTH: f64 = 1.2;

/// A side: its outward normal, and what is on it.
struct Side {
    normal: DVec3,
    /// Distance of the plane from the origin along the normal.
    offset: f64,
    count: usize,
    /// Root mean square of its points' distances from the plane.
    rms: f64,
    /// Least and greatest coordinate along the grain.
    reach: (f64, f64),
}

/// A piece of squared timber.
pub(super) struct Timber {
    pub stem: TracedStem,
    /// m.
    pub thickness: f64,
    /// m.
    pub width: f64,
}

/// Points with their normals, about their mean.
struct Samples {
    mean: DVec3,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
}

/// The piece of squared timber that a cloud shows, where it shows one.
pub(super) fn find_timber(cloud: &PointCloud) -> Option<Timber> {
    let samples = Samples::new(cloud)?;
    // The grain runs along one of the directions in which normals vary: the one along which the piece is longest.
    let mut grains = symmetric_eigen(spread(samples.normals.iter())).map(|e| e.1);
    let length = |along: DVec3| {
        let coordinates: Vec<f64> = samples.points.iter().map(|p| p.dot(along)).collect();
        let (low, high) = quantiles(coordinates, 0.02);
        high - low
    };
    grains.sort_by(|a, b| length(*b).total_cmp(&length(*a)));
    let mut frame = frame_about_grain(grains[0], &samples.normals)?;
    let mut sides = Vec::new();
    // Twice, as sides show the directions better than normals do.
    for _ in 0..2 {
        sides = four_sides(&samples, frame)?;
        frame = frame_of_sides(&sides, frame)?;
    }
    between_sides(&samples, frame, &sides)
}

impl Samples {
    /// Some of the points of a cloud; `None` where there are too few.
    fn new(cloud: &PointCloud) -> Option<Self> {
        const MIN_POINTS: usize = 100;
        let stride = cloud.points.len().div_ceil(MAX_POINTS).max(1);
        let points: Vec<DVec3> = cloud.points.iter().step_by(stride).copied().collect();
        if points.len() < MIN_POINTS {
            return None;
        }
        let normals = if cloud.normals.is_empty() {
            normals(&points, &KdTree::new(&points), NORMAL_NEIGHBOURS)
        } else {
            cloud.normals.iter().step_by(stride).copied().collect()
        };
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        Some(Samples {
            mean,
            points: points.iter().map(|p| *p - mean).collect(),
            normals,
        })
    }
}

/// Sum of the outer products of vectors with themselves.
fn spread<'a>(vectors: impl Iterator<Item = &'a DVec3>) -> DMat3 {
    vectors.fold(DMat3::ZERO, |sum, v| {
        sum + DMat3::from_cols(*v * v.x, *v * v.y, *v * v.z)
    })
}

/// The values below and above which a share of all lie.
fn quantiles(mut values: Vec<f64>, share: f64) -> (f64, f64) {
    values.sort_unstable_by(f64::total_cmp);
    let k = (share * values.len() as f64) as usize;
    match (values.get(k), values.get(values.len().wrapping_sub(k + 1))) {
        (Some(low), Some(high)) => (*low, *high),
        _ => (0.0, 0.0),
    }
}

/// The frame (first side, second side, grain) about a grain from the normals across it: the angle that four times theirs
/// have in common. `None` where too few normals are a side's.
fn frame_about_grain(grain: DVec3, normals: &[DVec3]) -> Option<DMat3> {
    let (x, y) = grain.any_orthonormal_pair();
    let (mut sum, mut across) = (DVec2::ZERO, 0usize);
    for n in normals.iter().filter(|n| n.dot(grain).abs() < SQUARE_SINE) {
        let angle = 4.0 * libm::atan2(n.dot(y), n.dot(x));
        sum += DVec2::new(libm::cos(angle), libm::sin(angle));
        across += 1;
    }
    if across == 0 || sum.length() <= 0.0 {
        return None;
    }
    let angle = 0.25 * libm::atan2(sum.y, sum.x);
    let first = x * libm::cos(angle) + y * libm::sin(angle);
    let square = normals
        .iter()
        .filter(|n| n.dot(grain).abs() < SQUARE_SINE)
        .filter(|n| n.dot(first).abs().max(n.dot(grain.cross(first)).abs()) > PARALLEL_COSINE)
        .count();
    (square as f64 > MIN_SIDE_NORMALS * across as f64)
        .then(|| DMat3::from_cols(first, grain.cross(first), grain))
}

/// The planes of the four sides, those of the first direction before those of the second.
fn four_sides(samples: &Samples, frame: DMat3) -> Option<Vec<Side>> {
    let pairs = [frame.x_axis, frame.y_axis].map(|across| {
        let own: Vec<DVec3> = samples
            .points
            .iter()
            .zip(&samples.normals)
            .filter(|(_, n)| n.dot(across).abs() > PARALLEL_COSINE)
            .map(|(p, _)| *p)
            .collect();
        let reach = quantiles(own.iter().map(|p| p.dot(across)).collect(), 0.02);
        (across, own, reach)
    });
    let thickness = pairs
        .iter()
        .map(|(_, _, (low, high))| high - low)
        .fold(f64::INFINITY, f64::min);
    let mut sides = Vec::new();
    for (across, own, (low, high)) in pairs {
        for (sign, at) in [(1.0, high), (-1.0, low)] {
            let depth = SIDE_DEPTH * (high - low);
            let on: Vec<DVec3> = own
                .iter()
                .copied()
                .filter(|p| (p.dot(across) - at).abs() < depth)
                .collect();
            let outward = across * sign;
            // Steps and notches may make a side of several planes: then that of most points is taken.
            let found = fit_side(&on, &on, outward, frame.z_axis).or_else(|| {
                let most = densest_layer(&on, across, SIDE_DEPTH * thickness);
                fit_side(&on, &most, outward, frame.z_axis)
            });
            sides.push(found?);
        }
    }
    Some(sides)
}

/// The points of the layer across a direction, `width` thick, that holds most of them.
fn densest_layer(points: &[DVec3], across: DVec3, width: f64) -> Vec<DVec3> {
    let mut sorted: Vec<(f64, DVec3)> = points.iter().map(|p| (p.dot(across), *p)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let layer = |i: usize| {
        let end = sorted.partition_point(|p| p.0 <= sorted[i].0 + width);
        i..end
    };
    let best = (0..sorted.len()).map(layer).max_by_key(|l| l.len());
    sorted[best.unwrap_or(0..0)].iter().map(|p| p.1).collect()
}

/// The plane through points that face one way: by least squares of the first ones, then of all that are near the plane
/// so far.
fn fit_side(points: &[DVec3], first: &[DVec3], outward: DVec3, grain: DVec3) -> Option<Side> {
    let mut on = first.to_vec();
    let mut fitted = (outward, 0.0);
    for _ in 0..3 {
        if on.len() < 12 {
            return None;
        }
        let mean = on.iter().sum::<DVec3>() / on.len() as f64;
        let around: Vec<DVec3> = on.iter().map(|p| *p - mean).collect();
        let normal = symmetric_eigen(spread(around.iter()))[0].1;
        let normal = normal * normal.dot(outward).signum();
        if normal.dot(outward) < PARALLEL_COSINE {
            return None;
        }
        fitted = (normal, normal.dot(mean));
        let off: Vec<f64> = on
            .iter()
            .map(|p| (p.dot(normal) - fitted.1).abs())
            .collect();
        // Three standard deviations of the half of the points that lie nearest.
        let limit = 4.5 * quantiles(off, 0.5).0.max(1e-9 * mean.length());
        on = points
            .iter()
            .copied()
            .filter(|p| (p.dot(normal) - fitted.1).abs() <= limit)
            .collect();
    }
    let coordinates: Vec<f64> = on.iter().map(|p| p.dot(grain)).collect();
    let squares = on
        .iter()
        .map(|p| (p.dot(fitted.0) - fitted.1).powi(2))
        .sum::<f64>();
    Some(Side {
        rms: (squares / on.len() as f64).sqrt(),
        normal: fitted.0,
        offset: fitted.1,
        count: on.len(),
        reach: quantiles(coordinates, 0.005),
    })
}

/// The frame that the sides agree on: the grain square to all of them, the first direction that of their mean.
fn frame_of_sides(sides: &[Side], frame: DMat3) -> Option<DMat3> {
    let mut matrix = DMat3::ZERO;
    for side in sides {
        matrix += spread([side.normal].iter()) * side.count as f64;
    }
    let grain = symmetric_eigen(matrix)[0].1;
    let grain = grain * grain.dot(frame.z_axis).signum();
    let mut first = DVec3::ZERO;
    for (side, sign) in sides.iter().zip([1.0, -1.0, 1.0, -1.0]) {
        let normal = side.normal.reject_from_normalized(grain) * (sign * side.count as f64);
        // The second pair, turned back by a right angle.
        first += if normal.dot(frame.x_axis).abs() > normal.dot(frame.y_axis).abs() {
            normal
        } else {
            normal.cross(grain)
        };
    }
    let first = first.reject_from_normalized(grain).try_normalize()?;
    Some(DMat3::from_cols(first, grain.cross(first), grain))
}

/// Standard error of half the distance between two sides: their planes' offsets are as sure as the means of so many patches
/// of points that err together.
fn half_error(sides: &[Side]) -> f64 {
    const PATCHES: f64 = 24.0;
    let variance = |s: &Side| s.rms * s.rms / PATCHES.min(s.count as f64);
    let sum: f64 = sides.iter().map(variance).sum();
    // Two of the four, halved.
    0.5 * (0.5 * sum).sqrt()
}

/// The timber between four sides, where they hold the points.
fn between_sides(samples: &Samples, frame: DMat3, sides: &[Side]) -> Option<Timber> {
    // Each side cuts the line through the middle of the others where it is on average.
    let end = |coordinate: fn(&Side) -> f64| {
        let mut ends: Vec<f64> = sides.iter().map(coordinate).collect();
        ends.sort_by(f64::total_cmp);
        0.5 * (ends[1] + ends[2])
    };
    let (from, to) = (end(|s| s.reach.0), end(|s| s.reach.1));
    // The mean of the middle two of four has nearly the error of the mean of all.
    let end_error = |coordinate: fn(&Side) -> f64, mean: f64| {
        let squares = sides.iter().map(|s| (coordinate(s) - mean).powi(2));
        squares.sum::<f64>() / (3.0 * 4.0)
    };
    let length_error = (end_error(|s| s.reach.0, from) + end_error(|s| s.reach.1, to)).sqrt();
    let middle = 0.5 * (from + to);
    let at = |k: usize, across: DVec3| {
        let side = &sides[k];
        // Along `across` through the axis in the middle of the length.
        (side.offset - side.normal.dot(frame.z_axis) * middle) / side.normal.dot(across)
    };
    let (x, y) = (
        (at(0, frame.x_axis), at(1, frame.x_axis)),
        (at(2, frame.y_axis), at(3, frame.y_axis)),
    );
    let rectangle = CentredRectangle {
        centre: DVec2::new(0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)),
        halves: DVec2::new(0.5 * (x.0 - x.1), 0.5 * (y.0 - y.1)),
    };
    let halves = rectangle.halves;
    let (half, wide) = (halves.min_element(), halves.max_element());
    if half <= 0.0 || to - from < MIN_LENGTH_OVER_WIDTH * 2.0 * wide {
        return None;
    }
    if !rectangle.holds_most_points(samples, frame, (from, to)) {
        return None;
    }
    let across = if halves.x >= halves.y {
        frame.x_axis
    } else {
        frame.y_axis
    };
    let centre = rectangle.centre;
    let base = samples.mean + frame.x_axis * centre.x + frame.y_axis * centre.y;
    let curve: Vec<DVec3> = (0..=8)
        .map(|k| base + frame.z_axis * (from + (to - from) * f64::from(k) / 8.0))
        .collect();
    let axis = Axis::new(&curve, Some(across))?;
    let radii = [0.0, axis.length()].map(|length| RadiusAt {
        length,
        radius: half,
    });
    Some(Timber {
        stem: TracedStem {
            radii: radii.to_vec(),
            shape: SectionShape::Squared {
                half,
                core: wide - half,
            },
            axis,
            length_error,
            radius_error: half_error(sides),
        },
        thickness: 2.0 * half,
        width: 2.0 * wide,
    })
}

/// A rectangle along the axes.
struct CentredRectangle {
    centre: DVec2,
    /// Half its sides.
    halves: DVec2,
}

impl CentredRectangle {
    /// Whether most points between two coordinates along the grain lie on the rectangle, but for those whose normals run
    /// along the grain.
    fn holds_most_points(&self, samples: &Samples, frame: DMat3, (from, to): (f64, f64)) -> bool {
        let (mut on, mut all) = (0usize, 0usize);
        for (p, n) in samples.points.iter().zip(&samples.normals) {
            let along = p.dot(frame.z_axis);
            if !(from..=to).contains(&along) || n.dot(frame.z_axis).abs() > PARALLEL_COSINE {
                continue;
            }
            let q = DVec2::new(p.dot(frame.x_axis), p.dot(frame.y_axis)) - self.centre;
            let beyond = q.abs() - self.halves;
            let distance = beyond.max(DVec2::ZERO).length() + beyond.max_element().min(0.0);
            all += 1;
            on += usize::from(distance.abs() < ON_SIDE_TOLERANCE * self.halves.min_element());
        }
        (on as f64) >= MIN_POINTS_ON_SIDES * all as f64
    }
}
