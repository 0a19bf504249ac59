//! Linear systems of a bundle by conjugate gradients, for solvers that have a picture's time for a step and must not
//! remember anything from one step to the next.
//!
//! The preconditioner knows what is stiff in wood. Each rod is solved exactly along the grain, a band of three blocks,
//! with its bonds to others on the diagonal; and each section moves as a whole, stretches and shears in its plane (nine
//! freedoms for each piece of a section that bonds still hold together: the beam that a stem is). What is left to the
//! iteration is how rods of one section move against each other. The two corrections are added (an additive two-level
//! Schwarz method); no piece is remembered that has broken.
//!
//! Sums run in fixed blocks, so that the number of threads changes no bit.

// Rows, columns and vertices index several arrays alike.
#![allow(clippy::needless_range_loop)]

use super::direct::touch_block;
use super::lines::Lines;
use super::newton::Problem;
use super::sections::Sections;
use crate::bundle::Bundle;
use crate::energy::{Curvature, ElementHessian, bond, framed, rod};
use crate::solver::Touch;
use rayon::prelude::*;

/// Numbers at a vertex: three of its place, one of its edge's angle.
pub(super) type Node = [f64; 4];
/// Column of a block.
type Column = [f64; 4];
/// Vertices that one task takes, and that one sum is of.
const GRAIN: usize = 256;
/// Part of the vertices whose bonds are added together with the rods, so that both arrays take about as long.
const OWN: f64 = 0.3;
/// Iterations at most.
const MOST: usize = 400;
/// Stiffness of a yielding edge over that of an elastic one: none at all could leave the matrix singular.
const YIELDING: f64 = 2e-2;

/// The matrix of a bundle with `B` freedoms at a vertex, and its preconditioner.
#[derive(Debug, Clone, Default)]
pub(super) struct System<const B: usize> {
    generation: Option<u64>,
    /// First entry of each row, and their number at the end.
    first: Vec<u32>,
    column: Vec<u32>,
    /// Blocks as columns; part of the elements adds to its own array.
    value: Vec<[Column; B]>,
    other: Vec<[Column; B]>,
    elements: Vec<Element>,
    slots: Vec<[u32; 9]>,
    /// Vertex and edge of each bond, and its places.
    names: Vec<(u32, u32)>,
    bond_slots: Vec<[u32; 9]>,
    diagonal: Vec<u32>,
    lines: Lines<B>,
    sections: Sections,
    /// Contacts between rods.
    pushes: Vec<Push>,
    free: Vec<Node>,
    iterations: u64,
}

/// A contact between two rods, whose coupling has no place among the blocks.
#[derive(Debug, Clone, Copy)]
struct Push {
    /// Vertices of the one and of the other, with their weights.
    shares: [(usize, f64); 4],
    normal: glam::DVec3,
    stiffness: f64,
}

/// An element of a rod.
#[derive(Debug, Clone, Copy)]
enum Element {
    Edge(u32),
    Bend(u32),
}

impl Element {
    fn nodes(self) -> ([usize; 3], usize) {
        match self {
            Element::Edge(j) => ([j as usize, j as usize + 1, 0], 2),
            Element::Bend(i) => ([i as usize - 1, i as usize, i as usize + 1], 3),
        }
    }

    fn hessian(self, problem: &Problem) -> ElementHessian {
        let (bundle, state) = (problem.bundle, problem.state);
        match self {
            Element::Edge(j) => {
                let j = j as usize;
                let yields = state.plastic_strain[j] != problem.plastic[j];
                // Tension stiffens a string; pressure is left out, as what it softens can be more than there is.
                let kind = if rod::strain(bundle, state, j) > 0.0 && !yields {
                    Curvature::Exact
                } else {
                    Curvature::GaussNewton
                };
                let mut made = rod::stretch_hessian(bundle, state, j, kind);
                if yields {
                    made.matrix
                        .iter_mut()
                        .flatten()
                        .for_each(|v| *v *= YIELDING);
                }
                made
            }
            Element::Bend(i) if bundle.twisting => framed::hessian(bundle, state, i as usize),
            Element::Bend(i) => {
                rod::bend_hessian(bundle, state, i as usize, Curvature::GaussNewton)
            }
        }
    }
}

fn bond_nodes(bundle: &Bundle, bond: usize) -> [usize; 3] {
    let j = bundle.bonds.edge[bond] as usize;
    [bundle.bonds.vertex[bond] as usize, j, j + 1]
}

impl<const B: usize> System<B> {
    /// Conjugate gradients so far.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Makes everything that depends on which rods and bonds there are. Where only bonds have broken their places in the
    /// matrix stay, and hold zeros.
    pub fn prepare(&mut self, bundle: &Bundle) {
        if self.generation == Some(bundle.generation) {
            return;
        }
        self.generation = Some(bundle.generation);
        let names = (bundle.bonds.vertex.iter().zip(&bundle.bonds.edge)).map(|(v, e)| (*v, *e));
        let names: Vec<(u32, u32)> = names.collect();
        let kept = self.kept_slots(bundle, &names);
        self.names = names;
        match kept {
            Some(slots) => self.bond_slots = slots,
            None => self.build(bundle),
        }
        self.sections.prepare(bundle, &self.first, &self.column);
    }

    /// The places of the bonds there are, if these are some of those there were and no rod has broken.
    fn kept_slots(&self, bundle: &Bundle, names: &[(u32, u32)]) -> Option<Vec<[u32; 9]>> {
        if self.diagonal.len() != bundle.vertices() {
            return None;
        }
        let mut old = self.names.iter().zip(&self.bond_slots);
        names
            .iter()
            .map(|name| old.find(|o| o.0 == name).map(|o| *o.1))
            .collect()
    }

    fn build(&mut self, bundle: &Bundle) {
        let n = bundle.vertices();
        let all = 0..n as u32;
        let edges = all.clone().filter(|&j| bundle.is_edge(j as usize));
        let bends =
            all.filter(|&i| bundle.bend[i as usize] > 0.0 || bundle.twist[i as usize] > 0.0);
        self.elements = edges
            .map(Element::Edge)
            .chain(bends.map(Element::Bend))
            .collect();
        let mut rows: Vec<Vec<u32>> = (0..n as u32).map(|v| vec![v]).collect();
        let mut couple = |nodes: &[usize]| {
            for &a in nodes {
                rows[a].extend(nodes.iter().map(|b| *b as u32));
            }
        };
        for element in &self.elements {
            let (nodes, count) = element.nodes();
            couple(&nodes[..count]);
        }
        (0..bundle.bonds.len()).for_each(|b| couple(&bond_nodes(bundle, b)));
        (self.first, self.column) = (vec![0], Vec::new());
        for row in &mut rows {
            row.sort_unstable();
            row.dedup();
            self.column.extend_from_slice(row);
            self.first.push(self.column.len() as u32);
        }
        let find = |a: usize, b: usize| {
            let (from, to) = (self.first[a] as usize, self.first[a + 1] as usize);
            let row = &self.column[from..to];
            (from + row.partition_point(|&c| (c as usize) < b)) as u32
        };
        self.diagonal = (0..n).map(|v| find(v, v)).collect();
        let slots = |nodes: &[usize]| {
            let mut made = [0; 9];
            for (a, &u) in nodes.iter().enumerate() {
                for (b, &v) in nodes.iter().enumerate() {
                    made[3 * a + b] = find(u, v);
                }
            }
            made
        };
        self.slots = (self.elements.iter())
            .map(|element| {
                let (nodes, count) = element.nodes();
                slots(&nodes[..count])
            })
            .collect();
        self.bond_slots = (0..bundle.bonds.len())
            .map(|b| slots(&bond_nodes(bundle, b)))
            .collect();
        self.value = vec![[[0.0; 4]; B]; self.column.len()];
        self.other = self.value.clone();
        self.lines.prepare(bundle, &self.first, &self.column);
    }

    /// The step of a problem: `prescribed` where held, else what balances the linearised forces.
    pub fn solve(&mut self, problem: &Problem) -> Vec<f64> {
        let n = problem.bundle.vertices();
        if problem.fresh {
            self.assemble(problem);
        }
        let node = |of: &[f64], v: usize| -> Node {
            std::array::from_fn(|a| if a < B { of[v * B + a] } else { 0.0 })
        };
        let free: Vec<Node> = (0..n)
            .map(|v| std::array::from_fn(|a| f64::from(a < B && !problem.held[v * B + a])))
            .collect();
        self.free.clone_from(&free);
        let mut x: Vec<Node> = (0..n).map(|v| node(problem.prescribed, v)).collect();
        let mut r: Vec<Node> = (0..n).map(|v| node(problem.residual, v)).collect();
        if problem.prescribed.iter().any(|d| *d != 0.0) {
            let mut pushed = vec![[0.0; 4]; n];
            self.multiply(&x, &mut pushed);
            r.iter_mut()
                .zip(&pushed)
                .for_each(|(r, p)| (0..4).for_each(|a| r[a] -= p[a]));
        }
        mask(&mut r, &free);
        if problem.fresh {
            self.hold(&free);
            let (lines, sections) = (&mut self.lines, &mut self.sections);
            let value = &self.value;
            rayon::join(|| lines.factor(value), || sections.factor(value));
        }
        self.conjugate_gradients(problem.accuracy, &free, &mut r, &mut x);
        x.iter().flat_map(|x| x[..B].iter().copied()).collect()
    }

    fn conjugate_gradients(
        &mut self,
        accuracy: f64,
        free: &[Node],
        r: &mut [Node],
        x: &mut [Node],
    ) {
        let n = r.len();
        let (mut z, mut p, mut ap) = (vec![[0.0; 4]; n], vec![[0.0; 4]; n], vec![[0.0; 4]; n]);
        self.precondition(free, r, &mut z);
        p.copy_from_slice(&z);
        let mut rz = dot(r, &z);
        let goal = accuracy * accuracy * rz;
        for _ in 0..MOST {
            if rz <= goal || !rz.is_finite() {
                return;
            }
            self.iterations += 1;
            self.multiply(&p, &mut ap);
            let curvature = dot(&p, &ap);
            if curvature.is_nan() || curvature <= 0.0 {
                return;
            }
            let along = rz / curvature;
            for v in 0..n {
                for a in 0..4 {
                    x[v][a] += along * p[v][a];
                    r[v][a] -= along * ap[v][a];
                }
            }
            self.precondition(free, r, &mut z);
            let next = dot(r, &z);
            let keep = next / rz;
            rz = next;
            for v in 0..n {
                (0..4).for_each(|a| p[v][a] = z[v][a] + keep * p[v][a]);
            }
        }
    }

    fn precondition(&self, free: &[Node], r: &[Node], z: &mut [Node]) {
        let coarse = {
            let (lines, sections) = (&self.lines, &self.sections);
            rayon::join(|| lines.solve(r, z), || sections.solve(r)).1
        };
        self.sections.add(&coarse, z);
        mask(z, free);
    }

    /// Takes rows and columns that are not free out of the system: zero, with 1 on the diagonal.
    fn hold(&mut self, free: &[Node]) {
        if free.iter().all(|f| f[..B].iter().all(|f| *f == 1.0)) {
            return;
        }
        for v in 0..free.len() {
            for k in self.first[v] as usize..self.first[v + 1] as usize {
                let other = &free[self.column[k] as usize];
                for b in 0..B {
                    (0..4).for_each(|a| self.value[k][b][a] *= free[v][a] * other[b]);
                }
            }
            let block = &mut self.value[self.diagonal[v] as usize];
            (0..B).for_each(|a| block[a][a] += 1.0 - free[v][a]);
        }
    }

    /// `out` = matrix × `x`.
    fn multiply(&self, x: &[Node], out: &mut [Node]) {
        out.par_chunks_mut(GRAIN).enumerate().for_each(|(k, out)| {
            pulp::Arch::new().dispatch(|| {
                for (i, out) in out.iter_mut().enumerate() {
                    let v = k * GRAIN + i;
                    let (from, to) = (self.first[v] as usize, self.first[v + 1] as usize);
                    let mut sum = [0.0; 4];
                    for (block, &c) in self.value[from..to].iter().zip(&self.column[from..to]) {
                        let x = &x[c as usize];
                        for b in 0..B {
                            for a in 0..4 {
                                sum[a] += block[b][a] * x[b];
                            }
                        }
                    }
                    *out = sum;
                }
            });
        });
        for push in &self.pushes {
            let along = |of: &[(usize, f64)]| {
                of.iter().fold(0.0, |sum, &(v, w)| {
                    let moved = glam::DVec3::new(x[v][0], x[v][1], x[v][2]);
                    sum + w * moved.dot(push.normal)
                })
            };
            let less = push.stiffness * (along(&push.shares[..2]) - along(&push.shares[2..]));
            for (k, &(v, w)) in push.shares.iter().enumerate() {
                let force = push.normal * if k < 2 { -less * w } else { less * w };
                for a in 0..3 {
                    out[v][a] += force[a] * self.free[v][a];
                }
            }
        }
    }

    fn assemble(&mut self, problem: &Problem) {
        let bundle = problem.bundle;
        // The same bonds go to the same array whatever has broken: sums must not depend on it.
        let border = (OWN * bundle.vertices() as f64) as u32;
        let border = bundle.bonds.vertex.partition_point(|&v| v < border);
        let (elements, slots, bond_slots) = (&self.elements, &self.slots, &self.bond_slots);
        let clear = |value: &mut [[Column; B]]| value.fill([[0.0; 4]; B]);
        let rods = |value: &mut [[Column; B]]| {
            for (element, slots) in elements.iter().zip(slots) {
                add_element(&element.hessian(problem), element.nodes().1, slots, value);
            }
        };
        let bonds = |value: &mut [[Column; B]], range: std::ops::Range<usize>| {
            pulp::Arch::new().dispatch(|| {
                for k in range.clone() {
                    add_bond(problem, k, &bond_slots[k], value);
                }
            });
        };
        let (value, other) = (&mut self.value, &mut self.other);
        rayon::join(
            || {
                clear(value);
                rods(value);
                bonds(value, 0..border);
            },
            || {
                clear(other);
                bonds(other, border..bond_slots.len());
            },
        );
        for (v, o) in self.value.iter_mut().zip(&self.other) {
            for b in 0..B {
                (0..4).for_each(|a| v[b][a] += o[b][a]);
            }
        }
        for v in 0..bundle.vertices() {
            let block = &mut self.value[self.diagonal[v] as usize];
            (0..3).for_each(|a| block[a][a] += bundle.mass[v] * problem.inertia);
            if B == 4 {
                // An angle without an edge, or whose edge is free to turn.
                block[3][3] += bundle.inertia[v] * problem.inertia;
                if block[3][3] <= 0.0 {
                    block[3][3] = 1.0;
                }
            }
        }
        self.add_touches(problem.touches);
    }

    /// Adds contacts. What joins two rods has no place among the blocks: twice its diagonal blocks, which are never less,
    /// stand there for the preconditioner, and [`System::multiply`] makes up for the difference.
    fn add_touches(&mut self, touches: &[Touch]) {
        self.pushes.clear();
        for touch in touches {
            let parts: Vec<(usize, f64)> = touch.shares().collect();
            let by = if touch.other.is_some() { 2.0 } else { 1.0 };
            if let [a, b, c, d] = parts[..] {
                self.pushes.push(Push {
                    shares: [a, b, c, d],
                    normal: touch.normal,
                    stiffness: touch.stiffness,
                });
            }
            for (i, a) in parts.iter().enumerate() {
                for (k, b) in parts.iter().enumerate() {
                    if i / 2 != k / 2 {
                        continue;
                    }
                    let (from, to) = (self.first[a.0] as usize, self.first[a.0 + 1] as usize);
                    let row = &self.column[from..to];
                    let slot = from + row.partition_point(|&c| (c as usize) < b.0);
                    for column in 0..3 {
                        for row in 0..3 {
                            let k = touch_block(touch, touch.normal, row, column);
                            self.value[slot][column][row] += by * a.1 * b.1 * k;
                        }
                    }
                }
            }
        }
    }
}

/// Adds the Hessian of an element of `count` vertices.
fn add_element<const B: usize>(
    hessian: &ElementHessian,
    count: usize,
    slots: &[u32; 9],
    value: &mut [[Column; B]],
) {
    // Freedoms are those of places by vertex, then angles of the first two edges.
    let of = |f: usize| {
        if f < 3 * count {
            (f / 3, f % 3)
        } else {
            (f - 3 * count, 3)
        }
    };
    for column in 0..hessian.count {
        let (b, beta) = of(column);
        for row in 0..hessian.count {
            let (a, alpha) = of(row);
            value[slots[3 * a + b] as usize][beta][alpha] += hessian.matrix[row][column];
        }
    }
}

/// Adds a bond: k u uᵀ + 2 S w wᵀ with the gradients u of its length and w of its cosine.
#[inline(always)]
fn add_bond<const B: usize>(
    problem: &Problem,
    number: usize,
    slots: &[u32; 9],
    value: &mut [[Column; B]],
) {
    let bonds = &problem.bundle.bonds;
    let (e, d) = bond::vectors(problem.bundle, problem.state, number);
    let (le, ld) = (1.0 / e.length(), 1.0 / d.length());
    let (e, d) = (e * le, d * ld);
    let cosine = e.dot(d);
    let (by_d, by_e) = ((e - d * cosine) * ld, (d - e * cosine) * le);
    let t = bonds.t[number];
    let parts = [1.0, t - 1.0, -t];
    let node = |v: glam::DVec3| -> Node { [v.x, v.y, v.z, 0.0] };
    let length = parts.map(|p| node(d * p));
    let turn = [
        node(by_d),
        node(by_d * parts[1] - by_e),
        node(by_d * parts[2] + by_e),
    ];
    let k = bonds.transverse[number] / bonds.distance[number];
    let s = 2.0 * bonds.shear[number];
    for a in 0..3 {
        for b in 0..3 {
            let block = &mut value[slots[3 * a + b] as usize];
            for beta in 0..3 {
                let (u, w) = (k * length[b][beta], s * turn[b][beta]);
                for alpha in 0..4 {
                    block[beta][alpha] += u * length[a][alpha] + w * turn[a][alpha];
                }
            }
        }
    }
}

fn mask(of: &mut [Node], free: &[Node]) {
    of.iter_mut()
        .zip(free)
        .for_each(|(v, f)| (0..4).for_each(|a| v[a] *= f[a]));
}

fn dot(a: &[Node], b: &[Node]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.chunks(GRAIN).zip(b.chunks(GRAIN)) {
        let mut lanes = [0.0; 4];
        for (a, b) in a.iter().zip(b) {
            (0..4).for_each(|l| lanes[l] += a[l] * b[l]);
        }
        sum += (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
    }
    sum
}
