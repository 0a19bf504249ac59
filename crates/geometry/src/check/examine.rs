//! The examination of a mesh, one property after another.

use super::report::MAX_CONTACTS;
use super::report::{CheckOptions, MAX_PLACES, Report, SelfIntersections};
use crate::Unions;
use crate::components::{Edges, Use, corner_points, number_points, shells};
use crate::intersect::{Contact, collinear, contact_tree, self_contacts_while};
use crate::{Aabb, Mesh};
use glam::DVec3;

/// Examines a mesh and reports what it found.
pub(super) fn examine(mesh: &Mesh, options: CheckOptions) -> Report {
    let mut report = Report {
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        non_finite_positions: mesh.positions.iter().filter(|p| !p.is_finite()).count(),
        ..Report::default()
    };
    let (points, count) = number_points(&mesh.positions);
    report.points = count;
    let mut sound = Mesh {
        triangles: Vec::with_capacity(mesh.triangles.len()),
        ..Mesh::default()
    };
    for &triangle in &mesh.triangles {
        match corner_points(triangle, &points) {
            None => report.indices_out_of_range += 1,
            Some([a, b, c]) => {
                let corners = triangle.map(|i| mesh.positions[i as usize]);
                if !corners.iter().all(|p| p.is_finite()) {
                    continue;
                }
                let repeated = a == b || b == c || c == a;
                if repeated || collinear(corners[0], corners[1], corners[2]) {
                    report.degenerate_triangles += 1;
                    note(
                        &mut report.degenerate_places,
                        corners.iter().sum::<DVec3>() / 3.0,
                    );
                }
                if !repeated {
                    sound.triangles.push([a, b, c]);
                }
            }
        }
    }
    // From here on vertices are points, so that the following steps need no lookup.
    sound.positions = vec![DVec3::ZERO; count];
    for (&p, &point) in mesh.positions.iter().zip(&points) {
        sound.positions[point as usize] = p;
    }
    let numbers: Vec<u32> = (0..count as u32).collect();
    report.components = shells(&sound.triangles, &numbers, count).count;
    report.area_m2 = sound.area();
    edges(&sound, &numbers, &mut report);
    if report.closed && report.oriented {
        report.volume_m3 = Some(volume(&sound));
    }
    if options.self_intersections {
        report.self_intersections = Some(self_intersections(&sound));
    }
    report
}

/// Volume relative to a corner of the first triangle. Unused positions, which may be anywhere, have no influence.
fn volume(mesh: &Mesh) -> f64 {
    let Some(first) = mesh.triangles.first() else {
        return 0.0;
    };
    let origin = mesh.positions[first[0] as usize];
    let sum: f64 = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| p - origin);
            a.dot(b.cross(c))
        })
        .sum();
    sum / 6.0
}

/// Adds a place to those of a defect, unless there are enough.
fn note(places: &mut Vec<[f64; 3]>, place: DVec3) {
    if places.len() < MAX_PLACES {
        places.push(place.to_array());
    }
}

/// Examines edges, and vertices by the fans of triangles that edges connect.
fn edges(mesh: &Mesh, numbers: &[u32], report: &mut Report) {
    let edges = Edges::new(&mesh.triangles, numbers, numbers.len());
    // Corners of triangles, joined into fans across edges.
    let mut fans = Unions::new(3 * mesh.triangles.len());
    let mut boundary: Vec<[u32; 2]> = Vec::new();
    let mut opposites: Vec<u32> = Vec::new();
    edges.each(|low, uses| {
        let high = uses[0].high();
        let ends = |u: usize| {
            let (t, k) = (uses[u].triangle(), uses[u].edge());
            let (start, end) = ((3 * t + k) as u32, (3 * t + (k + 1) % 3) as u32);
            // The corner at the lower point comes first; the flag says whether the edge starts there.
            if mesh.triangles[t][k] == low {
                (start, end, true)
            } else {
                (end, start, false)
            }
        };
        if uses.len() == 1 {
            boundary.push([low, high]);
            return;
        }
        let first = ends(0);
        let mut forward = usize::from(first.2);
        for u in 1..uses.len() {
            let next = ends(u);
            fans.join(first.0, next.0);
            fans.join(first.1, next.1);
            forward += usize::from(next.2);
        }
        let middle = || (mesh.positions[low as usize] + mesh.positions[high as usize]) * 0.5;
        // An odd number of triangles cannot balance, whatever their orientation.
        if forward.abs_diff(uses.len() - forward) > 1 {
            report.misoriented_edges += 1;
            note(&mut report.misoriented_places, middle());
        }
        if uses.len() > 2 {
            report.non_manifold_edges += 1;
            note(&mut report.non_manifold_edge_places, middle());
        }
        // Triangles with the same points share all edges; they are counted at the edge of their two lowest points.
        opposites.clear();
        let opposite = |u: &Use| mesh.triangles[u.triangle()][(u.edge() + 2) % 3];
        opposites.extend(uses.iter().map(opposite).filter(|&p| p > high));
        opposites.sort_unstable();
        report.duplicate_triangles += opposites.windows(2).filter(|w| w[0] == w[1]).count();
    });
    report.boundary_edges = boundary.len();
    report.oriented = report.misoriented_edges == 0;
    report.closed =
        !mesh.triangles.is_empty() && boundary.is_empty() && report.non_manifold_edges == 0;
    boundary_loops(mesh, &boundary, report);
    vertex_fans(mesh, &mut fans, report);
}

/// Counts the rims of holes.
fn boundary_loops(mesh: &Mesh, boundary: &[[u32; 2]], report: &mut Report) {
    if boundary.is_empty() {
        return;
    }
    let mut loops = Unions::new(mesh.positions.len());
    for &[a, b] in boundary {
        loops.join(a, b);
    }
    let mut roots: Vec<u32> = boundary.iter().map(|e| loops.root(e[0])).collect();
    roots.sort_unstable();
    roots.dedup();
    report.boundary_loops = roots.len();
    for &root in roots.iter().take(MAX_PLACES) {
        note(&mut report.boundary_places, mesh.positions[root as usize]);
    }
}

/// Counts the points whose corners belong to several fans.
fn vertex_fans(mesh: &Mesh, fans: &mut Unions, report: &mut Report) {
    const NONE: u32 = u32::MAX;
    const SEVERAL: u32 = u32::MAX - 1;
    let mut fan_of_point = vec![NONE; mesh.positions.len()];
    for (corner, &point) in (0u32..).zip(mesh.triangles.as_flattened()) {
        let first = &mut fan_of_point[point as usize];
        if *first == SEVERAL {
            continue;
        }
        let fan = fans.root(corner);
        if *first == NONE {
            *first = fan;
        } else if *first != fan {
            *first = SEVERAL;
            report.non_manifold_vertices += 1;
            note(
                &mut report.non_manifold_vertex_places,
                mesh.positions[point as usize],
            );
        }
    }
}

/// Most pairs of triangles that are looked at, for each triangle. Broken faces need up to 41.
const MAX_LOOKED_AT: usize = 1000;

/// Counts the pairs of triangles that touch or cross, up to [`MAX_CONTACTS`].
fn self_intersections(mesh: &Mesh) -> SelfIntersections {
    let mut found = SelfIntersections::default();
    let most = MAX_CONTACTS + MAX_LOOKED_AT * mesh.triangles.len();
    let complete = self_contacts_while(mesh, &contact_tree(mesh), most, |s, t, kind| {
        let place = || {
            let [s, t] = [s, t].map(|t| Aabb::around(&mesh.corners(t)));
            s.intersection(&t).centre()
        };
        match kind {
            Contact::Apart => {}
            Contact::Touching => {
                found.touching += 1;
                note(&mut found.touching_places, place());
            }
            Contact::Crossing => {
                found.crossing += 1;
                note(&mut found.crossing_places, place());
            }
        }
        found.crossing + found.touching < MAX_CONTACTS
    });
    found.incomplete = !complete;
    found
}
