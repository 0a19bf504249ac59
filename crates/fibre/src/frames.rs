//! Frames along rods: parallel transport, the curvature binormal, curvature and twist (Bergou 2008, 2010).
//!
//! Each edge carries a **reference director**, a unit vector across it, that is moved with the edge by parallel transport
//! in time, and an angle by which the material frame is turned from it. Twist at a vertex is the difference of the
//! angles of its two edges plus the **reference twist**: the angle from the first reference director, carried across the
//! vertex, to the second.

use glam::DVec3;

/// `v` carried from an edge along `from` to one along `to` (unit vectors) without turning about them.
///
/// Directions that are exactly opposite leave `v` as it is.
pub fn transport(v: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let cosine = from.dot(to);
    if cosine <= -1.0 + 1e-12 {
        return v;
    }
    let axis = from.cross(to);
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
}

/// Directors across the edges of a rod, parallel along it. The first is the one across the first edge nearest to
/// `wanted`; any where that is `None` or lies along the edge.
pub fn parallel_along(edges: &[DVec3], wanted: Option<DVec3>) -> Vec<DVec3> {
    let mut made: Vec<DVec3> = Vec::with_capacity(edges.len());
    let mut last = DVec3::ZERO;
    for edge in edges {
        let t = edge.normalize_or(DVec3::Z);
        let director = match made.last() {
            None => {
                let across = wanted.unwrap_or(DVec3::ZERO).reject_from_normalized(t);
                across
                    .try_normalize()
                    .unwrap_or_else(|| t.any_orthonormal_vector())
            }
            Some(&d) => transport(d, last, t),
        };
        made.push(
            director
                .reject_from_normalized(t)
                .normalize_or(t.any_orthonormal_vector()),
        );
        last = t;
    }
    made
}

/// Curvature binormal of two unit tangents: 2 t₋×t₊/(1 + t₋·t₊).
pub fn binormal(before: DVec3, after: DVec3) -> DVec3 {
    before.cross(after) * (2.0 / (1.0 + before.dot(after)))
}

/// Curvature (κ₁, κ₂) at a vertex in the mean of its edges' material frames, each given as tangent and first director.
pub fn curvature((t0, d0): (DVec3, DVec3), (t1, d1): (DVec3, DVec3)) -> [f64; 2] {
    let kb = binormal(t0, t1);
    let (e0, e1) = (t0.cross(d0), t1.cross(d1));
    [0.5 * kb.dot(e0 + e1), -0.5 * kb.dot(d0 + d1)]
}

/// Angle from `a` to `b` about the unit vector `about` (rad, −π to π).
pub fn angle_about(a: DVec3, b: DVec3, about: DVec3) -> f64 {
    libm::atan2(a.cross(b).dot(about), a.dot(b))
}

/// The director turned by `angle` (rad) about the unit tangent it is across.
pub fn turned(director: DVec3, tangent: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(angle);
    director * cos + tangent.cross(director) * sin
}

/// Reference twist from the frame of one edge to that of the next, the turn nearest to `guess` (rad).
pub fn reference_twist((t0, d0): (DVec3, DVec3), (t1, d1): (DVec3, DVec3), guess: f64) -> f64 {
    let carried = turned(transport(d0, t0, t1), t1, guess);
    guess + angle_about(carried, d1, t1)
}
