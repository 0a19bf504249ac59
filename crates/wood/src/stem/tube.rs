//! The space that a stem fills, as a tube about its axis: which other shells come inside it, and which triangles of its
//! own shell belong to the limb.

use super::body::Body;
use super::model::CrossSection;
use super::shells::{Shell, WeldedMesh};
use super::surface::Surface;
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context, Unions};
use std::f64::consts::{PI, TAU};

/// Sectors in which a section's outline is stored for the test whether a point is inside.
const SECTORS: usize = 64;
/// A shell touches the stem where it comes inside the outline or as near to it, in radii.
const TOUCHING_RADII: f64 = 0.03;
/// Triangles within this many radii of the outline are the limb's: wider than the relief of any bark, narrower than the
/// way to another limb.
const LIMB_RADII: f64 = 1.6;
/// Cells of the surface smaller than this, in radii, are in or out as a whole.
const SMALL_CELL_RADII: f64 = 0.4;
/// Triangles between two checks for cancellation: each may be sampled hundreds of times.
const CHECK_INTERVAL: usize = 64;

/// Range of lengths, m; empty where `low` is above `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LengthRange {
    low: f64,
    high: f64,
}

impl LengthRange {
    const EMPTY: LengthRange = LengthRange {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    fn add(&mut self, s: f64) {
        self.low = self.low.min(s);
        self.high = self.high.max(s);
    }
}

/// A section's outline as the largest radius in each sector about its centroid.
struct PolarOutline {
    centroid: DVec2,
    radii: Vec<f64>,
}

/// The stem's tube about its axis.
pub(crate) struct Tube<'a> {
    body: &'a Body,
    /// At each axis point, where there is a section.
    outlines: Vec<Option<PolarOutline>>,
    /// Radius of the circle of equal area at or next to each axis point, m.
    radii: Vec<f64>,
    low: DVec3,
    high: DVec3,
    widest: f64,
}

/// Where a point lies relative to the tube.
struct TubePosition {
    /// Length along the axis, m.
    length: f64,
    /// Distance from the centroid over the outline's radius; `None` where the axis has no section.
    ratio: Option<f64>,
}

impl<'a> Tube<'a> {
    pub fn new(body: &'a Body) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut widest: f64 = 0.0;
        let mut outlines: Vec<Option<PolarOutline>> = Vec::new();
        for station in &body.stations {
            let Some(section) = &station.section else {
                outlines.push(None);
                continue;
            };
            let frame = body.axis.frame(section.length);
            for p in &section.contour {
                let p = frame.origin + frame.x * p.x + frame.y * p.y;
                (low, high) = (low.min(p), high.max(p));
                widest = widest.max(p.distance(frame.origin));
            }
            outlines.push(Some(PolarOutline {
                centroid: section.centroid,
                radii: sector_radii(section),
            }));
        }
        let lengths = body.axis.lengths().iter();
        Tube {
            body,
            outlines,
            radii: lengths.map(|&s| body.radius(s)).collect(),
            low: low - 0.1 * widest,
            high: high + 0.1 * widest,
            widest,
        }
    }

    /// Index of the axis point next to `p`.
    fn nearest_axis_point(&self, p: DVec3) -> usize {
        let points = self.body.axis.points();
        let (mut best, mut nearest) = (0, f64::INFINITY);
        let mut consider = |i: usize| {
            let d = points[i].distance_squared(p);
            if d < nearest {
                (best, nearest) = (i, d);
            }
            best
        };
        // Neighbouring points are a quarter of a radius apart: every fourth, then those around the best.
        for i in (0..points.len()).step_by(4) {
            consider(i);
        }
        let coarse = consider(0);
        for i in coarse.saturating_sub(4)..(coarse + 5).min(points.len()) {
            consider(i);
        }
        best
    }

    /// Radius (m) of the circle of equal area next to `p`.
    fn radius(&self, p: DVec3) -> f64 {
        self.radii[self.nearest_axis_point(p)]
    }

    fn locate(&self, p: DVec3) -> TubePosition {
        let i = self.nearest_axis_point(p);
        let axis = &self.body.axis;
        let frame = axis.frame(axis.lengths()[i]);
        let d = p - frame.origin;
        let length = axis.lengths()[i] + d.dot(frame.tangent);
        let ratio = self.outlines[i].as_ref().map(|outline| {
            let q = DVec2::new(d.dot(frame.x), d.dot(frame.y)) - outline.centroid;
            let turn = (libm::atan2(q.y, q.x) + PI) / TAU * SECTORS as f64;
            q.length() / outline.radii[turn as usize % SECTORS]
        });
        TubePosition { length, ratio }
    }

    fn bounds_meet(&self, [a, b, c]: [DVec3; 3]) -> bool {
        a.min(b).min(c).cmple(self.high).all() && a.max(b).max(c).cmpge(self.low).all()
    }

    /// Ranges of length (m) over which another shell comes inside the stem.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn contact_ranges(
        &self,
        mesh: &WeldedMesh,
        shell: &Shell,
        context: &Context,
    ) -> Result<Vec<(f64, f64)>, Cancelled> {
        let mut ranges: Vec<(f64, f64)> = Vec::new();
        if shell.low.cmpgt(self.high).any() || shell.high.cmplt(self.low).any() {
            return Ok(ranges);
        }
        for (k, &t) in shell.triangles.iter().enumerate() {
            if k % CHECK_INTERVAL == 0 {
                context.check()?;
            }
            let corners = mesh.corners(t);
            if !self.bounds_meet(corners) {
                continue;
            }
            let mut range = LengthRange::EMPTY;
            let spacing = 0.25 * self.radius(corners[0]);
            sample_triangle(corners, spacing, |p| {
                let at = self.locate(p);
                let along = at.length > -spacing && at.length < self.body.axis.length() + spacing;
                if at.ratio.is_some_and(|r| r < 1.0 + TOUCHING_RADII) && along {
                    range.add(at.length);
                }
            });
            if range.low <= range.high {
                ranges.push((range.low, range.high));
            }
        }
        Ok(merge_ranges(ranges, 0.5 * self.widest))
    }

    /// Triangles of the stem's own shell that belong to the limb between two lengths (m): those connected with the ones
    /// under the section, given as `start`, without leaving the limb.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn limb(
        &self,
        surface: &Surface,
        range: (f64, f64),
        start: &[u32],
        context: &Context,
    ) -> Result<Vec<u32>, Cancelled> {
        let near = self.triangles_near(surface, range, context)?;
        let largest = near
            .iter()
            .flat_map(|&i| surface.corner_points(i))
            .max()
            .map_or(0, |m| m + 1);
        let mut sets = Unions::new(largest as usize);
        for &i in &near {
            let [a, b, c] = surface.corner_points(i);
            sets.join(a, b);
            sets.join(a, c);
        }
        let mut wanted = start.to_vec();
        wanted.sort_unstable();
        let mut roots: Vec<u32> = near
            .iter()
            .filter(|&&i| wanted.binary_search(&surface.mesh_triangle(i)).is_ok())
            .map(|&i| sets.root(surface.corner_points(i)[0]))
            .collect();
        roots.sort_unstable();
        roots.dedup();
        context.check()?;
        // Marks instead of sorting: a limb of a scan has a million triangles.
        let last = near
            .iter()
            .map(|&i| surface.mesh_triangle(i))
            .chain(wanted.iter().copied())
            .max();
        let mut marked = vec![false; last.map_or(0, |n| n as usize + 1)];
        for &i in &near {
            let root = sets.root(surface.corner_points(i)[0]);
            if roots.binary_search(&root).is_ok() {
                marked[surface.mesh_triangle(i) as usize] = true;
            }
        }
        wanted.iter().for_each(|&n| marked[n as usize] = true);
        Ok((0..marked.len() as u32)
            .filter(|&n| marked[n as usize])
            .collect())
    }

    /// Triangles (indices into the surface) within [`LIMB_RADII`] of the axis between two lengths (m).
    fn triangles_near(
        &self,
        surface: &Surface,
        range: (f64, f64),
        context: &Context,
    ) -> Result<Vec<usize>, Cancelled> {
        let mut near: Vec<usize> = Vec::new();
        let mut sampled = 0;
        for cell in surface.cells() {
            context.check()?;
            let (middle, half) = (cell.middle, cell.half);
            let apart =
                (middle - half).cmpgt(self.high).any() || (middle + half).cmplt(self.low).any();
            if apart {
                continue;
            }
            let size = half.length() / self.radius(middle);
            let at = self.locate(middle);
            if let (true, Some(ratio)) = (size < SMALL_CELL_RADII, at.ratio) {
                let (s, by) = (at.length, 1.5 * half.length());
                if s + by < range.0 || s - by > range.1 {
                    continue;
                }
                if s - by >= range.0 && s + by <= range.1 && ratio + 1.5 * size < LIMB_RADII {
                    near.extend(cell.triangles.clone());
                    continue;
                }
            }
            for i in cell.triangles.clone() {
                let corners = surface.corners(i);
                if !self.bounds_meet(corners) {
                    continue;
                }
                sampled += 1;
                if sampled % CHECK_INTERVAL == 0 {
                    context.check()?;
                }
                let mut lengths = LengthRange::EMPTY;
                let mut inside = false;
                sample_triangle(corners, 0.3 * self.radius(corners[0]), |p| {
                    let at = self.locate(p);
                    lengths.add(at.length);
                    inside |= at.ratio.is_some_and(|r| r < LIMB_RADII);
                });
                if inside && lengths.low <= range.1 && lengths.high >= range.0 {
                    near.push(i);
                }
            }
        }
        Ok(near)
    }
}

/// Visits points of a triangle close enough together not to step over the stem.
fn sample_triangle([a, b, c]: [DVec3; 3], spacing: f64, mut visit: impl FnMut(DVec3)) {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let n = (longest / spacing).ceil().clamp(1.0, 24.0) as u32;
    for i in 0..=n {
        for j in 0..=n - i {
            let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            visit(a + (b - a) * u + (c - a) * v);
        }
    }
}

/// Largest distance of the outline from the centroid in each of [`SECTORS`] sectors.
fn sector_radii(section: &CrossSection) -> Vec<f64> {
    let mut radii = vec![0.0_f64; SECTORS];
    let count = section.contour.len();
    for (i, &a) in section.contour.iter().enumerate() {
        let (a, b) = (
            a - section.centroid,
            section.contour[(i + 1) % count] - section.centroid,
        );
        // Sides of a coarse outline span sectors: walk along them.
        let angle = libm::atan2(a.perp_dot(b), a.dot(b)).abs();
        let steps = (2.0 * angle / TAU * SECTORS as f64).ceil().clamp(1.0, 64.0) as u32;
        for k in 0..steps {
            let p = a + (b - a) * (f64::from(k) / f64::from(steps));
            let turn = (libm::atan2(p.y, p.x) + PI) / TAU * SECTORS as f64;
            let bin = &mut radii[turn as usize % SECTORS];
            *bin = bin.max(p.length());
        }
    }
    let fallback = (section.area / PI).sqrt();
    for k in 0..SECTORS {
        if radii[k] == 0.0 {
            let next = radii[(k + 1) % SECTORS];
            let before = radii[(k + SECTORS - 1) % SECTORS];
            let filled = before.max(next);
            radii[k] = if filled > 0.0 { filled } else { fallback };
        }
    }
    radii
}

/// Ranges in rising order, those closer than `gap` merged.
pub(crate) fn merge_ranges(mut ranges: Vec<(f64, f64)>, gap: f64) -> Vec<(f64, f64)> {
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut merged: Vec<(f64, f64)> = Vec::new();
    for r in ranges {
        match merged.last_mut() {
            Some(last) if r.0 <= last.1 + gap => last.1 = last.1.max(r.1),
            _ => merged.push(r),
        }
    }
    merged
}
