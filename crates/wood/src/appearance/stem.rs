//! The appearance of a whole stem: the species gives the wood its structure, the size of the stem its rings and its bark.

use super::{BarkAppearance, BarkKind, WoodAppearance};
use crate::noise::smoothstep;
use crate::rings::{RingField, StemRings};
use crate::species::{HeartwoodColour, RingCharacter, Species};
use crate::stem::Stem;
use crate::tissue::Proportions;
use glam::DVec3;

/// The appearance of a stem's wood and bark.
#[derive(Debug, Clone, PartialEq)]
pub struct StemAppearance {
    /// The wood inside.
    pub wood: WoodAppearance,
    /// Its annual rings.
    pub rings: StemRings,
    /// The bark.
    pub bark: BarkAppearance,
    /// Sections at the ends, whose tissues sawn ends show; without one an end shows those of the section at the location.
    pub ends: Vec<EndSection>,
}

/// The section at an end of a stem. A stem tapers, and its bark has furrows: the rings and the bark of an end follow the
/// outline there.
#[derive(Debug, Clone, PartialEq)]
pub struct EndSection {
    /// Its length along the axis, m.
    pub length: f64,
    /// Ring coordinate and angle in it.
    pub rings: RingField,
}

/// Width of an annual ring where nothing else is known, m.
const RING_WIDTH: f64 = 2.2e-3;
/// Fewest and most rings of a stem: fewer look like a target, more are finer than textures.
const RING_COUNT: (f64, f64) = (5.0, 60.0);
/// Most rings about the pith of sawn wood, which may be far off, so that only some of them are in the wood.
const SAWN_RING_COUNT: f64 = 250.0;
/// Radius above which bark is furrowed, m.
const FURROWED_BARK_RADIUS: f64 = 0.06;
/// How much darker the bottom of furrows is than the ridges, where the colour of the bark is given.
const FURROW_SHADE: f64 = 0.35;
/// How much darker heartwood is than sapwood in species whose heartwood is light.
const LIGHT_HEARTWOOD: f64 = 0.93;
/// Ring coordinates between which the outer bark may begin.
const CORK_START: (f64, f64) = (0.6, 0.99);
/// Least ring coordinate at which the inner bark begins.
const MIN_PHLOEM_START: f64 = 0.3;
/// A ring coordinate beyond all wood: the tissue is absent.
const ABSENT: f64 = 2.0;

impl StemAppearance {
    /// The appearance of `stem`, a softwood where no species is given.
    ///
    /// `wood` is what [`WoodAppearance::of_stem`] gives, and `rings` are the annual rings that the stem shows.
    pub fn new(stem: &Stem, wood: WoodAppearance, rings: StemRings) -> StemAppearance {
        let mut bark = if stem.radius > FURROWED_BARK_RADIUS {
            BarkAppearance::furrowed(stem.radius)
        } else {
            BarkAppearance::young(stem.radius)
        };
        if let Some(kind) = &wood.bark_kind {
            bark = kind.apply(bark);
        }
        bark.seed = wood.seed;
        if let Some(color) = wood.bark_color {
            bark.ridge_color = color;
            bark.furrow_color = color.map(|c| c * FURROW_SHADE);
        }
        StemAppearance {
            wood,
            rings,
            bark,
            ends: Vec::new(),
        }
    }
}

/// Distance from an end over which rings turn from those of the location to those of the end, radii.
const END_REACH: f64 = 2.0;

impl StemAppearance {
    /// Returns the ring coordinate and the angle at a point of `stem` with grain coordinates `grain`, m.
    pub(super) fn address(&self, stem: &Stem, grain: DVec3) -> (f64, f64) {
        let across = grain.truncate();
        let (rho, angle) = stem.rings.address(across);
        let nearness = |end: &EndSection| {
            let distance = (grain.z - end.length).abs() / stem.radius;
            1.0 - smoothstep(0.0, END_REACH, distance)
        };
        let ends = self.ends.iter().map(|end| (nearness(end), end));
        let nearest = ends.max_by(|a, b| a.0.total_cmp(&b.0));
        match nearest.filter(|n| n.0 > 0.0) {
            Some((share, end)) => {
                let at_end = end.rings.address(across).0;
                (rho + (at_end - rho) * share, angle)
            }
            None => (rho, angle),
        }
    }
}

impl WoodAppearance {
    /// The wood of `stem`, a softwood where no species is given.
    ///
    /// `proportions` are those of the tissues in the section, `bark` is the ring coordinate at which the outer bark begins,
    /// and `seed` decides what is random. Sawn wood has neither bark nor pith, and one colour; a
    /// pole has no bark.
    pub fn of_stem(
        stem: &Stem,
        proportions: &Proportions,
        seed: u64,
        species: Option<&Species>,
        bark: f64,
    ) -> WoodAppearance {
        let mut wood = wood_of(species);
        wood.seed = seed;
        let sawn = stem.kind.is_sawn();
        wood.radius = if sawn {
            stem.rings.outer_radius(0.0)
        } else {
            stem.radius
        };
        let most = if sawn { SAWN_RING_COUNT } else { RING_COUNT.1 };
        wood.rings = (wood.radius / RING_WIDTH).clamp(RING_COUNT.0, most);
        if sawn {
            (wood.pith, wood.heartwood, wood.phloem, wood.cork) = (0.0, 0.0, ABSENT, ABSENT);
        } else {
            wood.cork = match stem.kind.has_bark() {
                true => bark.clamp(CORK_START.0, CORK_START.1),
                false => ABSENT,
            };
            wood.pith = proportions.pith;
            wood.heartwood = if proportions.heartwood > 0.0 {
                proportions.pith + proportions.heartwood
            } else {
                0.0
            };
            let wood_end = wood.heartwood.max(MIN_PHLOEM_START);
            // The inner bark goes with the bark.
            wood.phloem = match stem.kind.has_bark() {
                true => (wood.cork - proportions.phloem).max(wood_end),
                false => ABSENT,
            };
        }
        wood
    }
}

/// The structure and colours of a species' wood.
fn wood_of(species: Option<&Species>) -> WoodAppearance {
    let mut wood = match species.and_then(|s| s.ring_character) {
        Some(RingCharacter::RingPorous | RingCharacter::SemiRingPorous) => {
            WoodAppearance::ring_porous()
        }
        Some(RingCharacter::DiffusePorous) => WoodAppearance::hardwood(),
        Some(RingCharacter::AbruptLatewood | RingCharacter::GradualLatewood) | None => {
            WoodAppearance::softwood()
        }
    };
    wood.bark_kind = species.and_then(|s| BarkKind::of(&s.scientific_name));
    if species.and_then(|s| s.heartwood_colour) == Some(HeartwoodColour::Light) {
        wood.heartwood_color = wood.sapwood_color.map(|c| c * LIGHT_HEARTWOOD);
    }
    wood
}
