//! A stem as hexahedra for finite elements, with the axes of its wood.
//!
//! Each section of a round stem is a square of cells about the pith with layers of cells around it (an O-grid), laid out in
//! ring coordinates and mapped to the section by its rings, so that layers follow rings and the last one is the bark. Boards
//! have columns instead ([`super::board_elements`]).

use super::board_elements::divide_board;
use super::hexahedra::{ElementError, MAX_ELEMENTS, SLENDERNESS, StemElement, StemElements};
use super::model::Anatomy;
use super::sections::TransverseSection;
use crate::polygon;
use crate::stem::Frame;
use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Ring coordinate around which the square of cells ends.
const CORE: f64 = 0.5;
/// How round the square of cells is: 0 a square, 1 a circle, whose cells would be flat at its corners.
const CORE_ROUNDNESS: f64 = 0.5;
/// Edge of a cell where it is not given, in radii at the location.
const DEFAULT_EDGE_RADII: f64 = 0.2;
/// Fewest and most cells along each side of the square.
const SIDE_RANGE: (f64, f64) = (2.0, 64.0);
/// How far within an end of the stem its section is taken, in slabs: at the very end a plane lies in the cut face, which may be
/// rough.
const END_INSET_SLABS: f64 = 0.5;
/// Step by which the direction across the rings is found, as an angle, rad.
const ANGLE_STEP: f64 = 1e-3;

impl StemElements {
    /// Divides a stem where its sections are whole. `edge` (m) is how wide elements are; where absent a fifth of the radius,
    /// and in a board at most a quarter of its thickness.
    ///
    /// # Errors
    /// [`ElementError`].
    pub fn new(
        anatomy: &Anatomy,
        edge: Option<f64>,
        context: &Context,
    ) -> Result<Self, ElementError> {
        if anatomy.is_board() {
            return divide_board(anatomy, edge, context);
        }
        let sections = anatomy.sections();
        let radius = sections.stem().radius;
        let edge = edge.unwrap_or(DEFAULT_EDGE_RADII * radius);
        let (low, high) = sections.whole;
        let slabs = ((high - low) / (SLENDERNESS * edge)).ceil().max(1.0);
        let layout = SectionLayout::new(radius / edge, anatomy.cambium());
        let count = slabs * layout.cells.len() as f64;
        if count > MAX_ELEMENTS {
            return Err(ElementError::TooMany { edge, count });
        }
        let slabs = slabs as usize;
        let inset = END_INSET_SLABS * (high - low) / slabs as f64;
        let rows: Vec<SectionNodes> = (0..=slabs)
            .into_par_iter()
            .map(|k| {
                context.check()?;
                let length = low + (high - low) * k as f64 / slabs as f64;
                let inside = length.clamp(low + inset, high - inset);
                let section = sections
                    .section(inside)
                    .ok_or(ElementError::Section(length))?;
                let frame = sections.stem().grain.axis().frame(length);
                Ok(SectionNodes {
                    places: layout.places(&section),
                    frame,
                    section,
                })
            })
            .collect::<Result<_, ElementError>>()?;
        let nodes = rows.iter().flat_map(SectionNodes::in_world).collect();
        let mut elements = Vec::with_capacity(slabs * layout.cells.len());
        for (k, pair) in rows.windows(2).enumerate() {
            context.check()?;
            for cell in &layout.cells {
                elements.push(element(anatomy, &layout, [&pair[0], &pair[1]], k, *cell));
            }
        }
        let mut stem = StemElements {
            nodes,
            elements,
            end_nodes: [layout.nodes.len(); 2],
        };
        stem.measure();
        Ok(stem)
    }
}

/// The nodes of a section.
struct SectionNodes {
    /// Where they stand.
    frame: Frame,
    /// In the frame's x and y, m.
    places: Vec<DVec2>,
    section: TransverseSection,
}

impl SectionNodes {
    fn in_world(&self) -> impl Iterator<Item = DVec3> + '_ {
        let f = self.frame;
        (self.places.iter()).map(move |p| f.origin + f.x * p.x + f.y * p.y)
    }
}

/// The cells of a section in the unit disc of ring coordinates.
struct SectionLayout {
    nodes: Vec<DVec2>,
    cells: Vec<[u32; 4]>,
    /// Nodes on the outline, in order.
    rim: Vec<u32>,
}

impl SectionLayout {
    /// Cells for a stem whose radius is so many edges; the last layer begins at the ring coordinate `cambium`.
    fn new(radius_edges: f64, cambium: f64) -> Self {
        let (fewest, most) = SIDE_RANGE;
        let side = (FRAC_PI_2 * radius_edges).round().clamp(fewest, most) as usize;
        let layers = ((cambium - CORE) * radius_edges).round().max(1.0) as usize;
        let mut nodes = Vec::new();
        let mut cells = Vec::new();
        let row = side + 1;
        for j in 0..row {
            for i in 0..row {
                let place = |k: usize| 2.0 * k as f64 / side as f64 - 1.0;
                nodes.push(core_place(place(i), place(j)));
            }
        }
        let at = |i: usize, j: usize| (j * row + i) as u32;
        for j in 0..side {
            for i in 0..side {
                cells.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        // Around the square, counter-clockwise from its lower left corner.
        let mut rim: Vec<u32> = Vec::with_capacity(4 * side);
        rim.extend((0..side).map(|i| at(i, 0)));
        rim.extend((0..side).map(|j| at(side, j)));
        rim.extend((0..side).map(|i| at(side - i, side)));
        rim.extend((0..side).map(|j| at(0, side - j)));
        let square: Vec<DVec2> = rim.iter().map(|&n| nodes[n as usize]).collect();
        // From the square to the circle between wood and bark, then to the outline.
        let wood = (1..=layers).map(|k| (cambium, k as f64 / layers as f64));
        let bark = (cambium < 1.0).then_some((1.0, 1.0));
        for (radius, share) in wood.chain(bark) {
            let first = nodes.len() as u32;
            nodes.extend(square.iter().map(|p| p.lerp(p.normalize() * radius, share)));
            let next: Vec<u32> = (first..).take(rim.len()).collect();
            for k in 0..rim.len() {
                let l = (k + 1) % rim.len();
                cells.push([rim[k], next[k], next[l], rim[l]]);
            }
            rim = next;
        }
        SectionLayout { nodes, cells, rim }
    }

    /// The nodes in a section: at its rings, and moved from the pith so that they enclose the section's area.
    fn places(&self, section: &TransverseSection) -> Vec<DVec2> {
        let pith = section.field.pith();
        let mut places: Vec<DVec2> = self
            .nodes
            .iter()
            .map(|n| section.field.point(n.length(), libm::atan2(n.y, n.x)))
            .collect();
        let rim: Vec<DVec2> = self.rim.iter().map(|&n| places[n as usize]).collect();
        let enclosed = polygon::area_and_centroid(&rim).0.abs();
        let scale = if enclosed > 0.0 {
            (section.outline.area / enclosed).sqrt()
        } else {
            1.0
        };
        places
            .iter_mut()
            .for_each(|p| *p = pith + (*p - pith) * scale);
        places
    }
}

/// Where a point of the square −1 to 1 lies in the disc: half way between a square and a circle.
fn core_place(u: f64, v: f64) -> DVec2 {
    let size = u.abs().max(v.abs());
    if size == 0.0 {
        return DVec2::ZERO;
    }
    let angle = if u.abs() >= v.abs() {
        FRAC_PI_4 * v / u + if u < 0.0 { 2.0 * FRAC_PI_2 } else { 0.0 }
    } else {
        FRAC_PI_2 - FRAC_PI_4 * u / v + if v < 0.0 { 2.0 * FRAC_PI_2 } else { 0.0 }
    };
    let (sin, cos) = libm::sincos(angle);
    let circle = DVec2::new(cos, sin) * size;
    let square = DVec2::new(u, v) * std::f64::consts::FRAC_1_SQRT_2;
    CORE * square.lerp(circle, CORE_ROUNDNESS)
}

/// The element between two sections.
fn element(
    anatomy: &Anatomy,
    layout: &SectionLayout,
    ends: [&SectionNodes; 2],
    slab: usize,
    cell: [u32; 4],
) -> StemElement {
    let count = layout.nodes.len() as u32;
    let (low, high) = (slab as u32 * count, (slab as u32 + 1) * count);
    let [a, b, c, d] = cell;
    let middle = cell.map(|n| layout.nodes[n as usize]);
    let middle = middle.iter().sum::<DVec2>() / 4.0;
    let (rho, angle) = (middle.length(), libm::atan2(middle.y, middle.x));
    let rings = anatomy.rings();
    let last = rings.edges().len() - 1;
    let ring = rings.edges().partition_point(|edge| *edge <= rho).min(last);
    StemElement {
        corners: [
            low + a,
            low + b,
            low + c,
            low + d,
            high + a,
            high + b,
            high + c,
            high + d,
        ],
        axes: axes(ends, rho, angle),
        tissue: rings.tissues()[ring],
        ring: ring as u16 + 1,
        volume: 0.0,
    }
}

/// Directions along the grain, across the rings and along them in the middle between two sections.
fn axes(ends: [&SectionNodes; 2], rho: f64, angle: f64) -> [DVec3; 3] {
    let world = |end: &SectionNodes, angle: f64| {
        let p = end.section.field.point(rho, angle);
        end.frame.origin + end.frame.x * p.x + end.frame.y * p.y
    };
    // Along the grain a fibre keeps its ring and its angle.
    let tangent = ends[0].frame.tangent + ends[1].frame.tangent;
    let along = (world(ends[1], angle) - world(ends[0], angle)).normalize_or(tangent.normalize());
    let middle = |angle: f64| 0.5 * (world(ends[0], angle) + world(ends[1], angle));
    let around = middle(angle + ANGLE_STEP) - middle(angle - ANGLE_STEP);
    let around = around.reject_from_normalized(along);
    let around = around.normalize_or(along.any_orthonormal_vector());
    let across = around.cross(along).normalize();
    [along, across, along.cross(across)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_the_disc_without_turning_over() {
        for (edges, cambium) in [(1.0, 0.9), (5.0, 0.9), (12.0, 1.0)] {
            let layout = SectionLayout::new(edges, cambium);
            let mut sum = 0.0;
            for cell in &layout.cells {
                let corners = cell.map(|n| layout.nodes[n as usize]);
                let (area, _) = polygon::area_and_centroid(&corners);
                // Every corner turns left.
                for k in 0..4 {
                    let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 4]);
                    let turn = (b - a).normalize().perp_dot((c - b).normalize());
                    assert!(turn > 0.2, "{edges}: {corners:?}");
                }
                sum += area;
            }
            let rim: Vec<DVec2> = layout
                .rim
                .iter()
                .map(|&n| layout.nodes[n as usize])
                .collect();
            assert!((sum / polygon::area_and_centroid(&rim).0 - 1.0).abs() < 1e-12);
            assert!(rim.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
        }
    }
}
