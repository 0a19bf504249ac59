//! Where along a rod it breaks: at the maximum of the demand, which lies between vertices (Sutherland 2012 §6.2 asks for
//! stress that varies continuously along the rod, and for breaks at its local maxima).
//!
//! The demand along the rod is the parabola through that of the vertex that breaks and of its neighbours, each over the
//! strength of the wood there. The vertex is moved along its rod to the maximum, at most by half an edge, and then split
//! ([`crate::topology`]): between them the vertices of a rod reach every place of it, and no edge becomes shorter than a half.
//!
//! The vertex is moved along the wood, not with it. Mass goes with the length from one edge to the other. Momentum and angular
//! momentum are conserved exactly: what moved mass changes of them is made up for by a rigid motion of the vertex and its
//! neighbours, the least motion that does. Edges and bonds keep their strain. What the energy changes (the rod is straighter
//! or more bent by the new corner) is booked as fracture loss.

use super::demand::combined_rod_demand;
use crate::bonds::{Bond, Bonds};
use crate::energy::bond::{BondSpring, BondStrain};
use crate::energy::{self, energies};
use crate::loads::Loads;
use crate::material_frame;
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::vectors::Vectors;
use crate::world::World;
use glam::{DMat3, DVec3};

/// Least part of a bond's distance across the edge at rest that a break leaves of it.
const MIN_REST_FRACTION: f64 = 0.1;

/// A vertex that is moved along its rod towards a neighbour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BreakPlace {
    /// The vertex.
    pub vertex: usize,
    /// The neighbour, one before or after.
    pub towards: usize,
    /// Fraction of the edge between them, 0 to ½.
    pub fraction: f64,
}

impl BreakPlace {
    /// Returns where a rod breaks at `vertex`; `None` where that is the vertex itself: next to a rod's end, where there is no
    /// demand to compare with, and where loads hold the vertex.
    pub fn new(bundle: &RodBundle, state: &State, loads: &Loads, vertex: u32) -> Option<Self> {
        let v = vertex as usize;
        let rod = bundle.rod_of(v);
        let range = bundle.rod(rod);
        let held = loads.clamps.iter().any(|c| c.vertices.contains(&vertex));
        if held || v < range.start + 2 || v + 2 >= range.end {
            return None;
        }
        let demand = |i: usize| combined_rod_demand(bundle, state, i, bundle.diameter[rod]);
        // Curvature at a vertex is the bending moment there over the stiffness: where forces act on vertices, moments are known
        // at these, however long the edges beside them are.
        let (before, after) = (bundle.rest_length[v - 1], bundle.rest_length[v]);
        let middle = demand(v);
        let rise = (middle - demand(v - 1)) / before;
        let fall = (middle - demand(v + 1)) / after;
        if !(rise + fall).is_finite() || rise + fall <= 0.0 {
            return None;
        }
        // The parabola has the slope `rise` in the middle of the edge before and −`fall` in that of the edge after.
        let offset = -0.5 * before + 0.5 * (before + after) * rise / (rise + fall);
        let (towards, length) = if offset > 0.0 {
            (v + 1, after)
        } else {
            (v - 1, before)
        };
        let fraction = (offset.abs() / length).min(0.5);
        (fraction > 0.0).then_some(BreakPlace {
            vertex: v,
            towards,
            fraction,
        })
    }

    /// Returns the place, m.
    pub fn position(&self, state: &State) -> DVec3 {
        self.between(&state.position)
    }

    fn between(&self, vectors: &Vectors) -> DVec3 {
        let (own, other) = (vectors.get(self.vertex), vectors.get(self.towards));
        own.lerp(other, self.fraction)
    }

    /// The edge that becomes shorter and the one that becomes longer.
    fn edges(&self) -> (usize, usize) {
        if self.towards > self.vertex {
            (self.vertex, self.vertex - 1)
        } else {
            (self.vertex - 1, self.vertex)
        }
    }

    /// The neighbour on the other side.
    fn away(&self) -> usize {
        2 * self.vertex - self.towards
    }
}

/// Moves the vertex of a state to the place, and its velocity to that of the wood there.
pub(crate) fn move_state(state: &mut State, bundle: &RodBundle, places: &[BreakPlace]) {
    for place in places {
        let position = place.between(&state.position);
        state.position.set(place.vertex, position);
        let velocity = place.between(&state.velocity);
        state.velocity.set(place.vertex, velocity);
    }
    state.transport_frames(bundle);
}

/// Moves the vertices at which rods are about to break to their places. Returns these.
pub(crate) fn move_breaks(world: &mut World, splits: &[u32]) -> Vec<BreakPlace> {
    let before = remaining_energy(world, splits);
    let mut places = Vec::new();
    for &vertex in splits {
        let World {
            bundle,
            state,
            loads,
            ..
        } = &mut *world;
        if let Some(place) = BreakPlace::new(bundle, state, loads, vertex) {
            move_break(bundle, state, &place);
            places.push(place);
        }
    }
    if !places.is_empty() {
        world.bundle.generation += 1;
        // Edges that have become shorter vibrate faster.
        world.limit = None;
        world.fracture_loss += before - remaining_energy(world, splits);
    }
    places
}

/// Returns the energy (J) that will be left when rods have split at `splits`: that of bending and twist there is what their
/// breaks take.
fn remaining_energy(world: &World, splits: &[u32]) -> f64 {
    let World { bundle, state, .. } = world;
    let taken: f64 = splits
        .iter()
        .map(|&v| corner_energy(bundle, state, v as usize))
        .sum();
    energies(bundle, state).total() - taken
}

/// Returns the energy of bending and twist at a vertex, J.
pub(super) fn corner_energy(bundle: &RodBundle, state: &State, vertex: usize) -> f64 {
    if bundle.twisting {
        let (bend, twist) = energy::bend_twist::energy(bundle, state, vertex);
        bend + twist
    } else {
        energy::rod::bend_energy(bundle, state, vertex)
    }
}

/// Moves one vertex.
fn move_break(bundle: &mut RodBundle, state: &mut State, place: &BreakPlace) {
    let bonds = TouchedBonds::new(bundle, state, place);
    let motion = Motion::new(bundle, state, place);
    let strain = merged_strain(bundle, state, place);
    move_rest(bundle, place);
    move_state(state, bundle, std::slice::from_ref(place));
    move_material(bundle, place);
    let (_, out) = place.edges();
    state.plastic_strain[out] = strain.plastic;
    bundle.rest_length[out] = state.edge(out).length() / (1.0 + strain.total);
    bundle.distribute_mass(bundle.rod(bundle.rod_of(place.vertex)));
    motion.restore(bundle, state, place);
    bonds.restore(bundle, state);
}

/// The strain of the edge that becomes longer: the mean of what it is made of.
struct MergedStrain {
    total: f64,
    plastic: f64,
}

fn merged_strain(bundle: &RodBundle, state: &State, place: &BreakPlace) -> MergedStrain {
    let (into, out) = place.edges();
    let (own, other) = (
        bundle.rest_length[out],
        place.fraction * bundle.rest_length[into],
    );
    let strain = |edge: usize| state.edge(edge).length() / bundle.rest_length[edge] - 1.0;
    let mean = |a: f64, b: f64| (own * a + other * b) / (own + other);
    MergedStrain {
        total: mean(strain(out), strain(into)),
        plastic: mean(state.plastic_strain[out], state.plastic_strain[into]),
    }
}

/// Moves the vertex of the shape at rest, and with it the natural curvature at the neighbour whose edge turns.
fn move_rest(bundle: &mut RodBundle, place: &BreakPlace) {
    let (_, out) = place.edges();
    let tangent = |bundle: &RodBundle, edge: usize| {
        (bundle.rest.get(edge + 1) - bundle.rest.get(edge)).normalize_or(DVec3::Z)
    };
    let from = tangent(bundle, out);
    let position = place.between(&bundle.rest);
    bundle.rest.set(place.vertex, position);
    let to = tangent(bundle, out);
    let director = material_frame::parallel_transport(bundle.rest_director.get(out), from, to);
    let director = director.reject_from_normalized(to);
    let director = director.normalize_or(to.any_orthonormal_vector());
    bundle.rest_director.set(out, director);
    let away = place.away();
    if bundle.twisting && bundle.bend[away] > 0.0 {
        let frame = |edge: usize| (tangent(bundle, edge), bundle.rest_director.get(edge));
        let curvature = material_frame::curvature(frame(away - 1), frame(away));
        for (axis, kappa) in bundle.natural_curvature.iter_mut().zip(curvature) {
            axis[away] = kappa;
        }
    }
}

/// Moves mass and length from one edge to the other.
fn move_material(bundle: &mut RodBundle, place: &BreakPlace) {
    let (into, out) = place.edges();
    let moved = place.fraction * bundle.rest_length[into];
    let softness = bundle.rest_length[out] / bundle.stretch[out] + moved / bundle.stretch[into];
    bundle.stretch[out] = (bundle.rest_length[out] + moved) / softness;
    bundle.rest_length[into] -= moved;
    for array in [&mut bundle.edge_mass, &mut bundle.inertia] {
        let part = place.fraction * array[into];
        array[into] -= part;
        array[out] += part;
    }
}

/// The momentum of a vertex and its neighbours, with the spin of the edges between them.
struct Motion {
    linear: DVec3,
    /// About the vertex before it moved.
    angular: DVec3,
    centre: DVec3,
}

impl Motion {
    fn new(bundle: &RodBundle, state: &State, place: &BreakPlace) -> Self {
        Motion::about(bundle, state, place, state.position.get(place.vertex))
    }

    fn about(bundle: &RodBundle, state: &State, place: &BreakPlace, centre: DVec3) -> Self {
        let v = place.vertex;
        let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
        for i in v - 1..=v + 1 {
            let momentum = state.velocity.get(i) * bundle.mass[i];
            linear += momentum;
            angular += (state.position.get(i) - centre).cross(momentum);
        }
        for edge in [v - 1, v] {
            let spin = bundle.inertia[edge] * state.spin[edge];
            angular += state.edge(edge).normalize_or(DVec3::Z) * spin;
        }
        Motion {
            linear,
            angular,
            centre,
        }
    }

    /// Adds the rigid motion that makes up for what has changed.
    fn restore(&self, bundle: &RodBundle, state: &mut State, place: &BreakPlace) {
        let vertices = place.vertex - 1..=place.vertex + 1;
        let now = Motion::about(bundle, state, place, self.centre);
        let mass: f64 = vertices.clone().map(|i| bundle.mass[i]).sum();
        let middle = vertices.clone().fold(DVec3::ZERO, |sum, i| {
            sum + state.position.get(i) * (bundle.mass[i] / mass)
        });
        let linear = self.linear - now.linear;
        let angular = self.angular - now.angular - (middle - self.centre).cross(linear);
        let mut inertia = DMat3::ZERO;
        for i in vertices.clone() {
            let d = state.position.get(i) - middle;
            let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
            let own = DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer;
            inertia += own * bundle.mass[i];
        }
        let turn = turn_for(
            inertia,
            angular,
            state.edge(place.vertex).normalize_or(DVec3::Z),
        );
        for i in vertices {
            let arm = state.position.get(i) - middle;
            let change = linear / mass + turn.cross(arm);
            state.velocity.set(i, state.velocity.get(i) + change);
        }
    }
}

/// Returns the angular velocity that gives a body with this inertia an angular momentum. Of points on a line along `axis` it
/// is across the line.
fn turn_for(inertia: DMat3, angular: DVec3, axis: DVec3) -> DVec3 {
    /// Points nearer to a line than this, as a fraction of their distances squared, lie on it.
    const ON_A_LINE: f64 = 1e-10;
    let size = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
    if size <= 0.0 {
        return DVec3::ZERO;
    }
    if axis.dot(inertia * axis) > ON_A_LINE * size {
        return inertia.inverse() * angular;
    }
    // About axes across the line it is half of the trace.
    angular.reject_from_normalized(axis) / (0.5 * size)
}

/// The bonds of a vertex and of the edges beside it, as they were before it moved.
struct TouchedBonds {
    bonds: Vec<Bond>,
    touched: Vec<TouchedBond>,
}

/// A bond with its spring and its strain before a break moves.
struct TouchedBond {
    number: usize,
    spring: BondSpring,
    strain: BondStrain,
}

impl TouchedBonds {
    fn new(bundle: &RodBundle, state: &State, place: &BreakPlace) -> Self {
        let (v, (into, out)) = (place.vertex, place.edges());
        let mut bonds: Vec<Bond> = bundle.bonds.iter().collect();
        let mut touched = Vec::new();
        for (number, bond) in bonds.iter_mut().enumerate() {
            let edge = bond.edge as usize;
            if bond.vertex as usize != v && edge != into && edge != out {
                continue;
            }
            let spring = BondSpring::intact(bundle, number);
            let (e, d) = energy::bond::vectors(bundle, state, number);
            touched.push(TouchedBond {
                number,
                spring,
                strain: spring.strain(e, d),
            });
            if edge == into || edge == out {
                (bond.edge, bond.t) = place.on_new_edges(bundle, edge, bond.t);
            }
        }
        TouchedBonds { bonds, touched }
    }

    /// Puts the bonds back, each as stiff, open and slipped as it was.
    fn restore(mut self, bundle: &mut RodBundle, state: &State) {
        for TouchedBond {
            number,
            spring,
            strain,
        } in self.touched
        {
            let bond = &mut self.bonds[number];
            let edge = bond.edge as usize;
            let e = state.edge(edge);
            let d =
                state.position.get(bond.vertex as usize) - (state.position.get(edge) + e * bond.t);
            let now = spring.strain(e, d);
            let across = spring.rest_opening + now.opening - strain.opening;
            let along = spring.rest_slip + now.slip - strain.slip;
            // Where wood is pressed together so far that nothing would be left at rest, some of it is.
            let across = across.max(MIN_REST_FRACTION * spring.rest_opening);
            bond.distance = across.hypot(along);
            bond.rest_cosine = (along / bond.distance).clamp(-1.0, 1.0);
            bond.transverse = spring.opening * bond.distance;
            bond.shear = 0.5 * spring.slip * bond.distance * bond.distance;
        }
        bundle.bonds = Bonds::sorted(self.bonds, bundle.vertices());
    }
}

impl BreakPlace {
    /// Returns the edge and the parameter that the point `t` of `edge` will have.
    fn on_new_edges(&self, bundle: &RodBundle, edge: usize, t: f64) -> (u32, f64) {
        let (into, out) = self.edges();
        let length = |edge: usize| bundle.rest_length[edge];
        // Distances from the far end of the edge that becomes longer.
        let forward = self.towards > self.vertex;
        let along = |t: f64| if forward { t } else { 1.0 - t };
        let place = length(out) + self.fraction * length(into);
        let distance = if edge == out {
            along(t) * length(out)
        } else {
            length(out) + along(t) * length(into)
        };
        let (edge, t) = if distance <= place {
            (out, distance / place)
        } else {
            let whole = length(out) + length(into) - place;
            (into, (distance - place) / whole)
        };
        (edge as u32, along(t.clamp(0.0, 1.0)))
    }
}
