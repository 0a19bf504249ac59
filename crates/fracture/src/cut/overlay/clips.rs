//! What of an overlay of the skin and a layout does not depend on heights: which part of a triangle lies over which
//! facet. It is computed once for each triangle near a break and cached for the next break.

use super::super::facet_grid::FacetGrid;
use super::super::parts::{Host, Solid};
use super::super::skin::Skin;
use crate::surface::{NONE, SectionLayout};
use glam::{DVec2, DVec3};
use greenstick_geometry::intersect::orient2d as orientation;
use rustc_hash::FxHashMap;

/// What an edge of a clipped polygon lies on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Support {
    /// Side i of the skin's triangle.
    Skin(u8),
    /// Side k of the facet.
    Facet(u8),
}

/// What a corner of a clipped polygon is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Corner {
    /// Corner i of the skin's triangle.
    Point(u8),
    /// Side i of the triangle across side k of the facet.
    Crossing(u8, u8),
    /// Corner k of the facet.
    Node(u8),
}

/// A corner of the part of a triangle over a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub corner: Corner,
    /// What the edge to the next corner lies on.
    pub support: Support,
    /// Number of the vertex in [`Clips::vertices`], for a point of the skin in [`Clips::weights`].
    pub vertex: u32,
    /// Number in [`Clips::parts`] of the part of the same triangle beyond the edge to the next corner, or [`NONE`].
    pub beyond: u32,
    /// Length along the stem, m.
    pub length: f64,
    /// The facet's corners between which it lies on the facet's border, in the order of their nodes, twice the same where it
    /// is one of them, and the fraction from the first to the second. Of no use for a point of the skin.
    pub ends: [u8; 2],
    pub fraction: f64,
}

/// The part of a triangle over a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub facet: u32,
    /// Its corners in [`Clips::slots`], from and to.
    pub slots: (u32, u32),
}

/// A place on the skin over an edge or a node of the layout.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fixed {
    pub grain: DVec3,
    pub host: Host,
    /// Fraction along the edge of the layout.
    pub fraction: f64,
    /// The node of the layout, or [`NONE`] for a place over an edge.
    pub node: u32,
}

/// Parts of the triangles met so far. Only of use with the solid, skin and grid that it was made with.
#[derive(Debug, Default)]
pub(in super::super) struct Clips {
    /// By rank of the triangle: 1 + its number in `lists`, or 0.
    known: Vec<u32>,
    /// From and to in `parts`.
    lists: Vec<(u32, u32)>,
    pub(super) parts: Vec<Part>,
    pub(super) slots: Vec<Slot>,
    pub(super) vertices: Vec<Fixed>,
    /// Weights of a facet's corners at a point of the skin, and their sum.
    pub(super) weights: Vec<[f64; 4]>,
    crossings: FxHashMap<(u32, u32, u32), u32>,
    nodes: FxHashMap<(u32, u32), u32>,
    /// For each facet the last triangle that looked for its facets.
    marks: Vec<u32>,
    turn: u32,
    found: Vec<u32>,
    polygon: Vec<(Corner, Support)>,
    before: Vec<(Corner, Support)>,
    /// How many vertices the last break made on the skin.
    pub made: usize,
}

/// Number of cached slots above which the cache is emptied before the next break: about 100 MB.
const MAX_CACHED_SLOTS: usize = 1 << 22;

impl Clips {
    /// Makes ready for a break on a skin of `ranks` triangles over `facets` facets, the `same` as before or others.
    pub fn begin(&mut self, same: bool, (ranks, facets): (usize, usize)) {
        if !same || self.slots.len() > MAX_CACHED_SLOTS {
            *self = Clips {
                known: vec![0; ranks],
                marks: vec![0; facets],
                ..Clips::default()
            };
        }
    }

    /// The facets of some parts.
    pub fn facets(&self, parts: (u32, u32)) -> impl Iterator<Item = u32> {
        let parts = &self.parts[parts.0 as usize..parts.1 as usize];
        parts.iter().map(|p| p.facet)
    }

    /// The parts of the limb triangle of a rank over all facets, from and to in `parts`.
    pub fn of(&mut self, rank: usize, skin: &Skin, grid: &FacetGrid, solid: &Solid) -> (u32, u32) {
        if let Some(i) = self.known[rank].checked_sub(1) {
            return self.lists[i as usize];
        }
        let triangle = skin.order[rank];
        let points = solid.triangles[triangle as usize];
        let flat = points.map(|p| solid.points[p as usize].truncate());
        let mut found = std::mem::take(&mut self.found);
        self.turn += 1;
        grid.candidates(rank, skin, flat, (&mut self.marks, self.turn), &mut found);
        let from = self.parts.len() as u32;
        let over = Over {
            layout: &grid.layout,
            points,
            flat,
        };
        for &facet in &found {
            over.clip(facet, &mut self.polygon, &mut self.before);
            if self.polygon.len() < 3 {
                continue;
            }
            let first = self.slots.len() as u32;
            for i in 0..self.polygon.len() {
                let (corner, support) = self.polygon[i];
                let (vertex, ends) = match corner {
                    Corner::Point(i) => {
                        self.weights.push(over.weights(facet, i));
                        (self.weights.len() as u32 - 1, [0; 2])
                    }
                    Corner::Crossing(i, k) => (
                        self.crossing(solid, &over, facet, (i, k)),
                        over.side_ends(facet, k),
                    ),
                    Corner::Node(k) => (self.node(solid, &over, triangle, facet, k), [k; 2]),
                };
                let (length, fraction) = match corner {
                    Corner::Point(i) => (solid.points[points[usize::from(i)] as usize].z, 0.0),
                    _ => {
                        let fixed = &self.vertices[vertex as usize];
                        (fixed.grain.z, fixed.fraction)
                    }
                };
                self.slots.push(Slot {
                    corner,
                    support,
                    vertex,
                    beyond: NONE,
                    length,
                    ends,
                    fraction,
                });
            }
            self.parts.push(Part {
                facet,
                slots: (first, self.slots.len() as u32),
            });
        }
        self.found = found;
        self.join(from as usize, &grid.layout);
        let list = (from, self.parts.len() as u32);
        self.lists.push(list);
        self.known[rank] = self.lists.len() as u32;
        list
    }

    /// Finds what lies beyond the edges of the parts from number `from` on, which are one triangle's.
    fn join(&mut self, from: usize, layout: &SectionLayout) {
        let parts = &self.parts[from..];
        for part in parts {
            for slot in &mut self.slots[part.slots.0 as usize..part.slots.1 as usize] {
                let Support::Facet(k) = slot.support else {
                    continue;
                };
                let edge =
                    &layout.edges[layout.sides[part.facet as usize][usize::from(k)] as usize];
                let other = edge.facets[usize::from(edge.facets[0].0 == part.facet)].0;
                if let Ok(i) = parts.binary_search_by_key(&other, |p| p.facet) {
                    slot.beyond = (from + i) as u32;
                }
            }
        }
    }

    /// Where side `i` of the triangle crosses side `k` of `facet`.
    fn crossing(&mut self, solid: &Solid, over: &Over, facet: u32, (i, k): (u8, u8)) -> u32 {
        let i = usize::from(i);
        let ends = [over.points[i], over.points[(i + 1) % 3]];
        let [p, q] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let layout = over.layout;
        let edge = layout.sides[facet as usize][usize::from(k)];
        if let Some(&known) = self.crossings.get(&(p, q, edge)) {
            return known;
        }
        let xy = |p: u32| solid.points[p as usize].truncate();
        let [a, b] = layout.edges[edge as usize]
            .nodes
            .map(|n| layout.nodes[n as usize]);
        let (u, v) = (orientation(a, b, xy(p)), orientation(a, b, xy(q)));
        let t = (u / (u - v)).clamp(0.0, 1.0);
        let (u, v) = (orientation(xy(p), xy(q), a), orientation(xy(p), xy(q), b));
        let fraction = if u == v {
            0.5
        } else {
            (u / (u - v)).clamp(0.0, 1.0)
        };
        self.vertices.push(Fixed {
            grain: solid.points[p as usize].lerp(solid.points[q as usize], t),
            host: Host::Edge { ends: [p, q], t },
            fraction,
            node: NONE,
        });
        let number = self.vertices.len() as u32 - 1;
        self.crossings.insert((p, q, edge), number);
        number
    }

    /// Where the line along the grain over corner `k` of `facet` pierces the triangle.
    fn node(&mut self, solid: &Solid, over: &Over, triangle: u32, facet: u32, k: u8) -> u32 {
        let node = over.layout.facets[facet as usize][usize::from(k)];
        if let Some(&known) = self.nodes.get(&(triangle, node)) {
            return known;
        }
        let n = over.layout.nodes[node as usize];
        let [a, b, c] = over.flat;
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
            .map(|i| w[i] * solid.points[over.points[i] as usize].z)
            .sum();
        self.vertices.push(Fixed {
            grain: n.extend(s),
            host: Host::Face {
                triangle,
                weights: w,
            },
            fraction: 0.0,
            node,
        });
        let number = self.vertices.len() as u32 - 1;
        self.nodes.insert((triangle, node), number);
        number
    }
}

/// A triangle over a layout.
struct Over<'a> {
    layout: &'a SectionLayout,
    points: [u32; 3],
    flat: [DVec2; 3],
}

impl Over<'_> {
    /// Weights of a facet's corners at corner `i`, and their sum.
    fn weights(&self, facet: u32, i: u8) -> [f64; 4] {
        let [a, b, c] = self.layout.facets[facet as usize].map(|n| self.layout.nodes[n as usize]);
        let p = self.flat[usize::from(i)];
        let (u, v, w) = (
            orientation(b, c, p),
            orientation(c, a, p),
            orientation(a, b, p),
        );
        [u, v, w, u + v + w]
    }

    /// The corners at the ends of side `k` of `facet`, in the order of their nodes.
    fn side_ends(&self, facet: u32, k: u8) -> [u8; 2] {
        let nodes = self.layout.facets[facet as usize];
        let next = (k + 1) % 3;
        if nodes[usize::from(k)] < nodes[usize::from(next)] {
            [k, next]
        } else {
            [next, k]
        }
    }

    /// For each corner whether it lies left of side `k` of `facet`. Ties go the same way for both facets of an edge.
    fn inside(&self, facet: u32, k: u8) -> [bool; 3] {
        let layout = self.layout;
        let edge = &layout.edges[layout.sides[facet as usize][usize::from(k)] as usize];
        let [a, b] = edge.nodes.map(|n| layout.nodes[n as usize]);
        let turned = edge.facets[0] == (facet, k);
        self.flat.map(|p| (orientation(a, b, p) >= 0.0) == turned)
    }

    /// Whether `node` lies left of side `i`. Ties go the same way for both triangles of an edge.
    fn left(&self, i: u8, node: u32) -> bool {
        let (i, j) = (usize::from(i), (usize::from(i) + 1) % 3);
        let n = self.layout.nodes[node as usize];
        let forward = self.points[i] < self.points[j];
        let (a, b) = if forward { (i, j) } else { (j, i) };
        (orientation(self.flat[a], self.flat[b], n) >= 0.0) == forward
    }

    /// The part over a facet (Sutherland and Hodgman 1974), each corner named by what it is.
    fn clip(
        &self,
        facet: u32,
        out: &mut Vec<(Corner, Support)>,
        before: &mut Vec<(Corner, Support)>,
    ) {
        out.clear();
        let mut inside = [[false; 3]; 3];
        for k in 0..3u8 {
            let line = self.inside(facet, k);
            if line == [false; 3] {
                return;
            }
            inside[usize::from(k)] = line;
        }
        let nodes = self.layout.facets[facet as usize];
        out.extend((0..3).map(|i| (Corner::Point(i), Support::Skin(i))));
        for k in 0..3u8 {
            if inside[usize::from(k)].iter().all(|&i| i) {
                continue;
            }
            std::mem::swap(before, out);
            out.clear();
            let keeps = |corner: Corner| match corner {
                Corner::Point(i) => inside[usize::from(k)][usize::from(i)],
                Corner::Node(_) => true,
                Corner::Crossing(i, line) => {
                    // Along the other line, the crossing lies before or after the node it shares with line k.
                    let next = (line + 1) % 3 == k;
                    let shared = nodes[usize::from(if next { k } else { line })];
                    let before = self.left(i, shared) == inside[usize::from(line)][usize::from(i)];
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
}
