//! A board as hexahedra for finite elements, with the axes of its wood.
//!
//! Columns of cells stand across the wider side, evenly, and each is divided into as many cells from face to face. Nodes thus
//! lie in the faces, and those at a side, of the board or of a gap in it (a handle, a slot, a bored hole), are moved to that
//! side. Where a side runs across the grain it is bounded by steps as long as a cell.

use super::hexahedra::{ElementError, MAX_ELEMENTS, SLENDERNESS, StemElement, StemElements};
use super::model::Anatomy;
use super::sections::TransverseSection;
use crate::polygon;
use crate::stem::Frame;
use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use rayon::prelude::*;

/// Edge of a cell where it is not given: a part of the thickness, so that a board that bends across it has cells enough, but no
/// longer than this part of the radius of the circle of the same area.
const DEFAULT_EDGE_THICKNESS: f64 = 0.25;
const DEFAULT_EDGE_RADII: f64 = 0.2;
/// Fewest and most cells along each side of a section.
const SIDE_RANGE: (f64, f64) = (2.0, 512.0);
/// Distance from a node, in widths of a column, at which the faces of its column are looked for: at a side there are none.
const FACE_REACH: f64 = 0.1;
/// How far a node is moved to a side at most, in widths of a column, so that no cell is narrower than a tenth of it.
const SIDE_REACH: f64 = 0.45;
/// Thinnest column, in thicknesses of the board: thinner ones, at a rounded edge, would be slivers.
const MIN_COLUMN: f64 = 0.3;
/// Parts of a column's thickness at which lines are laid by which a side is found.
const SIDE_LINES: [f64; 3] = [0.2, 0.5, 0.8];

/// Divides a board where its sections are whole.
pub(super) fn divide_board(
    anatomy: &Anatomy,
    edge: Option<f64>,
    context: &Context,
) -> Result<StemElements, ElementError> {
    let sections = anatomy.sections();
    let stem = sections.stem();
    let (low, high) = sections.whole;
    let usual = stem.location.clamp(low, high);
    let section = sections
        .section(usual)
        .ok_or(ElementError::Section(usual))?;
    let corners: Vec<DVec2> = section.outline.points().collect();
    let rectangle = polygon::smallest_rectangle(&corners).ok_or(ElementError::Section(usual))?;
    let default =
        (DEFAULT_EDGE_THICKNESS * rectangle.thickness).min(DEFAULT_EDGE_RADII * stem.radius);
    let edge = edge.unwrap_or(default);
    let slabs = ((high - low) / (SLENDERNESS * edge)).ceil().max(1.0);
    let too_many = |count: f64| ElementError::TooMany { edge, count };
    if slabs > MAX_ELEMENTS {
        return Err(too_many(slabs));
    }
    let slabs = slabs as usize;
    let rows = rows(anatomy, slabs, rectangle.wide, context)?;
    let layout = BoardLayout::new(&rows, rectangle.thickness, edge);
    let count = slabs as f64 * layout.columns as f64 * layout.levels as f64;
    if count > MAX_ELEMENTS {
        return Err(too_many(count));
    }
    let faces: Vec<Vec<Faces>> = (rows.iter().map(|row| row.columns(&layout)))
        .collect::<Option<_>>()
        .ok_or(ElementError::Section(usual))?;
    let kept = largest_part(&layout, slabs, |slab, column, level| {
        let k = 2 * slab + 1;
        rows[k].is_wood(layout.middle(&faces[k], column, level))
    });
    context.check()?;
    let planes: Vec<Plane> = (0..=slabs)
        .map(|k| Plane::new(&layout, &rows[2 * k], &faces[2 * k], (k, &kept)))
        .collect();
    Ok(elements(anatomy, &layout, &planes, &kept))
}

/// The planes between slabs at even numbers, the middles of slabs at odd ones.
fn rows(
    anatomy: &Anatomy,
    slabs: usize,
    wide: DVec2,
    context: &Context,
) -> Result<Vec<BoardSection>, ElementError> {
    let sections = anatomy.sections();
    let (low, high) = sections.whole;
    // At the very end a plane lies in the cut face.
    let inset = 0.5 * (high - low) / slabs as f64;
    (0..=2 * slabs)
        .into_par_iter()
        .map(|k| {
            context.check()?;
            let length = low + (high - low) * k as f64 / (2 * slabs) as f64;
            let inside = if k % 2 == 0 {
                length.clamp(low + inset, high - inset)
            } else {
                length
            };
            let section = sections.section(inside);
            let section = section.ok_or(ElementError::Section(length))?;
            let grain = &sections.stem().grain;
            let pith = grain.to_section(sections.stem().rings.pith(), length);
            Ok(BoardSection::new(
                section,
                (grain.axis().frame(length), pith),
                wide,
            ))
        })
        .collect()
}

/// Between which distances across the thickness, m, a column lies.
type Faces = (f64, f64);

/// How all sections of a board are divided, in directions of its wider and its thinner side.
struct BoardLayout {
    /// Where the first column begins, m.
    left: f64,
    /// Width of a column, m.
    width: f64,
    /// Thickness of the board, m.
    thickness: f64,
    /// Cells across the wider side.
    columns: usize,
    /// Cells across the thinner side.
    levels: usize,
}

impl BoardLayout {
    /// Columns over all that the sections of a board reach across its wider side.
    fn new(rows: &[BoardSection], thickness: f64, edge: f64) -> Self {
        let points = || rows.iter().flat_map(|row| row.loops.iter().flatten());
        let left = points().fold(f64::INFINITY, |left, p| left.min(p.x));
        let right = points().fold(f64::NEG_INFINITY, |right, p| right.max(p.x));
        let (fewest, most) = SIDE_RANGE;
        let cells = |side: f64| (side / edge).round().clamp(fewest, most);
        let columns = cells(right - left);
        BoardLayout {
            left,
            width: (right - left) / columns,
            thickness,
            columns: columns as usize,
            levels: cells(thickness) as usize,
        }
    }

    /// Number of nodes of a section.
    fn nodes(&self) -> usize {
        (self.columns + 1) * (self.levels + 1)
    }

    fn node(&self, column: usize, level: usize) -> usize {
        column * (self.levels + 1) + level
    }

    /// Cells of a slab.
    fn cells(&self) -> usize {
        self.columns * self.levels
    }

    /// Where the nodes between two columns lie.
    fn side(&self, column: usize) -> f64 {
        self.left + self.width * column as f64
    }

    /// How far across the thickness a node lies.
    fn across(&self, (below, above): Faces, level: usize) -> f64 {
        below + (above - below) * level as f64 / self.levels as f64
    }

    /// The middle of a cell.
    fn middle(&self, faces: &[Faces], column: usize, level: usize) -> DVec2 {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
            .map(|(i, j)| self.across(faces[column + i], level + j));
        let x = 0.5 * (self.side(column) + self.side(column + 1));
        DVec2::new(x, corners.iter().sum::<f64>() / 4.0)
    }
}

/// A section of a board.
struct BoardSection {
    frame: Frame,
    section: TransverseSection,
    /// The pith in the frame's x and y, m.
    pith: DVec2,
    /// Direction of the wider side in the frame's x and y (unit).
    wide: DVec2,
    /// Its loops in directions of the wider and the thinner side.
    loops: Vec<Vec<DVec2>>,
}

impl BoardSection {
    /// Of a section near the one in which the `frame` and the pith lie.
    fn new(section: TransverseSection, (frame, pith): (Frame, DVec2), wide: DVec2) -> Self {
        let turned = |p: &DVec2| DVec2::new(p.dot(wide), p.dot(wide.perp()));
        let loops = section.outline.loops.iter();
        BoardSection {
            loops: loops.map(|l| l.iter().map(turned).collect()).collect(),
            frame,
            section,
            pith,
            wide,
        }
    }

    /// Whether a point is wood.
    fn is_wood(&self, p: DVec2) -> bool {
        let around = self.loops.iter().filter(|l| polygon::contains(l, p));
        around.count() % 2 == 1
    }

    /// The faces at all nodes across the wider side; in a gap those between its neighbours'. `None` where there are none.
    fn columns(&self, layout: &BoardLayout) -> Option<Vec<Faces>> {
        let least = MIN_COLUMN * layout.thickness;
        let found: Vec<Option<Faces>> = (0..=layout.columns)
            .map(|k| {
                let (at, reach) = (layout.side(k), FACE_REACH * layout.width);
                let sides = [at - reach, at + reach].map(|x| self.faces(x));
                let (below, above) = match sides {
                    [Some(a), Some(b)] if b.1 - b.0 > a.1 - a.0 => b,
                    [Some(a), _] => a,
                    [None, b] => b?,
                };
                let more = 0.5 * (least - (above - below)).max(0.0);
                Some((below - more, above + more))
            })
            .collect();
        (0..found.len()).map(|k| between(&found, k)).collect()
    }

    /// Between which faces a line across the thickness lies in the board; `None` where it misses it.
    fn faces(&self, at: f64) -> Option<Faces> {
        crossings(&self.loops, at, |p| p).fold(None, |found, y| {
            let (below, above) = found.unwrap_or((y, y));
            Some((below.min(y), above.max(y)))
        })
    }

    /// Where the side next to a node between two columns lies; where it is if there is none within reach.
    fn side(&self, layout: &BoardLayout, column: usize, faces: Faces) -> f64 {
        let at = layout.side(column);
        let reach = SIDE_REACH * layout.width;
        let nearest = |share: f64| {
            let height = faces.0 + (faces.1 - faces.0) * share;
            crossings(&self.loops, height, |p| DVec2::new(p.y, p.x))
                .min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()))
        };
        let found: Vec<f64> = SIDE_LINES.into_iter().filter_map(nearest).collect();
        if found.is_empty() {
            return at;
        }
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        if (mean - at).abs() > layout.width {
            return at;
        }
        mean.clamp(at - reach, at + reach)
    }
}

/// Where loops cross the line x = `at`, in coordinates that `turned` gives.
fn crossings<'a>(
    loops: &'a [Vec<DVec2>],
    at: f64,
    turned: impl Fn(DVec2) -> DVec2 + Copy + 'a,
) -> impl Iterator<Item = f64> + 'a {
    loops.iter().flat_map(move |l| {
        (0..l.len()).filter_map(move |k| {
            let (a, b) = (turned(l[k]), turned(l[(k + 1) % l.len()]));
            let crosses = (a.x <= at) != (b.x <= at);
            crosses.then(|| a.y + (b.y - a.y) * (at - a.x) / (b.x - a.x))
        })
    })
}

/// The faces of a node; where it has none, those between the nearest that have.
fn between(found: &[Option<Faces>], k: usize) -> Option<Faces> {
    let before = (0..=k).rev().find_map(|i| Some((i, found[i]?)));
    let after = (k..found.len()).find_map(|i| Some((i, found[i]?)));
    match (before, after) {
        (Some((a, f)), Some((b, g))) if b > a => {
            let share = (k - a) as f64 / (b - a) as f64;
            Some((f.0 + (g.0 - f.0) * share, f.1 + (g.1 - f.1) * share))
        }
        (Some((_, f)), _) | (None, Some((_, f))) => Some(f),
        (None, None) => None,
    }
}

/// The nodes between two slabs.
struct Plane<'a> {
    section: &'a BoardSection,
    /// In the frame's x and y, m, column by column.
    places: Vec<DVec2>,
}

impl<'a> Plane<'a> {
    /// The plane number `k`, between slabs whose cells are kept or not.
    fn new(
        layout: &BoardLayout,
        section: &'a BoardSection,
        faces: &[Faces],
        (k, kept): (usize, &[bool]),
    ) -> Self {
        let slabs = kept.len() / layout.cells();
        let has_cells = |slab: usize, column: usize| {
            let first = slab * layout.cells() + column * layout.levels;
            kept[first..first + layout.levels].iter().any(|cell| *cell)
        };
        let is_side = |column: usize| {
            let beside = k.saturating_sub(1)..(k + 1).min(slabs);
            beside.into_iter().any(|slab| {
                let before = column > 0 && has_cells(slab, column - 1);
                before != (column < layout.columns && has_cells(slab, column))
            })
        };
        let wide = section.wide;
        let mut places = Vec::with_capacity(layout.nodes());
        for (column, faces) in faces.iter().enumerate() {
            let x = if is_side(column) {
                section.side(layout, column, *faces)
            } else {
                layout.side(column)
            };
            let y = (0..=layout.levels).map(|level| layout.across(*faces, level));
            places.extend(y.map(|y| wide * x + wide.perp() * y));
        }
        Plane { section, places }
    }

    /// The middle of a cell in the frame's x and y.
    fn middle(&self, layout: &BoardLayout, column: usize, level: usize) -> DVec2 {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
            .map(|(i, j)| self.places[layout.node(column + i, level + j)]);
        corners.iter().sum::<DVec2>() / 4.0
    }

    /// A point in the frame's x and y, m, in the world.
    fn world(&self, p: DVec2) -> DVec3 {
        let f = &self.section.frame;
        f.origin + f.x * p.x + f.y * p.y
    }

    fn pith(&self) -> DVec3 {
        self.world(self.section.pith)
    }
}

/// Which cells, slab by slab and column by column, belong to the largest part of the wood that hangs together by faces.
fn largest_part(
    layout: &BoardLayout,
    slabs: usize,
    is_wood: impl Fn(usize, usize, usize) -> bool,
) -> Vec<bool> {
    let (columns, levels) = (layout.columns, layout.levels);
    let per_slab = columns * levels;
    let place = |cell: usize| (cell / per_slab, cell % per_slab / levels, cell % levels);
    let wood: Vec<bool> = (0..slabs * per_slab)
        .map(|cell| {
            let (slab, column, level) = place(cell);
            is_wood(slab, column, level)
        })
        .collect();
    let mut part = vec![0_u32; wood.len()];
    let (mut largest, mut parts) = ((0, 0), 0);
    let mut open = Vec::new();
    for start in 0..wood.len() {
        if !wood[start] || part[start] != 0 {
            continue;
        }
        parts += 1;
        let mut size = 0;
        part[start] = parts;
        open.push(start);
        while let Some(cell) = open.pop() {
            size += 1;
            let (slab, column, level) = place(cell);
            let neighbours = [
                (slab > 0).then(|| cell - per_slab),
                (slab + 1 < slabs).then(|| cell + per_slab),
                (column > 0).then(|| cell - levels),
                (column + 1 < columns).then(|| cell + levels),
                (level > 0).then(|| cell - 1),
                (level + 1 < levels).then(|| cell + 1),
            ];
            for next in neighbours.into_iter().flatten() {
                if wood[next] && part[next] == 0 {
                    part[next] = parts;
                    open.push(next);
                }
            }
        }
        if size > largest.0 {
            largest = (size, parts);
        }
    }
    part.iter().map(|p| *p != 0 && *p == largest.1).collect()
}

/// The elements of the cells that are kept, and the nodes that they have.
fn elements(
    anatomy: &Anatomy,
    layout: &BoardLayout,
    planes: &[Plane],
    kept: &[bool],
) -> StemElements {
    let count = layout.nodes();
    let mut elements = Vec::new();
    for cell in (0..kept.len()).filter(|cell| kept[*cell]) {
        let (slab, in_slab) = (cell / layout.cells(), cell % layout.cells());
        let (column, level) = (in_slab / layout.levels, in_slab % layout.levels);
        let corner = |up: usize, i: usize, j: usize| {
            ((slab + up) * count + layout.node(column + i, level + j)) as u32
        };
        let face = |up| [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| corner(up, i, j));
        let ([a, b, c, d], [e, f, g, h]) = (face(0), face(1));
        let ends = [&planes[slab], &planes[slab + 1]];
        let middle = ends.map(|end| end.middle(layout, column, level));
        elements.push(element(anatomy, ends, middle, [a, b, c, d, e, f, g, h]));
    }
    let nodes = planes
        .iter()
        .flat_map(|plane| plane.places.iter().map(|p| plane.world(*p)));
    StemElements::of_used_nodes(nodes.collect(), elements, count)
}

/// An element whose middle lies at `middle` in the planes at its ends.
fn element(
    anatomy: &Anatomy,
    ends: [&Plane; 2],
    middle: [DVec2; 2],
    corners: [u32; 8],
) -> StemElement {
    let ring_coordinate = |k: usize| ends[k].section.section.field.address(middle[k]).0;
    let rho = 0.5 * (ring_coordinate(0) + ring_coordinate(1));
    let rings = anatomy.rings();
    let last = rings.edges().len() - 1;
    let ring = rings.edges().partition_point(|edge| *edge <= rho).min(last);
    StemElement {
        corners,
        axes: axes(ends, middle),
        tissue: rings.tissues()[ring],
        ring: ring as u16 + 1,
        volume: 0.0,
    }
}

/// Directions along the grain, across the rings and along them. Fibres of a board are parallel to its pith, which may lie
/// outside of it.
fn axes(ends: [&Plane; 2], middle: [DVec2; 2]) -> [DVec3; 3] {
    let pith = ends.map(Plane::pith);
    let along = (pith[1] - pith[0]).normalize_or(ends[0].section.frame.tangent);
    let place = 0.5 * (ends[0].world(middle[0]) + ends[1].world(middle[1]));
    let outwards = (place - 0.5 * (pith[0] + pith[1])).reject_from_normalized(along);
    let across = outwards.normalize_or(along.any_orthonormal_vector());
    [along, across, along.cross(across)]
}
