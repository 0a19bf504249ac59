//! The parameters of a fracture test: a specimen in usual proportions, and the model of it.

use super::specimen::{
    CrackSystem, FractureTest, FractureTestKind, MIN_SLIDING_CRACK_RATIO, RodArrangement,
};
use greenstick_schema::{Declaration, Unit, choice, count, length, number, parameters};
use greenstick_wood::moisture::{AIR_DRY_PERCENT, MOISTURE_WORDS, WETTEST_PERCENT};

/// Height of the specimen, m.
const HEIGHT: f64 = 0.02;
/// Crack of the double cantilever beam, its growth, and what is left behind it, in heights.
const OPENING_CRACK: f64 = 5.0;
const OPENING_GROWTH: f64 = 2.5;
const OPENING_REST: f64 = 5.0;
/// Span of end-notched flexure, and growth of its crack, in heights: the process zone is one or two heights long, and must not
/// reach the load.
const SLIDING_SPAN: f64 = 30.0;
const SLIDING_GROWTH: f64 = 2.0;
/// The single-edge notched beam of NT BUILD 422 (1993): height, m; width, span and notch in heights.
const NOTCHED_HEIGHT: f64 = 0.08;
const NOTCHED_WIDTH: f64 = 45.0 / 80.0;
const NOTCHED_SPAN: f64 = 6.0;
const NOTCH: f64 = 0.6;
/// Rods in the height, and edges in a height, of specimens along the grain and of the notched beam, whose crack grows by less than
/// its height.
const RODS_PER_HEIGHT: (f64, f64) = (8.0, 16.0);
const EDGES_PER_HEIGHT: (f64, f64) = (5.0, 40.0);

/// A length of the specimen or the model, which follows from others where it is not given.
const fn dimension() -> Declaration {
    length(0.0, 100.0).above().auto()
}

parameters! {
    /// The parameters of a fracture test. Lengths that are not given follow from the height.
    ///
    /// ```
    /// use greenstick_fibre::fracture_test::FractureParameters;
    /// use greenstick_schema::Parameters;
    ///
    /// let mut parameters = FractureParameters::default();
    /// parameters.set_text("test", "end-notched-flexure")?;
    /// parameters.set_text("height", "2 cm")?;
    /// assert!((parameters.test().length - 0.6).abs() < 1e-12);
    /// # Ok::<(), greenstick_schema::ParameterError>(())
    /// ```
    pub struct FractureParameters {
        "Test", "fracture" {
            /// Which test.
            test: FractureTestKind = FractureTestKind::DoubleCantileverBeam, choice(FractureTestKind::CHOICES);
            /// System of the crack: its normal, and L, in which it runs.
            system: CrackSystem = CrackSystem::Tl, choice(CrackSystem::CHOICES);
        }
        "Wood", "fracture" {
            /// Moisture content, percent of the oven-dry mass: 12 is air-dry, 30 and more is green.
            moisture: f64 = AIR_DRY_PERCENT,
                number(Unit::Percent, 0.0, WETTEST_PERCENT).above().words(MOISTURE_WORDS);
        }
        "Specimen", "fracture" {
            /// Height of the specimen, twice that of an arm, such as 2cm; "auto" is the width, or 2 cm. Of a single-edge notched beam
            /// "auto" is 8 cm.
            height: Option<f64> = None, dimension();
            /// Width of the specimen; "auto" is the height, or 45/80 of it for a single-edge notched beam.
            width: Option<f64> = None, dimension();
            /// Length from the line of the load to the end, or from support to support; "auto" is that of the crack at the
            /// end of the test and 5 heights more, or a span of 30 heights, or of 6 for a single-edge notched beam.
            length: Option<f64> = None, dimension();
            /// Length of the crack at the start from the line of the load or the support, or of the notch; "auto" is 5 heights, 0.7 of
            /// half the span, or 0.6 heights.
            crack: Option<f64> = None, dimension();
            /// Growth of the crack at which the test ends; "auto" is 2.5 heights, or 2 in end-notched flexure. A single-edge notched
            /// beam always breaks through.
            growth: Option<f64> = None, dimension();
        }
        "Model", "fracture" {
            /// How rods are arranged in the section.
            arrangement: RodArrangement = RodArrangement::Layers, choice(RodArrangement::CHOICES);
            /// Distance between rods; "auto" is an eighth of the height, or a sixteenth in a single-edge notched beam.
            spacing: Option<f64> = None, dimension();
            /// Longest edge of rods; "auto" is a fifth of the height, or a 40th in a single-edge notched beam.
            edge: Option<f64> = None, dimension();
            /// Seed of the positions of scattered rods.
            seed: u64 = 1, count(0, u64::MAX as i128);
        }
    }
}

impl FractureParameters {
    /// Returns the test that they describe.
    pub fn test(&self) -> FractureTest {
        if self.test == FractureTestKind::SingleEdgeNotchedBeam {
            return self.notched_beam();
        }
        let height = self.height.or(self.width).unwrap_or(HEIGHT);
        let opens = self.test == FractureTestKind::DoubleCantileverBeam;
        let growth = if opens {
            OPENING_GROWTH
        } else {
            SLIDING_GROWTH
        };
        let growth = self.growth.unwrap_or(growth * height);
        let (length, crack) = if opens {
            let crack = self.crack.unwrap_or(OPENING_CRACK * height);
            (crack + growth + OPENING_REST * height, crack)
        } else {
            let span = self.length.unwrap_or(SLIDING_SPAN * height);
            (span, MIN_SLIDING_CRACK_RATIO * 0.5 * span)
        };
        FractureTest {
            width: self.width.unwrap_or(height),
            length: self.length.unwrap_or(length),
            crack: self.crack.unwrap_or(crack),
            growth,
            ..self.model(height, RODS_PER_HEIGHT.0, EDGES_PER_HEIGHT.0)
        }
    }

    fn notched_beam(&self) -> FractureTest {
        let height = self.height.unwrap_or(NOTCHED_HEIGHT);
        let crack = self.crack.unwrap_or(NOTCH * height);
        FractureTest {
            width: self.width.unwrap_or(NOTCHED_WIDTH * height),
            length: self.length.unwrap_or(NOTCHED_SPAN * height),
            crack,
            growth: self.growth.unwrap_or(height - crack),
            ..self.model(height, RODS_PER_HEIGHT.1, EDGES_PER_HEIGHT.1)
        }
    }

    /// Returns what all tests have, for a specimen of a height (m) with so many rods and edges in it.
    fn model(&self, height: f64, rods: f64, edges: f64) -> FractureTest {
        FractureTest {
            kind: self.test,
            width: height,
            height,
            length: height,
            crack: height,
            growth: height,
            system: self.system,
            arrangement: self.arrangement,
            spacing: self.spacing.unwrap_or(height / rods),
            edge: self.edge.unwrap_or(height / edges),
            seed: self.seed,
        }
    }
}

impl Default for FractureTest {
    fn default() -> Self {
        FractureParameters::default().test()
    }
}
