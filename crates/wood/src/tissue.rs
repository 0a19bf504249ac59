//! Tissue: pith, heartwood, sapwood, phloem and bark of a section (Yang 2019, section 3.2), and where bark begins.

use serde::{Deserialize, Serialize};

/// Ring coordinate at which the outer bark begins where its relief is not measured.
pub const BARK_START: f64 = 0.94;
/// Least ring coordinate at which bark may begin: relief deeper than that cuts into the wood.
pub const MIN_BARK_START: f64 = 0.88;
/// Greatest ring coordinate at which bark may begin: smooth bark is no thinner than this leaves it.
pub const MAX_BARK_START: f64 = 0.96;

/// A tissue of the cross-section, from the inside out. The paper calls them tissue zones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zone {
    /// The soft core.
    Pith,
    /// Dead, often darker wood around the pith.
    Heartwood,
    /// Wood with living cells, between heartwood and cambium.
    Sapwood,
    /// Inner bark.
    Phloem,
    /// Outer bark.
    Bark,
}

impl Zone {
    /// All zones from the inside out; the index of each is its [`Zone::code`].
    pub const ALL: [Zone; 5] = [
        Zone::Pith,
        Zone::Heartwood,
        Zone::Sapwood,
        Zone::Phloem,
        Zone::Bark,
    ];

    /// The number that stands for the zone in mesh attributes: 0 pith … 4 bark.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The zone of a [`Zone::code`]; `None` above 4.
    pub fn from_code(code: u8) -> Option<Zone> {
        Zone::ALL.get(usize::from(code)).copied()
    }

    /// Lower-case English name.
    pub const fn name(self) -> &'static str {
        match self {
            Zone::Pith => "pith",
            Zone::Heartwood => "heartwood",
            Zone::Sapwood => "sapwood",
            Zone::Phloem => "phloem",
            Zone::Bark => "bark",
        }
    }
}

impl std::fmt::Display for Zone {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// The part of the section's radius that each tissue takes. Sapwood takes the rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Proportions {
    /// ν_pith, a part of the radius in 0..=1.
    pub pith: f64,
    /// ν_heartwood, a part of the radius in 0..=1.
    pub heartwood: f64,
    /// ν_phloem, a part of the radius in 0..=1.
    pub phloem: f64,
}

impl Proportions {
    /// Those of a branch where nothing else is known.
    pub const USUAL: Proportions = Proportions {
        pith: 0.05,
        heartwood: 0.4,
        phloem: 0.05,
    };

    /// The zone of ring `ring` of `rings`, counted from 1 at the pith to `rings` at the outside, by
    /// the inequalities of section 3.2. The outermost ring is bark whatever the proportions; a ring
    /// beyond it is bark too.
    pub fn zone_of_ring(&self, ring: u32, rings: u32) -> Zone {
        if ring >= rings {
            return Zone::Bark;
        }
        self.inner_zone(f64::from(ring) / f64::from(rings))
    }

    /// The zone at ring coordinate `rho` (0 at the pith, 1 at the outside) when bark takes the
    /// outer `bark` part of the radius. Section 3.2 has one ring of bark: pass 1/N_ring for the
    /// same boundary.
    pub fn zone_at(&self, rho: f64, bark: f64) -> Zone {
        if rho >= 1.0 || rho > 1.0 - bark {
            Zone::Bark
        } else {
            self.inner_zone(rho)
        }
    }

    fn inner_zone(&self, rho: f64) -> Zone {
        // 12 of 40 rings must lie within a proportion of 0.3, whatever 12/40 and 0.3 round to.
        const ROUNDING: f64 = 1e-12;
        if rho <= self.pith + ROUNDING {
            Zone::Pith
        } else if rho <= self.pith + self.heartwood + ROUNDING {
            Zone::Heartwood
        } else if rho <= 1.0 - self.phloem + ROUNDING {
            Zone::Sapwood
        } else {
            Zone::Phloem
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_of_figure_19_fall_into_the_zones_of_section_3_2() {
        let p = Proportions {
            pith: 0.05,
            heartwood: 0.3,
            phloem: 0.1,
        };
        let count = |zone| (1..=40).filter(|&r| p.zone_of_ring(r, 40) == zone).count();
        // 40 × 0.05 = 2, 40 × 0.35 = 14, 40 × 0.9 = 36, and ring 40 is bark.
        assert_eq!(Zone::ALL.map(count), [2, 12, 22, 3, 1]);
    }

    #[test]
    fn continuous_zone_agrees_with_rings_at_every_ring() {
        let p = Proportions {
            pith: 0.05,
            heartwood: 0.45,
            phloem: 0.125,
        };
        for ring in 1..=100 {
            let rho = f64::from(ring) / 100.0;
            // Half a ring of bark puts only the last ring's own coordinate in the bark.
            assert_eq!(
                p.zone_at(rho, 0.005),
                p.zone_of_ring(ring, 100),
                "ring {ring}"
            );
        }
        assert_eq!(p.zone_at(0.0, 0.0), Zone::Pith);
    }

    #[test]
    fn codes_and_names_are_those_of_all() {
        for (code, zone) in (0u8..).zip(Zone::ALL) {
            assert_eq!((zone.code(), Zone::from_code(code)), (code, Some(zone)));
        }
        assert_eq!(Zone::from_code(5), None);
    }
}
