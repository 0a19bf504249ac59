//! The points of a stem with their address: length, angle, radius.

use super::grid::{GridSize, UnrolledGrid};
use super::shape::SectionShape;
use super::traced::TracedStem;
use crate::stem::Frame;
use crate::tissue::MIN_BARK_START;
use glam::{DVec2, DVec3};
use greenstick_geometry::cloud::{KdTree, normals};
use greenstick_geometry::{Cancelled, Context, PointCloud};
use rayon::prelude::*;

/// Points beyond so many radii belong to something else.
const MAX_REACH_RADII: f64 = 1.8;
/// Points off the stem's form by more than this share of the radius, and by more than so many times their spread, are
/// foreign.
const MAX_DEVIATION_RADII: f64 = 0.2;
const MAX_DEVIATION_SIGMAS: f64 = 4.0;
/// Half of the points of a patch are farther from their median than this, in radii, where a ray meets the bark twice.
const FOLD_SPREAD_RADII: f64 = 0.2;
/// Normals within about 50 degrees of the axis are those of a broken or sawn face.
const FACE_COSINE: f64 = 0.64;
/// Neighbours that a normal is estimated from.
const NORMAL_NEIGHBOURS: usize = 12;
/// Standard deviation of a normal distribution over its median absolute deviation.
const SIGMA_PER_MEDIAN_DEVIATION: f64 = 1.4826;
/// A patch whose median differs from the traced radius by this share shows another limb and says nothing of the stem.
const MAX_FORM_DEVIATION: f64 = 0.5;
/// Points that are addressed between two checks for cancellation.
const BATCH: usize = 1 << 14;

/// The address of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Address {
    /// Length along the axis, m.
    s: f64,
    /// Angle in turns, 0 to 1.
    turn: f64,
    /// Distance from the axis, m.
    radius: f64,
}

/// A point of the stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StemPoint {
    /// Its number in the cloud.
    pub number: u32,
    /// Length along the axis, m.
    pub s: f64,
    /// Angle in turns, 0 to 1.
    pub turn: f64,
    /// Distance from the axis, m.
    pub radius: f64,
}

/// How many patches of the sections at a length a ray from the pith meets more than once.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Folds {
    /// m.
    length: f64,
    folded: usize,
    patches: usize,
}

/// The points about a stem.
pub(super) struct StemPoints<'a> {
    pub cloud: &'a PointCloud,
    pub points: Vec<StemPoint>,
    /// Number of points about the stem that are not of its bark.
    pub foreign: usize,
    /// Number of points of a fracture surface.
    pub fracture_points: usize,
    folds: Vec<Folds>,
    bark_only: bool,
}

/// The frames of an axis at equal steps, to find lengths quickly.
struct Frames {
    frames: Vec<Frame>,
    tree: KdTree,
    step: f64,
    shape: SectionShape,
}

impl Frames {
    fn new(stem: &TracedStem) -> Self {
        let length = stem.axis.length();
        let least = stem
            .radii
            .iter()
            .fold(f64::INFINITY, |a, r| a.min(r.radius));
        let count = ((length / (0.2 * least)).ceil()).clamp(8.0, 50_000.0) as usize;
        let step = length / count as f64;
        let frames: Vec<Frame> = (0..=count)
            .map(|k| stem.axis.frame(step * k as f64))
            .collect();
        let origins: Vec<DVec3> = frames.iter().map(|f| f.origin).collect();
        Frames {
            frames,
            tree: KdTree::new(&origins),
            step,
            shape: stem.shape,
        }
    }

    /// The address of a point; `None` beyond the ends.
    fn address(&self, p: DVec3) -> Option<Address> {
        let k = self.tree.nearest(p, 1).first()?.1 as usize;
        let nearest = &self.frames[k];
        let offset = (p - nearest.origin).dot(nearest.tangent) / self.step;
        let (a, b) = if offset >= 0.0 {
            (k, k + 1)
        } else {
            (k.wrapping_sub(1), k)
        };
        let (Some(a), Some(b)) = (self.frames.get(a), self.frames.get(b)) else {
            // Beyond an end, where half a step of slack is allowed.
            return (offset.abs() <= 0.5).then(|| self.in_frame(nearest, p, k as f64 * self.step));
        };
        let (u, v) = ((p - a.origin).dot(a.tangent), (b.origin - p).dot(b.tangent));
        let t = (u / (u + v)).clamp(0.0, 1.0);
        let tangent = a.tangent.lerp(b.tangent, t).normalize();
        let x = a.x.lerp(b.x, t).reject_from_normalized(tangent).normalize();
        let between = Frame {
            origin: a.origin.lerp(b.origin, t),
            x,
            y: tangent.cross(x),
            tangent,
        };
        let first = if offset >= 0.0 { k } else { k - 1 };
        Some(self.in_frame(&between, p, (first as f64 + t) * self.step))
    }

    fn in_frame(&self, frame: &Frame, p: DVec3, s: f64) -> Address {
        let d = p - frame.origin;
        let (turn, radius) = self
            .shape
            .address(DVec2::new(d.dot(frame.x), d.dot(frame.y)));
        Address { s, turn, radius }
    }
}

impl<'a> StemPoints<'a> {
    /// The points about a stem; with `bark_only` without those whose normals run along the axis.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        cloud: &'a PointCloud,
        stem: &TracedStem,
        bark_only: bool,
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let frames = Frames::new(stem);
        let addressed = |(number, p): (usize, &DVec3)| {
            let Address { s, turn, radius } = frames.address(*p)?;
            (radius <= MAX_REACH_RADII * stem.radius(s)).then_some(StemPoint {
                number: number as u32,
                s,
                turn,
                radius,
            })
        };
        let batches: Vec<Vec<StemPoint>> = cloud
            .points
            .par_chunks(BATCH)
            .enumerate()
            .map(|(batch, points)| {
                context.check()?;
                let numbered = (batch * BATCH..).zip(points);
                Ok(numbered.filter_map(&addressed).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        let points = batches.concat();
        let mut found = StemPoints {
            cloud,
            points,
            foreign: 0,
            fracture_points: 0,
            folds: Vec::new(),
            bark_only,
        };
        if bark_only {
            context.check()?;
            found.remove_faces(stem);
        }
        Ok(found)
    }

    /// Removes the points whose normals run along the axis.
    fn remove_faces(&mut self, stem: &TracedStem) {
        let before = self.points.len();
        let cloud = self.cloud;
        let directions: Vec<DVec3> = if cloud.normals.is_empty() {
            let positions: Vec<DVec3> = self
                .points
                .iter()
                .map(|p| cloud.points[p.number as usize])
                .collect();
            normals(&positions, &KdTree::new(&positions), NORMAL_NEIGHBOURS)
        } else {
            let numbers = self.points.iter().map(|p| p.number as usize);
            numbers.map(|n| cloud.normals[n]).collect()
        };
        let mut directions = directions.iter();
        self.points.retain(|p| {
            let tangent = stem.axis.frame(p.s).tangent;
            directions
                .next()
                .is_none_or(|n| n.dot(tangent).abs() < FACE_COSINE)
        });
        self.fracture_points += before - self.points.len();
    }

    /// Share of the patches of sections between two lengths (m) that a ray from the pith meets more than once.
    pub fn folded(&self, from: f64, to: f64) -> f64 {
        let between = self
            .folds
            .iter()
            .filter(|f| (from..=to).contains(&f.length));
        let (folded, patches) =
            between.fold((0, 0), |sum, f| (sum.0 + f.folded, sum.1 + f.patches));
        folded as f64 / patches.max(1) as f64
    }

    /// The numbers of the points (in this list) in each cell of a grid.
    fn by_cell(&self, size: GridSize) -> Vec<Vec<u32>> {
        let mut cells = vec![Vec::new(); size.cells()];
        for (p, i) in self.points.iter().zip(0..) {
            cells[size.cell(p.s, p.turn)].push(i);
        }
        cells
    }

    /// Removes the points far from the median form of the stem, which is taken over patches of an eighth of the girth or
    /// less by about a radius.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn remove_foreign_points(
        &mut self,
        stem: &TracedStem,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let length = stem.axis.length();
        let along = ((length / stem.mean_radius()).round() as usize).clamp(2, 20_000);
        let per_row = self.points.len() as f64 / along as f64;
        let size = GridSize {
            around: ((per_row / 6.0) as usize).clamp(8, 32),
            along,
            length,
        };
        let (form, sigma) = self.median_form(stem, size, context)?;
        let before = self.points.len();
        let mut inside = 0;
        let bark_only = self.bark_only;
        self.points.retain(|p| {
            let bark = form.at(p.s, p.turn);
            if bark_only && p.radius < MIN_BARK_START * bark {
                inside += 1;
                return false;
            }
            let allowed = (MAX_DEVIATION_SIGMAS * sigma).max(MAX_DEVIATION_RADII * bark);
            (p.radius - bark).abs() <= allowed
        });
        self.fracture_points += inside;
        self.foreign = before - self.points.len() - inside;
        Ok(())
    }

    /// The median radius of each patch, and the standard deviation of points from it; counts folds on the way.
    fn median_form(
        &mut self,
        stem: &TracedStem,
        size: GridSize,
        context: &Context,
    ) -> Result<(UnrolledGrid, f64), Cancelled> {
        let mut form = UnrolledGrid::new(size);
        let mut spread = Vec::new();
        self.folds = (0..size.along)
            .map(|i| Folds {
                length: size.length_of(i),
                folded: 0,
                patches: 0,
            })
            .collect();
        for (k, cell) in self.by_cell(size).iter().enumerate() {
            context.check()?;
            if cell.len() < 3 {
                continue;
            }
            let mut radii: Vec<f64> = cell
                .iter()
                .map(|&i| self.points[i as usize].radius)
                .collect();
            radii.sort_unstable_by(f64::total_cmp);
            let median = radii[radii.len() / 2];
            let mut deviations: Vec<f64> = radii.iter().map(|r| (r - median).abs()).collect();
            deviations.sort_unstable_by(f64::total_cmp);
            let deviation = deviations[deviations.len() / 2];
            let s = (k / size.around) as f64 / size.along as f64 * size.length;
            let expected = stem.radius(s);
            let folds = &mut self.folds[k / size.around];
            folds.folded += usize::from(deviation > FOLD_SPREAD_RADII * expected);
            folds.patches += 1;
            spread.push(deviation);
            if (median / expected - 1.0).abs() < MAX_FORM_DEVIATION {
                form.set(k, median);
            }
        }
        form.median_filter();
        form.complete(|s| stem.radius(s), context)?;
        spread.sort_unstable_by(f64::total_cmp);
        let median = spread.get(spread.len() / 2).copied().unwrap_or(0.0);
        Ok((form, SIGMA_PER_MEDIAN_DEVIATION * median))
    }
}
