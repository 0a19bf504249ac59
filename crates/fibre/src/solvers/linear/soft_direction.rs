//! The direction in which an equilibrium is least stable, by conjugate gradients on the second variation of the potential.
//!
//! The matrices of [`super::iterative`] leave out what forces add to the stiffness, and so are positive whatever the load.
//! Here the product of the matrix and a direction is the difference of the forces on either side of the state
//! ([`SecondVariation`]), which has all of it. Conjugate gradients meet a direction of negative curvature exactly where the
//! matrix is not positive definite (Nocedal and Wright, *Numerical Optimization*, section 7.1); otherwise their solution is
//! mostly the softest direction, the more so the softer that is.

use super::iterative::{Buffers, IterativeSolver, dot, mask};
use super::problem::LinearProblem;
use crate::evaluator::ForceEvaluator;
use crate::simd::lanes::PaddedVec3;
use greenstick_geometry::{Cancelled, Context};

/// A direction whose stiffness without forces is below this fraction of what the stretching stiffness of the rods would give
/// it does not strain the wood: something hangs loose.
const LOOSE_STIFFNESS: f64 = 1e-13;

/// The second derivatives of the potential at a state, with what forces add to the stiffness.
pub(crate) trait SecondVariation {
    /// Sets `out` to their product with a direction.
    fn multiply(
        &mut self,
        evaluator: &mut ForceEvaluator,
        direction: &[PaddedVec3],
        out: &mut [PaddedVec3],
    );
}

/// The direction in which a state is least stable, as far as it was found.
#[derive(Debug, Clone)]
pub(crate) struct SoftDirection {
    /// Its stiffness over that without forces: 1 in wood without load, 0 at the critical load, negative beyond it.
    pub stiffness_ratio: f64,
    /// The vertex that moves most.
    pub vertex: usize,
}

impl<const B: usize> IterativeSolver<B> {
    /// Returns the softest direction that a disturbance, the problem's residual, excites; `None` where that direction does
    /// not strain the wood.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    pub fn soft_direction(
        &mut self,
        problem: &LinearProblem,
        evaluator: &mut ForceEvaluator,
        variation: &mut dyn SecondVariation,
        context: &Context,
    ) -> Result<Option<SoftDirection>, Cancelled> {
        let mut buffers = std::mem::take(&mut self.buffers);
        self.begin(problem, evaluator, &mut buffers, context)?;
        let curvature = self.descend(problem, evaluator, variation, &mut buffers, context)?;
        let Buffers { p, q, .. } = &mut buffers;
        let stiffness = self.multiply(problem, evaluator, p, q);
        let found = (stiffness > LOOSE_STIFFNESS * stretching(problem, p)).then(|| SoftDirection {
            stiffness_ratio: curvature / stiffness,
            vertex: largest(p),
        });
        self.buffers = buffers;
        Ok(found)
    }

    /// Leaves in the buffer `p` a direction of negative curvature, or else the displacement that the disturbance causes.
    /// Returns its curvature.
    fn descend(
        &mut self,
        problem: &LinearProblem,
        evaluator: &mut ForceEvaluator,
        variation: &mut dyn SecondVariation,
        buffers: &mut Buffers,
        context: &Context,
    ) -> Result<f64, Cancelled> {
        let mut product = |solver: &mut Self, p: &[PaddedVec3], q: &mut [PaddedVec3]| {
            variation.multiply(evaluator, p, q);
            mask(q, &solver.free);
            dot(p, q)
        };
        let tolerance = problem.tolerance;
        if let Some(curvature) =
            self.conjugate_gradients(tolerance, &mut product, buffers, context)?
        {
            return Ok(curvature);
        }
        buffers.p.clone_from(&buffers.x);
        Ok(product(self, &buffers.p, &mut buffers.q))
    }
}

/// Returns the stiffness of a direction if rods resisted across as they do along, N/m times its square.
fn stretching(problem: &LinearProblem, direction: &[PaddedVec3]) -> f64 {
    let bundle = problem.bundle;
    let square = |v: usize| -> f64 { (0..3).map(|a| direction[v].0[a].powi(2)).sum() };
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    edges.fold(0.0, |sum, j| {
        sum + bundle.stretch[j] / bundle.rest_length[j] * (square(j) + square(j + 1))
    })
}

/// Returns the vertex that moves most.
fn largest(direction: &[PaddedVec3]) -> usize {
    let square = |v: &PaddedVec3| -> f64 { (0..3).map(|a| v.0[a].powi(2)).sum() };
    let mut found = (0, 0.0);
    for (v, d) in direction.iter().enumerate() {
        if square(d) > found.1 {
            found = (v, square(d));
        }
    }
    found.0
}
