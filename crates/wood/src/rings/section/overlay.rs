//! Rings drawn over a photograph of their section (Forests 2023, Fig. 13).

use super::rings::SectionRings;
use crate::colour::RgbImage;
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};

/// Colours that stand out from wood, sRGB: the outline, rings, the pith.
const OUTLINE: [u8; 3] = [0, 114, 178];
const RING: [u8; 3] = [230, 30, 30];
const PITH: [u8; 3] = [0, 158, 115];
/// Width of lines, as a part of the photograph's smaller side, and the least, pixels.
const LINE_WIDTH: f64 = 1.0 / 500.0;
const MIN_LINE_WIDTH: f64 = 1.4;
/// Half the length of the cross at the pith, in widths of a line.
const CROSS_ARM: f64 = 5.0;

impl SectionRings {
    /// Draws outline, rings and pith over a photograph. The section's coordinates are the photograph's pixels, from the middle of
    /// the upper left one; where its y points up, from the lower left one.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint_over(&self, photo: &RgbImage, context: &Context) -> Result<RgbImage, Cancelled> {
        let mut image = photo.clone();
        let smaller = f64::from(photo.width.min(photo.height));
        let width = (LINE_WIDTH * smaller).max(MIN_LINE_WIDTH);
        let flip = self.outline.y_up;
        let pixel = |p: &DVec2| {
            let y = if flip {
                f64::from(photo.height) - 1.0 - p.y
            } else {
                p.y
            };
            DVec2::new(p.x, y)
        };
        for curve in self.curves(context)? {
            let points: Vec<DVec2> = curve.points.iter().map(pixel).collect();
            draw_closed(&mut image, &points, width, RING);
        }
        let outline: Vec<DVec2> = self.outline.points.iter().map(pixel).collect();
        draw_closed(&mut image, &outline, width, OUTLINE);
        let pith = pixel(&self.pith());
        for arm in [DVec2::X, DVec2::Y] {
            let arm = arm * CROSS_ARM * width;
            draw_closed(&mut image, &[pith - arm, pith + arm], 1.5 * width, PITH);
        }
        Ok(image)
    }
}

/// Draws a closed line through points, with smooth edges.
fn draw_closed(image: &mut RgbImage, points: &[DVec2], width: f64, colour: [u8; 3]) {
    // Each pixel once, however many segments reach it: by row, the coverage of its pixels.
    let mut covered = std::collections::BTreeMap::<usize, f64>::new();
    let reach = 0.5 * width + 1.0;
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    for (i, &a) in points.iter().enumerate() {
        let b = points[(i + 1) % points.len()];
        let low = (a.min(b) - reach).max(DVec2::ZERO).ceil();
        let high = (a.max(b) + reach).min(size - 1.0).floor();
        let (mut y, along) = (low.y, b - a);
        while y <= high.y {
            let mut x = low.x;
            while x <= high.x {
                let p = DVec2::new(x, y);
                let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                let distance = p.distance(a + along * t);
                let coverage = (0.5 * width + 0.5 - distance).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    let pixel = y as usize * image.width as usize + x as usize;
                    let most = covered.entry(pixel).or_default();
                    *most = most.max(coverage);
                }
                x += 1.0;
            }
            y += 1.0;
        }
    }
    for (pixel, coverage) in covered {
        for (old, new) in image.rgb[3 * pixel..3 * pixel + 3].iter_mut().zip(colour) {
            let mixed = f64::from(*old) + (f64::from(new) - f64::from(*old)) * coverage;
            *old = mixed.round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rings::{RingSeries, SectionOutline, SectionRingMethod};
    use std::f64::consts::TAU;

    #[test]
    fn rings_lie_over_the_photograph_where_they_are() {
        let points = (0..90).map(|i| DVec2::from_angle(f64::from(i) * TAU / 90.0));
        let outline = SectionOutline {
            points: points.map(|d| DVec2::new(60.0, 50.0) + d * 40.0).collect(),
            pith: Some(DVec2::new(60.0, 50.0)),
            y_up: false,
            eccentricity_onset: None,
        };
        let method = SectionRingMethod::Field(RingSeries::Number(2));
        let rings = SectionRings::new(outline, &method, &Context::quiet()).unwrap();
        let photo = RgbImage {
            width: 120,
            height: 110,
            rgb: vec![200; 3 * 120 * 110],
        };
        let over = rings.paint_over(&photo, &Context::quiet()).unwrap();
        let at = |x: usize, y: usize| {
            let i = 3 * (y * 120 + x);
            [over.rgb[i], over.rgb[i + 1], over.rgb[i + 2]]
        };
        // The inner ring is 20 in radius, the outline 40; between them and outside is the photograph.
        assert_eq!(at(80, 50), RING);
        assert_eq!(at(60, 70), RING);
        assert_eq!(at(100, 50), OUTLINE);
        assert_eq!(at(60, 50), PITH);
        assert_eq!((at(90, 50), at(110, 50)), ([200; 3], [200; 3]));
    }
}
