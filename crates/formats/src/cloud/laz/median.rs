//! The running median of five values that predicts differences of coordinates.

/// An approximate median of the last values: five sorted values, of which alternately the highest and the lowest is
/// dropped.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunningMedian {
    values: [i32; 5],
    drops_highest: bool,
}

impl RunningMedian {
    pub fn new() -> Self {
        RunningMedian {
            values: [0; 5],
            drops_highest: true,
        }
    }

    /// The median.
    pub fn get(&self) -> i32 {
        self.values[2]
    }

    /// Adds a value. The end that is dropped next lies on the other side of the median than the value.
    pub fn add(&mut self, value: i32) {
        let v = &mut self.values;
        if self.drops_highest {
            self.drops_highest = value < v[2];
            v[4] = value;
        } else {
            self.drops_highest = value <= v[2];
            v[0] = value;
        }
        v.sort_unstable();
    }
}
