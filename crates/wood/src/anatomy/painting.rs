//! Pictures of sections: contour, rings and tissues.
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
use std::ops::Range;

/// Fewest pixels along the sides of pictures of sections, and most along those of the grid of which they show a part.
const MIN_SECTION_PIXELS: usize = 640;
const MAX_GRID_PIXELS: usize = 4096;
/// Width of a picture over that of its section.
const PICTURE_MARGIN: f64 = 1.06;
/// Samples along each side of a pixel where wood is shown.
const SAMPLES_PER_SIDE: usize = 2;
/// Linear colour of the paper.
pub(super) const PAPER: DVec3 = DVec3::splat(0.93);

/// A picture whose scale is known.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaledImage {
    /// The picture.
    pub image: RgbImage,
    /// Side of a pixel, m.
    pub pixel: f64,
}

/// Pictures of one section, with its y upwards, of the same scale.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionPictures {
    /// Side of a pixel, m.
    pub pixel: f64,
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
        let (low, high) = bounds(section);
        let share = PICTURE_MARGIN * (high - low).max_element() / voxels.side();
        let (grid, zoom) = if self.is_eroded() {
            let crop = Crop::around(section, voxels);
            (*voxels, MIN_SECTION_PIXELS.div_ceil(crop.x.len().max(1)))
        } else {
            let count = (MIN_SECTION_PIXELS as f64 / share).ceil() as usize;
            let count = count.clamp(MIN_SECTION_PIXELS, MAX_GRID_PIXELS);
            (voxels.resampled(voxels.count.max(count)), 1)
        };
        let crop = Crop::around(section, &grid);
        let raster = self.rasterize(section, &grid, context)?;
        context.check()?;
        let paint = |colour: &dyn Fn(u16) -> [u8; 3]| paint_passes(&raster, &crop, zoom, colour);
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
            self.paint_wood(section, &grid, &crop, context)?
        };
        Ok(SectionPictures {
            pixel: grid.pixel / zoom as f64,
            contour,
            rings,
            tissues,
        })
    }

    /// Paints the wood of a section within a crop of the grid.
    fn paint_wood(
        &self,
        section: &TransverseSection,
        grid: &PixelGrid,
        crop: &Crop,
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
        let rows: Vec<Vec<u8>> = (crop.y.clone())
            .into_par_iter()
            .rev()
            .map(|y| {
                context.check()?;
                Ok(crop.x.clone().flat_map(|x| colour(x, y)).collect())
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(RgbImage {
            width: crop.x.len() as u32,
            height: crop.y.len() as u32,
            rgb: rows.concat(),
        })
    }

    /// Linear colour of the wood at a point of a section, m.
    pub(super) fn colour_at(
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
        let point = WoodPoint {
            address,
            end_grain,
            facing: DVec2::ZERO,
        };
        let surface = (self.wood()).surface_at(self.rings(), &point, footprint);
        DVec3::from_array(surface.color)
    }
}

/// How a painted face cuts the grain.
#[derive(Debug, Clone, Copy)]
pub(super) enum CutFace {
    Across,
    Along,
}

/// The part of a section's grid that a picture shows: the section with some paper around it.
struct Crop {
    x: Range<usize>,
    y: Range<usize>,
}

impl Crop {
    /// The square about a section's outline.
    fn around(section: &TransverseSection, grid: &PixelGrid) -> Self {
        let (low, high) = bounds(section);
        let [low, high] = [low, high].map(|p| grid.to_pixels(p));
        let side = (PICTURE_MARGIN * (high - low).max_element()).min(grid.count as f64);
        let range = |low: f64, high: f64| {
            let start = (0.5 * (low + high - side)).clamp(0.0, grid.count as f64 - side);
            start.floor() as usize..(start + side).ceil() as usize
        };
        Crop {
            x: range(low.x, high.x),
            y: range(low.y, high.y),
        }
    }
}

/// The corners of the box about a section's outline, m.
fn bounds(section: &TransverseSection) -> (DVec2, DVec2) {
    let points = || section.outline.loops.iter().flatten();
    (
        points().fold(DVec2::INFINITY, |a, &p| a.min(p)),
        points().fold(DVec2::NEG_INFINITY, |a, &p| a.max(p)),
    )
}

/// Paints the passes of a section within a crop, each pixel as `zoom` × `zoom`.
fn paint_passes(
    raster: &SectionRaster,
    crop: &Crop,
    zoom: usize,
    colour: &dyn Fn(u16) -> [u8; 3],
) -> RgbImage {
    let mut rgb = Vec::with_capacity(3 * crop.x.len() * crop.y.len() * zoom * zoom);
    for y in crop.y.clone().rev() {
        let row: Vec<u8> = (crop.x.clone())
            .flat_map(|x| colour(raster.pass(x, y)).repeat(zoom))
            .collect();
        (0..zoom).for_each(|_| rgb.extend_from_slice(&row));
    }
    RgbImage {
        width: (crop.x.len() * zoom) as u32,
        height: (crop.y.len() * zoom) as u32,
        rgb,
    }
}
