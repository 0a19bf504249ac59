//! The walls of the broken face, along the grain between tops of different heights.

use super::super::error::CutError;
use super::super::follow::{Chains, follow};
use super::super::parts::CapFace;
use super::super::polygon;
use super::{Builder, Faces, INSIDE, Rims, of};
use crate::surface::Edge;
use glam::DVec2;
use greenstick_geometry::triangulate::Triangulator;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;
use std::ops::Deref;

/// Edges whose walls one task fills.
const EDGES_AT_ONCE: usize = 4096;

/// Fills walls of a face that is known but for them.
struct WallFiller<'a, 'b, 'c> {
    builder: &'c Builder<'a, 'b>,
    triangulator: Triangulator,
    filled: Faces,
}

impl<'a, 'b> Deref for WallFiller<'a, 'b, '_> {
    type Target = Builder<'a, 'b>;

    fn deref(&self) -> &Builder<'a, 'b> {
        self.builder
    }
}

impl Builder<'_, '_> {
    /// Fills the walls over all stepped edges.
    pub(super) fn walls(&self) -> Result<Vec<Faces>, CutError> {
        let tasks = self.stepped_edges.par_chunks(EDGES_AT_ONCE);
        let fill = |edges: &[(u32, Rims)]| {
            let mut filler = WallFiller {
                builder: self,
                triangulator: Triangulator::default(),
                filled: Faces::with_capacity(edges.len() * 3),
            };
            filler.fill_walls(edges)?;
            Ok(filler.filled)
        };
        let filled: Vec<Result<Faces, CutError>> = tasks.map(fill).collect();
        // Of several errors the first, whichever was found first.
        filled.into_iter().collect()
    }

    /// Whether the start of a wall that the outline does not cross lies inside the stem.
    fn starts_inside(&self, e: u32, edge: &Edge, span: (f64, f64)) -> bool {
        let (facet, k) = edge.facets[0];
        let inside = self.status[facet as usize][usize::from(k)] == INSIDE;
        let rail = self.overlay.rail(e, 0);
        let crossed = rail.filter(|p| p.0 < span.0).count();
        inside != (crossed % 2 == 1)
    }
}

impl WallFiller<'_, '_, '_> {
    fn fill_walls(&mut self, edges: &[(u32, Rims)]) -> Result<(), CutError> {
        let builder = self.builder;
        for &(e, rims) in edges {
            let e = e as usize;
            let edge = &builder.layout().edges[e];
            let knot = builder.knot(e as u32);
            let mut ends = edge.nodes.iter();
            let touched = builder.touched[e] || ends.any(|&n| builder.pierced[n as usize]);
            if !touched {
                let (facet, k) = edge.facets[0];
                if builder.status[facet as usize][usize::from(k)] == INSIDE {
                    self.fill_whole_wall(edge, rims, knot);
                }
                continue;
            }
            builder.context.check()?;
            let chains = if builder.touched[e] {
                of(&builder.outline_on_walls, e as u32)
            } else {
                Vec::new()
            };
            let [a, b] = builder.rim_heights(rims);
            match knot {
                None => self.fill_wall(e as u32, edge, [a, b], (0.0, 1.0), &chains)?,
                Some((t, _)) => {
                    self.fill_wall(e as u32, edge, [a, b], (0.0, t), &chains)?;
                    self.fill_wall(e as u32, edge, [a, b], (t, 1.0), &chains)?;
                }
            }
        }
        Ok(())
    }

    /// Notes that a wall begins, and what it belongs to.
    fn begin_wall(&mut self, edge: &Edge, left_high: bool) -> CapFace {
        self.filled.walls.push(self.filled.triangles.len() as u32);
        let facet = edge.facets[usize::from(!left_high)].0;
        CapFace {
            cell: self.layout().cells[facet as usize],
            top: false,
        }
    }

    /// Fills a wall that the outline does not touch: a trapezium, or two triangles where its rims cross.
    fn fill_whole_wall(&mut self, edge: &Edge, [a, b]: Rims, knot: Option<(f64, u32)>) {
        // The vertices over a node are numbered by their heights.
        let column = |k: usize| {
            let (low, high) = (a[k].min(b[k]), a[k].max(b[k]));
            (low - self.first, high - self.first)
        };
        let (left, right) = (column(0), column(1));
        let Some((_, id)) = knot else {
            let left_high = (a[0] > b[0]) | (a[1] > b[1]);
            let face = self.begin_wall(edge, left_high);
            self.fill_between(left, right, left_high, face);
            return;
        };
        let at = (id - self.first, id - self.first);
        let face = self.begin_wall(edge, a[0] > b[0]);
        self.fill_between(left, at, a[0] > b[0], face);
        let face = self.begin_wall(edge, a[1] > b[1]);
        self.fill_between(at, right, a[1] > b[1], face);
    }

    /// Triangles between two columns of vertices, each from its lowest to its highest, by the shorter diagonals.
    fn fill_between(
        &mut self,
        (mut i, left): (u32, u32),
        (mut j, right): (u32, u32),
        forward: bool,
        face: CapFace,
    ) {
        let builder = self.builder;
        let height = |i: u32| builder.cap.inside[i as usize].z;
        let count = (left - i) + (right - j);
        // Which column climbs is not to be predicted, so nothing branches on it.
        for _ in 0..count {
            let (next_left, next_right) = ((i + 1).min(left), (j + 1).min(right));
            let shorter =
                (height(next_right) - height(i)).abs() <= (height(next_left) - height(j)).abs();
            let climbs_right = (j < right) & ((i == left) | shorter);
            let (p, q) = (i, j);
            i += u32::from(!climbs_right);
            j += u32::from(climbs_right);
            let r = if climbs_right { j } else { i };
            let (second, third) = if forward { (q, r) } else { (r, q) };
            let triangle = [p, second, third].map(|v| builder.first + v);
            self.filled.push(triangle, face);
        }
    }

    /// Vertices on a rim of a wall within `span`, from its start to its end, the ends included.
    fn rim(&self, e: u32, edge: &Edge, which: u8, span: (f64, f64)) -> Vec<u32> {
        let (facet, k) = edge.facets[usize::from(which)];
        let corners = self.corners(facet);
        let ends = [corners[usize::from(k)], corners[(usize::from(k) + 1) % 3]];
        let [start, end] = if which == 0 { ends } else { [ends[1], ends[0]] };
        let knot = self.knot(e);
        let mut rim = vec![if span.0 == 0.0 {
            start
        } else {
            knot.map_or(start, |k| k.1)
        }];
        let list = self.overlay.rail(e, which);
        rim.extend(list.filter(|p| p.0 > span.0 && p.0 < span.1).map(|p| p.1));
        rim.push(if span.1 == 1.0 {
            end
        } else {
            knot.map_or(end, |k| k.1)
        });
        rim
    }

    /// Vertices of the line along the grain over `node` strictly between two heights, ascending.
    fn upright(&self, node: u32, low: f64, high: f64) -> Vec<u32> {
        let range = self.starts[node as usize] as usize..self.starts[node as usize + 1] as usize;
        let column = range.map(|i| (self.cap.inside[i].z, self.first + i as u32));
        let mut list: Vec<(f64, u32)> = column.filter(|p| p.0 > low && p.0 < high).collect();
        if self.pierced[node as usize] {
            let pierced = self.overlay.upright(node);
            list.extend(pierced.filter(|p| p.0 > low && p.0 < high));
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        list.into_iter().map(|p| p.1).collect()
    }

    fn fill_wall(
        &mut self,
        e: u32,
        edge: &Edge,
        [a, b]: [[f64; 2]; 2],
        span: (f64, f64),
        chains: Chains,
    ) -> Result<(), CutError> {
        let middle = (span.0 + span.1) / 2.0;
        let at = |rim: [f64; 2]| rim[0] + (rim[1] - rim[0]) * middle;
        // The higher facet's wood stands behind the wall; seen from the lower one, its border is counter-clockwise.
        let left_high = at(a) > at(b);
        let (high, low) = if left_high { (0, 1) } else { (1, 0) };
        let (mut top, bottom) = (self.rim(e, edge, high, span), self.rim(e, edge, low, span));
        let (high_rim, low_rim) = if left_high { (a, b) } else { (b, a) };
        let mut border = bottom;
        if span.1 == 1.0 {
            border.extend(self.upright(edge.nodes[1], low_rim[1], high_rim[1]));
        }
        top.reverse();
        border.extend(top);
        if span.0 == 0.0 {
            let mut down = self.upright(edge.nodes[0], low_rim[0], high_rim[0]);
            down.reverse();
            border.extend(down);
        }
        border.dedup();
        if border.first() == border.last() {
            border.pop();
        }
        if !left_high {
            border.reverse();
        }
        let traced = follow(chains, &border).ok_or_else(|| self.gap(chains))?;
        let mut loops = traced.loops;
        let [p, q] = edge.nodes.map(|n| self.layout().nodes[n as usize]);
        // Lines that close within the wall may belong to its part beyond the knot.
        let on_border = |l: &[u32]| border.contains(&l[0]);
        let within = |l: &[u32]| {
            let t = (self.grain(l[0]).truncate() - p).dot(q - p) / (q - p).length_squared();
            t > span.0 && t < span.1
        };
        loops.retain(|l| on_border(l) || within(l));
        if !traced.met && self.starts_inside(e, edge, span) {
            loops.insert(0, border);
        }
        if loops.is_empty() {
            return Ok(());
        }
        let along = (q - p) / (q - p).length();
        let sign = if left_high { 1.0 } else { -1.0 };
        let mut triangulator = std::mem::take(&mut self.triangulator);
        let flat = |id: u32| {
            let g = self.grain(id);
            DVec2::new(sign * (g.truncate() - p).dot(along), g.z)
        };
        let mut triangles = Vec::new();
        let filled = polygon::fill(&mut triangulator, &loops, flat, &mut triangles);
        self.triangulator = triangulator;
        filled.map_err(|_| CutError::Face {
            at: self.grain(loops[0][0]),
        })?;
        let face = self.begin_wall(edge, left_high);
        for triangle in triangles {
            self.filled.push(triangle, face);
        }
        Ok(())
    }
}
