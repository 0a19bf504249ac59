//! What a simulated face was made from.

use super::fractures::SimulatedFracture;
use super::section_field::SectionRod;
use greenstick_fracture::heights::FailureMode;
use greenstick_wood::stem::{Stem, StemLocation};
use serde::{Deserialize, Serialize};
use std::fmt;

/// How much of the section failed in a mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModeShare {
    /// `torn`, `crushed`, `split`, `twisted` or `unbroken`.
    pub mode: String,
    /// Number of rods.
    pub rods: usize,
    /// Share of the section's area, 0 to 1.
    pub share: f64,
}

/// A face that a run decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SimulatedFaceReport {
    /// The location along the stem, in the form that [`StemLocation::parse`] reads.
    pub at: String,
    /// Length along the stem's axis to the break, m.
    pub place_m: f64,
    /// Whether the simulation parted the stem there.
    pub parted: bool,
    /// The mode in which most of the section failed.
    pub mode: String,
    /// All modes that occur, the largest first.
    pub modes: Vec<ModeShare>,
    /// Number of rods of the wood.
    pub rods: usize,
    /// Number of rods that broke there.
    pub broken: usize,
    /// Share of the section that is whole there, 0 to 1.
    pub unbroken_share: f64,
    /// Lowest and highest break of a rod over the location, m.
    pub heights_m: [f64; 2],
    /// Further breaks of the same rods, which are left out.
    pub further_breaks: usize,
    /// Length of splinters finer than rods, m.
    pub splinters_m: f64,
}

impl SimulatedFaceReport {
    pub(super) fn new(
        fracture: &SimulatedFracture,
        rods: &[SectionRod],
        (stem, location): (&Stem, &StemLocation),
        splinters: f64,
    ) -> Self {
        let area: f64 = rods.iter().map(|r| r.area).sum();
        let share = |mode: FailureMode| {
            let of_mode = rods.iter().filter(|r| r.mode == mode);
            let rods = of_mode.clone().count();
            (rods > 0).then(|| ModeShare {
                mode: mode.word().into(),
                rods,
                share: of_mode.map(|r| r.area).sum::<f64>() / area,
            })
        };
        let mut modes: Vec<ModeShare> = FailureMode::ALL.into_iter().filter_map(share).collect();
        modes.sort_by(|a, b| b.share.total_cmp(&a.share));
        let heights = || rods.iter().filter_map(|r| r.height);
        let unbroken = FailureMode::Unbroken.word();
        let failed = modes.iter().find(|m| m.mode != unbroken);
        SimulatedFaceReport {
            at: location.to_string(),
            place_m: stem.location,
            parted: fracture.parted,
            mode: failed.map_or_else(|| unbroken.into(), |m| m.mode.clone()),
            rods: rods.len(),
            broken: heights().count(),
            unbroken_share: (modes.iter().find(|m| m.mode == unbroken)).map_or(0.0, |m| m.share),
            modes,
            heights_m: [
                heights().fold(f64::INFINITY, f64::min),
                heights().fold(f64::NEG_INFINITY, f64::max),
            ],
            further_breaks: fracture.further_breaks,
            splinters_m: splinters * stem.radius,
        }
    }
}

impl fmt::Display for SimulatedFaceReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let modes = self
            .modes
            .iter()
            .map(|m| format!("{:.0} % {} ({} rods)", 100.0 * m.share, m.mode, m.rods));
        writeln!(
            f,
            "broke    {} of {} rods at {:.2} cm along the stem, {}: {}",
            self.broken,
            self.rods,
            100.0 * self.place_m,
            if self.parted { "in two" } else { "not through" },
            modes.collect::<Vec<_>>().join(", ")
        )?;
        writeln!(
            f,
            "heights  rods broke from {:.2} to {:.2} mm; splinters between them {:.2} mm long",
            1e3 * self.heights_m[0],
            1e3 * self.heights_m[1],
            1e3 * self.splinters_m
        )?;
        if self.further_breaks > 0 {
            writeln!(
                f,
                "note     {} further breaks of the same rods are left out",
                self.further_breaks
            )?;
        }
        Ok(())
    }
}
