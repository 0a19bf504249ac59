//! How deep the skin of a stem lies, by direction and length: what stands inside the wood must stay below it.

use super::angle::wrap_angle;
use std::f64::consts::{PI, TAU};

/// Sectors about the pith in which the depth is known.
const SECTORS: usize = 128;
/// Greatest number of slices along the stem.
const MAX_SLICES: f64 = 512.0;
/// Ring coordinate by which a cell must lie below the skin.
const MARGIN: f64 = 0.005;

/// A point of the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinPoint {
    /// Ring coordinate.
    pub rho: f64,
    /// Angle about the pith, rad.
    pub phi: f64,
    /// Length along the axis, m.
    pub length: f64,
}

/// An edge along a ring that is to lie below the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InnerEdge {
    /// Ring coordinate.
    pub rho: f64,
    /// Angle of its middle about the pith, rad.
    pub phi: f64,
    /// Half its width, rad.
    pub half_width: f64,
}

/// The least ring coordinate of a stem's skin, by direction and length.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinDepth {
    low: f64,
    step: f64,
    /// By slice, then by sector.
    least: Vec<[f32; SECTORS]>,
}

impl SkinDepth {
    /// Returns the depth of a skin of no triangles between the lengths `low` and `high` (m), in slices of about `step` (m).
    pub fn new((low, high): (f64, f64), step: f64) -> Self {
        let count = ((high - low) / step).ceil().clamp(1.0, MAX_SLICES);
        SkinDepth {
            low,
            step: (high - low) / count,
            least: vec![[f32::INFINITY; SECTORS]; count as usize],
        }
    }

    /// Adds a triangle of the skin.
    pub fn add(&mut self, triangle: [SkinPoint; 3]) {
        let fold = |of: fn(&SkinPoint) -> f64| {
            let values = triangle.iter().map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            })
        };
        let (from, to) = fold(|p| p.length);
        let slices = ((from - self.low) / self.step, (to - self.low) / self.step);
        if !(slices.1 >= 0.0 && slices.0 < self.least.len() as f64) {
            return;
        }
        let first = triangle[0].phi;
        let turns = triangle.map(|p| wrap_angle(p.phi - first));
        let (right, left) = turns.iter().fold((0.0f64, 0.0f64), |(low, high), &t| {
            (low.min(t), high.max(t))
        });
        let span = left - right;
        // The middle of a chord lies deeper than its ends; a triangle of an end reaches the pith.
        let (rho, count) = if span < PI {
            let count = ((span / TAU * SECTORS as f64).ceil() as usize + 1).min(SECTORS);
            (fold(|p| p.rho).0 * libm::cos(0.5 * span), count)
        } else {
            (0.0, SECTORS)
        };
        let start = sector(first + right);
        let last = (slices.1 as usize).min(self.least.len() - 1);
        for slice in &mut self.least[slices.0.max(0.0) as usize..=last] {
            for k in 0..count {
                let least = &mut slice[(start + k) % SECTORS];
                *least = least.min(rho as f32);
            }
        }
    }

    /// Returns the least ring coordinate of the skin.
    pub fn least(&self) -> f64 {
        let all = self.least.iter().flatten();
        f64::from(all.copied().fold(f32::INFINITY, f32::min))
    }

    /// Returns the length (m) up to which an edge lies below the skin from the length `from` (m) on; `None` where it does
    /// not there.
    pub fn covered_up_to(&self, edge: &InnerEdge, from: f64) -> Option<f64> {
        let first = self.slice(from)?;
        let slices = self.least[first..].iter();
        let covered = slices.take_while(self.covers(edge)).count();
        (covered > 0).then(|| self.low + (first + covered) as f64 * self.step)
    }

    /// Returns whether an edge lies below the skin from the length `from` (m) to beyond the length `to` (m): whether
    /// [`SkinDepth::covered_up_to`] is greater than `to`.
    pub fn covers_between(&self, edge: &InnerEdge, from: f64, to: f64) -> bool {
        let Some(first) = self.slice(from) else {
            return false;
        };
        let covers = self.covers(edge);
        for (i, slice) in self.least.iter().enumerate().skip(first) {
            if !covers(&slice) {
                return false;
            }
            if self.low + (i + 1) as f64 * self.step > to {
                return true;
            }
        }
        false
    }

    /// The slice of a length.
    fn slice(&self, length: f64) -> Option<usize> {
        let slice = (length - self.low) / self.step;
        (slice >= 0.0 && slice < self.least.len() as f64).then_some(slice as usize)
    }

    /// Whether an edge lies below the skin of a slice.
    fn covers(&self, edge: &InnerEdge) -> impl Fn(&&[f32; SECTORS]) -> bool {
        let start = sector(edge.phi - edge.half_width);
        let count = (2.0 * edge.half_width / TAU * SECTORS as f64).ceil() as usize + 1;
        let least = (edge.rho + MARGIN) as f32;
        move |slice| {
            let sectors = (0..count.min(SECTORS)).map(|k| slice[(start + k) % SECTORS]);
            sectors.fold(f32::INFINITY, f32::min) >= least
        }
    }
}

fn sector(phi: f64) -> usize {
    let turn = phi / TAU;
    (((turn - turn.floor()) * SECTORS as f64) as usize).min(SECTORS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cone about the pith whose ring coordinate falls from 1 at the length 0 to 0.5 at the length 1, as quadrangles.
    fn cone() -> SkinDepth {
        let mut skin = SkinDepth::new((0.0, 1.0), 0.01);
        let point = |i: usize, j: usize| {
            let length = i as f64 / 50.0;
            SkinPoint {
                rho: 1.0 - 0.5 * length,
                phi: wrap_angle(j as f64 * TAU / 64.0),
                length,
            }
        };
        for i in 0..50 {
            for j in 0..64 {
                let [a, b, c, d] =
                    [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| point(i, j));
                skin.add([a, b, c]);
                skin.add([a, c, d]);
            }
        }
        skin
    }

    #[test]
    fn a_cell_is_covered_up_to_where_the_cone_is_as_thin() {
        let skin = cone();
        let edge = |phi: f64| InnerEdge {
            rho: 0.75,
            phi,
            half_width: 0.05,
        };
        for phi in [-3.1, -0.2, 0.0, 1.4, 3.13] {
            let top = skin.covered_up_to(&edge(phi), 0.1).unwrap();
            // The cone is as thin as the edge at 0.5; margin, chords and slices take some of it.
            assert!(top < 0.5 && top > 0.45, "{phi}: {top}");
            for (to, covered) in [(0.1, true), (0.44, true), (top, false), (0.9, false)] {
                assert_eq!(skin.covers_between(&edge(phi), 0.1, to), covered, "{to}");
            }
            assert!(!skin.covers_between(&edge(phi), 0.6, 0.6));
            assert_eq!(skin.covered_up_to(&edge(phi), 0.6), None);
            assert_eq!(skin.covered_up_to(&edge(phi), -0.1), None);
        }
        assert!((skin.least() - 0.5).abs() < 0.01, "{}", skin.least());
    }

    #[test]
    fn an_end_covers_nothing() {
        let mut skin = cone();
        let corner = |phi| SkinPoint {
            rho: 0.1,
            phi,
            length: 0.3,
        };
        skin.add([0.0, 2.1, -2.1].map(corner));
        let edge = InnerEdge {
            rho: 0.2,
            phi: 1.0,
            half_width: 0.05,
        };
        let top = skin.covered_up_to(&edge, 0.1).unwrap();
        assert!((top - 0.3).abs() < 0.0101, "{top}");
    }
}
