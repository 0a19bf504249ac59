//! Parting the broken face at the levels of the grain, between which grain space is affine.

use super::{CapFace, Cut};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Part of the levels' span within which a vertex counts as lying on a level.
const NEAR: f64 = 1e-10;

impl Cut {
    /// Parts every triangle of the broken face that crosses one of the `levels` (m, ascending); `points` as given to
    /// [`super::cut`]. The skin must cross none of them.
    pub fn part_at(&mut self, points: &[DVec3], levels: &[f64]) {
        let (Some(first), Some(last)) = (levels.first(), levels.last()) else {
            return;
        };
        // The skin ends at levels but for rounding; an edge of it must not be parted for that.
        let near = NEAR * (last - first);
        let snapped = |s: f64| {
            let n = levels.partition_point(|&l| l < s);
            let level = |i: usize| levels.get(i).copied().filter(|l| (l - s).abs() <= near);
            level(n).or_else(|| level(n.wrapping_sub(1))).unwrap_or(s)
        };
        let heights: Vec<f64> = (0..self.points + self.vertices.len() + self.inside.len())
            .map(|id| snapped(self.grain(points, id as u32).z))
            .collect();
        let crosses = |t: &[u32; 3]| {
            let s = t.map(|id| heights[id as usize]);
            let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
            let n = levels.partition_point(|&l| l <= low);
            n < levels.len() && levels[n] < high
        };
        if !self.cap.iter().any(crosses) {
            return;
        }
        Parter {
            cut: self,
            points,
            heights,
            levels,
            made: FxHashMap::default(),
        }
        .run();
    }
}

struct Parter<'a> {
    cut: &'a mut Cut,
    points: &'a [DVec3],
    /// Length (m) of every vertex.
    heights: Vec<f64>,
    levels: &'a [f64],
    /// Vertices on edges, by the edge's ends and the level.
    made: FxHashMap<(u32, u32, u32), u32>,
}

impl Parter<'_> {
    fn run(&mut self) {
        let triangles = std::mem::take(&mut self.cut.cap);
        let faces = std::mem::take(&mut self.cut.faces);
        let mut walls = std::mem::take(&mut self.cut.walls).into_iter().peekable();
        let mut stack = Vec::new();
        for (i, (triangle, face)) in triangles.into_iter().zip(faces).enumerate() {
            while walls.next_if(|w| *w as usize <= i).is_some() {
                self.cut.walls.push(self.cut.cap.len() as u32);
            }
            stack.push(triangle);
            while let Some(t) = stack.pop() {
                self.part(t, face, &mut stack);
            }
        }
        for _ in walls {
            self.cut.walls.push(self.cut.cap.len() as u32);
        }
    }

    fn part(&mut self, t: [u32; 3], face: CapFace, stack: &mut Vec<[u32; 3]>) {
        let s = t.map(|id| self.heights[id as usize]);
        let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
        let n = self.levels.partition_point(|&l| l <= low);
        if n >= self.levels.len() || self.levels[n] >= high {
            self.cut.cap.push(t);
            self.cut.faces.push(face);
            return;
        }
        let level = self.levels[n];
        if let Some(i) = (0..3).find(|&i| s[i] == level) {
            let (b, c) = (t[(i + 1) % 3], t[(i + 2) % 3]);
            let m = self.vertex(b, c, n, level);
            stack.extend([[t[i], m, c], [t[i], b, m]]);
            return;
        }
        // One corner is alone on its side of the level.
        let side = |i: usize| s[i] > level;
        let i = (0..3).find(|&i| side(i) != side((i + 1) % 3) && side(i) != side((i + 2) % 3));
        let i = i.unwrap_or(0);
        let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
        let (m, k) = (self.vertex(a, b, n, level), self.vertex(a, c, n, level));
        stack.extend([[b, c, k], [m, b, k], [a, m, k]]);
    }

    fn vertex(&mut self, a: u32, b: u32, number: usize, level: f64) -> u32 {
        let (a, b) = (a.min(b), a.max(b));
        if let Some(&known) = self.made.get(&(a, b, number as u32)) {
            return known;
        }
        let (u, v) = (self.heights[a as usize], self.heights[b as usize]);
        let t = (level - u) / (v - u);
        let (p, q) = (
            self.cut.grain(self.points, a),
            self.cut.grain(self.points, b),
        );
        let mut p = p.lerp(q, t);
        p.z = level;
        self.cut.inside.push(p);
        self.cut.nodes.push(crate::surface::NONE);
        self.heights.push(level);
        let id = (self.cut.points + self.cut.vertices.len() + self.cut.inside.len() - 1) as u32;
        self.made.insert((a, b, number as u32), id);
        id
    }
}
