//! The mode in which wood broke, by the names that the field has for failures in bending (Record 1914, *The Mechanical
//! Properties of Wood*, part 1; ASTM D143) where they apply.

use crate::event::{Cause, Event, EventKind};
use serde::Serialize;
use std::collections::BTreeSet;

/// Fewer broken rods than this fraction of all are no break across the grain, and fewer crushed ones no failure in compression.
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
    /// Bonds were torn open along the grain, and hardly a rod broke.
    Split,
    /// Bonds slid along the grain under a load across it, and hardly a rod broke.
    HorizontalShear,
    /// Rods were crushed, and hardly one broke, or most that broke did where they were crushed before.
    Compression,
    /// Rods broke, and the rest still holds the wood together.
    Greenstick,
    /// The wood parted almost flat across the grain.
    BrashTension,
    /// The wood parted with a short, regular tear.
    SimpleTension,
    /// The wood parted with long splinters.
    SplinteringTension,
    /// The wood broke in torsion: rods by it, or bonds that slid under a torque.
    Torsion,
}

/// What happened to rods and bonds, counted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Damage {
    /// Breaks of rods, and those of them by torsion.
    rod_breaks: [usize; 2],
    /// Rods that broke, and rods that yielded, at least once.
    pub rods_broken: usize,
    rods_yielded: usize,
    /// Rods that had yielded in compression where they broke first.
    crushed_before: usize,
    edges_yielded: usize,
    /// Breaks of bonds, and those of them in which the bond slid.
    bond_breaks: [usize; 2],
}

/// Numbers of what there was at the start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elements {
    pub rods: usize,
    pub edges: usize,
    pub bonds: usize,
}

impl Damage {
    pub fn count(events: &[Event]) -> Self {
        let mut damage = Damage::default();
        let [mut broken, mut yielded, mut crushed_edges] = [const { BTreeSet::new() }; 3];
        for event in events {
            match event.kind {
                EventKind::RodBroke => {
                    let beside = [event.vertex.wrapping_sub(1), event.vertex];
                    let crushed = beside.iter().any(|edge| crushed_edges.contains(edge));
                    if broken.insert(event.rod) && crushed {
                        damage.crushed_before += 1;
                    }
                    damage.rod_breaks[0] += 1;
                    damage.rod_breaks[1] += usize::from(event.cause == Cause::Torsion);
                }
                EventKind::RodYielded => {
                    yielded.insert(event.rod);
                    crushed_edges.insert(event.vertex);
                    damage.edges_yielded += 1;
                }
                EventKind::BondBroke => {
                    damage.bond_breaks[0] += 1;
                    damage.bond_breaks[1] += usize::from(event.cause == Cause::Shear);
                }
            }
        }
        (damage.rods_broken, damage.rods_yielded) = (broken.len(), yielded.len());
        damage
    }

    /// Whether most bonds that broke slid.
    fn slid(&self) -> bool {
        2 * self.bond_breaks[1] > self.bond_breaks[0]
    }
}

impl Mode {
    /// Returns the mode of wood with a damage. `spread` is the standard deviation of the places at which rods broke in its face,
    /// over the diameter; `torque` says whether the greatest moment twisted the stem.
    pub(super) fn new(
        damage: &Damage,
        elements: Elements,
        (spread, parted, torque): (f64, bool, bool),
    ) -> Self {
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        let [rod_breaks, by_torsion] = damage.rod_breaks;
        let crushed = share(damage.rods_yielded, elements.rods) >= MIN_BROKEN;
        if rod_breaks == 0 && damage.bond_breaks[0] == 0 && !crushed {
            return Mode::Whole;
        }
        if 2 * by_torsion > rod_breaks || torque && damage.slid() {
            return Mode::Torsion;
        }
        if share(damage.rods_broken, elements.rods) < MIN_BROKEN {
            // A few bonds give way beside crushed fibres, and a few fibres are crushed where a load enters split wood.
            let edges = share(damage.edges_yielded, elements.edges);
            return if crushed && edges > share(damage.bond_breaks[0], elements.bonds) {
                Mode::Compression
            } else if damage.slid() {
                Mode::HorizontalShear
            } else {
                Mode::Split
            };
        }
        if 2 * damage.crushed_before > damage.rods_broken {
            Mode::Compression
        } else if !parted {
            Mode::Greenstick
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
            Mode::HorizontalShear => "sheared along the grain: its parts slid along each other",
            Mode::Compression => "crushed along the grain, before anything tore there",
            Mode::Greenstick => "greenstick: broken in part, and held together by the rest",
            Mode::BrashTension => "parted by brash tension, almost flat across",
            Mode::SimpleTension => "parted by simple tension, with a short tear",
            Mode::SplinteringTension => "parted by splintering tension, with long splinters",
            Mode::Torsion => "broken in torsion",
        }
    }
}
