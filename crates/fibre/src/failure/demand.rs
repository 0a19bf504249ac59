//! How close rods and bonds are to failure: demand over strength (Sutherland 2012 §3.4).

use super::cohesion::Softening;
use super::criteria::{BondCriterion, FailureCriteria};
use crate::energy::{self, bond::BondSpring};
use crate::evaluator::ForceEvaluator;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use glam::DVec3;

/// What can break. Rods order before bonds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Element {
    /// A rod at this vertex.
    Rod(u32),
    /// This bond.
    Bond(u32),
}

/// An element whose criterion is exceeded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overstressed {
    /// Demand over strength.
    pub demand: f64,
    /// The rod vertex or bond.
    pub element: Element,
}

/// Returns the vertices of the rods in `queue`, in its order.
pub(crate) fn rods_in(queue: &[Overstressed]) -> Vec<u32> {
    let vertex = |o: &Overstressed| match o.element {
        Element::Rod(vertex) => Some(vertex),
        Element::Bond(_) => None,
    };
    queue.iter().filter_map(vertex).collect()
}

/// Returns the bonds in `queue`, in its order.
pub(crate) fn bonds_in(queue: &[Overstressed]) -> Vec<u32> {
    let bond = |o: &Overstressed| match o.element {
        Element::Bond(bond) => Some(bond),
        Element::Rod(_) => None,
    };
    queue.iter().filter_map(bond).collect()
}

/// The demand on a rod at a vertex.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RodDemand {
    /// The largest strain along the rod on its surface over that at tensile failure; negative in compression.
    pub tension: f64,
    /// The shear strain of torsion at its surface over that at failure.
    pub torsion: f64,
}

impl RodDemand {
    /// Returns both together, as for bonds: failure is where the sum of squares is 1, and compression does not count.
    pub fn combined(self) -> f64 {
        if self.torsion == 0.0 {
            self.tension
        } else {
            let tension = self.tension.max(0.0);
            (tension * tension + self.torsion * self.torsion).sqrt()
        }
    }
}

/// Returns the demand on a rod at a vertex ([`rod_demand`]) as one number.
pub(crate) fn combined_rod_demand(
    bundle: &RodBundle,
    state: &State,
    vertex: usize,
    diameter: f64,
) -> f64 {
    rod_demand(bundle, state, vertex, diameter).combined()
}

/// Returns the demand on a rod at a vertex: the strain of stretch × bending ratio over the strain at tensile failure, and with
/// twist the shear strain of torsion over that at failure. Both are 0 at a rod's ends.
///
/// A round bar under a torque T has the shear stress τ = T r/J = G r θ′ at its surface, with the twist θ′ per length
/// (Timoshenko and Goodier, *Theory of Elasticity*, chapter "Torsion"). The strength of wood in torsion is that in shear along
/// the grain (Wood Handbook, chapter 5). Section 6.1 of the thesis proposes how much longer twist makes a line along the
/// surface; that grows with the square of the angle of shear, of which wood bears a few hundredths, and is left out.
pub(crate) fn rod_demand(
    bundle: &RodBundle,
    state: &State,
    vertex: usize,
    diameter: f64,
) -> RodDemand {
    if bundle.bend[vertex] <= 0.0 {
        return RodDemand::default();
    }
    let torsion = if bundle.twist[vertex] > 0.0 {
        let rate = energy::bend_twist::twist_rate(bundle, state, vertex);
        0.5 * diameter * rate.abs() / bundle.shear_limit[vertex]
    } else {
        0.0
    };
    let before = EdgeStrain::new(bundle, state, vertex - 1);
    let after = EdgeStrain::new(bundle, state, vertex);
    let curvature = if bundle.twisting {
        energy::bend_twist::curvature_change(bundle, state, vertex)
    } else {
        before.curvature(&after)
    };
    RodDemand {
        tension: before.surface_strain(&after, curvature, diameter) / bundle.tension_limit[vertex],
        torsion,
    }
}

/// An edge at one side of a vertex.
struct EdgeStrain {
    edge: DVec3,
    length: f64,
    strain: f64,
}

impl EdgeStrain {
    fn new(bundle: &RodBundle, state: &State, edge: usize) -> Self {
        let (vector, rest) = (state.edge(edge), bundle.rest_length[edge]);
        let length = vector.length();
        EdgeStrain {
            edge: vector,
            length,
            strain: length / rest - 1.0 - state.plastic_strain[edge],
        }
    }

    /// Returns one over the radius of the circle through the three vertices of two edges, 1/m.
    fn curvature(&self, next: &EdgeStrain) -> f64 {
        let across = (self.edge + next.edge).length();
        2.0 * self.edge.cross(next.edge).length() / (self.length * next.length * across)
    }

    /// Returns the largest strain on the rod's surface, stretch × bending ratio less 1.
    fn surface_strain(&self, next: &EdgeStrain, curvature: f64, diameter: f64) -> f64 {
        let stretch = 1.0 + 0.5 * (self.strain + next.strain);
        stretch * (1.0 + 0.5 * diameter * curvature) - 1.0
    }
}

/// Returns the demand on a bond.
pub(crate) fn bond_demand(
    criterion: BondCriterion,
    bundle: &RodBundle,
    state: &State,
    bond: usize,
) -> f64 {
    let b = &bundle.bonds;
    let spring = BondSpring::new(bundle, bond);
    let strain = || {
        let (e, d) = energy::bond::vectors(bundle, state, bond);
        spring.strain(e, d)
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
            // Compression closes a crack: breaking would release none of its energy.
            let released = if strain().opening > 0.0 {
                transverse
            } else {
                0.0
            };
            (released + shear) / b.fracture_energy[bond]
        }
        BondCriterion::Stress => {
            let strain = strain();
            let tension = spring.opening * strain.opening.max(0.0) / b.tension_strength[bond];
            let along = spring.slip * strain.slip / b.shear_strength[bond];
            (tension * tension + along * along).sqrt()
        }
        BondCriterion::Cohesive => {
            let softening = Softening::new(bundle, state, bond);
            softening.strain / softening.threshold(b.damage[bond])
        }
    }
}

/// Returns the largest demand in a state.
pub(crate) fn largest_demand(failure: &FailureCriteria, bundle: &RodBundle, state: &State) -> f64 {
    let mut largest = 0.0f64;
    if failure.rods_break {
        for r in 0..bundle.rods() {
            for v in bundle.rod(r) {
                let demand = combined_rod_demand(bundle, state, v, bundle.diameter[r]);
                largest = largest.max(demand);
            }
        }
    }
    if failure.bonds != BondCriterion::Never {
        for b in 0..bundle.bonds.len() {
            largest = largest.max(bond_demand(failure.bonds, bundle, state, b));
        }
    }
    largest
}

/// Fills `queue` with the elements that fail in a state, the most overstressed first, and by number where equal.
pub(crate) fn find_overstressed(
    failure: &FailureCriteria,
    bundle: &RodBundle,
    state: &State,
    queue: &mut Vec<Overstressed>,
) {
    let all = 0..bundle.bonds.len() as u32;
    find_among(failure, bundle, state, all, queue);
}

/// Finds overstressed elements with an evaluator's help, and reuses its buffers.
#[derive(Debug, Clone, Default)]
pub(crate) struct FailureDetector {
    /// The elements found last.
    pub queue: Vec<Overstressed>,
    suspects: Vec<u32>,
}

impl FailureDetector {
    /// Finds the same elements as [`find_overstressed`]. The bundle's evaluator excludes most bonds in one fast pass.
    pub fn detect(
        &mut self,
        failure: &FailureCriteria,
        bundle: &RodBundle,
        state: &State,
        evaluator: &mut ForceEvaluator,
    ) {
        if failure.bonds == BondCriterion::Never {
            self.suspects.clear();
        } else {
            evaluator.suspects(bundle, state, failure.bonds, &mut self.suspects);
        }
        let suspects = self.suspects.iter().copied();
        find_among(failure, bundle, state, suspects, &mut self.queue);
    }
}

fn find_among(
    failure: &FailureCriteria,
    bundle: &RodBundle,
    state: &State,
    bonds: impl Iterator<Item = u32>,
    queue: &mut Vec<Overstressed>,
) {
    queue.clear();
    if failure.rods_break {
        find_rods(bundle, state, queue);
    }
    if failure.bonds != BondCriterion::Never {
        for number in bonds {
            let demand = bond_demand(failure.bonds, bundle, state, number as usize);
            if demand >= 1.0 {
                queue.push(Overstressed {
                    demand,
                    element: Element::Bond(number),
                });
            }
        }
    }
    queue.sort_unstable_by(|a, b| {
        let larger = b.demand.total_cmp(&a.demand);
        larger.then(a.element.cmp(&b.element))
    });
    queue.truncate(failure.max_breaks as usize);
}

/// Puts into the queue for each rod the vertex where it is most overstressed: where it breaks there, it is unloaded on both
/// sides, so that others break only if they still are overstressed then.
fn find_rods(bundle: &RodBundle, state: &State, queue: &mut Vec<Overstressed>) {
    for rod in 0..bundle.rods() {
        let (range, diameter) = (bundle.rod(rod), bundle.diameter[rod]);
        let mut most = (0.0, range.start);
        let mut compare = |vertex: usize, demand: f64| {
            if demand > most.0 {
                most = (demand, vertex);
            }
        };
        if bundle.twisting {
            range.for_each(|v| compare(v, combined_rod_demand(bundle, state, v, diameter)));
        } else {
            let mut before = EdgeStrain::new(bundle, state, range.start);
            for v in range.start + 1..range.end - 1 {
                let after = EdgeStrain::new(bundle, state, v);
                let strain = before.surface_strain(&after, before.curvature(&after), diameter);
                compare(v, strain / bundle.tension_limit[v]);
                before = after;
            }
        }
        let (demand, vertex) = most;
        if demand >= 1.0 {
            queue.push(Overstressed {
                demand,
                element: Element::Rod(vertex as u32),
            });
        }
    }
}
