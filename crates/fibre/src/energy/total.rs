//! Energies and forces of whole bundles, element by element.

use super::{bend_twist, bond, rod};
use crate::forces::Forces;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use serde::{Deserialize, Serialize};

/// Energies by kind, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Stretch of rods.
    pub stretch: f64,
    /// Bending of rods.
    pub bend: f64,
    /// Twist of rods.
    pub twist: f64,
    /// Bonds in tension or compression.
    pub bond_transverse: f64,
    /// Bonds in shear.
    pub bond_shear: f64,
}

impl Energies {
    /// Returns the energies of a state without those of bonds.
    pub(crate) fn of_rods(bundle: &RodBundle, state: &State) -> Self {
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
                    let (bend, twist) = bend_twist::energy(bundle, state, i);
                    sum.bend += bend;
                    sum.twist += twist;
                } else {
                    sum.bend += rod::bend_energy(bundle, state, i);
                }
            }
        }
        sum
    }

    /// Returns all stored energy, J.
    pub fn potential(&self) -> f64 {
        self.stretch + self.bend + self.twist + self.bond_transverse + self.bond_shear
    }

    /// Returns stored and kinetic energy, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential()
    }
}

/// Returns the energies of a state. The frames of `state` must belong to its positions ([`State::transport_frames`]).
pub fn energies(bundle: &RodBundle, state: &State) -> Energies {
    let mut sum = Energies::of_rods(bundle, state);
    for b in 0..bundle.bonds.len() {
        let (transverse, shear) = bond::energy(bundle, state, b);
        sum.bond_transverse += transverse;
        sum.bond_shear += shear;
    }
    sum
}

/// Adds the forces of all energies to `forces`. The frames of `state` must belong to its positions ([`State::transport_frames`]).
pub fn add_forces(bundle: &RodBundle, state: &State, forces: &mut Forces) {
    for i in 0..bundle.vertices() {
        if bundle.is_edge(i) {
            let gradient = rod::stretch(bundle, state, i).gradient_of_p(state.edge(i));
            forces.linear.add(i, gradient);
            forces.linear.add(i + 1, -gradient);
        }
        if bundle.bend[i] > 0.0 || bundle.twist[i] > 0.0 {
            if bundle.twisting {
                let g = bend_twist::gradient(bundle, state, i);
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
