//! Rings of a section by the published erosion.

use super::super::field::RingField;
use super::super::source::RingPart;
use super::super::{Erosion, ring_numbers};
use super::curves::CURVE_POINTS;
use super::error::SectionRingError;
use super::outline::SectionOutline;
use crate::raster::{PixelGrid, fill_loops};
use glam::DVec2;
use greenstick_geometry::{Bitmap, Cancelled, Context};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Width of the bitmap that is eroded over the section's.
const BITMAP_MARGIN: f64 = 1.04;

/// The passes of an erosion over a section's outline.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ErodedSection {
    grid: PixelGrid,
    /// The point at the grid's origin.
    centre: DVec2,
    passes: Vec<u16>,
    /// What pass n takes off, at index n − 1, from the contour inwards.
    pub parts: Vec<RingPart>,
    /// Outer contours of the rings from the innermost on, the largest where a ring is in several parts.
    pub contours: Vec<Vec<DVec2>>,
}

impl ErodedSection {
    /// Erodes a section in a bitmap of `resolution` × `resolution` pixels. The field's pith is where an inner circle lies.
    pub fn new(
        outline: &SectionOutline,
        field: &RingField,
        erosion: &Erosion,
        resolution: usize,
        context: &Context,
    ) -> Result<Self, SectionRingError> {
        let fronts = erosion.fronts(resolution)?;
        let extent = outline.extent();
        let centre = extent.centre();
        let grid = PixelGrid {
            count: resolution,
            pixel: BITMAP_MARGIN * extent.side() / resolution as f64,
        };
        let points: Vec<DVec2> = outline.points.iter().map(|p| *p - centre).collect();
        let wood = fill_loops(&grid, &[points]);
        let pith = grid.to_pixel_centres(field.pith() - centre);
        let mean_radius = (wood.count() as f64 / PI).sqrt();
        let eroded = fronts.passes(&wood, pith, mean_radius, context)?;
        if eroded.parts.is_empty() {
            return Err(SectionRingError::NotEroded { resolution });
        }
        let mut section = ErodedSection {
            grid,
            centre,
            passes: eroded.passes,
            parts: eroded.parts,
            contours: Vec::new(),
        };
        section.contours = section.ring_contours(context)?;
        Ok(section)
    }

    /// The outer contours of the rings, from the innermost on.
    fn ring_contours(&self, context: &Context) -> Result<Vec<Vec<DVec2>>, Cancelled> {
        let rings = ring_numbers(self.parts.iter().copied());
        let first_passes = (1..rings.len()).filter(|&n| rings[n] > rings[n - 1]);
        let passes_before: Vec<usize> = first_passes.rev().map(|n| n - 1).collect();
        let contours: Vec<Vec<DVec2>> = passes_before
            .par_iter()
            .map(|&passes| {
                context.check()?;
                Ok(self.contour_after(passes))
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(contours.into_iter().filter(|c| !c.is_empty()).collect())
    }

    /// The contour of what is left after a number of passes, of the largest part of it; [`CURVE_POINTS`] points at equal
    /// distances, from the middles of pixels' edges. None where nothing is left.
    pub fn contour_after(&self, passes: usize) -> Vec<DVec2> {
        let count = self.grid.count;
        let mut left = Bitmap::new(count, count);
        for (i, &pass) in self.passes.iter().enumerate() {
            if usize::from(pass) > passes {
                left.set(i % count, i / count, true);
            }
        }
        let twice_area = |border: &Vec<[usize; 2]>| -> i64 {
            let next = border.iter().cycle().skip(1);
            border
                .iter()
                .zip(next)
                .map(|([x, y], [u, v])| (x * v) as i64 - (u * y) as i64)
                .sum()
        };
        let Some(border) = left.borders().into_iter().max_by_key(twice_area) else {
            return Vec::new();
        };
        let corner = |i: usize| {
            let [x, y] = border[i % border.len()];
            DVec2::new(x as f64, y as f64)
        };
        let half = 0.5 * count as f64;
        (0..CURVE_POINTS)
            .map(|k| {
                // Between the middles of an edge and the next one.
                let place = k as f64 / CURVE_POINTS as f64 * border.len() as f64;
                let i = place as usize;
                let middle = |i: usize| 0.5 * (corner(i) + corner(i + 1));
                let p = middle(i).lerp(middle(i + 1), place.fract());
                (p - half) * self.grid.pixel + self.centre
            })
            .collect()
    }

    /// Which part of a ring a point of the section's plane lies in; `None` outside of the section. What no pass took is
    /// earlywood.
    pub fn part_at(&self, p: DVec2) -> Option<RingPart> {
        let count = self.grid.count as f64;
        let at = self.grid.to_pixels(p - self.centre).floor();
        if at.min_element() < 0.0 || at.max_element() >= count {
            return None;
        }
        let pass = self.passes[at.y as usize * self.grid.count + at.x as usize];
        let index = usize::from(pass).checked_sub(1)?;
        Some(
            self.parts
                .get(index)
                .copied()
                .unwrap_or(RingPart::Earlywood),
        )
    }
}
