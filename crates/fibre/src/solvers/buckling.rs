//! Buckling: the load at which an equilibrium stops being stable.
//!
//! Along a path of equilibria without breaks and contacts the second variation of the potential is positive in every
//! direction until a critical load (the energy criterion; Bažant and Cedolin, *Stability of Structures*, chapter 4). Beyond it
//! a straight column still has its straight equilibrium, to which Newton's method leads, but no wood would stay there. Just
//! before it, wood that is a little crooked moves far for little load, and equilibria become so hard to find that steps hardly
//! advance. Both end the path here.
//!
//! Only paths on which the wood is elastic are looked at. A column whose fibres yield first buckles at less than Euler's load,
//! and is not noticed.

use super::balance::EquilibriumProblem;
use super::linear::{LinearProblem, SecondVariation, SoftDirection};
use super::newton::{LinearSolver, Newton};
use super::quasi_static::QuasiStatic;
use super::solver::{AdvanceReport, Buckling};
use crate::bodies::state::ContactsState;
use crate::contact::Contacts;
use crate::error::SolverError;
use crate::evaluator::ForceEvaluator;
use crate::forces::Forces;
use crate::reactions::clamp_forces;
use crate::simd::lanes::PaddedVec3;
use crate::state::State;
use crate::world::World;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::noise::unit;

/// The load step in which stability is lost is halved so often: the load is known to a 256th of it.
const BISECTIONS: u32 = 8;
/// Where steps do not converge, wood whose softest direction has less than this fraction of its stiffness without load is at
/// its critical load.
const CRITICAL_RATIO: f64 = 0.1;
/// A step has hardly advanced that came less far than this fraction of its way; after so many in a row the path is at its end.
const HARDLY: f64 = 1.0 / 16.0;
const MOST_SHORT_STEPS: u32 = 3;
/// Largest change of an edge over its length by which second derivatives are taken as a difference: with a tenth of it, rounding
/// would show in slender rods, with ten times as much the edge's change of direction.
const DIFFERENCE: f64 = 1e-5;
/// Relative accuracy to which the displacement under a disturbance is solved.
const TOLERANCE: f64 = 1e-3;
/// Part of the disturbance that differs from vertex to vertex; the rest pushes all in one direction, askew to all axes.
const SCATTER: f64 = 0.5;
const PUSH: [f64; 3] = [1.0, 0.83, 0.61];
/// Lever arm of the disturbance's moments, m.
const MOMENT_ARM: f64 = 1e-3;

/// The world and its contacts at the last stable equilibrium.
struct Stable {
    world: World,
    contacts: ContactsState,
}

impl Stable {
    fn new(world: &World, contacts: &dyn Contacts) -> Self {
        Stable {
            world: world.clone(),
            contacts: contacts.snapshot(),
        }
    }

    fn restore(&self, world: &mut World, contacts: &mut dyn Contacts) {
        world.clone_from(&self.world);
        contacts.restore(&self.contacts, &world.bundle, &world.loads);
    }
}

impl QuasiStatic {
    /// Goes to the next equilibrium on the way to `time` (s), as far as equilibria are stable. The report has it where they are
    /// not.
    ///
    /// # Errors
    /// [`SolverError`]. World and contacts are then as they were.
    pub(super) fn next_stable(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        time: f64,
        context: &Context,
    ) -> Result<AdvanceReport, SolverError> {
        if !world.is_elastic() || !self.newton.options.stateless {
            return self.next_equilibrium(world, contacts, time, context);
        }
        let start = Stable::new(world, contacts);
        let report = match self.next_equilibrium(world, contacts, time, context) {
            Err(error @ SolverError::NotConverged { .. }) => {
                return self
                    .critical(world, contacts, context)?
                    .map_or(Err(error), |found| Ok(AdvanceReport::buckled(found)));
            }
            report => report?,
        };
        if !world.is_elastic() {
            return Ok(report);
        }
        if let Some(soft) = self.soft_direction(world, contacts, context)?
            && soft.stiffness_ratio <= 0.0
        {
            return self.bisect(start, world, contacts, soft, context);
        }
        self.count_short_steps(start.world.state.time, world.state.time, time);
        if self.short_steps >= MOST_SHORT_STEPS {
            let buckling = self.critical(world, contacts, context)?;
            return Ok(AdvanceReport { buckling, ..report });
        }
        Ok(report)
    }

    fn count_short_steps(&mut self, start: f64, reached: f64, time: f64) {
        let hardly = reached - start < HARDLY * (time - start);
        self.short_steps = if hardly { self.short_steps + 1 } else { 0 };
    }

    /// Goes from a stable equilibrium towards that of the world, which is not, as far as equilibria are stable.
    fn bisect(
        &mut self,
        mut stable: Stable,
        world: &mut World,
        contacts: &mut dyn Contacts,
        mut soft: SoftDirection,
        context: &Context,
    ) -> Result<AdvanceReport, SolverError> {
        let mut sum = AdvanceReport::default();
        let mut high = world.state.time;
        for _ in 0..BISECTIONS {
            let low = stable.world.state.time;
            stable.restore(world, contacts);
            let one = self.next_equilibrium(world, contacts, 0.5 * (low + high), context)?;
            match self.soft_direction(world, contacts, context)? {
                Some(found) if found.stiffness_ratio <= 0.0 => {
                    soft = found;
                    high = world.state.time;
                }
                _ => {
                    sum.add(&one);
                    stable = Stable::new(world, contacts);
                }
            }
        }
        stable.restore(world, contacts);
        sum.buckling = Some(buckling(world, &soft));
        Ok(sum)
    }

    /// Returns the end of the path where the world is at its critical load.
    fn critical(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Option<Buckling>, Cancelled> {
        let found = self.soft_direction(world, contacts, context)?;
        let critical = found.filter(|soft| soft.stiffness_ratio < CRITICAL_RATIO);
        Ok(critical.map(|soft| buckling(world, &soft)))
    }

    /// Returns the direction in which the world's equilibrium is least stable; `None` where something is in contact.
    fn soft_direction(
        &mut self,
        world: &World,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Option<SoftDirection>, Cancelled> {
        self.newton.prepare(&world.bundle, &[]);
        let problem = EquilibriumProblem::at_rest(world, world.state.time);
        self.newton.soft_direction(&problem, contacts, context)
    }
}

fn buckling(world: &World, soft: &SoftDirection) -> Buckling {
    let forces = clamp_forces(world);
    Buckling {
        time: world.state.time,
        load: (forces.iter()).fold(0.0, |most, c| f64::max(most, c.force.length())),
        vertex: world.bundle.origin[soft.vertex],
    }
}

impl Newton {
    /// Returns the direction in which the equilibrium from which `problem` starts is least stable; `None` where something is in
    /// contact, and with the direct linear solver.
    fn soft_direction(
        &mut self,
        problem: &EquilibriumProblem,
        contacts: &mut dyn Contacts,
        context: &Context,
    ) -> Result<Option<SoftDirection>, Cancelled> {
        let mut state = problem.start.clone();
        let balance = &mut self.balance;
        balance.apply_clamps(problem, &state);
        balance.evaluate(problem, contacts, &mut state, context)?;
        if !balance.springs.is_empty() {
            return Ok(None);
        }
        let system = LinearProblem {
            bundle: problem.bundle,
            state: &state,
            plastic: &problem.base.plastic_strain,
            softened: &[],
            springs: &[],
            grips: &[],
            inertia: 0.0,
            residual: &disturbance(problem, balance.block),
            held: &balance.held,
            prescribed: &vec![0.0; balance.held.len()],
            tolerance: TOLERANCE,
            update_preconditioner: true,
        };
        let mut variation = ForceDifference::new(problem, &state);
        match (&mut self.linear, &mut balance.evaluator) {
            (LinearSolver::WithoutTwist(solver), Some(evaluator)) => {
                solver.soft_direction(&system, evaluator, &mut variation, context)
            }
            (LinearSolver::WithTwist(solver), Some(evaluator)) => {
                solver.soft_direction(&system, evaluator, &mut variation, context)
            }
            _ => Ok(None),
        }
    }
}

/// Returns forces that excite all directions.
fn disturbance(problem: &EquilibriumProblem, block: usize) -> Vec<f64> {
    let bundle = problem.bundle;
    let mut forces = Vec::with_capacity(bundle.vertices() * block);
    for v in 0..bundle.vertices() {
        let scatter = |axis: i64| SCATTER * (2.0 * unit(0, v as i64, axis, 0) - 1.0);
        forces.extend((0..3).map(|a| bundle.mass[v] * (PUSH[a] + scatter(a as i64))));
        if block == 4 {
            forces.push(bundle.mass[v] * MOMENT_ARM * scatter(3));
        }
    }
    forces
}

/// Second derivatives as the difference of the forces on either side of a state.
struct ForceDifference<'a> {
    problem: &'a EquilibriumProblem<'a>,
    at: &'a State,
    beside: State,
    forces: [Forces; 2],
}

impl<'a> ForceDifference<'a> {
    fn new(problem: &'a EquilibriumProblem<'a>, at: &'a State) -> Self {
        let zeros = || Forces::zeros(problem.bundle.vertices());
        ForceDifference {
            problem,
            at,
            beside: at.clone(),
            forces: [zeros(), zeros()],
        }
    }

    /// Sets the forces at `length` times a direction from the state.
    fn evaluate(
        &mut self,
        side: usize,
        evaluator: &mut ForceEvaluator,
        direction: &[PaddedVec3],
        length: f64,
    ) {
        let EquilibriumProblem {
            bundle,
            loads,
            time,
            ..
        } = *self.problem;
        self.beside.clone_from(self.at);
        for (v, d) in direction.iter().enumerate() {
            let [x, y, z, angle] = d.0.map(|d| d * length);
            self.beside.position.add(v, DVec3::new(x, y, z));
            if bundle.twisting {
                self.beside.angle[v] += angle;
            }
        }
        self.beside.transport_frames(bundle);
        let forces = &mut self.forces[side];
        evaluator.forces(bundle, &self.beside, forces);
        if !bundle.twisting {
            forces.moment.fill(0.0);
        }
        let (x, v) = (&self.beside.position, &self.beside.velocity);
        loads.add_forces(bundle, time, x, v, forces);
    }
}

impl SecondVariation for ForceDifference<'_> {
    fn multiply(
        &mut self,
        evaluator: &mut ForceEvaluator,
        direction: &[PaddedVec3],
        out: &mut [PaddedVec3],
    ) {
        let bundle = self.problem.bundle;
        let place = |v: usize| DVec3::from_slice(&direction[v].0[..3]);
        let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
        let change = edges.fold(0.0, |most, j| {
            let edge = (place(j + 1) - place(j)).length() / bundle.rest_length[j];
            f64::max(most, edge.max(direction[j].0[3].abs()))
        });
        let length = DIFFERENCE / change;
        if !length.is_finite() {
            out.fill(PaddedVec3::ZERO);
            return;
        }
        self.evaluate(0, evaluator, direction, length);
        self.evaluate(1, evaluator, direction, -length);
        let [ahead, behind] = &self.forces;
        for (v, out) in out.iter_mut().enumerate() {
            let force = (behind.linear.get(v) - ahead.linear.get(v)) / (2.0 * length);
            let moment = (behind.moment[v] - ahead.moment[v]) / (2.0 * length);
            out.0 = [force.x, force.y, force.z, moment];
        }
    }
}
