//! Newton's method on everything that acts on a bundle: the equilibrium of a load step or of a stage of a time step.
//!
//! Unknown are the places of vertices and, with twist, the angles of edges. Edges yield inside the iteration: permanent
//! strain is found anew for every trial from that before the step, so that the force is the yield force at the end of
//! the step, whatever its length. The linear systems are solved by conjugate gradients with the last Cholesky factor
//! ([`super::matrix`]), which is made anew where it has become too old: a factor costs as much as some fifty
//! iterations, and between two load steps little of the matrix changes.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::direct::Direct;
use super::grips::{Grip, Held, resolve};
use super::iterative::System;
use super::swing::shorten;
use crate::bundle::Bundle;
use crate::energy::{Forces, rod};
use crate::error::SolverError;
use crate::failure::{self, Break, Failure};
use crate::frames;
use crate::kernel::Evaluator;
use crate::loads::Loads;
use crate::solver::{Contacts, Touch};
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;

/// Unbalanced forces fall to this part of the largest force in a rod.
const TOLERANCE: f64 = 1e-7;
/// Rounding: no force is balanced better than this part of the stiffest rod's k.
const ROUNDING: f64 = 1e-12;
/// Newton iterations.
const ITERATIONS: usize = 40;
/// Accuracy of linear solutions.
const LINEAR: f64 = 1e-3;
/// Tries of the line search.
const SEARCHES: usize = 8;
/// The slope along the step must fall to this part.
const SLOPE: f64 = 0.5;
/// Forces unbalanced by this many times the largest in a rod at the start hold energy that nobody put in: it is gone on then.
const WILD: f64 = 8.0;
/// For at most this many times the usual iterations.
const WILDEST: usize = 3;
/// Forces on a vertex count as balanced up to this part of those in its edges.
const PART: f64 = 0.2;
/// Moments count as couples so far apart, m.
const ARM: f64 = 1e-3;

/// What makes a stage of a time step of an equilibrium: M (x − `ahead`)/h² = F − c M (x − `behind`)/h.
#[derive(Debug, Clone)]
pub(crate) struct Inertia {
    pub h: f64,
    pub ahead: Vectors,
    pub behind: Vectors,
    pub angle_ahead: Vec<f64>,
    pub angle_behind: Vec<f64>,
}

/// What a step is to reach.
pub(crate) struct Goal<'a> {
    pub bundle: &'a Bundle,
    pub loads: &'a Loads,
    /// Whether edges yield.
    pub yielding: bool,
    /// Where the step begins, if not where the iteration does: contacts slide from there.
    pub from: &'a State,
    pub inertia: Option<&'a Inertia>,
    /// Time at the end, s.
    pub time: f64,
}

/// An equilibrium.
pub(crate) struct Found {
    pub state: State,
    /// Forces by clamps on vertices, N.
    pub reaction: Vectors,
    /// Contacts.
    pub touches: Vec<Touch>,
    pub iterations: usize,
    /// Whether forces are balanced as exactly as was asked for.
    pub settled: bool,
}

/// The method, with what it keeps between steps.
#[derive(Debug, Clone, Default)]
pub(crate) struct Newton {
    generation: Option<u64>,
    block: usize,
    linear: Linear,
    manner: Manner,
    evaluator: Option<Evaluator>,
    forces: Forces,
    residual: Vec<f64>,
    held: Vec<bool>,
    grips: Vec<Held>,
    touches: Vec<Touch>,
    scale: f64,
    /// Whether the preconditioner is to be made anew.
    stale: bool,
    breaks: failure::Room,
}

/// How linear systems are solved.
#[derive(Debug, Clone)]
enum Linear {
    /// With a Cholesky factor that is kept.
    Direct(Box<Direct>),
    /// Anew each time, of three freedoms at a vertex, or four.
    Three(Box<System<3>>),
    Four(Box<System<4>>),
}

impl Default for Linear {
    fn default() -> Self {
        Linear::Direct(Box::default())
    }
}

/// How exactly everything is solved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Manner {
    /// Whether nothing is remembered from one step to the next.
    pub forgetful: bool,
    /// Unbalanced forces fall to this part of the largest force in a rod.
    pub tolerance: f64,
    /// Newton iterations at most.
    pub iterations: usize,
    /// Accuracy of each linear solution.
    pub accuracy: f64,
    /// Whether the last iterate is taken where they do not suffice.
    pub take_last: bool,
    /// Whether the preconditioner of the first iteration after [`Newton::renew`] serves all that follow.
    pub one_matrix: bool,
}

/// As exactly as by default, remembering nothing.
pub(crate) const EXACT: Manner = Manner {
    forgetful: true,
    tolerance: TOLERANCE,
    iterations: ITERATIONS,
    accuracy: LINEAR,
    take_last: false,
    one_matrix: false,
};

impl Default for Manner {
    fn default() -> Self {
        let mut manner = EXACT;
        manner.forgetful = false;
        manner
    }
}

/// A linear system.
pub(super) struct Problem<'a> {
    pub bundle: &'a Bundle,
    pub state: &'a State,
    /// Permanent strain before the step.
    pub plastic: &'a [f64],
    pub touches: &'a [Touch],
    pub grips: &'a [Held],
    /// Stiffness of inertia and damping over mass, 1/s².
    pub inertia: f64,
    /// Per freedom: unbalanced force, N.
    pub residual: &'a [f64],
    /// Per freedom: whether a clamp holds it.
    pub held: &'a [bool],
    /// Per freedom: how far it goes where held, m.
    pub prescribed: &'a [f64],
    /// Accuracy of the solution.
    pub accuracy: f64,
    /// Whether the matrix, or what stands for it, is made anew.
    pub fresh: bool,
}

impl Newton {
    /// The method in another manner.
    pub fn in_manner(manner: Manner) -> Self {
        Newton {
            manner,
            ..Newton::default()
        }
    }

    /// Takes the stiffness of bonds `broken` of the bundle that this was prepared for; in `bundle` they have none already.
    pub fn weaken(&mut self, bundle: &Bundle, broken: &[u32]) {
        if let Some(evaluator) = &mut self.evaluator {
            evaluator.weaken(broken);
        }
        match &mut self.linear {
            Linear::Direct(_) => {}
            Linear::Three(system) => system.weakened(bundle),
            Linear::Four(system) => system.weakened(bundle),
        }
        self.stale = true;
    }

    /// What fails in a state of the bundle that this was prepared for.
    pub fn detect(&mut self, failure: &Failure, bundle: &Bundle, state: &State) -> &mut Vec<Break> {
        match &mut self.evaluator {
            Some(evaluator) => self.breaks.detect(failure, bundle, state, evaluator),
            None => failure::detect(failure, bundle, state, &mut self.breaks.queue),
        }
        &mut self.breaks.queue
    }

    /// Whether the forces on a vertex of a rod and its neighbours are balanced but for a small part of those in its edges.
    pub fn is_balanced(&self, bundle: &Bundle, state: &State, vertex: usize) -> bool {
        let edges = [vertex - 1, vertex];
        let stress = |&j: &usize| (bundle.stretch[j] * rod::strain(bundle, state, j)).abs();
        let most = PART * edges.iter().map(stress).fold(0.0, f64::max);
        (vertex - 1..=vertex + 1).all(|v| {
            let left = |axis| {
                let f = self.freedom(v, axis);
                if self.held[f] { 0.0 } else { self.residual[f] }
            };
            DVec3::new(left(0), left(1), left(2)).length() <= most
        })
    }

    /// Lets the preconditioner be made anew.
    pub fn renew(&mut self) {
        self.stale = true;
    }

    /// Makes everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &Bundle, grips: &[Grip]) {
        if self.generation == Some(bundle.generation) {
            return;
        }
        self.stale = true;
        self.generation = Some(bundle.generation);
        self.grips = grips.iter().map(|g| resolve(g, bundle)).collect();
        let n = bundle.vertices();
        self.block = if bundle.twisting { 4 } else { 3 };
        if !self.manner.forgetful {
            let mut direct = match std::mem::take(&mut self.linear) {
                Linear::Direct(direct) => direct,
                _ => Box::default(),
            };
            direct.prepare(bundle, &self.grips);
            self.linear = Linear::Direct(direct);
        } else {
            match &mut self.linear {
                Linear::Four(system) if bundle.twisting => system.prepare(bundle),
                Linear::Three(system) if !bundle.twisting => system.prepare(bundle),
                other => {
                    *other = if bundle.twisting {
                        Linear::Four(Box::default())
                    } else {
                        Linear::Three(Box::default())
                    };
                    self.generation = None;
                    return self.prepare(bundle, grips);
                }
            }
        }
        self.evaluator = Some(Evaluator::new(bundle));
        self.forces = Forces::zeros(n);
        self.residual = vec![0.0; n * self.block];
    }

    fn freedom(&self, vertex: usize, axis: usize) -> usize {
        vertex * self.block + axis
    }

    /// Forces of the grips, N.
    pub fn grip_forces(&self, bundle: &Bundle, state: &State, time: f64) -> Vec<f64> {
        self.grips
            .iter()
            .map(|g| g.force(bundle, state, time))
            .collect()
    }

    /// Mean displacements of what the grips hold, m.
    pub fn grip_displacements(&self, bundle: &Bundle, state: &State) -> Vec<f64> {
        self.grips
            .iter()
            .map(|g| g.displacement(bundle, state))
            .collect()
    }

    /// Conjugate gradients so far, of systems solved anew.
    pub fn gradients(&self) -> u64 {
        match &self.linear {
            Linear::Direct(_) => 0,
            Linear::Three(system) => system.iterations(),
            Linear::Four(system) => system.iterations(),
        }
    }

    /// Factors made so far.
    pub fn factors(&self) -> usize {
        match &self.linear {
            Linear::Direct(direct) => direct.factors,
            _ => 0,
        }
    }

    /// Finds the equilibrium at `goal.time`, looking from `start` on. The permanent strain before the step is that of `base`.
    pub fn solve(
        &mut self,
        goal: &Goal,
        base: &State,
        start: &State,
        contacts: &mut dyn Contacts,
    ) -> Result<Found, SolverError> {
        let bundle = goal.bundle;
        let (mut state, mut from) = (start.clone(), start.clone());
        let mut prescribed = self.hold(goal, start);
        self.balance(goal, base, contacts, &mut state);
        let (mut iterations, mut worst) = (0, self.worst());
        let moved = prescribed.iter().any(|d| *d != 0.0);
        let mut tolerance = self.manner.tolerance * self.scale;
        // A load on all vertices is small at each: a tolerance that is coarse would not see it.
        let at_least = usize::from(moved || self.manner.take_last);
        let mut allowed = self.manner.iterations;
        let begun = self.scale;
        while iterations < at_least || worst > tolerance || prescribed.iter().any(|d| *d != 0.0) {
            let most = if self.manner.take_last && worst > WILD * begun {
                WILDEST * self.manner.iterations
            } else {
                allowed
            };
            if iterations >= most || !worst.is_finite() {
                if self.manner.take_last && worst.is_finite() {
                    break;
                }
                return Err(SolverError::NotConverged {
                    time: goal.time,
                    iterations,
                    residual: worst,
                    tolerance,
                });
            }
            let fresh = !self.manner.one_matrix || self.stale;
            self.stale = false;
            let mut step = self.direction(goal, base, &state, &prescribed, fresh);
            let free = !prescribed.iter().any(|d| *d != 0.0);
            let last = iterations + 1 >= most;
            let short = shorten(bundle, self.block, last, &mut step, &mut prescribed);
            if short && allowed < 2 * self.manner.iterations {
                allowed += 1;
            }
            let slope = self.slope(&step);
            from.clone_from(&state);
            let mut length = 1.0;
            for search in 0..SEARCHES {
                self.place_at(bundle, &from, &step, length, &mut state);
                self.balance(goal, base, contacts, &mut state);
                let now = self.slope(&step);
                // The force along the step must not have turned round by much.
                let ok = now.abs() <= SLOPE * slope.abs()
                    || self.worst() <= self.manner.tolerance * self.scale;
                if !free
                    || ok
                    || search + 1 == SEARCHES
                    || slope.is_nan()
                    || slope <= 0.0
                    || now > 0.0
                {
                    break;
                }
                let part = if now.is_finite() {
                    slope / (slope - now)
                } else {
                    0.25
                };
                length *= part.clamp(0.1, 0.9);
            }
            iterations += 1;
            worst = self.worst();
            tolerance = self.manner.tolerance * self.scale;
        }
        let mut reaction = Vectors::zeros(bundle.vertices());
        for v in 0..bundle.vertices() {
            let part = |axis| {
                let f = self.freedom(v, axis);
                if self.held[f] { -self.residual[f] } else { 0.0 }
            };
            reaction.set(v, DVec3::new(part(0), part(1), part(2)));
        }
        Ok(Found {
            state,
            reaction,
            touches: std::mem::take(&mut self.touches),
            iterations,
            settled: worst <= tolerance,
        })
    }

    /// Marks what clamps hold and returns how far it has to go.
    fn hold(&mut self, goal: &Goal, base: &State) -> Vec<f64> {
        let (bundle, loads) = (goal.bundle, goal.loads);
        let n = bundle.vertices();
        self.held = vec![false; n * self.block];
        let mut way = vec![0.0; n * self.block];
        let mut moved = base.clone();
        for clamp in &loads.clamps {
            for (k, &v) in clamp.vertices.iter().enumerate() {
                let i = v as usize;
                let by = clamp.place(k, goal.time) - base.position.get(i);
                let mut at = moved.position.get(i);
                for axis in (0..3).filter(|&a| clamp.axes[a]) {
                    let f = self.freedom(i, axis);
                    (self.held[f], way[f]) = (true, by[axis]);
                    at[axis] = base.position.get(i)[axis] + by[axis];
                }
                moved.position.set(i, at);
            }
        }
        if bundle.twisting {
            moved.carry_frames(bundle);
            for j in (0..n).filter(|&j| !bundle.is_edge(j)) {
                let f = self.freedom(j, 3);
                self.held[f] = true;
            }
            for clamp in &loads.clamps {
                for (k, &e) in clamp.edges.iter().enumerate() {
                    let (j, f) = (e as usize, self.freedom(e as usize, 3));
                    let tangent = moved.tangent.get(j);
                    let wanted = clamp.director(k, goal.time).reject_from_normalized(tangent);
                    let turn =
                        frames::angle_about(moved.material_director(bundle, j), wanted, tangent);
                    self.held[f] = true;
                    way[f] = if turn.is_finite() { turn } else { 0.0 };
                }
            }
        }
        way
    }

    /// Lets edges yield from the permanent strain of `base`, and finds all unbalanced forces.
    fn balance(
        &mut self,
        goal: &Goal,
        base: &State,
        contacts: &mut dyn Contacts,
        state: &mut State,
    ) {
        let bundle = goal.bundle;
        let mut scale = 0.0f64;
        let mut stiffest = 0.0f64;
        for j in (0..bundle.vertices()).filter(|&j| bundle.is_edge(j)) {
            state.plastic_strain[j] = base.plastic_strain[j];
            let strain = rod::strain(bundle, state, j);
            let over = strain + bundle.yield_strain[j];
            if goal.yielding && over < 0.0 {
                state.plastic_strain[j] += over;
            }
            scale = scale.max((bundle.stretch[j] * strain.max(-bundle.yield_strain[j])).abs());
            stiffest = stiffest.max(bundle.stretch[j]);
        }
        let mut forces = std::mem::take(&mut self.forces);
        if let Some(evaluator) = &mut self.evaluator {
            evaluator.forces(bundle, state, &mut forces);
        }
        let Forces { linear, moment } = &mut forces;
        if !bundle.twisting {
            moment.fill(0.0);
        }
        let loads = goal.loads;
        loads.add_forces(
            bundle,
            goal.time,
            &state.position,
            &state.velocity,
            linear,
            moment,
        );
        if !contacts.is_empty() {
            contacts.touches(bundle, state, goal.from, goal.time, &mut self.touches);
            for touch in &self.touches {
                scale = scale.max(touch.force.length());
                for (v, w) in touch.shares() {
                    linear.add(v, touch.force * w);
                }
            }
        }
        for g in &self.grips {
            let force = g.force(bundle, state, goal.time);
            for &(v, w) in &g.vertices {
                linear.add(v as usize, g.direction * (force * w));
            }
        }
        if let Some(i) = goal.inertia {
            for v in 0..bundle.vertices() {
                let x = state.position.get(v);
                let a = (x - i.ahead.get(v)) / (i.h * i.h)
                    + (x - i.behind.get(v)) * (loads.damping / i.h);
                linear.add(v, a * -bundle.mass[v]);
                scale = scale.max(
                    bundle.mass[v] * ((i.behind.get(v) - i.ahead.get(v)) / (i.h * i.h)).length(),
                );
                if bundle.twisting {
                    let angle = state.angle[v];
                    let a = (angle - i.angle_ahead[v]) / (i.h * i.h)
                        + (angle - i.angle_behind[v]) * (loads.damping / i.h);
                    moment[v] -= bundle.inertia[v] * a;
                }
            }
        }
        for v in 0..bundle.vertices() {
            let f = linear.get(v);
            for axis in 0..3 {
                let at = self.freedom(v, axis);
                self.residual[at] = f[axis];
            }
            if self.block == 4 {
                let at = self.freedom(v, 3);
                self.residual[at] = moment[v];
            }
        }
        self.forces = forces;
        // Rounding of the stiffest rod is no force.
        self.scale = scale.max(stiffest * ROUNDING / TOLERANCE);
    }

    /// Work of the unbalanced forces along a step, where nothing is held.
    fn slope(&self, step: &[f64]) -> f64 {
        let all = step.iter().zip(&self.residual).zip(&self.held);
        all.fold(0.0, |s, ((d, r), h)| if *h { s } else { s + d * r })
    }

    /// The largest unbalanced force; moments count as couples a millimetre apart.
    fn worst(&self) -> f64 {
        let mut worst = 0.0f64;
        for (f, (r, h)) in self.residual.iter().zip(&self.held).enumerate() {
            if !h {
                let size = if f % self.block == 3 {
                    r.abs() / ARM
                } else {
                    r.abs()
                };
                // NaN must not pass.
                worst = if size.is_nan() {
                    f64::NAN
                } else {
                    worst.max(size)
                };
                if worst.is_nan() {
                    return f64::INFINITY;
                }
            }
        }
        worst
    }

    fn place_at(
        &self,
        bundle: &Bundle,
        from: &State,
        step: &[f64],
        length: f64,
        state: &mut State,
    ) {
        state.clone_from(from);
        for v in 0..bundle.vertices() {
            let d = DVec3::from_array([0, 1, 2].map(|a| step[self.freedom(v, a)]));
            state.position.add(v, d * length);
            if bundle.twisting {
                state.angle[v] += length * step[self.freedom(v, 3)];
            }
        }
        state.carry_frames(bundle);
    }

    /// The step that balances the linearised forces, `prescribed` where held.
    fn direction(
        &mut self,
        goal: &Goal,
        base: &State,
        state: &State,
        prescribed: &[f64],
        fresh: bool,
    ) -> Vec<f64> {
        let step_inertia = goal
            .inertia
            .map_or(0.0, |i| 1.0 / (i.h * i.h) + goal.loads.damping / i.h);
        let problem = Problem {
            bundle: goal.bundle,
            state,
            plastic: &base.plastic_strain,
            touches: &self.touches,
            grips: &self.grips,
            inertia: step_inertia,
            residual: &self.residual,
            held: &self.held,
            prescribed,
            accuracy: self.manner.accuracy,
            fresh,
        };
        match (&mut self.linear, &mut self.evaluator) {
            (Linear::Three(system), Some(evaluator)) => system.solve(&problem, evaluator),
            (Linear::Four(system), Some(evaluator)) => system.solve(&problem, evaluator),
            (Linear::Direct(direct), _) => direct.solve(&problem),
            _ => vec![0.0; self.residual.len()],
        }
    }
}
