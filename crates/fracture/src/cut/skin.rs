//! The skin of a stem, sorted along the grain and across it once for any number of cuts.

use super::parts::{Side, Solid};
use crate::surface::NONE;
use glam::DVec2;
use greenstick_geometry::Unions;
use std::sync::Arc;

/// Cells of the finest grid, each way.
pub(super) const FINEST: usize = 256;
/// Grids from fine to coarse, each of half as many cells each way.
pub(super) const LEVELS: usize = 5;

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
    pub(super) spans: Vec<(f64, f64)>,
    /// Highest length of all up to each rank, and lowest of all from it on.
    highest: Vec<f64>,
    lowest: Vec<f64>,
    /// Whether each is of the limb, by rank.
    limb: Vec<bool>,
    /// Lowest and highest rank of the limb's triangles at each point.
    about: Vec<(u32, u32)>,
    /// Columns and rows of the finest grid that each limb triangle covers.
    pub(super) cells: Vec<[u16; 4]>,
    low: DVec2,
    scale: DVec2,
    /// For each level of the grid, from fine to coarse, the cells that skin within reach covers.
    pub(super) masks: Vec<Vec<bool>>,
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

    pub(super) fn cell(&self, p: DVec2) -> [usize; 2] {
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
