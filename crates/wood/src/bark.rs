//! The look of bark as a pure function of the address: ridges between furrows of three orders, flakes and lenticels.

use crate::appearance::{WoodSurface, left_of, mix, mix_scalar, srgb};
use crate::noise::{smoothstep, space};
use glam::DVec3;

/// A place on the outside of the bark.
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
    /// The ground of the furrows.
    pub furrow_color: [f64; 3],
    /// Distance between furrows, m.
    pub furrow_width: f64,
    /// Depth of the furrows, m; small for young, smooth bark.
    pub furrow_depth: f64,
    /// How many lenticels (pale cross stripes) show, 0 to 1.
    pub lenticels: f64,
    /// Seed of everything irregular.
    pub seed: u64,
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
            ridge_color: srgb([132, 112, 92]),
            furrow_color: srgb([84, 62, 47]),
            furrow_width: (radius * 0.14).clamp(8e-4, 0.015),
            furrow_depth: (radius * 0.02).clamp(1e-4, 2e-3),
            lenticels: 0.5,
            seed: 0,
        }
    }

    /// Bark of an old stem of the given radius (m): deep furrows between long ridges.
    pub fn furrowed(radius: f64) -> Self {
        BarkAppearance {
            ridge_color: srgb([118, 104, 90]),
            furrow_color: srgb([56, 40, 30]),
            furrow_width: (radius * 0.25).clamp(3e-3, 0.06),
            furrow_depth: (radius * 0.06).clamp(5e-4, 0.02),
            lenticels: 0.0,
            seed: 0,
        }
    }
}

/// What for, in the hash.
const PURPOSE: u64 = 0xba7c;
/// Furrows of three orders: distance in widths, length in distances, share of the depth.
const FURROWS: [(f64, f64, f64); 3] = [(1.0, 6.0, 1.0), (0.45, 3.5, 0.55), (0.17, 2.2, 0.35)];
/// Half width of a furrow as a value of the noise whose sign changes in it.
const FURROW_EDGE: f64 = 0.17;
/// Flakes, scales and dust between them: size in furrow widths, length in sizes, share of the brightness.
const ROUGH: [(f64, f64, f64); 4] = [
    (1.7, 2.0, 0.18),
    (0.5, 1.6, 0.22),
    (0.16, 1.3, 0.26),
    (0.055, 1.0, 0.24),
];

/// What bark looks like at a place; detail finer than `footprint` (m) is averaged. `slope` is along x and y of the
/// section and along the stem, as for wood.
pub fn bark(look: &BarkAppearance, at: &BarkPoint, footprint: f64) -> WoodSurface {
    let (sine, cosine) = libm::sincos(at.angle);
    let place = DVec3::new(cosine * at.radius, sine * at.radius, at.along);
    let seed = look.seed ^ PURPOSE;
    let width = look.furrow_width;
    let (ridge, mut height, mut slope) = furrows(look, place, footprint);
    let mut shade = 0.0;
    for (i, (size, stretch, share)) in ROUGH.into_iter().enumerate() {
        let size = size * width;
        let keep = left_of(size, footprint);
        if keep == 0.0 {
            break;
        }
        let scale = DVec3::new(1.0, 1.0, 1.0 / stretch) / size;
        let (v, g) = space(seed ^ ((i as u64 + 2) << 8), place * scale, 0);
        shade += v * share * keep;
        let relief = 0.16 * size.min(look.furrow_depth * 4.0) * keep;
        height += v * relief;
        slope += g * scale * relief;
    }
    let ridge_color = DVec3::from_array(look.ridge_color);
    // Patches of lichen and dust: slow changes towards a greenish grey.
    let (patch, _) = space(
        seed ^ 3,
        place * DVec3::new(1.0, 1.0, 0.6) / (4.0 * width),
        0,
    );
    let weathered = mix(
        ridge_color,
        DVec3::new(0.24, 0.24, 0.19),
        (0.30 + 0.5 * patch).clamp(0.0, 0.6),
    );
    let mut color =
        mix(DVec3::from_array(look.furrow_color), weathered, ridge) * (1.0 + 1.3 * shade).max(0.15);
    if look.lenticels > 0.0 {
        let size = DVec3::new(1.0, 1.0, 6.0) / (0.5 * width);
        let (v, _) = space(seed ^ 4, place * size, 0);
        let spot = smoothstep(0.45, 0.62, v) * look.lenticels * left_of(0.1 * width, footprint);
        color = mix(color, DVec3::new(0.30, 0.22, 0.15), spot);
        height += 0.3 * look.furrow_depth * spot;
    }
    WoodSurface {
        color: color.clamp(DVec3::splat(0.004), DVec3::ONE).to_array(),
        roughness: 0.95,
        height,
        slope,
    }
}

/// Furrows: how little a place is in one (0 to 1), relief (m) and its slope.
fn furrows(look: &BarkAppearance, place: DVec3, footprint: f64) -> (f64, f64, DVec3) {
    let (seed, width) = (look.seed ^ PURPOSE, look.furrow_width);
    let (mut ridge, mut height, mut slope) = (1.0, 0.0, DVec3::ZERO);
    for (i, (size, stretch, share)) in FURROWS.into_iter().enumerate() {
        let size = size * width;
        let keep = left_of(size, footprint);
        // Furrows wander: the place is shifted sideways by slower noise before they are cut.
        let seed = seed ^ ((i as u64 + 1) << 16);
        let slow = DVec3::new(0.9, 0.9, 0.35) / size;
        let (shift, shift_slope) = space(seed ^ 1, place * slow, 0);
        let shifted = place + DVec3::new(shift, -shift, 0.0) * (0.5 * size);
        let scale = DVec3::new(1.0, 1.0, 1.0 / stretch) / size;
        let (v, g) = space(seed, shifted * scale, 0);
        let g = g * scale;
        let g = g + shift_slope * slow * (0.5 * size * (g.x - g.y));
        // A furrow runs where the noise changes sign; how wide it gapes changes along it.
        let along = DVec3::new(0.7, 0.7, 0.3) / size;
        let (gape, gape_slope) = space(seed ^ 2, place * along, 0);
        let edge = FURROW_EDGE * (1.0 + 1.1 * gape).max(0.12);
        let x = (v.abs() / edge).min(1.0);
        let open = mix_scalar(0.78, x * x * (3.0 - 2.0 * x), keep);
        ridge *= 1.0 - share * (1.0 - open);
        let depth = look.furrow_depth * share;
        height += depth * (open - 1.0);
        if x < 1.0 {
            let narrowing = if 1.0 + 1.1 * gape > 0.12 {
                FURROW_EDGE * 1.1
            } else {
                0.0
            };
            let x_slope = (g * v.signum() - gape_slope * along * (narrowing * x)) / edge;
            slope += x_slope * (6.0 * x * (1.0 - x) * depth * keep);
        }
    }
    (ridge, height, slope)
}
