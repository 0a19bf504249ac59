//! Denoising of light: an edge-avoiding à-trous wavelet filter (Dammertz et al. 2010) guided by normals, planes, and the variance
//! of the light itself (Schied et al. 2017). It sees light without the colours of surfaces, so that it leaves wood sharp.

use crate::light::{Light, Traced, luminance};
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
    let turned = (1.0 - here.normal.dot(there.normal)) * (1.0 / NORMAL_TOLERANCE);
    let difference = 1.0 + away * away + turned * turned;
    1.0 / (difference * difference)
}

/// Light with the variance of its [`values`]; as small as can be, because filtering waits for memory.
#[derive(Clone, Copy, Default)]
struct Noisy {
    light: Light,
    variance: [f32; 3],
}

impl Noisy {
    fn new(light: Light, variance: Vec4) -> Self {
        Noisy {
            light,
            variance: variance.truncate().to_array(),
        }
    }

    fn variance(&self) -> Vec4 {
        Vec3::from_array(self.variance).extend(0.0)
    }
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

/// Filters the light of all pixels. Those without light of their own get that of alike ones around.
pub(crate) fn smooth(neighbours: &Neighbours, light: Vec<Traced>) -> Vec<Light> {
    let [width, height] = neighbours.size;
    let mut noisy = vec![Noisy::default(); width * height];
    fill(neighbours, &mut noisy, |at| {
        first_pass(neighbours, &light, at)
    });
    drop(light);
    // Two lists in turn: new ones would cost as much as a pass.
    let mut next = vec![Noisy::default(); width * height];
    for distance in TAP_DISTANCES {
        fill(neighbours, &mut next, |at| {
            further_pass(neighbours, &noisy, at, distance)
        });
        std::mem::swap(&mut noisy, &mut next);
    }
    noisy.into_iter().map(|n| n.light).collect()
}

/// Sets the values at all pixels, in rows.
fn fill(neighbours: &Neighbours, all: &mut [Noisy], value: impl Fn([usize; 2]) -> Noisy + Sync) {
    let rows = all.par_chunks_mut(neighbours.size[0]).enumerate();
    rows.for_each(|(y, row)| {
        for (x, noisy) in row.iter_mut().enumerate() {
            *noisy = value([x, y]);
        }
    });
}

/// Averages alike places nearby whatever their light, which removes single outliers, and finds the variance of the mean.
fn first_pass(neighbours: &Neighbours, light: &[Traced], at: [usize; 2]) -> Noisy {
    let centre = at[1] * neighbours.size[0] + at[0];
    let here = &neighbours.places[centre];
    if here.met.is_unlit() {
        return Noisy::default();
    }
    let mut sum = WeightedLight::default();
    let (mut first, mut squares) = (Vec4::ZERO, Vec4::ZERO);
    let mut total_squared = Vec4::ZERO;
    for (dy, row) in (-2..).zip(WIDE) {
        for (dx, column) in (-2..).zip(WIDE) {
            let Some(index) = neighbours.index(at, [dx, dy]) else {
                continue;
            };
            let weight = row * column * likeness(here, &neighbours.places[index]);
            if weight < 1e-6 {
                continue;
            }
            let Traced {
                light: there,
                has_key,
                has_rest,
            } = &light[index];
            let [key, rest] = [*has_key, *has_rest].map(|has| if has { weight } else { 0.0 });
            let weights = Vec4::new(key, rest, rest, rest);
            let v = values(there);
            sum.add(there, v, weights);
            first += v * weights;
            squares += v * v * weights;
            total_squared += weights * weights;
        }
    }
    let mean = 1.0 / sum.total;
    let m = first * mean;
    // The variance of the mean of weighted values.
    let own = (squares * mean - m * m).max(Vec4::ZERO);
    Noisy::new(sum.mean(), own * (total_squared * mean * mean))
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
    let per_tolerance = Vec4::ONE / ((own.variance() + least * least) * (DEVIATIONS * DEVIATIONS));
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
            let d = Vec4::ONE + difference * difference * per_tolerance;
            let weights = alike / (d * d);
            sum.add(&there.light, there_values, weights);
            variance += there.variance() * weights * weights;
        }
    }
    Noisy::new(sum.mean(), variance / (sum.total * sum.total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_without_light_of_their_own_get_that_of_those_around() {
        let size = [24, 16];
        let place = |met| Place {
            met,
            position: Vec3::ZERO,
            normal: Vec3::Z,
            geometric_normal: Vec3::Z,
            footprint: 1.0,
            is_fibrous: false,
        };
        // A floor with a wall beside it.
        let places: Vec<Place> = (0..size[0] * size[1])
            .map(|i| {
                place(if i % size[0] < 12 {
                    Met::Floor
                } else {
                    Met::Item(0)
                })
            })
            .collect();
        let lit = |at: usize| Light {
            lamps: [if at % size[0] < 12 { 0.25 } else { 0.75 }, 0.5],
            indirect: Vec3::new(0.1, 0.2, 0.3),
        };
        let traced = |at: usize| {
            let [x, y] = [at % size[0], at / size[0]];
            let has_rest = x.is_multiple_of(2) && y.is_multiple_of(2);
            let has_key = has_rest || at.is_multiple_of(7);
            let light = if has_key { lit(at) } else { Light::default() };
            Traced {
                light,
                has_key,
                has_rest,
            }
        };
        let neighbours = Neighbours {
            places: &places,
            size,
        };
        let smooth = smooth(&neighbours, (0..places.len()).map(traced).collect());
        for (at, light) in smooth.iter().enumerate() {
            let expected = lit(at);
            assert!(
                (light.lamps[0] - expected.lamps[0]).abs() < 1e-5,
                "{at}: {light:?}"
            );
            assert!(
                (light.lamps[1] - expected.lamps[1]).abs() < 1e-5,
                "{at}: {light:?}"
            );
            assert!(
                light.indirect.abs_diff_eq(expected.indirect, 1e-5),
                "{at}: {light:?}"
            );
        }
    }
}
