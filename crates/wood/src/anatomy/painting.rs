//! Pictures of the inside: sections as contour, rings and tissues, and the longitudinal section of Forests 2023, Fig. 9.
//!
//! Rings are those of the data, ring by ring; streaks, vessels and rays between them come from the appearance of the wood.

use super::model::Anatomy;
use super::palette::{RingColouring, TISSUE_COLOURS, published};
use super::section_raster::SectionRaster;
use super::sections::TransverseSection;
use crate::appearance::WoodPoint;
use crate::colour::{RgbImage, linear_from_srgb, srgb_bytes};
use crate::raster::{PixelGrid, fill_loops};
use crate::rings::{RingSource, StemAddress};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;

/// Fewest pixels along the sides of pictures of sections.
const MIN_SECTION_PIXELS: usize = 640;
/// The longitudinal picture: fewest pixels across the stem, and most along it.
const MIN_PIXELS_ACROSS: usize = 256;
const MAX_PIXELS_ALONG: usize = 3000;
/// Columns of the longitudinal picture between two reports of progress.
const COLUMNS_PER_REPORT: usize = 64;
/// Samples along each side of a pixel where wood is shown.
const SAMPLES_PER_SIDE: usize = 2;
/// Linear colour of the paper.
const PAPER: DVec3 = DVec3::splat(0.93);

/// Pictures of one section, with its y upwards.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SectionPictures {
    /// The wood in white.
    pub contour: RgbImage,
    /// The rings.
    pub rings: RgbImage,
    /// The tissues.
    pub tissues: RgbImage,
}

impl Anatomy<'_> {
    /// Paints a section.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint_section(
        &self,
        section: &TransverseSection,
        context: &Context,
    ) -> Result<SectionPictures, Cancelled> {
        let voxels = &self.sections().grid;
        // Eroded rings are those of the voxels, shown as squares.
        let (grid, zoom) = if self.is_eroded() {
            (*voxels, MIN_SECTION_PIXELS.div_ceil(voxels.count))
        } else {
            (voxels.resampled(voxels.count.max(MIN_SECTION_PIXELS)), 1)
        };
        let raster = self.rasterize(section, &grid, context)?;
        context.check()?;
        let paint = |colour: &dyn Fn(u16) -> [u8; 3]| paint_passes(&raster, zoom, colour);
        let contour = paint(&|pass| [u8::from(pass != 0) * 255; 3]);
        let tissues = paint(&|pass| match pass {
            0 => [255; 3],
            pass => TISSUE_COLOURS[usize::from(raster.legend.of(pass).tissue.code())],
        });
        context.check()?;
        let rings = if self.is_eroded() {
            let paper = srgb_bytes(PAPER);
            paint(&|pass| match pass {
                0 => paper,
                pass => raster.palette[usize::from(pass)],
            })
        } else {
            self.paint_wood(section, &grid, context)?
        };
        Ok(SectionPictures {
            contour,
            rings,
            tissues,
        })
    }

    /// Paints the wood of a section.
    fn paint_wood(
        &self,
        section: &TransverseSection,
        grid: &PixelGrid,
        context: &Context,
    ) -> Result<RgbImage, Cancelled> {
        const SAMPLES: usize = SAMPLES_PER_SIDE * SAMPLES_PER_SIDE;
        let fine = PixelGrid {
            count: grid.count * SAMPLES_PER_SIDE,
            pixel: grid.pixel / SAMPLES_PER_SIDE as f64,
        };
        let wood = fill_loops(&fine, &section.outline.loops);
        let colour = |x: usize, y: usize| {
            let mut sum = DVec3::ZERO;
            for k in 0..SAMPLES {
                let u = SAMPLES_PER_SIDE * x + k % SAMPLES_PER_SIDE;
                let v = SAMPLES_PER_SIDE * y + k / SAMPLES_PER_SIDE;
                sum += if wood.get(u, v) {
                    self.colour_at(
                        section,
                        fine.pixel_centre(u, v),
                        CutFace::Across,
                        fine.pixel,
                    )
                } else {
                    PAPER
                };
            }
            srgb_bytes(sum / SAMPLES as f64)
        };
        let rows: Vec<Vec<u8>> = (0..grid.count)
            .into_par_iter()
            .rev()
            .map(|y| {
                context.check()?;
                Ok((0..grid.count).flat_map(|x| colour(x, y)).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(RgbImage {
            width: grid.count as u32,
            height: grid.count as u32,
            rgb: rows.concat(),
        })
    }

    /// Linear colour of the wood at a point of a section, m.
    fn colour_at(
        &self,
        section: &TransverseSection,
        p: DVec2,
        face: CutFace,
        footprint: f64,
    ) -> DVec3 {
        let (rho, angle) = section.field.address(p);
        let address = StemAddress {
            rho: rho.min(1.0),
            angle,
            across: p - section.field.pith(),
            along: section.length,
        };
        let Some(ring) = self.rings().ring_at(&address) else {
            return PAPER;
        };
        if self.colouring() == RingColouring::Published {
            return DVec3::from_array(linear_from_srgb(published(ring.part)));
        }
        let end_grain = match face {
            CutFace::Across => 1.0,
            CutFace::Along => 0.0,
        };
        let point = WoodPoint { address, end_grain };
        let surface = (self.wood()).surface_at(self.rings(), &point, footprint);
        DVec3::from_array(surface.color)
    }

    /// Paints the stem cut in half along its pith, straightened, the base on the left.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paint_longitudinal(&self, context: &Context) -> Result<RgbImage, Cancelled> {
        let grid = &self.sections().grid;
        let length = self.sections().length();
        let pixel = (grid.side() / grid.count.max(MIN_PIXELS_ACROSS) as f64)
            .max(length / MAX_PIXELS_ALONG as f64);
        let scale = LongitudinalScale {
            height: (grid.side() / pixel).round().max(1.0) as usize,
            pixel,
        };
        let width = (length / pixel).round().max(1.0) as usize;
        let mut columns: Vec<Vec<[u8; 3]>> = Vec::with_capacity(width);
        for start in (0..width).step_by(COLUMNS_PER_REPORT) {
            context.report(start as f64 / width as f64)?;
            let batch: Vec<Vec<[u8; 3]>> = (start..width.min(start + COLUMNS_PER_REPORT))
                .into_par_iter()
                .map(|k| {
                    let along = length * (k as f64 + 0.5) / width as f64;
                    self.paint_column(along, &scale, context)
                })
                .collect::<Result<_, Cancelled>>()?;
            columns.extend(batch);
        }
        let rgb = (0..scale.height)
            .rev()
            .flat_map(|y| columns.iter().flat_map(move |column| column[y]))
            .collect();
        Ok(RgbImage {
            width: width as u32,
            height: scale.height as u32,
            rgb,
        })
    }

    /// A column of the longitudinal picture, the lowest pixel first: the line through the pith along the section's x.
    fn paint_column(
        &self,
        length: f64,
        scale: &LongitudinalScale,
        context: &Context,
    ) -> Result<Vec<[u8; 3]>, Cancelled> {
        context.check()?;
        let paper = srgb_bytes(PAPER);
        let Some(section) = self.sections().section(length) else {
            return Ok(vec![paper; scale.height]);
        };
        // A board's pith may lie outside of it.
        let level = if self.is_board() {
            section.outline.centroid.y
        } else {
            section.field.pith().y
        };
        if self.is_eroded() {
            let raster = self.rasterize(&section, &self.sections().grid, context)?;
            return Ok(paint_eroded_column(&raster, level, scale));
        }
        let crossings = crossings(&section.outline.loops, level);
        let footprint = scale.pixel / SAMPLES_PER_SIDE as f64;
        let colour = |x: f64| {
            let inside = crossings.partition_point(|&c| c < x) % 2 == 1;
            if !inside {
                return paper;
            }
            let mut sum = DVec3::ZERO;
            for k in 0..SAMPLES_PER_SIDE {
                let offset = ((k as f64 + 0.5) / SAMPLES_PER_SIDE as f64 - 0.5) * scale.pixel;
                let p = DVec2::new(x + offset, level);
                sum += self.colour_at(&section, p, CutFace::Along, footprint);
            }
            srgb_bytes(sum / SAMPLES_PER_SIDE as f64)
        };
        Ok((0..scale.height).map(|y| colour(scale.x(y))).collect())
    }
}

/// How a painted face cuts the grain.
#[derive(Debug, Clone, Copy)]
enum CutFace {
    Across,
    Along,
}

/// The pixels of the longitudinal picture.
struct LongitudinalScale {
    /// Pixels across the stem.
    height: usize,
    /// Side of a pixel, m.
    pixel: f64,
}

impl LongitudinalScale {
    /// The section's x of the middle of pixel `y` from the bottom, m.
    fn x(&self, y: usize) -> f64 {
        (y as f64 + 0.5 - 0.5 * self.height as f64) * self.pixel
    }
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

/// A column of the longitudinal picture from eroded rings.
fn paint_eroded_column(
    raster: &SectionRaster,
    level: f64,
    scale: &LongitudinalScale,
) -> Vec<[u8; 3]> {
    let grid = &raster.grid;
    let index = |v: f64| {
        let i = (v / grid.pixel + 0.5 * grid.count as f64).max(0.0) as usize;
        i.min(grid.count - 1)
    };
    let row = index(level);
    (0..scale.height)
        .map(|y| match raster.pass(index(scale.x(y)), row) {
            0 => srgb_bytes(PAPER),
            pass => raster.palette[usize::from(pass)],
        })
        .collect()
}

/// Paints the passes of a section, each pixel as `zoom` × `zoom`.
fn paint_passes(raster: &SectionRaster, zoom: usize, colour: &dyn Fn(u16) -> [u8; 3]) -> RgbImage {
    let count = raster.grid.count * zoom;
    let rgb = (0..count)
        .rev()
        .flat_map(|y| (0..count).map(move |x| (x, y)))
        .flat_map(|(x, y)| colour(raster.pass(x / zoom, y / zoom)))
        .collect();
    RgbImage {
        width: count as u32,
        height: count as u32,
        rgb,
    }
}
