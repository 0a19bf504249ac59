//! The mode in which wood broke, by the names that the field has for failures in bending (Record 1914, *The Mechanical
//! Properties of Wood*, part 1; ASTM D143) where they apply.

use crate::event::{Cause, Event, EventKind};
use serde::Serialize;

/// Fewer broken rods than this fraction of all are no break across the grain.
const MIN_BROKEN: f64 = 0.1;
/// Breaks that lie within this many diameters of each other along the grain (standard deviation) are brash, and those beyond
/// the second are splinters: brash wood breaks almost flat across, and the splinters of tough wood are several times as long as
/// the tear of simple tension.
const BRASH_SPREAD: f64 = 0.1;
const SPLINTERING_SPREAD: f64 = 0.4;

/// How wood broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Nothing broke.
    Whole,
    /// Bonds broke along the grain, and hardly a rod.
    Split,
    /// Rods broke, and the rest still holds the wood together.
    Greenstick,
    /// The wood parted almost flat across the grain.
    BrashTension,
    /// The wood parted with a short, regular tear.
    SimpleTension,
    /// The wood parted with long splinters.
    SplinteringTension,
    /// The wood parted in torsion.
    Torsion,
}

impl Mode {
    /// Returns the mode of wood of which so many rods broke out of `rods`. `spread` is the standard deviation of their places
    /// over the diameter.
    pub(super) fn new(
        events: &[Event],
        (broken, rods): (usize, usize),
        spread: f64,
        parted: bool,
    ) -> Self {
        let count = |kind, cause: Option<Cause>| {
            let is = |e: &&Event| e.kind == kind && cause.is_none_or(|c| e.cause == c);
            events.iter().filter(is).count()
        };
        let rod_breaks = count(EventKind::RodBroke, None);
        let torsion = count(EventKind::RodBroke, Some(Cause::Torsion));
        if rod_breaks == 0 && count(EventKind::BondBroke, None) == 0 {
            Mode::Whole
        } else if (broken as f64) < MIN_BROKEN * rods as f64 {
            Mode::Split
        } else if !parted {
            Mode::Greenstick
        } else if 2 * torsion > rod_breaks {
            Mode::Torsion
        } else if spread < BRASH_SPREAD {
            Mode::BrashTension
        } else if spread < SPLINTERING_SPREAD {
            Mode::SimpleTension
        } else {
            Mode::SplinteringTension
        }
    }

    /// Returns the mode in words that follow "broke" or stand alone.
    pub fn description(self) -> &'static str {
        match self {
            Mode::Whole => "whole: nothing broke",
            Mode::Split => "split along the grain",
            Mode::Greenstick => "greenstick: broken in part, and held together by the rest",
            Mode::BrashTension => "parted by brash tension, almost flat across",
            Mode::SimpleTension => "parted by simple tension, with a short tear",
            Mode::SplinteringTension => "parted by splintering tension, with long splinters",
            Mode::Torsion => "parted in torsion",
        }
    }
}
