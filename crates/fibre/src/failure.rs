//! When rods and bonds fail (Sutherland 2012 §3.4), and what is left then.

use crate::bundle::Bundle;
use crate::energy;
use crate::error::LoadError;
use crate::event::{Cause, Event, EventKind};
use crate::kernel::Evaluator;
use crate::solver::{Contacts, World};
use crate::state::State;
use crate::topology;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// When a bond breaks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum BondCriterion {
    /// Never.
    Never,
    /// Weighted energy `(1 − w) E_t + w E_s` above a threshold, pressure counted like tension (§3.4.2; w = ½ is half its plain sum).
    Potential {
        /// Threshold, J.
        threshold: f64,
        /// Weight w of shear, 0 to 1.
        shear_weight: f64,
    },
    /// Stored energy above the bond's energy of fracture.
    Griffith,
    /// (σ/f_t90)² + (τ/f_v)² ≥ 1; pressure across the bond does not count.
    Stress,
}

/// When a bundle fails. The default is never.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Whether rods break where stretch × bending ratio passes 1 + the strain at tensile failure.
    pub rods_break: bool,
    /// Whether rods yield in compression, and keep the strain.
    pub rods_yield: bool,
    /// When bonds break.
    pub bonds: BondCriterion,
    /// Whether anything fails is looked at every so many steps; 1 for each.
    pub interval: u32,
    /// Most that may break between two steps, the most overstressed first; `u32::MAX` for no limit.
    pub at_once: u32,
}

impl Default for Failure {
    fn default() -> Self {
        Failure {
            rods_break: false,
            rods_yield: false,
            bonds: BondCriterion::Never,
            interval: 1,
            at_once: u32::MAX,
        }
    }
}

impl Failure {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`LoadError::Value`] for what is out of range.
    pub fn check(&self) -> Result<(), LoadError> {
        if let BondCriterion::Potential {
            threshold,
            shear_weight,
        } = self.bonds
        {
            if !(threshold > 0.0 && threshold.is_finite()) {
                return Err(LoadError::Value {
                    what: "the bonds' threshold (J)",
                    value: threshold,
                    right: "above 0 and finite",
                });
            }
            if !(0.0..=1.0).contains(&shear_weight) {
                return Err(LoadError::Value {
                    what: "the weight of shear",
                    value: shear_weight,
                    right: "from 0 to 1",
                });
            }
        }
        Ok(())
    }
}

/// Something that is to break.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Break {
    /// How far its criterion is passed: demand over strength.
    pub demand: f64,
    /// Whether it is a bond; else a rod at a vertex.
    pub bond: bool,
    /// Number of the bond or vertex.
    pub number: u32,
}

/// How near a rod is to breaking at a vertex: the strain of stretch × bending ratio over the strain at tensile failure.
/// 0 at a rod's ends.
pub fn rod_demand(bundle: &Bundle, state: &State, vertex: usize, diameter: f64) -> f64 {
    if bundle.bend[vertex] <= 0.0 {
        return 0.0;
    }
    let before = Side::of(bundle, state, vertex - 1);
    let after = Side::of(bundle, state, vertex);
    let curvature = if bundle.twisting {
        energy::framed::curvature_change(bundle, state, vertex)
    } else {
        before.curvature(&after)
    };
    before.strain_at_skin(&after, curvature, diameter) / bundle.tension_limit[vertex]
}

/// An edge at one side of a vertex.
struct Side {
    edge: DVec3,
    length: f64,
    strain: f64,
}

impl Side {
    fn of(bundle: &Bundle, state: &State, edge: usize) -> Self {
        let (vector, rest) = (state.edge(edge), bundle.rest_length[edge]);
        let length = vector.length();
        Side {
            edge: vector,
            length,
            strain: length / rest - 1.0 - state.plastic_strain[edge],
        }
    }

    /// One over the radius of the circle through the three vertices of two edges, 1/m.
    fn curvature(&self, next: &Side) -> f64 {
        let across = (self.edge + next.edge).length();
        2.0 * self.edge.cross(next.edge).length() / (self.length * next.length * across)
    }

    /// Stretch × bending ratio, less 1.
    fn strain_at_skin(&self, next: &Side, curvature: f64, diameter: f64) -> f64 {
        let stretch = 1.0 + 0.5 * (self.strain + next.strain);
        stretch * (1.0 + 0.5 * diameter * curvature) - 1.0
    }
}

/// How near a bond is to breaking: demand over strength.
pub fn bond_demand(criterion: BondCriterion, bundle: &Bundle, state: &State, bond: usize) -> f64 {
    let b = &bundle.bonds;
    let opening = || {
        let (_, d) = energy::bond::vectors(bundle, state, bond);
        (d.length() / b.distance[bond] - 1.0).max(0.0)
    };
    match criterion {
        BondCriterion::Never => 0.0,
        BondCriterion::Potential {
            threshold,
            shear_weight,
        } => {
            let (transverse, shear) = energy::bond::energy(bundle, state, bond);
            ((1.0 - shear_weight) * transverse + shear_weight * shear) / threshold
        }
        BondCriterion::Griffith => {
            let (transverse, shear) = energy::bond::energy(bundle, state, bond);
            // Pressure closes a crack: it frees nothing.
            let opened = if opening() > 0.0 { transverse } else { 0.0 };
            (opened + shear) / b.fracture_energy[bond]
        }
        BondCriterion::Stress => {
            let tension = b.transverse[bond] * opening() / b.tension_strength[bond];
            let (_, shear) = energy::bond::energy(bundle, state, bond);
            // Of S γ² the force along the facet is 2 S γ/d₀, γ = (E/S)^½.
            let force = 2.0 * (b.shear[bond] * shear).sqrt() / b.distance[bond];
            let along = force / b.shear_strength[bond];
            (tension * tension + along * along).sqrt()
        }
    }
}

/// Lets rods yield: what is below the strain of yielding becomes permanent. Returns the energy it took, J.
fn yield_rods(bundle: &Bundle, state: &mut State, events: &mut Vec<Event>) -> f64 {
    let mut taken = 0.0;
    for j in 0..bundle.vertices() {
        if !bundle.is_edge(j) {
            continue;
        }
        let strain = energy::rod::strain(bundle, state, j);
        let limit = bundle.yield_strain[j];
        if strain >= -limit {
            continue;
        }
        let energy =
            0.5 * bundle.stretch[j] * bundle.rest_length[j] * (strain * strain - limit * limit);
        if state.plastic_strain[j] == 0.0 {
            let rod = bundle.rod_of(j);
            events.push(Event {
                time: state.time,
                kind: EventKind::RodYielded,
                rod: bundle.parent[rod],
                vertex: bundle.origin[j],
                other: None,
                place: state.position.get(j).midpoint(state.position.get(j + 1)),
                cause: Cause::Compression,
                demand: -strain / limit,
                energy,
            });
        }
        state.plastic_strain[j] += strain + limit;
        taken += energy;
    }
    taken
}

/// Fills `queue` with what fails in a state, the most overstressed first, and in order of number where alike.
pub fn detect(failure: &Failure, bundle: &Bundle, state: &State, queue: &mut Vec<Break>) {
    let all = 0..bundle.bonds.len() as u32;
    detect_among(failure, bundle, state, all, queue);
}

/// Room in which a solver looks for what fails.
#[derive(Debug, Clone, Default)]
pub(crate) struct Room {
    /// What fails.
    pub queue: Vec<Break>,
    suspects: Vec<u32>,
}

impl Room {
    /// The same as [`detect`], with the help of the bundle's evaluator, which looks at most bonds in passing.
    pub fn detect(
        &mut self,
        failure: &Failure,
        bundle: &Bundle,
        state: &State,
        evaluator: &mut Evaluator,
    ) {
        if failure.bonds == BondCriterion::Never {
            self.suspects.clear();
        } else {
            evaluator.suspects(bundle, state, failure.bonds, &mut self.suspects);
        }
        let suspects = self.suspects.iter().copied();
        detect_among(failure, bundle, state, suspects, &mut self.queue);
    }
}

fn detect_among(
    failure: &Failure,
    bundle: &Bundle,
    state: &State,
    bonds: impl Iterator<Item = u32>,
    queue: &mut Vec<Break>,
) {
    queue.clear();
    if failure.rods_break {
        let mut push = |vertex: usize, demand: f64| {
            if demand >= 1.0 {
                queue.push(Break {
                    demand,
                    bond: false,
                    number: vertex as u32,
                });
            }
        };
        for rod in 0..bundle.rods() {
            let (range, diameter) = (bundle.rod(rod), bundle.diameter[rod]);
            if bundle.twisting {
                range.for_each(|v| push(v, rod_demand(bundle, state, v, diameter)));
                continue;
            }
            let mut before = Side::of(bundle, state, range.start);
            for v in range.start + 1..range.end - 1 {
                let after = Side::of(bundle, state, v);
                let strain = before.strain_at_skin(&after, before.curvature(&after), diameter);
                push(v, strain / bundle.tension_limit[v]);
                before = after;
            }
        }
    }
    if failure.bonds != BondCriterion::Never {
        for number in bonds {
            let demand = bond_demand(failure.bonds, bundle, state, number as usize);
            if demand >= 1.0 {
                queue.push(Break {
                    demand,
                    bond: true,
                    number,
                });
            }
        }
    }
    let key = |b: &Break| (b.bond, b.number);
    queue.sort_unstable_by(|a, b| b.demand.total_cmp(&a.demand).then(key(a).cmp(&key(b))));
    queue.truncate(failure.at_once as usize);
}

/// Finds what fails in the world's state and lets it, in a fixed order. Returns whether anything broke, so that the bundle
/// has changed.
pub(crate) fn after_step(
    world: &mut World,
    contacts: &mut dyn Contacts,
    evaluator: &mut Evaluator,
    room: &mut Room,
) -> bool {
    let failure = world.failure;
    if !world
        .state
        .step
        .is_multiple_of(u64::from(failure.interval.max(1)))
    {
        return false;
    }
    if failure.rods_yield {
        world.fracture_loss += yield_rods(&world.bundle, &mut world.state, &mut world.events);
    }
    room.detect(&failure, &world.bundle, &world.state, evaluator);
    if room.queue.is_empty() {
        return false;
    }
    apply(world, contacts, &room.queue);
    true
}

/// Breaks all that is in `queue`, notes it in the world's events, and renumbers whatever named a vertex. Returns for each
/// vertex of the bundle now which it was before.
pub fn apply(world: &mut World, contacts: &mut dyn Contacts, queue: &[Break]) -> Vec<u32> {
    note(world, queue);
    let bonds = queue.iter().filter(|b| b.bond).map(|b| b.number).collect();
    let splits = queue.iter().filter(|b| !b.bond).map(|b| b.number).collect();
    take_out(world, contacts, bonds, splits)
}

/// Notes in the world's events, and as energy lost, that all in `queue` breaks.
pub(crate) fn note(world: &mut World, queue: &[Break]) {
    let cause = match world.failure.bonds {
        BondCriterion::Never | BondCriterion::Potential { .. } => Cause::Potential,
        BondCriterion::Griffith => Cause::Griffith,
        BondCriterion::Stress => Cause::Stress,
    };
    let World { bundle, state, .. } = world;
    for b in queue {
        let i = b.number as usize;
        let event = if b.bond {
            let (vertex, edge) = (
                bundle.bonds.vertex[i] as usize,
                bundle.bonds.edge[i] as usize,
            );
            let (transverse, shear) = energy::bond::energy(bundle, state, i);
            let (_, d) = energy::bond::vectors(bundle, state, i);
            Event {
                time: state.time,
                kind: EventKind::BondBroke,
                rod: bundle.parent[bundle.rod_of(vertex)],
                vertex: bundle.origin[vertex],
                other: Some(bundle.parent[bundle.rod_of(edge)]),
                place: state.position.get(vertex) - d * 0.5,
                cause,
                demand: b.demand,
                energy: transverse + shear,
            }
        } else {
            let energy = if bundle.twisting {
                let (bend, twist) = energy::framed::energy(bundle, state, i);
                bend + twist
            } else {
                energy::rod::bend_energy(bundle, state, i)
            };
            Event {
                time: state.time,
                kind: EventKind::RodBroke,
                rod: bundle.parent[bundle.rod_of(i)],
                vertex: bundle.origin[i],
                other: None,
                place: state.position.get(i),
                cause: Cause::Tension,
                demand: b.demand,
                energy,
            }
        };
        world.fracture_loss += event.energy;
        world.events.push(event);
    }
}

/// Takes `bonds` out and splits rods at the vertices `splits`, and renumbers whatever named a vertex. Returns for each
/// vertex of the bundle now which it was before.
pub(crate) fn take_out(
    world: &mut World,
    contacts: &mut dyn Contacts,
    mut bonds: Vec<u32>,
    mut splits: Vec<u32>,
) -> Vec<u32> {
    bonds.sort_unstable();
    splits.sort_unstable();
    let before = topology::break_up(
        &mut world.bundle,
        &mut world.state,
        &mut world.loads,
        &bonds,
        &splits,
    );
    contacts.renumbered(&world.bundle, &before);
    before
}
