//! What the wood and bark of a stem look like: by species where one is named.

use greenstick_fracture::parameters::BreakParameters;
use greenstick_wood::appearance::{BarkAppearance, WoodAppearance};
use greenstick_wood::species::{HeartwoodColour, RingCharacter, Species};
use greenstick_wood::stem::{Stem, StemKind};

/// Looks of a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Looks {
    /// The wood inside.
    pub wood: WoodAppearance,
    /// The bark.
    pub bark: BarkAppearance,
}

/// Width of an annual ring where nothing else is known, m, and the fewest and most rings drawn.
const RING_WIDTH: f64 = 2.2e-3;
const FEWEST_RINGS: f64 = 5.0;
const MOST_RINGS: f64 = 60.0;
/// Radius above which bark is taken for furrowed, m.
const OLD: f64 = 0.06;

/// Looks of `stem`, `bark` being the ring coordinate at which its bark begins.
pub(crate) fn looks(
    stem: &Stem,
    p: &BreakParameters,
    species: Option<&Species>,
    bark: f64,
) -> Looks {
    let mut wood = match species.and_then(|s| s.ring_character) {
        Some(RingCharacter::RingPorous | RingCharacter::SemiRingPorous) => {
            WoodAppearance::ring_porous()
        }
        Some(RingCharacter::DiffusePorous) => WoodAppearance::hardwood(),
        Some(RingCharacter::AbruptLatewood | RingCharacter::GradualLatewood) | None => {
            WoodAppearance::softwood()
        }
    };
    if species.and_then(|s| s.heartwood_colour) == Some(HeartwoodColour::Light) {
        wood.heartwood_color = wood.sapwood_color.map(|c| c * 0.93);
    }
    let board = stem.kind == StemKind::Board;
    wood.radius = if board {
        stem.rings.outer_radius(0.0)
    } else {
        stem.radius
    };
    wood.rings = (wood.radius / RING_WIDTH).clamp(FEWEST_RINGS, MOST_RINGS);
    wood.seed = p.seed;
    if board {
        // A board has neither bark nor pith in it, and one colour of wood.
        (wood.pith, wood.heartwood, wood.phloem, wood.cork) = (0.0, 0.0, 2.0, 2.0);
    } else {
        let cork = bark.clamp(0.6, 0.99);
        wood.pith = p.pith_proportion;
        wood.heartwood = if p.heartwood_proportion > 0.0 {
            p.pith_proportion + p.heartwood_proportion
        } else {
            0.0
        };
        wood.cork = cork;
        wood.phloem = (cork - p.phloem_proportion).max(wood.heartwood.max(0.3));
    }
    let mut look = if stem.radius > OLD {
        BarkAppearance::furrowed(stem.radius)
    } else {
        BarkAppearance::young(stem.radius)
    };
    look.seed = p.seed;
    Looks { wood, bark: look }
}
