//! The bending test of every species against its table.

use super::error::BendingError;
use super::report::{BendReport, Compared};
use super::species::bend_species;
use super::specimen::BendTest;
use super::statistics::correlation;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::species::Species;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A species' row.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BendRow {
    /// Species.
    pub species: String,
    /// Scientific name.
    pub scientific_name: String,
    /// The test; without its sequence of failure.
    pub report: Option<BendReport>,
    /// Stress in the outermost fibre, as if linear, at the first break, Pa.
    pub stress_at_first_break_pa: Option<f64>,
    /// Why there is no test.
    pub not_tested_because: Option<String>,
}

/// How a column of the test agrees with the table's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    /// Species with both.
    pub species: usize,
    /// Median of test over table.
    pub median_ratio: f64,
    /// Least ratio.
    pub least_ratio: f64,
    /// Greatest ratio.
    pub greatest_ratio: f64,
    /// How many are within 5 %.
    pub within_5_percent: usize,
    /// How many are within 10 %.
    pub within_10_percent: usize,
    /// Spearman's rank correlation.
    pub rank_correlation: f64,
}

impl Summary {
    fn of(compared: &[Compared]) -> Option<Summary> {
        let pairs: Vec<(f64, f64)> = compared
            .iter()
            .filter_map(|c| Some((c.test, c.table?)))
            .collect();
        let mut ratios: Vec<f64> = pairs.iter().map(|(test, table)| test / table).collect();
        ratios.sort_by(f64::total_cmp);
        let n = ratios.len();
        let within = |part: f64| ratios.iter().filter(|r| (*r - 1.0).abs() <= part).count();
        let [tests, tables]: [Vec<f64>; 2] = [
            pairs.iter().map(|p| p.0).collect(),
            pairs.iter().map(|p| p.1).collect(),
        ];
        Some(Summary {
            species: n,
            median_ratio: 0.5 * (ratios.get(n.checked_sub(1)? / 2)? + ratios[n / 2]),
            least_ratio: ratios[0],
            greatest_ratio: ratios[n - 1],
            within_5_percent: within(0.05),
            within_10_percent: within(0.10),
            rank_correlation: correlation(&ranks(&tests), &ranks(&tables)),
        })
    }
}

/// Ranks from 1; equals share their mean.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut from = 0;
    while from < order.len() {
        let same = |&&i: &&usize| values[i] == values[order[from]];
        let to = from + order[from..].iter().take_while(same).count();
        for &i in &order[from..to] {
            ranks[i] = 0.5 * (from + 1 + to) as f64;
        }
        from = to;
    }
    ranks
}

/// Bending tests of all species.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BendTable {
    /// `greenstick-bend-table`.
    pub schema: &'static str,
    /// Version of the schema: it rises when a name changes or goes.
    pub version: u32,
    /// Moisture content, percent.
    pub moisture_percent: f64,
    /// Modulus of elasticity.
    pub modulus_of_elasticity: Option<Summary>,
    /// Modulus of rupture.
    pub modulus_of_rupture: Option<Summary>,
    /// Work to maximum load.
    pub work_to_maximum_load: Option<Summary>,
    /// Species whose strength across or along the grain is estimated from specific gravity.
    pub estimated: usize,
    /// In the order of [`Species::all`].
    pub rows: Vec<BendRow>,
}

/// Tests every species at `moisture` percent but Yang's four, whose values are of branches and not of such specimens. A species
/// for which the table lacks values gets a row that says so.
///
/// # Errors
/// [`BendingError::Test`] where the specimen is wrong for all, and where the caller stops the work.
pub fn bend_all(
    moisture: f64,
    test: &BendTest,
    context: &Context,
) -> Result<BendTable, BendingError> {
    test.check()?;
    let all = Species::all()
        .iter()
        .filter(|s| s.splitting_resistance.is_none());
    let all: Vec<&Species> = all.collect();
    let done = AtomicUsize::new(0);
    context.report(0.0)?;
    let rows: Result<Vec<BendRow>, Cancelled> = all
        .par_iter()
        .map(|species| {
            let row = row(species, moisture, test, &context.silenced())?;
            let now = done.fetch_add(1, Ordering::Relaxed) + 1;
            context.report(now as f64 / all.len() as f64)?;
            Ok(row)
        })
        .collect();
    let rows = rows?;
    let column = |of: fn(&BendReport) -> Compared| {
        let column: Vec<Compared> = rows
            .iter()
            .filter_map(|r| r.report.as_ref())
            .map(of)
            .collect();
        Summary::of(&column)
    };
    Ok(BendTable {
        schema: "greenstick-bend-table",
        version: 1,
        moisture_percent: moisture,
        modulus_of_elasticity: column(|r| r.modulus_of_elasticity_pa),
        modulus_of_rupture: column(|r| r.modulus_of_rupture_pa),
        work_to_maximum_load: column(|r| r.work_to_maximum_load_j_per_m3),
        estimated: rows
            .iter()
            .filter_map(|r| r.report.as_ref())
            .filter(|r| r.notes.iter().any(|n| n.contains("estimated")))
            .count(),
        rows,
    })
}

fn row(
    species: &Species,
    moisture: f64,
    test: &BendTest,
    context: &Context,
) -> Result<BendRow, Cancelled> {
    let row = BendRow {
        species: species.name.clone(),
        scientific_name: species.scientific_name.clone(),
        report: None,
        stress_at_first_break_pa: None,
        not_tested_because: None,
    };
    match bend_species(species, moisture, test, context) {
        Ok(bent) => Ok(BendRow {
            stress_at_first_break_pa: bent.outcome.stress_at_first_break,
            report: Some(BendReport {
                sequence: Vec::new(),
                ..bent.report
            }),
            ..row
        }),
        Err(BendingError::Cancelled(stop)) => Err(stop),
        Err(why) => Ok(BendRow {
            not_tested_because: Some(why.to_string()),
            ..row
        }),
    }
}

impl fmt::Display for BendTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:28}{:>24}{:>24}{:>24}",
            "", "elasticity, GPa", "rupture, MPa", "work, kJ/m³"
        )?;
        write!(f, "{:28}", "species")?;
        for _ in 0..3 {
            write!(f, "{:>9}{:>8}{:>7}", "test", "table", "ratio")?;
        }
        writeln!(f)?;
        let cell = |x: Option<f64>, scale: f64, digits: usize| {
            x.map_or("-".to_owned(), |x| format!("{:.digits$}", x / scale))
        };
        for row in &self.rows {
            let Some(r) = &row.report else {
                let why = row.not_tested_because.as_deref().unwrap_or("");
                writeln!(f, "{:28}not tested: {why}", row.species)?;
                continue;
            };
            write!(f, "{:28}", row.species)?;
            for (c, scale, digits) in [
                (&r.modulus_of_elasticity_pa, 1e9, 2),
                (&r.modulus_of_rupture_pa, 1e6, 1),
                (&r.work_to_maximum_load_j_per_m3, 1e3, 1),
            ] {
                let [test, table] = [Some(c.test), c.table].map(|x| cell(x, scale, digits));
                write!(f, "{test:>9}{table:>8}{:>7}", cell(c.ratio, 1.0, 3))?;
            }
            writeln!(f)?;
        }
        writeln!(
            f,
            "\n{:28}{:>8}{:>8}{:>16}{:>8}{:>9}{:>18}",
            "test over table",
            "species",
            "median",
            "range",
            "in 5 %",
            "in 10 %",
            "rank correlation"
        )?;
        for (name, summary) in [
            ("modulus of elasticity", &self.modulus_of_elasticity),
            ("modulus of rupture", &self.modulus_of_rupture),
            ("work to maximum load", &self.work_to_maximum_load),
        ] {
            if let Some(s) = summary {
                let range = format!("{:.3} to {:.3}", s.least_ratio, s.greatest_ratio);
                writeln!(
                    f,
                    "{name:28}{:>8}{:>8.3}{range:>16}{:>8}{:>9}{:>18.3}",
                    s.species,
                    s.median_ratio,
                    s.within_5_percent,
                    s.within_10_percent,
                    s.rank_correlation
                )?;
            }
        }
        if self.estimated > 0 {
            writeln!(
                f,
                "{} species have no strength across the grain or in shear in the table; theirs is estimated from specific gravity",
                self.estimated
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_by_hand() {
        let of = |test: f64, table: Option<f64>| Compared {
            test,
            table,
            ratio: None,
            basis: None,
        };
        let made = Summary::of(&[
            of(1.04, Some(1.0)),
            of(1.8, Some(2.0)),
            of(2.4, Some(3.0)),
            of(7.0, None),
            of(2.4, Some(4.0)),
        ]);
        let s = made.unwrap();
        assert_eq!(
            (s.species, s.within_5_percent, s.within_10_percent),
            (4, 1, 2)
        );
        assert!((s.median_ratio - 0.85).abs() < 1e-12);
        assert_eq!((s.least_ratio, s.greatest_ratio), (0.6, 1.04));
        // Ranks 1, 2, 3½, 3½ against 1, 2, 3, 4: covariance 4.5 of √(4.5 · 5).
        assert!((s.rank_correlation - (4.5f64 / 5.0).sqrt()).abs() < 1e-12);
        assert!(Summary::of(&[of(1.0, None)]).is_none());
    }
}
