//! Loops of directed edges, and filling them with triangles.

use glam::DVec2;
use greenstick_geometry::intersect::orient2d as orientation;
use greenstick_geometry::triangulate::{TriangulateError, Triangulator};

/// Chains directed edges into closed loops; the inside lies on the left. Where loops touch at a vertex, the leftmost
/// turn keeps them apart. `None` where the edges do not close.
pub(super) fn trace(edges: &[[u32; 2]], flat: impl Fn(u32) -> DVec2) -> Option<Vec<Vec<u32>>> {
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by_key(|&i| edges[i]);
    let from = |v: u32| {
        let start = order.partition_point(|&i| edges[i][0] < v);
        order[start..]
            .iter()
            .copied()
            .take_while(move |&i| edges[i][0] == v)
    };
    let mut used = vec![false; edges.len()];
    let mut loops = Vec::new();
    for &first in &order {
        if used[first] {
            continue;
        }
        used[first] = true;
        let (start, mut current) = (edges[first][0], edges[first]);
        let mut corners = vec![start];
        while current[1] != start {
            let [a, b] = current.map(&flat);
            let turn = |i: usize| {
                let d = flat(edges[i][1]) - b;
                let back = a - b;
                // Angle from the way back, counted clockwise: the leftmost turn has the smallest of the open ones.
                let angle = libm::atan2(back.perp_dot(d), back.dot(d));
                if angle >= 0.0 {
                    angle - 2.0 * std::f64::consts::PI
                } else {
                    angle
                }
            };
            let mut next = from(current[1]).filter(|&i| !used[i]);
            let candidate = next.next()?;
            let chosen = next.fold(
                candidate,
                |best, i| if turn(i) > turn(best) { i } else { best },
            );
            used[chosen] = true;
            corners.push(current[1]);
            current = edges[chosen];
        }
        loops.push(corners);
    }
    Some(loops)
}

/// Twice the signed area of a loop.
pub(super) fn area(corners: &[u32], flat: &impl Fn(u32) -> DVec2) -> f64 {
    let origin = flat(corners[0]);
    (1..corners.len() - 1)
        .map(|i| (flat(corners[i]) - origin).perp_dot(flat(corners[i + 1]) - origin))
        .sum()
}

/// Twice the signed area of a loop.
pub(super) fn twice_area(places: &[DVec2]) -> f64 {
    let origin = places[0];
    places
        .windows(2)
        .map(|w| (w[0] - origin).perp_dot(w[1] - origin))
        .sum()
}

/// Fills loops (outer ones counter-clockwise, holes clockwise) with triangles, every corner used.
pub(super) fn fill(
    triangulator: &mut Triangulator,
    loops: &[Vec<u32>],
    flat: impl Fn(u32) -> DVec2,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), TriangulateError> {
    if let [only] = loops {
        return fill_one(triangulator, only, &[], &flat, triangles);
    }
    let (outer, holes): (Vec<_>, Vec<_>) = loops.iter().partition(|l| area(l, &flat) >= 0.0);
    let housed = |h: &&Vec<u32>| outer.iter().any(|r| contains(r, flat(h[0]), &flat));
    if !holes.iter().all(housed) {
        return Err(TriangulateError::HoleOutside(0));
    }
    for &ring in &outer {
        let within: Vec<&Vec<u32>> = holes
            .iter()
            .copied()
            .filter(|h| contains(ring, flat(h[0]), &flat))
            .collect();
        fill_one(triangulator, ring, &within, &flat, triangles)?;
    }
    Ok(())
}

fn fill_one(
    triangulator: &mut Triangulator,
    ring: &[u32],
    holes: &[&Vec<u32>],
    flat: &impl Fn(u32) -> DVec2,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), TriangulateError> {
    if let [a, b, c] = *ring
        && holes.is_empty()
    {
        triangles.push([a, b, c]);
        return Ok(());
    }
    let mut ids = ring.to_vec();
    let mut starts = Vec::new();
    for hole in holes {
        starts.push(ids.len());
        ids.extend(*hole);
    }
    let points: Vec<DVec2> = ids.iter().map(|&id| flat(id)).collect();
    let mut filled = Vec::with_capacity(ids.len());
    let sound = triangulator.polygon_with_holes(&points, &starts, &mut filled);
    if let Err(error) = sound {
        if !holes.is_empty() {
            return Err(error);
        }
        clip_ears(&points, &mut filled);
        triangles.extend(filled.into_iter().map(|t| t.map(|i| ids[i as usize])));
        return Ok(());
    }
    part_slivers(&points, &mut filled);
    // A sliver may turn the other way by rounding; its edges must run as the ring does all the same.
    let turned = holes.is_empty() && area(ring, flat) < 0.0;
    triangles.extend(filled.into_iter().map(|t| {
        let [a, b, c] = t.map(|i| ids[i as usize]);
        if turned { [a, c, b] } else { [a, b, c] }
    }));
    Ok(())
}

/// Fills a loop that touches or crosses itself, by rounding or because winding grain bends its edges: the best ears
/// first, whatever is left at the end. Its edges are those of the loop, so faces close all the same.
fn clip_ears(points: &[DVec2], triangles: &mut Vec<[u32; 3]>) {
    triangles.clear();
    let mut ring: Vec<u32> = (0..points.len() as u32).collect();
    while ring.len() > 3 {
        let n = ring.len();
        let corner = |i: usize| [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
        let quality = |i: usize| {
            let [a, b, c] = corner(i).map(|v| points[v as usize]);
            let blocked = |v: &u32| {
                let p = points[*v as usize];
                p != a
                    && p != b
                    && p != c
                    && orientation(a, b, p) >= 0.0
                    && orientation(b, c, p) >= 0.0
                    && orientation(c, a, p) >= 0.0
            };
            let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
            let shape = orientation(a, b, c) / sides.max(f64::MIN_POSITIVE);
            if shape > 0.0 && ring.iter().any(blocked) {
                -1.0
            } else {
                shape
            }
        };
        let best = (0..n)
            .max_by(|&i, &j| quality(i).total_cmp(&quality(j)))
            .unwrap_or(0);
        triangles.push(corner(best));
        ring.remove(best);
    }
    triangles.extend(<[u32; 3]>::try_from(ring).ok());
}

/// Height over the longest side below which a triangle counts as three points of one line.
const FLAT: f64 = 1e-9;

/// The longest side of a triangle whose third corner lies on it but for rounding, between its ends; named by the
/// corner it starts at.
fn sliver(points: &[DVec2], t: [u32; 3]) -> Option<usize> {
    let p = t.map(|v| points[v as usize]);
    let side = |k: usize| p[(k + 1) % 3] - p[k];
    let longest = (0..3).max_by(|&a, &b| {
        side(a)
            .length_squared()
            .total_cmp(&side(b).length_squared())
    })?;
    let along = side(longest);
    let to = p[(longest + 2) % 3] - p[longest];
    let place = along.dot(to) / along.length_squared();
    let thin = along.perp_dot(to).abs() <= FLAT * along.length_squared();
    (thin && place > FLAT && place < 1.0 - FLAT).then_some(longest)
}

/// Turns the longest side of every sliver, so that no triangle spans points that lie on one line but for rounding:
/// moved to their places in the world, such triangles would fold over their neighbours. Where several lie side by side,
/// each turn leaves slivers with shorter sides, until none is left that has a neighbour.
pub(super) fn part_slivers(points: &[DVec2], triangles: &mut [[u32; 3]]) {
    if triangles.len() < 2 || triangles.iter().all(|&t| sliver(points, t).is_none()) {
        return;
    }
    let mut turned = 0;
    let mut at = 0;
    // Turns end by themselves but for rounding.
    while at < triangles.len() && turned < 4 * triangles.len() {
        let t = triangles[at];
        let beyond = sliver(points, t).and_then(|k| {
            let (a, b, apex) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            let runs_back = |u: &[u32; 3]| (0..3).find(|&j| u[j] == b && u[(j + 1) % 3] == a);
            let found = triangles
                .iter()
                .enumerate()
                .find_map(|(i, u)| runs_back(u).map(|j| (i, u[(j + 2) % 3])));
            found.map(|(i, other)| (i, a, b, apex, other))
        });
        match beyond {
            Some((i, a, b, apex, other)) if apex != other => {
                triangles[at] = [a, other, apex];
                triangles[i] = [other, b, apex];
                turned += 1;
                at = at.min(i);
            }
            _ => at += 1,
        }
    }
}

/// Whether `p` lies inside the loop (even–odd rule).
fn contains(corners: &[u32], p: DVec2, flat: &impl Fn(u32) -> DVec2) -> bool {
    let mut inside = false;
    for i in 0..corners.len() {
        let (a, b) = (flat(corners[i]), flat(corners[(i + 1) % corners.len()]));
        if (a.y > p.y) != (b.y > p.y) && (orientation(a, b, p) > 0.0) == (b.y > a.y) {
            inside = !inside;
        }
    }
    inside
}
