//! What vertices of the skin follow before the cracks beside them open: the mean of all rods that are joined around them
//! in a frame, not only of those that are in the last. Both sides of a crack are then at one place until it opens
//! (Sutherland 2012 §5.2: associations are dropped with their bonds).

use super::complex::{Complex, Place};
use super::faces::{Faces, Source, Vertex, blended};
use super::history::{History, NEVER};
use super::joints::Joints;
use super::parting::Part;
use super::section::OUTSIDE;
use rustc_hash::FxHashMap;

/// What a vertex follows up to a frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Version {
    /// The first frame in which it does not.
    pub until: u32,
    /// Whether a crack that it lies on is closed.
    pub closed: bool,
    /// Joints and weights, which add up to 1.
    pub follows: Vec<(u32, f64)>,
}

/// What a vertex follows in a frame.
type Now = (bool, Vec<(u32, f64)>);

struct Looker<'a, 'b> {
    complex: &'a Complex<'b>,
    history: &'a History,
    joints: &'a Joints,
    /// The columns that have each corner of the section, and which of theirs it is.
    around: Vec<Vec<(u32, u32)>>,
}

/// The prisms that meet in a corner of the section at a station.
#[derive(Default)]
struct Crossing {
    /// Corners of prisms.
    numbers: Vec<u32>,
    /// The rod of each, and its part in the last frame.
    of: Vec<(u32, Part)>,
    /// Two of them that are joined up to a frame.
    joins: Vec<(usize, usize, u32)>,
    /// Frames in which something changes, ascending.
    changes: Vec<u32>,
    /// Vertices found there, and which of them each is.
    found: Vec<(u32, usize)>,
}

/// What vertices follow before.
#[derive(Default)]
pub(super) struct Before {
    /// For each vertex what it follows before the last change, in order; empty where it follows the same all the time.
    pub versions: Vec<Vec<Version>>,
    /// Pairs of vertices that are at one place up to a frame.
    pub together: Vec<([u32; 2], u32)>,
}

/// What vertices follow before.
pub(super) fn earlier(
    faces: &Faces,
    complex: &Complex,
    history: &History,
    joints: &Joints,
) -> Before {
    let mut around = vec![Vec::new(); complex.columns.corners.len()];
    for (a, column) in complex.columns.columns.iter().enumerate() {
        for (k, &corner) in column.corners.iter().enumerate() {
            around[corner as usize].push((a as u32, k as u32));
        }
    }
    let looker = Looker {
        complex,
        history,
        joints,
        around,
    };
    let mut known: FxHashMap<(u32, usize), Crossing> = FxHashMap::default();
    let mut made: Vec<Vec<Version>> = Vec::with_capacity(faces.vertices.len());
    let mut together = Vec::new();
    for (v, vertex) in faces.vertices.iter().enumerate() {
        let versions = match vertex.source {
            Source::Corner(number) => {
                let place = complex.place(number);
                let corner = complex.columns.columns[place.column].corners[place.corner];
                let crossing = (known.entry((corner, place.station)))
                    .or_insert_with(|| looker.crossing(corner, place.station));
                let own = crossing.numbers.iter().position(|&n| n == number);
                own.map_or_else(Vec::new, |own| {
                    let beside = crossing.found.iter();
                    together.extend(beside.filter_map(|&(other, of)| {
                        let until = crossing.until(own, of);
                        (until > 0 && until < NEVER).then_some(([other, v as u32], until))
                    }));
                    crossing.found.push((v as u32, own));
                    looker.corner(vertex, own, crossing)
                })
            }
            Source::Tip { rod, parts, twin } => {
                let until = history.parted(looker.breaks(rod), parts[0], parts[1]);
                let closed = twin.filter(|_| until > 0 && until < NEVER);
                together.extend(closed.map(|twin| ([twin, v as u32], until)));
                looker.tip(vertex, rod, parts)
            }
            Source::Middle(ends) => middle(faces, ends, &made, vertex),
        };
        made.push(versions);
    }
    Before {
        versions: made,
        together,
    }
}

impl Crossing {
    /// Which prisms are joined with one of them in a frame, and whether by a crack that opens later.
    fn joined(&self, own: usize, frame: u32) -> (Vec<bool>, bool) {
        let mut with = vec![false; self.numbers.len()];
        with[own] = true;
        let mut left = vec![own];
        let mut closed = false;
        while let Some(k) = left.pop() {
            for &(i, j, until) in self.joins.iter().filter(|j| j.2 > frame) {
                let other = match (i == k, j == k) {
                    (true, _) => j,
                    (_, true) => i,
                    _ => continue,
                };
                closed |= until != NEVER;
                if !std::mem::replace(&mut with[other], true) {
                    left.push(other);
                }
            }
        }
        (with, closed)
    }

    /// The first frame in which two of them are not joined.
    fn until(&self, a: usize, b: usize) -> u32 {
        let frames = std::iter::once(0).chain(self.changes.iter().copied());
        let mut apart = frames.filter(|&frame| !self.joined(a, frame).0[b]);
        apart.next().unwrap_or(NEVER)
    }
}

/// The versions that `now` gives from frame 0 and from each of `changes` on, up to where the vertex follows what it does
/// in the end.
fn versions(vertex: &Vertex, changes: &[u32], mut now: impl FnMut(u32) -> Now) -> Vec<Version> {
    let mut all: Vec<Version> = Vec::new();
    let mut from = 0;
    for &until in changes {
        let (closed, follows) = now(from);
        from = until;
        match all.last_mut() {
            Some(last) if (last.closed, &last.follows) == (closed, &follows) => last.until = until,
            _ => all.push(Version {
                until,
                closed,
                follows,
            }),
        }
    }
    if all
        .last()
        .is_some_and(|l| !l.closed && l.follows == vertex.follows)
    {
        all.pop();
    }
    all
}

impl Looker<'_, '_> {
    fn breaks(&self, rod: u32) -> &[super::parting::RodBreak] {
        &self.history.last().breaks[rod as usize]
    }

    /// The joints of a part of a rod in a frame.
    fn follow(&self, rod: u32, part: Part, frame: u32, s: f64) -> [(u32, f64); 2] {
        let breaks = self.breaks(rod);
        let then = self.history.part(breaks, part, frame);
        let same = |p: &Part| self.history.part(breaks, *p, frame) == then;
        let mut low = part;
        while low > 0 && same(&(low - 1)) {
            low -= 1;
        }
        let mut high = part;
        while usize::from(high) < breaks.len() && same(&(high + 1)) {
            high += 1;
        }
        self.joints.along(rod, low..=high, s)
    }

    fn crossing(&self, corner: u32, station: usize) -> Crossing {
        let (complex, history) = (self.complex, self.history);
        let mut made = Crossing::default();
        let mut places: Vec<Place> = Vec::new();
        for &(column, k) in &self.around[corner as usize] {
            for above in [false, true] {
                let slab = if above {
                    station
                } else {
                    station.wrapping_sub(1)
                };
                if slab >= complex.slabs() {
                    continue;
                }
                let place = Place {
                    column: column as usize,
                    corner: k as usize,
                    station,
                    above,
                };
                let rod = complex.columns.columns[place.column].rod;
                made.of
                    .push((rod, complex.parts[complex.prism(place.column, slab)]));
                made.numbers.push(complex.number(place));
                places.push(place);
            }
        }
        for (i, p) in places.iter().enumerate() {
            for (j, q) in places.iter().enumerate().skip(i + 1) {
                let until = if p.column == q.column {
                    if complex.is_whole(p.column, station) {
                        NEVER
                    } else {
                        let (rod, a) = made.of[i];
                        history.parted(self.breaks(rod), a, made.of[j].1)
                    }
                } else if p.above == q.above {
                    self.beside(p, q)
                } else {
                    0
                };
                if until > 0 {
                    made.joins.push((i, j, until));
                }
            }
        }
        let mut changes: Vec<u32> = made.joins.iter().map(|j| j.2).collect();
        for &(rod, _) in &made.of {
            changes.extend(self.breaks(rod).iter().map(|b| history.broke(b.vertex)));
        }
        changes.retain(|&c| c > 0 && c != NEVER);
        changes.sort_unstable();
        changes.dedup();
        made.changes = changes;
        made
    }

    /// Until when the prisms of two columns at a corner that both have are joined by a side.
    fn beside(&self, p: &Place, q: &Place) -> u32 {
        let column = &self.complex.columns.columns[p.column];
        let slab = if p.above { p.station } else { p.station - 1 };
        let n = column.corners.len();
        let sides = [p.corner, (p.corner + n - 1) % n];
        let until = sides
            .into_iter()
            .filter(|&side| {
                column.beyond[side] != OUTSIDE && column.beyond[side] as usize == q.column
            })
            .map(|side| self.complex.opens(p.column, side, slab, self.history));
        until.max().unwrap_or(0)
    }

    fn corner(&self, vertex: &Vertex, own: usize, crossing: &Crossing) -> Vec<Version> {
        versions(vertex, &crossing.changes, |frame| {
            // Those that are joined with it, in the order of their columns.
            let (with, closed) = crossing.joined(own, frame);
            let mut rods: Vec<(u32, Part, Part)> = Vec::new();
            for (&(rod, part), _) in crossing.of.iter().zip(&with).filter(|(_, w)| **w) {
                let then = self.history.part(self.breaks(rod), part, frame);
                if !rods.iter().any(|r| (r.0, r.2) == (rod, then)) {
                    rods.push((rod, part, then));
                }
            }
            let share = 1.0 / rods.len() as f64;
            let mut follows: Vec<(u32, f64)> = Vec::with_capacity(2 * rods.len());
            for (rod, part, _) in rods {
                let joints = self.follow(rod, part, frame, vertex.grain.z);
                let used = joints.into_iter().filter(|j| j.1 > 0.0);
                follows.extend(used.map(|(joint, weight)| (joint, weight * share)));
            }
            follows.sort_unstable_by_key(|f| f.0);
            (closed, follows)
        })
    }

    fn tip(&self, vertex: &Vertex, rod: u32, parts: [Part; 2]) -> Vec<Version> {
        let breaks = self.breaks(rod);
        let mut changes: Vec<u32> = breaks
            .iter()
            .map(|b| self.history.broke(b.vertex))
            .collect();
        changes.retain(|&c| c > 0 && c != NEVER);
        changes.sort_unstable();
        changes.dedup();
        let opens = self.history.parted(breaks, parts[0], parts[1]);
        versions(vertex, &changes, |frame| {
            let joints = self.follow(rod, parts[0], frame, vertex.grain.z);
            (opens != NEVER && frame < opens, joints.to_vec())
        })
    }
}

fn middle(faces: &Faces, ends: [u32; 2], made: &[Vec<Version>], vertex: &Vertex) -> Vec<Version> {
    let of = ends.map(|v| made[v as usize].as_slice());
    let mut changes: Vec<u32> = of.iter().flat_map(|v| v.iter()).map(|v| v.until).collect();
    changes.sort_unstable();
    changes.dedup();
    versions(vertex, &changes, |frame| {
        let now = [0, 1].map(|k| {
            let version = of[k].iter().find(|v| frame < v.until);
            let last = &faces.vertices[ends[k] as usize].follows;
            version.map_or((false, last), |v| (v.closed, &v.follows))
        });
        (
            now[0].0 || now[1].0,
            blended(&[now[0].1.as_slice(), now[1].1.as_slice()]),
        )
    })
}
