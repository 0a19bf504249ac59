//! Rays that wander: the angles by which pieces of a torn face are told apart, so that they do not end on straight lines to the pith.

use crate::height_model::NoiseSamplers;
use crate::slabs::SectionSpan;
use glam::DVec2;

/// How far rays about a pith wander, rad, and how often over a radius.
const WANDER: f64 = 0.16;
const WAVES: f64 = 3.5;
/// How far rays through a board wander and lean, in the lesser of its width and its thickness, and how often over that.
const BOARD_WANDER: f64 = 0.5;
const BOARD_WAVES: f64 = 0.6;
/// Greatest slope of rays through a board against the radius, and how often it changes.
const BOARD_SLOPE: f64 = 2.2;
const BOARD_SLOPE_WAVES: f64 = 0.23;

/// Rays of a section.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rays {
    /// Of a board: the ring coordinate and the angle (rad) of its middle, and the lesser of its width and its thickness.
    board: Option<((f64, f64), f64)>,
}

impl Rays {
    pub fn new(span: &SectionSpan) -> Rays {
        let board = span.phi.map(|(low, high)| {
            let middle = (span.rho.0 + span.rho.1) / 2.0;
            let least = ((high - low) * middle).min(span.rho.1 - span.rho.0);
            ((middle, (low + high) / 2.0), least.max(1e-9))
        });
        Rays { board }
    }

    /// Returns the angle (rad) of a point among these rays; `direction` is the unit vector of its angle `phi`.
    ///
    /// A board shows a small part of its rings. Rays through it lean to one side and to the other, so that no piece of it is a block
    /// whose walls are square to its faces.
    pub fn angle(
        &self,
        noises: &mut NoiseSamplers,
        (rho, phi): (f64, f64),
        direction: DVec2,
    ) -> f64 {
        let Some(((middle, from), size)) = self.board else {
            return phi + WANDER * noises.wander.at(direction * rho * WAVES);
        };
        let place = DVec2::new((phi - from) * middle, rho - middle) / size;
        let slope = noises
            .wander
            .at(DVec2::new(BOARD_SLOPE_WAVES * place.x, 17.3));
        let wander = noises.wander.at(place * BOARD_WAVES);
        let off = BOARD_WANDER * wander + BOARD_SLOPE * slope * place.y;
        phi + off * size / middle
    }
}
