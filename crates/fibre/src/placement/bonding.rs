//! Bonds of placed rods: from every vertex to the nearest point of each neighbouring rod within reach, with stiffness and
//! strength from the species through the facet's area.
//!
//! Both rods of a facet bond to each other, so that each bond represents half of its vertex's length of the facet:
//! ℓ = ½ · l/2, S = ½ G w ℓ d₀, k_t = E_⊥ w ℓ. G and E_⊥ are interpolated between the radial and the tangential value by the
//! square of the cosine of the facet's direction. The energy of fracture is that of the crack's plane, which facets of scattered
//! rods exceed in area ([`Arrangement::roughness`](super::options::Arrangement)).

use super::material::WoodMaterial;
use super::neighbours::bonded_facets;
use super::options::PlacementOptions;
use super::scatter::weibull;
use super::section_wood::{FacetWood, SectionWood, radial_part};
use super::voronoi::VoronoiCell;
use crate::bonds::Bond;
use crate::rod_bundle::RodBundle;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::noise::unit;
use greenstick_wood::stem::Stem;

/// The material of a facet between two rods.
pub(crate) struct FacetMaterial {
    /// Modulus of elasticity across it, Pa.
    across: f64,
    /// Shear modulus along it, Pa.
    shear: f64,
    /// Tensile strength across it, Pa.
    tension_strength: f64,
    /// Shear strength along it, Pa.
    shear_strength: f64,
    /// Fracture energy in opening and in shear along the grain, J/m² of the facet.
    fracture_energy: f64,
    shear_fracture_energy: f64,
}

impl FacetMaterial {
    /// Returns the material of a facet whose normal is radial to this part, from 0 (tangential) to 1.
    pub fn new(wood: &WoodMaterial, radial: f64) -> Self {
        let mix = |r: f64, t: f64| t + (r - t) * radial;
        FacetMaterial {
            across: mix(wood.radial, wood.tangential),
            shear: mix(wood.shear_radial, wood.shear_tangential),
            tension_strength: wood.tension_across,
            shear_strength: wood.shear,
            fracture_energy: wood.fracture_energy,
            shear_fracture_energy: wood.shear_fracture_energy(),
        }
    }

    /// Returns the material of facets along which a crack has `roughness` times the area of its plane, so that the plane takes
    /// the wood's energy of fracture.
    pub fn with_roughness(self, roughness: f64) -> Self {
        FacetMaterial {
            fracture_energy: self.fracture_energy / roughness,
            shear_fracture_energy: self.shear_fracture_energy / roughness,
            ..self
        }
    }

    fn scaled(self, relative: FacetWood) -> Self {
        FacetMaterial {
            across: self.across * relative.modulus,
            shear: self.shear * relative.modulus,
            tension_strength: self.tension_strength * relative.tension,
            shear_strength: self.shear_strength * relative.shear,
            fracture_energy: self.fracture_energy * relative.tension,
            shear_fracture_energy: self.shear_fracture_energy * relative.shear,
        }
    }

    /// Returns the bond of a vertex to the nearest point on another rod. It stands for `area` (m²) of the facet, and has
    /// `relative_strength` times the facet's strength and energy of fracture.
    pub fn bond(
        &self,
        vertex: usize,
        nearest: &NearestPoint,
        area: f64,
        relative_strength: f64,
    ) -> Bond {
        let strength = relative_strength * area;
        Bond {
            vertex: vertex as u32,
            edge: nearest.edge as u32,
            t: nearest.t,
            distance: nearest.distance,
            rest_cosine: nearest.cosine.clamp(-1.0, 1.0),
            transverse: self.across * area,
            shear: 0.5 * self.shear * area * nearest.distance,
            area,
            tension_strength: self.tension_strength * strength,
            shear_strength: self.shear_strength * strength,
            fracture_energy: self.fracture_energy * strength,
            shear_fracture_energy: self.shear_fracture_energy * strength,
            damage: 0.0,
        }
    }
}

/// The point on a rod that is nearest to a vertex.
pub(crate) struct NearestPoint {
    pub edge: usize,
    /// Parameter along the edge.
    pub t: f64,
    /// Distance from the vertex, m.
    pub distance: f64,
    /// Cosine of the angle between the edge and the direction to the vertex.
    pub cosine: f64,
}

/// Returns the nearest point to vertex `i` on rod `rod`. Vertices of a rod ascend in length along the axis, so that only edges
/// near the vertex's own length need testing.
fn nearest_point(bundle: &RodBundle, along: &[f64], i: usize, rod: usize) -> Option<NearestPoint> {
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
            NearestPoint {
                edge: j,
                t,
                distance: d.length(),
                cosine: e.dot(d) / (e.length() * d.length()),
            }
        })
        .min_by(|a, b| a.distance.total_cmp(&b.distance))
        .filter(|n| n.distance > 0.0)
}

/// Returns all bonds of a bundle placed in a stem.
///
/// # Errors
/// [`Cancelled`] where the caller cancels the work.
pub(super) fn bonds(
    stem: &Stem,
    (wood, section): (&WoodMaterial, &SectionWood),
    options: &PlacementOptions,
    bundle: &RodBundle,
    cells: &[VoronoiCell],
    along: &[f64],
    context: &Context,
) -> Result<Vec<Bond>, Cancelled> {
    let area: f64 = cells.iter().map(|c| c.area).sum();
    let reach = options.reach * (area / cells.len().max(1) as f64).sqrt();
    let facets = bonded_facets(options.neighbours, cells, reach);
    let mut bonds = Vec::new();
    for (number, cell) in cells.iter().enumerate() {
        context.report(number as f64 / cells.len() as f64)?;
        for &facet in &facets[number] {
            let (p, q) = (cell.centroid, cells[facet.neighbour as usize].centroid);
            let radial = radial_part(stem, [p, q]);
            let relative = section.facet([number, facet.neighbour as usize], radial);
            let material = FacetMaterial::new(wood, radial)
                .with_roughness(options.arrangement.roughness())
                .scaled(relative);
            for i in bundle.rod(number) {
                let other = facet.neighbour as usize;
                let Some(nearest) = nearest_point(bundle, along, i, other) else {
                    continue;
                };
                let length = 0.25 * bundle.both_lengths(i);
                let scale = stem.grain.scale(along[i]);
                let area = facet.width * scale * length;
                let uniform = unit(options.seed ^ 0xb0d5, i as i64, other as i64, 0);
                let scatter = weibull(options.weibull, uniform);
                bonds.push(material.bond(i, &nearest, area, scatter));
            }
        }
    }
    Ok(bonds)
}
