//! Following a stem through a shell: from one section to the next, until the wood ends or forks.

use super::section::{ShellSection, aligned_section, closed_loops, section, stump_step};
use super::surface::Surface;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Distance between sections, in radii. A third of a radius sees a bend of the tightest kind (1.5 radii) turn by 13°.
const STEP_RADII: f64 = 0.3;
/// A section this much larger than those before it, by area or by reach, is a fork.
const FORK_GROWTH: f64 = 1.5;
/// A section this much smaller is either one arm of a fork or the closing of the end.
const CLOSING_SHRINKAGE: f64 = 0.62;
/// Sections that the present one is compared with: about two radii of stem.
const REMEMBERED_SECTIONS: usize = 6;
/// Sections followed at most in one direction; a stem 1,000 radii long has about 3,300.
const MAX_SECTIONS: usize = 6000;
/// Where the stem has thinned out to this part of its greatest radius, it has ended.
const VANISHING: f64 = 0.01;
/// Closing sections after which the end may be a stem that goes on thinner, and how many of them must be about equal.
const CLOSING_SECTIONS: usize = 8;
const THINNER_SECTIONS: usize = 4;

/// What a station of a trace is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StationState {
    /// A plain section of the stem.
    Good,
    /// In or at a fork.
    Fork,
    /// Where the end closes.
    Cap,
}

/// How a trace ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TraceEnd {
    /// The wood ends, closed or open.
    Real,
    /// Other wood joins.
    Fork,
}

/// A stem as followed: its stations in order.
#[derive(Debug, Clone)]
pub(crate) struct Trace {
    pub sections: Vec<ShellSection>,
    pub states: Vec<StationState>,
    /// The last points of the axis at either end, m.
    pub tips: [DVec3; 2],
    pub ends: [TraceEnd; 2],
}

impl Trace {
    /// Volume of the good part, m³.
    pub fn volume(&self) -> f64 {
        let mut sum = 0.0;
        for i in 1..self.sections.len() {
            if self.states[i] == StationState::Good && self.states[i - 1] == StationState::Good {
                let (a, b) = (&self.sections[i], &self.sections[i - 1]);
                sum += 0.5 * (a.area + b.area) * a.centre.distance(b.centre);
            }
        }
        sum
    }

    /// Reverses the direction in which the stem runs.
    pub fn reverse(&mut self) {
        self.sections.reverse();
        self.states.reverse();
        self.tips.reverse();
        self.ends.reverse();
        self.sections.iter_mut().for_each(|c| c.normal = -c.normal);
    }
}

/// Whether a trace stops at the first fork or goes on into its thickest arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AtForks {
    Stop,
    GoOn,
}

/// Follows the stem both ways from `seed`.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn trace(
    surface: &Surface,
    seed: ShellSection,
    at_forks: AtForks,
    context: &Context,
) -> Result<Trace, Cancelled> {
    let up = March::new(surface, &seed, seed.normal, at_forks).run(context)?;
    let down = March::new(surface, &seed, -seed.normal, at_forks).run(context)?;
    let mut sections: Vec<ShellSection> = down.sections.into_iter().rev().collect();
    sections.iter_mut().for_each(|c| c.normal = -c.normal);
    let mut states: Vec<StationState> = down.states.into_iter().rev().collect();
    sections.push(seed);
    states.push(StationState::Good);
    sections.extend(up.sections);
    states.extend(up.states);
    let mut trace = Trace {
        sections,
        states,
        tips: [down.tip, up.tip],
        ends: [down.end, up.end],
    };
    if trace.ends[0] == TraceEnd::Fork {
        mark_swelling(&mut trace, 0, 1);
    }
    if trace.ends[1] == TraceEnd::Fork {
        let last = trace.sections.len() - 1;
        mark_swelling(&mut trace, last, -1);
    }
    for i in 1..trace.states.len() {
        if trace.states[i] == StationState::Fork && trace.states[i - 1] == StationState::Good {
            mark_swelling(&mut trace, i - 1, -1);
        }
    }
    Ok(trace)
}

/// Marks the stations next to a fork that already swell towards it, from `from` in steps of `by`.
fn mark_swelling(trace: &mut Trace, from: usize, by: isize) {
    const MAX_RUN: usize = 24;
    let mut run = Vec::new();
    let mut i = from as isize;
    let state = |i: isize| usize::try_from(i).ok().and_then(|k| trace.states.get(k));
    while let Some(StationState::Good) = state(i) {
        run.push(i as usize);
        i += by;
        if run.len() >= MAX_RUN {
            break;
        }
    }
    let mut areas: Vec<f64> = run.iter().map(|&k| trace.sections[k].area).collect();
    areas.sort_by(f64::total_cmp);
    let Some(&plain) = areas.get(areas.len() / 4) else {
        return;
    };
    for k in run {
        if trace.sections[k].area < 1.2 * plain && trace.sections[k].nearby_loops == 0 {
            break;
        }
        trace.states[k] = StationState::Fork;
    }
}

/// The part of a section that those after it are compared with.
#[derive(Debug, Clone, Copy)]
struct Size {
    area: f64,
    reach: f64,
}

impl Size {
    fn of(section: &ShellSection) -> Self {
        Size {
            area: section.area,
            reach: section.reach,
        }
    }
}

/// What the next plane showed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ahead {
    Plain,
    Gone,
    Fork,
}

/// One direction of a trace as far as it was followed.
struct March<'a> {
    surface: &'a Surface<'a>,
    at_forks: AtForks,
    /// Sections of a shell lower than it is wide are closer together, m.
    stump_step: Option<f64>,
    direction: DVec3,
    last: ShellSection,
    recent: Vec<Size>,
    /// Centroids since the last fork.
    centres: Vec<DVec3>,
    greatest_radius: f64,
    sections: Vec<ShellSection>,
    states: Vec<StationState>,
    tip: DVec3,
    end: TraceEnd,
}

impl<'a> March<'a> {
    fn new(
        surface: &'a Surface<'a>,
        seed: &ShellSection,
        direction: DVec3,
        at_forks: AtForks,
    ) -> Self {
        March {
            surface,
            at_forks,
            stump_step: stump_step(surface, seed),
            direction,
            last: seed.clone(),
            recent: vec![Size::of(seed)],
            centres: vec![seed.centre],
            greatest_radius: seed.radius,
            sections: Vec::new(),
            states: Vec::new(),
            tip: seed.centre,
            end: TraceEnd::Real,
        }
    }

    /// Follows the stem until it ends, forks or thins out.
    fn run(mut self, context: &Context) -> Result<Self, Cancelled> {
        while self.sections.len() < MAX_SECTIONS {
            context.check()?;
            let size = self.recent_size();
            let max_step = self.stump_step.unwrap_or(f64::INFINITY);
            let step = (STEP_RADII * self.last.radius).min(max_step);
            let next = section(
                self.surface,
                self.last.centre + self.direction * step,
                self.direction,
                self.last.radius,
            );
            let ahead = self.judge(next.as_ref(), step, size);
            if let (Ahead::Plain, Some(next)) = (ahead, next) {
                self.advance(next, size);
                if self.last.radius < VANISHING * self.greatest_radius {
                    break;
                }
                continue;
            }
            let fork = ahead == Ahead::Fork;
            let Some(beyond) = self.continuation(fork, size) else {
                self.end = if fork { TraceEnd::Fork } else { TraceEnd::Real };
                self.tip = match ahead {
                    Ahead::Gone => self.last_point(step),
                    _ => self.last.centre,
                };
                return Ok(self);
            };
            self.bridge(beyond);
        }
        Ok(self)
    }

    /// The usual size of the stem's last sections.
    fn recent_size(&self) -> Size {
        // Roots spread so fast that only the last section of a stump compares.
        let count = if self.stump_step.is_some() {
            1
        } else {
            REMEMBERED_SECTIONS
        };
        let recent = || self.recent.iter().rev().take(count);
        Size {
            area: median(recent().map(|m| m.area)),
            reach: median(recent().map(|m| m.reach)),
        }
    }

    fn judge(&self, next: Option<&ShellSection>, step: f64, size: Size) -> Ahead {
        let Some(next) = next else { return Ahead::Gone };
        if next.centre.distance(self.last.centre) > step + size.reach {
            Ahead::Gone
        } else if next.area > FORK_GROWTH * size.area
            || next.reach > FORK_GROWTH * size.reach
            || (next.area < CLOSING_SHRINKAGE * size.area && next.nearby_loops > 0)
        {
            Ahead::Fork
        } else {
            Ahead::Plain
        }
    }

    /// Takes a plain section.
    fn advance(&mut self, next: ShellSection, size: Size) {
        let closing = next.area < CLOSING_SHRINKAGE * size.area;
        self.last = next.clone();
        self.tip = next.centre;
        if closing {
            self.states.push(StationState::Cap);
            self.sections.push(next);
            self.reopen_thinner_stem();
            return;
        }
        self.recent.push(Size::of(&next));
        self.centres.push(next.centre);
        self.greatest_radius = self.greatest_radius.max(next.radius);
        // Over a stump's few steps the centroids say more of its roots than of its direction.
        if self.stump_step.is_none() {
            self.direction = next_direction(&self.centres, self.direction);
        }
        self.states.push(StationState::Good);
        self.sections.push(next);
    }

    /// A stem that goes on thinner is no closing end.
    fn reopen_thinner_stem(&mut self) {
        let is_cap = |s: &&StationState| **s == StationState::Cap;
        let tail = self.states.iter().rev().take_while(is_cap).count();
        let recent = &self.sections[self.sections.len() - tail.min(THINNER_SECTIONS)..];
        if tail >= CLOSING_SECTIONS && recent[0].area < 1.15 * recent[recent.len() - 1].area {
            let from = self.states.len() - THINNER_SECTIONS;
            self.states[from..].fill(StationState::Good);
            self.recent = recent.iter().map(Size::of).collect();
            self.centres = recent.iter().map(|c| c.centre).collect();
        }
    }

    /// The section in which the stem goes on beyond a fork or a gap.
    fn continuation(&self, fork: bool, size: Size) -> Option<ShellSection> {
        if fork && self.at_forks == AtForks::Stop {
            return None;
        }
        // A gap that is no fork is bridged only where the stem goes on at once.
        let far = if fork {
            5.0 * size.reach
        } else {
            1.5 * size.reach.min(2.0 * self.last.radius)
        };
        section_beyond(self.surface, &self.last, self.direction, far, size)
    }

    /// Goes on with the section beyond a gap. One station stands for the whole gap.
    fn bridge(&mut self, beyond: ShellSection) {
        let mut gap = beyond.clone();
        gap.centre = self.last.centre.lerp(beyond.centre, 0.5);
        self.sections.push(gap);
        self.states.push(StationState::Fork);
        self.direction = beyond.normal;
        self.recent = vec![Size::of(&beyond)];
        self.centres = vec![beyond.centre];
        self.last = beyond.clone();
        self.sections.push(beyond);
        self.states.push(StationState::Good);
    }

    /// The last point, to a thousandth of a step, at which there still is a section.
    fn last_point(&self, step: f64) -> DVec3 {
        let (mut there, mut gone) = (0.0, step);
        for _ in 0..10 {
            let middle = 0.5 * (there + gone);
            let at = self.last.centre + self.direction * middle;
            match section(self.surface, at, self.direction, self.last.radius) {
                Some(c) if c.centre.distance(self.last.centre) < middle + self.last.reach => {
                    there = middle;
                }
                _ => gone = middle,
            }
        }
        self.last.centre + self.direction * there
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// The direction in which to go on: along the last radius and a half of stem, smoothed.
fn next_direction(centres: &[DVec3], direction: DVec3) -> DVec3 {
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

/// A plain section within `far` (m) in which the stem goes on: the thickest candidate.
fn section_beyond(
    surface: &Surface,
    last: &ShellSection,
    direction: DVec3,
    far: f64,
    size: Size,
) -> Option<ShellSection> {
    const STOPS: usize = 16;
    for k in 1..=STOPS {
        let offset = far * k as f64 / STOPS as f64;
        let at = last.centre + direction * offset;
        let loops = closed_loops(surface, at, direction);
        let fitting = loops.sections.iter().find(|c| {
            c.area < FORK_GROWTH * size.area
                && c.area > 0.12 * size.area
                && c.reach < FORK_GROWTH * size.reach
                && c.centre.distance(at) < 0.5 * size.reach + 0.8 * offset
        });
        let Some(arm) = fitting else { continue };
        let Some(aligned) = aligned_section(surface, arm.centre, direction) else {
            continue;
        };
        let ahead = aligned.normal.dot(direction) > 0.4
            && (aligned.centre - last.centre).dot(direction) > 0.0;
        if ahead
            && aligned.area < FORK_GROWTH * size.area
            && aligned.reach < FORK_GROWTH * size.reach
        {
            return Some(aligned);
        }
    }
    None
}
