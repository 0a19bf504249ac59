//! Parting the broken face at the levels of the grain, between which grain space is affine.

use super::Cut;
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Part of the levels' span within which a vertex counts as lying on a level.
const NEAR: f64 = 1e-10;

/// How many levels lie at or below a vertex, and how many below it; they differ where it lies on one.
type Rank = (u32, u32);

/// The first level that a triangle with corners of such ranks crosses.
fn crossed(ranks: [Rank; 3]) -> Option<usize> {
    let [a, b, c] = ranks;
    let (least, most) = (a.0.min(b.0).min(c.0), a.1.max(b.1).max(c.1));
    (least < most).then_some(least as usize)
}

impl Cut {
    /// Parts every triangle of the broken face that crosses one of the `levels` (m, ascending); `points` as given to
    /// [`super::cut`]. The skin must cross none of them.
    pub fn part_at(&mut self, points: &[DVec3], levels: &[f64]) {
        let (Some(first), Some(last)) = (levels.first(), levels.last()) else {
            return;
        };
        // The skin ends at levels but for rounding; an edge of it must not be parted for that.
        let near = NEAR * (last - first);
        let rank = |s: f64| {
            if levels.len() > FEW {
                let at = levels.partition_point(|&l| l <= s + near) as u32;
                return (at, levels.partition_point(|&l| l < s - near) as u32);
            }
            levels.iter().fold((0, 0), |(at, below), &l| {
                (
                    at + u32::from(l <= s + near),
                    below + u32::from(l < s - near),
                )
            })
        };
        let made = self.vertices.iter().map(|v| v.grain.z);
        let ranks: Vec<Rank> = made
            .chain(self.inside.iter().map(|p| p.z))
            .map(rank)
            .collect();
        let mut parter = Parter {
            points,
            rank: &rank,
            ranks,
            levels,
            made: FxHashMap::default(),
            cut: self,
        };
        let crosses = |t: &[u32; 3]| crossed(parter.ranks(t)).is_some();
        if let Some(first) = parter.cut.cap.iter().position(crosses) {
            parter.run(first);
        }
    }
}

/// Levels up to which counting all of them is quicker than searching.
const FEW: usize = 32;

struct Parter<'a, R> {
    cut: &'a mut Cut,
    points: &'a [DVec3],
    rank: &'a R,
    /// Rank of every vertex but the mesh's own.
    ranks: Vec<Rank>,
    levels: &'a [f64],
    /// Vertices on edges, by the edge's ends and the level.
    made: FxHashMap<(u32, u32, u32), u32>,
}

impl<R: Fn(f64) -> Rank> Parter<'_, R> {
    fn ranks(&self, t: &[u32; 3]) -> [Rank; 3] {
        t.map(|id| self.rank_of(id))
    }

    fn rank_of(&self, id: u32) -> Rank {
        match (id as usize).checked_sub(self.cut.points) {
            Some(i) => self.ranks[i],
            // Vertices of the mesh itself are not expected in the broken face.
            None => (self.rank)(self.points[id as usize].z),
        }
    }

    /// Length of a vertex, m: that of the level where it lies on one.
    fn height(&self, id: u32) -> f64 {
        let (at, below) = self.rank_of(id);
        if at > below {
            self.levels[below as usize]
        } else {
            self.cut.grain(self.points, id).z
        }
    }

    /// Parts the triangles from number `first` on.
    fn run(&mut self, first: usize) {
        let triangles = self.cut.cap[first..].to_vec();
        let faces = self.cut.faces[first..].to_vec();
        let mut wall = self.cut.walls.partition_point(|&w| (w as usize) < first);
        self.cut.cap.truncate(first);
        self.cut.faces.truncate(first);
        let mut stack = Vec::new();
        for (i, (triangle, face)) in triangles.into_iter().zip(faces).enumerate() {
            while self
                .cut
                .walls
                .get(wall)
                .is_some_and(|&w| w as usize <= first + i)
            {
                self.cut.walls[wall] = self.cut.cap.len() as u32;
                wall += 1;
            }
            stack.push(triangle);
            while let Some(t) = stack.pop() {
                match crossed(self.ranks(&t)) {
                    Some(n) => self.part(t, n, &mut stack),
                    None => {
                        self.cut.cap.push(t);
                        self.cut.faces.push(face);
                    }
                }
            }
        }
        let end = self.cut.cap.len() as u32;
        self.cut.walls[wall..].fill(end);
    }

    /// Parts a triangle at level number `n`.
    fn part(&mut self, t: [u32; 3], n: usize, stack: &mut Vec<[u32; 3]>) {
        let level = self.levels[n];
        let ranks = self.ranks(&t);
        let above = ranks.map(|r| r.1 as usize > n);
        let on = ranks.map(|r| (r.1 as usize..r.0 as usize).contains(&n));
        if let Some(i) = (0..3).find(|&i| on[i]) {
            let (b, c) = (t[(i + 1) % 3], t[(i + 2) % 3]);
            let m = self.vertex(b, c, n, level);
            stack.extend([[t[i], m, c], [t[i], b, m]]);
            return;
        }
        // One corner is alone on its side of the level.
        let i = (0..3).find(|&i| above[i] != above[(i + 1) % 3] && above[i] != above[(i + 2) % 3]);
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
        let (u, v) = (self.height(a), self.height(b));
        let t = (level - u) / (v - u);
        let (p, q) = (
            self.cut.grain(self.points, a),
            self.cut.grain(self.points, b),
        );
        let mut p = p.lerp(q, t);
        p.z = level;
        self.cut.inside.push(p);
        self.cut.nodes.push(crate::surface::NONE);
        self.ranks.push((number as u32 + 1, number as u32));
        let id = (self.cut.points + self.cut.vertices.len() + self.cut.inside.len() - 1) as u32;
        self.made.insert((a, b, number as u32), id);
        id
    }
}
