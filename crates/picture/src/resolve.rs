//! The steps of a picture pixel by pixel: what is seen, its light, and what becomes of the pixel. One ray through the middle is enough
//! for most pixels; those with an edge or strong detail take more, lit by the light that was found around them.

use crate::camera::Camera;
use crate::denoise::{Neighbours, likeness};
use crate::focus::Focus;
use crate::layers::Pixel;
use crate::light::{Light, Studio, Traced, luminance};
use crate::sampling::{Purpose, Sampler};
use crate::scene::Scene;
use crate::surface::{Met, Place, Seen};
use glam::Vec3;

/// Pixels around one that show its surface too, of 24, below which it takes twice as many rays for its light: the filter
/// cannot help it.
const LITTLE_SUPPORT: f32 = 8.0;
/// The same from which on a surface is smooth.
const SMOOTH_SUPPORT: f32 = 14.0;
/// Difference of the shares of the key light around a pixel in its soft shadow.
const SOFT_SHADOW: f32 = 0.2;
/// How many times as many rays to the key light a pixel in its soft shadow takes.
const MORE_RAYS: u32 = 4;
/// Side of cells, pixels: light on smooth surfaces is traced at the first pixel of one alone, and a ground that is spread far has one colour
/// there.
pub(crate) const CELL: usize = 2;
/// Likeness to the first pixel of its cell from which on another one goes without light of its own.
const FILLED_IN_LIKENESS: f32 = 0.5;
/// Difference of the indirect light around a pixel, as a part of the greatest, from which on it needs light of its own.
const VARIED_INDIRECT: f32 = 0.85;
/// Likeness of neighbours below which there is an edge between them.
const EDGE_LIKENESS: f32 = 0.2;
/// Difference of luminance between neighbours, as a part of their sum, from which one ray does not stand for a pixel.
const DETAIL_CONTRAST: f32 = 0.4;
/// The same between the first rays of a pixel, from which on more are needed.
const RAY_CONTRAST: f32 = 0.35;
/// Rays of a pixel before it is decided whether the others are needed.
pub(crate) const FIRST_RAYS: u32 = 4;
/// Relative standard error of the mean of a pixel's rays below which no more are needed. The rays are stratified: the true error is well
/// below that of independent ones.
const MEAN_ERROR: f32 = 0.3;
/// Contrast of colours and cosine of normals of the same item in a pixel from which on rays do not take the appearance of others.
const VARIED_COLOR: f32 = 0.2;
const VARIED_NORMAL: f32 = 0.9;
/// How many times as far as an item something lies past its outline.
const FARTHER: f32 = 1.03;
/// Rays per pixel from which on every pixel takes all of them.
pub(crate) const RAYS_FOR_ALL: u32 = 64;
/// Radius of the disc of an unsharp pixel from which on one ray of each kind stands for it, pixels.
const ONE_RAY_RADIUS: f32 = 2.5;
/// Radius of the disc of a pixel from which on what is around it is spread over it enough for half as many rays.
const UNSHARP_RADIUS: f32 = 1.5;
/// Part of the radius of a disc over which detail of the ground is averaged before it is spread over the disc: what is as fine is lost in both.
const AVERAGED: f32 = 0.5;
/// Likeness of places around that together suffice to light a place.
const MIN_LIKENESS: f32 = 0.05;
/// Luminance that is added to both where contrast is measured: darkness hides it.
const CONTRAST_BASE: f32 = 0.02;

/// Shares of a pixel and its neighbours in a row where the middles of pixels stand for the pixel filter.
const FILTER: [f32; 3] = [0.14, 0.72, 0.14];

/// The least and the greatest of some numbers.
#[derive(Clone, Copy)]
struct Extremes {
    low: f32,
    high: f32,
}

impl Extremes {
    const NONE: Extremes = Extremes {
        low: f32::INFINITY,
        high: f32::NEG_INFINITY,
    };

    fn include(&mut self, value: f32) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    fn width(&self) -> f32 {
        self.high - self.low
    }
}

/// What a picture is made of.
pub(crate) struct Frame<'a> {
    pub scene: &'a Scene<'a>,
    pub studio: &'a Studio,
    pub camera: &'a Camera,
    /// Width and height.
    pub size: [usize; 2],
    /// Most camera rays per pixel.
    pub samples: u32,
    /// Rays for light per pixel where the filter finds enough pixels of the same surface.
    pub rays: u32,
}

impl Frame<'_> {
    /// A point of the picture at an offset from the middle of a pixel, in pixels, in coordinates from −1 to 1.
    fn point(&self, [x, y]: [usize; 2], [dx, dy]: [f32; 2]) -> [f64; 2] {
        let [width, height] = self.size.map(|n| n as f64);
        [
            (x as f64 + 0.5 + f64::from(dx)) / width * 2.0 - 1.0,
            1.0 - (y as f64 + 0.5 + f64::from(dy)) / height * 2.0,
        ]
    }

    /// What is seen at the middle of a pixel. A ground that is shown has no colour yet.
    pub fn seen(&self, x: usize, y: usize) -> Seen {
        let point = self.point([x, y], [0.0, 0.0]);
        self.scene.look(self.studio, self.camera, point, &[])
    }

    /// Colours the ground in a row of cells, of which `seen` is what is seen at the middles of its pixels; a lens spreads places over discs
    /// of a radius, pixels.
    pub fn color_ground(&self, row: usize, seen: &mut [Seen], disc: impl Fn(&Place) -> f32) {
        let columns = self.size[0];
        let mut shared = vec![None; columns.div_ceil(CELL)];
        for (i, seen) in seen.iter_mut().enumerate() {
            let at = [i % columns, CELL * row + i / columns];
            let shared = &mut shared[at[0] / CELL];
            let disc = disc(&seen.place);
            let is_spread = is_ground(seen.place.met) && disc > ONE_RAY_RADIUS;
            match *shared {
                Some(color) if is_spread => seen.color = color,
                _ => {
                    let blur = f64::from((AVERAGED * disc).max(1.0));
                    self.color_ground_at(seen, self.point(at, [0.0, 0.0]), blur);
                    *shared = is_spread.then_some(seen.color);
                }
            }
        }
    }

    fn color_ground_at(&self, seen: &mut Seen, point: [f64; 2], blur: f64) {
        if is_ground(seen.place.met) {
            let color = self.studio.ground_color(self.camera, point, blur);
            seen.color = color.unwrap_or(seen.color);
        }
    }

    /// What a ray sees that left the middle of its pixel by an offset, in pixels, where some is `known` of what others have seen and of the
    /// colour of the ground.
    fn look(&self, at: [usize; 2], offset: [f32; 2], known: &[Seen], ground: Option<Vec3>) -> Seen {
        let point = self.point(at, offset);
        let mut seen = self.scene.look(self.studio, self.camera, point, known);
        match ground {
            Some(color) if is_ground(seen.place.met) => seen.color = color,
            _ => self.color_ground_at(&mut seen, point, 1.0),
        }
        seen
    }

    /// The light at what is seen at a pixel; nothing where the filter finds it around. `support` is that of all pixels, `disc` the radius
    /// of the disc over which a lens spreads this one, pixels.
    pub fn light(
        &self,
        neighbours: &Neighbours,
        (support, disc): (&[f32], f32),
        at: [usize; 2],
    ) -> Traced {
        let pixel = at[1] * self.size[0] + at[0];
        let place = &neighbours.places[pixel];
        if place.met.is_unlit() || self.is_filled_in(neighbours, support, at) {
            return Traced::default();
        }
        let factor = match support[pixel] > LITTLE_SUPPORT || disc > UNSHARP_RADIUS {
            true => 1,
            false => 2,
        };
        self.traced(place, at, factor * self.rays)
    }

    fn traced(&self, place: &Place, at: [usize; 2], rays: u32) -> Traced {
        Traced {
            light: (self.scene).light_at(self.studio, place, &self.light_sampler(at), rays),
            has_key: true,
            has_rest: true,
        }
    }

    /// The first pixel of the cell of a pixel.
    fn first(&self, at: [usize; 2]) -> usize {
        let [x, y] = at.map(|k| k - k % CELL);
        y * self.size[0] + x
    }

    /// Whether a pixel of a smooth surface takes its light from the first pixel of its cell and others around.
    fn is_filled_in(&self, neighbours: &Neighbours, support: &[f32], at: [usize; 2]) -> bool {
        let [own, first] = [at[1] * self.size[0] + at[0], self.first(at)];
        let [here, there] = [own, first].map(|i| &neighbours.places[i]);
        own != first
            && self.samples < RAYS_FOR_ALL
            && support[own].min(support[first]) > SMOOTH_SUPPORT
            && likeness(here, there) > FILLED_IN_LIKENESS
    }

    /// The light with more rays where noise would be seen best on a smooth surface: to the key light in its soft shadow, and of all kinds
    /// where indirect light varies much.
    pub fn refined(
        &self,
        neighbours: &Neighbours,
        (light, support): (&[Traced], f32),
        at: [usize; 2],
    ) -> Traced {
        let pixel = at[1] * self.size[0] + at[0];
        let (place, own) = (&neighbours.places[pixel], light[pixel]);
        if place.met.is_unlit() || support < SMOOTH_SUPPORT {
            return own;
        }
        let (mut key, mut rest) = (Extremes::NONE, Extremes::NONE);
        neighbours.visit_around(at, |i| {
            let Traced {
                light,
                has_key,
                has_rest,
            } = &light[i];
            if *has_key {
                key.include(light.lamps[0]);
            }
            if *has_rest {
                rest.include(luminance(light.indirect));
            }
        });
        if !own.has_rest && rest.width() > VARIED_INDIRECT * rest.high {
            return self.traced(place, at, self.rays);
        }
        // Most places are not in a soft shadow, whatever surfaces are around them.
        if key.width() < SOFT_SHADOW {
            return own;
        }
        let mut key = Extremes::NONE;
        neighbours.visit_around(at, |i| {
            if light[i].has_key && likeness(place, &neighbours.places[i]) > EDGE_LIKENESS {
                key.include(light[i].light.lamps[0]);
            }
        });
        if key.width() < SOFT_SHADOW {
            return own;
        }
        let first = if own.has_key { self.rays } else { 0 };
        let rays = [first, MORE_RAYS * self.rays - first];
        let sampler = self.light_sampler(at);
        Traced {
            light: (self.scene).refined_light(self.studio, place, &sampler, own.light, rays),
            has_key: true,
            ..own
        }
    }

    fn light_sampler(&self, at: [usize; 2]) -> Sampler {
        Sampler::new(at, MORE_RAYS * self.rays)
    }
}

/// What became of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct Resolved {
    pub pixel: Pixel,
    /// Whether its rays met an item, and also what lies far behind or before that.
    pub has_outline: bool,
}

/// What is known before pixels are resolved.
pub(crate) struct Resolve<'a> {
    pub frame: &'a Frame<'a>,
    pub neighbours: Neighbours<'a>,
    /// What is seen at the middle of each pixel.
    pub seen: &'a [Seen],
    /// The smoothed light at what is seen at the middle of each pixel.
    pub light: &'a [Light],
    /// The radiance of that.
    pub centres: &'a [Vec3],
    /// What is out of focus is blurred.
    pub focus: Option<&'a Focus>,
}

impl Resolve<'_> {
    /// What becomes of a pixel; all rays are taken where `is_beside_outline`.
    pub fn pixel(&self, at: [usize; 2], is_beside_outline: bool) -> Resolved {
        let centre = at[1] * self.frame.size[0] + at[0];
        let samples = self.frame.samples;
        let all = samples >= RAYS_FOR_ALL;
        let even = |radiance| Resolved {
            pixel: Pixel::even(radiance, self.nearness(&self.neighbours.places[centre])),
            has_outline: false,
        };
        if samples == 1 {
            return even(self.centres[centre]);
        }
        let may_stop = !(all || is_beside_outline);
        if may_stop && self.is_blurred(at) {
            return even(self.centres[centre]);
        }
        if may_stop && !self.is_detailed(at) {
            return even(self.mean_around(at));
        }
        let sampler = Sampler::new(at, samples.next_power_of_two());
        // What rays have seen in this pixel and what they may see again.
        let mut known = Vec::with_capacity(samples.min(RAYS_FOR_ALL) as usize);
        let mut rays = Vec::with_capacity(samples as usize);
        let (mut sum, mut low, mut high) = (Vec3::ZERO, f32::INFINITY, 0.0f32);
        let (mut count, mut squares) = (0, 0.0);
        let mut depths = Extremes::NONE;
        let (mut is_varied, mut has_item, mut has_outline) = (false, false, false);
        let ground = if all { None } else { self.ground_around(at) };
        while count < samples {
            let [dx, dy] = sampler.square(count, Purpose::Pixel).map(tent);
            let may_share = !all && count >= FIRST_RAYS && !is_varied;
            let shared: &[Seen] = if may_share { &known } else { &[] };
            let seen = self.frame.look(at, [dx, dy], shared, ground);
            if known.len() < known.capacity() {
                known.push(seen);
            }
            let light = self.light_of(at, [dx, dy], &seen, &sampler, count);
            let radiance = seen.radiance(self.frame.studio, &light);
            rays.push((radiance, self.nearness(&seen.place)));
            let brightness = luminance(radiance);
            (low, high) = (low.min(brightness), high.max(brightness));
            sum += radiance;
            squares += brightness * brightness;
            count += 1;
            depths.include(depth(&seen.place));
            has_item |= matches!(seen.place.met, Met::Item(_));
            has_outline = has_item && depths.high > FARTHER * depths.low;
            let is_enough = || match count {
                // It is looked at once more, with those beside it.
                FIRST_RAYS => has_outline || contrast(low, high) < RAY_CONTRAST,
                _ => standard_error(luminance(sum), squares, count) < MEAN_ERROR,
            };
            if count == FIRST_RAYS {
                is_varied = varied(&known);
            }
            if may_stop && count.is_multiple_of(FIRST_RAYS) && is_enough() {
                break;
            }
        }
        Resolved {
            pixel: Pixel::of_rays(&rays),
            has_outline,
        }
    }

    /// The colour of a ground that is shown at a pixel or next to it.
    fn ground_around(&self, at: [usize; 2]) -> Option<Vec3> {
        self.frame.studio.floor.as_ref()?.ground.as_ref()?;
        let offsets = [0, -1, 1];
        let mut around = (offsets.iter()).flat_map(|dy| offsets.map(|dx| [dx, *dy]));
        around.find_map(|off| {
            let seen = &self.seen[self.neighbours.index(at, off)?];
            is_ground(seen.place.met).then_some(seen.color)
        })
    }

    /// One over the distance of a place, 1/m; the same for all where none is asked for.
    fn nearness(&self, place: &Place) -> f32 {
        (self.focus).map_or(0.0, |focus| focus.distances.nearness(place))
    }

    /// Whether a pixel and those around it will be spread so far that one ray stands for it.
    fn is_blurred(&self, at: [usize; 2]) -> bool {
        let Some(focus) = self.focus else {
            return false;
        };
        let [width, height] = self.frame.size;
        let columns = at[0].saturating_sub(1)..(at[0] + 2).min(width);
        (at[1].saturating_sub(1)..(at[1] + 2).min(height)).all(|y| {
            columns
                .clone()
                .all(|x| focus.radius(&self.neighbours.places[y * width + x]) > ONE_RAY_RADIUS)
        })
    }

    /// The mean of what is seen at the middles of a pixel and its neighbours, weighted by the pixel filter.
    fn mean_around(&self, at: [usize; 2]) -> Vec3 {
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (dy, row) in (-1..).zip(FILTER) {
            for (dx, column) in (-1..).zip(FILTER) {
                if let Some(i) = self.neighbours.index(at, [dx, dy]) {
                    sum += self.centres[i] * (row * column);
                    total += row * column;
                }
            }
        }
        sum / total
    }

    /// Whether one ray does not stand for a pixel: an edge runs near it, or its neighbours are much lighter or darker.
    fn is_detailed(&self, at: [usize; 2]) -> bool {
        let centre = at[1] * self.frame.size[0] + at[0];
        let here = &self.neighbours.places[centre];
        let own = luminance(self.centres[centre]);
        let differs = |i: usize| {
            let there = &self.neighbours.places[i];
            let is_empty = here.met == Met::Background && there.met == Met::Background;
            // Detail of a ground is averaged over a pixel where it is made.
            let is_ground = is_ground(here.met) && is_ground(there.met);
            !is_empty
                && (likeness(here, there) < EDGE_LIKENESS
                    || !is_ground && contrast(own, luminance(self.centres[i])) > DETAIL_CONTRAST)
        };
        let [x, y] = at;
        let columns = x.saturating_sub(1)..(x + 2).min(self.frame.size[0]);
        (y.saturating_sub(1)..(y + 2).min(self.frame.size[1])).any(|row| {
            columns
                .clone()
                .any(|column| differs(row * self.frame.size[0] + column))
        })
    }

    /// The light at what a ray sees that left the middle of its pixel by an offset: that of alike places around, or its own.
    fn light_of(
        &self,
        [x, y]: [usize; 2],
        offset: [f32; 2],
        seen: &Seen,
        sampler: &Sampler,
        index: u32,
    ) -> Light {
        if seen.place.met.is_unlit() {
            return Light::default();
        }
        let mut sum = Light::default();
        let mut total = 0.0;
        for dy in -1..=1 {
            for dx in -1..=1 {
                let Some(i) = self.neighbours.index([x, y], [dx, dy]) else {
                    continue;
                };
                let [a, b] = [dx as f32 - offset[0], dy as f32 - offset[1]];
                let near = 1.0 / (0.1 + a * a + b * b);
                let weight = near * likeness(&seen.place, &self.neighbours.places[i]);
                let light = &self.light[i];
                sum.lamps[0] += light.lamps[0] * weight;
                sum.lamps[1] += light.lamps[1] * weight;
                sum.indirect += light.indirect * weight;
                total += weight;
            }
        }
        if total < MIN_LIKENESS {
            let Frame {
                scene,
                studio,
                rays,
                ..
            } = self.frame;
            let own = Sampler::of_sample(sampler, index, *rays);
            return scene.light_at(studio, &seen.place, &own, *rays);
        }
        Light {
            lamps: sum.lamps.map(|v| v / total),
            indirect: sum.indirect / total,
        }
    }
}

/// How far off a place is, as the size of a pixel there, m.
fn depth(place: &Place) -> f32 {
    match place.met {
        Met::Background => f32::INFINITY,
        _ => place.footprint,
    }
}

/// Whether a ray met the floor.
fn is_ground(met: Met) -> bool {
    matches!(met, Met::Floor | Met::FarGround)
}

/// The standard error of the mean of `count` luminances, as a part of it, from their sum and that of their squares.
fn standard_error(sum: f32, squares: f32, count: u32) -> f32 {
    let n = count as f32;
    let mean = sum / n;
    let variance = (squares / n - mean * mean).max(0.0) / n;
    variance.sqrt() / (mean + CONTRAST_BASE)
}

/// Whether the same item looks unlike itself at some places.
fn varied(seen: &[Seen]) -> bool {
    let is_unlike = |a: &Seen, b: &Seen| {
        a.place.met == b.place.met
            && (contrast(luminance(a.color), luminance(b.color)) > VARIED_COLOR
                || a.normal.dot(b.normal) < VARIED_NORMAL)
    };
    (1..seen.len()).any(|i| seen[..i].iter().any(|a| is_unlike(a, &seen[i])))
}

/// How much two luminances differ.
fn contrast(a: f32, b: f32) -> f32 {
    (a - b).abs() / (a + b + CONTRAST_BASE)
}

/// Maps a uniform distribution on 0…1 to a tent on −1…1, the pixel filter.
fn tent(t: f32) -> f32 {
    if t < 0.5 {
        (2.0 * t).sqrt() - 1.0
    } else {
        1.0 - (2.0 - 2.0 * t).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_error_is_that_of_the_mean() {
        // Of 1, 2, 3 and 4: the standard deviation √1.25 over √4, relative to the mean 2.5.
        let values = [1.0f32, 2.0, 3.0, 4.0];
        let squares = values.iter().map(|v| v * v).sum();
        let found = standard_error(values.iter().sum(), squares, 4);
        let expected = 1.25f32.sqrt() / 2.0 / (2.5 + CONTRAST_BASE);
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        assert_eq!(standard_error(6.0, 12.0, 3), 0.0);
    }
}
