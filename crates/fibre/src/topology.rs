//! Changes of a bundle where rods and bonds break (Sutherland 2012 §3.4.1): a broken rod becomes two rods, its vertex
//! becomes one vertex of each, and every bond follows.
//!
//! A bond of the broken vertex goes to both new ones, each with the share of stiffness and strength that is the share of
//! its rod in the length, so that breaking creates no energy. (The thesis gives both the whole.) Forces on the vertex are
//! shared in the same way; a clamp holds both.

use crate::bonds::{Bond, Bonds};
use crate::loads::{Loads, PointForce};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use glam::DVec3;

/// Removes the bonds `bonds` and splits rods at the inner vertices `splits`, both ascending. Returns for each vertex of the
/// bundle its number before.
pub fn break_up(
    bundle: &mut RodBundle,
    state: &mut State,
    loads: &mut Loads,
    bonds: &[u32],
    splits: &[u32],
) -> Vec<u32> {
    let n = bundle.vertices();
    let splits = Splits::new(bundle, splits);
    let remaining = remaining_bonds(bundle, bonds);
    if splits.vertices.is_empty() {
        bundle.bonds = Bonds::sorted(remaining, n);
        bundle.generation += 1;
        return (0..n as u32).collect();
    }
    let before: Vec<u32> = (0..n as u32)
        .flat_map(|v| std::iter::repeat_n(v, splits.copies(v).count()))
        .collect();
    let remaining = remaining
        .into_iter()
        .flat_map(|bond| splits.bond_copies(bond))
        .collect();
    splits.renumber_loads(loads);
    split_state(state, &before);
    split_bundle(bundle, &before, &splits.vertices);
    bundle.bonds = Bonds::sorted(remaining, bundle.vertices());
    bundle.generation += 1;
    before
}

/// A vertex that replaces one of the bundle before.
#[derive(Clone, Copy)]
struct VertexCopy {
    /// Its new number.
    vertex: u32,
    /// Its share of what the old vertex had.
    share: f64,
}

/// The vertices at which rods split, by their old numbers.
struct Splits {
    /// Ascending.
    vertices: Vec<u32>,
    /// Shares of the two copies of each, that with the following edge first.
    shares: Vec<[f64; 2]>,
}

impl Splits {
    /// Takes those of `wanted` (ascending) that are inner vertices of rods.
    fn new(bundle: &RodBundle, wanted: &[u32]) -> Self {
        let inner = |v: &u32| {
            let rod = bundle.rod_of(*v as usize);
            (*v as usize) < bundle.vertices()
                && *v > bundle.rod_offsets[rod]
                && v + 1 < bundle.rod_offsets[rod + 1]
        };
        let mut vertices: Vec<u32> = wanted.iter().copied().filter(inner).collect();
        vertices.dedup();
        let share = |&s: &u32| {
            let (a, b) = (
                bundle.rest_length[s as usize - 1],
                bundle.rest_length[s as usize],
            );
            [b / (a + b), a / (a + b)]
        };
        let shares = vertices.iter().map(share).collect();
        Splits { vertices, shares }
    }

    /// Returns the new number of the copy of `vertex` that has its following edge; it is also the new number of that edge.
    fn last_copy(&self, vertex: u32) -> u32 {
        vertex + self.vertices.partition_point(|&s| s <= vertex) as u32
    }

    /// Iterates over the copies of `vertex`, the last first.
    fn copies(&self, vertex: u32) -> impl Iterator<Item = VertexCopy> + use<> {
        let last = self.last_copy(vertex);
        let pair = match self.vertices.binary_search(&vertex) {
            Ok(k) => [Some(self.shares[k][0]), Some(self.shares[k][1])],
            Err(_) => [Some(1.0), None],
        };
        let numbered = pair.into_iter().zip([last, last.wrapping_sub(1)]);
        numbered.filter_map(|(share, vertex)| share.map(|share| VertexCopy { vertex, share }))
    }

    fn bond_copies(&self, bond: Bond) -> impl Iterator<Item = Bond> + use<> {
        let edge = self.last_copy(bond.edge);
        self.copies(bond.vertex).map(move |copy| Bond {
            vertex: copy.vertex,
            edge,
            transverse: bond.transverse * copy.share,
            shear: bond.shear * copy.share,
            area: bond.area * copy.share,
            tension_strength: bond.tension_strength * copy.share,
            shear_strength: bond.shear_strength * copy.share,
            fracture_energy: bond.fracture_energy * copy.share,
            shear_fracture_energy: bond.shear_fracture_energy * copy.share,
            ..bond
        })
    }

    fn renumber_loads(&self, loads: &mut Loads) {
        for clamp in &mut loads.clamps {
            let held: Vec<(u32, DVec3)> = (clamp.vertices.iter())
                .zip(&clamp.rest_positions)
                .flat_map(|(&v, &position)| self.copies(v).map(move |c| (c.vertex, position)))
                .collect();
            (clamp.vertices, clamp.rest_positions) = held.into_iter().unzip();
            clamp.edges.iter_mut().for_each(|e| *e = self.last_copy(*e));
        }
        loads.forces = (loads.forces.iter())
            .flat_map(|f| {
                self.copies(f.vertex).map(|copy| PointForce {
                    vertex: copy.vertex,
                    force: f.force * copy.share,
                    ..*f
                })
            })
            .collect();
        (loads.moments.iter_mut()).for_each(|m| m.edge = self.last_copy(m.edge));
    }
}

fn remaining_bonds(bundle: &RodBundle, broken: &[u32]) -> Vec<Bond> {
    let mut broken = broken.iter().peekable();
    let mut remaining = Vec::with_capacity(bundle.bonds.len());
    for (i, bond) in bundle.bonds.iter().enumerate() {
        while broken.next_if(|&&b| (b as usize) < i).is_some() {}
        if broken.peek().is_none_or(|&&b| b as usize != i) {
            remaining.push(bond);
        }
    }
    remaining
}

fn select<T: Copy>(from: &mut Vec<T>, before: &[u32]) {
    if !from.is_empty() {
        *from = before.iter().map(|&v| from[v as usize]).collect();
    }
}

fn select_vectors(from: &mut Vectors, before: &[u32]) {
    select(&mut from.x, before);
    select(&mut from.y, before);
    select(&mut from.z, before);
}

/// Gives each vertex of a state the values of vertex `before[v]`, as [`break_up`] returns them.
pub(crate) fn split_state(state: &mut State, before: &[u32]) {
    let State {
        position,
        velocity,
        tangent,
        director,
        ..
    } = state;
    for vectors in [position, velocity, tangent, director] {
        select_vectors(vectors, before);
    }
    let State {
        angle,
        spin,
        reference_twist,
        plastic_strain,
        ..
    } = state;
    for numbers in [angle, spin, reference_twist, plastic_strain] {
        select(numbers, before);
    }
}

fn split_bundle(bundle: &mut RodBundle, before: &[u32], splits: &[u32]) {
    let RodBundle {
        rest,
        rest_director,
        ..
    } = bundle;
    select_vectors(rest, before);
    select_vectors(rest_director, before);
    let [kappa, lambda] = &mut bundle.natural_curvature;
    let numbers = [
        &mut bundle.mass,
        &mut bundle.bend,
        kappa,
        lambda,
        &mut bundle.twist,
        &mut bundle.tension_limit,
        &mut bundle.shear_limit,
        &mut bundle.rest_length,
        &mut bundle.stretch,
        &mut bundle.edge_mass,
        &mut bundle.inertia,
        &mut bundle.yield_strain,
    ];
    for array in numbers {
        select(array, before);
    }
    select(&mut bundle.origin, before);
    // Each rod is cut at its splits.
    let (mut first, mut area, mut diameter, mut parent) =
        (vec![0], Vec::new(), Vec::new(), Vec::new());
    let mut splits_left = splits.iter().enumerate().peekable();
    for rod in 0..bundle.rods() {
        let end = bundle.rod_offsets[rod + 1];
        let mut put = |start: u32| {
            first.push(start);
            area.push(bundle.area[rod]);
            diameter.push(bundle.diameter[rod]);
            parent.push(bundle.parent[rod]);
        };
        let mut done = splits.partition_point(|&s| s < bundle.rod_offsets[rod]);
        while let Some((k, &s)) = splits_left.next_if(|(_, s)| **s < end) {
            put(s + k as u32 + 1);
            done = k + 1;
        }
        put(end + done as u32);
    }
    (
        bundle.rod_offsets,
        bundle.area,
        bundle.diameter,
        bundle.parent,
    ) = (first, area, diameter, parent);
    for (k, &s) in splits.iter().enumerate() {
        let (left, right) = (s as usize + k, s as usize + k + 1);
        // Behind the left copy there is a gap now.
        bundle.rest_length[left] = 1.0;
        for array in [
            &mut bundle.stretch,
            &mut bundle.edge_mass,
            &mut bundle.inertia,
        ] {
            array[left] = 0.0;
        }
        let [kappa, lambda] = &mut bundle.natural_curvature;
        for array in [&mut bundle.bend, &mut bundle.twist, kappa, lambda] {
            array[left] = 0.0;
            array[right] = 0.0;
        }
    }
    for rod in 0..bundle.rods() {
        bundle.distribute_mass(bundle.rod(rod));
    }
}
