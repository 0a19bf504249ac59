//! The measures of a stem as numbers of a report.

use super::logs::LogReport;
use super::measurement_errors::ErrorsAt;
use super::section_size::SectionSize;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::fmt;

/// The size of the section at breast height. Errors are standard errors, `None` where the stem is no scan's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BreastHeightReport {
    /// Diameter of the circle of the same area, m.
    pub diameter_by_area_m: f64,
    /// Its error, m.
    pub diameter_by_area_error_m: Option<f64>,
    /// Diameter of the circle of the same girth, m.
    pub diameter_by_girth_m: f64,
    /// Its error, m.
    pub diameter_by_girth_error_m: Option<f64>,
    /// Diameter that a diameter tape shows, m: the convex hull's girth over π.
    pub diameter_by_tape_m: f64,
    /// Its error, m.
    pub diameter_by_tape_error_m: Option<f64>,
    /// Diameter under bark of the circle of the same area, m.
    pub diameter_under_bark_m: f64,
    /// By how much the least calliper diameter is below the greatest, as a share of it.
    pub ovality: f64,
    /// Its error.
    pub ovality_error: Option<f64>,
}

impl BreastHeightReport {
    pub(super) fn new(size: &SectionSize, errors: Option<ErrorsAt>) -> Self {
        BreastHeightReport {
            diameter_by_area_m: size.diameter_by_area(),
            diameter_by_area_error_m: errors.map(|e| e.diameter),
            diameter_by_girth_m: size.diameter_by_girth(),
            diameter_by_girth_error_m: errors.map(|e| e.girth / PI),
            diameter_by_tape_m: size.diameter_by_tape(),
            diameter_by_tape_error_m: errors.map(|e| e.girth / PI),
            diameter_under_bark_m: size.diameter_under_bark(),
            ovality: size.ovality(),
            ovality_error: errors.map(|e| e.ovality),
        }
    }
}

/// What is measured along a stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MensurationReport {
    /// Breast height, m along the stem from its butt.
    pub breast_height_m: f64,
    /// The section there; `None` where the stem is too short.
    pub at_breast_height: Option<BreastHeightReport>,
    /// Volume over bark: the sections' areas over the stem's length, m³.
    pub volume_over_bark_m3: f64,
    /// Its standard error, m³; `None` where the stem is no scan's.
    pub volume_over_bark_error_m3: Option<f64>,
    /// Volume under bark, m³.
    pub volume_under_bark_m3: f64,
    /// Its standard error, m³, without that of the bark's thickness; `None` where the stem is no scan's.
    pub volume_under_bark_error_m3: Option<f64>,
    /// The share of the radius that is taken for bark.
    pub bark_share: f64,
    /// Standard error of the stem's length, m; `None` where the stem is no scan's.
    pub length_error_m: Option<f64>,
    /// Annual rings of the wood at the butt; `None` where rings have no widths.
    pub rings_at_butt: Option<u32>,
    /// Logs and their volumes.
    pub logs: LogReport,
}

/// ` ± ` with an error in a unit that is `scale` to the SI unit; nothing where there is none.
fn plus_minus(error: Option<f64>, scale: f64, digits: usize) -> String {
    error.map_or(String::new(), |e| format!(" ± {:.*}", digits, e * scale))
}

impl fmt::Display for MensurationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.at_breast_height {
            Some(size) => writeln!(
                f,
                "breast    at {:.2} m: diameter {:.2}{} cm by area, {:.2} by girth, {:.2} by tape, {:.2} under bark",
                self.breast_height_m,
                100.0 * size.diameter_by_area_m,
                plus_minus(size.diameter_by_area_error_m, 100.0, 2),
                100.0 * size.diameter_by_girth_m,
                100.0 * size.diameter_by_tape_m,
                100.0 * size.diameter_under_bark_m,
            )?,
            None => writeln!(
                f,
                "breast    no section at {:.2} m: the stem is too short",
                self.breast_height_m
            )?,
        }
        writeln!(
            f,
            "volume    {:.6}{} m³ over bark, {:.6} under bark, taken for {:.1} % of the radius",
            self.volume_over_bark_m3,
            plus_minus(self.volume_over_bark_error_m3, 1.0, 6),
            self.volume_under_bark_m3,
            100.0 * self.bark_share
        )?;
        let logs = &self.logs;
        if logs.logs.is_empty() {
            return writeln!(
                f,
                "logs      none: the stem is nowhere {:.1} cm thick",
                100.0 * logs.top_diameter_m
            );
        }
        writeln!(
            f,
            "logs      {} of {:.2} m to {:.1} cm at {:.2} m: {:.6}{} m³ by Smalian's rule, {:.6} exactly",
            logs.logs.len(),
            logs.log_length_m,
            100.0 * logs.top_diameter_m,
            logs.merchantable_length_m,
            logs.smalian_m3,
            plus_minus(logs.smalian_error_m3, 1.0, 6),
            logs.volume_m3
        )
    }
}
