//! Forces of whole bundles, and the linearised bonds that solvers multiply with.

use super::bond_filter::BondFilter;
use crate::energy::Energies;
use crate::energy::bend_twist::{self, BendTwistGradient, EdgeFrame};
use crate::energy::bond::BondSpring;
use crate::failure::criteria::BondCriterion;
use crate::forces::Forces;
use crate::parallel::join;
use crate::rod_bundle::RodBundle;
use crate::simd::SimdLevel;
use crate::simd::bond_gradients::{BondGradient, GradientBatch};
use crate::simd::bond_strains::StrainBatch;
use crate::simd::bonds::BondTable;
use crate::simd::lanes::{PaddedPair, PaddedVec3, WIDTH};
use crate::simd::places::Places;
use crate::simd::rods::{
    self, BEFORE, BEHIND, BLOCK, Masses, RodInput, Scratch, StepInput, Stiffness,
};
use crate::simd::same_rod_blocks::SameRodBlocks;
use crate::state::State;
use crate::vectors::Vectors;
use rayon::prelude::*;
use std::ops::Range;

/// Vertices of one task: a multiple of [`BLOCK`], and enough to make the cost of a task negligible.
const VERTICES_PER_TASK: usize = 32 * BLOCK;
/// The same for bending and twist in material frames, which takes longer.
const BEND_TWIST_PER_TASK: usize = VERTICES_PER_TASK / 8;

/// Arrays that a pass over all vertices writes, as slices for the same vertices.
struct Output<'a> {
    /// Velocities or forces.
    first: [&'a mut [f64]; 3],
    /// Positions, or nothing.
    second: [&'a mut [f64]; 3],
    /// One entry for each block, or nothing.
    sums: &'a mut [f64],
}

impl<'a> Output<'a> {
    /// Splits before vertex `at` of these, a multiple of [`BLOCK`].
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

/// Divides `out`, whose first vertex is `first`, into tasks and calls `work` for each.
fn for_each_task<'a>(first: usize, out: Output<'a>, work: &(impl Fn(usize, Output<'a>) + Sync)) {
    let n = out.first[0].len();
    if n <= VERTICES_PER_TASK {
        work(first, out);
    } else {
        let middle = n.div_ceil(VERTICES_PER_TASK) / 2 * VERTICES_PER_TASK;
        let (a, b) = out.split(middle);
        join(
            || for_each_task(first, a, work),
            || for_each_task(first + middle, b, work),
        );
    }
}

/// Returns the three arrays of a range of vectors.
fn slices<'a>(of: &'a Vectors, range: &Range<usize>) -> [&'a [f64]; 3] {
    [
        &of.x[range.clone()],
        &of.y[range.clone()],
        &of.z[range.clone()],
    ]
}

/// An explicit step: v ← (v + Δt f/m) k, x ← x + Δt v.
pub(crate) struct ExplicitStep<'a> {
    /// External forces, N.
    pub external: Option<&'a Vectors>,
    /// Δt, s.
    pub step: f64,
    /// The factor k of damping.
    pub damping_factor: f64,
}

/// Computes the forces of a bundle from data derived from it. After `refresh` it allocates nothing.
///
/// ```
/// use glam::DVec3;
/// use greenstick_fibre::energy::add_forces;
/// use greenstick_fibre::{ForceEvaluator, Forces, Rod, RodBundle, RodMaterial, State};
///
/// let material = RodMaterial::solid(1e-5, 1e7, 1e6, 600.0);
/// let vertices = (0..10).map(|i| DVec3::Z * (0.01 * f64::from(i))).collect();
/// let bundle = RodBundle::new(&[Rod::new(vertices, material)], false)?;
/// let mut state = State::at_rest(&bundle);
/// state.position.set(9, DVec3::new(0.01, 0.0, 0.09));
/// let (mut fast, mut reference) = (Forces::zeros(10), Forces::zeros(10));
/// ForceEvaluator::new(&bundle).forces(&bundle, &state, &mut fast);
/// add_forces(&bundle, &state, &mut reference);
/// for (a, b) in fast.linear.iter().zip(reference.linear.iter()) {
///     assert!((a - b).length() < 1e-9);
/// }
/// # Ok::<(), greenstick_fibre::RodBundleError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ForceEvaluator {
    generation: u64,
    level: SimdLevel,
    /// Stiffness, from the vertex before the first on.
    stiffness: Vec<Stiffness>,
    masses: Vec<Masses>,
    bonds: BondTable,
    /// Where vertices and edges are, for bonds.
    places: Places,
    /// Per entry of the table: force on the bond's vertex.
    bond_force: Vec<PaddedVec3>,
    /// Per edge: sums over its bonds of the forces on their vertices and on y₁.
    edge_force: Vec<PaddedPair>,
    bend_twist: Vec<BendTwistGradient>,
    /// Per edge, with twist: its frame.
    frames: Vec<EdgeFrame>,
    /// The linearised bonds, after [`ForceEvaluator::linearise_bonds`].
    gradients: Vec<GradientBatch>,
    /// Buffer: openings and slips of bonds.
    strains: Vec<StrainBatch>,
    filter: BondFilter,
}

const NO_MASS: Masses = Masses {
    mass: [0.0; WIDTH],
    inverse: [0.0; WIDTH],
};
impl ForceEvaluator {
    /// Returns an evaluator for a bundle, with the widest instructions of the processor.
    pub fn new(bundle: &RodBundle) -> Self {
        ForceEvaluator::with_level(bundle, SimdLevel::best())
    }

    /// Returns an evaluator for a bundle, with no wider instructions than `level`.
    pub fn with_level(bundle: &RodBundle, level: SimdLevel) -> Self {
        let mut evaluator = ForceEvaluator {
            generation: 0,
            level,
            stiffness: Vec::new(),
            masses: Vec::new(),
            bonds: BondTable::default(),
            places: Places::default(),
            bond_force: Vec::new(),
            edge_force: Vec::new(),
            bend_twist: Vec::new(),
            frames: Vec::new(),
            gradients: Vec::new(),
            strains: Vec::new(),
            filter: BondFilter::default(),
        };
        evaluator.derive(bundle);
        evaluator
    }

    /// Derives everything anew where the bundle has changed. Returns whether it had.
    pub(crate) fn refresh(&mut self, bundle: &RodBundle) -> bool {
        let changed = self.generation != bundle.generation
            || self.masses.len() != bundle.vertices().div_ceil(WIDTH);
        if changed {
            self.derive(bundle);
        }
        changed
    }

    fn derive(&mut self, bundle: &RodBundle) {
        let n = bundle.vertices();
        self.generation = bundle.generation;
        self.masses = vec![NO_MASS; n.div_ceil(WIDTH)];
        self.stiffness = vec![Stiffness::ZERO; (n + BEHIND).div_ceil(WIDTH) + 1];
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
        self.places = Places::zeros(bonded);
        self.edge_force = vec![PaddedPair([0.0; 8]); bonded];
        self.bond_force = vec![PaddedVec3([0.0; 4]); self.bonds.len()];
        self.bend_twist = vec![BendTwistGradient::ZERO; if bundle.twisting { n } else { 0 }];
    }

    /// Sets `out` to the forces of all energies, as [`crate::energy::add_forces`] does. The frames of `state` must belong to
    /// its positions.
    pub fn forces(&mut self, bundle: &RodBundle, state: &State, out: &mut Forces) {
        self.refresh(bundle);
        if bundle.twisting {
            out.clear();
            self.add_bend_twist(bundle, state, out);
        }
        self.bond_pass(state);
        let (this, adding) = (&*self, bundle.twisting);
        let Vectors { x, y, z } = &mut out.linear;
        let output = Output {
            first: [x, y, z],
            second: [&mut [], &mut [], &mut []],
            sums: &mut [],
        };
        for_each_task(0, output, &|first, out| {
            let mut scratch = Scratch::NEW;
            out.each_block(first, |first, out| {
                let count = out.first[0].len();
                this.block_forces(bundle, state, first, count, &mut scratch);
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

    /// Returns the energies of a state, with the bits of [`crate::energy::energies`].
    pub(crate) fn energies(&mut self, bundle: &RodBundle, state: &State) -> Energies {
        self.refresh(bundle);
        let mut sum = Energies::of_rods(bundle, state);
        if self.bonds.is_empty() {
            return sum;
        }
        self.places.set(&state.position);
        (self.strains).resize(self.bonds.len() / WIDTH, StrainBatch::ZERO);
        self.bonds
            .strains(self.level, &self.places, &mut self.strains);
        for bond in 0..bundle.bonds.len() {
            let strain = self.bonds.strain(&self.strains, bond);
            // The table may have the damage of a trial.
            let (transverse, shear) = BondSpring::new(bundle, bond).energy(strain);
            sum.bond_transverse += transverse;
            sum.bond_shear += shear;
        }
        sum
    }

    /// Takes a step of all vertices from `state` into `velocity` and `position`, with all forces but those in material frames.
    /// Sets `sums`, one for each block ([`ForceEvaluator::blocks`]), to the blocks' kinetic energy after it.
    pub(crate) fn step(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        step: &ExplicitStep,
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
        for_each_task(0, output, &|first, out| {
            let mut scratch = Scratch::NEW;
            out.each_block(first, |first, out| {
                let range = first..first + out.first[0].len();
                this.block_forces(bundle, state, first, range.len(), &mut scratch);
                let input = StepInput {
                    velocity: slices(&state.velocity, &range),
                    position: slices(&state.position, &range),
                    external: step.external.map_or([&[][..]; 3], |v| slices(v, &range)),
                    masses: &this.masses[first / WIDTH..range.end.div_ceil(WIDTH)],
                    step: step.step,
                    damping_factor: step.damping_factor,
                };
                let energy = rods::step(this.level, &input, &scratch, out.first, out.second);
                if let Some(sum) = out.sums.first_mut() {
                    *sum = energy;
                }
            });
        });
    }

    /// Adds the forces and moments of bending and twist in material frames.
    pub(crate) fn add_bend_twist(&mut self, bundle: &RodBundle, state: &State, out: &mut Forces) {
        self.frames.clear();
        (self.frames).extend((0..bundle.vertices()).map(|j| {
            if bundle.is_edge(j) {
                EdgeFrame::new(state, j)
            } else {
                EdgeFrame::default()
            }
        }));
        let frames = &self.frames;
        let each = |(i, g): (usize, &mut BendTwistGradient)| {
            *g = if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
                bend_twist::gradient_between(bundle, state, i, (&frames[i - 1], &frames[i]))
            } else {
                BendTwistGradient::ZERO
            };
        };
        if self.bend_twist.len() <= BEND_TWIST_PER_TASK {
            self.bend_twist.iter_mut().enumerate().for_each(each);
        } else {
            self.bend_twist
                .par_iter_mut()
                .with_min_len(BEND_TWIST_PER_TASK)
                .enumerate()
                .for_each(each);
        }
        for i in 0..self.bend_twist.len() {
            let g = &self.bend_twist;
            let (own, next) = (
                g[i],
                g.get(i + 1).copied().unwrap_or(BendTwistGradient::ZERO),
            );
            let last = if i > 0 {
                g[i - 1]
            } else {
                BendTwistGradient::ZERO
            };
            out.linear
                .add(i, own.after - own.before + next.before - last.after);
            out.moment[i] -= own.angle_after + next.angle_before;
        }
    }

    /// Computes the forces of bonds.
    fn bond_pass(&mut self, state: &State) {
        if self.bonds.is_empty() {
            return;
        }
        self.places.set(&state.position);
        self.bonds.forces(
            self.level,
            &self.places,
            &mut self.bond_force,
            &mut self.edge_force,
        );
    }

    /// Returns the number of blocks that [`ForceEvaluator::step`] sums over.
    pub(crate) fn blocks(vertices: usize) -> usize {
        vertices.div_ceil(BLOCK)
    }

    /// Computes the forces on a block of vertices into the scratch.
    fn block_forces(
        &self,
        bundle: &RodBundle,
        state: &State,
        first: usize,
        count: usize,
        scratch: &mut Scratch,
    ) {
        let bond_forces = if self.bonds.is_empty() {
            &[][..]
        } else {
            let (force, sums) = (&self.bond_force, &self.edge_force);
            let out = &mut scratch.bond_forces[..count];
            self.bonds
                .gather(self.level, bundle, force, sums, first, out);
            &scratch.bond_forces[..]
        };
        let need = count + BEFORE + BEHIND;
        let n = state.position.len();
        let p = &state.position;
        let sources = [&p.x, &p.y, &p.z, &state.plastic_strain];
        let copies = &mut scratch.copies;
        let inside = first >= BEFORE && first - BEFORE + need <= n;
        let input: [&[f64]; 4] = if inside {
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
            position: [input[0], input[1], input[2]],
            plastic_strain: input[3],
            stiffness: &self.stiffness[first / WIDTH..(first + need) / WIDTH],
        };
        rods::rod_forces(
            self.level,
            &input,
            bond_forces,
            count,
            &mut scratch.passes,
            &mut scratch.force,
        );
    }

    /// Sets `found` to the bonds, ascending, that may fail in a state: all that do, and few others.
    pub(crate) fn suspects(
        &mut self,
        bundle: &RodBundle,
        state: &State,
        criterion: BondCriterion,
        found: &mut Vec<u32>,
    ) {
        found.clear();
        self.refresh(bundle);
        if self.bonds.is_empty() {
            return;
        }
        self.filter.refresh(&self.bonds, bundle, criterion);
        self.places.set(&state.position);
        let (filter, level) = (&mut self.filter, self.level);
        filter.suspects(&self.bonds, level, &self.places, criterion, found);
    }

    /// Linearises the bonds about a state.
    pub(crate) fn linearise_bonds(&mut self, state: &State) {
        (self.gradients).resize(self.bonds.len() / WIDTH, GradientBatch::ZERO);
        if !self.bonds.is_empty() {
            self.places.set(&state.position);
            let (level, gradients) = (self.level, &mut self.gradients);
            self.bonds.linearise(level, &self.places, gradients);
        }
    }

    /// Computes the restoring forces of the linearised bonds to the displacement `x` of vertices, for
    /// [`ForceEvaluator::gather_bond_product`].
    pub(crate) fn multiply_bonds(&mut self, x: &[PaddedVec3]) {
        if self.bonds.is_empty() {
            return;
        }
        let (force, sums) = (&mut self.bond_force, &mut self.edge_force);
        self.bonds
            .products(self.level, x, &self.gradients, force, sums);
    }

    /// Gathers these forces on the vertices from `first` on into `out`.
    pub(crate) fn gather_bond_product(
        &self,
        bundle: &RodBundle,
        first: usize,
        out: &mut [PaddedVec3],
    ) {
        if self.bonds.is_empty() {
            out.fill(PaddedVec3::ZERO);
            return;
        }
        let (force, sums) = (&self.bond_force, &self.edge_force);
        self.bonds
            .gather(self.level, bundle, force, sums, first, out);
    }

    /// Calls `work` for each linearised bond with stiffness in part number `part` of `parts` equal parts.
    #[inline(always)]
    pub(crate) fn for_each_gradient(
        &self,
        part: usize,
        parts: usize,
        work: impl FnMut(&BondGradient),
    ) {
        let end = |k: usize| self.bonds.len() * k / parts;
        self.bonds
            .for_each_gradient(&self.gradients, end(part)..end(part + 1), work);
    }

    /// Sets `out` to the blocks of the linearised bonds' matrix between vertices of one rod, one entry for each vertex.
    pub(crate) fn same_rod_blocks(&self, bundle: &RodBundle, out: &mut Vec<SameRodBlocks>) {
        out.resize(bundle.vertices(), SameRodBlocks::ZERO);
        if self.bonds.is_empty() {
            out.fill(SameRodBlocks::ZERO);
        } else {
            self.bonds.same_rod_blocks(self.level, &self.gradients, out);
        }
    }

    /// Sets the damage of a bond, until everything is derived anew.
    pub(crate) fn set_bond_damage(&mut self, bundle: &RodBundle, bond: u32, damage: f64) {
        self.bonds.set_damage(bundle, bond, damage);
    }
}
