//! Forces of whole bundles, fast: the energies of [`crate::energy`] in loops over eight vertices or bonds at once.
//!
//! Bonds are nine tenths of the work. A first pass computes each bond's forces and writes them where the bond is; a
//! second pass goes through the vertices and gathers, in a fixed order, what acts on each. No two threads ever write to
//! one place, and no sum depends on how the work was shared out, so that the same bytes come out of any number of
//! threads. Work is shared with `rayon` in the caller's pool.

mod lanes;

pub use lanes::Level;

use crate::bundle::Bundle;
use crate::energy::Forces;
use crate::energy::framed::{self, FramedGradient};
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;
use lanes::{
    BEFORE, BEHIND, BLOCK, BlockForces, BondForce, BondInput, ROOM, RodInput, Scratch, WIDTH,
};
use rayon::prelude::*;

/// Vertices that one task takes: a multiple of [`BLOCK`], and long against what starting a task costs.
const GRAIN: usize = 16 * BLOCK;
/// Bonds that one task takes.
const BOND_GRAIN: usize = 4096;

/// What is derived from a bundle to compute its forces. Makes no allocation after [`Evaluator::refresh`].
#[derive(Debug, Clone)]
pub struct Evaluator {
    generation: u64,
    level: Level,
    // Per vertex or edge, with BEFORE entries of padding in front and more behind.
    inverse_rest: Vec<f64>,
    stretch: Vec<f64>,
    rest_product: Vec<f64>,
    bend: Vec<f64>,
    // Per bond, padded to whole lanes with bonds that nobody gathers.
    vertex: Vec<u32>,
    edge: Vec<u32>,
    t: Vec<f64>,
    inverse_distance: Vec<f64>,
    rest_cosine: Vec<f64>,
    transverse: Vec<f64>,
    shear: Vec<f64>,
    bond_force: Vec<BondForce>,
    framed: Vec<FramedGradient>,
}

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
            inverse_rest: Vec::new(),
            stretch: Vec::new(),
            rest_product: Vec::new(),
            bend: Vec::new(),
            vertex: Vec::new(),
            edge: Vec::new(),
            t: Vec::new(),
            inverse_distance: Vec::new(),
            rest_cosine: Vec::new(),
            transverse: Vec::new(),
            shear: Vec::new(),
            bond_force: Vec::new(),
            framed: Vec::new(),
        };
        made.derive(bundle);
        made
    }

    /// Derives everything again where the bundle has changed; returns whether it had.
    pub fn refresh(&mut self, bundle: &Bundle) -> bool {
        let changed = self.generation != bundle.generation
            || self.inverse_rest.len() != bundle.vertices() + BEFORE + BEHIND + BLOCK;
        if changed {
            self.derive(bundle);
        }
        changed
    }

    fn derive(&mut self, bundle: &Bundle) {
        let n = bundle.vertices();
        self.generation = bundle.generation;
        let padded = |value: &dyn Fn(usize) -> f64, padding: f64| {
            let mut made = vec![padding; n + BEFORE + BEHIND + BLOCK];
            for i in 0..n {
                made[BEFORE + i] = value(i);
            }
            made
        };
        self.inverse_rest = padded(&|j| 1.0 / bundle.rest_length[j], 1.0);
        self.stretch = padded(&|j| bundle.stretch[j], 0.0);
        let before = |i: usize| {
            if i > 0 {
                bundle.rest_length[i - 1]
            } else {
                1.0
            }
        };
        self.rest_product = padded(&|i| before(i) * bundle.rest_length[i], 1.0);
        let straight = |i: usize| bundle.bend[i] > 0.0 && !bundle.twisting;
        self.bend = padded(
            &|i| {
                if straight(i) {
                    bundle.bend[i] / (before(i) + bundle.rest_length[i])
                } else {
                    0.0
                }
            },
            0.0,
        );
        let b = &bundle.bonds;
        let whole = b.len().div_ceil(WIDTH) * WIDTH;
        let numbers = |from: &mut dyn Iterator<Item = f64>| {
            let mut made: Vec<f64> = from.collect();
            made.resize(whole, 0.0);
            made
        };
        self.vertex = b.vertex.clone();
        self.vertex.resize(whole, 0);
        self.edge = b.edge.clone();
        self.edge.resize(whole, 0);
        self.t = numbers(&mut b.t.iter().copied());
        self.inverse_distance = numbers(&mut b.distance.iter().map(|d| 1.0 / d));
        self.rest_cosine = numbers(&mut b.rest_cosine.iter().copied());
        self.transverse = numbers(&mut b.transverse.iter().copied());
        self.shear = numbers(&mut b.shear.iter().map(|s| 2.0 * s));
        self.bond_force = vec![[0.0; 8]; whole];
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
        let Forces { linear, .. } = out;
        let twisting = bundle.twisting;
        self.each_vertex(
            bundle,
            state,
            linear,
            &mut [],
            |_, forces, count, mut chunk, _| {
                for (to, from) in chunk.iter_mut().zip(forces) {
                    for (to, from) in to.iter_mut().zip(&from[..count]) {
                        *to = if twisting { *to + from } else { *from };
                    }
                }
            },
        );
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

    fn bond_pass(&mut self, state: &State) {
        let p = &state.position;
        let level = self.level;
        let work = |(k, out): (usize, &mut [BondForce])| {
            let range = k * BOND_GRAIN..k * BOND_GRAIN + out.len();
            let input = BondInput {
                position: [&p.x, &p.y, &p.z],
                vertex: &self.vertex[range.clone()],
                edge: &self.edge[range.clone()],
                t: &self.t[range.clone()],
                inverse_distance: &self.inverse_distance[range.clone()],
                rest_cosine: &self.rest_cosine[range.clone()],
                transverse: &self.transverse[range.clone()],
                shear: &self.shear[range],
            };
            lanes::bond_forces(level, &input, out);
        };
        if self.bond_force.len() <= BOND_GRAIN {
            work((0, &mut self.bond_force));
        } else {
            self.bond_force
                .par_chunks_mut(BOND_GRAIN)
                .enumerate()
                .for_each(work);
        }
    }

    /// Calls `finish(first, forces, count, out, sum)` for every block of vertices with the forces of stretch, bending
    /// without twist, and bonds; `out` are the block's parts of `out`, and `sum` its entry of `sums`, which holds one
    /// for each block or nothing.
    pub(crate) fn each_vertex(
        &mut self,
        bundle: &Bundle,
        state: &State,
        out: &mut Vectors,
        sums: &mut [f64],
        finish: impl Fn(usize, &BlockForces, usize, [&mut [f64]; 3], Option<&mut f64>) + Sync,
    ) {
        if !bundle.bonds.is_empty() {
            self.bond_pass(state);
        }
        let this = &*self;
        let task = |k: usize, x: &mut [f64], y: &mut [f64], z: &mut [f64], sums: &mut [f64]| {
            let mut scratch = Scratch::NEW;
            let mut forces: BlockForces = [[0.0; ROOM]; 3];
            let mut sums = sums.iter_mut();
            let blocks = x
                .chunks_mut(BLOCK)
                .zip(y.chunks_mut(BLOCK))
                .zip(z.chunks_mut(BLOCK));
            for (b, ((x, y), z)) in blocks.enumerate() {
                let first = k * GRAIN + b * BLOCK;
                let count = x.len();
                this.rod_block(state, first, count, &mut scratch, &mut forces);
                if !bundle.bonds.is_empty() {
                    this.gather(bundle, first, count, &mut forces);
                }
                finish(first, &forces, count, [x, y, z], sums.next());
            }
        };
        let per_task = GRAIN / BLOCK;
        if out.len() <= GRAIN {
            task(0, &mut out.x, &mut out.y, &mut out.z, sums);
        } else if sums.is_empty() {
            let chunks = out.x.par_chunks_mut(GRAIN).zip(out.y.par_chunks_mut(GRAIN));
            chunks
                .zip(out.z.par_chunks_mut(GRAIN))
                .enumerate()
                .for_each(|(k, ((x, y), z))| task(k, x, y, z, &mut []));
        } else {
            let chunks = out.x.par_chunks_mut(GRAIN).zip(out.y.par_chunks_mut(GRAIN));
            chunks
                .zip(out.z.par_chunks_mut(GRAIN))
                .zip(sums.par_chunks_mut(per_task))
                .enumerate()
                .for_each(|(k, (((x, y), z), s))| task(k, x, y, z, s));
        }
    }

    /// How many entries `sums` of [`Evaluator::each_vertex`] has.
    pub(crate) fn blocks(vertices: usize) -> usize {
        vertices.div_ceil(BLOCK)
    }

    fn rod_block(
        &self,
        state: &State,
        first: usize,
        count: usize,
        scratch: &mut Scratch,
        out: &mut BlockForces,
    ) {
        let need = count.div_ceil(WIDTH) * WIDTH + BEFORE + BEHIND;
        let n = state.position.len();
        let p = &state.position;
        let sources = [&p.x, &p.y, &p.z, &state.plastic_strain];
        let constants = |a: &'_ [f64]| first..(first + need).min(a.len());
        let mut copies = [[0.0; ROOM]; 4];
        let inside = first >= BEFORE && first - BEFORE + need <= n;
        let view: [&[f64]; 4] = if inside {
            sources.map(|s| &s[first - BEFORE..first - BEFORE + need])
        } else {
            let (low, high) = (
                first.saturating_sub(BEFORE),
                (first - BEFORE.min(first) + need).min(n),
            );
            let shift = low + BEFORE - first;
            for (copy, source) in copies.iter_mut().zip(sources) {
                copy[shift..shift + high - low].copy_from_slice(&source[low..high]);
            }
            [0, 1, 2, 3].map(|a| &copies[a][..need])
        };
        let input = RodInput {
            position: [view[0], view[1], view[2]],
            plastic_strain: view[3],
            inverse_rest: &self.inverse_rest[constants(&self.inverse_rest)],
            stretch: &self.stretch[constants(&self.stretch)],
            rest_product: &self.rest_product[constants(&self.rest_product)],
            bend: &self.bend[constants(&self.bend)],
        };
        lanes::rod_forces(self.level, &input, count, scratch, out);
    }

    /// Adds what bonds do to the vertices of a block.
    fn gather(&self, bundle: &Bundle, first: usize, count: usize, out: &mut BlockForces) {
        let lists = &bundle.bonds.incidence;
        let [fx, fy, fz] = out;
        // What bonds do to the end of the edge before.
        let end_of = |edge: usize| {
            let mut sum = [0.0; 4];
            let range = lists.first[edge] as usize..lists.first[edge + 1] as usize;
            for &b in &lists.held[range] {
                let f = &self.bond_force[b as usize];
                sum[0] += f[3];
                sum[1] += f[4];
                sum[2] += f[5];
            }
            sum
        };
        let mut carried = if first > 0 {
            end_of(first - 1)
        } else {
            [0.0; 4]
        };
        for i in 0..count {
            let v = first + i;
            let mut sum = carried;
            for f in &self.bond_force[lists.own[v] as usize..lists.own[v + 1] as usize] {
                sum[0] += f[0];
                sum[1] += f[1];
                sum[2] += f[2];
            }
            let mut end = [0.0; 4];
            let range = lists.first[v] as usize..lists.first[v + 1] as usize;
            for &b in &lists.held[range] {
                let f = &self.bond_force[b as usize];
                for a in 0..3 {
                    sum[a] -= f[a] + f[3 + a];
                    end[a] += f[3 + a];
                }
            }
            fx[i] += sum[0];
            fy[i] += sum[1];
            fz[i] += sum[2];
            carried = end;
        }
    }
}
