//! Where vertices rest: cracks are opened by a hair, so that their sides are two in every file and do not pass through each
//! other there.

use super::Wood;
use super::faces::{Faces, Shows};
use glam::{DVec2, DVec3};
use greenstick_wood::stem::StemKind;

/// The sides of a crack lie this part of the distance between columns from where it is.
const KERF: f64 = 2e-4;
/// They lie at least this part of the largest coordinate from it, which is 16 times what single precision rounds by.
const ROUNDING: f64 = 1e-6;
/// The bark lies between these parts of where the outline says; elsewhere the outline is believed.
const BELIEVED: (f64, f64) = (0.5, 2.0);
/// A way that leads away from each face by this part of its length is good enough.
const AWAY: f64 = 0.5;
/// And so is one that does so by this part of the best.
const NEARLY: f64 = 0.8;
/// The longest way, where faces meet in an edge like a knife's.
const FARTHEST: f64 = 150.0;
/// Length of the way where none leads from all faces.
const SHORT: f64 = 0.2;
/// Rounds in which a way is looked for.
const ROUNDS: usize = 300;

/// Opens cracks, and gives every vertex its place at rest.
pub(super) fn put(faces: &mut Faces, wood: &Wood, spacing: f64) {
    let mut far = 0.0f64;
    for v in &mut faces.vertices {
        v.closed = place(wood, v.grain);
        v.rest = v.closed;
        far = far.max(v.closed.abs().max_element());
    }
    let kerf = (KERF * spacing).max(ROUNDING * far);
    // Normals of the faces at each vertex that lies on a crack, of which those at one place come behind each other.
    let mut normals: Vec<At> = Vec::new();
    for triangle in &faces.triangles {
        if matches!(triangle.shows, Shows::Bark | Shows::End) {
            continue;
        }
        let places = triangle.corners.map(|v| faces.vertices[v as usize].grain);
        let [a, b, c] = places;
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        let middle = (a + b + c) / 3.0;
        for (v, at) in triangle.corners.into_iter().zip(places) {
            if faces.vertices[v as usize].cracked {
                normals.push((v, normal, (middle - at).normalize_or_zero()));
            }
        }
    }
    normals.sort_by_key(|n| n.0);
    for of in normals.chunk_by(|a, b| a.0 == b.0) {
        let v = &mut faces.vertices[of[0].0 as usize];
        v.grain += inward(of) * kerf;
        v.rest = place(wood, v.grain);
    }
}

/// A vertex, the normal of a face there, and the way to the face's middle.
type At = (u32, DVec3, DVec3);

/// The way that leads from all faces with these normals by 1; a short one, that makes two vertices of what lies at one place,
/// where there is none, as from two faces that face each other.
fn inward(normals: &[At]) -> DVec3 {
    // Of all means of the normals the shortest leads away from the worst of them the best (Gilbert 1966).
    let mut mean = normals.iter().map(|n| n.1).sum::<DVec3>() / normals.len() as f64;
    let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
    for _ in 0..ROUNDS {
        let length = mean.length();
        if length < f64::EPSILON {
            break;
        }
        let (away, normal) = (normals.iter())
            .map(|n| (n.1.dot(mean) / length, n.1))
            .fold(
                (f64::INFINITY, DVec3::ZERO),
                |a, b| if b.0 < a.0 { b } else { a },
            );
        if away > best.0 {
            best = (away, mean / length);
        }
        if away >= AWAY || away >= NEARLY * length {
            break;
        }
        let step = normal - mean;
        let t = -mean.dot(step) / step.length_squared().max(f64::EPSILON);
        mean += step * t.clamp(0.0, 1.0);
    }
    if best.0 * FARTHEST < 1.0 {
        // Along them, so that several such vertices at one place are not one.
        let along: DVec3 = normals.iter().map(|n| n.2).sum();
        let way = (-best.1).try_normalize();
        return SHORT * way.unwrap_or_else(|| along.normalize_or_zero());
    }
    -best.1 / best.0
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
