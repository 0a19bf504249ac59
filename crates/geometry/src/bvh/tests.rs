//! Every query against an exhaustive search.

use super::{Aabb, Bvh};
use glam::DVec3;

/// A generator of pseudo-random numbers from 0 to 1.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn soup(count: usize, seed: u64) -> crate::Mesh {
    let mut next = numbers(seed);
    let mut mesh = crate::Mesh::default();
    for t in 0..count as u32 {
        let p = DVec3::new(next(), next(), next() * 5.0);
        for _ in 0..3 {
            mesh.positions
                .push(p + DVec3::new(next(), next(), next()) * 0.3);
        }
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    mesh
}

fn collect(f: impl FnOnce(&mut dyn FnMut(usize))) -> Vec<usize> {
    let mut found = Vec::new();
    f(&mut |i| found.push(i));
    found.sort_unstable();
    found
}

#[test]
fn region_queries_match_exhaustive_search() {
    let mesh = soup(500, 1);
    let tree = Bvh::from_mesh(&mesh);
    let boxes: Vec<Aabb> = (0..500).map(|t| Aabb::around(&mesh.corners(t))).collect();
    let all = |f: &dyn Fn(usize) -> bool| (0..500).filter(|&i| f(i)).collect::<Vec<_>>();
    let mut next = numbers(2);
    for _ in 0..50 {
        let p = DVec3::new(next(), next(), next() * 5.0);
        let region = Aabb {
            low: p,
            high: p + 0.2,
        };
        assert_eq!(
            collect(|v| tree.overlapping(&region, v)),
            all(&|i| boxes[i].overlaps(&region))
        );
        let normal = DVec3::new(next() - 0.5, next() - 0.5, next() - 0.5);
        let corner = |b: &Aabb, k: usize| {
            DVec3::new(
                if k & 1 == 0 { b.low.x } else { b.high.x },
                if k & 2 == 0 { b.low.y } else { b.high.y },
                if k & 4 == 0 { b.low.z } else { b.high.z },
            )
        };
        let straddles = |i: usize| {
            let side = |k| normal.dot(corner(&boxes[i], k) - p) > 0.0;
            (1..8).any(|k| side(k) != side(0))
        };
        assert_eq!(collect(|v| tree.straddling(p, normal, v)), all(&straddles));
    }
    let mut pairs = Vec::new();
    tree.self_pairs(|a, b| pairs.push((a, b)));
    pairs.sort_unstable();
    let mut expected = Vec::new();
    for a in 0..500 {
        expected.extend(
            (a + 1..500)
                .filter(|&b| boxes[a].overlaps(&boxes[b]))
                .map(|b| (a, b)),
        );
    }
    assert!(expected.len() > 100);
    assert_eq!(pairs, expected);
}

#[test]
fn nearest_points_and_first_hits_match_exhaustive_search() {
    let mesh = soup(400, 3);
    let tree = Bvh::from_mesh(&mesh);
    let mut next = numbers(4);
    let mut hits = 0;
    for _ in 0..200 {
        let p = DVec3::new(next() * 2.0 - 0.5, next() * 2.0 - 0.5, next() * 5.0);
        let found = tree.nearest_on_mesh(&mesh, p, f64::INFINITY).unwrap();
        // Independent of the closest-point formula: no sampled point of a triangle is nearer, and the samples of the
        // triangle found are nearly as near.
        let sampled = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            let mut best = f64::INFINITY;
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let q = a + (b - a) * (i as f64 / 40.0) + (c - a) * (j as f64 / 40.0);
                    best = best.min(q.distance(p));
                }
            }
            best
        };
        assert!(
            (0..400)
                .step_by(7)
                .all(|t| sampled(t) >= found.distance - 1e-12)
        );
        assert!(sampled(found.triangle) <= found.distance + 0.01);
        let beyond = tree.nearest_on_mesh(&mesh, p, found.distance * 0.999);
        assert!(beyond.is_none() || found.distance == 0.0);
        let direction = DVec3::new(next() - 0.5, next() - 0.5, next() - 0.5);
        let first = tree.first_triangle(&mesh, p, direction, f64::INFINITY);
        let mut expected: Option<f64> = None;
        for t in 0..400 {
            let [a, b, c] = mesh.corners(t);
            // Cramer's rule for origin + t·direction = a + u·(b − a) + v·(c − a).
            let matrix = glam::DMat3::from_cols(direction, a - b, a - c);
            let s = matrix.inverse() * (a - p);
            if s.x >= 0.0 && s.y >= 0.0 && s.z >= 0.0 && s.y + s.z <= 1.0 {
                expected = Some(expected.map_or(s.x, |e| e.min(s.x)));
            }
        }
        hits += usize::from(first.is_some());
        assert_eq!(first.is_some(), expected.is_some());
        if let (Some((_, t)), Some(e)) = (first, expected) {
            assert!((t - e).abs() < 1e-9 * (1.0 + e));
        }
    }
    assert!(hits > 20);
}

#[test]
fn coincident_infinite_and_nan_boxes_are_handled() {
    let same = vec![
        Aabb {
            low: DVec3::ONE,
            high: DVec3::splat(2.0)
        };
        100
    ];
    let mut boxes = same.clone();
    boxes.push(Aabb {
        low: DVec3::NAN,
        high: DVec3::NAN,
    });
    boxes.push(Aabb {
        low: DVec3::NEG_INFINITY,
        high: DVec3::INFINITY,
    });
    boxes.push(Aabb::EMPTY);
    let tree = Bvh::new(&boxes);
    let found = collect(|v| tree.overlapping(&same[0], v));
    assert_eq!(found, (0..100).chain([101]).collect::<Vec<_>>());
    let mut pairs = 0;
    tree.self_pairs(|_, _| pairs += 1);
    assert_eq!(pairs, 101 * 100 / 2);
    assert!(Bvh::new(&[]).nearest(DVec3::ZERO, 1.0, |_| 0.0).is_none());
}
