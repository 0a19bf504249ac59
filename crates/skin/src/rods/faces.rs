//! The faces that lie open, as triangles over vertices that know where they are in the wood and which rods they follow.

use super::complex::{Complex, Place, reach};
use super::joints::Joints;
use super::parting::{Part, Parting};
use super::section::OUTSIDE;
use super::{RodSkinOptions, Wood};
use glam::{DVec2, DVec3};
use greenstick_geometry::Unions;
use greenstick_wood::noise::unit;
use greenstick_wood::stem::StemKind;
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
    /// The broken end of a fibre bundle.
    Tip,
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

/// The sides of a crack lie this part of the distance between columns apart at rest, so that they are two in every file.
const KERF: f64 = 2e-4;
/// Height of a fibre bundle's tip, in lengths of pull-out: least, and most on top.
const TIP: [f64; 2] = [0.3, 1.0];
/// How far a tip lies off the middle, in half widths.
const LEAN: f64 = 0.45;
/// The bark lies between these parts of where the outline says; elsewhere the outline is believed.
const BELIEVED: (f64, f64) = (0.5, 2.0);

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
        let lengths = column.corners.iter().map(|&c| complex.length(c, station));
        let mean = lengths.sum::<f64>() / n as f64;
        let apex = if inner {
            self.tip(a, station, mean)
        } else {
            column.centre.extend(mean)
        };
        for above in [false, true] {
            let slab = if above {
                station
            } else {
                station.wrapping_sub(1)
            };
            if slab >= complex.slabs() {
                continue;
            }
            let centre = self.faces.vertices.len() as u32;
            self.sets.push(u32::MAX);
            let grain = apex;
            let part = complex.parts[complex.prism(a, slab)];
            self.faces.vertices.push(Vertex {
                grain,
                rest: DVec3::ZERO,
                follows: self.joints.at(column.rod, part, grain.z).to_vec(),
                cracked: inner,
            });
            let prism = complex.prism(a, slab) as u32;
            let shows = if inner { Shows::Tip } else { Shows::End };
            for corner in 0..n {
                let at = |corner| Place {
                    column: a,
                    corner,
                    station,
                    above,
                };
                let (p, q) = (self.corner(at(corner)), self.corner(at((corner + 1) % n)));
                let corners = if above {
                    [q, p, centre]
                } else {
                    [p, q, centre]
                };
                self.faces.triangles.push(Triangle {
                    corners,
                    prism,
                    shows,
                });
            }
        }
    }

    /// Where the tip of a broken fibre bundle lies, which is where the hollow of the other side ends.
    fn tip(&self, a: usize, station: usize, mean: f64) -> DVec3 {
        let complex = self.complex;
        let column = &complex.columns.columns[a];
        let below = complex.parts[complex.prism(a, station - 1)];
        let breaks = &self.parting.breaks[column.rod as usize];
        let Some(broken) = breaks.get(usize::from(below)) else {
            return column.centre.extend(mean);
        };
        let random = |what: u64| unit(self.options.seed ^ what, a as i64, station as i64, 0);
        let length = reach(self.wood, column.width(), broken.cause) * self.options.splinters;
        let height = length * (TIP[0] + TIP[1] * random(0x71b) * random(0x71c));
        let up = random(0x71d) < 0.5;
        // Within the prisms up to the next break of the column.
        let end = if up {
            (station + 1..=complex.slabs()).find(|&s| !complex.is_whole(a, s))
        } else {
            (0..station).rev().find(|&s| !complex.is_whole(a, s))
        };
        let slab = complex.stations[1] - complex.stations[0];
        let room = end.map_or(0.0, |s| (complex.stations[s] - mean).abs() - slab);
        let height = height.min(room.max(0.0));
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * random(0x71e));
        let lean = DVec2::new(cos, sin) * (LEAN * 0.5 * column.width() * random(0x71f));
        let across = if inside(
            column
                .corners
                .iter()
                .map(|&c| complex.columns.corners[c as usize]),
            column.centre + lean,
        ) {
            column.centre + lean
        } else {
            column.centre
        };
        across.extend(mean + if up { height } else { -height })
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

/// Opens cracks by a hair, so that their sides are two in every file, and gives every vertex its place at rest.
pub(super) fn put(faces: &mut Faces, wood: &Wood, spacing: f64) {
    let mut inward = vec![DVec3::ZERO; faces.vertices.len()];
    for triangle in &faces.triangles {
        if matches!(triangle.shows, Shows::Bark | Shows::End) {
            continue;
        }
        let corners = triangle.corners.map(|v| faces.vertices[v as usize].grain);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for k in 0..3 {
            let (p, q, r) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            inward[triangle.corners[k] as usize] -= normal * (q - p).angle_between(r - p);
        }
    }
    for (v, inward) in faces.vertices.iter_mut().zip(inward) {
        if v.cracked && inward.is_finite() {
            v.grain += inward * (KERF * spacing / inward.length().max(1.0));
        }
        v.rest = place(wood, v.grain);
    }
}

/// Whether a place is inside of a convex polygon with counter-clockwise corners.
fn inside(corners: impl Iterator<Item = DVec2> + Clone, p: DVec2) -> bool {
    let next = corners.clone().cycle().skip(1);
    corners
        .zip(next)
        .all(|(a, b)| (b - a).perp_dot(p - a) > 0.0)
}

/// How far a closed outline is from a place within it in a direction, m; the farthest crossing.
fn outline_at(outline: &[DVec2], from: DVec2, direction: DVec2) -> Option<f64> {
    let direction = direction.try_normalize()?;
    let across = |p: DVec2| direction.perp_dot(p - from);
    let next = outline.iter().cycle().skip(1);
    let crossed = outline.iter().zip(next).filter_map(|(&a, &b)| {
        let (h, k) = (across(a), across(b));
        let crosses = (h > 0.0) != (k > 0.0);
        crosses.then(|| direction.dot(a.lerp(b, h / (h - k)) - from))
    });
    crossed.filter(|&r| r > 0.0).max_by(f64::total_cmp)
}

/// A place in grain coordinates of the section as one in the rods' world at rest. Where there is a bark the section is
/// stretched along each radius so that its outline lies on it.
fn place(wood: &Wood, grain: DVec3) -> DVec3 {
    let stem = wood.stem;
    let stretched = wood
        .bark
        .filter(|_| stem.kind == StemKind::Round)
        .and_then(|(mesh, tree)| {
            let pith = stem.rings.pith();
            let out = grain.truncate() - pith;
            let r = out.length();
            let outer = outline_at(wood.outline, pith, out)?;
            let origin = stem.grain.to_world(pith.extend(grain.z));
            let end = stem
                .grain
                .to_world((pith + out * (outer / r)).extend(grain.z));
            let (_, t) = tree.first_triangle(mesh, origin, end - origin, BELIEVED.1)?;
            let believed = t > BELIEVED.0 && r > 0.0;
            // Nothing in the middle, all at the outline.
            believed.then(|| pith + out * (1.0 + (t - 1.0) * (r / outer)))
        });
    let across = stretched.unwrap_or(grain.truncate());
    wood.laid
        .transform_point3(stem.grain.to_world(across.extend(grain.z)))
}
