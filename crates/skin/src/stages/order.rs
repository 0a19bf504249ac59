//! The order in which several breaks of one stem are made.

use greenstick_wood::stem::FoundStem;
use std::sync::Arc;

/// Breaks are on different stems.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "breaks on several stems: break 1 is at {first_m:.3} m of one, break {other} at {other_m:.3} m of another; expected all on one"
)]
pub struct SeveralStems {
    /// Where the first one is along its stem, m.
    pub first_m: f64,
    /// Number of a break on another stem, from 1.
    pub other: usize,
    /// Where it is along its stem, m.
    pub other_m: f64,
}

/// Returns the numbers of breaks, for each of which its stem was found, from the farthest from the base to the nearest.
///
/// # Errors
/// [`SeveralStems`].
pub fn order_from_tip(found: &[Arc<FoundStem>]) -> Result<Vec<usize>, SeveralStems> {
    let shell = |number: usize| (found[number].node, found[number].shell.first().copied());
    let at = |number: usize| found[number].stem.location;
    let mut order: Vec<usize> = (0..found.len()).collect();
    if let Some(&other) = order.iter().find(|&&number| shell(number) != shell(0)) {
        return Err(SeveralStems {
            first_m: at(0),
            other: other + 1,
            other_m: at(other),
        });
    }
    order.sort_by(|&a, &b| at(b).total_cmp(&at(a)));
    Ok(order)
}
