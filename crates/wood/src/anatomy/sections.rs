//! A stem's sections and segments (forests-2023 §3.1): segments slightly longer than the stem is wide, so that N voxels
//! along one show a section as sharply as its length.

use super::fill::{Grid, fill};
use super::outline::{Outline, Slicer};
use crate::polygon;
use crate::rings::RingField;
use crate::stem::{Axis, FoundStem, Frame, Stem, StemKind};
use glam::DVec2;
use greenstick_geometry::{Bitmap, Mesh};

/// Why there is no anatomy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AnatomyError {
    /// Voxels that are too coarse or too many.
    #[error("a resolution of {0} voxels; expected {least} to {most}", least = RESOLUTIONS.0, most = RESOLUTIONS.1)]
    Resolution(usize),
    /// No plane along the stem meets it.
    #[error("none of the {0} sections that were tried along the stem has an outline")]
    NoSections(usize),
    /// A stem that is too long for its width.
    #[error("the stem is {length:.3} m long and {width:.5} m wide, which makes {segments} segments; expected at most {most}", most = MOST_SEGMENTS)]
    TooLong {
        /// Length, m.
        length: f64,
        /// Width, m.
        width: f64,
        /// Segments it would be parted into.
        segments: usize,
    },
}

/// Fewest and most voxels along the side of a segment.
pub const RESOLUTIONS: (usize, usize) = (32, 512);
/// A stem of more segments is a thread, or has a wrong section somewhere.
const MOST_SEGMENTS: usize = 1000;
/// How much wider than the stem a segment is, so that relief between the sections that were tried fits in.
const SLACK: f64 = 1.04;
/// Sections tried along the stem, for each of its radii, and the fewest and most.
const TRIED: (f64, f64, f64) = (4.0, 48.0, 2000.0);
/// A section of less than this part of the area next to it is cut by the stem's end, which may stand at an angle.
const WHOLE: f64 = 0.7;

/// What is wanted of a stem's sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnatomyOptions {
    /// Voxels along each side of a segment, 32 to 512.
    pub resolution: usize,
    /// Number of rings between pith and bark.
    pub rings: u16,
}

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

/// A section of a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Length along the centreline, m.
    pub length: f64,
    /// Its frame; all that follows is in the frame's x and y.
    pub frame: Frame,
    /// Its outline.
    pub outline: Outline,
    /// Its rings, about its pith.
    pub field: RingField,
}

/// A stem that can be cut into sections anywhere.
#[derive(Debug, Clone)]
pub struct Anatomy<'a> {
    stem: &'a Stem,
    slicer: Slicer,
    /// The pixels of every section.
    pub grid: Grid,
    /// Number of rings.
    pub rings: u16,
    /// Segments from the base on.
    pub segments: Vec<Segment>,
    /// Between which lengths (m) sections are whole, not cut by the stem's ends.
    pub whole: (f64, f64),
}

impl<'a> Anatomy<'a> {
    /// The anatomy of a stem found in `mesh`, which is in world metres.
    ///
    /// # Errors
    /// [`AnatomyError`] where no section can be made, or not with such options.
    pub fn new(
        found: &'a FoundStem,
        mesh: &Mesh,
        options: &AnatomyOptions,
    ) -> Result<Self, AnatomyError> {
        let count = options.resolution;
        if !(RESOLUTIONS.0..=RESOLUTIONS.1).contains(&count) {
            return Err(AnatomyError::Resolution(count));
        }
        let stem = &found.stem;
        let slicer = Slicer::new(mesh, &found.shell, stem.kind == StemKind::Board);
        let axis = stem.grain.axis();
        let length = axis.length();
        let tried = (TRIED.0 * length / stem.radius)
            .ceil()
            .clamp(TRIED.1, TRIED.2) as usize;
        let stations: Vec<(f64, Outline)> = (0..tried)
            .map(|k| length * (k as f64 + 0.5) / tried as f64)
            .filter_map(|s| Some((s, slicer.outline(&axis.frame(s))?)))
            .collect();
        let reach = stations
            .iter()
            .flat_map(|(_, o)| o.points())
            .map(|p| p.abs().max_element())
            .fold(0.0, f64::max);
        if reach == 0.0 {
            return Err(AnatomyError::NoSections(tried));
        }
        let side = 2.0 * SLACK * reach;
        let segments = (length / side).floor().max(1.0);
        if segments > MOST_SEGMENTS as f64 {
            return Err(AnatomyError::TooLong {
                length,
                width: 2.0 * reach,
                segments: segments as usize,
            });
        }
        let at = |k: f64| length * k / segments;
        Ok(Anatomy {
            stem,
            slicer,
            grid: Grid {
                count,
                pixel: side / count as f64,
            },
            rings: options.rings.max(1),
            segments: (0..segments as usize)
                .map(|k| segment(axis, (at(k as f64), at(k as f64 + 1.0))))
                .collect(),
            whole: whole(&stations, stem.radius, length),
        })
    }

    /// The stem.
    pub fn stem(&self) -> &Stem {
        self.stem
    }

    /// Distance of the sections of a segment, m.
    pub fn spacing(&self) -> f64 {
        self.stem.grain.axis().length() / (self.segments.len() * self.grid.count) as f64
    }

    /// Length (m) of section `k` of a segment, from 0 to before the resolution: the middle of its voxels.
    pub fn length_of(&self, segment: &Segment, k: usize) -> f64 {
        let (a, b) = segment.range;
        a + (b - a) * (k as f64 + 0.5) / self.grid.count as f64
    }

    /// The outline at a length, m; `None` where the plane misses the stem.
    pub fn outline(&self, length: f64) -> Option<Outline> {
        self.slicer.outline(&self.stem.grain.axis().frame(length))
    }

    /// The section at a length, m; `None` where the plane misses the stem.
    pub fn section(&self, length: f64) -> Option<Section> {
        let frame = self.stem.grain.axis().frame(length);
        let outline = self.slicer.outline(&frame)?;
        let field = self.field(&outline, length);
        Some(Section {
            length,
            frame,
            outline,
            field,
        })
    }

    /// The voxels of a section.
    pub fn voxels(&self, outline: &Outline) -> Bitmap {
        fill(&self.grid, &outline.loops)
    }

    /// The rings of a section with this outline, about the stem's pith, or the centroid where the pith lies outside.
    fn field(&self, outline: &Outline, length: f64) -> RingField {
        let scale = self.stem.grain.scale(length);
        let pith = self.stem.rings.pith() * scale;
        if self.stem.kind == StemKind::Board {
            let reach = outline
                .points()
                .map(|p| p.distance(pith))
                .fold(0.0, f64::max);
            return RingField::arcs(pith, reach, reach);
        }
        let own = &outline.loops[0];
        let clear = 0.1 * (outline.area / std::f64::consts::PI).sqrt();
        let safe = polygon::contains(own, pith) && polygon::distance(own, pith) > clear;
        let pith = if safe { pith } else { outline.centroid };
        let extent = own.iter().map(|p| p.distance(pith)).fold(0.0, f64::max);
        if polygon::contains(own, pith) {
            RingField::round(own, pith, extent)
        } else {
            RingField::arcs(pith, extent, extent)
        }
    }
}

impl Section {
    /// A point of the section, m, in the world.
    pub fn world(&self, p: DVec2) -> glam::DVec3 {
        self.frame.origin + self.frame.x * p.x + self.frame.y * p.y
    }
}

fn segment(axis: &Axis, range: (f64, f64)) -> Segment {
    let middle = 0.5 * (range.0 + range.1);
    let frame = axis.frame(middle);
    const SAMPLES: usize = 32;
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

/// Between which of the tried lengths sections are whole; the stem's own ends count as far as they are.
fn whole(stations: &[(f64, Outline)], radius: f64, length: f64) -> (f64, f64) {
    let Some(step) = stations
        .windows(2)
        .map(|w| w[1].0 - w[0].0)
        .min_by(f64::total_cmp)
    else {
        return (0.0, length);
    };
    // An end at an angle reaches no further in than about a radius; in a stump that would be all of it.
    let near = (radius.min(0.1 * length) / step).ceil().max(1.0) as usize;
    let inward = |areas: Vec<f64>| {
        let cut = |k: &usize| {
            let inner = areas
                .get(*k + 1..(*k + 1 + near).min(areas.len()))
                .unwrap_or_default();
            let next = inner.iter().copied().fold(0.0, f64::max);
            areas[*k] < WHOLE * next
        };
        (0..areas.len().min(near))
            .rev()
            .find(cut)
            .map_or(0, |k| k + 1)
    };
    let areas: Vec<f64> = stations.iter().map(|s| s.1.area).collect();
    let low = inward(areas.clone());
    let high = inward(areas.into_iter().rev().collect());
    let last = stations.len() - 1;
    if low + high >= last {
        return (stations[0].0, stations[last].0);
    }
    // Whole sections at the first and the last station reach to the ends beyond them, half a step away.
    let from = if low == 0 {
        stations[0].0 - 0.5 * step
    } else {
        stations[low].0
    };
    let to = if high == 0 {
        stations[last].0 + 0.5 * step
    } else {
        stations[last - high].0
    };
    (from.max(0.0), to.min(length))
}
