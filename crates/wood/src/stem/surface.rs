//! One shell prepared for many questions: sections by a plane, the nearest triangle, what lies inside.
//!
//! Triangles are sorted into the cells of a grid, each with the bounding box of its triangles, so that a plane or a
//! ray looks at a small part of a large mesh.

use super::shells::{Points, Shell};
use glam::DVec3;

/// Triangles per cell that the grid aims at.
const PER_CELL: f64 = 24.0;

struct Cell {
    middle: DVec3,
    half: DVec3,
    start: usize,
    end: usize,
}

/// A shell's triangles, sorted by place.
pub(crate) struct Surface<'a> {
    positions: &'a [DVec3],
    /// Corners as points; triangles with two equal corners are left out.
    triangles: Vec<[u32; 3]>,
    /// Number of each in its mesh.
    numbers: Vec<u32>,
    cells: Vec<Cell>,
}

/// A connected line in which a plane cuts a shell.
#[derive(Debug, Clone)]
pub(crate) struct Loop {
    pub points: Vec<DVec3>,
    /// Numbers of the triangles crossed, in the mesh.
    pub triangles: Vec<u32>,
    pub closed: bool,
}

impl<'a> Surface<'a> {
    pub fn new(points: &'a Points, shell: &Shell) -> Self {
        let size = shell.high - shell.low;
        let longest = size.max_element().max(f64::MIN_POSITIVE);
        // Cells are cubes. A surface fills about the square of the cells along it, not the cube.
        let along = (shell.triangles.len() as f64 / PER_CELL)
            .sqrt()
            .clamp(1.0, 90.0);
        let width = longest / along;
        let count = (size / width).floor().as_uvec3() + 1;
        let total = (count.x * count.y * count.z) as usize;
        let cell_of = |t: &[u32; 3]| {
            let middle = t
                .iter()
                .map(|&c| points.positions[c as usize])
                .sum::<DVec3>()
                / 3.0;
            let c = ((middle - shell.low) / width)
                .floor()
                .as_uvec3()
                .min(count - 1);
            ((c.z * count.y + c.y) * count.x + c.x) as usize
        };
        let kept: Vec<u32> = shell
            .triangles
            .iter()
            .copied()
            .filter(|&i| {
                let t = points.triangles[i as usize];
                t[0] != t[1] && t[1] != t[2] && t[2] != t[0]
            })
            .collect();
        let keys: Vec<u32> = kept
            .iter()
            .map(|&i| cell_of(&points.triangles[i as usize]) as u32)
            .collect();
        let mut starts = vec![0usize; total + 1];
        for &k in &keys {
            starts[k as usize + 1] += 1;
        }
        for k in 0..total {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let mut numbers = vec![0; kept.len()];
        for (&i, &k) in kept.iter().zip(&keys) {
            numbers[next[k as usize]] = i;
            next[k as usize] += 1;
        }
        let triangles: Vec<[u32; 3]> = numbers
            .iter()
            .map(|&i| points.triangles[i as usize])
            .collect();
        let mut cells = Vec::new();
        for k in 0..total {
            let (start, end) = (starts[k], starts[k + 1]);
            if start == end {
                continue;
            }
            let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for &c in triangles[start..end].iter().flatten() {
                low = low.min(points.positions[c as usize]);
                high = high.max(points.positions[c as usize]);
            }
            cells.push(Cell {
                middle: (low + high) * 0.5,
                half: (high - low) * 0.5,
                start,
                end,
            });
        }
        Surface {
            positions: &points.positions,
            triangles,
            numbers,
            cells,
        }
    }

    /// Corners of triangle `i`.
    pub fn corners(&self, i: usize) -> [DVec3; 3] {
        self.triangles[i].map(|c| self.positions[c as usize])
    }

    /// Shortest side of the bounding box, m.
    pub fn shortest_side(&self) -> f64 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for cell in &self.cells {
            low = low.min(cell.middle - cell.half);
            high = high.max(cell.middle + cell.half);
        }
        (high - low).min_element()
    }

    /// How many triangles there are.
    pub fn count(&self) -> usize {
        self.triangles.len()
    }

    /// Runs of triangles (indices for [`Surface::corners`]) with the bounding box of each: middle and half size.
    pub fn cells(&self) -> impl Iterator<Item = (DVec3, DVec3, std::ops::Range<usize>)> {
        self.cells
            .iter()
            .map(|c| (c.middle, c.half, c.start..c.end))
    }

    /// Points of triangle `i`.
    pub fn points_of(&self, i: usize) -> [u32; 3] {
        self.triangles[i]
    }

    /// Number of triangle `i` in its mesh.
    pub fn number(&self, i: usize) -> u32 {
        self.numbers[i]
    }

    /// The lines in which the plane through `origin` cuts the shell.
    pub fn slice(&self, origin: DVec3, normal: DVec3) -> Vec<Loop> {
        let reach = normal.abs();
        let mut segments: Vec<([(u64, DVec3); 2], u32)> = Vec::new();
        for cell in &self.cells {
            if (cell.middle - origin).dot(normal).abs() > cell.half.dot(reach) * (1.0 + 1e-12) {
                continue;
            }
            for i in cell.start..cell.end {
                let t = self.triangles[i];
                let height = t.map(|c| (self.positions[c as usize] - origin).dot(normal));
                let above = height.map(|h| h > 0.0);
                if above[0] == above[1] && above[1] == above[2] {
                    continue;
                }
                let lone = (0..3)
                    .find(|&k| above[k] != above[(k + 1) % 3] && above[k] != above[(k + 2) % 3]);
                let Some(k) = lone else { continue };
                let ends = [(k + 1) % 3, (k + 2) % 3].map(|m| {
                    // From the smaller point to the larger: both triangles of an edge get the same bits.
                    let (a, b) = if t[k] < t[m] { (k, m) } else { (m, k) };
                    let (p, q) = (self.positions[t[a] as usize], self.positions[t[b] as usize]);
                    let at = p + (q - p) * (height[a] / (height[a] - height[b]));
                    ((u64::from(t[a]) << 32) | u64::from(t[b]), at)
                });
                segments.push((ends, self.numbers[i]));
            }
        }
        chain(&segments)
    }

    /// The nearest triangle (its number in the mesh) and the point on it.
    pub fn nearest(&self, p: DVec3) -> Option<(u32, DVec3)> {
        let mut order: Vec<(f64, usize)> = self
            .cells
            .iter()
            .enumerate()
            .map(|(k, c)| {
                (
                    ((p - c.middle).abs() - c.half)
                        .max(DVec3::ZERO)
                        .length_squared(),
                    k,
                )
            })
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(f64, u32, DVec3)> = None;
        for (bound, k) in order {
            if best.is_some_and(|b| bound > b.0) {
                break;
            }
            for i in self.cells[k].start..self.cells[k].end {
                let at = nearest_on_triangle(self.corners(i), p);
                let d = at.distance_squared(p);
                let number = self.numbers[i];
                if best.is_none_or(|b| d < b.0 || (d == b.0 && number < b.1)) {
                    best = Some((d, number, at));
                }
            }
        }
        best.map(|(_, number, at)| (number, at))
    }

    /// Whether `p` lies inside: the majority of seven rays crosses the surface an odd number of times. Rays that
    /// leave through an open end are outvoted.
    pub fn holds(&self, p: DVec3) -> bool {
        // Directions without symmetry to the axes, so that no ray runs along a wall of a modelled object.
        const RAYS: [[f64; 3]; 7] = [
            [0.8134, 0.3071, 0.4937],
            [-0.7219, 0.5417, 0.4302],
            [0.2413, -0.8871, 0.3931],
            [-0.3377, -0.4719, -0.8145],
            [0.6133, 0.6421, -0.4601],
            [-0.5519, 0.1237, -0.8247],
            [0.1171, 0.2713, 0.9553],
        ];
        let votes = RAYS
            .iter()
            .filter(|r| self.crossings(p, DVec3::from_array(**r)) % 2 == 1);
        votes.count() >= 4
    }

    fn crossings(&self, p: DVec3, d: DVec3) -> usize {
        let mut count = 0;
        for cell in &self.cells {
            let (low, high) = (cell.middle - cell.half - p, cell.middle + cell.half - p);
            let (a, b) = (low / d, high / d);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            if enter > leave * (1.0 + 1e-12) || leave < 0.0 {
                continue;
            }
            for i in cell.start..cell.end {
                let [a, b, c] = self.corners(i);
                let (u, v) = (b - a, c - a);
                let h = d.cross(v);
                let det = u.dot(h);
                if det == 0.0 {
                    continue;
                }
                let from = p - a;
                let (s, q) = (from.dot(h) / det, from.cross(u));
                let t = d.dot(q) / det;
                if s >= 0.0 && t >= 0.0 && s + t <= 1.0 && v.dot(q) / det > 0.0 {
                    count += 1;
                }
            }
        }
        count
    }
}

/// Joins segments at equal edges into lines.
fn chain(segments: &[([(u64, DVec3); 2], u32)]) -> Vec<Loop> {
    let mut ends: Vec<(u64, u32)> = Vec::with_capacity(segments.len() * 2);
    for (i, (pair, _)) in segments.iter().enumerate() {
        ends.push((pair[0].0, 2 * i as u32));
        ends.push((pair[1].0, 2 * i as u32 + 1));
    }
    ends.sort_unstable();
    // Ends at one edge are joined two by two; one that is left over is a border of the surface.
    let mut partner = vec![u32::MAX; ends.len()];
    let mut i = 0;
    while i + 1 < ends.len() {
        if ends[i].0 == ends[i + 1].0 {
            partner[ends[i].1 as usize] = ends[i + 1].1;
            partner[ends[i + 1].1 as usize] = ends[i].1;
            i += 2;
        } else {
            i += 1;
        }
    }
    let mut used = vec![false; segments.len()];
    let mut loops = Vec::new();
    let mut follow = |start: usize, used: &mut Vec<bool>| {
        let mut line = Loop {
            points: Vec::new(),
            triangles: Vec::new(),
            closed: false,
        };
        let mut end = start;
        loop {
            let (segment, side) = (end / 2, end % 2);
            used[segment] = true;
            line.points.push(segments[segment].0[side].1);
            line.triangles.push(segments[segment].1);
            let next = partner[end ^ 1];
            if next == u32::MAX {
                line.points.push(segments[segment].0[1 - side].1);
                break;
            }
            end = next as usize;
            if used[end / 2] {
                line.closed = end == start;
                break;
            }
        }
        loops.push(line);
    };
    for (end, &other) in partner.iter().enumerate() {
        if other == u32::MAX && !used[end / 2] {
            follow(end, &mut used);
        }
    }
    for segment in 0..segments.len() {
        if !used[segment] {
            follow(2 * segment, &mut used);
        }
    }
    loops
}

/// The point of a triangle nearest to `p` (Ericson 2005, §5.1.5).
pub(crate) fn nearest_on_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    if sum == 0.0 {
        return a;
    }
    a + ab * (vb / sum) + ac * (vc / sum)
}
