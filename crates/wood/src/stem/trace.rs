//! Following a stem through a shell: from one section to the next, until the wood ends or forks.

use super::polygon;
use super::surface::Surface;
use glam::{DVec2, DVec3};

/// Distance between sections, in radii. A third of a radius sees a bend of the tightest kind (1.5 radii) turn by 13°.
const STEP: f64 = 0.3;
/// A section this much larger than those before it, by area or by reach, is a fork.
const GROWN: f64 = 1.5;
/// A section this much smaller is either one arm of a fork or the closing of the end.
const SHRUNK: f64 = 0.62;
/// Sections that the present one is compared with: about two radii of stem.
const REMEMBERED: usize = 6;
/// Sections over the height of a stump.
const STUMP_STEPS: f64 = 24.0;
/// Sections followed at most in one direction; a stem 1,000 radii long has about 3,300.
const LONGEST: usize = 6000;

/// A closed section of a shell.
#[derive(Debug, Clone)]
pub(crate) struct Cut {
    /// Centroid, m.
    pub centre: DVec3,
    pub normal: DVec3,
    /// Area, m².
    pub area: f64,
    /// Radius of the circle of equal area, m.
    pub radius: f64,
    /// Largest distance of the outline from the centroid, m.
    pub reach: f64,
    /// Other closed loops of some size close by.
    pub rivals: usize,
    /// The outline, m.
    pub points: Vec<DVec3>,
    /// Triangles that it runs over.
    pub triangles: Vec<u32>,
}

/// What a station of a trace is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum State {
    /// A plain section of the stem.
    Good,
    /// In or at a fork.
    Fork,
    /// Where the end closes.
    Cap,
}

/// How a trace ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// The wood ends, closed or open.
    Real,
    /// Other wood joins.
    Fork,
}

/// A stem as followed: its stations in order.
#[derive(Debug, Clone)]
pub(crate) struct Trace {
    pub cuts: Vec<Cut>,
    pub states: Vec<State>,
    /// The last points of the axis at either end, m.
    pub tips: [DVec3; 2],
    pub ends: [End; 2],
}

impl Trace {
    /// Volume of the good part, m³.
    pub fn volume(&self) -> f64 {
        let mut sum = 0.0;
        for i in 1..self.cuts.len() {
            if self.states[i] == State::Good && self.states[i - 1] == State::Good {
                let step = self.cuts[i].centre.distance(self.cuts[i - 1].centre);
                sum += 0.5 * (self.cuts[i].area + self.cuts[i - 1].area) * step;
            }
        }
        sum
    }

    /// The same, run through the other way.
    pub fn reverse(&mut self) {
        self.cuts.reverse();
        self.states.reverse();
        self.tips.reverse();
        self.ends.reverse();
        self.cuts.iter_mut().for_each(|c| c.normal = -c.normal);
    }
}

/// An orthonormal pair across `normal`.
pub(crate) fn across(normal: DVec3) -> (DVec3, DVec3) {
    let x = normal.any_orthonormal_vector();
    (x, normal.cross(x))
}

/// All closed loops of the plane through `origin`, largest first, and the one that is meant: the largest that holds
/// `origin`, else the one whose outline is nearest to it.
fn closed_loops(surface: &Surface, origin: DVec3, normal: DVec3) -> (Vec<Cut>, Option<usize>) {
    let (x, y) = across(normal);
    let mut cuts: Vec<(Cut, bool, f64)> = Vec::new();
    for line in surface.slice(origin, normal) {
        if !line.closed || line.points.len() < 3 {
            continue;
        }
        let flat: Vec<DVec2> = line
            .points
            .iter()
            .map(|&p| DVec2::new((p - origin).dot(x), (p - origin).dot(y)))
            .collect();
        let (area, middle) = polygon::area_and_centroid(&flat);
        let reach = flat.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        // A sliver, where the plane grazes a flat face, is no section.
        if area.abs() <= 1e-6 * reach * reach {
            continue;
        }
        let holds = polygon::contains(&flat, DVec2::ZERO);
        let far = if holds {
            0.0
        } else {
            polygon::distance(&flat, DVec2::ZERO)
        };
        let cut = Cut {
            centre: origin + x * middle.x + y * middle.y,
            normal,
            area: area.abs(),
            radius: (area.abs() / std::f64::consts::PI).sqrt(),
            reach,
            rivals: 0,
            points: line.points,
            triangles: line.triangles,
        };
        cuts.push((cut, holds, far));
    }
    cuts.sort_by(|a, b| b.0.area.total_cmp(&a.0.area));
    let meant = cuts.iter().position(|c| c.1).or_else(|| {
        (0..cuts.len()).min_by(|&i, &j| cuts[i].2.total_cmp(&cuts[j].2).then(i.cmp(&j)))
    });
    (cuts.into_iter().map(|c| c.0).collect(), meant)
}

/// The section at or nearest to `origin`, its outline at most `limit` (m) away.
pub(crate) fn section(surface: &Surface, origin: DVec3, normal: DVec3, limit: f64) -> Option<Cut> {
    let (mut cuts, meant) = closed_loops(surface, origin, normal);
    let meant = meant?;
    let chosen = &cuts[meant];
    let near = chosen
        .points
        .iter()
        .map(|p| p.distance(origin))
        .fold(f64::INFINITY, f64::min);
    let inside = chosen.centre.distance(origin) <= chosen.reach;
    if !inside && near > limit {
        return None;
    }
    let rivals = cuts
        .iter()
        .enumerate()
        .filter(|(i, c)| {
            let gap = c.centre.distance(chosen.centre) - c.reach - chosen.reach;
            *i != meant
                && c.area > 0.1 * chosen.area
                && gap < chosen.radius.max(c.radius)
                && c.centre.distance(chosen.centre) > 0.5 * chosen.radius
        })
        .count();
    let mut cut = cuts.swap_remove(meant);
    cut.rivals = rivals;
    Some(cut)
}

/// Turns the plane through `origin` until its normal is the local direction of the stem: the centroids of the two
/// parallel sections before and behind lie on the axis even where the plane is tilted. `None` where that does not
/// settle.
pub(crate) fn settle(surface: &Surface, origin: DVec3, direction: DVec3) -> Option<Cut> {
    let mut direction = direction.try_normalize()?;
    let mut cut = section(surface, origin, direction, f64::INFINITY)?;
    let mut turn = f64::INFINITY;
    let longest_step = stump_height(surface, &cut).map_or(f64::INFINITY, |h| h / STUMP_STEPS);
    for _ in 0..10 {
        let near = 2.0 * cut.reach;
        let (mut before, mut behind) = (None, None);
        let mut h = (0.5 * cut.radius).min(longest_step);
        for _ in 0..3 {
            let fits = |c: &Cut| c.area < 1.7 * cut.area && c.area > 0.55 * cut.area;
            before = section(surface, cut.centre + direction * h, direction, near).filter(fits);
            behind = section(surface, cut.centre - direction * h, direction, near).filter(fits);
            if before.is_some() || behind.is_some() {
                break;
            }
            h *= 0.4;
        }
        let ahead = before.map_or(cut.centre, |c| c.centre);
        let back = behind.map_or(cut.centre, |c| c.centre);
        let better = (ahead - back).try_normalize()?;
        turn = better.distance(direction);
        direction = better;
        cut = section(surface, cut.centre, direction, near)?;
        if turn < 0.01 {
            break;
        }
    }
    (turn < 0.2).then_some(cut)
}

/// Height of a shell that is lower than the section is wide: a stump.
fn stump_height(surface: &Surface, cut: &Cut) -> Option<f64> {
    let shortest = surface.shortest_side();
    (shortest < 1.9 * cut.radius && shortest > 0.5 * cut.radius).then_some(shortest)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// One direction of a trace.
struct Arm {
    cuts: Vec<Cut>,
    states: Vec<State>,
    tip: DVec3,
    end: End,
}

/// What the next plane showed.
enum Event {
    None,
    Gone,
    Fork,
}

/// Follows the stem both ways from `seed`. With `through_forks` the trace goes on into the thickest arm of a fork.
pub(crate) fn trace(surface: &Surface, seed: Cut, through_forks: bool) -> Trace {
    let up = march(surface, &seed, seed.normal, through_forks);
    let down = march(surface, &seed, -seed.normal, through_forks);
    let mut cuts: Vec<Cut> = down.cuts.into_iter().rev().collect();
    cuts.iter_mut().for_each(|c| c.normal = -c.normal);
    let mut states: Vec<State> = down.states.into_iter().rev().collect();
    cuts.push(seed);
    states.push(State::Good);
    cuts.extend(up.cuts);
    states.extend(up.states);
    let mut trace = Trace {
        cuts,
        states,
        tips: [down.tip, up.tip],
        ends: [down.end, up.end],
    };
    if trace.ends[0] == End::Fork {
        swell(&mut trace, 0, 1);
    }
    if trace.ends[1] == End::Fork {
        let last = trace.cuts.len() - 1;
        swell(&mut trace, last, -1);
    }
    for i in 1..trace.states.len() {
        if trace.states[i] == State::Fork && trace.states[i - 1] == State::Good {
            swell(&mut trace, i - 1, -1);
        }
    }
    trace
}

/// Marks the stations next to a fork that already swell towards it, from `from` in steps of `by`.
fn swell(trace: &mut Trace, from: usize, by: isize) {
    let mut run = Vec::new();
    let mut i = from as isize;
    while let Some(State::Good) = usize::try_from(i).ok().and_then(|k| trace.states.get(k)) {
        run.push(i as usize);
        i += by;
        if run.len() >= 24 {
            break;
        }
    }
    let mut areas: Vec<f64> = run.iter().map(|&k| trace.cuts[k].area).collect();
    areas.sort_by(f64::total_cmp);
    let Some(&plain) = areas.get(areas.len() / 4) else {
        return;
    };
    for k in run {
        if trace.cuts[k].area < 1.2 * plain && trace.cuts[k].rivals == 0 {
            break;
        }
        trace.states[k] = State::Fork;
    }
}

fn march(surface: &Surface, seed: &Cut, direction: DVec3, through_forks: bool) -> Arm {
    let mut arm = Arm {
        cuts: Vec::new(),
        states: Vec::new(),
        tip: seed.centre,
        end: End::Real,
    };
    let mut direction = direction;
    let mut last = seed.clone();
    let mut remembered: Vec<(f64, f64)> = vec![(seed.area, seed.reach)];
    let mut centres = vec![seed.centre];
    let mut thickest = seed.radius;
    let stump = stump_height(surface, seed);
    let longest_step = stump.map_or(f64::INFINITY, |height| height / STUMP_STEPS);
    // Roots spread so fast that only the last section compares.
    let memory = if stump.is_some() { 1 } else { REMEMBERED };
    while arm.cuts.len() < LONGEST {
        let (area, reach) = (
            median(remembered.iter().rev().take(memory).map(|m| m.0)),
            median(remembered.iter().rev().take(memory).map(|m| m.1)),
        );
        let step = (STEP * last.radius).min(longest_step);
        let next = section(
            surface,
            last.centre + direction * step,
            direction,
            last.radius,
        );
        let event = match &next {
            None => Event::Gone,
            Some(c) if c.centre.distance(last.centre) > step + reach => Event::Gone,
            Some(c) if c.area > GROWN * area || c.reach > GROWN * reach => Event::Fork,
            Some(c) if c.area < SHRUNK * area && c.rivals > 0 => Event::Fork,
            _ => Event::None,
        };
        let (Event::None, Some(cut)) = (&event, next) else {
            let fork = matches!(event, Event::Fork);
            let beyond = if fork && !through_forks {
                None
            } else {
                // A gap that is no fork is bridged only where the stem goes on at once.
                let far = if fork {
                    5.0 * reach
                } else {
                    1.5 * reach.min(2.0 * last.radius)
                };
                beyond(surface, &last, direction, far, area, reach)
            };
            let Some(cut) = beyond else {
                arm.end = if fork { End::Fork } else { End::Real };
                arm.tip = match event {
                    Event::Gone => tip(surface, &last, direction, step),
                    _ => last.centre,
                };
                return arm;
            };
            // One station stands for the whole gap.
            let mut gap = cut.clone();
            gap.centre = last.centre.lerp(cut.centre, 0.5);
            arm.cuts.push(gap);
            arm.states.push(State::Fork);
            direction = cut.normal;
            remembered = vec![(cut.area, cut.reach)];
            centres = vec![cut.centre];
            last = cut.clone();
            arm.cuts.push(cut);
            arm.states.push(State::Good);
            continue;
        };
        let closing = cut.area < SHRUNK * area;
        last = cut.clone();
        arm.tip = cut.centre;
        if closing {
            arm.states.push(State::Cap);
            arm.cuts.push(cut);
            // A stem that goes on thinner is no closing end.
            let tail = arm
                .states
                .iter()
                .rev()
                .take_while(|s| **s == State::Cap)
                .count();
            let recent = &arm.cuts[arm.cuts.len() - tail.min(4)..];
            if tail >= 8 && recent[0].area < 1.15 * recent[recent.len() - 1].area {
                let from = arm.states.len() - 4;
                arm.states[from..].fill(State::Good);
                remembered = recent.iter().map(|c| (c.area, c.reach)).collect();
                centres = recent.iter().map(|c| c.centre).collect();
            }
        } else {
            remembered.push((cut.area, cut.reach));
            centres.push(cut.centre);
            thickest = thickest.max(cut.radius);
            // Over a stump's few steps the centroids say more of its roots than of its direction.
            if stump.is_none() {
                direction = turned(&centres, direction);
            }
            arm.states.push(State::Good);
            arm.cuts.push(cut);
        }
        if last.radius < 0.01 * thickest {
            break;
        }
    }
    arm
}

/// The direction in which to go on: along the last radius and a half of stem, smoothed.
fn turned(centres: &[DVec3], direction: DVec3) -> DVec3 {
    let last = centres.len() - 1;
    let back = last.saturating_sub(5);
    let chord = (centres[last] - centres[back]).normalize_or_zero();
    // The chord points where the stem went half its span ago; what it turned since is added.
    let weight = if last < 3 { 1.0 } else { 0.35 };
    let ahead = if last >= 10 {
        let before = (centres[back] - centres[back - 5]).normalize_or_zero();
        (chord + (chord - before) * 0.5).normalize_or_zero()
    } else {
        chord
    };
    (direction * weight + ahead)
        .try_normalize()
        .unwrap_or(direction)
}

/// The last point, to a thousandth of a step, at which there still is a section.
fn tip(surface: &Surface, last: &Cut, direction: DVec3, step: f64) -> DVec3 {
    let (mut there, mut gone) = (0.0, step);
    for _ in 0..10 {
        let middle = 0.5 * (there + gone);
        let at = last.centre + direction * middle;
        match section(surface, at, direction, last.radius) {
            Some(c) if c.centre.distance(last.centre) < middle + last.reach => there = middle,
            _ => gone = middle,
        }
    }
    last.centre + direction * there
}

/// A plain section within `far` (m) in which the stem goes on: the thickest that could be it.
fn beyond(
    surface: &Surface,
    last: &Cut,
    direction: DVec3,
    far: f64,
    area: f64,
    reach: f64,
) -> Option<Cut> {
    const STOPS: usize = 16;
    for k in 1..=STOPS {
        let off = far * k as f64 / STOPS as f64;
        let at = last.centre + direction * off;
        let (cuts, _) = closed_loops(surface, at, direction);
        let fitting = cuts.iter().find(|c| {
            c.area < GROWN * area
                && c.area > 0.12 * area
                && c.reach < GROWN * reach
                && c.centre.distance(at) < 0.5 * reach + 0.8 * off
        });
        let Some(arm) = fitting else { continue };
        let Some(settled) = settle(surface, arm.centre, direction) else {
            continue;
        };
        let ahead = settled.normal.dot(direction) > 0.4
            && (settled.centre - last.centre).dot(direction) > 0.0;
        if ahead && settled.area < GROWN * area && settled.reach < GROWN * reach {
            return Some(settled);
        }
    }
    None
}
