//! Specimens that somebody measured, to set beside simulated ones.

use super::statistics::{Correlation, Statistics};
use serde::Serialize;

/// Density and modulus of rupture of specimens, pair by pair.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredSpecimens {
    /// Where they come from, such as the name of a file.
    pub source: String,
    /// Density, kg/m³.
    pub density: Vec<f64>,
    /// Modulus of rupture, Pa.
    pub modulus_of_rupture: Vec<f64>,
    /// Rows of the source without one of both.
    pub incomplete: usize,
}

/// Measured specimens in numbers. Names end with the unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredSummary {
    /// Where they come from.
    pub source: String,
    /// Rows of the source without density or modulus of rupture, which were left out.
    pub incomplete: usize,
    /// Density, kg/m³.
    pub density_kg_per_m3: Option<Statistics>,
    /// Modulus of rupture, Pa.
    pub modulus_of_rupture_pa: Option<Statistics>,
    /// Correlation of the modulus of rupture with density.
    pub rupture_with_density: Option<Correlation>,
}

impl MeasuredSpecimens {
    /// Returns them in numbers.
    pub fn summary(&self) -> MeasuredSummary {
        MeasuredSummary {
            source: self.source.clone(),
            incomplete: self.incomplete,
            density_kg_per_m3: Statistics::new(&self.density),
            modulus_of_rupture_pa: Statistics::new(&self.modulus_of_rupture),
            rupture_with_density: Correlation::new(&self.density, &self.modulus_of_rupture),
        }
    }
}
