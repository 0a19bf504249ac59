//! From a stem to a bundle: rods along the grain, their cells, and bonds between neighbours (Sutherland 2012 §3.3;
//! physical constants of `model.md` §3).
//!
//! Rods run at constant grain coordinates, so they follow a curved and tapering axis; sections and stiffness shrink with
//! the taper. A rod lies at the centroid of its cell, so that the rods' places and own bending stiffness together give
//! the section's bending stiffness.

pub mod bonding;
pub mod cells;
pub mod material;
pub mod points;

use crate::bundle::{Bundle, Rod, RodMaterial};
use crate::error::BundleError;
use cells::{Cell, cells};
use glam::{DVec2, DVec3};
use greenstick_wood::noise::{hash, unit};
use greenstick_wood::stem::Stem;
pub use material::WoodMaterial;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How rods are arranged in a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Arrangement {
    /// Poisson disk, as in the thesis.
    PoissonDisk,
    /// Bundles by ring and sector.
    Anatomy,
}

/// How many rods.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HowMany {
    /// This many in a section.
    Number(u32),
    /// As many as this distance (m) between them makes.
    Spacing(f64),
}

/// How a stem is filled with rods.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Seed of all that is random.
    pub seed: u64,
    /// Arrangement in the section.
    pub arrangement: Arrangement,
    /// How many.
    pub rods: HowMany,
    /// Least and greatest length of edges, m; both the same for even vertices.
    pub edges: (f64, f64),
    /// Range along the stem's axis, m; its usable part where `None`.
    pub range: Option<(f64, f64)>,
    /// Bonds reach this many times the mean distance of rods.
    pub reach: f64,
    /// Twist: `None` for where rods are curved only.
    pub twisting: Option<bool>,
    /// Weibull modulus of the scatter of strength of rods and bonds; infinite for none.
    pub weibull: f64,
    /// Rings in the section; bonds between rods of different rings are weaker. 0 for none.
    pub rings: u32,
    /// Rays around the section; bonds across one are weaker. 0 for none.
    pub rays: u32,
    /// Strength of bonds across ring boundaries over that of others.
    pub ring_strength: f64,
    /// Strength of bonds across rays over that of others.
    pub ray_strength: f64,
}

impl Default for Placement {
    /// 100 rods by Poisson disk with edges of 4 to 6 mm: the thesis's. Without scatter or weak planes.
    fn default() -> Self {
        Placement {
            seed: 1,
            arrangement: Arrangement::PoissonDisk,
            rods: HowMany::Number(100),
            edges: (4e-3, 6e-3),
            range: None,
            reach: 2.5,
            twisting: None,
            weibull: f64::INFINITY,
            rings: 0,
            rays: 0,
            ring_strength: 0.7,
            ray_strength: 0.8,
        }
    }
}

/// Why a stem cannot be filled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacementError {
    /// A number out of range.
    #[error("{what} is {value}, but it must be {right}")]
    Value {
        /// Which, with its unit.
        what: &'static str,
        /// The value found.
        value: f64,
        /// What would be right.
        right: &'static str,
    },
    /// No section to place rods in.
    #[error("the stem has no section with an area between {from} m and {to} m along its axis")]
    NoSection {
        /// Start of the range, m.
        from: f64,
        /// End, m.
        to: f64,
    },
    /// Rods too far apart for the section.
    #[error(
        "no rod fits: with {spacing} m between rods none lies in a section of {area} m²; give a smaller spacing"
    )]
    NoRods {
        /// Spacing, m.
        spacing: f64,
        /// Area of the section, m².
        area: f64,
    },
    /// The bundle is not sound.
    #[error(transparent)]
    Bundle(#[from] BundleError),
}

/// A stem filled with rods.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The bundle, with bonds.
    pub bundle: Bundle,
    /// Cell of each rod in the section of the stem's place, grain coordinates, m. The rod is at its centroid.
    pub cells: Vec<Cell>,
    /// Length along the axis of each vertex, m.
    pub along: Vec<f64>,
    /// Outline of the section in the same coordinates, m.
    pub outline: Vec<DVec2>,
}

/// Rounds that move points to the centroids of their cells (Lloyd): they take out the holes that cutting down to a number
/// leaves.
const SETTLING: usize = 3;
/// Most rods.
const MOST_RODS: f64 = 1e6;

/// Fills a stem with rods of `wood`.
///
/// # Errors
/// [`PlacementError`].
pub fn place(
    stem: &Stem,
    wood: &WoodMaterial,
    options: &Placement,
) -> Result<Placed, PlacementError> {
    check(options)?;
    let (from, to) = options.range.unwrap_or(stem.usable);
    if !(from.is_finite() && to.is_finite() && to - from > options.edges.0) {
        return Err(PlacementError::Value {
            what: "the length of the range along the axis (m)",
            value: to - from,
            right: "longer than the least edge",
        });
    }
    let outline = outline(stem, 0.5 * (from + to)).ok_or(PlacementError::NoSection { from, to })?;
    let points = section_points(stem, &outline, options)?;
    let mut settled = points;
    let mut found = cells(&outline, &settled);
    for _ in 0..SETTLING {
        settled = found.iter().map(|c| c.centroid).collect();
        found = cells(&outline, &settled);
    }
    found.retain(|c| c.area > 0.0);
    if found.len() != settled.len() {
        // A cell without area, of points that coincide: number facets anew.
        settled = found.iter().map(|c| c.centroid).collect();
        found = cells(&outline, &settled);
    }
    build(stem, wood, options, (from, to), outline, found)
}

fn check(options: &Placement) -> Result<(), PlacementError> {
    let (least, greatest) = options.edges;
    let spacing = match options.rods {
        HowMany::Spacing(s) => s,
        HowMany::Number(n) => f64::from(n),
    };
    let above = [
        ("the least edge (m)", least),
        ("the greatest edge (m)", greatest),
        ("the number or spacing of rods", spacing),
        ("the reach of bonds", options.reach),
        ("the strength of ring boundaries", options.ring_strength),
        ("the strength of rays", options.ray_strength),
    ];
    for (what, value) in above {
        if !(value > 0.0 && value.is_finite()) {
            return Err(PlacementError::Value {
                what,
                value,
                right: "above 0 and finite",
            });
        }
    }
    if greatest < least {
        return Err(PlacementError::Value {
            what: "the greatest edge (m)",
            value: greatest,
            right: "no less than the least edge",
        });
    }
    if options.weibull.is_nan() || options.weibull < 1.0 {
        return Err(PlacementError::Value {
            what: "the Weibull modulus",
            value: options.weibull,
            right: "1 or more",
        });
    }
    Ok(())
}

/// The outline of the section nearest to `s` (m), in grain coordinates, counter-clockwise.
fn outline(stem: &Stem, s: f64) -> Option<Vec<DVec2>> {
    let near = |a: &&greenstick_wood::stem::CrossSection,
                b: &&greenstick_wood::stem::CrossSection| {
        (a.length - s).abs().total_cmp(&(b.length - s).abs())
    };
    let section = stem
        .sections
        .iter()
        .filter(|c| c.area > 0.0 && c.contour.len() > 2)
        .min_by(near)?;
    let scale = stem.grain.scale(section.length);
    let mut outline: Vec<DVec2> = section.contour.iter().map(|&p| p / scale).collect();
    outline.dedup();
    if outline.first() == outline.last() {
        outline.pop();
    }
    let ring: Vec<DVec2> = outline.iter().chain(outline.first()).copied().collect();
    if cells::area_and_centroid(&ring).0 < 0.0 {
        outline.reverse();
    }
    (outline.len() > 2).then_some(outline)
}

fn section_points(
    stem: &Stem,
    outline: &[DVec2],
    options: &Placement,
) -> Result<Vec<DVec2>, PlacementError> {
    let ring: Vec<DVec2> = outline.iter().chain(outline.first()).copied().collect();
    let area = cells::area_and_centroid(&ring).0;
    let sample = |spacing: f64| match options.arrangement {
        Arrangement::PoissonDisk => points::poisson_disk(outline, spacing, options.seed),
        Arrangement::Anatomy => points::by_anatomy(outline, &stem.rings, spacing, options.seed),
    };
    let too_many = |count: f64| PlacementError::Value {
        what: "the number of rods in the section",
        value: count,
        right: "up to a million",
    };
    let points = match options.rods {
        HowMany::Spacing(spacing) => {
            if area / (spacing * spacing) > MOST_RODS {
                return Err(too_many(area / (spacing * spacing)));
            }
            sample(spacing)
        }
        HowMany::Number(number) => {
            let wanted = number as usize;
            if f64::from(number) > MOST_RODS {
                return Err(too_many(f64::from(number)));
            }
            // The largest spacing tried that gives enough, then cut down to the number in an order of chance.
            let (mut low, mut high) = (
                0.3 * (area / wanted as f64).sqrt(),
                2.0 * (area / wanted as f64).sqrt(),
            );
            let mut best = sample(low);
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                let tried = sample(middle);
                if tried.len() >= wanted {
                    (low, best) = (middle, tried);
                } else {
                    high = middle;
                }
            }
            let mut order: Vec<usize> = (0..best.len()).collect();
            order.sort_by_key(|&i| hash(options.seed ^ 0xc075, i as i64, 0, 0));
            order.truncate(wanted);
            order.sort_unstable();
            order.into_iter().map(|i| best[i]).collect()
        }
    };
    if points.is_empty() {
        let spacing = match options.rods {
            HowMany::Spacing(s) => s,
            HowMany::Number(n) => (area / f64::from(n)).sqrt(),
        };
        return Err(PlacementError::NoRods { spacing, area });
    }
    Ok(points)
}

/// Lengths along the axis of one rod's vertices.
fn vertices_along(options: &Placement, rod: usize, (from, to): (f64, f64)) -> Vec<f64> {
    let (least, greatest) = options.edges;
    let length = to - from;
    let mut lengths = Vec::new();
    let mut sum = 0.0;
    while sum < length {
        let edge = least
            + (greatest - least) * unit(options.seed ^ 0xed6e, rod as i64, lengths.len() as i64, 0);
        // The last edge is left out where that misses the length by less.
        if sum + edge - length > length - sum && !lengths.is_empty() {
            break;
        }
        sum += edge;
        lengths.push(edge);
    }
    let mut along = vec![from];
    let mut done = 0.0;
    for edge in lengths {
        done += edge;
        along.push(from + length * (done / sum));
    }
    along
}

/// A strength relative to the mean, Weibull distributed.
pub(crate) fn weibull(modulus: f64, uniform: f64) -> f64 {
    if modulus.is_infinite() {
        return 1.0;
    }
    libm::pow(-libm::log1p(-uniform), 1.0 / modulus) / libm::tgamma(1.0 + 1.0 / modulus)
}

fn build(
    stem: &Stem,
    wood: &WoodMaterial,
    options: &Placement,
    range: (f64, f64),
    outline: Vec<DVec2>,
    cells: Vec<Cell>,
) -> Result<Placed, PlacementError> {
    let mean = 0.5 * (wood.shear_radial + wood.shear_tangential);
    let mut along = Vec::new();
    let rods: Vec<Rod> = cells
        .iter()
        .enumerate()
        .map(|(number, cell)| {
            let lengths = vertices_along(options, number, range);
            let at = |&s: &f64| {
                stem.grain
                    .to_world(DVec3::new(cell.centroid.x, cell.centroid.y, s))
            };
            let vertices: Vec<DVec3> = lengths.iter().map(at).collect();
            let strength = |k: usize| {
                // The weakest do not fall below what still is wood.
                weibull(
                    options.weibull,
                    unit(options.seed ^ 0x57e6, number as i64, k as i64, 0),
                )
                .max(1e-3)
            };
            let relative_strength = (0..vertices.len()).map(strength).collect();
            along.extend(lengths);
            Rod {
                vertices,
                material: RodMaterial {
                    tension_limit: wood.tension / wood.longitudinal,
                    yield_strain: wood.compression / wood.longitudinal,
                    ..RodMaterial::solid(cell.area, wood.longitudinal, mean, wood.density)
                },
                relative_strength,
                director: Some(stem.grain.axis().frame(range.0).x),
            }
        })
        .collect();
    let mut bundle = match options.twisting {
        Some(twisting) => Bundle::new(&rods, twisting)?,
        None => match Bundle::new(&rods, false) {
            Err(BundleError::Curved { .. }) => Bundle::new(&rods, true)?,
            other => other?,
        },
    };
    let straight: Vec<Range<usize>> = (0..bundle.rods()).map(|r| bundle.rod(r)).collect();
    taper(&mut bundle, stem, &along, &straight);
    let bonds = bonding::bonds(stem, wood, options, &bundle, &cells, &along);
    bundle.set_bonds(bonds)?;
    Ok(Placed {
        bundle,
        cells,
        along,
        outline,
    })
}

/// Stiffness and mass where the section is not as large as at the place: areas by the square of the size.
fn taper(bundle: &mut Bundle, stem: &Stem, along: &[f64], rods: &[Range<usize>]) {
    for range in rods {
        for i in range.clone() {
            let area = |s: f64| stem.grain.scale(s) * stem.grain.scale(s);
            let own = area(along[i]);
            bundle.bend[i] *= own * own;
            bundle.twist[i] *= own * own;
            if bundle.is_edge(i) {
                let middle = area(0.5 * (along[i] + along[i + 1]));
                bundle.stretch[i] *= middle;
                bundle.edge_mass[i] *= middle;
                bundle.inertia[i] *= middle * middle;
            }
        }
        bundle.share_mass(range.clone());
    }
}
