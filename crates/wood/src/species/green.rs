//! Estimates of green wood for the species whose green properties are in no table here.
//!
//! The tables have 27 species both dry and green, 6 hardwoods and 21 softwoods. Within a group the ratio of the green to the
//! dry value scatters little, so that the group's mean ratio (the geometric mean, as errors are relative) times the dry value
//! is a fair estimate. Its error is found by leaving each of the species out in turn: predicting it from the mean of the
//! others, root mean square of the logarithms. It holds for species like those of the tables, which are North American.
//!
//! Green modulus of rupture comes from the crushing strength at 12 %, not from its own dry value. In green wood the two
//! strengths are almost proportional: modulus of rupture over crushing strength is 2.33 in hardwoods and 2.07 in softwoods,
//! each missed by 3 or 4 % when it is predicted from the others, whereas dry wood has 1.6 to 2.1. Green wood yields in compression
//! long before it breaks, so that its bending strength is mostly crushing strength. Two ratios, each estimated by itself, would
//! give the woods with the highest dry ratio a green one of 2.9, near the 3 at which section analysis needs infinite tensile
//! strength.

use super::record::{Group, MechanicalProperties, Property, Species};
use std::sync::LazyLock;

/// The mean ratio of a green to a dry value in a group's species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreenRatio {
    /// Geometric mean of the green over the 12 % value.
    pub ratio: f64,
    /// Leave-one-out error of the estimate, relative: 0.07 is 7 %.
    pub error: f64,
    /// Species that are known dry and green.
    pub species: usize,
}

/// The ratios of a group.
#[derive(Debug)]
struct GroupRatios {
    specific_gravity: Option<GreenRatio>,
    /// Of [`Property::ALL`], green over dry.
    properties: [Option<GreenRatio>; Property::ALL.len()],
    /// Green modulus of rupture over dry crushing strength.
    rupture_to_crushing: Option<GreenRatio>,
}

static RATIOS: LazyLock<[GroupRatios; 2]> = LazyLock::new(|| {
    [Group::Hardwood, Group::Softwood].map(|group| GroupRatios {
        specific_gravity: GreenRatio::mean(group, |green, dry| {
            Some(green.specific_gravity? / dry.specific_gravity?)
        }),
        properties: Property::ALL.map(|property| {
            GreenRatio::mean(group, |green, dry| {
                Some(green.get(property)? / dry.get(property)?)
            })
        }),
        rupture_to_crushing: GreenRatio::mean(group, |green, dry| {
            Some(green.modulus_of_rupture? / dry.compression_parallel?)
        }),
    })
});

impl GreenRatio {
    /// Returns the mean of `ratio` of the green and the dry row over a group's species that have both values.
    fn mean(
        group: Group,
        ratio: impl Fn(&MechanicalProperties, &MechanicalProperties) -> Option<f64>,
    ) -> Option<Self> {
        let members = Species::all().iter().filter(|s| s.group == group);
        let logarithm = |s: &Species| Some(ratio(s.green.as_ref()?, &s.dry)?.ln());
        Self::from_logarithms(&members.filter_map(logarithm).collect::<Vec<f64>>())
    }

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

    /// The ratio of green to dry wood of a property in a group; `None` where fewer than three species of the group are known
    /// dry and green.
    pub fn of_property(group: Group, property: Property) -> Option<GreenRatio> {
        let column = Property::ALL.iter().position(|p| *p == property)?;
        RATIOS[group as usize].properties[column]
    }

    /// The ratio of specific gravity, whose volume is that of the green wood, in a group.
    pub fn of_specific_gravity(group: Group) -> Option<GreenRatio> {
        RATIOS[group as usize].specific_gravity
    }

    /// The ratio of green modulus of rupture to crushing strength at 12 % in a group.
    pub fn of_rupture_to_crushing(group: Group) -> Option<GreenRatio> {
        RATIOS[group as usize].rupture_to_crushing
    }
}

/// An estimate of a property of green wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreenEstimate {
    /// In the property's SI unit.
    pub value: f64,
    /// Leave-one-out error, relative.
    pub error: f64,
}

impl Species {
    /// Estimates a property of green wood from the species' row at 12 %; `None` where the row has no value, or too few species
    /// of the group are known dry and green.
    pub fn estimate_green(&self, property: Property) -> Option<GreenEstimate> {
        let crushing = (property == Property::ModulusOfRupture)
            .then_some(self.dry.compression_parallel)
            .flatten();
        let (dry, ratio) = match crushing {
            Some(crushing) => (crushing, GreenRatio::of_rupture_to_crushing(self.group)?),
            None => (
                self.dry.get(property)?,
                GreenRatio::of_property(self.group, property)?,
            ),
        };
        Some(GreenEstimate {
            value: ratio.ratio * dry,
            error: ratio.error,
        })
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
        for (group, ratio, error) in [
            (Group::Hardwood, 1.169, 0.0765),
            (Group::Softwood, 1.035, 0.047),
        ] {
            let got = GreenRatio::of_rupture_to_crushing(group).unwrap();
            assert!(
                (got.ratio - ratio).abs() < 5.1e-4 && (got.error - error).abs() < 5.1e-4,
                "{got:?}"
            );
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
