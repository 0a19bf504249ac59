//! Frames, and how they are stored; [`super`] documents the format.

use super::checksum::checksum;
use super::error::StoreError;
use crate::bodies::BodyState;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::{DQuat, DVec3};
use std::io::{self, Read};

const MAGIC: &[u8; 8] = b"GSFRAMES";
/// Since 2, frames have the rest lengths of the edges at the ends of rods.
const VERSION: u32 = 2;
/// Longest valid record, bytes.
const MAX_RECORD_LENGTH: u64 = 1 << 36;

/// Centre and orientation of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPose {
    /// Centre, m.
    pub centre: DVec3,
    /// Orientation.
    pub rotation: DQuat,
}

/// One frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Time, s.
    pub time: f64,
    /// Steps taken.
    pub step: u64,
    /// Per rod: its first vertex, and at the end the number of vertices.
    pub rod_offsets: Vec<u32>,
    /// Per rod: its rod in the unbroken bundle.
    pub parent: Vec<u32>,
    /// Per rod: diameter, m.
    pub diameter: Vec<f32>,
    /// Per rod: lengths at rest of its first and its last edge, m, which a break between vertices changes; empty in frames
    /// stored by versions up to 0.1.
    pub end_rest_lengths: Vec<[f32; 2]>,
    /// Per vertex: its vertex in the unbroken bundle.
    pub origin: Vec<u32>,
    /// Per vertex: position, m.
    pub position: Vec<[f32; 3]>,
    /// Per edge: material director.
    pub director: Vec<[f32; 3]>,
    /// Per bond: vertex and edge.
    pub bonds: Vec<[u32; 2]>,
    /// Per body: its pose.
    pub bodies: Vec<BodyPose>,
}

impl BodyPose {
    fn of_body(body: &BodyState) -> Self {
        BodyPose {
            centre: body.centre,
            rotation: body.rotation,
        }
    }
}

impl Frame {
    /// Returns the frame of a state.
    pub fn capture(bundle: &RodBundle, state: &State, bodies: &[BodyState]) -> Frame {
        let single = |v: DVec3| v.as_vec3().to_array();
        Frame {
            time: state.time,
            step: state.step,
            rod_offsets: bundle.rod_offsets.clone(),
            parent: bundle.parent.clone(),
            diameter: bundle.diameter.iter().map(|&d| d as f32).collect(),
            end_rest_lengths: (bundle.rod_offsets.windows(2))
                .map(|ends| [ends[0], ends[1] - 2].map(|e| bundle.rest_length[e as usize] as f32))
                .collect(),
            origin: bundle.origin.clone(),
            position: state.position.iter().map(single).collect(),
            director: (0..bundle.vertices())
                .map(|j| single(state.material_director(bundle, j)))
                .collect(),
            bonds: bundle
                .bonds
                .vertex
                .iter()
                .zip(&bundle.bonds.edge)
                .map(|(&v, &e)| [v, e])
                .collect(),
            bodies: bodies.iter().map(BodyPose::of_body).collect(),
        }
    }

    fn content(&self) -> Vec<u8> {
        let mut to = Vec::new();
        to.extend(self.time.to_le_bytes());
        to.extend(self.step.to_le_bytes());
        let counts = [
            self.parent.len(),
            self.position.len(),
            self.bonds.len(),
            self.bodies.len(),
        ];
        counts
            .iter()
            .for_each(|&c| to.extend((c as u32).to_le_bytes()));
        let mut put = |v: &mut dyn Iterator<Item = u32>| {
            v.for_each(|n| to.extend(n.to_le_bytes()));
        };
        put(&mut self.rod_offsets.iter().copied());
        put(&mut self.parent.iter().copied());
        put(&mut self.diameter.iter().map(|d| d.to_bits()));
        put(&mut (self.end_rest_lengths.iter().flatten()).map(|l| l.to_bits()));
        put(&mut self.origin.iter().copied());
        put(&mut self.position.iter().flatten().map(|d| d.to_bits()));
        put(&mut self.director.iter().flatten().map(|d| d.to_bits()));
        put(&mut self.bonds.iter().flatten().copied());
        for body in &self.bodies {
            let centre = body.centre.to_array().into_iter();
            let numbers = centre.chain(body.rotation.to_array());
            numbers.for_each(|n| to.extend(n.to_le_bytes()));
        }
        to
    }

    /// Returns the frame as one record.
    pub fn to_bytes(&self) -> Vec<u8> {
        let content = self.content();
        let mut record = Vec::with_capacity(content.len() + 16);
        record.extend((content.len() as u64).to_le_bytes());
        record.extend(&content);
        record.extend(checksum(&content).to_le_bytes());
        record
    }

    fn parse(content: &[u8]) -> Option<Frame> {
        let mut at = content;
        let time = f64::from_le_bytes(take(&mut at)?);
        let step = u64::from_le_bytes(take(&mut at)?);
        let mut count = || Some(u32::from_le_bytes(take(&mut at)?) as usize);
        let (rods, vertices, bonds, bodies) = (count()?, count()?, count()?, count()?);
        let expected = 4 * (3 * rods + 1) + 28 * vertices + 8 * bonds + 56 * bodies;
        let ends = match at.len().checked_sub(expected)? {
            0 => 0,
            more if more == 8 * rods => rods,
            _ => return None,
        };
        let mut words = |n: usize| -> Option<Vec<u32>> {
            (0..n)
                .map(|_| take(&mut at).map(u32::from_le_bytes))
                .collect()
        };
        let triples = |v: Vec<u32>| -> Vec<[f32; 3]> {
            v.chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]].map(f32::from_bits))
                .collect()
        };
        let (rod_offsets, parent) = (words(rods + 1)?, words(rods)?);
        let diameter = words(rods)?.into_iter().map(f32::from_bits).collect();
        let end_rest_lengths: Vec<[f32; 2]> = (words(2 * ends)?.chunks_exact(2))
            .map(|c| [c[0], c[1]].map(f32::from_bits))
            .collect();
        let is_length = |l: &f32| l.is_finite() && *l > 0.0;
        if !end_rest_lengths.iter().flatten().all(is_length) {
            return None;
        }
        let origin = words(vertices)?;
        let (position, director) = (triples(words(3 * vertices)?), triples(words(3 * vertices)?));
        let bonds = words(2 * bonds)?
            .chunks_exact(2)
            .map(|c| [c[0], c[1]])
            .collect();
        let mut number = || take(&mut at).map(f64::from_le_bytes);
        let bodies = (0..bodies)
            .map(|_| {
                let centre = DVec3::new(number()?, number()?, number()?);
                let rotation = DQuat::from_xyzw(number()?, number()?, number()?, number()?);
                Some(BodyPose { centre, rotation })
            })
            .collect::<Option<_>>()?;
        Some(Frame {
            time,
            step,
            rod_offsets,
            parent,
            diameter,
            end_rest_lengths,
            origin,
            position,
            director,
            bonds,
            bodies,
        })
    }
}

fn take<const N: usize>(at: &mut &[u8]) -> Option<[u8; N]> {
    let (head, rest) = at.split_first_chunk::<N>()?;
    *at = rest;
    Some(*head)
}

/// Returns the header of a frame store.
pub(super) fn frame_header() -> Vec<u8> {
    [&MAGIC[..], &VERSION.to_le_bytes(), &[0; 4]].concat()
}

/// Reads frame `number` where its record begins. Returns `None` at the end, and for an incomplete record, as a killed run
/// leaves it.
pub(super) fn read_frame(from: &mut impl Read, number: usize) -> Result<Option<Frame>, StoreError> {
    let mut length = [0; 8];
    if fill(from, &mut length)? < 8 {
        return Ok(None);
    }
    let damaged = |problem: String| StoreError::Damaged {
        what: "frame store",
        problem,
    };
    let length = u64::from_le_bytes(length);
    if length > MAX_RECORD_LENGTH {
        return Err(damaged(format!("frame {number} claims {length} bytes")));
    }
    // Takes no more memory than there are bytes.
    let mut content = Vec::new();
    let got = from.take(length + 8).read_to_end(&mut content)?;
    if (got as u64) < length + 8 {
        return Ok(None);
    }
    let sum = content.split_off(length as usize);
    if sum != checksum(&content).to_le_bytes() {
        return Err(damaged(format!("the checksum of frame {number} is wrong")));
    }
    Frame::parse(&content)
        .map(Some)
        .ok_or_else(|| damaged(format!("frame {number} contradicts itself")))
}

/// Reads the header of a frame store. Returns its length.
pub(super) fn header(from: &mut impl Read) -> Result<u64, StoreError> {
    let mut head = [0; 16];
    let got = fill(from, &mut head)?;
    if got < 16 || &head[..8] != MAGIC {
        return Err(StoreError::Foreign {
            expected: "frames of a simulation",
            found: String::from_utf8_lossy(&head[..got.min(8)]).into_owned(),
        });
    }
    let version = u32::from_le_bytes([head[8], head[9], head[10], head[11]]);
    if version > VERSION {
        return Err(StoreError::Newer {
            what: "frame store",
            found: version,
            known: VERSION,
        });
    }
    Ok(head.len() as u64)
}

/// Reads until the buffer is full or the source ends. Returns the number of bytes read.
pub(super) fn fill(from: &mut impl Read, to: &mut [u8]) -> io::Result<usize> {
    let mut got = 0;
    while got < to.len() {
        match from.read(&mut to[got..]) {
            Ok(0) => break,
            Ok(n) => got += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(got)
}
