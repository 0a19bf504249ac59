//! The points of a stem with their address: length, angle, radius.

use super::Followed;
use super::field::Field;
use super::section::Section;
use crate::stem::Frame;
use glam::{DVec2, DVec3};
use greenstick_geometry::PointCloud;
use greenstick_geometry::cloud::{KdTree, normals};
use rayon::prelude::*;

/// Points beyond so many radii belong to something else.
const REACH: f64 = 1.8;
/// Points off the stem's form by more than this share of the radius (and than four times their spread) are strangers.
const OFF: f64 = 0.2;
/// Half of the points of a part are farther from their median than this, in radii, where a ray meets the bark twice.
const FOLD: f64 = 0.2;
/// Normals within about 50 degrees of the axis are those of a broken or sawn face.
const FACE: f64 = 0.64;
/// Wood inside this share of the bark's radius is no bark.
const INSIDE: f64 = 0.88;

/// A point of the stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// Its number in the cloud.
    pub number: u32,
    /// Length along the axis, m.
    pub s: f64,
    /// Angle in turns, 0 to 1.
    pub turn: f64,
    /// Distance from the axis, m.
    pub radius: f64,
}

/// The points about a stem.
pub(super) struct Addressed<'a> {
    pub cloud: &'a PointCloud,
    pub points: Vec<Point>,
    /// Points about the stem that are not of its bark.
    pub strangers: usize,
    /// Points of a fracture surface.
    pub face: usize,
    /// Parts of sections by length: how many a ray meets more than once, and of how many.
    pub folds: Vec<(f64, usize, usize)>,
    bark_only: bool,
}

/// The frames of an axis at equal steps, to find lengths quickly.
struct Frames {
    frames: Vec<Frame>,
    tree: KdTree,
    step: f64,
    section: Section,
}

impl Frames {
    fn new(followed: &Followed) -> Self {
        let length = followed.axis.length();
        let least = followed.radii.iter().fold(f64::INFINITY, |a, r| a.min(r.1));
        let count = ((length / (0.2 * least)).ceil()).clamp(8.0, 50_000.0) as usize;
        let step = length / count as f64;
        let frames: Vec<Frame> = (0..=count)
            .map(|k| followed.axis.frame(step * k as f64))
            .collect();
        let origins: Vec<DVec3> = frames.iter().map(|f| f.origin).collect();
        Frames {
            frames,
            tree: KdTree::new(&origins),
            step,
            section: followed.section,
        }
    }

    /// Address of a point: length, angle in turns, radius.
    fn address(&self, p: DVec3) -> Option<(f64, f64, f64)> {
        let k = self.tree.nearest(p, 1).first()?.1 as usize;
        let near = &self.frames[k];
        let off = (p - near.origin).dot(near.tangent) / self.step;
        let (a, b) = if off >= 0.0 {
            (k, k + 1)
        } else {
            (k.wrapping_sub(1), k)
        };
        let (Some(a), Some(b)) = (self.frames.get(a), self.frames.get(b)) else {
            // Beyond an end, where half a step of slack is allowed.
            return (off.abs() <= 0.5).then(|| self.polar(near, p, k as f64 * self.step));
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
        let first = if off >= 0.0 { k } else { k - 1 };
        Some(self.polar(&between, p, (first as f64 + t) * self.step))
    }

    fn polar(&self, frame: &Frame, p: DVec3, s: f64) -> (f64, f64, f64) {
        let d = p - frame.origin;
        let (turn, radius) = self
            .section
            .address(DVec2::new(d.dot(frame.x), d.dot(frame.y)));
        (s, turn, radius)
    }
}

impl<'a> Addressed<'a> {
    /// Share of the parts of sections between two lengths that a ray meets more than once.
    pub fn folded(&self, from: f64, to: f64) -> f64 {
        let between = self.folds.iter().filter(|f| (from..=to).contains(&f.0));
        let (folded, full) = between.fold((0, 0), |sum, f| (sum.0 + f.1, sum.1 + f.2));
        folded as f64 / full.max(1) as f64
    }

    /// The points about a stem; with `bark_only` without those whose normals run along the axis.
    pub fn new(cloud: &'a PointCloud, followed: &Followed, bark_only: bool) -> Self {
        let frames = Frames::new(followed);
        let mut points: Vec<Point> = cloud
            .points
            .par_iter()
            .enumerate()
            .filter_map(|(number, p)| {
                let (s, turn, radius) = frames.address(*p)?;
                (radius <= REACH * followed.radius(s)).then_some(Point {
                    number: number as u32,
                    s,
                    turn,
                    radius,
                })
            })
            .collect();
        let before = points.len();
        if bark_only {
            let places: Vec<DVec3> = points
                .iter()
                .map(|p| cloud.points[p.number as usize])
                .collect();
            let directions = if cloud.normals.is_empty() {
                normals(&places, &KdTree::new(&places), 12)
            } else {
                points
                    .iter()
                    .map(|p| cloud.normals[p.number as usize])
                    .collect()
            };
            let mut directions = directions.iter();
            points.retain(|p| {
                let tangent = followed.axis.frame(p.s).tangent;
                directions
                    .next()
                    .is_none_or(|n| n.dot(tangent).abs() < FACE)
            });
        }
        Addressed {
            cloud,
            face: before - points.len(),
            points,
            strangers: 0,
            folds: Vec::new(),
            bark_only,
        }
    }

    /// Leaves only points near the median form of the stem, in parts of an eighth of the girth or less by about a radius.
    pub fn drop_strangers(&mut self, followed: &Followed) {
        let length = followed.axis.length();
        let mean = followed.mean_radius();
        let along = ((length / mean).round() as usize).clamp(2, 20_000);
        let per_ring = self.points.len() as f64 / along as f64;
        let around = ((per_ring / 6.0) as usize).clamp(8, 32);
        let cells = Field::cells(&self.points, around, along, length);
        let mut form = Field::new(around, along, length);
        let mut spread = Vec::new();
        self.folds = (0..along).map(|i| (form.length_of(i), 0, 0)).collect();
        for (k, cell) in cells.iter().enumerate() {
            if cell.len() < 3 {
                continue;
            }
            let mut radii: Vec<f64> = cell
                .iter()
                .map(|&i| self.points[i as usize].radius)
                .collect();
            radii.sort_unstable_by(f64::total_cmp);
            let median = radii[radii.len() / 2];
            let mut off: Vec<f64> = radii.iter().map(|r| (r - median).abs()).collect();
            off.sort_unstable_by(f64::total_cmp);
            let s = (k / around) as f64 / along as f64 * length;
            let expected = followed.radius(s);
            let fold = &mut self.folds[k / around];
            fold.1 += usize::from(off[off.len() / 2] > FOLD * expected);
            fold.2 += 1;
            spread.push(off[off.len() / 2]);
            // A part that only another limb was seen in says nothing of the stem.
            if (median / expected - 1.0).abs() < 0.5 {
                form.set(k, median);
            }
        }
        form.calm();
        form.complete(|s| followed.radius(s));
        spread.sort_unstable_by(f64::total_cmp);
        let sigma = 1.4826 * spread.get(spread.len() / 2).copied().unwrap_or(0.0);
        let before = self.points.len();
        let mut face = 0;
        let bark_only = self.bark_only;
        self.points.retain(|p| {
            let bark = form.at(p.s, p.turn);
            if bark_only && p.radius < INSIDE * bark {
                face += 1;
                return false;
            }
            (p.radius - bark).abs() <= (4.0 * sigma).max(OFF * bark)
        });
        self.face += face;
        self.strangers = before - self.points.len() - face;
    }
}
