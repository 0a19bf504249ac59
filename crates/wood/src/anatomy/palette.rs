//! Colours of passes, rings and tissues.

use super::passes::{PassLegend, PassMeaning};
use crate::appearance::WoodAppearance;
use crate::colour::srgb_bytes;
use crate::rings::RingPart;
use crate::tissue::Zone;
use glam::DVec3;

greenstick_schema::choices! {
    /// Colours of rings.
    pub enum RingColouring {
        /// Those of the species' wood, tissue by tissue.
        Wood = "wood",
        /// The two browns of Forests 2023 §3.3.
        Published = "published",
    }
}

/// Colours of tissues from the pith outwards, chosen to be distinguishable with colour vision deficiencies (Okabe and Ito
/// 2008, Color Universal Design).
pub(super) const TISSUE_COLOURS: [[u8; 3]; 5] = [
    [213, 94, 0],
    [230, 159, 0],
    [240, 228, 66],
    [0, 158, 115],
    [86, 60, 40],
];

/// The paper's browns for latewood and earlywood. It prints (30, 92, 186) and (184, 215, 248), which are blues: OpenCV's
/// order, blue first.
pub(super) const fn published(part: RingPart) -> [u8; 3] {
    match part {
        RingPart::Latewood => [186, 92, 30],
        RingPart::Earlywood => [248, 215, 184],
    }
}

/// The factor by which latewood darkens a linear colour.
pub(super) fn latewood_factor(wood: &WoodAppearance) -> DVec3 {
    DVec3::from_array(wood.latewood_color)
        / DVec3::from_array(wood.sapwood_color).max(DVec3::splat(1e-3))
}

/// Colour of every pass, sRGB; black for what is no wood.
pub(super) fn palette(
    wood: &WoodAppearance,
    colouring: RingColouring,
    legend: &PassLegend,
) -> Vec<[u8; 3]> {
    let darker = latewood_factor(wood);
    let colour = |pass: &PassMeaning| {
        if pass.ring == 0 {
            return [0; 3];
        }
        if colouring == RingColouring::Published {
            return published(pass.part);
        }
        let base = match pass.tissue {
            Zone::Pith => wood.pith_color,
            Zone::Heartwood => wood.heartwood_color,
            Zone::Sapwood => wood.sapwood_color,
            Zone::Phloem => wood.phloem_color,
            Zone::Bark => wood.cork_color,
        };
        let is_wood = matches!(pass.tissue, Zone::Heartwood | Zone::Sapwood);
        let dark = pass.part == RingPart::Latewood && is_wood;
        let shade = if dark { darker } else { DVec3::ONE };
        srgb_bytes(DVec3::from_array(base) * shade)
    };
    legend.passes.iter().map(colour).collect()
}
