//! Closed sections of a shell by a plane, and the plane that is square to the stem.

use super::surface::Surface;
use crate::polygon;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Loops of less area than this, relative to the square of their reach, are slivers: the plane grazes a flat face.
const SLIVER: f64 = 1e-6;
/// Rounds in which the plane is turned, and the turn (as the chord of a unit circle) below which it is square.
const ALIGNMENT_ROUNDS: usize = 10;
const ALIGNED: f64 = 0.01;
/// The last turn may be this large at most, or the plane does not settle.
const MAX_LAST_TURN: f64 = 0.2;

/// A closed section of a shell.
#[derive(Debug, Clone)]
pub(crate) struct ShellSection {
    /// Centroid, m.
    pub centre: DVec3,
    pub normal: DVec3,
    /// Area, m².
    pub area: f64,
    /// Radius of the circle of equal area, m.
    pub radius: f64,
    /// Largest distance of the outline from the centroid, m.
    pub reach: f64,
    /// Number of other closed loops of some size close by.
    pub nearby_loops: usize,
    /// The outline, m.
    pub points: Vec<DVec3>,
    /// Triangles that it runs over.
    pub triangles: Vec<u32>,
}

/// Two unit vectors square to `normal` and to each other.
pub(crate) fn across(normal: DVec3) -> (DVec3, DVec3) {
    let x = normal.any_orthonormal_vector();
    (x, normal.cross(x))
}

/// The closed loops of one plane.
pub(crate) struct ClosedLoops {
    /// The largest first.
    pub sections: Vec<ShellSection>,
    /// Index of the largest that contains the plane's origin, else of the one whose outline is nearest to it.
    pub chosen: Option<usize>,
}

/// Finds the closed loops in which the plane through `origin` cuts the shell.
pub(crate) fn closed_loops(surface: &Surface, origin: DVec3, normal: DVec3) -> ClosedLoops {
    struct Candidate {
        section: ShellSection,
        contains_origin: bool,
        distance: f64,
    }
    let (x, y) = across(normal);
    let mut candidates: Vec<Candidate> = Vec::new();
    for line in surface.slice(origin, normal) {
        if !line.closed || line.points.len() < 3 {
            continue;
        }
        let flat: Vec<DVec2> = line
            .points
            .iter()
            .map(|&p| DVec2::new((p - origin).dot(x), (p - origin).dot(y)))
            .collect();
        let (area, centroid) = polygon::area_and_centroid(&flat);
        let distance_to_centroid = |p: &DVec2| p.distance(centroid);
        let reach = flat.iter().map(distance_to_centroid).fold(0.0, f64::max);
        if area.abs() <= SLIVER * reach * reach {
            continue;
        }
        let contains_origin = polygon::contains(&flat, DVec2::ZERO);
        let distance = if contains_origin {
            0.0
        } else {
            polygon::distance(&flat, DVec2::ZERO)
        };
        candidates.push(Candidate {
            section: ShellSection {
                centre: origin + x * centroid.x + y * centroid.y,
                normal,
                area: area.abs(),
                radius: (area.abs() / PI).sqrt(),
                reach,
                nearby_loops: 0,
                points: line.points,
                triangles: line.triangles,
            },
            contains_origin,
            distance,
        });
    }
    candidates.sort_by(|a, b| b.section.area.total_cmp(&a.section.area));
    let nearest = || {
        let distance = |i: usize| candidates[i].distance;
        (0..candidates.len()).min_by(|&i, &j| distance(i).total_cmp(&distance(j)).then(i.cmp(&j)))
    };
    let chosen = candidates
        .iter()
        .position(|c| c.contains_origin)
        .or_else(nearest);
    ClosedLoops {
        sections: candidates.into_iter().map(|c| c.section).collect(),
        chosen,
    }
}

/// The section at or nearest to `origin`, its outline at most `limit` (m) away.
pub(crate) fn section(
    surface: &Surface,
    origin: DVec3,
    normal: DVec3,
    limit: f64,
) -> Option<ShellSection> {
    let ClosedLoops {
        mut sections,
        chosen,
    } = closed_loops(surface, origin, normal);
    let index = chosen?;
    let chosen = &sections[index];
    let distance = chosen
        .points
        .iter()
        .map(|p| p.distance(origin))
        .fold(f64::INFINITY, f64::min);
    let inside = chosen.centre.distance(origin) <= chosen.reach;
    if !inside && distance > limit {
        return None;
    }
    let nearby_loops = sections
        .iter()
        .enumerate()
        .filter(|(i, c)| {
            let gap = c.centre.distance(chosen.centre) - c.reach - chosen.reach;
            *i != index
                && c.area > 0.1 * chosen.area
                && gap < chosen.radius.max(c.radius)
                && c.centre.distance(chosen.centre) > 0.5 * chosen.radius
        })
        .count();
    let mut section = sections.swap_remove(index);
    section.nearby_loops = nearby_loops;
    Some(section)
}

/// Turns the plane through `origin` until its normal is the local direction of the stem: the centroids of the two
/// parallel sections before and behind lie on the axis even where the plane is tilted. `None` where the direction does
/// not converge.
pub(crate) fn aligned_section(
    surface: &Surface,
    origin: DVec3,
    direction: DVec3,
) -> Option<ShellSection> {
    let mut direction = direction.try_normalize()?;
    let mut cut = section(surface, origin, direction, f64::INFINITY)?;
    let mut turn = f64::INFINITY;
    let max_step = stump_step(surface, &cut).unwrap_or(f64::INFINITY);
    for _ in 0..ALIGNMENT_ROUNDS {
        let limit = 2.0 * cut.reach;
        let (mut before, mut behind) = (None, None);
        let mut h = (0.5 * cut.radius).min(max_step);
        for _ in 0..3 {
            let fits = |c: &ShellSection| c.area < 1.7 * cut.area && c.area > 0.55 * cut.area;
            before = section(surface, cut.centre + direction * h, direction, limit).filter(fits);
            behind = section(surface, cut.centre - direction * h, direction, limit).filter(fits);
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
        cut = section(surface, cut.centre, direction, limit)?;
        if turn < ALIGNED {
            break;
        }
    }
    (turn < MAX_LAST_TURN).then_some(cut)
}

/// Sections over the height of a stump.
const STUMP_STEPS: f64 = 24.0;

/// The step (m) between sections of a stump: a shell that is lower than its section is wide. `None` for other shells.
pub(crate) fn stump_step(surface: &Surface, section: &ShellSection) -> Option<f64> {
    let height = surface.shortest_side();
    let is_stump = height < 1.9 * section.radius && height > 0.5 * section.radius;
    is_stump.then_some(height / STUMP_STEPS)
}
