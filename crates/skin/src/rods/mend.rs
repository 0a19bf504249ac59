//! Makes the open faces a manifold: a crack may end in an edge or a vertex, so that several sheets of skin meet in it.

use super::faces::{Faces, Source, Triangle, Vertex, blended};
use glam::DVec3;
use greenstick_geometry::Unions;
use rustc_hash::FxHashMap;

/// Parts edges of more than two triangles, and vertices in which several fans of triangles meet. Returns how many.
pub(super) fn mend(faces: &mut Faces) -> (usize, usize) {
    let mut edges = 0;
    // Halving an edge makes edges of two triangles only; a second round finds none.
    for _ in 0..3 {
        let parted = part_edges(faces);
        edges += parted;
        if parted == 0 {
            break;
        }
    }
    (edges, part_fans(faces))
}

/// Uses of an edge: triangle, which of its sides, and whether it runs from the smaller vertex to the larger.
type Uses = Vec<(u32, u8, bool)>;

fn edges_of(faces: &Faces) -> Vec<((u32, u32), Uses)> {
    let mut edges: FxHashMap<(u32, u32), Uses> = FxHashMap::default();
    for (t, triangle) in faces.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
            let uses = edges.entry((a.min(b), a.max(b))).or_default();
            uses.push((t as u32, k as u8, a < b));
        }
    }
    let mut many: Vec<_> = edges
        .into_iter()
        .filter(|(_, uses)| uses.len() > 2)
        .collect();
    many.sort_unstable_by_key(|(edge, _)| *edge);
    many
}

/// Pairs the triangles of edges of more than two: about the edge those pair that bound the same wedge of wood. Every pair
/// but the first gets a vertex of its own in the middle of the edge.
fn part_edges(faces: &mut Faces) -> usize {
    let many = edges_of(faces);
    // Which sides of each triangle get which middle.
    let mut halved: FxHashMap<u32, [Option<u32>; 3]> = FxHashMap::default();
    let mut parted = 0;
    for ((a, b), uses) in many {
        for pair in wedges(faces, a, b, &uses).into_iter().skip(1) {
            let [p, q] = [a, b].map(|v| &faces.vertices[v as usize]);
            let vertex = Vertex {
                grain: 0.5 * (p.grain + q.grain),
                rest: DVec3::ZERO,
                follows: blended(&[&p.follows, &q.follows]),
                cracked: true,
                source: Source::Middle([a, b]),
                closed: DVec3::ZERO,
            };
            let new = faces.vertices.len() as u32;
            faces.vertices.push(vertex);
            parted += 1;
            for (t, k) in pair {
                halved.entry(t).or_default()[usize::from(k)] = Some(new);
            }
        }
    }
    let mut all: Vec<_> = halved.into_iter().collect();
    all.sort_unstable_by_key(|(t, _)| *t);
    for (t, middles) in all {
        split(faces, t, middles);
    }
    parted
}

/// The uses of an edge in pairs that bound the same wedge of wood, by their angle about the edge.
fn wedges(faces: &Faces, a: u32, b: u32, uses: &Uses) -> Vec<Vec<(u32, u8)>> {
    let at = |v: u32| faces.vertices[v as usize].grain;
    let axis = (at(b) - at(a)).normalize_or(DVec3::Z);
    let (x, y) = axis.any_orthonormal_pair();
    let mut around: Vec<(f64, u32, u8, bool)> = uses
        .iter()
        .map(|&(t, k, forward)| {
            let opposite = faces.triangles[t as usize].corners[(usize::from(k) + 2) % 3];
            let d = at(opposite) - 0.5 * (at(a) + at(b));
            (libm::atan2(d.dot(y), d.dot(x)), t, k, forward)
        })
        .collect();
    // Of two that lie on each other wood ends at the first and begins at the second.
    around.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(q.3.cmp(&p.3)).then(p.1.cmp(&q.1)));
    // A triangle that runs along the axis, seen along it, has its inside clockwise of it, and wood ends there; one that
    // runs back has it counter-clockwise, and wood begins. So each that runs back pairs with the next one along.
    let n = around.len();
    let mut pairs = Vec::new();
    for i in 0..n {
        if !around[i].3 {
            let next = (1..n).map(|j| around[(i + j) % n]).find(|u| u.3);
            if let Some(next) = next {
                pairs.push(vec![(around[i].1, around[i].2), (next.1, next.2)]);
            }
        }
    }
    pairs
}

/// Replaces a triangle some of whose sides have a vertex in their middle.
fn split(faces: &mut Faces, t: u32, middles: [Option<u32>; 3]) {
    let triangle = faces.triangles[t as usize];
    let mut ring: Vec<u32> = Vec::new();
    for (k, middle) in middles.into_iter().enumerate() {
        ring.push(triangle.corners[k]);
        ring.extend(middle);
    }
    // From a middle every other vertex of the ring is seen; its neighbours on its own side are not used together.
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

/// Gives each fan of triangles about a vertex a vertex of its own.
fn part_fans(faces: &mut Faces) -> usize {
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
    let mut parted = 0;
    for corner in 0..3 * faces.triangles.len() as u32 {
        let (t, k) = (corner as usize / 3, corner as usize % 3);
        let v = faces.triangles[t].corners[k];
        let fan = fans.root(corner);
        let known = &mut first_fan[v as usize];
        if *known == u32::MAX {
            *known = fan;
        }
        if *known == fan {
            continue;
        }
        let new = *own.entry(fan).or_insert_with(|| {
            parted += 1;
            faces.vertices[v as usize].cracked = true;
            let vertex = faces.vertices[v as usize].clone();
            faces.vertices.push(vertex);
            faces.vertices.len() as u32 - 1
        });
        faces.triangles[t].corners[k] = new;
    }
    parted
}
