//! Which bonds may fail: the evaluator's part of [`crate::failure`].

use super::Evaluator;
use super::wide::lanes::WIDTH;
use super::wide::watch::{Demands, Limits};
use crate::bundle::Bundle;
use crate::failure::BondCriterion;
use crate::state::State;

/// Demand at which a bond is looked at: below 1 by far more than rounding.
const SUSPECT: f64 = 1.0 - 1e-6;

/// What is watched for.
#[derive(Debug, Clone, Default)]
pub(super) struct Watch {
    of: Option<(BondCriterion, u64)>,
    limits: Vec<Limits>,
    demands: Vec<Demands>,
}

impl Evaluator {
    /// Sets `found` to the bonds, ascending, that may fail in a state: all that do, and few others.
    pub(crate) fn suspects(
        &mut self,
        bundle: &Bundle,
        state: &State,
        criterion: BondCriterion,
        found: &mut Vec<u32>,
    ) {
        found.clear();
        self.refresh(bundle);
        if self.bonds.is_empty() {
            return;
        }
        let watched = Some((criterion, self.generation));
        if self.watch.of != watched {
            self.watch.of = watched;
            self.set_limits(bundle, criterion);
        }
        self.fill_places(state);
        let Watch {
            limits, demands, ..
        } = &mut self.watch;
        let pressed = match criterion {
            BondCriterion::Potential { .. } => 1.0,
            _ => 0.0,
        };
        self.bonds
            .demands(self.level, &self.position, limits, pressed, demands);
        for (k, eight) in demands.iter().enumerate() {
            // What is no number is looked at, too.
            if eight.0.iter().all(|d| *d < SUSPECT) {
                continue;
            }
            for (l, demand) in eight.0.iter().enumerate() {
                if demand.is_nan() || *demand >= SUSPECT {
                    found.extend(self.bonds.bond(k * WIDTH + l));
                }
            }
        }
        found.sort_unstable();
    }

    fn set_limits(&mut self, bundle: &Bundle, criterion: BondCriterion) {
        let b = &bundle.bonds;
        let count = self.bonds.len() / WIDTH;
        self.watch.limits = vec![Limits::NONE; count];
        self.watch.demands = vec![Demands([0.0; WIDTH]); count];
        for place in 0..self.bonds.len() {
            let Some(bond) = self.bonds.bond(place) else {
                continue;
            };
            let i = bond as usize;
            // Energies are ½ k ε² d₀ and S γ².
            let energies = [0.5 * b.transverse[i] * b.distance[i], b.shear[i]];
            let [opening, shearing] = match criterion {
                BondCriterion::Never => [0.0; 2],
                BondCriterion::Potential {
                    threshold,
                    shear_weight,
                } => [
                    (1.0 - shear_weight) * energies[0] / threshold,
                    shear_weight * energies[1] / threshold,
                ],
                BondCriterion::Griffith => energies.map(|e| e / b.fracture_energy[i]),
                BondCriterion::Stress => {
                    let across = b.transverse[i] / b.tension_strength[i];
                    let along = 2.0 * b.shear[i] / b.distance[i] / b.shear_strength[i];
                    [across * across, along * along]
                }
            };
            let limits = &mut self.watch.limits[place / WIDTH];
            limits.opening[place % WIDTH] = opening;
            limits.shearing[place % WIDTH] = shearing;
        }
    }
}
