//! What happens to a bundle: breaks and yielding, as `events.csv` lists them.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A rod broke at a vertex, and is two rods now.
    RodBroke,
    /// An edge of a rod began to yield in compression.
    RodYielded,
    /// A bond broke.
    BondBroke,
}

/// The failure criterion that was exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// Tension along the grain: stretch × bending ratio.
    Tension,
    /// Compression along the grain.
    Compression,
    /// The bond's stored energy against the thesis's threshold.
    Potential,
    /// The bond's stored energy against its fracture energy.
    Griffith,
    /// Stress across and along the bond's facet.
    Stress,
    /// Work across and along the bond's facet, from its strength to its energy of fracture, most of it across.
    Cohesive,
    /// Torsion: shear along the grain at the rod's surface, where it exceeds tension.
    Torsion,
    /// The same work of a bond as [`Cause::Cohesive`], most of it along the facet: the bond slid.
    Shear,
}

/// One event. Rod and vertex are numbers of the unbroken bundle, so that they name the same wood at all times.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// What happened.
    pub kind: EventKind,
    /// Rod of the unbroken bundle; for a bond the rod of its vertex.
    pub rod: u32,
    /// Vertex of the unbroken bundle; for yielding the first vertex of the edge.
    pub vertex: u32,
    /// The other rod of a bond.
    pub other: Option<u32>,
    /// Position, m.
    pub position: DVec3,
    /// The criterion that was exceeded.
    pub cause: Cause,
    /// Demand over strength.
    pub demand: f64,
    /// Energy that is no longer stored, J.
    pub energy: f64,
}
