//! Joints along the pieces that faces cut wood into. Each follows the rods of its piece near one length of the stem.

use super::strands::{HeldBonds, SectionParts};
use crate::remainder::Follower;
use crate::rods::{BreakHistory, Joints, Pieces, RodPart, Wood};
use crate::simulated::{ObservedRun, SimulatedFracture, main_pieces};
use glam::{DAffine3, DQuat};
use greenstick_geometry::{Joint, Pose};

/// Distance between sections, mean radii of the stem.
const SECTION_DISTANCE: f64 = 0.4;
/// Length (radii) to both sides over which a joint follows the rods of a whole section, and the most, where few rods of the
/// section are of the piece: what is slender is to be smooth, whichever rods are in it from one section to the next.
const REACH: (f64, f64) = (0.3, 2.0);
/// Most sections along the stem.
const MAX_SECTIONS: usize = 400;
/// Least share of the stem's section that the rods of a piece must have for a joint there.
const MIN_SHARE: f64 = 0.03;
/// Distance (radii) from a face up to which the wood that holds there keeps both sides together, and that from which on each
/// side follows its own rods.
const HINGE: (f64, f64) = (1.0, 3.0);
/// The same beyond the face, among what was split off.
const BEYOND: (f64, f64) = (0.4, 0.9);

/// Joints along some rods, one at each section of the stem.
#[derive(Debug, Clone, Default)]
pub(super) struct JointChain {
    /// Length along the axis of each section, m.
    along: Vec<f64>,
    /// The number of the first joint; that of each further section follows.
    first: u32,
}

/// What a joint follows.
#[derive(Debug, Clone)]
struct SectionJoint {
    name: String,
    /// Where it is at rest.
    rest: Pose,
    /// The follower of all rods of the section, before the face beside it begins to open.
    whole: usize,
    /// The first frame in which that has begun.
    until: u32,
    /// The follower of the rods of its own.
    own: usize,
}

/// Joints along the pieces of a film.
///
/// Until the first rod breaks in a face, the joints on both sides follow all rods: both sides then coincide exactly, in every
/// format.
#[derive(Debug, Clone, Default)]
pub(in crate::film) struct SectionJoints {
    followers: Vec<Follower>,
    joints: Vec<SectionJoint>,
}

impl SectionJoints {
    /// The joints of a film.
    pub fn film_joints(&self) -> impl Iterator<Item = Joint> + '_ {
        self.joints.iter().map(|joint| Joint {
            name: joint.name.clone(),
            rest: joint.rest,
        })
    }

    /// Returns the poses of the joints in a frame of the film in which the joints of the rods have the poses `rods`.
    pub fn poses(&self, frame: usize, rods: &[Pose]) -> impl Iterator<Item = Pose> + '_ {
        let follow = |f: &Follower| f.pose(rods).affine() * f.at_rest().inverse();
        let maps: Vec<DAffine3> = self.followers.iter().map(follow).collect();
        self.joints.iter().map(move |joint| {
            let follower = if frame < joint.until as usize {
                joint.whole
            } else {
                joint.own
            };
            let map = maps[follower];
            Pose {
                translation: map.transform_point3(joint.rest.translation),
                rotation: (DQuat::from_mat3(&map.matrix3) * joint.rest.rotation).normalize(),
            }
        })
    }
}

/// The joints of a film and what they are for.
#[derive(Debug, Clone, Default)]
pub(super) struct Sections {
    /// One for each piece, from the base of the stem to its tip.
    pub pieces: Vec<JointChain>,
    /// One for each face: the rods that are whole there; `None` where the wood is in two.
    pub hinges: Vec<Option<JointChain>>,
    /// For each piece, the parts of rods that it follows.
    pub parts: Vec<Vec<(u32, RodPart)>>,
    /// The joints of all chains.
    pub joints: SectionJoints,
}

/// The faces of the wood, as rods meet them.
pub(super) struct RodFaces<'a> {
    wood: &'a Wood<'a>,
    run: &'a ObservedRun,
    fractures: &'a [SimulatedFracture],
    /// For each face and rod, the length along the axis at which the rod passes it, m.
    lengths: Vec<Vec<f64>>,
    /// For each face and rod, the part of the rod before its break there; `None` where it is whole.
    parts_before: Vec<Vec<Option<RodPart>>>,
}

impl<'a> RodFaces<'a> {
    pub fn new(
        wood: &'a Wood<'a>,
        run: &'a ObservedRun,
        fractures: &'a [SimulatedFracture],
    ) -> Self {
        let lengths = fractures.iter().map(|f| f.lengths_of_rods(wood)).collect();
        RodFaces {
            wood,
            run,
            fractures,
            lengths,
            parts_before: (fractures.iter().map(|f| f.parts_before().collect())).collect(),
        }
    }

    /// The number of faces.
    pub fn count(&self) -> usize {
        self.fractures.len()
    }

    /// The rod whose cell is nearest to a point of the section.
    pub fn rod_at(&self, at: glam::DVec2) -> usize {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (rod, cell) in self.wood.cells.iter().enumerate() {
            let far = cell.centroid.distance_squared(at);
            if far < least {
                (best, least) = (rod, far);
            }
        }
        best
    }

    /// The length along the axis at which a rod passes a face, m.
    pub fn length(&self, face: usize, rod: usize) -> f64 {
        self.lengths[face][rod]
    }

    /// The face nearest to a length along the axis, m.
    pub fn nearest(&self, along: f64) -> Option<usize> {
        let off = |face: &usize| (self.mean_length(*face) - along).abs();
        (0..self.count()).min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The first frame in which a rod is broken in each face.
    pub fn openings(&self, history: &BreakHistory) -> Vec<u32> {
        let opening = |face: usize| {
            let rods = 0..self.wood.bundle.rods();
            let broken = rods.filter_map(|rod| self.broken_vertex(face, rod));
            let frames = broken.map(|vertex| history.break_frame(vertex));
            frames.min().unwrap_or(u32::MAX)
        };
        (0..self.count()).map(opening).collect()
    }

    /// The mean length along the axis at which rods pass a face, m.
    pub fn mean_length(&self, face: usize) -> f64 {
        let all = &self.lengths[face];
        all.iter().sum::<f64>() / all.len().max(1) as f64
    }

    /// The vertex of the unbroken bundle at which a rod broke in a face; `None` for one that is whole there.
    pub fn broken_vertex(&self, face: usize, rod: usize) -> Option<u32> {
        let part = self.parts_before[face][rod]?;
        let of_rod = &self.run.state.breaks[rod];
        of_rod.get(usize::from(part)).map(|b| b.vertex)
    }

    /// How far whole rods decide the motion of a point of the piece below a face, or above it, at a place of the section and a
    /// length along the axis (m): 1 on the face between whole rods, 0 among broken ones and far away.
    pub fn held(&self, face: usize, is_below: bool, at: glam::DVec2, along: f64) -> f64 {
        if self.fractures[face].parted {
            return 0.0;
        }
        let width = self.wood.spacing();
        let (mut whole, mut all) = (0.0, 0.0);
        let mut nearest = (f64::INFINITY, 0.0);
        for (rod, cell) in self.wood.cells.iter().enumerate() {
            let far = cell.centroid.distance_squared(at) / (width * width);
            let weight = cell.area * libm::exp(-far);
            all += weight;
            if self.parts_before[face][rod].is_none() {
                whole += weight;
                if far < nearest.0 {
                    nearest = (far, self.length(face, rod));
                }
            }
        }
        let share = whole / all.max(f64::MIN_POSITIVE);
        let above = (along - nearest.1) / self.wood.stem.radius;
        let inside = if is_below { -above } else { above };
        let near = if inside >= 0.0 {
            smooth((HINGE.1 - inside) / (HINGE.1 - HINGE.0))
        } else {
            smooth((BEYOND.1 + inside) / (BEYOND.1 - BEYOND.0))
        };
        smooth((share - 0.25) / 0.5) * near
    }
}

/// A smooth step from 0 to 1.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Collects chains.
struct Maker<'a> {
    faces: &'a RodFaces<'a>,
    joints: &'a Joints,
    rest: &'a [Pose],
    /// Length along the axis of each section, m.
    along: Vec<f64>,
    /// Area of the stem's section, m².
    area: f64,
    /// For each face, the first frame in which a rod is broken in it.
    opening: &'a [u32],
    made: SectionJoints,
}

impl Maker<'_> {
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

    /// Makes the chain of joints that follow `own` at their sections, and the nearest one where it has none; and `whole` until
    /// the face beside them opens. `None` if it has none at all.
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
            });
        }
        Some(JointChain {
            along: self.along.clone(),
            first,
        })
    }
}

/// Which piece each part of a rod belongs to.
struct Membership<'a> {
    faces: &'a RodFaces<'a>,
    pieces: Pieces,
    /// The pieces of the run that the stem consists of, from its base to its tip.
    main: Vec<u32>,
}

impl Membership<'_> {
    /// Whether a part of a rod is of the wood that a piece was cut from, and no splinter. Of what hangs together several
    /// pieces may be cut.
    fn belongs(&self, rod: usize, part: RodPart, piece: usize) -> bool {
        let own = self.pieces.piece_of(rod as u32, part);
        let before = self.faces.fractures[..piece].iter();
        let number = before.filter(|f| f.parted).count();
        self.main.is_empty() || self.main.get(number) == Some(&own)
    }

    /// The part of a rod at a length along the axis (m), if it is of any piece.
    fn of_any(&self, rod: usize, along: f64) -> Option<RodPart> {
        let part = self.faces.run.part_at(rod, along);
        let mut pieces = 0..=self.faces.count();
        pieces
            .any(|piece| self.belongs(rod, part, piece))
            .then_some(part)
    }

    /// The same, if it is of this piece and between its faces.
    fn of_piece(&self, piece: usize, rod: usize, along: f64) -> Option<RodPart> {
        let faces = self.faces;
        let part = faces.run.part_at(rod, along);
        let beyond = piece == 0 || faces.length(piece - 1, rod) <= along;
        let before = piece == faces.count() || along <= faces.length(piece, rod);
        (beyond && before && self.belongs(rod, part, piece)).then_some(part)
    }

    /// The same, if the rod is whole in this face and near it.
    fn of_hinge(&self, face: usize, rod: usize, along: f64) -> Option<RodPart> {
        let faces = self.faces;
        let part = faces.run.part_at(rod, along);
        let reach = HINGE.1 * faces.wood.stem.radius;
        let near = (along - faces.length(face, rod)).abs() <= reach;
        let holds = near && faces.parts_before[face][rod].is_none();
        (holds && self.belongs(rod, part, face)).then_some(part)
    }

    /// All parts of rods that belong to a piece.
    fn parts(&self, piece: usize) -> Vec<(u32, RodPart)> {
        let mut parts = Vec::new();
        for (rod, breaks) in self.faces.run.state.breaks.iter().enumerate() {
            let all = 0..=breaks.len() as RodPart;
            let own = all.filter(|&part| self.belongs(rod, part, piece));
            parts.extend(own.map(|part| (rod as u32, part)));
        }
        parts
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

impl Sections {
    /// Makes the joints of the pieces that `faces` cut the wood into, which follow `joints` of rods that rest at `rest`. In frame
    /// `opening` of the film a rod is first broken in each face. `None` where no rod belongs to a piece.
    pub fn new(
        faces: &RodFaces,
        (joints, rest): (&Joints, &[Pose]),
        names: &[String],
        opening: &[u32],
    ) -> Option<Self> {
        let (wood, run) = (faces.wood, faces.run);
        let mut maker = Maker {
            faces,
            joints,
            rest,
            along: section_lengths(wood),
            area: wood.cells.iter().map(|c| c.area).sum(),
            opening,
            made: SectionJoints::default(),
        };
        let of_parts = run.state.pieces(wood);
        let members = Membership {
            faces,
            main: main_pieces(wood, run, &of_parts),
            pieces: of_parts,
        };
        let all = maker.parts(|rod, along| members.of_any(rod, along));
        let whole = maker.followers(&all);
        let bonds = HeldBonds::new(wood, &run.state);
        let mut pieces = Vec::new();
        for (piece, name) in names.iter().enumerate() {
            let own = maker.parts(|rod, along| members.of_piece(piece, rod, along));
            let sections = (&maker.along[..], maker.area);
            let own = maker.followers(&bonds.leading_strand(wood, sections, &own));
            let has_own = own.iter().any(Option::is_some);
            let own = if has_own { &own } else { &whole };
            pieces.push(maker.chain(name, &whole, own)?);
        }
        let mut hinges = Vec::new();
        for (face, fracture) in faces.fractures.iter().enumerate() {
            if fracture.parted {
                hinges.push(None);
                continue;
            }
            let own = maker.parts(|rod, along| members.of_hinge(face, rod, along));
            let own = maker.followers(&own);
            hinges.push(maker.chain(&format!("hinge_{face}"), &whole, &own));
        }
        Some(Sections {
            parts: (0..pieces.len()).map(|p| members.parts(p)).collect(),
            pieces,
            hinges,
            joints: maker.made,
        })
    }
}

impl JointChain {
    /// The joints on both sides of a length along the axis (m), with their weights; beyond the ends the last one.
    pub fn weights_at(&self, along: f64) -> [(u32, f64); 2] {
        let above = self.along.partition_point(|&a| a <= along);
        let (a, b) = (above.saturating_sub(1), above.min(self.along.len() - 1));
        let t = match self.along[b] - self.along[a] {
            width if width > 0.0 => (along - self.along[a]) / width,
            _ => 0.0,
        };
        [(self.first + a as u32, 1.0 - t), (self.first + b as u32, t)]
    }
}
