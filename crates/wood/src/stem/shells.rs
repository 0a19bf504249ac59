//! Shells: the connected parts of a mesh, connected where triangles share a point.

use glam::DVec3;
use greenstick_geometry::{Mesh, Unions};

/// Points of a mesh (welded vertices) and the triangles over them.
pub(crate) struct Points {
    /// Position of each point, m.
    pub positions: Vec<DVec3>,
    /// Corners of each of the mesh's triangles as points.
    pub triangles: Vec<[u32; 3]>,
    /// How many vertices a tolerance moved, where one was used.
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

/// Points of `mesh`: vertices at bitwise equal positions, or, for a `tolerance` above 0, within it.
pub(crate) fn points(mesh: &Mesh, tolerance: f64) -> Points {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut moved = 0;
    // Open addressing with linear probing: the key is the position's bits, or the cell of the tolerance grid.
    let slots = (mesh.positions.len() * 2).next_power_of_two().max(16);
    let mut table = vec![u32::MAX; slots];
    let mut cells: Vec<[u64; 3]> = Vec::new();
    let hash = |key: &[u64; 3]| {
        let mut h = 0x9e37_79b9_7f4a_7c15_u64;
        for k in key {
            h = (h ^ k).wrapping_mul(0xff51_afd7_ed55_8ccd);
            h ^= h >> 32;
        }
        h as usize & (slots - 1)
    };
    let mut number = Vec::with_capacity(mesh.positions.len());
    for &p in &mesh.positions {
        let p = p + DVec3::ZERO;
        let key = |q: DVec3| {
            if tolerance > 0.0 {
                q.to_array().map(|c| (c / tolerance).floor().to_bits())
            } else {
                q.to_array().map(f64::to_bits)
            }
        };
        let look = |key: [u64; 3], cells: &[[u64; 3]], table: &[u32]| {
            let mut slot = hash(&key);
            while table[slot] != u32::MAX && cells[table[slot] as usize] != key {
                slot = (slot + 1) & (slots - 1);
            }
            slot
        };
        let slot = look(key(p), &cells, &table);
        let mut found = table[slot];
        if found == u32::MAX && tolerance > 0.0 {
            // A near point may lie in a neighbouring cell.
            'around: for corner in 0..27 {
                let d = [corner % 3, corner / 3 % 3, corner / 9].map(|k| f64::from(k) - 1.0);
                let near = look(key(p + DVec3::from_array(d) * tolerance), &cells, &table);
                if table[near] != u32::MAX
                    && positions[table[near] as usize].distance(p) <= tolerance
                {
                    found = table[near];
                    break 'around;
                }
            }
        }
        if found == u32::MAX {
            found = positions.len() as u32;
            table[slot] = found;
            cells.push(key(p));
            positions.push(p);
        } else if positions[found as usize] != p {
            moved += 1;
        }
        number.push(found);
    }
    let triangles = mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| number[v as usize]))
        .collect();
    Points {
        positions,
        triangles,
        moved,
    }
}

/// The shells of a mesh, in order of their first triangle. Triangles without area are left with their neighbours.
pub(crate) fn shells(node: usize, points: &Points) -> Vec<Shell> {
    let mut sets = Unions::new(points.positions.len());
    for t in &points.triangles {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    let mut number = vec![u32::MAX; points.positions.len()];
    let mut shells: Vec<Shell> = Vec::new();
    for (i, t) in points.triangles.iter().enumerate() {
        let root = sets.root(t[0]) as usize;
        if number[root] == u32::MAX {
            number[root] = shells.len() as u32;
            let (low, high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            shells.push(Shell {
                node,
                triangles: Vec::new(),
                low,
                high,
            });
        }
        let shell = &mut shells[number[root] as usize];
        shell.triangles.push(i as u32);
        for &c in t {
            let p = points.positions[c as usize];
            shell.low = shell.low.min(p);
            shell.high = shell.high.max(p);
        }
    }
    shells
}
