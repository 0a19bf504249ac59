//! Triangles in one plane, compared in a projection along an axis, which changes no side of any line.

use super::{Contact, orient2d};
use glam::{DVec2, DVec3};

/// `p` without its coordinate `drop`.
pub(super) fn flatten(p: DVec3, drop: usize) -> DVec2 {
    DVec2::new(p[(drop + 1) % 3], p[(drop + 2) % 3])
}

/// The triangle without coordinate `drop`, counter-clockwise; `None` where it has no area then.
pub(super) fn project(t: &[DVec3; 3], drop: usize) -> Option<[DVec2; 3]> {
    let [a, b, c] = t.map(|p| flatten(p, drop));
    match orient2d(a, b, c) {
        o if o > 0.0 => Some([a, b, c]),
        o if o < 0.0 => Some([a, c, b]),
        _ => None,
    }
}

/// The coordinate to leave out so that the triangle keeps an area; `None` where it has none.
pub(super) fn projection(t: &[DVec3; 3]) -> Option<usize> {
    let normal = (t[1] - t[0]).cross(t[2] - t[0]).abs();
    let most = (0..3)
        .max_by(|&a, &b| normal[a].total_cmp(&normal[b]))
        .unwrap_or(0);
    (most..most + 3)
        .map(|k| k % 3)
        .find(|&k| project(t, k).is_some())
}

/// How two triangles of one plane meet; they may share their first vertex.
pub(super) fn contact(a: &[DVec3; 3], b: &[DVec3; 3], drop: usize, share_vertex: bool) -> Contact {
    let (Some(p), Some(q)) = (project(a, drop), project(b, drop)) else {
        return Contact::Apart;
    };
    // Convex polygons are apart exactly where the line of an edge of one of them parts them.
    let (mut apart, mut parted) = (false, false);
    for (of, other) in [(&p, &q), (&q, &p)] {
        for i in 0..3 {
            let sides = other.map(|r| orient2d(of[i], of[(i + 1) % 3], r));
            parted |= sides.iter().all(|&s| s <= 0.0);
            apart |= sides.iter().all(|&s| s < 0.0);
        }
    }
    if apart {
        Contact::Apart
    } else if !parted {
        Contact::Crossing
    } else if !share_vertex || edges_overlap(&p, &q) {
        Contact::Touching
    } else {
        Contact::Apart
    }
}

/// Whether an edge of `p` from the vertex shared with `q` runs along one of `q`. The first vertex is the shared one.
fn edges_overlap(p: &[DVec2; 3], q: &[DVec2; 3]) -> bool {
    let way = |from: DVec2, to: DVec2| (to.x.partial_cmp(&from.x), to.y.partial_cmp(&from.y));
    p[1..].iter().any(|&a| {
        q[1..]
            .iter()
            .any(|&b| way(p[0], a) == way(p[0], b) && orient2d(p[0], a, b) == 0.0)
    })
}
