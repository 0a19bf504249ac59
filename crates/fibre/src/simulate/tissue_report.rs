//! Which tissues the rods of a stem lie in, and the values of each.

use crate::placement::PlacedRods;
use greenstick_wood::tissue::Zone;
use serde::Serialize;

/// The rods of a tissue: those of whose cell it takes the most.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TissueReport {
    /// Tissue.
    pub tissue: Zone,
    /// Number of rods.
    pub rods: usize,
    /// Part of all rods.
    pub rod_fraction: f64,
    /// Part of the section's area.
    pub area_fraction: f64,
    /// Mass per volume, kg/m³; this and what follows are means over the area.
    pub density_kg_m3: f64,
    /// Modulus of elasticity along the grain, Pa.
    pub modulus_pa: f64,
    /// Tensile strength along the grain, Pa.
    pub tension_pa: f64,
    /// Crushing strength along the grain, Pa.
    pub compression_pa: f64,
}

impl TissueReport {
    /// Returns the tissues of a stem's rods, from the inside out.
    pub(super) fn from_rods(placed: &PlacedRods) -> Vec<TissueReport> {
        let whole: f64 = placed.cells.iter().map(|c| c.area).sum();
        let of_zone = |zone: Zone| {
            let rods = || {
                let pairs = placed.wood.iter().zip(&placed.cells);
                pairs.filter(move |(wood, _)| wood.tissue == zone)
            };
            let (count, area) = rods().fold((0, 0.0), |(n, a), (_, cell)| (n + 1, a + cell.area));
            let mean = |value: fn(&crate::WoodMaterial) -> f64| {
                rods().fold(0.0, |sum, (wood, cell)| {
                    sum + value(&wood.material) * cell.area / area
                })
            };
            (count > 0).then(|| TissueReport {
                tissue: zone,
                rods: count,
                rod_fraction: count as f64 / placed.wood.len() as f64,
                area_fraction: area / whole,
                density_kg_m3: mean(|m| m.density),
                modulus_pa: mean(|m| m.longitudinal),
                tension_pa: mean(|m| m.tension),
                compression_pa: mean(|m| m.compression),
            })
        };
        Zone::ALL.into_iter().filter_map(of_zone).collect()
    }
}

impl std::fmt::Display for TissueReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:<10}{:>4.0} % of rods, {:.0} kg/m³, modulus {:.2} GPa, tension {:.1} MPa, crushing {:.1} MPa",
            self.tissue.name(),
            100.0 * self.rod_fraction,
            self.density_kg_m3,
            self.modulus_pa / 1e9,
            self.tension_pa / 1e6,
            self.compression_pa / 1e6
        )
    }
}
