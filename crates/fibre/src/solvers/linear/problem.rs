//! The linear system of a Newton step.

use crate::contact::ContactSpring;
use crate::rod_bundle::RodBundle;
use crate::solvers::grip::ResolvedGrip;
use crate::state::State;

/// A linear system: the forces at a state, linearised.
pub(crate) struct LinearProblem<'a> {
    pub bundle: &'a RodBundle,
    pub state: &'a State,
    /// Plastic strain before the step.
    pub plastic: &'a [f64],
    /// Bonds that soften at the state, with their damage.
    pub softened: &'a [(u32, f64)],
    /// Contacts at the state.
    pub springs: &'a [ContactSpring],
    pub grips: &'a [ResolvedGrip],
    /// Stiffness of inertia and damping over mass, 1/s².
    pub inertia: f64,
    /// Per degree of freedom: unbalanced force, N.
    pub residual: &'a [f64],
    /// Per degree of freedom: whether a clamp holds it.
    pub held: &'a [bool],
    /// Per degree of freedom: its displacement where held, m.
    pub prescribed: &'a [f64],
    /// Relative accuracy of the solution.
    pub tolerance: f64,
    /// Whether the preconditioner is made anew.
    pub update_preconditioner: bool,
}
