//! Forces of clamps on the wood.

use crate::energy::add_forces;
use crate::forces::Forces;
use crate::loads::{Clamp, ClampForce};
use crate::world::World;

/// Returns the forces of all energies and loads, without clamps and contacts.
pub(crate) fn forces_on(world: &World) -> Forces {
    let (bundle, state) = (&world.bundle, &world.state);
    let mut forces = Forces::zeros(bundle.vertices());
    add_forces(bundle, state, &mut forces);
    let (x, v) = (&state.position, &state.velocity);
    (world.loads).add_forces(bundle, state.time, x, v, &mut forces);
    forces
}

/// Returns the present forces of the clamps: against the forces of the wood and the loads, without the inertia of what they hold.
pub(crate) fn clamp_forces(world: &World) -> Vec<ClampForce> {
    let (state, clamps) = (&world.state, &world.loads.clamps);
    if clamps.is_empty() {
        return Vec::new();
    }
    let forces = forces_on(world);
    let of_clamp = |clamp: &Clamp| {
        let centre = clamp.centre + clamp.motion.pose(state.time).translation;
        let mut sum = ClampForce::default();
        for &v in &clamp.vertices {
            let mut against = -forces.linear.get(v as usize);
            for a in (0..3).filter(|&a| !clamp.axes[a]) {
                against[a] = 0.0;
            }
            sum.force += against;
            sum.moment += (state.position.get(v as usize) - centre).cross(against);
        }
        if world.bundle.twisting {
            for &j in &clamp.edges {
                let along = state.edge(j as usize).normalize_or_zero();
                sum.moment -= along * forces.moment[j as usize];
            }
        }
        sum
    };
    clamps.iter().map(of_clamp).collect()
}
