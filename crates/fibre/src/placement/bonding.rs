//! Bonds of a placed bundle: from every vertex to the nearest point of each neighbouring rod within reach, with stiffness
//! and strength from the species through the facet's area (`model.md` §3).
//!
//! Both rods of a facet bond to each other, so each bond stands for half of its vertex's length of the facet:
//! ℓ = ½ · l/2, S = ½ G w ℓ d₀, k_t = E_⊥ w ℓ. G and E_⊥ lie between the radial and the tangential value by the square of
//! the facet's direction.

use super::cells::Cell;
use super::{Placement, WoodMaterial, weibull};
use crate::bonds::Bond;
use crate::bundle::Bundle;
use glam::DVec2;
use greenstick_wood::noise::unit;
use greenstick_wood::stem::Stem;
use std::f64::consts::TAU;

/// Facets narrower than this part of the distance of their rods join nothing.
const NARROW: f64 = 1e-3;

/// What a facet is.
struct Facet {
    width: f64,
    /// Modulus across it and shear modulus along it, Pa.
    across: f64,
    shear: f64,
    /// Strength relative to that of wood without weak planes.
    strength: f64,
}

fn facet(
    stem: &Stem,
    wood: &WoodMaterial,
    options: &Placement,
    (p, q): (DVec2, DVec2),
    width: f64,
) -> Facet {
    let radial = (p.midpoint(q) - stem.rings.pith()).normalize_or_zero();
    let direction = (q - p).normalize_or_zero().dot(radial);
    let part = direction * direction;
    let mix = |r: f64, t: f64| t + (r - t) * part;
    let ((ring_p, angle_p), (ring_q, angle_q)) = (stem.rings.address(p), stem.rings.address(q));
    let differs = |count: u32, a: f64, b: f64| {
        let slot = |v: f64| (v * f64::from(count)).floor();
        count > 0 && slot(a) != slot(b)
    };
    let mut strength = 1.0;
    if part > 0.5 && differs(options.rings, ring_p, ring_q) {
        strength *= options.ring_strength;
    }
    if part <= 0.5 && differs(options.rays, angle_p / TAU, angle_q / TAU) {
        strength *= options.ray_strength;
    }
    Facet {
        width,
        across: mix(wood.radial, wood.tangential),
        shear: mix(wood.shear_radial, wood.shear_tangential),
        strength,
    }
}

/// The nearest point to vertex `i` on rod `rod`: edge, place on it, distance and cosine. Vertices of the rod ascend in
/// length along the axis, so only edges near the vertex's own length are looked at.
fn nearest(bundle: &Bundle, along: &[f64], i: usize, rod: usize) -> Option<(usize, f64, f64, f64)> {
    let range = bundle.rod(rod);
    let last = range.end - 2;
    let k = range.start + along[range.clone()].partition_point(|&s| s <= along[i]);
    let low = k.saturating_sub(3).clamp(range.start, last);
    let x = bundle.rest.get(i);
    (low..=(low + 4).min(last))
        .map(|j| {
            let (a, b) = (bundle.rest.get(j), bundle.rest.get(j + 1));
            let e = b - a;
            let t = ((x - a).dot(e) / e.length_squared()).clamp(0.0, 1.0);
            let d = x - (a + e * t);
            (j, t, d.length(), e.dot(d) / (e.length() * d.length()))
        })
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .filter(|n| n.2 > 0.0)
}

/// All bonds of a bundle placed in a stem.
pub(super) fn bonds(
    stem: &Stem,
    wood: &WoodMaterial,
    options: &Placement,
    bundle: &Bundle,
    cells: &[Cell],
    along: &[f64],
) -> Vec<Bond> {
    let area: f64 = cells.iter().map(|c| c.area).sum();
    let reach = options.reach * (area / cells.len().max(1) as f64).sqrt();
    let mut made = Vec::new();
    for (number, cell) in cells.iter().enumerate() {
        for &(other, width) in &cell.facets {
            let (p, q) = (cell.centroid, cells[other as usize].centroid);
            let distance = p.distance(q);
            if distance > reach || width < NARROW * distance {
                continue;
            }
            let facet = facet(stem, wood, options, (p, q), width);
            for i in bundle.rod(number) {
                let Some((edge, t, d0, cosine)) = nearest(bundle, along, i, other as usize) else {
                    continue;
                };
                let length = 0.25 * bundle.both_lengths(i);
                let scale = stem.grain.scale(along[i]);
                let area = facet.width * scale * length;
                let scatter = weibull(
                    options.weibull,
                    unit(options.seed ^ 0xb0d5, i as i64, i64::from(other), 0),
                );
                let strength = facet.strength * scatter * area;
                made.push(Bond {
                    vertex: i as u32,
                    edge: edge as u32,
                    t,
                    distance: d0,
                    rest_cosine: cosine.clamp(-1.0, 1.0),
                    transverse: facet.across * area,
                    shear: 0.5 * facet.shear * area * d0,
                    area,
                    tension_strength: wood.tension_across * strength,
                    shear_strength: wood.shear * strength,
                    fracture_energy: wood.fracture_energy * strength,
                });
            }
        }
    }
    made
}
