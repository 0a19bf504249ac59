//! Kernels on wide registers: the one module with unsafe code. Its requirements are checked where safe code calls it: the
//! lengths of arrays, and that the processor has the instructions of a [`SimdLevel`].
//!
//! | module | content |
//! |---|---|
//! | `lanes`, `x86`, `level`, `dispatch` | eight numbers at once, and functions compiled for several instruction sets |
//! | `rods` | stretch and bending of rods, and the explicit step |
//! | `bonds`, `places` | forces of bonds, and where vertices and edges are |
//! | `bond_gradients`, `same_rod_blocks` | bonds linearised about a state, and their blocks between vertices of one rod |
//! | `bond_demands`, `bond_strains` | demand over strength of bonds, and their openings and slips |
//! | `banded_cholesky` | Cholesky factors of bands, eight side by side |
//! | `rank_update` | weighted sums of rows in blocks of the coarse matrix |
#![allow(unsafe_code)]

pub(crate) mod banded_cholesky;
pub(crate) mod bond_demands;
pub(crate) mod bond_gradients;
pub(crate) mod bond_strains;
pub(crate) mod bonds;
pub(crate) mod dispatch;
pub(crate) mod lanes;
pub(crate) mod level;
pub(crate) mod places;
pub(crate) mod rank_update;
pub(crate) mod rods;
pub(crate) mod same_rod_blocks;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use level::SimdLevel;
