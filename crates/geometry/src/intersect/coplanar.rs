//! Triangles in one plane, compared in a projection along an axis.

use super::Contact;
use super::predicates::orient2d;
use super::projection::{flatten, normal_axis, project};
use glam::{DVec2, DVec3};

/// Whether two triangles that share their first two vertices lie on different sides of that edge in a projection, so
/// that they have nothing else in common, whether or not they lie in one plane.
pub(super) fn separated_by_edge(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let drop = normal_axis(a);
    let [p, q, r, s] = [a[0], a[1], a[2], b[2]].map(|p| flatten(p, drop));
    let (r, s) = (orient2d(p, q, r), orient2d(p, q, s));
    (r > 0.0 && s < 0.0) || (r < 0.0 && s > 0.0)
}

/// Whether the line through an edge of one of two triangles separates them in a projection, so that they have nothing
/// in common, or only their first vertex if they share it. For triangles that lie nearly in one plane this avoids the
/// exact predicate in space, which is slowest for them.
pub(super) fn separated(a: &[DVec3; 3], b: &[DVec3; 3], share_vertex: bool) -> bool {
    let drop = normal_axis(a);
    let (p, q) = (a.map(|p| flatten(p, drop)), b.map(|p| flatten(p, drop)));
    [(&p, &q), (&q, &p)].into_iter().any(|(of, other)| {
        (0..3).any(|i| {
            // A line that does not contain the shared vertex has it on the triangle's own side.
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

/// The contact of two triangles in one plane; they may share their first vertex.
pub(super) fn contact(a: &[DVec3; 3], b: &[DVec3; 3], drop: usize, share_vertex: bool) -> Contact {
    let (Some(p), Some(q)) = (project(a, drop), project(b, drop)) else {
        return Contact::Apart;
    };
    // Convex polygons are disjoint exactly if the line through an edge of one of them separates them.
    let (mut apart, mut separated) = (false, false);
    for (of, other) in [(&p, &q), (&q, &p)] {
        for i in 0..3 {
            let sides = other.map(|r| orient2d(of[i], of[(i + 1) % 3], r));
            separated |= sides.iter().all(|&s| s <= 0.0);
            apart |= sides.iter().all(|&s| s < 0.0);
        }
    }
    if apart {
        Contact::Apart
    } else if !separated {
        Contact::Crossing
    } else if !share_vertex || edges_overlap(&p, &q) {
        Contact::Touching
    } else {
        Contact::Apart
    }
}

/// Whether an edge of `p` from the shared vertex, the first, runs along one of `q`.
fn edges_overlap(p: &[DVec2; 3], q: &[DVec2; 3]) -> bool {
    let direction = |from: DVec2, to: DVec2| (to.x.partial_cmp(&from.x), to.y.partial_cmp(&from.y));
    p[1..].iter().any(|&a| {
        q[1..]
            .iter()
            .any(|&b| direction(p[0], a) == direction(p[0], b) && orient2d(p[0], a, b) == 0.0)
    })
}
