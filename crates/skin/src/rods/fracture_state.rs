//! The state of fracture of a bundle: where its rods are broken, and which bonds hold which parts together (Sutherland 2012
//! §5.3). It follows from one frame alone.

use super::error::RodSkinError;
use super::wood::Wood;
use greenstick_fibre::Cause;
use greenstick_fibre::store::Frame;
use greenstick_geometry::Unions;
use std::collections::BTreeMap;

/// A break of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodBreak {
    /// Vertex of the unbroken bundle.
    pub vertex: u32,
    /// The cause.
    pub cause: Cause,
}

/// The number of a part of a rod: the number of breaks of the rod before it.
pub type RodPart = u16;

/// The state of fracture of a bundle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FractureState {
    /// Breaks of each rod of the unbroken bundle, along it.
    pub breaks: Vec<Vec<RodBreak>>,
    /// The parts that each bond of the unbroken bundle holds together: those of the rod of its vertex and of the rod of its
    /// edge. A bond at a broken vertex holds both parts.
    pub bonded_parts: Vec<[Option<(RodPart, RodPart)>; 2]>,
}

/// The piece of each part of each rod.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pieces {
    /// Number of each rod's first part; parts of all rods are numbered through.
    pub first: Vec<u32>,
    /// Piece of each part.
    pub piece: Vec<u32>,
    /// Number of pieces.
    pub count: usize,
}

impl Pieces {
    /// Returns the piece of a part of a rod.
    pub fn piece_of(&self, rod: u32, part: RodPart) -> u32 {
        self.piece[self.first[rod as usize] as usize + usize::from(part)]
    }
}

impl FractureState {
    /// Returns the state in which nothing is broken.
    pub fn unbroken(wood: &Wood) -> Self {
        FractureState {
            breaks: vec![Vec::new(); wood.bundle.rods()],
            bonded_parts: vec![[Some((0, 0)), None]; wood.bundle.bonds.len()],
        }
    }

    /// Returns the state of fracture in a frame.
    ///
    /// `causes` holds the causes by vertex of the unbroken bundle. Any other break counts as one in tension.
    ///
    /// # Errors
    /// [`RodSkinError::OtherBundle`] for a frame of another bundle.
    pub fn from_frame(
        wood: &Wood,
        frame: &Frame,
        causes: &BTreeMap<u32, Cause>,
    ) -> Result<Self, RodSkinError> {
        check(wood, frame)?;
        let mut breaks = vec![Vec::new(); wood.bundle.rods()];
        let mut part_of = Vec::with_capacity(frame.parent.len());
        for (rod, &parent) in frame.parent.iter().enumerate() {
            let rod_breaks: &mut Vec<RodBreak> = &mut breaks[parent as usize];
            let first = frame.origin[frame.rod_offsets[rod] as usize];
            if rod > 0 && frame.parent[rod - 1] == parent {
                rod_breaks.push(RodBreak {
                    vertex: first,
                    cause: causes.get(&first).copied().unwrap_or(Cause::Tension),
                });
            }
            part_of.push(rod_breaks.len() as RodPart);
        }
        let part = |vertex: u32| {
            let rod = frame.rod_offsets.partition_point(|&f| f <= vertex) - 1;
            part_of[rod]
        };
        let (bonds, rod_of) = (&wood.bundle.bonds, wood.rods_of_vertices());
        let mut bonded_parts = vec![[None; 2]; bonds.len()];
        for &[vertex, edge] in &frame.bonds {
            let (v, e) = (frame.origin[vertex as usize], frame.origin[edge as usize]);
            let own = bonds.incidence.vertex_offsets[v as usize] as usize
                ..bonds.incidence.vertex_offsets[v as usize + 1] as usize;
            // A rod that breaks between vertices may take the bond from one of its edges to the next. A vertex has one bond to
            // each rod.
            let same_rod = |&b: &usize| rod_of[bonds.edge[b] as usize] == rod_of[e as usize];
            let Some(bond) = own.clone().find(same_rod) else {
                return Err(RodSkinError::OtherBundle {
                    what: "a bond",
                    problem: format!("vertex {v} and the rod of edge {e} were never bonded"),
                });
            };
            let free = bonded_parts[bond].iter_mut().find(|h| h.is_none());
            if let Some(free) = free {
                *free = Some((part(vertex), part(edge)));
            }
        }
        Ok(FractureState {
            breaks,
            bonded_parts,
        })
    }

    /// Returns the pieces: the parts of rods that bonds hold together. They are numbered in the order of their first part.
    pub fn pieces(&self, wood: &Wood) -> Pieces {
        let mut first = vec![0];
        for breaks in &self.breaks {
            first.push(first.last().copied().unwrap_or(0) + breaks.len() as u32 + 1);
        }
        let count = first.pop().unwrap_or(0);
        let mut unions = Unions::new(count as usize);
        let rod_of = wood.rods_of_vertices();
        let bonds = &wood.bundle.bonds;
        for (bond, parts) in self.bonded_parts.iter().enumerate() {
            let [v, e] = [bonds.vertex[bond], bonds.edge[bond]].map(|v| rod_of[v as usize]);
            for (a, b) in parts.iter().flatten() {
                unions.join(
                    first[v as usize] + u32::from(*a),
                    first[e as usize] + u32::from(*b),
                );
            }
        }
        let mut piece = vec![u32::MAX; count as usize];
        let mut pieces = 0;
        for part in 0..count {
            let root = unions.root(part) as usize;
            if piece[root] == u32::MAX {
                piece[root] = pieces;
                pieces += 1;
            }
            piece[part as usize] = piece[root];
        }
        Pieces {
            first,
            piece,
            count: pieces as usize,
        }
    }

    /// Returns the number of rods that are broken at least once.
    pub fn broken_rods(&self) -> usize {
        self.breaks.iter().filter(|b| !b.is_empty()).count()
    }
}

/// Checks that a frame can be one of this bundle: its rods are parts of the bundle's rods in order, and its vertices run
/// through them.
fn check(wood: &Wood, frame: &Frame) -> Result<(), RodSkinError> {
    let wrong =
        |what: &'static str, problem: String| Err(RodSkinError::OtherBundle { what, problem });
    let bundle = wood.bundle;
    let (rods, vertices) = (bundle.rods(), bundle.vertices());
    if frame.rod_offsets.len() != frame.parent.len() + 1
        || frame.rod_offsets.first() != Some(&0)
        || frame.rod_offsets.last().map(|&l| l as usize) != Some(frame.origin.len())
        || frame
            .rod_offsets
            .windows(2)
            .any(|w| w[1] < w[0].saturating_add(2))
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
            "a position",
            format!("it is not a finite number at time {} s", frame.time),
        );
    }
    Ok(())
}
