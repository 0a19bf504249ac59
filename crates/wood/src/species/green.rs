//! Estimates of green wood for the species whose green properties are in no table here.
//!
//! The tables have 27 species both dry and green, 6 hardwoods and 21 softwoods. Within a group the ratio of the green to the
//! dry value scatters little, so that the group's mean ratio (the geometric mean, as errors are relative) times the dry value
//! is a fair estimate. Its error is found by leaving each of the species out in turn: predicting it from the mean of the
//! others, root mean square of the logarithms. It holds for species like those of the tables, which are North American.

use super::record::{Group, MechanicalProperties, Property, Species};
use std::sync::LazyLock;

/// The ratio of green to dry wood of a group's species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreenRatio {
    /// Geometric mean of the green over the 12 % value.
    pub ratio: f64,
    /// Leave-one-out error of the estimate, relative: 0.07 is 7 %.
    pub error: f64,
    /// Species that are known dry and green.
    pub species: usize,
}

/// The ratios of a group: specific gravity first, then [`Property::ALL`].
type GroupRatios = [Option<GreenRatio>; 1 + Property::ALL.len()];

static RATIOS: LazyLock<[GroupRatios; 2]> = LazyLock::new(|| {
    [Group::Hardwood, Group::Softwood].map(|group| {
        let members: Vec<&Species> = (Species::all().iter())
            .filter(|s| s.group == group && s.green.is_some())
            .collect();
        std::array::from_fn(|column| {
            let value = |p: &MechanicalProperties| match column.checked_sub(1) {
                None => p.specific_gravity,
                Some(k) => p.get(Property::ALL[k]),
            };
            let logarithm = |s: &&Species| Some((value(s.green.as_ref()?)? / value(&s.dry)?).ln());
            let logarithms: Vec<f64> = members.iter().filter_map(logarithm).collect();
            GreenRatio::from_logarithms(&logarithms)
        })
    })
});

impl GreenRatio {
    /// Returns the mean of ratios, given their natural logarithms, and its leave-one-out error. `None` of fewer than three.
    fn from_logarithms(logarithms: &[f64]) -> Option<Self> {
        let count = logarithms.len();
        if count < 3 {
            return None;
        }
        let mean = logarithms.iter().sum::<f64>() / count as f64;
        // The mean of the others misses a value by n/(n − 1) of the value's distance from the mean of all.
        let enlargement = count as f64 / (count - 1) as f64;
        let squares: f64 = logarithms.iter().map(|x| (x - mean).powi(2)).sum();
        Some(GreenRatio {
            ratio: libm::exp(mean),
            error: enlargement * (squares / count as f64).sqrt(),
            species: count,
        })
    }

    /// The ratio of a property in a group; `None` where fewer than three species of the group are known dry and green.
    pub fn of_property(group: Group, property: Property) -> Option<GreenRatio> {
        let column = Property::ALL.iter().position(|p| *p == property)?;
        RATIOS[group as usize][1 + column]
    }

    /// The ratio of specific gravity, whose volume is that of the green wood, in a group.
    pub fn of_specific_gravity(group: Group) -> Option<GreenRatio> {
        RATIOS[group as usize][0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_those_of_the_table_computed_elsewhere() {
        // By numpy from the same file: geometric mean of the ratios, and the root mean square of log errors in a loop that
        // leaves each species out.
        for (group, property, ratio, error, species) in [
            (Group::Hardwood, Property::ModulusOfRupture, 0.597, 0.073, 6),
            (
                Group::Softwood,
                Property::ModulusOfRupture,
                0.586,
                0.075,
                21,
            ),
            (
                Group::Softwood,
                Property::ModulusOfElasticity,
                0.802,
                0.034,
                21,
            ),
            (
                Group::Hardwood,
                Property::CompressionParallel,
                0.502,
                0.050,
                6,
            ),
            (
                Group::Softwood,
                Property::TensionPerpendicular,
                0.836,
                0.179,
                16,
            ),
        ] {
            let got = GreenRatio::of_property(group, property).unwrap();
            assert_eq!(got.species, species, "{group:?} {property}");
            assert!((got.ratio - ratio).abs() < 5.1e-4, "{property}: {got:?}");
            assert!((got.error - error).abs() < 5.1e-4, "{property}: {got:?}");
        }
        let gravity = GreenRatio::of_specific_gravity(Group::Hardwood).unwrap();
        assert!((gravity.ratio - 0.911).abs() < 5.1e-4, "{gravity:?}");
    }

    #[test]
    fn one_of_two_known_species_is_no_spread() {
        assert!(GreenRatio::from_logarithms(&[-0.5, -0.6]).is_none());
        // Equal ratios leave no error.
        let equal = GreenRatio::from_logarithms(&[-0.5; 4]).unwrap();
        assert_eq!(equal.error, 0.0);
        assert!((equal.ratio - (-0.5f64).exp()).abs() < 1e-15);
    }
}
