//! The rings of a section as pixels: from the ring field, or eroded as published (forests-2023 §3.3).
//!
//! Eroded rings are counted from the bark inwards, so that the outermost is the same year all along the stem and slimmer
//! sections lack the first years, as in a tree. Tissues go by each section's own number of rings.

use super::{RingColours, Work, paint};
use crate::Error;
use crate::erosion::{Erosion, Fronts};
use glam::DVec2;
use greenstick_geometry::Bitmap;
use greenstick_wood::anatomy::{Anatomy, Grid, RingNumbers, Section, field_passes, fill};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::rings::{self, Kind};
use greenstick_wood::stem::StemKind;
use greenstick_wood::tissue::Proportions;
use rayon::prelude::*;
use std::borrow::Cow;

/// Where rings come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum RingsBy {
    /// The continuous field, of any number of rings, whatever the resolution.
    #[default]
    Field,
    /// Erosion of the voxels, as published. The schedule and the resolution make the number of rings.
    Erosion(Erosion),
}

/// Sections along the stem in which rings are counted beforehand.
const COUNTED: usize = 96;

impl RingsBy {
    /// `field`, or `erosion` with its schedule and its circle.
    pub(super) fn name(&self) -> String {
        match self {
            RingsBy::Field => "field".to_owned(),
            RingsBy::Erosion(erosion) => erosion.to_string(),
        }
    }

    /// The fronts of an erosion at a resolution.
    pub(super) fn fronts(&self, resolution: usize) -> Result<Option<Fronts>, Error> {
        match self {
            RingsBy::Field => Ok(None),
            RingsBy::Erosion(erosion) => match erosion.fronts(resolution) {
                Ok(fronts) => Ok(Some(fronts)),
                Err(error) => Err(Error::Amount(error.to_string())),
            },
        }
    }
}

/// The pass of every pixel of a section, row by row, and the kinds of passes 1 to the last.
fn passes(fronts: &Fronts, map: &Bitmap, section: &Section, grid: &Grid) -> (Vec<u16>, Vec<Kind>) {
    // The middle of pixel 0 lies half a pixel within the grid's edge.
    let edge = 0.5 * grid.count as f64 - 0.5;
    let pith = section.field.pith() / grid.pixel + DVec2::splat(edge);
    let radius = (section.outline.area / std::f64::consts::PI).sqrt() / grid.pixel;
    fronts.passes(map, pith, radius)
}

/// The largest number of rings that an erosion makes in a section of the stem.
pub(super) fn count_rings(anatomy: &Anatomy, fronts: &Fronts) -> Result<u16, Error> {
    if anatomy.stem().kind == StemKind::Board {
        return Err(Error::Amount(
            "rings of a board by erosion, which would follow its faces; expected a round stem, or rings by the field"
                .to_owned(),
        ));
    }
    let length = anatomy.stem().grain.axis().length();
    let most = (0..COUNTED)
        .into_par_iter()
        .filter_map(|k| anatomy.section(length * (k as f64 + 0.5) / COUNTED as f64))
        .map(|section| {
            let map = fill(&anatomy.grid, &section.outline.loops);
            let (_, kinds) = passes(fronts, &map, &section, &anatomy.grid);
            rings::rings_of(kinds.into_iter())
                .last()
                .copied()
                .unwrap_or(0)
        })
        .max();
    Ok(most.unwrap_or(0).max(1))
}

/// A section's pixels.
pub(super) struct Drawn<'a> {
    /// Which of them are wood.
    pub map: Bitmap,
    /// The pass of each, row by row; 0 where there is no wood.
    pub passes: Vec<u16>,
    /// What passes stand for.
    pub numbers: Cow<'a, RingNumbers>,
    /// Colour of each pass, sRGB.
    pub palette: Cow<'a, [[u8; 3]]>,
}

/// The look of passes.
pub(super) struct Look {
    pub wood: WoodAppearance,
    pub tissue: Proportions,
    pub colours: RingColours,
}

impl Work<'_> {
    /// The pixels of a section on a grid. Eroded rings are as wide as the grid's pixels make them.
    pub(super) fn drawn(&self, section: &Section, grid: &Grid) -> Drawn<'_> {
        let map = fill(grid, &section.outline.loops);
        let Some(fronts) = &self.erosion else {
            return Drawn {
                passes: field_passes(grid, &map, &section.field, self.anatomy.rings),
                map,
                numbers: Cow::Borrowed(&self.numbers),
                palette: Cow::Borrowed(&self.palette),
            };
        };
        let (mut passes, kinds) = passes(fronts, &map, section, grid);
        let last = kinds.len() as u16;
        for p in &mut passes {
            // What no pass took, which no published schedule leaves, is the pith's.
            *p = (*p).min(last);
        }
        let numbers = eroded(&kinds, self.anatomy.rings, &self.look.tissue);
        Drawn {
            map,
            passes,
            palette: Cow::Owned(paint::palette(&self.look, &numbers)),
            numbers: Cow::Owned(numbers),
        }
    }
}

/// What the passes of a section stand for in a stem of `most` rings.
fn eroded(kinds: &[Kind], most: u16, tissue: &Proportions) -> RingNumbers {
    let inwards = rings::rings_of(kinds.iter().copied());
    let own = inwards.last().copied().unwrap_or(0).max(1);
    // A section that was not counted beforehand may have more: those share the innermost number.
    let ring = |n: u16| {
        if n == 0 {
            0
        } else {
            most.saturating_sub(n - 1).max(1)
        }
    };
    let zone = |n: u16| tissue.zone_of_ring((own + 1 - n.max(1)).into(), own.into());
    RingNumbers {
        rings: most,
        ring: inwards.iter().map(|&n| ring(n)).collect(),
        zone: inwards.iter().map(|&n| zone(n)).collect(),
        latewood: std::iter::once(false)
            .chain(kinds.iter().map(|k| *k == Kind::Latewood))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_wood::tissue::Zone;

    #[test]
    fn eroded_rings_count_from_the_bark_and_tissues_by_the_section() {
        let tissue = Proportions {
            pith: 0.2,
            heartwood: 0.4,
            phloem: 0.1,
        };
        // 20 passes make 10 rings, in a stem of 12.
        let kinds = [Kind::Latewood, Kind::Earlywood].repeat(10);
        let numbers = eroded(&kinds, 12, &tissue);
        assert_eq!(
            (numbers.ring[0], numbers.ring[1], numbers.ring[2]),
            (0, 12, 12)
        );
        assert_eq!((numbers.ring[3], numbers.ring[20]), (11, 3));
        assert_eq!(
            (numbers.zone[1], numbers.zone[20]),
            (Zone::Bark, Zone::Pith)
        );
        // More rings than the stem was counted to have.
        let numbers = eroded(&kinds, 7, &tissue);
        assert_eq!(
            (numbers.ring[1], numbers.ring[13], numbers.ring[20]),
            (7, 1, 1)
        );
    }
}
