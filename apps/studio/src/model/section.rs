//! The plane faces of pieces that are cut open in the picture: where a plane meets closed pieces, filled with wood.

use super::meshes::{DrawnScene, Vertex};
use glam::{DVec2, Vec3};
use greenstick::geometry::triangulate::Triangulator;
use std::collections::{BTreeMap, HashMap};

/// How far faces lie behind the plane that cuts, radii of the scene: what lies before it is not drawn.
const BEHIND: f32 = 1e-5;
/// The tissue of what is in all of them.
const ALL_TISSUES: f32 = -1.0;

/// A plane: what lies on the side that its unit normal points to, farther than `distance` (m from the middle), is cut away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// The unit normal.
    pub normal: Vec3,
    /// Its distance from the middle, m.
    pub distance: f32,
}

/// The faces in a plane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SectionFaces {
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Corners of triangles.
    pub indices: Vec<u32>,
}

/// A point where the plane meets an edge.
#[derive(Debug, Clone, Copy)]
struct Met {
    place: Vec3,
    grain: [f32; 4],
}

/// The lines in which the plane meets one piece.
#[derive(Debug, Default)]
struct Lines {
    points: Vec<Met>,
    /// The number of the point on each edge, by the positions of its ends.
    known: HashMap<[[u32; 3]; 2], u32>,
    /// From each point to those after it, with the piece on the left as seen against the normal.
    after: BTreeMap<u32, Vec<u32>>,
}

impl Lines {
    /// The point of the plane on the edge from `a` to `b`, which lie on different sides at `heights`.
    fn point(&mut self, [a, b]: [&Vertex; 2], heights: [f32; 2]) -> u32 {
        let bits = |v: &Vertex| v.position.map(f32::to_bits);
        let (mut ends, mut heights) = ([a, b], heights);
        // Both triangles of an edge find the same point.
        if bits(a) > bits(b) {
            ends.reverse();
            heights.reverse();
        }
        let next = self.points.len() as u32;
        let number = *self.known.entry(ends.map(bits)).or_insert(next);
        if number == next {
            let t = heights[0] / (heights[0] - heights[1]);
            let between = |x: f32, y: f32| x + (y - x) * t;
            let [p, q] = ends.map(|v| Vec3::from_array(v.position));
            let (from, to) = (ends[0].grain, ends[1].grain);
            self.points.push(Met {
                place: p.lerp(q, t),
                // What does not lie on the stem has no address.
                grain: std::array::from_fn(|i| between(from[i], to[i])),
            });
        }
        number
    }

    /// Adds the line in a triangle whose corners lie at `heights` above the plane.
    fn add(&mut self, corners: [&Vertex; 3], heights: [f32; 3]) {
        let above = heights.map(|h| h > 0.0);
        // The corner that lies alone on its side.
        let Some(k) =
            (0..3).find(|&k| above[k] != above[(k + 1) % 3] && above[k] != above[(k + 2) % 3])
        else {
            return;
        };
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        let from = self.point([corners[k], corners[next]], [heights[k], heights[next]]);
        let to = self.point([corners[last], corners[k]], [heights[last], heights[k]]);
        let (from, to) = if above[k] { (from, to) } else { (to, from) };
        if from != to {
            self.after.entry(from).or_default().push(to);
        }
    }

    /// The closed loops; lines that do not close, of pieces that are not closed, are left out.
    fn loops(&mut self) -> Vec<Vec<u32>> {
        let mut loops = Vec::new();
        while let Some((&first, _)) = self.after.first_key_value() {
            let mut ring = Vec::new();
            let mut at = first;
            while let Some(list) = self.after.get_mut(&at) {
                ring.push(at);
                let next = list.pop();
                if list.is_empty() {
                    self.after.remove(&at);
                }
                let Some(next) = next else { break };
                at = next;
                if at == first {
                    break;
                }
            }
            if at == first && ring.len() > 2 {
                loops.push(ring);
            }
        }
        loops
    }
}

/// The faces in which a plane meets the pieces of a scene.
pub fn section_faces(scene: &DrawnScene, plane: Plane) -> SectionFaces {
    let mut pieces: BTreeMap<u32, Lines> = BTreeMap::new();
    let height = |v: &Vertex| plane.normal.dot(v.position.into()) - plane.distance;
    for corners in scene.indices.as_chunks::<3>().0 {
        let corners = corners.map(|i| &scene.vertices[i as usize]);
        let heights = corners.map(height);
        let above = heights.map(|h| h > 0.0);
        if above[0] != above[1] || above[1] != above[2] {
            let piece = corners[0].zone_piece[1] as u32;
            pieces.entry(piece).or_default().add(corners, heights);
        }
    }
    let mut out = SectionFaces::default();
    let mut triangulator = Triangulator::default();
    let behind = plane.normal * (BEHIND * scene.radius as f32);
    for (piece, mut lines) in pieces {
        let loops = lines.loops();
        for face in Faces::new(&lines.points, plane.normal, loops).with_holes() {
            let (ids, starts) = face;
            let flat: Vec<DVec2> = (ids.iter())
                .map(|&i| flat(plane.normal, lines.points[i as usize].place))
                .collect();
            let mut triangles = Vec::new();
            // A loop that meets itself by rounding stays open.
            if triangulator
                .polygon_with_holes(&flat, &starts, &mut triangles)
                .is_err()
            {
                continue;
            }
            let first = out.vertices.len() as u32;
            out.vertices.extend(ids.iter().map(|&i| {
                let point = lines.points[i as usize];
                let mut grain = point.grain;
                grain[3] = f32::from(u8::from(grain[3] > 0.99));
                Vertex {
                    position: (point.place - behind).to_array(),
                    normal: plane.normal.to_array(),
                    uv: [0.0; 2],
                    grain,
                    zone_piece: [ALL_TISSUES, piece as f32],
                }
            }));
            let corners = triangles.as_flattened().iter();
            out.indices.extend(corners.map(|i| first + i));
        }
    }
    out
}

/// A point in coordinates of the plane, counter-clockwise as seen against its normal.
fn flat(normal: Vec3, place: Vec3) -> DVec2 {
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    DVec2::new(place.dot(u).into(), place.dot(v).into())
}

/// A loop with its points in the plane.
struct Loop {
    ids: Vec<u32>,
    flat: Vec<DVec2>,
    area: f64,
}

/// The loops of one piece: outer ones run counter-clockwise, holes clockwise.
struct Faces {
    outer: Vec<Loop>,
    holes: Vec<Loop>,
}

impl Faces {
    fn new(points: &[Met], normal: Vec3, loops: Vec<Vec<u32>>) -> Self {
        let of = |ids: Vec<u32>| {
            let flat: Vec<DVec2> = (ids.iter())
                .map(|&i| flat(normal, points[i as usize].place))
                .collect();
            let area = twice_area(&flat);
            Loop { ids, flat, area }
        };
        let (outer, holes) = loops.into_iter().map(of).partition(|l| l.area >= 0.0);
        Faces { outer, holes }
    }

    /// Each outer loop followed by the holes in it, as the numbers of its points, and where the holes start among them.
    fn with_holes(&self) -> Vec<(Vec<u32>, Vec<usize>)> {
        let mut faces: Vec<(Vec<u32>, Vec<usize>)> = (self.outer.iter())
            .map(|l| (l.ids.clone(), Vec::new()))
            .collect();
        for hole in &self.holes {
            // The smallest loop around it.
            let around = (0..self.outer.len())
                .filter(|&i| contains(&self.outer[i].flat, hole.flat[0]))
                .min_by(|&a, &b| self.outer[a].area.total_cmp(&self.outer[b].area));
            if let Some(i) = around {
                let (ids, starts) = &mut faces[i];
                starts.push(ids.len());
                ids.extend(&hole.ids);
            }
        }
        faces
    }
}

fn twice_area(ring: &[DVec2]) -> f64 {
    (0..ring.len())
        .map(|i| ring[i].perp_dot(ring[(i + 1) % ring.len()]))
        .sum()
}

/// Whether a point lies in a loop (even–odd rule).
fn contains(ring: &[DVec2], p: DVec2) -> bool {
    let crosses = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
    };
    (0..ring.len()).filter(|&i| crosses(i)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick::geometry::{Node, Scene};
    use greenstick::wood::primitive::cylinder;

    fn area(faces: &SectionFaces) -> f64 {
        let place = |i: u32| Vec3::from_array(faces.vertices[i as usize].position).as_dvec3();
        let corners = faces.indices.as_chunks::<3>().0.iter();
        corners
            .map(|&[a, b, c]| {
                let (a, b, c) = (place(a), place(b), place(c));
                0.5 * (b - a).cross(c - a).length()
            })
            .sum()
    }

    fn drawn(nodes: Vec<Node>) -> DrawnScene {
        DrawnScene::unbroken(&Scene {
            nodes,
            ..Scene::default()
        })
    }

    /// A cylinder of 64 sides is cut along, across and aslant: a rectangle, a polygon and an ellipse.
    #[test]
    fn the_faces_of_a_cylinder_have_the_areas_of_its_sections() {
        let (radius, length, sides) = (0.02, 0.3, 64);
        let at = glam::DAffine3::IDENTITY;
        let scene = drawn(vec![Node::new("a", at, cylinder(radius, length, sides))]);
        let polygon = 0.5
            * f64::from(sides)
            * radius
            * radius
            * (std::f64::consts::TAU / f64::from(sides)).sin();
        let axis = (0..3).max_by(|&a, &b| {
            let reach = |i: usize| {
                scene
                    .vertices
                    .iter()
                    .map(|v| v.position[i])
                    .fold(0.0, f32::max)
            };
            reach(a).total_cmp(&reach(b))
        });
        let along = Vec3::AXES[axis.unwrap()];
        let across = along.any_orthonormal_vector();
        for (normal, expected) in [
            (across, 2.0 * radius * length),
            (along, polygon),
            ((along + across).normalize(), polygon * 2f64.sqrt()),
        ] {
            let distance = 0.0001;
            let faces = section_faces(&scene, Plane { normal, distance });
            let found = area(&faces);
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{normal}: {found} for {expected}"
            );
            for v in &faces.vertices {
                let off = normal.dot(v.position.into()) - distance;
                assert!(off <= 0.0 && off > -1e-5);
            }
        }
    }

    /// A tube's section is a ring; one that is open has none.
    #[test]
    fn holes_stay_open_and_what_is_not_closed_has_no_face() {
        let at = glam::DAffine3::IDENTITY;
        let (outer, mut inner) = (cylinder(0.02, 0.3, 64), cylinder(0.01, 0.2, 64));
        inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let mut open = cylinder(0.02, 0.3, 64);
        let whole = drawn(vec![Node::new("a", at, outer.clone())]);
        let hollow = drawn(vec![Node::new("a", at, outer), Node::new("b", at, inner)]);
        let plane = Plane {
            normal: Vec3::new(0.6, 0.64, 0.48),
            distance: 0.0001,
        };
        let [whole, hollow] = [whole, hollow].map(|s| area(&section_faces(&s, plane)));
        assert!((hollow / whole - 0.75).abs() < 2e-3, "{hollow} of {whole}");
        open.triangles.truncate(open.triangles.len() / 2);
        let open = drawn(vec![Node::new("a", at, open)]);
        assert_eq!(section_faces(&open, plane).indices.len(), 0);
    }
}
