//! Where in the section, how high and for what cause the rods of a run broke.

use super::statistics::{Weighted, quantile};
use crate::rods::{FractureState, Wood};
use glam::{DVec2, DVec3};
use greenstick_fibre::Cause;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_wood::stem::{Stem, StemKind};
use greenstick_wood::tissue::Zone;
use std::collections::BTreeMap;

/// A break of a rod, before it has an address in the section.
#[derive(Debug, Clone, Copy)]
pub(super) struct BreakPoint {
    pub rod: u32,
    /// Area of the rod's cell, m².
    pub area: f64,
    /// Position at rest in the stem's world, m.
    pub world: DVec3,
    /// Length along the axis of the run's stem, m.
    pub along: f64,
    pub in_tension: bool,
}

/// A break of a rod along the stem.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BreakOnStem {
    pub rod: u32,
    /// Area of the rod's cell, m².
    pub area: f64,
    /// Length along the axis of the run's stem, m.
    pub along: f64,
}

impl BreakPoint {
    fn on_stem(&self) -> BreakOnStem {
        BreakOnStem {
            rod: self.rod,
            area: self.area,
            along: self.along,
        }
    }
}

/// A break of a rod by its address in the section.
#[derive(Debug, Clone, Copy)]
pub(super) struct AddressedBreak {
    pub rod: u32,
    /// Part of the area of all breaks.
    pub weight: f64,
    /// Ring coordinate.
    pub ring: f64,
    /// Angle about the pith, degrees.
    pub angle: f64,
    pub zone: Zone,
    /// Offset from the pith, radii.
    pub across: DVec2,
    /// Position in the coordinates of the compression shelf, −1 to 1.
    pub shelf: DVec2,
    /// Height over the location of the break, radii.
    pub height: f64,
    pub in_tension: bool,
}

/// The break of the stem in which most of the section broke.
pub(super) struct MainBreak {
    /// One break of each rod that broke: the one nearest to where most of the wood broke.
    pub broken: Vec<BreakPoint>,
    /// The rods that did not break there, at the middle of the break.
    pub whole: Vec<BreakPoint>,
    /// Number of further breaks of the same rods.
    pub repeated: usize,
    /// Number of breaks elsewhere along the stem.
    pub elsewhere: usize,
}

/// Breaks of rods with a longer stretch between them than this, radii, and none on it, are two breaks of the stem.
pub(crate) const MAX_GAP: f64 = 4.0;

impl MainBreak {
    /// Finds the main break of a bundle.
    pub fn find(wood: &Wood, state: &FractureState) -> MainBreak {
        let point = |rod: usize, along: f64, in_tension: bool| {
            let cell = &wood.cells[rod];
            let grain = DVec3::new(cell.centroid.x, cell.centroid.y, along);
            BreakPoint {
                rod: rod as u32,
                area: cell.area,
                world: wood.stem.grain.to_world(grain),
                along,
                in_tension,
            }
        };
        let mut all: Vec<BreakPoint> = Vec::new();
        for (rod, breaks) in state.breaks.iter().enumerate() {
            for found in breaks {
                let along = wood.along[found.vertex as usize];
                all.push(point(rod, along, found.cause != Cause::Compression));
            }
        }
        let spans: Vec<BreakOnStem> = all.iter().map(BreakPoint::on_stem).collect();
        let range = main_range(&spans, MAX_GAP * wood.stem.radius);
        let here: Vec<BreakPoint> = all
            .iter()
            .filter(|b| b.along >= range.low && b.along <= range.high)
            .copied()
            .collect();
        let lengths = here.iter().map(|b| Weighted {
            value: b.along,
            weight: b.area,
        });
        let middle = quantile(&lengths.collect::<Vec<_>>(), 0.5);
        let broken = nearest_of_each_rod(&here, middle);
        let mut whole = vec![true; state.breaks.len()];
        broken.iter().for_each(|b| whole[b.rod as usize] = false);
        MainBreak {
            whole: (0..whole.len())
                .filter(|&rod| whole[rod])
                .map(|rod| point(rod, middle, false))
                .collect(),
            repeated: here.len() - broken.len(),
            elsewhere: all.len() - here.len(),
            broken,
        }
    }

    /// Broken rods, then whole ones.
    pub fn section(&self) -> Vec<BreakPoint> {
        self.broken.iter().chain(&self.whole).copied().collect()
    }

    /// Pairs of broken rods, by their number among these, that were bonded.
    pub fn neighbours(&self, wood: &Wood) -> Vec<[usize; 2]> {
        let broken = self.broken.iter().enumerate();
        let number: BTreeMap<u32, usize> = broken.map(|(i, b)| (b.rod, i)).collect();
        wood.bonded_rods()
            .iter()
            .filter_map(|(a, b)| Some([*number.get(a)?, *number.get(b)?]))
            .collect()
    }
}

/// The break of each rod that is nearest to the length `middle`, m; breaks are sorted by rod.
fn nearest_of_each_rod(breaks: &[BreakPoint], middle: f64) -> Vec<BreakPoint> {
    let mut nearest: Vec<BreakPoint> = Vec::new();
    for found in breaks {
        match nearest.last_mut() {
            Some(last) if last.rod == found.rod => {
                if (found.along - middle).abs() < (last.along - middle).abs() {
                    *last = *found;
                }
            }
            _ => nearest.push(*found),
        }
    }
    nearest
}

/// A range of lengths along the axis, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct LengthRange {
    pub low: f64,
    pub high: f64,
}

/// The lengths between which most of the section broke, with no gap of more than `gap` (m) between breaks.
pub(crate) fn main_range(all: &[BreakOnStem], gap: f64) -> LengthRange {
    let mut sorted: Vec<&BreakOnStem> = all.iter().collect();
    sorted.sort_by(|a, b| a.along.total_cmp(&b.along));
    let (mut largest_area, mut main) = (0.0, LengthRange::default());
    for group in sorted.chunk_by(|a, b| b.along - a.along <= gap) {
        let mut rods: Vec<(u32, f64)> = group.iter().map(|b| (b.rod, b.area)).collect();
        rods.sort_by_key(|r| r.0);
        rods.dedup_by_key(|r| r.0);
        let area: f64 = rods.iter().map(|r| r.1).sum();
        if let (true, Some(first), Some(last)) = (area > largest_area, group.first(), group.last())
        {
            largest_area = area;
            main = LengthRange {
                low: first.along,
                high: last.along,
            };
        }
    }
    main
}

/// The section that breaks are addressed in.
pub(super) struct AddressSpace<'a> {
    /// The stem, located at the break.
    pub stem: &'a Stem,
    /// Outline of the run's section, m.
    pub outline: &'a [DVec2],
    /// World to grain coordinates, m.
    pub to_grain: &'a dyn Fn(DVec3) -> DVec3,
}

impl AddressSpace<'_> {
    /// Returns the addresses of breaks; their weights are parts of the sum of their areas.
    pub fn address(&self, breaks: &[BreakPoint]) -> Vec<AddressedBreak> {
        let area: f64 = breaks.iter().map(|b| b.area).sum();
        let proportions = BreakParameters::default().proportions();
        let stem = self.stem;
        let pith = stem.rings.pith();
        let outline = self.outline.iter().copied();
        let low = outline.clone().fold(DVec2::INFINITY, DVec2::min);
        let high = outline.fold(DVec2::NEG_INFINITY, DVec2::max);
        let address = |b: &BreakPoint| {
            let grain = (self.to_grain)(b.world);
            let at = grain.truncate();
            let (ring, angle) = stem.rings.address(at);
            let (sin, cos) = libm::sincos(angle);
            AddressedBreak {
                rod: b.rod,
                weight: b.area / area,
                ring,
                angle: angle.to_degrees(),
                zone: proportions.zone_at(ring, 0.0),
                across: (at - pith) / stem.radius,
                shelf: match stem.kind {
                    StemKind::Board | StemKind::Dowel => {
                        (at - 0.5 * (low + high)) / (0.5 * (high - low).max_element())
                    }
                    StemKind::Round | StemKind::Pole => DVec2::new(cos, sin) * ring,
                },
                height: (grain.z - stem.location) / stem.radius,
                in_tension: b.in_tension,
            }
        };
        breaks.iter().map(address).collect()
    }
}

/// Returns the mean distance along the axis between neighbouring vertices of a rod, m. Heights of breaks are no more
/// precise than that.
pub(crate) fn mean_edge_length(wood: &Wood) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for rod in 0..wood.bundle.rods() {
        for pair in wood.along[wood.bundle.rod(rod)].windows(2) {
            sum += (pair[1] - pair[0]).abs();
            count += 1;
        }
    }
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_break_of_most_rods_is_taken_and_not_that_of_most_breaks() {
        let point = |rod: u32, along: f64| BreakOnStem {
            rod,
            area: 1.0,
            along,
        };
        let range = |low: f64, high: f64| LengthRange { low, high };
        // One rod in five parts at one end, three rods once in the middle, no two farther than the gap from the next.
        let mut all: Vec<BreakOnStem> = (0..5).map(|i| point(0, 0.01 * f64::from(i))).collect();
        all.extend([point(1, 0.52), point(2, 0.44), point(3, 0.48)]);
        assert_eq!(main_range(&all, 0.05), range(0.44, 0.52));
        // With a smaller gap they are three breaks of one rod each, and the first of those counts.
        assert_eq!(main_range(&all, 0.02), range(0.0, 0.04));
        assert_eq!(main_range(&[], 0.02), range(0.0, 0.0));
    }
}
