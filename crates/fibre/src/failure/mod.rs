//! When rods and bonds fail, and how they break (Sutherland 2012 §3.4).
//!
//! | module | content |
//! |---|---|
//! | `criteria` | [`FailureCriteria`], [`BondCriterion`] |
//! | `cohesion` | softening of bonds with a strength and an energy of fracture |
//! | `demand` | demand over strength of rods and bonds, and the elements that exceed it |
//! | `yielding` | yielding of rods in compression |
//! | `break_place` | where between vertices a rod breaks |
//! | `crumbs` | pieces of one or two edges, and the bonds that they turn off |
//! | `breaking` | breaking of elements, with its events |

pub(crate) mod break_place;
#[cfg(test)]
mod break_place_tests;
pub(crate) mod breaking;
pub(crate) mod cohesion;
#[cfg(test)]
mod cohesion_tests;
#[cfg(test)]
mod crack_band_tests;
pub(crate) mod criteria;
pub(crate) mod crumbs;
#[cfg(test)]
mod crumbs_tests;
pub(crate) mod demand;
#[cfg(test)]
mod tests;
pub(crate) mod yielding;

pub use criteria::{BondCriterion, FailureCriteria};
