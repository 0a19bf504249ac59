//! The broken end of a fibre bundle: a row of thorns along the ring. Every other one stands on the other side of the break
//! (thorns: Yang et al. 2019 §3.3; that both sides are the same faces is our addition).

use super::prisms::PrismComplex;
use glam::{DVec2, DVec3};
use greenstick_wood::noise::unit;

/// Number of thorns and hollows of an end.
const THORN_COUNT: usize = 3;
/// Heights of the lowest and the highest thorn, in lengths of pull-out.
const THORN_HEIGHT: [f64; 2] = [0.5, 3.0];
/// Greatest deviation of thorns from even spacing, as part of it.
const UNEVENNESS: f64 = 0.25;
/// Least area of a triangle, as part of the bundle's section.
const MIN_TRIANGLE_SHARE: f64 = 0.02;

/// The end of a prism.
pub(super) struct BrokenEnd {
    /// Points inside the end, grain coordinates, m.
    pub points: Vec<DVec3>,
    /// Triangles, counter-clockwise as seen from above, each with the number of its smooth side. They index the corners of
    /// the prism followed by `points`.
    pub triangles: Vec<([usize; 3], u32)>,
}

impl BrokenEnd {
    /// Returns a fan about the middle.
    pub fn flat(complex: &PrismComplex, column: usize, station: usize) -> Self {
        let own = &complex.columns.columns[column];
        BrokenEnd::fan(
            own.corners.len(),
            own.centre.extend(mean_length(complex, column, station)),
        )
    }

    fn fan(n: usize, middle: DVec3) -> Self {
        BrokenEnd {
            points: vec![middle],
            triangles: (0..n).map(|k| ([k, (k + 1) % n, n], k as u32)).collect(),
        }
    }

    /// Returns an end with thorns up to about `length` (m) high.
    pub fn with_thorns(
        complex: &PrismComplex,
        column: usize,
        station: usize,
        length: f64,
        seed: u64,
    ) -> Self {
        let own = &complex.columns.columns[column];
        let corners: Vec<DVec2> = (own.corners.iter())
            .map(|&c| complex.columns.corners[c as usize])
            .collect();
        let mean = mean_length(complex, column, station);
        let [down, up] = clearance(complex, column, station, mean);
        let even_up = unit(seed ^ 0x71d, column as i64, station as i64, 0) < 0.5;
        let height = |k: usize| {
            let random = |what: u64| unit(seed ^ what, column as i64, station as i64, k as i64);
            // Most are short.
            let share = random(0x71b) * random(0x71c);
            let height = length * (THORN_HEIGHT[0] + (THORN_HEIGHT[1] - THORN_HEIGHT[0]) * share);
            if even_up == k.is_multiple_of(2) {
                mean + height.min(up)
            } else {
                mean - height.min(down)
            }
        };
        let random = |k: usize| unit(seed ^ 0x71e, column as i64, station as i64, k as i64);
        let min_area = MIN_TRIANGLE_SHARE * own.area;
        thorn_row(&corners, THORN_COUNT, random, min_area)
            .or_else(|| thorn_row(&corners, 1, random, min_area))
            .map_or_else(
                || BrokenEnd::fan(corners.len(), own.centre.extend(height(0))),
                |ThornRow { points, triangles }| BrokenEnd {
                    points: (points.iter().enumerate())
                        .map(|(k, p)| p.extend(height(k)))
                        .collect(),
                    triangles,
                },
            )
    }
}

/// Returns the mean length along the axis of a column's corners at a station, m.
fn mean_length(complex: &PrismComplex, column: usize, station: usize) -> f64 {
    let corners = &complex.columns.columns[column].corners;
    let lengths = corners.iter().map(|&c| complex.length(c, station));
    lengths.sum::<f64>() / corners.len() as f64
}

/// Returns how far thorns may reach down and up, m: to one slab before the next break of the column.
fn clearance(complex: &PrismComplex, column: usize, station: usize, mean: f64) -> [f64; 2] {
    let is_broken = |&s: &usize| !complex.is_whole(column, s);
    let ends = [
        (0..station).rev().find(is_broken),
        (station + 1..=complex.slabs()).find(is_broken),
    ];
    let slab = complex.stations[1] - complex.stations[0];
    ends.map(|end| {
        end.map_or(0.0, |s| {
            ((complex.stations[s] - mean).abs() - slab).max(0.0)
        })
    })
}

/// A row of points in a polygon, and the triangles that split it, each with the number of its side of the row.
struct ThornRow {
    points: Vec<DVec2>,
    triangles: Vec<([usize; 3], u32)>,
}

/// Splits a convex polygon into triangles with `count` points on the line between the two corners that are farthest apart.
/// Returns `None` where a triangle would be smaller than `min_area` (m²).
fn thorn_row(
    corners: &[DVec2],
    count: usize,
    random: impl Fn(usize) -> f64,
    min_area: f64,
) -> Option<ThornRow> {
    let n = corners.len();
    let pairs = (0..n).flat_map(|i| (i + 2..n).map(move |j| (i, j)));
    let (left, right) = pairs.filter(|&(i, j)| (j + 1) % n != i).max_by(|a, b| {
        let distance = |p: &(usize, usize)| corners[p.0].distance_squared(corners[p.1]);
        distance(a).total_cmp(&distance(b))
    })?;
    let (from, to) = (corners[left], corners[right]);
    let point = |k: usize| {
        let off = UNEVENNESS * (2.0 * random(k) - 1.0);
        from.lerp(to, (k as f64 + 1.0 + off) / (count as f64 + 1.0))
    };
    let points: Vec<DVec2> = (0..count).map(point).collect();
    let at = |k: usize| if k < n { corners[k] } else { points[k - n] };
    let along = |k: usize| (at(k) - from).dot(to - from);
    let base: Vec<usize> = std::iter::once(left)
        .chain(n..n + count)
        .chain(std::iter::once(right))
        .collect();
    // The corners of one side from left to right, and those of the other.
    let chains = [
        (left + 1..right).collect::<Vec<_>>(),
        (right + 1..n + left).rev().map(|k| k % n).collect(),
    ];
    let mut triangles = Vec::with_capacity(n + 2 * count);
    for (side, chain) in chains.into_iter().enumerate() {
        let (mut i, mut j) = (0, 0);
        loop {
            let onward = chain.get(i + 1).copied();
            let next = base.get(j + 1).copied();
            let triangle = match (onward, next) {
                (Some(u), Some(b)) if along(u) < along(b) => {
                    i += 1;
                    [chain[i - 1], u, base[j]]
                }
                (_, Some(b)) => {
                    j += 1;
                    [base[j - 1], b, chain[i]]
                }
                (Some(u), None) => {
                    i += 1;
                    [chain[i - 1], u, base[j]]
                }
                (None, None) => break,
            };
            let [a, b, c] = triangle.map(at);
            let area = 0.5 * (b - a).perp_dot(c - a);
            let [a, b, c] = triangle;
            let around = if area < 0.0 { [b, a, c] } else { triangle };
            triangles.push((around, side as u32));
            if area.abs() < min_area {
                return None;
            }
        }
    }
    let sum: f64 = triangles
        .iter()
        .map(|(t, _)| {
            let [a, b, c] = t.map(at);
            0.5 * (b - a).perp_dot(c - a)
        })
        .sum();
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let area = 0.5 * sides.map(|(a, b)| a.perp_dot(*b)).sum::<f64>();
    // The triangles fill the polygon only where it is convex.
    ((sum - area).abs() < min_area).then_some(ThornRow { points, triangles })
}
