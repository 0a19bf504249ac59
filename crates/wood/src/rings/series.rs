//! The rings of one section, given as a number, as mean radii or as widths (a climate series).

use super::field::RingField;
use crate::polygon;
use glam::DVec2;

/// Most rings of a section, twice those of the oldest tree known: 4,844 (D. R. Currey, "An ancient bristlecone pine stand in
/// eastern Nevada", Ecology 46, 1965, 564–566).
pub const MAX_RINGS: usize = 10_000;
/// The last ring may be larger than the outline by this share, since printed radii are rounded.
const ROUNDING_TOLERANCE: f64 = 1e-3;

/// The rings of a section. Lengths are in the outline's unit.
#[derive(Debug, Clone, PartialEq)]
pub enum RingSeries {
    /// This many rings of the same mean width; the last one is the outline.
    Number(usize),
    /// Mean radii about the pith, from the pith outwards.
    Radii(Vec<f64>),
    /// Mean widths from the pith outwards. The rest of the mean radius lies outside the last one.
    Widths(Vec<f64>),
    /// Mean radii about the pith as shares of the outline's, from the pith outwards.
    Shares(Vec<f64>),
}

/// Why rings do not fit a section.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RingError {
    /// Too few points.
    #[error("the outline has {0} points; it takes at least 3")]
    Points(usize),
    /// A coordinate that is not finite.
    #[error("point {index} of the outline is ({x}, {y}); coordinates must be finite numbers")]
    Coordinate {
        /// Which point, from 0.
        index: usize,
        /// As given.
        x: f64,
        /// As given.
        y: f64,
    },
    /// All points lie on a line.
    #[error("the outline encloses no area; its points lie on a line or in one place")]
    Flat,
    /// The pith is not in the section.
    #[error(
        "the pith ({x}, {y}) lies outside the outline, which reaches from ({left}, {top}) to ({right}, {bottom})"
    )]
    Pith {
        /// As given.
        x: f64,
        /// As given.
        y: f64,
        /// Least x of the outline.
        left: f64,
        /// Least y of the outline.
        top: f64,
        /// Largest x of the outline.
        right: f64,
        /// Largest y of the outline.
        bottom: f64,
    },
    /// No rings, or more than wood has.
    #[error("{0} rings; expected 1 to {MAX_RINGS}, twice those of the oldest tree known")]
    Number(usize),
    /// A radius or width that is not a positive number.
    #[error("{what} {number} is {value}; it must be a positive number")]
    Value {
        /// `radius` or `width`.
        what: &'static str,
        /// Which, from 1.
        number: usize,
        /// As given.
        value: f64,
    },
    /// Radii that do not increase.
    #[error(
        "radius {number} is {value}, not more than {before} before it; radii must increase from the pith outwards"
    )]
    Order {
        /// Which, from 1.
        number: usize,
        /// As given.
        value: f64,
        /// The one before.
        before: f64,
    },
    /// A ring outside of the section.
    #[error(
        "ring {number} would have the mean radius {value:.6}, but the outline's is {outer:.6}; {what} must end within it"
    )]
    TooLarge {
        /// `radii` or `the sum of widths`.
        what: &'static str,
        /// Which ring, from 1.
        number: usize,
        /// Its mean radius.
        value: f64,
        /// The outline's mean radius.
        outer: f64,
    },
}

impl RingField {
    /// The rings of a section with a closed `outline` about its `pith`, in any unit of length.
    ///
    /// # Errors
    /// [`RingError`] where the outline is no area or does not hold the pith.
    pub fn from_outline(outline: &[DVec2], pith: DVec2) -> Result<Self, RingError> {
        RingField::with_eccentricity_onset(outline, pith, None)
    }

    /// [`RingField::from_outline`] where the ring coordinate is known at which eccentricity begins.
    ///
    /// # Errors
    /// As [`RingField::from_outline`].
    pub fn with_eccentricity_onset(
        outline: &[DVec2],
        pith: DVec2,
        eccentricity_onset: Option<f64>,
    ) -> Result<Self, RingError> {
        if outline.len() < 3 {
            return Err(RingError::Points(outline.len()));
        }
        if let Some(index) = outline.iter().position(|p| !p.is_finite()) {
            let DVec2 { x, y } = outline[index];
            return Err(RingError::Coordinate { index, x, y });
        }
        let low = outline.iter().fold(DVec2::INFINITY, |a, &p| a.min(p));
        let high = outline.iter().fold(DVec2::NEG_INFINITY, |a, &p| a.max(p));
        let size = high - low;
        let area = polygon::area_and_centroid(outline).0.abs();
        if !area.is_finite() || area <= 1e-9 * size.length_squared() {
            return Err(RingError::Flat);
        }
        if !polygon::contains(outline, pith) {
            return Err(RingError::Pith {
                x: pith.x,
                y: pith.y,
                left: low.x,
                top: low.y,
                right: high.x,
                bottom: high.y,
            });
        }
        let reach = outline.iter().map(|p| p.distance(pith)).fold(0.0, f64::max);
        Ok(RingField::round(outline, pith, reach, eccentricity_onset))
    }

    /// Ring coordinates of a list of rings, from the pith outwards.
    ///
    /// # Errors
    /// [`RingError`] where they do not fit into the section.
    pub fn coordinates(&self, rings: &RingSeries) -> Result<Vec<f64>, RingError> {
        let outer = self.mean_radius(1.0);
        let (what, radii) = match rings {
            RingSeries::Number(n) => {
                if !(1..=MAX_RINGS).contains(n) {
                    return Err(RingError::Number(*n));
                }
                return Ok((1..=*n).map(|i| i as f64 / *n as f64).collect());
            }
            RingSeries::Radii(radii) => {
                check("radius", radii)?;
                ("radii", radii.clone())
            }
            RingSeries::Widths(widths) => {
                check("width", widths)?;
                let mut sum = 0.0;
                let radii = widths.iter().map(|w| {
                    sum += w;
                    sum
                });
                ("the sum of widths", radii.collect())
            }
            RingSeries::Shares(shares) => {
                check("share", shares)?;
                ("radii", shares.iter().map(|s| s * outer).collect())
            }
        };
        let mut before = 0.0;
        let mut coordinates = Vec::with_capacity(radii.len());
        for (i, value) in radii.into_iter().enumerate() {
            let number = i + 1;
            if value <= before {
                return Err(RingError::Order {
                    number,
                    value,
                    before,
                });
            }
            // Only the last may use the tolerance: two rings on the outline would be one.
            if value > outer * (1.0 + ROUNDING_TOLERANCE) || before >= outer {
                return Err(RingError::TooLarge {
                    what,
                    number,
                    value,
                    outer,
                });
            }
            coordinates.push(self.ring_of_mean_radius(value.min(outer)));
            before = value;
        }
        Ok(coordinates)
    }

    /// The ring of a coordinate as `count` points at equal angles about the pith, the first at angle 0.
    pub fn curve(&self, ring: f64, count: usize) -> Vec<DVec2> {
        (0..count)
            .map(|i| {
                let turn = i as f64 / count as f64;
                let turn = if turn > 0.5 { turn - 1.0 } else { turn };
                self.point(ring, turn * std::f64::consts::TAU)
            })
            .collect()
    }
}

fn check(what: &'static str, values: &[f64]) -> Result<(), RingError> {
    if !(1..=MAX_RINGS).contains(&values.len()) {
        return Err(RingError::Number(values.len()));
    }
    match values.iter().position(|v| !(v.is_finite() && *v > 0.0)) {
        Some(i) => Err(RingError::Value {
            what,
            number: i + 1,
            value: values[i],
        }),
        None => Ok(()),
    }
}
