//! The stem of a scan as it was traced: its curve from the base, its radius along it, and the shape of its sections.

use super::shape::SectionShape;
use crate::stem::Axis;

/// Radius at one length of a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RadiusAt {
    /// Length along the axis, m.
    pub length: f64,
    /// m.
    pub radius: f64,
}

/// A stem as it was traced through the cloud.
#[derive(Debug, Clone)]
pub(crate) struct TracedStem {
    pub axis: Axis,
    /// At least two, rising in length.
    pub radii: Vec<RadiusAt>,
    pub shape: SectionShape,
    /// Standard error of the axis's length, m.
    pub length_error: f64,
    /// Standard error of the mean radius, of squared timber of half its thickness, m.
    pub radius_error: f64,
}

impl TracedStem {
    /// Mean radius, m.
    pub fn mean_radius(&self) -> f64 {
        self.radii.iter().map(|r| r.radius).sum::<f64>() / self.radii.len() as f64
    }

    /// Radius at `s`, m.
    pub fn radius(&self, s: f64) -> f64 {
        let k = self
            .radii
            .partition_point(|r| r.length <= s)
            .clamp(1, self.radii.len() - 1);
        let (a, b) = (self.radii[k - 1], self.radii[k]);
        let t = ((s - a.length) / (b.length - a.length)).clamp(0.0, 1.0);
        a.radius + (b.radius - a.radius) * t
    }
}
