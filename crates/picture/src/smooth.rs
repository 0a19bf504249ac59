//! Takes the grain of few samples out of the light, not out of the surface: an edge-avoiding à-trous wavelet filter
//! (Dammertz and others 2010) over the light divided by the surface's colour, guided by normals and distances.

use crate::scene::Seen;
use glam::DVec3;
use rayon::prelude::*;

/// The kernel of a cubic B-spline.
const KERNEL: [f64; 5] = [1.0 / 16.0, 1.0 / 4.0, 3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];
/// Distance between taps in each pass, pixels.
const STEPS: [i64; 3] = [1, 2, 4];
/// Relative difference of brightness that halves a tap's weight at one sample per pixel; noise falls with the root
/// of the number of samples, and so does what counts as noise.
const BRIGHTNESS: f64 = 1.6;
/// Squared difference of unit normals that halves a tap's weight.
const NORMAL: f64 = 0.02;
/// Difference of distance, in pixels' sizes per pixel of the tap's offset, that halves a tap's weight.
const DISTANCE: f64 = 3.0;
/// Colours darker than this are not divided by.
const DARKEST: f64 = 0.02;

/// Smooths the pixels' means; `pixel` is the size of a pixel one metre ahead, m.
pub(crate) fn smooth(seen: &[Seen], width: usize, pixel: f64) -> Vec<DVec3> {
    let height = seen.len() / width;
    let divisor = |s: &Seen| s.color.max(DVec3::splat(DARKEST));
    let mut light: Vec<DVec3> = seen.iter().map(|s| s.light / divisor(s)).collect();
    for (pass, step) in STEPS.into_iter().enumerate() {
        // The first pass goes by shape alone, so that single stray pixels dissolve. Each pass takes noise out, so
        // less of a difference is noise in the next.
        let tolerance = if pass == 0 {
            f64::INFINITY
        } else {
            BRIGHTNESS / f64::from(1u32 << (pass - 1))
        };
        light = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                let light = &light;
                (0..width)
                    .map(move |x| tap(seen, light, [width, height], [x, y], step, pixel, tolerance))
            })
            .collect();
    }
    seen.iter()
        .zip(light)
        .map(|(s, l)| l * divisor(s))
        .collect()
}

fn tap(
    seen: &[Seen],
    light: &[DVec3],
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    step: i64,
    pixel: f64,
    tolerance: f64,
) -> DVec3 {
    let centre = y * width + x;
    let here = &seen[centre];
    if !here.distance.is_finite() {
        return light[centre];
    }
    let tolerance = tolerance / f64::from(here.samples.max(1)).sqrt();
    let brightness = crate::light::luminance(light[centre]) + 1e-3;
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for (j, row) in KERNEL.iter().enumerate() {
        let b = y as i64 + (j as i64 - 2) * step;
        if b < 0 || b >= height as i64 {
            continue;
        }
        for (i, column) in KERNEL.iter().enumerate() {
            let a = x as i64 + (i as i64 - 2) * step;
            if a < 0 || a >= width as i64 {
                continue;
            }
            let index = b as usize * width + a as usize;
            let there = &seen[index];
            if !there.distance.is_finite() || there.item != here.item {
                continue;
            }
            let apart = ((i as i64 - 2).abs() + (j as i64 - 2).abs()) as f64 * step as f64 + 1.0;
            let size = pixel * here.distance * DISTANCE * apart;
            let deeper = (there.distance - here.distance) / size;
            let turned = (there.normal - here.normal).length_squared() / NORMAL;
            let brighter = (crate::light::luminance(light[index]) / brightness - 1.0) / tolerance;
            let off = deeper * deeper + turned + brighter * brighter;
            let weight = row * column / ((1.0 + off) * (1.0 + off));
            sum += light[index] * weight;
            total += weight;
        }
    }
    sum / total
}
