//! The figures of a variant's report: what a table has of it.

use greenstick::BreakReport;
use greenstick::bending::{BendReport, SpecimensReport, Statistics};
use greenstick::simulate::SimulateReport;
use serde::{Deserialize, Serialize};

/// The figures of one report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Figures {
    /// Of a break.
    Break(BreakFigures),
    /// Of a simulation.
    Run(RunFigures),
    /// Of a bending test.
    Bend(BendFigures),
}

/// A figure as a column: its name, its unit, its meaning, and the number of a report.
pub(crate) type Column<F> = (&'static str, &'static str, &'static str, fn(&F) -> f64);

/// A number that may be missing, as tables have it.
fn or_missing(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

/// A number that JSON can hold.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The word that reports have for a value.
fn word(value: &impl Serialize) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    value.as_str().unwrap_or_default().to_owned()
}

/// 1 for true.
fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

/// The figures of a break.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BreakFigures {
    /// Pieces.
    pub pieces: usize,
    /// Whether all of them are closed.
    pub closed: bool,
    /// Triangles of all of them.
    pub triangles: usize,
    /// Volume of the input, m³; none unless it is closed and oriented.
    pub input_volume_m3: Option<f64>,
    /// Volume of the first piece, at the base, m³.
    pub lower_volume_m3: Option<f64>,
    /// Volume of all pieces, m³.
    pub volume_m3: Option<f64>,
    /// Fibre bundles of the face.
    pub bundles: usize,
    /// Thorns of the face.
    pub thorns: usize,
    /// Lowest and highest point of the face, m from the location of the break along the grain.
    pub range_m: [f64; 2],
    /// How far the face was moved along the stem, m.
    pub moved_m: f64,
    /// Height of the face by the species, m.
    pub height_m: Option<f64>,
    /// Length along the stem to the break, m.
    pub length_m: f64,
    /// Notes of the report.
    pub notes: usize,
}

impl From<&BreakReport> for BreakFigures {
    fn from(report: &BreakReport) -> Self {
        let volumes = report.pieces.iter().map(|p| p.volume_m3);
        BreakFigures {
            pieces: report.pieces.len(),
            closed: report.pieces.iter().all(|p| p.closed),
            triangles: report.pieces.iter().map(|p| p.triangles).sum(),
            input_volume_m3: report.input.volume_m3,
            lower_volume_m3: report.pieces.first().and_then(|p| p.volume_m3),
            volume_m3: volumes.sum(),
            bundles: report.face.bundles,
            thorns: report.face.thorns,
            range_m: report.face.range_m,
            moved_m: report.face.moved_m,
            height_m: report.species.as_ref().map(|s| s.height_m),
            length_m: report.place.length_m,
            notes: report.notes.len(),
        }
    }
}

pub(crate) const BREAK_COLUMNS: &[Column<BreakFigures>] = &[
    ("pieces", "", "pieces", |f| f.pieces as f64),
    ("closed", "", "1 where all pieces are closed", |f| {
        flag(f.closed)
    }),
    ("triangles", "", "triangles of all pieces", |f| {
        f.triangles as f64
    }),
    ("input_volume", "m3", "volume of the input", |f| {
        or_missing(f.input_volume_m3)
    }),
    (
        "lower_volume",
        "m3",
        "volume of the piece at the base",
        |f| or_missing(f.lower_volume_m3),
    ),
    ("volume", "m3", "volume of all pieces", |f| {
        or_missing(f.volume_m3)
    }),
    ("bundles", "", "fibre bundles of the face", |f| {
        f.bundles as f64
    }),
    ("thorns", "", "thorns of the face", |f| f.thorns as f64),
    (
        "face_low",
        "m",
        "lowest point of the face along the grain, from the place of the break",
        |f| f.range_m[0],
    ),
    (
        "face_high",
        "m",
        "highest point of the face along the grain, from the place of the break",
        |f| f.range_m[1],
    ),
    (
        "moved",
        "m",
        "how far the face was moved along the stem",
        |f| f.moved_m,
    ),
    (
        "species_height",
        "m",
        "height of the face by the species",
        |f| or_missing(f.height_m),
    ),
    ("length", "m", "length along the stem to the break", |f| {
        f.length_m
    }),
    ("notes", "", "notes of the report", |f| f.notes as f64),
];

/// The figures of a simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunFigures {
    /// How the wood broke, in a word of the report.
    pub mode: String,
    /// Whether it came apart between base and tip.
    pub parted: bool,
    /// Largest force of a clamp or moved body, N.
    pub greatest_load_n: Option<f64>,
    /// Share of it at the end.
    pub load_left: Option<f64>,
    /// Largest moment of a clamp or moved body, N m.
    pub greatest_moment_nm: Option<f64>,
    /// Tension along the grain that the wood could still carry, over that at the start.
    pub tension_left: Option<f64>,
    /// Median of the places at which rods broke in the face, m from the base.
    pub place_m: Option<f64>,
    /// Standard deviation of these places, m.
    pub spread_m: Option<f64>,
    /// Pieces without splinters.
    pub wood_pieces: usize,
    /// Splinters.
    pub splinters: usize,
    /// Rods at the start.
    pub rods: usize,
    /// Breaks of rods.
    pub rods_broken: u64,
    /// Edges that yielded.
    pub edges_yielded: u64,
    /// Bonds that broke.
    pub bonds_broken: u64,
    /// Time of the first break, s.
    pub first_break_s: Option<f64>,
    /// Energy that breaking took, J.
    pub fracture_loss_j: Option<f64>,
    /// Largest energy there was, J.
    pub most_energy_j: Option<f64>,
    /// Drift of the balance of energy, J.
    pub energy_drift_j: Option<f64>,
    /// Force at which the wood buckles, N, where it does.
    pub buckling_load_n: Option<f64>,
    /// Time reached, s.
    pub time_s: Option<f64>,
    /// Notes of the report.
    pub notes: usize,
}

impl From<&SimulateReport> for RunFigures {
    fn from(report: &SimulateReport) -> Self {
        let outcome = report.outcome.as_ref();
        let [rods_broken, edges_yielded, bonds_broken] = report.broke;
        RunFigures {
            mode: outcome.map_or_else(String::new, |o| word(&o.mode)),
            parted: outcome.is_some_and(|o| o.parted),
            greatest_load_n: outcome.and_then(|o| finite(o.greatest_load_n)),
            load_left: outcome.and_then(|o| finite(o.load_left)),
            greatest_moment_nm: outcome.and_then(|o| finite(o.greatest_moment_nm)),
            tension_left: outcome.and_then(|o| o.tension_left),
            place_m: outcome.and_then(|o| o.place_m),
            spread_m: outcome.and_then(|o| o.spread_m),
            wood_pieces: outcome.map_or(0, |o| o.pieces.len()),
            splinters: outcome.map_or(0, |o| o.splinters),
            rods: report.rods,
            rods_broken,
            edges_yielded,
            bonds_broken,
            first_break_s: report.first_break_s,
            fracture_loss_j: finite(report.fracture_loss_j),
            most_energy_j: finite(report.energy.most_j),
            energy_drift_j: finite(report.energy.drift_j),
            buckling_load_n: report.buckling.map(|b| b.load_n),
            time_s: finite(report.time_s),
            notes: report.notes.len(),
        }
    }
}

pub(crate) const RUN_COLUMNS: &[Column<RunFigures>] = &[
    (
        "parted",
        "",
        "1 where the wood came apart between base and tip",
        |f| flag(f.parted),
    ),
    (
        "greatest_load",
        "N",
        "largest force of a clamp or moved body",
        |f| or_missing(f.greatest_load_n),
    ),
    (
        "load_left",
        "",
        "share of the largest force at the end",
        |f| or_missing(f.load_left),
    ),
    (
        "greatest_moment",
        "Nm",
        "largest moment of a clamp or moved body about its centre",
        |f| or_missing(f.greatest_moment_nm),
    ),
    (
        "tension_left",
        "",
        "tension that the wood could still carry, over that at the start",
        |f| or_missing(f.tension_left),
    ),
    (
        "place",
        "m",
        "median of the places at which rods broke in the face, from the base",
        |f| or_missing(f.place_m),
    ),
    ("spread", "m", "standard deviation of these places", |f| {
        or_missing(f.spread_m)
    }),
    ("pieces", "", "pieces, without splinters", |f| {
        f.wood_pieces as f64
    }),
    ("splinters", "", "smaller pieces", |f| f.splinters as f64),
    ("rods", "", "rods at the start", |f| f.rods as f64),
    ("rods_broken", "", "breaks of rods", |f| {
        f.rods_broken as f64
    }),
    ("edges_yielded", "", "edges of rods that yielded", |f| {
        f.edges_yielded as f64
    }),
    ("bonds_broken", "", "bonds that broke", |f| {
        f.bonds_broken as f64
    }),
    ("first_break", "s", "time of the first break", |f| {
        or_missing(f.first_break_s)
    }),
    (
        "fracture_loss",
        "J",
        "energy that breaking and yielding took",
        |f| or_missing(f.fracture_loss_j),
    ),
    (
        "most_energy",
        "J",
        "largest energy that there was to conserve",
        |f| or_missing(f.most_energy_j),
    ),
    ("energy_drift", "J", "drift of the balance of energy", |f| {
        or_missing(f.energy_drift_j)
    }),
    (
        "buckling_load",
        "N",
        "force at which the wood buckles, of the quasi-static solver",
        |f| or_missing(f.buckling_load_n),
    ),
    ("time", "s", "time reached", |f| or_missing(f.time_s)),
    ("notes", "", "notes of the report", |f| f.notes as f64),
];

/// A figure of bending tests: the mean of all specimens, beside the table's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BendFigure {
    /// Mean of the specimens, or the figure of the only one.
    pub test: Option<f64>,
    /// Of the table at this moisture; none where there is none, and of many specimens.
    pub table: Option<f64>,
    /// Standard deviation of the specimens.
    pub deviation: Option<f64>,
}

impl BendFigure {
    fn of_many(statistics: Option<Statistics>) -> Self {
        BendFigure {
            test: statistics.map(|s| s.mean),
            table: None,
            deviation: statistics.and_then(|s| s.standard_deviation),
        }
    }
}

/// The figures of a bending test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BendFigures {
    /// Specimens that were tested.
    pub specimens: usize,
    /// Modulus of elasticity, Pa.
    pub elasticity_pa: BendFigure,
    /// Modulus of rupture, Pa.
    pub rupture_pa: BendFigure,
    /// Work to maximum load, J/m³.
    pub work_j_per_m3: BendFigure,
    /// Largest load, N.
    pub maximum_load_n: Option<f64>,
    /// Deflection there, m.
    pub deflection_m: Option<f64>,
    /// Load at the first break, N; none of many specimens.
    pub first_break_n: Option<f64>,
    /// Breaks of rods; none of many specimens.
    pub rods_broken: Option<u32>,
    /// Bonds that broke; none of many specimens.
    pub bonds_broken: Option<u32>,
}

impl From<&BendReport> for BendFigures {
    fn from(report: &BendReport) -> Self {
        let figure = |compared: greenstick::bending::Compared| BendFigure {
            test: Some(compared.test),
            table: compared.table,
            deviation: None,
        };
        BendFigures {
            specimens: 1,
            elasticity_pa: figure(report.modulus_of_elasticity_pa),
            rupture_pa: figure(report.modulus_of_rupture_pa),
            work_j_per_m3: figure(report.work_to_maximum_load_j_per_m3),
            maximum_load_n: finite(report.maximum.load_n),
            deflection_m: finite(report.maximum.deflection_m),
            first_break_n: report.first_break.map(|f| f.load_n),
            rods_broken: Some(report.rods_broken),
            bonds_broken: Some(report.bonds_broken),
        }
    }
}

impl From<&SpecimensReport> for BendFigures {
    fn from(report: &SpecimensReport) -> Self {
        let results: Vec<_> = report.rows.iter().filter_map(|row| row.result).collect();
        let mean = |sum: f64| finite(sum / results.len() as f64);
        let summary = &report.summary;
        BendFigures {
            specimens: results.len(),
            elasticity_pa: BendFigure::of_many(summary.modulus_of_elasticity_pa),
            rupture_pa: BendFigure::of_many(summary.modulus_of_rupture_pa),
            work_j_per_m3: BendFigure::of_many(summary.work_to_maximum_load_j_per_m3),
            maximum_load_n: mean(results.iter().map(|r| r.maximum_load_n).sum()),
            deflection_m: mean(results.iter().map(|r| r.deflection_at_maximum_load_m).sum()),
            first_break_n: None,
            rods_broken: None,
            bonds_broken: None,
        }
    }
}

pub(crate) const BEND_COLUMNS: &[Column<BendFigures>] = &[
    ("specimens", "", "specimens that were tested", |f| {
        f.specimens as f64
    }),
    (
        "modulus_of_elasticity",
        "Pa",
        "modulus of elasticity; of many specimens the mean, as all that follows",
        |f| or_missing(f.elasticity_pa.test),
    ),
    (
        "table_modulus_of_elasticity",
        "Pa",
        "the table's at this moisture",
        |f| or_missing(f.elasticity_pa.table),
    ),
    (
        "sd_modulus_of_elasticity",
        "Pa",
        "standard deviation of the specimens",
        |f| or_missing(f.elasticity_pa.deviation),
    ),
    ("modulus_of_rupture", "Pa", "modulus of rupture", |f| {
        or_missing(f.rupture_pa.test)
    }),
    (
        "table_modulus_of_rupture",
        "Pa",
        "the table's at this moisture",
        |f| or_missing(f.rupture_pa.table),
    ),
    (
        "sd_modulus_of_rupture",
        "Pa",
        "standard deviation of the specimens",
        |f| or_missing(f.rupture_pa.deviation),
    ),
    (
        "work_to_maximum_load",
        "J_per_m3",
        "work to maximum load",
        |f| or_missing(f.work_j_per_m3.test),
    ),
    (
        "table_work_to_maximum_load",
        "J_per_m3",
        "the table's at this moisture",
        |f| or_missing(f.work_j_per_m3.table),
    ),
    (
        "sd_work_to_maximum_load",
        "J_per_m3",
        "standard deviation of the specimens",
        |f| or_missing(f.work_j_per_m3.deviation),
    ),
    ("maximum_load", "N", "largest load", |f| {
        or_missing(f.maximum_load_n)
    }),
    (
        "deflection_at_maximum_load",
        "m",
        "deflection at the largest load",
        |f| or_missing(f.deflection_m),
    ),
    (
        "first_break_load",
        "N",
        "load at the first break of a rod or bond",
        |f| or_missing(f.first_break_n),
    ),
    ("rods_broken", "", "breaks of rods", |f| {
        or_missing(f.rods_broken.map(f64::from))
    }),
    ("bonds_broken", "", "bonds that broke", |f| {
        or_missing(f.bonds_broken.map(f64::from))
    }),
];
