//! Rings of a section as passes (forests-2023 §3.3): a number for each pixel, 1 at the outside, odd in latewood and even
//! in earlywood; a dark pass and the light one within it make a ring.
//!
//! Erosion of a bitmap gives such numbers. Here they are drawn from the continuous ring field instead, so that both kinds
//! of rings are taken the same way by whatever comes after.

use super::fill::{Grid, Scan};
use crate::rings::RingField;
use crate::tissue::{Proportions, Zone};
use glam::DVec2;
use greenstick_geometry::Bitmap;
use std::f64::consts::{PI, TAU};

/// Part of a ring's width that is latewood.
pub const LATEWOOD: f64 = 0.3;
/// Corners of the polygons that rings are drawn as.
const CORNERS: usize = 360;

/// Passes of a section: `rings` rings of the field, painted from the outside in.
pub fn field_passes(grid: &Grid, section: &Bitmap, field: &RingField, rings: u16) -> Vec<u16> {
    let mut passes = vec![1; grid.count * grid.count];
    let mut scan = Scan::default();
    let count = f64::from(rings);
    let directions: Vec<(f64, DVec2)> = (0..CORNERS)
        .map(|j| TAU * j as f64 / CORNERS as f64 - PI)
        .map(|angle| {
            let (sin, cos) = libm::sincos(angle);
            (angle, DVec2::new(cos, sin))
        })
        .collect();
    let mut curve = vec![DVec2::ZERO; CORNERS];
    for outside in 0..rings {
        let outer = count - f64::from(outside);
        let number = 2 * outside + 1;
        for (ring, pass) in [(outer - LATEWOOD, number + 1), (outer - 1.0, number + 2)] {
            if ring <= 0.0 {
                break;
            }
            for (p, (angle, direction)) in curve.iter_mut().zip(&directions) {
                *p = field.pith() + *direction * field.radius(ring / count, *angle);
            }
            scan.spans(grid, &curve, |y, pixels| {
                passes[y * grid.count..][pixels].fill(pass);
            });
        }
    }
    mask(section, &mut passes);
    passes
}

/// Sets the pixels that are not in the section to 0.
fn mask(section: &Bitmap, passes: &mut [u16]) {
    let width = section.width();
    if width == 0 {
        return;
    }
    for (y, line) in passes.chunks_exact_mut(width).enumerate() {
        for (word, pixels) in section.row(y).iter().zip(line.chunks_mut(64)) {
            match *word {
                0 => pixels.fill(0),
                u64::MAX => {}
                word => pixels
                    .iter_mut()
                    .enumerate()
                    .for_each(|(x, p)| *p *= (word >> x & 1) as u16),
            }
        }
    }
}

/// What the numbers of passes stand for.
#[derive(Debug, Clone, PartialEq)]
pub struct RingNumbers {
    /// Number of rings.
    pub rings: u16,
    /// Ring of each pass, counted 1 at the pith to `rings` at the outside; 0 for pass 0, which is no wood.
    pub ring: Vec<u16>,
    /// Tissue of each pass; that of pass 0 means nothing.
    pub zone: Vec<Zone>,
    /// Whether each pass is latewood.
    pub latewood: Vec<bool>,
}

impl RingNumbers {
    /// For passes 1 to `last` that are latewood and earlywood in turn.
    pub fn alternating(last: u16, proportions: &Proportions) -> Self {
        let rings = last.div_ceil(2);
        let ring: Vec<u16> = (0..=last)
            .map(|p| if p == 0 { 0 } else { rings + 1 - p.div_ceil(2) })
            .collect();
        Self::new(rings, ring, proportions)
    }

    /// For passes whose rings are given, counted from 1 at the pith to `rings`; the first is that of pass 0. Odd passes
    /// are latewood.
    pub fn new(rings: u16, ring: Vec<u16>, proportions: &Proportions) -> Self {
        let zone = ring
            .iter()
            .map(|&r| proportions.zone_of_ring(r.into(), rings.into()))
            .collect();
        let latewood = (0..ring.len()).map(|pass| pass % 2 == 1).collect();
        RingNumbers {
            rings,
            ring,
            zone,
            latewood,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::fill::fill;

    #[test]
    fn passes_of_the_field_are_those_of_its_ring_coordinate() {
        let outline: Vec<DVec2> = (0..240)
            .map(|i| TAU * f64::from(i) / 240.0)
            .map(|a| DVec2::from_angle(a) * 0.05 * (1.0 + 0.15 * (3.0 * a).cos()))
            .collect();
        let field = RingField::round(&outline, DVec2::new(0.008, -0.004), 0.1);
        let grid = Grid {
            count: 256,
            pixel: 0.125 / 256.0,
        };
        let section = fill(&grid, &[outline]);
        let passes = field_passes(&grid, &section, &field, 9);
        let numbers = RingNumbers::alternating(
            18,
            &Proportions {
                pith: 0.1,
                heartwood: 0.4,
                phloem: 0.1,
            },
        );
        assert_eq!(
            (
                numbers.rings,
                numbers.ring[1],
                numbers.ring[2],
                numbers.ring[18]
            ),
            (9, 9, 9, 1)
        );
        let (mut wrong, mut seen) = (0, vec![0; 19]);
        for y in 0..256 {
            for x in 0..256 {
                let pass = passes[y * 256 + x];
                assert_eq!(pass > 0, section.get(x, y));
                if pass == 0 {
                    continue;
                }
                seen[usize::from(pass)] += 1;
                let rho = 9.0 * field.address(grid.middle(x, y)).0;
                let ring = rho.ceil().clamp(1.0, 9.0);
                let late = rho > ring - LATEWOOD;
                let right = numbers.ring[usize::from(pass)] == ring as u16
                    && numbers.latewood[usize::from(pass)] == late;
                wrong += usize::from(!right);
            }
        }
        // A polygon of 360 corners lies less than 4e-5 of its radius within its curve: 0.004 pixels here.
        assert!(
            wrong * 500 < section.count(),
            "{wrong} of {}",
            section.count()
        );
        assert!(seen[1..].iter().all(|&n| n > 0), "{seen:?}");
    }
}
