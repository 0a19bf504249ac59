//! What is made of a run's files: frames, and charts of energies and loads.

use super::SimulateError;
use super::growing::{ENERGIES, EVENTS, FORCES, FRAMES, GROWING};
use crate::files::FileError;
use glam::DVec3;
use greenstick_fibre::Cause;
use greenstick_fibre::store::{Frame, FrameReader};
use greenstick_picture::{Chart, Line, Picture};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

/// Upwards in a scene.
pub const UP: DVec3 = DVec3::Z;

/// Movements and turns below these are none, m and degrees.
const UNMOVED: f64 = 1e-9;

/// The frames of a run, in order.
///
/// # Errors
/// [`SimulateError`] where they are not there or damaged.
pub fn frames(folder: &Path) -> Result<Vec<Frame>, SimulateError> {
    let path = folder.join(GROWING[FRAMES]);
    let wrong = |error| SimulateError::Store {
        path: path.clone(),
        error,
    };
    let file = File::open(&path).map_err(|e| wrong(e.into()))?;
    FrameReader::new(BufReader::new(file))
        .map_err(wrong)?
        .collect::<Result<_, _>>()
        .map_err(wrong)
}

/// Why vertices of the unbroken bundle broke, as a run's events tell.
///
/// # Errors
/// [`SimulateError`] where they cannot be read.
pub(crate) fn causes(folder: &Path) -> Result<BTreeMap<u32, Cause>, SimulateError> {
    let path = folder.join(GROWING[EVENTS]);
    let text =
        fs::read_to_string(&path).map_err(|source| FileError::Unreadable { path, source })?;
    let table = Table::parse(&text);
    let (kinds, causes) = (table.words("kind"), table.words("cause"));
    let vertices = table.column("vertex");
    let rows = kinds.zip(causes).zip(vertices);
    Ok(rows
        .filter(|((kind, _), vertex)| *kind == "rod_broke" && *vertex >= 0.0)
        .map(|((_, cause), vertex)| {
            let cause = match cause {
                "compression" => Cause::Compression,
                _ => Cause::Tension,
            };
            (vertex as u32, cause)
        })
        .collect())
}

/// A table with named columns.
pub(super) struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn parse(text: &str) -> Table {
        let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines();
        let names = lines.next().map(cells).unwrap_or_default();
        let whole = |row: &Vec<String>| row.len() == names.len();
        Table {
            rows: lines.map(cells).filter(whole).collect(),
            names,
        }
    }

    /// The cells of a column; nothing where there is no such column.
    fn words(&self, name: &str) -> impl Iterator<Item = &str> {
        let at = self.names.iter().position(|n| n == name);
        at.into_iter()
            .flat_map(|at| self.rows.iter().map(move |row| row[at].as_str()))
    }

    /// The numbers of a column; NaN where a cell is none, nothing where there is no such column.
    pub(super) fn column(&self, name: &str) -> Vec<f64> {
        let Some(at) = self.names.iter().position(|n| n == name) else {
            return Vec::new();
        };
        let number = |row: &Vec<String>| row[at].parse().unwrap_or(f64::NAN);
        self.rows.iter().map(number).collect()
    }

    /// The rows of each word in a column, in order of the words' first rows.
    fn parts(self, name: &str) -> Vec<(String, Table)> {
        let at = self.names.iter().position(|n| n == name);
        let mut parts: Vec<(String, Table)> = Vec::new();
        for row in self.rows {
            let word = at.map_or(String::new(), |a| row[a].clone());
            let names = self.names.clone();
            match parts.iter_mut().find(|p| p.0 == word) {
                Some(part) => part.1.rows.push(row),
                None => parts.push((
                    word,
                    Table {
                        names,
                        rows: vec![row],
                    },
                )),
            }
        }
        parts
    }
}

/// One of the growing tables of a run.
pub(super) fn table(folder: &Path, which: usize) -> Result<Table, SimulateError> {
    let path = folder.join(GROWING[which]);
    let text =
        fs::read_to_string(&path).map_err(|source| FileError::Unreadable { path, source })?;
    Ok(Table::parse(&text))
}

/// Energies over time, from the table of a run.
///
/// # Errors
/// [`SimulateError`] where the table is not there.
pub fn energy_chart(folder: &Path) -> Result<Picture, SimulateError> {
    let table = table(folder, ENERGIES)?;
    // What a line of the picture adds up.
    let curves: [(&str, &[&str]); 7] = [
        ("kinetic", &["kinetic_J"]),
        ("stretch", &["stretch_J"]),
        ("bend, twist", &["bend_J", "twist_J"]),
        ("bonds", &["bond_transverse_J", "bond_shear_J"]),
        ("fracture", &["fracture_loss_J"]),
        ("bodies", &["body_J"]),
        ("balance", &["balance_J"]),
    ];
    let time = table.column("time_s");
    let mut lines = Vec::new();
    for (name, columns) in curves {
        let parts: Vec<Vec<f64>> = columns.iter().map(|c| table.column(c)).collect();
        let sum = |i: usize| parts.iter().filter_map(|p| p.get(i)).sum::<f64>();
        let points: Vec<[f64; 2]> = (0..time.len()).map(|i| [time[i], sum(i)]).collect();
        if name != "bodies" || points.iter().any(|p| p[1] != 0.0) {
            let name = name.to_owned();
            lines.push(Line { name, points });
        }
    }
    Ok(Chart {
        title: "Energies".to_owned(),
        axes: ["time (s)".to_owned(), "energy (J)".to_owned()],
        lines,
    }
    .draw(1600, 800))
}

/// Load over deflection of everything that is moved: force over way, or, where nothing is moved but turned, moment over
/// angle. Nothing where nothing moves.
///
/// # Errors
/// [`SimulateError`] where the table is not there.
pub fn load_chart(folder: &Path) -> Result<Option<Picture>, SimulateError> {
    let holders = table(folder, FORCES)?.parts("holder");
    let (moved, turned) = (["moved_", "_m"], ["turned_", "_deg"]);
    let ways = load_lines(&holders, moved, ["force_", "_N"]);
    let (axes, lines) = if ways.is_empty() {
        let turns = load_lines(&holders, turned, ["moment_", "_Nm"]);
        (["angle (degrees)", "moment (N m)"], turns)
    } else {
        (["way (m)", "force (N)"], ways)
    };
    let chart = Chart {
        title: "Load".to_owned(),
        axes: axes.map(str::to_owned),
        lines,
    };
    Ok((!chart.lines.is_empty()).then(|| chart.draw(1600, 800)))
}

/// Of each holder that moves: how far along the way to its last place, and what it bears against the wood along it.
fn load_lines(holders: &[(String, Table)], way: [&str; 2], load: [&str; 2]) -> Vec<Line> {
    let vectors = |table: &Table, [before, after]: [&str; 2]| -> Vec<DVec3> {
        let [x, y, z] = ["x", "y", "z"].map(|a| table.column(&format!("{before}{a}{after}")));
        let count = x.len().min(y.len()).min(z.len());
        (0..count).map(|i| DVec3::new(x[i], y[i], z[i])).collect()
    };
    let mut lines = Vec::new();
    for (name, table) in holders {
        let (way, load) = (vectors(table, way), vectors(table, load));
        let far = way.iter().copied().fold(DVec3::ZERO, |most, w| {
            if w.length() > most.length() { w } else { most }
        });
        let Some(along) = far.try_normalize().filter(|_| far.length() > UNMOVED) else {
            continue;
        };
        let points = way
            .iter()
            .zip(&load)
            .map(|(w, l)| [w.dot(along), l.dot(along)]);
        lines.push(Line {
            name: name.clone(),
            points: points.collect(),
        });
    }
    lines
}
