//! Meshes made from nothing: the built-in branch, and plain boards and cylinders.
//!
//! Only + − × ÷, square roots and the pure-Rust `libm` are used: the same bits on every machine.

use crate::noise::smoothstep;
use crate::stem::Axis;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Attribute, Mesh};
use std::f64::consts::TAU;

/// What the built-in branch is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchOptions {
    /// Length along its axis, m.
    pub length: f64,
    /// Diameter in the middle, m.
    pub diameter: f64,
    /// Strength of the bark's relief; 1 for furrows of about 6 % of the radius, 0 for none.
    pub relief: f64,
    /// Vertices around; rows along the branch are 2.8 times as far apart, as furrows run along it.
    pub around: u32,
    /// Chooses the bend, knots and furrows.
    pub seed: u64,
}

impl Default for BranchOptions {
    fn default() -> Self {
        BranchOptions {
            length: 0.6,
            diameter: 0.04,
            relief: 1.0,
            around: 104,
            seed: 7,
        }
    }
}

/// A number in 0 to 1 for a place, by the finaliser of MurmurHash3 over its words.
fn hash(seed: u64, purpose: u64, x: i64, y: i64) -> f64 {
    let mut h = seed ^ purpose.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for word in [x as u64, y as u64] {
        h = (h ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd);
        h = (h ^ (h >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        h ^= h >> 33;
    }
    (h >> 11) as f64 / (1u64 << 53) as f64
}

/// Smooth noise in −1 to 1 that repeats in x after `period` cells.
fn noise(seed: u64, purpose: u64, x: f64, y: f64, period: i64) -> f64 {
    let (i, j) = (x.floor(), y.floor());
    let (u, v) = (x - i, y - j);
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let at = |a: i64, b: i64| {
        2.0 * hash(
            seed,
            purpose,
            (i as i64 + a).rem_euclid(period),
            j as i64 + b,
        ) - 1.0
    };
    let (u, v) = (fade(u), fade(v));
    let (low, high) = (
        at(0, 0) + (at(1, 0) - at(0, 0)) * u,
        at(0, 1) + (at(1, 1) - at(0, 1)) * u,
    );
    low + (high - low) * v
}

/// Distance (cells) to the border between the two nearest of scattered cells: 0 on the border (Worley 1996).
fn border(seed: u64, purpose: u64, x: f64, y: f64, period: i64) -> f64 {
    let (i, j) = (x.floor() as i64, y.floor() as i64);
    let (mut first, mut second) = (f64::INFINITY, f64::INFINITY);
    let mut visit = |a: i64, b: i64| {
        let (ci, cj) = (i + a, j + b);
        let key = ci.rem_euclid(period);
        let px = ci as f64 + hash(seed, purpose, key, cj);
        let py = cj as f64 + hash(seed, purpose + 1, key, cj);
        let d = ((px - x) * (px - x) + (py - y) * (py - y)).sqrt();
        if d < first {
            (first, second) = (d, first);
        } else if d < second {
            second = d;
        }
        second
    };
    let mut near = f64::INFINITY;
    for a in -1..=1 {
        for b in -1..=1 {
            near = visit(a, b);
        }
    }
    // What is in the cells beyond is at least a cell away.
    if near >= 1.0 {
        for a in -2_i64..=2 {
            for b in -2_i64..=2 {
                if a.abs().max(b.abs()) == 2 {
                    visit(a, b);
                }
            }
        }
    }
    second - first
}

/// The built-in branch: bent in space, tapered, with furrowed bark, some knots and flat sawn ends. It begins at the
/// origin and grows along +y. `NORMAL` and `TEXCOORD_0` (u from 0 to 1 around; v in circumferences of the branch, so that
/// a square picture stays square) are set, without materials. Empty where the length is not a positive number.
pub fn branch(options: &BranchOptions) -> Mesh {
    let around = options.around.max(8) as usize;
    const STRETCH: f64 = 2.8;
    let radius = 0.5 * options.diameter;
    let Some(axis) = bent_axis(options) else {
        return Mesh::default();
    };
    let length = axis.length();
    let rows = ((length / (radius * TAU / around as f64 * STRETCH)).round() as usize).max(4);
    let at = |i: usize, j: usize| {
        let (s, turn) = (
            length * i as f64 / rows as f64,
            (j % around) as f64 / around as f64,
        );
        let frame = axis.frame(s);
        let (sin, cos) = libm::sincos(TAU * turn);
        let r = bark_radius(options, s / length, turn);
        frame.origin + (frame.x * cos + frame.y * sin) * r
    };
    let mut mesh = Mesh::default();
    let mut uv: Vec<f32> = Vec::new();
    for i in 0..=rows {
        for j in 0..=around {
            mesh.positions.push(at(i, j));
            let v = length * i as f64 / rows as f64 / (TAU * radius);
            uv.extend([(j as f64 / around as f64) as f32, v as f32]);
        }
    }
    let wide = around as u32 + 1;
    for i in 0..rows as u32 {
        for j in 0..around as u32 {
            let (a, b) = (i * wide + j, (i + 1) * wide + j);
            mesh.triangles.push([a, a + 1, b + 1]);
            mesh.triangles.push([a, b + 1, b]);
        }
    }
    let mut normals = side_normals(&mesh, around, rows);
    for (end, s) in [(0, 0.0), (rows, length)] {
        let frame = axis.frame(s);
        let normal = if end == 0 {
            -frame.tangent
        } else {
            frame.tangent
        };
        let rim: Vec<DVec3> = (0..around).map(|j| at(end, j)).collect();
        cap(
            &mut mesh,
            &mut uv,
            &mut normals,
            &rim,
            (frame.origin, normal),
            end != 0,
        );
    }
    finish(mesh, uv, normals)
}

/// Centreline of the branch: a slow bend with smaller ones on it, and none at the very ends.
fn bent_axis(options: &BranchOptions) -> Option<Axis> {
    const POINTS: usize = 96;
    let (length, seed) = (options.length, options.seed);
    let mut direction = DVec3::Y;
    let mut p = DVec3::ZERO;
    let mut points = vec![p];
    let step = length / POINTS as f64;
    for i in 0..POINTS {
        let t = (i as f64 + 0.5) / POINTS as f64;
        // Curvature in turns per length: 1.1 rad over the whole at most, in directions that wander.
        let ends = 4.0 * t * (1.0 - t);
        let turn = |purpose: u64| {
            0.55 * noise(seed, purpose, 1.7 * t + 0.3, 0.5, 1 << 20)
                + 0.5 * noise(seed, purpose, 4.6 * t + 9.1, 7.5, 1 << 20)
        };
        let bend = DVec3::new(0.55 + turn(11), 0.0, turn(12)) * (1.1 * ends / POINTS as f64);
        direction = (direction + bend).normalize();
        p += direction * step;
        points.push(p);
    }
    Axis::new(&points, Some(DVec3::X))
}

/// Share of the bark's relief that is left at the rim of an end, and the length over which it fades, radii.
const RIM_RELIEF: f64 = 0.3;
const RIM_LENGTH: f64 = 0.8;

/// Radius (m) of the branch's bark at fractions of its length and of a turn.
fn bark_radius(options: &BranchOptions, along: f64, turn: f64) -> f64 {
    let seed = options.seed;
    let radius = 0.5 * options.diameter;
    let slim = options.length / radius;
    // Height in units of the radius, so that furrows keep their shape whatever the branch's size.
    let z = along * slim;
    let taper = 1.16 - 0.32 * along;
    // The section is no circle and changes slowly along the branch.
    let oval = 0.035 * noise(seed, 21, turn * 3.0, z * 0.12, 3)
        + 0.02 * noise(seed, 22, turn * 5.0, z * 0.25, 5);
    // Swellings where twigs were.
    let mut knots = 0.0;
    for k in 0..5 {
        let at = (0.12 + 0.19 * k as f64 + 0.1 * hash(seed, 31, k, 0)) * slim;
        let mut side = turn - hash(seed, 31, k, 1);
        side -= side.round();
        let size = 0.35 + 0.3 * hash(seed, 31, k, 2);
        let (a, b) = (TAU * side / size, (z - at) / (1.3 * size));
        let d = a * a + b * b;
        let bump = 1.0 / ((1.0 + d) * (1.0 + d));
        knots += bump * (0.08 + 0.1 * hash(seed, 31, k, 3));
        // The scar itself: a dimple in the swelling.
        knots -= 0.07 / ((1.0 + 9.0 * d) * (1.0 + 9.0 * d));
    }
    let (coarse, fine) = furrows(options, along, turn);
    let depth = 0.75 + 0.5 * noise(seed, 71, turn * 3.0, z * 0.3, 3);
    let grain = noise(seed, 72, turn * 110.0, z * 3.1, 110);
    let relief = 0.06 * depth * (coarse - 0.7) + 0.02 * (fine - 0.6) + 0.006 * grain;
    // A saw rubs off the crests of the bark beside it: the rim of an end is rounder than the bark.
    let from_end = along.min(1.0 - along) * slim;
    let relief = relief * (RIM_RELIEF + (1.0 - RIM_RELIEF) * smoothstep(0.0, RIM_LENGTH, from_end));
    radius * taper * (1.0 + oval + options.relief * (0.6 * knots + relief))
}

/// How far a place is from the coarse and from the fine furrows of the bark, 0 (in one) to 1.
fn furrows(options: &BranchOptions, along: f64, turn: f64) -> (f64, f64) {
    let seed = options.seed;
    let z = along * (options.length / (0.5 * options.diameter));
    // Furrows: borders of cells drawn out along the grain, shifted to and fro so that no two run alike.
    let shift = 0.06 * noise(seed, 41, turn * 4.0, z * 0.5, 4)
        + 0.015 * noise(seed, 42, turn * 16.0, z * 1.7, 16);
    let plate = |purpose: u64, cells: i64, stretch: f64| {
        let edge = border(
            seed,
            purpose,
            (turn + shift) * cells as f64,
            z * stretch,
            cells,
        );
        let width = (edge * 2.6).min(1.0);
        width * (2.0 - width)
    };
    (plate(51, 17, 0.55), plate(61, 31, 1.4))
}

/// Area-weighted normals of a tube of `rows` × `around` quads, equal on both sides of its seam.
fn side_normals(mesh: &Mesh, around: usize, rows: usize) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        let n = (b - a).cross(c - a);
        corners.iter().for_each(|&i| normals[i as usize] += n);
    }
    for i in 0..=rows {
        let (a, b) = (i * (around + 1), i * (around + 1) + around);
        let sum = normals[a] + normals[b];
        (normals[a], normals[b]) = (sum, sum);
    }
    normals.iter().map(|n| n.normalize_or(DVec3::Y)).collect()
}

/// A flat end as rings of triangles towards the middle, so that no triangle is a long sliver.
fn cap(
    mesh: &mut Mesh,
    uv: &mut Vec<f32>,
    normals: &mut Vec<DVec3>,
    rim: &[DVec3],
    (middle, normal): (DVec3, DVec3),
    turned: bool,
) {
    const RINGS: usize = 4;
    let count = rim.len() as u32;
    let first = mesh.positions.len() as u32;
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let size = rim
        .iter()
        .map(|p| p.distance(middle))
        .fold(0.0, f64::max)
        .max(f64::MIN_POSITIVE);
    let mut push = |p: DVec3| {
        mesh.positions.push(p);
        normals.push(normal);
        let q = DVec2::new((p - middle).dot(x), (p - middle).dot(y)) / (2.0 * size) + 0.5;
        uv.extend([q.x as f32, q.y as f32]);
    };
    for ring in 0..RINGS {
        for &p in rim {
            let t = ring as f64 / RINGS as f64;
            push(if ring == 0 { p } else { p + (middle - p) * t });
        }
    }
    push(middle);
    let mut add = |a: u32, b: u32, c: u32| {
        mesh.triangles
            .push(if turned { [a, b, c] } else { [a, c, b] });
    };
    for ring in 0..RINGS as u32 {
        for j in 0..count {
            let (a, b) = (
                first + ring * count + j,
                first + ring * count + (j + 1) % count,
            );
            if ring + 1 == RINGS as u32 {
                add(a, b, first + RINGS as u32 * count);
            } else {
                add(a, b, b + count);
                add(a, b + count, a + count);
            }
        }
    }
}

fn finish(mut mesh: Mesh, uv: Vec<f32>, normals: Vec<DVec3>) -> Mesh {
    let data = normals
        .iter()
        .flat_map(|n| n.as_vec3().to_array())
        .collect();
    mesh.attributes
        .insert("NORMAL".to_owned(), Attribute { width: 3, data });
    mesh.attributes
        .insert("TEXCOORD_0".to_owned(), Attribute { width: 2, data: uv });
    mesh
}

/// A closed board of six rectangles: length along z, width along x, thickness along y (m), its middle at the origin.
/// Faces are divided into squares of about the thickness, at most 64 along an edge.
pub fn board(length: f64, width: f64, thickness: f64) -> Mesh {
    let size = DVec3::new(width, thickness, length);
    let count = (size / thickness)
        .to_array()
        .map(|n| n.round().clamp(1.0, 64.0) as u32);
    let mut mesh = Mesh::default();
    let (mut uv, mut normals) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let first = mesh.positions.len() as u32;
            for i in 0..=count[u] {
                for j in 0..=count[v] {
                    let mut p = DVec3::ZERO;
                    p[axis] = side * 0.5 * size[axis];
                    p[u] = size[u] * (f64::from(i) / f64::from(count[u]) - 0.5);
                    p[v] = size[v] * (f64::from(j) / f64::from(count[v]) - 0.5);
                    mesh.positions.push(p);
                    let mut normal = DVec3::ZERO;
                    normal[axis] = side;
                    normals.push(normal);
                    uv.extend([p[u] as f32, p[v] as f32]);
                }
            }
            for i in 0..count[u] {
                for j in 0..count[v] {
                    let a = first + i * (count[v] + 1) + j;
                    let (b, c, d) = (a + count[v] + 1, a + count[v] + 2, a + 1);
                    let turn = |t: [u32; 3]| if side > 0.0 { t } else { [t[0], t[2], t[1]] };
                    mesh.triangles.extend([turn([a, b, c]), turn([a, c, d])]);
                }
            }
        }
    }
    finish(mesh, uv, normals)
}

/// A closed cylinder from the origin along +y (m), with `around` sides and rows about as high as they are wide.
pub fn cylinder(radius: f64, length: f64, around: u32) -> Mesh {
    let square = length * f64::from(around.max(3)) / (TAU * radius);
    cylinder_of(radius, length, around, square.round() as u32)
}

/// A [`cylinder`] whose side has `rows` quadrilaterals along it, 1 to 4096.
pub fn cylinder_of(radius: f64, length: f64, around: u32, rows: u32) -> Mesh {
    let around = around.max(3) as usize;
    let rows = rows.clamp(1, 4096) as usize;
    let mut mesh = Mesh::default();
    let mut uv = Vec::new();
    let at = |i: usize, j: usize| {
        let (sin, cos) = libm::sincos(TAU * (j % around) as f64 / around as f64);
        DVec3::new(radius * sin, length * i as f64 / rows as f64, radius * cos)
    };
    for i in 0..=rows {
        for j in 0..=around {
            mesh.positions.push(at(i, j));
            let v = length * i as f64 / rows as f64 / (TAU * radius);
            uv.extend([(j as f64 / around as f64) as f32, v as f32]);
        }
    }
    let wide = around as u32 + 1;
    for i in 0..rows as u32 {
        for j in 0..around as u32 {
            let (a, b) = (i * wide + j, (i + 1) * wide + j);
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    let mut normals = side_normals(&mesh, around, rows);
    for (row, normal) in [(0, DVec3::NEG_Y), (rows, DVec3::Y)] {
        let rim: Vec<DVec3> = (0..around).map(|j| at(row, j)).collect();
        let middle = DVec3::new(0.0, length * row as f64 / rows as f64, 0.0);
        cap(
            &mut mesh,
            &mut uv,
            &mut normals,
            &rim,
            (middle, normal),
            row != 0,
        );
    }
    finish(mesh, uv, normals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Every edge once in each direction between points.
    fn closed(mesh: &Mesh) -> bool {
        let (points, _) = mesh.points();
        let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                let (a, b) = (points[t[k] as usize], points[t[(k + 1) % 3] as usize]);
                *edges.entry((a, b)).or_default() += 1;
            }
        }
        edges
            .iter()
            .all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }

    #[test]
    fn primitives_are_closed_and_have_their_size() {
        let b = board(0.9, 0.2, 0.03);
        assert!(closed(&b) && (b.volume() - 0.9 * 0.2 * 0.03).abs() < 1e-12);
        let c = cylinder(0.1, 1.0, 48);
        let area = 0.5 * 48.0 * 0.01 * (TAU / 48.0).sin();
        assert!(closed(&c) && (c.volume() - area).abs() < 1e-12);
        let branch = branch(&BranchOptions::default());
        let count = branch.triangles.len();
        assert!(
            closed(&branch) && (20_000..40_000).contains(&count),
            "{count}"
        );
        // A tapered branch of 0.6 m and 4 cm.
        assert!((branch.volume() / (0.6 * TAU / 2.0 * 4e-4) - 1.0).abs() < 0.1);
        let normals = &branch.attributes["NORMAL"];
        for i in 0..branch.positions.len() {
            let n = normals.at(i);
            assert!((n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_branch_is_the_same_everywhere() {
        // FNV-1a over all position bits; differs if any machine's arithmetic does.
        let digest = branch(&BranchOptions::default())
            .positions
            .iter()
            .flat_map(|p| p.to_array())
            .fold(0xcbf2_9ce4_8422_2325_u64, |h, c| {
                (h ^ c.to_bits()).wrapping_mul(0x100_0000_01b3)
            });
        assert_eq!(digest, DIGEST);
    }

    const DIGEST: u64 = 1_178_509_892_513_809_040;
}
