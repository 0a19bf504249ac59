//! The grain of a photograph: the noise of its sensor, of which light parts have more than dark ones, as photons come at random.

use crate::sampling::hash;
use glam::{Vec3, Vec4, Vec4Swizzles};

/// Standard deviation of a grain of 1 where it is strongest, about a third of white, levels of 255.
const STRONGEST: f32 = 10.0;
/// Share of the noise that the three colours have each for themselves.
const COLORED: f32 = 0.3;
/// What dark parts have, and how much of it is lost towards white, where the tone curve is flat.
const IN_THE_DARK: f32 = 0.35;
const LOST_IN_WHITE: f32 = 0.6;
/// Shares of a pixel and its neighbours in a row: colours are found from several places of the sensor, so that noise is as wide as they.
const FILTER: [f32; 3] = [0.25, 0.5, 0.25];
/// Height (pixels) of a picture from which on it has the noise of each pixel; a smaller one is a reduced one of that height.
const FULL_HEIGHT: u32 = 900;

/// The grain of one picture.
pub(crate) struct Grain {
    strength: f32,
    seed: u32,
}

impl Grain {
    /// Grain of a strength of 0 to 1 in a picture of a height in pixels.
    pub fn new(strength: f64, height: u32, seed: u32) -> Grain {
        let reduced = height.min(FULL_HEIGHT) as f32 / FULL_HEIGHT as f32;
        Grain {
            strength: STRONGEST * strength as f32 * reduced,
            seed,
        }
    }

    /// The grain of a row of pixels.
    pub fn row(&self, y: usize, width: usize) -> Row {
        let strength = self.strength;
        if strength == 0.0 {
            let columns = Vec::new();
            return Row { strength, columns };
        }
        let seeds = [0, 1, 2, 3].map(|channel| hash(self.seed, channel));
        let column = |x: usize| {
            let columns = seeds.map(|seed| hash(seed, x as u32));
            let cells = (y..).zip(FILTER).map(|(y, part)| {
                part * Vec4::from(columns.map(|column| normal(hash(column, y as u32))))
            });
            cells.sum()
        };
        Row {
            strength,
            columns: (0..width + 2).map(column).collect(),
        }
    }
}

/// The grain of a row of pixels.
pub(crate) struct Row {
    strength: f32,
    /// Noise of all colours and of each, filtered along the columns, of which one more lies at either side; none without grain.
    columns: Vec<Vec4>,
}

impl Row {
    /// The levels of a pixel with its noise, 0 to 255.
    pub fn over(&self, levels: Vec3, x: usize) -> Vec3 {
        let Some(columns) = self.columns.get(x..x + FILTER.len()) else {
            return levels;
        };
        let light = (levels.element_sum() / (3.0 * 255.0)).clamp(0.0, 1.0);
        let strength = self.strength * (IN_THE_DARK + light.sqrt()) * (1.0 - LOST_IN_WHITE * light);
        let noise: Vec4 = columns.iter().zip(FILTER).map(|(c, part)| *c * part).sum();
        // The filter keeps this part of the standard deviation.
        let noise = noise / FILTER.map(|v| v * v).iter().sum::<f32>();
        let noise = Vec3::splat(noise.x) + noise.yzw() * COLORED;
        (levels + noise * strength).clamp(Vec3::ZERO, Vec3::splat(255.0))
    }
}

/// A number of a nearly normal distribution about 0 with a standard deviation of 1: the sum of four bytes.
fn normal(bits: u32) -> f32 {
    let sum: u32 = bits.to_le_bytes().into_iter().map(u32::from).sum();
    // Four uniform numbers of 0 to 255: a mean of 510 and a variance of 4 (256² − 1) / 12.
    (sum as f32 - 510.0) / 147.8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and standard deviation of the levels of an even grey with grain.
    fn statistics(strength: f64, height: u32, level: f32) -> (f32, f32) {
        let grain = Grain::new(strength, height, 7);
        let side = 300;
        let row = |y: usize| {
            let row = grain.row(y, side);
            (0..side).map(move |x| row.over(Vec3::splat(level), x).y)
        };
        let values: Vec<f32> = (0..side).flat_map(row).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let squares: f32 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        (mean, (squares / values.len() as f32).sqrt())
    }

    #[test]
    fn grain_keeps_the_brightness_and_is_as_strong_as_asked_for() {
        let (mean, deviation) = statistics(1.0, 900, 85.0);
        assert!((mean - 85.0).abs() < 0.2, "{mean}");
        let expected = STRONGEST
            * (IN_THE_DARK + (1.0f32 / 3.0).sqrt())
            * (1.0 - LOST_IN_WHITE / 3.0)
            * (1.0 + COLORED * COLORED).sqrt();
        assert!(
            (deviation / expected - 1.0).abs() < 0.05,
            "{deviation}, {expected}"
        );
        let (_, dark) = statistics(1.0, 900, 20.0);
        assert!(dark < 0.9 * deviation, "{dark}");
        // A picture of a third of the height is one whose pixels were averaged.
        let (_, reduced) = statistics(1.0, 300, 85.0);
        assert!((reduced / deviation - 1.0 / 3.0).abs() < 0.02, "{reduced}");
        assert_eq!(statistics(0.0, 900, 85.0), (85.0, 0.0));
    }
}
