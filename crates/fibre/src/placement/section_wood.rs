//! The wood of each rod of a cross-section, from the structure of the stem.
//!
//! The structure is relative to the mean of the species' wood. A rod has its mean over the rod's cell, since fibres side by
//! side share their strain. What is wood is then scaled so that the section returns the table:
//!
//! - density: the mass of the wood is that of as much wood of the mean density;
//! - modulus along the grain: the bending stiffness of the wood, the mean of all directions, is E I. (The table's modulus is
//!   that of bending tests. A section that is stiffer outside than inside, as juvenile wood makes it, then has less than E A
//!   in tension: no section has both unless its modulus has no trend.)
//! - strength along the grain: the moment that the wood bears before its first rod breaks, the mean of all directions, is that
//!   of even wood, with rods that yield in compression;
//! - across the grain: the mean of all facets, by their width. The table's values are means of tests along and across rings
//!   (Wood Handbook, chapter 5, "Annual ring orientation") and contain the weak planes.
//!
//! Bark is not scaled.

use super::material::WoodMaterial;
use super::section_moment::{Element, moment_capacity};
use super::voronoi::VoronoiCell;
use glam::DVec2;
use greenstick_wood::rings::StemAddress;
use greenstick_wood::stem::Stem;
use greenstick_wood::structure::{LocalWood, WoodStructure};
use greenstick_wood::tissue::Zone;
use std::f64::consts::TAU;

/// Samples of a cell for each width of a ring, and the least and greatest number along an edge of a triangle of it.
const SAMPLES_PER_RING: f64 = 4.0;
const SAMPLE_RANGE: (f64, f64) = (2.0, 12.0);

/// The wood of one rod.
#[derive(Debug, Clone, PartialEq)]
pub struct RodWood {
    /// The tissue that takes most of its cell.
    pub tissue: Zone,
    /// Its properties.
    pub material: WoodMaterial,
}

/// The wood of a section's rods, and the strength of the planes between them.
#[derive(Debug, Clone)]
pub(super) struct SectionWood<'a> {
    pub rods: Vec<RodWood>,
    structured: Option<Structured<'a>>,
}

#[derive(Debug, Clone)]
struct Structured<'a> {
    structure: &'a WoodStructure,
    rods: Vec<CellMean>,
    /// The annual ring at each rod.
    rings: Vec<i64>,
    planes: PlaneScale,
}

/// What scales the means over all facets to the table's.
#[derive(Debug, Clone, Copy)]
struct PlaneScale {
    modulus: f64,
    tension: f64,
    shear: f64,
}

/// Stiffness and strength of a facet relative to the table's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacetWood {
    pub modulus: f64,
    pub tension: f64,
    pub shear: f64,
}

const EVEN: FacetWood = FacetWood {
    modulus: 1.0,
    tension: 1.0,
    shear: 1.0,
};

/// Means over a cell, of its wood and of its bark, each over the whole cell's area.
#[derive(Debug, Clone, Copy, Default)]
struct CellMean {
    wood: Sums,
    bark: Sums,
    /// Part of the cell that each zone takes, by its code.
    zones: [f64; 5],
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    part: f64,
    density: f64,
    modulus: f64,
    strength: f64,
    modulus_across: f64,
    tension_across: f64,
    shear: f64,
}

impl Sums {
    fn add(&mut self, local: &LocalWood, weight: f64) {
        self.part += weight;
        self.density += weight * local.density;
        self.modulus += weight * local.modulus;
        self.strength += weight * local.strength;
        self.modulus_across += weight * local.modulus_across;
        self.tension_across += weight * local.tension_across;
        self.shear += weight * local.shear;
    }
}

impl CellMean {
    fn new(stem: &Stem, structure: &WoodStructure, cell: &VoronoiCell, along: f64) -> Self {
        let pith = stem.rings.pith();
        let mut mean = CellMean::default();
        for (point, weight) in samples(cell, ring_width(stem, structure)) {
            let (rho, angle) = stem.rings.address(point);
            let address = StemAddress {
                // Relief may lie beyond the outermost ring.
                rho: rho.min(1.0),
                angle,
                across: point - pith,
                along,
            };
            let Some(local) = structure.at(&address) else {
                continue;
            };
            mean.zones[usize::from(local.tissue.code())] += weight;
            let sums = if local.is_wood() {
                &mut mean.wood
            } else {
                &mut mean.bark
            };
            sums.add(&local, weight);
        }
        mean
    }

    fn tissue(&self) -> Zone {
        let largest = |a: &Zone, b: &Zone| {
            let part = |z: &Zone| self.zones[usize::from(z.code())];
            part(a).total_cmp(&part(b))
        };
        Zone::ALL
            .into_iter()
            .max_by(largest)
            .unwrap_or(Zone::Sapwood)
    }

    fn is_wood(&self) -> bool {
        self.wood.part >= self.bark.part
    }
}

/// Mean width of a ring, m.
fn ring_width(stem: &Stem, structure: &WoodStructure) -> f64 {
    stem.rings.outer_radius(0.0) * structure.mean_ring_width()
}

/// Points of a cell and the part of its area that each stands for: the triangles about its centroid, each divided into
/// equal ones.
fn samples(cell: &VoronoiCell, ring_width: f64) -> impl Iterator<Item = (DVec2, f64)> + '_ {
    let count = cell.corners.len();
    (0..count).flat_map(move |i| {
        let (a, b) = (cell.corners[i], cell.corners[(i + 1) % count]);
        let [p, q] = [a - cell.centroid, b - cell.centroid];
        let reach = p.length().max(q.length());
        let divisions = (SAMPLES_PER_RING * reach / ring_width).ceil();
        let n = divisions.clamp(SAMPLE_RANGE.0, SAMPLE_RANGE.1) as u32;
        let weight = 0.5 * p.perp_dot(q) / (cell.area * f64::from(n * n));
        let at = move |u: f64, v: f64| cell.centroid + (p * u + q * v) / f64::from(n);
        let upright = (0..n).flat_map(move |j| (0..n - j).map(move |k| (j, k, 1.0 / 3.0)));
        let inverted =
            (0..n.max(1) - 1).flat_map(move |j| (0..n - 1 - j).map(move |k| (j, k, 2.0 / 3.0)));
        upright
            .chain(inverted)
            .map(move |(j, k, shift)| (at(f64::from(j) + shift, f64::from(k) + shift), weight))
    })
}

impl<'a> SectionWood<'a> {
    /// The wood of rods that are all alike.
    pub fn even(wood: &WoodMaterial, rods: usize) -> Self {
        let rod = RodWood {
            tissue: Zone::Sapwood,
            material: *wood,
        };
        SectionWood {
            rods: vec![rod; rods],
            structured: None,
        }
    }

    /// The wood of rods by their cells in the section at the length `along` (m) of the stem.
    pub fn structured(
        stem: &Stem,
        wood: &WoodMaterial,
        structure: &'a WoodStructure,
        cells: &[VoronoiCell],
        along: f64,
    ) -> Self {
        let means: Vec<CellMean> = cells
            .iter()
            .map(|cell| CellMean::new(stem, structure, cell, along))
            .collect();
        let scale = SectionScale::new(wood, &means, cells);
        let rods = means.iter().map(|mean| scale.rod(wood, mean)).collect();
        let ring = |cell: &VoronoiCell| {
            let (rho, angle) = stem.rings.address(cell.centroid);
            let address = StemAddress {
                rho: rho.min(1.0),
                angle,
                across: cell.centroid - stem.rings.pith(),
                along,
            };
            structure.at(&address).map_or(0, |local| local.ring)
        };
        let mut structured = Structured {
            structure,
            rods: means,
            rings: cells.iter().map(ring).collect(),
            planes: PlaneScale {
                modulus: 1.0,
                tension: 1.0,
                shear: 1.0,
            },
        };
        structured.planes = structured.plane_scale(stem, cells);
        SectionWood {
            rods,
            structured: Some(structured),
        }
    }

    /// Returns the facet between two rods. `radial` is the part (cos²) of its normal across the rings.
    pub fn facet(&self, [p, q]: [usize; 2], radial: f64) -> FacetWood {
        let Some(structured) = &self.structured else {
            return EVEN;
        };
        let own = structured.facet([p, q], radial);
        let scale = structured.planes;
        FacetWood {
            modulus: own.modulus * scale.modulus,
            tension: own.tension * scale.tension,
            shear: own.shear * scale.shear,
        }
    }
}

/// Returns the part (cos²) of the normal of the facet between two rods that points across the rings.
pub(super) fn radial_part(stem: &Stem, [p, q]: [DVec2; 2]) -> f64 {
    let radial = (p.midpoint(q) - stem.rings.pith()).normalize_or_zero();
    let direction = (q - p).normalize_or_zero().dot(radial);
    direction * direction
}

impl Structured<'_> {
    /// Returns a facet before it is scaled: as stiff as half of each rod in a row, as strong as the weaker of them or the
    /// plane between them.
    fn facet(&self, [p, q]: [usize; 2], radial: f64) -> FacetWood {
        let [a, b] = [&self.rods[p], &self.rods[q]].map(|mean| {
            let sum = |f: fn(&Sums) -> f64| f(&mean.wood) + f(&mean.bark);
            FacetWood {
                modulus: sum(|s| s.modulus_across),
                tension: sum(|s| s.tension_across),
                shear: sum(|s| s.shear),
            }
        });
        let weaker = [a.tension.min(b.tension), a.shear.min(b.shear)];
        let ray = self.structure.ray_plane();
        let crosses = self.rings[p] != self.rings[q];
        let plane = self.structure.ring_plane();
        let strength = |k: usize| {
            let along_rings = if crosses {
                weaker[k].min(plane[k])
            } else {
                weaker[k]
            };
            radial * along_rings + (1.0 - radial) * weaker[k] * ray
        };
        FacetWood {
            modulus: 2.0 * a.modulus * b.modulus / (a.modulus + b.modulus).max(f64::MIN_POSITIVE),
            tension: strength(0),
            shear: strength(1),
        }
    }

    /// Compares all facets between rods of wood with the table's mean.
    fn plane_scale(&self, stem: &Stem, cells: &[VoronoiCell]) -> PlaneScale {
        let (mut width, mut sum) = (0.0, [0.0; 3]);
        for (p, cell) in cells.iter().enumerate() {
            for facet in &cell.facets {
                let q = facet.neighbour as usize;
                if !(self.rods[p].is_wood() && self.rods[q].is_wood()) {
                    continue;
                }
                let radial = radial_part(stem, [cell.centroid, cells[q].centroid]);
                let own = self.facet([p, q], radial);
                width += facet.width;
                for (sum, value) in sum.iter_mut().zip([own.modulus, own.tension, own.shear]) {
                    *sum += facet.width * value;
                }
            }
        }
        let scale = |sum: f64| if sum > 0.0 { width / sum } else { 1.0 };
        PlaneScale {
            modulus: scale(sum[0]),
            tension: scale(sum[1]),
            shear: scale(sum[2]),
        }
    }
}

/// What scales the wood of a section to the table's means.
#[derive(Debug, Clone, Copy)]
struct SectionScale {
    density: f64,
    modulus: f64,
    strength: f64,
    across: f64,
}

impl SectionScale {
    fn new(wood: &WoodMaterial, means: &[CellMean], cells: &[VoronoiCell]) -> Self {
        let total = |f: &dyn Fn(&Sums) -> f64| {
            let pairs = means.iter().zip(cells);
            pairs.fold(0.0, |sum, (mean, cell)| sum + cell.area * f(&mean.wood))
        };
        let area = total(&|s| s.part);
        if area <= 0.0 {
            return SectionScale {
                density: 1.0,
                modulus: 1.0,
                strength: 1.0,
                across: 1.0,
            };
        }
        let second = |f: &dyn Fn(&Sums) -> f64| {
            let whole = total(f);
            let centre = means.iter().zip(cells).fold(DVec2::ZERO, |sum, (m, c)| {
                sum + c.centroid * (c.area * f(&m.wood) / whole)
            });
            means.iter().zip(cells).fold(0.0, |sum, (m, c)| {
                let own = c.area / TAU;
                sum + c.area * f(&m.wood) * (c.centroid.distance_squared(centre) + own)
            })
        };
        let modulus = second(&|s| s.part) / second(&|s| s.modulus);
        let elements = |structured: bool| -> Vec<Element> {
            let element = |(mean, cell): (&CellMean, &VoronoiCell)| {
                let own = mean.wood;
                let (stiff, strong) = if structured {
                    (own.modulus * modulus, own.strength)
                } else {
                    (own.part, own.part)
                };
                Element {
                    position: cell.centroid,
                    area: cell.area,
                    modulus: wood.longitudinal * stiff,
                    tension: wood.tension * strong,
                    compression: wood.compression * strong,
                }
            };
            let wooden = means.iter().zip(cells).filter(|(m, _)| m.is_wood());
            wooden.map(element).collect()
        };
        SectionScale {
            density: area / total(&|s| s.density),
            modulus,
            strength: moment_capacity(&elements(false)) / moment_capacity(&elements(true)),
            across: area / total(&|s| s.modulus_across),
        }
    }

    /// Returns the wood of a rod.
    fn rod(&self, wood: &WoodMaterial, mean: &CellMean) -> RodWood {
        let CellMean {
            wood: own, bark, ..
        } = mean;
        let modulus = own.modulus * self.modulus + bark.modulus;
        let strength = own.strength * self.strength + bark.strength;
        let across = own.modulus_across * self.across + bark.modulus_across;
        RodWood {
            tissue: mean.tissue(),
            material: WoodMaterial {
                density: wood.density * (own.density * self.density + bark.density),
                longitudinal: wood.longitudinal * modulus,
                radial: wood.radial * across,
                tangential: wood.tangential * across,
                shear_radial: wood.shear_radial * across,
                shear_tangential: wood.shear_tangential * across,
                tension: wood.tension * strength,
                compression: wood.compression * strength,
                compression_across: wood.compression_across
                    * (own.tension_across + bark.tension_across),
                tension_across: wood.tension_across * (own.tension_across + bark.tension_across),
                shear: wood.shear * (own.shear + bark.shear),
                fracture_energy: wood.fracture_energy * (own.tension_across + bark.tension_across),
            },
        }
    }
}
