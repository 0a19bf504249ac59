//! A break that is finished.

use super::piece::Pieces;
use crate::stages::BreakStages;

/// One break of a stem, with its stages and pieces.
#[derive(Debug, Clone, Copy)]
pub struct FinishedBreak<'a> {
    /// Its number among the breaks that were requested. They are made from the farthest from the base to the nearest.
    pub number: usize,
    /// Its stages up to the cut.
    pub stages: &'a BreakStages,
    /// Its pieces.
    pub pieces: &'a Pieces,
}

/// Returns breaks in the order in which they were requested.
pub(super) fn in_order_of_request<'a>(breaks: &[FinishedBreak<'a>]) -> Vec<FinishedBreak<'a>> {
    let mut order = breaks.to_vec();
    order.sort_by_key(|one| one.number);
    order
}
