//! From a trace to the body of a stem: a smooth axis, the sections across it, and what each stretch of it is good for.

use super::Axis;
use super::body::{Body, BodyStation, Stretch};
use super::centreline::{ParameterRange, SmoothCurve, Station, smooth};
use super::model::{CrossSection, StemKind};
use super::plank::Plank;
use super::section::{ShellSection, section};
use super::surface::Surface;
use super::trace::{StationState, Trace, TraceEnd};
use crate::polygon;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context};
use std::f64::consts::PI;

/// Below this length in radii the centroids do not show a direction: the axis is straight, as in a stump.
const MIN_CURVED_LENGTH_RADII: f64 = 2.5;
/// A body shorter than this, in radii of its thinner end, is a sheet: planes inset from both ends would pass each other.
const MIN_LENGTH_RADII: f64 = 4.0 * END_INSET_RADII;
/// At the very ends a plane would graze the end face, or cut it off where it is not quite square. It lies this far inside.
const END_INSET_RADII: f64 = 0.06;
/// Area of a plain section relative to that expected from the trace.
const MIN_AREA_RATIO: f64 = 0.5;
const MAX_AREA_RATIO: f64 = 1.8;
/// A board's section of less than this part of the usual area is a rounded end.
const MIN_BOARD_AREA_RATIO: f64 = 0.5;

/// A section across the axis, with the number of other closed loops close by.
pub(crate) struct FoundSection {
    pub section: CrossSection,
    nearby_loops: usize,
}

/// The section in the axis frame at `s` (m), its outline at most `limit` (m) from the axis.
pub(crate) fn section_at(
    surface: &Surface,
    axis: &Axis,
    s: f64,
    limit: f64,
) -> Option<FoundSection> {
    let frame = axis.frame(s);
    let cut = section(surface, frame.origin, frame.tangent, limit)?;
    let mut contour: Vec<DVec2> = cut
        .points
        .iter()
        .map(|&p| {
            DVec2::new(
                (p - frame.origin).dot(frame.x),
                (p - frame.origin).dot(frame.y),
            )
        })
        .collect();
    let (area, centroid) = polygon::area_and_centroid(&contour);
    if area < 0.0 {
        contour.reverse();
    }
    let perimeter = polygon::perimeter(&contour);
    Some(FoundSection {
        section: CrossSection {
            length: s,
            contour,
            centroid,
            area: area.abs(),
            perimeter,
        },
        nearby_loops: cut.nearby_loops,
    })
}

/// The good sections of a trace, in order, by the length t (m) along the polygon of their centroids.
struct GoodSections<'a> {
    trace: &'a Trace,
    /// Indices into the trace.
    good: Vec<usize>,
    stations: Vec<Station>,
    /// From the one tip of the trace to the other.
    whole: ParameterRange,
    /// Between neighbouring good stations with a fork between them.
    gaps: Vec<ParameterRange>,
}

impl<'a> GoodSections<'a> {
    /// `None` where the trace has no good section or no length.
    fn new(trace: &'a Trace) -> Option<Self> {
        let is_good = |i: &usize| trace.states[*i] == StationState::Good;
        let good: Vec<usize> = (0..trace.sections.len()).filter(is_good).collect();
        let first = &trace.sections[*good.first()?];
        let last = &trace.sections[*good.last()?];
        let mut stations: Vec<Station> = Vec::with_capacity(good.len());
        let mut t = 0.0;
        for (k, &i) in good.iter().enumerate() {
            let cut = &trace.sections[i];
            if k > 0 {
                let before = trace.sections[good[k - 1]].centre;
                t += cut.centre.distance(before).max(1e-6 * cut.radius);
            }
            stations.push(Station {
                t,
                centre: cut.centre,
                radius: cut.radius,
                reach: cut.reach,
            });
        }
        let before_first = (first.centre - trace.tips[0]).dot(first.normal).max(0.0);
        let beyond_last = (trace.tips[1] - last.centre).dot(last.normal).max(0.0);
        let whole = ParameterRange {
            low: -before_first,
            high: t + beyond_last,
        };
        let thinnest = first.radius.min(last.radius);
        if whole.high - whole.low < MIN_LENGTH_RADII * thinnest {
            return None;
        }
        let gaps = good
            .windows(2)
            .zip(stations.windows(2))
            .filter(|(g, _)| g[1] > g[0] + 1)
            .map(|(_, s)| ParameterRange {
                low: s[0].t,
                high: s[1].t,
            })
            .collect();
        Some(GoodSections {
            trace,
            good,
            stations,
            whole,
            gaps,
        })
    }

    fn section(&self, k: usize) -> &ShellSection {
        &self.trace.sections[self.good[k]]
    }

    /// t of the last good station.
    fn end(&self) -> f64 {
        self.stations[self.stations.len() - 1].t
    }

    /// The range between forks that contains the trace's station `near`.
    fn unforked_range(&self, near: usize) -> ParameterRange {
        let k = self.good.partition_point(|&g| g < near);
        let at = self.stations[k.min(self.good.len() - 1)].t;
        let before = self.gaps.iter().map(|g| g.high).filter(|&g| g <= at);
        let after = self.gaps.iter().map(|g| g.low).filter(|&g| g >= at);
        ParameterRange {
            low: before.fold(self.whole.low, f64::max),
            high: after.fold(self.whole.high, f64::min),
        }
    }

    /// The axis. It must not bend too tightly in the range between forks that contains the station `near`.
    fn axis(
        &self,
        surface: &Surface,
        near: usize,
        context: &Context,
    ) -> Result<Option<ParametricAxis>, Cancelled> {
        let middle = self.section(self.good.len() / 2);
        if self.stations.len() < 3 || self.end() < MIN_CURVED_LENGTH_RADII * middle.radius {
            return Ok(self.straight_axis(middle.normal));
        }
        self.curved_axis(surface, self.unforked_range(near), context)
    }

    /// A straight axis through the middle of the centroids along `normal`.
    fn straight_axis(&self, normal: DVec3) -> Option<ParametricAxis> {
        let stations = &self.stations;
        let mean = stations.iter().map(|s| s.centre).sum::<DVec3>() / stations.len() as f64;
        let middle = stations.iter().map(|s| s.t).sum::<f64>() / stations.len() as f64;
        let radius = stations[stations.len() / 2].radius;
        let ParameterRange { low, high } = self.whole;
        let count = ((high - low) / (0.25 * radius)).ceil().clamp(8.0, 4000.0) as usize;
        let parameters: Vec<f64> = (0..=count)
            .map(|i| low + (high - low) * i as f64 / count as f64)
            .collect();
        let points = parameters
            .iter()
            .map(|t| mean + normal * (t - middle))
            .collect();
        ParametricAxis::new(SmoothCurve { points, parameters })
    }

    /// A smooth axis: through the centroids as traced, then once more through those of sections square to it.
    fn curved_axis(
        &self,
        surface: &Surface,
        limited: ParameterRange,
        context: &Context,
    ) -> Result<Option<ParametricAxis>, Cancelled> {
        let mut stations = self.stations.clone();
        let Some(first) = ParametricAxis::new(smooth(&stations, self.whole, limited)) else {
            return Ok(None);
        };
        for station in &mut stations {
            context.check()?;
            let in_gap = |g: &ParameterRange| station.t >= g.low && station.t <= g.high;
            if self.gaps.iter().any(in_gap) {
                continue;
            }
            let s = first.length_at(station.t);
            let Some(found) = section_at(surface, &first.axis, s, 0.5 * station.radius) else {
                continue;
            };
            let (area, found) = (PI * station.radius * station.radius, found.section);
            if found.area > 0.7 * area && found.area < 1.3 * area {
                let frame = first.axis.frame(s);
                station.centre =
                    frame.origin + frame.x * found.centroid.x + frame.y * found.centroid.y;
            }
        }
        Ok(ParametricAxis::new(smooth(&stations, self.whole, limited)))
    }

    /// The range of t that good sections cover, up to the very end where nothing but the end follows the last one.
    fn free_range(&self) -> ParameterRange {
        let reaches_end = |side: usize, station: usize| {
            let outermost = if side == 0 {
                0
            } else {
                self.trace.states.len() - 1
            };
            station == outermost && self.trace.ends[side] == TraceEnd::Real
        };
        ParameterRange {
            low: if reaches_end(0, self.good[0]) {
                self.whole.low
            } else {
                0.0
            },
            high: if reaches_end(1, self.good[self.good.len() - 1]) {
                self.whole.high
            } else {
                self.end()
            },
        }
    }

    /// Whether a fork, rather than the stem's own end, follows the last good section on a side.
    fn ends_in_fork(&self, side: usize) -> bool {
        let beyond = if side == 0 {
            &self.trace.states[..self.good[0]]
        } else {
            &self.trace.states[self.good[self.good.len() - 1]..]
        };
        self.trace.ends[side] == TraceEnd::Fork || beyond.contains(&StationState::Fork)
    }
}

/// An axis and the t (m) of each of its points.
struct ParametricAxis {
    axis: Axis,
    parameters: Vec<f64>,
}

impl ParametricAxis {
    /// `None` where points coincide.
    fn new(curve: SmoothCurve) -> Option<Self> {
        let axis = Axis::new(&curve.points, None)?;
        (axis.points().len() == curve.parameters.len()).then_some(ParametricAxis {
            axis,
            parameters: curve.parameters,
        })
    }

    /// Length (m) along the axis at t.
    fn length_at(&self, t: f64) -> f64 {
        let (parameters, lengths) = (&self.parameters, self.axis.lengths());
        let k = parameters
            .partition_point(|&p| p <= t)
            .clamp(1, parameters.len() - 1);
        let u = (t - parameters[k - 1]) / (parameters[k] - parameters[k - 1]);
        lengths[k - 1] + (lengths[k] - lengths[k - 1]) * u
    }
}

/// Makes axis and sections of a trace. `near` is the station about which the axis must not bend too tightly.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn body(
    surface: &Surface,
    trace: &Trace,
    near: usize,
    context: &Context,
) -> Result<Option<Body>, Cancelled> {
    let Some(course) = GoodSections::new(trace) else {
        return Ok(None);
    };
    let Some(ParametricAxis { axis, parameters }) = course.axis(surface, near, context)? else {
        return Ok(None);
    };
    let free = course.free_range();
    let forks = [course.ends_in_fork(0), course.ends_in_fork(1)];
    let stretch_beyond = |side: usize| {
        if forks[side] {
            Stretch::Fork
        } else {
            Stretch::End
        }
    };
    let first_radius = course.section(0).radius;
    let last_radius = course.section(course.good.len() - 1).radius;
    // A curved axis may be a little shorter than the polygon of centroids.
    let inset = (END_INSET_RADII * first_radius.min(last_radius)).min(0.25 * axis.length());
    let mut stations = Vec::with_capacity(parameters.len());
    for (i, &t) in parameters.iter().enumerate() {
        context.check()?;
        let blocked = if course.gaps.iter().any(|g| t > g.low && t < g.high) {
            Some(Stretch::Fork)
        } else if t < free.low - 1e-12 {
            Some(stretch_beyond(0))
        } else if t > free.high + 1e-12 {
            Some(stretch_beyond(1))
        } else {
            None
        };
        stations.push(match blocked {
            Some(stretch) => BodyStation {
                stretch,
                section: None,
            },
            None => {
                let s = axis.lengths()[i].clamp(inset, axis.length() - inset);
                let outermost = i == 0 || i + 1 == parameters.len();
                free_station(surface, &axis, s, &course.stations, t, outermost)
            }
        });
    }
    Ok(Some(Body {
        axis,
        stations,
        kind: StemKind::Round,
        ends: trace.ends,
        width: 0.0,
    }))
}

/// The station at length `s` and parameter `t` where nothing blocks the axis.
fn free_station(
    surface: &Surface,
    axis: &Axis,
    s: f64,
    traced: &[Station],
    t: f64,
    outermost: bool,
) -> BodyStation {
    let nearest = traced.partition_point(|q| q.t < t).min(traced.len() - 1);
    let radius = traced[nearest].radius;
    let expected = PI * radius * radius;
    let section = section_at(surface, axis, s, 0.5 * radius)
        .map(|found| found.section)
        .filter(|c| c.area > MIN_AREA_RATIO * expected && c.area < MAX_AREA_RATIO * expected);
    let stretch = if section.is_some() {
        Stretch::Free
    } else if outermost {
        Stretch::End
    } else {
        Stretch::Broken
    };
    BodyStation { stretch, section }
}

/// Axis and sections of a board: straight along its box, whatever notches and holes there are.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn board_body(
    surface: &Surface,
    plank: &Plank,
    context: &Context,
) -> Result<Option<Body>, Cancelled> {
    let [length, width, thickness] = plank.size;
    // A quarter of the radius of a circle of the same area.
    let spacing = 0.25 * (width * thickness / PI).sqrt();
    let count = (length / spacing).ceil().clamp(16.0, 1000.0) as usize;
    let points: Vec<DVec3> = (0..=count)
        .map(|i| plank.end + plank.direction * (length * i as f64 / count as f64))
        .collect();
    let axis = Axis::new(&points, Some(plank.wide));
    let Some(axis) = axis.filter(|axis| axis.points().len() == points.len()) else {
        return Ok(None);
    };
    let mut found: Vec<Option<FoundSection>> = Vec::with_capacity(count + 1);
    for i in 0..=count {
        context.check()?;
        let s = axis.lengths()[i].clamp(0.1 * spacing, length - 0.1 * spacing);
        found.push(section_at(surface, &axis, s, width));
    }
    let mut areas: Vec<f64> = found.iter().flatten().map(|c| c.section.area).collect();
    areas.sort_by(f64::total_cmp);
    let Some(&usual) = areas.get(areas.len() / 2) else {
        return Ok(None);
    };
    let station = |(i, found): (usize, Option<FoundSection>)| {
        let (stretch, section) = match found {
            Some(FoundSection {
                section,
                nearby_loops: 0,
            }) if section.area > MIN_BOARD_AREA_RATIO * usual => (Stretch::Free, Some(section)),
            Some(found) if found.nearby_loops > 0 => (Stretch::Broken, None),
            _ if i < count / 8 || i > count - count / 8 => (Stretch::End, None),
            _ => (Stretch::Broken, None),
        };
        BodyStation { stretch, section }
    };
    Ok(Some(Body {
        axis,
        stations: found.into_iter().enumerate().map(station).collect(),
        kind: StemKind::Board,
        ends: [TraceEnd::Real; 2],
        width,
    }))
}
