//! OBJ numbers positions, texture coordinates and normals apart; a mesh has one number for all three.

use std::collections::HashMap;

/// "None" among the numbers of a corner.
pub const ABSENT: u32 = u32::MAX;

/// Numbers of position, texture coordinate and normal, from 0, or [`ABSENT`].
pub type Corner = [u32; 3];

/// Gives every distinct corner a vertex number.
pub struct Unifier {
    /// For each position: the group that saw it last, its first corner there, and that corner's number.
    first: Vec<(u32, Corner, u32)>,
    group: u32,
}

impl Unifier {
    pub fn new(positions: usize) -> Self {
        Unifier {
            first: vec![(0, [ABSENT; 3], 0); positions],
            group: 0,
        }
    }

    /// The distinct corners, ordered by position and then by first appearance, and each corner as a number into them.
    pub fn unify(&mut self, corners: &[Corner]) -> (Vec<Corner>, Vec<u32>) {
        self.group += 1;
        let mut distinct: Vec<Corner> = Vec::new();
        let mut others: HashMap<Corner, u32> = HashMap::new();
        let mut numbers = Vec::with_capacity(corners.len());
        for &corner in corners {
            let next = distinct.len() as u32;
            let slot = &mut self.first[corner[0] as usize];
            let number = if slot.0 != self.group {
                *slot = (self.group, corner, next);
                next
            } else if slot.1 == corner {
                slot.2
            } else {
                *others.entry(corner).or_insert(next)
            };
            if number == next {
                distinct.push(corner);
            }
            numbers.push(number);
        }
        // Back to the order of the file's own positions, so that reading does not shuffle the vertices.
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
