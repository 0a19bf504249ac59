//! A frame's rods and bonds as lines with their fields, in the scene's own axes.

use super::run::Run;
use glam::DVec3;
use greenstick_fibre::store::Frame;
use std::cmp::Ordering;

/// The rods of a frame as polylines, whose points are those of the frame.
#[derive(Debug, Clone, PartialEq)]
pub struct RodLines {
    /// The vertices, m.
    pub points: Vec<DVec3>,
    /// For each line which part of its unbroken rod it is, counted from 0.
    pub parts: Vec<u32>,
    /// For each vertex the mean strain of its edges.
    pub strains: Vec<f64>,
}

/// The bonds of a frame as lines, two points each.
#[derive(Debug, Clone, PartialEq)]
pub struct BondLines {
    /// Where each bond begins and ends, m.
    pub points: Vec<DVec3>,
    /// For each bond its length over that at rest.
    pub stretch: Vec<f64>,
}

impl Run {
    /// Returns the rods of a frame as lines.
    pub fn rod_lines(&self, frame: &Frame) -> RodLines {
        let points = positions(frame);
        let mut parts = Vec::new();
        for (rod, parent) in frame.parent.iter().enumerate() {
            let same_rod = rod > 0 && frame.parent[rod - 1] == *parent;
            let before: u32 = parts.last().copied().unwrap_or(0);
            parts.push(if same_rod { before + 1 } else { 0 });
        }
        RodLines {
            strains: self.strains(frame, &points),
            points,
            parts,
        }
    }

    /// Returns the mean strain of each vertex's edges.
    fn strains(&self, frame: &Frame, points: &[DVec3]) -> Vec<f64> {
        let mut strains = vec![0.0; points.len()];
        for (rod, ends) in frame.rod_offsets.windows(2).enumerate() {
            let (from, to) = (ends[0] as usize, ends[1] as usize);
            for i in from..to - 1 {
                let own = frame.end_rest_lengths.get(rod);
                let rest = match own {
                    Some(&[first, _]) if i == from => first.into(),
                    Some(&[_, last]) if i + 2 == to => last.into(),
                    _ => self.wood.bundle.rest_length[frame.origin[i] as usize],
                };
                let strain = points[i].distance(points[i + 1]) / rest - 1.0;
                for v in [i, i + 1] {
                    let edges = if v == from || v + 1 == to { 1.0 } else { 2.0 };
                    strains[v] += strain / edges;
                }
            }
        }
        strains
    }

    /// Returns the bonds of a frame as lines.
    pub fn bond_lines(&self, frame: &Frame) -> BondLines {
        let positions = positions(frame);
        let bonds = &self.wood.bundle.bonds;
        let offsets = &bonds.incidence.vertex_offsets;
        let (mut points, mut stretch) = (Vec::new(), Vec::new());
        for &[v, e] in &frame.bonds {
            let (x, y, z) = (v as usize, e as usize, e as usize + 1);
            let (vertex, edge) = (frame.origin[x] as usize, frame.origin[y]);
            let own = offsets[vertex] as usize..offsets[vertex + 1] as usize;
            // A rod that breaks between vertices moves one along itself, and bonds beside it come to lie on the next edge.
            let near = own.filter(|&b| bonds.edge[b].abs_diff(edge) <= 1);
            let Some(bond) = near.min_by_key(|&b| bonds.edge[b].abs_diff(edge)) else {
                continue;
            };
            let part = self.part_along(bond, edge, positions[y].distance(positions[z]));
            let end = positions[y].lerp(positions[z], part);
            stretch.push(positions[x].distance(end) / bonds.distance[bond]);
            points.extend([positions[x], end]);
        }
        BondLines { points, stretch }
    }

    /// Returns how far along an edge of the unbroken bundle a bond ends, 0 to 1. The edge is `length` long now: by as much more
    /// than at rest as its first vertex was moved backwards, where the bond was on the edge before.
    fn part_along(&self, bond: usize, edge: u32, length: f64) -> f64 {
        let bundle = &self.wood.bundle;
        let (own, t) = (bundle.bonds.edge[bond], bundle.bonds.t[bond]);
        let rest = |e: u32| bundle.rest_length[e as usize];
        let along = match own.cmp(&edge) {
            Ordering::Equal => return t,
            Ordering::Less => (length - rest(edge)) - (1.0 - t) * rest(own),
            Ordering::Greater => rest(edge) + t * rest(own),
        };
        (along / length.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
    }
}

/// Returns the vertices of a frame, m.
fn positions(frame: &Frame) -> Vec<DVec3> {
    let double = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
    frame.position.iter().map(double).collect()
}
