//! The limits of what is made of a stem.

use std::ops::RangeInclusive;

/// Voxels along the side of a segment.
pub const RESOLUTION_RANGE: RangeInclusive<usize> = 32..=512;
/// Most segments: a stem of more is a thread, or has a wrong section somewhere.
pub(super) const MAX_SEGMENTS: usize = 1000;
/// Most particles: more are a slip of the hand.
pub const MAX_PARTICLES: u64 = 50_000_000;
