//! How rings are divided into sectors, whose wood is a bundle of fibres (Forests 2023 §3.4).
//!
//! As published every ring is divided into the same number of sectors; outer bundles are then many times larger than inner
//! ones, as its authors deplore. Equal-area bundles have sectors in proportion to each ring's area, and within a ring the
//! sectors' borders lie so that all have the same share of it.

use crate::rings::{ConcentricRings, RingField};
use std::f64::consts::TAU;

greenstick_schema::choices! {
    /// How rings are divided into sectors.
    pub enum SectorDivision {
        /// The same number of sectors in every ring, at equal angles, as published.
        EqualAngle = "fixed",
        /// As many sectors as make the cross-sections of bundles equal.
        EqualArea = "equal-area",
    }
}

/// Numbers of sectors by ring; the same in all layers, so that particles of one address follow each other along the
/// grain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SectorLayout {
    /// How sectors are bounded.
    pub division: SectorDivision,
    /// Sectors of each ring, from the pith outwards.
    pub sectors: Vec<u32>,
}

/// Directions in which a ring's area is summed.
const DIRECTIONS: usize = 720;

/// Areas of the rings of a section, direction by direction.
pub(super) struct RingAreas {
    /// For each ring from the pith: its area (m²) from angle 0 up to direction j of [`DIRECTIONS`], and to a whole turn.
    sums: Vec<Vec<f64>>,
}

impl RingAreas {
    /// The areas of rings.
    pub fn new(field: &RingField, rings: &ConcentricRings) -> Self {
        let half_step = 0.5 * TAU / DIRECTIONS as f64;
        let squares = |edge: f64| -> Vec<f64> {
            (0..DIRECTIONS)
                .map(|j| {
                    let angle = TAU * j as f64 / DIRECTIONS as f64;
                    let p = field.point(edge, angle);
                    p.distance_squared(field.pith())
                })
                .collect()
        };
        let mut inner = vec![0.0; DIRECTIONS];
        let sums = rings
            .edges()
            .iter()
            .map(|&edge| {
                let outer = squares(edge);
                let width = |j: usize| outer[j % DIRECTIONS] - inner[j % DIRECTIONS];
                let mut sum = vec![0.0; DIRECTIONS + 1];
                for j in 0..DIRECTIONS {
                    // Half the squared radius is the area by angle; the trapezoidal rule.
                    sum[j + 1] = sum[j] + half_step * 0.5 * (width(j) + width(j + 1));
                }
                inner = outer;
                sum
            })
            .collect();
        RingAreas { sums }
    }

    /// Area of a ring, m².
    pub fn total(&self, ring: usize) -> f64 {
        self.sums[ring][DIRECTIONS]
    }

    /// Area (m²) of a ring from angle 0 to `angle` (rad).
    pub fn up_to(&self, ring: usize, angle: f64) -> f64 {
        let u = angle / TAU;
        let whole = u.floor();
        let v = (u - whole) * DIRECTIONS as f64;
        let j = (v as usize).min(DIRECTIONS - 1);
        let sum = &self.sums[ring];
        whole * self.total(ring) + sum[j] + (sum[j + 1] - sum[j]) * (v - j as f64)
    }

    /// The angle (rad, 0 to 2π) up to which a ring has the given area (m²).
    pub fn angle(&self, ring: usize, area: f64) -> f64 {
        let sum = &self.sums[ring];
        let j = sum.partition_point(|&a| a <= area).clamp(1, DIRECTIONS) - 1;
        let part = (area - sum[j]) / (sum[j + 1] - sum[j]).max(f64::MIN_POSITIVE);
        (j as f64 + part.clamp(0.0, 1.0)) * TAU / DIRECTIONS as f64
    }
}

impl SectorLayout {
    /// `sectors` in every ring.
    pub fn equal_angle(rings: u16, sectors: u32) -> Self {
        SectorLayout {
            division: SectorDivision::EqualAngle,
            sectors: vec![sectors; rings.into()],
        }
    }

    /// Sectors of equal area: `sectors` in the outermost ring, and in each other as many as make bundles of nearly that
    /// area. They are averaged over the sections whose `fields` are given: the share of a ring in a section differs along a
    /// stem, as the outermost includes the bark's relief, and the numbers are the same in all layers.
    pub fn equal_area<'a>(
        fields: impl IntoIterator<Item = &'a RingField>,
        rings: &ConcentricRings,
        sectors: u32,
    ) -> Self {
        let mut shares = vec![0.0; rings.edges().len()];
        for field in fields {
            let areas = RingAreas::new(field, rings);
            let whole: f64 = (0..shares.len()).map(|ring| areas.total(ring)).sum();
            for (ring, share) in shares.iter_mut().enumerate() {
                *share += areas.total(ring) / whole;
            }
        }
        let most = shares.last().copied().unwrap_or(0.0);
        let count = |share: &f64| {
            let wanted = f64::from(sectors) * share / most;
            (wanted.round() as u32).clamp(1, sectors.max(1))
        };
        SectorLayout {
            division: SectorDivision::EqualArea,
            sectors: shares.iter().map(count).collect(),
        }
    }

    /// Number of rings.
    pub fn rings(&self) -> u16 {
        self.sectors.len() as u16
    }

    /// Particles in a layer: one term of Eq. 1's sum.
    pub fn particles(&self) -> u64 {
        self.sectors.iter().map(|&n| u64::from(n)).sum()
    }
}
