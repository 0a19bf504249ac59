//! What is left when rods and bonds have broken (Sutherland 2012 §3.4.1): a broken rod is two rods, its vertex one of
//! each, and every bond follows.
//!
//! A bond of the broken vertex goes to both new ones, each with the share of stiffness and strength that the share of
//! its rod is long, so that breaking makes no energy. (The thesis gives both the whole.) Forces on the vertex are shared
//! alike; a clamp holds both.

use crate::bonds::{Bond, Bonds};
use crate::bundle::Bundle;
use crate::loads::Loads;
use crate::state::State;
use crate::vectors::Vectors;

/// Takes out the bonds `bonds` and splits rods at the inner vertices `splits`, both ascending. Returns for each vertex of
/// the bundle now which it was before.
pub fn break_up(
    bundle: &mut Bundle,
    state: &mut State,
    loads: &mut Loads,
    bonds: &[u32],
    splits: &[u32],
) -> Vec<u32> {
    let n = bundle.vertices();
    let inner = |v: &u32| {
        let rod = bundle.rod_of(*v as usize);
        (*v as usize) < n && *v > bundle.first[rod] && v + 1 < bundle.first[rod + 1]
    };
    let mut splits: Vec<u32> = splits.iter().copied().filter(inner).collect();
    splits.dedup();
    let kept = kept_bonds(bundle, bonds);
    if splits.is_empty() {
        bundle.bonds = Bonds::sorted(kept, n);
        bundle.generation += 1;
        return (0..n as u32).collect();
    }
    let before: Vec<u32> = (0..n as u32)
        .flat_map(|v| std::iter::repeat_n(v, 1 + usize::from(splits.binary_search(&v).is_ok())))
        .collect();
    // The last of a vertex's copies carries on its edge.
    let last = |v: u32| v + splits.partition_point(|&s| s <= v) as u32;
    let copies = |v: u32| (last(v) - u32::from(splits.binary_search(&v).is_ok())..=last(v)).rev();
    // Shares of the copies of a vertex, the last first.
    let shares: Vec<[f64; 2]> = splits
        .iter()
        .map(|&s| {
            let (a, b) = (
                bundle.rest_length[s as usize - 1],
                bundle.rest_length[s as usize],
            );
            [b / (a + b), a / (a + b)]
        })
        .collect();
    let share = |v: u32, copy: usize| splits.binary_search(&v).map_or(1.0, |k| shares[k][copy]);
    let moved: Vec<Bond> = kept
        .into_iter()
        .flat_map(|b| {
            let v = b.vertex;
            copies(v)
                .enumerate()
                .map(move |(k, copy)| (copy, share(v, k), b))
                .collect::<Vec<_>>()
        })
        .map(|(vertex, part, b)| Bond {
            vertex,
            edge: last(b.edge),
            transverse: b.transverse * part,
            shear: b.shear * part,
            area: b.area * part,
            tension_strength: b.tension_strength * part,
            shear_strength: b.shear_strength * part,
            fracture_energy: b.fracture_energy * part,
            ..b
        })
        .collect();
    for clamp in &mut loads.clamps {
        let all = clamp.vertices.iter().zip(&clamp.held);
        let doubled: Vec<(u32, glam::DVec3)> = all
            .flat_map(|(&v, &at)| copies(v).map(move |c| (c, at)).collect::<Vec<_>>())
            .collect();
        (clamp.vertices, clamp.held) = doubled.into_iter().unzip();
        clamp.edges.iter_mut().for_each(|e| *e = last(*e));
    }
    loads.forces = loads
        .forces
        .iter()
        .flat_map(|f| {
            let all = copies(f.vertex).enumerate();
            all.map(|(k, vertex)| {
                let force = f.force * share(f.vertex, k);
                crate::loads::PointForce {
                    vertex,
                    force,
                    ..*f
                }
            })
            .collect::<Vec<_>>()
        })
        .collect();
    loads.moments.iter_mut().for_each(|m| m.edge = last(m.edge));
    split_state(state, &before);
    split_bundle(bundle, &before, &splits);
    bundle.bonds = Bonds::sorted(moved, bundle.vertices());
    bundle.generation += 1;
    before
}

fn kept_bonds(bundle: &Bundle, broken: &[u32]) -> Vec<Bond> {
    let mut broken = broken.iter().peekable();
    let mut kept = Vec::with_capacity(bundle.bonds.len());
    for (i, bond) in bundle.bonds.iter().enumerate() {
        while broken.next_if(|&&b| (b as usize) < i).is_some() {}
        if broken.peek().is_none_or(|&&b| b as usize != i) {
            kept.push(bond);
        }
    }
    kept
}

fn picked<T: Copy>(from: &mut Vec<T>, before: &[u32]) {
    if !from.is_empty() {
        *from = before.iter().map(|&v| from[v as usize]).collect();
    }
}

fn picked_vectors(from: &mut Vectors, before: &[u32]) {
    picked(&mut from.x, before);
    picked(&mut from.y, before);
    picked(&mut from.z, before);
}

/// Gives each vertex of a state that it was before, as [`break_up`] tells.
pub fn split_state(state: &mut State, before: &[u32]) {
    let State {
        position,
        velocity,
        tangent,
        director,
        ..
    } = state;
    for vectors in [position, velocity, tangent, director] {
        picked_vectors(vectors, before);
    }
    let State {
        angle,
        spin,
        reference_twist,
        plastic_strain,
        ..
    } = state;
    for numbers in [angle, spin, reference_twist, plastic_strain] {
        picked(numbers, before);
    }
}

fn split_bundle(bundle: &mut Bundle, before: &[u32], splits: &[u32]) {
    let Bundle {
        rest,
        rest_director,
        ..
    } = bundle;
    picked_vectors(rest, before);
    picked_vectors(rest_director, before);
    let [kappa, lambda] = &mut bundle.natural_curvature;
    let numbers = [
        &mut bundle.mass,
        &mut bundle.bend,
        kappa,
        lambda,
        &mut bundle.twist,
        &mut bundle.tension_limit,
        &mut bundle.rest_length,
        &mut bundle.stretch,
        &mut bundle.edge_mass,
        &mut bundle.inertia,
        &mut bundle.yield_strain,
    ];
    for array in numbers {
        picked(array, before);
    }
    picked(&mut bundle.origin, before);
    // Rods: each is cut at its splits.
    let (mut first, mut area, mut diameter, mut parent) =
        (vec![0], Vec::new(), Vec::new(), Vec::new());
    let mut splits_left = splits.iter().enumerate().peekable();
    for rod in 0..bundle.rods() {
        let end = bundle.first[rod + 1];
        let mut put = |start: u32| {
            first.push(start);
            area.push(bundle.area[rod]);
            diameter.push(bundle.diameter[rod]);
            parent.push(bundle.parent[rod]);
        };
        let mut done = splits.partition_point(|&s| s < bundle.first[rod]);
        while let Some((k, &s)) = splits_left.next_if(|(_, s)| **s < end) {
            put(s + k as u32 + 1);
            done = k + 1;
        }
        put(end + done as u32);
    }
    (bundle.first, bundle.area, bundle.diameter, bundle.parent) = (first, area, diameter, parent);
    for (k, &s) in splits.iter().enumerate() {
        let (left, right) = (s as usize + k, s as usize + k + 1);
        // The left copy is a gap now.
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
        bundle.share_mass(bundle.rod(rod));
    }
}
