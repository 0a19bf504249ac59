//! The tension along the grain that wood can still carry from one end to the other: the maximum flow through a network in which
//! rods and bonds carry as much as their strength allows. Its minimum cut (Ford and Fulkerson 1956, *Canadian Journal of
//! Mathematics* 8) is where the wood would part, and what lies on either side of it is held together by more.

use crate::failure::cohesion::Softening;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use petgraph::Graph;
use petgraph::algo::dinics;
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

/// Capacities are whole numbers of this fraction of the strength of all rods, so that flows are exact.
const UNIT: f64 = 1e-9;
/// Strain at which a rod that never fails is taken to.
const MAX_STRAIN: f64 = 1.0;

/// The tension that wood can carry, and where it would part.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TensionCapacity {
    /// The largest tension, N.
    pub newtons: f64,
    /// Per vertex: whether it lies on the base's side of the weakest cut.
    pub at_base: Vec<bool>,
}

/// Returns the strength of an edge of a rod in tension, N.
fn rod_strength(bundle: &RodBundle, edge: usize) -> f64 {
    let limit = bundle.tension_limit[edge].min(bundle.tension_limit[edge + 1]);
    bundle.stretch[edge] * limit.min(MAX_STRAIN)
}

/// Returns the force along the grain that a bond can still pass on, N: of one that has softened, what is left of its strength.
fn bond_strength(bundle: &RodBundle, state: &State, bond: usize) -> f64 {
    let whole = bundle.bonds.shear_strength[bond];
    let damage = bundle.bonds.damage[bond];
    if damage == 0.0 {
        return whole;
    }
    let threshold = Softening::new(bundle, state, bond).threshold(damage);
    whole * ((1.0 - damage) * threshold).clamp(0.0, 1.0)
}

impl TensionCapacity {
    /// Returns that of a bundle between its vertices `base` and `tip`.
    pub fn new(bundle: &RodBundle, state: &State, [base, tip]: [&[u32]; 2]) -> Self {
        let edges = (0..bundle.vertices()).filter(|&j| bundle.is_edge(j));
        let strength: f64 = edges.clone().map(|j| rod_strength(bundle, j)).sum();
        let unit = UNIT * strength.max(f64::MIN_POSITIVE);
        let whole = |newtons: f64| (newtons / unit).min(1.0 / UNIT) as u64;
        let mut network = Graph::<(), u64>::new();
        let vertices: Vec<NodeIndex> = (0..bundle.vertices())
            .map(|_| network.add_node(()))
            .collect();
        let [source, sink] = [network.add_node(()), network.add_node(())];
        for &v in base {
            network.add_edge(source, vertices[v as usize], whole(f64::INFINITY));
        }
        for &v in tip {
            network.add_edge(vertices[v as usize], sink, whole(f64::INFINITY));
        }
        let mut join = |a: usize, b: usize, newtons: f64| {
            for (from, to) in [(a, b), (b, a)] {
                network.add_edge(vertices[from], vertices[to], whole(newtons));
            }
        };
        for j in edges {
            join(j, j + 1, rod_strength(bundle, j));
        }
        let bonds = &bundle.bonds;
        for bond in 0..bonds.len() {
            let nearer = usize::from(bonds.t[bond] > 0.5);
            let other = bonds.edge[bond] as usize + nearer;
            let strength = bond_strength(bundle, state, bond);
            join(bonds.vertex[bond] as usize, other, strength);
        }
        let (flow, flows) = dinics(&network, source, sink);
        let reached = reached(&network, source, &flows);
        TensionCapacity {
            newtons: flow as f64 * unit,
            at_base: vertices.iter().map(|v| reached[v.index()]).collect(),
        }
    }
}

/// Returns for each node whether more flow could reach it from `source`: the side of the source of the minimum cut.
fn reached(network: &Graph<(), u64>, source: NodeIndex, flows: &[u64]) -> Vec<bool> {
    let mut reached = vec![false; network.node_count()];
    reached[source.index()] = true;
    let mut open = vec![source];
    while let Some(node) = open.pop() {
        let ahead = network.edges_directed(node, petgraph::Outgoing);
        let back = network.edges_directed(node, petgraph::Incoming);
        let next = ahead
            .filter(|e| flows[e.id().index()] < *e.weight())
            .map(|e| e.target())
            .chain(
                back.filter(|e| flows[e.id().index()] > 0)
                    .map(|e| e.source()),
            );
        for other in next {
            if !std::mem::replace(&mut reached[other.index()], true) {
                open.push(other);
            }
        }
    }
    reached
}
