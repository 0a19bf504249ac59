//! What a fracture test returns, beside what went in.

use super::outcome::FractureOutcome;
use super::specimen::{CrackSystem, FractureTest, FractureTestKind, RodArrangement};
use super::theory::BeamTheory;
use crate::bend_test::short;
use greenstick_wood::species::Species;
use serde::Serialize;
use std::fmt;

/// The process zone should span so many edges.
const MIN_EDGES_IN_ZONE: f64 = 2.0;

/// A number that the test returned beside another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Beside {
    /// Of the test.
    pub test: f64,
    /// What it is compared with.
    pub expected: f64,
    /// The first over the second.
    pub ratio: f64,
}

impl Beside {
    fn new(test: f64, expected: f64) -> Self {
        Beside {
            test,
            expected,
            ratio: test / expected,
        }
    }
}

/// What a fracture test returned. Names end with the unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FractureReport {
    /// `greenstick-fracture-test`.
    pub schema: &'static str,
    /// Version of the schema: it rises when a name changes or goes.
    pub version: u32,
    /// The test.
    pub test: FractureTestKind,
    /// Species.
    pub species: String,
    /// Scientific name.
    pub scientific_name: String,
    /// Table of the species' values.
    pub source: String,
    /// Moisture content, percent.
    pub moisture_percent: f64,
    /// System of the crack.
    pub system: CrackSystem,
    /// Width, m.
    pub width_m: f64,
    /// Height, m.
    pub height_m: f64,
    /// Length from the load to the end, or from support to support, m.
    pub length_m: f64,
    /// Length of the crack at the start, m.
    pub crack_m: f64,
    /// Length of the crack at the end, m.
    pub final_crack_m: f64,
    /// Arrangement of rods.
    pub arrangement: RodArrangement,
    /// Rods of what was tested: a slice where they are in layers.
    pub rods: usize,
    /// Width of what was tested, m.
    pub slice_m: f64,
    /// Distance between rods, m.
    pub spacing_m: f64,
    /// Length of their edges, m.
    pub edge_m: f64,
    /// Seed.
    pub seed: u64,
    /// Energy of fracture of the wood over the area of the crack's plane, J/m²: what went in.
    pub put_in_j_per_m2: f64,
    /// Area of the facets along which the crack runs over that of its plane.
    pub facet_area_ratio: f64,
    /// Energy of fracture by dissipated work over area, J/m².
    pub by_work: Beside,
    /// Energy of fracture by the change of the compliance, P²/(2B) dC/da, J/m². Like the next two it needs a crack that grows
    /// steadily, as in no single-edge notched beam.
    pub by_compliance: Option<Beside>,
    /// Energy of fracture by beam theory from load and crack, J/m².
    pub by_beam_theory: Option<Beside>,
    /// The same with the crack that the compliance tells, so that the process zone counts, J/m².
    pub by_equivalent_crack: Option<Beside>,
    /// Compliance at the start beside that of beam theory, m/N.
    pub compliance_m_per_n: Beside,
    /// The largest load beside that at which a sharp crack begins to grow in beam theory, N.
    pub maximum_load_n: Beside,
    /// Deflection at the largest load, m.
    pub deflection_at_maximum_load_m: f64,
    /// Mean length of the process zone, in which bonds soften, m.
    pub process_zone_m: f64,
    /// Bonds that broke, of what was tested.
    pub bonds_broken: u32,
    /// Energy that bonds beside the crack's plane dissipated over that of all.
    pub dissipated_beside: f64,
    /// Work of the load less energy stored and energy dissipated by bonds, over the work.
    pub energy_balance: f64,
    /// The largest demand on a rod over its strength: above 1 the arms would have broken.
    pub rod_demand: f64,
    /// What limits the test, a sentence each.
    pub notes: Vec<String>,
}

impl FractureReport {
    pub(super) fn new(
        species: &Species,
        moisture: f64,
        test: &FractureTest,
        theory: &BeamTheory,
        outcome: &FractureOutcome,
    ) -> Self {
        let first = outcome.points.first().copied().unwrap_or_default();
        let last = outcome.points.last().copied().unwrap_or_default();
        let put_in = outcome.put_in;
        let demand = outcome.points.iter().fold(0.0, |m, p| p.rod_demand.max(m));
        FractureReport {
            schema: "greenstick-fracture-test",
            version: 1,
            test: test.kind,
            species: species.name.clone(),
            scientific_name: species.scientific_name.clone(),
            source: species.source.clone(),
            moisture_percent: moisture,
            system: test.system,
            width_m: test.width,
            height_m: test.height,
            length_m: test.length,
            crack_m: first.crack,
            final_crack_m: last.crack,
            arrangement: test.arrangement,
            rods: outcome.rods,
            slice_m: outcome.slice,
            spacing_m: test.spacing,
            edge_m: outcome.edge,
            seed: test.seed,
            put_in_j_per_m2: put_in,
            facet_area_ratio: outcome.roughness,
            by_work: Beside::new(outcome.energy_by_work, put_in),
            by_compliance: outcome.steady.map(|s| Beside::new(s.by_compliance, put_in)),
            by_beam_theory: outcome
                .steady
                .map(|s| Beside::new(s.by_beam_theory, put_in)),
            by_equivalent_crack: outcome
                .steady
                .map(|s| Beside::new(s.by_equivalent_crack, put_in)),
            compliance_m_per_n: Beside::new(outcome.compliance, theory.compliance(first.crack)),
            maximum_load_n: Beside::new(outcome.maximum.load, theory.load(put_in, first.crack)),
            deflection_at_maximum_load_m: outcome.maximum.deflection,
            process_zone_m: outcome.process_zone,
            bonds_broken: last.bonds_broken,
            dissipated_beside: outcome.dissipated_beside,
            energy_balance: (last.dissipated() - last.dissipated_by_bonds) / last.work,
            rod_demand: demand,
            notes: notes(outcome, demand),
        }
    }
}

fn notes(outcome: &FractureOutcome, demand: f64) -> Vec<String> {
    let mut notes = Vec::new();
    let edges = outcome.process_zone / outcome.edge;
    if edges < MIN_EDGES_IN_ZONE {
        notes.push(format!(
            "the process zone spans {edges:.1} edges: with fewer than {MIN_EDGES_IN_ZONE} the crack jumps from one to the \
             next and takes more energy than went in"
        ));
    }
    if demand > 1.0 {
        notes.push(format!(
            "the arms bear {demand:.2} times their strength along the grain: a real specimen would have to be higher"
        ));
    }
    if outcome.roughness > 1.0 + 1e-9 {
        notes.push(format!(
            "the facets along which the crack runs have {:.2} times the area of its plane; bonds have the energy that \
             goes with {:.2} times, the mean of random cells",
            outcome.roughness,
            RodArrangement::Scattered.roughness()
        ));
    }
    notes
}

impl FractureTestKind {
    fn description(self) -> &'static str {
        match self {
            FractureTestKind::DoubleCantileverBeam => "double cantilever beam (mode I, opening)",
            FractureTestKind::EndNotchedFlexure => "end-notched flexure (mode II, sliding)",
            FractureTestKind::SingleEdgeNotchedBeam => "single-edge notched beam (mode I, opening)",
        }
    }
}

impl FractureTestKind {
    /// What its stiffness and largest load stand beside.
    pub(super) fn theory(self) -> &'static str {
        match self {
            FractureTestKind::SingleEdgeNotchedBeam => "sharp crack",
            _ => "beam theory",
        }
    }
}

impl fmt::Display for FractureReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_test(f)?;
        self.fmt_energies(f)?;
        writeln!(
            f,
            "\nmaximum   {:.1} N at {:.2} mm",
            self.maximum_load_n.test,
            self.deflection_at_maximum_load_m * 1e3
        )?;
        writeln!(
            f,
            "crack     from {:.1} to {:.1} mm with a process zone of {:.1} mm, in which bonds soften; {} bonds broke",
            self.crack_m * 1e3,
            self.final_crack_m * 1e3,
            self.process_zone_m * 1e3,
            self.bonds_broken
        )?;
        writeln!(
            f,
            "balance   work less energy stored and dissipated by bonds is {:+.3} % of the work; {:.1} % was dissipated beside \
             the crack's plane",
            100.0 * self.energy_balance,
            100.0 * self.dissipated_beside
        )?;
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        Ok(())
    }
}

impl FractureReport {
    /// Writes the wood, the specimen and the model.
    fn fmt_test(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "wood      {} ({}) at {} % moisture, {}",
            self.species, self.scientific_name, self.moisture_percent, self.source
        )?;
        writeln!(
            f,
            "test      {}, system {}",
            self.test.description(),
            self.system.word().to_uppercase()
        )?;
        let length = match self.test {
            FractureTestKind::DoubleCantileverBeam => "mm long",
            _ => "mm of span",
        };
        writeln!(
            f,
            "specimen  {} mm wide, {} mm high, {} {length}, with a crack of {:.1} mm",
            short(self.width_m),
            short(self.height_m),
            short(self.length_m),
            self.crack_m * 1e3
        )?;
        writeln!(
            f,
            "model     {} rods ({}) {} mm apart with edges of {:.2} mm",
            self.rods,
            self.arrangement.word(),
            short(self.spacing_m),
            self.edge_m * 1e3
        )
    }

    /// Writes energies and loads beside what is expected.
    fn fmt_energies(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = |head: [&str; 2], rows: &[(&str, Option<&Beside>, f64)]| {
            writeln!(
                f,
                "\n{:42}{:>9}{:>13}{:>12}",
                head[0], "test", head[1], "deviation"
            )?;
            for (name, beside, scale) in rows {
                let Some(beside) = beside else { continue };
                writeln!(
                    f,
                    "{name:42}{:>9.1}{:>13.1}{:>12}",
                    beside.test * scale,
                    beside.expected * scale,
                    format!("{:+.1} %", 100.0 * (beside.ratio - 1.0))
                )?;
            }
            Ok(())
        };
        let energies = [
            (
                "  by dissipated work over area, J/m²",
                Some(&self.by_work),
                1.0,
            ),
            ("  by P²/(2B) dC/da, J/m²", self.by_compliance.as_ref(), 1.0),
            (
                "  by beam theory of a sharp crack, J/m²",
                self.by_beam_theory.as_ref(),
                1.0,
            ),
            (
                "  by beam theory and compliance, J/m²",
                self.by_equivalent_crack.as_ref(),
                1.0,
            ),
        ];
        table(["energy of fracture", "put in"], &energies)?;
        table(
            ["", self.test.theory()],
            &[
                (
                    "compliance at the start, µm/N",
                    Some(&self.compliance_m_per_n),
                    1e6,
                ),
                ("largest load, N", Some(&self.maximum_load_n), 1.0),
            ],
        )
    }
}
