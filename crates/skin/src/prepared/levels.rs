//! Splitting the skin of a bent stem at the levels of its grain.
//!
//! Between two levels grain space is affine ([`LayeredGrain`]), so triangles that cross no level are the same straight
//! triangles there and in the world: what is cut in one is cut in the other.

use crate::source::SplitTriangles;
use glam::{DAffine3, DVec3};
use greenstick_geometry::Mesh;
use greenstick_wood::stem::{FoundStem, LayeredGrain};
use rustc_hash::FxHashMap;

/// A mesh whose triangles are split; new vertices and triangles are only at the end of the lists.
pub(super) struct LevelSplitter {
    pub mesh: Mesh,
    /// Point of every vertex.
    pub points: Vec<u32>,
    /// Grain coordinates of every point, m.
    pub grain: Vec<DVec3>,
    /// Triangles of the limb; those that were split are replaced by their parts.
    pub limb: Vec<u32>,
    /// How many triangles were split.
    pub split: usize,
    /// Which triangles were split into which.
    pub parts: SplitTriangles,
}

/// A level of the grain.
#[derive(Clone, Copy)]
struct Level {
    number: u32,
    /// Length along the grain, m.
    length: f64,
}

/// The maps that new vertices are placed by.
struct Maps<'a> {
    layers: &'a LayeredGrain,
    /// From the mesh to the world.
    transform: &'a DAffine3,
    /// Lengths of all levels, m.
    levels: &'a [f64],
    /// Distance within which a vertex counts as lying on a level, m.
    near: f64,
}

/// Points and vertices made on edges, by the edge's ends and the level's number.
#[derive(Default)]
struct Made {
    points: FxHashMap<(u32, u32, u32), u32>,
    vertices: FxHashMap<(u32, u32, u32), u32>,
    /// The level at which the edge between two points was split.
    splits: FxHashMap<(u32, u32), Level>,
}

/// Part of the stem's radius within which a vertex counts as lying on a level: more would bend straight edges.
const ON_LEVEL: f64 = 1e-9;

/// Cosine of the angle with the grain below which a triangle's normal makes it one of a face across the stem.
const ALONG: f64 = 0.7;

/// Distance within which a vertex of a stem counts as lying on a level, m.
pub(super) fn near(found: &FoundStem) -> f64 {
    ON_LEVEL * found.stem.radius
}

impl LevelSplitter {
    /// The levels of the grain that the skin is to be split at, m, ascending. That at an end of the free length is left out where
    /// triangles that cross it face along the grain: an earlier break's face or a sawn end lies there, whose many small triangles
    /// might cross each other when they were split, and straight grain's map goes on unchanged beyond that level. Elsewhere it is
    /// kept: on coarse trunks later breaks find their stem by these vertices.
    fn levels(&self, layers: &LayeredGrain) -> Vec<f64> {
        let mut levels: Vec<f64> = layers.levels().collect();
        if layers.has_spiral_grain() {
            return levels;
        }
        let crosses_face = |level: f64| {
            self.limb.iter().any(|&t| {
                let corners = self.mesh.triangles[t as usize];
                let [a, b, c] = corners.map(|v| self.grain[self.points[v as usize] as usize]);
                let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
                let normal = (b - a).cross(c - a);
                low < level && high > level && normal.z.abs() > ALONG * normal.length()
            })
        };
        levels.pop_if(|last| crosses_face(*last));
        if levels.first().is_some_and(|&first| crosses_face(first)) {
            levels.remove(0);
        }
        levels
    }

    /// Splits the limb's triangles at every level, and triangles of the shell beside the limb along with it, so that edges
    /// stay whole. `transform` leads from the mesh to the world. Returns the levels (m) and the new triangles.
    pub fn split(
        &mut self,
        layers: &LayeredGrain,
        transform: &DAffine3,
        found: &FoundStem,
    ) -> (Vec<f64>, Vec<u32>) {
        let levels = self.levels(layers);
        let before = self.mesh.triangles.len();
        self.parts = SplitTriangles::of_unsplit(&self.mesh);
        if levels.is_empty() {
            return (levels, Vec::new());
        }
        let mut beside = vec![true; before];
        self.limb.iter().for_each(|&t| beside[t as usize] = false);
        let maps = Maps {
            layers,
            transform,
            levels: &levels,
            near: near(found),
        };
        let mut made = Made::default();
        self.split_limb(&maps, &mut made);
        let mut stack: Vec<u32> = (found.shell.iter().copied())
            .filter(|&t| beside[t as usize])
            .collect();
        while let Some(t) = stack.pop() {
            let parts = self.split_beside(t, before, &maps, &mut made);
            stack.extend(parts.into_iter().flatten());
        }
        let new = before as u32..self.mesh.triangles.len() as u32;
        (levels, new.collect())
    }

    /// Splits the limb's triangles.
    fn split_limb(&mut self, maps: &Maps, made: &mut Made) {
        let before = self.mesh.triangles.len();
        let mut stack: Vec<u32> = std::mem::take(&mut self.limb);
        stack.reverse();
        while let Some(t) = stack.pop() {
            let corners = self.mesh.triangles[t as usize];
            let s = corners.map(|v| maps.snapped(self.grain[self.points[v as usize] as usize].z));
            let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
            let n = maps.levels.partition_point(|&l| l <= low);
            let Some(&length) = maps.levels.get(n).filter(|&&l| l < high) else {
                self.limb.push(t);
                continue;
            };
            self.split += usize::from((t as usize) < before);
            self.parts.note(t, corners);
            let level = Level {
                number: n as u32,
                length,
            };
            let parts = self.parts(corners, s, level, maps, made);
            let material = self.mesh.materials.get(t as usize).copied();
            for (i, part) in parts.into_iter().enumerate() {
                if i == 0 {
                    self.mesh.triangles[t as usize] = part;
                    stack.push(t);
                } else {
                    self.parts.add(t);
                    stack.push(self.mesh.triangles.len() as u32);
                    self.mesh.triangles.push(part);
                    self.mesh.materials.extend(material);
                }
            }
        }
        self.limb.sort_unstable();
    }

    /// The parts of a triangle whose corners have the lengths `s` and lie on both sides of a level.
    fn parts(
        &mut self,
        corners: [u32; 3],
        s: [f64; 3],
        level: Level,
        maps: &Maps,
        made: &mut Made,
    ) -> Vec<[u32; 3]> {
        let mut cut = |splitter: &mut Self, a: usize, b: usize| {
            splitter.vertex(corners[a], corners[b], level, maps, made)
        };
        let (below, above) = (
            |i: usize| s[i] < level.length,
            |i: usize| s[i] > level.length,
        );
        // The triangle is turned so that its first corner lies on the level or is alone on its side of it.
        if let Some(i) = (0..3).find(|&i| s[i] == level.length) {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let m = cut(self, j, k);
            return vec![[corners[i], corners[j], m], [corners[i], m, corners[k]]];
        }
        let alone = (0..3).find(|&i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            (below(i) && above(j) && above(k)) || (above(i) && below(j) && below(k))
        });
        let i = alone.unwrap_or(0);
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (m, n) = (cut(self, i, j), cut(self, i, k));
        let (b, c) = (corners[j], corners[k]);
        let at = |v: u32| self.mesh.positions[v as usize];
        // The shorter diagonal of the quadrilateral.
        if at(m).distance_squared(at(c)) < at(b).distance_squared(at(n)) {
            vec![[corners[i], m, n], [m, b, c], [m, c, n]]
        } else {
            vec![[corners[i], m, n], [m, b, n], [b, c, n]]
        }
    }

    /// Splits a triangle beside the limb at an edge that was split; returns both parts. Triangles from number `before` on
    /// are new.
    fn split_beside(
        &mut self,
        t: u32,
        before: usize,
        maps: &Maps,
        made: &mut Made,
    ) -> Option<[u32; 2]> {
        let corners = self.mesh.triangles[t as usize];
        let point = |i: usize| self.points[corners[i % 3] as usize];
        let (i, level) = (0..3).find_map(|i| {
            let (p, q) = (point(i), point(i + 1));
            let split = made.splits.get(&(p.min(q), p.max(q)));
            split.map(|&level| (i, level))
        })?;
        let (a, b, c) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
        let m = self.vertex(a, b, level, maps, made);
        self.split += usize::from((t as usize) < before);
        self.parts.note(t, corners);
        self.parts.add(t);
        self.mesh.triangles[t as usize] = [a, m, c];
        let new = self.mesh.triangles.len() as u32;
        self.mesh.triangles.push([m, b, c]);
        let material = self.mesh.materials.get(t as usize).copied();
        self.mesh.materials.extend(material);
        Some([t, new])
    }

    /// The vertex where the edge between two vertices crosses a level.
    fn vertex(&mut self, a: u32, b: u32, level: Level, maps: &Maps, made: &mut Made) -> u32 {
        let point = |v: u32| self.points[v as usize];
        // From the lower point number, so that both triangles of the edge get the same bits.
        let (a, b) = if point(a) < point(b) { (a, b) } else { (b, a) };
        let key = (a, b, level.number);
        if let Some(&known) = made.vertices.get(&key) {
            return known;
        }
        let (p, q) = (point(a), point(b));
        let (u, v) = (self.grain[p as usize].z, self.grain[q as usize].z);
        made.splits.insert((p, q), level);
        let t = (level.length - u) / (v - u);
        let vertex = push_between(&mut self.mesh, a as usize, b as usize, t);
        let position = self.mesh.positions[vertex as usize];
        let grain = &mut self.grain;
        let point = *made.points.entry((p, q, level.number)).or_insert_with(|| {
            let world = maps.transform.transform_point3(position);
            grain.push(maps.layers.to_grain_on(world, level.length));
            grain.len() as u32 - 1
        });
        self.points.push(point);
        made.vertices.insert(key, vertex);
        vertex
    }
}

impl Maps<'_> {
    /// A length, or that of the level it lies on up to rounding, m.
    fn snapped(&self, s: f64) -> f64 {
        let n = self.levels.partition_point(|&l| l < s - self.near);
        let level = self.levels.get(n).copied();
        level.filter(|l| *l <= s + self.near).unwrap_or(s)
    }
}

/// Adds a vertex at fraction `t` from one vertex to another, with their attributes.
fn push_between(mesh: &mut Mesh, i: usize, j: usize, t: f64) -> u32 {
    let position = mesh.positions[i].lerp(mesh.positions[j], t);
    mesh.positions.push(position);
    for (name, attribute) in &mut mesh.attributes {
        let first = attribute.data.len();
        for c in 0..attribute.width {
            let (x, y) = (attribute.at(i)[c], attribute.at(j)[c]);
            attribute.data.push(x + (y - x) * t as f32);
        }
        if name == "NORMAL" || name == "TANGENT" {
            let v = &mut attribute.data[first..first + 3];
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.0 {
                v.iter_mut().for_each(|x| *x /= length);
            }
            if attribute.width == 4 {
                attribute.data[first + 3] = attribute.data[i * 4 + 3];
            }
        }
    }
    mesh.positions.len() as u32 - 1
}
