//! The parts of a cut that stay the same while its parameters change: the skin sorted along the grain and across it, and which facets of a
//! layout lie near it.

use super::parts::{Side, Solid};
use crate::surface::{FractureSurface, NONE, SectionLayout, range};
use glam::DVec2;
use greenstick_geometry::Unions;
use std::ops::Range;
use std::sync::Arc;

/// Cells of the finest grid, each way.
const FINEST: usize = 256;
const LEVELS: usize = 5;

/// The skin of a stem, sorted once for any number of cuts.
///
/// Its triangles are ranked by their middle along the grain, so that those wholly below a break come first and those
/// wholly above it last. Parts of the shell off the limb are ranked by where they are joined to it.
#[derive(Debug, Clone, Default)]
pub struct Skin {
    /// Triangles of the shell by rank.
    pub order: Vec<u32>,
    pub(super) ranks: Arc<Vec<u32>>,
    /// Lowest and highest length of each, by rank, m.
    spans: Vec<(f64, f64)>,
    /// Highest length of all up to each rank, and lowest of all from it on.
    highest: Vec<f64>,
    lowest: Vec<f64>,
    /// Whether each is of the limb, by rank.
    limb: Vec<bool>,
    /// Lowest and highest rank of the limb's triangles at each point.
    about: Vec<(u32, u32)>,
    /// Columns and rows of the finest grid that each limb triangle covers.
    cells: Vec<[u16; 4]>,
    low: DVec2,
    scale: DVec2,
    /// For each level of the grid, from fine to coarse, the cells that skin within reach covers.
    masks: Vec<Vec<bool>>,
}

impl Skin {
    /// Sorts the skin of `solid` for breaks whose heights lie within `reach` (m).
    pub fn new(solid: &Solid, reach: (f64, f64)) -> Self {
        let mut items: Vec<(f64, u32, f64, f64, bool)> = Vec::with_capacity(solid.shell.len());
        let mut on_limb = vec![false; solid.triangles.len()];
        let mut touched = vec![false; solid.points.len()];
        for &t in solid.limb {
            on_limb[t as usize] = true;
            let s = solid.triangles[t as usize].map(|p| {
                touched[p as usize] = true;
                solid.points[p as usize].z
            });
            let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
            items.push(((low + high) / 2.0, t, low, high, true));
        }
        let shell = solid.shell.iter().copied();
        let off: Vec<u32> = shell.filter(|&t| !on_limb[t as usize]).collect();
        if !off.is_empty() {
            let mut joined = Unions::new(solid.points.len());
            for &t in &off {
                joined.join_triangle(solid.triangles[t as usize]);
            }
            let none = (f64::INFINITY, f64::NEG_INFINITY);
            let mut spans = vec![none; solid.points.len()];
            for p in 0..solid.points.len() as u32 {
                if touched[p as usize] {
                    let span = &mut spans[joined.root(p) as usize];
                    let s = solid.points[p as usize].z;
                    *span = (span.0.min(s), span.1.max(s));
                }
            }
            for &t in &off {
                let root = joined.root(solid.triangles[t as usize][0]);
                let (mut low, mut high) = spans[root as usize];
                if low > high {
                    // Joined to the limb nowhere: it stays with the lower piece.
                    (low, high) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
                }
                items.push((low / 2.0 + high / 2.0, t, low, high, false));
            }
        }
        items.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut skin = Skin {
            order: items.iter().map(|i| i.1).collect(),
            spans: items.iter().map(|i| (i.2, i.3)).collect(),
            limb: items.iter().map(|i| i.4).collect(),
            ..Skin::default()
        };
        let mut ranks = vec![NONE; solid.triangles.len()];
        for (rank, &t) in skin.order.iter().enumerate() {
            ranks[t as usize] = rank as u32;
        }
        skin.ranks = Arc::new(ranks);
        skin.about = vec![(NONE, 0); solid.points.len()];
        for (rank, &t) in skin.order.iter().enumerate().filter(|(r, _)| skin.limb[*r]) {
            for p in solid.triangles[t as usize] {
                let about = &mut skin.about[p as usize];
                *about = (about.0.min(rank as u32), about.1.max(rank as u32));
            }
        }
        let mut most = f64::NEG_INFINITY;
        skin.highest = Vec::with_capacity(skin.spans.len());
        for span in &skin.spans {
            most = most.max(span.1);
            skin.highest.push(most);
        }
        let mut least = f64::INFINITY;
        skin.lowest = vec![0.0; skin.spans.len()];
        for (rank, span) in skin.spans.iter().enumerate().rev() {
            least = least.min(span.0);
            skin.lowest[rank] = least;
        }
        skin.spread_cells(solid, reach);
        skin
    }

    /// Finds the cells that the limb's triangles cover.
    fn spread_cells(&mut self, solid: &Solid, reach: (f64, f64)) {
        let within = |span: &(f64, f64)| span.1 >= reach.0 && span.0 <= reach.1;
        let rectangle = |t: u32| {
            let [a, b, c] =
                solid.triangles[t as usize].map(|p| solid.points[p as usize].truncate());
            (a.min(b).min(c), a.max(b).max(c))
        };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for rank in 0..self.order.len() {
            if self.limb[rank] && within(&self.spans[rank]) {
                let (l, h) = rectangle(self.order[rank]);
                (low, high) = (low.min(l), high.max(h));
            }
        }
        if low.x > high.x {
            (low, high) = (DVec2::ZERO, DVec2::ONE);
        }
        self.low = low;
        self.scale = DVec2::splat(FINEST as f64) / (high - low).max(DVec2::splat(1e-300));
        let mut mask = vec![false; FINEST * FINEST];
        self.cells = Vec::with_capacity(self.order.len());
        for rank in 0..self.order.len() {
            let mut cells = [0; 4];
            if self.limb[rank] && within(&self.spans[rank]) {
                let (l, h) = rectangle(self.order[rank]);
                let ([i0, j0], [i1, j1]) = (self.cell(l), self.cell(h));
                cells = [i0, j0, i1, j1].map(|c| c as u16);
                for j in j0..=j1 {
                    mask[j * FINEST + i0..=j * FINEST + i1].fill(true);
                }
            }
            self.cells.push(cells);
        }
        self.masks.push(mask);
        for level in 1..LEVELS {
            let size = FINEST >> level;
            let mut mask = vec![false; size * size];
            for (i, &full) in self.masks[level - 1].iter().enumerate() {
                if full {
                    mask[(i / (2 * size) / 2) * size + i % (2 * size) / 2] = true;
                }
            }
            self.masks.push(mask);
        }
    }

    fn cell(&self, p: DVec2) -> [usize; 2] {
        let c = (p - self.low) * self.scale;
        [c.x, c.y].map(|c| (c.max(0.0) as usize).min(FINEST - 1))
    }

    /// Ranks from and to which the skin meets heights between `low` and `high` (m).
    pub(super) fn window(&self, (low, high): (f64, f64)) -> (usize, usize) {
        let below = self.highest.partition_point(|&h| h <= low);
        let above = self.lowest.partition_point(|&l| l <= high);
        (below, above.max(below))
    }

    pub(super) fn span(&self, rank: usize) -> (f64, f64) {
        self.spans[rank]
    }

    /// Lowest and highest rank of the limb's triangles at a point; the lowest is [`NONE`] where there are none.
    pub(super) fn about(&self, point: u32) -> (u32, u32) {
        self.about[point as usize]
    }

    pub(super) fn is_limb(&self, rank: usize) -> bool {
        self.limb[rank]
    }
}

/// Which piece every triangle of a mesh goes to.
#[derive(Debug, Clone, Default)]
pub struct Sides {
    ranks: Arc<Vec<u32>>,
    /// Rank before which all of the skin is in the lower piece.
    pub below: usize,
    /// Rank from which on all of it is in the upper piece.
    pub above: usize,
    /// Sides of what lies between, by rank.
    pub between: Vec<Side>,
}

impl Sides {
    pub(super) fn new(skin: &Skin, (below, above): (usize, usize)) -> Self {
        Sides {
            ranks: skin.ranks.clone(),
            below,
            above,
            between: vec![Side::Elsewhere; above - below],
        }
    }
}

impl std::ops::Index<usize> for Sides {
    type Output = Side;

    /// The side of a triangle of the mesh.
    fn index(&self, triangle: usize) -> &Side {
        match self.ranks[triangle] {
            NONE => &Side::Elsewhere,
            rank if (rank as usize) < self.below => &Side::Lower,
            rank if (rank as usize) >= self.above => &Side::Upper,
            rank => &self.between[rank as usize - self.below],
        }
    }
}

/// The facets of a layout as they lie on a skin; made once for any heights.
#[derive(Debug, Clone, Default)]
pub struct Ground {
    /// The layout.
    pub layout: Arc<SectionLayout>,
    /// Halvings of the skin's finest grid.
    level: usize,
    size: usize,
    /// Where each cell's list in `facets` starts.
    starts: Vec<u32>,
    facets: Vec<u32>,
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
    /// For each node the region that all facets about it belong to, [`NEAR`] where one of them lies near the skin.
    pub(super) node_regions: Vec<u32>,
}

/// "Near the skin" in [`Ground::regions`].
pub(super) const NEAR: u32 = NONE;
const UNKNOWN: u32 = NONE - 1;

impl Ground {
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

    /// Lays out `layout` on `skin`.
    pub fn new(skin: &Skin, layout: &Arc<SectionLayout>) -> Self {
        let wanted = (layout.facets.len() as f64).sqrt() as usize;
        let mut level = 0;
        while level + 1 < LEVELS && FINEST >> level > wanted.max(1) {
            level += 1;
        }
        let size = FINEST >> level;
        let mut ground = Ground {
            layout: layout.clone(),
            level,
            size,
            starts: vec![0; size * size + 1],
            regions: vec![UNKNOWN; layout.facets.len()],
            ..Ground::default()
        };
        ground.spread(skin);
        ground.part();
        ground.gather();
        ground
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
}

/// The heights of a surface over the cells of a ground.
pub(super) struct Relief<'a> {
    ground: &'a Ground,
    skin: &'a Skin,
    surface: &'a FractureSurface,
    /// Lowest and highest height over each cell; [`UNKNOWN_RANGE`] for cells whose range is not known yet.
    cells: Vec<(f64, f64)>,
}

const UNKNOWN_RANGE: (f64, f64) = (0.0, 0.0);

impl<'a> Relief<'a> {
    pub fn new(skin: &'a Skin, ground: &'a Ground, surface: &'a FractureSurface) -> Self {
        Relief {
            ground,
            skin,
            surface,
            cells: vec![UNKNOWN_RANGE; ground.size * ground.size],
        }
    }

    fn range(&self, facets: impl Iterator<Item = u32>) -> (f64, f64) {
        range(facets.map(|f| &self.surface.heights[f as usize]))
    }

    /// The side of a limb triangle, or [`Side::Split`] where the facets over it decide.
    pub fn meet(&mut self, rank: usize) -> Side {
        let [i0, j0, i1, j1] = self.skin.cells[rank].map(|c| usize::from(c) >> self.ground.level);
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for j in j0..=j1 {
            for cell in j * self.ground.size + i0..=j * self.ground.size + i1 {
                if self.cells[cell] == UNKNOWN_RANGE {
                    let list =
                        self.ground.starts[cell] as usize..self.ground.starts[cell + 1] as usize;
                    self.cells[cell] = self.range(self.ground.facets[list].iter().copied());
                }
                let cell = self.cells[cell];
                range = (range.0.min(cell.0), range.1.max(cell.1));
            }
        }
        match side(self.skin.spans[rank], range) {
            Side::Elsewhere => Side::Split,
            side => side,
        }
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
