//! What of a bundle is broken at one time: where its rods are in parts, and which bonds hold which parts together
//! (Sutherland 2012 §5.3). Read off a frame, so that it needs no history.

use super::{RodSkinError, Wood};
use greenstick_fibre::Cause;
use greenstick_fibre::store::Frame;
use greenstick_geometry::Unions;
use std::collections::BTreeMap;

/// A place where a rod is broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodBreak {
    /// Vertex of the unbroken bundle.
    pub vertex: u32,
    /// Why it broke.
    pub cause: Cause,
}

/// A part of a rod: how many breaks of the rod lie before it.
pub type Part = u16;

/// What is broken.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parting {
    /// Breaks of each rod of the unbroken bundle, along it.
    pub breaks: Vec<Vec<RodBreak>>,
    /// For each bond of the unbroken bundle the parts that it holds together, of the rod of its vertex and of the rod of
    /// its edge. A bond at a broken vertex holds both parts.
    pub holds: Vec<[Option<(Part, Part)>; 2]>,
}

/// Which piece each part of each rod is in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pieces {
    /// Number of each rod's first part.
    pub first: Vec<u32>,
    /// Piece of each part.
    pub number: Vec<u32>,
    /// How many pieces there are.
    pub count: usize,
}

impl Pieces {
    /// The piece of a part of a rod.
    pub fn of(&self, rod: u32, part: Part) -> u32 {
        self.number[self.first[rod as usize] as usize + usize::from(part)]
    }
}

impl Parting {
    /// Nothing is broken.
    pub fn none(wood: &Wood) -> Self {
        Parting {
            breaks: vec![Vec::new(); wood.bundle.rods()],
            holds: vec![[Some((0, 0)), None]; wood.bundle.bonds.len()],
        }
    }

    /// What is broken in a frame. `causes` tells why vertices of the unbroken bundle broke; a break that it does not
    /// know is taken for one in tension.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] for a frame of another bundle.
    pub fn of(
        wood: &Wood,
        frame: &Frame,
        causes: &BTreeMap<u32, Cause>,
    ) -> Result<Self, RodSkinError> {
        check(wood, frame)?;
        let mut breaks = vec![Vec::new(); wood.bundle.rods()];
        let mut part_of = Vec::with_capacity(frame.parent.len());
        for (rod, &parent) in frame.parent.iter().enumerate() {
            let known: &mut Vec<RodBreak> = &mut breaks[parent as usize];
            let first = frame.origin[frame.rod_offsets[rod] as usize];
            if rod > 0 && frame.parent[rod - 1] == parent {
                known.push(RodBreak {
                    vertex: first,
                    cause: causes.get(&first).copied().unwrap_or(Cause::Tension),
                });
            }
            part_of.push(known.len() as Part);
        }
        let part = |vertex: u32| {
            let rod = frame.rod_offsets.partition_point(|&f| f <= vertex) - 1;
            part_of[rod]
        };
        let bonds = &wood.bundle.bonds;
        let mut holds = vec![[None; 2]; bonds.len()];
        for &[vertex, edge] in &frame.bonds {
            let (v, e) = (frame.origin[vertex as usize], frame.origin[edge as usize]);
            let own = bonds.incidence.vertex_offsets[v as usize] as usize
                ..bonds.incidence.vertex_offsets[v as usize + 1] as usize;
            let Some(bond) = own.clone().find(|&b| bonds.edge[b] == e) else {
                return Err(RodSkinError::OtherBundle {
                    what: "a bond",
                    problem: format!("vertex {v} and edge {e} were never bonded"),
                });
            };
            let place = holds[bond].iter_mut().find(|h| h.is_none());
            if let Some(place) = place {
                *place = Some((part(vertex), part(edge)));
            }
        }
        Ok(Parting { breaks, holds })
    }

    /// The pieces: parts of rods that bonds hold together, as the number of each part's piece. Parts of all rods are
    /// numbered through, rod by rod; `first` of a rod is the number of its first part. Pieces are numbered in the order
    /// of their first part.
    pub fn pieces(&self, wood: &Wood) -> Pieces {
        let mut first = vec![0];
        for breaks in &self.breaks {
            first.push(first.last().copied().unwrap_or(0) + breaks.len() as u32 + 1);
        }
        let count = first.pop().unwrap_or(0);
        let mut unions = Unions::new(count as usize);
        let rod_of = wood.rods_of_vertices();
        let bonds = &wood.bundle.bonds;
        for (bond, holds) in self.holds.iter().enumerate() {
            let [v, e] = [bonds.vertex[bond], bonds.edge[bond]].map(|v| rod_of[v as usize]);
            for (a, b) in holds.iter().flatten() {
                unions.join(
                    first[v as usize] + u32::from(*a),
                    first[e as usize] + u32::from(*b),
                );
            }
        }
        let mut number = vec![u32::MAX; count as usize];
        let mut pieces = 0;
        for part in 0..count {
            let root = unions.root(part) as usize;
            if number[root] == u32::MAX {
                number[root] = pieces;
                pieces += 1;
            }
            number[part as usize] = number[root];
        }
        Pieces {
            first,
            number,
            count: pieces as usize,
        }
    }

    /// How many rods are broken at least once.
    pub fn broken_rods(&self) -> usize {
        self.breaks.iter().filter(|b| !b.is_empty()).count()
    }
}

/// Whether a frame can be one of this bundle: rods are parts of its rods in order, and vertices run through them.
fn check(wood: &Wood, frame: &Frame) -> Result<(), RodSkinError> {
    let wrong =
        |what: &'static str, problem: String| Err(RodSkinError::OtherBundle { what, problem });
    let bundle = wood.bundle;
    let (rods, vertices) = (bundle.rods(), bundle.vertices());
    if frame.rod_offsets.len() != frame.parent.len() + 1
        || frame.rod_offsets.first() != Some(&0)
        || frame.rod_offsets.last().map(|&l| l as usize) != Some(frame.origin.len())
        || frame.rod_offsets.windows(2).any(|w| w[1] < w[0] + 2)
    {
        return wrong("the list of rods", "it does not cover the vertices".into());
    }
    let mut expected = 0;
    for (rod, ends) in frame.rod_offsets.windows(2).enumerate() {
        let parent = frame.parent[rod] as usize;
        if parent >= rods {
            return wrong("a rod", format!("it is a part of rod {parent} of {rods}"));
        }
        let origins = &frame.origin[ends[0] as usize..ends[1] as usize];
        // The next part of the same rod begins with the vertex that the last one ends with.
        let again = rod > 0 && frame.parent[rod - 1] as usize == parent;
        let start = expected - u32::from(again && expected > 0);
        let consecutive = origins.iter().zip(start..).all(|(&o, n)| o == n);
        if !consecutive || !bundle.rod(parent).contains(&(start as usize)) {
            return wrong(
                "a rod",
                format!(
                    "rod {rod} of time {} s does not follow rod {parent} of the scene",
                    frame.time
                ),
            );
        }
        expected = start + origins.len() as u32;
    }
    if expected as usize != vertices {
        return wrong(
            "the number of vertices",
            format!("the frame ends with vertex {expected}, the scene's wood has {vertices}"),
        );
    }
    let count = frame.origin.len() as u32;
    if let Some(bond) = frame.bonds.iter().flatten().find(|&&v| v >= count) {
        return wrong("a bond", format!("it names vertex {bond} of {count}"));
    }
    let numbers = frame.position.iter().chain(&frame.director).flatten();
    if numbers.clone().any(|v| !v.is_finite()) {
        return wrong(
            "a place",
            format!("it is no number at time {} s", frame.time),
        );
    }
    Ok(())
}
