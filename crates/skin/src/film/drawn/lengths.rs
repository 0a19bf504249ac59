//! Which length of the stem every vertex of a piece belongs to. What is near the axis belongs where it is; side branches and
//! the rest of a tree belong where they grow out of what is near.

use glam::DVec3;
use greenstick_geometry::Mesh;
use greenstick_wood::stem::Stem;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// What is no farther from the axis than this many radii of the stem is part of it.
const NEAR: f64 = 1.6;

/// A distance that can be ordered, m; never NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Returns for each vertex of a mesh in the stem's world the length along the axis (m) that it belongs to.
pub(super) fn lengths_along(mesh: &Mesh, stem: &Stem) -> Vec<f64> {
    let axis = stem.grain.axis();
    let along: Vec<f64> = mesh.positions.iter().map(|&p| axis.length_at(p)).collect();
    let is_near = |v: usize| {
        let off = mesh.positions[v].distance(axis.frame(along[v]).origin);
        off <= NEAR * stem.radius * stem.grain.scale(along[v])
    };
    let near: Vec<bool> = (0..along.len()).map(is_near).collect();
    if near.iter().all(|&n| n) || !near.contains(&true) {
        return along;
    }
    spread(mesh, &along, &near)
}

/// Gives what is not near the length of the nearest vertex that is, along the edges of the mesh; what no edges lead to keeps
/// its own.
fn spread(mesh: &Mesh, along: &[f64], near: &[bool]) -> Vec<f64> {
    let group = same_place(&mesh.positions);
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); along.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| group[v as usize]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            neighbours[p as usize].push(q);
            neighbours[q as usize].push(p);
        }
    }
    let mut source: Vec<Option<u32>> = vec![None; along.len()];
    let mut queue = BinaryHeap::new();
    for v in (0..along.len()).filter(|&v| near[v]) {
        queue.push(Reverse((Distance(0.0), group[v], v as u32)));
    }
    while let Some(Reverse((Distance(far), v, from))) = queue.pop() {
        if source[v as usize].is_some() {
            continue;
        }
        source[v as usize] = Some(from);
        for &n in &neighbours[v as usize] {
            if source[n as usize].is_none() {
                let [p, q] = [v, n].map(|v| mesh.positions[v as usize]);
                queue.push(Reverse((Distance(far + p.distance(q)), n, from)));
            }
        }
    }
    let length = |v: usize| match (near[v], source[group[v] as usize]) {
        (false, Some(from)) => along[from as usize],
        _ => along[v],
    };
    (0..along.len()).map(length).collect()
}

/// For each vertex the first one at the same place.
pub(super) fn same_place(positions: &[DVec3]) -> Vec<u32> {
    let mut first: BTreeMap<[u64; 3], u32> = BTreeMap::new();
    let numbered = positions.iter().enumerate();
    let place = |(v, p): (usize, &DVec3)| {
        let key = place_key(*p);
        *first.entry(key).or_insert(v as u32)
    };
    numbered.map(place).collect()
}

/// What points have in common that are in the same place.
pub(super) fn place_key(p: DVec3) -> [u64; 3] {
    // Zero has two signs.
    p.to_array().map(|x| (x + 0.0).to_bits())
}
