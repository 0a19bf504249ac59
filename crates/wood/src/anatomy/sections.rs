//! A stem's sections and segments (Forests 2023 §3.1): segments slightly longer than the stem is wide, so that N voxels
//! along one show a section as sharply as its length.

use super::error::AnatomyError;
use super::limits::{MAX_SEGMENTS, RESOLUTION_RANGE};
use super::outline::Outline;
use super::slicer::SectionSlicer;
use crate::polygon;
use crate::raster::PixelGrid;
use crate::rings::RingField;
use crate::stem::{Axis, FoundStem, Frame, Stem, StemKind};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context, Mesh};
use rayon::prelude::*;

/// How much wider than the stem a segment is, so that relief between the stations fits in.
const SEGMENT_MARGIN: f64 = 1.04;
/// Stations along the stem, for each of its radii, and the fewest and most.
const STATIONS_PER_RADIUS: f64 = 4.0;
const MIN_STATIONS: f64 = 48.0;
const MAX_STATIONS: f64 = 2000.0;
/// A section of less than this part of the area next to it is cut by the stem's end, which may stand at an angle.
const WHOLE_SECTION: f64 = 0.7;
/// The pith of a section lies this far from the outline at least, in mean radii.
const PITH_CLEARANCE_RADII: f64 = 0.1;

/// A part of the stem's length that is voxelised by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Where it begins and ends along the centreline, m.
    pub range: (f64, f64),
    /// Frame at its middle.
    pub frame: Frame,
    /// How far the centreline leaves the straight line through that frame at most, m.
    pub sagitta: f64,
}

/// A section square to the stem's centreline.
#[derive(Debug, Clone, PartialEq)]
pub struct TransverseSection {
    /// Length along the centreline, m.
    pub length: f64,
    /// Its frame; all that follows is in the frame's x and y.
    pub frame: Frame,
    /// Its outline.
    pub outline: Outline,
    /// The shape of its rings, about its pith.
    pub field: RingField,
}

impl TransverseSection {
    /// A point of the section, m, in the world.
    pub fn world(&self, p: DVec2) -> DVec3 {
        self.frame.origin + self.frame.x * p.x + self.frame.y * p.y
    }
}

/// A stem that can be cut into sections anywhere.
#[derive(Debug, Clone)]
pub struct StemSections<'a> {
    stem: &'a Stem,
    slicer: SectionSlicer,
    /// The pixels of every section.
    pub grid: PixelGrid,
    /// Segments from the base on.
    pub segments: Vec<Segment>,
    /// Between which lengths (m) sections are whole, not cut by the stem's ends.
    pub whole: (f64, f64),
    /// By which root mean square distance (m) outlines are smoothed at most.
    smoothing: Option<f64>,
}

/// A section that was tried along the stem.
struct SectionStation {
    /// m.
    length: f64,
    outline: Outline,
}

impl<'a> StemSections<'a> {
    /// The sections of a stem found in `mesh`, which is in world metres, with `resolution` voxels along each side of a
    /// segment.
    ///
    /// # Errors
    /// [`AnatomyError`] where no section can be made, or not with such a resolution.
    pub fn new(
        found: &'a FoundStem,
        mesh: &Mesh,
        resolution: usize,
        context: &Context,
    ) -> Result<Self, AnatomyError> {
        if !RESOLUTION_RANGE.contains(&resolution) {
            return Err(AnatomyError::Resolution(resolution));
        }
        let stem = &found.stem;
        let slicer = SectionSlicer::new(mesh, &found.shell, stem.kind == StemKind::Board);
        context.check()?;
        let axis = stem.grain.axis();
        let length = axis.length();
        let count = (STATIONS_PER_RADIUS * length / stem.radius)
            .ceil()
            .clamp(MIN_STATIONS, MAX_STATIONS) as usize;
        let stations = stations(&slicer, axis, count, context)?;
        let reach = stations
            .iter()
            .flat_map(|s| s.outline.points())
            .map(|p| p.abs().max_element())
            .fold(0.0, f64::max);
        if reach == 0.0 {
            return Err(AnatomyError::NoSections(count));
        }
        let side = 2.0 * SEGMENT_MARGIN * reach;
        let segments = (length / side).floor().max(1.0);
        if segments > MAX_SEGMENTS as f64 {
            return Err(AnatomyError::TooLong {
                length,
                width: 2.0 * reach,
                segments: segments as usize,
            });
        }
        let at = |k: f64| length * k / segments;
        Ok(StemSections {
            stem,
            slicer,
            grid: PixelGrid {
                count: resolution,
                pixel: side / resolution as f64,
            },
            segments: (0..segments as usize)
                .map(|k| segment(axis, (at(k as f64), at(k as f64 + 1.0))))
                .collect(),
            whole: whole_range(&stations, stem.radius, length),
            smoothing: None,
        })
    }

    /// The same with outlines that are smoothed by a root mean square distance of at most `tolerance` m, such as a scan's
    /// error. Boards keep their corners.
    #[must_use]
    pub fn smoothed(mut self, tolerance: Option<f64>) -> Self {
        self.smoothing = tolerance.filter(|_| self.stem.kind != StemKind::Board);
        self
    }

    /// The stem.
    pub fn stem(&self) -> &Stem {
        self.stem
    }

    /// Length of the centreline, m.
    pub fn length(&self) -> f64 {
        self.stem.grain.axis().length()
    }

    /// Distance of the sections of a segment, m.
    pub fn spacing(&self) -> f64 {
        self.length() / (self.segments.len() * self.grid.count) as f64
    }

    /// Length (m) of section `k` of a segment, from 0 to before the resolution: the middle of its voxels.
    pub fn length_in_segment(&self, segment: &Segment, k: usize) -> f64 {
        let (a, b) = segment.range;
        a + (b - a) * (k as f64 + 0.5) / self.grid.count as f64
    }

    /// The outline at a length, m; `None` where the plane misses the stem.
    pub fn outline(&self, length: f64) -> Option<Outline> {
        self.outline_in(&self.stem.grain.axis().frame(length))
    }

    /// The outline in a frame.
    fn outline_in(&self, frame: &Frame) -> Option<Outline> {
        let outline = self.slicer.outline(frame)?;
        Some(match self.smoothing {
            Some(tolerance) => outline.smoothed(tolerance),
            None => outline,
        })
    }

    /// The section at a length, m; `None` where the plane misses the stem.
    pub fn section(&self, length: f64) -> Option<TransverseSection> {
        let frame = self.stem.grain.axis().frame(length);
        let outline = self.outline_in(&frame)?;
        let field = self.field(&outline, length);
        Some(TransverseSection {
            length,
            frame,
            outline,
            field,
        })
    }

    /// The sections at `lengths` (m) by all threads of the current pool; those that miss the stem are left out.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn sections_at(
        &self,
        lengths: &[f64],
        context: &Context,
    ) -> Result<Vec<TransverseSection>, Cancelled> {
        let sections: Vec<Option<TransverseSection>> = lengths
            .par_iter()
            .map(|&s| {
                context.check()?;
                Ok(self.section(s))
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(sections.into_iter().flatten().collect())
    }

    /// The rings of a section with this outline, about the stem's pith, or the centroid where the pith lies outside.
    fn field(&self, outline: &Outline, length: f64) -> RingField {
        let scale = self.stem.grain.scale(length);
        let pith = self.stem.grain.to_section(self.stem.rings.pith(), length);
        if self.stem.kind.is_sawn() {
            let reach = outline
                .points()
                .map(|p| p.distance(pith))
                .fold(0.0, f64::max);
            return RingField::arcs(pith, self.stem.rings.outer_radius(0.0) * scale, reach);
        }
        let own = &outline.loops[0];
        let clearance = PITH_CLEARANCE_RADII * outline.mean_radius();
        let clear = polygon::contains(own, pith) && polygon::distance(own, pith) > clearance;
        let pith = if clear { pith } else { outline.centroid };
        let extent = own.iter().map(|p| p.distance(pith)).fold(0.0, f64::max);
        if polygon::contains(own, pith) {
            RingField::round(own, pith, extent, self.stem.rings.eccentricity_onset())
        } else {
            RingField::arcs(pith, extent, extent)
        }
    }
}

/// Outlines at `count` equal steps along the axis; those that miss the stem are left out.
fn stations(
    slicer: &SectionSlicer,
    axis: &Axis,
    count: usize,
    context: &Context,
) -> Result<Vec<SectionStation>, Cancelled> {
    let stations: Vec<Option<SectionStation>> = (0..count)
        .into_par_iter()
        .map(|k| {
            context.check()?;
            let length = axis.length() * (k as f64 + 0.5) / count as f64;
            let outline = slicer.outline(&axis.frame(length));
            Ok(outline.map(|outline| SectionStation { length, outline }))
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(stations.into_iter().flatten().collect())
}

fn segment(axis: &Axis, range: (f64, f64)) -> Segment {
    const SAMPLES: usize = 32;
    let middle = 0.5 * (range.0 + range.1);
    let frame = axis.frame(middle);
    let sagitta = (0..=SAMPLES)
        .map(|k| range.0 + (range.1 - range.0) * k as f64 / SAMPLES as f64)
        .map(|s| {
            let straight = frame.origin + frame.tangent * (s - middle);
            axis.frame(s).origin.distance(straight)
        })
        .fold(0.0, f64::max);
    Segment {
        range,
        frame,
        sagitta,
    }
}

/// Between which lengths (m) sections are whole, judged by the stations; the stem's own ends count as far as they are.
fn whole_range(stations: &[SectionStation], radius: f64, length: f64) -> (f64, f64) {
    let Some(step) = stations
        .windows(2)
        .map(|w| w[1].length - w[0].length)
        .min_by(f64::total_cmp)
    else {
        return (0.0, length);
    };
    // An end at an angle reaches no further in than about a radius; in a stump that would be all of it.
    let near = (radius.min(0.1 * length) / step).ceil().max(1.0) as usize;
    let areas: Vec<f64> = stations.iter().map(|s| s.outline.area).collect();
    let reversed: Vec<f64> = areas.iter().rev().copied().collect();
    let low = cut_stations(&areas, near);
    let high = cut_stations(&reversed, near);
    let last = stations.len() - 1;
    if low + high >= last {
        return (stations[0].length, stations[last].length);
    }
    // Whole sections at the first and the last station reach to the ends beyond them, half a step away.
    let from = if low == 0 {
        stations[0].length - 0.5 * step
    } else {
        stations[low].length
    };
    let to = if high == 0 {
        stations[last].length + 0.5 * step
    } else {
        stations[last - high].length
    };
    (from.max(0.0), to.min(length))
}

/// Number of stations, from the first on, whose sections are cut by the stem's end within `near` stations of it.
fn cut_stations(areas: &[f64], near: usize) -> usize {
    let is_cut = |k: &usize| {
        let inner = areas
            .get(*k + 1..(*k + 1 + near).min(areas.len()))
            .unwrap_or_default();
        let next = inner.iter().copied().fold(0.0, f64::max);
        areas[*k] < WHOLE_SECTION * next
    };
    (0..areas.len().min(near))
        .rev()
        .find(is_cut)
        .map_or(0, |k| k + 1)
}
