//! The fast evaluation of whole bundles: the energies of [`crate::energy`] in loops over eight vertices or bonds at once.
//!
//! Bonds are nine tenths of the work. A first pass computes each bond's forces and writes them in the bond's slot; a second
//! pass goes through the vertices and gathers, in a fixed order, the forces on each. No two threads ever write to one place,
//! and no sum depends on how the work was divided, so that any number of threads gives the same bytes. Work is shared with
//! `rayon` in the caller's pool.

mod bond_filter;
mod forces;
#[cfg(test)]
mod tests;

pub(crate) use forces::ExplicitStep;
pub use forces::ForceEvaluator;
