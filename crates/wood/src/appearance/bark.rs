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

/// How much of the colour of ridges is seen at the bottom of furrows.
const FURROW_DUST: f64 = 0.3;
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

impl FigureSize {
    /// What has to be seen of furrows of a size (m): the slope of a side, which is narrower than the ridge. Finer slopes would glitter.
    fn least_width(&self, size: f64, openness: f64) -> f64 {
        (1.8 * self.edge * openness).min(1.0) * size * self.stretch.min(1.0)
    }
}

/// Furrows of three orders: wide ones between ridges, narrower ones that part the ridges, and cracks.
const FURROWS: [FigureSize; 3] = [
    furrow(1.0, 8.0, 1.0, 0.34),
    furrow(0.47, 8.0, 0.50, 0.22),
    furrow(0.19, 9.0, 0.22, 0.20),
];
/// Ridges are of several widths: the bark is shifted about the stem by slow noise, in parts of the distance between furrows, before
/// furrows are cut. Size and length over size of the noise, and the farthest shift.
const UNEVEN_RIDGES: FigureSize = figure(3.4, 6.0, 0.8);
/// Bark is smooth in some places and rough in others: size and length over size of the noise that scales all furrows, in furrow widths,
/// the factor on that noise, and the least scale.
const SMOOTH_PATCHES: FigureSize = figure(7.0, 2.2, 1.8);
const LEAST_RELIEF: f64 = 0.2;
/// Flakes, scales and dust between them.
const FLAKES: [FigureSize; 4] = [
    figure(1.7, 2.0, 0.09),
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
const MEAN_DEPTHS: [f64; FURROWS.len()] = [0.49, 0.335, 0.31];
/// Part of a flake's size that has to be seen: slopes of one pixel glitter.
const FLAKE_DETAIL: f64 = 0.5;
/// Share of dust on ridges, and of lichen in its patches, and the values of the noise between which their edges lie.
const DUST: f64 = 0.34;
const LICHEN_SHARE: f64 = 0.62;
/// How much more dust there is in patches, and on flakes that are light, and how much those fray the edges of lichen.
const DUST_PATCHES: f64 = 0.12;
const DUST_FLAKES: f64 = 0.45;
const LICHEN_FRAYING: f64 = 1.25;
const LICHEN_EDGE: (f64, f64) = (0.36, 0.47);
/// Algae on the side that stays damp: colour, the most of them, and how far they spread about the stem, as a cosine.
const ALGAE: DVec3 = DVec3::new(0.128, 0.142, 0.066);
const ALGAE_SHARE: f64 = 0.40;
const ALGAE_SIDE: (f64, f64) = (-0.35, 1.0);
/// Linear colours of lichen and dust, and of lenticels.
const LICHEN: DVec3 = DVec3::new(0.27, 0.275, 0.225);
const LENTICEL: DVec3 = DVec3::new(0.30, 0.22, 0.15);

/// Numbers of the noises; those of the flakes come first, then three for each order of furrows.
const PATCH_NOISE: usize = FLAKES.len();
const LENTICEL_NOISE: usize = PATCH_NOISE + 1;
const ALGA_NOISE: usize = LENTICEL_NOISE + 1;
const RIDGE_NOISE: usize = ALGA_NOISE + 1;
const PATCHINESS_NOISE: usize = RIDGE_NOISE + 1;
const FURROW_NOISES: usize = PATCHINESS_NOISE + 1;

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
        let lichen =
            smoothstep(LICHEN_EDGE.0, LICHEN_EDGE.1, patch + LICHEN_FRAYING * shade) * LICHEN_SHARE;
        let weathered = mix(
            DVec3::from_array(self.ridge_color),
            LICHEN,
            lichen.max((DUST + DUST_PATCHES * patch + DUST_FLAKES * shade).clamp(0.0, DUST * 2.0)),
        );
        let weathered = mix(weathered, ALGAE, self.algae(place, at.angle, shade, noises));
        let furrow_color = DVec3::from_array(self.furrow_color);
        // Furrows are dark from their sides on, as light gets out of them hardly, but for the dust on their sides.
        let lit = FURROW_DUST + (1.0 - FURROW_DUST) * ridge.max(0.0);
        let mut color = mix(furrow_color, weathered, lit) * (1.0 + 1.3 * shade).max(0.15);
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

    /// Shifts a place of the bark about the stem, so that ridges differ in width.
    fn uneven(&self, place: DVec3, noises: &mut impl Noises) -> Shifted {
        let most = UNEVEN_RIDGES.share * self.furrow_width;
        let size = DVec3::splat(UNEVEN_RIDGES.size * self.furrow_width);
        let seed = self.seed ^ PURPOSE ^ 6;
        let (v, g) = self.noise(
            (noises, RIDGE_NOISE),
            seed,
            place,
            (size, UNEVEN_RIDGES.stretch),
        );
        let radius = place.truncate().length().max(1e-9);
        let outwards = place.truncate().extend(0.0) / radius;
        let around = DVec3::new(-outwards.y, outwards.x, 0.0);
        Shifted {
            place: place + around * (most * v),
            outwards,
            around,
            turn: most * v / radius,
            rise: g * most,
        }
    }

    fn furrows(&self, place: DVec3, footprint: f64, noises: &mut impl Noises) -> Furrows {
        let at = self.uneven(place, noises);
        let mut sum = Furrows {
            ridge: 1.0,
            height: 0.0,
            slope: DVec3::ZERO,
        };
        // Shallow furrows are narrow: smooth bark has lines where rough bark has valleys.
        let steepness = self.furrow_depth / self.furrow_width / WIDE_FURROW_DEPTH;
        let openness = steepness.clamp(NARROWEST_FURROW, 1.0);
        for (i, order) in FURROWS.iter().enumerate() {
            let size = order.size * self.furrow_width;
            let mean = MEAN_DEPTHS[i] * openness;
            let visible = visible_detail(order.least_width(size, openness), footprint);
            if visible == 0.0 {
                sum.add(order.share, self.furrow_depth, (-mean, DVec3::ZERO));
                continue;
            }
            // Furrows wander: the place is shifted sideways by slower noise before they are cut.
            let seed = self.seed ^ PURPOSE ^ ((i as u64 + 1) << 16);
            let slow = (DVec3::splat(size / 0.9), 0.9 / 0.35);
            let number = FURROW_NOISES + 3 * i;
            let (shift, shift_slope) = self.noise((noises, number), seed ^ 1, at.place, slow);
            let shifted = at.place + DVec3::new(shift, -shift, 0.0) * (0.5 * size);
            let furrow = (DVec3::splat(size), order.stretch * self.furrow_stretch);
            let (v, g) = self.noise((noises, number + 1), seed, shifted, furrow);
            let g = g + shift_slope * (0.5 * size * (g.x - g.y));
            // How wide it opens changes along it.
            let along = (DVec3::splat(size / 0.7), 0.7 / 0.3);
            let opening = self.noise((noises, number + 2), seed ^ 2, at.place, along);
            let cut = Cut::of((v, g), opening, order.edge * openness);
            // The widest furrows part all ridges.
            let (share, share_slope) = if i == 0 {
                (1.0, DVec3::ZERO)
            } else {
                cut.share
            };
            let seen = (
                share * (cut.open - 1.0),
                share * cut.open_slope + share_slope * (cut.open - 1.0),
            );
            let low = mix_scalar(-mean, seen.0, visible);
            sum.add(
                order.share,
                self.furrow_depth,
                (low, at.slope(seen.1) * visible),
            );
        }
        sum.scaled(self.relief_scale(place, noises))
    }

    /// The factor on the depth of furrows at a place, 1 on average, and its gradient, 1/m.
    fn relief_scale(&self, place: DVec3, noises: &mut impl Noises) -> (f64, DVec3) {
        let seed = self.seed ^ PURPOSE ^ 7;
        let size = DVec3::splat(SMOOTH_PATCHES.size * self.furrow_width);
        let (v, g) = self.noise(
            (noises, PATCHINESS_NOISE),
            seed,
            place,
            (size, SMOOTH_PATCHES.stretch),
        );
        let scale = 1.0 + SMOOTH_PATCHES.share * v;
        match scale > LEAST_RELIEF {
            true => (scale, g * SMOOTH_PATCHES.share),
            false => (LEAST_RELIEF, DVec3::ZERO),
        }
    }
}

/// A place that was shifted about the stem.
struct Shifted {
    place: DVec3,
    /// Directions away from the pith and about it.
    outwards: DVec3,
    around: DVec3,
    /// The shift over the distance from the pith.
    turn: f64,
    /// Slope of the shift.
    rise: DVec3,
}

impl Shifted {
    /// The slope of what has a slope `g` where it was shifted to.
    fn slope(&self, g: DVec3) -> DVec3 {
        g + self.rise * g.dot(self.around) - self.around * (self.turn * g.dot(self.outwards))
    }
}

/// A furrow at a place.
struct Cut {
    /// 0 in the middle of the furrow, 1 beside it, and its slope.
    open: f64,
    open_slope: DVec3,
    /// How deep it is of what furrows of its order are at most, and its slope.
    share: (f64, DVec3),
}

impl Cut {
    /// A furrow runs where a noise changes sign; `opening` is the noise that changes its width along it, `half` half its width.
    fn of((v, g): (f64, DVec3), (opening, opening_slope): (f64, DVec3), half: f64) -> Cut {
        let widened = 1.0 + FURROW_EDGE_VARIATION * opening;
        let edge = half * widened.max(MIN_FURROW_EDGE);
        let x = (v.abs() / edge).min(1.0);
        let narrowing = match widened > MIN_FURROW_EDGE {
            true => half * FURROW_EDGE_VARIATION,
            false => 0.0,
        };
        let x_slope = match x < 1.0 {
            true => (g * v.signum() - opening_slope * (narrowing * x)) / edge,
            false => DVec3::ZERO,
        };
        let range = FURROW_END - MIN_FURROW_EDGE;
        let t = ((widened - MIN_FURROW_EDGE) / range).clamp(0.0, 1.0);
        let deepening = 6.0 * t * (1.0 - t) * FURROW_EDGE_VARIATION / range;
        Cut {
            open: x * x * (3.0 - 2.0 * x),
            open_slope: x_slope * (6.0 * x * (1.0 - x)),
            share: (t * t * (3.0 - 2.0 * t), opening_slope * deepening),
        }
    }
}

impl Furrows {
    /// Adds a furrow as low as a part of the depth of its order, whose part of the greatest depth (m) is `share`.
    fn add(&mut self, share: f64, depth: f64, (low, slope): (f64, DVec3)) {
        self.ridge *= 1.0 + share * low;
        self.height += depth * share * low;
        self.slope += slope * (depth * share);
    }

    /// The same furrows, deeper and darker by a factor, whose gradient (1/m) comes with it.
    fn scaled(self, (scale, gradient): (f64, DVec3)) -> Furrows {
        Furrows {
            ridge: (1.0 - scale * (1.0 - self.ridge)).max(0.0),
            height: scale * self.height,
            slope: scale * self.slope + gradient * self.height,
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
    fn ridges_run_along_the_stem_and_are_of_several_widths() {
        let bark = BarkAppearance::furrowed(0.1);
        let around = 8000;
        let (mut across, mut along, mut widths) = (0.0, 0.0, Vec::new());
        for level in 0..40 {
            let at = |i: i32| {
                let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(i) / 8e3);
                let place = DVec3::new(0.1 * cosine, 0.1 * sine, 0.11 * f64::from(level));
                (bark.furrows(place, 1e-6, &mut Forgetful), cosine, sine)
            };
            let mut last = None;
            for i in 0..around {
                let (here, cosine, sine) = at(i);
                across += (here.slope.y * cosine - here.slope.x * sine).powi(2);
                along += here.slope.z.powi(2);
                let is_bottom = here.ridge < 0.04
                    && here.ridge <= at(i - 1).0.ridge
                    && here.ridge < at(i + 1).0.ridge;
                if is_bottom {
                    widths.extend(last.map(|last| f64::from(i - last)));
                    last = Some(i);
                }
            }
        }
        // No net of cracks lies over them.
        let steepness = f64::sqrt(along / across);
        assert!(steepness < 0.35, "{steepness}");
        widths.sort_by(f64::total_cmp);
        let part = |share: f64| widths[(share * widths.len() as f64) as usize];
        assert!(widths.len() > 200, "{}", widths.len());
        assert!(part(0.9) > 4.5 * part(0.1), "{} {}", part(0.1), part(0.9));
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
