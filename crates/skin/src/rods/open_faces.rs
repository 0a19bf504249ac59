//! The open faces, as triangles over vertices that have an address in the wood and follow rods.

use super::broken_end::BrokenEnd;
use super::columns::OUTSIDE;
use super::fracture_state::{FractureState, RodPart};
use super::joints::Joints;
use super::options::RodSkinOptions;
use super::prisms::{PrismComplex, PrismCorner, break_reach};
use super::wood::Wood;
use glam::DVec3;
use greenstick_geometry::Unions;
use greenstick_wood::noise::unit;
use rustc_hash::FxHashMap;

/// The kind of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FaceKind {
    /// The outside.
    Bark,
    /// An end of the bundle.
    End,
    /// The side of a fibre bundle; sides with one number are smooth together.
    Side(u32),
    /// The broken end of a fibre bundle; faces with one number are smooth together.
    BrokenEnd(u32),
}

/// A vertex of the skin.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Vertex {
    /// Grain coordinates, m.
    pub grain: DVec3,
    /// Position at rest in the world of the rods, m.
    pub rest: DVec3,
    /// Joints and weights, which add up to 1.
    pub weights: Vec<(u32, f64)>,
    /// Whether it lies on a crack, where it coincides with other vertices.
    pub is_on_crack: bool,
    /// Where it comes from.
    pub origin: VertexOrigin,
    /// Position at rest while the crack is closed, m.
    pub closed_rest: DVec3,
}

/// Where a vertex of the skin comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum VertexOrigin {
    /// Corners of prisms; the number of one of them.
    Corner(u32),
    /// The inside of a fibre bundle's end.
    BundleEnd {
        rod: u32,
        /// The part of the rod that it bounds, and the part beyond.
        parts: [RodPart; 2],
        /// The vertex of the other side, where that has a smaller number.
        twin: Option<u32>,
    },
    /// The midpoint of two other vertices.
    Middle([u32; 2]),
}

/// Returns the mean of the weights of several vertices.
pub(super) fn mean_weights(vertices: &[&[(u32, f64)]]) -> Vec<(u32, f64)> {
    let mut mean: Vec<(u32, f64)> = Vec::new();
    for &(joint, weight) in vertices.iter().copied().flatten() {
        let weight = weight / vertices.len() as f64;
        match mean.iter_mut().find(|entry| entry.0 == joint) {
            Some(entry) => entry.1 += weight,
            None => mean.push((joint, weight)),
        }
    }
    mean.sort_unstable_by_key(|entry| entry.0);
    mean
}

/// A triangle of the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    /// Vertices, counter-clockwise as seen from outside.
    pub corners: [u32; 3],
    /// The prism that it bounds.
    pub prism: u32,
    /// Its kind.
    pub kind: FaceKind,
}

/// All open faces.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct OpenFaces {
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<Triangle>,
}

/// Open faces while they are made.
struct FaceBuilder<'a, 'b> {
    wood: &'a Wood<'a>,
    complex: &'a PrismComplex<'b>,
    state: &'a FractureState,
    joints: &'a Joints,
    options: &'a RodSkinOptions,
    /// Sets of corners of prisms that are one vertex.
    topology: Unions,
    /// Sets of corners of prisms that follow the same rods.
    bonded: Unions,
    faces: OpenFaces,
    /// Vertex of each set of corners.
    vertex_of: FxHashMap<u32, u32>,
    /// The set of corners of each vertex, or [`NO_SET`].
    sets: Vec<u32>,
}

/// The set of a vertex that is no corner of a prism.
const NO_SET: u32 = u32::MAX;

/// Makes all open faces.
pub(super) fn open_faces(
    wood: &Wood,
    complex: &mut PrismComplex,
    state: &FractureState,
    joints: &Joints,
    options: &RodSkinOptions,
) -> OpenFaces {
    let mut topology = complex.vertex_sets(options.keep_inner);
    let bonded = if options.keep_inner {
        complex.vertex_sets(false)
    } else {
        complex.close_held(&mut topology);
        topology.clone()
    };
    let mut builder = FaceBuilder {
        wood,
        complex,
        state,
        joints,
        options,
        topology,
        bonded,
        faces: OpenFaces::default(),
        vertex_of: FxHashMap::default(),
        sets: Vec::new(),
    };
    builder.add_open_faces();
    builder.bind();
    builder.faces
}

impl FaceBuilder<'_, '_> {
    fn add_open_faces(&mut self) {
        let complex = self.complex;
        let mut number = 0;
        for a in 0..complex.columns.columns.len() {
            for side in 0..complex.columns.columns[a].corners.len() {
                for slab in 0..complex.slabs() {
                    if self.is_open(a, side, slab) {
                        self.add_side(a, side, slab, number);
                    }
                }
                number += 1;
            }
            for station in 0..=complex.slabs() {
                if !complex.is_whole(a, station) {
                    self.add_ends(a, station);
                }
            }
        }
        self.mark_cracks();
    }

    fn is_open(&self, a: usize, side: usize, slab: usize) -> bool {
        let columns = &self.complex.columns.columns;
        let beyond = columns.get(columns[a].beyond[side] as usize);
        let between_rods =
            self.options.keep_inner && beyond.is_some_and(|b| b.rod != columns[a].rod);
        between_rods || !self.complex.is_joined(a, side, slab)
    }

    /// Adds the side of a prism: two triangles, with the same diagonal as on the other side.
    fn add_side(&mut self, a: usize, side: usize, slab: usize, number: u32) {
        let column = &self.complex.columns.columns[a];
        let n = column.corners.len();
        let (u, v) = (column.corners[side], column.corners[(side + 1) % n]);
        let around = self.complex.corners_of_side(a, side, slab);
        let is_shared = around.map(|(here, beyond)| {
            let here = self.topology.root(here);
            beyond.is_some_and(|b| self.topology.root(b) == here)
        });
        let at = [
            (side, slab, true),
            ((side + 1) % n, slab, true),
            ((side + 1) % n, slab + 1, false),
            (side, slab + 1, false),
        ];
        let corners = at.map(|(corner, station, above)| {
            self.corner(PrismCorner {
                column: a,
                corner,
                station,
                above,
            })
        });
        // The diagonal from the first corner to the third, or from the second to the fourth: where its ends are shared
        // with the face beyond and those of the other are not, both faces would have the same triangles.
        let shared_diagonals = [is_shared[0] && is_shared[2], is_shared[1] && is_shared[3]];
        let first_diagonal = if shared_diagonals[0] == shared_diagonals[1] {
            let first_half = unit(
                self.options.seed ^ 0xd1a6,
                i64::from(u.min(v)),
                slab as i64,
                i64::from(u.max(v)),
            ) < 0.5;
            first_half == (u < v)
        } else {
            shared_diagonals[1]
        };
        let outer = &self.complex.columns.outer;
        let bark = column.beyond[side] == OUTSIDE && outer[u as usize] && outer[v as usize];
        let kind = if bark {
            FaceKind::Bark
        } else {
            FaceKind::Side(number)
        };
        let [p, q, r, s] = corners;
        let triangles = if first_diagonal {
            [[p, q, r], [p, r, s]]
        } else {
            [[p, q, s], [q, r, s]]
        };
        let prism = self.complex.prism(a, slab) as u32;
        for corners in triangles {
            self.faces.triangles.push(Triangle {
                corners,
                prism,
                kind,
            });
        }
    }

    /// Adds the ends of the prisms below and above a station, where they are not joined.
    fn add_ends(&mut self, a: usize, station: usize) {
        let complex = self.complex;
        let column = &complex.columns.columns[a];
        let n = column.corners.len();
        let is_break = station > 0 && station < complex.slabs();
        let end = if is_break {
            self.broken_end(a, station)
        } else {
            BrokenEnd::flat(complex, a, station)
        };
        let mut below = None;
        for above in [false, true] {
            let slab = if above {
                station
            } else {
                station.wrapping_sub(1)
            };
            if slab >= complex.slabs() {
                continue;
            }
            let first = self.faces.vertices.len() as u32;
            let twins = below.replace(first);
            let part = complex.parts[complex.prism(a, slab)];
            let other = if above {
                slab.wrapping_sub(1)
            } else {
                slab + 1
            };
            let beyond = if is_break {
                complex.parts[complex.prism(a, other)]
            } else {
                part
            };
            for (k, &grain) in end.points.iter().enumerate() {
                self.sets.push(NO_SET);
                self.faces.vertices.push(Vertex {
                    grain,
                    rest: DVec3::ZERO,
                    weights: self.joints.weights_at(column.rod, part, grain.z).to_vec(),
                    is_on_crack: is_break,
                    origin: VertexOrigin::BundleEnd {
                        rod: column.rod,
                        parts: [part, beyond],
                        twin: twins.map(|t| t + k as u32).filter(|_| is_break),
                    },
                    closed_rest: DVec3::ZERO,
                });
            }
            let prism = complex.prism(a, slab) as u32;
            let start = self.faces.triangles.len() as u32;
            for (triangle, side) in &end.triangles {
                let kind = if is_break {
                    FaceKind::BrokenEnd(start + side)
                } else {
                    FaceKind::End
                };
                let mut corners = triangle.map(|k| match k.checked_sub(n) {
                    Some(inside) => first + inside as u32,
                    None => self.corner(PrismCorner {
                        column: a,
                        corner: k,
                        station,
                        above,
                    }),
                });
                if above {
                    corners.reverse();
                }
                self.faces.triangles.push(Triangle {
                    corners,
                    prism,
                    kind,
                });
            }
        }
    }

    /// Returns the broken end of a fibre bundle, whose thorns are the hollows of the other side.
    fn broken_end(&self, a: usize, station: usize) -> BrokenEnd {
        let complex = self.complex;
        let column = &complex.columns.columns[a];
        let below = complex.parts[complex.prism(a, station - 1)];
        let breaks = &self.state.breaks[column.rod as usize];
        let Some(broken) = breaks.get(usize::from(below)) else {
            return BrokenEnd::flat(complex, a, station);
        };
        let length = break_reach(self.wood, column.width(), broken.cause) * self.options.splinters;
        BrokenEnd::with_thorns(complex, a, station, length, self.options.seed)
    }

    /// Returns the vertex at a corner of a prism.
    fn corner(&mut self, corner: PrismCorner) -> u32 {
        let number = self.complex.number(corner);
        let set = self.topology.root(number);
        if let Some(&known) = self.vertex_of.get(&set) {
            return known;
        }
        let line = self.complex.columns.columns[corner.column].corners[corner.corner];
        let across = self.complex.columns.corners[line as usize];
        let new = self.faces.vertices.len() as u32;
        self.faces.vertices.push(Vertex {
            grain: across.extend(self.complex.length(line, corner.station)),
            rest: DVec3::ZERO,
            weights: Vec::new(),
            is_on_crack: false,
            origin: VertexOrigin::Corner(number),
            closed_rest: DVec3::ZERO,
        });
        self.sets.push(set);
        self.vertex_of.insert(set, new);
        new
    }

    /// Marks vertices that coincide with others: they lie on cracks.
    fn mark_cracks(&mut self) {
        let mut count: FxHashMap<[u64; 3], u32> = FxHashMap::default();
        let key = |v: &Vertex| v.grain.to_array().map(f64::to_bits);
        for v in &self.faces.vertices {
            *count.entry(key(v)).or_default() += 1;
        }
        for v in &mut self.faces.vertices {
            v.is_on_crack = count[&key(v)] > 1;
        }
    }

    /// Gives every vertex its weights: the mean of the rods that are bonded there.
    fn bind(&mut self) {
        let complex = self.complex;
        let mut rods: FxHashMap<u32, Vec<(u32, RodPart)>> = FxHashMap::default();
        let mut bonded_sets = Vec::with_capacity(self.sets.len());
        for &set in &self.sets {
            let bonded = if set == NO_SET {
                set
            } else {
                self.bonded.root(set)
            };
            if bonded != NO_SET {
                rods.entry(bonded).or_default();
            }
            bonded_sets.push(bonded);
        }
        for (a, column) in complex.columns.columns.iter().enumerate() {
            for corner in 0..column.corners.len() {
                for station in 0..=complex.slabs() {
                    for above in [false, true] {
                        let slab = if above {
                            station
                        } else {
                            station.wrapping_sub(1)
                        };
                        if slab >= complex.slabs() {
                            continue;
                        }
                        let set = self.bonded.root(complex.number(PrismCorner {
                            column: a,
                            corner,
                            station,
                            above,
                        }));
                        if let Some(list) = rods.get_mut(&set) {
                            let own = (column.rod, complex.parts[complex.prism(a, slab)]);
                            if !list.contains(&own) {
                                list.push(own);
                            }
                        }
                    }
                }
            }
        }
        for (v, bonded) in self.faces.vertices.iter_mut().zip(bonded_sets) {
            let Some(list) = rods.get(&bonded) else {
                continue;
            };
            let share = 1.0 / list.len() as f64;
            let mut weights: Vec<(u32, f64)> = Vec::with_capacity(2 * list.len());
            for &(rod, part) in list {
                for (joint, weight) in self.joints.weights_at(rod, part, v.grain.z) {
                    if weight > 0.0 {
                        weights.push((joint, weight * share));
                    }
                }
            }
            weights.sort_unstable_by_key(|entry| entry.0);
            v.weights = weights;
        }
    }
}
