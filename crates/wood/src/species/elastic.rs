//! The nine elastic constants of a species' wood (Wood Handbook, Tables 5-1 and 5-2).

use super::record::{ElasticRow, Group, Property, Species};
use super::table;
use crate::moisture::{Adjusted, Basis, Fallback, MoistureError};
use std::sync::LazyLock;

/// The true modulus along the grain over that of bending tests, whose deflection is partly shear (Wood Handbook, chapter 5:
/// "increased by 10 percent").
const TRUE_OVER_BENDING_MODULUS: f64 = 1.1;

/// Elastic constants of wood as an orthotropic solid with the axes L (along the grain), R (across the rings) and T (along
/// them). `ν_LR` is the contraction along R over the stretch along L under a stress along L.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngineeringConstants {
    /// Moduli E_L, E_R, E_T, Pa.
    pub moduli: [f64; 3],
    /// Poisson's ratios ν_LR, ν_LT, ν_RT.
    pub poisson: [f64; 3],
    /// Shear moduli G_LR, G_LT, G_RT, Pa.
    pub shear: [f64; 3],
    /// Whether all ratios are the species' own; the mean of hardwoods or of softwoods stands for others.
    pub own_ratios: bool,
    /// Where the modulus along the grain comes from.
    pub basis: Basis,
}

static ROWS: LazyLock<Vec<ElasticRow>> = LazyLock::new(table::read_elastic);

/// Mean of a column over the species of a group that have it.
fn group_mean(group: Group, column: usize) -> f64 {
    let of_group = ROWS.iter().filter(|r| r.group == group);
    let known: Vec<f64> = of_group.filter_map(|r| r.ratios[column]).collect();
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

/// The row of a species; that of its kind where the table does not tell its varieties apart.
fn row(species: &Species) -> Option<&'static ElasticRow> {
    let named = |name: &str| ROWS.iter().find(|r| r.name.eq_ignore_ascii_case(name));
    named(&species.name).or_else(|| named(species.name.split(',').next()?))
}

impl Species {
    /// Returns the elastic constants at `moisture` percent: the modulus of bending tests there, raised by 10 % for their
    /// shear, times the ratios at 12 %.
    ///
    /// ```
    /// use greenstick_wood::moisture::Fallback;
    /// use greenstick_wood::species::Species;
    ///
    /// let spruce = Species::find("Sitka spruce")?.engineering_constants(12.0, Fallback::Refuse)?;
    /// assert!(spruce.own_ratios && spruce.poisson == [0.372, 0.467, 0.435]);
    /// assert!((spruce.moduli[1] / spruce.moduli[0] - 0.078).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MoistureError`] where the modulus is not known there.
    pub fn engineering_constants(
        &self,
        moisture: f64,
        fallback: Fallback,
    ) -> Result<EngineeringConstants, MoistureError> {
        let Adjusted { value, basis } =
            self.property_at(Property::ModulusOfElasticity, moisture, fallback)?;
        let longitudinal = TRUE_OVER_BENDING_MODULUS * value;
        let own = row(self).map_or([None; 8], |r| r.ratios);
        let [er, et, glr, glt, grt, lr, lt, rt] =
            std::array::from_fn(|k| own[k].unwrap_or_else(|| group_mean(self.group, k)));
        Ok(EngineeringConstants {
            moduli: [1.0, er, et].map(|ratio| ratio * longitudinal),
            poisson: [lr, lt, rt],
            shear: [glr, glt, grt].map(|ratio| ratio * longitudinal),
            own_ratios: own.iter().all(Option::is_some),
            basis,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_the_groups_are_those_of_the_table() {
        // Means of the columns of Table 5-1 without balsa, as bonded rods take them.
        let means = |group| [0, 1, 2, 3].map(|k| (1000.0 * group_mean(group, k)).round());
        assert_eq!(means(Group::Hardwood), [119.0, 60.0, 92.0, 69.0]);
        assert_eq!(means(Group::Softwood), [96.0, 57.0, 82.0, 77.0]);
    }

    #[test]
    fn every_species_is_stable() {
        for species in Species::all() {
            let Ok(wood) = species.engineering_constants(12.0, Fallback::Refuse) else {
                continue;
            };
            let ([el, er, et], [lr, lt, rt]) = (wood.moduli, wood.poisson);
            // The compliances of a stable solid are positive definite: so are the leading minors.
            let (a, b, c) = (1.0 / el, 1.0 / er, 1.0 / et);
            let (x, y, z) = (-lr / el, -lt / el, -rt / er);
            assert!(a * b - x * x > 0.0, "{}", species.name);
            let determinant = a * (b * c - z * z) - x * (x * c - z * y) + y * (x * z - b * y);
            assert!(determinant > 0.0, "{}", species.name);
            assert!(
                er.max(et) < 0.3 * el && wood.shear[2] < wood.shear[0],
                "{}",
                species.name
            );
        }
        let pine = Species::find("Douglas-fir, coast").unwrap();
        let pine = pine.engineering_constants(12.0, Fallback::Refuse).unwrap();
        assert!(pine.own_ratios && pine.poisson[2] == 0.390);
    }
}
