//! Makes the open faces a manifold. A crack may end in an edge or a vertex, so that several sheets of skin meet there.

use super::open_faces::{OpenFaces, Triangle, Vertex, VertexOrigin, mean_weights};
use glam::DVec3;
use greenstick_geometry::Unions;
use rustc_hash::FxHashMap;

/// Where several sheets of skin met and were separated.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NonmanifoldSplits {
    /// Vertices added in the middle of edges that had more than two triangles.
    pub edges: usize,
    /// Copies made of vertices in which several fans of triangles met.
    pub vertices: usize,
}

/// Splits edges of more than two triangles, and vertices in which several fans of triangles meet.
pub(super) fn split_nonmanifold_vertices(faces: &mut OpenFaces) -> NonmanifoldSplits {
    let mut edges = 0;
    // Halving an edge makes edges of two triangles only; a second round finds none.
    for _ in 0..3 {
        let split = split_edges(faces);
        edges += split;
        if split == 0 {
            break;
        }
    }
    NonmanifoldSplits {
        edges,
        vertices: split_fans(faces),
    }
}

/// The use of an edge by a triangle.
#[derive(Debug, Clone, Copy)]
struct EdgeUse {
    triangle: u32,
    side: u8,
    /// Whether the side runs from the smaller vertex to the larger.
    forward: bool,
}

/// Returns the edges that have more than two triangles, with their uses.
fn crowded_edges(faces: &OpenFaces) -> Vec<((u32, u32), Vec<EdgeUse>)> {
    let mut edges: FxHashMap<(u32, u32), Vec<EdgeUse>> = FxHashMap::default();
    for (t, triangle) in faces.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
            let uses = edges.entry((a.min(b), a.max(b))).or_default();
            uses.push(EdgeUse {
                triangle: t as u32,
                side: k as u8,
                forward: a < b,
            });
        }
    }
    let mut crowded: Vec<_> = edges
        .into_iter()
        .filter(|(_, uses)| uses.len() > 2)
        .collect();
    crowded.sort_unstable_by_key(|(edge, _)| *edge);
    crowded
}

/// Pairs the triangles of edges that have more than two: those that bound the same wedge of wood. Every pair but the first
/// gets a vertex of its own in the middle of the edge. Returns the number of vertices added.
fn split_edges(faces: &mut OpenFaces) -> usize {
    let crowded = crowded_edges(faces);
    // The new vertex in the middle of each side of a triangle.
    let mut halved: FxHashMap<u32, [Option<u32>; 3]> = FxHashMap::default();
    let mut added = 0;
    for ((a, b), uses) in crowded {
        for pair in wedges(faces, a, b, &uses).into_iter().skip(1) {
            let [p, q] = [a, b].map(|v| &faces.vertices[v as usize]);
            let vertex = Vertex {
                grain: 0.5 * (p.grain + q.grain),
                rest: DVec3::ZERO,
                weights: mean_weights(&[&p.weights, &q.weights]),
                is_on_crack: true,
                origin: VertexOrigin::Middle([a, b]),
                closed_rest: DVec3::ZERO,
            };
            let new = faces.vertices.len() as u32;
            faces.vertices.push(vertex);
            added += 1;
            for EdgeUse { triangle, side, .. } in pair {
                halved.entry(triangle).or_default()[usize::from(side)] = Some(new);
            }
        }
    }
    let mut all: Vec<_> = halved.into_iter().collect();
    all.sort_unstable_by_key(|(t, _)| *t);
    for (t, middles) in all {
        split_triangle(faces, t, middles);
    }
    added
}

/// Returns the uses of an edge in pairs that bound the same wedge of wood, by their angle about the edge.
fn wedges(faces: &OpenFaces, a: u32, b: u32, uses: &[EdgeUse]) -> Vec<[EdgeUse; 2]> {
    let at = |v: u32| faces.vertices[v as usize].grain;
    let axis = (at(b) - at(a)).normalize_or(DVec3::Z);
    let (x, y) = axis.any_orthonormal_pair();
    let mut around: Vec<(f64, EdgeUse)> = uses
        .iter()
        .map(|&edge_use| {
            let corners = faces.triangles[edge_use.triangle as usize].corners;
            let opposite = corners[(usize::from(edge_use.side) + 2) % 3];
            let d = at(opposite) - 0.5 * (at(a) + at(b));
            (libm::atan2(d.dot(y), d.dot(x)), edge_use)
        })
        .collect();
    // Of two that coincide wood ends at the first and begins at the second.
    around.sort_unstable_by(|(p, first), (q, second)| {
        p.total_cmp(q)
            .then(second.forward.cmp(&first.forward))
            .then(first.triangle.cmp(&second.triangle))
    });
    // A triangle that runs along the axis, seen along it, has its inside clockwise of it, and wood ends there; one that
    // runs back has it counter-clockwise, and wood begins. So each that runs back pairs with the next one along.
    let n = around.len();
    let mut pairs = Vec::new();
    for i in 0..n {
        let (_, backward) = around[i];
        if !backward.forward {
            let mut following = (1..n).map(|j| around[(i + j) % n].1);
            if let Some(next) = following.find(|u| u.forward) {
                pairs.push([backward, next]);
            }
        }
    }
    pairs
}

/// Replaces a triangle some of whose sides have a vertex in their middle.
fn split_triangle(faces: &mut OpenFaces, t: u32, middles: [Option<u32>; 3]) {
    let triangle = faces.triangles[t as usize];
    let mut ring: Vec<u32> = Vec::new();
    for (k, middle) in middles.into_iter().enumerate() {
        ring.push(triangle.corners[k]);
        ring.extend(middle);
    }
    // Every other vertex of the ring is visible from a middle; its two neighbours on its own side never share a triangle.
    let start = middles.iter().position(Option::is_some).map_or(0, |k| {
        let middle = middles[k];
        ring.iter().position(|&v| Some(v) == middle).unwrap_or(0)
    });
    ring.rotate_left(start);
    let fan = (1..ring.len() - 1).map(|i| Triangle {
        corners: [ring[0], ring[i], ring[i + 1]],
        ..triangle
    });
    let made: Vec<Triangle> = fan.collect();
    for (i, triangle) in made.into_iter().enumerate() {
        if i == 0 {
            faces.triangles[t as usize] = triangle;
        } else {
            faces.triangles.push(triangle);
        }
    }
}

/// Gives each fan of triangles about a vertex a vertex of its own. Returns the number of vertices added.
fn split_fans(faces: &mut OpenFaces) -> usize {
    let mut fans = Unions::new(3 * faces.triangles.len());
    let mut edges: FxHashMap<(u32, u32), (u32, u32)> = FxHashMap::default();
    for (t, triangle) in faces.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
            let (here, next) = ((3 * t + k) as u32, (3 * t + (k + 1) % 3) as u32);
            match edges.remove(&(b, a)) {
                // The other triangle ran from b to a: its first corner is at b.
                Some((first, second)) => {
                    fans.join(first, next);
                    fans.join(second, here);
                }
                None => {
                    edges.insert((a, b), (here, next));
                }
            }
        }
    }
    let mut first_fan = vec![u32::MAX; faces.vertices.len()];
    let mut own: FxHashMap<u32, u32> = FxHashMap::default();
    let mut added = 0;
    for corner in 0..3 * faces.triangles.len() as u32 {
        let (t, k) = (corner as usize / 3, corner as usize % 3);
        let v = faces.triangles[t].corners[k];
        let fan = fans.root(corner);
        let first = &mut first_fan[v as usize];
        if *first == u32::MAX {
            *first = fan;
        }
        if *first == fan {
            continue;
        }
        let new = *own.entry(fan).or_insert_with(|| {
            added += 1;
            faces.vertices[v as usize].is_on_crack = true;
            let vertex = faces.vertices[v as usize].clone();
            faces.vertices.push(vertex);
            faces.vertices.len() as u32 - 1
        });
        faces.triangles[t].corners[k] = new;
    }
    added
}
