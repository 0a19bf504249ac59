//! Separation of the sheets that meet at edges of more than two triangles, as scans have where folds touch. A cut across such an edge
//! would have four ends at one point.

use crate::components::NonManifoldEdge;
use crate::{Cancelled, Context, Mesh, Unions};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// How far the middle of an edge is moved into the solid, as a part of the smallest height of its triangles over it: out of sight, and far
/// more than numbers of single precision are apart.
const INSET: f64 = 1e-3;
/// Triangles at a smaller angle (rad) lie on each other, as those of cards that are seen from both sides: these have no inside.
const SMALLEST_ANGLE: f64 = 1e-4;
/// Rounds: each separates one edge of a triangle, which has three.
const MOST_ROUNDS: usize = 3;

/// A triangle at an edge.
#[derive(Clone, Copy)]
struct EdgeUse {
    triangle: u32,
    /// The edge runs from this corner to the next.
    side: usize,
    /// Whether it runs from the edge's first point to its second.
    forward: bool,
    /// Its angle (rad) about the edge, 0 to τ.
    angle: f64,
}

/// Separates the sheets of a closed surface that meet at edges of more than two triangles: every two triangles between which the solid lies
/// are divided at the middle of the edge, which is moved a little into the solid. So are the edge's ends, where sheets would go on to meet in
/// one point. Edges at which triangles lie on each other, or that have no inside, are left. Returns how many were separated.
///
/// # Errors
/// [`Cancelled`].
pub fn separate_sheets(mesh: &mut Mesh, context: &Context) -> Result<usize, Cancelled> {
    let mut count = 0;
    let mut ends: Vec<DVec3> = Vec::new();
    for _ in 0..MOST_ROUNDS {
        context.check()?;
        let (points, _) = mesh.points();
        let mut divided = FxHashSet::<u32>::default();
        let mut separated = 0;
        for edge in mesh.adjacency().non_manifold {
            // The edges of a triangle that has been divided are others now.
            if edge.triangles.iter().any(|t| divided.contains(t)) {
                continue;
            }
            let Some(wedges) = wedges(mesh, &points, &edge) else {
                continue;
            };
            divided.extend(&edge.triangles);
            ends.extend(wedges[0].ends);
            for wedge in wedges {
                divide(mesh, wedge);
            }
            separated += 1;
        }
        count += separated;
        if separated == 0 {
            break;
        }
    }
    if count > 0 {
        separate_fans(mesh, &ends);
    }
    Ok(count)
}

/// Two triangles at an edge, and the middle of the edge moved into the solid between them.
struct Wedge {
    sides: [EdgeUse; 2],
    middle: DVec3,
    /// The edge's ends.
    ends: [DVec3; 2],
}

/// The triangles of an edge in pairs between which the solid lies; `None` where it is not known where that is.
fn wedges(mesh: &Mesh, points: &[u32], edge: &NonManifoldEdge) -> Option<Vec<Wedge>> {
    let at = |v: u32| mesh.positions[v as usize];
    let side = |t: u32| {
        let corners = mesh.triangles[t as usize];
        let ends = |k: usize| [k, (k + 1) % 3].map(|i| points[corners[i] as usize]);
        let [a, b] = edge.points;
        (0..3).find_map(|k| match ends(k) {
            e if e == [a, b] => Some((k, true)),
            e if e == [b, a] => Some((k, false)),
            _ => None,
        })
    };
    let first = edge.triangles.first().copied()?;
    let (k, forward) = side(first)?;
    let corners = mesh.triangles[first as usize];
    let (p, q) = (at(corners[k]), at(corners[(k + 1) % 3]));
    let (a, b) = if forward { (p, q) } else { (q, p) };
    let axis = (b - a).try_normalize()?;
    let (x, y) = axis.any_orthonormal_pair();
    let middle = a.midpoint(b);
    let mut least = f64::INFINITY;
    let mut uses = Vec::with_capacity(edge.triangles.len());
    for &triangle in &edge.triangles {
        let (side, forward) = side(triangle)?;
        let opposite = mesh.triangles[triangle as usize][(side + 2) % 3];
        let d = at(opposite) - middle;
        let (u, v) = (d.dot(x), d.dot(y));
        least = least.min(libm::hypot(u, v));
        uses.push(EdgeUse {
            triangle,
            side,
            forward,
            angle: libm::atan2(v, u).rem_euclid(TAU),
        });
    }
    uses.sort_by(|p, q| p.angle.total_cmp(&q.angle));
    let inset = INSET * least.min(a.distance(b));
    if !(inset > 0.0 && inset.is_finite()) {
        return None;
    }
    let count = uses.len();
    let mut wedges = Vec::new();
    for i in 0..count {
        let (from, to) = (uses[i], uses[(i + 1) % count]);
        let angle = (to.angle - from.angle).rem_euclid(TAU);
        // Inside and outside take turns: along the axis, the solid begins at triangles that run back and ends at those that run along.
        if from.forward == to.forward || angle < SMALLEST_ANGLE {
            return None;
        }
        if !from.forward {
            let (sin, cos) = libm::sincos(from.angle + 0.5 * angle);
            wedges.push(Wedge {
                sides: [from, to],
                middle: middle + (x * cos + y * sin) * inset,
                ends: [a, b],
            });
        }
    }
    Some(wedges)
}

/// Divides the two triangles of a wedge at its middle.
fn divide(mesh: &mut Mesh, wedge: Wedge) {
    let mut known: Option<([u32; 2], u32)> = None;
    for EdgeUse { triangle, side, .. } in wedge.sides {
        let t = triangle as usize;
        let corners = mesh.triangles[t];
        let [a, b, c] = [side, (side + 1) % 3, (side + 2) % 3].map(|i| corners[i]);
        let middle = match known {
            Some((ends, middle)) if ends == [b, a] => middle,
            _ => mesh.push_vertex_between((a, b), 0.5, wedge.middle),
        };
        known = Some(([a, b], middle));
        mesh.triangles[t] = [a, middle, c];
        mesh.triangles.push([middle, b, c]);
        if !mesh.materials.is_empty() {
            let material = mesh.materials[t];
            mesh.materials.push(material);
        }
    }
}

/// Separates the fans of triangles that meet in one of some places: all but the largest get vertices of their own, a little inside the
/// solid.
fn separate_fans(mesh: &mut Mesh, places: &[DVec3]) {
    // 0 and −0 are one place.
    let key = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let places: FxHashSet<[u64; 3]> = places.iter().map(|p| key(*p)).collect();
    let (points, _) = mesh.points();
    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for &v in triangle {
            if places.contains(&key(mesh.positions[v as usize])) {
                around.entry(points[v as usize]).or_default().push(t as u32);
            }
        }
    }
    let mut moved: Vec<(u32, Vec<u32>)> = Vec::new();
    for (point, triangles) in around {
        let mut fans = fans(mesh, &points, point, &triangles);
        fans.sort_by_key(|fan| Reverse(fan.len()));
        moved.extend(fans.into_iter().skip(1).map(|fan| (point, fan)));
    }
    for (point, fan) in moved {
        move_fan(mesh, &points, point, &fan);
    }
}

/// The triangles about a point in fans: those that share another point, too.
fn fans(mesh: &Mesh, points: &[u32], point: u32, triangles: &[u32]) -> Vec<Vec<u32>> {
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| points[v as usize]);
    let others: Vec<[u32; 2]> = (triangles.iter())
        .filter_map(|&t| {
            let [a, b, c] = corners(t);
            let k = [a, b, c].iter().position(|p| *p == point)?;
            Some([[b, c], [c, a], [a, b]][k])
        })
        .collect();
    let mut local: Vec<u32> = others.as_flattened().to_vec();
    local.sort_unstable();
    local.dedup();
    let number = |p: u32| local.partition_point(|q| *q < p) as u32;
    let mut joined = Unions::new(local.len());
    for [p, q] in &others {
        joined.join(number(*p), number(*q));
    }
    let mut fans: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (&t, [p, _]) in triangles.iter().zip(&others) {
        fans.entry(joined.root(number(*p))).or_default().push(t);
    }
    fans.into_values().collect()
}

/// Moves the tip of a fan of triangles about a point into the solid.
fn move_fan(mesh: &mut Mesh, points: &[u32], point: u32, fan: &[u32]) {
    let (mut normal, mut shortest) = (DVec3::ZERO, f64::INFINITY);
    for &t in fan {
        let [a, b, c] = mesh.corners(t as usize);
        normal += (b - a).cross(c - a);
        shortest = [(a, b), (b, c), (c, a)]
            .map(|(p, q)| p.distance(q))
            .into_iter()
            .fold(shortest, f64::min);
    }
    let mut own: FxHashMap<u32, u32> = FxHashMap::default();
    for &t in fan {
        for k in 0..3 {
            let v = mesh.triangles[t as usize][k];
            if points.get(v as usize) == Some(&point) {
                let place =
                    mesh.positions[v as usize] - normal.normalize_or_zero() * (INSET * shortest);
                let new =
                    *(own.entry(v)).or_insert_with(|| mesh.push_vertex_between((v, v), 0.0, place));
                mesh.triangles[t as usize][k] = new;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Attribute;

    /// Two tetrahedra that share an edge from (0, 0, 0) to (0, 0, 1), wound outwards, each with its own vertices or with shared ones.
    fn tetrahedra(shared: bool) -> Mesh {
        let positions = [
            [0., 0., 0.],
            [0., 0., 1.],
            [1., 0.2, 0.5],
            [1., -0.2, 0.5],
            [-1., 0.2, 0.5],
            [-1., -0.2, 0.5],
        ];
        let mut mesh = Mesh {
            positions: positions.map(DVec3::from).to_vec(),
            ..Mesh::default()
        };
        let faces = |[a, b, c, d]: [u32; 4]| [[a, b, c], [b, a, d], [c, d, a], [d, c, b]];
        let mut second = faces([1, 0, 4, 5]);
        if !shared {
            mesh.positions.extend([DVec3::ZERO, DVec3::Z]);
            let own = |v: u32| if v < 2 { v + 6 } else { v };
            second = second.map(|t| t.map(own));
        }
        mesh.triangles = [faces([1, 0, 3, 2]), second].concat();
        if mesh.volume() < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let data = (0..mesh.positions.len()).map(|i| i as f32).collect();
        (mesh.attributes).insert("_NUMBER".to_owned(), Attribute { width: 1, data });
        mesh.materials = (0..8).collect();
        mesh
    }

    #[test]
    fn sheets_that_meet_at_an_edge_are_separated() {
        for shared in [false, true] {
            let mut mesh = tetrahedra(shared);
            let (volume, vertices) = (mesh.volume(), mesh.positions.len());
            assert!(volume > 0.1, "{volume}");
            assert_eq!(mesh.adjacency().non_manifold.len(), 1);
            assert_eq!(separate_sheets(&mut mesh, &Context::quiet()), Ok(1));
            assert!(mesh.adjacency().non_manifold.is_empty());
            // Still closed, each half of a triangle of its material, and hardly smaller.
            assert!(
                mesh.adjacency()
                    .neighbours
                    .as_flattened()
                    .iter()
                    .all(|&n| n != u32::MAX)
            );
            assert_eq!((mesh.triangles.len(), mesh.materials.len()), (12, 12));
            // Two middles, and the ends of one of the two.
            assert_eq!(mesh.positions.len(), vertices + 4);
            assert_eq!(mesh.attributes["_NUMBER"].data.len(), vertices + 4);
            assert_eq!(mesh.shells().count, 2);
            let lost = (volume - mesh.volume()) / volume;
            assert!(lost > 0.0 && lost < 2.0 * INSET, "{lost}");
            assert_eq!(separate_sheets(&mut mesh, &Context::quiet()), Ok(0));
        }
    }

    #[test]
    fn cards_seen_from_both_sides_and_flaps_stay_as_they_are() {
        let positions = [
            [0., 0., 0.],
            [1., 0., 0.],
            [1., 1., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
        ];
        let card = Mesh {
            positions: positions.map(DVec3::from).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]],
            ..Mesh::default()
        };
        let flap = Mesh {
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 2, 4]],
            ..card.clone()
        };
        for mesh in [card, flap] {
            assert_eq!(mesh.adjacency().non_manifold.len(), 1);
            let mut separated = mesh.clone();
            assert_eq!(separate_sheets(&mut separated, &Context::quiet()), Ok(0));
            assert_eq!(separated, mesh);
        }
    }
}
