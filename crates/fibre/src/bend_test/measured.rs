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

/// Fewer pairs have no correlation.
const MIN_SPECIMENS: usize = 3;

/// Too few specimens to speak of scatter.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{name}: {found} rows have density and modulus of rupture; expected at least {MIN_SPECIMENS}"
)]
pub struct TooFewSpecimens {
    /// Where they come from.
    pub name: String,
    /// Number of rows with both.
    pub found: usize,
}

impl MeasuredSpecimens {
    /// Returns specimens from rows of density (kg/m³) and modulus of rupture (Pa). Rows without one of both are counted and left
    /// out.
    ///
    /// # Errors
    /// [`TooFewSpecimens`].
    pub fn from_rows(source: &str, rows: &[[Option<f64>; 2]]) -> Result<Self, TooFewSpecimens> {
        let pair = |[density, rupture]: &[Option<f64>; 2]| density.zip(*rupture);
        let (density, modulus_of_rupture): (Vec<f64>, Vec<f64>) =
            rows.iter().filter_map(pair).unzip();
        let found = density.len();
        if found < MIN_SPECIMENS {
            return Err(TooFewSpecimens {
                name: source.to_owned(),
                found,
            });
        }
        Ok(MeasuredSpecimens {
            source: source.to_owned(),
            incomplete: rows.len() - found,
            density,
            modulus_of_rupture,
        })
    }

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
