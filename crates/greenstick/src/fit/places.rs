//! Where in the section and how high the rods of a run broke.

use glam::{DVec2, DVec3};
use greenstick_fibre::Cause;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_skin::rods::{Parting, Wood};
use greenstick_wood::stem::{Stem, StemKind};
use greenstick_wood::tissue::Zone;

/// Where a rod broke, before it has an address.
#[derive(Debug, Clone, Copy)]
pub(super) struct Broke {
    pub rod: u32,
    /// Area of its cell, m².
    pub area: f64,
    /// At rest in the stem's world, m.
    pub world: DVec3,
    /// Length along the axis of the run's stem, m.
    pub along: f64,
    pub tension: bool,
}

/// Where a rod broke.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub rod: u32,
    /// Part of the area of all that broke.
    pub weight: f64,
    /// Ring coordinate.
    pub rho: f64,
    /// About the pith, degrees.
    pub angle: f64,
    pub zone: Zone,
    /// From the pith in radii.
    pub across: DVec2,
    /// As the compression shelf counts places: −1 to 1.
    pub shelf: DVec2,
    /// Height over the place of the break in radii.
    pub height: f64,
    pub tension: bool,
}

/// The value below which `part` of the weights lie. Values and weights are paired; 0 for none.
pub(super) fn quantile(values: &[(f64, f64)], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = sorted.iter().map(|v| v.1).sum();
    let mut below = 0.0;
    for (value, weight) in &sorted {
        below += weight;
        if below >= part * all {
            return *value;
        }
    }
    sorted.last().map_or(0.0, |v| v.0)
}

/// From the 5th to the 95th hundredth.
pub(super) fn spread(values: &[(f64, f64)]) -> f64 {
    quantile(values, 0.95) - quantile(values, 0.05)
}

/// Breaks of rods.
pub(super) struct Chosen {
    /// One of each rod that broke: the one nearest to where most of the wood broke.
    pub broke: Vec<Broke>,
    /// The rods that did not break there, at the middle of the break.
    pub whole: Vec<Broke>,
    /// Further breaks of the same rods.
    pub again: usize,
    /// Breaks at other places of the stem.
    pub elsewhere: usize,
}

/// Breaks that are farther from each other than this, in radii, with none between them, are two breaks of the stem.
const APART: f64 = 4.0;

/// The break in which most of the section broke.
pub(super) fn chosen(wood: &Wood, parting: &Parting) -> Chosen {
    let broke = |rod: usize, along: f64, tension: bool| {
        let cell = &wood.cells[rod];
        let at = DVec3::new(cell.centroid.x, cell.centroid.y, along);
        Broke {
            rod: rod as u32,
            area: cell.area,
            world: wood.stem.grain.to_world(at),
            along,
            tension,
        }
    };
    let mut all: Vec<Broke> = Vec::new();
    for (rod, breaks) in parting.breaks.iter().enumerate() {
        for found in breaks {
            let along = wood.along[found.vertex as usize];
            all.push(broke(rod, along, found.cause != Cause::Compression));
        }
    }
    let (from, to) = main_part(&all, APART * wood.stem.radius);
    let here: Vec<Broke> = all
        .iter()
        .filter(|b| b.along >= from && b.along <= to)
        .copied()
        .collect();
    let lengths: Vec<(f64, f64)> = here.iter().map(|b| (b.along, b.area)).collect();
    let middle = quantile(&lengths, 0.5);
    let mut kept: Vec<Broke> = Vec::new();
    for broke in &here {
        match kept.last_mut() {
            Some(last) if last.rod == broke.rod => {
                if (broke.along - middle).abs() < (last.along - middle).abs() {
                    *last = *broke;
                }
            }
            _ => kept.push(*broke),
        }
    }
    let mut whole = vec![true; parting.breaks.len()];
    kept.iter().for_each(|b| whole[b.rod as usize] = false);
    Chosen {
        whole: (0..whole.len())
            .filter(|&rod| whole[rod])
            .map(|rod| broke(rod, middle, false))
            .collect(),
        again: here.len() - kept.len(),
        elsewhere: all.len() - here.len(),
        broke: kept,
    }
}

/// The lengths between which most of the section broke, with no gap of more than `gap` (m) between breaks.
fn main_part(all: &[Broke], gap: f64) -> (f64, f64) {
    let mut sorted: Vec<&Broke> = all.iter().collect();
    sorted.sort_by(|a, b| a.along.total_cmp(&b.along));
    let parts = sorted.chunk_by(|a, b| b.along - a.along <= gap);
    let mut best = (0.0, (0.0, 0.0));
    for part in parts {
        let mut rods: Vec<(u32, f64)> = part.iter().map(|b| (b.rod, b.area)).collect();
        rods.sort_by_key(|r| r.0);
        rods.dedup_by_key(|r| r.0);
        let area: f64 = rods.iter().map(|r| r.1).sum();
        if let (true, Some(first), Some(last)) = (area > best.0, part.first(), part.last()) {
            best = (area, (first.along, last.along));
        }
    }
    best.1
}

/// The addresses of what broke, in `stem`, whose grain coordinates `to_grain` gives; weights are parts of `area` (m²).
pub(super) fn addressed(
    broke: &[Broke],
    area: f64,
    stem: &Stem,
    outline: &[DVec2],
    to_grain: impl Fn(DVec3) -> DVec3,
) -> Vec<Place> {
    let proportions = BreakParameters::default().proportions();
    let pith = stem.rings.pith();
    let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = outline
        .iter()
        .copied()
        .fold(DVec2::NEG_INFINITY, DVec2::max);
    broke
        .iter()
        .map(|b| {
            let grain = to_grain(b.world);
            let at = grain.truncate();
            let (rho, phi) = stem.rings.address(at);
            let (sin, cos) = libm::sincos(phi);
            Place {
                rod: b.rod,
                weight: b.area / area,
                rho,
                angle: phi.to_degrees(),
                zone: proportions.zone_at(rho, 0.0),
                across: (at - pith) / stem.radius,
                shelf: match stem.kind {
                    StemKind::Board => {
                        (at - 0.5 * (low + high)) / (0.5 * (high - low).max_element())
                    }
                    StemKind::Round => DVec2::new(cos, sin) * rho,
                },
                height: (grain.z - stem.location) / stem.radius,
                tension: b.tension,
            }
        })
        .collect()
}

/// Mean distance along the axis between neighbouring vertices of a rod, m: no height is known better.
pub(super) fn edge(wood: &Wood) -> f64 {
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
        let broke = |rod: u32, along: f64| Broke {
            rod,
            area: 1.0,
            world: DVec3::ZERO,
            along,
            tension: true,
        };
        // One rod in five parts at one end, three rods once in the middle, no two farther than the gap from the next.
        let mut all: Vec<Broke> = (0..5).map(|i| broke(0, 0.01 * f64::from(i))).collect();
        all.extend([broke(1, 0.52), broke(2, 0.44), broke(3, 0.48)]);
        assert_eq!(main_part(&all, 0.05), (0.44, 0.52));
        // With a smaller gap they are three breaks of one rod each, and the first of those counts.
        assert_eq!(main_part(&all, 0.02), (0.0, 0.04));
        assert_eq!(main_part(&[], 0.02), (0.0, 0.0));
    }
}
