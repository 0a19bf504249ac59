//! Convex hulls with a largest number of vertices: Quickhull (Barber, Dobkin & Huhdanpaa 1996), which takes the farthest
//! point first, stopped early. Sides are told by exact predicates, so that the result is convex and closed to the last bit.

use crate::Mesh;
use crate::intersect::{collinear, orient3d};
use glam::DVec3;

/// How far a hull goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HullLimits {
    /// Most vertices, 4 or more.
    pub vertices: usize,
    /// Points that lie no farther than this outside are left out, m; at least [`FINEST`] of the size.
    pub tolerance: f64,
}

/// Points closer to a hull than this share of the points' extent are no corners of it: the planes of faces that were
/// thinner could not be told in doubles.
pub const FINEST: f64 = 1e-9;

struct Face {
    corners: [u32; 3],
    normal: DVec3,
    offset: f64,
    /// Points outside this face, each in the list of one face.
    outside: Vec<u32>,
    /// The farthest of them, and how far.
    farthest: (f64, u32),
}

impl Face {
    fn new(points: &[DVec3], corners: [u32; 3]) -> Face {
        let [a, b, c] = corners.map(|i| points[i as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Face {
            corners,
            normal,
            offset: normal.dot(a),
            outside: Vec::new(),
            farthest: (0.0, u32::MAX),
        }
    }

    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    fn is_seen_from(&self, points: &[DVec3], from: DVec3) -> bool {
        let [a, b, c] = self.corners.map(|i| points[i as usize]);
        // Shewchuk's determinant is negative on the side from which a, b, c run counter-clockwise.
        orient3d(a, b, c, from) < 0.0
    }

    fn take(&mut self, index: u32, height: f64) {
        self.outside.push(index);
        if height > self.farthest.0 {
            self.farthest = (height, index);
        }
    }
}

/// Puts each point into the list of the face that it lies farthest outside of; those inside are dropped.
fn share(points: &[DVec3], indices: impl Iterator<Item = u32>, faces: &mut [Face]) {
    for i in indices {
        let mut best = (0.0, usize::MAX);
        for (f, face) in faces.iter().enumerate() {
            let height = face.height(points[i as usize]);
            if height > best.0 {
                best = (height, f);
            }
        }
        if let Some(face) = faces.get_mut(best.1) {
            face.take(i, best.0);
        }
    }
}

/// Four points that span a solid as large as the extremes give, the first three counter-clockwise from outside, and the
/// distance below which points are the same; none where all points lie in a plane.
fn first_four(points: &[DVec3]) -> Option<([u32; 4], f64)> {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        let mut best = (0.0, None);
        for (i, &p) in points.iter().enumerate() {
            let value = measure(p);
            if value > best.0 {
                best = (value, Some(i));
            }
        }
        best.1
    };
    let middle = points.first()?;
    let a = farthest(&|p| p.distance_squared(*middle))?;
    let pa = points[a];
    let b = farthest(&|p| p.distance_squared(pa))?;
    let along = (points[b] - pa).normalize_or_zero();
    let c = farthest(&|p| (p - pa).cross(along).length_squared())?;
    let normal = (points[b] - pa).cross(points[c] - pa).normalize_or_zero();
    let d = farthest(&|p| normal.dot(p - pa).abs())?;
    let least = FINEST * points[b].distance(pa);
    if normal.dot(points[d] - pa).abs() <= least {
        return None;
    }
    let side = orient3d(pa, points[b], points[c], points[d]);
    let [a, b, c, d] = [a, b, c, d].map(|i| i as u32);
    if side > 0.0 {
        Some(([a, b, c, d], least))
    } else if side < 0.0 {
        Some(([b, a, c, d], least))
    } else {
        None
    }
}

/// The convex hull of `points` within `limits`, closed and oriented, its vertices being some of the points: no vertex
/// lies outside a face, exactly. None where the points span no volume, or a coordinate is no finite number.
pub fn hull(points: &[DVec3], limits: &HullLimits) -> Option<Mesh> {
    if points.len() > u32::MAX as usize || points.iter().any(|p| !p.is_finite()) {
        return None;
    }
    let ([a, b, c, d], least) = first_four(points)?;
    let tolerance = limits.tolerance.max(least);
    let mut faces = [[a, b, c], [b, a, d], [c, b, d], [a, c, d]]
        .map(|corners| Face::new(points, corners))
        .into_iter()
        .collect::<Vec<_>>();
    share(points, 0..points.len() as u32, &mut faces);
    let mut vertices = 4;
    let mut bounds: Vec<(u32, u32)> = Vec::new();
    while vertices < limits.vertices.max(4) {
        let far = |face: &Face| face.farthest.0;
        let Some(next) = (0..faces.len()).max_by(|&x, &y| {
            // Of equal ones the first.
            far(&faces[x]).total_cmp(&far(&faces[y])).then(y.cmp(&x))
        }) else {
            break;
        };
        let (height, apex) = faces[next].farthest;
        if apex == u32::MAX || height <= tolerance {
            break;
        }
        let from = points[apex as usize];
        if !faces[next].is_seen_from(points, from) {
            // Outside by rounding only.
            let again = std::mem::take(&mut faces[next].outside);
            faces[next].farthest = (0.0, u32::MAX);
            for i in again.into_iter().filter(|&i| i != apex) {
                let height = faces[next].height(points[i as usize]);
                faces[next].take(i, height);
            }
            continue;
        }
        let (seen, kept): (Vec<Face>, Vec<Face>) =
            (faces.into_iter()).partition(|face| face.is_seen_from(points, from));
        faces = kept;
        bounds.clear();
        for face in &seen {
            let [a, b, c] = face.corners;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                // An edge between two faces that are seen goes with them.
                match bounds.iter().position(|&edge| edge == (q, p)) {
                    Some(place) => drop(bounds.swap_remove(place)),
                    None => bounds.push((p, q)),
                }
            }
        }
        let old = faces.len();
        faces.extend((bounds.iter()).map(|&(p, q)| Face::new(points, [p, q, apex])));
        let orphans = seen.iter().flat_map(|face| face.outside.iter().copied());
        share(points, orphans.filter(|&i| i != apex), &mut faces[old..]);
        // The apex may have hidden others that were corners.
        vertices = corners(&faces).len();
    }
    let used = corners(&faces);
    let number = |i: u32| used.binary_search(&i).unwrap_or(0) as u32;
    Some(Mesh {
        positions: used.iter().map(|&i| points[i as usize]).collect(),
        triangles: faces.iter().map(|f| f.corners.map(number)).collect(),
        ..Mesh::default()
    })
}

fn corners(faces: &[Face]) -> Vec<u32> {
    let mut used: Vec<u32> = faces.iter().flat_map(|f| f.corners).collect();
    used.sort_unstable();
    used.dedup();
    used
}

/// Whether a mesh is a closed, oriented surface of which no vertex lies outside a face, told exactly.
pub fn is_convex(mesh: &Mesh) -> bool {
    let report = mesh.check();
    let outside = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        collinear(a, b, c) || (mesh.positions.iter()).any(|&p| orient3d(a, b, c, p) < 0.0)
    };
    report.closed
        && report.oriented
        && report.indices_out_of_range == 0
        && report.non_finite_positions == 0
        && !(0..mesh.triangles.len()).any(outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: HullLimits = HullLimits {
        vertices: usize::MAX,
        tolerance: 0.0,
    };

    /// Points of the three numbers' fractional parts: spread evenly, the same everywhere.
    fn spread(count: usize) -> impl Iterator<Item = DVec3> {
        let steps = DVec3::new(0.819_172_513_396, 0.671_043_606_703, 0.549_700_477_901);
        (1..=count).map(move |i| (steps * i as f64).fract())
    }

    /// A face's plane must have all points behind it, told by brute force, and all corners must be corners of the hull.
    fn holds_all(mesh: &Mesh, points: &[DVec3]) {
        assert!(is_convex(mesh));
        let size = mesh.bounds().map_or(0.0, |(low, high)| low.distance(high));
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let normal = (b - a).cross(c - a).normalize();
            for &p in points {
                assert!(normal.dot(p - a) <= 1e-9 * size);
            }
        }
    }

    #[test]
    fn a_cube_full_of_points_has_its_eight_corners() {
        let mut points: Vec<DVec3> = spread(500).collect();
        // A grid: many points in the planes of faces and on edges.
        for i in 0..125 {
            let at = [i / 25, i / 5 % 5, i % 5].map(|k| f64::from(k) / 4.0);
            points.push(DVec3::from_array(at));
        }
        let mesh = hull(&points, &ALL).unwrap();
        holds_all(&mesh, &points);
        assert!((mesh.volume() - 1.0).abs() < 1e-12);
        for corner in 0..8 {
            let at = DVec3::new(
                f64::from(corner & 1),
                f64::from(corner >> 1 & 1),
                f64::from(corner >> 2),
            );
            assert!(mesh.positions.contains(&at));
        }
    }

    #[test]
    fn points_of_a_sphere_are_all_corners_and_fewer_lie_inside() {
        // Along a spiral of the golden angle.
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let on_sphere = |i: i32| {
            let z = (f64::from(i) + 0.5) / 200.0 - 1.0;
            let (sine, cosine) = (golden * f64::from(i)).sin_cos();
            (DVec3::new(cosine, sine, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z) * 3.0
        };
        let points: Vec<DVec3> = (0..400).map(on_sphere).collect();
        let mesh = hull(&points, &ALL).unwrap();
        holds_all(&mesh, &points);
        // Euler: a closed surface of triangles on n points has 2n − 4 of them.
        assert_eq!(mesh.positions.len(), 400);
        assert_eq!(mesh.triangles.len(), 796);
        let few = HullLimits {
            vertices: 40,
            ..ALL
        };
        let small = hull(&points, &few).unwrap();
        assert!(is_convex(&small));
        assert!(small.positions.len() <= 40);
        assert!(small.volume() < mesh.volume() && small.volume() > 0.7 * mesh.volume());
    }

    #[test]
    fn points_without_volume_have_no_hull() {
        let flat: Vec<DVec3> = spread(50).map(|p| DVec3::new(p.x, p.y, 0.25)).collect();
        assert_eq!(hull(&flat, &ALL), None);
        assert_eq!(hull(&[DVec3::ONE; 9], &ALL), None);
        assert_eq!(hull(&[], &ALL), None);
        let mut bad: Vec<DVec3> = spread(50).collect();
        bad[7].y = f64::NAN;
        assert_eq!(hull(&bad, &ALL), None);
    }
}
