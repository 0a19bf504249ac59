//! Cleaning a cloud, step by step, with a count for each step.

use super::{Neighbours, PointCloud};
use crate::{Cancelled, Context};
use glam::DVec3;
use rayon::prelude::*;

/// Which steps are taken, in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CleanOptions {
    /// Drop points with coordinates that are not finite; where not, they are refused.
    pub not_finite: bool,
    /// Drop points at the place of an earlier one.
    pub duplicates: bool,
    /// Drop points whose mean distance to their nearest neighbours exceeds the cloud's mean by so many standard
    /// deviations (Rusu et al. 2008); `None` leaves the step out.
    pub outliers: Option<f64>,
    /// Drop points that have fewer than two others within so many median spacings; `None` leaves the step out.
    pub isolated: Option<f64>,
    /// Keep one point for each cube of this side, m; `None` leaves the step out.
    pub spacing: Option<f64>,
}

impl Default for CleanOptions {
    fn default() -> Self {
        CleanOptions {
            not_finite: true,
            duplicates: true,
            outliers: Some(3.0),
            isolated: Some(8.0),
            spacing: None,
        }
    }
}

/// One step of the cleaning.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CleanStep {
    /// What was looked for.
    pub name: &'static str,
    /// Points removed.
    pub removed: usize,
    /// Points left.
    pub left: usize,
    /// Why they were removed, with the figures that decided.
    pub why: String,
}

/// What the cleaning did.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct CleanReport {
    /// Points that came in.
    pub read: usize,
    /// The steps that were taken.
    pub steps: Vec<CleanStep>,
    /// Median distance from a point to the nearest other, m, of what is left.
    pub spacing_m: f64,
}

/// Why a cloud cannot be cleaned.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CleanError {
    /// A point that is no number, where those are not to be dropped.
    #[error(
        "point {point} has the coordinate {value}; expected finite numbers, or let such points be dropped"
    )]
    NotFinite {
        /// Number of the point, from 0.
        point: usize,
        /// The coordinate.
        value: f64,
    },
    /// Too little is left.
    #[error("{left} of {read} points are left after cleaning; expected at least {least}")]
    TooFew {
        /// Points that came in.
        read: usize,
        /// Points left.
        left: usize,
        /// Points needed.
        least: usize,
    },
    /// An option out of its range.
    #[error("{option} is {value}; expected a finite number above 0")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// More points than their numbers have bits for.
    #[error("{0} points; expected fewer than 4294967295")]
    TooMany(usize),
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Neighbours whose distances tell outliers.
const NEIGHBOURS: usize = 8;
/// Fewest points that can be called a cloud.
const LEAST: usize = 50;

/// Cleans a cloud.
///
/// # Errors
/// [`CleanError`] where too little is left or an option is out of its range.
pub fn clean(
    cloud: &PointCloud,
    options: &CleanOptions,
    context: &Context,
) -> Result<(PointCloud, CleanReport), CleanError> {
    for (option, value) in [
        ("outliers", options.outliers),
        ("isolated", options.isolated),
        ("spacing", options.spacing),
    ] {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(CleanError::Option { option, value });
        }
    }
    let read = cloud.points.len();
    if read >= u32::MAX as usize {
        return Err(CleanError::TooMany(read));
    }
    let mut report = CleanReport {
        read,
        ..CleanReport::default()
    };
    context.step("clean", 0.0)?;
    let finite: Vec<u32> = (0..read as u32)
        .filter(|&i| cloud.points[i as usize].is_finite())
        .collect();
    if !options.not_finite && finite.len() < read {
        let bad = cloud.points.iter().position(|p| !p.is_finite());
        let point = bad.unwrap_or_default();
        let values = cloud.points[point].to_array();
        let value = values.into_iter().find(|v| !v.is_finite());
        return Err(CleanError::NotFinite {
            point,
            value: value.unwrap_or(f64::NAN),
        });
    }
    let mut at = cloud.clone();
    if options.not_finite {
        at = keep(at, finite, "not finite", &mut report, || {
            "a coordinate is NaN or infinite".to_owned()
        });
    }
    if options.duplicates {
        let kept = distinct(&at.points);
        at = keep(at, kept, "duplicates", &mut report, || {
            "another point is at the same place".to_owned()
        });
    }
    context.step("clean", 0.2)?;
    if let Some(deviations) = options.outliers {
        let (kept, limit) = inliers(&at.points, deviations);
        at = keep(at, kept, "outliers", &mut report, || {
            format!(
                "the mean distance to {NEIGHBOURS} neighbours exceeds {limit:.6} m, the mean and {deviations} standard \
                 deviations"
            )
        });
    }
    context.step("clean", 0.6)?;
    if let Some(times) = options.isolated {
        let (kept, radius) = connected(&at.points, times);
        at = keep(at, kept, "isolated", &mut report, || {
            format!("fewer than two other points within {radius:.6} m, {times} median spacings")
        });
    }
    if let Some(side) = options.spacing {
        let kept = thinned(&at.points, side);
        at = keep(at, kept, "thinning", &mut report, || {
            format!("one point is kept for each cube of {side} m")
        });
    }
    context.step("clean", 0.8)?;
    let left = at.points.len();
    if left < LEAST {
        return Err(CleanError::TooFew {
            read,
            left,
            least: LEAST,
        });
    }
    report.spacing_m = spacing(&at.points);
    context.step("clean", 1.0)?;
    Ok((at, report))
}

fn keep(
    cloud: PointCloud,
    kept: Vec<u32>,
    name: &'static str,
    report: &mut CleanReport,
    why: impl Fn() -> String,
) -> PointCloud {
    let removed = cloud.points.len() - kept.len();
    report.steps.push(CleanStep {
        name,
        removed,
        left: kept.len(),
        why: why(),
    });
    if removed == 0 {
        cloud
    } else {
        cloud.select(&kept)
    }
}

/// The first point at each place.
fn distinct(points: &[DVec3]) -> Vec<u32> {
    let mut order: Vec<(DVec3, u32)> = points.iter().map(|p| *p + DVec3::ZERO).zip(0..).collect();
    let compare = |a: &(DVec3, u32), b: &(DVec3, u32)| {
        a.0.x
            .total_cmp(&b.0.x)
            .then(a.0.y.total_cmp(&b.0.y))
            .then(a.0.z.total_cmp(&b.0.z))
            .then(a.1.cmp(&b.1))
    };
    order.par_sort_unstable_by(compare);
    order.dedup_by(|b, a| a.0 == b.0);
    let mut kept: Vec<u32> = order.into_iter().map(|o| o.1).collect();
    kept.sort_unstable();
    kept
}

/// Points whose mean distance to their neighbours is not far above the mean of all, and the limit.
fn inliers(points: &[DVec3], deviations: f64) -> (Vec<u32>, f64) {
    let tree = Neighbours::new(points);
    let mean_distance = |p: &DVec3| {
        let near = tree.nearest(*p, NEIGHBOURS + 1);
        let sum: f64 = near.iter().skip(1).map(|n| n.0.sqrt()).sum();
        sum / (near.len().max(2) - 1) as f64
    };
    let distances: Vec<f64> = points.par_iter().map(mean_distance).collect();
    let count = distances.len().max(1) as f64;
    let mean = distances.iter().sum::<f64>() / count;
    let variance = distances
        .iter()
        .map(|d| (d - mean) * (d - mean))
        .sum::<f64>()
        / count;
    let limit = mean + deviations * variance.sqrt();
    let kept = (0..distances.len() as u32)
        .filter(|&i| distances[i as usize] <= limit)
        .collect();
    (kept, limit)
}

/// Points that have two others within so many median spacings, and that radius.
fn connected(points: &[DVec3], times: f64) -> (Vec<u32>, f64) {
    let tree = Neighbours::new(points);
    let second: Vec<(f64, f64)> = points
        .par_iter()
        .map(|p| {
            let near = tree.nearest(*p, 3);
            let at = |k: usize| near.get(k).map_or(f64::INFINITY, |n| n.0.sqrt());
            (at(1), at(2))
        })
        .collect();
    let mut nearest: Vec<f64> = second.iter().map(|s| s.0).collect();
    nearest.sort_unstable_by(f64::total_cmp);
    let radius = times * nearest.get(nearest.len() / 2).copied().unwrap_or(0.0);
    let kept = (0..second.len() as u32)
        .filter(|&i| second[i as usize].1 <= radius)
        .collect();
    (kept, radius)
}

/// Of the points in each cube of a lattice the one nearest to their mean.
fn thinned(points: &[DVec3], side: f64) -> Vec<u32> {
    let low = points.iter().fold(DVec3::INFINITY, |a, p| a.min(*p));
    let cell = |p: &DVec3| ((*p - low) / side).to_array().map(|v| v as i64);
    let mut order: Vec<([i64; 3], u32)> = points
        .par_iter()
        .map(cell)
        .zip_eq((0..points.len()).into_par_iter().map(|i| i as u32))
        .collect();
    order.par_sort_unstable();
    let mut kept: Vec<u32> = order
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|cube| {
            let sum: DVec3 = cube.iter().map(|c| points[c.1 as usize]).sum();
            let mean = sum / cube.len() as f64;
            let distance = |c: &&([i64; 3], u32)| points[c.1 as usize].distance_squared(mean);
            let nearest = cube
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.map(|c| c.1)
        })
        .collect();
    kept.sort_unstable();
    kept
}

/// Median distance from a point to the nearest other, m; of a hundred thousand points evenly taken where there are more.
pub fn spacing(points: &[DVec3]) -> f64 {
    const SAMPLE: usize = 100_000;
    if points.len() < 2 {
        return 0.0;
    }
    let tree = Neighbours::new(points);
    let stride = points.len().div_ceil(SAMPLE);
    let nearest = |i: usize| tree.nearest(points[i * stride], 2)[1].0.sqrt();
    let mut distances: Vec<f64> = (0..points.len().div_ceil(stride))
        .into_par_iter()
        .map(nearest)
        .collect();
    distances.sort_unstable_by(f64::total_cmp);
    distances[distances.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice of spacing 1 cm with what does not belong to it.
    fn cloud() -> PointCloud {
        let mut points: Vec<DVec3> = (0..2500)
            .map(|i| DVec3::new((i % 50) as f64, (i / 50) as f64, 0.0) * 0.01)
            .collect();
        points.push(points[7]);
        points.push(DVec3::new(f64::NAN, 0.0, 0.0));
        points.push(DVec3::new(0.2, 0.2, 5.0));
        PointCloud {
            colours: vec![[1, 2, 3]; points.len()],
            points,
            normals: Vec::new(),
        }
    }

    #[test]
    fn each_step_removes_what_it_is_for_and_has_its_switch() {
        let cloud = cloud();
        let (kept, report) = clean(&cloud, &CleanOptions::default(), &Context::quiet()).unwrap();
        let removed: Vec<usize> = report.steps.iter().map(|s| s.removed).collect();
        assert_eq!(removed, [1, 1, 1, 0], "{report:?}");
        assert_eq!((kept.points.len(), kept.colours.len()), (2500, 2500));
        assert!((report.spacing_m - 0.01).abs() < 1e-12);
        let only = |change: fn(&mut CleanOptions)| {
            let mut options = CleanOptions {
                not_finite: true,
                duplicates: false,
                outliers: None,
                isolated: None,
                spacing: None,
            };
            change(&mut options);
            clean(&cloud, &options, &Context::quiet()).map(|c| c.0.points.len())
        };
        assert_eq!(only(|_| ()), Ok(2502));
        assert_eq!(only(|o| o.isolated = Some(8.0)), Ok(2501));
        // The cubes of 2.5 cm about lattice points 0 to 49 of each side: 20 of them, and the far point.
        assert_eq!(only(|o| o.spacing = Some(0.025)), Ok(401));
        assert!(matches!(
            only(|o| o.not_finite = false),
            Err(CleanError::NotFinite { point: 2501, .. })
        ));
        let wrong = only(|o| o.spacing = Some(f64::NAN));
        assert!(matches!(
            wrong,
            Err(CleanError::Option {
                option: "spacing",
                ..
            })
        ));
    }

    #[test]
    fn too_few_points_are_refused_by_their_number() {
        let few = cloud().select(&[0, 1, 2]);
        let error = clean(&few, &CleanOptions::default(), &Context::quiet()).unwrap_err();
        assert!(error.to_string().contains("of 3 points"), "{error}");
    }
}
