//! A stem's sections with their rings: from the ring field, or eroded as published (Forests 2023 §3.3).

use super::error::AnatomyError;
use super::palette::{RingColouring, palette};
use super::passes::{PassLegend, passes_of_rings};
use super::section_raster::SectionRaster;
use super::sections::{StemSections, TransverseSection};
use crate::appearance::WoodAppearance;
use crate::raster::{PixelGrid, fill_loops};
use crate::rings::{
    ConcentricRings, ErodedPasses, Erosion, ErosionFronts, RingDivision, ring_numbers,
};
use crate::stem::FoundStem;
use crate::tissue::{Proportions, Zone};
use greenstick_geometry::{Bitmap, Cancelled, Context, Mesh};
use rayon::prelude::*;
use std::borrow::Cow;
use std::fmt;

/// Where rings come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum RingMethod {
    /// The continuous field, of any number of rings, whatever the resolution.
    #[default]
    Field,
    /// Erosion of the voxels, as published. The schedule and the resolution make the number of rings.
    Erosion(Erosion),
}

impl fmt::Display for RingMethod {
    /// `field`, or `erosion` with its schedule and its circle.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RingMethod::Field => f.write_str("field"),
            RingMethod::Erosion(erosion) => erosion.fmt(f),
        }
    }
}

/// How the inside of a stem is made.
#[derive(Debug, Clone, PartialEq)]
pub struct AnatomyOptions {
    /// Voxels along each side of a segment, in [`super::RESOLUTION_RANGE`].
    pub resolution: usize,
    /// Where rings come from.
    pub rings: RingMethod,
    /// How the years divide the radius; an erosion makes its own rings.
    pub division: RingDivision,
    /// Colours of rings.
    pub colouring: RingColouring,
    /// The part of the radius that each tissue takes.
    pub proportions: Proportions,
    /// By which root mean square distance (m) outlines of sections are smoothed at most; not at all where absent.
    pub smoothing: Option<f64>,
}

impl Default for AnatomyOptions {
    fn default() -> Self {
        AnatomyOptions {
            resolution: 128,
            rings: RingMethod::Field,
            division: RingDivision::Even(14),
            colouring: RingColouring::Wood,
            proportions: Proportions {
                pith: 0.05,
                heartwood: 0.3,
                phloem: 0.1,
            },
            smoothing: None,
        }
    }
}

/// Sections along the stem in which eroded rings are counted beforehand.
const COUNTED_SECTIONS: usize = 96;

/// The inside of a stem.
#[derive(Debug, Clone)]
pub struct Anatomy<'a> {
    sections: StemSections<'a>,
    /// The erosion that rings come from, where they come from one.
    fronts: Option<ErosionFronts>,
    /// Rings by the field; of an erosion as many even ones as it makes at most.
    rings: ConcentricRings,
    /// The wood between rings.
    wood: WoodAppearance,
    colouring: RingColouring,
    proportions: Proportions,
    /// The passes of `rings`.
    legend: PassLegend,
    /// Colour of each of these passes, sRGB.
    palette: Vec<[u8; 3]>,
}

impl<'a> Anatomy<'a> {
    /// The inside of a stem found in `mesh`, which is in world metres; `wood` gives the colours and what is between rings.
    ///
    /// # Errors
    /// [`AnatomyError`] where no section can be made, or not with such options.
    pub fn new(
        found: &'a FoundStem,
        mesh: &Mesh,
        options: &AnatomyOptions,
        wood: WoodAppearance,
        context: &Context,
    ) -> Result<Self, AnatomyError> {
        let fronts = match &options.rings {
            RingMethod::Field => None,
            RingMethod::Erosion(erosion) => Some(erosion.fronts(options.resolution)?),
        };
        let sections = StemSections::new(found, mesh, options.resolution, context)?
            .smoothed(options.smoothing);
        let is_board = sections.stem().kind.is_sawn();
        let eroded;
        let division = match &fronts {
            None => &options.division,
            Some(_) if is_board => return Err(AnatomyError::BoardErosion),
            Some(fronts) => {
                eroded = RingDivision::Even(count_eroded_rings(&sections, fronts, context)?);
                &eroded
            }
        };
        let rings = division.rings(&found.stem.rings, &options.proportions, is_board)?;
        let legend = PassLegend::of_rings(&rings);
        Ok(Anatomy {
            palette: palette(&wood, options.colouring, &legend),
            sections,
            fronts,
            rings,
            wood,
            colouring: options.colouring,
            proportions: options.proportions,
            legend,
        })
    }

    /// The stem's sections.
    pub fn sections(&self) -> &StemSections<'a> {
        &self.sections
    }

    /// Number of rings; by erosion that of the section with most.
    pub fn ring_count(&self) -> u16 {
        self.legend.rings
    }

    /// Whether rings come from an erosion.
    pub fn is_eroded(&self) -> bool {
        self.fronts.is_some()
    }

    /// Whether the stem is a board.
    pub fn is_board(&self) -> bool {
        self.sections.stem().kind.is_sawn()
    }

    /// The rings by whose ring coordinates the field is divided.
    pub(super) fn rings(&self) -> &ConcentricRings {
        &self.rings
    }

    /// Ring coordinate at which the wood ends and inner bark begins; 1 in a board, which has no bark.
    pub(super) fn cambium(&self) -> f64 {
        if self.is_board() {
            return 1.0;
        }
        let end = self.end_of(Zone::Sapwood);
        end.unwrap_or(1.0 - self.proportions.phloem)
    }

    /// Ring coordinate at which the heartwood ends; 0 without any.
    pub(super) fn heartwood_edge(&self) -> f64 {
        self.end_of(Zone::Heartwood).unwrap_or(0.0)
    }

    /// Where the last ring of a tissue, or of one within it, ends.
    fn end_of(&self, tissue: Zone) -> Option<f64> {
        let rings = self.rings.edges().iter().zip(self.rings.tissues());
        let mut within = rings.filter(|(_, t)| **t <= tissue);
        within.next_back().map(|(edge, _)| *edge)
    }

    /// What the wood looks like between rings.
    pub(super) fn wood(&self) -> &WoodAppearance {
        &self.wood
    }

    /// Colours of rings.
    pub(super) fn colouring(&self) -> RingColouring {
        self.colouring
    }

    /// Colour of the latewood of each ring from the pith, sRGB.
    pub(super) fn ring_colours(&self) -> Vec<[u8; 3]> {
        let latewood_pass = |ring: u16| usize::from(2 * (self.legend.rings - ring) + 1);
        (1..=self.legend.rings)
            .map(|ring| self.palette[latewood_pass(ring)])
            .collect()
    }

    /// The pixels of a section on a grid. Eroded rings are as wide as the grid's pixels make them.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn rasterize(
        &self,
        section: &TransverseSection,
        grid: &PixelGrid,
        context: &Context,
    ) -> Result<SectionRaster<'_>, Cancelled> {
        let wood = fill_loops(grid, &section.outline.loops);
        let (passes, legend, palette) = match &self.fronts {
            None => (
                passes_of_rings(grid, &wood, &section.field, &self.rings),
                Cow::Borrowed(&self.legend),
                Cow::Borrowed(&*self.palette),
            ),
            Some(fronts) => {
                let eroded = erode_section(fronts, &wood, section, grid, context)?;
                let most = self.legend.rings;
                let legend = PassLegend::of_erosion(&eroded.parts, most, &self.proportions);
                let last = eroded.parts.len() as u16;
                let mut passes = eroded.passes;
                // What no pass took, which no published schedule leaves, is the pith's.
                passes.iter_mut().for_each(|pass| *pass = (*pass).min(last));
                let palette = palette(&self.wood, self.colouring, &legend);
                (passes, Cow::Owned(legend), Cow::Owned(palette))
            }
        };
        Ok(SectionRaster {
            grid: *grid,
            wood,
            passes,
            legend,
            palette,
            pith: section.field.pith(),
        })
    }
}

/// The passes of an erosion of a section.
fn erode_section(
    fronts: &ErosionFronts,
    wood: &Bitmap,
    section: &TransverseSection,
    grid: &PixelGrid,
    context: &Context,
) -> Result<ErodedPasses, Cancelled> {
    let pith = grid.to_pixel_centres(section.field.pith());
    let radius = section.outline.mean_radius() / grid.pixel;
    fronts.passes(wood, pith, radius, context)
}

/// The largest number of rings that an erosion makes in a section of the stem.
fn count_eroded_rings(
    sections: &StemSections,
    fronts: &ErosionFronts,
    context: &Context,
) -> Result<u16, Cancelled> {
    let grid = &sections.grid;
    let count = |k: usize| -> Result<u16, Cancelled> {
        context.check()?;
        let length = sections.length() * (k as f64 + 0.5) / COUNTED_SECTIONS as f64;
        let Some(section) = sections.section(length) else {
            return Ok(0);
        };
        let wood = fill_loops(grid, &section.outline.loops);
        let eroded = erode_section(fronts, &wood, &section, grid, context)?;
        let numbers = ring_numbers(eroded.parts.into_iter());
        Ok(numbers.last().copied().unwrap_or(0))
    };
    let counts: Vec<u16> = (0..COUNTED_SECTIONS)
        .into_par_iter()
        .map(count)
        .collect::<Result<_, _>>()?;
    Ok(counts.into_iter().max().unwrap_or(0).max(1))
}
