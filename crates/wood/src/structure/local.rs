//! Tissue, density, stiffness and strength at a place of a section.

use super::bark::BarkTissue;
use super::density::RingDensity;
use super::grain::GrainAngles;
use super::juvenile::JuvenileWood;
use crate::appearance::WoodAppearance;
use crate::rings::{RingPart, StemAddress, StemRings};
use crate::species::{Group, Species};
use crate::tissue::Zone;

/// Strength across the grain grows with this power of density: tension, of hardwoods and of softwoods (Wood Handbook,
/// Table 5-11, at 12 % moisture).
const TENSION_ACROSS_EXPONENT: [f64; 2] = [1.30, 1.11];
/// The same of shear along the grain.
const SHEAR_EXPONENT: [f64; 2] = [1.13, 0.85];
/// Strength of a plane along rays over that of one along rings: rays reinforce wood across rings, and tensile strength is 1.4
/// times as large there (Gibson and Ashby, *Cellular Solids*, 2nd ed., chapter 10).
const RAY_PLANE_STRENGTH: f64 = 1.0 / 1.4;

/// The ring coordinates at which tissues end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TissueBoundaries {
    /// Edge of the pith.
    pub pith: f64,
    /// Edge of the heartwood; 0 for none.
    pub heartwood: f64,
    /// Where wood ends and phloem begins; above 1 for none.
    pub phloem: f64,
    /// Where outer bark begins; above 1 for none.
    pub bark: f64,
}

impl From<&WoodAppearance> for TissueBoundaries {
    /// The boundaries that the wood shows.
    fn from(wood: &WoodAppearance) -> Self {
        TissueBoundaries {
            pith: wood.pith,
            heartwood: wood.heartwood,
            phloem: wood.phloem,
            bark: wood.cork,
        }
    }
}

impl TissueBoundaries {
    /// Mature sapwood from edge to edge, as in a clear specimen.
    pub const SAPWOOD: TissueBoundaries = TissueBoundaries {
        pith: 0.0,
        heartwood: 0.0,
        phloem: 2.0,
        bark: 2.0,
    };

    /// Returns the tissue at a ring coordinate.
    pub fn tissue(&self, rho: f64) -> Zone {
        if rho > self.bark {
            Zone::Bark
        } else if rho > self.phloem {
            Zone::Phloem
        } else if rho <= self.pith {
            Zone::Pith
        } else if rho <= self.heartwood {
            Zone::Heartwood
        } else {
            Zone::Sapwood
        }
    }
}

/// What there is at a place, relative to the mean of the species' wood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalWood {
    /// Tissue.
    pub tissue: Zone,
    /// Annual ring, from 1 at the pith.
    pub ring: i64,
    /// Earlywood or latewood.
    pub part: RingPart,
    /// Mass per volume with its water.
    pub density: f64,
    /// Modulus of elasticity along the grain.
    pub modulus: f64,
    /// Tensile and crushing strength along the grain.
    pub strength: f64,
    /// Moduli across the grain and in shear.
    pub modulus_across: f64,
    /// Tensile strength across the grain, and fracture energy.
    pub tension_across: f64,
    /// Shear strength along the grain.
    pub shear: f64,
}

impl LocalWood {
    /// Whether it is wood, and no bark.
    pub fn is_wood(&self) -> bool {
        !matches!(self.tissue, Zone::Phloem | Zone::Bark)
    }
}

/// The structure of a stem's wood.
///
/// Along the grain, stiffness and strength are in proportion to density (Gibson and Ashby, *Cellular Solids*, 2nd ed.,
/// chapter 10: cell walls are stretched, and there are as many as the density says). Across it they follow the power laws
/// of Wood Handbook Table 5-11. The pith counts as juvenile wood.
///
/// ```
/// use glam::DVec2;
/// use greenstick_wood::rings::{ConcentricRings, StemAddress, StemRings};
/// use greenstick_wood::species::Species;
/// use greenstick_wood::structure::{TissueBoundaries, WoodStructure};
/// use greenstick_wood::tissue::{Proportions, Zone};
///
/// let tissue = Proportions { pith: 0.05, heartwood: 0.4, phloem: 0.05 };
/// let rings = StemRings::new(ConcentricRings::even(30, &tissue));
/// let boundaries = TissueBoundaries { pith: 0.05, heartwood: 0.45, phloem: 0.89, bark: 0.94 };
/// let structure = WoodStructure::new(Species::find("Douglas-fir, coast")?, 12.0, rings, boundaries);
/// let at = |rho| {
///     let across = DVec2::X * (0.1 * rho);
///     structure.at(&StemAddress { rho, angle: 0.0, across, along: 0.0 }).expect("a point of the stem")
/// };
/// assert!(at(0.02).modulus < 0.6 * at(0.8).modulus); // juvenile
/// assert_eq!(at(0.97).tissue, Zone::Bark);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct WoodStructure {
    rings: StemRings,
    boundaries: TissueBoundaries,
    group: Group,
    density: RingDensity,
    juvenile: Option<JuvenileWood>,
    /// Mass of heartwood and of sapwood with their water over that at mean moisture.
    wetness: [f64; 2],
    ring_plane_strength: Option<f64>,
    ray_plane_strength: f64,
    grain: GrainAngles,
}

impl WoodStructure {
    /// The structure of a species' wood at `moisture` percent.
    pub fn new(
        species: &Species,
        moisture: f64,
        rings: StemRings,
        boundaries: TissueBoundaries,
    ) -> Self {
        WoodStructure {
            rings,
            boundaries,
            group: species.group,
            density: RingDensity::new(species),
            juvenile: Some(JuvenileWood::of_group(species.group)),
            wetness: wetness(species, moisture, &boundaries),
            ring_plane_strength: None,
            ray_plane_strength: RAY_PLANE_STRENGTH,
            grain: GrainAngles::default(),
        }
    }

    /// The same without juvenile wood: a clear specimen that was not cut from the core.
    #[must_use]
    pub fn mature(mut self) -> Self {
        self.juvenile = None;
        self
    }

    /// The same with other strengths of weak planes, relative to the mean across the grain: along ring boundaries (that of
    /// earlywood where `None`) and along rays (1/1.4 where `None`).
    #[must_use]
    pub fn with_planes(mut self, ring: Option<f64>, ray: Option<f64>) -> Self {
        self.ring_plane_strength = ring;
        self.ray_plane_strength = ray.unwrap_or(RAY_PLANE_STRENGTH);
        self
    }

    /// The same with grain that is not along the stem.
    #[must_use]
    pub fn with_grain(mut self, grain: GrainAngles) -> Self {
        self.grain = grain;
        self
    }

    /// The angles of its grain.
    pub fn grain(&self) -> &GrainAngles {
        &self.grain
    }

    /// Its annual rings.
    pub fn rings(&self) -> &StemRings {
        &self.rings
    }

    /// Mean width of a ring, in ring coordinates.
    pub fn mean_ring_width(&self) -> f64 {
        1.0 / self.rings.ring_count().max(1) as f64
    }

    /// Returns what there is at an address; `None` outside the stem.
    pub fn at(&self, address: &StemAddress) -> Option<LocalWood> {
        let position = self.rings.ring_at(address)?;
        let tissue = self.boundaries.tissue(address.rho);
        let (ring, part) = (position.ring, position.part);
        if let Some(bark) = BarkTissue::of_zone(tissue, self.group) {
            return Some(LocalWood {
                tissue,
                ring,
                part,
                density: bark.density,
                modulus: bark.modulus,
                strength: bark.strength,
                modulus_across: bark.modulus,
                tension_across: bark.strength,
                shear: bark.strength,
            });
        }
        let width = position.width / self.mean_ring_width();
        let own = self.density.relative(part, width);
        let [density, modulus, strength] = match &self.juvenile {
            None => [1.0; 3],
            Some(j) => [j.density, j.modulus, j.strength].map(|first| j.value(first, ring)),
        };
        let wetness = match tissue {
            Zone::Sapwood => self.wetness[1],
            _ => self.wetness[0],
        };
        Some(LocalWood {
            tissue,
            ring,
            part,
            density: own * density * wetness,
            modulus: own * modulus,
            strength: own * strength,
            modulus_across: own * density,
            tension_across: libm::pow(own * density, self.exponent(TENSION_ACROSS_EXPONENT)),
            shear: libm::pow(own * density, self.exponent(SHEAR_EXPONENT)),
        })
    }

    fn exponent(&self, [hardwood, softwood]: [f64; 2]) -> f64 {
        match self.group {
            Group::Hardwood => hardwood,
            Group::Softwood => softwood,
        }
    }

    /// Strength of a ring boundary relative to the mean across the grain, in tension and in shear: that of the earlywood
    /// that begins there.
    pub fn ring_plane(&self) -> [f64; 2] {
        if let Some(strength) = self.ring_plane_strength {
            return [strength; 2];
        }
        let earlywood = self.density.relative(RingPart::Earlywood, 1.0);
        [TENSION_ACROSS_EXPONENT, SHEAR_EXPONENT]
            .map(|exponents| libm::pow(earlywood, self.exponent(exponents)))
    }

    /// Strength of a plane along rays over that of one along rings.
    pub fn ray_plane(&self) -> f64 {
        self.ray_plane_strength
    }
}

/// Mass of heartwood and of sapwood at `moisture` percent over that of wood of this moisture throughout. Only green wood
/// differs: Table 4-1 of the Wood Handbook has both moistures, and their ratio is kept with the mean as given.
fn wetness(species: &Species, moisture: f64, tissues: &TissueBoundaries) -> [f64; 2] {
    let (Some(heartwood), Some(sapwood)) = (
        species.green_heartwood_percent,
        species.green_sapwood_percent,
    ) else {
        return [1.0; 2];
    };
    if moisture < species.intersection_percent() {
        return [1.0; 2];
    }
    let wood = tissues.phloem.min(1.0);
    let inner = (tissues.heartwood.max(tissues.pith) / wood).powi(2);
    let mean = inner * heartwood + (1.0 - inner) * sapwood;
    [heartwood, sapwood].map(|own| (1.0 + 0.01 * moisture * own / mean) / (1.0 + 0.01 * moisture))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rings::ConcentricRings;
    use crate::tissue::Proportions;
    use glam::DVec2;

    const TISSUES: TissueBoundaries = TissueBoundaries {
        pith: 0.05,
        heartwood: 0.45,
        phloem: 0.89,
        bark: 0.94,
    };

    fn structure(name: &str, moisture: f64) -> WoodStructure {
        let proportions = Proportions {
            pith: 0.05,
            heartwood: 0.4,
            phloem: 0.05,
        };
        let rings = StemRings::new(ConcentricRings::even(40, &proportions));
        WoodStructure::new(Species::find(name).unwrap(), moisture, rings, TISSUES)
    }

    fn at(structure: &WoodStructure, rho: f64) -> LocalWood {
        let address = StemAddress {
            rho,
            angle: 0.0,
            across: DVec2::X * rho,
            along: 0.0,
        };
        structure.at(&address).unwrap()
    }

    #[test]
    fn tissues_lie_where_the_wood_shows_them() {
        let s = structure("white oak", 12.0);
        let zones = [0.04, 0.3, 0.6, 0.91, 0.97].map(|rho| at(&s, rho).tissue);
        assert_eq!(zones, Zone::ALL);
    }

    #[test]
    fn latewood_is_stiff_and_strong_and_juvenile_wood_is_not() {
        let s = structure("Douglas-fir, coast", 12.0);
        // Rings are 0.025 wide, the last 0.3 of each latewood; ring 32 is mature.
        let (early, late) = (at(&s, 0.78), at(&s, 0.798));
        assert_eq!(
            (early.part, late.part),
            (RingPart::Earlywood, RingPart::Latewood)
        );
        for ratio in [
            late.density / early.density,
            late.modulus / early.modulus,
            late.strength / early.strength,
        ] {
            assert!((ratio - 2.5).abs() < 1e-9, "{ratio}");
        }
        let first = at(&s, 0.01);
        assert!((first.modulus / early.modulus - 0.5).abs() < 1e-9);
        assert!((first.strength / early.strength - 0.6).abs() < 1e-9);
        let mature = s.clone().mature();
        assert!((at(&mature, 0.01).modulus - early.modulus).abs() < 1e-12);
        // The boundary is as strong as the earlywood there.
        assert!((s.ring_plane()[0] - early.tension_across).abs() < 1e-12);
    }

    #[test]
    fn green_sapwood_is_heavy_where_the_table_has_its_moisture() {
        // Wood Handbook, Table 4-1, coast Douglas-fir: heartwood 37 %, sapwood 115 %.
        let s = structure("Douglas-fir, coast", 60.0);
        let dry = structure("Douglas-fir, coast", 12.0);
        let ratio = |rho: f64| at(&s, rho).density / at(&dry, rho).density;
        assert!(ratio(0.8) > 1.05 && ratio(0.3) < 0.8);
        // The mean moisture stays as given.
        let inner = (0.45f64 / 0.89).powi(2);
        let mean = inner * ratio(0.3) + (1.0 - inner) * ratio(0.8);
        assert!((mean - 1.0).abs() < 1e-12, "{mean}");
    }
}
