//! From a cleaned point cloud and a place to the bark of the stem there, as a mesh (model §1 of Forests 2023, from the
//! raw cloud on).
//!
//! The stem is found and followed by circles (`trace`); its points get an address (angle, length, radius), and where a
//! ray from the pith meets the bark once, the bark is a surface over (angle, length) at the scan's own resolution, which
//! closes holes and completes a girth that was seen in part. Elsewhere it is made by screened Poisson reconstruction.

mod circle;
mod field;
mod folded;
mod points;
mod report;
mod section;
mod surface;
mod timber;
mod trace;

pub use report::{Cover, ScanError, ScanOptions, ScanReport, ScannedBark};

use crate::stem::centreline::{Station, smooth};
use crate::stem::{Axis, Place};
use glam::DVec3;
use greenstick_geometry::cloud::KdTree;
use greenstick_geometry::{Context, PointCloud};
use points::Addressed;
use section::Section;
use trace::{Ring, Searched};

/// Points that the search for the stem looks at.
const SEARCHED: usize = 150_000;
/// Share of the sections' parts that a ray may meet more than once: bark flakes and stubs are no folds.
pub const MOST_FOLDED: f64 = 0.25;

/// Spread about the surface, in radii, from which on points are those of a crown and not of bark.
const CROWN: f64 = 0.1;

/// The stem as it was followed: its curve from the base and its radius along it.
#[derive(Debug, Clone)]
pub(crate) struct Followed {
    pub axis: Axis,
    /// Length (m), radius (m) of the rings, in order.
    pub radii: Vec<(f64, f64)>,
    /// The form of its sections.
    pub section: Section,
}

impl Followed {
    /// Mean radius, m.
    pub fn mean_radius(&self) -> f64 {
        self.radii.iter().map(|r| r.1).sum::<f64>() / self.radii.len() as f64
    }

    /// Radius at `s`, m.
    pub fn radius(&self, s: f64) -> f64 {
        let k = self
            .radii
            .partition_point(|r| r.0 <= s)
            .clamp(1, self.radii.len() - 1);
        let (a, b) = (self.radii[k - 1], self.radii[k]);
        let t = ((s - a.0) / (b.0 - a.0)).clamp(0.0, 1.0);
        a.1 + (b.1 - a.1) * t
    }
}

/// Parts of the whole work after which the stem has been followed, and every point has its address.
const FOLLOWED: f64 = 0.7;
const ADDRESSED: f64 = 0.8;

/// The bark of the stem or limb at `place`. Lengths and fractions are counted from the thicker end (the lower one where
/// both are alike) of the largest stem in the cloud.
///
/// # Errors
/// [`ScanError`] where there is no stem, too little of it was seen, or its sections are folded.
pub fn scanned_bark(
    cloud: &PointCloud,
    place: &Place,
    options: &ScanOptions,
    context: &Context,
) -> Result<ScannedBark, ScanError> {
    if !(0.0..=1.0).contains(&options.least_cover) {
        return Err(ScanError::LeastCover(options.least_cover));
    }
    let none = || ScanError::NoStem {
        points: cloud.points.len(),
    };
    context.report(0.0)?;
    let (followed, notes) = match timber::timber(cloud) {
        Some((followed, size)) => {
            let [thick, wide] = [size.x, size.y].map(|x| 1e3 * x);
            let note = format!(
                "four flat sides: taken for squared timber of {wide:.0} × {thick:.0} mm, straight and with corners"
            );
            (followed, vec![note])
        }
        None => round(cloud, place, &context.part(0.0, FOLLOWED))?.ok_or_else(none)?,
    };
    let at = asked(&followed, place)?;
    context.report(FOLLOWED)?;
    let mut addressed = Addressed::new(cloud, &followed, options.bark_only);
    addressed.drop_strangers(&followed);
    context.report(ADDRESSED)?;
    // Bark is most of what there is about a stem; of a crown any tube is the smaller part.
    let tube = followed.section == Section::Round;
    if tube && addressed.strangers > addressed.points.len() {
        return Err(none());
    }
    let mut bark = match surface::bark(&addressed, &followed, at, options) {
        Err(ScanError::NotStarShaped {
            from, to, share, ..
        }) if tube => {
            let mut bark =
                folded::bark(cloud, &followed, at, options, &context.part(ADDRESSED, 1.0))?;
            bark.report.folded = addressed.folded(0.0, followed.axis.length());
            bark.report.notes.push(folded::note(from, to, share));
            bark
        }
        made => made?,
    };
    if tube && bark.report.noise_m > CROWN * bark.report.radius_m {
        return Err(none());
    }
    context.report(1.0)?;
    bark.report.notes.extend(notes);
    Ok(bark)
}

/// The largest round stem or limb at a place, and why it ends where it does.
fn round(
    cloud: &PointCloud,
    place: &Place,
    context: &Context,
) -> Result<Option<(Followed, Vec<String>)>, ScanError> {
    let stride = cloud.points.len().div_ceil(SEARCHED).max(1);
    let searched: Vec<DVec3> = cloud.points.iter().step_by(stride).copied().collect();
    let tree = KdTree::new(&searched);
    let found = trace::limb(
        &Searched {
            points: &searched,
            tree: &tree,
            spacing: greenstick_geometry::cloud::spacing(&searched, context)?,
        },
        place,
        context,
    )?;
    // A tube that is wider than long has its axis somewhere else.
    let followed = found
        .and_then(|(rings, ends)| from_base(rings, ends))
        .filter(|(followed, _)| followed.axis.length() > 2.0 * followed.mean_radius());
    Ok(followed.map(|(followed, ends)| {
        let notes = ["base", "end"]
            .iter()
            .zip(ends)
            .map(|(which, why)| format!("the stem was followed to its {which}, where {why}"));
        (followed, notes.collect())
    }))
}

/// The smooth curve through rings, from the base on.
fn from_base(mut rings: Vec<Ring>, mut ends: Vec<String>) -> Option<(Followed, Vec<String>)> {
    let quarter = (rings.len() / 4).max(1);
    let mean = |part: &[Ring]| part.iter().map(|r| r.radius).sum::<f64>() / part.len() as f64;
    let (first, last) = (
        mean(&rings[..quarter]),
        mean(&rings[rings.len() - quarter..]),
    );
    let alike = (first - last).abs() < 0.05 * first.max(last);
    let lower = rings[rings.len() - 1].centre.z < rings[0].centre.z;
    if if alike { lower } else { last > first } {
        rings.reverse();
        ends.reverse();
    }
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
    let last = stations[stations.len() - 1].t;
    let (curve, lengths) = smooth(&stations, 0.0, last, (0.0, last));
    let axis = Axis::new(&curve, None)?;
    // The smooth curve is a little shorter than the polygon of centres.
    let at = |t: f64| {
        let k = lengths.partition_point(|l| *l < t).min(lengths.len() - 1);
        axis.lengths()[k.min(axis.lengths().len() - 1)]
    };
    let mut radii: Vec<(f64, f64)> = stations.iter().map(|s| (at(s.t), s.radius)).collect();
    radii.dedup_by(|b, a| b.0 <= a.0);
    let section = Section::Round;
    (radii.len() >= 2).then_some((
        Followed {
            axis,
            radii,
            section,
        },
        ends,
    ))
}

/// Length of the place along the stem, m.
fn asked(followed: &Followed, place: &Place) -> Result<f64, ScanError> {
    let length = followed.axis.length();
    let off = || ScanError::OffStem {
        asked: *place,
        length,
    };
    match *place {
        Place::Fraction(x) if (0.0..=1.0).contains(&x) => Ok(x * length),
        Place::Length(x) if (0.0..=length).contains(&x) => Ok(x),
        Place::Point(p) => {
            let at = followed.axis.length_at(p).clamp(0.0, length);
            let radius = followed.radius(at);
            let distance = followed.axis.frame(at).origin.distance(p);
            let widest = radius
                + match followed.section {
                    Section::Round => 0.0,
                    Section::Squared { core, .. } => core,
                };
            if distance > 2.0 * widest {
                return Err(ScanError::FarFromWood {
                    asked: *place,
                    distance,
                    radius,
                });
            }
            Ok(at)
        }
        _ => Err(off()),
    }
}

#[cfg(test)]
mod tests;
