//! The parameters of a bending test: a specimen in the proportions of ASTM D143, and the model of it.

use super::specimen::{BendSection, BendTest, END_AT_MAXIMUM};
use super::specimens::{CLEAR_WOOD_WEIBULL_MODULUS, MAX_SPECIMENS};
use crate::placement::RodCount;
use greenstick_schema::{Declaration, ParameterError, Unit, count, length, number, parameters};
use greenstick_wood::moisture::{AIR_DRY_PERCENT, MOISTURE_WORDS, WETTEST_PERCENT};

/// Height and width of the primary specimen of ASTM D143, m.
const STANDARD_SIDE: f64 = 0.05;
/// Span over height in ASTM D143: 710 mm over 50 mm.
const SPAN_PER_HEIGHT: f64 = 14.2;
/// Edges in a span where no length is given.
const EDGES_PER_SPAN: f64 = 36.0;
/// The same of tests of many specimens, which must be quick.
const EDGES_PER_SPAN_OF_MANY: f64 = 24.0;
/// The fraction of the largest load at which ASTM D143 allows a test to end.
const END: f64 = 0.5;

/// A length of the specimen or the model, which follows from others where it is not given.
const fn dimension() -> Declaration {
    length(0.0, 100.0).above().auto()
}

parameters! {
    /// The parameters of a bending test. Lengths that are not given follow from those that are, and all of them from the height
    /// of the section. Where none are given, it is the primary specimen of ASTM D143: 50 mm × 50 mm × 760 mm on a span of
    /// 710 mm.
    ///
    /// ```
    /// use greenstick_fibre::BendParameters;
    /// use greenstick_schema::Parameters;
    ///
    /// let mut parameters = BendParameters::default();
    /// parameters.set_text("height", "2 cm")?;
    /// assert!((parameters.test().span - 0.284).abs() < 1e-12);
    /// # Ok::<(), greenstick_schema::ParameterError>(())
    /// ```
    pub struct BendParameters {
        "Specimen", "bend" {
            /// Height of the section along the load, such as 5cm; "auto" is the width, or 5 cm.
            height: Option<f64> = None, dimension();
            /// Width of the section; "auto" is the height.
            width: Option<f64> = None, dimension();
            /// Diameter of a round section, in place of height and width.
            diameter: Option<f64> = None, dimension();
            /// Length of the specimen; "auto" is the span and one height.
            length: Option<f64> = None, dimension();
            /// Distance between the supports; "auto" is 14.2 heights.
            span: Option<f64> = None, dimension();
        }
        "Grain", "bend" {
            /// Angle of the grain to the specimen; stiffness and strength along it follow by Hankinson's formula.
            grain_angle: f64 = 0.0, number(Unit::Degree, 0.0, 45.0);
        }
        "Model", "bend" {
            /// Number of rods in the section.
            rods: u32 = 25, count(1, u32::MAX as i128).logarithmic();
            /// Distance between rods, in place of their number.
            spacing: Option<f64> = None, dimension();
            /// Longest edge of rods; "auto" is a 36th of the span, or a 24th for many specimens of a species.
            edge: Option<f64> = None, dimension();
            /// Seed of the placement of rods and of the scatter of their strength.
            seed: u64 = 1, count(0, u64::MAX as i128);
            /// Weibull modulus of the scatter of strength; the smaller, the wider the scatter, and "auto" is no scatter.
            scatter: Option<f64> = None, number(Unit::One, 1.0, f64::INFINITY).logarithmic().auto();
            /// Fraction of the maximum load at which the test ends after the load has fallen, from 0 to below 1; "auto" is
            /// 0.5, or 0.95 for many specimens or species, whose tests end at the maximum load.
            end: Option<f64> = None, number(Unit::Fraction, 0.0, 1.0).auto();
        }
    }
    check |p| if p.diameter.is_some() && (p.height.is_some() || p.width.is_some()) {
        Err(ParameterError::Conflict(
            "diameter and height or width are both given; expected a round section or a rectangle".to_owned(),
        ))
    } else {
        Ok(())
    };
}

parameters! {
    /// The parameters of bending tests: the moisture of the wood, its scatter, the specimen and its model.
    pub struct BendSettings {
        "Wood", "bend" {
            /// Moisture content, percent of the oven-dry mass: 12 is air-dry, 30 and more is green.
            moisture: f64 = AIR_DRY_PERCENT,
                number(Unit::Percent, 0.0, WETTEST_PERCENT).above().words(MOISTURE_WORDS);
        }
        "Scatter", "bend" {
            /// Number of specimens of one species, each of wood of its own: density, stiffness and strength vary as clear wood
            /// does (Wood Handbook, Table 5-6); "auto" is one specimen of mean wood.
            specimens: Option<u32> = None, count(1, MAX_SPECIMENS as i128).auto();
            /// Weibull modulus of the modulus of rupture by the flaws of such specimens: the smaller, the more scatter and the
            /// greater the effect of size.
            flaws: f64 = CLEAR_WOOD_WEIBULL_MODULUS, number(Unit::One, 1.0, f64::INFINITY).logarithmic();
        }
    }
    include {
        /// The specimen and its model.
        specimen: BendParameters = BendParameters::default();
    }
}

impl BendParameters {
    /// Returns the cross-section.
    fn section(&self) -> BendSection {
        if let Some(diameter) = self.diameter {
            return BendSection::Round { diameter };
        }
        let side = self.height.or(self.width).unwrap_or(STANDARD_SIDE);
        BendSection::Rectangle {
            width: self.width.unwrap_or(side),
            height: side,
        }
    }

    /// Returns the test that they describe.
    pub fn test(&self) -> BendTest {
        let section = self.section();
        let height = section.height();
        let span = match (self.span, self.length) {
            (Some(span), _) => span,
            (None, Some(length)) => length - height,
            (None, None) => SPAN_PER_HEIGHT * height,
        };
        BendTest {
            section,
            length: self.length.unwrap_or(span + height),
            span,
            rods: match self.spacing {
                Some(spacing) => RodCount::Spacing(spacing),
                None => RodCount::Number(self.rods),
            },
            edge: self.edge.unwrap_or(span / EDGES_PER_SPAN),
            seed: self.seed,
            grain_angle: self.grain_angle.to_radians(),
            weibull: self.scatter.unwrap_or(f64::INFINITY),
            end: self.end.unwrap_or(END),
        }
    }
}

impl BendSettings {
    /// Returns the test that they describe; that of many specimens has longer edges and ends earlier where nothing else is
    /// given.
    pub fn test(&self) -> BendTest {
        let mut test = self.specimen.test();
        if self.specimens.is_some() {
            test.edge = (self.specimen.edge).unwrap_or(test.span / EDGES_PER_SPAN_OF_MANY);
            test.end = self.specimen.end.unwrap_or(END_AT_MAXIMUM);
        }
        test
    }
}

impl Default for BendTest {
    fn default() -> Self {
        BendParameters::default().test()
    }
}
