//! Pictures enlarged.

use glam::Vec3;
use rayon::prelude::*;

/// A picture of another size, which is filled by all of it.
pub(crate) fn enlarged(pixels: Vec<Vec3>, from: [usize; 2], to: [usize; 2]) -> Vec<Vec3> {
    if from == to {
        return pixels;
    }
    let scale = [0, 1].map(|axis| from[axis] as f32 / to[axis] as f32);
    enlarge(&pixels, from, to, scale)
}

/// Enlarges pixels from one size to another, linearly between their middles. A pixel of the larger picture is `scale` of the smaller one's
/// wide and high.
pub(crate) fn enlarge(
    pixels: &[Vec3],
    from: [usize; 2],
    to: [usize; 2],
    scale: [f32; 2],
) -> Vec<Vec3> {
    // Where a middle of the larger picture lies between two of the smaller, and how near it is to the second.
    let between = |at: usize, axis: usize| {
        let place = (at as f32 + 0.5) * scale[axis] - 0.5;
        let place = place.clamp(0.0, (from[axis] - 1) as f32);
        let first = (place as usize).min(from[axis].saturating_sub(2));
        let second = (first + 1).min(from[axis] - 1);
        (first, second, place - first as f32)
    };
    let columns: Vec<_> = (0..to[0]).map(|x| between(x, 0)).collect();
    let at = |x: usize, y: usize| pixels[y * from[0] + x];
    let mut made = vec![Vec3::ZERO; to[0] * to[1]];
    let rows = made.par_chunks_mut(to[0]).enumerate();
    rows.for_each(|(y, row)| {
        let (top, bottom, down) = between(y, 1);
        for (pixel, &(left, right, along)) in row.iter_mut().zip(&columns) {
            let upper = at(left, top).lerp(at(right, top), along);
            let lower = at(left, bottom).lerp(at(right, bottom), along);
            *pixel = upper.lerp(lower, down);
        }
    });
    made
}
