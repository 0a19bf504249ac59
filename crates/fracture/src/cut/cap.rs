//! The broken faces: the part of the surface inside the stem, bounded by the outline on its skin.
//!
//! Tops of facets and walls between them are plane polygons. Where the outline crosses one, its boundary is followed
//! alternately along the outline and along its own border (Weiler and Atherton 1977). Vertices on a border are made
//! once and taken by every face that meets there, so the faces close without gaps. Faces that the outline does not
//! touch, nearly all, are triangles and trapezia and take short ways.

mod column;
mod faces;
mod line;
mod nodes;
mod walls;

use super::error::CutError;
use super::facet_grid::{FacetGrid, NEAR};
use super::follow::{Chains, follow};
use super::overlay::outline::Overlay;
use super::parts::CapFace;
use super::polygon;
use crate::surface::{Edge, FractureSurface, NONE, SectionLayout};
use faces::Faces;
use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use greenstick_geometry::triangulate::Triangulator;
pub(super) use nodes::{Columns, Nodes, one_height_each};
use rayon::iter::{IntoParallelRefMutIterator, ParallelIterator};

/// The broken face, oriented for the lower piece.
#[derive(Default)]
pub(super) struct Cap {
    /// Vertices within the wood.
    pub inside: Vec<DVec3>,
    /// Nodes they lie over, or [`NONE`].
    pub nodes: Vec<u32>,
    pub faces: Faces,
}

pub(super) struct Builder<'a, 'b> {
    surface: &'a FractureSurface,
    grid: &'a FacetGrid,
    overlay: &'b Overlay<'a>,
    /// Number of the first vertex in [`Cap::inside`].
    first: u32,
    /// Whether facets have different heights at a node. Where they have not, the node's vertex is that of all corners
    /// there, numbered as the nodes are.
    stepped: bool,
    /// Vertex at each corner of each facet of a stepped surface.
    corners: Vec<[u32; 3]>,
    /// For each node of a stepped surface where its vertices start in [`Cap::inside`], one for every distinct height of
    /// the facets about it, ascending.
    starts: Vec<u32>,
    /// Outline on facets and on walls: (facet or edge, (from, to)), sorted.
    outline_on_tops: Vec<(u32, (u32, u32))>,
    outline_on_walls: Vec<(u32, (u32, u32))>,
    /// Where the two rims of a wall cross: (fraction, vertex), and the number of that for each edge or [`NONE`].
    knots: Vec<(f64, u32)>,
    knot_of: Vec<u32>,
    /// Whether a facet has a knot on one of its sides.
    knotted: Vec<bool>,
    /// Edges that walls stand over, with the vertices of their rims.
    stepped_edges: Vec<(u32, Rims)>,
    /// Whether the outline touches the wall over an edge or its rims.
    touched: Vec<bool>,
    /// Whether the outline crosses the border of a facet.
    crossed_border: Vec<bool>,
    /// Whether the line along the grain over a node pierces the skin.
    pierced: Vec<bool>,
    /// For each corner of each facet whether it lies inside the stem: 0 unknown, 1 outside, 2 inside.
    status: Vec<[u8; 3]>,
    /// Triangles of tops that the outline crosses: (facet, triangle).
    crossed: Vec<(u32, [u32; 3])>,
    triangulator: Triangulator,
    cap: Cap,
    /// Asked whether to stop.
    context: &'a Context,
}

/// Vertices at the ends of both facets' sides along an inner edge, in the order of its nodes.
type Rims = [[u32; 2]; 2];

/// Memory that is reused from top to top.
#[derive(Default)]
struct TopMemory {
    ring: Vec<u32>,
    flat: Vec<DVec2>,
    filled: Vec<[u32; 3]>,
    chains: Vec<(u32, u32)>,
    border: Vec<u32>,
    /// Where each corner lies in `border`.
    corners: [usize; 3],
}

const OUTSIDE: u8 = 1;
const INSIDE: u8 = 2;

/// Builds the broken face from the outline found by `overlay`.
pub(super) fn build<'a>(
    surface: &'a FractureSurface,
    grid: &'a FacetGrid,
    overlay: &mut Overlay<'a>,
    nodes: Nodes,
    context: &'a Context,
) -> Result<Cap, CutError> {
    overlay.sort();
    let sorted = |list: Vec<(u32, [u32; 2])>| {
        let mut list: Vec<(u32, (u32, u32))> =
            list.into_iter().map(|(f, [a, b])| (f, (a, b))).collect();
        list.sort_unstable();
        list.dedup();
        list
    };
    let outline_on_tops = sorted(std::mem::take(&mut overlay.tops));
    let outline_on_walls = sorted(std::mem::take(&mut overlay.walls));
    let layout = &surface.layout;
    let mut touched = vec![false; layout.edges.len()];
    let mut pierced = vec![false; layout.nodes.len()];
    let mut crossed_border = vec![false; layout.facets.len()];
    for &((e, which), ..) in &overlay.rails {
        touched[e as usize] = true;
        let facet = layout.edges[e as usize].facets[usize::from(which)].0;
        if let Some(crossed) = crossed_border.get_mut(facet as usize) {
            *crossed = true;
        }
    }
    (outline_on_walls.iter()).for_each(|w| touched[w.0 as usize] = true);
    for &(n, ..) in &overlay.uprights {
        pierced[n as usize] = true;
    }
    let mut builder = Builder {
        surface,
        grid,
        first: (overlay.points() + overlay.vertices.len()) as u32,
        overlay,
        stepped: nodes.is_stepped(),
        corners: Vec::new(),
        starts: Vec::new(),
        outline_on_tops,
        outline_on_walls,
        knots: Vec::new(),
        knot_of: Vec::new(),
        knotted: Vec::new(),
        stepped_edges: Vec::new(),
        touched,
        crossed_border,
        pierced,
        status: vec![[0; 3]; layout.facets.len()],
        crossed: Vec::new(),
        triangulator: Triangulator::default(),
        cap: Cap::default(),
        context,
    };
    match nodes {
        Nodes::Even(heights) => {
            let nodes = layout.nodes.iter().zip(&heights).map(|(n, &h)| n.extend(h));
            builder.cap.inside.extend(nodes);
            builder.cap.nodes.extend(0..layout.nodes.len() as u32);
        }
        Nodes::Stepped(columns) => {
            builder.place(columns);
            builder.place_knots();
        }
    }
    let loose = builder.fill_touched_tops()?;
    context.check()?;
    builder.spread_status()?;
    builder.fill_loose_tops(&loose)?;
    let (mut faces, walls) = rayon::join(|| builder.tops(), || builder.walls());
    faces.append(&walls?);
    Ok(Cap {
        faces,
        ..builder.cap
    })
}

/// The chains of one facet or edge.
fn of(list: &[(u32, (u32, u32))], key: u32) -> Vec<(u32, u32)> {
    let from = list.partition_point(|c| c.0 < key);
    list[from..]
        .iter()
        .take_while(|c| c.0 == key)
        .map(|c| c.1)
        .collect()
}

impl<'a> Builder<'a, '_> {
    fn layout(&self) -> &'a SectionLayout {
        &self.surface.layout
    }

    /// Takes the vertices over the nodes of a stepped surface, which come first within the wood.
    fn place(&mut self, columns: Columns) {
        let first = self.first;
        self.corners = columns.corners;
        (self.corners.par_iter_mut()).for_each(|corners| *corners = corners.map(|c| first + c));
        self.starts = columns.starts;
        self.cap.inside = columns.inside;
        self.cap.nodes = columns.nodes;
    }

    fn add(&mut self, grain: DVec3, node: u32) -> u32 {
        self.cap.inside.push(grain);
        self.cap.nodes.push(node);
        self.first + self.cap.inside.len() as u32 - 1
    }

    /// Vertices at the corners of a facet.
    fn corners(&self, facet: u32) -> [u32; 3] {
        if self.stepped {
            self.corners[facet as usize]
        } else {
            self.layout().facets[facet as usize].map(|n| self.first + n)
        }
    }

    fn grain(&self, id: u32) -> DVec3 {
        match id.checked_sub(self.first) {
            Some(i) => self.cap.inside[i as usize],
            None => self.overlay.grain(id),
        }
    }

    /// Finds the walls, and makes a vertex where the two rims of one cross.
    fn place_knots(&mut self) {
        let layout = self.layout();
        self.knot_of = vec![NONE; layout.edges.len()];
        self.knotted = vec![false; layout.facets.len()];
        for (e, edge) in layout.edges.iter().enumerate() {
            let Some(rims) = self.rims(edge) else {
                continue;
            };
            let [a, b] = rims;
            if a == b {
                continue;
            }
            self.stepped_edges.push((e as u32, rims));
            // The vertices over a node ascend.
            if (a[0] < b[0] && a[1] > b[1]) || (a[0] > b[0] && a[1] < b[1]) {
                let [a, b] = self.rim_heights(rims);
                let (u, v) = (a[0] - b[0], a[1] - b[1]);
                let t = u / (u - v);
                let [p, q] = edge.nodes.map(|n| layout.nodes[n as usize]);
                let id = self.add(p.lerp(q, t).extend(a[0] + (a[1] - a[0]) * t), NONE);
                self.knot_of[e] = self.knots.len() as u32;
                self.knots.push((t, id));
                for (facet, _) in edge.facets {
                    self.knotted[facet as usize] = true;
                }
            }
        }
    }

    fn knot(&self, e: u32) -> Option<(f64, u32)> {
        let number = *self.knot_of.get(e as usize)?;
        self.knots.get(number as usize).copied()
    }

    /// The rims along an inner edge of a stepped surface.
    fn rims(&self, edge: &Edge) -> Option<Rims> {
        let [(f, i), (g, j)] = edge.facets;
        (f != NONE && g != NONE).then(|| {
            // The left facet has the nodes in the edge's order, the right one turned round.
            let (h, l) = (&self.corners[f as usize], &self.corners[g as usize]);
            let (i, j) = (usize::from(i), usize::from(j));
            [[h[i], h[(i + 1) % 3]], [l[(j + 1) % 3], l[j]]]
        })
    }

    /// Heights of the ends of rims, m.
    fn rim_heights(&self, rims: Rims) -> [[f64; 2]; 2] {
        rims.map(|rim| rim.map(|id| self.cap.inside[(id - self.first) as usize].z))
    }

    /// Appends the vertices on side `k` of a facet between its corners, in its own direction.
    fn add_side(&self, facet: u32, k: u8, border: &mut Vec<u32>) {
        let layout = self.layout();
        let e = layout.sides[facet as usize][usize::from(k)];
        let edge = &layout.edges[e as usize];
        let which = u8::from(edge.facets[1] == (facet, k));
        let start = border.len();
        let mut knot = self.knot(e);
        if self.touched[e as usize] {
            for (fraction, id) in self.overlay.rail(e, which) {
                border.extend(knot.take_if(|knot| knot.0 <= fraction).map(|knot| knot.1));
                border.push(id);
            }
        }
        border.extend(knot.map(|knot| knot.1));
        if which == 1 {
            border[start..].reverse();
        }
    }

    /// Lists the border of a facet, counter-clockwise: corners and what lies between. Returns where the corners are.
    fn border(&self, facet: u32, border: &mut Vec<u32>) -> [usize; 3] {
        border.clear();
        let corners = self.corners(facet);
        [0, 1, 2].map(|k: u8| {
            let at = border.len();
            border.push(corners[usize::from(k)]);
            self.add_side(facet, k, border);
            at
        })
    }

    /// Fills the tops whose border the outline meets. Returns the facets within which it closes, whose status is not
    /// known yet.
    fn fill_touched_tops(&mut self) -> Result<Vec<u32>, CutError> {
        let tops = std::mem::take(&mut self.outline_on_tops);
        let mut memory = TopMemory::default();
        let mut loose = Vec::new();
        for of_facet in tops.chunk_by(|a, b| a.0 == b.0) {
            self.context.check()?;
            let facet = of_facet[0].0;
            if self.fill_beside_line(facet, of_facet, &mut memory) {
                continue;
            }
            memory.chains.clear();
            memory.chains.extend(of_facet.iter().map(|c| c.1));
            memory.corners = self.border(facet, &mut memory.border);
            let traced = follow(&memory.chains, &memory.border);
            let traced = traced.ok_or_else(|| self.gap(&memory.chains))?;
            if !traced.met {
                loose.push(facet);
                continue;
            }
            self.status[facet as usize] = memory.corners.map(|at| {
                let inside = traced.border.contains(&memory.border[at]);
                if inside { INSIDE } else { OUTSIDE }
            });
            self.fill_top(facet, &traced.loops)?;
        }
        self.outline_on_tops = tops;
        Ok(loose)
    }

    fn fill_top(&mut self, facet: u32, loops: &[Vec<u32>]) -> Result<(), CutError> {
        let mut triangles = Vec::new();
        let mut triangulator = std::mem::take(&mut self.triangulator);
        let filled = polygon::fill(
            &mut triangulator,
            loops,
            |id| self.grain(id).truncate(),
            &mut triangles,
        );
        self.triangulator = triangulator;
        filled.map_err(|_| CutError::Face {
            at: self.grain(loops[0][0]),
        })?;
        self.crossed
            .extend(triangles.into_iter().map(|t| (facet, t)));
        Ok(())
    }

    fn gap(&self, chains: Chains) -> CutError {
        CutError::Face {
            at: self.grain(chains.first().map_or(self.first, |c| c.0)),
        }
    }

    /// How many times the line along the grain over `node` pierces the skin between two heights.
    fn count_pierced(&self, node: u32, a: f64, b: f64) -> usize {
        if !self.pierced[node as usize] {
            return 0;
        }
        let (low, high) = (a.min(b), a.max(b));
        let pierced = self.overlay.upright(node);
        pierced.filter(|p| p.0 > low && p.0 < high).count()
    }

    /// Carries inside and outside from facets that the outline crosses to all others. Where there is no skin above or
    /// below, a whole region of the layout has one status.
    fn spread_status(&mut self) -> Result<(), CutError> {
        let layout = self.layout();
        let mut regions = vec![0u8; self.grid.rims.len()];
        // In the order of facets, most of which border on one before; what lies behind waits.
        let mut queue = Vec::new();
        for f in 0..layout.facets.len() as u32 {
            if self.status[f as usize][0] != 0 {
                self.carry_status(f, f, &mut regions, &mut queue);
            }
        }
        while let Some(f) = queue.pop() {
            self.carry_status(f, NONE, &mut regions, &mut queue);
        }
        for (status, &region) in self.status.iter_mut().zip(&self.grid.regions) {
            if status[0] == 0 {
                let known = regions.get(region as usize).copied().unwrap_or(0);
                if known == 0 {
                    return Err(CutError::Misses);
                }
                *status = [known; 3];
            }
        }
        Ok(())
    }

    /// Carries the status of a facet to those beside it; up to number `passed` they go to the queue.
    fn carry_status(&mut self, f: u32, passed: u32, regions: &mut [u8], queue: &mut Vec<u32>) {
        let (layout, grid) = (self.layout(), self.grid);
        for k in 0..3usize {
            let (g, side) = grid.beside[f as usize][k];
            let side = usize::from(side);
            if g == NONE || self.status[g as usize][0] != 0 {
                continue;
            }
            let region = grid.regions[g as usize];
            if region != NEAR && regions[region as usize] != 0 {
                continue;
            }
            // Corner k of f is the end of g's side.
            let node = layout.facets[f as usize][k];
            let (a, b) = (
                self.surface.heights[f as usize][k],
                self.surface.heights[g as usize][(side + 1) % 3],
            );
            let flip = self.count_pierced(node, a, b) % 2 == 1;
            let inside = (self.status[f as usize][k] == INSIDE) != flip;
            let status = if inside { INSIDE } else { OUTSIDE };
            let mut set = |f: u32| {
                self.status[f as usize] = [status; 3];
                if f <= passed {
                    queue.push(f);
                }
            };
            if region == NEAR {
                set(g);
            } else {
                regions[region as usize] = status;
                grid.rims[region as usize].iter().for_each(|&f| set(f));
            }
        }
    }

    /// Fills the tops within which the outline closes.
    fn fill_loose_tops(&mut self, loose: &[u32]) -> Result<(), CutError> {
        for &facet in loose {
            self.context.check()?;
            let chains = of(&self.outline_on_tops, facet);
            let mut loops: Vec<Vec<u32>> = Vec::new();
            if self.status[facet as usize] == [INSIDE; 3] {
                let mut border = Vec::new();
                self.border(facet, &mut border);
                loops.push(border);
            }
            let traced = follow(&chains, &[]).ok_or_else(|| self.gap(&chains))?;
            loops.extend(traced.loops);
            if !loops.is_empty() {
                self.fill_top(facet, &loops)?;
            }
        }
        self.crossed.sort_by_key(|c| c.0);
        Ok(())
    }

    /// All tops: those that the outline crosses, filled before, and the whole ones.
    fn tops(&self) -> Faces {
        let layout = self.layout();
        let mut faces = Faces::with_capacity(layout.facets.len() + self.crossed.len());
        let mut done = self.crossed.iter().peekable();
        let mut outlined = self.outline_on_tops.iter().map(|t| t.0).peekable();
        for facet in 0..layout.facets.len() as u32 {
            let face = CapFace {
                cell: layout.cells[facet as usize],
                top: true,
            };
            while outlined.next_if(|&f| f < facet).is_some() {}
            if outlined.peek() == Some(&facet) {
                while let Some((_, triangle)) = done.next_if(|c| c.0 == facet) {
                    faces.push(*triangle, face);
                }
            } else if self.status[facet as usize] == [INSIDE; 3]
                && !self.crossed_border[facet as usize]
            {
                self.fill_whole_top(facet, |triangle| faces.push(triangle, face));
            }
        }
        faces
    }

    /// Fills a facet that lies wholly inside: split at knots on its sides, else as it is.
    fn fill_whole_top(&self, facet: u32, mut push: impl FnMut([u32; 3])) {
        let c = self.corners(facet);
        if self.knotted.get(facet as usize) != Some(&true) {
            return push(c);
        }
        let m = self.layout().sides[facet as usize].map(|e| self.knot(e).map(|k| k.1));
        match m {
            [None, None, None] => push(c),
            [Some(x), Some(y), Some(z)] => {
                for t in [[c[0], x, z], [x, c[1], y], [z, y, c[2]], [x, y, z]] {
                    push(t);
                }
            }
            _ => {
                for k in 0..3 {
                    let [a, b, d] = [c[k], c[(k + 1) % 3], c[(k + 2) % 3]];
                    match [m[k], m[(k + 1) % 3], m[(k + 2) % 3]] {
                        [Some(x), None, None] => {
                            push([a, x, d]);
                            push([x, b, d]);
                        }
                        [Some(x), Some(y), None] => {
                            push([x, b, y]);
                            push([a, x, y]);
                            push([a, y, d]);
                        }
                        _ => {}
                    }
                }
            }
        }
    }
}
