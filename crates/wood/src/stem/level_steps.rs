//! Finding the layer of a length among levels without a search.

/// Steps for each level.
const STEPS_PER_LEVEL: usize = 4;

/// Equal steps from the first of ascending levels to the last, with the number of levels before each.
///
/// ```
/// use greenstick_wood::stem::LevelSteps;
///
/// let levels = [0.0, 0.1, 0.5, 2.0];
/// let steps = LevelSteps::new(&levels);
/// assert_eq!(steps.count(&levels, 0.3), 2);
/// assert_eq!(steps.count(&levels, 0.5), 3);
/// assert_eq!(steps.count(&levels, -1.0), 0);
///
/// let one = LevelSteps::new(&[0.5]);
/// assert_eq!([0.4, 0.5, 0.6].map(|s| one.count(&[0.5], s)), [0, 1, 1]);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelSteps {
    /// Where the first step begins.
    first: f64,
    /// Steps per unit of length.
    scale: f64,
    /// The last step.
    last: f64,
    /// For each step how many levels lie in the steps before it.
    before: Vec<u32>,
}

impl LevelSteps {
    /// Returns the steps of `levels`, which ascend.
    pub fn new(levels: &[f64]) -> Self {
        let (Some(first), Some(last)) = (levels.first(), levels.last()) else {
            return LevelSteps::default();
        };
        let count = levels.len() * STEPS_PER_LEVEL;
        let mut steps = LevelSteps {
            first: *first,
            scale: count as f64 / (last - first),
            last: count as f64,
            before: vec![0; count + 2],
        };
        for &level in levels {
            let step = steps.step(level);
            steps.before[step + 1] += 1;
        }
        for i in 1..steps.before.len() {
            steps.before[i] += steps.before[i - 1];
        }
        steps
    }

    #[inline]
    fn step(&self, length: f64) -> usize {
        // A length below the first and NaN belong to step 0.
        let step = (length - self.first) * self.scale;
        step.max(0.0).min(self.last) as u32 as usize
    }

    /// Returns how many of the levels that the steps were made of lie at or below `length`.
    #[inline]
    pub fn count(&self, levels: &[f64], length: f64) -> usize {
        // A step rises with its length, so that all levels in the steps before lie below.
        let before = self.before.get(self.step(length)).copied().unwrap_or(0);
        let mut count = before as usize;
        while count < levels.len() && levels[count] <= length {
            count += 1;
        }
        count
    }
}
