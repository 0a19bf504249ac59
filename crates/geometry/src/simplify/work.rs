//! Edges that collapse, one after another.

use super::quadric::Quadric;
use crate::intersect::collinear;
use crate::{Cancelled, Context, Mesh};
use glam::DVec3;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Triangles may not turn by more than the angle with this cosine when an edge collapses.
const LEAST_COSINE: f64 = 0.2;
/// Planes along seams and across the surface, which hold seams in place, weigh as the square of the edge times this.
const SEAM_WEIGHT: f64 = 1.0;
/// Steps between two looks at whether to stop.
const STEPS: usize = 4096;
/// The volume of a closed mesh changes by no more than this share, whatever goes.
const VOLUME_KEPT: f64 = 0.01;
const GONE: u32 = u32::MAX;

/// A collapse of point `from` onto point `to` that was looked at when both had these ages.
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

/// A mesh while edges collapse.
pub struct Work<'a> {
    mesh: &'a Mesh,
    /// Point of each vertex.
    point: Vec<u32>,
    /// The first vertex at the same point that shows the same, but for small differences.
    class: Vec<u32>,
    /// Places of the points in each pose about the middle of the first.
    poses: Vec<Vec<DVec3>>,
    /// Corners of the triangles, vertices; the first is [`GONE`] where the triangle is.
    corners: Vec<[u32; 3]>,
    /// Triangles at each point; some of them may be gone.
    at: Vec<Vec<u32>>,
    /// One for each pose and point.
    quadrics: Vec<Vec<Quadric>>,
    ages: Vec<u32>,
    left: usize,
    /// Six times the volume that has come or gone, and the most that may.
    change: f64,
    most_change: f64,
}

impl<'a> Work<'a> {
    pub fn new(mesh: &'a Mesh, poses: &[Vec<DVec3>]) -> Self {
        let (point, count) = mesh.points();
        let middle = mesh.bounds().map_or(DVec3::ZERO, |(a, b)| 0.5 * (a + b));
        let placed = |pose: &Vec<DVec3>| {
            let mut places = vec![DVec3::ZERO; count];
            for (&n, &p) in point.iter().zip(pose) {
                places[n as usize] = p - middle;
            }
            places
        };
        let poses: Vec<Vec<DVec3>> = std::iter::once(&mesh.positions)
            .chain(poses)
            .map(placed)
            .collect();
        let mut at = vec![Vec::new(); count];
        let mut corners = mesh.triangles.clone();
        for (t, triangle) in corners.iter_mut().enumerate() {
            let [a, b, c] = triangle.map(|v| point[v as usize]);
            if a == b || b == c || c == a {
                triangle[0] = GONE;
                continue;
            }
            for p in [a, b, c] {
                at[p as usize].push(t as u32);
            }
        }
        let mut work = Work {
            mesh,
            left: corners.iter().filter(|c| c[0] != GONE).count(),
            quadrics: vec![vec![Quadric::NONE; count]; poses.len()],
            change: 0.0,
            most_change: most_change(mesh),
            class: classes(mesh, &point, count),
            ages: vec![0; count],
            point,
            poses,
            corners,
            at,
        };
        for pose in 0..work.poses.len() {
            work.add_planes(pose);
        }
        work
    }

    /// What is left: corners, and the triangle that they were.
    pub fn triangles(&self) -> Vec<([u32; 3], u32)> {
        let all = self.corners.iter().zip(0..);
        all.filter(|(c, _)| c[0] != GONE)
            .map(|(c, t)| (*c, t))
            .collect()
    }

    fn points_of(&self, triangle: u32) -> [u32; 3] {
        self.corners[triangle as usize].map(|v| self.point[v as usize])
    }

    fn live(&self, point: u32) -> impl Iterator<Item = u32> + '_ {
        let at = self.at[point as usize].iter().copied();
        at.filter(|&t| self.corners[t as usize][0] != GONE)
    }

    fn add_planes(&mut self, pose: usize) {
        for t in 0..self.corners.len() as u32 {
            if self.corners[t as usize][0] == GONE {
                continue;
            }
            let points = self.points_of(t);
            let places = points.map(|p| self.poses[pose][p as usize]);
            let cross = (places[1] - places[0]).cross(places[2] - places[0]);
            let normal = cross.normalize_or_zero();
            let plane = Quadric::of_plane(normal, places[0], 0.5 * cross.length());
            for p in points {
                self.quadrics[pose][p as usize] += plane;
            }
            for k in 0..3 {
                let l = (k + 1) % 3;
                if self.is_inside(t, k) {
                    continue;
                }
                let edge = places[l] - places[k];
                let across = edge.cross(normal).normalize_or_zero();
                let weight = SEAM_WEIGHT * edge.length_squared();
                let plane = Quadric::of_plane(across, places[k], weight);
                self.quadrics[pose][points[k] as usize] += plane;
                self.quadrics[pose][points[l] as usize] += plane;
            }
        }
    }

    /// Whether the edge from corner `k` of a triangle has one other triangle with the same corners and material.
    fn is_inside(&self, t: u32, k: usize) -> bool {
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

    fn candidate(&self, from: u32, to: u32) -> Candidate {
        let cost = (self.quadrics.iter().zip(&self.poses)).map(|(quadrics, places)| {
            let mut both = quadrics[from as usize];
            both += quadrics[to as usize];
            both.at(places[to as usize])
        });
        Candidate {
            cost: cost.sum(),
            from,
            to,
            ages: [from, to].map(|p| self.ages[p as usize]),
        }
    }

    /// Collapses edges until `target` triangles are left or nothing more can go.
    pub fn run(&mut self, target: usize, context: &Context) -> Result<(), Cancelled> {
        let first = self.left;
        loop {
            let before = self.left;
            let mut heap = BinaryHeap::new();
            for t in 0..self.corners.len() as u32 {
                if self.corners[t as usize][0] != GONE {
                    let [a, b, c] = self.points_of(t);
                    for (p, q) in [(a, b), (b, c), (c, a)] {
                        heap.push(Reverse(self.candidate(p, q)));
                        heap.push(Reverse(self.candidate(q, p)));
                    }
                }
            }
            let mut steps = 0usize;
            while self.left > target {
                if steps.is_multiple_of(STEPS) {
                    let done = (first - self.left) as f64 / (first - target) as f64;
                    context.report(done)?;
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
            // What could not go may go now that others have gone; a few at a time are not worth another round.
            if self.left <= target || before - self.left < 1 + first / 1000 {
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

    /// The two points across from `point` in a triangle at it, in the triangle's sense.
    fn across(&self, triangle: u32, point: u32) -> (u32, u32) {
        let [a, b, c] = self.points_of(triangle);
        match point {
            _ if point == a => (b, c),
            _ if point == b => (c, a),
            _ => (a, b),
        }
    }

    /// Whether the triangles at a point are one fan all around it.
    fn is_disc(&self, triangles: &[u32], point: u32) -> bool {
        let edges: Vec<(u32, u32)> = triangles.iter().map(|&t| self.across(t, point)).collect();
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

    /// Collapses point `from` onto `to` where that may be.
    fn collapse(&mut self, from: u32, to: u32) -> bool {
        let fan: Vec<u32> = self.live(from).collect();
        if !self.is_disc(&fan, from) {
            return false;
        }
        let (dying, staying): (Vec<u32>, Vec<u32>) =
            (fan.iter()).partition(|&&t| self.points_of(t).contains(&to));
        if dying.len() != 2 || !self.stays_surface(&staying, from, to) {
            return false;
        }
        let Some(moved) = self.new_corners(&dying, &staying, from, to) else {
            return false;
        };
        if !(staying.iter()).all(|&t| self.may_turn(t, from, to)) {
            return false;
        }
        let change = self.change + self.volume_change(&fan, from, to);
        if change.abs() > self.most_change && change.abs() > self.change.abs() {
            return false;
        }
        self.change = change;
        for &t in &dying {
            self.corners[t as usize][0] = GONE;
        }
        self.left -= dying.len();
        for (&t, corners) in staying.iter().zip(moved) {
            self.corners[t as usize] = corners;
        }
        let mut at: Vec<u32> = self.live(to).collect();
        at.extend(&staying);
        self.at[to as usize] = at;
        self.at[from as usize] = Vec::new();
        for quadrics in &mut self.quadrics {
            let gone = quadrics[from as usize];
            quadrics[to as usize] += gone;
        }
        self.ages[from as usize] += 1;
        self.ages[to as usize] += 1;
        true
    }

    /// The link condition: the two ends have no neighbours in common but those across from the edge, and no triangle
    /// comes to lie on another.
    fn stays_surface(&self, staying: &[u32], from: u32, to: u32) -> bool {
        let near = self.neighbours(to);
        let own = self.neighbours(from);
        let common = own.iter().filter(|p| near.binary_search(p).is_ok());
        let others: Vec<(u32, u32)> = self.live(to).map(|t| self.across(t, to)).collect();
        common.count() == 2
            && staying.iter().all(|&t| {
                let (x, y) = self.across(t, from);
                !others.contains(&(x, y)) && !others.contains(&(y, x))
            })
    }

    /// The corners of the triangles that stay, `from` taken to `to` on the same side of seams and in the same material;
    /// none where there is no such corner.
    fn new_corners(
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
        let mut pairs: Vec<(u32, u32, u32)> = Vec::with_capacity(2);
        for &t in dying {
            let (start, end) = (corner(t, from)?, corner(t, to)?);
            let material = self.mesh.material(t as usize);
            let differs = |p: &(u32, u32, u32)| {
                (class(p.0), p.1) == (class(start), material) && class(p.2) != class(end)
            };
            if pairs.iter().any(differs) {
                return None;
            }
            pairs.push((start, material, end));
        }
        let moved = staying.iter().map(|&t| {
            let start = corner(t, from)?;
            let material = self.mesh.material(t as usize);
            let alike = |p: &&(u32, u32, u32)| (class(p.0), p.1) == (class(start), material);
            let same = pairs.iter().filter(alike).find(|p| p.0 == start);
            let end = same.or_else(|| pairs.iter().find(alike))?.2;
            let corners = self.corners[t as usize];
            Some(corners.map(|v| if v == start { end } else { v }))
        });
        moved.collect()
    }

    /// Six times the volume at rest that comes when the middle of a fan goes to `to`.
    fn volume_change(&self, fan: &[u32], from: u32, to: u32) -> f64 {
        let places = &self.poses[0];
        let (p, q) = (places[from as usize], places[to as usize]);
        let of = |&t: &u32| {
            let (x, y) = self.across(t, from);
            let (x, y) = (places[x as usize] - p, places[y as usize] - p);
            (q - p).dot(x.cross(y))
        };
        fan.iter().map(of).sum()
    }

    /// Whether a triangle keeps its side in all poses, and an area, when its corner goes from `from` to `to`.
    fn may_turn(&self, t: u32, from: u32, to: u32) -> bool {
        let (x, y) = self.across(t, from);
        self.poses.iter().enumerate().all(|(pose, places)| {
            let [p, q, x, y] = [from, to, x, y].map(|i| places[i as usize]);
            if pose == 0 && collinear(q, x, y) {
                return false;
            }
            let (old, new) = ((x - p).cross(y - p), (x - q).cross(y - q));
            old == DVec3::ZERO || old.dot(new) > LEAST_COSINE * old.length() * new.length()
        })
    }
}

/// Six times the volume by which a mesh may change: without end where it is open and has none.
fn most_change(mesh: &Mesh) -> f64 {
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let cross = (b - a).cross(c - a);
        sum += cross;
        area += cross.length();
    }
    // The areas of a closed surface add up to nothing.
    if sum.length() <= 1e-9 * area {
        6.0 * VOLUME_KEPT * mesh.volume().abs()
    } else {
        f64::INFINITY
    }
}

/// Normals that enclose an angle with a smaller cosine are those of two faces.
const SMOOTH: f32 = 0.7;
/// What else differs by less, such as places in a texture or shares of colours, looks the same.
const ALIKE: f32 = 1e-3;

/// For each vertex the first one at its point that has about the same attributes.
fn classes(mesh: &Mesh, point: &[u32], count: usize) -> Vec<u32> {
    let alike = |a: u32, b: u32| {
        mesh.attributes.iter().all(|(name, attribute)| {
            let (x, y) = (attribute.at(a as usize), attribute.at(b as usize));
            match name.as_str() {
                // What it is made of is compared.
                "TANGENT" => true,
                "NORMAL" => x.iter().zip(y).map(|(x, y)| x * y).sum::<f32>() >= SMOOTH,
                _ => x.iter().zip(y).all(|(x, y)| (x - y).abs() <= ALIKE),
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
