//! The broken end of a fibre bundle: a row of thorns along the ring, of which every other one stands on the other side of
//! the break (Yang et al. 2019 §3.3 has thorns; that both sides are the same faces is ours).

use super::complex::Complex;
use glam::{DVec2, DVec3};
use greenstick_wood::noise::unit;

/// Thorns and hollows of an end.
const THORNS: usize = 3;
/// Height of the lowest thorn and of the highest, in lengths of pull-out.
const HEIGHT: [f64; 2] = [0.5, 3.0];
/// How far thorns lie off even spacing, in parts of it.
const UNEVEN: f64 = 0.25;
/// Triangles smaller than this part of the bundle's section are none.
const LEAST: f64 = 0.02;

/// The end of a prism.
pub(super) struct Tips {
    /// Places within it, grain coordinates, m.
    pub places: Vec<DVec3>,
    /// Triangles, counter-clockwise from above: corners of the prism, and behind them the places; and which of them are
    /// smooth together.
    pub triangles: Vec<([usize; 3], u32)>,
}

impl Tips {
    /// A fan about the middle.
    pub fn flat(complex: &Complex, column: usize, station: usize) -> Self {
        let own = &complex.columns.columns[column];
        Tips::fan(
            own.corners.len(),
            own.centre.extend(mean(complex, column, station)),
        )
    }

    fn fan(n: usize, middle: DVec3) -> Self {
        Tips {
            places: vec![middle],
            triangles: (0..n).map(|k| ([k, (k + 1) % n, n], k as u32)).collect(),
        }
    }

    /// Thorns up to about `length` (m) high.
    pub fn torn(complex: &Complex, column: usize, station: usize, length: f64, seed: u64) -> Self {
        let own = &complex.columns.columns[column];
        let corners: Vec<DVec2> = (own.corners.iter())
            .map(|&c| complex.columns.corners[c as usize])
            .collect();
        let mean = mean(complex, column, station);
        let [down, up] = room(complex, column, station, mean);
        let first = unit(seed ^ 0x71d, column as i64, station as i64, 0) < 0.5;
        let height = |k: usize| {
            let random = |what: u64| unit(seed ^ what, column as i64, station as i64, k as i64);
            // Most are short.
            let share = random(0x71b) * random(0x71c);
            let height = length * (HEIGHT[0] + (HEIGHT[1] - HEIGHT[0]) * share);
            if first == k.is_multiple_of(2) {
                mean + height.min(up)
            } else {
                mean - height.min(down)
            }
        };
        let random = |k: usize| unit(seed ^ 0x71e, column as i64, station as i64, k as i64);
        let least = LEAST * own.area;
        rows(&corners, THORNS, random, least)
            .or_else(|| rows(&corners, 1, random, least))
            .map_or_else(
                || Tips::fan(corners.len(), own.centre.extend(height(0))),
                |(places, triangles)| Tips {
                    places: (places.iter().enumerate())
                        .map(|(k, p)| p.extend(height(k)))
                        .collect(),
                    triangles,
                },
            )
    }
}

/// Mean length along the axis of a column's corners at a station, m.
fn mean(complex: &Complex, column: usize, station: usize) -> f64 {
    let corners = &complex.columns.columns[column].corners;
    let lengths = corners.iter().map(|&c| complex.length(c, station));
    lengths.sum::<f64>() / corners.len() as f64
}

/// How far thorns may reach down and up: to a slab before the next break of the column, m.
fn room(complex: &Complex, column: usize, station: usize, mean: f64) -> [f64; 2] {
    let broken = |&s: &usize| !complex.is_whole(column, s);
    let ends = [
        (0..station).rev().find(broken),
        (station + 1..=complex.slabs()).find(broken),
    ];
    let slab = complex.stations[1] - complex.stations[0];
    ends.map(|end| {
        end.map_or(0.0, |s| {
            ((complex.stations[s] - mean).abs() - slab).max(0.0)
        })
    })
}

/// Places in a polygon, and triangles that it is parted in, each of one side of it.
type Rows = (Vec<DVec2>, Vec<([usize; 3], u32)>);

/// Parts a convex polygon in triangles with `count` places on the line between the two corners that lie farthest apart;
/// none where one would be smaller than `least` (m²).
fn rows(
    corners: &[DVec2],
    count: usize,
    random: impl Fn(usize) -> f64,
    least: f64,
) -> Option<Rows> {
    let n = corners.len();
    let pairs = (0..n).flat_map(|i| (i + 2..n).map(move |j| (i, j)));
    let (left, right) = pairs.filter(|&(i, j)| (j + 1) % n != i).max_by(|a, b| {
        let far = |p: &(usize, usize)| corners[p.0].distance_squared(corners[p.1]);
        far(a).total_cmp(&far(b))
    })?;
    let (from, to) = (corners[left], corners[right]);
    let place = |k: usize| {
        let off = UNEVEN * (2.0 * random(k) - 1.0);
        from.lerp(to, (k as f64 + 1.0 + off) / (count as f64 + 1.0))
    };
    let places: Vec<DVec2> = (0..count).map(place).collect();
    let at = |k: usize| if k < n { corners[k] } else { places[k - n] };
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
            if area.abs() < least {
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
    // They fill the polygon only where it is convex.
    ((sum - area).abs() < least).then_some((places, triangles))
}
