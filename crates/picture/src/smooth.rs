//! Denoising: an edge-avoiding à-trous wavelet filter (Dammertz et al. 2010) over the radiance divided by the colour of the
//! surface, guided by normals and distances. It removes the noise of few samples and preserves the texture of surfaces.

use crate::light::luminance;
use crate::scene::Sample;
use glam::DVec3;
use rayon::prelude::*;

/// The kernel of a cubic B-spline.
const KERNEL: [f64; 5] = [1.0 / 16.0, 1.0 / 4.0, 3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];
/// Distance between taps in each pass, pixels.
const TAP_DISTANCES: [i64; 3] = [1, 2, 4];
/// Relative difference of luminance that reduces the weight of a tap at one sample per pixel; it decreases with the square
/// root of the number of samples, as noise does.
const LUMINANCE_TOLERANCE: f64 = 1.6;
/// Squared difference of unit normals that reduces the weight of a tap.
const NORMAL_TOLERANCE: f64 = 0.02;
/// Difference of distance that reduces the weight of a tap, in sizes of a pixel for each pixel of its offset.
const DISTANCE_TOLERANCE: f64 = 3.0;
/// Smallest component of a colour by which radiance is divided.
const MIN_COLOR: f64 = 0.02;

/// Filters the mean samples of all pixels; `pixel_size` is that at a distance of one metre, m.
pub(crate) fn smooth(pixels: &[Sample], width: usize, pixel_size: f64) -> Vec<DVec3> {
    let size = [width, pixels.len() / width];
    let divisor = |s: &Sample| s.color.max(DVec3::splat(MIN_COLOR));
    let mut light: Vec<DVec3> = pixels.iter().map(|s| s.radiance / divisor(s)).collect();
    for (pass, tap_distance) in TAP_DISTANCES.into_iter().enumerate() {
        // The first pass ignores luminance, so that it removes single outliers. Each pass reduces the noise, so that the
        // tolerance decreases.
        let tolerance = if pass == 0 {
            f64::INFINITY
        } else {
            LUMINANCE_TOLERANCE / f64::from(1u32 << (pass - 1))
        };
        let pass = Pass {
            pixels,
            light: &light,
            size,
            pixel_size,
            tap_distance,
            tolerance,
        };
        let rows = (0..size[1]).into_par_iter();
        light = rows
            .flat_map_iter(|y| (0..width).map(move |x| pass.filtered(x, y)))
            .collect();
    }
    pixels
        .iter()
        .zip(light)
        .map(|(s, l)| l * divisor(s))
        .collect()
}

/// One pass of the filter.
#[derive(Clone, Copy)]
struct Pass<'a> {
    pixels: &'a [Sample],
    /// Radiance divided by colour.
    light: &'a [DVec3],
    /// Width and height.
    size: [usize; 2],
    pixel_size: f64,
    tap_distance: i64,
    /// Tolerance of luminance at one sample per pixel.
    tolerance: f64,
}

impl Pass<'_> {
    /// The filtered value of a pixel.
    fn filtered(&self, x: usize, y: usize) -> DVec3 {
        let [width, height] = self.size;
        let centre = y * width + x;
        let here = &self.pixels[centre];
        if !here.distance.is_finite() {
            return self.light[centre];
        }
        let tolerance = self.tolerance / f64::from(here.samples.max(1)).sqrt();
        let own_luminance = luminance(self.light[centre]) + 1e-3;
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (j, row) in KERNEL.iter().enumerate() {
            let b = y as i64 + (j as i64 - 2) * self.tap_distance;
            if b < 0 || b >= height as i64 {
                continue;
            }
            for (i, column) in KERNEL.iter().enumerate() {
                let a = x as i64 + (i as i64 - 2) * self.tap_distance;
                if a < 0 || a >= width as i64 {
                    continue;
                }
                let index = b as usize * width + a as usize;
                let there = &self.pixels[index];
                if !there.distance.is_finite() || there.is_item != here.is_item {
                    continue;
                }
                let steps = ((i as i64 - 2).abs() + (j as i64 - 2).abs()) as f64;
                let offset = steps * self.tap_distance as f64 + 1.0;
                let size = self.pixel_size * here.distance * DISTANCE_TOLERANCE * offset;
                let depth = (there.distance - here.distance) / size;
                let normal = (there.normal - here.normal).length_squared() / NORMAL_TOLERANCE;
                let brightness = (luminance(self.light[index]) / own_luminance - 1.0) / tolerance;
                let difference = depth * depth + normal + brightness * brightness;
                let weight = row * column / ((1.0 + difference) * (1.0 + difference));
                sum += self.light[index] * weight;
                total += weight;
            }
        }
        sum / total
    }
}
