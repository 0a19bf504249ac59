//! The appearance of bark: ridges between furrows of three orders, flakes and lenticels.

use super::mix::{mix, mix_scalar, visible_detail};
use super::surface::WoodSurface;
use crate::colour::linear_from_srgb as srgb;
use crate::noise::{Forgetful, NoiseMemory, Noises, smoothstep, unit};
use crate::rings::periodic_cells;
use glam::DVec3;

/// A point on the outside of the bark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarkPoint {
    /// Angle about the pith, rad.
    pub angle: f64,
    /// Length along the stem, m.
    pub along: f64,
    /// Distance from the pith, m.
    pub radius: f64,
}

/// How bark looks. Colours are linear.
#[derive(Debug, Clone, PartialEq)]
pub struct BarkAppearance {
    /// The ridges, weathered.
    pub ridge_color: [f64; 3],
    /// The bottom of the furrows.
    pub furrow_color: [f64; 3],
    /// Distance between furrows, m.
    pub furrow_width: f64,
    /// Depth of the furrows, m; small for young, smooth bark.
    pub furrow_depth: f64,
    /// Factor on the length of ridges over their width: low for plates and scales, high for strings.
    pub furrow_stretch: f64,
    /// How many lenticels (pale cross stripes) show, 0 to 1.
    pub lenticels: f64,
    /// Seed of everything irregular.
    pub seed: u64,
    /// Length along the stem (m) after which it repeats, for tiling textures; `None` for bark as it grows.
    pub period: Option<f64>,
}

impl Default for BarkAppearance {
    fn default() -> Self {
        BarkAppearance::young(0.03)
    }
}

impl BarkAppearance {
    /// Bark of a branch or a young stem of the given radius (m): fine cracks and lenticels.
    pub fn young(radius: f64) -> Self {
        BarkAppearance {
            ridge_color: srgb([144, 125, 105]),
            furrow_color: srgb([66, 50, 40]),
            furrow_width: (radius * 0.14).clamp(8e-4, 0.015),
            furrow_depth: (radius * 0.028).clamp(1e-4, 2e-3),
            furrow_stretch: 1.0,
            lenticels: 0.5,
            seed: 0,
            period: None,
        }
    }

    /// Bark of an old stem of the given radius (m): deep furrows between long ridges.
    pub fn furrowed(radius: f64) -> Self {
        BarkAppearance {
            ridge_color: srgb([126, 113, 99]),
            furrow_color: srgb([56, 40, 30]),
            furrow_width: (radius * 0.25).clamp(3e-3, 0.06),
            furrow_depth: (radius * 0.06).clamp(5e-4, 0.02),
            furrow_stretch: 1.0,
            lenticels: 0.0,
            seed: 0,
            period: None,
        }
    }
}

/// Purpose in the hash.
const PURPOSE: u64 = 0xba7c;

/// A figure of one size: furrows of one order, or flakes.
struct FigureSize {
    /// In furrow widths.
    size: f64,
    /// Length over size.
    stretch: f64,
    /// Share of the depth or of the brightness.
    share: f64,
    /// Half the width of a furrow, as a value of the noise whose sign changes in it.
    edge: f64,
}

const fn figure(size: f64, stretch: f64, share: f64) -> FigureSize {
    FigureSize {
        size,
        stretch,
        share,
        edge: 0.17,
    }
}

const fn furrow(size: f64, stretch: f64, share: f64, edge: f64) -> FigureSize {
    FigureSize {
        edge,
        ..figure(size, stretch, share)
    }
}

/// Furrows of three orders: wide ones between ridges, narrower ones that part the ridges, and cracks; last the cracks across ridges,
/// between plates.
const FURROWS: [FigureSize; 4] = [
    furrow(1.0, 5.0, 1.0, 0.34),
    furrow(0.47, 6.0, 0.50, 0.22),
    furrow(0.19, 9.0, 0.22, 0.20),
    furrow(1.3, 0.6, 0.2, 0.06),
];
/// Flakes, scales and dust between them.
const FLAKES: [FigureSize; 4] = [
    figure(1.7, 2.0, 0.18),
    figure(0.5, 1.6, 0.26),
    figure(0.16, 1.3, 0.36),
    figure(0.055, 1.0, 0.34),
];
/// How much the width of a furrow varies along it, and its least factor.
const FURROW_EDGE_VARIATION: f64 = 1.1;
const MIN_FURROW_EDGE: f64 = 0.12;
/// Where a furrow narrows to less than this factor it gets shallower too, and ends: a line of even depth looks drawn.
const FURROW_END: f64 = 0.75;
/// Depth of furrows over the distance between them from which on they are as wide as furrows are, and the least factor on their width.
const WIDE_FURROW_DEPTH: f64 = 0.15;
const NARROWEST_FURROW: f64 = 0.35;
/// Mean share of their depth that furrows too fine to be seen take, by order, where they are as wide as furrows are.
const MEAN_DEPTHS: [f64; FURROWS.len()] = [0.49, 0.335, 0.31, 0.096];
/// Part of a flake's size that has to be seen: slopes of one pixel glitter.
const FLAKE_DETAIL: f64 = 0.5;
/// Share of dust on ridges, and of lichen in its patches, and the values of the noise between which their edges lie.
const DUST: f64 = 0.34;
const LICHEN_SHARE: f64 = 0.62;
const LICHEN_EDGE: (f64, f64) = (0.30, 0.46);
/// Algae on the side that stays damp: colour, the most of them, and how far they spread about the stem, as a cosine.
const ALGAE: DVec3 = DVec3::new(0.128, 0.142, 0.066);
const ALGAE_SHARE: f64 = 0.55;
const ALGAE_SIDE: (f64, f64) = (-0.35, 1.0);
/// Linear colours of lichen and dust, and of lenticels.
const LICHEN: DVec3 = DVec3::new(0.27, 0.275, 0.225);
const LENTICEL: DVec3 = DVec3::new(0.30, 0.22, 0.15);

/// Numbers of the noises; those of the flakes come first, then three for each order of furrows.
const PATCH_NOISE: usize = FLAKES.len();
const LENTICEL_NOISE: usize = PATCH_NOISE + 1;
const ALGA_NOISE: usize = LENTICEL_NOISE + 1;
const FURROW_NOISES: usize = ALGA_NOISE + 1;

/// Furrows at a point.
struct Furrows {
    /// How little it lies in one, 0 to 1.
    ridge: f64,
    /// Relief, m.
    height: f64,
    slope: DVec3,
}

impl BarkAppearance {
    /// Returns what bark looks like at a point; detail finer than `footprint` (m) is averaged. The slope is along x and y
    /// of the section and along the stem, as for wood.
    pub fn surface_at(&self, at: &BarkPoint, footprint: f64) -> WoodSurface {
        self.surface_by(at, footprint, &mut Forgetful)
    }

    /// [`BarkAppearance::surface_at`] for points visited one after another: `memory` is kept between them. The outcome is
    /// the same, sooner.
    pub fn surface_in_row(
        &self,
        at: &BarkPoint,
        footprint: f64,
        memory: &mut NoiseMemory,
    ) -> WoodSurface {
        self.surface_by(at, footprint, memory)
    }

    /// The noise at a place in features of a size (m), longer along the stem by `stretch`, with its gradient, 1/m.
    fn noise(
        &self,
        (noises, number): (&mut impl Noises, usize),
        seed: u64,
        place: DVec3,
        (size, stretch): (DVec3, f64),
    ) -> (f64, DVec3) {
        let (long, period) = periodic_cells(size.z * stretch, self.period);
        let scale = DVec3::new(1.0 / size.x, 1.0 / size.y, 1.0 / long);
        let (v, g) = noises.gradient(number, seed, place * scale, period);
        (v, g * scale)
    }

    fn surface_by(&self, at: &BarkPoint, footprint: f64, noises: &mut impl Noises) -> WoodSurface {
        let (sine, cosine) = libm::sincos(at.angle);
        let place = DVec3::new(cosine * at.radius, sine * at.radius, at.along);
        let seed = self.seed ^ PURPOSE;
        let width = self.furrow_width;
        let Furrows {
            ridge,
            mut height,
            mut slope,
        } = self.furrows(place, footprint, noises);
        let mut shade = 0.0;
        for (i, flakes) in FLAKES.iter().enumerate() {
            let size = flakes.size * width;
            let visible = visible_detail(size, footprint);
            if visible == 0.0 {
                break;
            }
            let (v, g) = self.noise(
                (noises, i),
                seed ^ ((i as u64 + 2) << 8),
                place,
                (DVec3::splat(size), flakes.stretch),
            );
            shade += v * (1.0 + 0.6 * v.abs()) * flakes.share * visible;
            let relief = 0.16
                * size.min(self.furrow_depth * 4.0)
                * visible_detail(FLAKE_DETAIL * size, footprint);
            height += v * relief;
            slope += g * relief;
        }
        // Dust, and patches of lichen with frayed edges: a greenish grey that grows on ridges.
        let patches = (DVec3::splat(5.0 * width), 1.0 / 0.7);
        let (patch, _) = self.noise((noises, PATCH_NOISE), seed ^ 3, place, patches);
        let lichen = smoothstep(LICHEN_EDGE.0, LICHEN_EDGE.1, patch + 0.8 * shade) * LICHEN_SHARE;
        let weathered = mix(
            DVec3::from_array(self.ridge_color),
            LICHEN,
            lichen.max((DUST + 0.3 * patch).clamp(0.0, DUST * 2.0)),
        );
        let weathered = mix(weathered, ALGAE, self.algae(place, at.angle, shade, noises));
        let furrow_color = DVec3::from_array(self.furrow_color);
        // Only the depths of furrows are dark: their sides are as weathered as ridges are.
        let mut color =
            mix(furrow_color, weathered, ridge.max(0.0).sqrt()) * (1.0 + 1.3 * shade).max(0.15);
        if self.lenticels > 0.0 {
            let stripes = (DVec3::splat(0.5 * width), 1.0 / 6.0);
            let (v, _) = self.noise((noises, LENTICEL_NOISE), seed ^ 4, place, stripes);
            let visible = visible_detail(0.1 * width, footprint);
            let spot = smoothstep(0.45, 0.62, v) * self.lenticels * visible;
            color = mix(color, LENTICEL, spot);
            height += 0.3 * self.furrow_depth * spot;
        }
        WoodSurface {
            color: color.clamp(DVec3::splat(0.004), DVec3::ONE).to_array(),
            roughness: 0.95,
            height,
            slope,
        }
    }

    /// How much of the bark at a place algae cover.
    fn algae(&self, place: DVec3, angle: f64, shade: f64, noises: &mut impl Noises) -> f64 {
        let damp = std::f64::consts::TAU * unit(self.seed ^ PURPOSE, 5, 0, 0);
        let side = smoothstep(ALGAE_SIDE.0, ALGAE_SIDE.1, libm::cos(angle - damp));
        if side == 0.0 {
            return 0.0;
        }
        let size = (DVec3::splat(9.0 * self.furrow_width), 2.0);
        let (patch, _) = self.noise((noises, ALGA_NOISE), self.seed ^ PURPOSE ^ 5, place, size);
        ALGAE_SHARE * side * smoothstep(-0.55, 0.45, patch + 0.7 * shade)
    }

    fn furrows(&self, place: DVec3, footprint: f64, noises: &mut impl Noises) -> Furrows {
        let (mut ridge, mut height, mut slope) = (1.0, 0.0, DVec3::ZERO);
        // Shallow furrows are narrow: smooth bark has lines where rough bark has valleys.
        let steepness = self.furrow_depth / self.furrow_width / WIDE_FURROW_DEPTH;
        let openness = steepness.clamp(NARROWEST_FURROW, 1.0);
        for (i, order) in FURROWS.iter().enumerate() {
            let size = order.size * self.furrow_width;
            let half = order.edge * openness;
            // What has to be seen is the slope of a furrow's side, which is narrower than the ridge: finer slopes would glitter.
            let narrowest = size * order.stretch.min(1.0);
            let visible = visible_detail((1.8 * half).min(1.0) * narrowest, footprint);
            // Furrows wander: the place is shifted sideways by slower noise before they are cut.
            let seed = self.seed ^ PURPOSE ^ ((i as u64 + 1) << 16);
            let slow = (DVec3::splat(size / 0.9), 0.9 / 0.35);
            let number = FURROW_NOISES + 3 * i;
            let (shift, shift_slope) = self.noise((noises, number), seed ^ 1, place, slow);
            let shifted = place + DVec3::new(shift, -shift, 0.0) * (0.5 * size);
            let furrow = (DVec3::splat(size), order.stretch * self.furrow_stretch);
            let (v, g) = self.noise((noises, number + 1), seed, shifted, furrow);
            let g = g + shift_slope * (0.5 * size * (g.x - g.y));
            // A furrow runs where the noise changes sign; how wide it opens changes along it.
            let along = (DVec3::splat(size / 0.7), 0.7 / 0.3);
            let (opening, opening_slope) = self.noise((noises, number + 2), seed ^ 2, place, along);
            let widened = 1.0 + FURROW_EDGE_VARIATION * opening;
            let edge = half * widened.max(MIN_FURROW_EDGE);
            let x = (v.abs() / edge).min(1.0);
            // The widest furrows part all ridges.
            let share = if i == 0 {
                1.0
            } else {
                smoothstep(MIN_FURROW_EDGE, FURROW_END, widened)
            };
            let profile = x * x * (3.0 - 2.0 * x);
            let mean = 1.0 - MEAN_DEPTHS[i] * openness;
            let open = mix_scalar(mean, 1.0 - share * (1.0 - profile), visible);
            ridge *= 1.0 - order.share * (1.0 - open);
            let depth = self.furrow_depth * order.share;
            height += depth * (open - 1.0);
            if x < 1.0 {
                let narrowing = if widened > MIN_FURROW_EDGE {
                    half * FURROW_EDGE_VARIATION
                } else {
                    0.0
                };
                let x_slope = (g * v.signum() - opening_slope * (narrowing * x)) / edge;
                let mut open_slope = x_slope * (share * 6.0 * x * (1.0 - x));
                if i > 0 && share > 0.0 && share < 1.0 {
                    let range = FURROW_END - MIN_FURROW_EDGE;
                    let t = (widened - MIN_FURROW_EDGE) / range;
                    let share_slope = 6.0 * t * (1.0 - t) * FURROW_EDGE_VARIATION / range;
                    open_slope -= opening_slope * (share_slope * (1.0 - profile));
                }
                slope += open_slope * (depth * visible);
            }
        }
        Furrows {
            ridge,
            height,
            slope,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_of_bark_are_those_of_its_relief() {
        let bark = BarkAppearance::furrowed(0.1);
        let height = |p: DVec3| {
            let furrows = bark.furrows(p, 1e-6, &mut Forgetful);
            (furrows.height, furrows.slope)
        };
        let (mut greatest, mut off) = (0.0f64, 0.0f64);
        for i in 0..400 {
            let t = f64::from(i);
            let (sine, cosine) = libm::sincos(0.7 * t);
            let p = DVec3::new(0.1 * cosine, 0.1 * sine, 0.013 * t);
            let h = 1e-7;
            let difference =
                |axis: DVec3| (height(p + axis * h).0 - height(p - axis * h).0) / (2.0 * h);
            let by_differences = DVec3::new(
                difference(DVec3::X),
                difference(DVec3::Y),
                difference(DVec3::Z),
            );
            greatest = greatest.max(by_differences.length());
            off = off.max((height(p).1 - by_differences).length());
        }
        assert!(
            greatest > 0.3 && off < 0.02 * greatest,
            "{off} of {greatest}"
        );
    }

    #[test]
    fn furrows_too_fine_to_be_seen_are_as_dark_as_they_are_on_average() {
        for bark in [BarkAppearance::furrowed(0.1), BarkAppearance::young(0.02)] {
            let mean = |footprint: f64| {
                let count = 20_000;
                let height = |i: i64| {
                    let u = |axis: i64| crate::noise::unit(9, i, axis, 0);
                    let place = DVec3::new(u(0), u(1), u(2)) * 20.0;
                    bark.furrows(place, footprint, &mut Forgetful).height
                };
                (0..count).map(height).sum::<f64>() / count as f64 / bark.furrow_depth
            };
            let (near, far) = (mean(1e-7), mean(1.0));
            assert!((near - far).abs() < 0.03, "{near} {far}");
        }
    }
}
