//! What became of the wood: whether it broke, where, in which mode, under which load, and into which pieces.
//!
//! Wood has parted where what is left of rods and bonds could carry hardly any tension along the grain, though single fibres may
//! still bridge the gap: what counts is the load, not the last bond.
//!
//! | module | content |
//! |---|---|
//! | `capacity` | the tension that the wood can still carry, and its weakest cut |
//! | `face` | the breaks of rods between the two sides that came apart |
//! | `mode` | [`Mode`]: how it broke |
//! | `pieces` | the pieces that rods and bonds hold together |
//! | `region` | where in the world it broke |

mod capacity;
mod face;
mod mode;
mod pieces;
#[cfg(test)]
mod tests;

pub use mode::Mode;
use mode::{Damage, Elements};

use crate::event::Event;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::store::{EnergyRow, ForceRow};
use capacity::TensionCapacity;
use face::Face;
use glam::DVec3;
pub use pieces::OutcomePiece;
use pieces::{Pieces, SPLINTER_SHARE};
use serde::Serialize;
use std::collections::BTreeMap;

/// Wood that can carry less than this fraction of the tension that it could carry at the start has parted.
const PARTED: f64 = 0.05;
/// Vertices of rods that begin or end within this fraction of the stem from its ends are its ends.
const END_FRACTION: f64 = 0.1;

/// What became of the wood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Whether the wood has come apart between base and tip.
    pub parted: bool,
    /// How it broke.
    pub mode: Mode,
    /// Tension along the grain that it could still carry from base to tip, over that at the start; `None` where no rods reach
    /// from one end of the stem to the other.
    pub tension_left: Option<f64>,
    /// Rods that broke at least once.
    pub rods_broken: usize,
    /// Median of the places at which rods broke in the face where the wood parted, along the stem from its base, m. Where it has
    /// not parted, of the break of each rod that gapes most.
    pub place_m: Option<f64>,
    /// Standard deviation of these places, m.
    pub spread_m: Option<f64>,
    /// Breaks of rods that are not among them: those of splinters, and of wood that broke in several places.
    pub further_breaks: usize,
    /// Largest force of a clamp or moved body, N, and the fraction of it that it bears at the end.
    pub greatest_load_n: f64,
    /// That fraction.
    pub load_left: f64,
    /// Largest moment of a clamp or moved body about its centre, N m.
    pub greatest_moment_nm: f64,
    /// The fraction of it that is left at the end.
    pub moment_left: f64,
    /// Pieces, the largest first, without splinters.
    pub pieces: Vec<OutcomePiece>,
    /// Smaller pieces.
    pub splinters: usize,
    /// Share of the wood that splinters have.
    pub splinter_share: f64,
    /// The most by which the energy that the method dissipated fell, J. It cannot fall: more than a thousandth of all energy means
    /// that the run is in error by so much.
    pub dissipation_fell_j: f64,
}

/// The wood before anything moved, as far as the outcome needs it.
#[derive(Debug, Clone)]
pub(crate) struct WoodAtStart {
    /// Per vertex: position along the stem, 0 to 1.
    fraction: Vec<f64>,
    /// Per vertex: its rod.
    rod: Vec<u32>,
    elements: Elements,
    /// Length of the stem, m.
    length: f64,
    /// Diameter of a circle of the rods' area, m.
    diameter: f64,
    /// Tension that it can carry, N; `None` where no rods reach from end to end.
    capacity: Option<f64>,
}

/// Records of a run.
pub(crate) struct OutcomeRecords<'a> {
    pub events: &'a [Event],
    pub energies: &'a [EnergyRow],
    pub forces: &'a [ForceRow],
}

impl WoodAtStart {
    /// Returns that of a bundle whose vertices are at fractions of a stem's `length` (m).
    pub fn new(bundle: &RodBundle, fraction: &[f64], length: f64) -> Self {
        let area: f64 = bundle.area.iter().sum();
        let rod = (0..bundle.rods()).flat_map(|r| bundle.rod(r).map(move |_| r as u32));
        let mut wood = WoodAtStart {
            fraction: fraction.to_vec(),
            rod: rod.collect(),
            elements: Elements {
                rods: bundle.rods(),
                edges: (0..bundle.vertices())
                    .filter(|&j| bundle.is_edge(j))
                    .count(),
                bonds: bundle.bonds.len(),
            },
            length,
            diameter: 2.0 * (area / std::f64::consts::PI).sqrt(),
            capacity: None,
        };
        let ends = wood.ends(bundle);
        if ends.iter().all(|end| !end.is_empty()) {
            let state = State::at_rest(bundle);
            let capacity = TensionCapacity::new(bundle, &state, [&ends[0], &ends[1]]);
            wood.capacity = Some(capacity.newtons).filter(|c| *c > 0.0);
        }
        wood
    }

    /// Returns the vertices at base and tip of what the bundle has become.
    fn ends(&self, bundle: &RodBundle) -> [Vec<u32>; 2] {
        let mut ends = [Vec::new(), Vec::new()];
        for (v, &origin) in bundle.origin.iter().enumerate() {
            let origin = origin as usize;
            let is_first = origin == 0 || self.rod[origin - 1] != self.rod[origin];
            let is_last = self.rod.get(origin + 1) != Some(&self.rod[origin]);
            if is_first && self.fraction[origin] < END_FRACTION {
                ends[0].push(v as u32);
            } else if is_last && self.fraction[origin] > 1.0 - END_FRACTION {
                ends[1].push(v as u32);
            }
        }
        ends
    }

    /// Returns what became of it.
    pub fn outcome(&self, bundle: &RodBundle, state: &State, records: &OutcomeRecords) -> Outcome {
        let ends = self.ends(bundle);
        let cut = (self.capacity).map(|whole| {
            (
                whole,
                TensionCapacity::new(bundle, state, [&ends[0], &ends[1]]),
            )
        });
        let tension_left = cut.as_ref().map(|(whole, cut)| cut.newtons / whole);
        let parted = tension_left.is_some_and(|left| left < PARTED);
        let at_base = cut.filter(|_| parted).map(|(_, cut)| cut.at_base);
        let pieces = Pieces::new(bundle, at_base.as_deref());
        let place = |vertex: usize| self.fraction[vertex] * self.length;
        let face = Face::new((bundle, state), place, (&pieces, at_base.as_deref()));
        let mut all = pieces.all;
        all.sort_by(|a, b| b.share.total_cmp(&a.share));
        let large = all.partition_point(|piece| piece.share >= SPLINTER_SHARE);
        let place = face.median_and_spread();
        let spread = place.map_or(0.0, |(_, spread)| spread / self.diameter);
        let damage = Damage::count(records.events);
        let [load, moment] = greatest_loads(records.forces);
        let torque = is_twisted(records.forces, moment.greatest);
        Outcome {
            parted,
            mode: Mode::new(&damage, self.elements, (spread, parted, torque)),
            tension_left,
            rods_broken: damage.rods_broken,
            place_m: place.map(|p| p.0),
            spread_m: place.map(|p| p.1),
            further_breaks: face.further,
            greatest_load_n: load.greatest,
            load_left: load.left(),
            greatest_moment_nm: moment.greatest,
            moment_left: moment.left(),
            pieces: all[..large].to_vec(),
            splinters: all.len() - large,
            splinter_share: all[large..].iter().map(|piece| piece.share).sum(),
            dissipation_fell_j: largest_fall(records.energies),
        }
    }
}

/// A load over time.
#[derive(Debug, Clone, Copy, Default)]
struct LoadHistory {
    greatest: f64,
    last: f64,
}

impl LoadHistory {
    fn left(&self) -> f64 {
        if self.greatest > 0.0 {
            self.last / self.greatest
        } else {
            0.0
        }
    }
}

/// Returns the force and the moment of the clamp or body that bears most of either.
fn greatest_loads(rows: &[ForceRow]) -> [LoadHistory; 2] {
    let mut holders = BTreeMap::<&str, [LoadHistory; 2]>::new();
    for row in rows {
        let histories = holders.entry(&row.holder).or_default();
        for (history, load) in histories.iter_mut().zip([row.force, row.moment]) {
            history.last = load.length();
            history.greatest = history.greatest.max(history.last);
        }
    }
    [0, 1].map(|kind| {
        (holders.values().map(|h| h[kind]))
            .max_by(|a, b| a.greatest.total_cmp(&b.greatest))
            .unwrap_or_default()
    })
}

/// Whether a clamp or body that turns about the stem, which lies along x, bore most of the greatest moment.
fn is_twisted(rows: &[ForceRow], greatest_moment: f64) -> bool {
    let is_along = |v: DVec3| 2.0 * v.x * v.x > v.length_squared();
    rows.iter().any(|row| {
        is_along(row.rotation_degrees)
            && is_along(row.moment)
            && row.moment.length() > 0.5 * greatest_moment
    })
}

/// Returns the most by which the dissipated energy fell below what it was before, J.
fn largest_fall(rows: &[EnergyRow]) -> f64 {
    let mut most = f64::NEG_INFINITY;
    rows.iter().fold(0.0, |fall: f64, row| {
        most = most.max(row.ledger.dissipated);
        fall.max(most - row.ledger.dissipated)
    })
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "outcome  {}", self.mode.description())?;
        if let (Some(place), Some(spread)) = (self.place_m, self.spread_m) {
            write!(
                f,
                "; {} rods broke {:.3} m from the base (standard deviation {:.1} mm)",
                self.rods_broken,
                place,
                spread * 1e3
            )?;
        }
        if self.further_breaks > 0 {
            write!(f, ", {} times more elsewhere", self.further_breaks)?;
        }
        if let Some(left) = self.tension_left.filter(|_| self.mode != Mode::Whole) {
            write!(
                f,
                "; what is left could carry {:.1} % of the tension that the whole could",
                100.0 * left
            )?;
        }
        writeln!(f)?;
        if self.mode != Mode::Whole {
            let shares: Vec<String> = (self.pieces.iter())
                .map(|p| format!("{:.1} %", 100.0 * p.share))
                .collect();
            write!(f, "pieces   {} of {}", self.pieces.len(), shares.join(", "))?;
            if self.splinters > 0 {
                write!(
                    f,
                    ", and {} splinters of {:.1} % in all",
                    self.splinters,
                    100.0 * self.splinter_share
                )?;
            }
            writeln!(f)?;
        }
        if self.greatest_load_n > 0.0 {
            writeln!(
                f,
                "load     at most {:.1} N and {:.2} N m; at the end {:.1} % and {:.1} % of it",
                self.greatest_load_n,
                self.greatest_moment_nm,
                100.0 * self.load_left,
                100.0 * self.moment_left
            )?;
        }
        Ok(())
    }
}
