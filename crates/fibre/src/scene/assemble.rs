//! From a scene and a bundle to a world that a solver can move.

use super::arc;
use super::choices::{BondCriterionChoice, MotionChoice, ShapeChoice, SolverChoice, StemChoice};
use super::error::SceneError;
use super::keys::{BodyKeys, ClampKeys, ForceKeys, KeyFrame, LoadKeys, RodKeys, Scene, StemKeys};
use super::start::{align_with_axes, bend, level_frame, rotation};
use crate::bodies::{Bodies, Body, BodyError, BodyMotion, ContactOptions, Shape, clearance};
use crate::failure::{BondCriterion, FailureCriteria};
use crate::loads::{Clamp, Keyframe, Moment, Motion, PointForce, Pose, Ramp, Wind};
use crate::rod_bundle::RodBundle;
use crate::state::State;
use crate::world::World;
use glam::{DAffine3, DMat3, DVec3};
use greenstick_geometry::Context;

/// A scene with a bundle in it.
pub struct AssembledScene {
    /// The bundle at the start, with its loads.
    pub world: World,
    /// Bodies and colliding rods.
    pub bodies: Bodies,
    /// Per vertex: position along the stem, 0 to 1.
    pub fraction: Vec<f64>,
    /// Length of the stem, m.
    pub length: f64,
    /// The map from the stem's coordinates to the scene's.
    pub scene_from_stem: DAffine3,
    /// What x, y and z of a level stem, whose z is the vertical, become in the scene: its columns.
    pub level: DMat3,
}

/// Distance at which a body counts as touching the stem, m.
const TOUCH_TOLERANCE: f64 = 1e-8;
/// Acceleration of free fall by which weights are turned into masses where a scene has no gravity, m/s².
const STANDARD_GRAVITY: f64 = 9.80665;
/// Largest number of moves of a body towards the stem.
const MAX_MOVES: usize = 2000;

/// Puts a bundle, whose vertices are at lengths `along` (m) of the stem, into a scene. `meshes` are the hulls and meshes of the
/// bodies' files, one entry for each body.
///
/// # Errors
/// [`SceneError`] for what does not fit: a clamp without vertices, bodies that overlap, numbers out of range.
pub fn assemble(
    scene: &Scene,
    mut bundle: RodBundle,
    along: &[f64],
    meshes: &[Option<Shape>],
    context: &Context,
) -> Result<AssembledScene, SceneError> {
    scene.check()?;
    let (low, high) = along
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &s| {
            (l.min(s), h.max(s))
        });
    let span = (high - low).max(f64::MIN_POSITIVE);
    let fraction: Vec<f64> = along.iter().map(|s| (s - low) / span).collect();
    let up = match scene.stem.kind {
        StemChoice::Input => scene.stem.up_of_input(),
        _ => DVec3::Z,
    };
    let (length, scene_from_stem) = align_with_axes(&mut bundle, &fraction, up);
    let mut world = World::new(bundle);
    bend(
        &world.bundle,
        &mut world.state,
        length,
        scene.start.bend.to_radians(),
    );
    let velocity = DVec3::from_array(scene.start.velocity);
    for i in 0..world.bundle.vertices() {
        world.state.velocity.set(i, velocity);
    }
    world.failure = failure(scene);
    let level = level_frame(vertical(&scene.stem, scene_from_stem.matrix3 * up));
    loads(scene, &mut world, &fraction, (length, level))?;
    world.check()?;
    let mut bodies = Vec::new();
    for (number, keys) in scene.body.iter().enumerate() {
        let mesh = meshes.get(number).and_then(Option::as_ref);
        let wood = Wood {
            world: &world,
            fraction: &fraction,
        };
        bodies.push(body(number, keys, mesh, wood, context)?);
    }
    let options = ContactOptions {
        gravity: world.loads.gravity,
        rod_restitution: scene.contact.rods.then_some(scene.contact.restitution),
    };
    let (bundle, state, loads) = (&world.bundle, &world.state, &world.loads);
    let bodies = Bodies::new(bodies, options, bundle, state, loads, context)?;
    Ok(AssembledScene {
        world,
        bodies,
        fraction,
        length,
        scene_from_stem,
        level,
    })
}

/// The vertical in the scene's axes; `standing` is that of the stem as it stands.
fn vertical(keys: &StemKeys, standing: DVec3) -> DVec3 {
    match (keys.inclination, keys.kind) {
        (Some(degrees), _) => {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            DVec3::new(sin, 0.0, cos)
        }
        (None, StemChoice::Input) => standing,
        (None, _) => DVec3::Z,
    }
}

fn failure(scene: &Scene) -> FailureCriteria {
    let keys = &scene.failure;
    FailureCriteria {
        rods_break: keys.rods,
        rods_yield: keys.yielding,
        between_vertices: keys.between_vertices,
        check_interval: if scene.solver == SolverChoice::Explicit {
            keys.every
        } else {
            1
        },
        bonds: match keys.bonds {
            BondCriterionChoice::Never => BondCriterion::Never,
            BondCriterionChoice::Potential => BondCriterion::Potential {
                threshold: keys.threshold,
                shear_weight: keys.shear_weight,
            },
            BondCriterionChoice::Griffith => BondCriterion::Griffith,
            BondCriterionChoice::Stress => BondCriterion::Stress,
            BondCriterionChoice::Cohesive => BondCriterion::Cohesive,
        },
        ..FailureCriteria::default()
    }
}

fn ramp(seconds: f64) -> Ramp {
    if seconds > 0.0 {
        Ramp::Linear(seconds)
    } else {
        Ramp::Constant
    }
}

/// Lays snow on all rods alike. Its mass is there from the start, so that what breaks off falls with its snow and no faster than
/// that; while its weight rises, the rest of it is held up.
fn snow(keys: &LoadKeys, level: &DMat3, bundle: &mut RodBundle, forces: &mut Vec<PointForce>) {
    if keys.snow <= 0.0 {
        return;
    }
    let gravity = *level * DVec3::from_array(keys.gravity);
    let weightless = gravity == DVec3::ZERO;
    let acceleration = if weightless {
        STANDARD_GRAVITY
    } else {
        gravity.length()
    };
    let weight = keys.snow / bundle.rods() as f64;
    bundle.add_line_mass(weight / acceleration);
    let (direction, ramp) = match (weightless, keys.snow_rise > 0.0) {
        (true, _) => (*level * DVec3::NEG_Z, ramp(keys.snow_rise)),
        (false, true) => (-gravity / acceleration, Ramp::Falling(keys.snow_rise)),
        (false, false) => return,
    };
    forces.extend((0..bundle.vertices()).map(|i| PointForce {
        vertex: i as u32,
        force: direction * (0.5 * weight * bundle.both_lengths(i)),
        ramp,
    }));
}

fn loads(
    scene: &Scene,
    world: &mut World,
    fraction: &[f64],
    (length, level): (f64, DMat3),
) -> Result<(), SceneError> {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let keys = &scene.loads;
    loads.gravity = level * DVec3::from_array(keys.gravity);
    loads.damping = keys.damping;
    let rods = bundle.rods() as f64;
    snow(keys, &level, bundle, &mut loads.forces);
    let velocity = level * DVec3::from_array(keys.wind);
    if velocity != DVec3::ZERO {
        let area: f64 = bundle.area.iter().sum();
        loads.wind = Some(Wind {
            velocity,
            density: keys.air,
            drag: keys.drag,
            // The stem's width divided among its rods, so that rods in the lee do not count again.
            width: Some(2.0 * (area / std::f64::consts::PI).sqrt() / rods),
            ramp: ramp(keys.wind_rise),
        });
    }
    for (number, clamp) in scene.clamp.iter().enumerate() {
        let clamp = self::clamp((number, clamp), &scene.rods, (bundle, state), fraction)?;
        world.loads.clamps.push(clamp);
    }
    let (clamps, position) = (&mut world.loads.clamps, &world.state.position);
    arc::preserve_length(clamps, &scene.clamp, &world.bundle, position, fraction)?;
    for force in &scene.force {
        add_force(force, world, fraction, length);
    }
    Ok(())
}

/// Returns key frames, or constant velocities, as a motion.
fn motion(
    what: String,
    keys: &[KeyFrame],
    velocity: [f64; 3],
    angular: [f64; 3],
) -> Result<Motion, SceneError> {
    if let Some(pair) = keys.windows(2).find(|p| p[1].time <= p[0].time) {
        let time = pair[1].time;
        return Err(SceneError::Keys { what, time });
    }
    if !keys.is_empty() {
        let frame = |k: &KeyFrame| {
            let pose = Pose {
                translation: DVec3::from_array(k.move_by),
                rotation: rotation(k.turn),
            };
            Keyframe { time: k.time, pose }
        };
        return Ok(Motion::Keyframes(keys.iter().map(frame).collect()));
    }
    let velocity = DVec3::from_array(velocity);
    let angular_velocity = DVec3::from_array(angular.map(f64::to_radians));
    Ok(
        if velocity == DVec3::ZERO && angular_velocity == DVec3::ZERO {
            Motion::Fixed
        } else {
            Motion::Steady {
                velocity,
                angular_velocity,
            }
        },
    )
}

/// Returns the vertices that a clamp holds: those in its range, and where edges are equal those with which it ends where it
/// should ([`PlacementOptions::clamp_ends`](crate::placement::PlacementOptions)).
///
/// Bending at a vertex is that of half of both edges beside it, so that a rod that is held up to a vertex is free from the middle
/// of the edge before it: this vertex must lie beyond the clamp's end. It is the same at a clamp's beginning, mirrored, for rods
/// without bonds. Rods with bonds turn by these, and where their vertices lie in common cross-sections bonds turn with the edge
/// before.
fn held_vertices(
    keys: &ClampKeys,
    rods: &RodKeys,
    bundle: &RodBundle,
    fraction: &[f64],
) -> Vec<u32> {
    let inside = |i: usize| (keys.from - 1e-9..=keys.to + 1e-9).contains(&fraction[i]);
    let even = rods.edge[0] == rods.edge[1];
    let (starts, ends) = (even && keys.from > 0.0, even && keys.to < 1.0);
    let starts = starts && bundle.bonds.is_empty();
    (0..bundle.vertices())
        .filter(|&i| {
            let after = ends && i > 0 && bundle.is_edge(i - 1) && inside(i - 1);
            let before = starts && bundle.is_edge(i) && inside(i + 1);
            inside(i) || after || before
        })
        .map(|i| i as u32)
        .collect()
}

fn clamp(
    (number, keys): (usize, &ClampKeys),
    rods: &RodKeys,
    (bundle, state): (&RodBundle, &State),
    fraction: &[f64],
) -> Result<Clamp, SceneError> {
    let vertices = held_vertices(keys, rods, bundle, fraction);
    if vertices.is_empty() {
        let apart = (0..bundle.vertices())
            .filter(|&j| bundle.is_edge(j))
            .map(|j| (fraction[j + 1] - fraction[j]).abs())
            .fold(0.0, f64::max);
        return Err(SceneError::EmptyClamp {
            clamp: number,
            from: keys.from,
            to: keys.to,
            apart,
        });
    }
    let motion = motion(
        format!("clamp {number}"),
        &keys.key,
        keys.velocity,
        keys.angular,
    )?;
    let mut clamp = Clamp::new(bundle, vertices, motion);
    // Positions at the start, which need not be those at rest.
    clamp.rest_positions = clamp
        .vertices
        .iter()
        .map(|&v| state.position.get(v as usize))
        .collect();
    let sum = clamp.rest_positions.iter().fold(DVec3::ZERO, |a, p| a + *p);
    clamp.centre = sum / clamp.rest_positions.len().max(1) as f64;
    clamp.directors = clamp
        .edges
        .iter()
        .map(|&j| state.material_director(bundle, j as usize))
        .collect();
    clamp.axes = keys.axes.0;
    Ok(clamp)
}

/// Returns the vertices of a cross-section: of each rod the one nearest to `at`.
fn section_vertices(bundle: &RodBundle, fraction: &[f64], at: f64) -> Vec<usize> {
    (0..bundle.rods())
        .filter_map(|r| {
            bundle.rod(r).min_by(|&a, &b| {
                (fraction[a] - at)
                    .abs()
                    .total_cmp(&(fraction[b] - at).abs())
            })
        })
        .collect()
}

fn add_force(keys: &ForceKeys, world: &mut World, fraction: &[f64], length: f64) {
    let bundle = &world.bundle;
    let area: f64 = bundle.area.iter().sum();
    let ramp = ramp(keys.rise);
    let (force, moment) = (
        DVec3::from_array(keys.force),
        DVec3::from_array(keys.moment),
    );
    for (rod, vertex) in section_vertices(bundle, fraction, keys.at)
        .into_iter()
        .enumerate()
    {
        let share = bundle.area[rod] / area;
        if force != DVec3::ZERO {
            world.loads.forces.push(PointForce {
                vertex: vertex as u32,
                force: force * share,
                ramp,
            });
        }
        if moment != DVec3::ZERO && length > 0.0 {
            let edge = if bundle.is_edge(vertex) {
                vertex
            } else {
                vertex - 1
            };
            world.loads.moments.push(Moment {
                edge: edge as u32,
                moment: moment * share,
                ramp,
            });
        }
    }
}

fn shape(number: usize, keys: &BodyKeys, mesh: Option<&Shape>) -> Result<Shape, SceneError> {
    let size = DVec3::from_array(keys.size);
    let radius = 0.5 * keys.diameter;
    let file = |shape| {
        mesh.cloned().ok_or(SceneError::NoMesh {
            body: number,
            shape,
        })
    };
    Ok(match keys.shape {
        ShapeChoice::HalfSpace => Shape::HalfSpace { normal: DVec3::Z },
        ShapeChoice::Box => Shape::Box { half: 0.5 * size },
        ShapeChoice::Sphere => Shape::Sphere { radius },
        ShapeChoice::Capsule => Shape::Capsule {
            half_length: (0.5 * size.y - radius).max(0.0),
            radius,
        },
        ShapeChoice::Cylinder => Shape::Cylinder {
            half_length: 0.5 * size.y,
            radius,
        },
        ShapeChoice::Wedge => wedge(0.5 * size),
        ShapeChoice::Hull => file("hull")?,
        ShapeChoice::Mesh => file("mesh")?,
    })
}

/// Returns a wedge of half these sides (m).
fn wedge(half: DVec3) -> Shape {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z) * half;
    let sides = [-1.0, 1.0].map(|y| {
        [
            corner(-1.0, y, 0.0),
            corner(1.0, y, -1.0),
            corner(1.0, y, 1.0),
        ]
    });
    Shape::Hull {
        points: sides.concat(),
    }
}

impl BodyKeys {
    /// Returns its shape, as body `number` of a scene; a hull or mesh is that of its `file`.
    ///
    /// # Errors
    /// [`SceneError::NoMesh`] where it needs a file and has none.
    pub fn body_shape(&self, number: usize, file: Option<&Shape>) -> Result<Shape, SceneError> {
        shape(number, self, file)
    }
}

/// The wood of a scene, and the position of each vertex along the stem.
#[derive(Clone, Copy)]
struct Wood<'a> {
    world: &'a World,
    fraction: &'a [f64],
}

fn body(
    number: usize,
    keys: &BodyKeys,
    mesh: Option<&Shape>,
    Wood { world, fraction }: Wood,
    context: &Context,
) -> Result<Body, SceneError> {
    let vertices = section_vertices(&world.bundle, fraction, keys.at);
    let axis = vertices
        .iter()
        .fold(DVec3::ZERO, |sum, &v| sum + world.state.position.get(v))
        / vertices.len().max(1) as f64;
    let motion = match keys.motion {
        MotionChoice::Given => BodyMotion::Prescribed(motion(
            format!("body {number}"),
            &keys.key,
            keys.velocity,
            keys.angular,
        )?),
        MotionChoice::Free => BodyMotion::Free {
            density: keys.density,
            velocity: DVec3::from_array(keys.velocity),
            angular_velocity: DVec3::from_array(keys.angular.map(f64::to_radians)),
        },
    };
    let body = Body {
        name: keys.name.clone(),
        shape: shape(number, keys, mesh)?,
        position: axis + DVec3::from_array(keys.place),
        rotation: rotation(keys.turn).normalize(),
        motion,
        restitution: keys.restitution,
        friction: keys.friction,
    };
    let Some(from) = keys.touch else {
        return Ok(body);
    };
    let from = DVec3::from_array(from);
    match moved_to_touch(body, from, keys.gap, world, context)? {
        Some(touching) => Ok(touching),
        None => Err(SceneError::Misses {
            body: number,
            x: from.x,
            y: from.y,
            z: from.z,
        }),
    }
}

/// Moves a body from far away in the direction `from` towards its position until it touches the wood, then back by `gap`
/// (m). Returns `None` where it misses.
fn moved_to_touch(
    mut body: Body,
    from: DVec3,
    gap: f64,
    world: &World,
    context: &Context,
) -> Result<Option<Body>, BodyError> {
    let Some(way) = from.try_normalize() else {
        return Ok(None);
    };
    let distance = |body: &Body| clearance(body, &world.bundle, &world.state, context);
    // Start where the body is certainly clear of the whole stem; the clearance also bounds the size of shapes.
    let stem = world
        .state
        .position
        .iter()
        .map(|p| p.distance(body.position))
        .fold(0.0, f64::max);
    let target = body.position;
    let mut start = 2.0 * stem + 0.01;
    loop {
        body.position = target + way * start;
        if distance(&body)? > 0.0 {
            break;
        }
        start *= 2.0;
        if start > 1e4 * (stem + 1.0) {
            return Ok(None);
        }
    }
    for _ in 0..MAX_MOVES {
        // The body can move by its clearance in any direction.
        let free = distance(&body)?;
        if free < TOUCH_TOLERANCE {
            body.position += way * (gap + TOUCH_TOLERANCE - free);
            return Ok(Some(body));
        }
        body.position -= way * free;
        if (target - body.position).dot(way) > 2.0 * (start + stem) {
            return Ok(None);
        }
    }
    body.position += way * gap;
    Ok(Some(body))
}
