//! Which piece each part of a rod belongs to.

use super::rod_faces::RodFaces;
use crate::rods::{Pieces, RodPart};
use crate::simulated::main_pieces;

/// Which piece each part of a rod belongs to.
pub(super) struct Membership<'a> {
    faces: &'a RodFaces<'a>,
    pieces: Pieces,
    /// The pieces of the run that the stem consists of, from its base to its tip.
    main: Vec<u32>,
}

impl<'a> Membership<'a> {
    pub fn new(faces: &'a RodFaces<'a>) -> Self {
        let pieces = faces.run.state.pieces(faces.wood);
        Membership {
            faces,
            main: main_pieces(faces.wood, faces.run, &pieces),
            pieces,
        }
    }

    /// Whether a part of a rod is of the wood that a piece was cut from, and no splinter. Of what hangs together several
    /// pieces may be cut.
    fn belongs(&self, rod: usize, part: RodPart, piece: usize) -> bool {
        let own = self.pieces.piece_of(rod as u32, part);
        let before = self.faces.fractures[..piece].iter();
        let number = before.filter(|f| f.parted).count();
        self.main.is_empty() || self.main.get(number) == Some(&own)
    }

    /// The part of a rod at a length along the axis (m), if it is of any piece.
    pub fn of_any(&self, rod: usize, along: f64) -> Option<RodPart> {
        let part = self.faces.run.part_at(rod, along);
        let mut pieces = 0..=self.faces.count();
        pieces
            .any(|piece| self.belongs(rod, part, piece))
            .then_some(part)
    }

    /// The same, if it is of this piece and between its faces, and no rod that holds both sides of one of them together there.
    pub fn of_piece_alone(&self, piece: usize, rod: usize, along: f64) -> Option<RodPart> {
        let beside = piece.saturating_sub(1)..(piece + 1).min(self.faces.count());
        let mut hinges = beside.filter(|&face| !self.faces.fractures[face].parted);
        let holds = |face: usize| self.of_hinge(face, rod, (along, 0.0)).is_some();
        let part = self.of_piece(piece, rod, along)?;
        (!hinges.any(holds)).then_some(part)
    }

    /// The same, if it is of this piece and between its faces.
    fn of_piece(&self, piece: usize, rod: usize, along: f64) -> Option<RodPart> {
        let faces = self.faces;
        let part = faces.run.part_at(rod, along);
        let beyond = piece == 0 || faces.length(piece - 1, rod) <= along;
        let before = piece == faces.count() || along <= faces.length(piece, rod);
        (beyond && before && self.belongs(rod, part, piece)).then_some(part)
    }

    /// The same, if the rod is whole in this face and no farther than `reach` (m) from where others broke in it.
    pub fn of_hinge(&self, face: usize, rod: usize, (along, reach): (f64, f64)) -> Option<RodPart> {
        let faces = self.faces;
        let part = faces.run.part_at(rod, along);
        let (low, high) = faces.range(face);
        let near = low - reach <= along && along <= high + reach;
        let holds = near && faces.part_before(face, rod).is_none();
        (holds && self.belongs(rod, part, face)).then_some(part)
    }

    /// All parts of rods that belong to a piece.
    pub fn parts(&self, piece: usize) -> Vec<(u32, RodPart)> {
        let mut parts = Vec::new();
        for (rod, breaks) in self.faces.run.state.breaks.iter().enumerate() {
            let all = 0..=breaks.len() as RodPart;
            let own = all.filter(|&part| self.belongs(rod, part, piece));
            parts.extend(own.map(|part| (rod as u32, part)));
        }
        parts
    }
}
