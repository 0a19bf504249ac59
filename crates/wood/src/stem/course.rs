//! Which shell of a scene is meant, and how its stem runs: as a log or as a board, and from which end.

use super::Place;
use super::build::StemKind;
use super::error::StemError;
use super::seed::{self, Plank};
use super::shells::{Points, Shell};
use super::surface::Surface;
use super::trace::{Trace, trace};
use glam::DVec3;
use greenstick_geometry::Context;

/// Shells tried as the main stem before giving up.
const TRIED: usize = 40;
/// Of those with a stem, so many are compared by volume.
const COMPARED: usize = 6;

/// The scene taken apart.
pub(super) struct Parts {
    pub points: Vec<Points>,
    pub shells: Vec<Shell>,
    /// Indices of the shells, largest first.
    pub order: Vec<usize>,
}

impl Parts {
    pub fn surface(&self, shell: usize) -> Surface<'_> {
        Surface::new(&self.points[self.shells[shell].node], &self.shells[shell])
    }
}

/// What a shell was followed as.
pub(super) enum Course {
    Log(Trace),
    Board(Plank),
}

/// A shell's main stem: a board where it is one or is said to be one, else a log; with its volume, m³.
pub(super) fn course(surface: &Surface, kind: Option<StemKind>) -> Option<(Course, f64)> {
    if kind != Some(StemKind::Round) {
        let plank = seed::plank(surface);
        let board = |p: &Plank| kind == Some(StemKind::Board) || seed::is_board(surface, p);
        if let Some(plank) = plank.filter(board) {
            return Some((Course::Board(plank), plank.size.iter().product()));
        }
    }
    let trace = seed::main_stem(surface)?;
    let volume = trace.volume();
    Some((Course::Log(trace), volume))
}

/// The shell with the thickest stem, its course, and no point.
pub(super) fn main_stem(
    parts: &Parts,
    kind: Option<StemKind>,
    context: &Context,
) -> Result<(usize, Course, Option<DVec3>), StemError> {
    let mut best: Option<(f64, usize, Course)> = None;
    let mut compared = 0;
    for &i in parts.order.iter().take(TRIED) {
        context.report(0.2)?;
        if parts.shells[i].triangles.len() < 6 {
            continue;
        }
        let Some((course, volume)) = course(&parts.surface(i), kind) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| volume > b.0) {
            best = Some((volume, i, course));
        }
        compared += 1;
        if compared >= COMPARED {
            break;
        }
    }
    best.map(|(_, i, course)| (i, course, None))
        .ok_or(StemError::NoStem {
            shells: parts.shells.len(),
        })
}

/// The shell nearest to a point, the limb of it there, and the nearest point on it.
pub(super) fn at_point(
    parts: &Parts,
    p: DVec3,
    place: &Place,
    kind: Option<StemKind>,
) -> Result<(usize, Course, Option<DVec3>), StemError> {
    let mut best: Option<(f64, usize, DVec3)> = None;
    for (i, shell) in parts.shells.iter().enumerate() {
        let bound = (shell.low - p)
            .max(p - shell.high)
            .max(DVec3::ZERO)
            .length();
        if best.is_some_and(|b| bound >= b.0) {
            continue;
        }
        let points = &parts.points[shell.node];
        for &t in &shell.triangles {
            let corners = points.triangles[t as usize].map(|c| points.positions[c as usize]);
            let q = super::surface::nearest_on_triangle(corners, p);
            let d = q.distance(p);
            if best.is_none_or(|b| d < b.0) {
                best = Some((d, i, q));
            }
        }
    }
    let Some((distance, i, q)) = best else {
        return Err(StemError::Empty);
    };
    let surface = parts.surface(i);
    let trace = match course(&surface, kind) {
        Some((Course::Board(plank), _)) => {
            let far = 1.5 * plank.size[1];
            if distance > far {
                let nearest = Place::Point(q);
                return Err(StemError::FarFromWood {
                    asked: *place,
                    distance,
                    nearest,
                });
            }
            return Ok((i, Course::Board(plank), Some(q)));
        }
        Some((Course::Log(trace), _)) if covers(&trace, q) => Some(trace),
        _ => seed::at_point(&surface, q).map(|cut| trace(&surface, cut, false)),
    };
    let Some(trace) = trace else {
        return Err(StemError::NowhereFree {
            asked: *place,
            found: "the nearest part of the model has no section that is one closed loop"
                .to_owned(),
        });
    };
    // Three radii of air around the wood are taken for a hand that was not quite steady.
    let radius = trace.cuts[nearest_station(&trace, q)].radius;
    let inside = surface.holds(p);
    if distance > 3.0 * radius && !inside {
        return Err(StemError::FarFromWood {
            asked: *place,
            distance,
            nearest: Place::Point(q),
        });
    }
    Ok((i, Course::Log(trace), Some(q)))
}

fn nearest_station(trace: &Trace, p: DVec3) -> usize {
    (0..trace.cuts.len())
        .min_by(|&a, &b| {
            let d = |i: usize| trace.cuts[i].centre.distance_squared(p);
            d(a).total_cmp(&d(b))
        })
        .unwrap_or(0)
}

/// The station of a trace that is about at the place.
pub(super) fn station_at(trace: &Trace, place: &Place, point: Option<DVec3>) -> usize {
    let station = match (place, point) {
        (_, Some(p)) => nearest_station(trace, p),
        (Place::Point(p), None) => nearest_station(trace, *p),
        (Place::Fraction(x), _) => (x.clamp(0.0, 1.0) * trace.cuts.len() as f64) as usize,
        (Place::Length(x), _) => {
            let mut left = *x;
            let steps = trace
                .cuts
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
    station.min(trace.cuts.len() - 1)
}

/// Whether a surface point belongs to the trace rather than to another limb of the shell.
fn covers(trace: &Trace, q: DVec3) -> bool {
    let cut = &trace.cuts[nearest_station(trace, q)];
    let d = q - cut.centre;
    let across = d.reject_from(cut.normal).length();
    across < 1.3 * cut.reach && d.dot(cut.normal).abs() < 1.2 * cut.reach
}

/// Whether the base is at the trace's last station.
pub(super) fn turned_over(course: &Course, tips: [DVec3; 2], held: [Option<usize>; 2]) -> bool {
    match held {
        [Some(_), None] => return false,
        [None, Some(_)] => return true,
        _ => {}
    }
    if let Course::Log(trace) = course {
        let areas: Vec<f64> = (0..trace.cuts.len())
            .filter(|&i| trace.states[i] == super::trace::State::Good)
            .map(|i| trace.cuts[i].area)
            .collect();
        let part = (areas.len() / 5).max(1).min(areas.len());
        let mean = |a: &[f64]| a.iter().sum::<f64>() / a.len().max(1) as f64;
        let (first, last) = (mean(&areas[..part]), mean(&areas[areas.len() - part..]));
        // Closer than this the ends are equally thick: noise must not decide.
        if (first - last).abs() > 0.05 * (first + last) {
            return last > first;
        }
    }
    let [a, b] = tips;
    let length = a.distance(b);
    for k in [1, 0, 2] {
        if (a[k] - b[k]).abs() > 1e-6 * length {
            return b[k] < a[k];
        }
    }
    false
}
