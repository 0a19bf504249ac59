//! A photographed section unrolled about its pith: a row for each ring coordinate, a column for each direction.

use super::error::{MIN_RADIUS, MeasureError};
use super::section::{PhotographedSection, SectionPhotograph};
use glam::DVec2;
use std::f64::consts::TAU;

/// Range of the numbers of rows and columns.
const ROWS: (f64, f64) = (100.0, 700.0);
const COLUMNS: (f64, f64) = (360.0, 4096.0);
/// Half the arc along a ring that a pixel is compared with, rad, and its least length, pixels.
const HALF_WINDOW: f64 = 0.35;
const MIN_WINDOW: f64 = 12.0;
/// Share of a column by which a side of the outline is widened, so that none falls between two sides.
const ROUNDING: f64 = 1e-9;
/// Levels of brightness that medians are taken of.
const LEVELS: usize = 256;

/// How much darker each place of a section is than what lies beside it along the ring.
pub(super) struct Unrolled {
    pub rows: usize,
    pub columns: usize,
    /// 0 for as bright as its neighbourhood along the ring, 1 for black; row by row from the pith.
    pub darkness: Vec<f32>,
    /// 0 for as bright as the whole ring, 1 for black: a crack along a ring fills its neighbourhood there.
    pub ring_darkness: Vec<f32>,
    /// Linear brightness.
    pub brightness: Vec<f32>,
}

impl Unrolled {
    pub fn new(
        photograph: &SectionPhotograph,
        section: &PhotographedSection,
    ) -> Result<Self, MeasureError> {
        let pith = DVec2::from(section.pith);
        let radii = radii(section)?;
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        if mean < MIN_RADIUS {
            return Err(MeasureError::Small { radius: mean });
        }
        let rows = mean.clamp(ROWS.0, ROWS.1) as usize;
        let columns = radii.len();
        let mut darkness = Vec::with_capacity(rows * columns);
        let mut ring_darkness = Vec::with_capacity(rows * columns);
        let mut all_brightness = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            let rho = (row as f64 + 0.5) / rows as f64;
            let brightness: Vec<f32> = (radii.iter().enumerate())
                .map(|(k, r)| {
                    let (sin, cos) = libm::sincos(TAU * k as f64 / columns as f64);
                    // Rows of a photograph run down, angles counter-clockwise.
                    photograph.brightness(pith + DVec2::new(cos, -sin) * (r * rho))
                })
                .collect();
            let half = HALF_WINDOW.max(MIN_WINDOW / (rho * mean));
            let half = ((half / TAU * columns as f64) as usize).min(columns / 2 - 1);
            let medians = running_median(&brightness, half);
            let dark = |b: f32, median: f32| (1.0 - b / median.max(1e-4)).max(0.0);
            let beside = brightness.iter().zip(medians);
            darkness.extend(beside.map(|(&b, m)| dark(b, m)));
            let mut sorted = brightness.clone();
            let whole = *sorted.select_nth_unstable_by(columns / 2, f32::total_cmp).1;
            ring_darkness.extend(brightness.iter().map(|&b| dark(b, whole)));
            all_brightness.extend(brightness);
        }
        Ok(Unrolled {
            rows,
            columns,
            darkness,
            ring_darkness,
            brightness: all_brightness,
        })
    }

    /// Returns the darkness along the ring, or against the whole ring.
    pub fn at(&self, row: usize, column: usize, against_ring: bool) -> f32 {
        let darkness = if against_ring {
            &self.ring_darkness
        } else {
            &self.darkness
        };
        darkness[row * self.columns + column % self.columns]
    }

    /// Returns the ring coordinate in the middle of a row.
    pub fn rho(&self, row: usize) -> f64 {
        (row as f64 + 0.5) / self.rows as f64
    }

    /// Returns the angle from one column to the next, rad.
    pub fn step(&self) -> f64 {
        TAU / self.columns as f64
    }
}

/// The distances of the outline from the pith, in as many directions as there are columns, pixels.
fn radii(section: &PhotographedSection) -> Result<Vec<f64>, MeasureError> {
    let pith = DVec2::from(section.pith);
    let error = |problem: &str| MeasureError::Outline {
        problem: problem.to_owned(),
        x: pith.x,
        y: pith.y,
    };
    let points: Vec<DVec2> = section
        .outline
        .iter()
        .map(|&p| DVec2::from(p) - pith)
        .collect();
    if points.len() < 3 || points.iter().any(|p| !p.is_finite()) {
        return Err(error("the outline has fewer than three points"));
    }
    let mean = points.iter().map(|p| p.length()).sum::<f64>() / points.len() as f64;
    let columns = (TAU * mean).clamp(COLUMNS.0, COLUMNS.1) as usize;
    let mut radii = vec![0.0f64; columns];
    for (i, a) in points.iter().enumerate() {
        let b = points[(i + 1) % points.len()];
        // Seen with y up, as angles are counted.
        let (p, q) = (DVec2::new(a.x, -a.y), DVec2::new(b.x, -b.y));
        let from = libm::atan2(p.y, p.x);
        let turn = libm::atan2(p.perp_dot(q), p.dot(q));
        let step = TAU / columns as f64;
        let (low, high) = (from.min(from + turn), from.max(from + turn));
        for k in (low / step - ROUNDING).ceil() as i64..=(high / step + ROUNDING).floor() as i64 {
            let (sin, cos) = libm::sincos(k as f64 * step);
            let d = DVec2::new(cos, sin);
            let side = d.perp_dot(q - p);
            if side != 0.0 {
                let r = (p + (q - p) * (d.perp_dot(-p) / side)).dot(d);
                let known = &mut radii[k.rem_euclid(columns as i64) as usize];
                *known = known.max(r);
            }
        }
    }
    if radii.iter().any(|r| *r <= 0.0) {
        return Err(error("the outline does not go around the pith"));
    }
    Ok(radii)
}

/// Returns the medians of the values within `half` places to both sides, around.
fn running_median(values: &[f32], half: usize) -> Vec<f32> {
    let most = values.iter().copied().fold(1e-6, f32::max);
    let level = |v: f32| ((v / most * (LEVELS - 1) as f32) as usize).min(LEVELS - 1);
    let n = values.len();
    let levels: Vec<usize> = values.iter().map(|&v| level(v)).collect();
    let mut counts = [0usize; LEVELS];
    for k in 0..=2 * half {
        counts[levels[(n + k - half) % n]] += 1;
    }
    (0..n)
        .map(|i| {
            if i > 0 {
                counts[levels[(n + i - 1 - half) % n]] -= 1;
                counts[levels[(i + half) % n]] += 1;
            }
            let (mut sum, mut median) = (0, 0);
            while sum <= half && median < LEVELS {
                sum += counts[median];
                median += 1;
            }
            (median as f32 - 0.5) / (LEVELS - 1) as f32 * most
        })
        .collect()
}
