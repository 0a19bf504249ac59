//! Joining the pieces of a triangle of the skin on either side of the surface.

use super::super::error::CutError;
use super::super::parts::SkinTriangle;
use super::super::polygon;
use super::outline::Overlay;
use crate::surface::NONE;
use glam::DVec2;

/// A directed edge of the lower or the upper part of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub from: u32,
    pub to: u32,
    pub upper: bool,
    /// The edge of the layout it lies on, or [`NONE`].
    pub edge: u32,
    /// Side of the skin's triangle it lies on, or 3.
    pub side: u8,
}

/// Memory that is reused from triangle to triangle.
#[derive(Debug, Default)]
pub(super) struct JoinMemory {
    /// Cuts on edges along the layout's: edge, the edge's ends, fraction between them, vertex.
    inner: Vec<Inner>,
    between: Vec<(f64, u32)>,
    expanded: Vec<Piece>,
    twins: Vec<(u32, u32, bool)>,
    /// Pieces along a side of the triangle.
    along: Vec<u32>,
    edges: Vec<[u32; 2]>,
    ring: Vec<u32>,
    flat: Vec<DVec2>,
    filled: Vec<[u32; 3]>,
}

#[derive(Debug, Clone, Copy)]
struct Inner {
    edge: u32,
    ends: (u32, u32),
    fraction: f64,
    id: u32,
}

/// Follows directed edges, sorted, around the one loop that all of them make; `false` where they do otherwise.
fn one_loop(edges: &[[u32; 2]], ring: &mut Vec<u32>) -> bool {
    ring.clear();
    if edges.len() < 3 || edges.windows(2).any(|w| w[0][0] == w[1][0]) {
        return false;
    }
    let start = edges[0][0];
    let mut at = edges[0];
    ring.push(start);
    while at[1] != start {
        let Ok(next) = edges.binary_search_by_key(&at[1], |e| e[0]) else {
            return false;
        };
        if ring.len() >= edges.len() {
            return false;
        }
        ring.push(at[1]);
        at = edges[next];
    }
    ring.len() == edges.len()
}

impl Overlay<'_> {
    /// Puts into every edge along a layout's edge the cut points of both its facets.
    pub(super) fn expand(
        &self,
        spans: &[(u32, u32, u32)],
        pieces: &mut Vec<Piece>,
        memory: &mut JoinMemory,
    ) {
        let inner = &mut memory.inner;
        inner.clear();
        for &(a, b, edge) in spans {
            let mut next = self.first_cuts.get(&(a, b)).copied().unwrap_or(NONE);
            while let Some(cut) = self.cuts.get(next as usize) {
                if !inner.iter().any(|l| l.edge == edge && l.id == cut.id) {
                    inner.push(Inner {
                        edge,
                        ends: (a, b),
                        fraction: cut.fraction,
                        id: cut.id,
                    });
                }
                next = cut.next;
            }
        }
        inner.sort_by_key(|l| l.edge);
        if inner.is_empty() {
            return;
        }
        memory.expanded.clear();
        for &piece in pieces.iter() {
            let list = if piece.edge == NONE {
                &inner[..0]
            } else {
                let from = inner.partition_point(|l| l.edge < piece.edge);
                let count = inner[from..].partition_point(|l| l.edge == piece.edge);
                &inner[from..from + count]
            };
            let place = |id: u32| {
                list.iter().find_map(|l| match id {
                    _ if id == l.ends.0 => Some(0.0),
                    _ if id == l.ends.1 => Some(1.0),
                    _ if id == l.id => Some(l.fraction),
                    _ => None,
                })
            };
            let (Some(u), Some(v)) = (place(piece.from), place(piece.to)) else {
                memory.expanded.push(piece);
                continue;
            };
            let between = &mut memory.between;
            between.clear();
            between.extend(
                list.iter()
                    .filter(|l| {
                        (l.fraction > u.min(v) && l.fraction < u.max(v))
                            && l.id != piece.from
                            && l.id != piece.to
                    })
                    .map(|l| (l.fraction, l.id)),
            );
            between.sort_by(|x, y| x.0.total_cmp(&y.0));
            if u > v {
                between.reverse();
            }
            let mut from = piece.from;
            for &(_, id) in between.iter() {
                memory.expanded.push(Piece {
                    from,
                    to: id,
                    ..piece
                });
                from = id;
            }
            memory.expanded.push(Piece { from, ..piece });
        }
        std::mem::swap(pieces, &mut memory.expanded);
    }

    /// Joins the pieces of a triangle on either side of the surface and triangulates them.
    pub(super) fn join(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        pieces: &mut Vec<Piece>,
        memory: &mut JoinMemory,
    ) -> Result<(), CutError> {
        // Edges along the layout's, by their ends; of several the last counts.
        let twins = &mut memory.twins;
        twins.clear();
        twins.extend(
            pieces
                .iter()
                .filter(|p| p.edge != NONE)
                .map(|p| (p.from, p.to, p.upper)),
        );
        twins.sort_by_key(|t| (t.0, t.1));
        let twin = |from: u32, to: u32| {
            let end = twins.partition_point(|t| (t.0, t.1) <= (from, to));
            let last = twins[..end].last();
            last.filter(|t| (t.0, t.1) == (from, to)).map(|t| t.2)
        };
        let walls = &mut self.walls;
        pieces.retain(|p| {
            if p.edge == NONE {
                return true;
            }
            let other = twin(p.to, p.from);
            if p.upper && other == Some(false) {
                walls.push((p.edge, [p.from, p.to]));
            }
            other != Some(p.upper)
        });
        drop_needless(pieces, corners, &mut memory.along);
        for upper in [false, true] {
            memory.edges.clear();
            memory.edges.extend(
                pieces
                    .iter()
                    .filter(|p| p.upper == upper)
                    .map(|p| [p.from, p.to]),
            );
            self.fill(triangle, corners, upper, memory)?;
        }
        Ok(())
    }

    /// Fills the loop in `memory`, a part of the triangle on one side of the surface. Returns `false` where it runs the
    /// wrong way or meets itself, by rounding.
    pub(super) fn fill_ring(
        &mut self,
        (triangle, corners): (u32, [u32; 3]),
        upper: bool,
        memory: &mut JoinMemory,
    ) -> bool {
        let JoinMemory {
            ring, flat, filled, ..
        } = memory;
        let add = |skin: &mut Vec<SkinTriangle>, corners: [u32; 3]| {
            skin.push(SkinTriangle {
                source: triangle,
                corners,
                upper,
            });
        };
        if let [a, b, c] = **ring {
            add(&mut self.skin, [a, b, c]);
            return true;
        }
        flat.clear();
        flat.extend(ring.iter().map(|&id| self.flat(id, corners)));
        filled.clear();
        if polygon::twice_area(flat) < 0.0 || self.triangulator.polygon(flat, filled).is_err() {
            return false;
        }
        for t in filled {
            add(&mut self.skin, t.map(|i| ring[i as usize]));
        }
        true
    }

    /// Position of a vertex in the triangle's own plane: the weights of the second and the third corner.
    fn flat(&self, id: u32, corners: [u32; 3]) -> DVec2 {
        let w = self.weights(id, corners);
        DVec2::new(w[1], w[2])
    }

    /// Fills what the edges in `memory` enclose.
    fn fill(
        &mut self,
        triangle: u32,
        corners: [u32; 3],
        upper: bool,
        memory: &mut JoinMemory,
    ) -> Result<(), CutError> {
        memory.edges.sort_unstable();
        if one_loop(&memory.edges, &mut memory.ring)
            && self.fill_ring((triangle, corners), upper, memory)
        {
            return Ok(());
        }
        let JoinMemory { edges, filled, .. } = memory;
        filled.clear();
        let mut triangulator = std::mem::take(&mut self.triangulator);
        let flat = |id: u32| self.flat(id, corners);
        let done = polygon::trace(edges, flat)
            .and_then(|loops| polygon::fill(&mut triangulator, &loops, flat, filled).ok())
            .is_some();
        self.triangulator = triangulator;
        if !done {
            return Err(CutError::Outline {
                triangle,
                at: self.grain(edges.first().map_or(corners[0], |e| e[0])),
            });
        }
        self.skin.extend(filled.iter().map(|&corners| SkinTriangle {
            source: triangle,
            corners,
            upper,
        }));
        Ok(())
    }
}

impl JoinMemory {
    /// The corners of a loop, none yet.
    pub(super) fn ring(&mut self) -> &mut Vec<u32> {
        self.ring.clear();
        &mut self.ring
    }
}

/// Takes out vertices on the triangle's sides where the outline does not pass.
fn drop_needless(pieces: &mut Vec<Piece>, corners: [u32; 3], along: &mut Vec<u32>) {
    const GONE: u8 = 4;
    let mut dropped = false;
    for side in 0..3u8 {
        along.clear();
        let numbers = 0..pieces.len() as u32;
        along.extend(numbers.filter(|&i| pieces[i as usize].side == side));
        for &i in along.iter() {
            let i = i as usize;
            while pieces[i].side == side && !corners.contains(&pieces[i].to) {
                let (to, upper) = (pieces[i].to, pieces[i].upper);
                let follows = |n: &Piece| n.side == side && n.from == to && n.upper == upper;
                let next = along.iter().map(|&j| j as usize);
                let Some(j) = next.into_iter().find(|&j| j != i && follows(&pieces[j])) else {
                    break;
                };
                pieces[i].to = pieces[j].to;
                pieces[j].side = GONE;
                dropped = true;
            }
        }
    }
    if dropped {
        pieces.retain(|p| p.side != GONE);
    }
}
