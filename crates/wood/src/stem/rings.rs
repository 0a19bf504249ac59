//! The rings of the section at the break: ring coordinate and angle of every point, and back (`model.md` §1).
//!
//! In a round stem ρ = 1 is the outline and rings lose the outline's shape inwards, the finer its waves the sooner:
//! wave k of the radius r(φ) is weakened by ρ to the power p(k−1). In a board rings are arcs about the pith and ρ is
//! the distance from it over the largest one in the section.

use super::polygon;
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Directions of the table.
const ANGLES: usize = 512;
/// Steps of ρ in the table.
const LEVELS: usize = 32;
/// Waves around the outline that are weakened one by one; finer ones vanish with the last.
const WAVES: usize = 24;
/// The exponent p above. Smaller keeps the outline's shape deeper inside.
const FADING: f64 = 0.5;
/// Rings are nowhere closer than this, relative to even spacing along the ray.
const CLOSEST: f64 = 0.25;

/// Ring coordinate and angle in a section, in its grain coordinates (x, y).
#[derive(Debug, Clone, PartialEq)]
pub struct RingField {
    pith: DVec2,
    extent: f64,
    shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// Circles about the pith; radius of ρ = 1, m.
    Arcs(f64),
    /// Radius (m) of ring `level`/LEVELS at angle −π + τ·`angle`/ANGLES, as `table[angle * (LEVELS + 1) + level]`.
    Table(Vec<f64>),
}

impl RingField {
    /// Rings of a round stem: `outline` (closed, m) about `pith`, which must lie inside it.
    pub(crate) fn round(outline: &[DVec2], pith: DVec2, extent: f64) -> Self {
        let mut outer: Vec<Option<f64>> = vec![None; ANGLES];
        for (j, radius) in outer.iter_mut().enumerate() {
            let (sin, cos) = libm::sincos(angle_of(j));
            *radius = polygon::farthest_crossing(outline, pith, DVec2::new(cos, sin));
        }
        let mean = (polygon::area_and_centroid(outline).0.abs() / PI).sqrt();
        let raw: Vec<f64> = outer
            .iter()
            .map(|r| r.unwrap_or(mean).max(0.02 * mean))
            .collect();
        // An outline that folds back makes the radius jump; one pass takes the edge off it.
        let outer: Vec<f64> = (0..ANGLES)
            .map(|j| {
                let (a, b) = (raw[(j + ANGLES - 1) % ANGLES], raw[(j + 1) % ANGLES]);
                if (a - b).abs() > 0.1 * (a + b) {
                    0.25 * (a + b) + 0.5 * raw[j]
                } else {
                    raw[j]
                }
            })
            .collect();
        let waves = Waves::of(&outer);
        let mut fading = FADING;
        loop {
            let table = waves.table(&outer, fading);
            if evenly_rising(&table) || fading < 1e-3 {
                // Without fading every ring is the outline made smaller, which always rises.
                let table = if fading < 1e-3 {
                    waves.table(&outer, 0.0)
                } else {
                    table
                };
                return RingField {
                    pith,
                    extent,
                    shape: Shape::Table(table),
                };
            }
            fading *= 0.7;
        }
    }

    /// Rings as arcs about `pith`, which may lie anywhere: `outer` is the radius of ρ = 1, m.
    pub(crate) fn arcs(pith: DVec2, outer: f64, extent: f64) -> Self {
        RingField {
            pith,
            extent,
            shape: Shape::Arcs(outer),
        }
    }

    /// The pith, m.
    pub fn pith(&self) -> DVec2 {
        self.pith
    }

    /// Ring coordinate ρ (0 at the pith, 1 at the outside, more beyond it) and angle φ (rad, −π to π) of a point (m).
    pub fn address(&self, p: DVec2) -> (f64, f64) {
        let d = p - self.pith;
        let r = d.length();
        let angle = libm::atan2(d.y, d.x);
        let table = match &self.shape {
            Shape::Arcs(outer) => return (r / outer, angle),
            Shape::Table(table) => table,
        };
        let column = Column::at(table, angle);
        let outer = column.radius(LEVELS);
        if r >= outer {
            return (r / outer, angle);
        }
        let (mut low, mut high) = (0, LEVELS);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if column.radius(middle) <= r {
                low = middle;
            } else {
                high = middle;
            }
        }
        let (a, b) = (column.radius(low), column.radius(high));
        ((low as f64 + (r - a) / (b - a)) / LEVELS as f64, angle)
    }

    /// The point (m) of a ring coordinate and angle (rad).
    pub fn point(&self, ring: f64, angle: f64) -> DVec2 {
        let r = match &self.shape {
            Shape::Arcs(outer) => ring * outer,
            Shape::Table(table) => {
                let column = Column::at(table, angle);
                let level = (ring * LEVELS as f64).max(0.0);
                if level >= LEVELS as f64 {
                    ring * column.radius(LEVELS)
                } else {
                    let k = level as usize;
                    let (a, b) = (column.radius(k), column.radius(k + 1));
                    a + (b - a) * (level - k as f64)
                }
            }
        };
        let (sin, cos) = libm::sincos(angle);
        self.pith + DVec2::new(cos, sin) * r
    }

    /// Radius (m) of ρ = 1 at an angle (rad).
    pub fn outer(&self, angle: f64) -> f64 {
        match &self.shape {
            Shape::Arcs(outer) => *outer,
            Shape::Table(table) => Column::at(table, angle).radius(LEVELS),
        }
    }

    /// Radius (m) of a circle about the pith that holds the stem within its usable length, relief included.
    pub fn extent(&self) -> f64 {
        self.extent
    }
}

fn angle_of(j: usize) -> f64 {
    TAU * j as f64 / ANGLES as f64 - PI
}

/// The radii at one angle, between two directions of the table.
struct Column<'a> {
    a: &'a [f64],
    b: &'a [f64],
    t: f64,
}

impl<'a> Column<'a> {
    fn at(table: &'a [f64], angle: f64) -> Self {
        let turns = (angle + PI) / TAU;
        let u = (turns - turns.floor()) * ANGLES as f64;
        let j = (u as usize).min(ANGLES - 1);
        let row = |j: usize| &table[j * (LEVELS + 1)..(j + 1) * (LEVELS + 1)];
        Column {
            a: row(j),
            b: row((j + 1) % ANGLES),
            t: u - j as f64,
        }
    }

    fn radius(&self, level: usize) -> f64 {
        self.a[level] + (self.b[level] - self.a[level]) * self.t
    }
}

/// The outer radius as waves around the pith.
struct Waves {
    /// Cosine and sine coefficients from wave 1 on, m.
    waves: Vec<(f64, f64)>,
    mean: f64,
}

impl Waves {
    fn of(outer: &[f64]) -> Self {
        let mean = outer.iter().sum::<f64>() / ANGLES as f64;
        let waves = (1..=WAVES)
            .map(|k| {
                let (mut c, mut s) = (0.0, 0.0);
                for (j, r) in outer.iter().enumerate() {
                    let (sin, cos) = libm::sincos(angle_of(j) * k as f64);
                    c += r * cos;
                    s += r * sin;
                }
                (2.0 * c / ANGLES as f64, 2.0 * s / ANGLES as f64)
            })
            .collect();
        Waves { waves, mean }
    }

    fn table(&self, outer: &[f64], fading: f64) -> Vec<f64> {
        let mut table = Vec::with_capacity(ANGLES * (LEVELS + 1));
        let weights: Vec<Vec<f64>> = (0..=LEVELS)
            .map(|level| {
                let ring = level as f64 / LEVELS as f64;
                (0..=WAVES)
                    .map(|k| libm::pow(ring, fading * k as f64))
                    .collect()
            })
            .collect();
        for (j, &full) in outer.iter().enumerate() {
            let parts: Vec<f64> = self
                .waves
                .iter()
                .enumerate()
                .map(|(k, (c, s))| {
                    let (sin, cos) = libm::sincos(angle_of(j) * (k + 1) as f64);
                    c * cos + s * sin
                })
                .collect();
            let rest = full - self.mean - parts.iter().sum::<f64>();
            for (level, weight) in weights.iter().enumerate() {
                let ring = level as f64 / LEVELS as f64;
                let waves: f64 = parts.iter().zip(weight).map(|(p, w)| p * w).sum();
                // Written so that ρ = 1 is the outline to the last bit.
                let radius = if level == LEVELS {
                    full
                } else {
                    ring * (self.mean + waves + rest * weight[WAVES])
                };
                table.push(radius);
            }
        }
        table
    }
}

/// Whether rings follow each other along every ray without crowding.
fn evenly_rising(table: &[f64]) -> bool {
    table.chunks_exact(LEVELS + 1).all(|column| {
        let least = CLOSEST * column[LEVELS] / LEVELS as f64;
        column.windows(2).all(|w| w[1] - w[0] > least)
    })
}

/// Where the pith of a round section is taken to be when nobody says: midway between the centroid and the centre of
/// the largest inscribed circle. Growth is about even around the pith, which favours the inscribed circle; leaning
/// stems grow more on one side, which favours the centroid.
pub(crate) fn likely_pith(outline: &[DVec2]) -> DVec2 {
    let (_, centroid) = polygon::area_and_centroid(outline);
    let (centre, radius) = polygon::largest_inscribed_circle(outline);
    let middle = (centroid + centre) * 0.5;
    let thin = polygon::thinned(outline, 400);
    let safe = polygon::contains(&thin, middle) && polygon::distance(&thin, middle) > 0.3 * radius;
    if safe { middle } else { centre }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobed(depth: f64) -> Vec<DVec2> {
        (0..240)
            .map(|i| {
                let a = TAU * f64::from(i) / 240.0;
                let r = 0.05 * (1.0 + depth * (5.0 * a).cos() + 0.1 * (2.0 * a + 1.0).cos());
                DVec2::new(r * a.cos(), r * a.sin()) + DVec2::new(0.3, -0.1)
            })
            .collect()
    }

    #[test]
    fn addresses_invert_and_the_outline_is_one() {
        // From mild lobes to a star whose furrows go down to a third.
        for depth in [0.0, 0.05, 0.5] {
            let outline = lobed(depth);
            let field = RingField::round(&outline, likely_pith(&outline), 0.1);
            for i in 0..60 {
                for ring in [0.0, 1e-3, 0.2, 0.63, 0.999, 1.0, 1.4] {
                    let angle = 0.1 + f64::from(i) * 0.1 - PI;
                    let (r, a) = field.address(field.point(ring, angle));
                    assert!((r - ring).abs() < 1e-12, "{ring} {angle}: {r}");
                    assert!(ring == 0.0 || (a - angle).abs() < 1e-9);
                }
                let mut before = -1.0;
                for k in 0..200 {
                    let (sin, cos) = (f64::from(i) * 0.1).sin_cos();
                    let p = field.pith() + DVec2::new(cos, sin) * (f64::from(k) * 5e-4);
                    let ring = field.address(p).0;
                    assert!(ring > before);
                    before = ring;
                }
            }
            for p in &outline {
                assert!((field.address(*p).0 - 1.0).abs() < 0.02, "{depth}");
            }
        }
    }

    #[test]
    fn inner_rings_are_rounder_than_the_outline() {
        let outline = lobed(0.1);
        let field = RingField::round(&outline, DVec2::new(0.3, -0.1), 0.1);
        let spread = |ring: f64| {
            let radii: Vec<f64> = (0..90)
                .map(|i| {
                    field
                        .point(ring, f64::from(i) * TAU / 90.0)
                        .distance(field.pith())
                })
                .collect();
            let high = radii.iter().copied().fold(0.0, f64::max);
            let low = radii.iter().copied().fold(f64::INFINITY, f64::min);
            (high - low) / (high + low)
        };
        assert!(
            spread(0.2) < 0.5 * spread(1.0),
            "{} {}",
            spread(0.2),
            spread(1.0)
        );
    }
}
