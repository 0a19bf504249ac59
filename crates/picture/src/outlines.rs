//! Outlines, followed from pixel to pixel.

use crate::error::PictureError;
use crate::resolve::{FIRST_RAYS, RAYS_FOR_ALL, Resolve, Resolved};
use greenstick_geometry::Context;
use rayon::prelude::*;

/// Most pixels over which an outline is followed from one in which rays found it, and how many pixels are resolved at once.
const MOST_FOLLOWED: usize = 16;
const FOLLOWED_AT_ONCE: usize = 1 << 14;

impl Resolve<'_> {
    /// Follows outlines from the pixels that have some to those beside them, and takes all rays there: a hair may be so thin that the
    /// middles of pixels, and the first rays of others, met it here and there only.
    ///
    /// # Errors
    /// [`PictureError`] if the caller asked to stop.
    pub fn follow_outlines(
        &self,
        pixels: &mut [Resolved],
        (context, progress): (&Context, f64),
    ) -> Result<(), PictureError> {
        if !(FIRST_RAYS + 1..RAYS_FOR_ALL).contains(&self.frame.samples) {
            return Ok(());
        }
        let width = self.frame.size[0];
        let mut is_known = vec![false; pixels.len()];
        let mut ends: Vec<usize> = (0..pixels.len())
            .filter(|i| pixels[*i].has_outline)
            .collect();
        for _ in 0..MOST_FOLLOWED {
            let beside = self.new_beside(&ends, &mut is_known);
            ends.clear();
            for some in beside.chunks(FOLLOWED_AT_ONCE) {
                context.report(progress)?;
                let resolved: Vec<Resolved> = (some.par_iter())
                    .map(|i| self.pixel([i % width, i / width], true))
                    .collect();
                for (i, resolved) in some.iter().zip(resolved) {
                    let before = std::mem::replace(&mut pixels[*i], resolved);
                    if resolved.has_outline && !before.has_outline {
                        ends.push(*i);
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the pixels next to some, and themselves, that are not known yet.
    fn new_beside(&self, some: &[usize], is_known: &mut [bool]) -> Vec<usize> {
        let [width, height] = self.frame.size;
        let mut beside = Vec::new();
        for pixel in some {
            let (x, y) = (pixel % width, pixel / width);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            for row in y.saturating_sub(1)..(y + 2).min(height) {
                let new = columns.clone().map(|column| row * width + column);
                beside.extend(new.filter(|i| !std::mem::replace(&mut is_known[*i], true)));
            }
        }
        beside
    }
}
