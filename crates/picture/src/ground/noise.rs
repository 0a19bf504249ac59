//! Random numbers and value noise in the plane, for the patterns of grounds.

use crate::sampling::hash;
use glam::Vec2;

/// A number from 0 to 1 for a cell.
pub(super) fn unit(seed: u32, i: i32, j: i32) -> f32 {
    fraction(hash(hash(seed, i as u32), j as u32))
}

/// A number from 0 to 1 for a hash.
fn fraction(hash: u32) -> f32 {
    // 24 bits are what an f32 holds.
    (hash >> 8) as f32 / 16_777_216.0
}

/// The greatest whole number that is not above `v`, as `f32::floor` has it, which is a call where the processor's own instruction may not
/// be used.
fn whole(v: f32) -> f32 {
    // From 2²³ on all are whole.
    if v.abs() >= 8_388_608.0 {
        return v;
    }
    let cut = v as i32 as f32;
    if cut > v { cut - 1.0 } else { cut }
}

/// Value noise with features as wide as 1, from −1 to 1.
pub(super) fn value(seed: u32, place: Vec2) -> f32 {
    let low = Vec2::new(whole(place.x), whole(place.y));
    let f = place - low;
    let s = f * f * (Vec2::splat(3.0) - 2.0 * f);
    let (i, j) = (low.x as i32, low.y as i32);
    let columns = [i, i.wrapping_add(1)].map(|i| hash(seed, i as u32));
    let row = |j: i32| {
        let [a, b] = columns.map(|column| fraction(hash(column, j as u32)));
        a + (b - a) * s.x
    };
    let [a, b] = [row(j), row(j.wrapping_add(1))];
    2.0 * (a + (b - a) * s.y) - 1.0
}

/// Rises smoothly from 0 to 1 between two numbers.
pub(super) fn smoothstep(low: f32, high: f32, v: f32) -> f32 {
    let t = ((v - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// How much of a detail of a size is left when averaged over a footprint, 0 to 1.
pub(super) fn visible(size: f32, footprint: f32) -> f32 {
    1.0 - smoothstep(0.4, 1.2, footprint / size)
}
