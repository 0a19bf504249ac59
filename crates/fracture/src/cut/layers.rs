//! Splitting the broken face at the levels of the grain, between which grain space is affine.

use super::Cut;
use crate::surface::NONE;
use glam::DVec3;
use greenstick_wood::stem::LevelSteps;

/// How many levels lie at or below a vertex, and how many below it; they differ where it lies on one.
type Rank = [u32; 2];

/// The levels that a triangle crosses: the number of the first, and whether it is the only one.
struct Crossed {
    first: usize,
    only: bool,
}

/// A vertex and its rank.
#[derive(Clone, Copy, Default)]
struct RankedVertex {
    id: u32,
    rank: Rank,
}

/// Corners of a part of a triangle, or nothing where two of them are one.
#[inline]
fn whole(part: &[RankedVertex; 3]) -> Option<[u32; 3]> {
    let [a, b, c] = part.map(|v| v.id);
    (a != b && b != c && c != a).then_some([a, b, c])
}

/// The levels that a triangle with such corners crosses.
#[inline]
fn crossed(corners: [RankedVertex; 3]) -> Option<Crossed> {
    let [a, b, c] = corners.map(|v| v.rank);
    let (least, most) = (a[0].min(b[0]).min(c[0]), a[1].max(b[1]).max(c[1]));
    (least < most).then(|| Crossed {
        first: least as usize,
        only: least + 1 == most,
    })
}

impl Cut {
    /// Splits every triangle of the broken face that crosses one of the `levels` (m, ascending); `points` as given to
    /// [`super::cut`]. The skin must cross none of them: its vertices lie on levels to within `near` (m), and its edges are not
    /// split for that.
    pub fn split_at_levels(&mut self, points: &[DVec3], levels: &[f64], near: f64) {
        if levels.is_empty() {
            return;
        }
        let steps = LevelSteps::new(levels);
        let rank = |s: f64| {
            let at = steps.count(levels, s + near);
            let mut below = at;
            while below > 0 && levels[below - 1] >= s - near {
                below -= 1;
            }
            [at as u32, below as u32]
        };
        let made = self.vertices.iter().map(|v| v.grain.z);
        let inside = self.inside.iter().map(|p| p.z);
        let mut ranks: Vec<Rank> = Vec::with_capacity(self.vertices.len() + 2 * self.inside.len());
        ranks.extend(made.map(rank));
        ranks.extend(inside.map(rank));
        let mut splitter = LevelSplitter {
            points,
            rank: &rank,
            ranks,
            levels,
            latest: Vec::new(),
            made: Vec::new(),
            cut: self,
        };
        let crossing = splitter.crossing();
        if !crossing.is_empty() {
            splitter.run(&crossing);
        }
    }
}

struct LevelSplitter<'a, R> {
    points: &'a [DVec3],
    rank: &'a R,
    /// Rank of every vertex but the mesh's own.
    ranks: Vec<Rank>,
    levels: &'a [f64],
    /// For each vertex the latest in `made` on an edge to a vertex of a greater number, or [`NONE`].
    latest: Vec<u32>,
    /// Vertices on edges.
    made: Vec<Made>,
    cut: &'a mut Cut,
}

/// A vertex where an edge crosses a level.
struct Made {
    /// The greater number of the edge's ends, and the level.
    of: (u32, u32),
    id: u32,
    /// The one before it at the edge's smaller end, or [`NONE`].
    before: u32,
}

impl<R: Fn(f64) -> Rank> LevelSplitter<'_, R> {
    fn ranked(&self, t: &[u32; 3]) -> [RankedVertex; 3] {
        t.map(|id| RankedVertex {
            id,
            rank: self.rank_of(id),
        })
    }

    #[inline]
    fn rank_of(&self, id: u32) -> Rank {
        match self.ranks.get((id as usize).wrapping_sub(self.cut.points)) {
            Some(rank) => *rank,
            // Vertices of the mesh itself are not expected in the broken face.
            None => (self.rank)(self.points[id as usize].z),
        }
    }

    /// Numbers of the triangles that cross a level.
    fn crossing(&self) -> Vec<u32> {
        // Corners of one rank have no level between them. Which triangles have several is not to be predicted, so nothing
        // branches on it.
        let mut list = vec![0; self.cut.cap.len()];
        let mut count = 0;
        let points = self.cut.points as u32;
        let rank = |id: u32| {
            let known = self.ranks.get(id.wrapping_sub(points) as usize);
            // Vertices of the mesh itself are looked at below.
            known.map_or([id, NONE], |rank| *rank)
        };
        for (number, t) in (0..).zip(&self.cut.cap) {
            let [a, b, c] = t.map(rank);
            list[count] = number;
            count += usize::from((a != b) | (b != c));
        }
        list.truncate(count);
        let crosses = |t: &[u32; 3]| crossed(self.ranked(t)).is_some();
        list.retain(|&number| crosses(&self.cut.cap[number as usize]));
        list
    }

    /// Grain coordinates of a vertex; its length is that of the level where it lies on one.
    #[inline]
    fn grain(&self, vertex: RankedVertex) -> DVec3 {
        let [at, below] = vertex.rank;
        let mut grain = self.cut.grain(self.points, vertex.id);
        if at > below {
            grain.z = self.levels[below as usize];
        }
        grain
    }

    /// Splits the triangles numbered in `crossing`, which ascend.
    fn run(&mut self, crossing: &[u32]) {
        // Most of the edges that cross belong to two triangles, and each triangle has two.
        let made = crossing.len() + crossing.len() / 8;
        self.latest = Vec::with_capacity(self.cut.points + self.ranks.len() + made);
        self.latest.resize(self.cut.points + self.ranks.len(), NONE);
        self.made.reserve(made);
        self.cut.inside.reserve(made);
        self.cut.nodes.reserve(made);
        let triangles = std::mem::take(&mut self.cut.cap);
        let faces = std::mem::take(&mut self.cut.faces);
        // Most are split at one level, into three.
        let capacity = triangles.len() + 3 * crossing.len();
        self.cut.cap.reserve(capacity);
        self.cut.faces.reserve(capacity);
        let mut walls = std::mem::take(&mut self.cut.walls);
        let mut later = walls.iter_mut().peekable();
        let mut from = 0;
        for &number in crossing {
            let at = number as usize;
            self.cut.cap.extend_from_slice(&triangles[from..at]);
            self.cut.faces.extend_from_slice(&faces[from..at]);
            from = at + 1;
            // The splits so far move all that follows.
            let moved = (self.cut.cap.len() - at) as u32;
            while let Some(wall) = later.next_if(|w| **w <= number) {
                *wall += moved;
            }
            self.split(self.ranked(&triangles[at]));
            self.cut.faces.resize(self.cut.cap.len(), faces[at]);
        }
        let moved = (self.cut.cap.len() - from) as u32;
        later.for_each(|wall| *wall += moved);
        self.cut.cap.extend_from_slice(&triangles[from..]);
        self.cut.faces.extend_from_slice(&faces[from..]);
        self.cut.walls = walls;
    }

    /// Adds a triangle to the face, split at the levels that it crosses.
    fn split(&mut self, t: [RankedVertex; 3]) {
        let Some(levels) = crossed(t) else {
            self.cut.cap.extend(whole(&t));
            return;
        };
        let (parts, count) = self.parts(t, levels.first);
        if levels.only {
            self.cut.cap.extend(parts[..count].iter().filter_map(whole));
        } else {
            parts[..count].iter().for_each(|part| self.split(*part));
        }
    }

    /// The parts of a triangle above and below level number `n`, two or three.
    fn parts(&mut self, t: [RankedVertex; 3], n: usize) -> ([[RankedVertex; 3]; 3], usize) {
        let level = self.levels[n];
        let above = t.map(|v| v.rank[1] as usize > n);
        let on = t.map(|v| (v.rank[1] as usize..v.rank[0] as usize).contains(&n));
        if let Some(i) = (0..3).find(|&i| on[i]) {
            let (b, c) = (t[(i + 1) % 3], t[(i + 2) % 3]);
            let m = self.vertex(b, c, n, level);
            return ([[t[i], b, m], [t[i], m, c], Default::default()], 2);
        }
        // One corner is alone on its side of the level.
        let i = (0..3).find(|&i| above[i] != above[(i + 1) % 3] && above[i] != above[(i + 2) % 3]);
        let i = i.unwrap_or(0);
        let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
        let (m, k) = (self.vertex(a, b, n, level), self.vertex(a, c, n, level));
        ([[a, m, k], [m, b, k], [b, c, k]], 3)
    }

    fn vertex(
        &mut self,
        a: RankedVertex,
        b: RankedVertex,
        number: usize,
        level: f64,
    ) -> RankedVertex {
        let (p, q) = if a.id < b.id { (a, b) } else { (b, a) };
        let (a, b) = (p.id, q.id);
        let of = (b, number as u32);
        let rank = [number as u32 + 1, number as u32];
        let first = self.latest[a as usize];
        let mut at = first;
        while let Some(known) = self.made.get(at as usize) {
            if known.of == of {
                return RankedVertex { id: known.id, rank };
            }
            at = known.before;
        }
        let (p, q) = (self.grain(p), self.grain(q));
        let t = (level - p.z) / (q.z - p.z);
        let mut p = p.lerp(q, t);
        p.z = level;
        // Narrow triangles that end closely beside a level may cross it in one place.
        let mut at = first;
        while let Some(known) = self.made.get(at as usize) {
            if known.of.1 == number as u32 && self.cut.grain(self.points, known.id) == p {
                return RankedVertex { id: known.id, rank };
            }
            at = known.before;
        }
        self.cut.inside.push(p);
        self.cut.nodes.push(NONE);
        self.ranks.push(rank);
        let id = (self.cut.points + self.cut.vertices.len() + self.cut.inside.len() - 1) as u32;
        self.latest[a as usize] = self.made.len() as u32;
        self.latest.push(NONE);
        self.made.push(Made {
            of,
            id,
            before: first,
        });
        RankedVertex { id, rank }
    }
}
