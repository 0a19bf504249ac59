//! Drawing points and lines into the triangulation of a surface: facets and edges they meet are parted, heights of
//! what is new lie on the facets they part.

use crate::surface::{FractureSurface, NONE, SectionLayout};
use glam::DVec2;
use std::sync::Arc;

/// A surface whose triangulation can be parted.
pub(super) struct Refined {
    pub nodes: Vec<DVec2>,
    pub facets: Vec<[u32; 3]>,
    pub heights: Vec<[f64; 3]>,
    pub cells: Vec<u32>,
    /// Facet across each side.
    across: Vec<[u32; 3]>,
    /// A facet at each node.
    at: Vec<u32>,
    /// Points and lines closer than this to a node or an edge (m) are drawn through it.
    near: f64,
    last: u32,
}

/// Where a point lies.
enum Spot {
    Node(u32),
    Side(u32, usize),
    Facet(u32),
}

impl Refined {
    pub fn new(surface: &FractureSurface, near: f64) -> Self {
        let layout = &surface.layout;
        let across = layout
            .sides
            .iter()
            .enumerate()
            .map(|(f, sides)| {
                sides.map(|e| {
                    let [a, b] = layout.edges[e as usize].facets;
                    if a.0 == f as u32 { b.0 } else { a.0 }
                })
            })
            .collect();
        let mut at = vec![NONE; layout.nodes.len()];
        for (f, facet) in layout.facets.iter().enumerate() {
            facet.iter().for_each(|&n| at[n as usize] = f as u32);
        }
        Refined {
            nodes: layout.nodes.clone(),
            facets: layout.facets.clone(),
            heights: surface.heights.clone(),
            cells: layout.cells.clone(),
            across,
            at,
            near,
            last: 0,
        }
    }

    /// The surface as it is now.
    pub fn finish(self) -> FractureSurface {
        FractureSurface {
            layout: Arc::new(SectionLayout::new(self.nodes, self.facets, self.cells)),
            heights: self.heights,
        }
    }

    fn p(&self, f: u32, k: usize) -> DVec2 {
        self.nodes[self.facets[f as usize][k % 3] as usize]
    }

    /// Distance of a point from the line of a side, positive inside.
    fn off(&self, f: u32, k: usize, p: DVec2) -> f64 {
        let (a, b) = (self.p(f, k), self.p(f, k + 1));
        (b - a).perp_dot(p - a) / (b - a).length().max(f64::MIN_POSITIVE)
    }

    /// Whether the point lies in some facet.
    pub fn holds(&mut self, p: DVec2) -> bool {
        self.facet(p).is_some()
    }

    /// A facet that holds the point.
    fn facet(&mut self, p: DVec2) -> Option<u32> {
        let least = |s: &Self, f: u32| {
            (0..3)
                .map(|k| (s.off(f, k, p), k))
                .fold((f64::INFINITY, 0), |a, b| if b.0 < a.0 { b } else { a })
        };
        let mut f = self.last;
        for _ in 0..200 {
            let (off, k) = least(self, f);
            if off >= 0.0 {
                self.last = f;
                return Some(f);
            }
            match self.across[f as usize][k] {
                NONE => break,
                g => f = g,
            }
        }
        let found = (0..self.facets.len() as u32).find(|&f| least(self, f).0 >= 0.0)?;
        self.last = found;
        Some(found)
    }

    fn spot(&mut self, p: DVec2) -> Option<Spot> {
        let f = self.facet(p)?;
        for k in 0..3 {
            if self.p(f, k).distance(p) <= self.near {
                return Some(Spot::Node(self.facets[f as usize][k]));
            }
        }
        for k in 0..3 {
            if self.off(f, k, p) <= self.near {
                return Some(Spot::Side(f, k));
            }
        }
        Some(Spot::Facet(f))
    }

    /// The node at a point (or the one very near it), made where there is none; `None` beyond the border.
    pub fn point(&mut self, p: DVec2) -> Option<u32> {
        Some(match self.spot(p)? {
            Spot::Node(n) => n,
            Spot::Side(f, k) => {
                let (a, b) = (self.p(f, k), self.p(f, k + 1));
                let t = (p - a).dot(b - a) / (b - a).length_squared();
                self.part_side(f, k, t)
            }
            Spot::Facet(f) => self.part_facet(f, p),
        })
    }

    fn part_facet(&mut self, f: u32, p: DVec2) -> u32 {
        let n = self.nodes.len() as u32;
        self.nodes.push(p);
        self.at.push(f);
        let (corners, heights) = (self.facets[f as usize], self.heights[f as usize]);
        let across = self.across[f as usize];
        let [a, b, c] = corners.map(|c| self.nodes[c as usize]);
        let area = (b - a).perp_dot(c - a);
        let weights = [
            (b - p).perp_dot(c - p) / area,
            (c - p).perp_dot(a - p) / area,
            (a - p).perp_dot(b - p) / area,
        ];
        let h = (0..3).map(|k| heights[k] * weights[k]).sum::<f64>();
        // Rounding must not lift a level facet.
        let low = heights[0].min(heights[1]).min(heights[2]);
        let high = heights[0].max(heights[1]).max(heights[2]);
        let h = h.clamp(low, high);
        let first = self.facets.len() as u32;
        let ids = [f, first, first + 1];
        for k in 0..3 {
            let new = [corners[k], corners[(k + 1) % 3], n];
            let lifted = [heights[k], heights[(k + 1) % 3], h];
            let beside = [across[k], ids[(k + 1) % 3], ids[(k + 2) % 3]];
            self.put(ids[k], f, new, lifted, beside);
            self.relink(across[k], f, ids[k]);
        }
        n
    }

    /// Writes facet `id`, a part of facet `of`.
    fn put(&mut self, id: u32, of: u32, nodes: [u32; 3], heights: [f64; 3], across: [u32; 3]) {
        if id as usize == self.facets.len() {
            self.facets.push(nodes);
            self.heights.push(heights);
            self.across.push(across);
            self.cells.push(self.cells[of as usize]);
        } else {
            self.facets[id as usize] = nodes;
            self.heights[id as usize] = heights;
            self.across[id as usize] = across;
        }
        nodes.iter().for_each(|&n| self.at[n as usize] = id);
    }

    fn relink(&mut self, f: u32, from: u32, to: u32) {
        if f != NONE {
            for g in &mut self.across[f as usize] {
                if *g == from {
                    *g = to;
                }
            }
        }
    }

    /// Splits side `k` of facet `f` at the fraction `t` of it, with the facet beyond.
    fn part_side(&mut self, f: u32, k: usize, t: f64) -> u32 {
        let [a, b] = [
            self.facets[f as usize][k],
            self.facets[f as usize][(k + 1) % 3],
        ];
        // From the smaller node on, so that both facets work out the very same height.
        let t = if a < b { t } else { 1.0 - t };
        let ends = [a.min(b), a.max(b)];
        let n = self.nodes.len() as u32;
        let [p, q] = ends.map(|e| self.nodes[e as usize]);
        self.nodes.push(p.lerp(q, t));
        self.at.push(f);
        let g = self.across[f as usize][k];
        let f2 = self.facets.len() as u32;
        let g2 = if g == NONE { NONE } else { f2 + 1 };
        self.halve(f, k, n, (ends[0], t), f2, [g, g2]);
        if g != NONE {
            let j = (0..3)
                .find(|&j| self.facets[g as usize][j] == b)
                .unwrap_or(0);
            // Facet f keeps the half at `a`; g, which runs the other way, the half at `b`.
            self.halve(g, j, n, (ends[0], t), g2, [f2, f]);
            self.across[f as usize][k] = g2;
            self.across[f2 as usize][0] = g;
        }
        n
    }

    /// Halves facet `f` from node `n` on its side `k`; `f2` is the half at the side's end. `beyond` are the facets
    /// across the first and the second half.
    fn halve(&mut self, f: u32, k: usize, n: u32, (low, t): (u32, f64), f2: u32, beyond: [u32; 2]) {
        let c = self.facets[f as usize];
        let h = self.heights[f as usize];
        let across = self.across[f as usize];
        let (k1, k2) = ((k + 1) % 3, (k + 2) % 3);
        let (x, y) = if c[k] == low {
            (h[k], h[k1])
        } else {
            (h[k1], h[k])
        };
        let lifted = x + (y - x) * t;
        let mut first = ([0; 3], [0.0; 3], [0; 3]);
        first.0[k] = c[k];
        first.0[k1] = n;
        first.0[k2] = c[k2];
        first.1[k] = h[k];
        first.1[k1] = lifted;
        first.1[k2] = h[k2];
        first.2[k] = beyond[0];
        first.2[k1] = f2;
        first.2[k2] = across[k2];
        self.put(f, f, first.0, first.1, first.2);
        self.put(
            f2,
            f,
            [n, c[k1], c[k2]],
            [lifted, h[k1], h[k2]],
            [beyond[1], across[k1], f],
        );
        self.relink(across[k1], f, f2);
    }

    /// Facets about a node with the number of its corner.
    fn about(&self, n: u32) -> Vec<(u32, usize)> {
        let corner = |f: u32| self.facets[f as usize].iter().position(|&c| c == n);
        let start = self.at[n as usize];
        let mut all = Vec::new();
        for way in [2, 0] {
            let mut f = start;
            while let Some(k) = corner(f) {
                if !all.contains(&(f, k)) {
                    all.push((f, k));
                }
                f = self.across[f as usize][(k + way) % 3];
                if f == NONE || f == start {
                    break;
                }
            }
        }
        all
    }

    /// Makes edges along the straight line between two nodes; the nodes on it, both ends included; `None` where facets are folded. Where the line
    /// passes a node very closely it is led through it.
    pub fn line(&mut self, from: u32, to: u32) -> Option<Vec<u32>> {
        let mut path = vec![from];
        let mut now = from;
        let most = 16 + self.facets.len();
        while now != to {
            let next = self.step(now, to);
            let next = next.filter(|n| path.len() < most && !path.contains(n))?;
            path.push(next);
            now = next;
        }
        Some(path)
    }

    /// The next node on the way.
    fn step(&mut self, now: u32, to: u32) -> Option<u32> {
        let (a, b) = (self.nodes[now as usize], self.nodes[to as usize]);
        let length = (b - a).length();
        let d = (b - a) / length;
        let about = self.about(now);
        let ends = |s: &Self, (f, k): (u32, usize)| {
            let c = s.facets[f as usize];
            [c[(k + 1) % 3], c[(k + 2) % 3]]
        };
        if about.iter().any(|&c| ends(self, c).contains(&to)) {
            return Some(to);
        }
        let mut best: Option<(f64, (u32, usize))> = None;
        for &c in &about {
            for n in ends(self, c) {
                let v = self.nodes[n as usize] - a;
                let along = v.dot(d);
                if v.perp_dot(d).abs() <= self.near && along > 0.0 && along < length {
                    return Some(n);
                }
            }
            let [p, q] = ends(self, c).map(|n| self.nodes[n as usize] - a);
            let inside = p
                .normalize_or_zero()
                .perp_dot(d)
                .min(d.perp_dot(q.normalize_or_zero()));
            if p.dot(d).max(q.dot(d)) > 0.0 && best.is_none_or(|b| inside > b.0) {
                best = Some((inside, c));
            }
        }
        let (inside, (f, k)) = best?;
        if inside < 0.0 {
            return None;
        }
        let [p, q] = ends(self, (f, k)).map(|n| self.nodes[n as usize] - a);
        let (u, v) = (p.perp_dot(d), q.perp_dot(d));
        let t = u / (u - v);
        (t > 0.0 && t < 1.0).then(|| self.part_side(f, (k + 1) % 3, t))
    }
}
