//! What a bending test returns, beside the table.

use super::grain::SlopedGrain;
use super::outcome::{BendEvent, BendOutcome};
use super::specimen::{BendSection, BendTest};
use crate::event::EventKind;
use crate::placement::strength_at;
use greenstick_wood::moisture::{Basis, Fallback};
use greenstick_wood::species::{Property, Species};
use serde::Serialize;
use std::fmt;

/// Fewer rods make strength too high by more than 10 % for some species: their own bending does not yield.
const MIN_RODS_FOR_STRENGTH: usize = 25;
/// The most phases of the failure that are printed.
const MAX_PRINTED_PHASES: usize = 12;

/// A number that the test returned beside the table's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Compared {
    /// Of the test.
    pub test: f64,
    /// Of the table at this moisture, or estimated from it; none where there is neither.
    pub table: Option<f64>,
    /// The first over the second.
    pub ratio: Option<f64>,
    /// How the table's came about.
    pub basis: Option<Basis>,
}

impl Compared {
    fn of(test: f64, species: &Species, property: Property, moisture: f64) -> Self {
        // An estimate for this moisture is worth comparing with, a value of another moisture is not.
        let table = species
            .property_at(property, moisture, Fallback::Estimate)
            .ok()
            .filter(|t| t.basis != Basis::Unadjusted);
        Compared {
            test,
            table: table.map(|t| t.value),
            ratio: table.map(|t| test / t.value),
            basis: table.map(|t| t.basis),
        }
    }
}

/// Load and deflection at something that failed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Failing {
    /// Deflection, m.
    pub deflection_m: f64,
    /// Load, N.
    pub load_n: f64,
}

/// Events of one kind, one after another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Phase {
    /// What happened.
    pub kind: EventKind,
    /// How often.
    pub count: usize,
    /// Deflection at the first and the last, m.
    pub deflection_m: [f64; 2],
    /// Load at the first and the last, N.
    pub load_n: [f64; 2],
    /// Least and greatest place along the specimen from its middle, m.
    pub along_m: [f64; 2],
    /// Least and greatest height above the axis, m; above it is compression.
    pub height_m: [f64; 2],
}

impl Phase {
    fn begin(e: &BendEvent) -> Self {
        Phase {
            kind: e.kind,
            count: 0,
            deflection_m: [e.deflection; 2],
            load_n: [e.load; 2],
            along_m: [e.along; 2],
            height_m: [e.height; 2],
        }
    }

    fn all(events: &[BendEvent]) -> Vec<Phase> {
        let mut phases: Vec<Phase> = Vec::new();
        for e in events {
            if phases.last().is_none_or(|p| p.kind != e.kind) {
                phases.push(Phase::begin(e));
            }
            if let Some(p) = phases.last_mut() {
                p.count += 1;
                (p.deflection_m[1], p.load_n[1]) = (e.deflection, e.load);
                p.along_m = [p.along_m[0].min(e.along), p.along_m[1].max(e.along)];
                p.height_m = [p.height_m[0].min(e.height), p.height_m[1].max(e.height)];
            }
        }
        phases
    }
}

/// What a bending test returned. Names end with the unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BendReport {
    /// `greenstick-bend-test`.
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
    /// Rods.
    pub rods: usize,
    /// Length of their edges, m.
    pub edge_m: f64,
    /// Seed.
    pub seed: u64,
    /// Weibull modulus of the scatter of strength, where there is one.
    pub weibull: Option<f64>,
    /// Modulus of elasticity from the deflection, Pa.
    pub modulus_of_elasticity_pa: Compared,
    /// Modulus of rupture, Pa.
    pub modulus_of_rupture_pa: Compared,
    /// Work to maximum load, J/m³.
    pub work_to_maximum_load_j_per_m3: Compared,
    /// At the largest load.
    pub maximum: Failing,
    /// Where the first edge yielded.
    pub first_yield: Option<Failing>,
    /// Where the first rod or bond broke.
    pub first_break: Option<Failing>,
    /// Edges that yielded.
    pub yielded: u32,
    /// Breaks of rods; one that breaks at two places counts twice.
    pub rods_broken: u32,
    /// Bonds that broke.
    pub bonds_broken: u32,
    /// Why the test ended.
    pub ended: &'static str,
    /// What failed, in order.
    pub sequence: Vec<Phase>,
    /// What Hankinson's formula expects where the grain is not along the specimen.
    pub sloped_grain: Option<SlopedGrain>,
    /// What was assumed, a sentence each.
    pub notes: Vec<String>,
}

impl BendReport {
    pub(super) fn of(
        species: &Species,
        moisture: f64,
        test: &BendTest,
        outcome: &BendOutcome,
    ) -> Self {
        let (section, width) = match test.section {
            BendSection::Rectangle { width, .. } => ("rectangle", width),
            BendSection::Round { diameter } => ("round", diameter),
        };
        let compared = |test, property| Compared::of(test, species, property, moisture);
        let first = |yields: bool| {
            let is = |e: &&BendEvent| (e.kind == EventKind::RodYielded) == yields;
            outcome.events.iter().find(is).map(|e| Failing {
                deflection_m: e.deflection,
                load_n: e.load,
            })
        };
        let rupture = compared(outcome.modulus_of_rupture, Property::ModulusOfRupture);
        let source = match (&species.green_source, rupture.basis) {
            (Some(green), Some(Basis::TableGreen)) => green.clone(),
            // Between the two rows.
            (Some(green), Some(Basis::Equation | Basis::EquationBelowRange)) => {
                format!("{} and {green}", species.source)
            }
            _ => species.source.clone(),
        };
        let last = outcome.points.last().copied().unwrap_or_default();
        let ended = if outcome.came_apart {
            "no equilibrium was left after the last break"
        } else if last.load < test.end * outcome.maximum.load {
            "the load fell"
        } else {
            "the deflection reached its limit"
        };
        BendReport {
            schema: "greenstick-bend-test",
            version: 1,
            species: species.name.clone(),
            scientific_name: species.scientific_name.clone(),
            source,
            moisture_percent: moisture,
            section,
            width_m: width,
            height_m: test.section.height(),
            length_m: test.length,
            span_m: test.span,
            rods: outcome.rods,
            edge_m: outcome.edge,
            seed: test.seed,
            weibull: test.weibull.is_finite().then_some(test.weibull),
            modulus_of_elasticity_pa: compared(
                outcome.modulus_of_elasticity,
                Property::ModulusOfElasticity,
            ),
            modulus_of_rupture_pa: rupture,
            work_to_maximum_load_j_per_m3: compared(
                outcome.work_to_maximum_load,
                Property::WorkToMaximumLoad,
            ),
            maximum: Failing {
                deflection_m: outcome.maximum.deflection,
                load_n: outcome.maximum.load,
            },
            first_yield: first(true),
            first_break: first(false),
            yielded: last.yielded,
            rods_broken: last.rods_broken,
            bonds_broken: last.bonds_broken,
            ended,
            sequence: Phase::all(&outcome.events),
            sloped_grain: None,
            notes: notes(species, moisture, test, outcome.rods),
        }
    }
}

fn notes(species: &Species, moisture: f64, test: &BendTest, rods: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if rods < MIN_RODS_FOR_STRENGTH {
        notes.push(format!(
            "{rods} rods are few: fewer than {MIN_RODS_FOR_STRENGTH} make wood that yields much before it breaks too strong"
        ));
    }
    let known = |p| species.property_at(p, moisture, Fallback::Estimate);
    for property in [Property::TensionPerpendicular, Property::ShearParallel] {
        if strength_at(species, property, moisture).is_err() {
            let state = species.property_at(property, moisture, Fallback::Estimate);
            notes.push(match state {
                Ok(value) if !estimated(species, property, moisture) => {
                    format!("{property} is {}", value.basis)
                }
                _ => format!(
                    "{property} is estimated from specific gravity (Wood Handbook, Table 5-11), as the table has none"
                ),
            });
        }
    }
    if let Ok(value) = known(Property::ModulusOfRupture)
        && matches!(
            value.basis,
            Basis::Equation | Basis::EquationBelowRange | Basis::Estimate { .. }
        )
    {
        notes.push(format!("the table's values are {}", value.basis));
    }
    if matches!(test.section, BendSection::Round { .. }) {
        notes.push(
            "the table's modulus of rupture is of square sections; a round one that yields has more".to_owned(),
        );
    }
    notes
}

/// Whether Table 5-11 stands for a value that the species' row at this moisture lacks.
fn estimated(species: &Species, property: Property, moisture: f64) -> bool {
    let green = (species.green.as_ref()).filter(|_| moisture >= species.intersection_percent());
    green.is_some_and(|g| g.get(property).is_none()) || species.dry.get(property).is_none()
}

impl fmt::Display for BendReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_test(f)?;
        self.fmt_moduli(f)?;
        self.fmt_failure(f)
    }
}

impl BendReport {
    /// Writes the wood, the specimen and the model.
    fn fmt_test(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "wood      {} ({}) at {} % moisture{}, {}",
            self.species,
            self.scientific_name,
            self.moisture_percent,
            if self.modulus_of_rupture_pa.basis == Some(Basis::TableGreen) {
                " (green)"
            } else {
                ""
            },
            self.source
        )?;
        let section = match self.section {
            "round" => format!("{} mm round", short(self.height_m)),
            _ => format!("{} x {} mm", short(self.width_m), short(self.height_m)),
        };
        writeln!(
            f,
            "specimen  {section}, {} mm long, on a span of {} mm",
            short(self.length_m),
            short(self.span_m)
        )?;
        writeln!(
            f,
            "model     {} rods with edges of {:.2} mm, seed {}",
            self.rods,
            self.edge_m * 1e3,
            self.seed
        )
    }

    /// Writes moduli and strengths beside those of the table.
    fn fmt_moduli(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{:30}{:>9}{:>9}{:>12}",
            "", "test", "table", "deviation"
        )?;
        for (name, compared, scale, unit) in [
            (
                "modulus of elasticity",
                &self.modulus_of_elasticity_pa,
                1e9,
                "GPa",
            ),
            (
                "modulus of rupture",
                &self.modulus_of_rupture_pa,
                1e6,
                "MPa",
            ),
            (
                "work to maximum load",
                &self.work_to_maximum_load_j_per_m3,
                1e3,
                "kJ/m³",
            ),
        ] {
            let table = compared
                .table
                .map_or("-".to_owned(), |t| format!("{:.2}", t / scale));
            let off = compared
                .ratio
                .map_or("-".to_owned(), |r| format!("{:+.1} %", 100.0 * (r - 1.0)));
            let own = compared.test / scale;
            writeln!(
                f,
                "{:30}{own:>9.2}{table:>9}{off:>12}",
                format!("{name}, {unit}")
            )?;
        }
        writeln!(f)
    }

    /// Writes how the specimen failed, and the notes.
    fn fmt_failure(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = |p: &Failing| {
            let (load, deflection) = (p.load_n * 1e-3, p.deflection_m * 1e3);
            format!("{load:.3} kN at {deflection:.2} mm")
        };
        writeln!(f, "maximum   {}", at(&self.maximum))?;
        if let Some(p) = &self.first_yield {
            writeln!(f, "yields    from {}", at(p))?;
        }
        if let Some(p) = &self.first_break {
            writeln!(f, "breaks    from {}", at(p))?;
        }
        writeln!(
            f,
            "ended     {}; in all {} edges yielded, {} rods and {} bonds broke",
            self.ended, self.yielded, self.rods_broken, self.bonds_broken
        )?;
        for (k, phase) in self.sequence.iter().take(MAX_PRINTED_PHASES).enumerate() {
            let head = if k == 0 { "sequence" } else { "" };
            writeln!(f, "{head:10}{}", phase_line(phase))?;
        }
        if self.sequence.len() > MAX_PRINTED_PHASES {
            writeln!(
                f,
                "{:10}and {} more of that kind",
                "",
                self.sequence.len() - MAX_PRINTED_PHASES
            )?;
        }
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        Ok(())
    }
}

/// A length in millimetres, no finer than a micrometre.
pub(crate) fn short(metres: f64) -> String {
    let text = format!("{:.3}", metres * 1e3);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Returns a phase as a line of the printed report.
fn phase_line(phase: &Phase) -> String {
    let what = match (phase.kind, phase.count) {
        (EventKind::RodYielded, 1) => "an edge yields in compression".to_owned(),
        (EventKind::RodYielded, n) => format!("{n} edges yield in compression"),
        (EventKind::RodBroke, 1) => "a rod breaks in tension".to_owned(),
        (EventKind::RodBroke, n) => format!("{n} rods break in tension"),
        (EventKind::BondBroke, 1) => "a bond breaks".to_owned(),
        (EventKind::BondBroke, n) => format!("{n} bonds break"),
    };
    let range = |[a, b]: [f64; 2], scale: f64, digits: usize| {
        let [a, b] = [a, b].map(|x| {
            let text = format!("{:.digits$}", x * scale);
            // Nothing has no sign.
            match text.strip_prefix('-') {
                Some(rest) if rest.chars().all(|c| "0.".contains(c)) => rest.to_owned(),
                _ => text,
            }
        });
        if a == b { a } else { format!("{a} to {b}") }
    };
    format!(
        "{what}: at {} mm, {} kN; {} mm along, {} mm high",
        range(phase.deflection_m, 1e3, 2),
        range(phase.load_n, 1e-3, 3),
        range(phase.along_m, 1e3, 0),
        range(phase.height_m, 1e3, 1)
    )
}
