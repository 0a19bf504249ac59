//! Parameters of the measures along a stem.

use super::logs::LogOptions;
use crate::moisture::WETTEST_PERCENT;
use greenstick_schema::{Unit, count, length, number, parameters};

/// Breast height in most of the world, m; 1.37 m in the United States.
const BREAST_HEIGHT: f64 = 1.3;
/// Greatest length along a stem, m: no tree is as tall.
const MAX_LENGTH: f64 = 1000.0;
/// Most radii: one for each degree.
const MAX_CORES: i128 = 360;

parameters! {
    /// What is measured along a stem.
    pub struct MensurationParameters {
        "Measures along the stem", "measures" {
            /// Distance of the rows of sections.csv; "auto" makes 20 to 50 rows.
            row_spacing: Option<f64> = None, length(0.0, MAX_LENGTH).above().auto();
            /// Height of the diameter at breast height, along the stem from its butt.
            breast_height: f64 = BREAST_HEIGHT, length(0.0, MAX_LENGTH).above();
            /// Length of logs.
            log_length: f64 = LogOptions::DEFAULT.log_length, length(0.0, MAX_LENGTH).above();
            /// Diameter over bark at which the last log ends.
            top_diameter: f64 = LogOptions::DEFAULT.top_diameter, length(0.0, MAX_LENGTH);
            /// Moisture content of the wood, in percent of its oven-dry mass; "auto" is that of green heartwood and sapwood.
            moisture: Option<f64> = None, number(Unit::Percent, 0.0, WETTEST_PERCENT).above().auto();
            /// Radii along which ring widths are given, at equal angles.
            cores: u32 = 4, count(1, MAX_CORES);
            /// Calendar year in which the outermost ring grew; without it, rings are counted from the pith.
            last_year: Option<u32> = None, count(1, 9998).auto();
            /// How wide finite elements are; "auto" is a fifth of the radius, in a board a quarter of the thickness at most.
            element_size: Option<f64> = None, length(0.0, MAX_LENGTH).above().auto();
        }
    }
}

impl MensurationParameters {
    /// Returns how the stem is cut into logs.
    pub fn log_options(&self) -> LogOptions {
        LogOptions {
            log_length: self.log_length,
            top_diameter: self.top_diameter,
        }
    }
}
