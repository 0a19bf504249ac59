//! A forest floor: dark soil under layers of fallen leaves.

use super::look::GroundSurface;
use super::noise::{smoothstep, unit, value, visible};
use glam::{Vec2, Vec3};

/// Layers of leaves from the top: distance between leaves, m, and the share of places that have one.
const LAYERS: [(f32, f32); 4] = [(0.085, 0.30), (0.052, 0.6), (0.036, 0.8), (0.019, 0.8)];
/// Half length and half width of a leaf, in distances between leaves: least, and what the largest has more.
const LENGTHS: (f32, f32) = (0.42, 0.34);
const WIDTHS: (f32, f32) = (0.13, 0.24);
/// Linear reflectance of leaves: fresh, usual, and rotten.
const LEAVES: [Vec3; 4] = [
    Vec3::new(0.265, 0.165, 0.082),
    Vec3::new(0.205, 0.120, 0.062),
    Vec3::new(0.150, 0.096, 0.058),
    Vec3::new(0.235, 0.165, 0.105),
];
/// Linear reflectance of soil, and how much darker each layer is than the one above.
const SOIL: Vec3 = Vec3::new(0.060, 0.043, 0.030);
const DEEPER: f32 = 0.76;
/// Slope of a leaf's halves to its midrib, and by how much leaves are tilted.
const FOLD: f32 = 0.30;
const TILT: f32 = 0.38;
/// How far beyond its edge a leaf shades what lies below it, in its half width, and how much.
const SHADE_REACH: f32 = 1.45;
const SHADE: f32 = 0.5;
/// Half width of a midrib and of veins, in half widths of the leaf, and how much paler they are.
const MIDRIB: f32 = 0.07;
const MIDRIB_SHADE: f32 = 0.35;
const VEINS: f32 = 0.10;
/// Mean of all that, for what is too far to be seen singly.
const MEAN: Vec3 = Vec3::new(0.123, 0.077, 0.042);

/// In the hash.
const SEED: u32 = 0x11f7;

/// The forest floor at a place; detail finer than `footprint` (m) is averaged.
pub(super) fn litter(place: Vec2, footprint: f32) -> GroundSurface {
    let seen = visible(0.036, footprint);
    if seen == 0.0 {
        return GroundSurface {
            color: MEAN,
            slope: Vec2::ZERO,
        };
    }
    let mut shade = 1.0;
    let mut found = GroundSurface {
        color: Vec3::ZERO,
        slope: Vec2::ZERO,
    };
    let mut is_found = false;
    for (layer, light) in (0..LAYERS.len()).zip([1.0, DEEPER, DEEPER * DEEPER, DEEPER * DEEPER]) {
        let over = leaf_over(place, layer, footprint);
        if let Some(leaf) = over.leaf {
            found.color = leaf.color * light;
            found.slope = leaf.slope;
            is_found = true;
            shade *= over.shade;
            break;
        }
        shade *= over.shade;
    }
    if !is_found {
        let crumbs = value(SEED ^ 1, place / 0.012) + 0.7 * value(SEED ^ 2, place / 0.004);
        found.color = SOIL * (1.0 + 0.5 * crumbs).max(0.2);
    }
    // Wet and dry parts, and light that falls through a crown.
    let uneven = value(SEED ^ 3, place / 0.55) + 0.5 * value(SEED ^ 4, place / 0.16);
    let fine = value(SEED ^ 5, place / 0.006) * visible(0.006, footprint);
    found.color *= shade * (1.0 + 0.20 * uneven + 0.10 * fine);
    found.color = MEAN.lerp(found.color, seen);
    found.slope *= seen;
    found
}

/// The uppermost leaf of a layer over a place.
struct Over {
    leaf: Option<GroundSurface>,
    /// What is left of the light beside leaves of the layer that lie above.
    shade: f32,
}

/// The uppermost leaf of a layer over a place, and the shade of those beside it.
fn leaf_over(place: Vec2, layer: usize, footprint: f32) -> Over {
    let (size, share) = LAYERS[layer];
    let at = place / size + Vec2::splat(0.31 * layer as f32);
    let cell = at.floor();
    let mut over = Over {
        leaf: None,
        shade: 1.0,
    };
    // Leaves of a layer lie over each other in the order of a number of their own.
    let mut highest = -1.0;
    for n in 0..9 {
        let there = cell + Vec2::new((n % 3) as f32 - 1.0, (n / 3) as f32 - 1.0);
        let seed = SEED ^ 0x1eaf ^ (layer as u32) << 16;
        let draw = |k: u32| unit(seed ^ k << 24, there.x as i32, there.y as i32);
        let above = draw(0);
        if draw(1) > share || above < highest {
            continue;
        }
        let middle = there + Vec2::new(draw(2), draw(3));
        let off = at - middle;
        let long = LENGTHS.0 + LENGTHS.1 * draw(4);
        let reach = long * SHADE_REACH;
        if off.length_squared() > reach * reach {
            continue;
        }
        let direction = direction(draw(5), draw(6));
        let along = off.dot(direction) / long;
        // The midrib is bent.
        let bend = 0.3 * (draw(7) - 0.5);
        let beside = off.perp_dot(direction) / long - bend * along * along;
        let wide = (WIDTHS.0 + WIDTHS.1 * draw(8)) / long;
        let t = (0.5 + 0.5 * along).clamp(0.0, 1.0);
        // Widest before its middle, drawn out at the tip, with an edge that is no curve of a compass.
        let teeth = 0.06 * value(seed ^ 0x7ee7, Vec2::new(9.0 * along, 17.0 * draw(9)));
        let profile = (2.6 * t.sqrt() * (1.0 - t) * (1.0 + teeth)).max(1e-3);
        let from_rib = beside / (wide * profile);
        let ends = (along.abs() - 1.0).max(0.0) / 0.1;
        let outside = from_rib
            .abs()
            .max(1.0 + ends * f32::from(u8::from(ends > 0.0)));
        let outside = if ends > 0.0 { outside } else { from_rib.abs() };
        if outside < 1.0 {
            highest = above;
            over.leaf = Some(leaf_at(
                draw,
                (along, from_rib),
                direction,
                (size, footprint),
            ));
            over.shade = 1.0;
        } else if outside < SHADE_REACH {
            let near = 1.0 - (outside - 1.0) / (SHADE_REACH - 1.0);
            over.shade = over.shade.min(1.0 - SHADE * near);
        }
    }
    over
}

/// A leaf at a place along and beside its midrib, both from −1 to 1.
fn leaf_at(
    draw: impl Fn(u32) -> f32,
    (along, beside): (f32, f32),
    direction: Vec2,
    (size, footprint): (f32, f32),
) -> GroundSurface {
    let kind = (draw(10) * LEAVES.len() as f32) as usize;
    let base = LEAVES[kind.min(LEAVES.len() - 1)] * (0.7 + 0.6 * draw(11));
    let seen = visible(0.1 * size, footprint);
    let rib = 1.0 - smoothstep(0.5 * MIDRIB, MIDRIB, beside.abs());
    let vein = 7.0 * (along + 0.35 * beside.abs());
    let vein = (vein - vein.floor() - 0.5).abs() * 2.0;
    let vein = VEINS * (smoothstep(0.6, 1.0, vein) - 0.2);
    let blotch = 0.22
        * value(
            SEED ^ 0xb107,
            Vec2::new(3.0 * along + 40.0 * draw(12), 2.0 * beside),
        );
    let tone = 1.0 + seen * (MIDRIB_SHADE * rib + vein) + blotch;
    let across = Vec2::new(-direction.y, direction.x);
    let fold = FOLD * (draw(13) - 0.3) * beside.clamp(-1.0, 1.0) * 2.0;
    let tilt = Vec2::new(draw(14) - 0.5, draw(15) - 0.5) * (2.0 * TILT);
    GroundSurface {
        color: base * tone,
        slope: across * fold + tilt + direction * (0.4 * along * (draw(16) - 0.5)),
    }
}

/// A unit vector from two random numbers: half angles keep to arithmetic that is the same on every machine.
fn direction(a: f32, b: f32) -> Vec2 {
    let t = 2.0 * a - 1.0;
    let quarter = Vec2::new(1.0 - t * t, 2.0 * t) / (1.0 + t * t);
    if b < 0.5 { quarter } else { -quarter }
}
