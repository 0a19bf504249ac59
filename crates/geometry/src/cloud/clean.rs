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

impl CleanOptions {
    /// Standard deviations beyond which a point is an outlier by default.
    pub const OUTLIER_DEVIATIONS: f64 = 3.0;
    /// Median spacings within which a point has others by default.
    pub const ISOLATED_SPACINGS: f64 = 8.0;
}

impl Default for CleanOptions {
    fn default() -> Self {
        CleanOptions {
            not_finite: true,
            duplicates: true,
            outliers: Some(Self::OUTLIER_DEVIATIONS),
            isolated: Some(Self::ISOLATED_SPACINGS),
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
    context.report(0.0)?;
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
    context.report(0.1)?;
    let mut near = measured(&at.points, context)?;
    if let Some(deviations) = options.outliers {
        let (kept, limit) = inliers(&near.means, deviations);
        near.leave(&kept);
        at = keep(at, kept, "outliers", &mut report, || {
            format!(
                "the mean distance to {NEIGHBOURS} neighbours exceeds {limit:.6} m, the mean and {deviations} standard \
                 deviations"
            )
        });
    }
    context.report(0.7)?;
    if let Some(times) = options.isolated {
        let (kept, radius) = near.connected(times);
        near.leave(&kept);
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
    context.report(0.8)?;
    let left = at.points.len();
    if left < LEAST {
        return Err(CleanError::TooFew {
            read,
            left,
            least: LEAST,
        });
    }
    report.spacing_m = match options.spacing {
        Some(_) => spacing(&at.points),
        None => near.spacing(),
    };
    context.report(1.0)?;
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

/// Points with their nearest neighbours, looked for once for all steps.
struct Near {
    points: Vec<DVec3>,
    tree: Neighbours,
    /// Mean distance to the neighbours that tell outliers, m.
    means: Vec<f64>,
    /// The two nearest others, as the square of the distance and the number.
    nearest: Vec<[(f64, u32); 2]>,
    /// Numbers of the points that are left, ascending, and whether each is.
    left: Vec<u32>,
    is_left: Vec<bool>,
}

/// Points of which the neighbours are looked for at once, so that the caller can stop between them.
const AT_ONCE: usize = 1 << 16;

fn measured(points: &[DVec3], context: &Context) -> Result<Near, Cancelled> {
    let tree = Neighbours::new(points);
    let of = |p: &DVec3| {
        let near = tree.nearest(*p, NEIGHBOURS + 1);
        let sum: f64 = near.iter().skip(1).map(|n| n.0.sqrt()).sum();
        let other = |k: usize| near.get(k).copied().unwrap_or((f64::INFINITY, u32::MAX));
        let mean = sum / (near.len().max(2) - 1) as f64;
        (mean, [other(1), other(2)])
    };
    let (mut means, mut nearest) = (Vec::new(), Vec::new());
    for part in points.chunks(AT_ONCE) {
        context.report(0.2 + 0.5 * means.len() as f64 / points.len() as f64)?;
        let some: Vec<(f64, [(f64, u32); 2])> = part.par_iter().map(of).collect();
        means.extend(some.iter().map(|s| s.0));
        nearest.extend(some.iter().map(|s| s.1));
    }
    Ok(Near {
        points: points.to_vec(),
        tree,
        means,
        nearest,
        left: (0..points.len() as u32).collect(),
        is_left: vec![true; points.len()],
    })
}

impl Near {
    /// Leaves only these, by their places among those that are left.
    fn leave(&mut self, kept: &[u32]) {
        self.left = kept.iter().map(|&k| self.left[k as usize]).collect();
        self.is_left.fill(false);
        self.left
            .iter()
            .for_each(|&i| self.is_left[i as usize] = true);
    }

    /// Distances from a point to the two nearest others that are left, m.
    fn others(&self, i: u32) -> (f64, f64) {
        let known = self.nearest[i as usize];
        if known
            .iter()
            .all(|n| self.is_left.get(n.1 as usize) == Some(&true))
        {
            return (known[0].0.sqrt(), known[1].0.sqrt());
        }
        let mut count = 4 * NEIGHBOURS;
        loop {
            let near = self.tree.nearest(self.points[i as usize], count);
            let mut others = near
                .iter()
                .filter(|n| n.1 != i && self.is_left[n.1 as usize]);
            let first = others.next().map(|n| n.0.sqrt());
            let second = others.next().map(|n| n.0.sqrt());
            if second.is_some() || near.len() < count {
                let far = f64::INFINITY;
                return (first.unwrap_or(far), second.unwrap_or(far));
            }
            count *= 4;
        }
    }

    /// Points that have two others within so many median spacings, by their places among those left, and that radius.
    fn connected(&self, times: f64) -> (Vec<u32>, f64) {
        let second: Vec<(f64, f64)> = self.left.par_iter().map(|&i| self.others(i)).collect();
        let radius = times * median(second.iter().map(|s| s.0).collect());
        let kept = (0..second.len() as u32)
            .filter(|&k| second[k as usize].1 <= radius)
            .collect();
        (kept, radius)
    }

    /// Median distance from a point to the nearest other, m.
    fn spacing(&self) -> f64 {
        median(self.left.par_iter().map(|&i| self.others(i).0).collect())
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Points whose mean distance to their neighbours is not far above the mean of all, and the limit.
fn inliers(distances: &[f64], deviations: f64) -> (Vec<u32>, f64) {
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
