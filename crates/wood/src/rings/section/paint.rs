//! A picture of the rings of a section: light earlywood, dark latewood.

use super::super::address::StemAddress;
use super::super::concentric::ConcentricRings;
use super::super::source::{RingPart, RingSource};
use super::eroded::ErodedSection;
use super::rings::{Rings, SectionRings};
use crate::colour::RgbImage;
use crate::tissue::Proportions;
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;

/// Colours, sRGB: around the section, earlywood, latewood, the pith.
const BACKGROUND: [f64; 3] = [246.0, 244.0, 240.0];
const EARLYWOOD: [f64; 3] = [226.0, 190.0, 140.0];
const LATEWOOD: [f64; 3] = [140.0, 88.0, 46.0];
const PITH: [f64; 3] = [96.0, 58.0, 32.0];
/// Where in a ring its wood begins to darken.
const DARKENING_START: f64 = 0.55;
/// Radius of the pith over the mean radius.
const PITH_RADIUS: f64 = 0.008;
/// Width of the picture over the section's.
const PICTURE_MARGIN: f64 = 1.06;
/// Samples along each side of a pixel.
const SAMPLES_PER_SIDE: u32 = 3;

impl SectionRings {
    /// Paints the rings, `size` pixels wide and high, with the section's y as it is.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint(&self, size: u32, context: &Context) -> Result<RgbImage, Cancelled> {
        match &self.rings {
            Rings::Field(coordinates) => {
                // Beyond the last ring is the year that is not over.
                let pith_only = Proportions {
                    pith: PITH_RADIUS,
                    heartwood: 0.0,
                    phloem: 0.0,
                };
                let rings = ConcentricRings::with_edges(coordinates.clone(), &pith_only);
                self.paint_points(size, |p| self.field_colour(&rings, p), context)
            }
            Rings::Eroded(eroded) => self.paint_points(size, |p| eroded_colour(eroded, p), context),
        }
    }

    /// The colour of a point, sRGB, by the rings of a source.
    fn field_colour(&self, rings: &dyn RingSource, p: DVec2) -> [f64; 3] {
        let (rho, angle) = self.field.address(p);
        if rho > 1.0 {
            return BACKGROUND;
        }
        if rho < PITH_RADIUS {
            return PITH;
        }
        let address = StemAddress {
            rho,
            angle,
            across: p - self.pith(),
            along: 0.0,
        };
        let fraction = rings.ring_at(&address).map_or(0.0, |ring| ring.fraction);
        let dark = ((fraction - DARKENING_START) / (1.0 - DARKENING_START)).clamp(0.0, 1.0);
        let dark = dark * dark;
        std::array::from_fn(|c| EARLYWOOD[c] + (LATEWOOD[c] - EARLYWOOD[c]) * dark)
    }

    fn paint_points(
        &self,
        size: u32,
        colour: impl Fn(DVec2) -> [f64; 3] + Sync,
        context: &Context,
    ) -> Result<RgbImage, Cancelled> {
        const SAMPLES: u32 = SAMPLES_PER_SIDE * SAMPLES_PER_SIDE;
        let size = size.max(1);
        let extent = self.outline.extent();
        let (centre, side) = (extent.centre(), extent.side() * PICTURE_MARGIN);
        // From −½ to ½.
        let place = |pixel: u32, sample: u32| {
            let sample = (f64::from(sample) + 0.5) / f64::from(SAMPLES_PER_SIDE);
            (f64::from(pixel) + sample) / f64::from(size) - 0.5
        };
        let pixel = |x: u32, y: u32| {
            let mut sum = [0.0; 3];
            for k in 0..SAMPLES {
                let (i, j) = (k % SAMPLES_PER_SIDE, k / SAMPLES_PER_SIDE);
                let mut p = DVec2::new(place(x, i), place(y, j)) * side;
                if self.outline.y_up {
                    p.y = -p.y;
                }
                for (sum, c) in sum.iter_mut().zip(colour(centre + p)) {
                    *sum += c / f64::from(SAMPLES);
                }
            }
            sum.map(|c| c as u8)
        };
        let rows: Vec<Vec<u8>> = (0..size)
            .into_par_iter()
            .map(|y| {
                context.check()?;
                Ok((0..size).flat_map(|x| pixel(x, y)).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(RgbImage {
            width: size,
            height: size,
            rgb: rows.concat(),
        })
    }
}

/// The colour of a point, sRGB, by eroded rings.
fn eroded_colour(eroded: &ErodedSection, p: DVec2) -> [f64; 3] {
    match eroded.part_at(p) {
        None => BACKGROUND,
        Some(RingPart::Latewood) => LATEWOOD,
        Some(RingPart::Earlywood) => EARLYWOOD,
    }
}
