//! Making the skin of a bent stem fine enough where it is to be cut.
//!
//! A straight edge of the mesh is a curve in grain space. The cut takes it for straight there too, so long edges of a
//! bent stem are halved until the difference is small.

use glam::DVec3;
use greenstick_geometry::Mesh;
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
    /// Length (m) of edges that are straight enough in any case.
    pub short: f64,
}

/// Most rounds of halving: an edge becomes 2⁸ parts at most.
const ROUNDS: usize = 8;

impl Refined {
    /// Halves edges of limb triangles whose middle in the world, brought to grain space by `to_grain`, is farther than
    /// `tolerance` (m) from the middle in grain space. `radius` is that of the stem, m.
    pub(crate) fn refine(
        &mut self,
        tolerance: f64,
        radius: f64,
        to_grain: &dyn Fn(&Mesh, DVec3, f64) -> DVec3,
    ) {
        // No stem bends tighter than by its own radius r, so an edge of length l sags by less than l² / 8r; the
        // eightfold allows for what grain space stretches on the inner side of a bend.
        self.short = (tolerance * radius).sqrt();
        for _ in 0..ROUNDS {
            if !self.round(tolerance, to_grain) {
                return;
            }
        }
    }

    fn round(&mut self, tolerance: f64, to_grain: &dyn Fn(&Mesh, DVec3, f64) -> DVec3) -> bool {
        // For each edge of points the new point, or none where it is straight enough.
        let mut halves: FxHashMap<(u32, u32), Option<u32>> = FxHashMap::default();
        let mut vertices: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        let mut limb = Vec::with_capacity(self.limb.len());
        let mut any = false;
        for t in std::mem::take(&mut self.limb) {
            let corners = self.mesh.triangles[t as usize];
            let middles: [Option<u32>; 3] = [0, 1, 2].map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let (p, q) = (self.points[a as usize], self.points[b as usize]);
                if self.grain[p as usize].distance(self.grain[q as usize]) <= self.short {
                    return None;
                }
                let key = (p.min(q), p.max(q));
                let half = match halves.get(&key) {
                    Some(half) => *half,
                    None => {
                        let half = self.half(a, b, tolerance, to_grain);
                        halves.insert(key, half);
                        half
                    }
                }?;
                let key = (a.min(b), a.max(b));
                Some(
                    *vertices
                        .entry(key)
                        .or_insert_with(|| self.vertex(key.0, key.1, half)),
                )
            });
            if middles.iter().all(Option::is_none) {
                limb.push(t);
                continue;
            }
            any = true;
            self.parted += 1;
            let parts = part(corners, middles);
            let material = self.mesh.materials.get(t as usize).copied();
            for (i, part) in parts.into_iter().enumerate() {
                if i == 0 {
                    self.mesh.triangles[t as usize] = part;
                    limb.push(t);
                } else {
                    limb.push(self.mesh.triangles.len() as u32);
                    self.mesh.triangles.push(part);
                    self.mesh.materials.extend(material);
                }
            }
        }
        self.limb = limb;
        any
    }

    fn half(
        &mut self,
        a: u32,
        b: u32,
        tolerance: f64,
        to_grain: &dyn Fn(&Mesh, DVec3, f64) -> DVec3,
    ) -> Option<u32> {
        let (p, q) = (self.points[a as usize], self.points[b as usize]);
        let (gp, gq) = (self.grain[p as usize], self.grain[q as usize]);
        let middle = (self.mesh.positions[a as usize] + self.mesh.positions[b as usize]) / 2.0;
        let expected = (gp + gq) / 2.0;
        let is = to_grain(&self.mesh, middle, expected.z);
        if is.distance(expected) <= tolerance {
            return None;
        }
        self.grain.push(is);
        Some(self.grain.len() as u32 - 1)
    }

    /// A vertex halfway between two, at `point`.
    fn vertex(&mut self, a: u32, b: u32, point: u32) -> u32 {
        let (a, b) = (a as usize, b as usize);
        self.mesh
            .positions
            .push((self.mesh.positions[a] + self.mesh.positions[b]) / 2.0);
        self.points.push(point);
        for (name, attribute) in &mut self.mesh.attributes {
            let first = attribute.data.len();
            for c in 0..attribute.width {
                let mean = (attribute.at(a)[c] + attribute.at(b)[c]) / 2.0;
                attribute.data.push(mean);
            }
            if name == "NORMAL" || name == "TANGENT" {
                let v = &mut attribute.data[first..first + 3];
                let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
                if length > 0.0 {
                    v.iter_mut().for_each(|x| *x /= length);
                }
                if attribute.width == 4 {
                    attribute.data[first + 3] = attribute.data[a * 4 + 3];
                }
            }
        }
        self.mesh.positions.len() as u32 - 1
    }
}

/// The parts of a triangle some of whose sides have a vertex in their middle.
fn part(c: [u32; 3], middles: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    let turned = |k: usize| [c[k], c[(k + 1) % 3], c[(k + 2) % 3]];
    match middles {
        [Some(x), Some(y), Some(z)] => {
            vec![[c[0], x, z], [x, c[1], y], [z, y, c[2]], [x, y, z]]
        }
        _ => {
            let count = middles.iter().flatten().count();
            for k in 0..3 {
                let [a, b, d] = turned(k);
                match [middles[k], middles[(k + 1) % 3], middles[(k + 2) % 3]] {
                    [Some(x), None, None] if count == 1 => return vec![[a, x, d], [x, b, d]],
                    [Some(x), Some(y), None] => return vec![[a, x, y], [x, b, y], [a, y, d]],
                    _ => {}
                }
            }
            vec![c]
        }
    }
}
