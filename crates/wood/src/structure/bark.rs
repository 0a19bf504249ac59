//! Bark: phloem and outer bark, which are no wood.
//!
//! Measured bark is 6 to 14 % denser than the wood of beech, hornbeam, oak, ash, poplar and fir, and its hardness is 2.3 to
//! 6.6 times lower, phloem and outer bark apart (*Drvna industrija* 51 (2000), no. 3, on bark properties of several
//! species); the bark of southern pines is a tenth lighter than their wood (Manwiller, *Wood and bark properties of spruce
//! pine*, US Forest Service: 0.37 to 0.39 against 0.41 to 0.44). Hardness stands for strength here: the phloem, with its
//! fibres, has the wood's over 2.3, the outer bark over 6.6. The modulus along the grain is a tenth of the wood's or less,
//! so that bark adds little to a stem's stiffness (Niklas, *American Journal of Botany* 86 (1999) 465; Onoda et al., *New
//! Phytologist* 185 (2010) 493), and it stretches farther than wood before it tears.

use crate::species::Group;
use crate::tissue::Zone;

/// A tissue of the bark, relative to the wood of its species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarkTissue {
    /// Density.
    pub density: f64,
    /// All moduli.
    pub modulus: f64,
    /// All strengths.
    pub strength: f64,
}

impl BarkTissue {
    /// The bark tissue of a zone; `None` for wood.
    pub fn of_zone(zone: Zone, group: Group) -> Option<Self> {
        let density = match group {
            Group::Hardwood => 1.1,
            Group::Softwood => 0.9,
        };
        match zone {
            Zone::Phloem => Some(BarkTissue {
                density,
                modulus: 0.1,
                strength: 1.0 / 2.3,
            }),
            Zone::Bark => Some(BarkTissue {
                density,
                modulus: 0.05,
                strength: 1.0 / 6.6,
            }),
            _ => None,
        }
    }
}
