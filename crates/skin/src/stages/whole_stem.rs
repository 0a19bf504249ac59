//! The stem of one or several breaks before any of them, and what follows from it for the face of each.

use greenstick_fracture::parameters::BreakParameters;
use greenstick_wood::noise;
use greenstick_wood::stem::{FoundStem, StemIdentity};

/// Bits of a seed that are kept: such a number is short enough to be compared by eye, and exact in all readers of JSON.
const SEED_BITS: u32 = 32;

/// The stem of one or several breaks before any of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WholeStem {
    /// What tells it from other stems.
    pub identity: StemIdentity,
    /// Its length, m.
    pub length: f64,
}

impl WholeStem {
    /// Returns what a stem that was found is before it is broken.
    pub fn new(found: &FoundStem) -> Self {
        WholeStem {
            identity: found.identity,
            length: found.stem.length,
        }
    }

    /// Returns the seed of a break of this stem: a hash of the seed of the request, of the stem, and of the number of the break
    /// among those of the request, from 0. It is the same wherever on the stem the break is.
    pub fn break_seed(&self, seed: u64, number: usize) -> u64 {
        let of_stem = noise::hash(seed, self.identity.hash() as i64, 0, 1);
        let own = match number {
            0 => of_stem,
            _ => noise::hash(of_stem, number as i64, 0, 2),
        };
        own >> (u64::BITS - SEED_BITS)
    }

    /// Returns the parameters of the face of a break of this stem: `p` with the seed of the break with this `number`, at the
    /// size of the stem, whose radius there is `radius` (m).
    pub fn face(&self, p: &BreakParameters, number: usize, radius: f64) -> BreakParameters {
        BreakParameters {
            seed: self.break_seed(p.seed, number),
            ..p.at_size(2.0 * radius)
        }
    }
}
