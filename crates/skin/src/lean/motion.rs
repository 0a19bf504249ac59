//! How the wood of a piece moves: with its splinter's lean, and about the kink of one that snapped.

use super::bend::Leans;
use super::snap::Snaps;
use glam::{DVec2, DVec3};

/// A point of the mesh.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    pub grain: DVec3,
    /// Its cell; none where it stays.
    pub cell: Option<u32>,
    /// How much of the displacement it has.
    pub share: f64,
}

/// How wood at a spot moves.
#[derive(Clone, Copy)]
pub(super) struct Moved {
    /// Grain space, m.
    pub by: DVec3,
    /// Slope of that across the section over the length along the axis.
    pub slope: DVec2,
    /// The side to which it is turned, and by what angle, rad.
    pub turn: Option<(DVec2, f64)>,
}

/// The motion of a piece.
pub(super) struct Motion {
    pub leans: Leans,
    pub snaps: Snaps,
    /// 1 for the lower piece, −1 for the upper one.
    pub sign: f64,
}

impl Motion {
    /// Returns how the wood at a spot moves; `None` where it stays.
    pub fn of(&self, spot: &Spot) -> Option<Moved> {
        let cell = spot.cell?;
        let height = self.sign * spot.grain.z;
        let at = spot.grain.truncate();
        let branch = self.leans.tree.branch_at(cell, height);
        let moved = match self.snaps.of(branch, height) {
            None => {
                let (lean, slope) = self.leans.at(cell, height);
                Moved {
                    by: (lean * spot.share).extend(0.0),
                    slope: slope * (spot.share * self.sign),
                    turn: None,
                }
            }
            Some((_, snap)) => {
                let lean = self.leans.at(cell, snap.from).0;
                let (to, up, angle) = snap.moved(at, height);
                let aside = lean * spot.share + to - at;
                Moved {
                    by: aside.extend(self.sign * (up - height)),
                    slope: DVec2::ZERO,
                    turn: Some((snap.toward, angle)),
                }
            }
        };
        let stays = moved.by == DVec3::ZERO && moved.slope == DVec2::ZERO;
        (!stays).then_some(moved)
    }

    /// Returns where a spot goes, m in grain space.
    pub fn way(&self, spot: &Spot) -> DVec3 {
        self.of(spot).map_or(DVec3::ZERO, |moved| moved.by)
    }

    /// Returns the number of the snapped splinter that a spot goes along with.
    pub fn snap_of(&self, spot: &Spot) -> Option<u32> {
        let height = self.sign * spot.grain.z;
        let branch = self.leans.tree.branch_at(spot.cell?, height);
        self.snaps.of(branch, height).map(|snap| snap.0)
    }

    /// Makes what meets in faults, each a few spots, move less. Returns whether anything does.
    pub fn calm<'a>(&mut self, faults: impl Iterator<Item = Vec<&'a Spot>>, times: usize) -> bool {
        let (mut turned, mut blamed) = (Vec::new(), Vec::new());
        for spots in faults {
            let before = turned.len();
            turned.extend(spots.iter().filter_map(|spot| self.snap_of(spot)));
            if turned.len() == before {
                let blame = |spot: &&Spot| self.leans.blame(spot.cell?, self.sign * spot.grain.z);
                blamed.extend(self.leans.thinnest(spots.iter().filter_map(blame)));
            }
        }
        for list in [&mut turned, &mut blamed] {
            list.sort_unstable();
            list.dedup();
        }
        for _ in 0..times {
            self.leans.damp(&blamed);
            turned.iter().for_each(|&number| self.snaps.lessen(number));
        }
        !(turned.is_empty() && blamed.is_empty())
    }

    /// Makes nothing move.
    pub fn stop(&mut self) {
        self.leans.straighten();
        self.snaps.straighten();
    }
}
