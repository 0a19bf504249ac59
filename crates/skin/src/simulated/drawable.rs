//! Which fractures of a run faces are drawn for.

use super::fractures::SimulatedFracture;
use super::observed::ObservedRun;
use crate::rods::Wood;

/// How much of the section must be broken for a face in wood that still hangs together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartlyBroken {
    /// Half: the pieces are moved apart.
    Separated,
    /// A tenth: the pieces stay together at what is whole, a hinge.
    Hinged,
}

impl PartlyBroken {
    /// Least share of the section, 0 to 1.
    fn least_share(self) -> f64 {
        match self {
            PartlyBroken::Separated => 0.5,
            PartlyBroken::Hinged => 0.1,
        }
    }
}

/// Why no face is drawn: the wood holds together.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WoodHolds {
    /// Nothing broke.
    #[error(
        "no rod is broken at {time:.4} s, so there is no face to draw; take a later frame, or simulate longer or harder"
    )]
    NoBreak {
        /// Time of the frame, s.
        time: f64,
    },
    /// Too little broke.
    #[error(
        "only {:.0} % of the section is broken at {time:.4} s and the wood holds, so there is no face to draw; it takes {:.0} %: \
         take a later frame, or simulate longer or harder",
        100.0 * share,
        100.0 * least
    )]
    TooLittle {
        /// Share of the section that is broken, 0 to 1.
        share: f64,
        /// The least that would do.
        least: f64,
        /// Time of the frame, s.
        time: f64,
    },
}

impl SimulatedFracture {
    /// Finds the fractures of a run that faces are drawn for, from the base of its stem to its tip.
    ///
    /// # Errors
    /// [`WoodHolds`] where there is none.
    pub fn find_drawable(
        wood: &Wood,
        observed: &ObservedRun,
        partly: PartlyBroken,
    ) -> Result<Vec<SimulatedFracture>, WoodHolds> {
        let mut fractures = SimulatedFracture::find(wood, observed);
        let time = observed.time;
        if fractures.is_empty() {
            return Err(WoodHolds::NoBreak { time });
        }
        // Beside a fracture that gapes, one that hardly opens need not be seen.
        let partly = match fractures.iter().any(|f| f.parted) {
            true => PartlyBroken::Separated,
            false => partly,
        };
        let least = partly.least_share();
        let shares = fractures.iter().map(|f| f.broken_share(wood));
        let share = shares.fold(0.0, f64::max);
        fractures.retain(|f| f.parted || f.broken_share(wood) >= least);
        if fractures.is_empty() {
            return Err(WoodHolds::TooLittle { share, least, time });
        }
        Ok(fractures)
    }
}
