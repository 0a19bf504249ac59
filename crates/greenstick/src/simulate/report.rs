//! What a simulation tells at its end.

use super::charts::{Table, table};
use super::growing::{ENERGIES, EVENTS, GROWING};
use super::{CHECKPOINT, Run, SimulateError, SimulateRequest};
use crate::files::FileError;
use greenstick_fibre::scene::AssembledScene;
use serde::Serialize;
use std::fs;

/// Rows of the energy table at either end whose mean is compared, of all.
const END: usize = 10;

/// What is left of the energy's balance: all that rods and bodies have and have lost, less what was put in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EnergyDrift {
    /// Most energy that there was to keep: the balance at the start and all work since, J.
    pub most_j: f64,
    /// Mean of the balance over the last tenth of the rows less that over the first, J.
    pub drift_j: f64,
    /// Largest difference of the balance from its start, J.
    pub largest_j: f64,
}

/// Less energy than this, J, is rounding: a part of it would tell nothing.
const NOTHING: f64 = 1e-9;

impl EnergyDrift {
    fn of(table: &Table) -> EnergyDrift {
        let balance = table.column("balance_J");
        let (work, pushed) = (table.column("work_J"), table.column("contact_work_J"));
        let Some(&start) = balance.first() else {
            return EnergyDrift::default();
        };
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let end = balance.len().div_ceil(END);
        let (first, last) = (&balance[..end], &balance[balance.len() - end..]);
        let most = work.iter().zip(&pushed).zip(&balance);
        EnergyDrift {
            most_j: most.fold(0.0, |m, ((w, p), b)| f64::max(m, w + p + b)),
            drift_j: mean(last) - mean(first),
            largest_j: balance
                .iter()
                .fold(0.0, |m, b| f64::max(m, (b - start).abs())),
        }
    }
}

/// What a simulation did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulateReport {
    /// What the scene shows.
    pub about: String,
    /// Rods at the start.
    pub rods: usize,
    /// Vertices at the start.
    pub vertices: usize,
    /// Bonds at the start.
    pub bonds: usize,
    /// Length of the stem, m.
    pub length_m: f64,
    /// Whether rods resist twist.
    pub twist: bool,
    /// Solver.
    pub solver: String,
    /// Its last step, s.
    pub step_s: f64,
    /// Largest stable step, s; none where there is no limit.
    pub limit_s: Option<f64>,
    /// Steps done.
    pub steps: u64,
    /// Time reached, s.
    pub time_s: f64,
    /// Frames written.
    pub frames: u64,
    /// Rods that broke, edges that yielded, bonds that broke.
    pub broke: [u64; 3],
    /// Time of the first break, s.
    pub first_break_s: Option<f64>,
    /// Energy that breaking took, J.
    pub fracture_loss_j: f64,
    /// How well energy was kept.
    pub energy: EnergyDrift,
    /// Files written.
    pub files: Vec<String>,
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
        let [rods, yields, bonds] = self.broke;
        writeln!(
            f,
            "broke    {rods} rods, {bonds} bonds; {yields} edges yielded{first}; {:.4} J lost",
            self.fracture_loss_j
        )?;
        let energy = &self.energy;
        if energy.most_j > NOTHING {
            writeln!(
                f,
                "energy   {:.4} J, of which the balance drifts by {:+.3} %, and is off by at most {:.3} %",
                energy.most_j,
                100.0 * energy.drift_j / energy.most_j,
                100.0 * energy.largest_j / energy.most_j
            )?;
        }
        writeln!(f, "time     {:.4} s in {} frames", self.time_s, self.frames)
    }
}

pub(super) fn begin_report(request: &SimulateRequest, made: &AssembledScene) -> SimulateReport {
    let bundle = &made.world.bundle;
    SimulateReport {
        about: request.scene.about.clone(),
        rods: bundle.rods(),
        vertices: bundle.vertices(),
        bonds: bundle.bonds.len(),
        length_m: made.length,
        twist: bundle.twisting,
        solver: request.scene.solver.name().to_owned(),
        step_s: 0.0,
        limit_s: None,
        steps: 0,
        time_s: 0.0,
        frames: 0,
        broke: [0; 3],
        first_break_s: None,
        fracture_loss_j: 0.0,
        energy: EnergyDrift::default(),
        files: Vec::new(),
    }
}

/// Takes counts from the files, so that those of a resumed run are of all of it.
pub(super) fn finish_report(report: &mut SimulateReport, run: &Run) -> Result<(), SimulateError> {
    let world = &run.made.world;
    (report.steps, report.time_s) = (world.state.step, world.state.time);
    report.frames = run.progress.frames;
    report.fracture_loss_j = world.fracture_loss;
    let path = run.request.folder.join(GROWING[EVENTS]);
    let text =
        fs::read_to_string(&path).map_err(|source| FileError::Unreadable { path, source })?;
    for line in text.lines().skip(1) {
        let mut cells = line.split(',');
        let time = cells.next().and_then(|t| t.parse().ok());
        match cells.next() {
            Some("rod_broke") => report.broke[0] += 1,
            Some("rod_yielded") => report.broke[1] += 1,
            Some("bond_broke") => report.broke[2] += 1,
            _ => {}
        }
        if !line.contains("rod_yielded") && report.first_break_s.is_none() {
            report.first_break_s = time;
        }
    }
    report.energy = EnergyDrift::of(&table(&run.request.folder, ENERGIES)?);
    report.files = GROWING
        .iter()
        .chain(&[CHECKPOINT, "scene.toml"])
        .map(|n| run.request.folder.join(n).display().to_string())
        .collect();
    Ok(())
}
