//! Approximate convex decomposition: a solid as a union of a few convex shapes. Planes cut the solid, always the part
//! whose hull exceeds its volume most, where the hulls of both sides are smallest; each part becomes a hull with few
//! vertices.
//!
//! A part is stored as a closed chain of triangles: where a plane cuts, every cut edge is joined with one point of the
//! plane, once for each side. Its signed volume is that of the solid in the part, whatever the section looks like.

use super::hull::{HullLimits, convex_hull};
use crate::triangle::closest_point_on_triangle;
use crate::{Cancelled, Context, Mesh, symmetric_eigen};
use glam::{DMat3, DVec3};

/// How finely a solid is decomposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexOptions {
    /// Most convex shapes, 1 or more.
    pub shapes: usize,
    /// Most vertices of each, 4 or more.
    pub vertices: usize,
    /// Cutting ends when the volume of the hulls exceeds that of the solid by less than this fraction of it.
    pub excess: f64,
}

impl Default for ConvexOptions {
    fn default() -> Self {
        ConvexOptions {
            shapes: 16,
            vertices: 32,
            excess: 0.1,
        }
    }
}

/// Convex shapes that cover a solid.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConvexParts {
    /// The shapes. Each is exactly convex, and its coordinates are exact in `f32`, so that it stays convex in files.
    pub shapes: Vec<Mesh>,
    /// Largest distance of a vertex of the solid from the nearest shape, m.
    pub uncovered: f64,
    /// Sum of the shapes' volumes over the volume of the solid.
    pub volume_ratio: f64,
}

/// Most vertices of hulls that only serve to compare cuts.
const TRIAL_VERTICES: usize = 24;
/// Equal intervals along the three axes, shortest first, between which cuts are tried: few across, more along.
const TRIAL_INTERVALS: [usize; 3] = [4, 4, 8];
/// A cut is made if it removes at least this fraction of the part's excess volume.
const MIN_IMPROVEMENT: f64 = 0.05;
/// Points closer to a shape than this fraction of its size do not become its corners: the difference is invisible.
const RELATIVE_TOLERANCE: f64 = 1e-5;

/// A part of the solid.
struct Part {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Volume of the trial hull.
    hull_volume: f64,
    volume: f64,
    /// Whether no cut improves it.
    is_final: bool,
}

impl Part {
    fn new(points: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Option<Part> {
        let hull_volume = trial_hull_volume(&points)?;
        let mut part = Part {
            volume: 0.0,
            hull_volume,
            points,
            triangles,
            is_final: false,
        };
        part.volume = part.solid_volume();
        Some(part)
    }

    fn solid_volume(&self) -> f64 {
        let origin = self.points[0];
        let six = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.points[i as usize] - origin);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// Volume by which the hull exceeds the solid.
    fn excess(&self) -> f64 {
        self.hull_volume - self.volume
    }

    /// Principal axes of the points, the shortest first.
    fn axes(&self) -> [DVec3; 3] {
        let middle = self.points.iter().sum::<DVec3>() / self.points.len() as f64;
        let covariance = self.points.iter().fold(DMat3::ZERO, |sum, &p| {
            let d = p - middle;
            sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
        });
        symmetric_eigen(covariance).map(|(_, axis)| axis)
    }

    /// The points on each side of a plane, and those where it cuts edges.
    fn sides(&self, heights: &[f64]) -> [Vec<DVec3>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for (&p, &h) in self.points.iter().zip(heights) {
            sides[usize::from(h >= 0.0)].push(p);
        }
        for t in &self.triangles {
            for (i, j) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                let (i, j) = (i as usize, j as usize);
                if heights[i] >= 0.0 && heights[j] < 0.0 {
                    let cut = crossing(&self.points, heights, i, j);
                    sides.iter_mut().for_each(|side| side.push(cut));
                }
            }
        }
        sides
    }

    /// Finds the plane for which the hulls of both sides are smallest. Returns the heights of all points above it.
    fn best_cut(&self, context: &Context) -> Result<Option<Vec<f64>>, Cancelled> {
        let mut best: Option<(f64, Vec<f64>)> = None;
        for (axis, intervals) in self.axes().into_iter().zip(TRIAL_INTERVALS) {
            let along: Vec<f64> = self.points.iter().map(|p| axis.dot(*p)).collect();
            let low = along.iter().copied().fold(f64::INFINITY, f64::min);
            let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            for place in 1..intervals {
                context.check()?;
                let at = low + (high - low) * place as f64 / intervals as f64;
                let heights: Vec<f64> = along.iter().map(|x| x - at).collect();
                let [below, above] = self.sides(&heights);
                let (Some(below), Some(above)) =
                    (trial_hull_volume(&below), trial_hull_volume(&above))
                else {
                    continue;
                };
                let sum = below + above;
                if best.as_ref().is_none_or(|b| sum < b.0) {
                    best = Some((sum, heights));
                }
            }
        }
        let limit = self.hull_volume - MIN_IMPROVEMENT * self.excess();
        Ok(best.filter(|b| b.0 < limit).map(|b| b.1))
    }

    /// The parts below and above a plane.
    fn cut(&self, heights: &[f64]) -> Option<[Part; 2]> {
        let mut sides = [Side::default(), Side::default()];
        let mut pivot = None;
        for &triangle in &self.triangles {
            let t = triangle.map(|i| i as usize);
            let up = t.map(|i| heights[i] >= 0.0);
            let count = up.iter().filter(|u| **u).count();
            if count == 0 || count == 3 {
                sides[usize::from(up[0])].add(t.map(|i| self.points[i]));
                continue;
            }
            // One corner is alone on its side.
            let alone = (0..3).find(|&k| up[k] == (count == 1)).unwrap_or(0);
            let [l, m, n] = [t[alone], t[(alone + 1) % 3], t[(alone + 2) % 3]];
            let p = crossing(&self.points, heights, l, m);
            let q = crossing(&self.points, heights, l, n);
            let pivot = *pivot.get_or_insert(p);
            let [l, m, n] = [l, m, n].map(|i| self.points[i]);
            let own = usize::from(up[alone]);
            sides[own].add([l, p, q]);
            sides[own].add([q, p, pivot]);
            sides[1 - own].add([p, m, n]);
            sides[1 - own].add([p, n, q]);
            sides[1 - own].add([p, q, pivot]);
        }
        let [below, above] = sides;
        Some([below.into_part()?, above.into_part()?])
    }
}

/// Triangles of one side of a plane.
#[derive(Default)]
struct Side {
    corners: Vec<DVec3>,
}

impl Side {
    fn add(&mut self, corners: [DVec3; 3]) {
        // A triangle without area adds nothing to a chain.
        if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
            self.corners.extend(corners);
        }
    }

    fn into_part(self) -> Option<Part> {
        let corners = 0..self.corners.len() as u32;
        let mesh = Mesh {
            triangles: corners.collect::<Vec<_>>().as_chunks::<3>().0.to_vec(),
            positions: self.corners,
            ..Mesh::default()
        };
        let (points, triangles) = weld(&mesh);
        Part::new(points, triangles)
    }
}

/// The point where the plane cuts the edge between two points on different sides: the same bits in either direction.
fn crossing(points: &[DVec3], heights: &[f64], i: usize, j: usize) -> DVec3 {
    let (i, j) = if heights[i] >= 0.0 { (i, j) } else { (j, i) };
    points[i].lerp(points[j], heights[i] / (heights[i] - heights[j]))
}

/// The volume of a hull of the points with few vertices.
fn trial_hull_volume(points: &[DVec3]) -> Option<f64> {
    let limits = HullLimits {
        vertices: TRIAL_VERTICES,
        tolerance: 0.0,
    };
    Some(convex_hull(points, &limits)?.volume())
}

/// Merges vertices at equal positions. Returns the points and the triangles between them.
fn weld(mesh: &Mesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (numbers, count) = mesh.points();
    let mut points = vec![DVec3::ZERO; count];
    for (&number, &p) in numbers.iter().zip(&mesh.positions) {
        points[number as usize] = p;
    }
    let on = |t: &[u32; 3]| t.map(|i| numbers[i as usize]);
    (points, mesh.triangles.iter().map(on).collect())
}

/// Decomposes `mesh` into convex shapes. If the mesh does not bound a solid, the shapes still cover its vertices, but there
/// may be more of them; a mesh without vertices, in one plane, or with indices or coordinates out of range gives none.
///
/// # Errors
/// [`Cancelled`] where the caller asked to stop.
pub fn convex_parts(
    mesh: &Mesh,
    options: &ConvexOptions,
    context: &Context,
) -> Result<ConvexParts, Cancelled> {
    let vertices = mesh.positions.len();
    let in_range = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < vertices);
    if !mesh.triangles.iter().all(in_range) || mesh.positions.iter().any(|p| !p.is_finite()) {
        return Ok(ConvexParts::default());
    }
    let (points, triangles) = weld(mesh);
    let all = points.clone();
    let Some(whole) = Part::new(points, triangles) else {
        return Ok(ConvexParts::default());
    };
    let solid = whole.volume;
    let mut parts = vec![whole];
    while parts.len() < options.shapes {
        let excess: f64 = parts.iter().map(Part::excess).sum();
        if excess <= options.excess * solid {
            break;
        }
        let open = (0..parts.len()).filter(|&k| !parts[k].is_final);
        let Some(worst) = open.max_by(|&a, &b| {
            let (x, y) = (parts[a].excess(), parts[b].excess());
            x.total_cmp(&y).then(b.cmp(&a))
        }) else {
            break;
        };
        let cut = parts[worst].best_cut(context)?;
        match cut.and_then(|heights| parts[worst].cut(&heights)) {
            Some([below, above]) => {
                parts[worst] = below;
                parts.push(above);
            }
            None => parts[worst].is_final = true,
        }
    }
    let mut shapes = Vec::new();
    for part in &parts {
        context.check()?;
        let single: Vec<DVec3> = part.points.iter().map(|p| p.as_vec3().as_dvec3()).collect();
        let size = crate::Aabb::around(&single).half_size().length();
        let limits = HullLimits {
            vertices: options.vertices,
            tolerance: RELATIVE_TOLERANCE * size,
        };
        shapes.extend(convex_hull(&single, &limits));
    }
    let uncovered = all.iter().map(|&p| distance_outside(&shapes, p));
    let sum: f64 = shapes.iter().map(Mesh::volume).sum();
    Ok(ConvexParts {
        uncovered: uncovered.fold(0.0, f64::max),
        volume_ratio: if solid > 0.0 {
            sum / solid
        } else {
            f64::INFINITY
        },
        shapes,
    })
}

/// The distance of a point from the nearest shape, 0 inside one.
fn distance_outside(shapes: &[Mesh], p: DVec3) -> f64 {
    let mut least = f64::INFINITY;
    for shape in shapes {
        let Some((low, high)) = shape.bounds() else {
            continue;
        };
        if p.clamp(low, high).distance(p) >= least {
            continue;
        }
        let mut inside = true;
        let mut nearest = f64::INFINITY;
        for t in 0..shape.triangles.len() {
            let [a, b, c] = shape.corners(t);
            if (b - a).cross(c - a).dot(p - a) > 0.0 {
                inside = false;
                let on = closest_point_on_triangle(p, [a, b, c]);
                nearest = nearest.min(on.distance(p));
            }
        }
        if inside {
            return 0.0;
        }
        least = least.min(nearest);
    }
    least
}

#[cfg(test)]
mod tests {
    use super::super::hull::is_convex;
    use super::*;

    fn parts(mesh: &Mesh, shapes: usize, vertices: usize) -> ConvexParts {
        let options = ConvexOptions {
            shapes,
            vertices,
            excess: 0.01,
        };
        convex_parts(mesh, &options, &Context::quiet()).unwrap()
    }

    /// Asserts that every vertex of the mesh lies behind all planes of one shape, or no farther outside than reported.
    fn assert_covers(found: &ConvexParts, mesh: &Mesh) {
        assert!(found.shapes.iter().all(is_convex));
        let behind = |shape: &Mesh, p: DVec3| {
            let planes = (0..shape.triangles.len()).map(|t| {
                let [a, b, c] = shape.corners(t);
                (b - a).cross(c - a).normalize().dot(p - a)
            });
            planes.fold(f64::NEG_INFINITY, f64::max)
        };
        for &p in &mesh.positions {
            let nearest = found.shapes.iter().map(|s| behind(s, p));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!(
                nearest <= found.uncovered + 1e-12,
                "{nearest} {}",
                found.uncovered
            );
        }
    }

    /// The boundary of the union of unit cubes, as a closed mesh.
    fn cubes(cubes: &[[i32; 3]]) -> Mesh {
        let mut mesh = Mesh::default();
        for cube in cubes {
            for axis in 0..3 {
                for side in [0, 1] {
                    let mut beyond = *cube;
                    beyond[axis] += 2 * side - 1;
                    if cubes.contains(&beyond) {
                        continue;
                    }
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let corner = |du: i32, dv: i32| {
                        let mut at = *cube;
                        at[axis] += side;
                        at[u] += du;
                        at[v] += dv;
                        DVec3::from_array(at.map(f64::from))
                    };
                    let first = mesh.positions.len() as u32;
                    let mut ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    if side == 0 {
                        ring.reverse();
                    }
                    mesh.positions.extend(ring);
                    mesh.triangles.push([first, first + 1, first + 2]);
                    mesh.triangles.push([first, first + 2, first + 3]);
                }
            }
        }
        mesh
    }

    #[test]
    fn a_hammer_is_decomposed_into_head_and_handle() {
        let head = (0..5).map(|x| [x, 3, 0]);
        let handle = (0..3).map(|y| [2, y, 0]);
        let mesh = cubes(&head.chain(handle).collect::<Vec<_>>());
        assert!((mesh.volume() - 8.0).abs() < 1e-12);
        let found = parts(&mesh, 16, 32);
        assert_covers(&found, &mesh);
        assert_eq!(found.shapes.len(), 2);
        assert!((found.volume_ratio - 1.0).abs() < 1e-6);
        assert!(found.uncovered < 1e-6);
        // One shape is the hull: a trapezoid of depth 1 with sides 5 and 1, and the head's height.
        let found = parts(&mesh, 1, 32);
        assert_eq!(found.shapes.len(), 1);
        let hull = 5.0 + 3.0 * (5.0 + 1.0) / 2.0;
        assert!((found.volume_ratio - hull / 8.0).abs() < 1e-6);
    }

    /// A tube along an arc of 270° with closed ends.
    fn arc() -> Mesh {
        let (rings, around) = (121usize, 24usize);
        let mut mesh = Mesh::default();
        for i in 0..rings {
            let turn = 1.5 * std::f64::consts::PI * i as f64 / (rings - 1) as f64;
            let out = DVec3::new(f64::cos(turn), f64::sin(turn), 0.0);
            for k in 0..around {
                let angle = std::f64::consts::TAU * k as f64 / around as f64;
                let at = out * (1.0 + 0.15 * f64::cos(angle)) + DVec3::Z * (0.15 * f64::sin(angle));
                mesh.positions.push(at);
            }
        }
        let at = |i: usize, k: usize| (i * around + k % around) as u32;
        for i in 0..rings - 1 {
            for k in 0..around {
                mesh.triangles
                    .push([at(i, k), at(i + 1, k), at(i + 1, k + 1)]);
                mesh.triangles
                    .push([at(i, k), at(i + 1, k + 1), at(i, k + 1)]);
            }
        }
        for k in 1..around - 1 {
            mesh.triangles.push([at(0, 0), at(0, k), at(0, k + 1)]);
            mesh.triangles
                .push([at(rings - 1, 0), at(rings - 1, k + 1), at(rings - 1, k)]);
        }
        if mesh.volume() < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        mesh
    }

    #[test]
    fn more_shapes_cover_an_arc_more_closely() {
        let mesh = arc();
        assert!(mesh.check().is_solid());
        let mut last = f64::INFINITY;
        for shapes in [1, 4, 16] {
            let found = parts(&mesh, shapes, 64);
            assert_covers(&found, &mesh);
            assert!(found.shapes.len() <= shapes);
            assert!(found.shapes.iter().all(|s| s.positions.len() <= 64));
            // A fifth of the tube.
            assert!(found.uncovered < 0.03, "{}", found.uncovered);
            assert!(found.volume_ratio < last, "{}", found.volume_ratio);
            last = found.volume_ratio;
        }
        assert!(last < 1.12, "{last}");
    }

    #[test]
    fn meshes_without_a_solid_give_no_shapes() {
        let mut mesh = arc();
        mesh.positions[5].x = f64::INFINITY;
        assert_eq!(parts(&mesh, 8, 32), ConvexParts::default());
        let mut mesh = arc();
        mesh.triangles[5][1] = 1 << 30;
        assert_eq!(parts(&mesh, 8, 32), ConvexParts::default());
        assert_eq!(parts(&Mesh::default(), 8, 32), ConvexParts::default());
    }
}
