//! Material frames along rods: parallel transport, the curvature binormal, curvature and twist (Bergou 2008, 2010).
//!
//! Each edge carries a **reference director**, a unit vector across it that parallel transport in time moves with the
//! edge, and an angle that turns the reference director into the material director. Twist at a vertex is the difference
//! of the angles of its two edges plus the **reference twist**: the angle from the first reference director, transported
//! across the vertex, to the second.

use glam::DVec3;
use std::f64::consts::TAU;

/// Transports `v` from an edge along `from` to one along `to` (unit vectors) without turning it about them.
///
/// Exactly opposite directions leave `v` unchanged.
pub(crate) fn parallel_transport(v: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let cosine = from.dot(to);
    if cosine <= -1.0 + 1e-12 {
        return v;
    }
    let axis = from.cross(to);
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
}

/// Returns directors across the edges of a rod that are parallel along it. The first is the direction across the first
/// edge that is nearest to `preferred`; any direction where that is `None` or lies along the edge.
pub(crate) fn parallel_directors(edges: &[DVec3], preferred: Option<DVec3>) -> Vec<DVec3> {
    let mut directors: Vec<DVec3> = Vec::with_capacity(edges.len());
    let mut last = DVec3::ZERO;
    for edge in edges {
        let t = edge.normalize_or(DVec3::Z);
        let director = match directors.last() {
            None => {
                let across = preferred.unwrap_or(DVec3::ZERO).reject_from_normalized(t);
                across
                    .try_normalize()
                    .unwrap_or_else(|| t.any_orthonormal_vector())
            }
            Some(&d) => parallel_transport(d, last, t),
        };
        directors.push(
            director
                .reject_from_normalized(t)
                .normalize_or(t.any_orthonormal_vector()),
        );
        last = t;
    }
    directors
}

/// Returns the curvature binormal of two unit tangents, 2 t₋×t₊/(1 + t₋·t₊).
pub(crate) fn curvature_binormal(before: DVec3, after: DVec3) -> DVec3 {
    before.cross(after) * (2.0 / (1.0 + before.dot(after)))
}

/// Returns the curvature (κ₁, κ₂) at a vertex in the mean of its edges' material frames, each given as tangent and first
/// director.
pub(crate) fn curvature((t0, d0): (DVec3, DVec3), (t1, d1): (DVec3, DVec3)) -> [f64; 2] {
    let kb = curvature_binormal(t0, t1);
    let (e0, e1) = (t0.cross(d0), t1.cross(d1));
    [0.5 * kb.dot(e0 + e1), -0.5 * kb.dot(d0 + d1)]
}

/// Returns the angle from `a` to `b` about the unit vector `axis` (rad, −π to π).
pub(crate) fn signed_angle(a: DVec3, b: DVec3, axis: DVec3) -> f64 {
    libm::atan2(a.cross(b).dot(axis), a.dot(b))
}

/// Turns a director by `angle` (rad) about the unit tangent that it is perpendicular to.
pub fn rotate_director(director: DVec3, tangent: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle);
    director * cos + tangent.cross(director) * sin
}

/// Returns the reference twist from the frame of one edge to that of the next, each given as tangent and first director.
/// Of all equivalent angles it is the one nearest to `guess` (rad).
pub(crate) fn reference_twist(
    (t0, d0): (DVec3, DVec3),
    (t1, d1): (DVec3, DVec3),
    guess: f64,
) -> f64 {
    let angle = signed_angle(parallel_transport(d0, t0, t1), d1, t1);
    angle + TAU * ((guess - angle) / TAU).round()
}
