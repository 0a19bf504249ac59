//! Ring character and heartwood colour by genus.
//!
//! Sources: R. B. Hoadley, *Identifying Wood*, and the species descriptions of the Wood Handbook,
//! chapter 2. The genus decides but for the exceptions listed; a genus that is not in the table has
//! no entry.

use serde::{Deserialize, Serialize};

/// How the vessels (or tracheids) lie in a ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RingCharacter {
    /// A sharp row of large earlywood vessels: rings stand out and are weak planes.
    RingPorous,
    /// Vessels shrink gradually outwards.
    SemiRingPorous,
    /// Vessels all alike: rings are faint.
    DiffusePorous,
    /// Conifer whose latewood starts abruptly: dark bands.
    AbruptLatewood,
    /// Conifer whose latewood starts gradually.
    GradualLatewood,
}

/// Whether the heartwood stands out from the sapwood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeartwoodColour {
    /// Hardly distinguishable from the sapwood.
    Light,
    /// Clearly darker than the sapwood.
    Dark,
}

use HeartwoodColour::{Dark, Light};
use RingCharacter::{AbruptLatewood, DiffusePorous, GradualLatewood, RingPorous, SemiRingPorous};

const GENERA: &[(&str, RingCharacter, HeartwoodColour)] = &[
    ("Abies", GradualLatewood, Light),
    ("Acer", DiffusePorous, Light),
    ("Ailanthus", RingPorous, Light),
    ("Alnus", DiffusePorous, Light),
    ("Betula", DiffusePorous, Light),
    ("Callitropsis", GradualLatewood, Light),
    ("Calocedrus", GradualLatewood, Dark),
    ("Carya", RingPorous, Dark),
    ("Castanea", RingPorous, Dark),
    ("Celtis", RingPorous, Light),
    ("Chamaecyparis", GradualLatewood, Light),
    ("Fagus", DiffusePorous, Light),
    ("Fraxinus", RingPorous, Dark),
    ("Gleditsia", RingPorous, Dark),
    ("Juglans", SemiRingPorous, Dark),
    ("Juniperus", GradualLatewood, Dark),
    ("Koelreuteria", RingPorous, Dark),
    ("Larix", AbruptLatewood, Dark),
    ("Liquidambar", DiffusePorous, Dark),
    ("Liriodendron", DiffusePorous, Dark),
    ("Magnolia", DiffusePorous, Dark),
    ("Nyssa", DiffusePorous, Light),
    ("Picea", GradualLatewood, Light),
    ("Pinus", AbruptLatewood, Dark),
    ("Platanus", DiffusePorous, Dark),
    ("Populus", DiffusePorous, Light),
    ("Prunus", DiffusePorous, Dark),
    ("Pseudotsuga", AbruptLatewood, Dark),
    ("Quercus", RingPorous, Dark),
    ("Robinia", RingPorous, Dark),
    ("Salix", DiffusePorous, Dark),
    ("Sassafras", RingPorous, Dark),
    ("Sequoia", AbruptLatewood, Dark),
    ("Taxodium", AbruptLatewood, Dark),
    ("Thuja", AbruptLatewood, Dark),
    ("Tilia", DiffusePorous, Light),
    ("Tsuga", AbruptLatewood, Light),
    ("Ulmus", RingPorous, Dark),
];

/// Species that differ from their genus.
const EXCEPTIONS: &[(&str, RingCharacter, HeartwoodColour)] = &[
    ("Carya aquatica", SemiRingPorous, Dark),
    ("Carya illinoinensis", SemiRingPorous, Dark),
    ("Juglans cinerea", SemiRingPorous, Light),
    ("Pinus lambertiana", GradualLatewood, Light),
    ("Pinus monticola", GradualLatewood, Light),
    ("Pinus strobus", GradualLatewood, Light),
    ("Populus deltoides", SemiRingPorous, Light),
    ("Quercus virginiana", SemiRingPorous, Dark),
    ("Salix nigra", SemiRingPorous, Dark),
    ("Thuja occidentalis", GradualLatewood, Light),
];

/// Ring character and heartwood colour by scientific name; `None` for an unknown genus.
pub(super) fn ring_character_and_heartwood(
    scientific_name: &str,
) -> Option<(RingCharacter, HeartwoodColour)> {
    let genus = scientific_name.split(' ').next()?;
    EXCEPTIONS
        .iter()
        .find(|e| scientific_name.starts_with(e.0))
        .or_else(|| GENERA.iter().find(|g| g.0 == genus))
        .map(|&(_, rings, heartwood)| (rings, heartwood))
}
