//! The longitudinal section of Forests 2023, Fig. 9: the stem cut in half along its pith and straightened.
//!
//! Sections that the stem's ends cut are left out, as the shape of rings cannot be told from them. A stem is much longer than wide. Its picture is therefore divided into strips, one below the other like lines of text, the
//! base at the upper left. Rings that are narrower than two pixels would make patterns with the pixels that look like knots;
//! each pixel is therefore the mean of several points, weighted by their distance from its middle.

use super::model::Anatomy;
use super::painting::{CutFace, PAPER, ScaledImage};
use super::section_raster::SectionRaster;
use super::sections::TransverseSection;
use crate::colour::{RgbImage, linear_from_srgb, srgb_bytes};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;

/// Width over height of the picture, about, and most strips.
const ASPECT: f64 = 1.6;
const MAX_STRIPS: f64 = 16.0;
/// Fewest pixels across the stem; a short stem has as many as make a strip this wide.
const MIN_PIXELS_ACROSS: f64 = 256.0;
const MIN_STRIP_PIXELS: f64 = 1400.0;
/// Most pixels along a strip, which go before those across.
const MAX_STRIP_PIXELS: f64 = 2400.0;
/// Sections in which the width of the stem is measured, for each strip.
const PROFILES_PER_STRIP: usize = 24;
/// Room around the stem in a strip, in its largest widths.
const STRIP_MARGIN: f64 = 0.04;
/// Points on the width of a ring or a voxel, and fewest and most on that of a pixel.
const POINTS_PER_RING: f64 = 4.0;
const POINTS_PER_VOXEL: f64 = 2.0;
const POINTS_PER_PIXEL: (usize, usize) = (2, 12);
/// Columns between two reports of progress.
const COLUMNS_PER_REPORT: usize = 64;

/// A part of the stem's length in the picture.
struct Strip {
    /// Where it begins and ends along the centreline, m.
    range: (f64, f64),
    /// Columns of pixels.
    width: usize,
    /// Rows of pixels.
    height: usize,
    /// The sections' x at the lower edge, m.
    low: f64,
}

/// Measures of the whole picture.
struct Layout {
    /// Side of a pixel, m.
    pixel: f64,
    /// Points on the width of a pixel.
    points: usize,
    strips: Vec<Strip>,
}

impl Anatomy<'_> {
    /// Paints the stem cut in half along its pith, straightened, in strips from the base on.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint_longitudinal(&self, context: &Context) -> Result<ScaledImage, Cancelled> {
        let layout = self.longitudinal_layout(context)?;
        let total: usize = layout.strips.iter().map(|s| s.width).sum();
        let width = layout.strips.iter().map(|s| s.width).max().unwrap_or(0);
        let paper = srgb_bytes(PAPER);
        let mut rgb: Vec<u8> = Vec::new();
        let mut height = 0;
        let mut done = 0;
        for strip in &layout.strips {
            let mut columns: Vec<Vec<[u8; 3]>> = Vec::with_capacity(strip.width);
            for start in (0..strip.width).step_by(COLUMNS_PER_REPORT) {
                context.report((done + start) as f64 / total as f64)?;
                let batch: Vec<Vec<[u8; 3]>> = (start..strip.width.min(start + COLUMNS_PER_REPORT))
                    .into_par_iter()
                    .map(|k| {
                        let (from, to) = strip.range;
                        let along = from + (to - from) * (k as f64 + 0.5) / strip.width as f64;
                        self.paint_column(along, strip, &layout, context)
                    })
                    .collect::<Result<_, Cancelled>>()?;
                columns.extend(batch);
            }
            for y in (0..strip.height).rev() {
                rgb.extend(columns.iter().flat_map(|column| column[y]));
                rgb.extend(paper.repeat(width - strip.width));
            }
            height += strip.height;
            done += strip.width;
        }
        Ok(ScaledImage {
            image: RgbImage {
                width: width as u32,
                height: height as u32,
                rgb,
            },
            pixel: layout.pixel,
        })
    }

    /// Divides the stem into strips.
    fn longitudinal_layout(&self, context: &Context) -> Result<Layout, Cancelled> {
        let (start, end) = self.sections().whole;
        let length = end - start;
        let count = PROFILES_PER_STRIP * MAX_STRIPS as usize;
        let profile: Vec<Option<(f64, f64)>> = (0..count)
            .into_par_iter()
            .map(|k| {
                context.check()?;
                let along = start + length * (k as f64 + 0.5) / count as f64;
                let section = self.sections().section(along);
                Ok(section.and_then(|section| {
                    let crossings = crossings(&section.outline.loops, self.level(&section));
                    Some((*crossings.first()?, *crossings.last()?))
                }))
            })
            .collect::<Result<_, Cancelled>>()?;
        let span = |range: std::ops::Range<usize>| {
            (profile[range].iter().flatten()).fold(
                (f64::INFINITY, f64::NEG_INFINITY),
                |(low, high), &(a, b)| (low.min(a), high.max(b)),
            )
        };
        let widest = (profile.iter().flatten().map(|(low, high)| high - low))
            .fold(self.sections().grid.pixel, f64::max);
        let strips = (length / (ASPECT * widest)).sqrt().round();
        let strips = strips.clamp(1.0, MAX_STRIPS) as usize;
        let strip_length = length / strips as f64;
        let pixel = (widest / MIN_PIXELS_ACROSS)
            .min(strip_length / MIN_STRIP_PIXELS)
            .max(strip_length / MAX_STRIP_PIXELS);
        let margin = STRIP_MARGIN * widest;
        let strip = |k: usize| {
            // One profile more on each side, as ends lie between them.
            let profiles = |k: usize| k * count / strips;
            let (low, high) = span(profiles(k).saturating_sub(1)..(profiles(k + 1) + 1).min(count));
            let (low, high) = if low < high {
                (low, high)
            } else {
                (0.0, widest)
            };
            Strip {
                range: (
                    start + strip_length * k as f64,
                    start + strip_length * (k + 1) as f64,
                ),
                width: (strip_length / pixel).round().max(1.0) as usize,
                height: ((high - low + 2.0 * margin) / pixel).ceil() as usize,
                low: low - margin,
            }
        };
        let fineness = if self.is_eroded() {
            POINTS_PER_VOXEL / self.sections().grid.pixel
        } else {
            POINTS_PER_RING * f64::from(self.ring_count()) / self.sections().stem().radius
        };
        let (fewest, most) = POINTS_PER_PIXEL;
        Ok(Layout {
            pixel,
            points: ((fineness * pixel).ceil() as usize).clamp(fewest, most),
            strips: (0..strips).map(strip).collect(),
        })
    }

    /// The y of the cut in a section, m: that of the pith. A board's may lie outside of it.
    fn level(&self, section: &TransverseSection) -> f64 {
        if self.is_board() {
            section.outline.centroid.y
        } else {
            section.field.pith().y
        }
    }

    /// A column of a strip, the lowest pixel first: the line through the pith along the section's x.
    fn paint_column(
        &self,
        length: f64,
        strip: &Strip,
        layout: &Layout,
        context: &Context,
    ) -> Result<Vec<[u8; 3]>, Cancelled> {
        context.check()?;
        let paper = srgb_bytes(PAPER);
        let Some(section) = self.sections().section(length) else {
            return Ok(vec![paper; strip.height]);
        };
        let level = self.level(&section);
        let spacing = layout.pixel / layout.points as f64;
        // Half a pixel more below and above, for the outermost pixels' means.
        let count = (strip.height + 1) * layout.points;
        let x = |k: usize| strip.low + (k as f64 + 0.5) * spacing - 0.5 * layout.pixel;
        let points: Vec<DVec3> = if self.is_eroded() {
            let raster = self.rasterize(&section, &self.sections().grid, context)?;
            let row = VoxelRow::new(&raster, level);
            (0..count).map(|k| row.colour(x(k))).collect()
        } else {
            let crossings = crossings(&section.outline.loops, level);
            let colour = |x: f64| {
                if crossings.partition_point(|&c| c < x).is_multiple_of(2) {
                    return PAPER;
                }
                let p = DVec2::new(x, level);
                self.colour_at(&section, p, CutFace::Along, 0.5 * layout.pixel)
            };
            (0..count).map(|k| colour(x(k))).collect()
        };
        Ok(tent_filter(&points, layout.points)
            .map(srgb_bytes)
            .collect())
    }
}

/// Means of `points`, `per_pixel` to a pixel, with weights that fall linearly over a pixel to both sides of its middle. A
/// box would let rings a little narrower than a pixel through as a coarse pattern. `points` begin half a pixel before the
/// first pixel and end half a pixel after the last.
fn tent_filter(points: &[DVec3], per_pixel: usize) -> impl Iterator<Item = DVec3> {
    let half = per_pixel as f64;
    let weights: Vec<f64> = (0..2 * per_pixel)
        .map(|k| 1.0 - (k as f64 + 0.5 - half).abs() / half)
        .collect();
    let sum: f64 = weights.iter().sum();
    points
        .windows(2 * per_pixel)
        .step_by(per_pixel)
        .map(move |window| {
            let weighted = window.iter().zip(&weights).map(|(c, w)| *c * *w);
            weighted.sum::<DVec3>() / sum
        })
}

/// The voxels of a section at the level of the cut, and those above and below, whose steps would show otherwise.
struct VoxelRow<'a> {
    raster: &'a SectionRaster<'a>,
    row: usize,
}

impl<'a> VoxelRow<'a> {
    fn new(raster: &'a SectionRaster<'a>, level: f64) -> Self {
        let row = index(raster, level).clamp(1, raster.grid.count.max(3) - 2);
        VoxelRow { raster, row }
    }

    /// Linear colour at x, m.
    fn colour(&self, x: f64) -> DVec3 {
        let column = index(self.raster, x);
        let colour = |row| match self.raster.pass(column, row) {
            0 => PAPER,
            pass => DVec3::from_array(linear_from_srgb(self.raster.palette[usize::from(pass)])),
        };
        0.25 * (colour(self.row - 1) + colour(self.row + 1)) + 0.5 * colour(self.row)
    }
}

/// The column or row of a coordinate, m.
fn index(raster: &SectionRaster, v: f64) -> usize {
    let grid = &raster.grid;
    let i = (v / grid.pixel + 0.5 * grid.count as f64).max(0.0) as usize;
    i.min(grid.count - 1)
}

/// Where the line at y = `level` crosses the loops: x, m, rising.
fn crossings(loops: &[Vec<DVec2>], level: f64) -> Vec<f64> {
    let mut crossings: Vec<f64> = Vec::new();
    for outline in loops {
        for (i, a) in outline.iter().enumerate() {
            let b = outline[(i + 1) % outline.len()];
            if (a.y <= level) != (b.y <= level) {
                crossings.push(a.x + (b.x - a.x) * (level - a.y) / (b.y - a.y));
            }
        }
    }
    crossings.sort_by(f64::total_cmp);
    crossings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_narrower_than_a_pixel_become_their_mean() {
        // Light and dark by turns, 0.9 to 0.3 pixels to a pair: a point in each pixel's middle would show beats from 0 to 1.
        for period in [0.9, 0.62, 0.31] {
            let per_pixel = (POINTS_PER_RING / period).ceil() as usize;
            let shade = |k: usize| {
                let at = k as f64 / per_pixel as f64 / period;
                DVec3::splat(f64::from(u8::from(at.fract() < 0.5)))
            };
            let points: Vec<DVec3> = (0..201 * per_pixel).map(shade).collect();
            let pixels: Vec<f64> = tent_filter(&points, per_pixel).map(|c| c.x).collect();
            assert_eq!(pixels.len(), 200);
            for shade in pixels {
                assert!((shade - 0.5).abs() < 0.12, "{period}: {shade}");
            }
        }
        // Wide ones keep their contrast.
        let points: Vec<DVec3> = (0..202)
            .map(|k| DVec3::splat(f64::from(u8::from(k / 2 % 8 < 4))))
            .collect();
        let (low, high) = tent_filter(&points, 2).fold((1.0, 0.0), |(low, high): (f64, f64), c| {
            (low.min(c.x), high.max(c.x))
        });
        assert!(low < 0.01 && high > 0.99, "{low} {high}");
    }
}
