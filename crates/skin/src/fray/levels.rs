//! Splitting a mesh at even heights, so that straight triangles can bend.

use glam::DVec3;
use greenstick_geometry::Mesh;
use rustc_hash::FxHashMap;

/// Part of the spacing within which a vertex counts as lying on a level.
const ON_LEVEL: f64 = 1e-5;

/// Splits every triangle at the heights that are multiples of `spacing` above 0. Edges at one position are split alike,
/// so a closed mesh stays closed.
pub(super) fn split_at_levels(mesh: &Mesh, height: &dyn Fn(DVec3) -> f64, spacing: f64) -> Mesh {
    let mut splitter = Splitter {
        levels: mesh
            .positions
            .iter()
            .map(|&p| {
                let level = height(p) / spacing;
                let whole = level.round();
                if (level - whole).abs() < ON_LEVEL {
                    whole
                } else {
                    level
                }
            })
            .collect(),
        mesh: Mesh {
            triangles: Vec::with_capacity(mesh.triangles.len()),
            materials: Vec::with_capacity(mesh.materials.len()),
            ..mesh.clone()
        },
        made: FxHashMap::default(),
    };
    let mut stack = Vec::new();
    for (t, &triangle) in mesh.triangles.iter().enumerate() {
        stack.push(triangle);
        while let Some(triangle) = stack.pop() {
            if !splitter.split(triangle, &mut stack) {
                splitter.mesh.triangles.push(triangle);
                splitter.mesh.materials.extend(mesh.materials.get(t));
            }
        }
    }
    splitter.mesh
}

struct Splitter {
    mesh: Mesh,
    /// Height of every vertex, in spacings.
    levels: Vec<f64>,
    /// Vertices made, by the ends of their edge and their level.
    made: FxHashMap<(u32, u32, u64), u32>,
}

impl Splitter {
    /// Splits a triangle at the lowest level that it crosses; false where it crosses none.
    fn split(&mut self, t: [u32; 3], stack: &mut Vec<[u32; 3]>) -> bool {
        let s = t.map(|v| self.levels[v as usize]);
        let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
        let level = (low.floor() + 1.0).max(1.0);
        if level.is_nan() || level >= high {
            return false;
        }
        if let Some(i) = (0..3).find(|&i| s[i] == level) {
            let (b, c) = (t[(i + 1) % 3], t[(i + 2) % 3]);
            let m = self.vertex(b, c, level);
            stack.extend([[t[i], m, c], [t[i], b, m]]);
            return true;
        }
        // One corner is alone on its side of the level.
        let side = |i: usize| s[i] > level;
        let alone = (0..3).find(|&i| side(i) != side((i + 1) % 3) && side(i) != side((i + 2) % 3));
        let i = alone.unwrap_or(0);
        let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
        let (m, k) = (self.vertex(a, b, level), self.vertex(a, c, level));
        stack.extend([[b, c, k], [m, b, k], [a, m, k]]);
        true
    }

    fn vertex(&mut self, a: u32, b: u32, level: f64) -> u32 {
        // From the lower end up, whichever vertices are there, so that both sides of a seam get the same position.
        let (a, b) = if self.levels[a as usize] < self.levels[b as usize] {
            (a, b)
        } else {
            (b, a)
        };
        let key = (a, b, level.to_bits());
        if let Some(&known) = self.made.get(&key) {
            return known;
        }
        let (from, to) = (self.levels[a as usize], self.levels[b as usize]);
        let t = (level - from) / (to - from);
        let made = push_vertex_between(&mut self.mesh, a, b, t);
        self.levels.push(level);
        self.made.insert(key, made);
        made
    }
}

/// Adds a vertex at fraction `t` from one vertex to another, with their attributes.
pub(crate) fn push_vertex_between(mesh: &mut Mesh, a: u32, b: u32, t: f64) -> u32 {
    let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
    mesh.positions.push(p.lerp(q, t));
    for (name, attribute) in &mut mesh.attributes {
        let mut values: Vec<f32> = (attribute.at(a as usize).iter())
            .zip(attribute.at(b as usize))
            .map(|(x, y)| x + (y - x) * t as f32)
            .collect();
        if name == "NORMAL" || name == "TANGENT" {
            let length = values.iter().take(3).map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.0 {
                values.iter_mut().take(3).for_each(|x| *x /= length);
            }
        }
        attribute.data.extend(values);
    }
    mesh.positions.len() as u32 - 1
}
