//! What a run shows over time and over deflection: its tables as curves.

use crate::curve::Curve;
use crate::store::{EnergyRow, ForceRow};
use glam::DVec3;

/// Smaller displacements (m) and rotations (degrees) count as none.
const MIN_MOTION: f64 = 1e-9;

/// A curve of energies: its name, and its energy in a row, J.
type EnergyCurve = (&'static str, fn(&EnergyRow) -> f64);

/// Returns the energies of a run (J) over time (s). That of bodies is left out where there are none.
pub fn energy_curves(rows: &[EnergyRow]) -> Vec<Curve> {
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
            lines.push(Curve { name, points });
        }
    }
    lines
}

/// What holders of the wood do to it: their load over their motion.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCurves {
    /// What the axes measure, with units.
    pub axes: [&'static str; 2],
    /// A curve for each holder that moves.
    pub curves: Vec<Curve>,
}

impl LoadCurves {
    /// Returns force over displacement, or, where nothing is displaced, moment over angle. Without curves where nothing moves.
    pub fn from_rows(rows: &[ForceRow]) -> LoadCurves {
        let displaced = load_curves(rows, |r| (r.displacement, r.force));
        if !displaced.is_empty() {
            return LoadCurves {
                axes: ["way (m)", "force (N)"],
                curves: displaced,
            };
        }
        LoadCurves {
            axes: ["angle (degrees)", "moment (N m)"],
            curves: load_curves(rows, |r| (r.rotation_degrees, r.moment)),
        }
    }
}

/// Returns a curve for each holder that moves: how far it is along the direction of its greatest motion, and its load on
/// the wood in that direction. `motion_and_load` returns both as vectors.
fn load_curves(
    rows: &[ForceRow],
    motion_and_load: impl Fn(&ForceRow) -> (DVec3, DVec3),
) -> Vec<Curve> {
    let mut holders: Vec<(&str, Vec<(DVec3, DVec3)>)> = Vec::new();
    for row in rows {
        let pair = motion_and_load(row);
        match holders.iter_mut().find(|h| h.0 == row.holder) {
            Some(holder) => holder.1.push(pair),
            None => holders.push((&row.holder, vec![pair])),
        }
    }
    let mut curves = Vec::new();
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
        curves.push(Curve {
            name: name.to_owned(),
            points: points.collect(),
        });
    }
    curves
}
