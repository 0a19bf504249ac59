//! How far both sides of a crack lie apart before it opens, where vertices follow the same all the time: what a film with
//! fixed weights is off by.

use super::joints::{Joints, frame_poses};
use glam::{DAffine3, DVec3};
use greenstick_fibre::store::Frame;

/// A gape.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Gape {
    /// Distance of the sides, m.
    pub distance: f64,
    /// When, s.
    pub time: f64,
}

/// Places of cracks whose sides are not apart yet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gapes {
    /// Vertices of the skin there: place at rest, m, and the first entry of what they follow.
    rest: Vec<DVec3>,
    starts: Vec<u32>,
    follows: Vec<(u32, f64)>,
    /// Pairs of them, and the first frame in which they are apart.
    pairs: Vec<([u32; 2], u32)>,
    /// Piece of each.
    pieces: Vec<u32>,
}

impl Gapes {
    /// Adds a vertex.
    pub(super) fn vertex(&mut self, rest: DVec3, follows: &[(u32, f64)], piece: u32) -> u32 {
        self.starts.push(self.follows.len() as u32);
        self.follows.extend(follows);
        self.pieces.push(piece);
        self.rest.push(rest);
        self.rest.len() as u32 - 1
    }

    /// Adds a pair of vertices that are at one place before frame `until`.
    pub(super) fn pair(&mut self, of: [u32; 2], until: u32) {
        self.pairs.push((of, until));
    }

    /// How many pairs of vertices there are.
    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    /// Looks at the film's frame `number`: puts what gapes more than before into `most`, one for each piece.
    pub fn see(&self, joints: &Joints, number: u32, frame: &Frame, most: &mut [Gape]) {
        if self.pairs.iter().all(|p| p.1 <= number) {
            return;
        }
        let poses = frame_poses(joints, frame);
        let both = poses.iter().zip(&joints.rest);
        let maps: Vec<DAffine3> = both.map(|(p, r)| p.affine() * r.inverse()).collect();
        let place = |v: u32| {
            let v = v as usize;
            let end = (self.starts.get(v + 1)).map_or(self.follows.len(), |&s| s as usize);
            let entries = &self.follows[self.starts[v] as usize..end];
            entries.iter().fold(DVec3::ZERO, |sum, &(j, w)| {
                sum + maps[j as usize].transform_point3(self.rest[v]) * w
            })
        };
        for &([a, b], until) in &self.pairs {
            if number >= until {
                continue;
            }
            let distance = place(a).distance(place(b));
            for v in [a, b] {
                let known = most.get_mut(self.pieces[v as usize] as usize);
                if let Some(known) = known
                    && distance > known.distance
                {
                    *known = Gape {
                        distance,
                        time: frame.time,
                    };
                }
            }
        }
    }
}
