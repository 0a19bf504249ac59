//! Fills a stem with rods.
//!
//! Rods run at constant grain coordinates, so that they follow a curved and tapering axis; cross-sections and stiffness
//! shrink with the taper. A rod lies at the centroid of its cell, so that the rods' positions and their own bending
//! stiffness together give the bending stiffness of the cross-section.

use super::bonding::bonds;
use super::grain::apply_grain;
use super::material::WoodMaterial;
use super::options::{Arrangement, PlacementError, PlacementOptions, RodCount};
use super::points;
use super::scatter::weibull;
use super::section_wood::{RodWood, SectionWood};
use super::voronoi::{VoronoiCell, area_and_centroid, cells_of_points};
use crate::error::RodBundleError;
use crate::rod_bundle::{Rod, RodBundle};
use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use greenstick_wood::noise::{hash, unit};
use greenstick_wood::stem::Stem;
use greenstick_wood::structure::WoodStructure;

/// A stem filled with rods.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedRods {
    /// The bundle, with bonds.
    pub bundle: RodBundle,
    /// Cell of each rod in the cross-section in the middle, in grain coordinates, m. The rod is at its centroid.
    pub cells: Vec<VoronoiCell>,
    /// Per vertex: length along the axis, m.
    pub along: Vec<f64>,
    /// Outline of the cross-section in the same coordinates, m.
    pub outline: Vec<DVec2>,
    /// Tissue and properties of each rod.
    pub wood: Vec<RodWood>,
}

/// Bisections of the spacing that gives a number of rods.
const SPACING_BISECTIONS: usize = 12;
const MAX_RODS: f64 = 1e6;
/// Least relative strength of a vertex. The Weibull distribution has no other.
const MIN_RELATIVE_STRENGTH: f64 = 1e-3;

/// The range of the stem's axis that is filled, m.
#[derive(Debug, Clone, Copy)]
struct AxisRange {
    from: f64,
    to: f64,
}

/// Fills a stem with rods of `wood`, all alike.
///
/// ```
/// use greenstick_fibre::placement::{PlacementOptions, RodCount, WoodMaterial, fill_stem};
/// use greenstick_geometry::Context;
/// use greenstick_wood::moisture::Fallback;
/// use greenstick_wood::primitive::cylinder;
/// use greenstick_wood::species::Species;
/// use greenstick_wood::stem::{StemOptions, find_stem};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let context = Context::quiet();
/// let mesh = cylinder(0.01, 0.2, 48); // radius, length, sides
/// let found = find_stem(&[mesh], &"0.5".parse()?, &StemOptions::default(), &context)?;
/// let wood = WoodMaterial::from_species(Species::find("white oak")?, 12.0, Fallback::Refuse)?;
/// let options = PlacementOptions {
///     rods: RodCount::Number(20),
///     ..PlacementOptions::default()
/// };
/// let placed = fill_stem(&found.stem, &wood, &options, &context)?;
/// assert_eq!(placed.bundle.rods(), 20);
/// assert!(placed.bundle.bonds.len() > 1000);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`PlacementError`].
pub fn fill_stem(
    stem: &Stem,
    wood: &WoodMaterial,
    options: &PlacementOptions,
    context: &Context,
) -> Result<PlacedRods, PlacementError> {
    fill(stem, (wood, None), options, context)
}

/// Fills a stem with rods whose wood follows its `structure`; `wood` is the mean of its section.
///
/// # Errors
/// [`PlacementError`].
pub fn fill_structured_stem(
    stem: &Stem,
    wood: &WoodMaterial,
    structure: &WoodStructure,
    options: &PlacementOptions,
    context: &Context,
) -> Result<PlacedRods, PlacementError> {
    fill(stem, (wood, Some(structure)), options, context)
}

fn fill(
    stem: &Stem,
    (wood, structure): (&WoodMaterial, Option<&WoodStructure>),
    options: &PlacementOptions,
    context: &Context,
) -> Result<PlacedRods, PlacementError> {
    options.check()?;
    let (from, to) = options.range.unwrap_or(stem.usable);
    if !(from.is_finite() && to.is_finite() && to - from > options.edges.least) {
        return Err(PlacementError::Value {
            what: "the length of the range along the axis (m)",
            value: to - from,
            right: "longer than the least edge",
        });
    }
    let outline = outline(stem, 0.5 * (from + to)).ok_or(PlacementError::NoSection { from, to })?;
    let points = section_points(stem, &outline, options, &context.part(0.0, 0.4))?;
    let cells = relaxed_cells(&outline, points, options.lloyd, &context.part(0.4, 0.7))?;
    let range = AxisRange { from, to };
    let context = context.part(0.7, 1.0);
    let section = Section { outline, cells };
    let section_wood = match structure {
        None => SectionWood::even(wood, section.cells.len()),
        Some(structure) => {
            let middle = 0.5 * (from + to);
            let shape = (&section.outline[..], &section.cells[..]);
            SectionWood::structured(stem, wood, structure, shape, middle)
        }
    };
    build(
        stem,
        (wood, section_wood, structure),
        options,
        range,
        section,
        &context,
    )
}

/// Cells of points after some Lloyd iterations.
fn relaxed_cells(
    outline: &[DVec2],
    mut points: Vec<DVec2>,
    iterations: u32,
    context: &Context,
) -> Result<Vec<VoronoiCell>, PlacementError> {
    let mut cells = cells_of_points(outline, &points, context)?;
    for iteration in 0..iterations {
        context.report(f64::from(iteration) / f64::from(iterations))?;
        points = cells.iter().map(|c| c.centroid).collect();
        cells = cells_of_points(outline, &points, context)?;
    }
    cells.retain(|c| c.area > 0.0);
    if cells.len() != points.len() {
        // Points that coincide leave a cell without area: without it facets must be numbered anew.
        points = cells.iter().map(|c| c.centroid).collect();
        cells = cells_of_points(outline, &points, context)?;
    }
    Ok(cells)
}

/// Returns the outline of the cross-section nearest to `s` (m), in grain coordinates, counter-clockwise.
fn outline(stem: &Stem, s: f64) -> Option<Vec<DVec2>> {
    let section = stem
        .sections
        .iter()
        .filter(|c| c.area > 0.0 && c.contour.len() > 2)
        .min_by(|a, b| (a.length - s).abs().total_cmp(&(b.length - s).abs()))?;
    let in_grain = |&p: &DVec2| stem.grain.from_section(p, section.length);
    let mut outline: Vec<DVec2> = section.contour.iter().map(in_grain).collect();
    outline.dedup();
    if outline.first() == outline.last() {
        outline.pop();
    }
    let ring: Vec<DVec2> = outline.iter().chain(outline.first()).copied().collect();
    if area_and_centroid(&ring).0 < 0.0 {
        outline.reverse();
    }
    (outline.len() > 2).then_some(outline)
}

/// Returns the points at which rods pierce the cross-section.
fn section_points(
    stem: &Stem,
    outline: &[DVec2],
    options: &PlacementOptions,
    context: &Context,
) -> Result<Vec<DVec2>, PlacementError> {
    let ring: Vec<DVec2> = outline.iter().chain(outline.first()).copied().collect();
    let area = area_and_centroid(&ring).0;
    let sample = |spacing: f64| match options.arrangement {
        Arrangement::PoissonDisk => points::poisson_disk(outline, spacing, options.seed, context),
        Arrangement::Anatomy => {
            points::by_ring_and_sector(outline, &stem.rings, spacing, options.seed, context)
        }
    };
    let check_count = |count: f64| {
        if count <= MAX_RODS {
            return Ok(());
        }
        Err(PlacementError::Value {
            what: "the number of rods in the section",
            value: count,
            right: "up to a million",
        })
    };
    let (points, spacing) = match options.rods {
        RodCount::Spacing(spacing) => {
            check_count(area / (spacing * spacing))?;
            (sample(spacing)?, spacing)
        }
        RodCount::Number(number) => {
            check_count(f64::from(number))?;
            let mean = (area / f64::from(number)).sqrt();
            // The largest spacing tried that gives enough points; then points are removed in random order.
            let (mut low, mut high) = (0.3 * mean, 2.0 * mean);
            let mut best = sample(low)?;
            for trial in 0..SPACING_BISECTIONS {
                context.report(trial as f64 / SPACING_BISECTIONS as f64)?;
                let middle = 0.5 * (low + high);
                let tried = sample(middle)?;
                if tried.len() >= number as usize {
                    (low, best) = (middle, tried);
                } else {
                    high = middle;
                }
            }
            (thinned(best, number as usize, options.seed), mean)
        }
    };
    if points.is_empty() {
        return Err(PlacementError::NoRods { spacing, area });
    }
    Ok(points)
}

/// Returns `count` of the points, chosen at random, in their order.
fn thinned(points: Vec<DVec2>, count: usize, seed: u64) -> Vec<DVec2> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by_key(|&i| hash(seed ^ 0xc075, i as i64, 0, 0));
    order.truncate(count);
    order.sort_unstable();
    order.into_iter().map(|i| points[i]).collect()
}

/// Returns the lengths along the axis of one rod's vertices.
fn vertices_along(options: &PlacementOptions, rod: usize, range: AxisRange) -> Vec<f64> {
    let is_even = options.edges.least == options.edges.greatest && options.fine.is_none();
    if is_even && !options.clamp_ends.is_empty() {
        return even_vertices(&options.clamp_ends, options.edges.least, range);
    }
    let (least, greatest) = (options.edges.least, options.edges.greatest);
    let length = range.to - range.from;
    let mut lengths = Vec::new();
    let mut sum = 0.0;
    while sum < length {
        let draw = lengths.len() as i64;
        let random = unit(options.seed ^ 0xed6e, rod as i64, draw, 0);
        let edge = (least + (greatest - least) * random) / options.times_shorter(range.from + sum);
        // The last edge is left out where the sum then misses the length by less.
        if sum + edge - length > length - sum && !lengths.is_empty() {
            break;
        }
        sum += edge;
        lengths.push(edge);
    }
    let mut along = vec![range.from];
    let mut done = 0.0;
    for edge in lengths {
        done += edge;
        along.push(range.from + length * (done / sum));
    }
    along
}

/// Returns lengths along the axis whose distances are nearly `edge`, two of them at the same distance from each clamp's end. The
/// edge between these is as long as those of the longer part beside it, which is the free one.
fn even_vertices(clamp_ends: &[f64], edge: f64, range: AxisRange) -> Vec<f64> {
    let margin = 1e-6 * edge;
    let mut points: Vec<f64> = (clamp_ends.iter().copied())
        .filter(|end| (range.from + margin..range.to - margin).contains(end))
        .chain([range.from, range.to])
        .collect();
    points.sort_by(f64::total_cmp);
    points.dedup_by(|a, b| *a - *b < margin);
    let last = points.len() - 2;
    let halves = |part: usize| 0.5 * f64::from(u8::from(part > 0) + u8::from(part < last));
    let length = |part: usize| points[part + 1] - points[part];
    let own_edge = |part: usize| {
        let least = if last == 0 { 1.0 } else { 0.5 };
        let count = (length(part) / edge - halves(part)).round() + halves(part);
        length(part) / count.max(least)
    };
    // Half of the edge at each point but the first and the last.
    let half_edge = |point: usize| {
        let longer = |a: &usize, b: &usize| length(*a).total_cmp(&length(*b));
        let beside = (point > 0 && point <= last).then(|| [point - 1, point].into_iter());
        let longest = beside.and_then(|parts| parts.max_by(longer));
        longest.map_or(0.0, |part| 0.5 * own_edge(part))
    };
    let mut along = Vec::new();
    for part in 0..=last {
        let (first, end) = (
            points[part] + half_edge(part),
            points[part + 1] - half_edge(part + 1),
        );
        if end - first < margin {
            // A clamp that is shorter than these edges.
            along.push(points[part] + if part > 0 { 0.5 * length(part) } else { 0.0 });
            continue;
        }
        let count = ((end - first) / edge).round().max(1.0);
        along.extend((0..=count as usize).map(|k| first + (end - first) * (k as f64 / count)));
    }
    along
}

/// The cross-section that rods pierce, in grain coordinates, m.
struct Section {
    outline: Vec<DVec2>,
    cells: Vec<VoronoiCell>,
}

fn build(
    stem: &Stem,
    (wood, section_wood, structure): (&WoodMaterial, SectionWood, Option<&WoodStructure>),
    options: &PlacementOptions,
    range: AxisRange,
    section: Section,
    context: &Context,
) -> Result<PlacedRods, PlacementError> {
    let director = stem.grain.axis().frame(range.from).x;
    let mut along = Vec::new();
    let mut rods = Vec::with_capacity(section.cells.len());
    for (number, cell) in section.cells.iter().enumerate() {
        context.check()?;
        let lengths = vertices_along(options, number, range);
        let position = |&s: &f64| stem.grain.to_world(cell.centroid.extend(s));
        let vertices: Vec<DVec3> = lengths.iter().map(position).collect();
        let strength = |k: usize| {
            let uniform = unit(options.seed ^ 0x57e6, number as i64, k as i64, 0);
            // The weakest of several short edges is as strong as the one that they take the place of.
            let size = libm::pow(options.times_shorter(lengths[k]), 1.0 / options.weibull);
            (size * weibull(options.weibull, uniform)).max(MIN_RELATIVE_STRENGTH)
        };
        rods.push(Rod {
            relative_strength: (0..vertices.len()).map(strength).collect(),
            vertices,
            material: section_wood.rods[number].material.rod(cell.area),
            director: Some(director),
        });
        along.extend(lengths);
    }
    let mut bundle = match options.twisting {
        Some(twisting) => RodBundle::new(&rods, twisting)?,
        None => match RodBundle::new(&rods, false) {
            Err(RodBundleError::Curved { .. }) => RodBundle::new(&rods, true)?,
            other => other?,
        },
    };
    apply_taper(&mut bundle, stem, &along);
    if let Some(structure) = structure {
        let rods = (&section_wood.rods[..], &section.cells[..]);
        apply_grain(&mut bundle, stem, structure, rods, &along);
    }
    let bonds = bonds(
        stem,
        (wood, &section_wood),
        options,
        &bundle,
        &section.cells,
        &along,
        context,
    )?;
    bundle.set_bonds(bonds)?;
    Ok(PlacedRods {
        bundle,
        cells: section.cells,
        along,
        outline: section.outline,
        wood: section_wood.rods,
    })
}

/// Scales stiffness and mass where the cross-section is larger or smaller than the one in the middle: areas with the square
/// of the size.
fn apply_taper(bundle: &mut RodBundle, stem: &Stem, along: &[f64]) {
    let area = |s: f64| stem.grain.scale(s) * stem.grain.scale(s);
    for rod in 0..bundle.rods() {
        let range = bundle.rod(rod);
        for i in range.clone() {
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
        bundle.distribute_mass(range);
    }
}
