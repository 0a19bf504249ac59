//! Rows of `energy.csv` and `events.csv`.

use crate::bodies::Bodies;
use crate::energy::{Energies, energies};
use crate::event::{Cause, Event, EventKind};
use crate::reactions::forces_on;
use crate::solvers::AdvanceReport;
use crate::world::World;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The first line of `energy.csv`.
pub(super) const ENERGY_HEADER: &str = "time_s,kinetic_J,stretch_J,bend_J,twist_J,bond_transverse_J,bond_shear_J,body_J,gravity_J,\
momentum_x_Ns,momentum_y_Ns,momentum_z_Ns,angular_x_Nms,angular_y_Nms,angular_z_Nms,fracture_loss_J,damped_J,\
dissipated_J,work_J,contact_J,contact_loss_J,contact_work_J,balance_J\n";

/// The first line of `events.csv`.
pub(super) const EVENT_HEADER: &str =
    "time_s,kind,rod,vertex,other_rod,x_m,y_m,z_m,cause,demand,energy_J\n";

/// Energy that solvers and loads have taken and given since the start, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLedger {
    /// Dissipated by damping.
    pub damped: f64,
    /// Dissipated by the method.
    pub dissipated: f64,
    /// Work of clamps and loads.
    pub work: f64,
}

impl EnergyLedger {
    /// Adds the energies that a solver reports.
    pub fn add(&mut self, advance: &AdvanceReport) {
        self.damped += advance.damped;
        self.dissipated += advance.dissipated;
        self.work += advance.work;
    }
}

/// A row of the energy table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyRow {
    /// Time, s.
    pub time: f64,
    /// Energies of the rods.
    pub rods: Energies,
    /// Energy of free bodies, with the potential energy of their weight, J.
    pub bodies: f64,
    /// Potential energy of the rods' weight, J, 0 at the origin. Its change is also part of the work of loads.
    pub gravity: f64,
    /// Momentum of rods and free bodies, N s.
    pub momentum: DVec3,
    /// Angular momentum about the origin, N m s.
    pub angular: DVec3,
    /// Energy that breaking and yielding took, J.
    pub fracture_loss: f64,
    /// Energy that solver and loads took and gave.
    pub ledger: EnergyLedger,
    /// Energy stored in overlaps, J.
    pub contact: f64,
    /// Energy that contacts dissipated, J.
    pub contact_loss: f64,
    /// Work of moved bodies, J.
    pub contact_work: f64,
}

impl EnergyRow {
    /// Returns the present row of a world whose velocities are those of `lag` seconds before its positions.
    pub fn measure(world: &World, bodies: &Bodies, ledger: &EnergyLedger, lag: f64) -> EnergyRow {
        let (momentum, angular) = bodies.momenta(DVec3::ZERO);
        EnergyRow {
            time: world.state.time,
            rods: Energies {
                kinetic: kinetic_energy(world, lag),
                ..energies(&world.bundle, &world.state)
            },
            bodies: bodies.energy(),
            gravity: -(0..world.bundle.vertices()).fold(0.0, |sum, i| {
                let position = world.state.position.get(i);
                sum + world.bundle.mass[i] * world.loads.gravity.dot(position)
            }),
            momentum: momentum + world.state.momentum(&world.bundle),
            angular: angular + world.state.angular_momentum(&world.bundle, DVec3::ZERO),
            fracture_loss: world.fracture_loss,
            ledger: *ledger,
            contact: bodies.ledger().stored,
            contact_loss: bodies.ledger().dissipated,
            contact_work: bodies.ledger().work,
        }
    }

    /// Returns the energy of rods and bodies plus what was taken less what was given, J. It is constant but for the error of the
    /// method.
    pub fn balance(&self) -> f64 {
        let taken = self.fracture_loss + self.ledger.damped + self.ledger.dissipated;
        let given = self.ledger.work + self.contact_work;
        self.rods.total() + self.bodies + self.contact + taken + self.contact_loss - given
    }

    /// Returns its numbers in the order of the columns of `energy.csv`.
    pub fn numbers(&self) -> [f64; 23] {
        let (e, p, l) = (&self.rods, self.momentum, self.angular);
        [
            self.time,
            e.kinetic,
            e.stretch,
            e.bend,
            e.twist,
            e.bond_transverse,
            e.bond_shear,
            self.bodies,
            self.gravity,
            p.x,
            p.y,
            p.z,
            l.x,
            l.y,
            l.z,
            self.fracture_loss,
            self.ledger.damped,
            self.ledger.dissipated,
            self.ledger.work,
            self.contact,
            self.contact_loss,
            self.contact_work,
            self.balance(),
        ]
    }

    /// Returns the row as a line, with its end.
    pub fn line(&self) -> String {
        self.numbers().map(|n| n.to_string()).join(",") + "\n"
    }
}

/// Returns the kinetic energy (J) at the time of the positions, from velocities of `lag` seconds before: the mean of ½ m v² over
/// twice the lag, in which the present forces act. A vibration of frequency ω that a leapfrog method gives the energy E so
/// counts (1 − (ω Δt)²/12) E. That is, to the second order in Δt, its part of what the method conserves while energy wanders from
/// one vibration to another (Hairer, Lubich and Wanner, *Geometric Numerical Integration*, chapter IX). The mean of the energies before and
/// after would count all of E, and rise as energy wanders into fast vibrations.
fn kinetic_energy(world: &World, lag: f64) -> f64 {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    if lag == 0.0 {
        return state.kinetic_energy(bundle);
    }
    let mut next = state.clone();
    let step = 2.0 * lag;
    let damping_factor = 1.0 / (1.0 + loads.damping * step);
    let forces = forces_on(world);
    for i in 0..bundle.vertices() {
        let push = forces.linear.get(i) * (step / bundle.mass[i]);
        next.velocity
            .set(i, (state.velocity.get(i) + push) * damping_factor);
        if bundle.is_edge(i) {
            next.spin[i] =
                (state.spin[i] + step * forces.moment[i] / bundle.inertia[i]) * damping_factor;
        }
    }
    for clamp in &loads.clamps {
        for &v in &clamp.vertices {
            let (now, mut new) = (
                state.velocity.get(v as usize),
                next.velocity.get(v as usize),
            );
            for a in (0..3).filter(|&a| clamp.axes[a]) {
                new[a] = now[a];
            }
            next.velocity.set(v as usize, new);
        }
        for &j in &clamp.edges {
            next.spin[j as usize] = state.spin[j as usize];
        }
    }
    (0..bundle.vertices()).fold(0.0, |sum, i| {
        let [v, w] = [state, &next].map(|s| s.velocity.get(i));
        let [r, q] = [state, &next].map(|s| s.spin[i]);
        let squares = v.length_squared() + v.dot(w) + w.length_squared();
        let spins = r * r + r * q + q * q;
        sum + (bundle.mass[i] * squares + bundle.inertia[i] * spins) / 6.0
    })
}

/// Replaces the present velocities by those of `lag` seconds before, from which a leapfrog method starts. Without that it
/// would start with more energy than the world has.
pub fn stagger_velocities(world: &mut World, lag: f64) {
    let forces = forces_on(world);
    let World { bundle, state, .. } = world;
    for i in 0..bundle.vertices() {
        let push = forces.linear.get(i) * (lag / bundle.mass[i]);
        state.velocity.add(i, -push);
        if bundle.is_edge(i) {
            state.spin[i] -= lag * forces.moment[i] / bundle.inertia[i];
        }
    }
}

/// What the column `kind` holds.
pub(super) const KINDS: [(EventKind, &str); 3] = [
    (EventKind::RodBroke, "rod_broke"),
    (EventKind::RodYielded, "rod_yielded"),
    (EventKind::BondBroke, "bond_broke"),
];

/// What the column `cause` holds.
pub(super) const CAUSES: [(Cause, &str); 8] = [
    (Cause::Tension, "tension"),
    (Cause::Compression, "compression"),
    (Cause::Potential, "potential"),
    (Cause::Griffith, "griffith"),
    (Cause::Stress, "stress"),
    (Cause::Cohesive, "cohesive"),
    (Cause::Shear, "shear"),
    (Cause::Torsion, "torsion"),
];

fn name_of<T: PartialEq>(value: T, names: &[(T, &'static str)]) -> &'static str {
    names.iter().find(|n| n.0 == value).map_or("", |n| n.1)
}

/// Returns what the column `kind` holds for an event.
pub(crate) fn kind_name(kind: EventKind) -> &'static str {
    name_of(kind, &KINDS)
}

/// Returns what the column `cause` holds for an event.
pub(crate) fn cause_name(cause: Cause) -> &'static str {
    name_of(cause, &CAUSES)
}

/// Returns an event as a line, with its end.
pub fn event_line(event: &Event) -> String {
    let (kind, cause) = (kind_name(event.kind), cause_name(event.cause));
    let other = event.other.map_or(String::new(), |o| o.to_string());
    let p = event.position;
    format!(
        "{},{kind},{},{},{other},{},{},{},{cause},{},{}\n",
        event.time, event.rod, event.vertex, p.x, p.y, p.z, event.demand, event.energy
    )
}
