//! Cutting the skin of a stem along a break surface.
//!
//! Each triangle of the skin is laid over the facets of the surface in the (x, y) plane of grain space. Which facets it
//! meets follows from exact orientation tests alone, so neighbouring triangles always agree, and a point cut on an
//! edge is made once and shared. Within a facet the skin lies above the surface (upper piece) or below it (lower
//! piece); the lines between are the outline that the broken faces must fill.

mod join;

use super::{CutError, CutVertex, Host};
use crate::surface::{NONE, Surface};
use glam::{DVec2, DVec3};
use greenstick_geometry::intersect::orient2d as orientation;
use greenstick_geometry::triangulate::Triangulator;
use rustc_hash::FxHashMap;

/// What an edge of a clipped polygon lies on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Support {
    /// Side i of the skin's triangle.
    Skin(u8),
    /// Side k of the facet.
    Facet(u8),
}

/// What a corner of a clipped polygon is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Corner {
    /// Corner i of the skin's triangle.
    Point(u8),
    /// Side i of the triangle across side k of the facet.
    Crossing(u8, u8),
    /// Corner k of the facet.
    Node(u8),
}

/// A corner of the part of a triangle over a facet.
#[derive(Clone, Copy)]
struct Placed {
    id: u32,
    /// Height above the surface, m.
    above: f64,
    /// What the edge to the next corner lies on.
    support: Support,
    corner: Corner,
}

/// A point where the surface cuts an edge of a clipped polygon.
#[derive(Clone, Copy)]
struct Cut {
    fraction: f64,
    id: u32,
    above: [u64; 2],
}

/// A directed edge of the lower or the upper part of a triangle.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: u32,
    to: u32,
    upper: bool,
    /// The edge of the layout it lies on, or [`NONE`].
    edge: u32,
    /// Side of the skin's triangle it lies on, or 3.
    side: u8,
}

/// The outline of the cut and everything found on the way. Vertex numbers below `points.len()` are the skin's points,
/// the others index `vertices`.
pub(super) struct Overlay<'a> {
    surface: &'a Surface,
    /// Grain coordinates of the skin's points.
    points: &'a [DVec3],
    /// Vertices made by the cut.
    pub vertices: Vec<CutVertex>,
    /// Outline on the top of a facet, directed as the upper skin has it: (facet, [from, to]).
    pub tops: Vec<(u32, [u32; 2])>,
    /// Outline on the wall over an edge: (edge, [from, to]).
    pub walls: Vec<(u32, [u32; 2])>,
    /// Outline points on the top rim of a wall: (edge, which of its facets) → (fraction of the edge, vertex).
    pub rails: FxHashMap<(u32, u8), Vec<(f64, u32)>>,
    /// Where the line along the grain over a node pierces the skin: node → (length, vertex).
    pub uprights: FxHashMap<u32, Vec<(f64, u32)>>,
    /// New triangles of the skin: (source triangle, corners, in the upper piece).
    pub skin: Vec<(u32, [u32; 3], bool)>,
    crossings: FxHashMap<(u32, u32, u32), (u32, f64)>,
    nodes: FxHashMap<(u32, u32), u32>,
    cuts: FxHashMap<(u32, u32), Vec<Cut>>,
    pieces: Vec<Piece>,
    triangulator: Triangulator,
}

/// Which side of the surface a whole triangle lies on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Place {
    /// All below.
    Lower,
    /// All above.
    Upper,
    /// Cut; its parts are in [`Overlay::skin`].
    Split,
}

impl<'a> Overlay<'a> {
    pub fn new(surface: &'a Surface, points: &'a [DVec3]) -> Self {
        Overlay {
            surface,
            points,
            vertices: Vec::new(),
            tops: Vec::new(),
            walls: Vec::new(),
            rails: FxHashMap::default(),
            uprights: FxHashMap::default(),
            skin: Vec::new(),
            crossings: FxHashMap::default(),
            nodes: FxHashMap::default(),
            cuts: FxHashMap::default(),
            pieces: Vec::new(),
            triangulator: Triangulator::default(),
        }
    }

    /// Number of the skin's points.
    pub fn points(&self) -> usize {
        self.points.len()
    }

    /// Grain coordinates of a vertex.
    pub fn grain(&self, id: u32) -> DVec3 {
        match (id as usize).checked_sub(self.points.len()) {
            None => self.points[id as usize],
            Some(i) => self.vertices[i].grain,
        }
    }

    pub fn add(&mut self, grain: DVec3, host: Host) -> u32 {
        self.vertices.push(CutVertex { grain, host });
        (self.points.len() + self.vertices.len() - 1) as u32
    }

    fn xy(&self, point: u32) -> DVec2 {
        self.points[point as usize].truncate()
    }

    /// Lays triangle number `triangle` with the points `corners` over the facets `candidates`.
    pub fn split(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        candidates: &[u32],
    ) -> Result<Place, CutError> {
        self.pieces.clear();
        let mut clipped = Vec::with_capacity(9);
        let mut spans: Vec<(u32, u32, u32)> = Vec::new();
        for &facet in candidates {
            self.clip(corners, facet, &mut clipped);
            if clipped.len() >= 3 {
                let placed = self.place(triangle, corners, facet, &clipped);
                self.divide(triangle, corners, facet, &placed, &mut spans)?;
            }
        }
        if self.pieces.iter().all(|p| p.upper) {
            return Ok(Place::Upper);
        }
        if self.pieces.iter().all(|p| !p.upper) {
            return Ok(Place::Lower);
        }
        self.expand(&spans);
        self.join(triangle, corners)?;
        Ok(Place::Split)
    }

    /// Whether point `p` lies left of side `k` of `facet`. Ties go the same way for both facets of an edge.
    fn inside(&self, facet: u32, k: u8, p: u32) -> bool {
        let layout = &self.surface.layout;
        let edge = &layout.edges[layout.sides[facet as usize][usize::from(k)] as usize];
        let [a, b] = edge.nodes.map(|n| layout.nodes[n as usize]);
        (orientation(a, b, self.xy(p)) >= 0.0) == (edge.facets[0] == (facet, k))
    }

    /// Whether `node` lies left of p → q. Ties go the same way for both triangles of an edge.
    fn left(&self, p: u32, q: u32, node: u32) -> bool {
        let n = self.surface.layout.nodes[node as usize];
        (orientation(self.xy(p.min(q)), self.xy(p.max(q)), n) >= 0.0) == (p < q)
    }

    /// The part of a triangle over a facet (Sutherland and Hodgman 1974), each corner named by what it is.
    fn clip(&self, corners: [u32; 3], facet: u32, out: &mut Vec<(Corner, Support)>) {
        out.clear();
        let mut inside = [[false; 3]; 3];
        for k in 0..3u8 {
            let line = corners.map(|p| self.inside(facet, k, p));
            if line == [false; 3] {
                return;
            }
            inside[usize::from(k)] = line;
        }
        let nodes = self.surface.layout.facets[facet as usize];
        out.extend((0..3).map(|i| (Corner::Point(i), Support::Skin(i))));
        let mut before = Vec::with_capacity(9);
        for k in 0..3u8 {
            if inside[usize::from(k)].iter().all(|&i| i) {
                continue;
            }
            std::mem::swap(&mut before, out);
            out.clear();
            let keeps = |corner: Corner| match corner {
                Corner::Point(i) => inside[usize::from(k)][usize::from(i)],
                Corner::Node(_) => true,
                Corner::Crossing(i, line) => {
                    // Along the other line, the crossing lies before or after the node it shares with line k.
                    let next = (line + 1) % 3 == k;
                    let shared = nodes[usize::from(if next { k } else { line })];
                    let (p, q) = (corners[usize::from(i)], corners[(usize::from(i) + 1) % 3]);
                    let before =
                        self.left(p, q, shared) == inside[usize::from(line)][usize::from(i)];
                    before == next
                }
            };
            let count = before.len();
            for j in 0..count {
                let (corner, support) = before[j];
                let following = before[(j + 1) % count].0;
                let (here, there) = (keeps(corner), keeps(following));
                let crossing = match support {
                    Support::Skin(i) => Corner::Crossing(i, k),
                    Support::Facet(line) => {
                        Corner::Node(if (line + 1) % 3 == k { k } else { line })
                    }
                };
                match (here, there) {
                    (true, true) => out.push((corner, support)),
                    (true, false) => out.extend([(corner, support), (crossing, Support::Facet(k))]),
                    (false, true) => out.push((crossing, support)),
                    (false, false) => {}
                }
            }
            if out.len() < 3 {
                out.clear();
                return;
            }
        }
    }

    /// Makes or finds the vertices of a clipped polygon and their heights above the facet.
    fn place(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        facet: u32,
        polygon: &[(Corner, Support)],
    ) -> Vec<Placed> {
        polygon
            .iter()
            .map(|&(corner, support)| {
                let (id, height) = match corner {
                    Corner::Point(i) => {
                        let p = corners[usize::from(i)];
                        (p, self.height(facet, self.xy(p)))
                    }
                    Corner::Crossing(i, k) => {
                        let (p, q) = (corners[usize::from(i)], corners[(usize::from(i) + 1) % 3]);
                        let (id, fraction) = self.crossing(p.min(q), p.max(q), facet, k);
                        let [a, b] = self.surface.rail(facet, k);
                        (id, a + (b - a) * fraction)
                    }
                    Corner::Node(k) => {
                        let id = self.node(
                            triangle,
                            corners,
                            self.surface.layout.facets[facet as usize][usize::from(k)],
                        );
                        (id, self.surface.heights[facet as usize][usize::from(k)])
                    }
                };
                Placed {
                    id,
                    above: self.grain(id).z - height,
                    support,
                    corner,
                }
            })
            .collect()
    }

    /// Height of a facet's plane over `p`.
    fn height(&self, facet: u32, p: DVec2) -> f64 {
        let layout = &self.surface.layout;
        let [a, b, c] = layout.facets[facet as usize].map(|n| layout.nodes[n as usize]);
        let h = self.surface.heights[facet as usize];
        let w = [
            orientation(b, c, p),
            orientation(c, a, p),
            orientation(a, b, p),
        ];
        // Rounding must not lead past the corners, between which whole triangles are told from cut ones.
        let height = (w[0] * h[0] + w[1] * h[1] + w[2] * h[2]) / (w[0] + w[1] + w[2]);
        height
            .max(h[0].min(h[1]).min(h[2]))
            .min(h[0].max(h[1]).max(h[2]))
    }

    /// The vertex where the skin's edge p–q (p < q) crosses side `k` of `facet`, and its fraction of that side.
    fn crossing(&mut self, p: u32, q: u32, facet: u32, k: u8) -> (u32, f64) {
        let layout = &self.surface.layout;
        let edge = layout.sides[facet as usize][usize::from(k)];
        if let Some(&known) = self.crossings.get(&(p, q, edge)) {
            return known;
        }
        let [a, b] = layout.edges[edge as usize]
            .nodes
            .map(|n| layout.nodes[n as usize]);
        let (u, v) = (orientation(a, b, self.xy(p)), orientation(a, b, self.xy(q)));
        let t = (u / (u - v)).clamp(0.0, 1.0);
        let (u, v) = (
            orientation(self.xy(p), self.xy(q), a),
            orientation(self.xy(p), self.xy(q), b),
        );
        let fraction = if u == v {
            0.5
        } else {
            (u / (u - v)).clamp(0.0, 1.0)
        };
        let grain = self.points[p as usize].lerp(self.points[q as usize], t);
        let id = self.add(grain, Host::Edge { ends: [p, q], t });
        self.crossings.insert((p, q, edge), (id, fraction));
        (id, fraction)
    }

    /// The vertex where the line along the grain over `node` pierces a triangle.
    fn node(&mut self, triangle: u32, corners: [u32; 3], node: u32) -> u32 {
        if let Some(&id) = self.nodes.get(&(triangle, node)) {
            return id;
        }
        let n = self.surface.layout.nodes[node as usize];
        let [a, b, c] = corners.map(|p| self.xy(p));
        let mut w = [
            orientation(b, c, n),
            orientation(c, a, n),
            orientation(a, b, n),
        ];
        let sum = w[0] + w[1] + w[2];
        w = if sum == 0.0 {
            [1.0 / 3.0; 3]
        } else {
            w.map(|v| (v / sum).clamp(0.0, 1.0))
        };
        let s: f64 = (0..3)
            .map(|i| w[i] * self.points[corners[i] as usize].z)
            .sum();
        let id = self.add(
            n.extend(s),
            Host::Face {
                triangle,
                weights: w,
            },
        );
        self.nodes.insert((triangle, node), id);
        self.uprights.entry(node).or_default().push((s, id));
        id
    }

    /// Fraction along side `k`'s edge of a corner that lies on that side.
    fn fraction(&self, corners: [u32; 3], facet: u32, k: u8, corner: Corner) -> f64 {
        let layout = &self.surface.layout;
        let edge = layout.sides[facet as usize][usize::from(k)];
        match corner {
            Corner::Crossing(i, _) => {
                let (p, q) = (corners[usize::from(i)], corners[(usize::from(i) + 1) % 3]);
                self.crossings[&(p.min(q), p.max(q), edge)].1
            }
            Corner::Node(n) => {
                let node = layout.facets[facet as usize][usize::from(n)];
                f64::from(u8::from(layout.edges[edge as usize].nodes[1] == node))
            }
            Corner::Point(_) => 0.5,
        }
    }

    /// Divides a clipped polygon by the facet's plane into lower and upper pieces.
    fn divide(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        facet: u32,
        polygon: &[Placed],
        spans: &mut Vec<(u32, u32, u32)>,
    ) -> Result<(), CutError> {
        let surface = self.surface;
        let layout = &surface.layout;
        let count = polygon.len();
        // The polygon's boundary with the cut points put in: (vertex, in the upper part, support of the next edge).
        let mut ring: Vec<(u32, Option<bool>, Support)> = Vec::with_capacity(count + 4);
        for j in 0..count {
            let (a, b) = (polygon[j], polygon[(j + 1) % count]);
            ring.push((a.id, Some(a.above > 0.0), a.support));
            if (a.above > 0.0) != (b.above > 0.0) {
                ring.push((self.cut(triangle, corners, facet, a, b), None, a.support));
            }
        }
        let crossings: Vec<usize> = (0..ring.len()).filter(|&i| ring[i].1.is_none()).collect();
        let is_upper = |i: usize| {
            // A cut point belongs to the run that follows it.
            ring[i]
                .1
                .unwrap_or_else(|| ring[(i + 1) % ring.len()].1.unwrap_or(false))
        };
        for i in 0..ring.len() {
            let (from, _, support) = ring[i];
            let to = ring[(i + 1) % ring.len()].0;
            let (edge, side) = match support {
                Support::Skin(side) => (NONE, side),
                Support::Facet(k) => (layout.sides[facet as usize][usize::from(k)], 3),
            };
            self.pieces.push(Piece {
                from,
                to,
                upper: is_upper(i),
                edge,
                side,
            });
        }
        for a in polygon
            .iter()
            .enumerate()
            .map(|(j, a)| (a, &polygon[(j + 1) % count]))
        {
            if let Support::Facet(k) = a.0.support {
                let edge = layout.sides[facet as usize][usize::from(k)];
                spans.push((a.0.id.min(a.1.id), a.0.id.max(a.1.id), edge));
                if layout.edges[edge as usize]
                    .facets
                    .iter()
                    .any(|f| f.0 == NONE)
                {
                    return Err(CutError::OffLayout {
                        at: self.grain(a.0.id),
                    });
                }
            }
        }
        // Every run of upper corners starts at one cut point and ends at the next; the cut joins them.
        for (n, &i) in crossings.iter().enumerate() {
            if ring[(i + 1) % ring.len()].1 == Some(true) {
                let (entry, exit) = (ring[i].0, ring[crossings[(n + 1) % crossings.len()]].0);
                self.pieces.push(Piece {
                    from: exit,
                    to: entry,
                    upper: true,
                    edge: NONE,
                    side: 3,
                });
                self.pieces.push(Piece {
                    from: entry,
                    to: exit,
                    upper: false,
                    edge: NONE,
                    side: 3,
                });
                self.tops.push((facet, [exit, entry]));
            }
        }
        Ok(())
    }

    /// The vertex where the surface cuts the polygon's edge a–b.
    fn cut(&mut self, triangle: u32, corners: [u32; 3], facet: u32, a: Placed, b: Placed) -> u32 {
        let (p, q) = if a.id < b.id { (a, b) } else { (b, a) };
        let above = [p.above.to_bits(), q.above.to_bits()];
        let fraction = p.above / (p.above - q.above);
        let known = self
            .cuts
            .get(&(p.id, q.id))
            .and_then(|cuts| cuts.iter().find(|c| c.above == above));
        let id = if let Some(cut) = known {
            cut.id
        } else {
            let grain = self.grain(p.id).lerp(self.grain(q.id), fraction);
            let host = match a.support {
                Support::Skin(i) => {
                    let (x, y) = (corners[usize::from(i)], corners[(usize::from(i) + 1) % 3]);
                    let ends = [x.min(y), x.max(y)];
                    let along = |v: u32| match v {
                        _ if v == ends[0] => 0.0,
                        _ if v == ends[1] => 1.0,
                        _ => match self.vertices[v as usize - self.points.len()].host {
                            Host::Edge { t, .. } => t,
                            _ => 0.5,
                        },
                    };
                    let (u, v) = (along(p.id), along(q.id));
                    Host::Edge {
                        ends,
                        t: u + (v - u) * fraction,
                    }
                }
                Support::Facet(_) => {
                    let (u, v) = (self.weights(p.id, corners), self.weights(q.id, corners));
                    Host::Face {
                        triangle,
                        weights: [0, 1, 2].map(|i| u[i] + (v[i] - u[i]) * fraction),
                    }
                }
            };
            let id = self.add(grain, host);
            self.cuts.entry((p.id, q.id)).or_default().push(Cut {
                fraction,
                id,
                above,
            });
            id
        };
        if let Support::Facet(k) = a.support {
            let layout = &self.surface.layout;
            let edge = layout.sides[facet as usize][usize::from(k)];
            let which = u8::from(layout.edges[edge as usize].facets[1] == (facet, k));
            let (u, v) = (
                self.fraction(corners, facet, k, p.corner),
                self.fraction(corners, facet, k, q.corner),
            );
            self.rails
                .entry((edge, which))
                .or_default()
                .push((u + (v - u) * fraction, id));
        }
        id
    }

    /// Barycentric weights of a vertex in the triangle with the points `corners`.
    pub fn weights(&self, id: u32, corners: [u32; 3]) -> [f64; 3] {
        let unit = |p: u32| [0, 1, 2].map(|i| f64::from(u8::from(corners[i] == p)));
        let Some(i) = (id as usize).checked_sub(self.points.len()) else {
            return unit(id);
        };
        match self.vertices[i].host {
            Host::Point(p) => unit(p),
            Host::Edge { ends, t } => {
                let (u, v) = (unit(ends[0]), unit(ends[1]));
                [0, 1, 2].map(|i| u[i] * (1.0 - t) + v[i] * t)
            }
            Host::Face { weights, .. } => weights,
            Host::Inside => [f64::NAN; 3],
        }
    }
}
