//! Crumbs: pieces of rods of one or two edges, which hang on by the bonds of a vertex.
//!
//! A bond stands for a facet along its rod, but acts at a point: about it a crumb turns as freely as a pendulum on a pin, and goes
//! on whirling when all else is at rest. A facet does not let it. Where its edge turns against the one that it holds to by an angle
//! θ, the facet opens at its end by a sin θ, with a half its length, and by half of that on average over the half that opens. Where
//! that is more than the opening at which softening ends, nothing of the facet is left to hold.

use super::cohesion::{FAILED, opening_at_end};
use super::demand::{Element, Overstressed};
use crate::rod_bundle::RodBundle;
use crate::world::World;
use glam::DVec3;

/// Most edges of a crumb.
const MAX_EDGES: usize = 2;
/// Half the length of a facet over that of the edge: the facet of a vertex at an end reaches to the middle of the edge.
const HALF_FACET: f64 = 0.25;

/// Whether a rod is a crumb: a short piece of what was longer.
pub(crate) fn is_crumb(bundle: &RodBundle, rod: usize) -> bool {
    let edges = bundle.rod(rod).len() - 1;
    let parent = bundle.parent[rod];
    let neighbours = [rod.checked_sub(1), Some(rod + 1)].into_iter().flatten();
    edges <= MAX_EDGES
        && (neighbours.filter(|&r| r < bundle.rods())).any(|r| bundle.parent[r] == parent)
}

/// Adds to `queue` the cohesive bonds of crumbs whose facets have opened by turning, without those that have softened to their end.
pub(crate) fn find_peeled_bonds(world: &World, queue: &mut Vec<Overstressed>) {
    // Of rods that resist twist this has not paid: `bend` took several times as long.
    if !world.failure.is_cohesive() || world.bundle.twisting {
        return;
    }
    let bundle = &world.bundle;
    for rod in (0..bundle.rods()).filter(|&rod| is_crumb(bundle, rod)) {
        for v in bundle.rod(rod) {
            let own = bundle.bonds.incidence.of_vertex(v);
            let edge = if bundle.is_edge(v) { v } else { v - 1 };
            queue.extend(own.filter_map(|bond| {
                let other = bundle.bonds.edge[bond] as usize;
                peeled(world, bond, edge, other)
            }));
            if !bundle.is_edge(v) {
                continue;
            }
            queue.extend(bonds_of_edge(bundle, v).filter_map(|bond| {
                let x = bundle.bonds.vertex[bond] as usize;
                let other = if bundle.is_edge(x) { x } else { x - 1 };
                // A bond between two crumbs is found from its vertex.
                (!is_crumb(bundle, bundle.rod_of(x))).then_some(())?;
                peeled(world, bond, v, other)
            }));
        }
    }
}

fn bonds_of_edge(bundle: &RodBundle, edge: usize) -> impl Iterator<Item = usize> + '_ {
    let incidence = &bundle.bonds.incidence;
    let range = incidence.edge_offsets[edge] as usize..incidence.edge_offsets[edge + 1] as usize;
    incidence.by_edge[range].iter().map(|bond| *bond as usize)
}

/// Returns the bond between two edges, of which the first is a crumb's, where it is peeled off.
fn peeled(world: &World, bond: usize, edge: usize, other: usize) -> Option<Overstressed> {
    let (bundle, state) = (&world.bundle, &world.state);
    let at_rest = |j: usize| bundle.rest.get(j + 1) - bundle.rest.get(j);
    let now = sine(state.edge(edge), state.edge(other));
    let turned = now - sine(at_rest(edge), at_rest(other));
    let mean = 0.5 * HALF_FACET * bundle.rest_length[edge] * turned;
    let demand = mean / opening_at_end(bundle, bond);
    (demand >= 1.0 && bundle.bonds.damage[bond] < FAILED).then_some(Overstressed {
        demand,
        element: Element::Bond(bond as u32),
    })
}

/// Returns the sine of the angle between two edges, 1 from a right angle on.
fn sine(a: DVec3, b: DVec3) -> f64 {
    if a.dot(b) > 0.0 {
        a.cross(b).length() / (a.length() * b.length())
    } else {
        1.0
    }
}
