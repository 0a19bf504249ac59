//! Charts of a run: energies over time, loads over deflection.

use glam::DVec3;
use greenstick_fibre::store::{EnergyRow, ForceRow};
use greenstick_picture::{Chart, Line, Picture};

/// Smaller displacements (m) and rotations (degrees) count as none.
const MIN_MOTION: f64 = 1e-9;
/// Size of a chart, pixels.
const SIZE: [u32; 2] = [1600, 800];

/// A curve of the energy chart: its name, and its energy in a row, J.
type EnergyCurve = (&'static str, fn(&EnergyRow) -> f64);

/// Draws the energies of a run over time.
pub fn energy_chart(rows: &[EnergyRow]) -> Picture {
    let curves: [EnergyCurve; 7] = [
        ("kinetic", |r| r.rods.kinetic),
        ("stretch", |r| r.rods.stretch),
        ("bend, twist", |r| r.rods.bend + r.rods.twist),
        ("bonds", |r| r.rods.bond_transverse + r.rods.bond_shear),
        ("fracture", |r| r.fracture_loss),
        ("bodies", |r| r.bodies),
        ("balance", |r| r.balance()),
    ];
    let mut lines = Vec::new();
    for (name, energy) in curves {
        let points: Vec<[f64; 2]> = rows.iter().map(|r| [r.time, energy(r)]).collect();
        if name != "bodies" || points.iter().any(|p| p[1] != 0.0) {
            let name = name.to_owned();
            lines.push(Line { name, points });
        }
    }
    Chart {
        title: "Energies".to_owned(),
        axes: ["time (s)".to_owned(), "energy (J)".to_owned()],
        lines,
    }
    .draw(SIZE[0], SIZE[1])
}

/// Draws the load over the deflection of everything that moves: force over displacement, or, where nothing is displaced,
/// moment over angle. Returns `None` where nothing moves.
pub fn load_chart(rows: &[ForceRow]) -> Option<Picture> {
    let displaced = load_lines(rows, |r| (r.displacement, r.force));
    let (axes, lines) = if displaced.is_empty() {
        let rotated = load_lines(rows, |r| (r.rotation_degrees, r.moment));
        (["angle (degrees)", "moment (N m)"], rotated)
    } else {
        (["way (m)", "force (N)"], displaced)
    };
    let chart = Chart {
        title: "Load".to_owned(),
        axes: axes.map(str::to_owned),
        lines,
    };
    (!chart.lines.is_empty()).then(|| chart.draw(SIZE[0], SIZE[1]))
}

/// Returns a line for each holder that moves: how far it is along the direction of its greatest motion, and its load on
/// the wood in that direction. `motion_and_load` returns both as vectors.
fn load_lines(
    rows: &[ForceRow],
    motion_and_load: impl Fn(&ForceRow) -> (DVec3, DVec3),
) -> Vec<Line> {
    let mut holders: Vec<(&str, Vec<(DVec3, DVec3)>)> = Vec::new();
    for row in rows {
        let pair = motion_and_load(row);
        match holders.iter_mut().find(|h| h.0 == row.holder) {
            Some(holder) => holder.1.push(pair),
            None => holders.push((&row.holder, vec![pair])),
        }
    }
    let mut lines = Vec::new();
    for (name, pairs) in holders {
        let greatest = pairs.iter().fold(DVec3::ZERO, |greatest, &(motion, _)| {
            if motion.length() > greatest.length() {
                motion
            } else {
                greatest
            }
        });
        if greatest.length() <= MIN_MOTION {
            continue;
        }
        let Some(direction) = greatest.try_normalize() else {
            continue;
        };
        let points = pairs
            .iter()
            .map(|(motion, load)| [motion.dot(direction), load.dot(direction)]);
        lines.push(Line {
            name: name.to_owned(),
            points: points.collect(),
        });
    }
    lines
}
