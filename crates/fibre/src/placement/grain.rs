//! Rods whose grain is not along the stem: stiffness and strength along the rod by the angle of the grain there.

use super::section_wood::RodWood;
use super::voronoi::VoronoiCell;
use crate::rod_bundle::RodBundle;
use greenstick_wood::stem::Stem;
use greenstick_wood::structure::WoodStructure;

/// What an angle of the grain leaves of a rod's properties.
struct Remaining {
    modulus: f64,
    /// Strain at tensile failure.
    tension_limit: f64,
    /// Strain at which the rod yields.
    yield_strain: f64,
}

/// Gives rods the stiffness and strength of their grain: of each edge in its middle, of each vertex there.
pub(super) fn apply_grain(
    bundle: &mut RodBundle,
    stem: &Stem,
    structure: &WoodStructure,
    (rods, cells): (&[RodWood], &[VoronoiCell]),
    along: &[f64],
) {
    let grain = structure.grain();
    if grain.is_straight() {
        return;
    }
    for rod in 0..bundle.rods() {
        let material = rods[rod].material;
        let (rho, _) = stem.rings.address(cells[rod].centroid);
        let ring = rho / structure.mean_ring_width();
        let remaining = |s: f64| {
            let turned = material.at_grain_angle(grain.angle(rho, ring, s));
            let modulus = turned.longitudinal / material.longitudinal;
            Remaining {
                modulus,
                tension_limit: turned.tension / material.tension / modulus,
                yield_strain: turned.compression / material.compression / modulus,
            }
        };
        for i in bundle.rod(rod) {
            let own = remaining(along[i]);
            bundle.bend[i] *= own.modulus;
            bundle.tension_limit[i] *= own.tension_limit;
            if bundle.is_edge(i) {
                let middle = remaining(0.5 * (along[i] + along[i + 1]));
                bundle.stretch[i] *= middle.modulus;
                bundle.yield_strain[i] *= middle.yield_strain;
            }
        }
    }
}
