//! Single triangles: the closest point, and the intersection with a line.

use glam::DVec3;

/// Returns the point of a triangle closest to `p` (Ericson 2005, Real-Time Collision Detection, §5.1.5).
///
/// ```
/// use glam::DVec3;
/// use greenstick_geometry::closest_point_on_triangle;
///
/// let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// let point = closest_point_on_triangle(DVec3::new(0.25, 0.25, 3.0), triangle);
/// assert_eq!(point, DVec3::new(0.25, 0.25, 0.0));
/// ```
pub fn closest_point_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

/// Returns where the line from `origin` along `direction` meets a triangle, in lengths of `direction` (negative behind
/// the origin). A line through an edge meets at least one of the triangles that share it (Woop, Benthin & Wald 2013,
/// Watertight Ray/Triangle Intersection).
pub(crate) fn line_triangle_intersection(
    origin: DVec3,
    direction: DVec3,
    corners: [DVec3; 3],
) -> Option<f64> {
    let size = direction.abs();
    let z = if size.x > size.y && size.x > size.z {
        0
    } else if size.y > size.z {
        1
    } else {
        2
    };
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let (sx, sy) = (direction[x] / direction[z], direction[y] / direction[z]);
    let [a, b, c] = corners.map(|p| {
        let d = p - origin;
        [d[x] - sx * d[z], d[y] - sy * d[z], d[z]]
    });
    // An edge gives the same number, up to its sign, for both of its triangles.
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let sum = u + v + w;
    (sum != 0.0).then(|| (u * a[2] + v * b[2] + w * c[2]) / sum / direction[z])
}
