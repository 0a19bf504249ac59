//! What happens to a bundle: breaks and yielding, as they are written to `events.csv`.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A rod broke at a vertex and is two rods now.
    RodBroke,
    /// An edge of a rod began to yield in compression.
    RodYielded,
    /// A bond broke.
    BondBroke,
}

/// Which criterion was passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// Tension along the grain: stretch × bending ratio.
    Tension,
    /// Compression along the grain.
    Compression,
    /// The bond's stored energy: the thesis's threshold.
    Potential,
    /// The bond's stored energy against its energy of fracture.
    Griffith,
    /// Stress across and along the bond's facet.
    Stress,
}

/// One event. Rod and vertex are numbers of the unbroken bundle, so that they name the same wood at every time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// What happened.
    pub kind: EventKind,
    /// Rod of the unbroken bundle; of a bond the one whose vertex it holds.
    pub rod: u32,
    /// Vertex of the unbroken bundle; of yielding the first of the edge's.
    pub vertex: u32,
    /// The other rod of a bond.
    pub other: Option<u32>,
    /// Place, m.
    pub place: DVec3,
    /// Why.
    pub cause: Cause,
    /// How far the criterion was passed: demand over strength.
    pub demand: f64,
    /// Energy that is no longer stored, J.
    pub energy: f64,
}
