//! A fast filter for the bonds that may fail.

use crate::energy::bond::BondSpring;
use crate::failure::cohesion::least_onset;
use crate::failure::criteria::BondCriterion;
use crate::rod_bundle::RodBundle;
use crate::simd::SimdLevel;
use crate::simd::bond_demands::{DemandFactors, Demands};
use crate::simd::bonds::BondTable;
use crate::simd::lanes::WIDTH;
use crate::simd::places::Places;

/// Demand from which a bond is checked exactly: below 1 by far more than rounding.
const SUSPICIOUS_DEMAND: f64 = 1.0 - 1e-6;

/// The factors of a criterion for all bonds, and the demands found last.
#[derive(Debug, Clone, Default)]
pub(super) struct BondFilter {
    /// The criterion, and the bundle's generation, that the factors are for.
    source: Option<(BondCriterion, u64)>,
    factors: Vec<DemandFactors>,
    demands: Vec<Demands>,
}

impl BondFilter {
    /// Derives the factors for a criterion where they are not those of now.
    pub(super) fn refresh(
        &mut self,
        table: &BondTable,
        bundle: &RodBundle,
        criterion: BondCriterion,
    ) {
        let source = Some((criterion, bundle.generation));
        if self.source != source {
            self.source = source;
            self.set_factors(table, bundle, criterion);
        }
    }

    fn set_factors(&mut self, table: &BondTable, bundle: &RodBundle, criterion: BondCriterion) {
        let b = &bundle.bonds;
        let count = table.len() / WIDTH;
        self.factors = vec![DemandFactors::ZERO; count];
        self.demands = vec![Demands([0.0; WIDTH]); count];
        for entry in 0..table.len() {
            let Some(bond) = table.bond(entry) else {
                continue;
            };
            let i = bond as usize;
            let spring = BondSpring::intact(bundle, i);
            let energies = [0.5 * spring.opening, 0.5 * spring.slip];
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
                    let across = spring.opening / b.tension_strength[i];
                    let along = spring.slip / b.shear_strength[i];
                    [across * across, along * along]
                }
                BondCriterion::Cohesive => {
                    let onset = least_onset(bundle, i);
                    let across = spring.opening / (b.tension_strength[i] * onset);
                    let along = spring.slip / (b.shear_strength[i] * onset);
                    [across * across, along * along]
                }
            };
            let factors = &mut self.factors[entry / WIDTH];
            factors.opening[entry % WIDTH] = opening;
            factors.shearing[entry % WIDTH] = shearing;
        }
    }

    /// Adds to `found` the bonds that may fail, ascending: all that do, and few others. `criterion` is that of the last
    /// [`BondFilter::refresh`].
    pub(super) fn suspects(
        &mut self,
        table: &BondTable,
        level: SimdLevel,
        places: &Places,
        criterion: BondCriterion,
        found: &mut Vec<u32>,
    ) {
        let in_compression = match criterion {
            BondCriterion::Potential { .. } => 1.0,
            _ => 0.0,
        };
        let demands = &mut self.demands;
        table.demands(level, places, &self.factors, in_compression, demands);
        for (k, eight) in demands.iter().enumerate() {
            // NaN must not pass unchecked.
            if eight.0.iter().all(|d| *d < SUSPICIOUS_DEMAND) {
                continue;
            }
            for (l, demand) in eight.0.iter().enumerate() {
                if demand.is_nan() || *demand >= SUSPICIOUS_DEMAND {
                    found.extend(table.bond(k * WIDTH + l));
                }
            }
        }
        found.sort_unstable();
    }
}
