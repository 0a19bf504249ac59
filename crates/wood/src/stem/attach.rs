//! What other shells do to a stem: where they are stuck into it, and which of them move with its upper piece.

use super::build::{Body, Section};
use super::shells::{Points, Shell};
use super::surface::Surface;
use glam::{DVec2, DVec3};
use greenstick_geometry::Unions;
use std::f64::consts::{PI, TAU};

/// Directions in which a section's outline is kept for the test whether a point is inside.
const ANGLES: usize = 64;
/// A shell touches the stem where it comes inside the outline or as near to it, in radii.
const TOUCH: f64 = 0.03;
/// Points of a shell that are looked at to find what it hangs on.
const SAMPLES: usize = 24;
/// A shell that touches nothing hangs on the nearest within this part of its own size.
const NEAR: f64 = 0.1;

/// The stem's tube: for each axis point the outline's radius around the section's centroid.
pub(crate) struct Tube<'a> {
    body: &'a Body,
    rows: Vec<Option<(DVec2, Vec<f64>)>>,
    /// Radius of the circle of equal area at or next to each axis point, m.
    radii: Vec<f64>,
    low: DVec3,
    high: DVec3,
    widest: f64,
}

impl<'a> Tube<'a> {
    pub fn new(body: &'a Body) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut widest: f64 = 0.0;
        let mut rows: Vec<Option<(DVec2, Vec<f64>)>> = Vec::new();
        for (_, section) in &body.stations {
            let Some(section) = section else {
                rows.push(None);
                continue;
            };
            let frame = body.axis.frame(section.length);
            for p in &section.contour {
                let p = frame.origin + frame.x * p.x + frame.y * p.y;
                (low, high) = (low.min(p), high.max(p));
                widest = widest.max(p.distance(frame.origin));
            }
            rows.push(Some((section.centroid, radii(section))));
        }
        let radii = body
            .axis
            .lengths()
            .iter()
            .map(|&s| body.radius(s))
            .collect();
        Tube {
            body,
            rows,
            radii,
            low: low - 0.1 * widest,
            high: high + 0.1 * widest,
            widest,
        }
    }

    /// Axis point next to `p`.
    fn next_to(&self, p: DVec3) -> usize {
        let points = self.body.axis.points();
        let (mut best, mut nearest) = (0, f64::INFINITY);
        let mut look = |i: usize| {
            let d = points[i].distance_squared(p);
            if d < nearest {
                (best, nearest) = (i, d);
            }
            best
        };
        // Neighbouring points are a quarter of a radius apart: every fourth, then those around the best.
        for i in (0..points.len()).step_by(4) {
            look(i);
        }
        let from = look(0);
        for i in from.saturating_sub(4)..(from + 5).min(points.len()) {
            look(i);
        }
        best
    }

    /// Radius (m) of the circle of equal area next to `p`.
    fn radius(&self, p: DVec3) -> f64 {
        self.radii[self.next_to(p)]
    }

    /// Length (m) at which `p` lies, and its distance from the axis over the outline's radius there.
    fn locate(&self, p: DVec3) -> (f64, Option<f64>) {
        let i = self.next_to(p);
        let axis = &self.body.axis;
        let frame = axis.frame(axis.lengths()[i]);
        let d = p - frame.origin;
        let s = axis.lengths()[i] + d.dot(frame.tangent);
        let Some((centroid, radii)) = &self.rows[i] else {
            return (s, None);
        };
        let q = DVec2::new(d.dot(frame.x), d.dot(frame.y)) - *centroid;
        let turn = (libm::atan2(q.y, q.x) + PI) / TAU * ANGLES as f64;
        (s, Some(q.length() / radii[turn as usize % ANGLES]))
    }

    fn meets(&self, [a, b, c]: [DVec3; 3]) -> bool {
        a.min(b).min(c).cmple(self.high).all() && a.max(b).max(c).cmpge(self.low).all()
    }

    /// Points of a triangle close enough together not to step over the stem.
    fn samples([a, b, c]: [DVec3; 3], spacing: f64, mut each: impl FnMut(DVec3)) {
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let n = (longest / spacing).ceil().clamp(1.0, 24.0) as u32;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                each(a + (b - a) * u + (c - a) * v);
            }
        }
    }

    /// Range of lengths (m) over which another shell comes inside the stem.
    pub fn touched_by(&self, points: &Points, shell: &Shell) -> Vec<(f64, f64)> {
        let apart = shell.low.cmpgt(self.high).any() || shell.high.cmplt(self.low).any();
        let mut ranges: Vec<(f64, f64)> = Vec::new();
        if apart {
            return ranges;
        }
        for &t in &shell.triangles {
            let corners = points.triangles[t as usize].map(|c| points.positions[c as usize]);
            if !self.meets(corners) {
                continue;
            }
            let mut range = (f64::INFINITY, f64::NEG_INFINITY);
            let spacing = 0.25 * self.radius(corners[0]);
            Tube::samples(corners, spacing, |p| {
                if let (s, Some(ratio)) = self.locate(p) {
                    let inside = s > -spacing && s < self.body.axis.length() + spacing;
                    if ratio < 1.0 + TOUCH && inside {
                        range = (range.0.min(s), range.1.max(s));
                    }
                }
            });
            if range.0 <= range.1 {
                ranges.push(range);
            }
        }
        merged(ranges, 0.5 * self.widest)
    }

    /// Triangles of the stem's own shell that belong to the limb between two lengths (m): connected with those under
    /// the section, given as `start`, without leaving the limb.
    pub fn limb(&self, surface: &Surface, range: (f64, f64), start: &[u32]) -> Vec<u32> {
        // Wider than the relief of any bark, narrower than the way to another limb.
        const WIDE: f64 = 1.6;
        let mut kept: Vec<usize> = Vec::new();
        for (middle, half, run) in surface.cells() {
            let low = middle - half;
            if low.cmpgt(self.high).any() || (middle + half).cmplt(self.low).any() {
                continue;
            }
            // A small cell is in or out as a whole.
            let size = half.length() / self.radius(middle);
            if let (true, (s, Some(ratio))) = (size < 0.4, self.locate(middle)) {
                let by = 1.5 * half.length();
                if s + by < range.0 || s - by > range.1 {
                    continue;
                }
                if s - by >= range.0 && s + by <= range.1 && ratio + 1.5 * size < WIDE {
                    kept.extend(run);
                    continue;
                }
            }
            for i in run {
                let corners = surface.corners(i);
                if !self.meets(corners) {
                    continue;
                }
                let spacing = 0.3 * self.radius(corners[0]);
                let mut lengths = (f64::INFINITY, f64::NEG_INFINITY);
                let mut inside = false;
                Tube::samples(corners, spacing, |p| {
                    let (s, ratio) = self.locate(p);
                    lengths = (lengths.0.min(s), lengths.1.max(s));
                    inside |= ratio.is_some_and(|r| r < WIDE);
                });
                if inside && lengths.0 <= range.1 && lengths.1 >= range.0 {
                    kept.push(i);
                }
            }
        }
        let largest = kept
            .iter()
            .flat_map(|&i| surface.points_of(i))
            .max()
            .map_or(0, |m| m + 1);
        let mut sets = Unions::new(largest as usize);
        for &i in &kept {
            let [a, b, c] = surface.points_of(i);
            sets.join(a, b);
            sets.join(a, c);
        }
        let mut wanted = start.to_vec();
        wanted.sort_unstable();
        let mut roots: Vec<u32> = kept
            .iter()
            .filter(|&&i| wanted.binary_search(&surface.number(i)).is_ok())
            .map(|&i| sets.root(surface.points_of(i)[0]))
            .collect();
        roots.sort_unstable();
        roots.dedup();
        // Marks instead of sorting: a limb of a scan has a million triangles.
        let last = kept
            .iter()
            .map(|&i| surface.number(i))
            .chain(wanted.iter().copied())
            .max();
        let mut marked = vec![false; last.map_or(0, |n| n as usize + 1)];
        for &i in &kept {
            if roots
                .binary_search(&sets.root(surface.points_of(i)[0]))
                .is_ok()
            {
                marked[surface.number(i) as usize] = true;
            }
        }
        wanted.iter().for_each(|&n| marked[n as usize] = true);
        (0..marked.len() as u32)
            .filter(|&n| marked[n as usize])
            .collect()
    }
}

/// Largest distance of the outline from the centroid in each of [`ANGLES`] sectors.
fn radii(section: &Section) -> Vec<f64> {
    let mut radii = vec![0.0_f64; ANGLES];
    let count = section.contour.len();
    for (i, &a) in section.contour.iter().enumerate() {
        let (a, b) = (
            a - section.centroid,
            section.contour[(i + 1) % count] - section.centroid,
        );
        // Sides of a coarse outline span sectors: walk along them.
        let angle = libm::atan2(a.perp_dot(b), a.dot(b)).abs();
        let steps = (2.0 * angle / TAU * ANGLES as f64).ceil().clamp(1.0, 64.0) as u32;
        for k in 0..steps {
            let p = a + (b - a) * (f64::from(k) / f64::from(steps));
            let turn = (libm::atan2(p.y, p.x) + PI) / TAU * ANGLES as f64;
            let bin = &mut radii[turn as usize % ANGLES];
            *bin = bin.max(p.length());
        }
    }
    let fallback = (section.area / PI).sqrt();
    for k in 0..ANGLES {
        if radii[k] == 0.0 {
            let next = radii[(k + 1) % ANGLES];
            let before = radii[(k + ANGLES - 1) % ANGLES];
            let filled = before.max(next);
            radii[k] = if filled > 0.0 { filled } else { fallback };
        }
    }
    radii
}

/// Ranges in rising order, those closer than `gap` made one.
pub(crate) fn merged(mut ranges: Vec<(f64, f64)>, gap: f64) -> Vec<(f64, f64)> {
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut result: Vec<(f64, f64)> = Vec::new();
    for r in ranges {
        match result.last_mut() {
            Some(last) if r.0 <= last.1 + gap => last.1 = last.1.max(r.1),
            _ => result.push(r),
        }
    }
    result
}

/// What a shell hangs on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hanging {
    /// Index of the shell that carries it.
    pub on: usize,
    /// About where, m.
    pub at: DVec3,
}

/// Points that tell where a shell is fixed: those of its border, or, for a closed shell, any.
fn fixing_points(points: &Points, shell: &Shell) -> Vec<DVec3> {
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for &t in &shell.triangles {
        let t = points.triangles[t as usize];
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if a != b {
                edges.push((a.min(b), a.max(b)));
            }
        }
    }
    edges.sort_unstable();
    let mut corners: Vec<u32> = edges
        .chunk_by(|a, b| a == b)
        .filter(|same| same.len() == 1)
        .map(|same| same[0].0)
        .collect();
    if corners.is_empty() {
        corners = edges.iter().map(|e| e.0).collect();
    }
    corners.dedup();
    let count = corners.len().min(SAMPLES);
    (0..count)
        .map(|k| points.positions[corners[k * corners.len() / count] as usize])
        .collect()
}

/// What `shell` hangs on among `carriers` (shell, surface): the one that holds most of its fixing points, else the
/// nearest one that is close.
pub(crate) fn hangs_on(
    points: &Points,
    shells: &[Shell],
    shell: usize,
    carriers: &[(usize, Surface)],
) -> Option<Hanging> {
    let me = &shells[shell];
    let close = NEAR * me.diagonal();
    let fixed = fixing_points(points, me);
    let mut best: Option<(usize, f64, Hanging)> = None;
    let mut nearest: Option<(f64, Hanging)> = None;
    for (on, surface) in carriers {
        if *on == shell || !shells[*on].meets(me, close) {
            continue;
        }
        let inside: Vec<DVec3> = fixed
            .iter()
            .copied()
            .filter(|&p| surface.holds(p))
            .collect();
        if !inside.is_empty() {
            let at = inside.iter().sum::<DVec3>() / inside.len() as f64;
            let size = shells[*on].diagonal();
            if best
                .as_ref()
                .is_none_or(|b| (inside.len(), size) > (b.0, b.1))
            {
                best = Some((inside.len(), size, Hanging { on: *on, at }));
            }
        }
        // Larger things do not hang on smaller ones that merely lie close.
        if best.is_none() && shells[*on].diagonal() > me.diagonal() {
            for &p in &fixed {
                let Some((_, q)) = surface.nearest(p) else {
                    continue;
                };
                let d = p.distance(q);
                if d <= close && nearest.as_ref().is_none_or(|n| d < n.0) {
                    nearest = Some((d, Hanging { on: *on, at: p }));
                }
            }
        }
    }
    best.map(|b| b.2).or(nearest.map(|n| n.1))
}

/// For every point of the cut shell whether it lies beyond the place: `barrier` are the triangles under the section
/// through `origin`. `None` where both sides are connected another way.
pub(crate) fn upper_side(
    points: &Points,
    shell: &Shell,
    barrier: &[u32],
    origin: DVec3,
    along: DVec3,
) -> Option<impl FnMut(u32) -> bool> {
    let mut sets = Unions::new(points.positions.len());
    let mut sorted = barrier.to_vec();
    sorted.sort_unstable();
    for &t in &shell.triangles {
        if sorted.binary_search(&t).is_err() {
            let [a, b, c] = points.triangles[t as usize];
            sets.join(a, b);
            sets.join(a, c);
        }
    }
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for &t in &sorted {
        for c in points.triangles[t as usize] {
            let root = sets.root(c);
            let high = (points.positions[c as usize] - origin).dot(along) > 0.0;
            if high {
                above.push(root)
            } else {
                below.push(root)
            }
        }
    }
    above.sort_unstable();
    if below.iter().any(|b| above.binary_search(b).is_ok()) {
        return None;
    }
    Some(move |point: u32| above.binary_search(&sets.root(point)).is_ok())
}
