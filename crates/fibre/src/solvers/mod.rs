//! Solvers: methods that move a world through time.
//!
//! | module | content |
//! |---|---|
//! | `solver` | [`Solver`], the interface of all; `stepwise`: those that go in equal steps |
//! | `explicit` | [`Explicit`]: symplectic Euler, the reference; `stability` finds its step |
//! | `implicit` | [`Implicit`]: time steps of animation at real stiffness |
//! | `interactive` | [`Interactive`]: one step per frame, short ones while wood breaks |
//! | `quasi_static` | [`QuasiStatic`]: load steps to equilibrium, and breaks one by one |
//! | `buckling` | [`Buckling`]: the load at which an equilibrium stops being stable |
//! | `newton` | Newton's method on all energies, loads and inertia, with yielding and grips; `balance`: its unbalanced forces |
//! | `limit_step` | limits Newton steps |
//! | `line_search` | how far each part goes along a step |
//! | `grip` | `Grip`: springs on weighted sums of displacements |
//! | `linear` | linear systems of a Newton step |

mod balance;
mod buckling;
mod crack;
mod explicit;
mod free_impulse;
#[cfg(test)]
mod free_impulse_tests;
mod free_motion;
mod grip;
mod implicit;
mod interactive;
mod limit_step;
mod line_search;
mod linear;
mod newton;
mod prediction;
mod quasi_static;
mod rigid_parts;
mod solver;
mod stability;
mod step_energy;
mod stepwise;

pub use explicit::{BLOW_UP_RATIO, Explicit};
pub(crate) use grip::Grip;
pub(crate) use implicit::DEFAULT_STEP as IMPLICIT_STEP;
pub use implicit::Implicit;
pub(crate) use interactive::DEFAULT_STEP as INTERACTIVE_STEP;
pub use interactive::{Interactive, InteractiveEffort};
pub use quasi_static::{QuasiStatic, QuasiStaticEffort};
pub use solver::{AdvanceReport, Buckling, Solver};
