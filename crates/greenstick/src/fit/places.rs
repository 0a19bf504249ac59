//! Where in the section and how high the rods of a run broke.

use glam::{DVec2, DVec3};
use greenstick_fibre::event::Cause;
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

/// One break of each broken rod: the one nearest to where most of the wood broke. With it the number of breaks that
/// were left out.
pub(super) fn chosen(wood: &Wood, parting: &Parting) -> (Vec<Broke>, usize) {
    let mut all = Vec::new();
    for (rod, breaks) in parting.breaks.iter().enumerate() {
        let cell = &wood.cells[rod];
        for found in breaks {
            let along = wood.along[found.vertex as usize];
            let at = DVec3::new(cell.centroid.x, cell.centroid.y, along);
            all.push(Broke {
                rod: rod as u32,
                area: cell.area,
                world: wood.stem.grain.to_world(at),
                along,
                tension: found.cause != Cause::Compression,
            });
        }
    }
    let middle = quantile(
        &all.iter().map(|b| (b.along, b.area)).collect::<Vec<_>>(),
        0.5,
    );
    let mut kept: Vec<Broke> = Vec::new();
    let count = all.len();
    for broke in all {
        match kept.last_mut() {
            Some(last) if last.rod == broke.rod => {
                if (broke.along - middle).abs() < (last.along - middle).abs() {
                    *last = broke;
                }
            }
            _ => kept.push(broke),
        }
    }
    let left = count - kept.len();
    (kept, left)
}

/// The addresses of what broke, in `stem`, whose grain coordinates `to_grain` gives.
pub(super) fn addressed(
    broke: &[Broke],
    stem: &Stem,
    outline: &[DVec2],
    to_grain: impl Fn(DVec3) -> DVec3,
) -> Vec<Place> {
    let area: f64 = broke.iter().map(|b| b.area).sum();
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
                height: (grain.z - stem.place) / stem.radius,
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
