//! Positions at rest. Cracks are opened by a hair, so that their two sides stay distinct in every file format and do not pass
//! through each other there.

use super::open_faces::{FaceKind, OpenFaces};
use super::wood::Wood;
use glam::{DVec2, DVec3};

/// Distance of each side of a crack from its middle, as part of the distance between columns.
const GAP: f64 = 2e-4;
/// Least such distance as part of the largest coordinate: 16 times the rounding error of single precision.
const MIN_GAP: f64 = 1e-6;
/// Distances of the bark from the pith, over that of the outline, that are taken for true; elsewhere the outline counts.
const PLAUSIBLE_BARK: (f64, f64) = (0.5, 2.0);
/// Part of its length by which a direction must lead away from each face to be good enough.
const SUFFICIENT_COSINE: f64 = 0.5;
/// Part of the best possible cosine that is good enough too.
const SUFFICIENT_SHARE: f64 = 0.8;
/// Longest offset, in gaps, where faces meet in an edge like a knife's.
const MAX_OFFSET: f64 = 150.0;
/// Offset, in gaps, where no direction leads away from all faces.
const FALLBACK_OFFSET: f64 = 0.2;
/// Most steps of the search for a direction.
const MAX_STEPS: usize = 300;

/// Gives every vertex its position at rest, with cracks opened.
pub(super) fn open_cracks(faces: &mut OpenFaces, wood: &Wood, spacing: f64) {
    let mut largest = 0.0f64;
    for v in &mut faces.vertices {
        v.closed_rest = rest_position(wood, v.grain);
        v.rest = v.closed_rest;
        largest = largest.max(v.closed_rest.abs().max_element());
    }
    let gap = (GAP * spacing).max(MIN_GAP * largest);
    // Corners at vertices on cracks, sorted by vertex.
    let mut corners: Vec<FaceCorner> = Vec::new();
    for triangle in &faces.triangles {
        if matches!(triangle.kind, FaceKind::Bark | FaceKind::End) {
            continue;
        }
        let positions = triangle.corners.map(|v| faces.vertices[v as usize].grain);
        let [a, b, c] = positions;
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        let middle = (a + b + c) / 3.0;
        for (vertex, at) in triangle.corners.into_iter().zip(positions) {
            if faces.vertices[vertex as usize].is_on_crack {
                corners.push(FaceCorner {
                    vertex,
                    normal,
                    to_middle: (middle - at).normalize_or_zero(),
                });
            }
        }
    }
    corners.sort_by_key(|corner| corner.vertex);
    for corners in corners.chunk_by(|a, b| a.vertex == b.vertex) {
        let v = &mut faces.vertices[corners[0].vertex as usize];
        v.grain += inward_offset(corners) * gap;
        v.rest = rest_position(wood, v.grain);
    }
}

/// The corner of a face at a vertex.
struct FaceCorner {
    vertex: u32,
    /// Unit normal of the face.
    normal: DVec3,
    /// Unit direction from the vertex to the face's middle.
    to_middle: DVec3,
}

/// Returns the offset that moves a vertex away from all its faces by 1. Where there is none, as for two faces that face each
/// other, a short offset that keeps coincident vertices distinct.
fn inward_offset(corners: &[FaceCorner]) -> DVec3 {
    // Of all means of the normals the shortest leads away from the worst of them the best (Gilbert 1966).
    let mut mean = corners.iter().map(|c| c.normal).sum::<DVec3>() / corners.len() as f64;
    let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
    for _ in 0..MAX_STEPS {
        let length = mean.length();
        if length < f64::EPSILON {
            break;
        }
        let (cosine, normal) = (corners.iter())
            .map(|c| (c.normal.dot(mean) / length, c.normal))
            .fold(
                (f64::INFINITY, DVec3::ZERO),
                |a, b| if b.0 < a.0 { b } else { a },
            );
        if cosine > best.0 {
            best = (cosine, mean / length);
        }
        if cosine >= SUFFICIENT_COSINE || cosine >= SUFFICIENT_SHARE * length {
            break;
        }
        let step = normal - mean;
        let t = -mean.dot(step) / step.length_squared().max(f64::EPSILON);
        mean += step * t.clamp(0.0, 1.0);
    }
    if best.0 * MAX_OFFSET < 1.0 {
        // Along the faces, so that several such vertices at one position stay distinct.
        let along: DVec3 = corners.iter().map(|c| c.to_middle).sum();
        let direction = (-best.1).try_normalize();
        return FALLBACK_OFFSET * direction.unwrap_or_else(|| along.normalize_or_zero());
    }
    -best.1 / best.0
}

/// Returns the distance from a point inside a closed outline to the farthest crossing in a direction, m.
fn distance_to_outline(outline: &[DVec2], from: DVec2, direction: DVec2) -> Option<f64> {
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

/// Maps grain coordinates of the section to the rods' world at rest. Where there is a bark, the section is stretched along
/// each radius so that its outline lies on it.
fn rest_position(wood: &Wood, grain: DVec3) -> DVec3 {
    let stem = wood.stem;
    let stretched = wood
        .bark
        .filter(|_| stem.kind.has_bark())
        .and_then(|(mesh, tree)| {
            let pith = stem.rings.pith();
            let out = grain.truncate() - pith;
            let r = out.length();
            let outer = distance_to_outline(wood.outline, pith, out)?;
            let origin = stem.grain.to_world(pith.extend(grain.z));
            let end = stem
                .grain
                .to_world((pith + out * (outer / r)).extend(grain.z));
            let (_, t) = tree.first_triangle(mesh, origin, end - origin, PLAUSIBLE_BARK.1)?;
            let is_plausible = t > PLAUSIBLE_BARK.0 && r > 0.0;
            // No stretch in the middle, all of it at the outline.
            is_plausible.then(|| pith + out * (1.0 + (t - 1.0) * (r / outer)))
        });
    let across = stretched.unwrap_or(grain.truncate());
    wood.stem_to_rods
        .transform_point3(stem.grain.to_world(across.extend(grain.z)))
}
