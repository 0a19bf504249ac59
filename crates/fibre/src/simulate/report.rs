//! The report of a simulation.

use super::error::SimulateError;
use super::tissue_report::TissueReport;
use crate::event::{Event, EventKind};
use crate::outcome::{Outcome, OutcomeRecords, WoodAtStart};
use crate::scene::{AssembledScene, Scene};
use crate::solvers::Buckling;
use crate::store::{EnergyRow, RunStore};
use crate::world::World;
use serde::Serialize;

/// The means over this fraction of the rows at either end of the energy table are compared: one in so many.
const END_FRACTION: usize = 10;

/// How far the energy is out of balance: all that rods and bodies have and have lost, less what was put in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EnergyDrift {
    /// Largest energy that there was to conserve: the balance and all work up to then, J.
    pub most_j: f64,
    /// Mean of the balance over the last tenth of the rows less that over the first tenth, J.
    pub drift_j: f64,
    /// Largest difference of the balance from its start, J.
    pub largest_j: f64,
    /// Largest fall of what the solver's method takes from the motion: so much energy it has made, J.
    pub made_j: f64,
}

/// Returns by how much a sequence falls most below what it was before.
fn largest_fall(values: impl Iterator<Item = f64>) -> f64 {
    let (mut highest, mut fall) = (f64::NEG_INFINITY, 0.0);
    for value in values {
        highest = f64::max(highest, value);
        fall = f64::max(fall, highest - value);
    }
    fall
}

/// A method that makes more than this fraction of the energy there is is said to.
const MADE_FRACTION: f64 = 1e-3;
/// Less energy than this, J, is rounding: no fraction of it means anything.
const ROUNDING_ENERGY: f64 = 1e-9;

impl EnergyDrift {
    fn from_rows(rows: &[EnergyRow]) -> EnergyDrift {
        let balance: Vec<f64> = rows.iter().map(EnergyRow::balance).collect();
        let Some(&start) = balance.first() else {
            return EnergyDrift::default();
        };
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let end = balance.len().div_ceil(END_FRACTION);
        let (first, last) = (&balance[..end], &balance[balance.len() - end..]);
        let put_in = |row: &EnergyRow| row.ledger.work + row.contact_work;
        EnergyDrift {
            most_j: (rows.iter().zip(&balance)).fold(0.0, |m, (r, b)| f64::max(m, put_in(r) + b)),
            drift_j: mean(last) - mean(first),
            largest_j: balance
                .iter()
                .fold(0.0, |m, b| f64::max(m, (b - start).abs())),
            made_j: largest_fall(rows.iter().map(|r| r.ledger.dissipated)),
        }
    }
}

/// The end of a run in which the wood buckles. Only the quasi-static solver ends there: the others follow the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Buckled {
    /// Time of the last stable equilibrium, s.
    pub time_s: f64,
    /// The largest force of a clamp then, N.
    pub load_n: f64,
    /// Where the wood moves most as it buckles, in m from the stem's base.
    pub place_m: f64,
}

impl Buckled {
    pub(super) fn new(buckling: &Buckling, fraction: &[f64], length: f64) -> Self {
        Buckled {
            time_s: buckling.time,
            load_n: buckling.load,
            place_m: length
                * fraction
                    .get(buckling.vertex as usize)
                    .copied()
                    .unwrap_or(0.0),
        }
    }
}

impl std::fmt::Display for Buckled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the wood buckles at {:.4} s, under {:.5} N (the largest force of a clamp), and gives way most at {:.3} m: under \
             more load it would not stay in its equilibrium, and the run ends here; to see where it goes, take the solver \
             interactive or implicit, and push it a little to the side, as no wood is quite straight",
            self.time_s, self.load_n, self.place_m
        )
    }
}

/// The report of a simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulateReport {
    /// What the scene shows, in its own words.
    pub about: String,
    /// Rods at the start.
    pub rods: usize,
    /// Vertices at the start.
    pub vertices: usize,
    /// Bonds at the start.
    pub bonds: usize,
    /// Length of the stem, m.
    pub length_m: f64,
    /// Area of the rods' section, m².
    pub section_m2: f64,
    /// Whether rods resist twist.
    pub twist: bool,
    /// Name of the solver.
    pub solver: String,
    /// Length of its last step, s.
    pub step_s: f64,
    /// Largest stable step, s; `None` where there is no limit.
    pub limit_s: Option<f64>,
    /// Number of steps taken.
    pub steps: u64,
    /// Time reached, s.
    pub time_s: f64,
    /// Frames recorded.
    pub frames: u64,
    /// Number of breaks of rods, each of which may break in several places, of edges that yielded, and of bonds that broke.
    pub broke: [u64; 3],
    /// Time of the first break, s.
    pub first_break_s: Option<f64>,
    /// Energy that breaking took, J.
    pub fracture_loss_j: f64,
    /// How well energy was conserved.
    pub energy: EnergyDrift,
    /// Where the wood buckles; the run then ends before its duration.
    pub buckling: Option<Buckled>,
    /// What became of the wood; `None` until the run is complete.
    pub outcome: Option<Outcome>,
    /// Files written; none for a run in memory.
    pub files: Vec<String>,
    /// The tissues that rods lie in, from the inside out.
    pub wood: Vec<TissueReport>,
    /// What of the input's mesh has no rods, a sentence each.
    pub notes: Vec<String>,
}

impl std::fmt::Display for SimulateReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "scene    {}", self.about)?;
        let twist = if self.twist {
            "with twist"
        } else {
            "without twist"
        };
        writeln!(
            f,
            "wood     {} rods, {} vertices, {} bonds on {:.3} m, {twist}",
            self.rods, self.vertices, self.bonds, self.length_m
        )?;
        for tissue in self.wood.iter().filter(|_| self.wood.len() > 1) {
            writeln!(f, "tissue   {tissue}")?;
        }
        let limit = self
            .limit_s
            .map_or(String::new(), |l| format!(" of at most {:.3} µs", l * 1e6));
        writeln!(
            f,
            "solver   {}, {} steps of {:.3} µs{limit}",
            self.solver,
            self.steps,
            self.step_s * 1e6
        )?;
        let first = self
            .first_break_s
            .map_or(String::new(), |t| format!(", first at {t:.4} s"));
        let [breaks, yields, bonds] = self.broke;
        // A rod may break in several places.
        let rods = match self.outcome.as_ref().map(|o| o.rods_broken as u64) {
            Some(rods) if rods < breaks => format!("{rods} rods in {breaks} places"),
            _ => format!("{breaks} rods"),
        };
        writeln!(
            f,
            "broke    {rods}, {bonds} bonds; {yields} edges yielded{first}; {:.4} J lost",
            self.fracture_loss_j
        )?;
        if let Some(outcome) = &self.outcome {
            write!(f, "{outcome}")?;
        }
        let energy = &self.energy;
        if energy.most_j > ROUNDING_ENERGY {
            writeln!(
                f,
                "energy   {:.4} J, of which the balance drifts by {:+.3} %, and is off by at most {:.3} %",
                energy.most_j,
                100.0 * energy.drift_j / energy.most_j,
                100.0 * energy.largest_j / energy.most_j
            )?;
        }
        if energy.most_j > ROUNDING_ENERGY && energy.made_j > MADE_FRACTION * energy.most_j {
            writeln!(
                f,
                "note     the solver's method made {:.4} J, {:.2} % of the energy; shorter steps make less",
                energy.made_j,
                100.0 * energy.made_j / energy.most_j
            )?;
        }
        writeln!(f, "time     {:.4} s in {} frames", self.time_s, self.frames)?;
        if let Some(buckling) = &self.buckling {
            writeln!(f, "note     {buckling}")?;
        }
        for note in &self.notes {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}

/// Returns the report of a run that begins.
pub(super) fn begin_report(
    scene: &Scene,
    assembled: &AssembledScene,
    (wood, notes): (Vec<TissueReport>, Vec<String>),
) -> SimulateReport {
    let bundle = &assembled.world.bundle;
    SimulateReport {
        about: scene.about.clone(),
        rods: bundle.rods(),
        vertices: bundle.vertices(),
        bonds: bundle.bonds.len(),
        length_m: assembled.length,
        section_m2: assembled.world.bundle.area.iter().sum(),
        twist: bundle.twisting,
        solver: scene.solver.word().to_owned(),
        step_s: 0.0,
        limit_s: None,
        steps: 0,
        time_s: 0.0,
        frames: 0,
        broke: [0; 3],
        first_break_s: None,
        fracture_loss_j: 0.0,
        energy: EnergyDrift::default(),
        buckling: None,
        outcome: None,
        files: Vec::new(),
        wood,
        notes,
    }
}

/// Completes the report from the records, so that that of a resumed run is of all of it.
pub(super) fn finish_report(
    report: &mut SimulateReport,
    (start, world): (&WoodAtStart, &World),
    frames: u64,
    store: &dyn RunStore,
) -> Result<(), SimulateError> {
    (report.steps, report.time_s) = (world.state.step, world.state.time);
    report.frames = frames;
    report.fracture_loss_j = world.fracture_loss;
    let events = store.events()?;
    let count = |kind: EventKind| events.iter().filter(|e| e.kind == kind).count() as u64;
    report.broke = [
        count(EventKind::RodBroke),
        count(EventKind::RodYielded),
        count(EventKind::BondBroke),
    ];
    let is_break = |e: &&Event| e.kind != EventKind::RodYielded;
    report.first_break_s = events.iter().find(is_break).map(|e| e.time);
    let energies = store.energies()?;
    report.energy = EnergyDrift::from_rows(&energies);
    let records = OutcomeRecords {
        events: &events,
        energies: &energies,
        forces: &store.forces()?,
    };
    report.outcome = Some(start.outcome(&world.bundle, &world.state, &records));
    report.files = store.outputs();
    Ok(())
}
