//! Energies of a bundle by kind, their forces, and the Hessians of single elements.
//!
//! Everything here is written to be read and to be checked: the reference that fast code is tested against. Forces are
//! the exact negative gradients of the energies.
//!
//! - stretch (Eq. 3.9): ½ k (|e|/|ē| − 1 − ε_p)² |ē|, ε_p the permanent strain;
//! - bend without twist (Eq. 3.4): α |κb|²/l, with the thesis's κb of rest lengths;
//! - bend with twist (Bergou 2010): α |κ − κ̄|²/l in the material frame, and twist β m²/l;
//! - bonds (§3.3.2, corrected): transverse ½ k_t (|d|/d₀ − 1)² d₀ and shear S (cos θ − cos θ₀)².

pub mod bond;
pub mod framed;
pub mod pair;
pub mod rod;

use crate::bundle::Bundle;
use crate::state::State;
use crate::vectors::Vectors;
use serde::{Deserialize, Serialize};

/// Energies by kind, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Of motion.
    pub kinetic: f64,
    /// Stretch of rods.
    pub stretch: f64,
    /// Bending of rods.
    pub bend: f64,
    /// Twist of rods.
    pub twist: f64,
    /// Bonds drawn apart or pressed together.
    pub bond_transverse: f64,
    /// Bonds sheared.
    pub bond_shear: f64,
}

impl Energies {
    /// All that is stored, without motion.
    pub fn potential(&self) -> f64 {
        self.stretch + self.bend + self.twist + self.bond_transverse + self.bond_shear
    }

    /// Stored and of motion.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential()
    }
}

/// Forces on vertices (N) and, with twist, moments on the angles of edges (N m).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Forces {
    /// Per vertex, N.
    pub linear: Vectors,
    /// Per edge, N m.
    pub moment: Vec<f64>,
}

impl Forces {
    /// No forces for `vertices` vertices.
    pub fn zeros(vertices: usize) -> Self {
        Forces {
            linear: Vectors::zeros(vertices),
            moment: vec![0.0; vertices],
        }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.linear.clear_to_zero();
        self.moment.fill(0.0);
    }
}

/// Energies of a state. The frames of `state` must belong to its positions ([`State::carry_frames`]).
pub fn energies(bundle: &Bundle, state: &State) -> Energies {
    let mut sum = Energies {
        kinetic: state.kinetic_energy(bundle),
        ..Energies::default()
    };
    for i in 0..bundle.vertices() {
        if bundle.is_edge(i) {
            sum.stretch += rod::stretch(bundle, state, i).value;
        }
        if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
            if bundle.twisting {
                let (bend, twist) = framed::energy(bundle, state, i);
                sum.bend += bend;
                sum.twist += twist;
            } else {
                sum.bend += rod::bend_energy(bundle, state, i);
            }
        }
    }
    for b in 0..bundle.bonds.len() {
        let (transverse, shear) = bond::energy(bundle, state, b);
        sum.bond_transverse += transverse;
        sum.bond_shear += shear;
    }
    sum
}

/// Adds the forces of all energies. The frames of `state` must belong to its positions ([`State::carry_frames`]).
pub fn add_forces(bundle: &Bundle, state: &State, forces: &mut Forces) {
    for i in 0..bundle.vertices() {
        if bundle.is_edge(i) {
            let gradient = rod::stretch(bundle, state, i).along_first(state.edge(i));
            forces.linear.add(i, gradient);
            forces.linear.add(i + 1, -gradient);
        }
        if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
            if bundle.twisting {
                let g = framed::gradient(bundle, state, i);
                forces.linear.add(i - 1, g.before);
                forces.linear.add(i, g.after - g.before);
                forces.linear.add(i + 1, -g.after);
                forces.moment[i - 1] -= g.angle_before;
                forces.moment[i] -= g.angle_after;
            } else {
                let (ga, gb) = rod::bend_gradient(bundle, state, i);
                forces.linear.add(i - 1, ga);
                forces.linear.add(i, gb - ga);
                forces.linear.add(i + 1, -gb);
            }
        }
    }
    for b in 0..bundle.bonds.len() {
        let (on_vertex, on_start, on_end) = bond::forces(bundle, state, b);
        let j = bundle.bonds.edge[b] as usize;
        forces
            .linear
            .add(bundle.bonds.vertex[b] as usize, on_vertex);
        forces.linear.add(j, on_start);
        forces.linear.add(j + 1, on_end);
    }
}

/// Which Hessian is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curvature {
    /// The exact second derivatives (of framed bending and twist the Gauss–Newton part, which is all of it at rest).
    Exact,
    /// The part of it that is never negative, from first derivatives of strains: always solvable.
    GaussNewton,
}

/// Most degrees of freedom of an element: three vertices and two angles.
pub const MOST_FREEDOMS: usize = 11;

/// The Hessian of one element over its degrees of freedom: number 3v + axis for vertex v, and 3n + j for the angle of
/// edge j, of n vertices.
#[derive(Debug, Clone, Copy)]
pub struct ElementHessian {
    /// How many of the entries below are used.
    pub count: usize,
    /// Degrees of freedom.
    pub freedoms: [u32; MOST_FREEDOMS],
    /// Symmetric matrix of second derivatives.
    pub matrix: [[f64; MOST_FREEDOMS]; MOST_FREEDOMS],
}

/// Calls `visit` for the Hessian of every edge, every vertex with bending, and every bond, in this order.
pub fn visit_hessians(
    bundle: &Bundle,
    state: &State,
    kind: Curvature,
    mut visit: impl FnMut(&ElementHessian),
) {
    for j in 0..bundle.vertices() {
        if bundle.is_edge(j) {
            visit(&rod::stretch_hessian(bundle, state, j, kind));
        }
    }
    for i in 0..bundle.vertices() {
        if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
            if bundle.twisting {
                visit(&framed::hessian(bundle, state, i));
            } else {
                visit(&rod::bend_hessian(bundle, state, i, kind));
            }
        }
    }
    for b in 0..bundle.bonds.len() {
        visit(&bond::hessian(bundle, state, b, kind));
    }
}
