//! Solvers that look for equilibrium: of one time step, or of a load step.
//!
//! | module | what is in it |
//! |---|---|
//! | [`matrix`] | sparse symmetric matrices in an envelope, and their Cholesky factors |
//! | [`newton`] | Newton's method on all energies, loads and inertia, with yielding and grips |
//! | [`implicit`] | [`Implicit`]: time steps of animation at real stiffness |
//! | [`quasi_static`] | [`QuasiStatic`]: load steps to equilibrium, and breaks one by one |

pub mod implicit;
pub mod matrix;
pub mod newton;
pub mod quasi_static;

pub use implicit::Implicit;
pub use newton::Grip;
pub use quasi_static::QuasiStatic;
