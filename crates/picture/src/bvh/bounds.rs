//! Axis-aligned boxes in `f32`.

/// An axis-aligned box.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Bounds {
    pub const EMPTY: Bounds = Bounds {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    pub fn join(&mut self, other: &Bounds) {
        for a in 0..3 {
            self.low[a] = lesser(other.low[a], self.low[a]);
            self.high[a] = greater(other.high[a], self.high[a]);
        }
    }

    pub fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|a| greater(self.high[a] - self.low[a], 0.0));
        x * y + y * z + z * x
    }

    pub fn centre(&self, axis: usize) -> f32 {
        (self.low[axis] + self.high[axis]) * 0.5
    }
}

// Comparisons instead of `f32::min`: they compile to one instruction, and a NaN in the first argument is ignored.
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

pub(super) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
