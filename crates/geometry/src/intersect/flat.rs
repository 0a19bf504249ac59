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
    let most = steepest(t);
    (most..most + 3)
        .map(|k| k % 3)
        .find(|&k| project(t, k).is_some())
}

/// The axis most nearly across the triangle.
fn steepest(t: &[DVec3; 3]) -> usize {
    let normal = (t[1] - t[0]).cross(t[2] - t[0]).abs();
    (0..3)
        .max_by(|&a, &b| normal[a].total_cmp(&normal[b]))
        .unwrap_or(0)
}

/// Whether two triangles that share their first two vertices lie on different sides of that edge in a projection, and
/// so have nothing else in common, be they flat or bent.
pub(super) fn parted_by_edge(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let drop = steepest(a);
    let [p, q, r, s] = [a[0], a[1], a[2], b[2]].map(|p| flatten(p, drop));
    let (r, s) = (orient2d(p, q, r), orient2d(p, q, s));
    (r > 0.0 && s < 0.0) || (r < 0.0 && s > 0.0)
}

/// Whether a line through an edge of one of two triangles parts them in a projection, so that they have nothing in
/// common, or nothing but their first vertex where they share that. Spares triangles that lie nearly in one plane the
/// exact predicate in space, which is slowest for them.
pub(super) fn parted(a: &[DVec3; 3], b: &[DVec3; 3], share_vertex: bool) -> bool {
    let drop = steepest(a);
    let (p, q) = (a.map(|p| flatten(p, drop)), b.map(|p| flatten(p, drop)));
    [(&p, &q), (&q, &p)].into_iter().any(|(of, other)| {
        (0..3).any(|i| {
            // A line that does not hold the shared vertex has it on the triangle's own side.
            if share_vertex && i == 1 {
                return false;
            }
            let (s, t) = (of[i], of[(i + 1) % 3]);
            let own = orient2d(s, t, of[(i + 2) % 3]);
            let others = &other[usize::from(share_vertex)..];
            own != 0.0
                && others
                    .iter()
                    .all(|&r| orient2d(s, t, r) * own.signum() < 0.0)
        })
    })
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
