//! Diameter, girth and ovality of the stem at the requested place and along it, with their standard errors.

use super::circle::{Expected, Prior, fit, sector_of};
use super::points::{StemPoint, StemPoints};
use super::report::PlaceMeasures;
use super::shape::SectionShape;
use super::traced::TracedStem;
use crate::{noise, polygon};
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Sectors of the outline.
const SECTORS: usize = 24;
/// Waves around the girth that the outline has: finer ones are bark and noise, which would lengthen it.
const WAVES: usize = 6;
/// Points of the outline.
const OUTLINE_POINTS: usize = 240;
/// Half the length of stem that is measured, in radii.
const HALF_LENGTH_RADII: f64 = 1.0;
/// Fewest and most places along the stem; they are a diameter apart.
const PLACES_ALONG: (f64, f64) = (4.0, 64.0);

/// Measures the stem at places between two lengths (m). Those with too few points are left out.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn measure_along(
    points: &StemPoints,
    stem: &TracedStem,
    span: [f64; 2],
    context: &Context,
) -> Result<Vec<PlaceMeasures>, Cancelled> {
    let length = span[1] - span[0];
    let (fewest, most) = PLACES_ALONG;
    let count = (length / (2.0 * stem.mean_radius()))
        .round()
        .clamp(fewest, most) as usize;
    let places: Vec<Option<PlaceMeasures>> = (0..count)
        .into_par_iter()
        .map(|k| {
            context.check()?;
            let at = span[0] + length * (k as f64 + 0.5) / count as f64;
            Ok(measure(points, stem, at))
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(places.into_iter().flatten().collect())
}

/// Measures the stem at length `at` (m). `None` where too few points are there.
pub(super) fn measure(points: &StemPoints, stem: &TracedStem, at: f64) -> Option<PlaceMeasures> {
    let radius = stem.radius(at);
    let centre_m = stem.axis.frame(at).origin.to_array();
    if let SectionShape::Squared { half, core } = stem.shape {
        let diameter = 2.0 * stem.shape.equal_radius(half);
        let girth = stem.shape.girth(half);
        // Each pair of sides is as far apart as it was measured.
        let error = 2.0 * stem.radius_error;
        let relative = (error / (2.0 * half)).hypot(error / (2.0 * (half + core)));
        // The greatest calliper diameter of a rectangle is its diagonal.
        let thinness = half / half.hypot(half + core);
        return Some(PlaceMeasures {
            at_m: at,
            centre_m,
            diameter_m: diameter,
            diameter_error_m: 0.5 * diameter * relative,
            girth_m: girth,
            girth_error_m: 2.0 * error * 2f64.sqrt(),
            tape_girth_m: girth,
            ovality: 1.0 - thinness,
            ovality_error: thinness * relative,
        });
    }
    let mut near: Vec<&StemPoint> = points
        .points
        .iter()
        .filter(|p| (p.s - at).abs() <= HALF_LENGTH_RADII * radius)
        .collect();
    near.sort_by_cached_key(|p| noise::hash(17, i64::from(p.number), 0, 0));
    let section: Vec<DVec2> = near
        .iter()
        .map(|p| stem.shape.point(p.turn, p.radius))
        .collect();
    let whole = SectionSize::new(&section, radius)?;
    // What halves of the points give: every other one, and every other two.
    let halves: Vec<SectionSize> = (0..4)
        .filter_map(|k| {
            let is_in = |i: usize| (i >> (k / 2)) % 2 == k % 2;
            let numbered = section.iter().enumerate().filter(|(i, _)| is_in(*i));
            let half: Vec<DVec2> = numbered.map(|(_, p)| *p).collect();
            SectionSize::new(&half, radius)
        })
        .collect();
    let error = |of: fn(&SectionSize) -> f64, fitted: f64| {
        let squares = halves.iter().map(|h| (of(h) - of(&whole)).powi(2));
        let spread = squares.sum::<f64>() / halves.len().max(1) as f64;
        spread.sqrt().hypot(fitted)
    };
    Some(PlaceMeasures {
        at_m: at,
        centre_m,
        diameter_m: whole.diameter,
        diameter_error_m: error(|s| s.diameter, 2.0 * whole.radius_error),
        girth_m: whole.girth,
        girth_error_m: error(|s| s.girth, TAU * whole.radius_error),
        tape_girth_m: whole.tape_girth,
        ovality: whole.ovality,
        ovality_error: error(|s| s.ovality, 0.0),
    })
}

/// What a round section measures, lengths in m.
struct SectionSize {
    diameter: f64,
    girth: f64,
    tape_girth: f64,
    /// A share.
    ovality: f64,
    /// Standard error of the circle's radius.
    radius_error: f64,
}

impl SectionSize {
    /// The size of a section of about this radius (m) with its middle near the origin.
    fn new(section: &[DVec2], radius: f64) -> Option<Self> {
        let expected = Expected {
            min_radius: 0.5 * radius,
            max_radius: 2.0 * radius,
            prior: Some(Prior {
                centre: DVec2::ZERO,
                radius,
                max_offset: 0.5 * radius,
            }),
        };
        let circle = fit(section, &expected, 0)?;
        let outline = outline(section, circle.centre, circle.radius);
        let (area, _) = polygon::area_and_centroid(&outline);
        Some(SectionSize {
            diameter: 2.0 * (area.abs() / PI).sqrt(),
            girth: polygon::perimeter(&outline),
            tape_girth: polygon::perimeter(&polygon::convex_hull(&outline)),
            ovality: polygon::ovality(&outline),
            radius_error: circle.radius_error,
        })
    }
}

/// The outline of a section about the circle through it: mean radii of sectors, the circle's where none was seen, as the
/// sum of their first waves.
fn outline(section: &[DVec2], centre: DVec2, radius: f64) -> Vec<DVec2> {
    let mut sums = [(0.0, 0.0); SECTORS];
    for d in section.iter().map(|p| *p - centre) {
        let sum = &mut sums[sector_of(d, SECTORS)];
        *sum = (sum.0 + d.length() - radius, sum.1 + 1.0);
    }
    let offs = sums.map(|(sum, count)| if count > 0.0 { sum / count } else { 0.0 });
    let angle_of = |k: usize| TAU * ((k as f64 + 0.5) / SECTORS as f64 - 0.5);
    let wave = |n: usize| {
        offs.iter().enumerate().fold(DVec2::ZERO, |sum, (k, off)| {
            let (sin, cos) = libm::sincos(n as f64 * angle_of(k));
            sum + DVec2::new(cos, sin) * (off * 2.0 / SECTORS as f64)
        })
    };
    let mean = offs.iter().sum::<f64>() / SECTORS as f64;
    let waves: Vec<DVec2> = (1..=WAVES).map(wave).collect();
    (0..OUTLINE_POINTS)
        .map(|j| {
            let angle = TAU * j as f64 / OUTLINE_POINTS as f64;
            let terms = waves.iter().zip(1..).map(|(wave, n)| {
                let (sin, cos) = libm::sincos(f64::from(n) * angle);
                wave.dot(DVec2::new(cos, sin))
            });
            let r = radius + mean + terms.sum::<f64>();
            let (sin, cos) = libm::sincos(angle);
            centre + DVec2::new(cos, sin) * r
        })
        .collect()
}
