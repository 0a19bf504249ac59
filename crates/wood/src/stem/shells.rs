//! Shells: the connected parts of a mesh, connected where triangles share a point.

use glam::DVec3;
use greenstick_geometry::{Cancelled, Context, Mesh, Unions};

/// Vertices or triangles between two checks for cancellation.
const CHECK_INTERVAL: usize = 1 << 16;

/// A mesh over points: vertices at one position, or within a tolerance of each other, are one point.
pub(crate) struct WeldedMesh {
    /// Position of each point, m.
    pub positions: Vec<DVec3>,
    /// Corners of each of the mesh's triangles as points.
    pub triangles: Vec<[u32; 3]>,
    /// How many vertices a tolerance moved.
    pub moved: usize,
}

/// A connected part of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct Shell {
    /// Index of the mesh.
    pub node: usize,
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
    pub low: DVec3,
    pub high: DVec3,
}

impl Shell {
    /// Diagonal of the bounding box, m.
    pub fn diagonal(&self) -> f64 {
        self.low.distance(self.high)
    }

    /// Whether the bounding boxes, widened by `by`, meet.
    pub fn meets(&self, other: &Shell, by: f64) -> bool {
        (self.low - by).cmple(other.high).all() && (other.low - by).cmple(self.high).all()
    }
}

/// A hash table of points by their positions, with open addressing and linear probing. Its key is the position's bits, or
/// the cell of a grid as wide as the tolerance.
struct PointTable {
    tolerance: f64,
    /// Points, or [`EMPTY`].
    slots: Vec<u32>,
    /// Key of each point.
    keys: Vec<[u64; 3]>,
    positions: Vec<DVec3>,
}

const EMPTY: u32 = u32::MAX;

impl PointTable {
    fn new(vertices: usize, tolerance: f64) -> Self {
        PointTable {
            tolerance,
            slots: vec![EMPTY; (vertices * 2).next_power_of_two().max(16)],
            keys: Vec::new(),
            positions: Vec::new(),
        }
    }

    fn key(&self, p: DVec3) -> [u64; 3] {
        if self.tolerance > 0.0 {
            p.to_array().map(|c| (c / self.tolerance).floor().to_bits())
        } else {
            p.to_array().map(f64::to_bits)
        }
    }

    /// The slot of a key: that of its point, or the empty one where it belongs.
    fn slot(&self, key: [u64; 3]) -> usize {
        let mut hash = 0x9e37_79b9_7f4a_7c15_u64;
        for k in key {
            hash = (hash ^ k).wrapping_mul(0xff51_afd7_ed55_8ccd);
            hash ^= hash >> 32;
        }
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        while self.slots[slot] != EMPTY && self.keys[self.slots[slot] as usize] != key {
            slot = (slot + 1) & mask;
        }
        slot
    }

    /// A point within the tolerance in a cell next to that of `p`.
    fn near_point(&self, p: DVec3) -> Option<u32> {
        (0..27).find_map(|corner| {
            let d = [corner % 3, corner / 3 % 3, corner / 9].map(|k| f64::from(k) - 1.0);
            let near = self.slot(self.key(p + DVec3::from_array(d) * self.tolerance));
            let point = self.slots[near];
            let within =
                point != EMPTY && self.positions[point as usize].distance(p) <= self.tolerance;
            within.then_some(point)
        })
    }

    /// The point of a vertex at `p`, a new one where there is none yet.
    fn insert(&mut self, p: DVec3) -> u32 {
        let key = self.key(p);
        let slot = self.slot(key);
        if self.slots[slot] != EMPTY {
            return self.slots[slot];
        }
        if self.tolerance > 0.0
            && let Some(near) = self.near_point(p)
        {
            return near;
        }
        let point = self.positions.len() as u32;
        self.slots[slot] = point;
        self.keys.push(key);
        self.positions.push(p);
        point
    }
}

impl WeldedMesh {
    /// Welds vertices at bitwise equal positions, or, for a `tolerance` (m) above 0, within it.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(mesh: &Mesh, tolerance: f64, context: &Context) -> Result<Self, Cancelled> {
        let mut table = PointTable::new(mesh.positions.len(), tolerance);
        let mut moved = 0;
        let mut points = Vec::with_capacity(mesh.positions.len());
        for chunk in mesh.positions.chunks(CHECK_INTERVAL) {
            context.check()?;
            for &p in chunk {
                // Adding 0 makes −0 a 0.
                let p = p + DVec3::ZERO;
                let point = table.insert(p);
                moved += usize::from(table.positions[point as usize] != p);
                points.push(point);
            }
        }
        context.check()?;
        let triangles = mesh
            .triangles
            .iter()
            .map(|t| t.map(|v| points[v as usize]))
            .collect();
        Ok(WeldedMesh {
            positions: table.positions,
            triangles,
            moved,
        })
    }

    /// Positions of the corners of triangle `t`, m.
    pub fn corners(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|c| self.positions[c as usize])
    }

    /// The shells of mesh `node`, in order of their first triangle. Triangles without area stay with their neighbours.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn shells(&self, node: usize, context: &Context) -> Result<Vec<Shell>, Cancelled> {
        let mut sets = Unions::new(self.positions.len());
        for chunk in self.triangles.chunks(CHECK_INTERVAL) {
            context.check()?;
            for t in chunk {
                sets.join(t[0], t[1]);
                sets.join(t[0], t[2]);
            }
        }
        let mut shell_of_root = vec![u32::MAX; self.positions.len()];
        let mut shells: Vec<Shell> = Vec::new();
        for (i, t) in self.triangles.iter().enumerate() {
            if i % CHECK_INTERVAL == 0 {
                context.check()?;
            }
            let root = sets.root(t[0]) as usize;
            if shell_of_root[root] == u32::MAX {
                shell_of_root[root] = shells.len() as u32;
                shells.push(Shell {
                    node,
                    triangles: Vec::new(),
                    low: DVec3::INFINITY,
                    high: DVec3::NEG_INFINITY,
                });
            }
            let shell = &mut shells[shell_of_root[root] as usize];
            shell.triangles.push(i as u32);
            for p in self.corners(i as u32) {
                shell.low = shell.low.min(p);
                shell.high = shell.high.max(p);
            }
        }
        Ok(shells)
    }
}
