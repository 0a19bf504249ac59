//! Numbers that tell the noises of wood's appearance apart, in the order of their memory.

/// Streaks: the noises before that of the heartwood.
pub(super) const STREAK_NOISES: usize = 3;
/// What shifts the heartwood's edge.
pub(super) const HEARTWOOD_NOISE: usize = STREAK_NOISES;
/// Specks of pith and bark.
pub(super) const SPECK_NOISE: usize = HEARTWOOD_NOISE + 1;
/// Unevenness of pith and bark, from coarse to fine.
pub(super) const UNEVEN_NOISES: usize = SPECK_NOISE + 1;
/// Tints of the wood, from coarse to fine, after the two of uneven barks.
pub(super) const TINT_NOISES: usize = UNEVEN_NOISES + 2;
/// Where inner bark stays on wood that bark came off, after the two of tints.
pub(super) const BAST_NOISE: usize = TINT_NOISES + 2;
