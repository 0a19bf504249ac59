//! The softness of a lens: its glass spreads every point a little, and scatters a small part of the light about, so that what is bright
//! has a faint glow and no edge is as sharp as a pixel.

use glam::Vec3;
use rayon::prelude::*;

/// Standard deviation to which a softness of 1 spreads a point, pixels.
const SPREAD: f32 = 1.5;
/// Height (pixels) of a picture from which on it has all of that; a smaller one is a reduced one of that height.
const FULL_HEIGHT: f32 = 900.0;
/// What a softness of 1 scatters: standard deviation, in heights of the picture, and share of the light.
const GLARE: [(f32, f32); 2] = [(5.5e-3, 0.024), (0.055, 0.012)];
/// Standard deviation below which nothing is spread, pixels, and that up to which weights are summed pixel by pixel.
const LEAST_DEVIATION: f32 = 0.1;
const LARGEST_SUMMED: f32 = 6.0;
/// Deviations to which weights are summed.
const REACH: f32 = 3.5;
/// Means over a row of pixels that follow each other are nearly normal (Wells 1986).
const BOXES: usize = 3;
/// Columns that are turned into rows at once.
const TURNED_TOGETHER: usize = 16;

/// A picture as a lens of a softness of 0 to 1 shows it.
pub(crate) fn soften(pixels: Vec<Vec3>, size: [usize; 2], softness: f64) -> Vec<Vec3> {
    if softness == 0.0 {
        return pixels;
    }
    let (softness, height) = (softness as f32, size[1] as f32);
    let sharpest = SPREAD * softness * (height / FULL_HEIGHT).min(1.0);
    let mut sum = spread(&pixels, size, sharpest);
    let scattered: f32 = GLARE.iter().map(|g| softness * g.1).sum();
    sum.par_iter_mut().for_each(|p| *p *= 1.0 - scattered);
    for (deviation, share) in GLARE {
        let glow = spread(&pixels, size, deviation * height);
        (sum.par_iter_mut().zip(&glow)).for_each(|(p, glow)| *p += *glow * (softness * share));
    }
    sum
}

/// Pixels spread by a normal distribution of a standard deviation; those at the edges go on beyond them.
fn spread(pixels: &[Vec3], size: [usize; 2], deviation: f32) -> Vec<Vec3> {
    if deviation < LEAST_DEVIATION {
        return pixels.to_vec();
    }
    let once = |pixels: &[Vec3], size: [usize; 2]| match deviation <= LARGEST_SUMMED {
        true => summed(pixels, size, deviation),
        false => {
            // The variance of a mean over n pixels is (n² − 1) / 12.
            let square = 12.0 * deviation * deviation / BOXES as f32 + 1.0;
            let reach = (0.5 * (square.sqrt() - 1.0)).round() as usize;
            (0..BOXES).fold(pixels.to_vec(), |p, _| averaged(&p, size, reach))
        }
    };
    let across = turned(&once(pixels, size), size);
    let size = [size[1], size[0]];
    turned(&once(&across, size), size)
}

/// Rows and columns exchanged.
fn turned(pixels: &[Vec3], [width, height]: [usize; 2]) -> Vec<Vec3> {
    let mut turned = vec![Vec3::ZERO; pixels.len()];
    // Some columns at once use all of each line of the cache that they read.
    let columns = turned.par_chunks_mut(TURNED_TOGETHER * height).enumerate();
    columns.for_each(|(k, columns)| {
        let first = k * TURNED_TOGETHER;
        for y in 0..height {
            let row = &pixels[y * width + first..(y + 1) * width];
            for (pixel, column) in row.iter().zip(columns.chunks_mut(height)) {
                column[y] = *pixel;
            }
        }
    });
    turned
}

/// Sums of the pixels of each row around each, by normal weights.
fn summed(pixels: &[Vec3], [width, _]: [usize; 2], deviation: f32) -> Vec<Vec3> {
    let reach = (REACH * deviation).ceil() as i64;
    let weight = |k: i64| libm::expf(-0.5 * (k as f32 / deviation).powi(2));
    let total: f32 = (-reach..=reach).map(weight).sum();
    let weights: Vec<f32> = (-reach..=reach).map(|k| weight(k) / total).collect();
    let last = width as i64 - 1;
    let pixel = |row: &[Vec3], x: i64| {
        let places = (x - reach..=x + reach).map(|k| k.clamp(0, last) as usize);
        places.zip(&weights).map(|(k, w)| row[k] * *w).sum::<Vec3>()
    };
    rows(pixels, width, |row, out| {
        (0..).zip(out).for_each(|(x, out)| *out = pixel(row, x));
    })
}

/// Means of the pixels of each row at most `reach` from each.
fn averaged(pixels: &[Vec3], [width, _]: [usize; 2], reach: usize) -> Vec<Vec3> {
    let part = 1.0 / (2 * reach + 1) as f64;
    rows(pixels, width, |row, out| {
        let at = |k: i64| row[k.clamp(0, width as i64 - 1) as usize].as_dvec3();
        let reach = reach as i64;
        let mut sum: glam::DVec3 = (-reach - 1..reach).map(at).sum();
        for (x, out) in (0..).zip(out) {
            sum += at(x + reach) - at(x - reach - 1);
            *out = (sum * part).as_vec3();
        }
    })
}

/// Pixels of which each row is made of the same row of others.
fn rows(pixels: &[Vec3], width: usize, make: impl Fn(&[Vec3], &mut [Vec3]) + Sync) -> Vec<Vec3> {
    let mut made = vec![Vec3::ZERO; pixels.len()];
    let pairs = pixels.par_chunks(width).zip(made.par_chunks_mut(width));
    pairs.for_each(|(row, out)| make(row, out));
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [301, 241];

    fn point() -> Vec<Vec3> {
        let mut pixels = vec![Vec3::ZERO; SIZE[0] * SIZE[1]];
        pixels[SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2] = Vec3::splat(1.0);
        pixels
    }

    #[test]
    fn a_point_is_spread_as_far_as_it_should_be_and_keeps_its_light() {
        for deviation in [0.7, 1.9, 5.9, 6.1, 20.0] {
            let spread = spread(&point(), SIZE, deviation);
            let (mut light, mut moment) = (0.0f64, [0.0f64; 2]);
            for (i, p) in spread.iter().enumerate() {
                let at = [i % SIZE[0], i / SIZE[0]];
                light += f64::from(p.y);
                for axis in 0..2 {
                    let off = at[axis] as f64 - (SIZE[axis] / 2) as f64;
                    moment[axis] += f64::from(p.y) * off * off;
                }
            }
            assert!((light - 1.0).abs() < 1e-3, "{deviation}: {light}");
            for moment in moment {
                let found = moment.sqrt() / f64::from(deviation);
                assert!((0.9..1.1).contains(&found), "{deviation}: {found}");
            }
        }
    }

    #[test]
    fn an_even_picture_stays_even_and_none_is_softened_by_nothing() {
        let even = vec![Vec3::new(0.2, 0.4, 0.6); SIZE[0] * SIZE[1]];
        let soft = soften(even.clone(), SIZE, 1.0);
        assert!(even.iter().zip(&soft).all(|(a, b)| a.abs_diff_eq(*b, 1e-5)));
        assert_eq!(soften(point(), SIZE, 0.0), point());
        // One pixel each way.
        assert_eq!(soften(vec![Vec3::ONE], [1, 1], 1.0).len(), 1);
    }
}
