//! Pieces of a break.

use crate::cracks::EndOfStem;
use crate::hang::HangReport;
use crate::report::{BreakNote, PieceReport};
use glam::DAffine3;
use greenstick_geometry::Mesh;
use std::sync::Arc;

/// The part that a piece has in a broken stem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PieceRole {
    /// What stays at the base.
    Lower,
    /// What lies beyond the break.
    Upper,
    /// The piece of this number, counted from 0 at the base, of a stem that is broken at several locations.
    Segment(usize),
    /// A splinter that came loose.
    Splinter(usize),
}

impl PieceRole {
    /// Name of the piece's node.
    pub fn name(self) -> String {
        match self {
            PieceRole::Lower => "lower".to_owned(),
            PieceRole::Upper => "upper".to_owned(),
            PieceRole::Segment(number) => format!("piece_{number}"),
            PieceRole::Splinter(number) => format!("splinter_{number:03}"),
        }
    }
}

/// A piece of a break.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Its role.
    pub role: PieceRole,
    /// Its mesh, in the coordinates of the node that was cut.
    pub mesh: Arc<Mesh>,
    /// Strands of torn fibre on its broken face, in the same coordinates; none where there is no fuzz.
    pub fuzz: Option<Arc<Mesh>>,
    /// Its motion in the world from where it was in the unbroken stem.
    pub motion: DAffine3,
}

/// The pieces of a break.
#[derive(Debug, Clone)]
pub struct Pieces {
    /// The lower piece, the upper one, then splinters.
    pub pieces: Vec<Piece>,
    /// A report on each of them.
    pub reports: Vec<PieceReport>,
    /// How the upper piece hangs, if it does.
    pub hang: Option<HangReport>,
    /// Volume of the cracks, m³; none if there are no cracks.
    pub crack_volume_m3: Option<f64>,
    /// The sawn end that has cracks, if any.
    pub end: Option<EndOfStem>,
    /// What was assumed, limited or repaired.
    pub notes: Vec<BreakNote>,
}
