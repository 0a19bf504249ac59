//! Linear systems of a Newton step.
//!
//! | module | content |
//! |---|---|
//! | `problem` | [`LinearProblem`]: what is to be solved |
//! | `direct` | [`DirectSolver`]: conjugate gradients with a Cholesky factor that is retained from step to step |
//! | `envelope`, `ordering` | symmetric matrices in an envelope and their Cholesky factors; reverse Cuthill–McKee |
//! | `iterative` | [`IterativeSolver`]: conjugate gradients with a two-level preconditioner, made anew for every step |
//! | `banded_preconditioner` | its fine level: each rod solved exactly along itself |
//! | `coarse_space` | its coarse level: cross-sections that move as a whole |
//! | `soft_direction` | [`SoftDirection`]: the direction in which a state is least stable |
//! | `rod_blocks`, `rod_operator` | linearised rods, as blocks of the matrix and matrix-free |

mod banded_preconditioner;
mod coarse_space;
mod direct;
mod envelope;
mod iterative;
mod ordering;
mod problem;
mod rod_blocks;
mod rod_operator;
mod soft_direction;

pub(super) use direct::DirectSolver;
pub(super) use iterative::IterativeSolver;
pub(super) use problem::LinearProblem;
pub(super) use soft_direction::{SecondVariation, SoftDirection};
