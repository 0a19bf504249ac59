//! Numbers of the materials of stills and films: their own first, then those of the input.

/// The wood inside.
pub(super) const INNER_MATERIAL: u32 = 0;
/// The bark of a stem whose mesh has no material for it.
pub(super) const BARK_MATERIAL: u32 = 1;
/// Bodies.
pub(super) const BODY_MATERIAL: u32 = 2;
/// Number of materials before those of the input.
pub(super) const OWN_MATERIALS: u32 = 3;
