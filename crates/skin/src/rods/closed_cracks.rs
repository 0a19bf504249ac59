//! How far the two sides of a crack lie apart before it opens, where vertices have the same weights all the time: the error
//! of a film with fixed weights.

use super::joints::{Joints, frame_poses};
use glam::{DAffine3, DVec3};
use greenstick_fibre::store::Frame;

/// The greatest distance between the two sides of a crack that should still be closed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CrackOpening {
    /// Distance between the sides, m.
    pub distance: f64,
    /// Time of the frame, s.
    pub time: f64,
}

/// Pairs of vertices on the two sides of cracks that open during a film.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClosedCracks {
    /// Position of each vertex at rest, m.
    rest: Vec<DVec3>,
    /// First entry of each vertex in `weights`.
    starts: Vec<u32>,
    /// Joints and weights of all vertices.
    weights: Vec<(u32, f64)>,
    /// Pairs of vertices, and the first frame in which they are apart.
    pairs: Vec<([u32; 2], u32)>,
    /// Piece of each vertex.
    pieces: Vec<u32>,
}

impl ClosedCracks {
    /// Adds a vertex and returns its number.
    pub(super) fn add_vertex(&mut self, rest: DVec3, weights: &[(u32, f64)], piece: u32) -> u32 {
        self.starts.push(self.weights.len() as u32);
        self.weights.extend(weights);
        self.pieces.push(piece);
        self.rest.push(rest);
        self.rest.len() as u32 - 1
    }

    /// Adds a pair of vertices that coincide before frame `until`.
    pub(super) fn add_pair(&mut self, vertices: [u32; 2], until: u32) {
        self.pairs.push((vertices, until));
    }

    /// Returns the number of pairs of vertices.
    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    /// Measures the cracks that are closed in frame `number` of the film. Raises the entries of `largest`, one for each
    /// piece, where a crack is open farther than they say.
    pub fn measure(
        &self,
        joints: &Joints,
        number: u32,
        frame: &Frame,
        largest: &mut [CrackOpening],
    ) {
        if self.pairs.iter().all(|p| p.1 <= number) {
            return;
        }
        let poses = frame_poses(joints, frame);
        let both = poses.iter().zip(&joints.rest);
        let maps: Vec<DAffine3> = both.map(|(p, r)| p.affine() * r.inverse()).collect();
        let position = |v: u32| {
            let v = v as usize;
            let end = (self.starts.get(v + 1)).map_or(self.weights.len(), |&s| s as usize);
            let entries = &self.weights[self.starts[v] as usize..end];
            entries.iter().fold(DVec3::ZERO, |sum, &(j, w)| {
                sum + maps[j as usize].transform_point3(self.rest[v]) * w
            })
        };
        for &([a, b], until) in &self.pairs {
            if number >= until {
                continue;
            }
            let distance = position(a).distance(position(b));
            for v in [a, b] {
                let known = largest.get_mut(self.pieces[v as usize] as usize);
                if let Some(known) = known
                    && distance > known.distance
                {
                    *known = CrackOpening {
                        distance,
                        time: frame.time,
                    };
                }
            }
        }
    }
}
