//! Denoising of light: an edge-avoiding à-trous wavelet filter (Dammertz et al. 2010) guided by normals, planes, and the variance
//! of the light itself (Schied et al. 2017). It sees light without the colours of surfaces, so that it leaves wood sharp.

use crate::light::{Light, luminance};
use crate::surface::{Met, Place};
use glam::{Vec3, Vec4};
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

/// Light with the variance of its [`values`].
#[derive(Clone, Copy, Default)]
struct Noisy {
    light: Light,
    variance: Vec4,
}

/// What is filtered, each with a variance of its own: the shares of the lamps and the luminance of indirect light; the last is 0.
fn values(light: &Light) -> Vec4 {
    let [key, rim] = light.lamps;
    Vec4::new(key, rim, luminance(light.indirect), 0.0)
}

/// The sum of weighted light; each of its values has a weight of its own.
#[derive(Default)]
struct WeightedLight {
    lamps: Vec4,
    indirect: Vec3,
    total: Vec4,
}

impl WeightedLight {
    #[inline]
    fn add(&mut self, light: &Light, values: Vec4, weights: Vec4) {
        self.lamps += values * weights;
        self.indirect += light.indirect * weights.z;
        self.total += weights;
    }

    fn mean(&self) -> Light {
        let lamps = self.lamps / self.total;
        Light {
            lamps: [lamps.x, lamps.y],
            indirect: self.indirect / self.total.z,
        }
    }
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
    let mut all = vec![Noisy::default(); width * height];
    let rows = all.par_chunks_mut(width).enumerate();
    rows.for_each(|(y, row)| {
        for (x, noisy) in row.iter_mut().enumerate() {
            *noisy = value([x, y]);
        }
    });
    all
}

/// Averages alike places nearby whatever their light, which removes single outliers, and finds the variance of the mean.
fn first_pass(neighbours: &Neighbours, light: &[Light], at: [usize; 2]) -> Noisy {
    let centre = at[1] * neighbours.size[0] + at[0];
    let here = &neighbours.places[centre];
    if here.met.is_unlit() {
        return Noisy::default();
    }
    let mut sum = WeightedLight::default();
    let (mut first, mut squares) = (Vec4::ZERO, Vec4::ZERO);
    let mut total_squared = 0.0;
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
            let v = values(there);
            sum.add(there, v, Vec4::splat(weight));
            first += v * weight;
            squares += v * v * weight;
            total_squared += weight * weight;
        }
    }
    let mean = 1.0 / sum.total.x;
    let m = first * mean;
    // The variance of the mean of weighted values.
    let own = (squares * mean - m * m).max(Vec4::ZERO);
    Noisy {
        light: sum.mean(),
        variance: own * (total_squared * mean * mean),
    }
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
    let scale = Vec4::new(1.0, 1.0, own_values.z, 1.0);
    let least = scale * MIN_DEVIATION + Vec4::splat(1e-6);
    let tolerance = (own.variance + least * least) * (DEVIATIONS * DEVIATIONS);
    let mut sum = WeightedLight::default();
    let mut variance = Vec4::ZERO;
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
            let difference = there_values - own_values;
            let d = Vec4::ONE + difference * difference / tolerance;
            let weights = alike / (d * d);
            sum.add(&there.light, there_values, weights);
            variance += there.variance * weights * weights;
        }
    }
    Noisy {
        light: sum.mean(),
        variance: variance / (sum.total * sum.total),
    }
}
