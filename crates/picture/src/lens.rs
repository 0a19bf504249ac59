//! The softness of a lens: its glass spreads every point a little, and scatters a small part of the light about, so that what is bright
//! has a faint glow and no edge is as sharp as a pixel.

use crate::enlarge::enlarge;
use glam::Vec3;
use rayon::prelude::*;

/// Standard deviation to which a softness of 1 spreads a point, pixels.
const SPREAD: f32 = 1.5;
/// Height (pixels) of a picture from which on it has all of that; a smaller one is a reduced one of that height.
const FULL_HEIGHT: f32 = 900.0;
/// What a softness of 1 scatters: standard deviation, in heights of the picture, and share of the light.
const GLARE: [(f32, f32); 2] = [(5.5e-3, 0.024), (0.055, 0.012)];
/// Standard deviation below which nothing is spread, pixels.
const LEAST_DEVIATION: f32 = 0.1;
/// Standard deviation in blocks of pixels down to which the means of blocks stand for pixels.
const COARSEST_DEVIATION: f32 = 2.4;
/// Deviations to which weights are summed.
const REACH: f32 = 3.5;
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
    let mut side = 1;
    while deviation >= COARSEST_DEVIATION * 2.0 * side as f32 {
        side *= 2;
    }
    if side == 1 {
        return spread_pixels(pixels, size, deviation);
    }
    // The mean over a block and what lies between the middles of blocks spread light by side² / 12 and side² / 6, too.
    let width = side as f32;
    let square = deviation * deviation - 0.25 * width * width;
    let (means, blocks) = block_means(pixels, size, side);
    let spread = spread_pixels(&means, blocks, square.sqrt() / width);
    enlarge(&spread, blocks, size, [1.0 / width; 2])
}

/// The same, pixel by pixel.
fn spread_pixels(pixels: &[Vec3], size: [usize; 2], deviation: f32) -> Vec<Vec3> {
    let across = turned(&summed(pixels, size, deviation), size);
    let size = [size[1], size[0]];
    turned(&summed(&across, size, deviation), size)
}

/// The means of square blocks of pixels, and how many there are; blocks at the edges have fewer pixels.
fn block_means(
    pixels: &[Vec3],
    [width, height]: [usize; 2],
    side: usize,
) -> (Vec<Vec3>, [usize; 2]) {
    let blocks = [width, height].map(|n| n.div_ceil(side));
    let mean = |i: usize| {
        let [x, y] = [i % blocks[0], i / blocks[0]].map(|k| k * side);
        let (right, bottom) = ((x + side).min(width), (y + side).min(height));
        let rows = (y..bottom).map(|row| &pixels[row * width + x..row * width + right]);
        let sum: Vec3 = rows.flatten().sum();
        sum / ((right - x) * (bottom - y)) as f32
    };
    let count = blocks[0] * blocks[1];
    ((0..count).into_par_iter().map(mean).collect(), blocks)
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
