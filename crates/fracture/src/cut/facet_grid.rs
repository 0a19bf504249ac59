//! Which facets of a layout lie near the skin, and the side of a surface that triangles of the skin lie on.

use super::parts::Side;
use super::skin::{FINEST, LEVELS, Skin};
use crate::surface::{FractureSurface, NONE, SectionLayout, range};
use glam::DVec2;
use rustc_hash::FxHashMap;
use std::ops::Range;
use std::sync::Arc;

/// A grid of the facets of a layout that lie near a skin, and the connected regions of the others; made once for any heights.
#[derive(Debug, Clone, Default)]
pub struct FacetGrid {
    /// The layout.
    pub layout: Arc<SectionLayout>,
    /// Halvings of the skin's finest grid.
    level: usize,
    size: usize,
    /// Where each cell's list in `facets` starts.
    starts: Vec<u32>,
    facets: Vec<u32>,
    /// The different rectangles of cells that limb triangles cover, as low column, low row, high column, high row.
    rectangles: Vec<[u16; 4]>,
    /// For each limb triangle by rank the number of its rectangle.
    rectangle_of: Vec<u32>,
    /// Boxes of the facets near the skin, as low x, low y, high x, high y.
    boxes: Vec<[f64; 4]>,
    /// For each facet [`NEAR`] where it lies near the skin, else the number of its region.
    pub(super) regions: Vec<u32>,
    /// For each region its facets that border on others.
    pub(super) rims: Vec<Vec<u32>>,
    /// For each node where its facets start in `around`.
    pub(super) node_starts: Vec<u32>,
    /// Facets about each node, with the node's place in each.
    pub(super) around: Vec<(u32, u8)>,
    /// The facet beyond each side of each facet, with its side; [`NONE`] beyond the border.
    pub(super) beside: Vec<[(u32, u8); 3]>,
    /// For each node where its cells start in `cell_corners`.
    pub(super) cell_starts: Vec<u32>,
    /// Cells about each node, each by the first of its facets there, with the node's place in that.
    pub(super) cell_corners: Vec<(u32, u8)>,
    /// For each corner of each facet the number of its cell in `cell_corners`.
    pub(super) corner_cells: Vec<[u32; 3]>,
    /// For each node the region that all facets about it belong to, [`NEAR`] where one of them lies near the skin.
    pub(super) node_regions: Vec<u32>,
}

/// "Near the skin" in [`FacetGrid::regions`].
pub(super) const NEAR: u32 = NONE;
const UNKNOWN: u32 = NONE - 1;

impl FacetGrid {
    /// Whether a facet lies near the skin at any length along it; others lie wholly inside or wholly outside.
    pub fn is_near(&self, facet: u32) -> bool {
        self.regions[facet as usize] == NEAR
    }

    /// Facets whose boxes meet that of the limb triangle of a rank, ascending. `flat` are its corners; `marks` has the
    /// mark of no facet yet.
    pub(super) fn candidates(
        &self,
        rank: usize,
        skin: &Skin,
        flat: [DVec2; 3],
        (marks, mark): (&mut [u32], u32),
        out: &mut Vec<u32>,
    ) {
        let [a, b, c] = flat;
        let (near, far) = (a.min(b).min(c), a.max(b).max(c));
        out.clear();
        let [i0, j0, i1, j1] = skin.cells[rank].map(|c| usize::from(c) >> self.level);
        for j in j0..=j1 {
            for cell in j * self.size + i0..=j * self.size + i1 {
                let (from, to) = (self.starts[cell], self.starts[cell + 1]);
                for &f in &self.facets[from as usize..to as usize] {
                    let b = &self.boxes[f as usize];
                    let meets = b[0] <= far.x && b[2] >= near.x && b[1] <= far.y && b[3] >= near.y;
                    if meets && marks[f as usize] != mark {
                        marks[f as usize] = mark;
                        out.push(f);
                    }
                }
            }
        }
        out.sort_unstable();
    }

    /// Sorts the facets of `layout` into the cells of the grid of `skin`.
    pub fn new(skin: &Skin, layout: &Arc<SectionLayout>) -> Self {
        let wanted = (layout.facets.len() as f64).sqrt() as usize;
        let mut level = 0;
        while level + 1 < LEVELS && FINEST >> level > wanted.max(1) {
            level += 1;
        }
        let size = FINEST >> level;
        let mut grid = FacetGrid {
            layout: layout.clone(),
            level,
            size,
            starts: vec![0; size * size + 1],
            regions: vec![UNKNOWN; layout.facets.len()],
            ..FacetGrid::default()
        };
        grid.number_rectangles(skin);
        grid.spread(skin);
        grid.part();
        grid.gather();
        grid.gather_neighbours();
        grid
    }

    /// Numbers the rectangles of cells. Triangles above each other along the stem mostly have the same one.
    fn number_rectangles(&mut self, skin: &Skin) {
        let mut numbers: FxHashMap<[u16; 4], u32> = FxHashMap::default();
        self.rectangle_of = Vec::with_capacity(skin.cells.len());
        let (mut last, mut number) = ([0; 4], NONE);
        for cells in &skin.cells {
            let rectangle = cells.map(|c| c >> self.level);
            if rectangle != last || number == NONE {
                let next = self.rectangles.len() as u32;
                number = *numbers.entry(rectangle).or_insert(next);
                if number == next {
                    self.rectangles.push(rectangle);
                }
                last = rectangle;
            }
            self.rectangle_of.push(number);
        }
    }

    /// Lists the facets over every cell that has skin.
    fn spread(&mut self, skin: &Skin) {
        let layout = self.layout.clone();
        let mask = &skin.masks[self.level];
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        self.boxes = Vec::with_capacity(layout.facets.len());
        for (f, facet) in layout.facets.iter().enumerate() {
            let [a, b, c] = facet.map(|n| layout.nodes[n as usize]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            self.boxes.push([low.x, low.y, high.x, high.y]);
            let ([i0, j0], [i1, j1]) = (skin.cell(low), skin.cell(high));
            let [i0, j0, i1, j1] = [i0, j0, i1, j1].map(|c| c >> self.level);
            for j in j0..=j1 {
                for i in i0..=i1 {
                    let cell = j * self.size + i;
                    if mask[cell] {
                        pairs.push((cell as u32, f as u32));
                        self.starts[cell + 1] += 1;
                        self.regions[f] = NEAR;
                    }
                }
            }
        }
        for i in 1..self.starts.len() {
            self.starts[i] += self.starts[i - 1];
        }
        let mut next = self.starts.clone();
        self.facets = vec![0; pairs.len()];
        for (cell, f) in pairs {
            self.facets[next[cell as usize] as usize] = f;
            next[cell as usize] += 1;
        }
    }

    /// Divides the facets without skin into connected regions.
    fn part(&mut self) {
        let layout = self.layout.clone();
        let mut queue = Vec::new();
        for first in 0..layout.facets.len() as u32 {
            if self.regions[first as usize] != UNKNOWN {
                continue;
            }
            let region = self.rims.len() as u32;
            let mut rim = Vec::new();
            self.regions[first as usize] = region;
            queue.push(first);
            while let Some(f) = queue.pop() {
                let mut borders = false;
                for e in layout.sides[f as usize] {
                    for (g, _) in layout.edges[e as usize].facets {
                        if g == NONE {
                            continue;
                        }
                        borders |= self.regions[g as usize] == NEAR;
                        if self.regions[g as usize] == UNKNOWN {
                            self.regions[g as usize] = region;
                            queue.push(g);
                        }
                    }
                }
                if borders {
                    rim.push(f);
                }
            }
            self.rims.push(rim);
        }
    }

    /// Lists the facets about every node.
    fn gather(&mut self) {
        let layout = &self.layout;
        let mut starts = vec![0u32; layout.nodes.len() + 1];
        for facet in &layout.facets {
            facet.iter().for_each(|&n| starts[n as usize + 1] += 1);
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        self.around = vec![(0, 0); layout.facets.len() * 3];
        let mut next = starts.clone();
        for (f, facet) in layout.facets.iter().enumerate() {
            for (k, &n) in facet.iter().enumerate() {
                self.around[next[n as usize] as usize] = (f as u32, k as u8);
                next[n as usize] += 1;
            }
        }
        let about = starts.windows(2).map(|w| w[0] as usize..w[1] as usize);
        let of_node = |list: Range<usize>| {
            let mut regions = (self.around[list].iter()).map(|&(f, _)| self.regions[f as usize]);
            let first = regions.next().unwrap_or(NEAR);
            if regions.all(|r| r == first) {
                first
            } else {
                NEAR
            }
        };
        self.node_regions = about.map(of_node).collect();
        self.node_starts = starts;
    }

    /// Lists the facets beside every facet and the cells about every node.
    fn gather_neighbours(&mut self) {
        let layout = &self.layout;
        let beyond = |f: u32, side: u32| {
            let facets = &layout.edges[side as usize].facets;
            facets[usize::from(facets[0].0 == f)]
        };
        let sides = (0..).zip(&layout.sides);
        self.beside = sides.map(|(f, s)| s.map(|e| beyond(f, e))).collect();
        self.corner_cells = vec![[0; 3]; layout.facets.len()];
        self.cell_starts = Vec::with_capacity(self.node_starts.len());
        for about in self.node_starts.windows(2) {
            let start = self.cell_corners.len();
            self.cell_starts.push(start as u32);
            for &(f, k) in &self.around[about[0] as usize..about[1] as usize] {
                let cell = layout.cells[f as usize];
                let mut known = self.cell_corners[start..].iter();
                let number = known.position(|&(g, _)| layout.cells[g as usize] == cell);
                let number = number.map_or(self.cell_corners.len(), |i| start + i);
                if number == self.cell_corners.len() {
                    self.cell_corners.push((f, k));
                }
                self.corner_cells[f as usize][usize::from(k)] = number as u32;
            }
        }
        self.cell_starts.push(self.cell_corners.len() as u32);
    }
}

/// The heights of a surface over the cells of a grid.
pub(super) struct Relief<'a> {
    grid: &'a FacetGrid,
    skin: &'a Skin,
    surface: &'a FractureSurface,
    /// Lowest and highest height over each cell; [`UNKNOWN_RANGE`] for cells whose range is not known yet.
    cells: Vec<(f64, f64)>,
    /// The same over each of [`FacetGrid::rectangles`].
    rectangles: Vec<(f64, f64)>,
}

const UNKNOWN_RANGE: (f64, f64) = (0.0, 0.0);

impl<'a> Relief<'a> {
    pub fn new(skin: &'a Skin, grid: &'a FacetGrid, surface: &'a FractureSurface) -> Self {
        Relief {
            grid,
            skin,
            surface,
            cells: vec![UNKNOWN_RANGE; grid.size * grid.size],
            rectangles: vec![UNKNOWN_RANGE; grid.rectangles.len()],
        }
    }

    fn range(&self, facets: impl Iterator<Item = u32>) -> (f64, f64) {
        range(facets.map(|f| &self.surface.heights[f as usize]))
    }

    /// The side of a limb triangle, or [`Side::Split`] where the facets over it decide.
    pub fn meet(&mut self, rank: usize) -> Side {
        let rectangle = self.grid.rectangle_of[rank] as usize;
        if self.rectangles[rectangle] == UNKNOWN_RANGE {
            self.rectangles[rectangle] = self.over_rectangle(self.grid.rectangles[rectangle]);
        }
        match side(self.skin.spans[rank], self.rectangles[rectangle]) {
            Side::Elsewhere => Side::Split,
            side => side,
        }
    }

    /// Lowest and highest height over the cells of a rectangle.
    fn over_rectangle(&mut self, rectangle: [u16; 4]) -> (f64, f64) {
        let [i0, j0, i1, j1] = rectangle.map(usize::from);
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for j in j0..=j1 {
            for cell in j * self.grid.size + i0..=j * self.grid.size + i1 {
                if self.cells[cell] == UNKNOWN_RANGE {
                    let list = self.grid.starts[cell] as usize..self.grid.starts[cell + 1] as usize;
                    self.cells[cell] = self.range(self.grid.facets[list].iter().copied());
                }
                let cell = self.cells[cell];
                range = (range.0.min(cell.0), range.1.max(cell.1));
            }
        }
        range
    }

    /// The side of a triangle that spans some lengths (m) and lies over some facets.
    pub fn compare(&self, span: (f64, f64), facets: impl Iterator<Item = u32>) -> Side {
        side(span, self.range(facets))
    }
}

/// The side of what spans some lengths, given the range of heights over it: [`Side::Split`] where they overlap,
/// [`Side::Elsewhere`] where there are no heights.
fn side((low, high): (f64, f64), range: (f64, f64)) -> Side {
    if range.0 > range.1 {
        Side::Elsewhere
    } else if low > range.1 {
        Side::Upper
    } else if high <= range.0 {
        Side::Lower
    } else {
        Side::Split
    }
}
