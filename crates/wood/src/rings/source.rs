//! What the annual rings of a stem may come from: the interface of all ring sources.
//!
//! The shape of rings is one thing, how the years divide them another. [`super::RingField`] gives the shape: the ring
//! coordinate of every point. A [`RingSource`] divides it into years: those of a
//! tree that grew, even or measured widths ([`super::ConcentricRings`]), or the published erosion of a section's pixels
//! ([`crate::anatomy::SectionRaster`]). Whatever shows or uses rings asks a source.

use super::StemAddress;
use crate::tissue::Zone;
use serde::{Deserialize, Serialize};

/// The parts of an annual ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RingPart {
    /// The dense, dark outer part, which grows last.
    Latewood,
    /// The light inner part, which grows first.
    Earlywood,
}

/// Where a point lies among the annual rings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingPosition {
    /// Ring, counted from 1 at the pith. Sources whose rings wander may have numbers below 1 next to the pith.
    pub ring: i64,
    /// Place within the ring: 0 at its inner edge to 1 at its outer edge.
    pub fraction: f64,
    /// Width of the ring, in ring coordinates.
    pub width: f64,
    /// Earlywood or latewood.
    pub part: RingPart,
    /// Tissue.
    pub tissue: Zone,
}

/// A source of annual rings.
///
/// ```
/// use glam::DVec2;
/// use greenstick_wood::rings::{ConcentricRings, RingPart, RingSource, StemAddress};
/// use greenstick_wood::tissue::{Proportions, Zone};
///
/// let tissue = Proportions { pith: 0.05, heartwood: 0.4, phloem: 0.1 };
/// let rings: &dyn RingSource = &ConcentricRings::even(20, &tissue);
/// let at = StemAddress { rho: 0.623, angle: 0.0, across: DVec2::X * 0.03, along: 0.5 };
/// let position = rings.ring_at(&at).expect("a point of the stem");
/// assert_eq!((position.ring, position.part), (13, RingPart::Earlywood));
/// assert_eq!(position.tissue, Zone::Sapwood);
/// assert!((position.fraction - 0.46).abs() < 1e-9);
/// ```
pub trait RingSource {
    /// Number of rings between pith and bark.
    fn ring_count(&self) -> usize;

    /// Ring coordinates of the outer edge of each ring, from the pith; none where they differ from place to place.
    fn edges(&self) -> &[f64] {
        &[]
    }

    /// Where an address lies among the rings; `None` where there is no wood.
    fn ring_at(&self, at: &StemAddress) -> Option<RingPosition>;
}
