//! From a scene and a bundle to a world that a solver can move.

use super::arc;
use super::start::{bend, lay, turn};
use super::{
    BodyKeys, BondWord, ClampKeys, ForceKeys, KeyFrame, MotionWord, Scene, SceneError, ShapeWord,
    SolverWord,
};
use crate::bodies::{Bodies, Body, BodyMotion, ContactOptions, Shape, clearance};
use crate::bundle::Bundle;
use crate::failure::{BondCriterion, Failure};
use crate::loads::{Clamp, Moment, Motion, PointForce, Pose, Ramp, Wind};
use crate::solver::World;
use crate::state::State;
use glam::{DAffine3, DVec3};

/// A scene with a bundle in it.
pub struct SetUp {
    /// The bundle at the start, with what acts on it.
    pub world: World,
    /// Bodies and colliding rods.
    pub bodies: Bodies,
    /// Place of each vertex along the stem, 0 to 1.
    pub fraction: Vec<f64>,
    /// Length of the stem, m.
    pub length: f64,
    /// The stem's world to the scene's.
    pub laid: DAffine3,
}

/// A body is near enough to the stem, m.
const TOUCHING: f64 = 1e-8;
/// Most moves of a body towards the stem.
const MOVES: usize = 2000;

/// Puts a bundle, whose vertices are at lengths `along` (m) of the stem, into a scene. `meshes` are the points and
/// triangles of the bodies' files, one entry for each body.
///
/// # Errors
/// [`SceneError`] for what does not fit: a clamp that holds nothing, bodies that overlap, numbers out of range.
pub fn set_up(
    scene: &Scene,
    mut bundle: Bundle,
    along: &[f64],
    meshes: &[Option<Shape>],
) -> Result<SetUp, SceneError> {
    scene.check()?;
    let (low, high) = along
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &s| {
            (l.min(s), h.max(s))
        });
    let span = (high - low).max(f64::MIN_POSITIVE);
    let fraction: Vec<f64> = along.iter().map(|s| (s - low) / span).collect();
    let (length, laid) = lay(&mut bundle, &fraction);
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
    loads(scene, &mut world, &fraction, length)?;
    world.check()?;
    let mut bodies = Vec::new();
    for (number, keys) in scene.body.iter().enumerate() {
        let mesh = meshes.get(number).and_then(Option::as_ref);
        bodies.push(body(number, keys, mesh, &world, &fraction)?);
    }
    let options = ContactOptions {
        gravity: DVec3::from_array(scene.loads.gravity),
        rods: scene.contact.rods.then_some(scene.contact.restitution),
    };
    let bodies = Bodies::new(bodies, options, &world.bundle, &world.state, &world.loads)?;
    Ok(SetUp {
        world,
        bodies,
        fraction,
        length,
        laid,
    })
}

fn failure(scene: &Scene) -> Failure {
    let keys = &scene.failure;
    Failure {
        rods_break: keys.rods,
        rods_yield: keys.yielding,
        interval: if scene.solver == SolverWord::Explicit {
            keys.every
        } else {
            1
        },
        bonds: match keys.bonds {
            BondWord::Never => BondCriterion::Never,
            BondWord::Potential => BondCriterion::Potential {
                threshold: keys.threshold,
                shear_weight: keys.shear_weight,
            },
            BondWord::Griffith => BondCriterion::Griffith,
            BondWord::Stress => BondCriterion::Stress,
        },
        ..Failure::default()
    }
}

fn rise(seconds: f64) -> Ramp {
    if seconds > 0.0 {
        Ramp::Rise(seconds)
    } else {
        Ramp::Constant
    }
}

fn loads(
    scene: &Scene,
    world: &mut World,
    fraction: &[f64],
    length: f64,
) -> Result<(), SceneError> {
    let World {
        bundle,
        state,
        loads,
        ..
    } = world;
    let keys = &scene.loads;
    loads.gravity = DVec3::from_array(keys.gravity);
    loads.damping = keys.damping;
    let rods = bundle.rods() as f64;
    if keys.snow_rise > 0.0 {
        let down = loads.gravity.try_normalize().unwrap_or(DVec3::NEG_Z);
        for i in 0..bundle.vertices() {
            loads.forces.push(PointForce {
                vertex: i as u32,
                force: down * (0.5 * keys.snow / rods * bundle.both_lengths(i)),
                ramp: rise(keys.snow_rise),
            });
        }
    } else {
        loads.snow = keys.snow / rods;
    }
    let velocity = DVec3::from_array(keys.wind);
    if velocity != DVec3::ZERO {
        let area: f64 = bundle.area.iter().sum();
        loads.wind = Some(Wind {
            velocity,
            density: keys.air,
            drag: keys.drag,
            // The stem's own width, shared, so that rods in the lee do not count again.
            width: Some(2.0 * (area / std::f64::consts::PI).sqrt() / rods),
        });
    }
    for (number, clamp) in scene.clamp.iter().enumerate() {
        let made = self::clamp(number, clamp, bundle, state, fraction)?;
        world.loads.clamps.push(made);
    }
    let (clamps, position) = (&mut world.loads.clamps, &world.state.position);
    arc::follow(clamps, &scene.clamp, &world.bundle, position, fraction)?;
    for force in &scene.force {
        add_force(force, world, fraction, length);
    }
    Ok(())
}

/// Key frames, or steady velocities, as a motion.
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
                translation: DVec3::from_array(k.move_by.0),
                rotation: turn(k.turn),
            };
            (k.time, pose)
        };
        return Ok(Motion::Keys(keys.iter().map(frame).collect()));
    }
    let (velocity, angular) = (
        DVec3::from_array(velocity),
        DVec3::from_array(angular.map(f64::to_radians)),
    );
    Ok(if velocity == DVec3::ZERO && angular == DVec3::ZERO {
        Motion::Fixed
    } else {
        Motion::Steady { velocity, angular }
    })
}

fn clamp(
    number: usize,
    keys: &ClampKeys,
    bundle: &Bundle,
    state: &State,
    fraction: &[f64],
) -> Result<Clamp, SceneError> {
    let inside = |f: f64| (keys.from - 1e-9..=keys.to + 1e-9).contains(&f);
    let vertices: Vec<u32> = (0..bundle.vertices())
        .filter(|&i| inside(fraction[i]))
        .map(|i| i as u32)
        .collect();
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
    let moved = motion(
        format!("clamp {number}"),
        &keys.key,
        keys.velocity,
        keys.angular,
    )?;
    let mut made = Clamp::of(bundle, vertices, moved);
    // Where they are at the start, which need not be where they are at rest.
    made.held = made
        .vertices
        .iter()
        .map(|&v| state.position.get(v as usize))
        .collect();
    made.centre = made.held.iter().fold(DVec3::ZERO, |a, p| a + *p) / made.held.len().max(1) as f64;
    made.directors = made
        .edges
        .iter()
        .map(|&j| state.material_director(bundle, j as usize))
        .collect();
    if keys.axes.is_empty() || keys.axes.chars().any(|c| !"xyz".contains(c)) {
        return Err(SceneError::Word {
            key: format!("axes of clamp {number}"),
            found: keys.axes.clone(),
            right: "one or more of x, y and z",
        });
    }
    made.axes = ['x', 'y', 'z'].map(|a| keys.axes.contains(a));
    Ok(made)
}

/// Vertices of a section: of each rod the one nearest to `at`.
fn section(bundle: &Bundle, fraction: &[f64], at: f64) -> Vec<usize> {
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
    let ramp = rise(keys.rise);
    let (force, moment) = (
        DVec3::from_array(keys.force),
        DVec3::from_array(keys.moment),
    );
    for (rod, vertex) in section(bundle, fraction, keys.at).into_iter().enumerate() {
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
    let size = DVec3::from_array(keys.size.0);
    let radius = 0.5 * keys.diameter.0;
    let file = |shape| {
        mesh.cloned().ok_or(SceneError::NoMesh {
            body: number,
            shape,
        })
    };
    Ok(match keys.shape {
        ShapeWord::HalfSpace => Shape::HalfSpace { normal: DVec3::Z },
        ShapeWord::Box => Shape::Box { half: 0.5 * size },
        ShapeWord::Sphere => Shape::Sphere { radius },
        ShapeWord::Capsule => Shape::Capsule {
            half_length: (0.5 * size.y - radius).max(0.0),
            radius,
        },
        ShapeWord::Cylinder => Shape::Cylinder {
            half_length: 0.5 * size.y,
            radius,
        },
        ShapeWord::Hull => file("hull")?,
        ShapeWord::Mesh => file("mesh")?,
    })
}

impl BodyKeys {
    /// Its shape, as body `number` of a scene; a hull or mesh is that of its `file`.
    ///
    /// # Errors
    /// [`SceneError::NoMesh`] where it needs a file and has none.
    pub fn plain_shape(&self, number: usize, file: Option<&Shape>) -> Result<Shape, SceneError> {
        shape(number, self, file)
    }
}

fn body(
    number: usize,
    keys: &BodyKeys,
    mesh: Option<&Shape>,
    world: &World,
    fraction: &[f64],
) -> Result<Body, SceneError> {
    let vertices = section(&world.bundle, fraction, keys.at);
    let axis = vertices
        .iter()
        .fold(DVec3::ZERO, |sum, &v| sum + world.state.position.get(v))
        / vertices.len().max(1) as f64;
    let motion = match keys.motion {
        MotionWord::Given => BodyMotion::Given(motion(
            format!("body {number}"),
            &keys.key,
            keys.velocity,
            keys.angular,
        )?),
        MotionWord::Free => BodyMotion::Free {
            density: keys.density,
            velocity: DVec3::from_array(keys.velocity),
            angular: DVec3::from_array(keys.angular.map(f64::to_radians)),
        },
    };
    let made = Body {
        name: keys.name.clone(),
        shape: shape(number, keys, mesh)?,
        place: axis + DVec3::from_array(keys.place.0),
        turn: turn(keys.turn).normalize(),
        motion,
        restitution: keys.restitution,
        friction: keys.friction,
    };
    match keys.touch {
        Some(from) => brought(number, made, DVec3::from_array(from), keys.gap.0, world),
        None => Ok(made),
    }
}

/// Moves a body from far away on the side of `from` towards its place until it touches, then back by `gap` (m).
fn brought(
    number: usize,
    mut body: Body,
    from: DVec3,
    gap: f64,
    world: &World,
) -> Result<Body, SceneError> {
    let misses = SceneError::Misses {
        body: number,
        x: from.x,
        y: from.y,
        z: from.z,
    };
    let Some(way) = from.try_normalize() else {
        return Err(misses);
    };
    // From where the whole stem is surely free of it; sizes of shapes are bounded by their clearance.
    let stem = world
        .state
        .position
        .iter()
        .map(|p| p.distance(body.place))
        .fold(0.0, f64::max);
    let target = body.place;
    let mut out = 2.0 * stem + 0.01;
    loop {
        body.place = target + way * out;
        if clearance(&body, &world.bundle, &world.state)? > 0.0 {
            break;
        }
        out *= 2.0;
        if out > 1e4 * (stem + 1.0) {
            return Err(misses);
        }
    }
    for _ in 0..MOVES {
        // What is free on all sides is free on this one.
        let free = clearance(&body, &world.bundle, &world.state)?;
        if free < TOUCHING {
            body.place += way * (gap + TOUCHING - free);
            return Ok(body);
        }
        body.place -= way * free;
        if (target - body.place).dot(way) > 2.0 * (out + stem) {
            return Err(misses);
        }
    }
    body.place += way * gap;
    Ok(body)
}
