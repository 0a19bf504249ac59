//! Rows of `forces.csv`: the forces of clamps and moved bodies on the wood, and how far they have moved.

use crate::bodies::{Bodies, BodyMotion};
use crate::loads::{ClampForce, Pose};
use crate::reactions::clamp_forces;
use crate::rotation::to_rotation_vector;
use crate::world::World;
use glam::DVec3;

/// The first line of `forces.csv`.
pub(super) const FORCE_HEADER: &str = "time_s,holder,moved_x_m,moved_y_m,moved_z_m,turned_x_deg,turned_y_deg,turned_z_deg,\
force_x_N,force_y_N,force_z_N,moment_x_Nm,moment_y_Nm,moment_z_Nm\n";

/// The force of a clamp or body on the wood at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceRow {
    /// Time, s.
    pub time: f64,
    /// `clamp 0`, or a body's name, or `body 0`; without characters that would end a cell.
    pub holder: String,
    /// Its displacement, m.
    pub displacement: DVec3,
    /// Its rotation vector: along the axis, as long as the angle in degrees.
    pub rotation_degrees: DVec3,
    /// Force on the wood, N.
    pub force: DVec3,
    /// Moment on the wood about the holder's present centre, N m.
    pub moment: DVec3,
}

impl ForceRow {
    /// Takes the rows of a world: those of clamps at the onsets of cracks since the last call ([`World::onsets`]), then the
    /// present ones of clamps and of bodies whose motion is prescribed. A clamp's force is against the forces of the wood and the
    /// loads, without the inertia of what it holds; a body's force is the mean since the last call, `interval` seconds ago.
    pub fn take(world: &mut World, bodies: &mut Bodies, interval: f64) -> Vec<ForceRow> {
        let time = world.state.time;
        let mut rows = Vec::new();
        for onset in std::mem::take(&mut world.onsets) {
            rows.extend(clamp_rows(world, onset.time, &onset.clamps));
        }
        rows.extend(clamp_rows(world, time, &clamp_forces(world)));
        let impulses = bodies.take_impulses();
        for (number, (body, _)) in bodies.iter().enumerate() {
            let BodyMotion::Prescribed(motion) = &body.motion else {
                continue;
            };
            let name = if body.name.is_empty() {
                format!("body {number}")
            } else {
                (body.name.chars())
                    .map(|c| if ",\"\n\r".contains(c) { ' ' } else { c })
                    .collect()
            };
            let per = if interval > 0.0 { -1.0 / interval } else { 0.0 };
            let given = impulses.get(number).copied().unwrap_or_default();
            let (force, moment) = (given.linear * per, given.angular * per);
            rows.push(row(time, name, motion.pose(time), [force, moment]));
        }
        rows
    }

    /// Returns the row as a line, with its end.
    pub fn line(&self) -> String {
        let vectors = [
            self.displacement,
            self.rotation_degrees,
            self.force,
            self.moment,
        ];
        let numbers = vectors.map(|v| v.to_array()).concat();
        let cells = (numbers.iter()).fold(String::new(), |text, n| text + &format!(",{n}"));
        format!("{},{}{cells}\n", self.time, self.holder)
    }
}

fn row(time: f64, holder: String, pose: Pose, [force, moment]: [DVec3; 2]) -> ForceRow {
    ForceRow {
        time,
        holder,
        displacement: pose.translation,
        rotation_degrees: to_rotation_vector(pose.rotation).map(f64::to_degrees),
        force,
        moment,
    }
}

fn clamp_rows(world: &World, time: f64, forces: &[ClampForce]) -> impl Iterator<Item = ForceRow> {
    let clamps = world.loads.clamps.iter().zip(forces).enumerate();
    clamps.map(move |(number, (clamp, f))| {
        let pose = clamp.motion.pose(time);
        row(time, format!("clamp {number}"), pose, [f.force, f.moment])
    })
}
