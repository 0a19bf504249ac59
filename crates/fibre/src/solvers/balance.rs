//! The balance of forces that Newton's method drives to zero: energies, loads, contacts, grips and inertia, with yielding.
//!
//! Edges yield inside the iteration: every trial finds the plastic strain anew from that before the step, so that the force
//! at the end of the step is the yield force, whatever the step's length.

use super::grip::ResolvedGrip;
use super::limit_step::connected_parts;
use crate::contact::{ContactSpring, ContactTrial, Contacts};
use crate::energy::rod;
use crate::evaluator::ForceEvaluator;
use crate::failure::cohesion::Softening;
use crate::failure::criteria::BondCriterion;
use crate::forces::Forces;
use crate::loads::Loads;
use crate::material_frame;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use crate::world::World;
use glam::DVec3;
use greenstick_geometry::{Cancelled, Context};

/// The finest tolerance of Newton's method: unbalanced forces fall to this fraction of the largest force in a rod.
pub(super) const FINEST_TOLERANCE: f64 = 1e-7;
/// Rounding: no force is balanced better than this fraction of the stiffest rod's k.
const ROUNDING: f64 = 1e-12;
/// Lever arm by which moments are compared with forces, m.
const MOMENT_ARM: f64 = 1e-3;

/// The inertia of a stage of a time step, which makes the stage an equilibrium: M (x − `ahead`)/h² = F − c M (x −
/// `behind`)/h.
#[derive(Debug, Clone)]
pub(super) struct Inertia {
    /// Length of the stage, s.
    pub h: f64,
    /// Positions without forces, and positions without motion.
    pub ahead: Vectors,
    pub behind: Vectors,
    /// The same of angles.
    pub angle_ahead: Vec<f64>,
    pub angle_behind: Vec<f64>,
}

/// The equilibrium that is looked for.
#[derive(Clone, Copy)]
pub(super) struct EquilibriumProblem<'a> {
    pub bundle: &'a RodBundle,
    pub loads: &'a Loads,
    /// Whether edges yield.
    pub yielding: bool,
    /// Whether bonds soften ([`crate::failure::cohesion`]).
    pub softening: bool,
    /// The state at the start of the step, from which contacts slide.
    pub start: &'a State,
    /// The state whose plastic strain is that before the step.
    pub base: &'a State,
    pub inertia: Option<&'a Inertia>,
    /// Time at the end, s.
    pub time: f64,
    /// Energy that breaking has taken so far, J.
    pub lost: f64,
    /// Work of forces that were left unbalanced so far, J.
    pub unbalanced_work: f64,
}

impl<'a> EquilibriumProblem<'a> {
    /// The equilibrium of a world at a time (s), without inertia.
    pub fn at_rest(world: &'a World, time: f64) -> Self {
        EquilibriumProblem {
            bundle: &world.bundle,
            loads: &world.loads,
            yielding: world.failure.rods_yield,
            softening: world.failure.is_cohesive(),
            lost: world.fracture_loss,
            unbalanced_work: world.unbalanced_work,
            start: &world.state,
            base: &world.state,
            inertia: None,
            time,
        }
    }
}

/// The unbalanced forces of a trial state.
#[derive(Debug, Clone, Default)]
pub(super) struct Balance {
    /// Degrees of freedom at a vertex: 3, or 4 with twist.
    pub block: usize,
    pub evaluator: Option<ForceEvaluator>,
    pub grips: Vec<ResolvedGrip>,
    /// Per degree of freedom: unbalanced force, N.
    pub residual: Vec<f64>,
    /// Per degree of freedom: whether a clamp holds it.
    pub held: Vec<bool>,
    /// Contacts.
    pub springs: Vec<ContactSpring>,
    /// The largest force, with which the residual is compared, N.
    pub scale: f64,
    /// Per vertex: the first of its connected part.
    pub parts: Vec<usize>,
    forces: Forces,
    /// Bonds that are softer than before the step, with their damage.
    pub softened: Vec<(u32, f64)>,
    suspects: Vec<u32>,
}

impl Balance {
    /// Derives everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &RodBundle, grips: Vec<ResolvedGrip>) {
        let n = bundle.vertices();
        self.grips = grips;
        self.block = if bundle.twisting { 4 } else { 3 };
        self.evaluator = Some(ForceEvaluator::new(bundle));
        self.forces = Forces::zeros(n);
        self.residual = vec![0.0; n * self.block];
        self.parts = connected_parts(bundle);
        self.softened.clear();
    }

    /// Returns the number of a vertex's degree of freedom.
    pub fn dof(&self, vertex: usize, axis: usize) -> usize {
        vertex * self.block + axis
    }

    /// Marks the degrees of freedom that clamps hold, and returns how far each of them has to go.
    pub fn apply_clamps(&mut self, problem: &EquilibriumProblem, state: &State) -> Vec<f64> {
        let (bundle, loads) = (problem.bundle, problem.loads);
        let n = bundle.vertices();
        self.held = vec![false; n * self.block];
        let mut prescribed = vec![0.0; n * self.block];
        let mut clamped = state.clone();
        for clamp in &loads.clamps {
            for (k, &v) in clamp.vertices.iter().enumerate() {
                let i = v as usize;
                let way = clamp.position(k, problem.time) - state.position.get(i);
                let mut position = clamped.position.get(i);
                for axis in (0..3).filter(|&a| clamp.axes[a]) {
                    let f = self.dof(i, axis);
                    (self.held[f], prescribed[f]) = (true, way[axis]);
                    position[axis] = state.position.get(i)[axis] + way[axis];
                }
                clamped.position.set(i, position);
            }
        }
        if bundle.twisting {
            clamped.transport_frames(bundle);
            self.apply_clamped_angles(problem, &clamped, &mut prescribed);
        }
        prescribed
    }

    fn apply_clamped_angles(
        &mut self,
        problem: &EquilibriumProblem,
        clamped: &State,
        prescribed: &mut [f64],
    ) {
        let bundle = problem.bundle;
        for j in (0..bundle.vertices()).filter(|&j| !bundle.is_edge(j)) {
            let f = self.dof(j, 3);
            self.held[f] = true;
        }
        for clamp in &problem.loads.clamps {
            for (k, &e) in clamp.edges.iter().enumerate() {
                let (j, f) = (e as usize, self.dof(e as usize, 3));
                let tangent = clamped.tangent.get(j);
                let director = clamp.director(k, problem.time);
                let director = director.reject_from_normalized(tangent);
                let now = clamped.material_director(bundle, j);
                let turn = material_frame::signed_angle(now, director, tangent);
                self.held[f] = true;
                prescribed[f] = if turn.is_finite() { turn } else { 0.0 };
            }
        }
    }

    /// Lets edges of a trial state yield, and computes all unbalanced forces.
    ///
    /// # Errors
    /// [`Cancelled`] where the caller cancels the work.
    pub fn evaluate(
        &mut self,
        problem: &EquilibriumProblem,
        contacts: &mut dyn Contacts,
        state: &mut State,
        context: &Context,
    ) -> Result<(), Cancelled> {
        context.check()?;
        let bundle = problem.bundle;
        let (mut scale, stiffest) = yield_edges(problem, state);
        let mut forces = std::mem::take(&mut self.forces);
        if problem.softening {
            self.soften(bundle, state);
        }
        if let Some(evaluator) = &mut self.evaluator {
            evaluator.forces(bundle, state, &mut forces);
        }
        if !bundle.twisting {
            forces.moment.fill(0.0);
        }
        let (x, v) = (&state.position, &state.velocity);
        problem
            .loads
            .add_forces(bundle, problem.time, x, v, &mut forces);
        if !contacts.is_empty() {
            let trial = ContactTrial {
                bundle,
                state,
                start: problem.start,
                time: problem.time,
            };
            if let Err(cancelled) = contacts.find_springs(&trial, context, &mut self.springs) {
                self.forces = forces;
                return Err(cancelled);
            }
            for spring in &self.springs {
                scale = scale.max(spring.force.length());
                for (v, w) in spring.shares() {
                    forces.linear.add(v, spring.force * w);
                }
            }
        }
        for g in &self.grips {
            let force = g.force(bundle, state, problem.time);
            for held in &g.vertices {
                (forces.linear).add(held.vertex as usize, held.weight * force);
            }
        }
        if let Some(inertia) = problem.inertia {
            scale = scale.max(add_inertia(problem, inertia, state, &mut forces));
        }
        self.set_residual(bundle, &forces);
        self.forces = forces;
        // Rounding of the stiffest rod is no force.
        self.scale = scale.max(stiffest * ROUNDING / FINEST_TOLERANCE);
        Ok(())
    }

    /// Lets bonds soften in a trial state, each from its damage before the step.
    fn soften(&mut self, bundle: &RodBundle, state: &State) {
        let Some(evaluator) = &mut self.evaluator else {
            return;
        };
        for (bond, _) in self.softened.drain(..) {
            let before = bundle.bonds.damage[bond as usize];
            evaluator.set_bond_damage(bundle, bond, before);
        }
        evaluator.suspects(bundle, state, BondCriterion::Cohesive, &mut self.suspects);
        for &bond in &self.suspects {
            let softening = Softening::new(bundle, state, bond as usize);
            let damage = softening.damage();
            if damage > bundle.bonds.damage[bond as usize] {
                evaluator.set_bond_damage(bundle, bond, damage);
                self.softened.push((bond, damage));
            }
        }
    }

    fn set_residual(&mut self, bundle: &RodBundle, forces: &Forces) {
        for v in 0..bundle.vertices() {
            let f = forces.linear.get(v);
            for axis in 0..3 {
                let dof = self.dof(v, axis);
                self.residual[dof] = f[axis];
            }
            if self.block == 4 {
                let dof = self.dof(v, 3);
                self.residual[dof] = forces.moment[v];
            }
        }
    }

    /// Returns the work of the unbalanced forces along a step, where nothing is held.
    pub fn slope(&self, step: &[f64]) -> f64 {
        let all = step.iter().zip(&self.residual).zip(&self.held);
        all.fold(0.0, |s, ((d, r), h)| if *h { s } else { s + d * r })
    }

    /// Returns the largest unbalanced force, N; infinite where one is NaN. Moments count as couples one [`MOMENT_ARM`] apart.
    pub fn largest_residual(&self) -> f64 {
        let sizes = (0..self.residual.len()).map(|f| self.size(f));
        sizes.fold(0.0, f64::max)
    }

    /// Returns the size of an unbalanced force, as [`Balance::largest_residual`] compares them; 0 where it is held.
    fn size(&self, f: usize) -> f64 {
        let size = match self.residual[f].abs() {
            _ if self.held[f] => 0.0,
            size if f % self.block == 3 => size / MOMENT_ARM,
            size => size,
        };
        if size.is_nan() { f64::INFINITY } else { size }
    }

    /// Adds the work of the unbalanced forces on a vertex along a step, where nothing is held, to the first, and makes the second
    /// the largest of them, N, where it is less.
    pub fn measure(&self, vertex: usize, step: &[f64], (work, largest): (&mut f64, &mut f64)) {
        for f in vertex * self.block..(vertex + 1) * self.block {
            if !self.held[f] {
                *work += step[f] * self.residual[f];
                *largest = largest.max(self.size(f));
            }
        }
    }

    /// Returns the forces of clamps on vertices, and with twist their moments on edges.
    pub fn reaction(&self, bundle: &RodBundle) -> Forces {
        let component = |v: usize, axis: usize| {
            let f = self.dof(v, axis);
            if self.held[f] { -self.residual[f] } else { 0.0 }
        };
        let moment = |j: usize| {
            if self.block == 4 {
                component(j, 3)
            } else {
                0.0
            }
        };
        Forces {
            linear: (0..bundle.vertices())
                .map(|v| DVec3::new(component(v, 0), component(v, 1), component(v, 2)))
                .collect(),
            moment: (0..bundle.vertices()).map(moment).collect(),
        }
    }
}

/// Lets edges yield from the plastic strain before the step. Returns the largest tension and the stiffest rod's k, N.
fn yield_edges(problem: &EquilibriumProblem, state: &mut State) -> (f64, f64) {
    let bundle = problem.bundle;
    let (mut largest, mut stiffest) = (0.0f64, 0.0f64);
    for j in (0..bundle.vertices()).filter(|&j| bundle.is_edge(j)) {
        state.plastic_strain[j] = problem.base.plastic_strain[j];
        let strain = rod::strain(bundle, state, j);
        let over = strain + bundle.yield_strain[j];
        if problem.yielding && over < 0.0 {
            state.plastic_strain[j] += over;
        }
        largest = largest.max((bundle.stretch[j] * strain.max(-bundle.yield_strain[j])).abs());
        stiffest = stiffest.max(bundle.stretch[j]);
    }
    (largest, stiffest)
}

/// Adds the forces of inertia and damping. Returns the largest force that inertia needs for the motion before the step, N.
fn add_inertia(
    problem: &EquilibriumProblem,
    inertia: &Inertia,
    state: &State,
    forces: &mut Forces,
) -> f64 {
    let (bundle, damping) = (problem.bundle, problem.loads.damping);
    let square = inertia.h * inertia.h;
    let mut scale = 0.0f64;
    for v in 0..bundle.vertices() {
        let (ahead, behind) = (inertia.ahead.get(v), inertia.behind.get(v));
        let x = state.position.get(v);
        let a = (x - ahead) / square + (x - behind) * (damping / inertia.h);
        forces.linear.add(v, a * -bundle.mass[v]);
        scale = scale.max(bundle.mass[v] * ((behind - ahead) / square).length());
        if bundle.twisting {
            let angle = state.angle[v];
            let a = (angle - inertia.angle_ahead[v]) / square
                + (angle - inertia.angle_behind[v]) * (damping / inertia.h);
            forces.moment[v] -= bundle.inertia[v] * a;
        }
    }
    scale
}
