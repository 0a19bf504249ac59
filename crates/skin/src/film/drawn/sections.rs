//! Joints along the pieces that faces cut wood into. Each follows the rods of its piece near one length of the stem; beside a face
//! those that hold have joints of their own, and pieces that reach into each other keep together.

use super::held::{HINGE, Held, held};
use super::membership::Membership;
use super::rod_faces::RodFaces;
use super::section_joints::{Interlock, SectionJoint, SectionJoints, smooth};
use super::strands::{HeldBonds, SectionParts};
use crate::remainder::Follower;
use crate::rods::{BreakHistory, Joints, RodPart, Wood};
use glam::{DVec2, DVec3};
use greenstick_geometry::Pose;
use std::ops::Range;

/// Distance between sections, mean radii of the stem.
const SECTION_DISTANCE: f64 = 0.4;
/// Length (radii) to both sides over which a joint follows the rods of a whole section, and the most, where few rods of the
/// section are of the piece: what is slender is to be smooth, whichever rods are in it from one section to the next.
const REACH: (f64, f64) = (0.3, 2.0);
/// Standard deviation (radii) of the distance over which the motions of sections are smoothed.
const SMOOTHED: f64 = 0.8;
/// Most sections along the stem.
const MAX_SECTIONS: usize = 400;
/// Least share of the stem's section that the rods of a piece must have for a joint there.
const MIN_SHARE: f64 = 0.03;
/// Length (radii) beyond the breaks of rods in a face up to which most slivers reach, and up to which the longest may.
const SLIVERS: f64 = 1.0;
const LONGEST_SLIVERS: f64 = 4.5;

/// Joints along some rods, one at each section of the stem.
#[derive(Debug, Clone, Copy)]
struct JointChain {
    /// The number of the first joint; that of each further section follows.
    first: u32,
}

/// Joints with their weights.
type Weights = Vec<(u32, f64)>;

/// The joints of a film and what they are for.
pub(super) struct Sections<'a> {
    faces: &'a RodFaces<'a>,
    /// Length along the axis of each section, m.
    along: Vec<f64>,
    /// One for each piece, from the base of the stem to its tip.
    pieces: Vec<JointChain>,
    /// One for each face: the rods that are whole there; `None` where the wood is in two.
    hinges: Vec<Option<JointChain>>,
    /// For each piece, the parts of rods that it follows.
    pub parts: Vec<Vec<(u32, RodPart)>>,
    /// All joints.
    pub joints: SectionJoints,
}

/// Makes joints.
struct Maker<'a> {
    faces: &'a RodFaces<'a>,
    joints: &'a Joints,
    rest: &'a [Pose],
    members: Membership<'a>,
    bonds: HeldBonds,
    /// Length along the axis of each section, m.
    along: Vec<f64>,
    /// Area of the stem's section, m².
    area: f64,
    /// For each face, the first frame in which a rod is broken in it.
    opening: Vec<u32>,
    /// For each follower the share of the stem's section that its rods have.
    shares: Vec<f64>,
    made: SectionJoints,
}

impl<'a> Maker<'a> {
    /// Makes a follower at every section of some parts of rods; `None` where they have too little of the section.
    fn followers(&mut self, parts: &[SectionParts]) -> Vec<Option<usize>> {
        let wood = self.faces.wood;
        let mut made = Vec::new();
        for (parts, &along) in parts.iter().zip(&self.along) {
            let share = parts.area(wood) / self.area;
            if share < MIN_SHARE {
                made.push(None);
                continue;
            }
            let reach = (REACH.0 / share).min(REACH.1) * wood.stem.radius;
            let mut followed = Vec::new();
            for &(rod, part) in &parts.0 {
                self.joints.near(rod, part, along, reach, &mut followed);
            }
            let follower = Follower::new(followed, self.rest, wood.stem.radius);
            self.made.followers.push(follower);
            self.shares.push(share);
            made.push(Some(self.made.followers.len() - 1));
        }
        made
    }

    /// Returns the parts of rods at every section, of which `part` gives the one that belongs to it at a length (m).
    fn parts(&self, part: impl Fn(usize, f64) -> Option<RodPart>) -> Vec<SectionParts> {
        let at = |&along: &f64| {
            let rods = 0..self.faces.wood.cells.len();
            let parts = rods.filter_map(|rod| Some((rod as u32, part(rod, along)?)));
            SectionParts(parts.collect())
        };
        self.along.iter().map(at).collect()
    }

    /// The sections no farther than a length (m) from the breaks in a face.
    fn sections_beside(&self, face: usize, beside: f64) -> Range<usize> {
        let (low, high) = self.faces.range(face);
        self.along.partition_point(|&a| a < low - beside)
            ..self.along.partition_point(|&a| a <= high + beside)
    }

    /// Adds a chain of joints that follow `own` at their sections, and the nearest one where it has none; and `whole` until the face
    /// beside them opens. `None` if it has none at all.
    fn chain(
        &mut self,
        name: &str,
        whole: &[Option<usize>],
        own: &[Option<usize>],
    ) -> Option<JointChain> {
        let nearest = |k: usize| {
            let present = (0..own.len()).filter(|&n| own[n].is_some());
            present.min_by_key(|n| n.abs_diff(k)).and_then(|n| own[n])
        };
        let first = self.made.joints.len() as u32;
        for (k, &along) in self.along.iter().enumerate() {
            let own = nearest(k)?;
            let whole = whole[k].unwrap_or(own);
            let face = self.faces.nearest(along);
            self.made.joints.push(SectionJoint {
                name: format!("{name}_{k:03}"),
                rest: self.made.followers[whole].at_rest(),
                whole,
                until: face.map_or(0, |face| self.opening[face]),
                own,
                about: Vec::new(),
            });
        }
        self.smooth(first, own);
        Some(JointChain { first })
    }

    /// Has the joints from `first` on, which follow `own` at their sections, move as the mean of those about them.
    fn smooth(&mut self, first: u32, own: &[Option<usize>]) {
        let width = SMOOTHED * self.faces.wood.stem.radius;
        let share = |k: usize| own[k].map_or(0.0, |follower| self.shares[follower]);
        let about = |k: usize| {
            let near = (0..self.along.len()).filter_map(|n| {
                let off = (self.along[n] - self.along[k]) / width;
                let weight = share(n) * libm::exp(-0.5 * off * off);
                (off.abs() <= 3.0 && weight > 0.0).then_some((first + n as u32, weight))
            });
            near.collect()
        };
        let all: Vec<Vec<(u32, f64)>> = (0..self.along.len()).map(about).collect();
        for (joint, about) in self.made.joints[first as usize..].iter_mut().zip(all) {
            joint.about = about;
        }
    }

    /// Adds the joints of a piece. `whole` are followers of all rods. `None` if there are no rods to follow.
    fn piece(&mut self, piece: usize, name: &str, whole: &[Option<usize>]) -> Option<JointChain> {
        let own = self.parts(|rod, along| self.members.of_piece_alone(piece, rod, along));
        let leading = (self.bonds).leading_strand(self.faces.wood, (&self.along, self.area), &own);
        let own = self.followers(&leading);
        let has_own = own.iter().any(Option::is_some);
        let own = if has_own { &own } else { whole };
        self.chain(name, whole, own)
    }

    /// Has the pieces on both sides of a face keep together sideways where they reach into each other.
    fn interlock(&mut self, face: usize, pieces: &[JointChain]) {
        let radius = self.faces.wood.stem.radius;
        let [core, all] =
            [SLIVERS, LONGEST_SLIVERS].map(|far| self.sections_beside(face, far * radius));
        if core.len() < 2 {
            return;
        }
        let (low, high) = (self.along[core.start], self.along[core.end - 1]);
        let share = |k: usize| smooth((self.along[k] - low) / (high - low));
        let interlock = Interlock {
            joints: [face, face + 1].map(|piece| pieces[piece].first + all.start as u32),
            shares: all.clone().map(share).collect(),
            along: self.direction(pieces[face], &core),
            core: core.start - all.start..core.end - all.start,
            length: high - low,
            radius,
        };
        self.made.interlocks.push(interlock);
    }

    /// The direction along the grain at rest from the first of some sections to the last.
    fn direction(&self, chain: JointChain, sections: &Range<usize>) -> DVec3 {
        let [a, b] = [sections.start, sections.end - 1].map(|k| {
            let joint = &self.made.joints[chain.first as usize + k];
            joint.rest.translation
        });
        (b - a).normalize_or(DVec3::X)
    }
}

/// Returns the lengths along the axis (m) of sections from one end of the rods to the other.
fn section_lengths(wood: &Wood) -> Vec<f64> {
    let lengths = || wood.along.iter().copied();
    let (low, high) = (
        lengths().fold(f64::INFINITY, f64::min),
        lengths().fold(f64::NEG_INFINITY, f64::max),
    );
    let wanted = ((high - low) / (SECTION_DISTANCE * wood.stem.radius)).ceil() as usize;
    let count = wanted.clamp(1, MAX_SECTIONS);
    let section = |k: usize| low + (high - low) * k as f64 / count as f64;
    (0..=count).map(section).collect()
}

impl<'a> Sections<'a> {
    /// Makes the joints of the pieces that `faces` cut the wood into, which follow `joints` of rods that rest at `rest`. `history` says
    /// in which frame of the film each rod breaks. `None` where no rod belongs to a piece.
    pub fn new(
        faces: &'a RodFaces<'a>,
        (joints, rest): (&Joints, &[Pose]),
        names: &[String],
        history: &BreakHistory,
    ) -> Option<Self> {
        let (wood, run) = (faces.wood, faces.run);
        let mut maker = Maker {
            faces,
            joints,
            rest,
            members: Membership::new(faces),
            bonds: HeldBonds::new(wood, &run.state),
            along: section_lengths(wood),
            area: wood.cells.iter().map(|c| c.area).sum(),
            opening: faces.openings(history),
            shares: Vec::new(),
            made: SectionJoints::default(),
        };
        let all = maker.parts(|rod, along| maker.members.of_any(rod, along));
        let whole = maker.followers(&all);
        let mut pieces = Vec::new();
        for (piece, name) in names.iter().enumerate() {
            pieces.push(maker.piece(piece, name, &whole)?);
        }
        let mut hinges = Vec::new();
        for (face, fracture) in faces.fractures.iter().enumerate() {
            if fracture.parted {
                hinges.push(None);
                continue;
            }
            let own = maker.parts(|rod, along| {
                let reach = HINGE.1 * wood.stem.radius;
                maker.members.of_hinge(face, rod, (along, reach))
            });
            let own = maker.followers(&own);
            hinges.push(maker.chain(&format!("hinge_{face}"), &whole, &own));
        }
        for face in 0..faces.count() {
            maker.interlock(face, &pieces);
        }
        Some(Sections {
            faces,
            hinges,
            parts: (0..pieces.len()).map(|p| maker.members.parts(p)).collect(),
            pieces,
            along: maker.along,
            joints: maker.made,
        })
    }

    /// The joints that a point of a piece follows at a length along the axis (m), with their weights, where whole rods decide `held`
    /// of its motion.
    pub fn weights(&self, piece: usize, along: f64, held: Held) -> Weights {
        let hinges = self.hinges_of(piece).into_iter().zip(held);
        let held = hinges.filter_map(|(hinge, share)| Some((hinge?.1, share)));
        let held = (held.filter(|h| h.1 > 0.0)).max_by(|a, b| a.1.total_cmp(&b.1));
        let free = held.map_or(1.0, |(_, share)| 1.0 - share);
        let mut weights = Weights::new();
        for (section, share) in self.sections_about(along) {
            if free > 0.0 {
                let own = self.pieces[piece].first + section as u32;
                weights.push((own, free * share));
            }
            if let Some((hinge, held)) = held {
                weights.push((hinge.first + section as u32, held * share));
            }
        }
        merged(weights)
    }

    /// How far whole rods decide the motion of a point of a piece at a place of the section and a length along the axis (m).
    pub fn held_at(&self, piece: usize, at: DVec2, along: f64) -> Held {
        let hinges = self.hinges_of(piece);
        [0, 1].map(|side| {
            hinges[side].map_or(0.0, |(face, _)| {
                held(self.faces, (face, side == 1), at, along)
            })
        })
    }

    /// The faces below and above a piece, if whole rods hold there, and those.
    fn hinges_of(&self, piece: usize) -> [Option<(usize, JointChain)>; 2] {
        let below = piece.checked_sub(1);
        [below, Some(piece)].map(|face| {
            let hinge = *self.hinges.get(face?)?;
            Some((face?, hinge?))
        })
    }

    /// The sections on both sides of a length along the axis (m), with their weights; beyond the ends the last one.
    fn sections_about(&self, along: f64) -> [(usize, f64); 2] {
        let above = self.along.partition_point(|&a| a <= along);
        let (a, b) = (above.saturating_sub(1), above.min(self.along.len() - 1));
        let t = match self.along[b] - self.along[a] {
            width if width > 0.0 => (along - self.along[a]) / width,
            _ => 0.0,
        };
        [(a, 1.0 - t), (b, t)]
    }
}

/// Adds up the weights of each joint, and leaves out those that have none.
fn merged(mut weights: Weights) -> Weights {
    weights.sort_by_key(|w| w.0);
    weights.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    weights.retain(|w| w.1 > 0.0);
    weights
}
