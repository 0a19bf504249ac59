//! Which shell of a model holds the stem at a location, and how the stem runs: as a log or as a board.

use super::StemLocation;
use super::error::StemError;
use super::identity::{StemIdentity, limb_at, size_of_trace};
use super::model::StemKind;
use super::parts::Parts;
use super::plank::{Plank, is_board};
use super::section::ShellSection;
use super::seed;
use super::surface::Surface;
use super::trace::{AtForks, StationState, Trace, trace};
use glam::DVec3;
use greenstick_geometry::closest_point_on_triangle;
use greenstick_geometry::{Cancelled, Context};

/// Most shells that are tried for the main stem.
const MAX_TRIED_SHELLS: usize = 40;
/// Most stems that are compared by volume.
const MAX_COMPARED_STEMS: usize = 6;
/// A point may be this far from the wood, in radii of a log or widths of a board: a hand is not quite steady.
const MAX_DISTANCE_RADII: f64 = 3.0;
const MAX_DISTANCE_WIDTHS: f64 = 1.5;
/// Triangles between two checks for cancellation.
const CHECK_INTERVAL: usize = 1 << 14;

/// What a shell was followed as.
pub(super) enum Course {
    Log(Trace),
    Board(Plank),
}

impl Course {
    /// The ends of the stem, m.
    pub fn tips(&self) -> [DVec3; 2] {
        match self {
            Course::Log(trace) => trace.tips,
            Course::Board(plank) => [plank.end, plank.end + plank.direction * plank.size[0]],
        }
    }

    /// The direction in which the stem runs at the station nearest to a point (m).
    pub fn direction_near(&self, p: DVec3) -> DVec3 {
        match self {
            Course::Log(trace) => trace.sections[nearest_station(trace, p)].normal,
            Course::Board(plank) => plank.direction,
        }
    }

    /// Exchanges base and tip.
    pub fn reverse(&mut self) {
        let [_, tip] = self.tips();
        match self {
            Course::Log(trace) => trace.reverse(),
            Course::Board(plank) => {
                plank.end = tip;
                plank.direction = -plank.direction;
            }
        }
    }

    /// Whether the base is at the last tip: the end that another shell holds, else the thicker end, else that with the
    /// lower y (then x, then z). `held` says for each tip which shell holds it.
    pub fn runs_from_tip_to_base(&self, held: [Option<usize>; 2]) -> bool {
        match held {
            [Some(_), None] => return false,
            [None, Some(_)] => return true,
            _ => {}
        }
        if let Course::Log(trace) = self {
            let areas: Vec<f64> = (0..trace.sections.len())
                .filter(|&i| trace.states[i] == StationState::Good)
                .map(|i| trace.sections[i].area)
                .collect();
            let fifth = (areas.len() / 5).max(1).min(areas.len());
            let mean = |a: &[f64]| a.iter().sum::<f64>() / a.len().max(1) as f64;
            let (first, last) = (mean(&areas[..fifth]), mean(&areas[areas.len() - fifth..]));
            // Closer than this the ends are equally thick: noise must not decide.
            if (first - last).abs() > 0.05 * (first + last) {
                return last > first;
            }
        }
        let [a, b] = self.tips();
        let length = a.distance(b);
        for k in [1, 0, 2] {
            if (a[k] - b[k]).abs() > 1e-6 * length {
                return b[k] < a[k];
            }
        }
        false
    }
}

/// The shell that holds the stem.
pub(super) struct Choice {
    /// Index of the shell.
    pub shell: usize,
    pub course: Course,
    /// Where the location is a point: the nearest point on the shell, m.
    pub surface_point: Option<DVec3>,
    pub identity: StemIdentity,
}

/// A shell's main stem: a board where it is one or is said to be one, else a log; with its volume, m³.
fn course_of_shell(
    surface: &Surface,
    kind: Option<StemKind>,
    context: &Context,
) -> Result<Option<(Course, f64)>, Cancelled> {
    if kind.is_none_or(|kind| kind == StemKind::Board) {
        let accepted = |p: &Plank| kind == Some(StemKind::Board) || is_board(surface, p);
        if let Some(plank) = Plank::around(surface, context)?.filter(accepted) {
            return Ok(Some((Course::Board(plank), plank.size.iter().product())));
        }
    }
    let trace = seed::main_stem(surface, context)?;
    Ok(trace.map(|trace| {
        let volume = trace.volume();
        (Course::Log(trace), volume)
    }))
}

/// Identifies the stem that runs along a shell.
fn identity(parts: &Parts, shell: usize, course: Option<&Course>) -> StemIdentity {
    let (length, girth) = match course {
        Some(Course::Log(trace)) => size_of_trace(trace),
        Some(Course::Board(plank)) => {
            let [length, width, thickness] = plank.size;
            (length, 2.0 * (width + thickness))
        }
        None => {
            let size = parts.shells[shell].high - parts.shells[shell].low;
            (size.max_element(), 2.0 * (size.x + size.y + size.z))
        }
    };
    StemIdentity {
        length,
        girth,
        shell,
        limb: None,
    }
}

/// The shell with the stem of largest volume.
pub(super) fn main_stem(
    parts: &Parts,
    kind: Option<StemKind>,
    context: &Context,
) -> Result<Choice, StemError> {
    let mut best: Option<(f64, usize, Course)> = None;
    let mut compared = 0;
    for &i in parts.largest_first.iter().take(MAX_TRIED_SHELLS) {
        context.report(0.0)?;
        if parts.shells[i].triangles.len() < 6 {
            continue;
        }
        let surface = parts.surface(i, context)?;
        let Some((course, volume)) = course_of_shell(&surface, kind, context)? else {
            continue;
        };
        if best.as_ref().is_none_or(|b| volume > b.0) {
            best = Some((volume, i, course));
        }
        compared += 1;
        if compared >= MAX_COMPARED_STEMS {
            break;
        }
    }
    let choice = best.map(|(_, shell, course)| Choice {
        shell,
        identity: identity(parts, shell, Some(&course)),
        course,
        surface_point: None,
    });
    choice.ok_or(StemError::NoStem {
        shells: parts.shells.len(),
    })
}

/// The shell nearest to the point `p`, and the limb of it there. Of shells that `p` lies within, the nearest of these: along the middle
/// of a stem the root of a limb that is stuck in it may be nearer than its own skin.
pub(super) fn stem_at_point(
    parts: &Parts,
    p: DVec3,
    kind: Option<StemKind>,
    context: &Context,
) -> Result<Choice, StemError> {
    let requested = StemLocation::Point(p);
    let Some(mut nearest) = nearest_shell(parts, p, &|_| true, context)? else {
        return Err(StemError::Empty);
    };
    if nearest.distance > 0.0 {
        let about = shells_about(parts, p, context)?;
        if !about.contains(&nearest.shell)
            && let Some(other) = nearest_shell(parts, p, &|i| about.contains(&i), context)?
        {
            nearest = other;
        }
    }
    let (shell, q) = (nearest.shell, nearest.point);
    let too_far = || StemError::FarFromWood {
        requested,
        distance: nearest.distance,
        nearest: StemLocation::Point(q),
    };
    let surface = parts.surface(shell, context)?;
    let course = course_of_shell(&surface, kind, context)?.map(|(course, _)| course);
    let mut identity = identity(parts, shell, course.as_ref());
    let trace = match course {
        Some(Course::Board(plank)) => {
            if nearest.distance > MAX_DISTANCE_WIDTHS * plank.size[1] {
                return Err(too_far());
            }
            return Ok(Choice {
                shell,
                course: Course::Board(plank),
                surface_point: Some(q),
                identity,
            });
        }
        Some(Course::Log(trace)) if covers(&trace, q) => Some(trace),
        course => match seed::section_of_limb(&surface, q) {
            Some(section) => {
                if let Some(Course::Log(main)) = &course {
                    identity.limb = limb_at(&surface, |p| covers(main, p), q, context)?;
                }
                Some(trace(&surface, section, AtForks::Stop, context)?)
            }
            None => None,
        },
    };
    let Some(trace) = trace else {
        return Err(StemError::NowhereFree {
            requested,
            found: "the nearest part of the model has no section that is one closed loop"
                .to_owned(),
        });
    };
    let radius = trace.sections[nearest_station(&trace, q)].radius;
    let inside = surface.contains(p);
    if nearest.distance > MAX_DISTANCE_RADII * radius && !inside {
        return Err(too_far());
    }
    Ok(Choice {
        shell,
        course: Course::Log(trace),
        surface_point: Some(q),
        identity,
    })
}

/// The point of a model's surface that is nearest to another.
struct NearestShell {
    distance: f64,
    shell: usize,
    point: DVec3,
}

/// The shells that a point lies within.
fn shells_about(parts: &Parts, p: DVec3, context: &Context) -> Result<Vec<usize>, Cancelled> {
    let mut about = Vec::new();
    for (i, shell) in parts.shells.iter().enumerate() {
        let in_box = shell.low.cmple(p).all() && p.cmple(shell.high).all();
        if in_box && parts.surface(i, context)?.contains(p) {
            about.push(i);
        }
    }
    Ok(about)
}

/// The nearest of the shells that are `asked` for.
fn nearest_shell(
    parts: &Parts,
    p: DVec3,
    asked: &dyn Fn(usize) -> bool,
    context: &Context,
) -> Result<Option<NearestShell>, Cancelled> {
    let mut best: Option<NearestShell> = None;
    for (i, shell) in parts.shells.iter().enumerate() {
        if !asked(i) {
            continue;
        }
        let bound = (shell.low - p)
            .max(p - shell.high)
            .max(DVec3::ZERO)
            .length();
        if best.as_ref().is_some_and(|b| bound >= b.distance) {
            continue;
        }
        let mesh = &parts.meshes[shell.node];
        for chunk in shell.triangles.chunks(CHECK_INTERVAL) {
            context.check()?;
            for &t in chunk {
                let point = closest_point_on_triangle(p, mesh.corners(t));
                let distance = point.distance(p);
                if best.as_ref().is_none_or(|b| distance < b.distance) {
                    best = Some(NearestShell {
                        distance,
                        shell: i,
                        point,
                    });
                }
            }
        }
    }
    Ok(best)
}

fn nearest_station(trace: &Trace, p: DVec3) -> usize {
    (0..trace.sections.len())
        .min_by(|&a, &b| {
            let d = |i: usize| trace.sections[i].centre.distance_squared(p);
            d(a).total_cmp(&d(b))
        })
        .unwrap_or(0)
}

/// The station of a trace that is about at the location.
pub(super) fn station_at(
    trace: &Trace,
    location: &StemLocation,
    surface_point: Option<DVec3>,
) -> usize {
    let station = match (location, surface_point) {
        (_, Some(p)) => nearest_station(trace, p),
        (StemLocation::Point(p), None) => nearest_station(trace, *p),
        (StemLocation::Fraction(x), _) => {
            (x.clamp(0.0, 1.0) * trace.sections.len() as f64) as usize
        }
        (StemLocation::Length(x), _) => {
            let mut left = *x;
            let steps = trace
                .sections
                .windows(2)
                .map(|w| w[0].centre.distance(w[1].centre));
            steps
                .take_while(|step| {
                    left -= step;
                    left > 0.0
                })
                .count()
        }
    };
    station.min(trace.sections.len() - 1)
}

/// Whether a surface point belongs to the trace rather than to another limb of the shell.
fn covers(trace: &Trace, q: DVec3) -> bool {
    let section: &ShellSection = &trace.sections[nearest_station(trace, q)];
    let d = q - section.centre;
    let across = d.reject_from(section.normal).length();
    across < 1.3 * section.reach && d.dot(section.normal).abs() < 1.2 * section.reach
}
