//! Newton's method for the equilibrium of a load step or of a stage of a time step.
//!
//! Unknown are the positions of vertices and, with twist, the angles of edges. [`super::balance`] has the unbalanced forces,
//! [`super::linear`] solves the linear systems.

use super::balance::{Balance, EquilibriumProblem, FINEST_TOLERANCE};
use super::free_impulse::FreeAcceleration;
use super::grip::{Grip, ResolvedGrip};
use super::limit_step::limit_step;
use super::line_search::{LINE_SEARCH_TRIALS, LineSearch};
use super::linear::{DirectSolver, IterativeSolver, LinearProblem};
use super::prediction::Prediction;
use crate::contact::{ContactSpring, Contacts};
use crate::energy::{Energies, add_forces, energies};
use crate::error::SolverError;
use crate::failure::criteria::FailureCriteria;
use crate::failure::demand::{FailureDetector, Overstressed, find_overstressed};
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// Newton iterations.
const MAX_ITERATIONS: usize = 40;
/// Relative accuracy of linear solutions.
const LINEAR_TOLERANCE: f64 = 1e-3;
/// The work that unbalanced forces of all steps may have done, over that of one step; and the fraction of that of one step that a
/// step may always have, since nothing is ever balanced to the last bit. Errors of steps that follow each other mostly have
/// the same sign: of a thousand they would add up.
const UNBALANCED_STEPS: f64 = 4.0;
const MIN_TOLERANCE_RATIO: f64 = 0.01;
/// Work ahead that does not count, as a fraction of what counts as no work.
const AHEAD_RATIO: f64 = 0.1;
/// Iterations before the work of unbalanced forces counts: the first steps do not see how stiff rods become as they turn.
const MIN_WORK_ITERATIONS: usize = 2;

/// An equilibrium.
pub(super) struct Equilibrium {
    pub state: State,
    /// Forces of clamps on vertices, and their moments on edges.
    pub reaction: Forces,
    /// Contacts.
    pub springs: Vec<ContactSpring>,
    /// Bonds that are softer than before the step, with their damage.
    pub softened: Vec<(u32, f64)>,
    pub iterations: usize,
    /// Work of the forces that are not balanced in the step, J, without those that move free parts as a whole.
    pub unbalanced_work: f64,
    /// What these would do to free parts.
    pub unbalanced_motion: Option<FreeAcceleration>,
}

/// The method, with what it retains between steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Newton {
    generation: Option<u64>,
    pub(super) balance: Balance,
    pub(super) linear: LinearSolver,
    pub(super) options: NewtonOptions,
    detector: FailureDetector,
}

/// How linear systems are solved.
#[derive(Debug, Clone)]
pub(super) enum LinearSolver {
    /// With a retained Cholesky factor.
    Direct(Box<DirectSolver>),
    /// Anew for every step, with three degrees of freedom at a vertex.
    WithoutTwist(Box<IterativeSolver<3>>),
    /// The same with four.
    WithTwist(Box<IterativeSolver<4>>),
}

impl Default for LinearSolver {
    fn default() -> Self {
        LinearSolver::Direct(Box::default())
    }
}

/// How accurately everything is solved.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewtonOptions {
    /// Whether nothing is retained from one step to the next, so that a resumed run gives the same bits.
    pub stateless: bool,
    /// Unbalanced forces fall to this fraction of the largest force in a rod.
    pub tolerance: f64,
    /// Least number of Newton iterations: a load on all vertices is small at each of them, and a coarse tolerance would not
    /// see it.
    pub min_iterations: usize,
    /// Largest number of Newton iterations.
    pub max_iterations: usize,
    /// Relative accuracy of each linear solution.
    pub linear_tolerance: f64,
    /// Iterations that a preconditioner serves.
    pub preconditioner_iterations: usize,
    /// Unbalanced forces do less work in the step than this fraction of all energy there has been. A state is balanced too where
    /// they would do less than a tenth of that on the way to where Newton's method expects the balance: slack fibres, which are
    /// stiff along and soft across, have large unbalanced forces that hardly move anything. Infinite to leave out both.
    pub work_tolerance: f64,
    /// Whether the line search lengthens steps too. Linear systems leave out what makes rods under pressure softer: where they
    /// buckle, the way is longer than the step. Without inertia that could lead to another equilibrium than the nearest.
    pub lengthen_steps: bool,
}

impl NewtonOptions {
    /// The default accuracy, with nothing retained from one step to the next.
    pub const STATELESS: NewtonOptions = NewtonOptions {
        stateless: true,
        tolerance: FINEST_TOLERANCE,
        min_iterations: 0,
        max_iterations: MAX_ITERATIONS,
        linear_tolerance: LINEAR_TOLERANCE,
        preconditioner_iterations: 1,
        work_tolerance: f64::INFINITY,
        lengthen_steps: false,
    };
}

impl Default for NewtonOptions {
    fn default() -> Self {
        let mut options = NewtonOptions::STATELESS;
        options.stateless = false;
        options
    }
}

/// The present iterate, and the one before it.
struct Iterates {
    state: State,
    previous: State,
}

/// Work of unbalanced forces in a step, J, without those that move free parts as a whole, and the motion of those.
struct UnbalancedWork {
    done: f64,
    tolerance: f64,
    motion: FreeAcceleration,
}

impl UnbalancedWork {
    fn is_small(&self) -> bool {
        self.done.abs() <= self.tolerance
    }
}

/// The progress of an iteration.
struct Iteration {
    count: usize,
    /// Allowed number of iterations.
    allowed: usize,
    /// The largest unbalanced force, N, and the one that counts as balanced.
    residual: f64,
    tolerance: f64,
}

impl Newton {
    /// Returns the method with these options.
    pub fn with_options(options: NewtonOptions) -> Self {
        Newton {
            options,
            ..Newton::default()
        }
    }

    /// Finds what fails in a state of the prepared bundle.
    pub fn detect(
        &mut self,
        failure: &FailureCriteria,
        bundle: &RodBundle,
        state: &State,
    ) -> &[Overstressed] {
        let detector = &mut self.detector;
        match &mut self.balance.evaluator {
            Some(evaluator) => detector.detect(failure, bundle, state, evaluator),
            None => find_overstressed(failure, bundle, state, &mut detector.queue),
        }
        &detector.queue
    }

    /// Adds the forces of rods and bonds of the prepared bundle in a state.
    pub fn internal_forces(&mut self, bundle: &RodBundle, state: &State, forces: &mut Forces) {
        match &mut self.balance.evaluator {
            Some(evaluator) => evaluator.forces(bundle, state, forces),
            None => add_forces(bundle, state, forces),
        }
        if !bundle.twisting {
            forces.moment.fill(0.0);
        }
    }

    /// Returns the energies of a state of the prepared bundle.
    pub fn energies(&mut self, bundle: &RodBundle, state: &State) -> Energies {
        match &mut self.balance.evaluator {
            Some(evaluator) => evaluator.energies(bundle, state),
            None => energies(bundle, state),
        }
    }

    /// Derives everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &RodBundle, grips: &[Grip]) {
        if self.generation == Some(bundle.generation) {
            return;
        }
        self.generation = Some(bundle.generation);
        let grips = grips.iter().map(|g| ResolvedGrip::new(g, bundle)).collect();
        self.balance.prepare(bundle, grips);
        self.prepare_linear_solver(bundle);
    }

    fn prepare_linear_solver(&mut self, bundle: &RodBundle) {
        let suits = match &self.linear {
            LinearSolver::Direct(_) => !self.options.stateless,
            LinearSolver::WithoutTwist(_) => self.options.stateless && !bundle.twisting,
            LinearSolver::WithTwist(_) => self.options.stateless && bundle.twisting,
        };
        if !suits {
            self.linear = match (self.options.stateless, bundle.twisting) {
                (false, _) => LinearSolver::Direct(Box::default()),
                (true, false) => LinearSolver::WithoutTwist(Box::default()),
                (true, true) => LinearSolver::WithTwist(Box::default()),
            };
        }
        match &mut self.linear {
            LinearSolver::Direct(solver) => solver.prepare(bundle, &self.balance.grips),
            LinearSolver::WithoutTwist(solver) => solver.prepare(bundle),
            LinearSolver::WithTwist(solver) => solver.prepare(bundle),
        }
    }

    /// Returns the forces of the grips, N.
    pub fn grip_forces(&self, bundle: &RodBundle, state: &State, time: f64) -> Vec<f64> {
        let grips = self.balance.grips.iter();
        grips.map(|g| g.force(bundle, state, time)).collect()
    }

    /// Returns the displacements on which the grips act, m.
    pub fn grip_displacements(&self, bundle: &RodBundle, state: &State) -> Vec<f64> {
        let grips = self.balance.grips.iter();
        grips.map(|g| g.displacement(bundle, state)).collect()
    }

    /// Returns the number of conjugate gradient iterations so far, without those of the direct solver.
    pub fn conjugate_gradients(&self) -> u64 {
        match &self.linear {
            LinearSolver::Direct(_) => 0,
            LinearSolver::WithoutTwist(solver) => solver.iterations(),
            LinearSolver::WithTwist(solver) => solver.iterations(),
        }
    }

    /// Returns the number of Cholesky factors so far.
    pub fn factorisations(&self) -> usize {
        match &self.linear {
            LinearSolver::Direct(solver) => solver.factorisations(),
            _ => 0,
        }
    }

    /// Returns the forces of clamps in the state from which `problem` starts, which is at the time of that state.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    pub fn reaction_at_start(
        &mut self,
        problem: &EquilibriumProblem,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Forces, Cancelled> {
        let mut state = problem.start.clone();
        let balance = &mut self.balance;
        balance.apply_clamps(problem, &state);
        balance.evaluate(problem, contacts, &mut state, context)?;
        Ok(balance.reaction(problem.bundle))
    }

    /// Finds the equilibrium of `problem`, starting the search from `first`.
    ///
    /// # Errors
    /// [`SolverError::NotConverged`], [`SolverError::Cancelled`].
    pub fn solve(
        &mut self,
        problem: &EquilibriumProblem,
        first: &State,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        let mut state = first.clone();
        let prescribed = self.balance.apply_clamps(problem, first);
        self.balance
            .evaluate(problem, contacts, &mut state, context)?;
        self.solve_from(problem, state, prescribed, contacts, context)
    }

    /// Finds the equilibrium of `problem`, starting the search from a prediction, as far along its displacement as lessens
    /// unbalanced forces.
    ///
    /// # Errors
    /// [`SolverError::NotConverged`], [`SolverError::Cancelled`].
    pub fn solve_predicted(
        &mut self,
        problem: &EquilibriumProblem,
        first: Prediction,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        let mut iterates = Iterates {
            previous: first.state.clone(),
            state: first.state,
        };
        self.balance.apply_clamps(problem, &iterates.state);
        self.balance
            .evaluate(problem, contacts, &mut iterates.state, context)?;
        let step = &first.displacement;
        // What is already being pushed back goes no further.
        if self.balance.slope(step) > 0.0 {
            self.take_step(problem, contacts, &mut iterates, step, Some(1.0), context)?;
        }
        let prescribed = self.balance.apply_clamps(problem, &iterates.state);
        self.solve_from(problem, iterates.state, prescribed, contacts, context)
    }

    /// Goes on from a state in which the balance is known, and in which clamps have `prescribed` left to go.
    fn solve_from(
        &mut self,
        problem: &EquilibriumProblem,
        state: State,
        mut prescribed: Vec<f64>,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Equilibrium, SolverError> {
        let bundle = problem.bundle;
        let mut iterates = Iterates {
            previous: state.clone(),
            state,
        };
        let mut now = Iteration {
            count: 0,
            allowed: self.options.max_iterations,
            residual: self.balance.largest_residual(),
            tolerance: self.options.tolerance * self.balance.scale,
        };
        let pending = |prescribed: &[f64]| prescribed.iter().any(|d| *d != 0.0);
        let at_least = self.options.min_iterations;
        let before = if self.options.work_tolerance.is_infinite() {
            0.0
        } else {
            problem.lost + self.energies(bundle, problem.start).total()
        };
        let mut work = self.unbalanced_work(problem, &iterates.state, before);
        while now.count < at_least
            || now.residual > now.tolerance
            || work.as_ref().is_some_and(|w| !w.is_small())
            || pending(&prescribed)
        {
            if now.count >= now.allowed || !now.residual.is_finite() {
                return Err(SolverError::NotConverged {
                    time: problem.time,
                    iterations: now.count,
                    residual: now.residual,
                    tolerance: now.tolerance,
                });
            }
            let renewal = self.options.preconditioner_iterations.max(1);
            let update = now.count.is_multiple_of(renewal);
            let mut step =
                self.newton_step(problem, &iterates.state, &prescribed, update, context)?;
            let search = !pending(&prescribed);
            let ahead = self.balance.slope(&step).abs();
            let small = |w: &UnbalancedWork| w.is_small() && ahead <= AHEAD_RATIO * w.tolerance;
            if search && now.count >= MIN_WORK_ITERATIONS && work.as_ref().is_some_and(small) {
                break;
            }
            let last = now.count + 1 >= now.allowed;
            let block = self.balance.block;
            let parts = &self.balance.parts;
            let longest = limit_step(bundle, parts, block, last, &mut step, &mut prescribed);
            if longest <= 1.0 && now.allowed < 2 * self.options.max_iterations {
                now.allowed += 1;
            }
            let lengthen = self.options.lengthen_steps;
            let longest = search.then_some(if lengthen { longest } else { 1.0 });
            self.take_step(problem, contacts, &mut iterates, &step, longest, context)?;
            now.count += 1;
            now.residual = self.balance.largest_residual();
            now.tolerance = self.options.tolerance * self.balance.scale;
            work = self.unbalanced_work(problem, &iterates.state, before);
        }
        Ok(Equilibrium {
            state: iterates.state,
            reaction: self.balance.reaction(bundle),
            springs: std::mem::take(&mut self.balance.springs),
            softened: self.balance.softened.clone(),
            iterations: now.count,
            unbalanced_work: work.as_ref().map_or(0.0, |w| w.done),
            unbalanced_motion: work.map(|w| w.motion),
        })
    }

    /// Returns the work of unbalanced forces in the step so far, where it counts. `before` is the energy before the step, with
    /// what breaking has taken, J. The energy of a trial state counts where its forces are nearly balanced, as in the first steps
    /// of wood that was at rest; elsewhere it may be any.
    fn unbalanced_work(
        &self,
        problem: &EquilibriumProblem,
        state: &State,
        before: f64,
    ) -> Option<UnbalancedWork> {
        let (bundle, start, balance) = (problem.bundle, problem.start, &self.balance);
        let residual = balance.largest_residual();
        if self.options.work_tolerance.is_infinite() || residual <= FINEST_TOLERANCE * balance.scale
        {
            return None;
        }
        let mut way = vec![0.0; balance.residual.len()];
        for v in 0..bundle.vertices() {
            let change = state.position.get(v) - start.position.get(v);
            for axis in 0..3 {
                way[balance.dof(v, axis)] = change[axis];
            }
            if balance.block == 4 {
                way[balance.dof(v, 3)] = state.angle[v] - start.angle[v];
            }
        }
        let motion = FreeAcceleration::new(problem, state, balance);
        let mut work = UnbalancedWork {
            done: balance.slope(&way) - motion.work(bundle, start, state),
            motion,
            tolerance: self.options.work_tolerance * before,
        };
        if !work.is_small() && residual <= self.options.tolerance * balance.scale {
            let potential = energies(bundle, state).potential();
            work.tolerance += self.options.work_tolerance * potential;
        }
        let so_far = problem.unbalanced_work;
        if work.done * so_far > 0.0 {
            let left = UNBALANCED_STEPS * self.options.work_tolerance * before - so_far.abs();
            work.tolerance = left.clamp(MIN_TOLERANCE_RATIO * work.tolerance, work.tolerance);
        }
        Some(work)
    }

    /// Moves the iterate along a step, with a line search up to `longest` times the step where there is one.
    fn take_step(
        &mut self,
        problem: &EquilibriumProblem,
        contacts: &mut dyn Contacts,
        iterates: &mut Iterates,
        step: &[f64],
        longest: Option<f64>,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let mut search = LineSearch::new(&self.balance, step);
        let Iterates { state, previous } = iterates;
        previous.clone_from(state);
        for _ in 0..LINE_SEARCH_TRIALS {
            self.displace(problem.bundle, previous, step, &search, state);
            self.balance.evaluate(problem, contacts, state, context)?;
            if !search.go_on(&self.balance, step, self.options.tolerance, longest) {
                break;
            }
        }
        Ok(())
    }

    /// Sets `state` to `from` displaced by as much of a step as a line search tries.
    fn displace(
        &self,
        bundle: &RodBundle,
        from: &State,
        step: &[f64],
        search: &LineSearch,
        state: &mut State,
    ) {
        state.clone_from(from);
        for v in 0..bundle.vertices() {
            let length = search.length(v);
            let d = DVec3::from_array([0, 1, 2].map(|a| step[self.balance.dof(v, a)]));
            state.position.add(v, d * length);
            if bundle.twisting {
                state.angle[v] += length * step[self.balance.dof(v, 3)];
            }
        }
        state.transport_frames(bundle);
    }

    /// Returns the step that balances the linearised forces; where clamps hold, it is `prescribed`.
    fn newton_step(
        &mut self,
        problem: &EquilibriumProblem,
        state: &State,
        prescribed: &[f64],
        update_preconditioner: bool,
        context: &Context,
    ) -> Result<Vec<f64>, Cancelled> {
        let inertia = problem
            .inertia
            .map_or(0.0, |i| 1.0 / (i.h * i.h) + problem.loads.damping / i.h);
        let balance = &mut self.balance;
        let system = LinearProblem {
            bundle: problem.bundle,
            state,
            plastic: &problem.base.plastic_strain,
            softened: &balance.softened,
            springs: &balance.springs,
            grips: &balance.grips,
            inertia,
            residual: &balance.residual,
            held: &balance.held,
            prescribed,
            tolerance: self.options.linear_tolerance,
            update_preconditioner,
        };
        let step = match (&mut self.linear, &mut balance.evaluator) {
            (LinearSolver::WithoutTwist(solver), Some(evaluator)) => {
                solver.solve(&system, evaluator, context)
            }
            (LinearSolver::WithTwist(solver), Some(evaluator)) => {
                solver.solve(&system, evaluator, context)
            }
            (LinearSolver::Direct(solver), _) => solver.solve(&system, context),
            _ => Ok(vec![0.0; balance.residual.len()]),
        }?;
        Ok(step)
    }
}
