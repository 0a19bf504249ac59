//! Cutting a mesh across a stem: the triangles that a plane crosses about the stem are split, and nothing else.

use glam::{DVec2, DVec3};
use greenstick_geometry::Mesh;
use greenstick_wood::polygon::area_and_centroid;
use greenstick_wood::stem::Frame;
use std::collections::BTreeMap;

/// A vertex nearer to the plane than this, in radii, makes the plane move.
const MIN_VERTEX_DISTANCE: f64 = 1e-9;
/// How far the plane moves at a time, in radii.
const PLANE_STEP: f64 = 1e-7;
/// Largest number of such steps.
const MAX_PLANE_STEPS: usize = 1000;
/// A loop that differs more than this from the expected section is not a section of the stem.
const MAX_MISMATCH: f64 = 1.0;

/// Where a mesh is cut.
pub(super) struct CutPlane {
    /// The plane is across the frame's tangent.
    pub frame: Frame,
    /// Centroid of the section that is expected there, m, in the frame.
    pub expected_centroid: DVec2,
    /// Area of that section, m².
    pub expected_area: f64,
    /// Radius of the stem, m.
    pub radius: f64,
}

impl CutPlane {
    /// Returns the height of a point above the plane, m.
    pub fn height(&self, p: DVec3) -> f64 {
        (p - self.frame.origin).dot(self.frame.tangent)
    }

    /// Returns a point in the coordinates of the frame's section.
    fn project(&self, p: DVec3) -> DVec2 {
        let p = p - self.frame.origin;
        DVec2::new(p.dot(self.frame.x), p.dot(self.frame.y))
    }

    /// Returns by how much a loop differs from the expected section: in area, as a logarithm, and in place, in radii.
    fn mismatch(&self, section: &[DVec2]) -> f64 {
        let (area, centroid) = area_and_centroid(section);
        let ratio = (area.abs() / self.expected_area).max(1e-300);
        libm::log(ratio).abs() + centroid.distance(self.expected_centroid) / self.radius
    }
}

/// A closed loop in which a plane cuts a mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct CutLoop {
    /// The new vertices of the mesh on it. Several lie at one point where the mesh has a seam.
    pub vertices: Vec<u32>,
    /// The points along it, m.
    pub positions: Vec<DVec3>,
    /// The same points in the section, counter-clockwise.
    pub section: Vec<DVec2>,
}

/// An edge between two points, the lower number first.
type Edge = (u32, u32);

fn edge(a: u32, b: u32) -> Edge {
    (a.min(b), a.max(b))
}

/// A triangle that a plane crosses, and those of its edges that it crosses.
struct CrossedTriangle {
    triangle: usize,
    edges: [Edge; 2],
}

/// The points of a mesh, in which vertices at the same position are one, and their heights above a plane.
struct PointHeights {
    point_of: Vec<u32>,
    position: Vec<DVec3>,
    height: Vec<f64>,
}

impl PointHeights {
    /// Measures heights above a plane that goes through no point, so that every triangle that it crosses is split into
    /// three. `None` where no such plane is near.
    fn new(mesh: &Mesh, plane: &CutPlane) -> Option<Self> {
        let (point_of, count) = mesh.points();
        let mut position = vec![DVec3::ZERO; count];
        for (&point, &p) in point_of.iter().zip(&mesh.positions) {
            position[point as usize] = p;
        }
        let mut height: Vec<f64> = position.iter().map(|&p| plane.height(p)).collect();
        let mut offsets = (0..MAX_PLANE_STEPS).map(|k| PLANE_STEP * plane.radius * k as f64);
        let clear = MIN_VERTEX_DISTANCE * plane.radius;
        let offset = offsets.find(|by| height.iter().all(|h| (h - by).abs() > clear))?;
        height.iter_mut().for_each(|h| *h -= offset);
        Some(PointHeights {
            point_of,
            position,
            height,
        })
    }

    /// Returns the corner of a triangle of points that is on the other side of the plane than the two others.
    fn lone_corner(&self, points: [u32; 3]) -> Option<usize> {
        let [a, b, c] = points.map(|p| self.height[p as usize] > 0.0);
        match (a == b, b == c) {
            (true, true) => None,
            (true, false) => Some(2),
            (false, true) => Some(0),
            (false, false) => Some(1),
        }
    }

    /// Returns where the plane crosses an edge, as a fraction of it.
    fn fraction(&self, (a, b): Edge) -> f64 {
        self.height[a as usize] / (self.height[a as usize] - self.height[b as usize])
    }

    fn crossing(&self, edge: Edge) -> DVec3 {
        self.position[edge.0 as usize].lerp(self.position[edge.1 as usize], self.fraction(edge))
    }

    fn crossed_triangles(&self, mesh: &Mesh, own: &[bool]) -> Vec<CrossedTriangle> {
        let mut crossed = Vec::new();
        for (triangle, corners) in mesh.triangles.iter().enumerate().filter(|(t, _)| own[*t]) {
            let p = corners.map(|v| self.point_of[v as usize]);
            if let Some(k) = self.lone_corner(p) {
                let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
                if a != b && b != c && c != a {
                    crossed.push(CrossedTriangle {
                        triangle,
                        edges: [edge(a, b), edge(a, c)],
                    });
                }
            }
        }
        crossed
    }
}

/// Returns the closed loops in which a plane crosses triangles, as the edges along them.
fn closed_loops(crossed: &[CrossedTriangle]) -> Vec<Vec<Edge>> {
    let mut at: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
    for (k, crossed) in crossed.iter().enumerate() {
        (crossed.edges.iter()).for_each(|e| at.entry(*e).or_default().push(k));
    }
    let mut used = vec![false; crossed.len()];
    let mut found = Vec::new();
    for start in 0..crossed.len() {
        let mut edges = Vec::new();
        let (mut k, mut from) = (start, crossed[start].edges[0]);
        while !used[k] {
            used[k] = true;
            edges.push(from);
            let [a, b] = crossed[k].edges;
            from = if a == from { b } else { a };
            match at[&from][..] {
                [x, y] => k = if x == k { y } else { x },
                // An open border, or more than two triangles at an edge.
                _ => break,
            }
        }
        if edges.len() > 2 && k == start && from == edges[0] {
            found.push(edges);
        }
    }
    found
}

/// Cuts the triangles of `mesh` that `own` marks where `plane` crosses them about the stem: each is split into one on one
/// side and two on the other. `own` grows with the mesh.
///
/// Returns `None`, and changes nothing, where no closed loop resembles the expected section.
pub(super) fn cut_across_stem(
    mesh: &mut Mesh,
    own: &mut Vec<bool>,
    plane: &CutPlane,
) -> Option<CutLoop> {
    let heights = PointHeights::new(mesh, plane)?;
    let mut crossed = heights.crossed_triangles(mesh, own);
    let section = |edges: &[Edge]| -> Vec<DVec2> {
        let points = edges.iter().map(|&e| heights.crossing(e));
        points.map(|p| plane.project(p)).collect()
    };
    let chosen = (closed_loops(&crossed).into_iter())
        .map(|edges| (plane.mismatch(&section(&edges)), edges))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(mismatch, _)| *mismatch < MAX_MISMATCH)?
        .1;
    let mut sorted = chosen.clone();
    sorted.sort_unstable();
    crossed.retain(|c| sorted.binary_search(&c.edges[0]).is_ok());
    let mut cut = CutLoop {
        vertices: Vec::new(),
        positions: chosen.iter().map(|&e| heights.crossing(e)).collect(),
        section: section(&chosen),
    };
    if area_and_centroid(&cut.section).0 < 0.0 {
        cut.positions.reverse();
        cut.section.reverse();
    }
    cut.vertices = split_triangles(mesh, own, &crossed, &heights);
    Some(cut)
}

/// Splits triangles where a plane crosses them. Returns the new vertices.
fn split_triangles(
    mesh: &mut Mesh,
    own: &mut Vec<bool>,
    crossed: &[CrossedTriangle],
    heights: &PointHeights,
) -> Vec<u32> {
    let point_of = &heights.point_of;
    let mut vertices = Vec::new();
    let mut new: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for &CrossedTriangle { triangle, .. } in crossed {
        let corners = mesh.triangles[triangle];
        let Some(k) = heights.lone_corner(corners.map(|v| point_of[v as usize])) else {
            continue;
        };
        let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let [p, q] = [b, c].map(|other| {
            // In the order of the points, so that both sides of a seam get the same bits.
            let in_order = point_of[a as usize] < point_of[other as usize];
            let (v, w) = if in_order { (a, other) } else { (other, a) };
            *new.entry((v, w)).or_insert_with(|| {
                let ends = (point_of[v as usize], point_of[w as usize]);
                let (t, crossing) = (heights.fraction(ends), heights.crossing(ends));
                let vertex = mesh.push_vertex_between((v, w), t, crossing);
                vertices.push(vertex);
                vertex
            })
        });
        mesh.triangles[triangle] = [a, p, q];
        mesh.triangles.extend([[p, b, c], [p, c, q]]);
        if !mesh.materials.is_empty() {
            let material = mesh.materials[triangle];
            mesh.materials.extend([material; 2]);
        }
        own.extend([true; 2]);
    }
    vertices
}
