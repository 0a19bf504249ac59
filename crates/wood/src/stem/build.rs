//! From a trace to a stem: smooth axis, sections across it, taper, and what part of it is free for a break.

use super::centreline::{Station, smooth};
use super::polygon;
use super::seed::Plank;
use super::surface::Surface;
use super::trace::{Cut, End, State, Trace, section};
use super::{Axis, GrainSpace, RingField};
use glam::{DVec2, DVec3};

/// Whether a stem is a log or was sawn from one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StemKind {
    /// A trunk, branch or pole: rings about a pith inside the section.
    Round,
    /// A board or beam: straight grain along its longest axis, rings are arcs about a pith that may lie outside.
    Board,
}

/// A section across the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Length along the axis, m.
    pub length: f64,
    /// Outline: closed, counter-clockwise, m, in the axis frame's (x, y) at `length`; not scaled with the taper.
    pub contour: Vec<DVec2>,
    /// Centroid in the same frame, m.
    pub centroid: DVec2,
    /// Area, m².
    pub area: f64,
    /// Length of the outline, m.
    pub perimeter: f64,
}

/// A stem and the place at which it is to break.
#[derive(Debug, Clone, PartialEq)]
pub struct Stem {
    /// Grain space about the axis; its scale is 1 at the place.
    pub grain: GrainSpace,
    /// Log or board.
    pub kind: StemKind,
    /// Plain sections in rising length, the one at the place among them.
    pub sections: Vec<Section>,
    /// Length along the axis at the place, m.
    pub place: f64,
    /// Range of length (m) about the place that is free for the surface of a break.
    pub usable: (f64, f64),
    /// Rings of the section at the place.
    pub rings: RingField,
    /// Radius of the circle of the same area as the section at the place, m.
    pub radius: f64,
    /// Whether `usable` ends at a real end of the stem, as opposed to a fork or another limb.
    pub ends: (bool, bool),
    /// Length of the axis, m.
    pub length: f64,
}

/// Below this length in radii the centroids do not tell a direction: the axis is straight, as in a stump.
const SHORT: f64 = 2.5;
/// Free space kept from ends, forks and other limbs, in radii.
pub(crate) const MARGIN: f64 = 0.08;

/// What a stretch of the axis is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stretch {
    Free,
    Fork,
    End,
    /// The section is open or not a single loop.
    Broken,
}

/// The axis with its sections, before the place is known.
pub(crate) struct Body {
    pub axis: Axis,
    /// At each of the axis's points: what it is good for, and its section.
    pub stations: Vec<(Stretch, Option<Section>)>,
    pub kind: StemKind,
    pub ends: [End; 2],
    /// Width of a board, m.
    pub width: f64,
}

impl Body {
    /// Radius at `s` (m) of the circle of equal area, m.
    pub fn radius(&self, s: f64) -> f64 {
        let near = self.section_near(s).map_or(0.0, |section| section.area);
        (near / std::f64::consts::PI).sqrt()
    }

    /// The section next to `s` (m).
    fn section_near(&self, s: f64) -> Option<&Section> {
        let k = self.axis.lengths().partition_point(|&l| l < s);
        let there = |i: &usize| self.stations[*i].1.is_some();
        let before = (0..k).rev().find(there);
        let behind = (k..self.stations.len()).find(there);
        [before, behind]
            .into_iter()
            .flatten()
            .filter_map(|i| self.stations[i].1.as_ref())
            .min_by(|a, b| (a.length - s).abs().total_cmp(&(b.length - s).abs()))
    }

    /// Runs of free stations as lengths (m).
    pub fn free(&self) -> Vec<(f64, f64)> {
        let lengths = self.axis.lengths();
        let mut runs = Vec::new();
        let mut start = None;
        for (i, (state, _)) in self.stations.iter().enumerate() {
            match (*state == Stretch::Free, start) {
                (true, None) => start = Some(i),
                (false, Some(a)) => {
                    runs.push((lengths[a], lengths[i - 1]));
                    start = None;
                }
                _ => {}
            }
        }
        if let Some(a) = start {
            runs.push((lengths[a], lengths[lengths.len() - 1]));
        }
        runs.retain(|r| r.1 > r.0);
        runs
    }
}

/// The section's outline in the axis frame at `s`.
pub(crate) fn section_at(surface: &Surface, axis: &Axis, s: f64, limit: f64) -> Option<Section> {
    section_and_rivals(surface, axis, s, limit).map(|(section, _)| section)
}

/// The same, with the number of other closed loops close by.
fn section_and_rivals(
    surface: &Surface,
    axis: &Axis,
    s: f64,
    limit: f64,
) -> Option<(Section, usize)> {
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
    Some((
        Section {
            length: s,
            contour,
            centroid,
            area: area.abs(),
            perimeter,
        },
        cut.rivals,
    ))
}

/// Makes axis and sections of a trace. `near` is the station about which the axis must not bend too tightly.
pub(crate) fn body(surface: &Surface, trace: &Trace, near: usize) -> Option<Body> {
    let good: Vec<usize> = (0..trace.cuts.len())
        .filter(|&i| trace.states[i] == State::Good)
        .collect();
    if good.is_empty() {
        return None;
    }
    let cuts: Vec<&Cut> = good.iter().map(|&i| &trace.cuts[i]).collect();
    let mut stations = Vec::new();
    let mut t = 0.0;
    for (k, cut) in cuts.iter().enumerate() {
        if k > 0 {
            t += cut
                .centre
                .distance(cuts[k - 1].centre)
                .max(1e-6 * cut.radius);
        }
        stations.push(Station {
            t,
            centre: cut.centre,
            radius: cut.radius,
            reach: cut.reach,
        });
    }
    let last = cuts[cuts.len() - 1];
    let first = -(cuts[0].centre - trace.tips[0])
        .dot(cuts[0].normal)
        .max(0.0);
    let end = t + (trace.tips[1] - last.centre).dot(last.normal).max(0.0);
    if end <= first {
        return None;
    }
    // Which good stations border a gap, by t.
    let gaps: Vec<(f64, f64)> = good
        .windows(2)
        .zip(stations.windows(2))
        .filter(|(g, _)| g[1] > g[0] + 1)
        .map(|(_, s)| (s[0].t, s[1].t))
        .collect();
    let at = stations[good.partition_point(|&g| g < near).min(good.len() - 1)].t;
    let keep = (
        gaps.iter()
            .map(|g| g.1)
            .filter(|&g| g <= at)
            .fold(first, f64::max),
        gaps.iter()
            .map(|g| g.0)
            .filter(|&g| g >= at)
            .fold(end, f64::min),
    );
    let (axis, lengths) = if stations.len() < 3 || t < SHORT * cuts[cuts.len() / 2].radius {
        straight(&stations, first, end, cuts[cuts.len() / 2].normal)?
    } else {
        curved(surface, stations.clone(), first, end, keep, &gaps)?
    };
    // Up to the very end, where nothing but the end follows the last good station.
    let whole = |side: usize, station: usize| {
        let outermost = if side == 0 { 0 } else { trace.states.len() - 1 };
        station == outermost && trace.ends[side] == End::Real
    };
    let free = (
        if whole(0, good[0]) { first } else { 0.0 },
        if whole(1, good[good.len() - 1]) {
            end
        } else {
            t
        },
    );
    let cut_off = |side: usize| {
        let states = if side == 0 {
            &trace.states[..good[0]]
        } else {
            &trace.states[good[good.len() - 1]..]
        };
        trace.ends[side] == End::Fork || states.contains(&State::Fork)
    };
    let kind = StemKind::Round;
    let mut body = Body {
        axis,
        stations: Vec::new(),
        kind,
        ends: trace.ends,
        width: 0.0,
    };
    let tiny = 0.06 * cuts[0].radius.min(last.radius);
    for (i, &t) in lengths.iter().enumerate() {
        // At the very ends the plane would graze the end face, or cut it off where it is not quite square.
        let s = body.axis.lengths()[i].clamp(tiny, body.axis.length() - tiny);
        let fork = gaps.iter().any(|g| t > g.0 && t < g.1);
        let state = if fork {
            Stretch::Fork
        } else if t < free.0 - 1e-12 {
            if cut_off(0) {
                Stretch::Fork
            } else {
                Stretch::End
            }
        } else if t > free.1 + 1e-12 {
            if cut_off(1) {
                Stretch::Fork
            } else {
                Stretch::End
            }
        } else {
            Stretch::Free
        };
        if state != Stretch::Free {
            body.stations.push((state, None));
            continue;
        }
        let nearest = stations
            .partition_point(|q| q.t < t)
            .min(stations.len() - 1);
        let expected = std::f64::consts::PI * stations[nearest].radius * stations[nearest].radius;
        let found = section_at(surface, &body.axis, s, 0.5 * stations[nearest].radius)
            .filter(|c| c.area > 0.5 * expected && c.area < 1.8 * expected);
        let state = if found.is_some() {
            Stretch::Free
        } else if i == 0 || i + 1 == lengths.len() {
            Stretch::End
        } else {
            Stretch::Broken
        };
        body.stations.push((state, found));
    }
    Some(body)
}

/// Axis and sections of a board: straight along its box, whatever notches and holes there are.
pub(crate) fn board_body(surface: &Surface, plank: &Plank) -> Option<Body> {
    let [length, width, thickness] = plank.size;
    // A quarter of the radius of a circle of the same area.
    let spacing = 0.25 * (width * thickness / std::f64::consts::PI).sqrt();
    let count = (length / spacing).ceil().clamp(16.0, 1000.0) as usize;
    let points: Vec<DVec3> = (0..=count)
        .map(|i| plank.end + plank.direction * (length * i as f64 / count as f64))
        .collect();
    let axis = Axis::new(&points, Some(plank.wide))?;
    if axis.points().len() != points.len() {
        return None;
    }
    let cuts: Vec<Option<(Section, usize)>> = (0..=count)
        .map(|i| {
            let s = axis.lengths()[i].clamp(0.1 * spacing, length - 0.1 * spacing);
            section_and_rivals(surface, &axis, s, width)
        })
        .collect();
    let mut areas: Vec<f64> = cuts.iter().flatten().map(|c| c.0.area).collect();
    areas.sort_by(f64::total_cmp);
    let typical = *areas.get(areas.len() / 2)?;
    let stations = cuts
        .into_iter()
        .enumerate()
        .map(|(i, cut)| match cut {
            // A rounded end is left out where it is less than half of the board.
            Some((section, 0)) if section.area > 0.5 * typical => (Stretch::Free, Some(section)),
            Some((_, rivals)) if rivals > 0 => (Stretch::Broken, None),
            _ if i < count / 8 || i > count - count / 8 => (Stretch::End, None),
            _ => (Stretch::Broken, None),
        })
        .collect();
    Some(Body {
        axis,
        stations,
        kind: StemKind::Board,
        ends: [End::Real; 2],
        width,
    })
}

/// A straight axis through the middle of the centroids along `normal`.
fn straight(stations: &[Station], first: f64, end: f64, normal: DVec3) -> Option<(Axis, Vec<f64>)> {
    let mean = stations.iter().map(|s| s.centre).sum::<DVec3>() / stations.len() as f64;
    let middle = stations.iter().map(|s| s.t).sum::<f64>() / stations.len() as f64;
    let radius = stations[stations.len() / 2].radius;
    let count = ((end - first) / (0.25 * radius)).ceil().clamp(8.0, 4000.0) as usize;
    let lengths: Vec<f64> = (0..=count)
        .map(|i| first + (end - first) * i as f64 / count as f64)
        .collect();
    let points: Vec<DVec3> = lengths
        .iter()
        .map(|t| mean + normal * (t - middle))
        .collect();
    let axis = Axis::new(&points, None)?;
    (axis.points().len() == lengths.len()).then_some((axis, lengths))
}

/// A smooth axis: through the centroids as traced, then once more through those of sections square to it.
fn curved(
    surface: &Surface,
    mut stations: Vec<Station>,
    first: f64,
    end: f64,
    keep: (f64, f64),
    gaps: &[(f64, f64)],
) -> Option<(Axis, Vec<f64>)> {
    let (points, lengths) = smooth(&stations, first, end, keep);
    let axis = Axis::new(&points, None)?;
    if axis.points().len() != lengths.len() {
        return None;
    }
    for station in &mut stations {
        if gaps.iter().any(|g| station.t >= g.0 && station.t <= g.1) {
            continue;
        }
        let k = lengths
            .partition_point(|&t| t <= station.t)
            .clamp(1, lengths.len() - 1);
        let u = (station.t - lengths[k - 1]) / (lengths[k] - lengths[k - 1]);
        let s = axis.lengths()[k - 1] + (axis.lengths()[k] - axis.lengths()[k - 1]) * u;
        let Some(found) = section_at(surface, &axis, s, 0.5 * station.radius) else {
            continue;
        };
        let area = std::f64::consts::PI * station.radius * station.radius;
        if found.area > 0.7 * area && found.area < 1.3 * area {
            let frame = axis.frame(s);
            station.centre = frame.origin + frame.x * found.centroid.x + frame.y * found.centroid.y;
        }
    }
    let (points, lengths) = smooth(&stations, first, end, keep);
    let axis = Axis::new(&points, None)?;
    (axis.points().len() == lengths.len()).then_some((axis, lengths))
}

/// Size of the sections of the run that holds `place`, relative to that at the place: smoothed, 1 at the place.
pub(crate) fn taper(body: &Body, run: (f64, f64), place: f64, area: f64) -> Vec<(f64, f64)> {
    if body.kind == StemKind::Board {
        return Vec::new();
    }
    let sizes: Vec<(f64, f64)> = body
        .stations
        .iter()
        .filter_map(|(_, section)| section.as_ref())
        .filter(|s| s.length >= run.0 && s.length <= run.1)
        .map(|s| (s.length, (s.area / area).sqrt()))
        .collect();
    let window = 3.0 * body.radius(place);
    let fit = |s: f64| {
        let mut m = [0.0; 5];
        let from = sizes.partition_point(|p| p.0 < s - window);
        for &(at, size) in sizes[from..].iter().take_while(|p| p.0 <= s + window) {
            let u = (at - s) / window;
            let w = (1.0 - u * u) * (1.0 - u * u) + 1e-9;
            m = [
                m[0] + w,
                m[1] + w * u,
                m[2] + w * u * u,
                m[3] + w * size,
                m[4] + w * u * size,
            ];
        }
        let det = m[0] * m[2] - m[1] * m[1];
        if det > 1e-9 * m[0] * m[0] {
            (m[3] * m[2] - m[4] * m[1]) / det
        } else {
            m[3] / m[0]
        }
    };
    if sizes.len() < 2 {
        return Vec::new();
    }
    let here = fit(place);
    let mut taper: Vec<(f64, f64)> = sizes
        .iter()
        .filter(|p| (p.0 - place).abs() > 1e-9 * window)
        .map(|p| (p.0, (fit(p.0) / here).clamp(0.1, 10.0)))
        .collect();
    let k = taper.partition_point(|p| p.0 < place);
    taper.insert(k, (place, 1.0));
    taper
}
