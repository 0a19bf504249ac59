//! A frame's rods and bonds as lines with their fields, in the scene's own axes.

use super::run::Run;
use glam::DVec3;
use greenstick_fibre::store::Frame;

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
        for ends in frame.rod_offsets.windows(2) {
            let (from, to) = (ends[0] as usize, ends[1] as usize);
            for i in from..to - 1 {
                let rest = self.wood.bundle.rest_length[frame.origin[i] as usize];
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
            let vertex = frame.origin[x] as usize;
            let mut own = offsets[vertex] as usize..offsets[vertex + 1] as usize;
            let Some(bond) = own.find(|&b| bonds.edge[b] == frame.origin[y]) else {
                continue;
            };
            let end = positions[y].lerp(positions[z], bonds.t[bond]);
            stretch.push(positions[x].distance(end) / bonds.distance[bond]);
            points.extend([positions[x], end]);
        }
        BondLines { points, stretch }
    }
}

/// Returns the vertices of a frame, m.
fn positions(frame: &Frame) -> Vec<DVec3> {
    let double = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
    frame.position.iter().map(double).collect()
}
