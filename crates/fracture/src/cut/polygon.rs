//! Loops of directed edges, and filling them with triangles.

use super::overlay::orientation;
use glam::DVec2;

/// Chains directed edges into closed loops; the inside lies on the left. Where loops touch at a vertex, the leftmost
/// turn keeps them apart. `None` where the edges do not close.
pub(super) fn trace(edges: &[[u32; 2]], flat: impl Fn(u32) -> DVec2) -> Option<Vec<Vec<u32>>> {
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by_key(|&i| edges[i]);
    let from = |v: u32| {
        let start = order.partition_point(|&i| edges[i][0] < v);
        order[start..].iter().copied().take_while(move |&i| edges[i][0] == v)
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
                if angle >= 0.0 { angle - 2.0 * std::f64::consts::PI } else { angle }
            };
            let mut next = from(current[1]).filter(|&i| !used[i]);
            let candidate = next.next()?;
            let chosen = next.fold(candidate, |best, i| if turn(i) > turn(best) { i } else { best });
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

/// Fills loops (outer ones counter-clockwise, holes clockwise) with triangles, every corner used.
/// `Err` where a loop crosses itself.
pub(super) fn fill(
    loops: &[Vec<u32>],
    flat: impl Fn(u32) -> DVec2,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), ()> {
    if let [only] = loops {
        return clip_ears(only, &flat, triangles);
    }
    let (outer, holes): (Vec<_>, Vec<_>) = loops.iter().partition(|l| area(l, &flat) >= 0.0);
    let mut filled: Vec<Vec<u32>> = outer.into_iter().cloned().collect();
    for hole in holes {
        let probe = flat(hole[0]);
        let host = filled.iter_mut().find(|l| contains(l, probe, &flat)).ok_or(())?;
        bridge(host, hole, &flat)?;
    }
    filled.iter().try_for_each(|l| clip_ears(l, &flat, triangles))
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

/// Joins a hole to its outer loop by the shortest pair of coinciding edges that crosses neither.
fn bridge(outer: &mut Vec<u32>, hole: &[u32], flat: &impl Fn(u32) -> DVec2) -> Result<(), ()> {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, &a) in outer.iter().enumerate() {
        for (j, &b) in hole.iter().enumerate() {
            pairs.push((flat(a).distance_squared(flat(b)), i, j));
        }
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
    let clear = |a: u32, b: u32, corners: &[u32]| {
        (0..corners.len()).all(|i| {
            let (c, d) = (corners[i], corners[(i + 1) % corners.len()]);
            if [c, d].iter().any(|v| *v == a || *v == b) {
                return true;
            }
            let [pa, pb, pc, pd] = [a, b, c, d].map(flat);
            orientation(pa, pb, pc) * orientation(pa, pb, pd) > 0.0
                || orientation(pc, pd, pa) * orientation(pc, pd, pb) > 0.0
        })
    };
    let &(_, i, j) = pairs
        .iter()
        .find(|&&(_, i, j)| clear(outer[i], hole[j], outer) && clear(outer[i], hole[j], hole))
        .ok_or(())?;
    let mut inserted: Vec<u32> = hole[j..].iter().chain(&hole[..=j]).copied().collect();
    inserted.push(outer[i]);
    outer.splice(i + 1..i + 1, inserted);
    Ok(())
}

/// Fills one loop by clipping ears, the best shaped first (Meisters 1975).
fn clip_ears(
    corners: &[u32],
    flat: &impl Fn(u32) -> DVec2,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), ()> {
    match *corners {
        [] | [_] | [_, _] => return Err(()),
        [a, b, c] => {
            triangles.push([a, b, c]);
            return Ok(());
        }
        [a, b, c, d] => {
            let [pa, pb, pc, pd] = [a, b, c, d].map(flat);
            let ac = [orientation(pa, pb, pc), orientation(pa, pc, pd)];
            let bd = [orientation(pa, pb, pd), orientation(pb, pc, pd)];
            let worst = |v: [f64; 2]| v[0].min(v[1]);
            let by_length = pa.distance_squared(pc) <= pb.distance_squared(pd);
            let use_ac = if worst(ac) > 0.0 && worst(bd) > 0.0 { by_length } else { worst(ac) >= worst(bd) };
            triangles.extend(if use_ac { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            return Ok(());
        }
        _ => {}
    }
    let mut ring: Vec<(u32, DVec2)> = corners.iter().map(|&c| (c, flat(c))).collect();
    let quality = |ring: &[(u32, DVec2)], i: usize| -> f64 {
        let n = ring.len();
        let (a, b, c) = (ring[(i + n - 1) % n].1, ring[i].1, ring[(i + 1) % n].1);
        let area = orientation(a, b, c);
        if area <= 0.0 {
            return -1.0;
        }
        let blocked = ring.iter().any(|&(_, p)| {
            p != a && p != b && p != c
                && orientation(a, b, p) >= 0.0
                && orientation(b, c, p) >= 0.0
                && orientation(c, a, p) >= 0.0
        });
        if blocked {
            return -1.0;
        }
        area / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
    };
    let mut qualities: Vec<f64> = (0..ring.len()).map(|i| quality(&ring, i)).collect();
    while ring.len() > 3 {
        let n = ring.len();
        let mut best = (0..n).max_by(|&a, &b| qualities[a].total_cmp(&qualities[b])).unwrap_or(0);
        if qualities[best] < 0.0 {
            // Only corners on a straight line are left, or the loop touches itself: take the flattest.
            best = (0..n)
                .min_by(|&a, &b| {
                    let flatness = |i: usize| {
                        orientation(ring[(i + n - 1) % n].1, ring[i].1, ring[(i + 1) % n].1).abs()
                    };
                    flatness(a).total_cmp(&flatness(b))
                })
                .unwrap_or(0);
        }
        triangles.push([ring[(best + n - 1) % n].0, ring[best].0, ring[(best + 1) % n].0]);
        ring.remove(best);
        qualities.remove(best);
        let n = ring.len();
        for i in [(best + n - 1) % n, best % n] {
            qualities[i] = quality(&ring, i);
        }
        // An ear may have been blocked by the corner that has gone.
        for (i, q) in qualities.iter_mut().enumerate() {
            if *q < 0.0 {
                *q = quality(&ring, i);
            }
        }
    }
    triangles.push([ring[0].0, ring[1].0, ring[2].0]);
    Ok(())
}
