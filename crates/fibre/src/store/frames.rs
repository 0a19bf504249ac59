//! The frame store: see the module above for its layout.

use super::{StoreError, checksum};
use crate::bodies::BodyState;
use crate::bundle::Bundle;
use crate::state::State;
use glam::{DQuat, DVec3};
use std::io::{self, Read, Write};

const MAGIC: &[u8; 8] = b"GSFRAMES";
const VERSION: u32 = 1;
/// Longest record that is believed, bytes.
const LONGEST: u64 = 1 << 36;

/// One frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// First vertex of each rod, and the number of vertices at the end.
    pub first: Vec<u32>,
    /// Rod of the unbroken bundle.
    pub parent: Vec<u32>,
    /// Diameter of each rod, m.
    pub diameter: Vec<f32>,
    /// Vertex of the unbroken bundle.
    pub origin: Vec<u32>,
    /// Places, m.
    pub position: Vec<[f32; 3]>,
    /// Material directors of edges.
    pub director: Vec<[f32; 3]>,
    /// Vertex and edge of each bond.
    pub bonds: Vec<[u32; 2]>,
    /// Centre (m) and orientation of each body.
    pub bodies: Vec<(DVec3, DQuat)>,
}

impl Frame {
    /// The frame of a state.
    pub fn of(bundle: &Bundle, state: &State, bodies: &[BodyState]) -> Frame {
        let single = |v: DVec3| v.as_vec3().to_array();
        Frame {
            time: state.time,
            step: state.step,
            first: bundle.first.clone(),
            parent: bundle.parent.clone(),
            diameter: bundle.diameter.iter().map(|&d| d as f32).collect(),
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
            bodies: bodies.iter().map(|b| (b.centre, b.turn)).collect(),
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
        let mut whole = |v: &mut dyn Iterator<Item = u32>| {
            v.for_each(|n| to.extend(n.to_le_bytes()));
        };
        whole(&mut self.first.iter().copied());
        whole(&mut self.parent.iter().copied());
        whole(&mut self.diameter.iter().map(|d| d.to_bits()));
        whole(&mut self.origin.iter().copied());
        whole(&mut self.position.iter().flatten().map(|d| d.to_bits()));
        whole(&mut self.director.iter().flatten().map(|d| d.to_bits()));
        whole(&mut self.bonds.iter().flatten().copied());
        for (centre, turn) in &self.bodies {
            let numbers = centre.to_array().into_iter().chain(turn.to_array());
            numbers.for_each(|n| to.extend(n.to_le_bytes()));
        }
        to
    }

    /// Writes the frame as one record.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&self, to: &mut dyn Write) -> io::Result<()> {
        let content = self.content();
        let mut record = Vec::with_capacity(content.len() + 16);
        record.extend((content.len() as u64).to_le_bytes());
        record.extend(&content);
        record.extend(checksum(&content).to_le_bytes());
        to.write_all(&record)
    }

    fn parse(content: &[u8]) -> Option<Frame> {
        let mut at = content;
        let time = f64::from_le_bytes(take(&mut at)?);
        let step = u64::from_le_bytes(take(&mut at)?);
        let mut count = || Some(u32::from_le_bytes(take(&mut at)?) as usize);
        let (rods, vertices, bonds, bodies) = (count()?, count()?, count()?, count()?);
        let expected = 4 * (3 * rods + 1) + 28 * vertices + 8 * bonds + 56 * bodies;
        if at.len() != expected {
            return None;
        }
        let mut whole = |n: usize| -> Option<Vec<u32>> {
            (0..n)
                .map(|_| take(&mut at).map(u32::from_le_bytes))
                .collect()
        };
        let triples = |v: Vec<u32>| -> Vec<[f32; 3]> {
            v.chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]].map(f32::from_bits))
                .collect()
        };
        let (first, parent) = (whole(rods + 1)?, whole(rods)?);
        let diameter = whole(rods)?.into_iter().map(f32::from_bits).collect();
        let origin = whole(vertices)?;
        let (position, director) = (triples(whole(3 * vertices)?), triples(whole(3 * vertices)?));
        let bonds = whole(2 * bonds)?
            .chunks_exact(2)
            .map(|c| [c[0], c[1]])
            .collect();
        let mut number = || take(&mut at).map(f64::from_le_bytes);
        let bodies = (0..bodies)
            .map(|_| {
                let centre = DVec3::new(number()?, number()?, number()?);
                let turn = DQuat::from_xyzw(number()?, number()?, number()?, number()?);
                Some((centre, turn))
            })
            .collect::<Option<_>>()?;
        Some(Frame {
            time,
            step,
            first,
            parent,
            diameter,
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

/// Writes what a frame store begins with.
///
/// # Errors
/// Those of the writer.
pub fn write_header(to: &mut dyn Write) -> io::Result<()> {
    to.write_all(MAGIC)?;
    to.write_all(&VERSION.to_le_bytes())?;
    to.write_all(&[0; 4])
}

/// Reads frames in order. An unfinished record at the end, as a killed run leaves it, ends the frames without an error.
pub struct FrameReader<R> {
    from: R,
    number: usize,
}

impl<R: Read> FrameReader<R> {
    /// Reads what a frame store begins with.
    ///
    /// # Errors
    /// [`StoreError`] for what is no frame store, or a newer one.
    pub fn new(mut from: R) -> Result<Self, StoreError> {
        header(&mut from)?;
        Ok(FrameReader { from, number: 0 })
    }

    /// Reads on at the record of frame `number`.
    pub(super) fn at(from: R, number: usize) -> Self {
        FrameReader { from, number }
    }

    fn read(&mut self) -> Result<Option<Frame>, StoreError> {
        let mut length = [0; 8];
        if fill(&mut self.from, &mut length)? < 8 {
            return Ok(None);
        }
        let damaged = |problem: String| StoreError::Damaged {
            what: "frame store",
            problem,
        };
        let number = self.number;
        let length = u64::from_le_bytes(length);
        if length > LONGEST {
            return Err(damaged(format!("frame {number} claims {length} bytes")));
        }
        // No more memory than there are bytes.
        let mut content = Vec::new();
        let got = (&mut self.from)
            .take(length + 8)
            .read_to_end(&mut content)?;
        if (got as u64) < length + 8 {
            return Ok(None);
        }
        let sum = content.split_off(length as usize);
        if sum != checksum(&content).to_le_bytes() {
            return Err(damaged(format!("the checksum of frame {number} is wrong")));
        }
        self.number += 1;
        Frame::parse(&content)
            .map(Some)
            .ok_or_else(|| damaged(format!("frame {number} contradicts itself")))
    }
}

impl<R: Read> Iterator for FrameReader<R> {
    type Item = Result<Frame, StoreError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read().transpose()
    }
}

/// Reads what a frame store begins with; returns its length.
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

/// Reads until the buffer is full or there is no more; returns how much.
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
