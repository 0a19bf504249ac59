//! Rings of a section as passes (Forests 2023 §3.3): a number for each pixel, 1 at the outside, odd in latewood and even
//! in earlywood; a dark pass and the light one within it make a ring.
//!
//! Erosion of a bitmap gives such numbers. Here they are painted from rings of the continuous field instead, so that both
//! kinds of rings are used in the same way by everything that follows.

use crate::raster::{PixelGrid, ScanConverter};
use crate::rings::{ConcentricRings, FieldRay, RingField, RingPart, RingSource, ring_numbers};
use crate::tissue::{Proportions, Zone};
use glam::DVec2;
use greenstick_geometry::Bitmap;
use std::f64::consts::{PI, TAU};

/// Corners of the polygons that rings are painted as.
const CORNERS: usize = 360;

/// Passes of a section: rings of the field, painted from the outside in.
pub fn passes_of_rings(
    grid: &PixelGrid,
    section: &Bitmap,
    field: &RingField,
    rings: &ConcentricRings,
) -> Vec<u16> {
    let mut passes = vec![1; grid.count * grid.count];
    let mut converter = ScanConverter::default();
    let rays: Vec<(FieldRay, DVec2)> = (0..CORNERS)
        .map(|j| TAU * j as f64 / CORNERS as f64 - PI)
        .map(|angle| {
            let (sin, cos) = libm::sincos(angle);
            (field.ray(angle), DVec2::new(cos, sin))
        })
        .collect();
    let mut curve = vec![DVec2::ZERO; CORNERS];
    let outermost_first = (0..rings.edges().len()).rev();
    for (outside, ring) in (0..).zip(outermost_first) {
        let edges = rings.ring(ring);
        let latewood: u16 = 2 * outside + 1;
        for (rho, pass) in [(edges.latewood, latewood + 1), (edges.inner, latewood + 2)] {
            if rho <= 0.0 {
                break;
            }
            for (p, (ray, direction)) in curve.iter_mut().zip(&rays) {
                *p = field.pith() + *direction * ray.radius(rho);
            }
            converter.spans(grid, &curve, |y, pixels| {
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

/// The meaning of one pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassMeaning {
    /// Ring, counted from 1 at the pith to the number of rings at the outside; 0 for pass 0, which is no wood.
    pub ring: u16,
    /// Tissue; that of pass 0 means nothing.
    pub tissue: Zone,
    /// Earlywood or latewood.
    pub part: RingPart,
}

/// What the numbers of passes mean.
#[derive(Debug, Clone, PartialEq)]
pub struct PassLegend {
    /// Number of rings.
    pub rings: u16,
    /// The meaning of each pass, from pass 0 on.
    pub passes: Vec<PassMeaning>,
}

impl PassLegend {
    /// The legend of rings painted by [`passes_of_rings`]: passes are latewood and earlywood in turn.
    pub fn of_rings(rings: &ConcentricRings) -> Self {
        let count = rings.edges().len() as u16;
        let meaning = |pass: u16| {
            let ring = count + 1 - pass.div_ceil(2);
            PassMeaning {
                ring,
                tissue: rings.tissues()[usize::from(ring) - 1],
                part: if pass % 2 == 1 {
                    RingPart::Latewood
                } else {
                    RingPart::Earlywood
                },
            }
        };
        PassLegend {
            rings: rings.ring_count() as u16,
            passes: std::iter::once(NO_WOOD)
                .chain((1..=2 * count).map(meaning))
                .collect(),
        }
    }

    /// The legend of an eroded section in a stem with at most `most` rings. Its rings are counted from the bark inwards, so
    /// that the outermost is the same year all along the stem and slimmer sections lack the first years, as in a tree.
    /// Tissues go by the section's own number of rings.
    pub fn of_erosion(parts: &[RingPart], most: u16, tissue: &Proportions) -> Self {
        let inwards = ring_numbers(parts.iter().copied());
        let own = inwards.last().copied().unwrap_or(0).max(1);
        let meaning = |(&n, &part): (&u16, &RingPart)| PassMeaning {
            // A section that was not counted beforehand may have more: those share the innermost number.
            ring: most.saturating_sub(n - 1).max(1),
            tissue: tissue.zone_of_ring((own + 1 - n.max(1)).into(), own.into()),
            part,
        };
        PassLegend {
            rings: most,
            passes: std::iter::once(NO_WOOD)
                .chain(inwards[1..].iter().zip(parts).map(meaning))
                .collect(),
        }
    }

    /// The meaning of a pass, which must be one of the legend's.
    pub fn of(&self, pass: u16) -> &PassMeaning {
        &self.passes[usize::from(pass)]
    }

    /// The tissue of a ring, by its first pass; bark where it has none.
    pub fn tissue_of_ring(&self, ring: usize) -> Zone {
        let pass = self.passes.iter().find(|p| usize::from(p.ring) == ring);
        pass.map_or(Zone::Bark, |p| p.tissue)
    }
}

/// The meaning of pass 0.
const NO_WOOD: PassMeaning = PassMeaning {
    ring: 0,
    tissue: Zone::Pith,
    part: RingPart::Earlywood,
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::fill_loops;

    const TISSUE: Proportions = Proportions {
        pith: 0.1,
        heartwood: 0.4,
        phloem: 0.1,
    };

    #[test]
    fn passes_of_the_field_are_those_of_its_ring_coordinate() {
        let outline: Vec<DVec2> = (0..240)
            .map(|i| TAU * f64::from(i) / 240.0)
            .map(|a| DVec2::from_angle(a) * 0.05 * (1.0 + 0.15 * (3.0 * a).cos()))
            .collect();
        let field = RingField::round(&outline, DVec2::new(0.008, -0.004), 0.1, None);
        let grid = PixelGrid {
            count: 256,
            pixel: 0.125 / 256.0,
        };
        let section = fill_loops(&grid, &[outline]);
        let rings = ConcentricRings::even(9, &TISSUE);
        let passes = passes_of_rings(&grid, &section, &field, &rings);
        let legend = PassLegend::of_rings(&rings);
        let ring_of = [1, 2, 18].map(|pass| legend.of(pass).ring);
        assert_eq!((legend.rings, ring_of), (9, [9, 9, 1]));
        let (mut wrong, mut seen) = (0, vec![0; 19]);
        for y in 0..256 {
            for x in 0..256 {
                let pass = passes[y * 256 + x];
                assert_eq!(pass > 0, section.get(x, y));
                if pass == 0 {
                    continue;
                }
                seen[usize::from(pass)] += 1;
                let rho = 9.0 * field.address(grid.pixel_centre(x, y)).0;
                let ring = rho.ceil().clamp(1.0, 9.0);
                let late = rho > ring - crate::rings::LATEWOOD_FRACTION;
                let meaning = legend.of(pass);
                let right =
                    meaning.ring == ring as u16 && (meaning.part == RingPart::Latewood) == late;
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

    #[test]
    fn eroded_rings_count_from_the_bark_and_tissues_by_the_section() {
        let tissue = Proportions {
            pith: 0.2,
            heartwood: 0.4,
            phloem: 0.1,
        };
        // 20 passes make 10 rings, in a stem of 12.
        let parts = [RingPart::Latewood, RingPart::Earlywood].repeat(10);
        let legend = PassLegend::of_erosion(&parts, 12, &tissue);
        let rings = [0, 1, 2, 3, 20].map(|pass| legend.of(pass).ring);
        assert_eq!(rings, [0, 12, 12, 11, 3]);
        assert_eq!(
            (legend.of(1).tissue, legend.of(20).tissue),
            (Zone::Bark, Zone::Pith)
        );
        // More rings than the stem was counted to have.
        let legend = PassLegend::of_erosion(&parts, 7, &tissue);
        assert_eq!([1, 13, 20].map(|pass| legend.of(pass).ring), [7, 1, 1]);
    }
}
