//! Cleaning a cloud step by step, with a count for each step.

use super::distances::{NEIGHBOURS, NeighbourDistances, spacing};
use super::local::LocalFrame;
use super::{CleanError, CleanOptions, CleanReport, CleanStep, PointCloud};
use crate::components::number_keys;
use crate::{Cancelled, Context};
use glam::DVec3;

/// Fewest points that make a cloud.
const MIN_POINTS: usize = 50;
/// Points after which a loop asks whether to stop: about a millisecond.
const CHECK_INTERVAL: usize = 1 << 14;

/// Cleans a cloud. Returns the points that remain and what was removed.
///
/// ```
/// use glam::DVec3;
/// use greenstick_geometry::cloud::{CleanOptions, clean};
/// use greenstick_geometry::{Context, PointCloud};
///
/// let mut points: Vec<DVec3> = (0..2500)
///     .map(|i| DVec3::new(f64::from(i % 50), f64::from(i / 50), 0.0))
///     .collect();
/// points.push(DVec3::new(20.0, 20.0, 500.0));
/// let cloud = PointCloud { points, ..PointCloud::default() };
/// let (cleaned, report) = clean(&cloud, &CleanOptions::default(), &Context::quiet())?;
/// assert_eq!((cleaned.points.len(), report.read, report.spacing_m), (2500, 2501, 1.0));
/// # Ok::<(), greenstick_geometry::cloud::CleanError>(())
/// ```
///
/// # Errors
/// [`CleanError`] where too few points are left, an option is out of its range, or the caller asked to stop.
pub fn clean(
    cloud: &PointCloud,
    options: &CleanOptions,
    context: &Context,
) -> Result<(PointCloud, CleanReport), CleanError> {
    let read = cloud.points.len();
    check_options(options)?;
    if read >= u32::MAX as usize {
        return Err(CleanError::TooMany(read));
    }
    let mut cleaning = Cleaning {
        cloud: cloud.clone(),
        report: CleanReport {
            read,
            ..CleanReport::default()
        },
    };
    context.report(0.0)?;
    cleaning.remove_not_finite(options.not_finite)?;
    if options.duplicates {
        let kept = distinct(&cleaning.cloud.points, context)?;
        let why = "another point is at the same place".to_owned();
        cleaning.keep(kept, "duplicates", why);
    }
    context.report(0.1)?;
    let local = LocalFrame::new(&cleaning.cloud.points).cloud(&cleaning.cloud);
    let mut distances = NeighbourDistances::new(&local.points, &context.part(0.2, 0.7))?;
    if let Some(deviations) = options.outliers {
        let (kept, limit) = inliers(&distances.means, deviations);
        distances.retain(&kept);
        let why = format!(
            "the mean distance to {NEIGHBOURS} neighbours exceeds {limit:.6} m, the mean and {deviations} standard \
             deviations"
        );
        cleaning.keep(kept, "outliers", why);
    }
    if let Some(spacings) = options.isolated {
        let (kept, radius) = distances.connected(spacings, &context.part(0.7, 0.75))?;
        distances.retain(&kept);
        let why =
            format!("fewer than two other points within {radius:.6} m, {spacings} median spacings");
        cleaning.keep(kept, "isolated", why);
    }
    if let Some(side) = options.spacing {
        let local = LocalFrame::new(&cleaning.cloud.points).cloud(&cleaning.cloud);
        let kept = thinned(&local.points, side, context)?;
        let why = format!("one point is kept for each cube of {side} m");
        cleaning.keep(kept, "thinning", why);
    }
    let Cleaning { cloud, mut report } = cleaning;
    let left = cloud.points.len();
    if left < MIN_POINTS {
        return Err(CleanError::TooFew {
            read,
            left,
            least: MIN_POINTS,
        });
    }
    let rest = context.part(0.8, 1.0);
    report.spacing_m = match options.spacing {
        Some(_) => spacing(&cloud.points, &rest)?,
        None => distances.spacing(&rest)?,
    };
    context.report(1.0)?;
    Ok((cloud, report))
}

fn check_options(options: &CleanOptions) -> Result<(), CleanError> {
    for (option, value) in [
        ("outliers", options.outliers),
        ("isolated", options.isolated),
        ("spacing", options.spacing),
    ] {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(CleanError::Option { option, value });
        }
    }
    Ok(())
}

/// A cloud while it is cleaned.
struct Cleaning {
    cloud: PointCloud,
    report: CleanReport,
}

impl Cleaning {
    /// Keeps only these points, and reports the step.
    fn keep(&mut self, kept: Vec<u32>, name: &'static str, why: String) {
        let removed = self.cloud.points.len() - kept.len();
        self.report.steps.push(CleanStep {
            name: name.into(),
            removed,
            left: kept.len(),
            why,
        });
        if removed > 0 {
            self.cloud = self.cloud.select(&kept);
        }
    }

    /// Removes points with coordinates that are not finite; without `allowed` there may be none.
    fn remove_not_finite(&mut self, allowed: bool) -> Result<(), CleanError> {
        let points = &self.cloud.points;
        if allowed {
            let finite = (0..points.len() as u32)
                .filter(|&i| points[i as usize].is_finite())
                .collect();
            let why = "a coordinate is NaN or infinite".to_owned();
            self.keep(finite, "not finite", why);
        } else if let Some(point) = points.iter().position(|p| !p.is_finite()) {
            let values = points[point].to_array();
            let value = values.into_iter().find(|v| !v.is_finite());
            return Err(CleanError::NotFinite {
                point,
                value: value.unwrap_or(f64::NAN),
            });
        }
        Ok(())
    }
}

/// Numbers items by their keys, in order of first appearance, for as long as the caller does not ask to stop.
fn numbered(
    count: usize,
    key: impl Fn(usize) -> [u64; 3],
    context: &Context,
) -> Result<(Vec<u32>, usize), Cancelled> {
    number_keys(count, key, |i| {
        if i.is_multiple_of(CHECK_INTERVAL) {
            context.check()?;
        }
        Ok(())
    })
}

/// Finds the first point at each position.
fn distinct(points: &[DVec3], context: &Context) -> Result<Vec<u32>, Cancelled> {
    // Zero is added so that 0 and −0 have the same bits.
    let key = |i: usize| (points[i] + DVec3::ZERO).to_array().map(f64::to_bits);
    let (numbers, _) = numbered(points.len(), key, context)?;
    let mut next = 0;
    let first = numbers.iter().zip(0..).filter_map(|(&number, i)| {
        let is_first = number == next;
        next += u32::from(is_first);
        is_first.then_some(i)
    });
    Ok(first.collect())
}

/// Finds the points whose mean distance to their neighbours is not far above the mean of all. Also returns the limit.
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

/// Finds in each cube of a lattice the point nearest to the mean of its points.
fn thinned(points: &[DVec3], side: f64, context: &Context) -> Result<Vec<u32>, Cancelled> {
    let low = points.iter().fold(DVec3::INFINITY, |a, p| a.min(*p));
    let cube = |i: usize| {
        ((points[i] - low) / side)
            .to_array()
            .map(|v| (v as i64) as u64)
    };
    let (cubes, count) = numbered(points.len(), cube, context)?;
    let mut sums = vec![(DVec3::ZERO, 0u32); count];
    for (&cube, &p) in cubes.iter().zip(points) {
        let sum = &mut sums[cube as usize];
        *sum = (sum.0 + p, sum.1 + 1);
    }
    context.check()?;
    let mut nearest = vec![(f64::INFINITY, u32::MAX); count];
    for ((&cube, &p), i) in cubes.iter().zip(points).zip(0..) {
        let (sum, number) = sums[cube as usize];
        let distance = p.distance_squared(sum / f64::from(number));
        let best = &mut nearest[cube as usize];
        // The first of several at one distance stays.
        if distance < best.0 || best.1 == u32::MAX {
            *best = (distance, i);
        }
    }
    context.check()?;
    let mut kept: Vec<u32> = nearest.into_iter().map(|n| n.1).collect();
    kept.sort_unstable();
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice of spacing 1 cm with a duplicate, a point that is not a number and a stray one.
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
    fn each_step_removes_its_points_and_can_be_switched_off() {
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
        // The cubes of 2.5 cm around lattice points 0 to 49 of each side: 20 of them, and the stray point.
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
    fn too_few_points_are_refused_with_their_number() {
        let few = cloud().select(&[0, 1, 2]);
        let error = clean(&few, &CleanOptions::default(), &Context::quiet()).unwrap_err();
        assert!(error.to_string().contains("of 3 points"), "{error}");
    }

    #[test]
    fn cleaning_can_be_cancelled() {
        let context = Context::quiet();
        context.cancel_token().cancel();
        let error = clean(&cloud(), &CleanOptions::default(), &context).unwrap_err();
        assert_eq!(error, CleanError::Cancelled(Cancelled));
    }
}
