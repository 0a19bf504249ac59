//! Scratches of a ground.

use super::noise::{smoothstep, unit, visible};
use glam::Vec2;

/// What scratches are like.
pub(super) struct Scratches {
    /// In the hash.
    pub seed: u32,
    /// Cells with one scratch each, m.
    pub cells: [f32; 2],
    /// Greatest half length, in cells.
    pub length: f32,
    /// Half width, m.
    pub width: f32,
    /// Greatest change of brightness.
    pub shade: f32,
    /// Share of them that are darker than the ground.
    pub dark: f32,
}

impl Scratches {
    /// How much lighter or darker a place is; detail finer than `footprint` (m) is averaged.
    pub fn at(&self, place: Vec2, footprint: f32) -> f32 {
        let seen = (self.width / (self.width + 0.5 * footprint)).sqrt();
        let mut shade = 0.0;
        for (size, n) in self.cells.into_iter().zip(0u32..) {
            let at = place / size + Vec2::splat(0.37 * n as f32);
            let cell = at.floor();
            let draw = |k: u32| unit(self.seed ^ n << 12 ^ k << 24, cell.x as i32, cell.y as i32);
            let off = at - cell - Vec2::splat(0.5);
            // Directions by half angles keep to arithmetic that is the same on every machine.
            let t = 4.0 * draw(0) - 2.0;
            let along = Vec2::new(1.0 - t * t, 2.0 * t) / (1.0 + t * t);
            let length = self.length * draw(1);
            let beside = (off - along * off.dot(along).clamp(-length, length)).length() * size;
            let wide = self.width * (0.4 + 0.9 * draw(2)) + 0.5 * footprint;
            let line = 1.0 - smoothstep(0.4 * wide, 1.4 * wide, beside);
            let tone = if draw(3) < self.dark { -1.0 } else { 0.7 };
            shade += tone * self.shade * draw(4) * line * seen * visible(0.3 * size, footprint);
        }
        shade
    }
}
