//! Edge collapses, the cheapest first.

use super::quadric::Quadric;
use crate::intersect::collinear;
use crate::{Cancelled, Context, Mesh};
use glam::DVec3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Smallest cosine of the angle by which a triangle may turn when an edge collapses.
const MIN_NORMAL_COSINE: f64 = 0.2;
/// Weight of the planes through seams perpendicular to the surface, which hold seams in place, relative to the squared
/// length of the edge.
const SEAM_WEIGHT: f64 = 1.0;
/// Steps after which a loop asks whether to stop.
const CHECK_INTERVAL: usize = 4096;
/// Largest change of the volume of a closed mesh, relative to the volume.
const MAX_VOLUME_CHANGE: f64 = 0.01;
/// First corner of a triangle that is removed.
const REMOVED: u32 = u32::MAX;

/// The collapse of point `from` onto point `to`. It is out of date when the points have other ages than these.
#[derive(Clone, Copy, PartialEq)]
struct Candidate {
    cost: f64,
    from: u32,
    to: u32,
    ages: [u32; 2],
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = (self.from, self.to, self.ages);
        let cost = self.cost.total_cmp(&other.cost);
        cost.then(place.cmp(&(other.from, other.to, other.ages)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A triangle that remains.
pub(super) struct RemainingTriangle {
    /// Its vertices.
    pub corners: [u32; 3],
    /// The original triangle.
    pub original: u32,
}

/// A corner of a triangle that collapses, and the corner that takes its place.
struct CollapsedCorner {
    from: u32,
    to: u32,
    material: u32,
}

/// A mesh while edges collapse.
pub(super) struct Collapse<'a> {
    mesh: &'a Mesh,
    /// Point of each vertex.
    point: Vec<u32>,
    /// For each vertex the first at the same point whose attributes are about the same.
    class: Vec<u32>,
    /// Positions of the points in each pose, relative to the middle of the mesh.
    poses: Vec<Vec<DVec3>>,
    /// Vertices at the corners of the triangles; the first is [`REMOVED`] if the triangle is.
    corners: Vec<[u32; 3]>,
    /// Triangles at each point; some of them may be removed.
    triangles_at: Vec<Vec<u32>>,
    /// One for each point in each pose.
    quadrics: Vec<Vec<Quadric>>,
    /// How often each point took part in a collapse.
    ages: Vec<u32>,
    /// Number of triangles that remain.
    remaining: usize,
    /// Six times the change of the volume so far, and the largest that is allowed.
    volume_change: f64,
    max_volume_change: f64,
}

impl<'a> Collapse<'a> {
    /// Prepares the mesh: connectivity and quadrics.
    pub fn new(mesh: &'a Mesh, poses: &[Vec<DVec3>], context: &Context) -> Result<Self, Cancelled> {
        let (point, count) = mesh.points();
        let middle = mesh.bounds().map_or(DVec3::ZERO, |(a, b)| 0.5 * (a + b));
        let at_points = |pose: &Vec<DVec3>| {
            let mut positions = vec![DVec3::ZERO; count];
            for (&n, &p) in point.iter().zip(pose) {
                positions[n as usize] = p - middle;
            }
            positions
        };
        let poses: Vec<Vec<DVec3>> = std::iter::once(&mesh.positions)
            .chain(poses)
            .map(at_points)
            .collect();
        let mut triangles_at = vec![Vec::new(); count];
        let mut corners = mesh.triangles.clone();
        for (t, triangle) in corners.iter_mut().enumerate() {
            let [a, b, c] = triangle.map(|v| point[v as usize]);
            if a == b || b == c || c == a {
                triangle[0] = REMOVED;
                continue;
            }
            for p in [a, b, c] {
                triangles_at[p as usize].push(t as u32);
            }
        }
        let mut collapse = Collapse {
            mesh,
            remaining: corners.iter().filter(|c| c[0] != REMOVED).count(),
            quadrics: vec![vec![Quadric::ZERO; count]; poses.len()],
            volume_change: 0.0,
            max_volume_change: max_volume_change(mesh),
            class: classes(mesh, &point, count),
            ages: vec![0; count],
            point,
            poses,
            corners,
            triangles_at,
        };
        for pose in 0..collapse.poses.len() {
            collapse.add_planes(pose, context)?;
        }
        Ok(collapse)
    }

    /// The triangles that remain.
    pub fn triangles(&self) -> Vec<RemainingTriangle> {
        let all = self.corners.iter().zip(0..);
        all.filter(|(c, _)| c[0] != REMOVED)
            .map(|(&corners, original)| RemainingTriangle { corners, original })
            .collect()
    }

    /// The points at the corners of a triangle.
    fn points_of(&self, triangle: u32) -> [u32; 3] {
        self.corners[triangle as usize].map(|v| self.point[v as usize])
    }

    /// The triangles at a point.
    fn live(&self, point: u32) -> impl Iterator<Item = u32> + '_ {
        let at = self.triangles_at[point as usize].iter().copied();
        at.filter(|&t| self.corners[t as usize][0] != REMOVED)
    }

    /// Adds the planes of the triangles and of seams to the quadrics of a pose.
    fn add_planes(&mut self, pose: usize, context: &Context) -> Result<(), Cancelled> {
        for t in 0..self.corners.len() as u32 {
            if (t as usize).is_multiple_of(CHECK_INTERVAL) {
                context.check()?;
            }
            if self.corners[t as usize][0] == REMOVED {
                continue;
            }
            let points = self.points_of(t);
            let positions = points.map(|p| self.poses[pose][p as usize]);
            let cross = (positions[1] - positions[0]).cross(positions[2] - positions[0]);
            let normal = cross.normalize_or_zero();
            let plane = Quadric::from_plane(normal, positions[0], 0.5 * cross.length());
            for p in points {
                self.quadrics[pose][p as usize] += plane;
            }
            for k in 0..3 {
                let l = (k + 1) % 3;
                if self.is_interior(t, k) {
                    continue;
                }
                let edge = positions[l] - positions[k];
                let perpendicular = edge.cross(normal).normalize_or_zero();
                let weight = SEAM_WEIGHT * edge.length_squared();
                let plane = Quadric::from_plane(perpendicular, positions[k], weight);
                self.quadrics[pose][points[k] as usize] += plane;
                self.quadrics[pose][points[l] as usize] += plane;
            }
        }
        Ok(())
    }

    /// Whether the edge from corner `k` of a triangle is no seam: one other triangle has the same corners there and the
    /// same material.
    fn is_interior(&self, t: u32, k: usize) -> bool {
        let corners = self.corners[t as usize];
        let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|v| self.class[v as usize]);
        let material = self.mesh.material(t as usize);
        let beyond = self.live(self.point[a as usize]).filter(|&o| {
            let c = self.corners[o as usize].map(|v| self.class[v as usize]);
            o != t && c.contains(&a) && c.contains(&b)
        });
        let mut beyond = beyond.map(|o| self.mesh.material(o as usize) == material);
        beyond.next() == Some(true) && beyond.next().is_none()
    }

    /// The collapse of `from` onto `to` with its cost.
    fn candidate(&self, from: u32, to: u32) -> Candidate {
        let cost = (self.quadrics.iter().zip(&self.poses)).map(|(quadrics, positions)| {
            let mut both = quadrics[from as usize];
            both += quadrics[to as usize];
            both.evaluate(positions[to as usize])
        });
        Candidate {
            cost: cost.sum(),
            from,
            to,
            ages: [from, to].map(|p| self.ages[p as usize]),
        }
    }

    /// Collapses edges until `target` triangles remain or no edge can collapse.
    pub fn run(&mut self, target: usize, context: &Context) -> Result<(), Cancelled> {
        let first = self.remaining;
        loop {
            let before = self.remaining;
            let mut heap = BinaryHeap::new();
            for t in 0..self.corners.len() as u32 {
                if self.corners[t as usize][0] != REMOVED {
                    let [a, b, c] = self.points_of(t);
                    for (p, q) in [(a, b), (b, c), (c, a)] {
                        heap.push(Reverse(self.candidate(p, q)));
                        heap.push(Reverse(self.candidate(q, p)));
                    }
                }
            }
            let mut steps = 0usize;
            while self.remaining > target {
                if steps.is_multiple_of(CHECK_INTERVAL) {
                    let fraction = (first - self.remaining) as f64 / (first - target) as f64;
                    context.report(fraction)?;
                }
                steps += 1;
                let Some(Reverse(next)) = heap.pop() else {
                    break;
                };
                let ages = [next.from, next.to].map(|p| self.ages[p as usize]);
                if ages != next.ages || !self.collapse(next.from, next.to) {
                    continue;
                }
                for near in self.neighbours(next.to) {
                    heap.push(Reverse(self.candidate(next.to, near)));
                    heap.push(Reverse(self.candidate(near, next.to)));
                }
            }
            // A collapse that was impossible may be possible now; a handful are not worth another round.
            if self.remaining <= target || before - self.remaining < 1 + first / 1000 {
                return Ok(());
            }
        }
    }

    /// Points that share an edge with `point`, each once.
    fn neighbours(&self, point: u32) -> Vec<u32> {
        let mut near: Vec<u32> = self.live(point).flat_map(|t| self.points_of(t)).collect();
        near.sort_unstable();
        near.dedup();
        near.retain(|&p| p != point);
        near
    }

    /// The two other points of a triangle at `point`, in the order of the triangle.
    fn opposite_edge(&self, triangle: u32, point: u32) -> (u32, u32) {
        let [a, b, c] = self.points_of(triangle);
        match point {
            _ if point == a => (b, c),
            _ if point == b => (c, a),
            _ => (a, b),
        }
    }

    /// Whether the triangles at a point form one closed fan around it.
    fn is_disc(&self, triangles: &[u32], point: u32) -> bool {
        let edges: Vec<(u32, u32)> = triangles
            .iter()
            .map(|&t| self.opposite_edge(t, point))
            .collect();
        let Some(&(start, mut end)) = edges.first() else {
            return false;
        };
        let mut steps = 1;
        while end != start && steps <= edges.len() {
            let mut next = edges.iter().filter(|e| e.0 == end);
            let Some(&(_, after)) = next.next() else {
                return false;
            };
            if next.next().is_some() {
                return false;
            }
            end = after;
            steps += 1;
        }
        end == start && steps == edges.len()
    }

    /// Collapses point `from` onto `to` if that is allowed.
    fn collapse(&mut self, from: u32, to: u32) -> bool {
        let fan: Vec<u32> = self.live(from).collect();
        if !self.is_disc(&fan, from) {
            return false;
        }
        let (dying, staying): (Vec<u32>, Vec<u32>) =
            (fan.iter()).partition(|&&t| self.points_of(t).contains(&to));
        if dying.len() != 2 || !self.stays_manifold(&staying, from, to) {
            return false;
        }
        let Some(moved) = self.replaced_corners(&dying, &staying, from, to) else {
            return false;
        };
        if !(staying.iter()).all(|&t| self.stays_oriented(t, from, to)) {
            return false;
        }
        let change = self.volume_change + self.fan_volume_change(&fan, from, to);
        if change.abs() > self.max_volume_change && change.abs() > self.volume_change.abs() {
            return false;
        }
        self.volume_change = change;
        for &t in &dying {
            self.corners[t as usize][0] = REMOVED;
        }
        self.remaining -= dying.len();
        for (&t, corners) in staying.iter().zip(moved) {
            self.corners[t as usize] = corners;
        }
        let mut at: Vec<u32> = self.live(to).collect();
        at.extend(&staying);
        self.triangles_at[to as usize] = at;
        self.triangles_at[from as usize] = Vec::new();
        for quadrics in &mut self.quadrics {
            let gone = quadrics[from as usize];
            quadrics[to as usize] += gone;
        }
        self.ages[from as usize] += 1;
        self.ages[to as usize] += 1;
        true
    }

    /// The link condition: both ends have only the two points opposite the edge as common neighbours, and no two triangles
    /// come to coincide.
    fn stays_manifold(&self, staying: &[u32], from: u32, to: u32) -> bool {
        let near = self.neighbours(to);
        let own = self.neighbours(from);
        let common = own.iter().filter(|p| near.binary_search(p).is_ok());
        let others: Vec<(u32, u32)> = self.live(to).map(|t| self.opposite_edge(t, to)).collect();
        common.count() == 2
            && staying.iter().all(|&t| {
                let (x, y) = self.opposite_edge(t, from);
                !others.contains(&(x, y)) && !others.contains(&(y, x))
            })
    }

    /// The corners of the triangles that remain, with `from` replaced by `to` on the same side of seams and in the same
    /// material; `None` if there is no such corner.
    fn replaced_corners(
        &self,
        dying: &[u32],
        staying: &[u32],
        from: u32,
        to: u32,
    ) -> Option<Vec<[u32; 3]>> {
        let corner = |t: u32, p: u32| {
            let corners = self.corners[t as usize];
            corners.into_iter().find(|&v| self.point[v as usize] == p)
        };
        let class = |v: u32| self.class[v as usize];
        let mut ends: Vec<CollapsedCorner> = Vec::with_capacity(2);
        for &t in dying {
            let new = CollapsedCorner {
                from: corner(t, from)?,
                material: self.mesh.material(t as usize),
                to: corner(t, to)?,
            };
            let differs = |old: &CollapsedCorner| {
                (class(old.from), old.material) == (class(new.from), new.material)
                    && class(old.to) != class(new.to)
            };
            if ends.iter().any(differs) {
                return None;
            }
            ends.push(new);
        }
        let moved = staying.iter().map(|&t| {
            let start = corner(t, from)?;
            let material = self.mesh.material(t as usize);
            let alike =
                |c: &&CollapsedCorner| (class(c.from), c.material) == (class(start), material);
            let same = ends.iter().filter(alike).find(|c| c.from == start);
            let end = same.or_else(|| ends.iter().find(alike))?.to;
            let corners = self.corners[t as usize];
            Some(corners.map(|v| if v == start { end } else { v }))
        });
        moved.collect()
    }

    /// Six times the change of the volume at rest when the centre of a fan moves to `to`.
    fn fan_volume_change(&self, fan: &[u32], from: u32, to: u32) -> f64 {
        let positions = &self.poses[0];
        let (p, q) = (positions[from as usize], positions[to as usize]);
        let tetrahedron = |&t: &u32| {
            let (x, y) = self.opposite_edge(t, from);
            let (x, y) = (positions[x as usize] - p, positions[y as usize] - p);
            (q - p).dot(x.cross(y))
        };
        fan.iter().map(tetrahedron).sum()
    }

    /// Whether a triangle keeps its orientation in all poses, and an area, when its corner moves from `from` to `to`.
    fn stays_oriented(&self, t: u32, from: u32, to: u32) -> bool {
        let (x, y) = self.opposite_edge(t, from);
        self.poses.iter().enumerate().all(|(pose, positions)| {
            let [p, q, x, y] = [from, to, x, y].map(|i| positions[i as usize]);
            if pose == 0 && collinear(q, x, y) {
                return false;
            }
            let (old, new) = ((x - p).cross(y - p), (x - q).cross(y - q));
            old == DVec3::ZERO || old.dot(new) > MIN_NORMAL_COSINE * old.length() * new.length()
        })
    }
}

/// Six times the largest allowed change of the volume; infinite for an open mesh, which has no volume.
fn max_volume_change(mesh: &Mesh) -> f64 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let cross = (b - a).cross(c - a);
        sum += cross;
        area += cross.length();
    }
    // The area vectors of a closed surface sum to zero.
    if sum.length() <= 1e-9 * area {
        6.0 * MAX_VOLUME_CHANGE * mesh.volume().abs()
    } else {
        f64::INFINITY
    }
}

/// Smallest cosine of the angle between normals that form no seam.
const MIN_SMOOTH_COSINE: f32 = 0.7;
/// Largest difference of other attributes, such as texture coordinates and colours, that forms no seam.
const MAX_SMOOTH_DIFFERENCE: f32 = 1e-3;

/// Finds for each vertex the first at the same point that has about the same attributes.
fn classes(mesh: &Mesh, point: &[u32], count: usize) -> Vec<u32> {
    let alike = |a: u32, b: u32| {
        mesh.attributes.iter().all(|(name, attribute)| {
            let (x, y) = (attribute.at(a as usize), attribute.at(b as usize));
            match name.as_str() {
                // It follows from the attributes that are compared.
                "TANGENT" => true,
                "NORMAL" => x.iter().zip(y).map(|(x, y)| x * y).sum::<f32>() >= MIN_SMOOTH_COSINE,
                _ => x
                    .iter()
                    .zip(y)
                    .all(|(x, y)| (x - y).abs() <= MAX_SMOOTH_DIFFERENCE),
            }
        })
    };
    let mut firsts: Vec<Vec<u32>> = vec![Vec::new(); count];
    let class = point.iter().zip(0..).map(|(&p, v)| {
        let firsts = &mut firsts[p as usize];
        let first = firsts.iter().copied().find(|&f| alike(f, v));
        first.unwrap_or_else(|| {
            firsts.push(v);
            v
        })
    });
    class.collect()
}
