//! A step a picture, at real stiffness, faster than the time it shows (issue "Solvers" 3).
//!
//! Each step is an equilibrium with inertia at its end (implicit Euler), found by Newton's method as in
//! [`super::newton`], but only as exactly as a picture needs, and with linear systems solved anew each time by conjugate
//! gradients that know rods and sections (`iterative`): a factor of the matrix, which would have to be made
//! anew whenever something breaks, costs as much as many pictures. Methods that go from vertex to vertex (vertex block
//! descent, position-based dynamics) do not carry a bending moment through a slender stem in any number of sweeps that a
//! picture has time for.
//!
//! What is overstressed at the end of a step breaks, and the same step is done again from where it is; what would break
//! still then breaks in the next. So a crack that runs in microseconds takes a few pictures. Bonds that break lose their
//! stiffness until the step ends, so that nothing has to be numbered anew but where a rod breaks. Implicit Euler
//! lets vibration that is fast against the picture die out, which is told as [`Advance::dissipated`].

use super::Stepwise;
use super::newton::{Found, Goal, Inertia, Manner, Newton};
use super::quasi_static::commit_yield;
use crate::energy::{Forces, energies};
use crate::error::SolverError;
use crate::failure::{self, Break};
use crate::solver::{Advance, Contacts, World};
use crate::state::State;
use crate::topology;
use crate::vectors::Vectors;

/// The step where none is given, s.
pub const STEP: f64 = 1.0 / 30.0;
/// Breaking rounds in a step.
const ROUNDS: usize = 1;
/// What breaks at once: what is overstressed by this part of what the most overstressed is.
const PART: f64 = 0.7;
/// What is overstressed by this breaks in any case: a load that grows faster than steps follow must not outrun it.
const MUCH: f64 = 1.3;
/// The same where forces are not balanced yet: without it one small bond that is torn far would keep all else whole.
const FAR: f64 = 2.0;
/// Where what breaks holds less than this part of all that is stored, the step is not done again: the next one sees it.
const LITTLE: f64 = 1e-2;
/// Most that a prediction moves anything, in shortest edges.
const FARTHEST: f64 = 0.5;
/// How exactly a step is solved: forces at break differ from those of the other solvers by far less.
const MANNER: Manner = Manner {
    forgetful: true,
    tolerance: 1e-2,
    iterations: 3,
    accuracy: 0.1,
    take_last: true,
    one_matrix: true,
};

/// The interactive solver.
#[derive(Debug, Clone)]
pub struct Interactive {
    given: Option<f64>,
    newton: Newton,
    queue: Vec<Break>,
    /// Newton iterations so far.
    iterations: u64,
    /// Equilibria so far.
    solved: u64,
}

impl Interactive {
    /// A solver with steps of `step` seconds, or 1/30 s.
    pub fn new(step: Option<f64>) -> Self {
        Interactive {
            given: step,
            newton: Newton::in_manner(MANNER),
            queue: Vec::new(),
            iterations: 0,
            solved: 0,
        }
    }

    /// Equilibria, Newton iterations and conjugate gradients so far.
    pub fn effort(&self) -> [u64; 3] {
        [self.solved, self.iterations, self.newton.gradients()]
    }

    /// The equilibrium at the end of a step of `dt` from `old`, looked for from the world's state on.
    fn equilibrium(
        &mut self,
        world: &World,
        old: &State,
        contacts: &mut dyn Contacts,
        dt: f64,
    ) -> Result<Found, SolverError> {
        self.newton.prepare(&world.bundle, &[]);
        let plus = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| a + b * dt).collect()
        };
        let (x, v) = (&old.position, &old.velocity);
        let inertia = Inertia {
            h: dt,
            ahead: Vectors {
                x: plus(&x.x, &v.x),
                y: plus(&x.y, &v.y),
                z: plus(&x.z, &v.z),
            },
            behind: old.position.clone(),
            angle_ahead: plus(&old.angle, &old.spin),
            angle_behind: old.angle.clone(),
        };
        let goal = Goal {
            bundle: &world.bundle,
            loads: &world.loads,
            yielding: world.failure.rods_yield,
            from: old,
            inertia: Some(&inertia),
            time: old.time + dt,
        };
        let found = self.newton.solve(&goal, old, &world.state, contacts)?;
        self.iterations += found.iterations as u64;
        self.solved += 1;
        Ok(found)
    }

    fn picture(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
        let stored = energies(&world.bundle, &world.state).total() + contacts.stored();
        let broken = world.fracture_loss;
        let mut old = world.state.clone();
        predict(world, dt);
        self.newton.renew();
        // Bonds without stiffness, which are taken out at the end or with the next rod that breaks.
        let mut weak = Vec::new();
        // Vertices at which rods break when the step has ended.
        let mut late = Vec::new();
        let mut round = 0;
        let found = loop {
            let mut found = self.equilibrium(world, &old, contacts, dt)?;
            if round == ROUNDS || !self.find_broken(world, &found) {
                break found;
            }
            round += 1;
            std::mem::swap(&mut world.state, &mut found.state);
            let lost = world.fracture_loss;
            failure::note(world, &self.queue);
            if found.settled && world.fracture_loss - lost < LITTLE * stored {
                std::mem::swap(&mut world.state, &mut found.state);
                weak.extend(numbers(&self.queue, true));
                late = numbers(&self.queue, false);
                break found;
            }
            if let Some(before) = self.let_break(world, contacts, &mut weak) {
                topology::split_state(&mut old, &before);
            }
        };
        world.state = old;
        let mut book = Book::default();
        take(world, contacts, found, dt, &mut book);
        if !(weak.is_empty() && late.is_empty()) {
            failure::take_out(world, contacts, weak, late);
        }
        let after = energies(&world.bundle, &world.state).total() + contacts.stored();
        report.work += book.work;
        report.damped += book.damped;
        report.dissipated +=
            stored + book.work + book.given - book.damped - (world.fracture_loss - broken) - after;
        report.steps += book.steps;
        Ok(())
    }

    /// Breaks what is in the queue. Bonds lose their stiffness, and are taken out with the next rod that breaks.
    /// Returns for each vertex which it was before, where that changes.
    fn let_break(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        weak: &mut Vec<u32>,
    ) -> Option<Vec<u32>> {
        let [bonds, splits] = [true, false].map(|bond| numbers(&self.queue, bond));
        for &b in &bonds {
            world.bundle.bonds.transverse[b as usize] = 0.0;
            world.bundle.bonds.shear[b as usize] = 0.0;
        }
        self.newton.weaken(&world.bundle, &bonds);
        weak.extend(bonds);
        if splits.is_empty() {
            return None;
        }
        let weak = std::mem::take(weak);
        Some(failure::take_out(world, contacts, weak, splits))
    }

    /// Looks for what breaks at the end of a step. Where forces are not balanced yet, overstress may be no more than that:
    /// it must be more, and rods break only where the forces on their own vertices are balanced.
    fn find_broken(&mut self, world: &World, found: &Found) -> bool {
        let (bundle, state) = (&world.bundle, &found.state);
        let mut queue = std::mem::take(&mut self.queue);
        queue.clone_from(self.newton.detect(&world.failure, bundle, state));
        let newton = &self.newton;
        queue.retain(|b| {
            b.bond || found.settled || newton.is_balanced(bundle, state, b.number as usize)
        });
        let most = PART * queue.first().map_or(0.0, |b| b.demand);
        let enough = most.min(if found.settled { MUCH } else { FAR });
        queue.retain(|b| b.demand >= enough);
        self.queue = queue;
        !self.queue.is_empty()
    }
}

/// Numbers of the bonds, or of the vertices of rods, that break.
fn numbers(queue: &[Break], bonds: bool) -> Vec<u32> {
    let all = queue.iter().filter(|b| b.bond == bonds);
    all.map(|b| b.number).collect()
}

/// What steps did, J.
#[derive(Debug, Clone, Copy, Default)]
struct Book {
    steps: u64,
    work: f64,
    damped: f64,
    /// Work of bodies less friction.
    given: f64,
}

/// Takes what was found at the end of a step of `dt` from the world's state.
fn take(world: &mut World, contacts: &mut dyn Contacts, found: Found, dt: f64, book: &mut Book) {
    let old = std::mem::replace(&mut world.state, found.state);
    for v in 0..world.bundle.vertices() {
        let way = world.state.position.get(v) - old.position.get(v);
        world.state.velocity.set(v, way / dt);
        world.state.spin[v] = (world.state.angle[v] - old.angle[v]) / dt;
    }
    world.state.time = old.time + dt;
    world.state.step = old.step + 1;
    let yielded = commit_yield(world, &old);
    world.fracture_loss += yielded;
    let met = contacts.accept(&old, old.time + dt, &found.touches);
    let (work, damped) = work(world, &old, &found.reaction, dt);
    book.given += met.work - met.lost;
    book.work += work;
    book.damped += damped;
    book.steps += 1;
}

/// Moves everything on as it moves: where equilibria follow each other evenly the next one is near there. Not where
/// something flies: it would fold.
fn predict(world: &mut World, dt: f64) {
    let World { bundle, state, .. } = world;
    let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
    let shortest = edges.fold(f64::INFINITY, |a, j| a.min(bundle.rest_length[j]));
    let fastest = (state.velocity.iter()).fold(0.0, |a: f64, v| a.max(v.length_squared()));
    let most = FARTHEST * shortest / dt;
    if fastest.is_nan() || fastest > most * most {
        return;
    }
    for v in 0..bundle.vertices() {
        state.position.add(v, state.velocity.get(v) * dt);
        state.angle[v] += state.spin[v] * dt;
    }
    state.carry_frames(bundle);
}

/// Work of loads and of clamps, which end the step with `reaction`, and what damping took, J. Clamps' forces are those of the
/// method at the end of the step.
fn work(world: &World, old: &State, reaction: &Vectors, dt: f64) -> (f64, f64) {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let mut acting = Forces::zeros(bundle.vertices());
    let Forces { linear, moment } = &mut acting;
    loads.add_forces(
        bundle,
        state.time,
        &state.position,
        &state.velocity,
        linear,
        moment,
    );
    let (mut work, mut damped) = (0.0, 0.0);
    for v in 0..bundle.vertices() {
        let way = state.position.get(v) - old.position.get(v);
        work += (linear.get(v) + reaction.get(v)).dot(way);
        damped += bundle.mass[v] * state.velocity.get(v).length_squared();
        if bundle.twisting {
            work += moment[v] * state.spin[v] * dt;
            damped += bundle.inertia[v] * state.spin[v] * state.spin[v];
        }
    }
    (work, damped * loads.damping * dt)
}

impl Stepwise for Interactive {
    const NAME: &'static str = "interactive";
    const USUAL: f64 = STEP;

    fn given(&self) -> Option<f64> {
        self.given
    }

    fn one_step(
        &mut self,
        world: &mut World,
        contacts: &mut dyn Contacts,
        dt: f64,
        report: &mut Advance,
    ) -> Result<(), SolverError> {
        self.picture(world, contacts, dt, report)
    }
}
