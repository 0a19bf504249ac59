//! The report on a scan, from its points to the surface.

use super::report::ScanReport;
use greenstick_geometry::Provenance;
use greenstick_geometry::cloud::CleanReport;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The report on a scan.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ScannedReport {
    /// The cleaning.
    pub clean: CleanReport,
    /// The bark.
    pub bark: Option<ScanReport>,
    /// Triangles of the surface.
    pub triangles: usize,
    /// What was subtracted from the file's coordinates, m.
    pub origin_m: [f64; 3],
    /// How the file was read and what was assumed; one sentence each.
    pub notes: Vec<String>,
}

/// Returns the provenance of what was made of a scan, if of one.
pub fn with_scan(mut provenance: Provenance, scan: Option<&ScannedReport>) -> Provenance {
    let bark = scan.and_then(|s| s.bark.as_ref());
    provenance.origin_m = scan.map_or([0.0; 3], |s| s.origin_m);
    provenance.coverage = bark.map(|b| b.mean_coverage);
    provenance.residual_m = bark.map(|b| b.noise_m);
    provenance
}

/// The error of a section's outline in a scan's cells, m: the points' noise over the root of their number in a cell that
/// was seen. `None` where the bark was not laid in cells.
pub fn outline_error(report: &ScannedReport) -> Option<f64> {
    let bark = report.bark.as_ref()?;
    let seen = bark.cells.iter().product::<usize>() as f64 * (1.0 - bark.completed);
    let points_per_cell = (bark.points as f64 / seen).max(1.0);
    let error = bark.noise_m / points_per_cell.sqrt();
    (seen > 0.0 && error.is_finite()).then_some(error)
}

impl fmt::Display for ScannedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.clean;
        writeln!(
            f,
            "cloud    {} points, {:.2} mm apart",
            c.read,
            c.spacing_m * 1e3
        )?;
        for step in c.steps.iter().filter(|s| s.removed > 0) {
            writeln!(
                f,
                "clean    {}: {} points removed, {} left ({})",
                step.name, step.removed, step.left, step.why
            )?;
        }
        if let Some(b) = &self.bark {
            writeln!(
                f,
                "scan     stem of {:.2} m followed, {:.2} to {:.2} m kept, mean radius {:.1} cm; {} points, {} of other \
                 limbs, {} of fracture surfaces",
                b.stem_length_m,
                b.span_m[0],
                b.span_m[1],
                b.radius_m * 100.0,
                b.points,
                b.foreign_points,
                b.fracture_points
            )?;
            writeln!(
                f,
                "errors   length {:.2} ± {:.2} m, mean diameter {:.1} ± {:.1} cm (standard errors)",
                b.stem_length_m,
                b.stem_length_error_m,
                200.0 * b.radius_m,
                200.0 * b.radius_error_m
            )?;
            if let Some(p) = &b.place {
                writeln!(
                    f,
                    "size     at {:.2} m: diameter {:.1} ± {:.1} cm, girth {:.1} ± {:.1} cm, by tape {:.1} cm",
                    p.at_m,
                    100.0 * p.diameter_m,
                    100.0 * p.diameter_error_m,
                    100.0 * p.girth_m,
                    100.0 * p.girth_error_m,
                    100.0 * p.tape_girth_m
                )?;
            }
            let parts: Vec<String> = b
                .coverage
                .iter()
                .map(|c| format!("{:.0}", c.share * 100.0))
                .collect();
            writeln!(
                f,
                "cover    {:.0} % of the girth seen; metre by metre {} %",
                b.mean_coverage * 100.0,
                parts.join(" ")
            )?;
            writeln!(
                f,
                "bark     {} × {} cells, {:.0} % completed, points {:.2} mm from it (standard deviation)",
                b.cells[0],
                b.cells[1],
                b.completed * 100.0,
                b.noise_m * 1e3
            )?;
        }
        writeln!(f, "surface  {} triangles", self.triangles)?;
        for note in &self.notes {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}
