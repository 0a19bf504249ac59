//! Energies of a bundle by kind, their forces, and the Hessians of single elements.
//!
//! This is the reference against which the fast code of the module `evaluator` is tested; it is written to be read and
//! checked. Forces are the exact negative gradients of the energies.
//!
//! - stretch (Sutherland 2012 Eq. 3.9): ½ k (|e|/|ē| − 1 − ε_p)² |ē|, ε_p the plastic strain;
//! - bend without twist (Eq. 3.4): α |κb|²/l, with the thesis's κb of rest lengths;
//! - bend with twist (Bergou 2010): α |κ − κ̄|²/l in the material frame, and twist β m²/l;
//! - bonds (§3.3.2, corrected): transverse ½ k_t (|d|/d₀ − 1)² d₀ and shear S (cos θ − cos θ₀)².

pub(crate) mod bend_twist;
pub(crate) mod bond;
pub(crate) mod hessian;
mod quadratic;
pub(crate) mod rod;
#[cfg(test)]
mod tests;
mod total;

pub use rod::strain;
pub use total::{Energies, add_forces, energies};
