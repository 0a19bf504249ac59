//! The specimen and the test.

use super::error::BendError;
use crate::placement::RodCount;
use serde::{Deserialize, Serialize};

/// The specimen's cross-section.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BendSection {
    /// A rectangle; the load acts along its height.
    Rectangle {
        /// Width, m.
        width: f64,
        /// Height, m.
        height: f64,
    },
    /// A circle.
    Round {
        /// Diameter, m.
        diameter: f64,
    },
}

impl BendSection {
    /// Returns the height along the load, m.
    pub fn height(self) -> f64 {
        match self {
            BendSection::Rectangle { height, .. } => height,
            BendSection::Round { diameter } => diameter,
        }
    }

    /// Returns the area, m².
    pub fn area(self) -> f64 {
        match self {
            BendSection::Rectangle { width, height } => width * height,
            BendSection::Round { diameter } => 0.25 * std::f64::consts::PI * diameter * diameter,
        }
    }

    /// Returns the second moment of area about the axis of bending, m⁴.
    pub fn inertia(self) -> f64 {
        match self {
            BendSection::Rectangle { width, height } => width * height.powi(3) / 12.0,
            BendSection::Round { diameter } => std::f64::consts::PI * diameter.powi(4) / 64.0,
        }
    }
}

/// A bending test. The default is that of [`super::BendParameters`]: the primary method of ASTM D143, 50 mm × 50 mm × 760 mm
/// on a span of 710 mm, loaded in the middle until the load has fallen to half.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendTest {
    /// Cross-section.
    pub section: BendSection,
    /// Length of the specimen, m.
    pub length: f64,
    /// Distance between the supports, m.
    pub span: f64,
    /// Number of rods, or their spacing.
    pub rods: RodCount,
    /// Longest edge, m: half the span is divided into equal edges no longer than this.
    pub edge: f64,
    /// Seed of the rods' positions and of scatter.
    pub seed: u64,
    /// Weibull modulus of the scatter of strength; infinite for none.
    pub weibull: f64,
    /// Angle of the grain to the specimen, rad.
    pub grain_angle: f64,
    /// The test ends when the load has fallen to this fraction of the largest.
    pub end: f64,
}

/// A good [`BendTest::end`] for many tests, which end at the largest load: what comes after takes most of the time.
pub const END_AT_MAXIMUM: f64 = 0.95;

/// Largest matrix, GB.
pub(crate) const MAX_MATRIX_GIGABYTES: f64 = 4.0;

/// Returns the approximate size of matrix and factor of a specimen of rods with vertices in common cross-sections, GB.
pub(crate) fn matrix_gigabytes(rods: f64, sections: f64) -> f64 {
    // Three unknowns at a vertex, each with those of its cross-section and the one before.
    2.0 * 8e-9 * (3.0 * rods * sections) * (4.5 * rods)
}

/// A quantity, its value, whether that is valid, and what would be.
type Check = (&'static str, f64, bool, &'static str);

impl BendTest {
    /// Checks the specimen.
    ///
    /// # Errors
    /// [`BendError::Value`] or [`BendError::TooFine`] for the first number out of range.
    pub fn check(&self) -> Result<(), BendError> {
        for (what, value, valid, right) in self.positive().into_iter().chain(self.relations()) {
            if !valid {
                return Err(BendError::Value { what, value, right });
            }
        }
        self.check_size()
    }

    /// Returns the stress in the outermost fibre under a load (N), as if linear, Pa.
    pub(crate) fn fibre_stress(&self, load: f64) -> f64 {
        load * self.span * self.section.height() / (8.0 * self.section.inertia())
    }

    fn rods(&self) -> (&'static str, f64) {
        match self.rods {
            RodCount::Number(n) => ("the number of rods", f64::from(n)),
            RodCount::Spacing(s) => ("the distance between rods (m)", s),
        }
    }

    fn width(&self) -> f64 {
        self.section.area() / self.section.height()
    }

    /// Values that must be positive.
    fn positive(&self) -> [Check; 6] {
        [
            (
                "the specimen's height or diameter (m)",
                self.section.height(),
            ),
            ("the specimen's width (m)", self.width()),
            ("the specimen's length (m)", self.length),
            ("the span (m)", self.span),
            ("the longest edge (m)", self.edge),
            self.rods(),
        ]
        .map(|(what, value)| {
            let valid = value > 0.0 && value.is_finite();
            (what, value, valid, "above 0 and finite")
        })
    }

    /// Relations between values.
    fn relations(&self) -> [Check; 7] {
        let (span, edge, height) = (self.span, self.edge, self.section.height());
        let (rods, number_or_spacing) = self.rods();
        let too_wide = matches!(self.rods, RodCount::Spacing(s) if s > height.min(self.width()));
        let (the_span, the_edge) = ("the span (m)", "the longest edge (m)");
        [
            (
                the_span,
                span,
                span < self.length,
                "shorter than the specimen",
            ),
            (
                the_span,
                span,
                span >= 4.0 * height,
                "at least four times the height",
            ),
            (
                the_edge,
                edge,
                edge <= span / 8.0,
                "at most an eighth of the span",
            ),
            (
                the_edge,
                edge,
                edge >= span / 20_000.0,
                "at least a 20,000th of the span",
            ),
            (
                "the fraction of the load that ends the test",
                self.end,
                (0.0..1.0).contains(&self.end),
                "from 0 to below 1",
            ),
            (
                "the Weibull modulus of the scatter",
                self.weibull,
                self.weibull >= 1.0,
                "1 or more",
            ),
            (
                rods,
                number_or_spacing,
                !too_wide,
                "at most the height and the width",
            ),
        ]
    }

    fn check_size(&self) -> Result<(), BendError> {
        let rods = match self.rods {
            RodCount::Number(n) => f64::from(n),
            RodCount::Spacing(s) => self.section.area() / (s * s),
        };
        let sections = self.length / self.edge;
        let gigabytes = matrix_gigabytes(rods, sections);
        if gigabytes > MAX_MATRIX_GIGABYTES {
            return Err(BendError::TooFine {
                rods,
                sections,
                gigabytes,
                most: MAX_MATRIX_GIGABYTES,
            });
        }
        Ok(())
    }
}
