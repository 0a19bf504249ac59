//! The faces that lie open, as triangles over vertices that know where they are in the wood and which rods they follow.

use super::complex::{Complex, Place, reach};
use super::joints::Joints;
use super::parting::{Part, Parting};
use super::section::OUTSIDE;
use super::tips::Tips;
use super::{RodSkinOptions, Wood};
use glam::DVec3;
use greenstick_geometry::Unions;
use greenstick_wood::noise::unit;
use rustc_hash::FxHashMap;

/// What a face shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Shows {
    /// The outside.
    Bark,
    /// An end of the bundle.
    End,
    /// The side of a fibre bundle; the number tells sides that are smooth together.
    Side(u32),
    /// The broken end of a fibre bundle; the number tells what is smooth together.
    Tip(u32),
}

/// A vertex of the skin.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Vertex {
    /// Grain coordinates, m.
    pub grain: DVec3,
    /// Place at rest in the world of the rods, m.
    pub rest: DVec3,
    /// Joints and weights, which add up to 1.
    pub follows: Vec<(u32, f64)>,
    /// Whether it lies on a crack, at one place with others.
    pub cracked: bool,
    /// What made it.
    pub source: Source,
    /// Place at rest while the crack is closed, m.
    pub closed: DVec3,
}

/// What a vertex of the skin is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Source {
    /// One of the corners of prisms that it is, by number.
    Corner(u32),
    /// In the end of a fibre bundle: its rod, the part that it bounds and the part beyond, and the vertex of the other side
    /// where that comes before.
    Tip {
        rod: u32,
        parts: [Part; 2],
        twin: Option<u32>,
    },
    /// The middle of two other vertices.
    Middle([u32; 2]),
}

/// The mean of what several vertices follow.
pub(super) fn blended(of: &[&[(u32, f64)]]) -> Vec<(u32, f64)> {
    let mut follows: Vec<(u32, f64)> = Vec::new();
    for &(joint, weight) in of.iter().copied().flatten() {
        let weight = weight / of.len() as f64;
        match follows.iter_mut().find(|f| f.0 == joint) {
            Some(f) => f.1 += weight,
            None => follows.push((joint, weight)),
        }
    }
    follows.sort_unstable_by_key(|f| f.0);
    follows
}

/// A triangle of the skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    /// Vertices, counter-clockwise from outside.
    pub corners: [u32; 3],
    /// The prism that it bounds.
    pub prism: u32,
    /// What it shows.
    pub shows: Shows,
}

/// All open faces.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Faces {
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<Triangle>,
}

struct Maker<'a, 'b> {
    wood: &'a Wood<'a>,
    complex: &'a Complex<'b>,
    parting: &'a Parting,
    joints: &'a Joints,
    options: &'a RodSkinOptions,
    /// Which corners of prisms are one vertex.
    topology: Unions,
    /// Which corners of prisms follow the same rods.
    bonded: Unions,
    faces: Faces,
    /// Vertex of each set of corners.
    made: FxHashMap<u32, u32>,
    /// The set of corners of each vertex; `u32::MAX` for a tip.
    sets: Vec<u32>,
}

/// Makes all open faces.
pub(super) fn open_faces(
    wood: &Wood,
    complex: &mut Complex,
    parting: &Parting,
    joints: &Joints,
    options: &RodSkinOptions,
) -> Faces {
    let mut topology = complex.vertices(options.keep_inner);
    let bonded = if options.keep_inner {
        complex.vertices(false)
    } else {
        complex.close_held(&mut topology);
        topology.clone()
    };
    let mut maker = Maker {
        wood,
        complex,
        parting,
        joints,
        options,
        topology,
        bonded,
        faces: Faces::default(),
        made: FxHashMap::default(),
        sets: Vec::new(),
    };
    maker.make();
    maker.bind();
    maker.faces
}

impl Maker<'_, '_> {
    fn make(&mut self) {
        let complex = self.complex;
        let mut number = 0;
        for a in 0..complex.columns.columns.len() {
            for side in 0..complex.columns.columns[a].corners.len() {
                for slab in 0..complex.slabs() {
                    if self.is_open(a, side, slab) {
                        self.side(a, side, slab, number);
                    }
                }
                number += 1;
            }
            for station in 0..=complex.slabs() {
                if !complex.is_whole(a, station) {
                    self.cap(a, station);
                }
            }
        }
        self.mark_cracks();
    }

    fn is_open(&self, a: usize, side: usize, slab: usize) -> bool {
        let columns = &self.complex.columns.columns;
        let beyond = columns.get(columns[a].beyond[side] as usize);
        let kept = self.options.keep_inner && beyond.is_some_and(|b| b.rod != columns[a].rod);
        kept || !self.complex.is_joined(a, side, slab)
    }

    /// The side of a prism: two triangles, parted alike from both sides.
    fn side(&mut self, a: usize, side: usize, slab: usize, number: u32) {
        let column = &self.complex.columns.columns[a];
        let n = column.corners.len();
        let (u, v) = (column.corners[side], column.corners[(side + 1) % n]);
        let around = self.complex.corners_of_side(a, side, slab);
        let same = around.map(|(here, beyond)| {
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
            self.corner(Place {
                column: a,
                corner,
                station,
                above,
            })
        });
        // The diagonal from the first corner to the third, or from the second to the fourth: where its ends are shared
        // with the face beyond and those of the other are not, both faces would have the same triangles.
        let pinned = [same[0] && same[2], same[1] && same[3]];
        let first = if pinned[0] == pinned[1] {
            let even = unit(
                self.options.seed ^ 0xd1a6,
                i64::from(u.min(v)),
                slab as i64,
                i64::from(u.max(v)),
            ) < 0.5;
            even == (u < v)
        } else {
            pinned[1]
        };
        let outer = &self.complex.columns.outer;
        let bark = column.beyond[side] == OUTSIDE && outer[u as usize] && outer[v as usize];
        let shows = if bark {
            Shows::Bark
        } else {
            Shows::Side(number)
        };
        let [p, q, r, s] = corners;
        let made = if first {
            [[p, q, r], [p, r, s]]
        } else {
            [[p, q, s], [q, r, s]]
        };
        let prism = self.complex.prism(a, slab) as u32;
        for corners in made {
            self.faces.triangles.push(Triangle {
                corners,
                prism,
                shows,
            });
        }
    }

    /// The ends of the prisms below and above a station, where they are not joined: fans about one place.
    fn cap(&mut self, a: usize, station: usize) {
        let complex = self.complex;
        let column = &complex.columns.columns[a];
        let n = column.corners.len();
        let inner = station > 0 && station < complex.slabs();
        let end = if inner {
            self.tips(a, station)
        } else {
            Tips::flat(complex, a, station)
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
            let beyond = if inner {
                complex.parts[complex.prism(a, other)]
            } else {
                part
            };
            for (k, &grain) in end.places.iter().enumerate() {
                self.sets.push(u32::MAX);
                self.faces.vertices.push(Vertex {
                    grain,
                    rest: DVec3::ZERO,
                    follows: self.joints.at(column.rod, part, grain.z).to_vec(),
                    cracked: inner,
                    source: Source::Tip {
                        rod: column.rod,
                        parts: [part, beyond],
                        twin: twins.map(|t| t + k as u32).filter(|_| inner),
                    },
                    closed: DVec3::ZERO,
                });
            }
            let prism = complex.prism(a, slab) as u32;
            let start = self.faces.triangles.len() as u32;
            for (triangle, side) in &end.triangles {
                let shows = if inner {
                    Shows::Tip(start + side)
                } else {
                    Shows::End
                };
                let mut corners = triangle.map(|k| match k.checked_sub(n) {
                    Some(tip) => first + tip as u32,
                    None => self.corner(Place {
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
                    shows,
                });
            }
        }
    }

    /// The tips of a broken fibre bundle, which are the hollows of the other side.
    fn tips(&self, a: usize, station: usize) -> Tips {
        let complex = self.complex;
        let column = &complex.columns.columns[a];
        let below = complex.parts[complex.prism(a, station - 1)];
        let breaks = &self.parting.breaks[column.rod as usize];
        let Some(broken) = breaks.get(usize::from(below)) else {
            return Tips::flat(complex, a, station);
        };
        let length = reach(self.wood, column.width(), broken.cause) * self.options.splinters;
        Tips::torn(complex, a, station, length, self.options.seed)
    }

    /// The vertex at a corner of a prism.
    fn corner(&mut self, place: Place) -> u32 {
        let set = self.topology.root(self.complex.number(place));
        if let Some(&known) = self.made.get(&set) {
            return known;
        }
        let corner = self.complex.columns.columns[place.column].corners[place.corner];
        let across = self.complex.columns.corners[corner as usize];
        let new = self.faces.vertices.len() as u32;
        self.faces.vertices.push(Vertex {
            grain: across.extend(self.complex.length(corner, place.station)),
            rest: DVec3::ZERO,
            follows: Vec::new(),
            cracked: false,
            source: Source::Corner(self.complex.number(place)),
            closed: DVec3::ZERO,
        });
        self.sets.push(set);
        self.made.insert(set, new);
        new
    }

    /// Marks vertices that lie at one place with others: they are on cracks.
    fn mark_cracks(&mut self) {
        let mut count: FxHashMap<[u64; 3], u32> = FxHashMap::default();
        let key = |v: &Vertex| v.grain.to_array().map(f64::to_bits);
        for v in &self.faces.vertices {
            *count.entry(key(v)).or_default() += 1;
        }
        for v in &mut self.faces.vertices {
            v.cracked = count[&key(v)] > 1;
        }
    }

    /// Gives every vertex the joints that it follows: the mean of the rods that are bonded there.
    fn bind(&mut self) {
        let complex = self.complex;
        let mut rods: FxHashMap<u32, Vec<(u32, Part)>> = FxHashMap::default();
        let mut of = Vec::with_capacity(self.sets.len());
        for &set in &self.sets {
            let bonded = if set == u32::MAX {
                set
            } else {
                self.bonded.root(set)
            };
            if bonded != u32::MAX {
                rods.entry(bonded).or_default();
            }
            of.push(bonded);
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
                        let set = self.bonded.root(complex.number(Place {
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
        for (v, bonded) in self.faces.vertices.iter_mut().zip(of) {
            let Some(list) = rods.get(&bonded) else {
                continue;
            };
            let share = 1.0 / list.len() as f64;
            let mut follows: Vec<(u32, f64)> = Vec::with_capacity(2 * list.len());
            for &(rod, part) in list {
                for (joint, weight) in self.joints.at(rod, part, v.grain.z) {
                    if weight > 0.0 {
                        follows.push((joint, weight * share));
                    }
                }
            }
            follows.sort_unstable_by_key(|f| f.0);
            v.follows = follows;
        }
    }
}
