//! How far whole rods beside a face decide where the points of a piece go, and not the piece's own rods.

use super::edge_graph::EdgeGraph;
use super::rod_faces::RodFaces;
use super::section_joints::smooth;
use glam::{DVec2, DVec3};
use greenstick_geometry::Mesh;
use greenstick_geometry::cloud::KdTree;

/// Distance (radii) from where rods broke up to which the wood that holds there keeps both sides together, and that from which on
/// each side follows its own rods.
pub(super) const HINGE: (f64, f64) = (1.0, 3.0);
/// The same beyond where whole rods pass the face, among what was split off them.
const BEYOND: (f64, f64) = (0.4, 0.9);
/// Least length (radii) along the surface over which the wood goes from what holds to what does not. Where rods split beside each other,
/// the mesh has no face between them: it is sheared.
const SHEARED: f64 = 1.5;

/// Shares of the motion that wood which holds decides: at the face below a piece, and at the one above.
pub(super) type Held = [f64; 2];

/// How far whole rods decide the motion of a point of the piece below a face, or above it, at a place of the section and a
/// length along the axis (m): 1 in whole rods from where the first beside them broke to the last, 0 in broken ones, in what was split off
/// them, and far away.
pub(super) fn held(
    faces: &RodFaces,
    (face, is_below): (usize, bool),
    at: DVec2,
    along: f64,
) -> f64 {
    let (cells, radius) = (&faces.wood.cells, faces.wood.stem.radius);
    let nearest = faces.rod_at(at);
    let is_whole = |rod: usize| faces.part_before(face, rod).is_none();
    if !is_whole(nearest) {
        return 0.0;
    }
    // Bundles are not bounded as rods are, and between whole rods that pass the face at different lengths it is even.
    let reach = cells[nearest].centroid.distance(at) + faces.wood.spacing();
    let about = (0..cells.len()).filter(|&rod| cells[rod].centroid.distance(at) <= reach);
    let beyond = about.filter(|&rod| is_whole(rod)).map(|rod| {
        let length = faces.length(face, rod);
        if is_below {
            along - length
        } else {
            length - along
        }
    });
    let beyond = beyond.fold(f64::INFINITY, f64::min) / radius;
    let (low, high) = faces.range(face);
    let away = (low - along).max(along - high) / radius;
    smooth((HINGE.1 - away) / (HINGE.1 - HINGE.0))
        * smooth((BEYOND.1 - beyond) / (BEYOND.1 - BEYOND.0))
}

/// Shares at the vertices of a piece.
pub(super) struct HeldPiece {
    pub held: Vec<Held>,
    /// The vertices; none where nothing is held.
    places: Option<KdTree>,
}

impl HeldPiece {
    /// Spreads shares over a mesh, so that they change along it by no more than wood can be sheared. `radius` is the stem's, m.
    pub fn spread(mesh: &Mesh, mut held: Vec<Held>, radius: f64) -> HeldPiece {
        let sides = [0, 1].map(|side| held.iter().any(|h| h[side] > 0.0));
        if sides == [false; 2] {
            return HeldPiece { held, places: None };
        }
        let graph = EdgeGraph::new(mesh);
        let limit = SHEARED * radius;
        for side in (0..2).filter(|&side| sides[side]) {
            let starts = (0..).zip(&held).filter(|(_, h)| h[side] > 0.0);
            let starts = starts.map(|(v, h)| (v, (1.0 - h[side]) * limit));
            let reached = graph.reach(starts, limit);
            for (held, &point) in held.iter_mut().zip(&graph.points) {
                if let Some(reached) = reached[point as usize] {
                    held[side] = f64::max(held[side], 1.0 - reached.distance / limit);
                }
            }
        }
        HeldPiece {
            held,
            places: Some(KdTree::new(&mesh.positions)),
        }
    }

    /// Returns the shares of strands that stand on the piece, for each vertex of their mesh: those of the wood at the foot of its strand.
    pub fn of_strands(&self, strands: &Mesh) -> Vec<Held> {
        let none = vec![[0.0; 2]; strands.positions.len()];
        let Some(places) = &self.places else {
            return none;
        };
        let shells = strands.shells();
        let mut feet = vec![(f64::INFINITY, 0); shells.count];
        let shell_of =
            |t: usize| Some(shells.of_triangle[t] as usize).filter(|&s| s < shells.count);
        let nearest = |p: DVec3| places.nearest(p, 1).first().copied();
        for (t, triangle) in strands.triangles.iter().enumerate() {
            let Some(shell) = shell_of(t) else {
                continue;
            };
            for &v in triangle {
                if let Some(found) = nearest(strands.positions[v as usize])
                    && found.0 < feet[shell].0
                {
                    feet[shell] = found;
                }
            }
        }
        let mut held = none;
        for (t, triangle) in strands.triangles.iter().enumerate() {
            if let Some(shell) = shell_of(t) {
                for &v in triangle {
                    held[v as usize] = self.held[feet[shell].1 as usize];
                }
            }
        }
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares of 1 mm along x.
    fn strip(count: u32) -> Mesh {
        let at = |i: u32| [0.0, 1e-3].map(|y| DVec3::new(f64::from(i) * 1e-3, y, 0.0));
        Mesh {
            positions: (0..=count).flat_map(at).collect(),
            triangles: (0..count)
                .flat_map(|i| {
                    let [a, b, c, d] = [0, 1, 2, 3].map(|k| 2 * i + k);
                    [[a, c, d], [a, d, b]]
                })
                .collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn shares_change_no_faster_along_a_piece_than_wood_is_sheared() {
        let mesh = strip(60);
        let radius = 0.02;
        // A step in the middle, of the face above the piece.
        let step = |p: &DVec3| [0.0, if p.x < 0.03 { 1.0 } else { 0.0 }];
        let held = mesh.positions.iter().map(step).collect();
        let piece = HeldPiece::spread(&mesh, held, radius);
        for (p, held) in mesh.positions.iter().zip(&piece.held) {
            // The last vertices that are held lie 29 mm along.
            let expected = (1.0 - (p.x - 0.029) / (SHEARED * radius)).clamp(0.0, 1.0);
            assert!((held[1] - expected).abs() < 0.03, "{p}: {held:?}");
            assert_eq!(held[0], 0.0);
        }
        for t in &mesh.triangles {
            for [v, w] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                let [p, q] = [v, w].map(|v| mesh.positions[v as usize]);
                let change = piece.held[v as usize][1] - piece.held[w as usize][1];
                let most = p.distance(q) / (SHEARED * radius);
                assert!(change.abs() <= most * (1.0 + 1e-9));
            }
        }
    }

    #[test]
    fn strands_go_with_the_wood_that_they_stand_on() {
        let mesh = strip(60);
        let held = mesh.positions.iter().map(|p| [0.0, p.x / 0.06]).collect();
        let piece = HeldPiece::spread(&mesh, held, 0.05);
        // Two strands that stand 10 and 50 mm along and lean 8 mm over others' wood.
        let foot = |x: f64| [(x, 1e-4), (x + 1e-4, 1e-4), (x + 8e-3, 6e-3)];
        let points = [foot(0.01), foot(0.05)].concat();
        let strands = Mesh {
            positions: points.iter().map(|&(x, z)| DVec3::new(x, 0.0, z)).collect(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            ..Mesh::default()
        };
        let held = piece.of_strands(&strands);
        for (v, of) in held.iter().enumerate() {
            let foot = piece.held[if v < 3 { 20 } else { 100 }];
            assert_eq!(*of, foot);
        }
    }
}
