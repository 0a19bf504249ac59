//! Contacts against cases known by construction and against a search over rational positions.

use super::{Contact, contact};
use glam::DVec3;

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The contact, which must be the same for every order of corners and triangles and under a rotation of the axes.
fn contact_of(a: [DVec3; 3], b: [DVec3; 3]) -> Contact {
    let expected = contact(a, b);
    let orders = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    for o in orders {
        for p in orders {
            let (s, t) = (o.map(|i| a[i]), p.map(|i| b[i]));
            assert_eq!(contact(s, t), expected);
            assert_eq!(contact(t, s), expected);
            assert_eq!(
                contact(s.map(|q| v(q.z, q.x, -q.y)), t.map(|q| v(q.z, q.x, -q.y))),
                expected
            );
        }
    }
    expected
}

const O: DVec3 = DVec3::ZERO;

#[test]
fn shared_vertices_and_edges_are_no_contact() {
    use Contact::*;
    let a = [O, v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)];
    let x = a[1];
    for (b, expected, what) in [
        ([O, x, v(1.0, -1.0, 0.0)], Apart, "flat across an edge"),
        ([O, x, v(1.0, 1.0, 1.0)], Apart, "bent across an edge"),
        ([O, x, v(1.0, 1.0, 0.0)], Crossing, "folded over an edge"),
        (
            [O, x, v(9.0, 9.0, 0.0)],
            Crossing,
            "folded over an edge, larger",
        ),
        (a, Crossing, "the same triangle"),
        (
            [O, v(-1.0, 0.0, 0.0), v(0.0, -1.0, 0.0)],
            Apart,
            "flat, tip to tip",
        ),
        (
            [O, v(-1.0, -1.0, 1.0), v(-1.0, -1.0, -1.0)],
            Apart,
            "across, tip to tip",
        ),
        (
            [O, v(1.0, 1.0, 1.0), v(1.0, 1.0, -1.0)],
            Crossing,
            "through the inside from a corner",
        ),
        (
            [O, v(9.0, 9.0, 9.0), v(9.0, 9.0, -9.0)],
            Crossing,
            "through and beyond from a corner",
        ),
        (
            [O, v(1.0, 1.0, 0.0), v(1.0, 1.0, 1.0)],
            Touching,
            "an edge on the inside from a corner",
        ),
        (
            [O, v(2.0, 0.0, 0.0), v(1.0, -1.0, 0.0)],
            Touching,
            "flat, along part of an edge",
        ),
        (
            [O, v(2.0, 0.0, 0.0), v(1.0, 0.0, 1.0)],
            Touching,
            "across, along part of an edge",
        ),
        (
            [O, v(-2.0, 0.0, 0.0), v(-1.0, -1.0, 0.0)],
            Apart,
            "flat, along the edge's other way",
        ),
        (
            [O, v(1.0, 1.0, 0.0), v(-1.0, 1.0, 0.0)],
            Crossing,
            "flat, overlapping from a corner",
        ),
        (
            [O, v(1.0, 1.0, 0.0), v(2.0, 1.0, 0.0)],
            Crossing,
            "flat, inside from a corner",
        ),
        (
            [x, v(-1.0, 1.0, 1.0), v(-1.0, 1.0, -1.0)],
            Crossing,
            "from another corner",
        ),
    ] {
        assert_eq!(contact_of(a, b), expected, "{what}");
    }
}

#[test]
fn triangles_without_shared_vertices_touch_or_cross() {
    use Contact::*;
    let a = [O, v(4.0, 0.0, 0.0), v(0.0, 4.0, 0.0)];
    for (b, expected, what) in [
        (
            [v(1.0, 1.0, 1.0), v(1.0, 1.0, -1.0), v(9.0, 9.0, 0.0)],
            Crossing,
            "through an edge",
        ),
        (
            [v(1.0, 1.0, 0.0), v(1.0, 1.0, 1.0), v(2.0, 1.0, 1.0)],
            Touching,
            "a corner on the inside",
        ),
        (
            [v(1.0, 1.0, 0.0), v(2.0, 1.0, 0.0), v(1.0, 1.0, 1.0)],
            Touching,
            "an edge on the inside",
        ),
        (
            [v(2.0, 0.0, 0.0), v(2.0, -1.0, 1.0), v(2.0, -1.0, -1.0)],
            Touching,
            "a corner on an edge",
        ),
        (
            [v(2.0, 0.0, 1.0), v(2.0, 0.0, -1.0), v(2.0, -1.0, 0.0)],
            Touching,
            "edge across edge",
        ),
        (
            [v(2.0, 1e-9, 1.0), v(2.0, 1e-9, -1.0), v(2.0, -1.0, 0.0)],
            Crossing,
            "edge just inside",
        ),
        (
            [v(2.0, -1e-9, 1.0), v(2.0, -1e-9, -1.0), v(2.0, -1.0, 0.0)],
            Apart,
            "edge just outside",
        ),
        (
            [v(1.0, 0.0, 0.0), v(2.0, 0.0, 0.0), v(1.0, -1.0, 0.0)],
            Touching,
            "flat, along an edge",
        ),
        (
            [v(3.0, 3.0, 0.0), v(2.0, 2.0, 0.0), v(3.0, 2.0, 0.0)],
            Touching,
            "flat, corner on edge",
        ),
        (
            [v(1.0, 1.0, 0.0), v(1.0, 1.5, 0.0), v(1.5, 1.0, 0.0)],
            Crossing,
            "flat, within",
        ),
        (
            [v(3.0, 3.0, 0.0), v(2.5, 2.0, 0.0), v(3.0, 2.0, 0.0)],
            Apart,
            "flat, apart",
        ),
        (
            [v(1.0, 1.0, 1.0), v(1.0, 1.0, -1.0), v(1.0, 1.0, 3.0)],
            Apart,
            "without area",
        ),
        (
            [v(9.0, 9.0, 1.0), v(9.0, 9.0, -1.0), v(9.0, 8.0, 0.0)],
            Apart,
            "beyond",
        ),
    ] {
        assert_eq!(contact_of(a, b), expected, "{what}");
    }
}

/// Exact reference on small whole numbers: the set common to both triangles is cut from `a` by the half-planes of `b`
/// as a polygon with `i128` fractions; here by clipping `a`'s polygon against the slab and edges of `b`.
fn reference(a: [[i64; 3]; 3], b: [[i64; 3]; 3]) -> Option<Vec<[f64; 3]>> {
    type Point = ([i128; 3], i128); // numerators and a positive denominator
    let sub = |p: [i64; 3], q: [i64; 3]| [0, 1, 2].map(|k| i128::from(p[k] - q[k]));
    let cross = |u: [i128; 3], w: [i128; 3]| {
        [
            u[1] * w[2] - u[2] * w[1],
            u[2] * w[0] - u[0] * w[2],
            u[0] * w[1] - u[1] * w[0],
        ]
    };
    let normal = cross(sub(b[1], b[0]), sub(b[2], b[0]));
    if normal == [0; 3] || cross(sub(a[1], a[0]), sub(a[2], a[0])) == [0; 3] {
        return None;
    }
    let mut planes = vec![(normal, b[0]), (normal.map(|x| -x), b[0])];
    for i in 0..3 {
        planes.push((cross(normal, sub(b[(i + 1) % 3], b[i])), b[i]));
    }
    let mut polygon: Vec<Point> = a.iter().map(|p| (p.map(i128::from), 1)).collect();
    for (n, o) in planes {
        let value = |p: &Point| -> i128 {
            (0..3)
                .map(|k| n[k] * (p.0[k] - i128::from(o[k]) * p.1))
                .sum()
        };
        let mut kept: Vec<Point> = Vec::new();
        for i in 0..polygon.len() {
            let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let (s, t) = (value(&p), value(&q));
            if s >= 0 {
                kept.push(p);
            }
            if (s > 0 && t < 0) || (s < 0 && t > 0) {
                // p·(t/q.1) − q·(s/p.1), cleared of fractions; a common sign makes the denominator positive.
                let mut numerator = [0, 1, 2].map(|k| p.0[k] * t - q.0[k] * s);
                let mut denominator = p.1 * t - q.1 * s;
                if denominator < 0 {
                    numerator = numerator.map(|x| -x);
                    denominator = -denominator;
                }
                kept.push((numerator, denominator));
            }
        }
        polygon = kept;
    }
    Some(
        polygon
            .iter()
            .map(|p| p.0.map(|x| x as f64 / p.1 as f64))
            .collect(),
    )
}

#[test]
fn contacts_agree_with_exact_clipping() {
    let mut state = 5u64;
    let mut next = |n: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % n) as i64
    };
    let mut seen = [0; 3];
    for _ in 0..60_000 {
        let size = 2 + next(4) as u64;
        let mut triangle = || [(); 3].map(|()| [next(size), next(size), next(size)]);
        let (a, b) = (triangle(), triangle());
        let [p, q] = [a, b].map(|t| t.map(|c| v(c[0] as f64, c[1] as f64, c[2] as f64)));
        let found = contact(p, q);
        let Some(common) = reference(a, b) else {
            assert_eq!(found, Contact::Apart);
            continue;
        };
        let shared: Vec<DVec3> = p.iter().copied().filter(|c| q.contains(c)).collect();
        // A point of the common set away from the simplex that is shared?
        let elsewhere = common
            .iter()
            .map(|&c| DVec3::from(c))
            .any(|c| match shared[..] {
                [] => true,
                [s] => c.distance(s) > 1e-9,
                [s, t] => (c - s).cross(t - s).length() > 1e-9,
                _ => true,
            });
        assert_eq!(found != Contact::Apart, elsewhere, "{a:?} {b:?}");
        seen[found as usize] += 1;
    }
    assert!(seen.iter().all(|&n| n > 1000), "{seen:?}");
}
