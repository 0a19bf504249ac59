//! Vertices of a break's outline on the skin that files hold at one position. There the two sides of a splinter or of a gap meet
//! although they lie apart, in an edge of four triangles that nothing can take apart again. So each gets a position of its own.

use glam::DVec3;
use greenstick_fracture::cut::{CutVertex, Host};
use rustc_hash::FxHashSet;

/// Most steps that a vertex is moved, each as long as positions in files are apart: a few, as only the outline of something thinner
/// than that has so many vertices there.
const MOST_STEPS: u32 = 8;

/// Moves vertices of an outline along the edges and triangles of the skin that they lie on, so that files hold no two of them, and
/// none of them and a point of the mesh, at one position. Vertices on an edge keep their order. `points` are those of the mesh,
/// `corners` returns those of its triangles. A vertex that has no free place within [`MOST_STEPS`] stays. Returns how many were moved.
pub(super) fn part_equal_positions(
    points: &[DVec3],
    corners: &dyn Fn(u32) -> [DVec3; 3],
    vertices: &mut [CutVertex],
) -> usize {
    let mut taken: FxHashSet<[u64; 3]> = points.iter().map(|&p| position_key(p)).collect();
    let mut on_edges: Vec<([u32; 2], f64, usize)> = Vec::new();
    let mut on_faces: Vec<usize> = Vec::new();
    for (i, vertex) in vertices.iter().enumerate() {
        match vertex.host {
            Host::Edge { ends, t } => on_edges.push((ends, t, i)),
            Host::Face { .. } => on_faces.push(i),
            Host::Point(_) | Host::Inside => {}
        }
    }
    on_edges.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut moved = 0;
    for edge in on_edges.chunk_by(|a, b| a.0 == b.0) {
        let ends = edge[0].0;
        let [a, b] = ends.map(|p| points[p as usize]);
        let step = spacing(a.abs().max(b.abs())) / a.distance(b);
        let mut before = 0.0;
        for &(_, t, i) in edge {
            let from = if t > before { t } else { before + step };
            let at = |k: u32| from + f64::from(k) * step;
            let free = (0..=MOST_STEPS)
                .map(at)
                .take_while(|&t| t < 1.0)
                .find(|&t| !taken.contains(&position_key(a.lerp(b, t))));
            let place = free.unwrap_or(t);
            taken.insert(position_key(a.lerp(b, place)));
            if place != t {
                vertices[i].host = Host::Edge { ends, t: place };
                moved += 1;
            }
            before = place;
        }
    }
    for i in on_faces {
        let Host::Face { triangle, weights } = vertices[i].host else {
            continue;
        };
        let corners = corners(triangle);
        let place = |w: [f64; 3]| corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
        let here = place(weights);
        if taken.insert(position_key(here)) {
            continue;
        }
        let towards = |(k, c): (u32, usize)| {
            let way = f64::from(k) * spacing(here.abs()) / here.distance(corners[c]);
            let mut moved = weights.map(|w| w * (1.0 - way));
            moved[c] += way;
            moved
        };
        let all = (1..=MOST_STEPS).flat_map(|k| (0..3).map(move |c| (k, c)));
        let free = all.map(towards).find(|&w| {
            w.iter().all(|part| (0.0..=1.0).contains(part)) && taken.insert(position_key(place(w)))
        });
        if let Some(weights) = free {
            vertices[i].host = Host::Face { triangle, weights };
            moved += 1;
        }
    }
    moved
}

/// How far apart positions of this size in files are, at most.
fn spacing(size: DVec3) -> f64 {
    size.max_element() * f64::from(f32::EPSILON)
}

/// A position as files hold it.
pub(super) fn rounded(p: DVec3) -> DVec3 {
    p.as_vec3().as_dvec3()
}

/// The bits of a position as files hold it; both zeros have the same.
fn position_key(p: DVec3) -> [u64; 3] {
    (rounded(p) + 0.0).to_array().map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_that_files_hold_at_one_position_are_parted_in_their_order() {
        let points = [
            DVec3::new(0.3, 2.0, -0.1),
            DVec3::new(0.2, 2.1, -0.1),
            DVec3::new(0.3, 2.0, 0.1),
        ];
        let on_edge = |t| CutVertex {
            grain: DVec3::ZERO,
            host: Host::Edge { ends: [0, 1], t },
        };
        let weights = [0.25, 0.25, 0.5];
        let on_face = CutVertex {
            grain: DVec3::ZERO,
            host: Host::Face {
                triangle: 0,
                weights,
            },
        };
        // Not in their order along the edge; the last but two is the mesh's own point as files hold it.
        let near = [0.500_000_02, 0.5, 0.500_000_01, 0.75, 1e-9].map(on_edge);
        let mut vertices: Vec<CutVertex> = near.into_iter().chain([on_face; 2]).collect();
        let place = |v: &CutVertex| match v.host {
            Host::Edge { ends: [a, b], t } => points[a as usize].lerp(points[b as usize], t),
            Host::Face { weights: w, .. } => (0..3).map(|k| points[k] * w[k]).sum(),
            _ => DVec3::NAN,
        };
        let before: Vec<DVec3> = vertices.iter().map(place).collect();
        let mut keys: Vec<_> = before.iter().map(|&p| position_key(p)).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), 4);
        let moved = part_equal_positions(&points, &|_| points, &mut vertices);
        assert_eq!(moved, 4);
        let after: Vec<DVec3> = vertices.iter().map(place).collect();
        let mut keys: Vec<_> = (after.iter().chain(&points))
            .map(|&p| position_key(p))
            .collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), vertices.len() + points.len());
        for (a, b) in before.iter().zip(&after) {
            assert!(a.distance(*b) < 1e-5, "{a} {b}");
        }
        let t = |i: usize| match vertices[i].host {
            Host::Edge { t, .. } => t,
            _ => f64::NAN,
        };
        assert!(0.0 < t(4) && t(4) < t(1) && t(1) < t(2) && t(2) < t(0) && t(0) < t(3));
        // Again, nothing is left to do.
        let (known, again) = (
            vertices.clone(),
            part_equal_positions(&points, &|_| points, &mut vertices),
        );
        assert_eq!((again, known), (0, vertices));
    }
}
