//! Coordinates of bark on wood that is no part of the broken stem: along each limb, and about it.
//!
//! The direction of a limb is the one that its surface's normals vary least in: the eigenvector of the least eigenvalue of their second
//! moments, averaged over neighbours. From one point to the next the frame is carried along without twist (parallel transport; Bergou
//! et al. 2008, § 4.2), and the length along the limb is summed up, then evened out over the mesh.

use super::look::WoodLook;
use super::meshes::{DrawnScene, Shading, Vertex};
use glam::{Mat3, Vec3};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Most points that coordinates are worked out for: more would hold up each change.
const MOST_POINTS: usize = 300_000;
/// Rounds in which neighbours are averaged: enough to see around limbs of coarse meshes, which have a few points around.
const AROUND: usize = 4;
/// Rounds in which lengths are evened out where they met from two sides.
const EVENING: usize = 12;
/// How much finer the bark of a limb may be than that of the stem, and by which power of the radii: bark is thinner on limbs, but seldom
/// in proportion.
const FINEST: f32 = 5.0;
const THINNING: f32 = 0.8;
/// Steps of how little a direction can be told: rounding decides nothing.
const DOUBTS: f32 = 1000.0;
/// Radius of the stem whose bark is that of no stem in particular, m.
const PLAIN_RADIUS: f32 = 0.03;
/// The fourth grain coordinate of what is off the stem: this, over how much finer its bark is. What is on the stem has 1.
const OFF_STEM: f32 = 0.4;

/// A surface, welded at equal positions; its points are in the order of these.
struct Surface {
    positions: Vec<Vec3>,
    /// Sums of the normals of triangles, weighted by areas, and of their second moments.
    normals: Vec<Vec3>,
    moments: Vec<Mat3>,
    /// Neighbours of each point.
    neighbours: Vec<Vec<u32>>,
}

/// A key that orders and tells apart positions.
fn key(position: [f32; 3]) -> [u32; 3] {
    // The order of bits of negative numbers is turned around; −0 is 0.
    position.map(|x| {
        let bits = (x + 0.0).to_bits();
        if bits >> 31 == 1 {
            !bits
        } else {
            bits | 1 << 31
        }
    })
}

impl Surface {
    /// The surface of triangles, and the point of each vertex in them.
    fn new(vertices: &[Vertex], triangles: &[[u32; 3]]) -> Option<(Surface, BTreeMap<u32, u32>)> {
        let mut places = BTreeMap::new();
        for &v in triangles.iter().flatten() {
            places.insert(key(vertices[v as usize].position), v);
        }
        if places.is_empty() || places.len() > MOST_POINTS {
            return None;
        }
        let place = |v: &u32| Vec3::from_array(vertices[*v as usize].position);
        let positions: Vec<Vec3> = places.values().map(place).collect();
        let numbers = places.keys().zip(0..);
        let numbers: BTreeMap<[u32; 3], u32> = numbers.map(|(key, n)| (*key, n)).collect();
        let mut points = BTreeMap::new();
        for &v in triangles.iter().flatten() {
            points
                .entry(v)
                .or_insert_with(|| numbers[&key(vertices[v as usize].position)]);
        }
        let count = positions.len();
        let mut surface = Surface {
            positions,
            normals: vec![Vec3::ZERO; count],
            moments: vec![Mat3::ZERO; count],
            neighbours: vec![Vec::new(); count],
        };
        for corners in triangles {
            let corners = corners.map(|v| points[&v]);
            surface.add(corners);
        }
        for near in &mut surface.neighbours {
            near.sort_unstable();
            near.dedup();
        }
        Some((surface, points))
    }

    fn add(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|i| self.positions[i as usize]);
        let normal = 0.5 * (b - a).cross(c - a);
        let area = normal.length();
        if area == 0.0 {
            return;
        }
        let moment = Mat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        for (i, &point) in corners.iter().enumerate() {
            self.normals[point as usize] += normal;
            self.moments[point as usize] += moment * area.recip();
            let others = [corners[(i + 1) % 3], corners[(i + 2) % 3]];
            self.neighbours[point as usize].extend(others);
        }
    }

    /// Values of points with those of their neighbours, round by round.
    fn averaged<T: Copy + std::ops::Add<Output = T>>(&self, mut values: Vec<T>) -> Vec<T> {
        for _ in 0..AROUND {
            let around = |(i, near): (usize, &Vec<u32>)| {
                near.iter()
                    .fold(values[i], |sum, &j| sum + values[j as usize])
            };
            values = self.neighbours.iter().enumerate().map(around).collect();
        }
        values
    }
}

/// The unit eigenvector of the least eigenvalue of a symmetric matrix without negative ones.
fn least_direction(m: &Mat3) -> Vec3 {
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    if trace <= 0.0 {
        return Vec3::Y;
    }
    // The least of the matrix is the greatest of what is left of its trace; squared again and again, that alone remains.
    let mut power = Mat3::IDENTITY - *m * (1.0 / trace);
    for _ in 0..12 {
        power = power * power;
        let size = power.x_axis.x + power.y_axis.y + power.z_axis.z;
        power *= 1.0 / size.max(f32::MIN_POSITIVE);
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = |a: &&Vec3, b: &&Vec3| a.length_squared().total_cmp(&b.length_squared());
    let found = columns.iter().max_by(longest);
    found.map_or(Vec3::Y, |v| v.normalize_or(Vec3::Y))
}

/// What is known of each point of a limb.
struct Course {
    /// Unit direction of the limb, and one across it.
    along: Vec<Vec3>,
    across: Vec<Vec3>,
    /// How much finer its bark is than the stem's.
    fineness: Vec<f32>,
    /// Length along the limb, in which what is finer counts more, m.
    length: Vec<f32>,
}

impl Course {
    fn step(&self, s: &Surface, i: usize, j: usize) -> f32 {
        let fine = 0.5 * (self.fineness[i] + self.fineness[j]);
        let along = 0.5 * (self.along[i] + self.along[j]);
        fine * along.dot(s.positions[j] - s.positions[i])
    }

    fn new(s: &Surface, normals: &[Vec3], stem_radius: f32) -> (Course, Vec<f32>) {
        let count = s.positions.len();
        let moments = s.averaged(s.moments.clone());
        let along: Vec<Vec3> = moments.iter().map(least_direction).collect();
        // How far apart neighbours are across the limb, over how far their normals turn.
        let spread = |i: usize| {
            let pair = |&j: &u32| {
                let off = s.positions[j as usize] - s.positions[i];
                let off = off - along[i] * along[i].dot(off);
                let turn = normals[j as usize] - normals[i];
                glam::Vec2::new(off.length(), turn.length())
            };
            s.neighbours[i].iter().map(pair).sum::<glam::Vec2>()
        };
        let spreads = s.averaged((0..count).map(spread).collect());
        let radii = spreads
            .iter()
            .map(|s| s.x / s.y.max(1e-3 * s.x).max(f32::MIN_POSITIVE));
        let radii: Vec<f32> = radii.collect();
        let finer = |r: &f32| {
            (stem_radius / r.max(1e-6))
                .powf(THINNING)
                .clamp(1.0, FINEST)
        };
        let mut course = Course {
            along,
            across: vec![Vec3::ZERO; count],
            fineness: radii.iter().map(finer).collect(),
            length: vec![0.0; count],
        };
        // How little the direction of a limb can be told, as at its ends: from where that is plain, lengths are counted on.
        let doubt = |i: usize| {
            let (m, along) = (&moments[i], course.along[i]);
            let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
            let share = along.dot(*m * along) / trace.max(f32::MIN_POSITIVE);
            (share.clamp(0.0, 1.0) * DOUBTS) as u32
        };
        let doubts: Vec<u32> = (0..count).map(doubt).collect();
        let mut seeds: Vec<usize> = (0..count).collect();
        seeds.sort_by_key(|&i| (doubts[i], i));
        let mut is_known = vec![false; count];
        let mut queue = BinaryHeap::new();
        for seed in seeds {
            if is_known[seed] {
                continue;
            }
            is_known[seed] = true;
            course.across[seed] = course.along[seed].any_orthonormal_vector();
            queue.push(Reverse((doubts[seed], seed)));
            while let Some(Reverse((_, i))) = queue.pop() {
                for j in s.neighbours[i].iter().map(|&j| j as usize) {
                    if is_known[j] {
                        continue;
                    }
                    is_known[j] = true;
                    if course.along[j].dot(course.along[i]) < 0.0 {
                        course.along[j] = -course.along[j];
                    }
                    let (across, along) = (course.across[i], course.along[j]);
                    let carried = across - along * along.dot(across);
                    course.across[j] = carried.normalize_or(along.any_orthonormal_vector());
                    course.length[j] = course.length[i] + course.step(s, i, j);
                    queue.push(Reverse((doubts[j], j)));
                }
            }
        }
        for _ in 0..EVENING {
            let even = |i: usize| {
                let near = s.neighbours[i].iter().map(|&j| j as usize);
                let sum = near.map(|j| course.length[j] + course.step(s, j, i));
                sum.sum::<f32>() / s.neighbours[i].len().max(1) as f32
            };
            course.length = (0..count).map(even).collect();
        }
        (course, radii)
    }
}

impl DrawnScene {
    /// Gives the skin that is no part of the stem coordinates along its limbs, in place of grain coordinates. Where a triangle is part of
    /// both, it gets vertices of its own on the stem's side, after all others.
    pub(super) fn place_limbs(&mut self) {
        let mut own: BTreeMap<u32, u32> = BTreeMap::new();
        let mut triangles = Vec::new();
        for batch in self.batches.iter().filter(|b| b.shading == Shading::Skin) {
            let (first, last) = (batch.first as usize, (batch.first + batch.count) as usize);
            for corners in self.indices[first..last].as_chunks_mut::<3>().0 {
                let off = corners.map(|v| self.vertices[v as usize].grain[3] < 0.5);
                if off == [false; 3] {
                    continue;
                }
                for (v, _) in corners.iter_mut().zip(off).filter(|(_, is_off)| !is_off) {
                    *v = *own.entry(*v).or_insert_with(|| {
                        let mut copy = self.vertices[*v as usize];
                        copy.grain = [0.0; 4];
                        self.vertices.push(copy);
                        self.vertices.len() as u32 - 1
                    });
                }
                triangles.push(*corners);
            }
        }
        let Some((surface, points)) = Surface::new(&self.vertices, &triangles) else {
            return;
        };
        let known = self.woods.first().filter(|_| !self.breaks.is_empty());
        let stem_radius = known.map_or(PLAIN_RADIUS, WoodLook::stem_radius);
        let normals = surface.normals.iter().map(|n| n.normalize_or_zero());
        let normals: Vec<Vec3> = normals.collect();
        let (course, radii) = Course::new(&surface, &normals, stem_radius);
        for (vertex, point) in points {
            let i = point as usize;
            let (along, across, fine) = (course.along[i], course.across[i], course.fineness[i]);
            let about = [normals[i].dot(across), normals[i].dot(along.cross(across))];
            let [x, y] = about.map(|part| part * radii[i] * fine);
            self.vertices[vertex as usize].grain = [x, y, course.length[i], OFF_STEM / fine];
        }
    }
}
