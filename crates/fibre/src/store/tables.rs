//! Rows of `energy.csv` and `events.csv`. Numbers are the shortest decimals that give the same double back.

use crate::bodies::Bodies;
use crate::energy::{Energies, energies};
use crate::event::{Cause, Event, EventKind};
use crate::solver::{Advance, Contacts, World};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// First line of the energy table.
pub const ENERGY_HEADER: &str = "time_s,kinetic_J,stretch_J,bend_J,twist_J,bond_transverse_J,bond_shear_J,body_J,\
momentum_x_Ns,momentum_y_Ns,momentum_z_Ns,angular_x_Nms,angular_y_Nms,angular_z_Nms,fracture_loss_J,damped_J,\
dissipated_J,work_J,contact_loss_J,contact_work_J\n";

/// First line of the events.
pub const EVENT_HEADER: &str =
    "time_s,kind,rod,vertex,other_rod,x_m,y_m,z_m,cause,demand,energy_J\n";

/// Energy that solvers and loads have taken and given since the start, J.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Taken by damping.
    pub damped: f64,
    /// Taken by the method.
    pub dissipated: f64,
    /// Work of clamps and forces.
    pub work: f64,
}

impl Ledger {
    /// Adds what a solver reports.
    pub fn add(&mut self, advance: &Advance) {
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
    /// Energy of free bodies, J.
    pub bodies: f64,
    /// Momentum of rods and free bodies, N s.
    pub momentum: DVec3,
    /// Angular momentum about the origin, N m s.
    pub angular: DVec3,
    /// Energy that breaking and yielding took, J.
    pub fracture_loss: f64,
    /// What solver and loads took and gave.
    pub ledger: Ledger,
    /// What contacts took, J.
    pub contact_loss: f64,
    /// Work of moved bodies, J.
    pub contact_work: f64,
}

impl EnergyRow {
    /// The row of a world now.
    pub fn of(world: &World, bodies: &Bodies, ledger: &Ledger) -> EnergyRow {
        let (momentum, angular) = bodies.momenta(DVec3::ZERO);
        EnergyRow {
            time: world.state.time,
            rods: energies(&world.bundle, &world.state),
            bodies: bodies.energy(),
            momentum: momentum + world.state.momentum(&world.bundle),
            angular: angular + world.state.angular_momentum(&world.bundle, DVec3::ZERO),
            fracture_loss: world.fracture_loss,
            ledger: *ledger,
            contact_loss: bodies.ledger().lost,
            contact_work: bodies.ledger().work,
        }
    }

    /// Its numbers in the order of [`ENERGY_HEADER`].
    pub fn numbers(&self) -> [f64; 20] {
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
            self.contact_loss,
            self.contact_work,
        ]
    }

    /// The line, with its end.
    pub fn line(&self) -> String {
        self.numbers().map(|n| n.to_string()).join(",") + "\n"
    }
}

/// The line of an event, with its end.
pub fn event_row(event: &Event) -> String {
    let kind = match event.kind {
        EventKind::RodBroke => "rod_broke",
        EventKind::RodYielded => "rod_yielded",
        EventKind::BondBroke => "bond_broke",
    };
    let cause = match event.cause {
        Cause::Tension => "tension",
        Cause::Compression => "compression",
        Cause::Potential => "potential",
        Cause::Griffith => "griffith",
        Cause::Stress => "stress",
    };
    let other = event.other.map_or(String::new(), |o| o.to_string());
    let p = event.place;
    format!(
        "{},{kind},{},{},{other},{},{},{},{cause},{},{}\n",
        event.time, event.rod, event.vertex, p.x, p.y, p.z, event.demand, event.energy
    )
}
