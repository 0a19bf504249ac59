//! A floor of cast concrete: worn, with pores, sand, stains and hairline cracks.

use super::look::GroundSurface;
use super::noise::{smoothstep, unit, value, visible};
use super::scratches::Scratches;
use glam::{Vec2, Vec3};

/// Linear reflectance of worn concrete, and of what has soaked into it.
const CONCRETE: Vec3 = Vec3::new(0.196, 0.190, 0.180);
const SOAKED: Vec3 = Vec3::new(0.80, 0.77, 0.72);
/// Clouds of cement paste: size, m, and share of the brightness.
const CLOUDS: [(f32, f32); 4] = [(0.37, 0.03), (0.12, 0.02), (0.041, 0.03), (0.013, 0.075)];
/// Worn patches with ragged edges: size, m, and share of the brightness by which they are lighter or darker.
const PATCHES: [(f32, f32); 2] = [(0.085, 0.055), (0.031, 0.08)];
/// Scuffs of what was dragged over the floor.
const SCUFFS: Scratches = Scratches {
    seed: SEED ^ 0x5c1f,
    cells: [0.071, 0.026],
    length: 0.42,
    width: 0.28e-3,
    shade: 0.4,
    dark: 0.35,
};
/// Sand at the surface, likewise, and the height of its relief, m.
const SAND: [(f32, f32, f32); 3] = [
    (2.9e-3, 0.02, 0.05e-3),
    (0.95e-3, 0.04, 0.04e-3),
    (0.40e-3, 0.19, 0.03e-3),
];
/// Strokes of the trowel: length and width, m, and share of the brightness.
const STROKES: (Vec2, f32) = (Vec2::new(0.19, 7e-3), 0.055);
/// Size of stains, m, and how much of such a place is soaked.
const STAIN: f32 = 0.29;
const STAIN_SHARE: f32 = 0.6;
/// Distance between places of pores, m, and the share of them that have one; radii in that distance; and what is left of the light
/// in one.
const PORE_CELLS: [(f32, f32); 2] = [(17e-3, 0.30), (5.1e-3, 0.30)];
const PORE_RADII: (f32, f32) = (0.02, 0.085);
const PORE_LIGHT: f32 = 0.34;
/// Size of places with many pores, in those distances.
const PORE_PATCH: f32 = 5.0;
/// Slope of the rim of a pore.
const PORE_SLOPE: f32 = 0.7;
/// Distance between grains that wear has laid bare, of gravel and of sand, m, and the share of places that have one; their radii in that
/// distance; and how much lighter or darker they are.
const GRAIN_CELLS: [(f32, f32); 3] = [(6.5e-3, 0.4), (2.3e-3, 0.55), (1.1e-3, 0.5)];
const GRAIN_RADII: (f32, f32) = (0.06, 0.24);
const GRAIN_TONE: f32 = 0.46;
/// Size of the pattern of hairline cracks, m; half their width, m; what is left of the light in them; and the share of lines that are
/// open.
const CRACK_SIZE: f32 = 0.34;
const CRACK_WIDTH: f32 = 0.22e-3;
const CRACK_LIGHT: f32 = 0.35;
const CRACK_OPEN: f32 = 0.3;

/// In the hash.
const SEED: u32 = 0xc09c;

/// The floor at a place; detail finer than `footprint` (m) is averaged.
pub(super) fn concrete(place: Vec2, footprint: f32) -> GroundSurface {
    // Octaves lie at angles to each other, so that their lattices do not show.
    let noise = |k: u32, size: Vec2| value(SEED ^ k << 8, turned(place, k) / size);
    let mut shade = 0.0;
    // What a footprint averages away is not worked out.
    let seen = |size: f32| Some(visible(size, footprint)).filter(|seen| *seen > 0.0);
    for ((size, share), k) in CLOUDS.into_iter().zip(1..) {
        if let Some(seen) = seen(size) {
            shade += share * seen * noise(k, Vec2::splat(size));
        }
    }
    for ((size, share), k) in PATCHES.into_iter().zip(56..) {
        if let Some(seen) = seen(size) {
            shade += share * seen * patch_at(place, size, k);
        }
    }
    shade += SCUFFS.at(place, footprint);
    if let Some(seen) = seen(STROKES.0.y) {
        shade += STROKES.1 * seen * noise(8, STROKES.0);
    }
    let mut slope = Vec2::ZERO;
    for ((size, share, height), k) in SAND.into_iter().zip(16..) {
        let seen = visible(size, footprint);
        if seen == 0.0 {
            break;
        }
        let here = noise(k, Vec2::splat(size));
        let step = 0.3 * size;
        let rise = |off: Vec2| value(SEED ^ k << 8, turned(place + off, k) / size) - here;
        slope += Vec2::new(rise(Vec2::X * step), rise(Vec2::Y * step)) * (height * seen / step);
        shade += share * seen * here;
    }
    for (grains, k) in GRAIN_CELLS.into_iter().zip(48..) {
        shade += grain_at(place, grains, k, footprint);
    }
    let stain = noise(24, Vec2::splat(STAIN)) + 0.5 * noise(25, Vec2::splat(0.3 * STAIN));
    let soaked = STAIN_SHARE * smoothstep(0.1, 0.9, stain) * visible(STAIN, footprint);
    let mut color = CONCRETE * (1.0 + shade).max(0.3);
    color *= Vec3::ONE.lerp(SOAKED, soaked);
    for ((cell, share), k) in PORE_CELLS.into_iter().zip(32..) {
        let pore = pore_at(place, (cell, share), k, footprint);
        color *= 1.0 + (PORE_LIGHT - 1.0) * pore.inside;
        slope += pore.slope;
    }
    color *= 1.0 + (CRACK_LIGHT - 1.0) * crack_at(place, footprint);
    GroundSurface { color, slope }
}

/// How much a place lies in lighter (1) or darker (−1) patches of a size, m, whose edges fine noise makes ragged.
fn patch_at(place: Vec2, size: f32, purpose: u32) -> f32 {
    let octave = |k: u32, scale: f32| {
        value(
            SEED ^ purpose << 8 ^ k << 20,
            turned(place, purpose + k) / (scale * size),
        )
    };
    let depth =
        octave(0, 1.0) + 0.5 * octave(1, 0.31) + 0.3 * octave(2, 0.1) + 0.2 * octave(3, 0.04);
    smoothstep(0.2, 0.38, depth) - smoothstep(0.2, 0.38, -depth)
}

/// A place in axes of its own for each purpose.
fn turned(place: Vec2, purpose: u32) -> Vec2 {
    let half = 0.31 * (purpose % 8) as f32;
    let turn = Vec2::new(1.0 - half * half, 2.0 * half) / (1.0 + half * half);
    turn.rotate(place)
}

/// How much lighter or darker a place is by a grain of gravel or sand: the distance between their places, m, and the share of them that
/// have one.
fn grain_at(place: Vec2, (size, share): (f32, f32), purpose: u32, footprint: f32) -> f32 {
    let seen = visible(0.3 * size, footprint);
    let place = turned(place, purpose);
    let at = place / size;
    let cell = at.floor();
    let seed = SEED ^ 0x96a7 ^ purpose << 16;
    let draw = |k: u32| unit(seed ^ k << 24, cell.x as i32, cell.y as i32);
    if seen == 0.0 || draw(0) > share {
        return 0.0;
    }
    let radius = GRAIN_RADII.0 + (GRAIN_RADII.1 - GRAIN_RADII.0) * draw(1) * draw(1);
    let middle = Vec2::new(
        radius + (1.0 - 2.0 * radius) * draw(2),
        radius + (1.0 - 2.0 * radius) * draw(3),
    );
    // Grains have corners.
    let uneven = 1.0 + 0.4 * value(seed ^ 1, place / (0.3 * size));
    let distance = (at - cell - middle).length() * uneven;
    let inside = 1.0 - smoothstep(0.75 * radius, 1.05 * radius, distance);
    GRAIN_TONE * (2.0 * draw(4) - 1.0) * inside * seen
}

/// A pore of the floor at a place.
#[derive(Default)]
struct Pore {
    /// How much the place lies in one, 0 to 1.
    inside: f32,
    slope: Vec2,
}

/// The pore of a lattice at a place: the distance between its places, m, and the share of them that have one.
fn pore_at(place: Vec2, (size, share): (f32, f32), purpose: u32, footprint: f32) -> Pore {
    let seen = visible(0.15 * size, footprint);
    let at = place / size;
    let cell = at.floor();
    let draw = |k: u32| {
        unit(
            SEED ^ 0x9049 ^ purpose << 16 ^ k << 24,
            cell.x as i32,
            cell.y as i32,
        )
    };
    // Pores lie together where air was caught.
    let caught = smoothstep(-0.3, 0.9, value(SEED ^ 0x904b, cell / PORE_PATCH));
    if seen == 0.0 || draw(0) > 2.4 * share * caught {
        return Pore::default();
    }
    let middle = Vec2::new(0.2 + 0.6 * draw(1), 0.2 + 0.6 * draw(2));
    let radius = PORE_RADII.0 + (PORE_RADII.1 - PORE_RADII.0) * draw(3) * draw(3);
    let uneven = 1.0 + 0.55 * value(SEED ^ 0x904a, place / (0.05 * size));
    let off = at - cell - middle;
    let distance = off.length() * uneven / radius;
    let soft = 0.5 * footprint / size / radius;
    let inside = (1.0 - smoothstep(0.7 - soft, 1.0 + soft, distance)) * seen;
    let rim = (1.0 - (distance - 0.9).abs() / 0.5).max(0.0) * seen;
    Pore {
        inside,
        slope: off.normalize_or_zero() * (PORE_SLOPE * rim),
    }
}

/// How much of a place hairline cracks take: the lines where a slow noise that bends them is 0.
fn crack_at(place: Vec2, footprint: f32) -> f32 {
    let open = value(SEED ^ 0xc7, place / (0.9 * CRACK_SIZE));
    if open < 1.0 - 2.0 * CRACK_OPEN - 0.4 {
        return 0.0;
    }
    let bent = |p: Vec2| {
        value(SEED ^ 0xc8, p / CRACK_SIZE)
            + 0.09 * value(SEED ^ 0xc9, p / (0.06 * CRACK_SIZE))
            + 0.02 * value(SEED ^ 0xca, p / (0.012 * CRACK_SIZE))
    };
    let here = bent(place);
    let step = 0.5e-3;
    let slope = Vec2::new(
        bent(place + Vec2::X * step) - here,
        bent(place + Vec2::Y * step) - here,
    )
    .length()
        / step;
    let beside = here.abs() / slope.max(0.5);
    let wide = CRACK_WIDTH * (1.0 + 0.6 * value(SEED ^ 0xcb, place / 0.01));
    let soft = wide + 0.5 * footprint;
    let line = 1.0 - smoothstep(0.4 * soft, 1.2 * soft, beside);
    let fading = smoothstep(1.0 - 2.0 * CRACK_OPEN - 0.4, 1.0 - 2.0 * CRACK_OPEN, open);
    line * fading * (wide / soft)
}
