//! From a cleaned point cloud and a location to the bark of the stem there, as a mesh (the first step of Forests 2023,
//! from the raw cloud on).
//!
//! The stem is found and followed by circles (`trace`); its points get an address (angle, length, radius). Where a ray from
//! the pith meets the bark once, the bark is a surface over (angle, length) at the scan's own resolution, which closes holes
//! and completes a girth that was seen in part. Elsewhere it is made by screened Poisson reconstruction.

mod circle;
mod cleaned;
mod coverage;
mod ends;
mod folded;
mod girth;
mod grid;
mod merit;
mod parameters;
mod points;
mod report;
mod scanned;
mod shape;
mod surface;
mod timber;
mod trace;
mod traced;

pub use cleaned::{ScanRequest, ScanningError, clean_and_reconstruct};
pub use parameters::ScanParameters;
pub use report::{Coverage, PlaceMeasures, ScanError, ScanOptions, ScanReport, ScannedBark};
pub use scanned::{ScannedReport, outline_error, with_scan};

use crate::EXTENT_RANGE;
use crate::noise;
use crate::stem::centreline::{ParameterRange, SmoothCurve, Station, smooth};
use crate::stem::{Axis, StemLocation};
use ends::LimbErrors;
use glam::DVec3;
use greenstick_geometry::cloud::{KdTree, LocalFrame, spacing};
use greenstick_geometry::{Context, PointCloud};
use points::StemPoints;
use shape::SectionShape;
use timber::Timber;
use trace::{Limb, Ring, Searched};
use traced::{RadiusAt, TracedStem};

/// Most points that the search for the stem uses.
const MAX_SEARCHED: usize = 150_000;
/// Spread about the surface, in radii, from which on points are those of a crown and not of bark.
const CROWN_SPREAD_RADII: f64 = 0.1;
/// A point as location may be this far from the axis, in half widths of the stem.
const MAX_DISTANCE_HALF_WIDTHS: f64 = 2.0;
/// Parts of the whole work after which the stem has been traced, and every point has its address.
const TRACED: f64 = 0.7;
const ADDRESSED: f64 = 0.8;

/// Reconstructs the bark of the stem or limb at `location`. Lengths and fractions are counted from the thicker end (the
/// lower one where both are alike) of the largest stem in the cloud.
///
/// # Errors
/// [`ScanError`] where there is no stem, too little of it was seen, or its sections are folded.
pub fn reconstruct_bark(
    cloud: &PointCloud,
    location: &StemLocation,
    options: &ScanOptions,
    context: &Context,
) -> Result<ScannedBark, ScanError> {
    if !(0.0..=1.0).contains(&options.min_coverage) {
        return Err(ScanError::MinCoverage(options.min_coverage));
    }
    check_extent(&cloud.points)?;
    let frame = LocalFrame::new(&cloud.points);
    let local = match location {
        StemLocation::Point(point) => StemLocation::Point(frame.to_local(*point)),
        other => *other,
    };
    let found = local_bark(&frame.cloud(cloud), &local, options, context);
    let (mut bark, limb_ends) = found.map_err(|error| error.with_location(location))?;
    bark.shift(frame.origin);
    if let Some(ends) = limb_ends {
        let notes = ["base", "end"].iter().zip(ends).map(|(which, end)| {
            let at = end + frame.origin;
            format!("the stem was followed to its {which}, where the points thin out near {at:.3}")
        });
        bark.report.notes.extend(notes);
    }
    Ok(bark)
}

/// Refuses points of which no tree has the size: rows along a stem and cells around it follow from its lengths.
fn check_extent(points: &[DVec3]) -> Result<(), ScanError> {
    let finite = || points.iter().filter(|p| p.is_finite());
    let low = finite().fold(DVec3::INFINITY, |a, p| a.min(*p));
    let high = finite().fold(DVec3::NEG_INFINITY, |a, p| a.max(*p));
    let extent = (high - low).max_element();
    if finite().next().is_none() || (EXTENT_RANGE.0..=EXTENT_RANGE.1).contains(&extent) {
        return Ok(());
    }
    Err(ScanError::Extent {
        points: points.len(),
        extent,
    })
}

/// The bark in the coordinates of a cloud about its own corner, and where a limb that was followed ends.
fn local_bark(
    cloud: &PointCloud,
    location: &StemLocation,
    options: &ScanOptions,
    context: &Context,
) -> Result<(ScannedBark, Option<[DVec3; 2]>), ScanError> {
    let no_stem = || ScanError::NoStem {
        points: cloud.points.len(),
    };
    context.report(0.0)?;
    let (stem, note, limb_ends) = match timber::find_timber(cloud) {
        Some(timber) => {
            let note = timber_note(&timber);
            (timber.stem, Some(note), None)
        }
        None => {
            let found = round_stem(cloud, location, &context.part(0.0, TRACED))?;
            let (stem, ends) = found.ok_or_else(no_stem)?;
            (stem, None, Some(ends))
        }
    };
    let at = length_at(&stem, location)?;
    context.report(TRACED)?;
    let mut points = StemPoints::new(cloud, &stem, options.bark_only, context)?;
    points.remove_foreign_points(&stem, context)?;
    context.report(ADDRESSED)?;
    // Bark is most of what there is about a stem; of a crown any tube is the smaller part.
    let round = stem.shape == SectionShape::Round;
    if round && points.foreign > points.points.len() {
        return Err(no_stem());
    }
    let last = context.part(ADDRESSED, 1.0);
    let mut bark = match surface::bark(&points, &stem, at, options, &last) {
        Err(ScanError::NotStarShaped {
            from, to, share, ..
        }) if round => {
            let mut bark = folded::bark(cloud, &stem, at, options, &last)?;
            bark.report.folded = points.folded(0.0, stem.axis.length());
            bark.report.notes.push(folded::note(from, to, share));
            bark
        }
        unfolded => unfolded?,
    };
    if round && bark.report.noise_m > CROWN_SPREAD_RADII * bark.report.radius_m {
        return Err(no_stem());
    }
    bark.report.place = girth::measure(&points, &stem, at);
    bark.report.along = girth::measure_along(&points, &stem, bark.report.span_m, context)?;
    context.report(1.0)?;
    bark.report.notes.extend(note);
    Ok((bark, limb_ends))
}

fn timber_note(timber: &Timber) -> String {
    let [wide, thick] = [timber.width, timber.thickness].map(|x| 1e3 * x);
    format!(
        "four flat sides: taken for squared timber of {wide:.0} × {thick:.0} mm, straight and with corners"
    )
}

/// The largest round stem or limb at a location, and where its points thin out.
fn round_stem(
    cloud: &PointCloud,
    location: &StemLocation,
    context: &Context,
) -> Result<Option<(TracedStem, [DVec3; 2])>, ScanError> {
    let mut numbers: Vec<u32> = (0..cloud.points.len() as u32).collect();
    numbers.sort_by_cached_key(|&i| (noise::hash(13, i64::from(i), 0, 0), i));
    numbers.truncate(MAX_SEARCHED);
    let points: Vec<DVec3> = numbers.iter().map(|&i| cloud.points[i as usize]).collect();
    let tree = KdTree::try_new(&points, context)?;
    let searched = Searched {
        points: &points,
        tree: &tree,
        spacing: spacing(&points, context)?,
    };
    let Some(mut limb) = trace::limb(&searched, location, context)? else {
        return Ok(None);
    };
    let errors = ends::confirm(&searched, &mut limb, context)?;
    if !limb.is_certain() {
        return Ok(None);
    }
    turn_base_first(&mut limb);
    // A tube that is wider than long has its axis somewhere else.
    let stem = traced_stem(&limb.rings, errors)
        .filter(|stem| stem.axis.length() > 2.0 * stem.mean_radius());
    let ends = [0, limb.rings.len() - 1].map(|k| limb.rings[k].centre);
    Ok(stem.map(|stem| (stem, ends)))
}

/// Turns a limb so that its thicker end, or the lower one where both are alike, comes first.
fn turn_base_first(limb: &mut Limb) {
    let rings = &limb.rings;
    let quarter = (rings.len() / 4).max(1);
    let mean = |part: &[Ring]| part.iter().map(|r| r.radius).sum::<f64>() / part.len() as f64;
    let (first, last) = (
        mean(&rings[..quarter]),
        mean(&rings[rings.len() - quarter..]),
    );
    let alike = (first - last).abs() < 0.05 * first.max(last);
    let last_is_lower = rings[rings.len() - 1].centre.z < rings[0].centre.z;
    let last_is_base = if alike { last_is_lower } else { last > first };
    if last_is_base {
        limb.rings.reverse();
    }
}

/// The smooth stem through rings, from the base on.
fn traced_stem(rings: &[Ring], errors: LimbErrors) -> Option<TracedStem> {
    let mut stations: Vec<Station> = Vec::with_capacity(rings.len());
    for (k, ring) in rings.iter().enumerate() {
        let t = match stations.last() {
            Some(s) => s.t + s.centre.distance(ring.centre),
            None => 0.0,
        };
        let near = &rings[k.saturating_sub(2)..(k + 3).min(rings.len())];
        let mut radii: Vec<f64> = near.iter().map(|r| r.radius).collect();
        radii.sort_by(f64::total_cmp);
        let radius = radii[radii.len() / 2];
        if stations.last().is_none_or(|s| t > s.t) {
            stations.push(Station {
                t,
                centre: ring.centre,
                radius,
                reach: radius,
            });
        }
    }
    if stations.len() < 3 {
        return None;
    }
    let whole = ParameterRange {
        low: 0.0,
        high: stations[stations.len() - 1].t,
    };
    let SmoothCurve { points, parameters } = smooth(&stations, whole, whole);
    let axis = Axis::new(&points, None)?;
    // The smooth curve is a little shorter than the polygon of centres.
    let length = |t: f64| {
        let k = parameters
            .partition_point(|p| *p < t)
            .min(parameters.len() - 1);
        axis.lengths()[k.min(axis.lengths().len() - 1)]
    };
    let mut radii: Vec<RadiusAt> = stations
        .iter()
        .map(|s| RadiusAt {
            length: length(s.t),
            radius: s.radius,
        })
        .collect();
    radii.dedup_by(|b, a| b.length <= a.length);
    (radii.len() >= 2).then_some(TracedStem {
        axis,
        radii,
        shape: SectionShape::Round,
        length_error: errors.length,
        radius_error: errors.radius.hypot(mean_error(rings)),
    })
}

/// Standard error of the mean of the rings' radii, m. Circles err alike along a stem, as they have the same side unseen and
/// the same form: their mean errs as each of them.
fn mean_error(rings: &[Ring]) -> f64 {
    let mut errors: Vec<f64> = rings.iter().map(|r| r.radius_error).collect();
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

/// Length of the location along the stem, m.
fn length_at(stem: &TracedStem, location: &StemLocation) -> Result<f64, ScanError> {
    let length = stem.axis.length();
    match *location {
        StemLocation::Fraction(x) if (0.0..=1.0).contains(&x) => Ok(x * length),
        StemLocation::Length(x) if (0.0..=length).contains(&x) => Ok(x),
        StemLocation::Point(p) => {
            let at = stem.axis.length_at(p).clamp(0.0, length);
            let radius = stem.radius(at);
            let distance = stem.axis.frame(at).origin.distance(p);
            let half_width = radius
                + match stem.shape {
                    SectionShape::Round => 0.0,
                    SectionShape::Squared { core, .. } => core,
                };
            if distance > MAX_DISTANCE_HALF_WIDTHS * half_width {
                return Err(ScanError::FarFromWood {
                    requested: *location,
                    distance,
                    radius,
                });
            }
            Ok(at)
        }
        _ => Err(ScanError::OffStem {
            requested: *location,
            length,
        }),
    }
}

#[cfg(test)]
mod tests;
