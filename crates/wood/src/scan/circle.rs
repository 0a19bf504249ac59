//! Circles through points of a section: random samples of three (Fischler and Bolles 1981), scored with a bounded loss
//! (Torr and Zisserman 2000), then refined by geometric least squares.

use crate::noise;
use glam::{DMat3, DVec2, DVec3};

/// A circle fitted to points of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub centre: DVec2,
    pub radius: f64,
    /// Share of the points that lie on it.
    pub share: f64,
    /// Root of the mean square of their distances from it, or from a form with lobes and flutes that follows it.
    pub rms: f64,
    /// Share of its girth that has points.
    pub coverage: f64,
    /// Points well inside it for each one on it: wood is solid, so that a scan shows none, whereas a crown is full of them.
    pub inside: f64,
    /// How unlikely it is that evenly scattered points would lie on any circle so well: the logarithm of one over the
    /// number of such circles that chance brings (Desolneux, Moisan and Morel 2000, Meaningful Alignments). At 0 one is to
    /// be expected.
    pub evidence: f64,
    /// The same of occupied cells instead of points: points that stand close together count once.
    pub cell_evidence: f64,
}

/// What is known of the circle beforehand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Expected {
    pub min_radius: f64,
    pub max_radius: f64,
    pub prior: Option<Prior>,
}

/// A circle that is about where it was before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub centre: DVec2,
    pub radius: f64,
    /// How far the centre may be from there.
    pub max_offset: f64,
}

/// Samples of three points.
const SAMPLES: i64 = 150;
/// Most points that score a sample.
const MAX_SCORED: usize = 240;
/// Rounds of least squares.
const REFINEMENTS: usize = 8;
/// Distance from the circle, in radii, up to which a point lies on it: bark furrows and buttresses included.
const ON_CIRCLE_RADII: f64 = 0.15;
/// Distance within the circle, in radii, from which on a point is well inside.
const INSIDE_RADII: f64 = 0.3;
/// Sectors in which the covered girth is counted.
const SECTORS: usize = 24;

/// The circle that most of the points lie on.
pub(super) fn fit(points: &[DVec2], expected: &Expected, seed: u64) -> Option<Circle> {
    let count = points.len();
    if count < 6 {
        return None;
    }
    let stride = count.div_ceil(MAX_SCORED);
    let scored: Vec<DVec2> = points.iter().step_by(stride).copied().collect();
    let allowed = |centre: DVec2, radius: f64| {
        (expected.min_radius..=expected.max_radius).contains(&radius)
            && expected
                .prior
                .is_none_or(|p| p.centre.distance(centre) <= p.max_offset)
    };
    let mut best: Option<(f64, DVec2, f64)> = None;
    let mut consider = |centre: DVec2, radius: f64| {
        if !allowed(centre, radius) {
            return;
        }
        let tolerance = ON_CIRCLE_RADII * expected.prior.map_or(radius, |p| p.radius);
        let loss: f64 = scored
            .iter()
            .map(|p| ((p.distance(centre) - radius) / tolerance).powi(2).min(1.0))
            .sum();
        if best.is_none_or(|b| loss < b.0) {
            best = Some((loss, centre, radius));
        }
    };
    if let Some(prior) = expected.prior {
        consider(prior.centre, prior.radius);
    }
    for k in 0..SAMPLES {
        let pick = |n: i64| points[(noise::unit(seed, k, n, 0) * count as f64) as usize % count];
        if let Some((centre, radius)) = circle_through(pick(0), pick(1), pick(2)) {
            consider(centre, radius);
        }
    }
    let (_, mut centre, mut radius) = best?;
    for _ in 0..REFINEMENTS {
        (centre, radius) = refine(points, centre, radius, expected)?;
    }
    allowed(centre, radius).then(|| judge(points, centre, radius))
}

/// Half the widths of bands about a circle, in radii, that are tried to judge it.
const BANDS: [f64; 4] = [0.15, 0.08, 0.04, 0.02];
/// Radii about a circle's middle within which points are compared with those on it.
const COMPARED_RADII: f64 = 2.0;
/// Side of the cells, in radii, of whose points one counts as evidence.
const CELL_RADII: f64 = 0.12;

/// Distances from the middle in radii, one for each occupied cell: points that stand close together, as those of a twig
/// do, were not scattered one by one, and count once.
fn cell_distances(points: &[DVec2], centre: DVec2, radius: f64) -> Vec<f64> {
    let mut cells: Vec<((i64, i64), f64)> = points
        .iter()
        .map(|p| {
            let d = (*p - centre) / radius;
            let cell = (d / CELL_RADII).floor();
            ((cell.x as i64, cell.y as i64), d.length())
        })
        .filter(|cell| cell.1 < COMPARED_RADII)
        .collect();
    cells.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // The middle one of a cell's points stands for all of them.
    cells
        .chunk_by(|a, b| a.0 == b.0)
        .map(|cell| cell[cell.len() / 2].1)
        .collect()
}

/// The evidence of a circle from its points' distances to the middle in radii. `count` points choose it, three by three.
fn evidence(distances: &[f64], count: usize) -> f64 {
    let compared = distances.iter().filter(|d| **d < COMPARED_RADII).count() as f64;
    if compared < 1.0 {
        return f64::NEG_INFINITY;
    }
    let unlikeliness = |band: f64| {
        let on = distances.iter().filter(|d| (**d - 1.0).abs() < band);
        let share = on.count() as f64 / compared;
        let chance = 4.0 * band / (COMPARED_RADII * COMPARED_RADII);
        if share <= chance {
            return 0.0;
        }
        // Hoeffding's bound of the binomial's tail.
        let rest = if share < 1.0 {
            (1.0 - share) * libm::log((1.0 - share) / (1.0 - chance))
        } else {
            0.0
        };
        compared * (share * libm::log(share / chance) + rest)
    };
    let best = BANDS.map(unlikeliness).into_iter().fold(0.0, f64::max);
    let tests = 3.0 * libm::log(count.max(2) as f64) + libm::log(BANDS.len() as f64);
    best - tests
}

/// Centre and radius of the circle through three points.
fn circle_through(a: DVec2, b: DVec2, c: DVec2) -> Option<(DVec2, f64)> {
    let (u, v) = (b - a, c - a);
    let d = 2.0 * u.perp_dot(v);
    let size = u.length_squared().max(v.length_squared());
    if d.abs() <= 1e-6 * size {
        return None;
    }
    let (uu, vv) = (u.length_squared(), v.length_squared());
    let offset = DVec2::new(v.y * uu - u.y * vv, u.x * vv - v.x * uu) / d;
    Some((a + offset, offset.length()))
}

/// The sector of the direction `d`.
fn sector(d: DVec2) -> usize {
    let turn = libm::atan2(d.y, d.x) / std::f64::consts::TAU + 0.5;
    ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// Weight of the prior against a whole girth: it keeps a short arc from running away.
const PRIOR_WEIGHT: f64 = 0.3;

/// One Gauss–Newton step. Each sector weighs the same, so that a side seen by two scanners does not pull.
fn refine(
    points: &[DVec2],
    centre: DVec2,
    radius: f64,
    expected: &Expected,
) -> Option<(DVec2, f64)> {
    let tolerance = ON_CIRCLE_RADII * radius;
    let on = |p: &&DVec2| (p.distance(centre) - radius).abs() < tolerance;
    let mut counts = [0.0; SECTORS];
    points
        .iter()
        .filter(on)
        .for_each(|p| counts[sector(*p - centre)] += 1.0);
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for p in points.iter().filter(on) {
        let d = *p - centre;
        let length = d.length();
        let Some(u) = d.try_normalize() else { continue };
        let row = DVec3::new(u.x, u.y, 1.0);
        let weight = 1.0 / counts[sector(d)];
        matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z) * weight;
        right += row * ((length - radius) * weight);
    }
    if let Some(prior) = expected.prior {
        matrix += DMat3::from_diagonal(DVec3::splat(PRIOR_WEIGHT));
        right += (prior.centre - centre).extend(prior.radius - radius) * PRIOR_WEIGHT;
    }
    if matrix.determinant().abs() < 1e-9 {
        return None;
    }
    let step = matrix.inverse() * right;
    let (centre, radius) = (centre + step.truncate(), radius + step.z);
    (centre.is_finite() && radius > 0.0).then_some((centre, radius))
}

/// Points from which on a fluted form can be distinguished from scattered points.
const MIN_FLUTED_POINTS: usize = 100;

/// Standard deviation of points, in radii, from whatever smooth form they lie on: each against the mean of those beside
/// it by angle, which needs no model of the form (Gasser, Sroka and Jennen-Steinmetz 1986). Evenly scattered points have
/// 0.17.
fn deviation_from_any_form(points: &[DVec2], centre: DVec2, radius: f64) -> Option<f64> {
    let mut polar: Vec<(f64, f64)> = points
        .iter()
        .map(|p| *p - centre)
        .map(|d| (libm::atan2(d.y, d.x), d.length() / radius - 1.0))
        .filter(|d| d.1.abs() < INSIDE_RADII)
        .collect();
    let count = polar.len();
    if count < MIN_FLUTED_POINTS {
        return None;
    }
    polar.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let off = |i: usize| polar[i % count].1;
    let squares: f64 = (0..count)
        .map(|i| off(i + 1) - 0.5 * (off(i) + off(i + 2)))
        .map(|e| e * e)
        .sum();
    Some((squares / (1.5 * count as f64)).sqrt())
}

/// How well the points lie on a circle.
fn judge(points: &[DVec2], centre: DVec2, radius: f64) -> Circle {
    let (mut on, mut squares, mut seen) = (0usize, 0.0, [false; SECTORS]);
    let mut inside = 0usize;
    let distances: Vec<f64> = points.iter().map(|p| p.distance(centre) / radius).collect();
    for (p, distance) in points.iter().zip(&distances) {
        let off = (distance - 1.0) * radius;
        inside += usize::from(off < -INSIDE_RADII * radius);
        if off.abs() < ON_CIRCLE_RADII * radius {
            on += 1;
            squares += off * off;
            seen[sector(*p - centre)] = true;
        }
    }
    let rms = (squares / on.max(1) as f64).sqrt();
    let deviation = deviation_from_any_form(points, centre, radius);
    let rms_from_form = deviation.map_or(rms, |off| off * radius);
    Circle {
        centre,
        radius,
        share: on as f64 / points.len() as f64,
        rms: rms.min(rms_from_form),
        inside: inside as f64 / on.max(1) as f64,
        evidence: evidence(&distances, points.len()),
        cell_evidence: evidence(&cell_distances(points, centre, radius), points.len()),
        coverage: seen.iter().filter(|s| **s).count() as f64 / SECTORS as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_found_among_scattered_points() {
        let centre = DVec2::new(2.0, -1.0);
        let mut points: Vec<DVec2> = (0..300)
            .map(|i| {
                let angle = std::f64::consts::TAU * noise::unit(1, i, 0, 0);
                let radius = 0.5 + 0.01 * (noise::unit(2, i, 0, 0) - 0.5);
                centre + radius * DVec2::new(libm::cos(angle), libm::sin(angle))
            })
            .collect();
        points.extend((0..200).map(|i| {
            let [x, y] = [3, 4].map(|n| 4.0 * noise::unit(n, i, 0, 0) - 2.0);
            centre + DVec2::new(x, y)
        }));
        let expected = Expected {
            min_radius: 0.1,
            max_radius: 2.0,
            prior: None,
        };
        let circle = fit(&points, &expected, 7).unwrap();
        assert!(circle.centre.distance(centre) < 0.01, "{circle:?}");
        assert!((circle.radius - 0.5).abs() < 0.01 && circle.coverage == 1.0);
        assert!(circle.share > 0.55 && circle.share < 0.8);
    }
}
