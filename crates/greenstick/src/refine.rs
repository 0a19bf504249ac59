//! Parting the skin of a bent stem at the levels of its grain.
//!
//! Between two levels grain space is affine ([`LayeredGrain`]), so triangles that cross none are the same straight
//! triangles there and in the world: what is cut in one is cut in the other.

use glam::{DAffine3, DVec3};
use greenstick_geometry::Mesh;
use greenstick_wood::stem::LayeredGrain;
use rustc_hash::FxHashMap;

/// A mesh whose triangles were parted; only vertices and triangles at the end of the lists are new.
pub(crate) struct Refined {
    pub mesh: Mesh,
    /// Point of every vertex.
    pub points: Vec<u32>,
    /// Grain coordinates of every point.
    pub grain: Vec<DVec3>,
    /// Limb triangles, those parted replaced by their parts.
    pub limb: Vec<u32>,
    /// How many triangles were parted.
    pub parted: usize,
}

/// Points and vertices made on edges, by the edge's ends and the level.
#[derive(Default)]
struct Made {
    points: FxHashMap<(u32, u32, u32), u32>,
    vertices: FxHashMap<(u32, u32, u32), u32>,
    /// The level (number and length, m) at which the edge between two points was parted.
    parted: FxHashMap<(u32, u32), (u32, f64)>,
}

/// Part of the stem's radius within which a vertex counts as lying on a level: more would bend straight edges.
const NEAR: f64 = 1e-9;

impl Refined {
    /// Parts the limb's triangles at every level. `transform` leads from the mesh to the world.
    /// Triangles of `shell` beside the limb are parted along with it, so that edges stay whole. Returns the new ones.
    pub(crate) fn part(
        &mut self,
        layers: &LayeredGrain,
        transform: &DAffine3,
        (shell, radius): (&[u32], f64),
    ) -> Vec<u32> {
        let levels: Vec<f64> = layers.levels().collect();
        let first_new = self.mesh.triangles.len() as u32;
        if levels.is_empty() {
            return Vec::new();
        }
        let mut beside = vec![true; self.mesh.triangles.len()];
        self.limb.iter().for_each(|&t| beside[t as usize] = false);
        let near = NEAR * radius;
        let mut made = Made::default();
        let mut stack: Vec<u32> = std::mem::take(&mut self.limb);
        let before = self.mesh.triangles.len();
        stack.reverse();
        while let Some(t) = stack.pop() {
            let corners = self.mesh.triangles[t as usize];
            // A vertex on a level but for rounding counts as on it.
            let s = corners.map(|v| {
                let s = self.grain[self.points[v as usize] as usize].z;
                let n = levels.partition_point(|&l| l < s - near);
                levels
                    .get(n)
                    .copied()
                    .filter(|l| *l <= s + near)
                    .unwrap_or(s)
            });
            let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
            let n = levels.partition_point(|&l| l <= low);
            if n >= levels.len() || levels[n] >= high {
                self.limb.push(t);
                continue;
            }
            self.parted += usize::from((t as usize) < before);
            let level = levels[n];
            let mut cut = |mesh: &mut Self, a: usize, b: usize| {
                mesh.vertex(
                    corners[a],
                    corners[b],
                    (n as u32, level),
                    (layers, transform),
                    &mut made,
                )
            };
            // Turned so that the first corner is alone on its side of the level, or lies on it.
            let below = |i: usize| s[i] < level;
            let above = |i: usize| s[i] > level;
            let parts: Vec<[u32; 3]> = if let Some(i) = (0..3).find(|&i| s[i] == level) {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let m = cut(self, j, k);
                vec![[corners[i], corners[j], m], [corners[i], m, corners[k]]]
            } else {
                let alone = (0..3).find(|&i| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    (below(i) && above(j) && above(k)) || (above(i) && below(j) && below(k))
                });
                let i = alone.unwrap_or(0);
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let (m, n) = (cut(self, i, j), cut(self, i, k));
                let (b, c) = (corners[j], corners[k]);
                let at = |v: u32| self.mesh.positions[v as usize];
                if at(m).distance_squared(at(c)) < at(b).distance_squared(at(n)) {
                    vec![[corners[i], m, n], [m, b, c], [m, c, n]]
                } else {
                    vec![[corners[i], m, n], [m, b, n], [b, c, n]]
                }
            };
            let material = self.mesh.materials.get(t as usize).copied();
            for (i, part) in parts.into_iter().enumerate() {
                if i == 0 {
                    self.mesh.triangles[t as usize] = part;
                    stack.push(t);
                } else {
                    stack.push(self.mesh.triangles.len() as u32);
                    self.mesh.triangles.push(part);
                    self.mesh.materials.extend(material);
                }
            }
        }
        self.limb.sort_unstable();
        let mut stack: Vec<u32> = shell
            .iter()
            .copied()
            .filter(|&t| beside[t as usize])
            .collect();
        while let Some(t) = stack.pop() {
            let corners = self.mesh.triangles[t as usize];
            let point = |i: usize| self.points[corners[i % 3] as usize];
            let found = (0..3).find_map(|i| {
                let (p, q) = (point(i), point(i + 1));
                made.parted
                    .get(&(p.min(q), p.max(q)))
                    .map(|&level| (i, level))
            });
            let Some((i, level)) = found else { continue };
            let (a, b, c) = (corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
            let m = self.vertex(a, b, level, (layers, transform), &mut made);
            self.parted += usize::from((t as usize) < before);
            self.mesh.triangles[t as usize] = [a, m, c];
            stack.extend([t, self.mesh.triangles.len() as u32]);
            self.mesh.triangles.push([m, b, c]);
            let material = self.mesh.materials.get(t as usize).copied();
            self.mesh.materials.extend(material);
        }
        (first_new..self.mesh.triangles.len() as u32).collect()
    }

    /// The vertex where the edge between two vertices crosses a level (number and length, m).
    fn vertex(
        &mut self,
        a: u32,
        b: u32,
        (number, level): (u32, f64),
        (layers, transform): (&LayeredGrain, &DAffine3),
        made: &mut Made,
    ) -> u32 {
        let point = |v: u32| self.points[v as usize];
        // From the lower point number on, so that both triangles of the edge get the same bits.
        let (a, b) = if point(a) < point(b) { (a, b) } else { (b, a) };
        if let Some(&known) = made.vertices.get(&(a, b, number)) {
            return known;
        }
        let (p, q) = (point(a), point(b));
        let (u, v) = (self.grain[p as usize].z, self.grain[q as usize].z);
        made.parted.insert((p, q), (number, level));
        let t = (level - u) / (v - u);
        let (i, j) = (a as usize, b as usize);
        let position = self.mesh.positions[i].lerp(self.mesh.positions[j], t);
        let grain = &mut self.grain;
        let point = *made.points.entry((p, q, number)).or_insert_with(|| {
            grain.push(layers.to_grain_on(transform.transform_point3(position), level));
            grain.len() as u32 - 1
        });
        self.mesh.positions.push(position);
        self.points.push(point);
        for (name, attribute) in &mut self.mesh.attributes {
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
        let vertex = self.mesh.positions.len() as u32 - 1;
        made.vertices.insert((a, b, number), vertex);
        vertex
    }
}
