//! The wood of each rod of a cross-section, from the structure of the stem.
//!
//! The structure is relative to the mean of the species' wood. A rod has its mean over the rod's cell, since fibres side by
//! side share their strain. What is wood is then scaled so that the section returns the table:
//!
//! - density: the mass of the wood is that of as much wood of the mean density;
//! - modulus along the grain: the bending stiffness of the wood, the mean of all directions, is E I. (The table's modulus is
//!   that of bending tests. A section that is stiffer outside than inside, as juvenile wood makes it, then has less than E A
//!   in tension: no section has both unless its modulus has no trend.)
//! - crushing strength: its mean is the table's;
//! - tensile strength: the moment that the wood bears before its first rod breaks, the mean of all directions (of a board, of
//!   those across its faces), is that of a solid section of even wood that yields in compression. The table's modulus of
//!   rupture is such a moment, and a few rods of the table's strengths bear another ([`section_moment`](super::section_moment));
//! - across the grain: the mean of all facets, by their width. The table's values are means of tests along and across rings
//!   (Wood Handbook, chapter 5, "Annual ring orientation") and contain the weak planes.
//!
//! Bark is not scaled.

use super::material::WoodMaterial;
use super::section_moment::{
    Element, EvenWood, bending_directions, solid_moment_capacity, tension_factor,
};
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
        let ring_width = ring_width(stem, structure);
        let divisions = |reach: f64| {
            let wanted = (SAMPLES_PER_RING * reach / ring_width).ceil();
            wanted.clamp(SAMPLE_RANGE.0, SAMPLE_RANGE.1) as u32
        };
        for (point, weight) in cell.samples(divisions) {
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

    /// The wood of rods by their cells in the section, whose outline is given, at the length `along` (m) of the stem.
    pub fn structured(
        stem: &Stem,
        wood: &WoodMaterial,
        structure: &'a WoodStructure,
        (outline, cells): (&[DVec2], &[VoronoiCell]),
        along: f64,
    ) -> Self {
        let means: Vec<CellMean> = cells
            .iter()
            .map(|cell| CellMean::new(stem, structure, cell, along))
            .collect();
        let directions = bending_directions(stem.kind, outline);
        let scale = SectionScale::new(wood, &means, cells, &directions);
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
    tension: f64,
    compression: f64,
    across: f64,
}

impl SectionScale {
    fn new(
        wood: &WoodMaterial,
        means: &[CellMean],
        cells: &[VoronoiCell],
        directions: &[DVec2],
    ) -> Self {
        let total = |f: &dyn Fn(&Sums) -> f64| {
            let pairs = means.iter().zip(cells);
            pairs.fold(0.0, |sum, (mean, cell)| sum + cell.area * f(&mean.wood))
        };
        let area = total(&|s| s.part);
        if area <= 0.0 {
            return SectionScale {
                density: 1.0,
                modulus: 1.0,
                tension: 1.0,
                compression: 1.0,
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
        let compression = area / total(&|s| s.strength);
        let wooden = || means.iter().zip(cells).filter(|(mean, _)| mean.is_wood());
        let rod = |(mean, cell): (&CellMean, &VoronoiCell)| Element {
            position: cell.centroid,
            area: cell.area,
            radius: Element::rod_radius(cell.area),
            modulus: wood.longitudinal * mean.wood.modulus * modulus,
            tension: wood.tension * mean.wood.strength,
            compression: wood.compression * mean.wood.strength * compression,
        };
        let rods: Vec<Element> = wooden().map(rod).collect();
        let solid: Vec<(&VoronoiCell, f64)> = wooden().map(|(m, c)| (c, m.wood.part)).collect();
        let even = EvenWood {
            modulus: wood.longitudinal,
            tension: wood.tension,
            compression: wood.compression,
        };
        let solid_moment = solid_moment_capacity(&solid, directions, even);
        SectionScale {
            density: area / total(&|s| s.density),
            modulus,
            tension: tension_factor(&rods, directions, solid_moment),
            compression,
            across: area / total(&|s| s.modulus_across),
        }
    }

    /// Returns the wood of a rod.
    fn rod(&self, wood: &WoodMaterial, mean: &CellMean) -> RodWood {
        let CellMean {
            wood: own, bark, ..
        } = mean;
        let modulus = own.modulus * self.modulus + bark.modulus;
        let tension = own.strength * self.tension + bark.strength;
        let compression = own.strength * self.compression + bark.strength;
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
                tension: wood.tension * tension,
                compression: wood.compression * compression,
                compression_across: wood.compression_across
                    * (own.tension_across + bark.tension_across),
                tension_across: wood.tension_across * (own.tension_across + bark.tension_across),
                shear: wood.shear * (own.shear + bark.shear),
                fracture_energy: wood.fracture_energy * (own.tension_across + bark.tension_across),
            },
        }
    }
}
