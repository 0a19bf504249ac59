//! Juvenile wood: the first years about the pith, with short cells, a large fibril angle and little latewood.
//!
//! Wood Handbook, chapter 5 ("Juvenile wood"): properties change over the first 5 to 20 rings, quickly at first, and are
//! those of mature wood from then on; stiffness is affected more than strength, and strength more than density. The
//! difference is larger in conifers than in hardwoods. The numbers are rounded and milder than those of fast-grown plantation
//! trees: there the juvenile wood as a whole has 0.47 to 0.63 of the mature properties in loblolly pine and 0.62 to 0.79 in
//! cottonwood, and it ends at ring 13 to 20 (Bendtsen and Senft, *Wood and Fiber Science* 18 (1986) 23, abstract); here the
//! mean over the juvenile rings is 0.75 (modulus) and 0.8 (strength) in conifers, 0.88 and 0.9 in hardwoods.

use crate::species::Group;

/// The wood of the first years, relative to mature wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JuvenileWood {
    /// Ring from which wood is mature, counted from 1 at the pith.
    pub transition_ring: f64,
    /// Density of the first ring.
    pub density: f64,
    /// Modulus of elasticity along the grain of the first ring.
    pub modulus: f64,
    /// Strength along the grain of the first ring.
    pub strength: f64,
}

impl JuvenileWood {
    /// The juvenile wood of hardwoods or of softwoods.
    pub const fn of_group(group: Group) -> Self {
        match group {
            Group::Softwood => JuvenileWood {
                transition_ring: 15.0,
                density: 0.85,
                modulus: 0.5,
                strength: 0.6,
            },
            Group::Hardwood => JuvenileWood {
                transition_ring: 10.0,
                density: 0.95,
                modulus: 0.75,
                strength: 0.8,
            },
        }
    }

    /// Returns how far ring `ring` (from 1 at the pith) is on its way to mature wood, 0 to 1.
    pub fn maturity(&self, ring: i64) -> f64 {
        ((ring as f64 - 1.0) / (self.transition_ring - 1.0)).clamp(0.0, 1.0)
    }

    /// Returns a value that is `first` in the first ring and 1 in mature wood.
    pub(super) fn value(&self, first: f64, ring: i64) -> f64 {
        first + (1.0 - first) * self.maturity(ring)
    }
}
