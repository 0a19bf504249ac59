//! Triangles of a piece that cross when it is bent.

use super::motion::Spot;
use glam::DVec3;
use greenstick_geometry::repair::crossing_pairs;
use greenstick_geometry::{Aabb, Cancelled, Context, Mesh};

/// The triangles of a piece that may cross when splinters lean, and the pairs that do.
pub(super) struct Crossings {
    triangles: Vec<[u32; 3]>,
    /// Whether each can move.
    moves: Vec<bool>,
    /// Pairs of numbers in `triangles` that cross.
    pub pairs: Vec<[u32; 2]>,
}

impl Crossings {
    /// Finds them for vertices at `bent`.
    pub fn new(
        mesh: &Mesh,
        spots: &[Spot],
        bent: &[DVec3],
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let can_move = |t: &[u32; 3]| t.iter().any(|&v| spots[v as usize].cell.is_some());
        let around = |t: &[u32; 3]| {
            let straight = Aabb::around(&t.map(|v| mesh.positions[v as usize]));
            straight.join(&Aabb::around(&t.map(|v| bent[v as usize])))
        };
        let moving = mesh.triangles.iter().filter(|t| can_move(t));
        let reach = moving.fold(Aabb::EMPTY, |reach, t| reach.join(&around(t)));
        let near: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&t| around(&mesh.triangles[t as usize]).overlaps(&reach))
            .collect();
        let triangles: Vec<[u32; 3]> = near.iter().map(|&t| mesh.triangles[t as usize]).collect();
        let mut found = Crossings {
            moves: triangles.iter().map(can_move).collect(),
            pairs: crossing_pairs(bent, &triangles, None, context)?,
            triangles,
        };
        found.leave_out_faults_of_the_input();
        Ok(found)
    }

    fn leave_out_faults_of_the_input(&mut self) {
        let moves = &self.moves;
        self.pairs.retain(|p| p.iter().any(|&t| moves[t as usize]));
    }

    /// Brings the pairs up to date after vertices have moved from the first positions to the second.
    pub fn update(
        &mut self,
        before: &[DVec3],
        bent: &[DVec3],
        context: &Context,
    ) -> Result<(), Cancelled> {
        let moved = |t: &[u32; 3]| t.iter().any(|&v| bent[v as usize] != before[v as usize]);
        let changed: Vec<u32> = (self.triangles.iter().zip(0..))
            .filter_map(|(t, number)| moved(t).then_some(number))
            .collect();
        let kept = |p: &[u32; 2]| p.iter().all(|t| changed.binary_search(t).is_err());
        self.pairs.retain(kept);
        let found = crossing_pairs(bent, &self.triangles, Some(&changed), context)?;
        self.pairs.extend(found);
        self.pairs.sort_unstable();
        self.pairs.dedup();
        self.leave_out_faults_of_the_input();
        Ok(())
    }

    /// The vertices of each pair of triangles that cross.
    pub fn vertices(&self) -> impl Iterator<Item = [u32; 6]> + '_ {
        let of = |t: u32| self.triangles[t as usize];
        self.pairs.iter().map(move |&[t, u]| {
            let ([a, b, c], [d, e, f]) = (of(t), of(u));
            [a, b, c, d, e, f]
        })
    }
}
