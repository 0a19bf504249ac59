//! Joining the pieces of a triangle of the skin on either side of the surface.

use super::super::{CutError, polygon};
use super::{Overlay, Piece};
use crate::surface::NONE;
use glam::DVec2;
use rustc_hash::FxHashMap;

impl Overlay<'_> {
    /// Puts into every edge along a layout's edge the cut points of both its facets.
    pub(super) fn expand(&mut self, spans: &[(u32, u32, u32)]) {
        let mut inner: FxHashMap<u32, Vec<(u32, f64, u32, u32)>> = FxHashMap::default();
        for &(a, b, edge) in spans {
            let Some(cuts) = self.cuts.get(&(a, b)) else {
                continue;
            };
            let list = inner.entry(edge).or_default();
            for cut in cuts {
                if !list.iter().any(|l| l.2 == cut.id) {
                    list.push((a, cut.fraction, cut.id, b));
                }
            }
        }
        let pieces = std::mem::take(&mut self.pieces);
        for piece in pieces {
            let list = if piece.edge == NONE {
                None
            } else {
                inner.get(&piece.edge)
            };
            let Some(list) = list.filter(|l| !l.is_empty()) else {
                self.pieces.push(piece);
                continue;
            };
            let place = |id: u32| {
                list.iter().find_map(|l| match id {
                    _ if id == l.0 => Some(0.0),
                    _ if id == l.3 => Some(1.0),
                    _ if id == l.2 => Some(l.1),
                    _ => None,
                })
            };
            let (Some(u), Some(v)) = (place(piece.from), place(piece.to)) else {
                self.pieces.push(piece);
                continue;
            };
            let mut between: Vec<(f64, u32)> = list
                .iter()
                .filter(|l| {
                    (l.1 > u.min(v) && l.1 < u.max(v)) && l.2 != piece.from && l.2 != piece.to
                })
                .map(|l| (l.1, l.2))
                .collect();
            between.sort_by(|x, y| x.0.total_cmp(&y.0));
            if u > v {
                between.reverse();
            }
            let mut from = piece.from;
            for (_, id) in between {
                self.pieces.push(Piece {
                    from,
                    to: id,
                    ..piece
                });
                from = id;
            }
            self.pieces.push(Piece { from, ..piece });
        }
    }

    /// Joins the pieces of a triangle on either side of the surface and triangulates them.
    pub(super) fn join(&mut self, triangle: u32, corners: [u32; 3]) -> Result<(), CutError> {
        let mut pieces = std::mem::take(&mut self.pieces);
        // Edges along the layout's, by their ends; of several the last counts.
        let mut twins: Vec<(u32, u32, bool)> = pieces
            .iter()
            .filter(|p| p.edge != NONE)
            .map(|p| (p.from, p.to, p.upper))
            .collect();
        twins.sort_by_key(|t| (t.0, t.1));
        let twin = |from: u32, to: u32| {
            let end = twins.partition_point(|t| (t.0, t.1) <= (from, to));
            let last = twins[..end].last();
            last.filter(|t| (t.0, t.1) == (from, to)).map(|t| t.2)
        };
        for p in &pieces {
            if p.edge != NONE && p.upper && twin(p.to, p.from) == Some(false) {
                self.walls.push((p.edge, [p.from, p.to]));
            }
        }
        pieces.retain(|p| p.edge == NONE || twin(p.to, p.from) != Some(p.upper));
        self.drop_needless(&mut pieces, corners);
        let mut triangulator = std::mem::take(&mut self.triangulator);
        for upper in [false, true] {
            let edges: Vec<[u32; 2]> = pieces
                .iter()
                .filter(|p| p.upper == upper)
                .map(|p| [p.from, p.to])
                .collect();
            // Weights of the second and third corner are coordinates in the triangle's own plane.
            let flat = |id: u32| {
                let w = self.weights(id, corners);
                DVec2::new(w[1], w[2])
            };
            let mut triangles = Vec::new();
            polygon::trace(&edges, flat)
                .and_then(|loops| {
                    polygon::fill(&mut triangulator, &loops, flat, &mut triangles).ok()
                })
                .ok_or_else(|| CutError::Outline {
                    triangle,
                    at: self.grain(edges.first().map_or(corners[0], |e| e[0])),
                })?;
            self.skin
                .extend(triangles.into_iter().map(|t| (triangle, t, upper)));
        }
        self.triangulator = triangulator;
        self.pieces = pieces;
        Ok(())
    }

    /// Takes out vertices on the triangle's sides where the outline does not pass.
    fn drop_needless(&self, pieces: &mut Vec<Piece>, corners: [u32; 3]) {
        for side in 0..3u8 {
            loop {
                let found = pieces.iter().enumerate().find_map(|(i, p)| {
                    if p.side != side || corners.contains(&p.to) {
                        return None;
                    }
                    pieces
                        .iter()
                        .position(|n| n.side == side && n.from == p.to && n.upper == p.upper)
                        .map(|j| (i, j))
                });
                let Some((i, j)) = found else { break };
                pieces[i].to = pieces[j].to;
                pieces.swap_remove(j);
            }
        }
    }
}
