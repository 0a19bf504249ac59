//! Where a limb ends by its sections: where what they say for it adds up to most.
//!
//! Each step along a limb has a merit that does not depend on how many points there are. The limb ends where the sum of
//! merits is greatest, so that a gap is bridged where what follows makes up for it.

/// Information of a point about a section, in nats, from which on a section speaks for the limb. Points scattered evenly
/// have 0.2 about the circle that suits them best, those of clean bark 1.9.
const MIN_INFORMATION: f64 = 0.55;
/// How much more of it makes a full step.
const INFORMATION_SCALE: f64 = 0.3;
/// What a step without a section adds to the merit.
const MISS_MERIT: f64 = -1.0;
/// How far the merit may fall below its greatest before a limb is followed no farther, in steps without a section.
const MAX_MERIT_LOSS: f64 = 8.0;
/// The merit of a limb as it is followed, summed over its steps.
#[derive(Debug, Default)]
pub(super) struct Merit {
    total: f64,
    greatest: f64,
    /// Rings up to where it is greatest.
    pub rings: usize,
}

impl Merit {
    /// Adds a step, after which there are so many rings, with the information of a point about its section. Returns whether
    /// the limb has ended.
    pub fn add(&mut self, information: Option<f64>, rings: usize) -> bool {
        self.total += information.map_or(MISS_MERIT, |i| {
            ((i - MIN_INFORMATION) / INFORMATION_SCALE).clamp(-1.0, 1.0)
        });
        if self.total > self.greatest {
            (self.greatest, self.rings) = (self.total, rings);
        }
        self.total < self.greatest - MAX_MERIT_LOSS
    }
}
