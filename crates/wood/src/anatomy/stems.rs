//! Many stems in one table.

use super::mensuration::BreastHeightReport;
use super::report::AnatomyReport;
use greenstick_geometry::{Column, Table, Values};

/// What became of one of several inputs.
#[derive(Debug, Clone)]
pub struct StemOutcome {
    /// Name of the input file.
    pub file: String,
    /// Name of the folder with its files; empty where it failed.
    pub folder: String,
    /// Its report, or why there is none.
    pub report: Result<AnatomyReport, String>,
}

/// Returns a table with a row for each input. Numbers of those that failed are missing, as are errors of meshes.
pub fn stems_table(stems: &[StemOutcome]) -> Table {
    let text = |name: &str, meaning: &str, of: &dyn Fn(&StemOutcome) -> String| {
        Column::new(
            name,
            "",
            meaning,
            Values::Text(stems.iter().map(of).collect()),
        )
    };
    let number = |name: &str, unit: &str, meaning: &str, of: Measure| {
        let value = |s: &StemOutcome| s.report.as_ref().ok().and_then(of).unwrap_or(f64::NAN);
        let values = stems.iter().map(value).collect();
        Column::new(name, unit, meaning, Values::F64(values))
    };
    let mut columns = vec![
        text("file", "the input", &|s| s.file.clone()),
        text("folder", "where its files are", &|s| s.folder.clone()),
    ];
    for (name, unit, meaning, of) in MEASURES {
        columns.push(number(name, unit, meaning, *of));
    }
    let failure = |s: &StemOutcome| s.report.as_ref().err().cloned().unwrap_or_default();
    columns.push(text("failure", "why there are no numbers", &failure));
    Table {
        columns,
        ..Table::default()
    }
}

/// A number of a report, if it has it.
type Measure = fn(&AnatomyReport) -> Option<f64>;

fn breast(report: &AnatomyReport) -> Option<&BreastHeightReport> {
    report.measures.at_breast_height.as_ref()
}

/// Name, unit, meaning and source of the columns of numbers.
const MEASURES: &[(&str, &str, &str, Measure)] = &[
    ("length", "m", "of the stem's axis", |r| Some(r.length_m)),
    ("length_error", "m", "standard error of length", |r| {
        r.measures.length_error_m
    }),
    (
        "breast_diameter",
        "m",
        "at breast height, of the circle of the section's area",
        |r| Some(breast(r)?.diameter_by_area_m),
    ),
    (
        "breast_diameter_error",
        "m",
        "standard error of breast_diameter",
        |r| breast(r)?.diameter_by_area_error_m,
    ),
    (
        "breast_diameter_by_tape",
        "m",
        "at breast height, as a diameter tape shows it",
        |r| Some(breast(r)?.diameter_by_tape_m),
    ),
    ("volume_over_bark", "m3", "of the stem", |r| {
        Some(r.measures.volume_over_bark_m3)
    }),
    (
        "volume_over_bark_error",
        "m3",
        "standard error of volume_over_bark",
        |r| r.measures.volume_over_bark_error_m3,
    ),
    ("volume_under_bark", "m3", "of the stem's wood", |r| {
        Some(r.measures.volume_under_bark_m3)
    }),
    (
        "merchantable_length",
        "m",
        "to the logs' top diameter",
        |r| Some(r.measures.logs.merchantable_length_m),
    ),
    (
        "logs_by_smalian",
        "m3",
        "volume of the logs over bark by Smalian's rule",
        |r| Some(r.measures.logs.smalian_m3),
    ),
    ("logs_volume", "m3", "volume of the logs over bark", |r| {
        Some(r.measures.logs.volume_m3)
    }),
    (
        "dry_mass",
        "kg",
        "oven-dry mass of the wood, of a known species",
        |r| Some(r.mass.as_ref()?.dry_mass_kg),
    ),
    (
        "mass",
        "kg",
        "mass of the wood with its water, of a known species",
        |r| Some(r.mass.as_ref()?.mass_kg),
    ),
    ("rings", "", "annual rings of the wood at the butt", |r| {
        r.measures.rings_at_butt.map(f64::from)
    }),
    ("limbs", "", "limbs that were left out", |r| {
        Some(r.limbs.len() as f64)
    }),
    (
        "girth_seen",
        "",
        "share of the girth that a scan shows",
        |r| r.provenance.coverage,
    ),
    (
        "residual",
        "m",
        "standard deviation of a scan's points from the surface",
        |r| r.provenance.residual_m,
    ),
];
