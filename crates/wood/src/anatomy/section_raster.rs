//! A section as pixels: which are wood, and the pass of each.

use super::passes::PassLegend;
use crate::raster::PixelGrid;
use crate::rings::{RingPosition, RingSource, StemAddress};
use glam::DVec2;
use greenstick_geometry::Bitmap;
use std::borrow::Cow;

/// The pixels of a section. As a [`RingSource`] it answers for addresses in that section.
#[derive(Debug, Clone)]
pub struct SectionRaster<'a> {
    /// The grid of the pixels.
    pub grid: PixelGrid,
    /// Which pixels are wood.
    pub wood: Bitmap,
    /// The pass of each pixel, row by row; 0 where there is no wood.
    pub passes: Vec<u16>,
    /// What passes mean.
    pub legend: Cow<'a, PassLegend>,
    /// Colour of each pass, sRGB.
    pub palette: Cow<'a, [[u8; 3]]>,
    /// The pith, m.
    pub pith: DVec2,
}

impl SectionRaster<'_> {
    /// The pass of pixel (x, y).
    pub fn pass(&self, x: usize, y: usize) -> u16 {
        self.passes[y * self.grid.count + x]
    }

    /// The pass at a point of the section, m; 0 outside of the grid.
    pub fn pass_at(&self, p: DVec2) -> u16 {
        let at = self.grid.to_pixels(p).floor();
        if at.min_element() < 0.0 || at.max_element() >= self.grid.count as f64 {
            return 0;
        }
        self.pass(at.x as usize, at.y as usize)
    }
}

impl RingSource for SectionRaster<'_> {
    fn ring_count(&self) -> usize {
        self.legend.rings.into()
    }

    /// The fraction and the width of a ring are by its number of passes.
    fn ring_at(&self, at: &StemAddress) -> Option<RingPosition> {
        let pass = usize::from(self.pass_at(self.pith + at.across));
        if pass == 0 {
            return None;
        }
        let passes = &self.legend.passes;
        let meaning = passes[pass];
        let same_ring = |p: &&super::passes::PassMeaning| p.ring == meaning.ring;
        // Passes are numbered inwards, fractions rise outwards.
        let outside = passes[1..pass].iter().rev().take_while(same_ring).count();
        let inside = passes[pass + 1..].iter().take_while(same_ring).count();
        let count = (outside + 1 + inside) as f64;
        Some(RingPosition {
            ring: meaning.ring.into(),
            fraction: (inside as f64 + 0.5) / count,
            width: count / (passes.len() - 1) as f64,
            part: meaning.part,
            tissue: meaning.tissue,
        })
    }
}
