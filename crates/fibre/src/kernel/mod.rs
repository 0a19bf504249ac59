//! Forces of whole bundles, fast: the energies of [`crate::energy`] in loops over eight vertices or bonds at once.
//!
//! Bonds are nine tenths of the work. A first pass computes each bond's forces and writes them where the bond is; a
//! second pass goes through the vertices and gathers, in a fixed order, what acts on each. No two threads ever write to
//! one place, and no sum depends on how the work was shared out, so that the same bytes come out of any number of
//! threads. Work is shared with `rayon` in the caller's pool.

mod linear;
mod watch;
mod wide;

pub(crate) use linear::NONE as NO_MOTION;
pub(crate) use wide::bands::{Lane, MOST as WIDEST_BAND, factor_bands, solve_bands};
pub use wide::lanes::Level;
pub(crate) use wide::lanes::Row;
pub(crate) use wide::outer::{Block, Line, add_rows};
pub(crate) use wide::own::Own;
pub(crate) use wide::slopes::Slope;

use crate::bundle::Bundle;
use crate::energy::Forces;
use crate::energy::framed::{self, FramedGradient};
use crate::state::State;
use crate::vectors::Vectors;

use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use watch::Watch;
use wide::bonds::BondTable;
use wide::lanes::{Pair, WIDTH};
use wide::rods::{self, BEFORE, BEHIND, BLOCK, Masses, RodInput, Scratch, StepInput, Stiffness};
use wide::slopes::Slopes;

/// Vertices that one task takes: a multiple of [`BLOCK`], and long against what starting a task costs.
const GRAIN: usize = 32 * BLOCK;

/// Does both, on two threads where there are.
fn both(a: impl FnOnce() + Send, b: impl FnOnce() + Send) {
    if rayon::current_num_threads() > 1 {
        rayon::join(a, b);
    } else {
        a();
        b();
    }
}

/// Arrays that a pass over all vertices writes: a part of each for the same vertices.
struct Output<'a> {
    /// Velocities, or forces.
    first: [&'a mut [f64]; 3],
    /// Positions, or nothing.
    second: [&'a mut [f64]; 3],
    /// One for each block, or nothing.
    sums: &'a mut [f64],
}

impl<'a> Output<'a> {
    /// Parts before and from vertex `at` of these, a multiple of [`BLOCK`].
    fn split(self, at: usize) -> (Self, Self) {
        fn cut<T>(a: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
            a.split_at_mut(at.min(a.len()))
        }
        let [a, b, c] = self.first.map(|a| cut(a, at));
        let [d, e, f] = self.second.map(|a| cut(a, at));
        let sums = cut(self.sums, at / BLOCK);
        (
            Output {
                first: [a.0, b.0, c.0],
                second: [d.0, e.0, f.0],
                sums: sums.0,
            },
            Output {
                first: [a.1, b.1, c.1],
                second: [d.1, e.1, f.1],
                sums: sums.1,
            },
        )
    }

    /// Calls `work` for each block in turn.
    fn each_block(self, first: usize, mut work: impl FnMut(usize, Output<'a>)) {
        let (mut first, mut left) = (first, self);
        while left.first[0].len() > BLOCK {
            let (block, rest) = left.split(BLOCK);
            work(first, block);
            first += BLOCK;
            left = rest;
        }
        work(first, left);
    }
}

/// Calls `work` for the tasks that `out`, whose first vertex is `first`, is made of.
fn share<'a>(first: usize, out: Output<'a>, work: &(impl Fn(usize, Output<'a>) + Sync)) {
    let n = out.first[0].len();
    if n <= GRAIN {
        work(first, out);
    } else {
        let middle = n.div_ceil(GRAIN) / 2 * GRAIN;
        let (a, b) = out.split(middle);
        both(|| share(first, a, work), || share(first + middle, b, work));
    }
}

/// The three arrays of some vectors.
fn part<'a>(of: &'a Vectors, range: &Range<usize>) -> [&'a [f64]; 3] {
    [
        &of.x[range.clone()],
        &of.y[range.clone()],
        &of.z[range.clone()],
    ]
}

/// A step to take: v ← (v + Δt f/m) k, x ← x + Δt v.
pub(crate) struct Step<'a> {
    /// Forces from outside, N.
    pub outside: Option<&'a Vectors>,
    /// Δt, s.
    pub step: f64,
    /// Part k of the velocity that damping keeps.
    pub keep: f64,
}

/// What is derived from a bundle to compute its forces. Makes no allocation after [`Evaluator::refresh`].
#[derive(Debug, Clone)]
pub struct Evaluator {
    generation: u64,
    level: Level,
    /// From the vertex before the first on.
    stiffness: Vec<Stiffness>,
    masses: Vec<Masses>,
    bonds: BondTable,
    /// Places of vertices in rows, for bonds.
    position: Vec<Row>,
    /// Per bond of the table: force on its vertex.
    bond_force: Vec<Row>,
    /// Per edge: sums over its bonds of forces on their vertices and on y₁.
    edge_force: Vec<Pair>,
    framed: Vec<FramedGradient>,
    /// The bonds made linear, where that was asked for.
    slopes: Vec<Slopes>,
    watch: Watch,
}

const NO_MASS: Masses = Masses {
    mass: [0.0; WIDTH],
    inverse: [0.0; WIDTH],
};
const NO_GRADIENT: FramedGradient = FramedGradient {
    before: DVec3::ZERO,
    after: DVec3::ZERO,
    angle_before: 0.0,
    angle_after: 0.0,
};

impl Evaluator {
    /// For a bundle, with the widest instructions there are.
    pub fn new(bundle: &Bundle) -> Self {
        Evaluator::with_level(bundle, Level::best())
    }

    /// For a bundle, with no wider instructions than `level`.
    pub fn with_level(bundle: &Bundle, level: Level) -> Self {
        let mut made = Evaluator {
            generation: 0,
            level,
            stiffness: Vec::new(),
            masses: Vec::new(),
            bonds: BondTable::default(),
            position: Vec::new(),
            bond_force: Vec::new(),
            edge_force: Vec::new(),
            framed: Vec::new(),
            slopes: Vec::new(),
            watch: Watch::default(),
        };
        made.derive(bundle);
        made
    }

    /// Derives everything again where the bundle has changed; returns whether it had.
    pub fn refresh(&mut self, bundle: &Bundle) -> bool {
        let changed = self.generation != bundle.generation
            || self.masses.len() != bundle.vertices().div_ceil(WIDTH);
        if changed {
            self.derive(bundle);
        }
        changed
    }

    fn derive(&mut self, bundle: &Bundle) {
        let n = bundle.vertices();
        self.generation = bundle.generation;
        self.masses = vec![NO_MASS; n.div_ceil(WIDTH)];
        self.stiffness = vec![Stiffness::NONE; (n + BEHIND).div_ceil(WIDTH) + 1];
        for i in 0..n {
            let at = &mut self.masses[i / WIDTH];
            at.mass[i % WIDTH] = bundle.mass[i];
            at.inverse[i % WIDTH] = 1.0 / bundle.mass[i];
            let (k, l) = ((i + 1) / WIDTH, (i + 1) % WIDTH);
            let at = &mut self.stiffness[k];
            if i > 0 {
                let (before, behind) = (bundle.rest_length[i - 1], bundle.rest_length[i]);
                at.inverse_rest[l] = 1.0 / before;
                at.stretch[l] = bundle.stretch[i - 1];
                at.rest_product[l] = before * behind;
                if bundle.bend[i] > 0.0 && !bundle.twisting {
                    at.bend[l] = bundle.bend[i] / (before + behind);
                }
            }
        }
        self.bonds = BondTable::new(bundle);
        let bonded = if self.bonds.is_empty() { 0 } else { n };
        self.position = vec![Row([0.0; 4]); bonded];
        self.edge_force = vec![Pair([0.0; 8]); bonded];
        self.bond_force = vec![Row([0.0; 4]); self.bonds.len()];
        self.framed = vec![NO_GRADIENT; if bundle.twisting { n } else { 0 }];
    }

    /// Sets `out` to the forces of all energies: those of [`crate::energy::add_forces`]. The frames of `state` must
    /// belong to its positions.
    pub fn forces(&mut self, bundle: &Bundle, state: &State, out: &mut Forces) {
        self.refresh(bundle);
        if bundle.twisting {
            out.clear();
            self.add_framed(bundle, state, out);
        }
        self.bond_pass(state);
        let (this, adding) = (&*self, bundle.twisting);
        let Vectors { x, y, z } = &mut out.linear;
        let output = Output {
            first: [x, y, z],
            second: [&mut [], &mut [], &mut []],
            sums: &mut [],
        };
        share(0, output, &|first, out| {
            let mut scratch = Scratch::NEW;
            out.each_block(first, |first, out| {
                let count = out.first[0].len();
                this.block(bundle, state, first, count, &mut scratch);
                for (to, from) in out.first.into_iter().zip(&scratch.force) {
                    if adding {
                        to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
                    } else {
                        to.copy_from_slice(&from[..to.len()]);
                    }
                }
            });
        });
    }

    /// Takes a step of all vertices from `state` into `velocity` and `position`, under all forces but those in material
    /// frames. Sets `sums` to parts of the kinetic energy after it, [`Evaluator::blocks`] of them.
    pub(crate) fn step(
        &mut self,
        bundle: &Bundle,
        state: &State,
        step: &Step,
        velocity: &mut Vectors,
        position: &mut Vectors,
        sums: &mut [f64],
    ) {
        self.bond_pass(state);
        let this = &*self;
        let output = Output {
            first: [&mut velocity.x, &mut velocity.y, &mut velocity.z],
            second: [&mut position.x, &mut position.y, &mut position.z],
            sums,
        };
        share(0, output, &|first, out| {
            let mut scratch = Scratch::NEW;
            out.each_block(first, |first, out| {
                let range = first..first + out.first[0].len();
                this.block(bundle, state, first, range.len(), &mut scratch);
                let input = StepInput {
                    velocity: part(&state.velocity, &range),
                    position: part(&state.position, &range),
                    outside: step.outside.map_or([&[][..]; 3], |v| part(v, &range)),
                    masses: &this.masses[first / WIDTH..range.end.div_ceil(WIDTH)],
                    step: step.step,
                    keep: step.keep,
                };
                let energy = rods::step(this.level, &input, &scratch, out.first, out.second);
                if let Some(sum) = out.sums.first_mut() {
                    *sum = energy;
                }
            });
        });
    }

    /// Adds the forces and moments of bending and twist in material frames.
    pub(crate) fn add_framed(&mut self, bundle: &Bundle, state: &State, out: &mut Forces) {
        let each = |(i, g): (usize, &mut FramedGradient)| {
            *g = if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
                framed::gradient(bundle, state, i)
            } else {
                NO_GRADIENT
            };
        };
        if self.framed.len() <= GRAIN / 8 {
            self.framed.iter_mut().enumerate().for_each(each);
        } else {
            self.framed
                .par_iter_mut()
                .with_min_len(GRAIN / 8)
                .enumerate()
                .for_each(each);
        }
        for i in 0..self.framed.len() {
            let g = &self.framed;
            let (own, next) = (g[i], g.get(i + 1).copied().unwrap_or(NO_GRADIENT));
            let last = if i > 0 { g[i - 1] } else { NO_GRADIENT };
            out.linear
                .add(i, own.after - own.before + next.before - last.after);
            out.moment[i] -= own.angle_after + next.angle_before;
        }
    }

    /// Puts places into rows.
    fn fill_places(&mut self, state: &State) {
        let p = &state.position;
        let fill = |(k, rows): (usize, &mut [Row])| {
            let range = k * GRAIN..k * GRAIN + rows.len();
            let places = p.x[range.clone()]
                .iter()
                .zip(&p.y[range.clone()])
                .zip(&p.z[range]);
            for (row, ((x, y), z)) in rows.iter_mut().zip(places) {
                row.0 = [*x, *y, *z, 0.0];
            }
        };
        if rayon::current_num_threads() > 1 {
            self.position
                .par_chunks_mut(GRAIN)
                .enumerate()
                .for_each(fill);
        } else {
            self.position.chunks_mut(GRAIN).enumerate().for_each(fill);
        }
    }

    /// Computes the forces of bonds.
    fn bond_pass(&mut self, state: &State) {
        if self.bonds.is_empty() {
            return;
        }
        self.fill_places(state);
        self.bonds.forces(
            self.level,
            &self.position,
            &mut self.bond_force,
            &mut self.edge_force,
        );
    }

    /// How many sums [`Evaluator::step`] makes.
    pub(crate) fn blocks(vertices: usize) -> usize {
        vertices.div_ceil(BLOCK)
    }

    /// Forces on a block of vertices into the scratch.
    fn block(
        &self,
        bundle: &Bundle,
        state: &State,
        first: usize,
        count: usize,
        scratch: &mut Scratch,
    ) {
        let rows = if self.bonds.is_empty() {
            &[][..]
        } else {
            let (force, sums) = (&self.bond_force, &self.edge_force);
            let out = &mut scratch.rows[..count];
            self.bonds
                .gather(self.level, bundle, force, sums, first, out);
            &scratch.rows[..]
        };
        let need = count + BEFORE + BEHIND;
        let n = state.position.len();
        let p = &state.position;
        let sources = [&p.x, &p.y, &p.z, &state.plastic_strain];
        let copies = &mut scratch.copies;
        let inside = first >= BEFORE && first - BEFORE + need <= n;
        let view: [&[f64]; 4] = if inside {
            sources.map(|s| &s[first - BEFORE..first - BEFORE + need])
        } else {
            let low = first.saturating_sub(BEFORE);
            let high = (first + need - BEFORE).min(n);
            let shift = low + BEFORE - first;
            for (copy, source) in copies.iter_mut().zip(sources) {
                copy.fill(0.0);
                copy[shift..shift + high - low].copy_from_slice(&source[low..high]);
            }
            [0, 1, 2, 3].map(|a| &copies[a][..need])
        };
        let input = RodInput {
            position: [view[0], view[1], view[2]],
            plastic_strain: view[3],
            stiffness: &self.stiffness[first / WIDTH..(first + need) / WIDTH],
        };
        rods::rod_forces(
            self.level,
            &input,
            rows,
            count,
            &mut scratch.passes,
            &mut scratch.force,
        );
    }
}
