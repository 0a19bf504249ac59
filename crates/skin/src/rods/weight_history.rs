//! The weights of vertices before the cracks beside them open: the mean of all rods that are joined around them in a frame,
//! not only of those that are in the last. Both sides of a crack then coincide until it opens (Sutherland 2012 §5.2:
//! associations are dropped with their bonds).

use super::columns::OUTSIDE;
use super::fracture_state::{RodBreak, RodPart};
use super::history::{BreakHistory, NEVER};
use super::joints::Joints;
use super::open_faces::{OpenFaces, Vertex, VertexOrigin, mean_weights};
use super::prisms::{PrismComplex, PrismCorner};
use rustc_hash::FxHashMap;

/// The weights of a vertex up to a frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EarlierWeights {
    /// The first frame in which they no longer hold.
    pub until: u32,
    /// Whether a crack that the vertex lies on is closed.
    pub is_closed: bool,
    /// Joints and weights, which add up to 1.
    pub weights: Vec<(u32, f64)>,
}

/// The weights of a vertex in a frame.
struct CurrentWeights {
    is_closed: bool,
    weights: Vec<(u32, f64)>,
}

/// Traces weights through the frames of a history.
struct WeightTracer<'a, 'b> {
    complex: &'a PrismComplex<'b>,
    history: &'a BreakHistory,
    joints: &'a Joints,
    /// The columns around each corner of the section, and its number among the corners of each.
    around: Vec<Vec<(u32, u32)>>,
}

/// The prisms that meet in a corner of the section at a station.
#[derive(Default)]
struct Crossing {
    /// Numbers of the corners of the prisms.
    numbers: Vec<u32>,
    /// The rod of each, and its part in the last frame.
    rods: Vec<(u32, RodPart)>,
    /// Pairs of them, each with the frame up to which they are joined.
    joins: Vec<(usize, usize, u32)>,
    /// Frames in which joins change, ascending.
    changes: Vec<u32>,
    /// Vertices found there, each with the number of its corner among `numbers`.
    vertices: Vec<(u32, usize)>,
}

/// The weights of all vertices before the last change.
#[derive(Default)]
pub(super) struct WeightHistory {
    /// Earlier weights of each vertex, in order; empty where its weights never change.
    pub of_vertex: Vec<Vec<EarlierWeights>>,
    /// Pairs of vertices that coincide up to a frame.
    pub coincident: Vec<([u32; 2], u32)>,
}

/// Returns the weights of all vertices before the last change.
pub(super) fn weight_history(
    faces: &OpenFaces,
    complex: &PrismComplex,
    history: &BreakHistory,
    joints: &Joints,
) -> WeightHistory {
    let mut around = vec![Vec::new(); complex.columns.corners.len()];
    for (a, column) in complex.columns.columns.iter().enumerate() {
        for (k, &corner) in column.corners.iter().enumerate() {
            around[corner as usize].push((a as u32, k as u32));
        }
    }
    let tracer = WeightTracer {
        complex,
        history,
        joints,
        around,
    };
    let mut crossings: FxHashMap<(u32, usize), Crossing> = FxHashMap::default();
    let mut of_vertex: Vec<Vec<EarlierWeights>> = Vec::with_capacity(faces.vertices.len());
    let mut coincident = Vec::new();
    for (v, vertex) in faces.vertices.iter().enumerate() {
        let versions = match vertex.origin {
            VertexOrigin::Corner(number) => {
                let prism = complex.corner(number);
                let corner = complex.columns.columns[prism.column].corners[prism.corner];
                let crossing = (crossings.entry((corner, prism.station)))
                    .or_insert_with(|| tracer.crossing(corner, prism.station));
                let own = crossing.numbers.iter().position(|&n| n == number);
                own.map_or_else(Vec::new, |own| {
                    let others = crossing.vertices.iter();
                    coincident.extend(others.filter_map(|&(other, corner)| {
                        let until = crossing.split_frame(own, corner);
                        (until > 0 && until < NEVER).then_some(([other, v as u32], until))
                    }));
                    crossing.vertices.push((v as u32, own));
                    tracer.corner(vertex, own, crossing)
                })
            }
            VertexOrigin::BundleEnd { rod, parts, twin } => {
                let until = history.split_frame(tracer.breaks(rod), parts[0], parts[1]);
                let closed = twin.filter(|_| until > 0 && until < NEVER);
                coincident.extend(closed.map(|twin| ([twin, v as u32], until)));
                tracer.bundle_end(vertex, rod, parts)
            }
            VertexOrigin::Middle(ends) => middle(faces, ends, &of_vertex, vertex),
        };
        of_vertex.push(versions);
    }
    WeightHistory {
        of_vertex,
        coincident,
    }
}

impl Crossing {
    /// Returns which prisms are joined with one of them in a frame, and whether a crack that opens later lies between them.
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

    /// Returns the first frame in which two of them are not joined.
    fn split_frame(&self, a: usize, b: usize) -> u32 {
        let frames = std::iter::once(0).chain(self.changes.iter().copied());
        let mut apart = frames.filter(|&frame| !self.joined(a, frame).0[b]);
        apart.next().unwrap_or(NEVER)
    }
}

/// Returns the weights that `current` gives from frame 0 and from each of `changes` on, up to where the vertex has its final
/// weights.
fn versions(
    vertex: &Vertex,
    changes: &[u32],
    mut current: impl FnMut(u32) -> CurrentWeights,
) -> Vec<EarlierWeights> {
    let mut all: Vec<EarlierWeights> = Vec::new();
    let mut from = 0;
    for &until in changes {
        let CurrentWeights { is_closed, weights } = current(from);
        from = until;
        match all.last_mut() {
            Some(last) if (last.is_closed, &last.weights) == (is_closed, &weights) => {
                last.until = until;
            }
            _ => all.push(EarlierWeights {
                until,
                is_closed,
                weights,
            }),
        }
    }
    if all
        .last()
        .is_some_and(|l| !l.is_closed && l.weights == vertex.weights)
    {
        all.pop();
    }
    all
}

impl WeightTracer<'_, '_> {
    fn breaks(&self, rod: u32) -> &[RodBreak] {
        &self.history.last_state().breaks[rod as usize]
    }

    /// Returns the joints, with weights, of a part of a rod in a frame.
    fn weights(&self, rod: u32, part: RodPart, frame: u32, s: f64) -> [(u32, f64); 2] {
        let breaks = self.breaks(rod);
        let then = self.history.part_in_frame(breaks, part, frame);
        let same = |p: &RodPart| self.history.part_in_frame(breaks, *p, frame) == then;
        let mut low = part;
        while low > 0 && same(&(low - 1)) {
            low -= 1;
        }
        let mut high = part;
        while usize::from(high) < breaks.len() && same(&(high + 1)) {
            high += 1;
        }
        self.joints.weights_while_together(rod, low..=high, s)
    }

    /// Returns the prisms that meet in a corner of the section at a station.
    fn crossing(&self, corner: u32, station: usize) -> Crossing {
        let (complex, history) = (self.complex, self.history);
        let mut crossing = Crossing::default();
        let mut corners: Vec<PrismCorner> = Vec::new();
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
                let prism = PrismCorner {
                    column: column as usize,
                    corner: k as usize,
                    station,
                    above,
                };
                let rod = complex.columns.columns[prism.column].rod;
                let part = complex.parts[complex.prism(prism.column, slab)];
                crossing.rods.push((rod, part));
                crossing.numbers.push(complex.number(prism));
                corners.push(prism);
            }
        }
        for (i, p) in corners.iter().enumerate() {
            for (j, q) in corners.iter().enumerate().skip(i + 1) {
                let until = if p.column == q.column {
                    if complex.is_whole(p.column, station) {
                        NEVER
                    } else {
                        let (rod, a) = crossing.rods[i];
                        history.split_frame(self.breaks(rod), a, crossing.rods[j].1)
                    }
                } else if p.above == q.above {
                    self.side_opening_frame(p, q)
                } else {
                    0
                };
                if until > 0 {
                    crossing.joins.push((i, j, until));
                }
            }
        }
        let mut changes: Vec<u32> = crossing.joins.iter().map(|j| j.2).collect();
        for &(rod, _) in &crossing.rods {
            changes.extend(
                self.breaks(rod)
                    .iter()
                    .map(|b| history.break_frame(b.vertex)),
            );
        }
        changes.retain(|&c| c > 0 && c != NEVER);
        changes.sort_unstable();
        changes.dedup();
        crossing.changes = changes;
        crossing
    }

    /// Returns the frame up to which the prisms of two columns are joined by a side at a corner that both have.
    fn side_opening_frame(&self, p: &PrismCorner, q: &PrismCorner) -> u32 {
        let column = &self.complex.columns.columns[p.column];
        let slab = if p.above { p.station } else { p.station - 1 };
        let n = column.corners.len();
        let sides = [p.corner, (p.corner + n - 1) % n];
        let until = sides
            .into_iter()
            .filter(|&side| {
                column.beyond[side] != OUTSIDE && column.beyond[side] as usize == q.column
            })
            .map(|side| {
                self.complex
                    .opening_frame(p.column, side, slab, self.history)
            });
        until.max().unwrap_or(0)
    }

    /// Returns the earlier weights of a vertex that is a corner of prisms.
    fn corner(&self, vertex: &Vertex, own: usize, crossing: &Crossing) -> Vec<EarlierWeights> {
        versions(vertex, &crossing.changes, |frame| {
            // Those that are joined with it, in the order of their columns.
            let (with, is_closed) = crossing.joined(own, frame);
            let mut rods: Vec<(u32, RodPart, RodPart)> = Vec::new();
            for (&(rod, part), _) in crossing.rods.iter().zip(&with).filter(|(_, w)| **w) {
                let then = self.history.part_in_frame(self.breaks(rod), part, frame);
                if !rods.iter().any(|r| (r.0, r.2) == (rod, then)) {
                    rods.push((rod, part, then));
                }
            }
            let share = 1.0 / rods.len() as f64;
            let mut weights: Vec<(u32, f64)> = Vec::with_capacity(2 * rods.len());
            for (rod, part, _) in rods {
                let joints = self.weights(rod, part, frame, vertex.grain.z);
                let used = joints.into_iter().filter(|j| j.1 > 0.0);
                weights.extend(used.map(|(joint, weight)| (joint, weight * share)));
            }
            weights.sort_unstable_by_key(|entry| entry.0);
            CurrentWeights { is_closed, weights }
        })
    }

    /// Returns the earlier weights of a vertex inside a fibre bundle's end.
    fn bundle_end(&self, vertex: &Vertex, rod: u32, parts: [RodPart; 2]) -> Vec<EarlierWeights> {
        let breaks = self.breaks(rod);
        let mut changes: Vec<u32> = breaks
            .iter()
            .map(|b| self.history.break_frame(b.vertex))
            .collect();
        changes.retain(|&c| c > 0 && c != NEVER);
        changes.sort_unstable();
        changes.dedup();
        let opens = self.history.split_frame(breaks, parts[0], parts[1]);
        versions(vertex, &changes, |frame| {
            let joints = self.weights(rod, parts[0], frame, vertex.grain.z);
            CurrentWeights {
                is_closed: opens != NEVER && frame < opens,
                weights: joints.to_vec(),
            }
        })
    }
}

/// Returns the earlier weights of the midpoint of two vertices, from those of all vertices before it.
fn middle(
    faces: &OpenFaces,
    ends: [u32; 2],
    of_vertex: &[Vec<EarlierWeights>],
    vertex: &Vertex,
) -> Vec<EarlierWeights> {
    let versions_of_ends = ends.map(|v| of_vertex[v as usize].as_slice());
    let mut changes: Vec<u32> = versions_of_ends
        .iter()
        .flat_map(|v| v.iter())
        .map(|v| v.until)
        .collect();
    changes.sort_unstable();
    changes.dedup();
    versions(vertex, &changes, |frame| {
        let now = [0, 1].map(|k| {
            let version = versions_of_ends[k].iter().find(|v| frame < v.until);
            let last = &faces.vertices[ends[k] as usize].weights;
            version.map_or((false, last), |v| (v.is_closed, &v.weights))
        });
        CurrentWeights {
            is_closed: now[0].0 || now[1].0,
            weights: mean_weights(&[now[0].1.as_slice(), now[1].1.as_slice()]),
        }
    })
}
