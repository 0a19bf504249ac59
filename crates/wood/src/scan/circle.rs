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
    /// Standard error of the radius from the residual and the coverage.
    pub radius_error: f64,
    /// Share of its girth that has points.
    pub coverage: f64,
    /// Points well inside it for each one on it: wood is solid, so that a scan shows none, whereas a crown is full of them.
    pub inside: f64,
    /// How unlikely it is that evenly scattered points would lie on any circle so well: the logarithm of one over the
    /// number of such circles that chance brings (Desolneux, Moisan and Morel 2000, Meaningful Alignments). At 0 one is to
    /// be expected.
    pub evidence: f64,
    /// What one point adds to the evidence on average, in nats: it does not depend on how many there are.
    pub information: f64,
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
/// Points after which a sample with too great a loss is given up.
const SCORED_AT_ONCE: usize = 16;
/// Most points that a circle is fitted to.
const MAX_FITTED: usize = 600;
/// Most rounds of least squares, and the step, in radii, below which they have converged.
const REFINEMENTS: usize = 20;
const CONVERGED: f64 = 1e-5;
/// Guesses with the least loss that are refined.
const REFINED: usize = 2;
/// Distance from the circle, in radii, up to which a point lies on it: bark furrows and buttresses included.
const ON_CIRCLE_RADII: f64 = 0.15;
/// Distance within the circle, in radii, from which on a point is well inside.
const INSIDE_RADII: f64 = 0.3;
/// Sectors in which the covered girth is counted.
const SECTORS: usize = 24;

/// The circle that most of the points lie on. They come in a random order: the first of many stand for all.
pub(super) fn fit(points: &[DVec2], expected: &Expected, seed: u64) -> Option<Circle> {
    let count = points.len();
    if count < 6 {
        return None;
    }
    let scored = &points[..count.min(MAX_SCORED)];
    // `None` as soon as the loss exceeds what is allowed.
    let loss = |centre: DVec2, radius: f64, most: f64| -> Option<f64> {
        let tolerance = ON_CIRCLE_RADII * expected.prior.map_or(radius, |p| p.radius);
        let mut sum = 0.0;
        for few in scored.chunks(SCORED_AT_ONCE) {
            for p in few {
                let off = (p.distance(centre) - radius) / tolerance;
                sum += (off * off).min(1.0);
            }
            if sum > most {
                return None;
            }
        }
        Some(sum)
    };
    // Ascending by loss, no more than are refined.
    let mut tried: Vec<(f64, DVec2, f64)> = Vec::with_capacity(REFINED + 1);
    let mut consider = |centre: DVec2, radius: f64| {
        if !expected.allows(centre, radius) {
            return;
        }
        let most = tried.get(REFINED - 1).map_or(f64::INFINITY, |t| t.0);
        if let Some(loss) = loss(centre, radius, most) {
            let place = tried.partition_point(|t| t.0 <= loss);
            tried.insert(place, (loss, centre, radius));
            tried.truncate(REFINED);
        }
    };
    match expected.prior {
        Some(prior) => prior
            .guesses()
            .for_each(|(centre, radius)| consider(centre, radius)),
        None => (0..SAMPLES).for_each(|k| {
            let pick =
                |n: i64| points[(noise::unit(seed, k, n, 0) * count as f64) as usize % count];
            if let Some((centre, radius)) = circle_through(pick(0), pick(1), pick(2)) {
                consider(centre, radius);
            }
        }),
    }
    let fitted = &points[..count.min(MAX_FITTED)];
    let refined = tried
        .into_iter()
        .filter_map(|(_, centre, radius)| refined(fitted, centre, radius, expected))
        .filter(|(centre, radius)| expected.allows(*centre, *radius));
    let (_, centre, radius) = refined
        .filter_map(|(centre, radius)| Some((loss(centre, radius, f64::INFINITY)?, centre, radius)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(judge(points, centre, radius, expected.prior.is_none()))
}

impl Expected {
    fn allows(&self, centre: DVec2, radius: f64) -> bool {
        (self.min_radius..=self.max_radius).contains(&radius)
            && self
                .prior
                .is_none_or(|p| p.centre.distance(centre) <= p.max_offset)
    }
}

impl Prior {
    /// Circles about the expected one, so close that one of them leads to the best.
    fn guesses(self) -> impl Iterator<Item = (DVec2, f64)> {
        const DIRECTIONS: usize = 8;
        let offsets = [0.0, 0.3].into_iter().flat_map(move |offset| {
            let count = if offset > 0.0 { DIRECTIONS } else { 1 };
            (0..count).map(move |j| {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * j as f64 / DIRECTIONS as f64);
                self.centre + DVec2::new(cos, sin) * (offset * self.radius)
            })
        });
        offsets
            .flat_map(move |centre| [1.0, 0.85, 1.15].map(|factor| (centre, factor * self.radius)))
    }
}

/// The circle that least squares converge to from a guess.
fn refined(
    points: &[DVec2],
    mut centre: DVec2,
    mut radius: f64,
    expected: &Expected,
) -> Option<(DVec2, f64)> {
    // As seen from the guess: the middle moves little.
    let near: Vec<(DVec2, usize)> = points
        .iter()
        .filter(|p| (p.distance(centre) - radius).abs() < 3.0 * ON_CIRCLE_RADII * radius)
        .map(|p| (*p, sector(*p - centre)))
        .collect();
    for _ in 0..REFINEMENTS {
        let last = (centre, radius);
        (centre, radius) = refine(&near, centre, radius, expected)?;
        if centre.distance(last.0) + (radius - last.1).abs() < CONVERGED * radius {
            break;
        }
    }
    Some((centre, radius))
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
    let tests = 3.0 * libm::log(count.max(2) as f64) + libm::log(BANDS.len() as f64);
    unlikeliness(distances).0 - tests
}

/// Logarithm of one over the chance that so many evenly scattered points lie on the circle, and the number of points
/// compared.
fn unlikeliness(distances: &[f64]) -> (f64, f64) {
    let compared = distances.iter().filter(|d| **d < COMPARED_RADII).count() as f64;
    if compared < 1.0 {
        return (0.0, 1.0);
    }
    let of_band = |band: f64| {
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
    (BANDS.map(of_band).into_iter().fold(0.0, f64::max), compared)
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

/// The sector of the direction `d` among equal ones.
pub(super) fn sector_of(d: DVec2, sectors: usize) -> usize {
    let turn = libm::atan2(d.y, d.x) / std::f64::consts::TAU + 0.5;
    ((turn * sectors as f64) as usize).min(sectors - 1)
}

fn sector(d: DVec2) -> usize {
    sector_of(d, SECTORS)
}

/// Weight of the prior against a whole girth: it keeps a short arc from running away.
const PRIOR_WEIGHT: f64 = 0.3;

/// Tukey's weight of a residual relative to the greatest one that counts: points come and go without a jump.
fn biweight(x: f64) -> f64 {
    (1.0 - x * x).max(0.0).powi(2)
}

/// One Gauss–Newton step. Each sector weighs the same, so that a side seen by two scanners does not pull.
fn refine(
    points: &[(DVec2, usize)],
    centre: DVec2,
    radius: f64,
    expected: &Expected,
) -> Option<(DVec2, f64)> {
    let tolerance = ON_CIRCLE_RADII * radius;
    let mut sums = [(DMat3::ZERO, DVec3::ZERO, 0.0); SECTORS];
    for (p, sector) in points {
        let d = *p - centre;
        let length = d.length();
        let off = length - radius;
        if off.abs() >= tolerance || length <= 0.0 {
            continue;
        }
        let weight = biweight(off / tolerance);
        let row = (d / length).extend(1.0);
        let sum = &mut sums[*sector];
        sum.0 += DMat3::from_cols(row * row.x, row * row.y, row * row.z) * weight;
        sum.1 += row * (off * weight);
        sum.2 += weight;
    }
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (m, r, weight) in sums.into_iter().filter(|s| s.2 > 0.0) {
        matrix += m * (1.0 / weight);
        right += r / weight;
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

/// Standard error of the radius: each sector is one observation, as bark and form are alike within it, and its mean residual
/// is what the circle does not explain. An arc that is seen in part leaves the radius open by as much as the normal matrix
/// of the fit says.
fn radius_error(points: &[DVec2], centre: DVec2, radius: f64) -> f64 {
    let mut sums = [(0.0, 0.0); SECTORS];
    for d in points.iter().map(|p| *p - centre) {
        let off = d.length() - radius;
        if off.abs() < ON_CIRCLE_RADII * radius {
            let sum = &mut sums[sector(d)];
            *sum = (sum.0 + off, sum.1 + 1.0);
        }
    }
    let (mut matrix, mut squares, mut seen) = (DMat3::ZERO, 0.0, 0.0);
    for (k, (sum, count)) in sums.into_iter().enumerate().filter(|s| s.1.1 > 0.0) {
        let angle = std::f64::consts::TAU * ((k as f64 + 0.5) / SECTORS as f64 - 0.5);
        let (sin, cos) = libm::sincos(angle);
        let row = DVec3::new(cos, sin, 1.0);
        matrix += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        squares += (sum / count).powi(2);
        seen += 1.0;
    }
    let variance = squares / f64::max(seen - 3.0, 1.0);
    let factor = if matrix.determinant() > 1e-9 {
        matrix.inverse().z_axis.z
    } else {
        f64::INFINITY
    };
    (variance * factor).sqrt().min(radius)
}

/// How well the points lie on a circle, or with `any_form` on a form with lobes that follows it.
fn judge(points: &[DVec2], centre: DVec2, radius: f64, any_form: bool) -> Circle {
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
    let deviation = any_form.then(|| deviation_from_any_form(points, centre, radius));
    let rms_from_form = deviation.flatten().map_or(rms, |off| off * radius);
    let (sum, compared) = unlikeliness(&distances);
    Circle {
        centre,
        radius,
        information: sum / compared,
        share: on as f64 / points.len() as f64,
        rms: rms.min(rms_from_form),
        radius_error: radius_error(points, centre, radius),
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
