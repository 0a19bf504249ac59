//! A frame of a simulation as plain meshes: rods as tubes, bodies as solids.

use glam::{DAffine3, DQuat, DVec3};
use greenstick_fibre::bodies::Shape;
use greenstick_fibre::store::Frame;
use greenstick_geometry::{Material, Mesh, Node, Scene};
use greenstick_wood::primitive;
use std::f64::consts::{PI, TAU};

/// Sides of a tube.
const TUBE_SIDES: usize = 7;
/// Sides of a cylinder.
const CYLINDER_SIDES: u32 = 48;
/// Rows of a ball from pole to pole, and vertices around it.
const BALL_ROWS: u32 = 24;
const BALL_SIDES: u32 = 32;
/// Thickness and side of the plate that stands for a half-space, as parts of the diagonal of the rods' bounding box.
const PLATE_THICKNESS: f64 = 0.01;
const PLATE_SIDE: f64 = 1.1;

/// A body of a frame as a node.
#[derive(Debug, Clone)]
pub struct BodyNode {
    /// The node, where the body is in the frame.
    pub node: Node,
    /// Number of the body whose motion the node follows; `None` for the plate of a half-space, which stays under the rods.
    pub follows: Option<usize>,
}

/// Returns a frame as a scene: one mesh with a tube for each rod, and a mesh for each body.
///
/// A plate stands for a half-space. `shapes` are the shapes of the bodies about the centres that frames hold, in the same
/// order.
///
/// # Examples
/// ```
/// use greenstick_fibre::store::Frame;
/// use greenstick_skin::rods_scene::rods_scene;
///
/// // A rod of one edge.
/// let frame = Frame {
///     rod_offsets: vec![0, 2],
///     diameter: vec![0.002],
///     position: vec![[0.0, 0.0, 0.0], [0.0, 0.0, 0.01]],
///     director: vec![[1.0, 0.0, 0.0]; 2],
///     ..Frame::default()
/// };
/// let scene = rods_scene(&frame, &[]);
/// assert!(scene.nodes[0].mesh.volume() > 0.0);
/// ```
pub fn rods_scene(frame: &Frame, shapes: &[Shape]) -> Scene {
    let wood = plain_material("wood", [0.72, 0.53, 0.33, 1.0]);
    let mut scene = Scene {
        materials: vec![wood, body_material()],
        ..Scene::default()
    };
    let tubes = Node::new("rods", DAffine3::IDENTITY, tubes(frame));
    scene.nodes.push(tubes);
    let bodies = body_nodes(frame, shapes, 1);
    scene.nodes.extend(bodies.into_iter().map(|body| body.node));
    scene
}

/// Returns the bodies of a frame with the material of number `material`; `shapes` as for [`rods_scene`].
pub fn body_nodes(frame: &Frame, shapes: &[Shape], material: u32) -> Vec<BodyNode> {
    let mut nodes = Vec::new();
    for (number, (shape, body)) in shapes.iter().zip(&frame.bodies).enumerate() {
        let (mut mesh, transform, follows) = match shape {
            Shape::HalfSpace { normal } => {
                let plate = plate(frame, body.centre, body.rotation * *normal);
                (plate, DAffine3::IDENTITY, None)
            }
            _ => {
                let transform = DAffine3::from_rotation_translation(body.rotation, body.centre);
                (solid(shape), transform, Some(number))
            }
        };
        if mesh.triangles.is_empty() {
            continue;
        }
        mesh.materials = vec![material; mesh.triangles.len()];
        let node = Node::new("body", transform, mesh);
        nodes.push(BodyNode { node, follows });
    }
    nodes
}

/// The material of bodies.
pub fn body_material() -> Material {
    plain_material("body", [0.10, 0.105, 0.11, 1.0])
}

fn plain_material(name: &str, base_color: [f32; 4]) -> Material {
    Material {
        name: name.into(),
        base_color,
        roughness: 0.8,
        ..Material::default()
    }
}

/// A tube along each rod, closed at its ends.
fn tubes(frame: &Frame) -> Mesh {
    let mut mesh = Mesh::default();
    let position = |i: usize| DVec3::from_array(frame.position[i].map(f64::from));
    for (rod, ends) in frame.rod_offsets.windows(2).enumerate() {
        let (from, to) = (ends[0] as usize, ends[1] as usize);
        let radius = 0.5 * f64::from(frame.diameter[rod]);
        let mut across = DVec3::from_array(frame.director[from].map(f64::from));
        let first = mesh.positions.len() as u32;
        for i in from..to {
            let (before, after) = (position(i.max(from + 1) - 1), position((i + 1).min(to - 1)));
            let along = (after - before).normalize_or(DVec3::X);
            across = across
                .reject_from_normalized(along)
                .normalize_or(along.any_orthonormal_vector());
            let other = along.cross(across);
            for k in 0..TUBE_SIDES {
                let (sin, cos) = libm::sincos(TAU * k as f64 / TUBE_SIDES as f64);
                let out = across * cos + other * sin;
                mesh.positions.push(position(i) + radius * out);
            }
        }
        let (rows, sides) = ((to - from) as u32, TUBE_SIDES as u32);
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
        } => {
            let centred = DAffine3::from_translation(DVec3::new(0.0, -half_length, 0.0));
            primitive::cylinder(*radius, 2.0 * half_length, CYLINDER_SIDES).transformed(&centred)
        }
        // A hull or mesh that is no solid was refused when the scene was read.
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

/// A plate on top of the half-space with this normal (in the world) through `origin`, under all of the rods.
fn plate(frame: &Frame, origin: DVec3, normal: DVec3) -> Mesh {
    let positions = || {
        let all = frame.position.iter();
        all.map(|p| DVec3::from_array(p.map(f64::from)))
    };
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
    let diagonal = (high - low).length();
    let up = normal.normalize_or(DVec3::Z);
    if !(diagonal > 0.0 && diagonal.is_finite()) {
        return Mesh::default();
    }
    let (thickness, side) = (PLATE_THICKNESS * diagonal, PLATE_SIDE * diagonal);
    let middle = 0.5 * (low + high);
    let top = middle - up * (middle - origin).dot(up);
    let rotation = DQuat::from_rotation_arc(DVec3::Z, up);
    let transform = DAffine3::from_rotation_translation(rotation, top - up * (0.5 * thickness));
    primitive::board(thickness, side, side).transformed(&transform)
}

/// A ball whose halves are moved apart by `half` (m) along ±y: a sphere where it is 0, else a capsule.
fn ball(radius: f64, half: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=BALL_ROWS {
        let (s, c) = libm::sincos(PI * f64::from(row) / f64::from(BALL_ROWS));
        let offset = if 2 * row < BALL_ROWS { half } else { -half };
        for k in 0..BALL_SIDES {
            let turn = DQuat::from_rotation_y(TAU * f64::from(k) / f64::from(BALL_SIDES));
            let profile = DVec3::new(radius * s, radius * c + offset, 0.0);
            mesh.positions.push(turn * profile);
        }
    }
    let at = |row: u32, k: u32| row * BALL_SIDES + k % BALL_SIDES;
    for row in 0..BALL_ROWS {
        for k in 0..BALL_SIDES {
            let (a, b) = (at(row, k), at(row, k + 1));
            let (c, d) = (at(row + 1, k + 1), at(row + 1, k));
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    mesh
}
