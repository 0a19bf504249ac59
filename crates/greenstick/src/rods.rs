//! A frame of a simulation as meshes: rods as tubes, bodies as solids.

use glam::{DAffine3, DQuat, DVec3};
use greenstick_fibre::bodies::Shape;
use greenstick_fibre::store::Frame;
use greenstick_geometry::{Material, Mesh, Node, Scene};
use greenstick_wood::primitive;

/// Sides of a tube.
const SIDES: usize = 7;
/// Thickness and width of the plate that is shown of a half-space, in diagonals of the box around the rods.
const PLATE: f64 = 0.01;
const OVER: f64 = 1.1;

/// A frame as a scene: one mesh of tubes, and one for each body; of a half-space a plate. `shapes` are the bodies' shapes
/// about the centres that frames hold, in their order ([`crate::simulate::body_shapes`]).
pub fn rods_scene(frame: &Frame, shapes: &[Shape]) -> Scene {
    let mut scene = Scene {
        materials: vec![material("wood", [0.72, 0.53, 0.33, 1.0]), body_material()],
        ..Scene::default()
    };
    scene
        .nodes
        .push(node("rods", tubes(frame), DAffine3::IDENTITY));
    scene
        .nodes
        .extend(bodies(frame, shapes, 1).into_iter().map(|(node, _)| node));
    scene
}

/// The bodies of a frame where they are, in material `material`, each with its number where it moves as a whole; of a
/// half-space a plate.
pub(crate) fn bodies(frame: &Frame, shapes: &[Shape], material: u32) -> Vec<(Node, Option<usize>)> {
    let mut nodes = Vec::new();
    for (number, (shape, body)) in shapes.iter().zip(&frame.bodies).enumerate() {
        let place = DAffine3::from_rotation_translation(body.rotation, body.centre);
        let (mut mesh, place, moves) = match shape {
            Shape::HalfSpace { normal } => {
                let plate = ground(frame, body.centre, body.rotation * *normal);
                (plate, DAffine3::IDENTITY, None)
            }
            _ => (solid(shape), place, Some(number)),
        };
        if mesh.triangles.is_empty() {
            continue;
        }
        mesh.materials = vec![material; mesh.triangles.len()];
        nodes.push((node("body", mesh, place), moves));
    }
    nodes
}

/// The material of bodies.
pub(crate) fn body_material() -> Material {
    material("body", [0.36, 0.40, 0.45, 1.0])
}

fn material(name: &str, base_color: [f32; 4]) -> Material {
    Material {
        name: name.into(),
        base_color,
        roughness: 0.8,
        ..Material::default()
    }
}

fn node(name: &str, mesh: Mesh, transform: DAffine3) -> Node {
    Node::new(name, transform, mesh)
}

fn tubes(frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let place = |i: usize| DVec3::from_array(frame.position[i].map(f64::from));
    for (rod, ends) in frame.rod_offsets.windows(2).enumerate() {
        let (from, to) = (ends[0] as usize, ends[1] as usize);
        let radius = 0.5 * f64::from(frame.diameter[rod]);
        let mut across = DVec3::from_array(frame.director[from].map(f64::from));
        let first = mesh.positions.len() as u32;
        for i in from..to {
            let (before, after) = (place(i.max(from + 1) - 1), place((i + 1).min(to - 1)));
            let along = (after - before).normalize_or(DVec3::X);
            across = across
                .reject_from_normalized(along)
                .normalize_or(along.any_orthonormal_vector());
            let other = along.cross(across);
            for k in 0..SIDES {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / SIDES as f64);
                mesh.positions
                    .push(place(i) + radius * (across * cos + other * sin));
            }
        }
        let (rows, sides) = ((to - from) as u32, SIDES as u32);
        let at = |row: u32, k: u32| first + row * sides + k % sides;
        for row in 0..rows - 1 {
            for k in 0..sides {
                let (a, b) = (at(row, k), at(row, k + 1));
                let (c, d) = (at(row + 1, k + 1), at(row + 1, k));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        for k in 1..sides - 1 {
            mesh.triangles.push([at(0, 0), at(0, k + 1), at(0, k)]);
            mesh.triangles
                .push([at(rows - 1, 0), at(rows - 1, k), at(rows - 1, k + 1)]);
        }
    }
    mesh.materials = vec![0; mesh.triangles.len()];
    mesh
}

/// A body about its centre.
fn solid(shape: &Shape) -> Mesh {
    let centred = |radius: f64, half: f64| {
        let map = DAffine3::from_translation(DVec3::new(0.0, -half, 0.0));
        primitive::cylinder(radius, 2.0 * half, 48).transformed(&map)
    };
    match shape {
        // Length along z, width along x, thickness along y.
        Shape::Box { half } => primitive::board(2.0 * half.z, 2.0 * half.x, 2.0 * half.y),
        Shape::Sphere { radius } => ball(*radius, 0.0),
        Shape::Capsule {
            half_length,
            radius,
        } => ball(*radius, *half_length),
        Shape::Cylinder {
            half_length,
            radius,
        } => centred(*radius, *half_length),
        // A hull or mesh that is no solid has been refused long before.
        _ => match shape.surface(0, false) {
            Ok(Some(surface)) => Mesh {
                positions: surface.points,
                triangles: surface.triangles,
                ..Mesh::default()
            },
            _ => Mesh::default(),
        },
    }
}

/// A plate on top of a half-space of some normal (in the world) through `place`, under all of the rods.
fn ground(frame: &Frame, place: DVec3, normal: DVec3) -> Mesh {
    let points = || {
        let each = frame.position.iter();
        each.map(|p| DVec3::from_array(p.map(f64::from)))
    };
    let low = points().fold(DVec3::INFINITY, DVec3::min);
    let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    let side = (high - low).length();
    let up = normal.normalize_or(DVec3::Z);
    if !(side > 0.0 && side.is_finite()) {
        return Mesh::default();
    }
    let thick = PLATE * side;
    let middle = 0.5 * (low + high);
    let top = middle - up * (middle - place).dot(up);
    let turn = DQuat::from_rotation_arc(DVec3::Z, up);
    let map = DAffine3::from_rotation_translation(turn, top - up * (0.5 * thick));
    primitive::board(thick, OVER * side, OVER * side).transformed(&map)
}

/// A ball whose halves are `half` (m) off the middle along ±y.
fn ball(radius: f64, half: f64) -> Mesh {
    const ROWS: u32 = 24;
    const AROUND: u32 = 32;
    let mut mesh = Mesh::default();
    for row in 0..=ROWS {
        let (s, c) = libm::sincos(std::f64::consts::PI * f64::from(row) / f64::from(ROWS));
        let off = if 2 * row < ROWS { half } else { -half };
        for k in 0..AROUND {
            let turn =
                DQuat::from_rotation_y(std::f64::consts::TAU * f64::from(k) / f64::from(AROUND));
            mesh.positions
                .push(turn * DVec3::new(radius * s, radius * c + off, 0.0));
        }
    }
    let at = |row: u32, k: u32| row * AROUND + k % AROUND;
    for row in 0..ROWS {
        for k in 0..AROUND {
            let (a, b) = (at(row, k), at(row, k + 1));
            let (c, d) = (at(row + 1, k + 1), at(row + 1, k));
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    mesh
}
