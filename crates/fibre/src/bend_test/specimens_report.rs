//! What bending tests of many specimens return, beside the scatter of the tables and what was measured.

use super::measured::{MeasuredSpecimens, MeasuredSummary};
use super::report::short;
use super::statistics::{Correlation, Statistics, regression_line};
use crate::curve::Curve;
use greenstick_wood::species::{ClearWoodVariation, CoefficientsOfVariation};
use serde::Serialize;
use std::fmt;

/// What a specimen's test returned. Names end with the unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpecimenResult {
    /// Modulus of elasticity from the deflection, Pa.
    pub modulus_of_elasticity_pa: f64,
    /// Modulus of rupture, Pa.
    pub modulus_of_rupture_pa: f64,
    /// Work to maximum load, J/m³.
    pub work_to_maximum_load_j_per_m3: f64,
    /// Stress in the outermost fibre, as if linear, at the first break, Pa.
    pub stress_at_first_break_pa: Option<f64>,
    /// Largest load, N.
    pub maximum_load_n: f64,
    /// Deflection there, m.
    pub deflection_at_maximum_load_m: f64,
}

/// A specimen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpecimenRow {
    /// Its number, from 1.
    pub specimen: u32,
    /// Its density at its moisture, kg/m³.
    pub density_kg_per_m3: f64,
    /// What its test returned.
    #[serde(flatten)]
    pub result: Option<SpecimenResult>,
    /// Why there is no result.
    pub not_tested_because: Option<String>,
}

/// The scatter that tables expect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExpectedScatter {
    /// The source of the coefficients of variation.
    pub source: &'static str,
    /// Standard deviation over mean.
    pub coefficients_of_variation: CoefficientsOfVariation,
    /// Correlation of the modulus of rupture with density: the slope of Table 5-11 times the scatter of density over that of
    /// rupture.
    pub rupture_with_density: f64,
    /// The same of the modulus of elasticity.
    pub elasticity_with_density: f64,
    /// Mean modulus of rupture over that of specimens of the size of the tables, by the theory of the weakest link.
    pub size_factor: f64,
}

impl ExpectedScatter {
    pub(super) fn new(variation: ClearWoodVariation, size_factor: f64) -> Self {
        let ClearWoodVariation {
            coefficients,
            slopes,
        } = variation;
        let correlation = |slope: f64, own: f64| slope * coefficients.density / own;
        ExpectedScatter {
            source: "Wood Handbook, Tables 5-6 and 5-11",
            coefficients_of_variation: coefficients,
            rupture_with_density: correlation(
                slopes.modulus_of_rupture,
                coefficients.modulus_of_rupture,
            ),
            elasticity_with_density: correlation(
                slopes.modulus_of_elasticity,
                coefficients.modulus_of_elasticity,
            ),
            size_factor,
        }
    }
}

/// The specimens that were tested, in numbers. Names end with the unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpecimensSummary {
    /// Density, kg/m³.
    pub density_kg_per_m3: Option<Statistics>,
    /// Modulus of elasticity, Pa.
    pub modulus_of_elasticity_pa: Option<Statistics>,
    /// Modulus of rupture, Pa.
    pub modulus_of_rupture_pa: Option<Statistics>,
    /// Work to maximum load, J/m³.
    pub work_to_maximum_load_j_per_m3: Option<Statistics>,
    /// Correlation of the modulus of rupture with density.
    pub rupture_with_density: Option<Correlation>,
    /// Correlation of the modulus of elasticity with density.
    pub elasticity_with_density: Option<Correlation>,
}

/// A column of the specimens that were tested.
fn column(rows: &[SpecimenRow], value: fn(&SpecimenResult) -> f64) -> Vec<f64> {
    let results = rows.iter().filter_map(|row| row.result.as_ref());
    results.map(value).collect()
}

/// The density of the specimens that were tested.
fn densities(rows: &[SpecimenRow]) -> Vec<f64> {
    let tested = rows.iter().filter(|row| row.result.is_some());
    tested.map(|row| row.density_kg_per_m3).collect()
}

impl SpecimensSummary {
    pub(super) fn new(rows: &[SpecimenRow]) -> Self {
        let density = densities(rows);
        let elasticity = column(rows, |r| r.modulus_of_elasticity_pa);
        let rupture = column(rows, |r| r.modulus_of_rupture_pa);
        SpecimensSummary {
            density_kg_per_m3: Statistics::new(&density),
            modulus_of_elasticity_pa: Statistics::new(&elasticity),
            modulus_of_rupture_pa: Statistics::new(&rupture),
            work_to_maximum_load_j_per_m3: Statistics::new(&column(rows, |r| {
                r.work_to_maximum_load_j_per_m3
            })),
            rupture_with_density: Correlation::new(&density, &rupture),
            elasticity_with_density: Correlation::new(&density, &elasticity),
        }
    }
}

/// Bending tests of many specimens of a species. Names end with the unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpecimensReport {
    /// `greenstick-bend-specimens`.
    pub schema: &'static str,
    /// Version of the schema: it rises when a name changes or goes.
    pub version: u32,
    /// Species.
    pub species: String,
    /// Scientific name.
    pub scientific_name: String,
    /// Table of the species' values.
    pub source: String,
    /// Moisture content, percent.
    pub moisture_percent: f64,
    /// `rectangle` or `round`.
    pub section: &'static str,
    /// Width, m; the diameter where round.
    pub width_m: f64,
    /// Height, m; the diameter where round.
    pub height_m: f64,
    /// Length, m.
    pub length_m: f64,
    /// Span, m.
    pub span_m: f64,
    /// Rods in a section, where their number was given.
    pub rods: Option<u32>,
    /// Longest edge, m.
    pub edge_m: f64,
    /// Seed of all specimens.
    pub seed: u64,
    /// Weibull modulus of the modulus of rupture, where there are flaws.
    pub flaws_weibull_modulus: Option<f64>,
    /// What tables expect.
    pub expected: ExpectedScatter,
    /// The specimens in numbers.
    pub summary: SpecimensSummary,
    /// Measured specimens beside them.
    pub measured: Option<MeasuredSummary>,
    /// The specimens.
    pub rows: Vec<SpecimenRow>,
}

impl SpecimensReport {
    /// Returns the report with measured specimens beside the tested ones.
    pub fn beside(mut self, measured: &MeasuredSpecimens) -> Self {
        self.measured = Some(measured.summary());
        self
    }

    /// Returns modulus of rupture (MPa) over density (kg/m³), a point for each specimen.
    pub fn scatter(&self) -> Curve {
        let rupture = column(&self.rows, |r| r.modulus_of_rupture_pa);
        scatter("simulated", &densities(&self.rows), &rupture)
    }
}

impl MeasuredSpecimens {
    /// Returns modulus of rupture (MPa) over density (kg/m³), a point for each specimen.
    pub fn scatter(&self) -> Curve {
        scatter("measured", &self.density, &self.modulus_of_rupture)
    }
}

fn scatter(name: &str, density: &[f64], rupture: &[f64]) -> Curve {
    let pairs = density.iter().zip(rupture);
    Curve {
        name: name.to_owned(),
        points: pairs.map(|(d, r)| [*d, 1e-6 * r]).collect(),
    }
}

impl Curve {
    /// Returns the least-squares line through the points, from the first to the last; `None` where they lie above each other.
    pub fn regression_line(&self) -> Option<Curve> {
        let column = |k: usize| self.points.iter().map(|p| p[k]).collect::<Vec<f64>>();
        let (x, y) = (column(0), column(1));
        let [intercept, slope] = regression_line(&x, &y)?;
        let low = x.iter().copied().fold(f64::INFINITY, f64::min);
        let high = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(Curve {
            name: format!("{}: regression", self.name),
            points: [low, high].map(|x| [x, intercept + slope * x]).to_vec(),
        })
    }
}

impl fmt::Display for SpecimensReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_test(f)?;
        self.fmt_summary(f)?;
        self.fmt_correlations(f)?;
        if let Some(measured) = &self.measured {
            let pairs = measured.density_kg_per_m3.map_or(0, |s| s.count);
            write!(f, "measured  {pairs} specimens of {}", measured.source)?;
            if measured.incomplete > 0 {
                write!(f, "; {} rows without both values", measured.incomplete)?;
            }
            writeln!(f)?;
        }
        if self.expected.size_factor != 1.0 {
            writeln!(
                f,
                "size      the theory of the weakest link expects {:.3} times the mean modulus of rupture of the tables' specimens",
                self.expected.size_factor
            )?;
        }
        let failed = self.rows.iter().filter_map(|r| {
            let why = r.not_tested_because.as_ref()?;
            Some((r.specimen, why))
        });
        for (number, why) in failed {
            writeln!(f, "note      specimen {number} was not tested: {why}")?;
        }
        Ok(())
    }
}

impl SpecimensReport {
    /// Writes the wood, the specimens and the model.
    fn fmt_test(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "wood      {} ({}) at {} % moisture, {}",
            self.species, self.scientific_name, self.moisture_percent, self.source
        )?;
        let section = match self.section {
            "round" => format!("{} mm round", short(self.height_m)),
            _ => format!("{} x {} mm", short(self.width_m), short(self.height_m)),
        };
        writeln!(
            f,
            "specimens {}, each {section}, {} mm long, on a span of {} mm",
            self.rows.len(),
            short(self.length_m),
            short(self.span_m)
        )?;
        let flaws = match self.flaws_weibull_modulus {
            Some(modulus) => format!("flaws with a Weibull modulus of {modulus}"),
            None => "no flaws".to_owned(),
        };
        writeln!(f, "model     {flaws}, seed {}", self.seed)
    }

    /// Writes means and scatter beside those of the tables and of measured specimens.
    fn fmt_summary(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{:28}{:>9}{:>16}{:>11}{:>9}{:>14}{:>7}{:>10}",
            "", "mean", "95 %", "deviation", "COV, %", "95 %", "table", "measured"
        )?;
        let (summary, expected) = (&self.summary, self.expected.coefficients_of_variation);
        let measured = self.measured.as_ref();
        for (name, statistics, unit, table, measured) in [
            (
                "density, kg/m³",
                &summary.density_kg_per_m3,
                1.0,
                expected.density,
                measured.and_then(|m| m.density_kg_per_m3),
            ),
            (
                "modulus of elasticity, GPa",
                &summary.modulus_of_elasticity_pa,
                1e9,
                expected.modulus_of_elasticity,
                None,
            ),
            (
                "modulus of rupture, MPa",
                &summary.modulus_of_rupture_pa,
                1e6,
                expected.modulus_of_rupture,
                measured.and_then(|m| m.modulus_of_rupture_pa),
            ),
            (
                "work to max. load, kJ/m³",
                &summary.work_to_maximum_load_j_per_m3,
                1e3,
                expected.work_to_maximum_load,
                None,
            ),
        ] {
            let Some(s) = statistics else { continue };
            let digits = if s.mean >= 100.0 * unit { 1 } else { 2 };
            let scaled = |x: f64| format!("{:.digits$}", x / unit);
            let percent = |x: f64| format!("{:.1}", 100.0 * x);
            let measured = measured.and_then(|m| m.coefficient_of_variation);
            writeln!(
                f,
                "{name:28}{:>9}{:>16}{:>11}{:>9}{:>14}{:>7.0}{:>10}",
                scaled(s.mean),
                range(s.mean_interval, scaled),
                s.standard_deviation.map_or("-".to_owned(), scaled),
                s.coefficient_of_variation.map_or("-".to_owned(), percent),
                range(s.coefficient_of_variation_interval, percent),
                100.0 * table,
                measured.map_or("-".to_owned(), percent)
            )?;
        }
        writeln!(f)
    }

    /// Writes the correlations beside those of the tables and of measured specimens.
    fn fmt_correlations(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (summary, expected) = (&self.summary, &self.expected);
        let measured = self.measured.as_ref().and_then(|m| m.rupture_with_density);
        for (name, correlation, table, measured) in [
            (
                "rupture with density",
                &summary.rupture_with_density,
                expected.rupture_with_density,
                measured,
            ),
            (
                "elasticity with density",
                &summary.elasticity_with_density,
                expected.elasticity_with_density,
                None,
            ),
        ] {
            let Some(c) = correlation else { continue };
            write!(f, "correlation of {name}: {}", interval(c))?;
            write!(f, "; expected from the tables {table:.2}")?;
            if let Some(m) = measured {
                write!(f, "; measured {}", interval(&m))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

fn range(interval: Option<[f64; 2]>, text: impl Fn(f64) -> String) -> String {
    interval.map_or("-".to_owned(), |[low, high]| {
        format!("{} to {}", text(low), text(high))
    })
}

/// A correlation with its confidence interval.
fn interval(correlation: &Correlation) -> String {
    let own = format!("{:.2}", correlation.coefficient);
    match correlation.interval {
        Some([low, high]) => format!("{own} (95 %: {low:.2} to {high:.2})"),
        None => own,
    }
}
