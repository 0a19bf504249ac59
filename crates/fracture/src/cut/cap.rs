//! The broken faces: the part of the surface inside the stem, bounded by the outline on its skin.
//!
//! Tops of facets and walls between them are plane polygons. Where the outline crosses one, its boundary is followed
//! alternately along the outline and along its own border (Weiler and Atherton 1977). Vertices on a border are made
//! once and taken by every face that meets there, so the faces close without gaps.

use super::overlay::Overlay;
use super::polygon;
use super::{CapFace, CutError, Host};
use crate::surface::{Edge, Layout, NONE, Surface};
use glam::DVec2;
use rustc_hash::FxHashMap;

/// The triangles of the broken face, oriented for the lower piece.
#[derive(Default)]
pub(super) struct Cap {
    pub triangles: Vec<[u32; 3]>,
    pub faces: Vec<CapFace>,
}

/// Directed edges of one face, by their start.
type Chains = FxHashMap<u32, u32>;

pub(super) struct Builder<'a, 'b> {
    surface: &'a Surface,
    overlay: &'b mut Overlay<'a>,
    /// Vertex at each corner of each facet.
    corners: Vec<[u32; 3]>,
    /// For each node where its list in `heights` starts.
    starts: Vec<u32>,
    /// Distinct heights of the facets about each node, ascending, with their vertices.
    heights: Vec<(f64, u32)>,
    /// Outline on each facet that has one.
    tops: FxHashMap<u32, Chains>,
    walls: FxHashMap<u32, Chains>,
    /// Where the two rims of a wall cross: edge → (fraction, vertex).
    knots: FxHashMap<u32, (f64, u32)>,
    /// For each corner of each facet whether it lies inside the stem: 0 unknown, 1 outside, 2 inside.
    status: Vec<[u8; 3]>,
    cap: Cap,
}

const OUTSIDE: u8 = 1;
const INSIDE: u8 = 2;

/// Builds the broken face from the outline found by `overlay`.
/// Walls are parted at every `level` m along the grain (infinite for none).
pub(super) fn build<'a>(
    surface: &'a Surface,
    overlay: &mut Overlay<'a>,
    level: f64,
) -> Result<Cap, CutError> {
    let (tops, walls) = (
        std::mem::take(&mut overlay.tops),
        std::mem::take(&mut overlay.walls),
    );
    let mut builder = Builder {
        surface,
        overlay,
        corners: Vec::new(),
        starts: Vec::new(),
        heights: Vec::new(),
        tops: FxHashMap::default(),
        walls: FxHashMap::default(),
        knots: FxHashMap::default(),
        status: vec![[0; 3]; surface.layout.facets.len()],
        cap: Cap::default(),
    };
    for (facet, [from, to]) in tops {
        builder.tops.entry(facet).or_default().insert(from, to);
    }
    for (edge, [from, to]) in walls {
        builder.walls.entry(edge).or_default().insert(from, to);
    }
    for list in builder.overlay.rails.values_mut() {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        list.dedup();
    }
    for list in builder.overlay.uprights.values_mut() {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    builder.place_corners(level);
    builder.place_knots();
    builder.fill_touched_tops()?;
    builder.spread_status()?;
    builder.fill_whole_tops()?;
    builder.fill_walls()?;
    Ok(builder.cap)
}

impl Builder<'_, '_> {
    fn layout(&self) -> &Layout {
        &self.surface.layout
    }

    /// Makes one vertex for every distinct height at every node, and for every level between them.
    fn place_corners(&mut self, level: f64) {
        let layout = self.surface.layout.clone();
        let mut starts = vec![0u32; layout.nodes.len() + 1];
        for facet in &layout.facets {
            facet.iter().for_each(|&n| starts[n as usize + 1] += 1);
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut around = vec![(0u32, 0u8); layout.facets.len() * 3];
        let mut next = starts.clone();
        for (f, facet) in layout.facets.iter().enumerate() {
            for (k, &n) in facet.iter().enumerate() {
                around[next[n as usize] as usize] = (f as u32, k as u8);
                next[n as usize] += 1;
            }
        }
        self.corners = vec![[0; 3]; layout.facets.len()];
        self.starts = Vec::with_capacity(layout.nodes.len() + 1);
        for n in 0..layout.nodes.len() {
            let first = self.heights.len();
            self.starts.push(first as u32);
            let list = &around[starts[n] as usize..starts[n + 1] as usize];
            for &(f, k) in list {
                let h = self.surface.heights[f as usize][usize::from(k)];
                let id = match self.heights[first..]
                    .iter()
                    .find(|(height, _)| *height == h)
                {
                    Some(&(_, id)) => id,
                    None => {
                        let id = self.overlay.add(layout.nodes[n].extend(h), Host::Inside);
                        self.heights.push((h, id));
                        id
                    }
                };
                self.corners[f as usize][usize::from(k)] = id;
            }
            self.heights[first..].sort_by(|a, b| a.0.total_cmp(&b.0));
            let (Some(&(low, _)), Some(&(high, _))) =
                (self.heights.get(first), self.heights.last())
            else {
                continue;
            };
            if high - low > level {
                for i in (low / level).ceil() as i64..=(high / level).floor() as i64 {
                    let h = i as f64 * level;
                    // A level next to a corner would only make slivers.
                    if self.heights[first..]
                        .iter()
                        .all(|p| (p.0 - h).abs() > 0.2 * level)
                    {
                        let id = self.overlay.add(layout.nodes[n].extend(h), Host::Inside);
                        self.heights.push((h, id));
                    }
                }
                self.heights[first..].sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        self.starts.push(self.heights.len() as u32);
    }

    /// Makes a vertex where the two rims of a wall cross.
    fn place_knots(&mut self) {
        let layout = self.surface.layout.clone();
        for (e, edge) in layout.edges.iter().enumerate() {
            let Some([a, b]) = self.rims(edge) else {
                continue;
            };
            let (u, v) = (a[0] - b[0], a[1] - b[1]);
            if u * v < 0.0 {
                let t = u / (u - v);
                let [p, q] = edge.nodes.map(|n| layout.nodes[n as usize]);
                let id = self
                    .overlay
                    .add(p.lerp(q, t).extend(a[0] + (a[1] - a[0]) * t), Host::Inside);
                self.knots.insert(e as u32, (t, id));
            }
        }
    }

    /// Heights of both facets of an inner edge along it, in the order of its nodes.
    fn rims(&self, edge: &Edge) -> Option<[[f64; 2]; 2]> {
        let [(f, i), (g, j)] = edge.facets;
        (f != NONE && g != NONE).then(|| [self.surface.rail(f, i), self.surface.rail(g, j)])
    }

    /// Vertices on side `k` of a facet between its corners, in its own direction, with their fraction along the edge.
    fn side(&self, facet: u32, k: u8) -> Vec<(f64, u32)> {
        let layout = self.layout();
        let e = layout.sides[facet as usize][usize::from(k)];
        let edge = &layout.edges[e as usize];
        let which = u8::from(edge.facets[1] == (facet, k));
        let mut list: Vec<(f64, u32)> = self
            .overlay
            .rails
            .get(&(e, which))
            .cloned()
            .unwrap_or_default();
        if let Some(&knot) = self.knots.get(&e) {
            list.insert(list.partition_point(|p| p.0 < knot.0), knot);
        }
        if which == 1 {
            list.reverse();
        }
        list
    }

    /// The border of a facet, counter-clockwise: corners and what lies between; true marks a corner.
    fn border(&self, facet: u32) -> Vec<(u32, Option<u8>)> {
        let mut border = Vec::with_capacity(6);
        for k in 0..3u8 {
            border.push((self.corners[facet as usize][usize::from(k)], Some(k)));
            border.extend(self.side(facet, k).into_iter().map(|(_, id)| (id, None)));
        }
        border
    }

    fn fill_touched_tops(&mut self) -> Result<(), CutError> {
        let mut facets: Vec<u32> = self.tops.keys().copied().collect();
        facets.sort_unstable();
        for facet in facets {
            let chains = self.tops.remove(&facet).unwrap_or_default();
            let border = self.border(facet);
            let ids: Vec<u32> = border.iter().map(|b| b.0).collect();
            let traced = follow(&chains, &ids);
            let traced = traced.ok_or_else(|| self.gap(&chains))?;
            if traced.met {
                for (id, k) in &border {
                    if let Some(k) = k {
                        let inside = traced.border.contains(id);
                        self.status[facet as usize][usize::from(*k)] =
                            if inside { INSIDE } else { OUTSIDE };
                    }
                }
                self.fill_top(facet, &traced.loops)?;
            } else {
                // Closed loops within the facet: kept until the status of its border is known.
                self.tops.insert(facet, chains);
            }
        }
        Ok(())
    }

    fn fill_top(&mut self, facet: u32, loops: &[Vec<u32>]) -> Result<(), CutError> {
        let face = CapFace {
            cell: self.layout().cells[facet as usize],
            top: true,
        };
        let mut triangles = Vec::new();
        polygon::fill(
            loops,
            |id| self.overlay.grain(id).truncate(),
            &mut triangles,
        )
        .map_err(|_| CutError::Face {
            at: self.overlay.grain(loops[0][0]),
        })?;
        self.push(triangles, face);
        Ok(())
    }

    fn push(&mut self, triangles: Vec<[u32; 3]>, face: CapFace) {
        self.cap.faces.extend(triangles.iter().map(|_| face));
        self.cap.triangles.extend(triangles);
    }

    fn gap(&self, chains: &Chains) -> CutError {
        let id = chains.keys().copied().min().unwrap_or(0);
        CutError::Face {
            at: self.overlay.grain(id),
        }
    }

    /// How many times the line along the grain over `node` pierces the skin between two heights.
    fn pierced(&self, node: u32, a: f64, b: f64) -> usize {
        let (low, high) = (a.min(b), a.max(b));
        self.overlay
            .uprights
            .get(&node)
            .map_or(0, |l| l.iter().filter(|p| p.0 > low && p.0 < high).count())
    }

    /// Carries inside and outside from facets that the outline crosses to all others.
    fn spread_status(&mut self) -> Result<(), CutError> {
        let layout = self.surface.layout.clone();
        let mut queue: Vec<u32> = (0..layout.facets.len() as u32)
            .filter(|&f| self.status[f as usize][0] != 0)
            .collect();
        while let Some(f) = queue.pop() {
            for k in 0..3usize {
                let edge = &layout.edges[layout.sides[f as usize][k] as usize];
                let other = edge.facets[usize::from(edge.facets[0].0 == f)];
                let (g, side) = (other.0, usize::from(other.1));
                if g == NONE || self.status[g as usize][0] != 0 {
                    continue;
                }
                // Corner k of f is the end of g's side.
                let node = layout.facets[f as usize][k];
                let (a, b) = (
                    self.surface.heights[f as usize][k],
                    self.surface.heights[g as usize][(side + 1) % 3],
                );
                let flip = self.pierced(node, a, b) % 2 == 1;
                let inside = (self.status[f as usize][k] == INSIDE) != flip;
                self.status[g as usize] = [if inside { INSIDE } else { OUTSIDE }; 3];
                queue.push(g);
            }
        }
        match self.status.iter().any(|s| s[0] == 0) {
            true => Err(CutError::Misses),
            false => Ok(()),
        }
    }

    fn fill_whole_tops(&mut self) -> Result<(), CutError> {
        for facet in 0..self.surface.layout.facets.len() as u32 {
            let status = self.status[facet as usize];
            let chains = self.tops.remove(&facet);
            let whole = status == [INSIDE; 3]
                && self.layout().sides[facet as usize].iter().all(|e| {
                    !self.overlay.rails.contains_key(&(*e, 0))
                        && !self.overlay.rails.contains_key(&(*e, 1))
                });
            if chains.is_none() && whole && self.knotless(facet) {
                self.cap.triangles.push(self.corners[facet as usize]);
                self.cap.faces.push(CapFace {
                    cell: self.layout().cells[facet as usize],
                    top: true,
                });
                continue;
            }
            let crossed = (0..3).any(|k| {
                self.side(facet, k)
                    .iter()
                    .any(|(_, id)| !self.is_knot(facet, k, *id))
            });
            if crossed && chains.is_none() {
                continue;
            }
            let mut loops: Vec<Vec<u32>> = Vec::new();
            if status == [INSIDE; 3] {
                loops.push(self.border(facet).into_iter().map(|b| b.0).collect());
            }
            if let Some(chains) = &chains {
                loops.extend(follow(chains, &[]).ok_or_else(|| self.gap(chains))?.loops);
            }
            if !loops.is_empty() {
                self.fill_top(facet, &loops)?;
            }
        }
        Ok(())
    }

    fn knotless(&self, facet: u32) -> bool {
        self.knots.is_empty()
            || self.layout().sides[facet as usize]
                .iter()
                .all(|e| !self.knots.contains_key(e))
    }

    fn is_knot(&self, facet: u32, k: u8, id: u32) -> bool {
        let e = self.layout().sides[facet as usize][usize::from(k)];
        self.knots.get(&e).is_some_and(|knot| knot.1 == id)
    }

    fn fill_walls(&mut self) -> Result<(), CutError> {
        let layout = self.surface.layout.clone();
        for (e, edge) in layout.edges.iter().enumerate() {
            let Some([a, b]) = self.rims(edge) else {
                continue;
            };
            if a == b {
                continue;
            }
            let chains = self.walls.remove(&(e as u32)).unwrap_or_default();
            let mut spans: Vec<(f64, f64)> = vec![(0.0, 1.0)];
            if let Some(knot) = self.knots.get(&(e as u32)) {
                spans = vec![(0.0, knot.0), (knot.0, 1.0)];
            }
            for span in spans {
                self.fill_wall(e as u32, edge, [a, b], span, &chains)?;
            }
        }
        Ok(())
    }

    /// Vertices on a rim of a wall within `span`, from its start to its end, the ends included.
    fn rim(&self, e: u32, edge: &Edge, which: u8, span: (f64, f64)) -> Vec<u32> {
        let (facet, k) = edge.facets[usize::from(which)];
        let corners = self.corners[facet as usize];
        let ends = [corners[usize::from(k)], corners[(usize::from(k) + 1) % 3]];
        let [start, end] = if which == 0 { ends } else { [ends[1], ends[0]] };
        let knot = self.knots.get(&e);
        let mut rim = vec![if span.0 == 0.0 {
            start
        } else {
            knot.map_or(start, |k| k.1)
        }];
        let list = self.overlay.rails.get(&(e, which));
        rim.extend(
            list.into_iter()
                .flatten()
                .filter(|p| p.0 > span.0 && p.0 < span.1)
                .map(|p| p.1),
        );
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
        let mut list: Vec<(f64, u32)> = self.heights[range]
            .iter()
            .filter(|p| p.0 > low && p.0 < high)
            .copied()
            .collect();
        if let Some(pierced) = self.overlay.uprights.get(&node) {
            list.extend(pierced.iter().filter(|p| p.0 > low && p.0 < high));
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
        chains: &Chains,
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
        if !traced.met {
            let [p, q] = edge.nodes.map(|n| self.layout().nodes[n as usize]);
            let within = |l: &Vec<u32>| {
                let t =
                    (self.overlay.grain(l[0]).truncate() - p).dot(q - p) / (q - p).length_squared();
                t > span.0 && t < span.1
            };
            loops.retain(within);
            if self.starts_inside(e, edge, span) {
                loops.insert(0, border);
            }
        }
        if loops.is_empty() {
            return Ok(());
        }
        let [p, q] = edge.nodes.map(|n| self.layout().nodes[n as usize]);
        let along = (q - p) / (q - p).length();
        let sign = if left_high { 1.0 } else { -1.0 };
        let flat = |id: u32| {
            let g = self.overlay.grain(id);
            DVec2::new(sign * (g.truncate() - p).dot(along), g.z)
        };
        let mut triangles = Vec::new();
        polygon::fill(&loops, flat, &mut triangles).map_err(|_| CutError::Face {
            at: self.overlay.grain(loops[0][0]),
        })?;
        let high_facet = edge.facets[usize::from(high)].0;
        let face = CapFace {
            cell: self.layout().cells[high_facet as usize],
            top: false,
        };
        self.push(triangles, face);
        Ok(())
    }

    /// Whether the start of a wall that the outline does not cross lies inside the stem.
    fn starts_inside(&self, e: u32, edge: &Edge, span: (f64, f64)) -> bool {
        let (facet, k) = edge.facets[0];
        let inside = self.status[facet as usize][usize::from(k)] == INSIDE;
        let crossed = self
            .overlay
            .rails
            .get(&(e, 0))
            .map_or(0, |l| l.iter().filter(|p| p.0 < span.0).count());
        inside != (crossed % 2 == 1)
    }
}

struct Traced {
    loops: Vec<Vec<u32>>,
    /// Border vertices that the loops pass.
    border: Vec<u32>,
    /// Whether the outline meets the border.
    met: bool,
}

/// Follows the outline's chains and, from the end of one to the start of the next, the border (counter-clockwise).
fn follow(chains: &Chains, border: &[u32]) -> Option<Traced> {
    let place: FxHashMap<u32, usize> = border.iter().enumerate().map(|(i, &id)| (id, i)).collect();
    let ends: rustc_hash::FxHashSet<u32> = chains.values().copied().collect();
    let mut starts: Vec<u32> = chains
        .keys()
        .copied()
        .filter(|id| place.contains_key(id) && !ends.contains(id))
        .collect();
    starts.sort_by_key(|id| place[id]);
    let mut traced = Traced {
        loops: Vec::new(),
        border: Vec::new(),
        met: !starts.is_empty(),
    };
    let mut used: Vec<bool> = vec![false; starts.len()];
    let mut passed = 0;
    for first in 0..starts.len() {
        if used[first] {
            continue;
        }
        let mut corners = Vec::new();
        let mut current = first;
        loop {
            used[current] = true;
            let mut id = starts[current];
            corners.push(id);
            while let Some(&next) = chains.get(&id) {
                id = next;
                corners.push(id);
                passed += 1;
                if passed > chains.len() {
                    return None;
                }
            }
            let mut i = *place.get(&id)?;
            loop {
                i = (i + 1) % border.len();
                if let Ok(n) = starts.binary_search_by_key(&i, |s| place[s]) {
                    current = n;
                    break;
                }
                corners.push(border[i]);
                traced.border.push(border[i]);
                if corners.len() > border.len() + chains.len() + 2 {
                    return None;
                }
            }
            if current == first {
                break;
            }
            if used[current] {
                return None;
            }
        }
        traced.loops.push(corners);
    }
    if passed < chains.len() {
        // What is left must be closed loops (or chains of another part of this face).
        let mut left: Vec<u32> = chains.keys().copied().collect();
        left.sort_unstable();
        let mut seen: rustc_hash::FxHashSet<u32> = traced.loops.iter().flatten().copied().collect();
        for first in left {
            if seen.contains(&first) {
                continue;
            }
            let mut corners = vec![first];
            let mut id = chains[&first];
            while id != first {
                if !chains.contains_key(&id) || corners.len() > chains.len() {
                    corners.clear();
                    break;
                }
                corners.push(id);
                id = chains[&id];
            }
            seen.extend(&corners);
            if !corners.is_empty() {
                traced.loops.push(corners);
            }
        }
    }
    Some(traced)
}
