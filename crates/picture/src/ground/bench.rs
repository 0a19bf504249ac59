//! The top of a workbench: planks that wear, stains and dust have made grey, with the figure of flat-sawn wood, knots and scratches.

use super::look::GroundSurface;
use super::noise::{smoothstep, unit, value, visible};
use super::scratches::Scratches;
use glam::{Vec2, Vec3};

/// Width of a plank and of the gap between planks, m, and the distance from its edge over which a plank is rounded.
const PLANK: f32 = 0.095;
const GAP: f32 = 0.7e-3;
const ROUNDED: f32 = 2.2e-3;
/// Slope of a plank at its edge.
const EDGE_SLOPE: f32 = 0.7;
/// How far the tones of planks differ.
const PLANK_TONES: f32 = 0.13;
/// Linear reflectance of worn wood and of the knots in it, and how grey it has become at most.
const WOOD: Vec3 = Vec3::new(0.176, 0.134, 0.102);
const KNOT: Vec3 = Vec3::new(0.052, 0.036, 0.026);
const GREYED: f32 = 0.6;
/// Width of a ring, m, and how far rings wander, in rings, with the sizes of such wanders along and across, m.
const RING: f32 = 5.2e-3;
const WANDERS: [(f32, Vec2); 2] = [
    (0.55, Vec2::new(0.11, 0.022)),
    (0.16, Vec2::new(0.03, 0.007)),
];
/// How far from the pith planks are cut, m: at least, and how much farther in places, as stems taper and bow; and the length of
/// such a place, m. Rings are cut in arches there.
const PITH_DISTANCE: (f32, f32) = (4e-3, 0.05);
const BOW_LENGTH: f32 = 0.62;
/// How much darker latewood is, and the mean of its profile.
const LATEWOOD: f32 = 0.42;
const MEAN_LATEWOOD: f32 = 1.0 / 3.0;
/// Streaks along the grain: length and width, m, and share of the brightness.
const STREAKS: [(Vec2, f32); 4] = [
    (Vec2::new(0.17, 9e-3), 0.06),
    (Vec2::new(0.06, 2.4e-3), 0.07),
    (Vec2::new(0.02, 0.8e-3), 0.12),
    (Vec2::new(0.007, 0.28e-3), 0.16),
];
/// Stains and wear: size, m, and share of the brightness.
const STAINS: [(f32, f32); 3] = [(0.24, 0.13), (0.075, 0.08), (0.021, 0.05)];
/// Size of patches of dirt, m, and how much darker they are.
const DIRT: (f32, f32) = (0.13, 0.26);
/// Distance between knots along a plank, m, the share of places that have one, and their radii, m.
const KNOT_DISTANCE: f32 = 0.36;
const KNOT_SHARE: f32 = 0.4;
const KNOT_RADII: (f32, f32) = (3e-3, 8e-3);
/// How many times longer than wide a knot is, and by how many rings the figure bends about it.
const KNOT_LENGTH: f32 = 1.5;
const KNOT_BEND: f32 = 2.4;
/// Scratches of tools.
const SCRATCHES: Scratches = Scratches {
    seed: SEED ^ 0x5c7a,
    cells: [0.047, 0.021],
    length: 0.36,
    width: 0.22e-3,
    shade: 0.30,
    dark: 0.6,
};
/// Distance between grains of saw dust, m, the share of places that have one in the dustiest parts, and its reflectance.
const DUST_CELL: f32 = 2.3e-3;
const DUST_SHARE: f32 = 0.30;
const DUST: Vec3 = Vec3::new(0.50, 0.37, 0.22);

/// In the hash.
const SEED: u32 = 0xbe9c;

/// The bench at a place; detail finer than `footprint` (m) is averaged.
pub(super) fn bench(place: Vec2, footprint: f32) -> GroundSurface {
    let plank = (place.y / PLANK).floor();
    let number = plank as i32;
    let across = place.y - plank * PLANK;
    let own = |k: i32| unit(SEED, number, k);
    // Each plank is another piece of wood.
    let grain = Vec2::new(place.x + 7.0 * own(0), across);
    let knot = knot_at(grain, number);
    let on_grain =
        |size: Vec2, k: u32| value(SEED ^ (k << 8) ^ (number as u32) << 16, grain / size);
    let seen_plank = visible(PLANK, footprint);
    // The figure: rings that a flat cut meets at a low angle.
    let wanders = WANDERS.into_iter().zip([1, 16]);
    let wander: f32 = wanders
        .map(|((rings, size), k)| rings * on_grain(size, k))
        .sum();
    let bow = value(
        SEED ^ 0xb0 ^ (number as u32) << 16,
        Vec2::new(grain.x / BOW_LENGTH, 0.5),
    );
    let depth = PITH_DISTANCE.0 + PITH_DISTANCE.1 * (0.5 + 0.5 * bow);
    let beside = across - PLANK * (0.2 + 0.6 * own(1));
    let ring = Vec2::new(beside, depth).length() / RING + wander + KNOT_BEND * knot.near;
    let fraction = ring - ring.floor();
    let seen = visible(0.5 * RING, footprint);
    let late = MEAN_LATEWOOD + (fraction * fraction - MEAN_LATEWOOD) * seen;
    let mut shade = PLANK_TONES * (2.0 * own(2) - 1.0) * seen_plank;
    for ((size, share), k) in STREAKS.into_iter().zip(2..) {
        let seen = visible(2.0 * size.y, footprint);
        if seen == 0.0 {
            break;
        }
        shade += share * seen * on_grain(size, k);
    }
    for ((size, share), k) in STAINS.into_iter().zip(8..) {
        shade += share * visible(size, footprint) * value(SEED ^ k << 8, place / size);
    }
    shade += SCRATCHES.at(place, footprint);
    let dirt =
        value(SEED ^ 0xd1, place / DIRT.0) + 0.5 * value(SEED ^ 0xd2, place / (0.3 * DIRT.0));
    shade -= DIRT.1 * smoothstep(0.25, 0.9, dirt) * visible(DIRT.0, footprint);
    let mut color = WOOD * (1.0 - LATEWOOD * (late - MEAN_LATEWOOD)) * (1.0 + shade).max(0.2);
    let grey = GREYED * (0.5 + 0.5 * value(SEED ^ 0x97, place / 0.17) * seen_plank);
    let light = color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    color = color.lerp(Vec3::splat(light), grey);
    let dark = knot.inside * visible(2.0 * KNOT_RADII.1, footprint);
    color = color.lerp(KNOT * (1.0 + 0.5 * shade), dark);
    // Dust lies in the gaps too, but there is little light.
    color = color.lerp(DUST, dust_at(place, footprint));
    let edge = across.min(PLANK - across);
    let soft = (0.5 * footprint).max(0.25e-3);
    let gap = 1.0 - smoothstep(GAP - soft, GAP + soft, edge);
    color *= 1.0
        - 0.92 * gap * (GAP / (GAP + 0.4 * footprint)).min(1.0) * visible(12.0 * GAP, footprint);
    let fall = (1.0 - edge / ROUNDED).max(0.0) * visible(2.0 * ROUNDED, footprint);
    let inwards = if across < 0.5 * PLANK { 1.0 } else { -1.0 };
    GroundSurface {
        color,
        slope: Vec2::new(0.0, inwards * EDGE_SLOPE * fall),
    }
}

/// A knot near a place.
#[derive(Default)]
struct Knot {
    /// How much the place lies in one, 0 to 1.
    inside: f32,
    /// How near one is, 0 to 1.
    near: f32,
}

/// The knot of a plank nearest to a place of its grain.
fn knot_at(grain: Vec2, plank: i32) -> Knot {
    let cell = (grain.x / KNOT_DISTANCE).floor() as i32;
    let mut knot = Knot::default();
    for cell in [cell - 1, cell, cell + 1] {
        let draw = |k: u32| unit(SEED ^ 0x4b07 ^ k << 24, plank, cell);
        if draw(0) > KNOT_SHARE {
            continue;
        }
        let middle = Vec2::new(
            (cell as f32 + draw(1)) * KNOT_DISTANCE,
            PLANK * (0.2 + 0.6 * draw(2)),
        );
        let radius = KNOT_RADII.0 + (KNOT_RADII.1 - KNOT_RADII.0) * draw(3);
        let off = (grain - middle) / Vec2::new(KNOT_LENGTH, 1.0) / radius;
        let distance = off.length();
        knot.inside = knot.inside.max(1.0 - smoothstep(0.75, 1.1, distance));
        knot.near = knot.near.max(1.0 / (1.0 + 0.12 * off.length_squared()));
    }
    knot
}

/// How much of a place grains of saw dust cover.
fn dust_at(place: Vec2, footprint: f32) -> f32 {
    let seen = visible(DUST_CELL, footprint);
    let dusty = smoothstep(-0.3, 0.9, value(SEED ^ 0xd057, place / 0.11)) * DUST_SHARE;
    let mean = 0.04 * dusty;
    if seen == 0.0 {
        return mean;
    }
    let at = place / DUST_CELL;
    let cell = at.floor();
    let draw = |k: u32| unit(SEED ^ 0xd057 ^ k << 24, cell.x as i32, cell.y as i32);
    if draw(0) > dusty {
        return mean * (1.0 - seen);
    }
    let middle = Vec2::new(0.3 + 0.4 * draw(1), 0.3 + 0.4 * draw(2));
    let t = 2.0 * draw(3) - 1.0;
    let along = Vec2::new(1.0 - t * t, 2.0 * t) / (1.0 + t * t);
    let off = at - cell - middle;
    let stretch = 1.0 + 2.5 * draw(4) * draw(4);
    let radius = 0.05 + 0.10 * draw(5) * draw(5);
    let distance = Vec2::new(off.dot(along) / stretch, off.perp_dot(along)).length();
    let soft = (0.5 * footprint / DUST_CELL).max(0.02);
    let inside = 1.0 - smoothstep(radius - soft, radius + soft, distance);
    mean * (1.0 - seen) + 0.8 * inside * seen
}
