//! The outline of a section, in any unit of length.

use super::super::field::RingField;
use super::super::pith::estimate_pith;
use super::super::series::RingError;
use glam::DVec2;

/// The outline of a section, in any unit of length.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionOutline {
    /// Its points; the last is joined to the first.
    pub points: Vec<DVec2>,
    /// The pith, where it is known.
    pub pith: Option<DVec2>,
    /// Whether y points up rather than down.
    pub y_up: bool,
    /// The ring coordinate at which eccentricity begins, where it is known.
    pub eccentricity_onset: Option<f64>,
}

/// Least and greatest coordinates of an outline.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    low: DVec2,
    high: DVec2,
}

impl Extent {
    pub fn centre(&self) -> DVec2 {
        (self.low + self.high) * 0.5
    }

    /// The longer side of the rectangle about the outline.
    pub fn side(&self) -> f64 {
        (self.high - self.low).max_element()
    }
}

impl SectionOutline {
    pub(super) fn extent(&self) -> Extent {
        let none = Extent {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        };
        self.points.iter().fold(none, |extent, &p| Extent {
            low: extent.low.min(p),
            high: extent.high.max(p),
        })
    }

    /// The ring field about the pith, which is estimated where it is not known.
    pub(super) fn field(&self) -> Result<RingField, RingError> {
        let about =
            |pith| RingField::with_eccentricity_onset(&self.points, pith, self.eccentricity_onset);
        if let Some(pith) = self.pith {
            return about(pith);
        }
        // The first attempt tells what is wrong with the outline before a pith is looked for in it.
        let first = self.points.first().copied().unwrap_or_default();
        match about(first) {
            Err(RingError::Pith { .. }) | Ok(_) => about(estimate_pith(&self.points)),
            Err(error) => Err(error),
        }
    }
}
