//! Newton's method on everything that acts on a bundle: the equilibrium of a load step or of a stage of a time step.
//!
//! Unknown are the places of vertices and, with twist, the angles of edges. Edges yield inside the iteration: permanent
//! strain is found anew for every trial from that before the step, so that the force is the yield force at the end of
//! the step, whatever its length. The linear systems are solved by conjugate gradients with the last Cholesky factor
//! ([`super::matrix`]), which is made anew where it has become too old: a factor costs as much as some fifty
//! iterations, and between two load steps little of the matrix changes.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::matrix::{Envelope, conjugate_gradients, order};
use crate::bundle::Bundle;
use crate::energy::{Curvature, ElementHessian, Forces, bond, framed, rod};
use crate::error::SolverError;
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
/// Stiffness of a yielding edge over that of an elastic one, in the matrix only: none at all could leave it singular.
const YIELDING: f64 = 1e-3;
/// Accuracy of linear solutions.
const LINEAR: f64 = 1e-3;
/// Conjugate gradients before a new factor is made.
const PATIENCE: usize = 14;
/// Tries of the line search.
const SEARCHES: usize = 8;
/// The slope along the step must fall to this part.
const SLOPE: f64 = 0.5;

/// A grip on the mean displacement of some vertices: it spreads its force over them and lets them turn, as a beam's
/// supports do in beam theory. A stiff spring.
#[derive(Debug, Clone, PartialEq)]
pub struct Grip {
    /// Vertices, by their numbers in the unbroken bundle.
    pub vertices: Vec<u32>,
    /// Their weights; both halves of a broken vertex share its.
    pub weights: Vec<f64>,
    /// Direction (unit).
    pub direction: DVec3,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Speed of the spring's other end along the direction, m/s; at time 0 it is where the vertices are at rest.
    pub speed: f64,
}

/// A grip on the bundle as it is now.
#[derive(Debug, Clone)]
struct Held {
    /// Vertices with weights whose sum is 1.
    vertices: Vec<(u32, f64)>,
    direction: DVec3,
    stiffness: f64,
    speed: f64,
}

impl Held {
    fn displacement(&self, bundle: &Bundle, state: &State) -> f64 {
        self.vertices.iter().fold(0.0, |sum, &(v, w)| {
            let moved = state.position.get(v as usize) - bundle.rest.get(v as usize);
            sum + w * moved.dot(self.direction)
        })
    }

    fn force(&self, bundle: &Bundle, state: &State, time: f64) -> f64 {
        self.stiffness * (self.speed * time - self.displacement(bundle, state))
    }
}

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
}

/// The method, with what it keeps between steps.
#[derive(Debug, Clone, Default)]
pub(crate) struct Newton {
    generation: Option<u64>,
    block: usize,
    place: Vec<u32>,
    matrix: Envelope,
    factor: Option<Envelope>,
    evaluator: Option<Evaluator>,
    forces: Forces,
    residual: Vec<f64>,
    held: Vec<bool>,
    grips: Vec<Held>,
    touches: Vec<Touch>,
    scale: f64,
    factors: usize,
}

impl Newton {
    /// Makes everything that depends on which rods and bonds there are.
    pub fn prepare(&mut self, bundle: &Bundle, grips: &[Grip]) {
        if self.generation == Some(bundle.generation) {
            return;
        }
        self.generation = Some(bundle.generation);
        self.grips = grips.iter().map(|g| resolve(g, bundle)).collect();
        self.block = if bundle.twisting { 4 } else { 3 };
        let n = bundle.vertices();
        let mut pairs = Vec::new();
        for i in 0..n as u32 {
            if bundle.is_edge(i as usize) {
                pairs.push((i, i + 1));
            }
            if bundle.bend[i as usize] > 0.0 {
                pairs.push((i - 1, i + 1));
            }
        }
        for (&v, &e) in bundle.bonds.vertex.iter().zip(&bundle.bonds.edge) {
            pairs.extend([(v, e), (v, e + 1)]);
        }
        for g in &self.grips {
            for (k, a) in g.vertices.iter().enumerate() {
                pairs.extend(g.vertices[..k].iter().map(|b| (a.0, b.0)));
            }
        }
        self.place = vec![0; n];
        for (k, v) in order(n, &pairs).into_iter().enumerate() {
            self.place[v as usize] = k as u32;
        }
        let place = &self.place;
        let moved = pairs
            .iter()
            .map(|&(a, b)| (place[a as usize], place[b as usize]));
        self.matrix = Envelope::zeros(self.block, n, moved);
        self.factor = None;
        self.evaluator = Some(Evaluator::new(bundle));
        self.forces = Forces::zeros(n);
        self.residual = vec![0.0; n * self.block];
    }

    fn freedom(&self, vertex: usize, axis: usize) -> usize {
        self.place[vertex] as usize * self.block + axis
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

    /// Factors made so far.
    pub fn factors(&self) -> usize {
        self.factors
    }

    /// Finds the equilibrium at `goal.time`, starting from `base`, whose permanent strain is that before the step.
    pub fn solve(
        &mut self,
        goal: &Goal,
        base: &State,
        contacts: &mut dyn Contacts,
    ) -> Result<Found, SolverError> {
        let bundle = goal.bundle;
        let mut state = base.clone();
        let mut prescribed = self.hold(goal, base);
        self.balance(goal, base, contacts, &mut state);
        let (mut iterations, mut worst) = (0, self.worst());
        let moved = prescribed.iter().any(|d| *d != 0.0);
        let mut tolerance = TOLERANCE * self.scale;
        while iterations == 0 && moved || worst > tolerance {
            if iterations == ITERATIONS || !worst.is_finite() {
                return Err(SolverError::NotConverged {
                    time: goal.time,
                    iterations,
                    residual: worst,
                    tolerance,
                });
            }
            let step = self.direction(goal, base, &state, &prescribed);
            let slope: f64 = step
                .iter()
                .zip(&self.residual)
                .zip(&self.held)
                .fold(0.0, |s, ((d, r), h)| if *h { s } else { s + d * r });
            let from = state.clone();
            let free = iterations > 0 || !moved;
            let mut length = if free {
                self.longest(bundle, &step)
            } else {
                1.0
            };
            for search in 0..SEARCHES {
                self.place_at(bundle, &from, &step, length, &mut state);
                self.balance(goal, base, contacts, &mut state);
                let now: f64 = step
                    .iter()
                    .zip(&self.residual)
                    .zip(&self.held)
                    .fold(0.0, |s, ((d, r), h)| if *h { s } else { s + d * r });
                // The force along the step must not have turned round by much.
                let ok = now.abs() <= SLOPE * slope.abs() || self.worst() <= TOLERANCE * self.scale;
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
            prescribed.fill(0.0);
            iterations += 1;
            worst = self.worst();
            tolerance = TOLERANCE * self.scale;
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

    /// The largest unbalanced force; moments count as couples a millimetre apart.
    fn worst(&self) -> f64 {
        const ARM: f64 = 1e-3;
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

    /// Most of a step that moves nothing farther than its shortest edge.
    fn longest(&self, bundle: &Bundle, step: &[f64]) -> f64 {
        let mut shortest = f64::INFINITY;
        let mut farthest = 0.0f64;
        for v in 0..bundle.vertices() {
            if bundle.is_edge(v) {
                shortest = shortest.min(bundle.rest_length[v]);
            }
            for axis in 0..3 {
                farthest = farthest.max(step[self.freedom(v, axis)].abs());
            }
        }
        if farthest > shortest {
            shortest / farthest
        } else {
            1.0
        }
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
    ) -> Vec<f64> {
        let rows = self.residual.len();
        let mut step = vec![0.0; rows];
        for kind in [Curvature::Exact, Curvature::GaussNewton] {
            self.assemble(goal, base, state, kind);
            let mut right = self.residual.clone();
            if prescribed.iter().any(|d| *d != 0.0) {
                let mut pushed = vec![0.0; rows];
                self.matrix.multiply(prescribed, &mut pushed);
                right.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= p);
            }
            self.matrix.hold(&self.held);
            for f in 0..rows {
                if self.held[f] {
                    right[f] = prescribed[f];
                }
            }
            if let Some(factor) = &self.factor {
                let done =
                    conjugate_gradients(&self.matrix, factor, &right, &mut step, LINEAR, PATIENCE);
                if done.is_some() {
                    return step;
                }
            }
            self.factors += 1;
            let mut factor = self.matrix.clone();
            if factor.factor().is_ok() {
                step.copy_from_slice(&right);
                factor.solve(&mut step);
                self.factor = Some(factor);
                return step;
            }
        }
        // Not even what is never negative can be factored: something hangs loose. A little stiffness holds it.
        self.factor = None;
        let most = (0..rows)
            .map(|i| self.matrix.diagonal(i))
            .fold(0.0, f64::max);
        let mut right = self.residual.clone();
        for f in 0..rows {
            if self.held[f] {
                right[f] = prescribed[f];
            } else {
                self.matrix.add(f, f, 1e-6 * most);
            }
        }
        let mut factor = self.matrix.clone();
        if factor.factor().is_ok() {
            factor.solve(&mut right);
        }
        right
    }

    /// Second derivatives of everything at `state`.
    fn assemble(&mut self, goal: &Goal, base: &State, state: &State, kind: Curvature) {
        let bundle = goal.bundle;
        let n = bundle.vertices();
        let mut matrix = std::mem::take(&mut self.matrix);
        matrix.clear();
        let (place, block) = (&self.place, self.block);
        let row = |freedom: u32| {
            let f = freedom as usize;
            if f < 3 * n {
                place[f / 3] as usize * block + f % 3
            } else {
                place[f - 3 * n] as usize * block + 3
            }
        };
        let mut put = |h: &ElementHessian, by: f64| {
            let mut rows = [0; crate::energy::MOST_FREEDOMS];
            (0..h.count).for_each(|k| rows[k] = row(h.freedoms[k]));
            for u in 0..h.count {
                for v in 0..h.count {
                    if rows[v] <= rows[u] {
                        matrix.add(rows[u], rows[v], by * h.matrix[u][v]);
                    }
                }
            }
        };
        for j in (0..n).filter(|&j| bundle.is_edge(j)) {
            put(&rod::stretch_hessian(bundle, state, j, kind), 1.0);
            if state.plastic_strain[j] != base.plastic_strain[j] {
                let elastic = rod::stretch_hessian(bundle, state, j, Curvature::GaussNewton);
                put(&elastic, YIELDING - 1.0);
            }
        }
        for i in (0..n).filter(|&i| bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0) {
            if bundle.twisting {
                put(&framed::hessian(bundle, state, i), 1.0);
            } else {
                put(&rod::bend_hessian(bundle, state, i, kind), 1.0);
            }
        }
        for b in 0..bundle.bonds.len() {
            put(&bond::hessian(bundle, state, b, kind), 1.0);
        }
        for g in &self.grips {
            for &(a, wa) in &g.vertices {
                for &(b, wb) in &g.vertices {
                    for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                        let (i, j) = (row(3 * a + r as u32), row(3 * b + c as u32));
                        if j <= i {
                            let along = g.direction[r] * g.direction[c];
                            matrix.add(i, j, g.stiffness * wa * wb * along);
                        }
                    }
                }
            }
        }
        for v in 0..n {
            let p = place[v] as usize * block;
            if let Some(i) = goal.inertia {
                let by = 1.0 / (i.h * i.h) + goal.loads.damping / i.h;
                (0..3).for_each(|a| matrix.add(p + a, p + a, bundle.mass[v] * by));
                if block == 4 {
                    matrix.add(p + 3, p + 3, bundle.inertia[v] * by);
                }
            }
        }
        for touch in &self.touches {
            add_touch(&mut matrix, touch, |v, axis| row((3 * v + axis) as u32));
        }
        self.matrix = matrix;
    }
}

/// Adds the stiffness of a contact. What joins two rods in it has no place in the matrix: twice its diagonal blocks are
/// taken in place of the whole, which is never less.
fn add_touch(matrix: &mut Envelope, touch: &Touch, row: impl Fn(usize, usize) -> usize) {
    let normal = touch.normal;
    let parts: Vec<(usize, f64)> = touch.shares().collect();
    let by = if touch.other.is_some() { 2.0 } else { 1.0 };
    for (a, pa) in parts.iter().enumerate() {
        for (_, pb) in parts.iter().enumerate().filter(|(b, _)| a / 2 == b / 2) {
            for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                let (i, j) = (row(pa.0, r), row(pb.0, c));
                if j <= i {
                    matrix.add(i, j, by * pa.1 * pb.1 * touch_block(touch, normal, r, c));
                }
            }
        }
    }
}

/// Stiffness of a contact along axes r and c, N/m.
pub(super) fn touch_block(touch: &Touch, normal: DVec3, r: usize, c: usize) -> f64 {
    let along = normal[r] * normal[c];
    let same = f64::from(u8::from(r == c));
    touch.stiffness * along + touch.hold * (same - along)
}

fn resolve(grip: &Grip, bundle: &Bundle) -> Held {
    let mut vertices = Vec::new();
    for (&origin, &weight) in grip.vertices.iter().zip(&grip.weights) {
        let copies: Vec<usize> = (0..bundle.vertices())
            .filter(|&v| bundle.origin[v] == origin)
            .collect();
        let mass: f64 = copies.iter().map(|&v| bundle.mass[v]).sum();
        vertices.extend(
            copies
                .iter()
                .map(|&v| (v as u32, weight * bundle.mass[v] / mass)),
        );
    }
    let sum: f64 = vertices.iter().map(|v| v.1).sum();
    vertices.iter_mut().for_each(|v| v.1 /= sum);
    Held {
        vertices,
        direction: grip.direction,
        stiffness: grip.stiffness,
        speed: grip.speed,
    }
}
