//! The axis of a stem with its cross-sections, before the location on it is known.

use super::Axis;
use super::model::{CrossSection, StemKind};
use super::trace::TraceEnd;
use std::f64::consts::PI;

/// What a stretch of the axis is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stretch {
    Free,
    Fork,
    End,
    /// The section is open or not a single loop.
    Broken,
}

/// One point of the axis.
#[derive(Debug, Clone)]
pub(crate) struct BodyStation {
    pub stretch: Stretch,
    /// The section across the axis, where there is a plain one.
    pub section: Option<CrossSection>,
}

/// The axis with its cross-sections.
pub(crate) struct Body {
    pub axis: Axis,
    /// One for each of the axis's points.
    pub stations: Vec<BodyStation>,
    pub kind: StemKind,
    pub ends: [TraceEnd; 2],
    /// Width of a board, m.
    pub width: f64,
}

impl Body {
    /// Radius at `s` (m) of the circle of equal area, m.
    pub fn radius(&self, s: f64) -> f64 {
        let area = self.section_near(s).map_or(0.0, |section| section.area);
        (area / PI).sqrt()
    }

    /// The section nearest to `s` (m).
    fn section_near(&self, s: f64) -> Option<&CrossSection> {
        let k = self.axis.lengths().partition_point(|&l| l < s);
        let has_section = |i: &usize| self.stations[*i].section.is_some();
        let before = (0..k).rev().find(has_section);
        let after = (k..self.stations.len()).find(has_section);
        [before, after]
            .into_iter()
            .flatten()
            .filter_map(|i| self.stations[i].section.as_ref())
            .min_by(|a, b| (a.length - s).abs().total_cmp(&(b.length - s).abs()))
    }

    /// Runs of free stations as ranges of length (m).
    pub fn free_runs(&self) -> Vec<(f64, f64)> {
        let lengths = self.axis.lengths();
        let mut runs = Vec::new();
        let mut start = None;
        for (i, station) in self.stations.iter().enumerate() {
            match (station.stretch == Stretch::Free, start) {
                (true, None) => start = Some(i),
                (false, Some(a)) => {
                    runs.push((lengths[a], lengths[i - 1]));
                    start = None;
                }
                _ => {}
            }
        }
        if let Some(a) = start {
            runs.push((lengths[a], lengths[lengths.len() - 1]));
        }
        runs.retain(|r| r.1 > r.0);
        runs
    }
}
