//! Vertices for corners: OBJ numbers positions, texture coordinates and normals separately, a mesh has one index for all
//! three.

use std::collections::HashMap;

/// "None" among the indices of a corner.
pub(super) const ABSENT: u32 = u32::MAX;

/// Indices of position, texture coordinate and normal, or [`ABSENT`].
pub(super) type Corner = [u32; 3];

/// Assigns a vertex to each distinct corner.
pub(super) struct Unifier {
    /// For each position its first corner in the group that used it last.
    first: Vec<FirstCorner>,
    /// The current group, counted from 1.
    group: u32,
}

/// The first corner at a position.
#[derive(Clone, Copy)]
struct FirstCorner {
    group: u32,
    corner: Corner,
    vertex: u32,
}

impl Unifier {
    /// Starts with a number of positions.
    pub fn new(positions: usize) -> Self {
        Unifier {
            first: vec![
                FirstCorner {
                    group: 0,
                    corner: [ABSENT; 3],
                    vertex: 0,
                };
                positions
            ],
            group: 0,
        }
    }

    /// Returns the distinct corners of a group, ordered by position and then by first appearance, and the index of each
    /// corner among them.
    pub fn unify(&mut self, corners: &[Corner]) -> (Vec<Corner>, Vec<u32>) {
        self.group += 1;
        let mut distinct: Vec<Corner> = Vec::new();
        let mut others: HashMap<Corner, u32> = HashMap::new();
        let mut numbers = Vec::with_capacity(corners.len());
        for &corner in corners {
            let next = distinct.len() as u32;
            let slot = &mut self.first[corner[0] as usize];
            let number = if slot.group != self.group {
                *slot = FirstCorner {
                    group: self.group,
                    corner,
                    vertex: next,
                };
                next
            } else if slot.corner == corner {
                slot.vertex
            } else {
                *others.entry(corner).or_insert(next)
            };
            if number == next {
                distinct.push(corner);
            }
            numbers.push(number);
        }
        // The order of positions in the file is restored, so that reading does not shuffle vertices.
        let mut order: Vec<u32> = (0..distinct.len() as u32).collect();
        order.sort_by_key(|&i| distinct[i as usize][0]);
        let mut rank = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            rank[old as usize] = new as u32;
        }
        numbers.iter_mut().for_each(|n| *n = rank[*n as usize]);
        (
            order.into_iter().map(|i| distinct[i as usize]).collect(),
            numbers,
        )
    }
}
