//! Denoising of light: an edge-avoiding à-trous wavelet filter (Dammertz et al. 2010) guided by normals, planes, and the variance
//! of the light itself (Schied et al. 2017). It sees light without the colours of surfaces, so that it leaves wood sharp.

use crate::light::{Light, luminance};
use crate::surface::{Met, Place};
use rayon::prelude::*;

/// The kernels of a quadratic and a cubic B-spline.
const NARROW: [f32; 3] = [0.25, 0.5, 0.25];
const WIDE: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
/// Distance between taps in each pass after the first, pixels.
const TAP_DISTANCES: [i64; 4] = [2, 4, 8, 16];
/// Distance from the plane of a place beyond which another one is unlike it, pixels.
const PLANE_TOLERANCE: f32 = 1.5;
/// Difference of the cosine of normals from 1 that makes places unlike.
const NORMAL_TOLERANCE: f32 = 0.02;
/// Standard deviations by which the light of alike places may differ: fewer keep the edges of shadows and more noise.
const DEVIATIONS: f32 = 5.0;
/// Least standard deviations of the share of a lamp, and of indirect light relative to its luminance.
const MIN_DEVIATION: f32 = 0.01;
/// Number of values that are filtered, each with its own variance: the shares of the lamps and the luminance of indirect light.
const VALUES: usize = 3;

/// The places that pixels see.
#[derive(Clone, Copy)]
pub(crate) struct Neighbours<'a> {
    pub places: &'a [Place],
    /// Width and height.
    pub size: [usize; 2],
}

impl<'a> Neighbours<'a> {
    /// The index of a pixel at an offset from another one, if it is in the picture.
    pub fn index(&self, [x, y]: [usize; 2], [dx, dy]: [i64; 2]) -> Option<usize> {
        let (a, b) = (x as i64 + dx, y as i64 + dy);
        let is_inside = a >= 0 && b >= 0 && a < self.size[0] as i64 && b < self.size[1] as i64;
        is_inside.then(|| b as usize * self.size[0] + a as usize)
    }

    /// Visits the 24 pixels around one, as far as they are in the picture.
    pub fn visit_around(&self, [x, y]: [usize; 2], mut visit: impl FnMut(usize)) {
        let [width, height] = self.size;
        let columns = x.saturating_sub(2)..(x + 3).min(width);
        for row in y.saturating_sub(2)..(y + 3).min(height) {
            for column in columns.clone() {
                if [column, row] != [x, y] {
                    visit(row * width + column);
                }
            }
        }
    }

    /// The number of pixels around one that show the same surface, which count by how alike they are, of 24.
    pub fn support(&self, at: [usize; 2]) -> f32 {
        let here = &self.places[at[1] * self.size[0] + at[0]];
        let mut sum = 0.0;
        self.visit_around(at, |i| sum += likeness(here, &self.places[i]));
        sum
    }
}

/// How alike two places are lit, from 0 to 1.
pub(crate) fn likeness(here: &Place, there: &Place) -> f32 {
    if here.met != there.met || here.met == Met::Background {
        return 0.0;
    }
    // The floor is one plane.
    if here.met == Met::Floor {
        return 1.0;
    }
    let away = here.normal.dot(there.position - here.position) / (here.footprint * PLANE_TOLERANCE);
    let turned = (1.0 - here.normal.dot(there.normal)) / NORMAL_TOLERANCE;
    let difference = 1.0 + away * away + turned * turned;
    1.0 / (difference * difference)
}

/// Light with the variance of its values.
#[derive(Clone, Copy, Default)]
struct Noisy {
    light: Light,
    variance: [f32; VALUES],
}

/// The values whose variance is kept.
fn values(light: &Light) -> [f32; VALUES] {
    [light.lamps[0], light.lamps[1], luminance(light.indirect)]
}

/// Filters the light of all pixels.
pub(crate) fn smooth(neighbours: &Neighbours, light: Vec<Light>) -> Vec<Light> {
    let mut noisy = each(neighbours, |at| first_pass(neighbours, &light, at));
    drop(light);
    for distance in TAP_DISTANCES {
        noisy = each(neighbours, |at| {
            further_pass(neighbours, &noisy, at, distance)
        });
    }
    noisy.into_iter().map(|n| n.light).collect()
}

/// The values at all pixels, in rows.
fn each(neighbours: &Neighbours, value: impl Fn([usize; 2]) -> Noisy + Sync) -> Vec<Noisy> {
    let [width, height] = neighbours.size;
    let value = &value;
    (0..height)
        .into_par_iter()
        .flat_map_iter(move |y| (0..width).map(move |x| value([x, y])))
        .collect()
}

/// Averages alike places nearby whatever their light, which removes single outliers, and finds the variance of the mean.
fn first_pass(neighbours: &Neighbours, light: &[Light], at: [usize; 2]) -> Noisy {
    let centre = at[1] * neighbours.size[0] + at[0];
    let here = &neighbours.places[centre];
    if here.met.is_unlit() {
        return Noisy::default();
    }
    let mut sum = Noisy::default();
    let mut squares = [0.0; VALUES];
    let mut first = [0.0; VALUES];
    let (mut total, mut total_squared) = (0.0, 0.0);
    for (dy, row) in (-2..).zip(WIDE) {
        for (dx, column) in (-2..).zip(WIDE) {
            let Some(index) = neighbours.index(at, [dx, dy]) else {
                continue;
            };
            let weight = row * column * likeness(here, &neighbours.places[index]);
            if weight < 1e-6 {
                continue;
            }
            let there = &light[index];
            for c in 0..2 {
                sum.light.lamps[c] += there.lamps[c] * weight;
            }
            sum.light.indirect += there.indirect * weight;
            for (c, v) in values(there).into_iter().enumerate() {
                first[c] += v * weight;
                squares[c] += v * v * weight;
            }
            total += weight;
            total_squared += weight * weight;
        }
    }
    let mean = 1.0 / total;
    sum.light.lamps = sum.light.lamps.map(|v| v * mean);
    sum.light.indirect *= mean;
    for c in 0..VALUES {
        let m = first[c] * mean;
        // The variance of the mean of weighted values.
        let own = (squares[c] * mean - m * m).max(0.0);
        sum.variance[c] = own * total_squared * mean * mean;
    }
    sum
}

/// Averages alike places whose light differs by no more than noise.
fn further_pass(neighbours: &Neighbours, noisy: &[Noisy], at: [usize; 2], distance: i64) -> Noisy {
    let centre = at[1] * neighbours.size[0] + at[0];
    let here = &neighbours.places[centre];
    let own = noisy[centre];
    if here.met.is_unlit() {
        return own;
    }
    let own_values = values(&own.light);
    let least = [1.0, 1.0, own_values[2]].map(|scale| MIN_DEVIATION * scale + 1e-6);
    let tolerance: [f32; VALUES] =
        std::array::from_fn(|c| DEVIATIONS * DEVIATIONS * (own.variance[c] + least[c] * least[c]));
    let mut sum = Noisy::default();
    let mut total = [0.0; VALUES];
    for (dy, row) in (-1..).zip(NARROW) {
        for (dx, column) in (-1..).zip(NARROW) {
            let Some(index) = neighbours.index(at, [dx * distance, dy * distance]) else {
                continue;
            };
            let alike = row * column * likeness(here, &neighbours.places[index]);
            if alike < 1e-6 {
                continue;
            }
            let there = &noisy[index];
            let there_values = values(&there.light);
            let weights: [f32; VALUES] = std::array::from_fn(|c| {
                let difference = there_values[c] - own_values[c];
                let d = 1.0 + difference * difference / tolerance[c];
                alike / (d * d)
            });
            for ((lamp, share), weight) in (sum.light.lamps.iter_mut())
                .zip(there.light.lamps)
                .zip(weights)
            {
                *lamp += share * weight;
            }
            sum.light.indirect += there.light.indirect * weights[2];
            for c in 0..VALUES {
                sum.variance[c] += there.variance[c] * weights[c] * weights[c];
                total[c] += weights[c];
            }
        }
    }
    for (lamp, total) in sum.light.lamps.iter_mut().zip(total) {
        *lamp /= total;
    }
    sum.light.indirect /= total[2];
    for (variance, total) in sum.variance.iter_mut().zip(total) {
        *variance /= total * total;
    }
    sum
}
