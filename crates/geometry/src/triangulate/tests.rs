//! Triangulations against the properties of every triangulation of a polygon, in exact integers.

use super::simple::monotone_orientation;
use super::{TriangulateError, Triangulator, triangulate};
use crate::intersect::orient2d;
use glam::DVec2;
use std::collections::BTreeMap;

type Point = [i64; 2];

struct Random(u64);

impl Random {
    fn below(&mut self, n: i64) -> i64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % n as u64) as i64
    }
}

fn turn(a: Point, b: Point, c: Point) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn twice_area(ring: &[Point]) -> i64 {
    (0..ring.len())
        .map(|i| turn([0, 0], ring[i], ring[(i + 1) % ring.len()]))
        .sum()
}

fn on_segment(p: Point, a: Point, b: Point) -> bool {
    turn(a, b, p) == 0 && (0..2).all(|k| p[k] >= a[k].min(b[k]) && p[k] <= a[k].max(b[k]))
}

/// Whether no two edges share a point, except neighbours, which share an end.
fn is_simple(ring: &[Point]) -> bool {
    let n = ring.len();
    let edge = |i: usize| (ring[i % n], ring[(i + 1) % n]);
    (0..n).all(|i| {
        let ((a, b), (_, c)) = (edge(i), edge(i + 1));
        a != b
            && !on_segment(c, a, b)
            && !on_segment(a, b, c)
            && (i + 2..n).all(|j| {
                let (d, e) = edge(j);
                (j + 1) % n == i
                    || !((turn(a, b, d).signum() * turn(a, b, e).signum() < 0
                        && turn(d, e, a).signum() * turn(d, e, b).signum() < 0)
                        || on_segment(d, a, b)
                        || on_segment(e, a, b)
                        || on_segment(a, d, e)
                        || on_segment(b, d, e))
            })
    })
}

/// Triangulates rings (holes after the first) and checks count, orientation, area, edges and the circle condition.
fn check(rings: &[Vec<Point>]) {
    let all: Vec<Point> = rings.concat();
    let points: Vec<DVec2> = all
        .iter()
        .map(|p| DVec2::new(p[0] as f64, p[1] as f64))
        .collect();
    let mut starts = Vec::new();
    for ring in &rings[..rings.len() - 1] {
        starts.push(starts.last().unwrap_or(&0) + ring.len());
    }
    let mut triangles = vec![[7, 7, 7]];
    Triangulator::default()
        .polygon_with_holes(&points, &starts, &mut triangles)
        .unwrap_or_else(|e| panic!("{e}: {rings:?}"));
    let triangles = &triangles[1..];
    assert_eq!(
        triangles.len(),
        all.len() + 2 * starts.len() - 2,
        "{rings:?}"
    );
    let at = |i: u32| all[i as usize];
    let areas: Vec<i64> = triangles
        .iter()
        .map(|&[a, b, c]| turn(at(a), at(b), at(c)))
        .collect();
    assert!(areas.iter().all(|&a| a > 0), "{rings:?} {triangles:?}");
    let expected =
        twice_area(&rings[0]).abs() - rings[1..].iter().map(|r| twice_area(r).abs()).sum::<i64>();
    assert_eq!(
        areas.iter().sum::<i64>(),
        expected,
        "{rings:?} {triangles:?}"
    );
    let mut opposite: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let edge = (t[k], t[(k + 1) % 3]);
            assert!(
                opposite.insert(edge, t[(k + 2) % 3]).is_none(),
                "an edge used twice in one direction"
            );
        }
    }
    let mut boundary = 0;
    for (&(a, b), &c) in &opposite {
        match opposite.get(&(b, a)) {
            None => boundary += 1,
            Some(&d) => {
                // The sum of the opposite angles is at most a half turn where the quadrilateral is convex.
                let convex = turn(at(c), at(a), at(d)) > 0 && turn(at(d), at(b), at(c)) > 0;
                let angle = |p: u32| {
                    let (u, v) = (
                        points[a as usize] - points[p as usize],
                        points[b as usize] - points[p as usize],
                    );
                    u.angle_to(v).abs()
                };
                assert!(
                    !convex || angle(c) + angle(d) < std::f64::consts::PI + 1e-9,
                    "{rings:?}"
                );
            }
        }
    }
    let mut start = 0;
    for ring in rings {
        let n = ring.len() as u32;
        for i in 0..n {
            let (a, b) = (start + i, start + (i + 1) % n);
            assert!(
                opposite.contains_key(&(a, b)) != opposite.contains_key(&(b, a)),
                "{rings:?}"
            );
        }
        start += n;
    }
    assert_eq!(boundary, all.len());
}

/// Points around `centre` by rising angle, so that the ring is seen whole from there.
fn star(random: &mut Random, centre: Point, count: usize, size: i64) -> Vec<Point> {
    (0..count)
        .map(|i| {
            let angle = i as f64 / count as f64 * std::f64::consts::TAU;
            let radius = (size / 4 + random.below(3 * size / 4)) as f64;
            [
                centre[0] + (radius * angle.cos()) as i64,
                centre[1] + (radius * angle.sin()) as i64,
            ]
        })
        .collect()
}

/// A random tour of points on a small grid with crossings undone: full of straight runs and narrow necks.
fn tour(random: &mut Random, count: usize, grid: Point) -> Vec<Point> {
    let mut ring: Vec<Point> = Vec::new();
    while ring.len() < count {
        let p = [random.below(grid[0]), random.below(grid[1])];
        if !ring.contains(&p) {
            ring.push(p);
        }
    }
    let length = |a: Point, b: Point| ((a[0] - b[0]) as f64).hypot((a[1] - b[1]) as f64);
    while let Some((i, j)) = (0..count - 1)
        .flat_map(|i| (i + 1..count).map(move |j| (i, j)))
        .find(|&(i, j)| {
            let (a, b, c, d) = (ring[i], ring[i + 1], ring[j], ring[(j + 1) % count]);
            length(a, c) + length(b, d) < length(a, b) + length(c, d) - 1e-9
        })
    {
        ring[i + 1..=j].reverse();
    }
    ring
}

#[test]
fn random_polygons_are_triangulated_and_crossing_ones_refused() {
    let mut random = Random(11);
    let (mut simple, mut crossing) = (0, 0);
    for round in 0..6000 {
        let count = 4 + random.below(if round % 20 == 0 { 60 } else { 9 }) as usize;
        let grid = [count as i64 + random.below(20), 3 + random.below(9)];
        let ring = match round % 3 {
            0 => star(&mut random, [0, 0], count, 1000),
            1 => tour(&mut random, count, grid),
            _ => (0..count)
                .map(|_| [random.below(5), random.below(5)])
                .collect(),
        };
        let sound = is_simple(&ring);
        if sound {
            check(std::slice::from_ref(&ring));
            check(&[ring.iter().rev().copied().collect()]);
            simple += 1;
        } else if ring.iter().any(|&p| turn(ring[0], ring[1], p) != 0) {
            let points: Vec<DVec2> = ring
                .iter()
                .map(|p| DVec2::new(p[0] as f64, p[1] as f64))
                .collect();
            let mut triangles = Vec::new();
            let error = triangulate(&points, &mut triangles).unwrap_err();
            assert!(
                matches!(error, TriangulateError::Crossing(..)),
                "{error} {ring:?}"
            );
            assert!(triangles.is_empty());
            crossing += 1;
        }
    }
    assert!(simple > 2000 && crossing > 500, "{simple} {crossing}");
}

#[test]
fn rings_of_two_chains_are_simple_and_their_orientation_is_known() {
    let mut random = Random(11);
    let places = |ring: &[Point]| -> Vec<DVec2> {
        let place = |p: &Point| DVec2::new(p[0] as f64, p[1] as f64);
        ring.iter().map(place).collect()
    };
    let mut known = 0;
    for round in 0..4000 {
        // Two chains over one another with a few points above each other, some of which touch or cross.
        let (low, high) = (random.below(4) + 2, random.below(4) + 2);
        let mut ring: Vec<Point> = (0..low)
            .map(|_| [random.below(9), random.below(5)])
            .collect();
        ring.sort_unstable();
        let mut back: Vec<Point> = (0..high)
            .map(|_| [random.below(9), random.below(9)])
            .collect();
        back.sort_unstable_by(|a, b| b.cmp(a));
        ring.extend(back);
        if round % 2 == 1 {
            ring.reverse();
        }
        let turn = random.below(ring.len() as i64) as usize;
        ring.rotate_left(turn);
        if let Some(clockwise) = monotone_orientation(&places(&ring)) {
            known += 1;
            assert!(is_simple(&ring), "{ring:?}");
            assert_eq!(clockwise, twice_area(&ring) < 0, "{ring:?}");
        }
    }
    assert!(known > 500, "{known}");
    let comb = [[0, 0], [6, 0], [6, 5], [4, 1], [3, 5], [2, 1], [1, 5]];
    assert_eq!(monotone_orientation(&places(&comb)), Some(false));
    let hook = [
        [0, 0],
        [6, 0],
        [6, 5],
        [2, 5],
        [2, 4],
        [4, 4],
        [4, 2],
        [0, 2],
    ];
    assert_eq!(monotone_orientation(&places(&hook)), None);
}

#[test]
fn polygons_with_holes_are_triangulated() {
    let mut random = Random(3);
    for round in 0..600 {
        let mut rings = vec![vec![[0, 0], [4000, 0], [4000, 3000], [0, 3000]]];
        if round % 2 == 1 {
            rings[0].insert(1, [1500, 0]);
            rings[0].insert(4, [2500, 3000]);
        }
        for cell in 0..12 {
            if random.below(3) > 0 {
                let centre = [500 + cell % 4 * 1000, 500 + cell / 4 * 1000];
                let count = 3 + random.below(7) as usize;
                let mut hole = star(
                    &mut random,
                    centre,
                    count,
                    if round % 3 == 0 { 80 } else { 490 },
                );
                if round % 5 == 0 {
                    // Squares in a row: bridges that run on along edges.
                    hole = [[-200, -200], [200, -200], [200, 200], [-200, 200]]
                        .map(|p: Point| [p[0] + centre[0], p[1] + centre[1]])
                        .to_vec();
                }
                if is_simple(&hole) {
                    rings.push(hole);
                }
            }
        }
        check(&rings);
    }
}

#[test]
fn thin_and_flat_polygons_keep_their_edges() {
    // Points of a straight run that rounding has moved to both sides of the line.
    for count in [3usize, 4, 5, 8, 30] {
        let mut points: Vec<DVec2> = (0..count)
            .map(|i| DVec2::new(i as f64 * 0.1, i as f64 * 0.1 * 0.3))
            .collect();
        points.push(DVec2::new(0.1, 1e-3 + 0.03));
        let mut triangles = Vec::new();
        triangulate(&points, &mut triangles).unwrap();
        assert_eq!(triangles.len(), count - 1);
        assert!(triangles.iter().all(|t| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            orient2d(a, b, c) > 0.0
        }));
    }
    let line: Vec<DVec2> = [0.0, 1.0, 2.0, 5.0, 3.0]
        .iter()
        .map(|&x| DVec2::new(x, 0.0))
        .collect();
    let mut triangles = Vec::new();
    triangulate(&line, &mut triangles).unwrap();
    assert_eq!(triangles, vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn invalid_polygons_are_refused_with_the_place() {
    let p = |x: f64, y: f64| DVec2::new(x, y);
    let square = vec![p(0.0, 0.0), p(9.0, 0.0), p(9.0, 9.0), p(0.0, 9.0)];
    let with_hole = |hole: &[DVec2]| {
        let points = [&square[..], hole].concat();
        Triangulator::default().polygon_with_holes(&points, &[4], &mut Vec::new())
    };
    assert_eq!(
        triangulate(&square[..2], &mut Vec::new()),
        Err(TriangulateError::TooFew { start: 0, count: 2 })
    );
    let bow = [square[0], square[2], square[1], square[3]];
    assert_eq!(
        triangulate(&bow, &mut Vec::new()),
        Err(TriangulateError::Crossing(0, 2))
    );
    let mut holed = square.clone();
    holed[2].x = f64::NAN;
    assert_eq!(
        triangulate(&holed, &mut Vec::new()),
        Err(TriangulateError::NotFinite(2))
    );
    assert_eq!(
        with_hole(&[p(20.0, 1.0), p(21.0, 1.0), p(20.0, 2.0)]),
        Err(TriangulateError::HoleOutside(4))
    );
    assert_eq!(
        with_hole(&[p(1.0, 1.0), p(2.0, 2.0), p(3.0, 3.0)]),
        Err(TriangulateError::NoArea(4))
    );
    assert!(matches!(
        with_hole(&[p(1.0, 1.0), p(20.0, 2.0), p(3.0, 3.0)]),
        Err(TriangulateError::Crossing(..))
    ));
}
