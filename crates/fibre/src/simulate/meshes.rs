//! The meshes of a simulation: that of the stem, and those of bodies.

use super::error::SimulateError;
use crate::bodies::Shape;
use crate::scene::{BodyKeys, MotionChoice, ShapeChoice, StemChoice};
use glam::{DAffine3, DVec3};
use greenstick_geometry::{Context, Node, Scene, repair};
use greenstick_wood::primitive::{self, BranchOptions};
use greenstick_wood::stem::StemLocation;
use std::collections::BTreeMap;

/// The meshes that a scene names.
#[derive(Debug, Clone, Default)]
pub struct SceneMeshes {
    /// The mesh with the stem, where the scene is of one, m.
    pub input: Option<Scene>,
    /// For each body the mesh of its file; `None` for those without a file. It may be shorter than the list of bodies.
    pub bodies: Vec<Option<Scene>>,
}

/// A scene with a stem, and where on it.
pub(super) struct StemScene {
    pub scene: Scene,
    pub location: StemLocation,
    /// What was repaired in it, a sentence each.
    pub notes: Vec<String>,
}

/// Returns the mesh with the stem of a scene, m: the input, or one of the scene's own.
pub(super) fn stem_scene(
    scene: &crate::Scene,
    input: Option<&Scene>,
    context: &Context,
) -> Result<StemScene, SimulateError> {
    let stem = &scene.stem;
    let mesh = match stem.kind {
        StemChoice::Branch => {
            let options = BranchOptions {
                length: stem.length,
                diameter: stem.diameter,
                ..BranchOptions::default()
            };
            return Ok(StemScene {
                scene: greenstick_wood::branch::branch_scene(&options),
                location: StemLocation::Fraction(0.5),
                notes: Vec::new(),
            });
        }
        StemChoice::Cylinder => primitive::cylinder(0.5 * stem.diameter, stem.length, 48),
        StemChoice::Board => primitive::board(stem.length, stem.width, stem.thickness),
        StemChoice::Input => {
            let mut scene = input.ok_or(SimulateError::NoInput)?.clone();
            return Ok(StemScene {
                notes: repair::repair_scene(&mut scene, context)?,
                scene,
                location: stem.at,
            });
        }
    };
    Ok(StemScene {
        scene: Scene {
            nodes: vec![Node::new("stem", DAffine3::IDENTITY, mesh)],
            ..Scene::default()
        },
        location: StemLocation::Fraction(0.5),
        notes: Vec::new(),
    })
}

/// Returns the shape of each body that has the shape of a mesh file; `None` for the others.
pub(super) fn mesh_shapes(
    scene: &crate::Scene,
    meshes: &SceneMeshes,
) -> Result<Vec<Option<Shape>>, SimulateError> {
    let shape = |(number, body): (usize, &BodyKeys)| {
        if body.file.is_empty() {
            return Ok(None);
        }
        let mesh = meshes.bodies.get(number).and_then(Option::as_ref);
        let mesh = mesh.ok_or_else(|| SimulateError::NoBodyMesh {
            body: number,
            file: body.file.clone(),
        })?;
        Ok(Some(mesh_shape(mesh, body.shape)))
    };
    scene.body.iter().enumerate().map(shape).collect()
}

/// Returns the mesh of a scene as a shape. Its equal points become one.
fn mesh_shape(scene: &Scene, choice: ShapeChoice) -> Shape {
    let mut numbers = BTreeMap::new();
    let (mut points, mut triangles): (Vec<DVec3>, Vec<[u32; 3]>) = Default::default();
    for node in &scene.nodes {
        for t in 0..node.mesh.triangles.len() {
            triangles.push(node.mesh.corners(t).map(|p| {
                // −0 becomes 0.
                let p = node.transform.transform_point3(p) + DVec3::ZERO;
                *numbers
                    .entry(p.to_array().map(f64::to_bits))
                    .or_insert_with(|| {
                        points.push(p);
                        points.len() as u32 - 1
                    })
            }));
        }
    }
    match choice {
        ShapeChoice::Hull => Shape::Hull { points },
        _ => Shape::Mesh { points, triangles },
    }
}

/// Returns the shapes of a scene's bodies as they are drawn about the centres that frames hold: those of mesh files as
/// meshes, hulls with their faces. The scene is that of a run ([`crate::store::RunSource::scene`]), whose lengths are for its
/// stem.
///
/// # Errors
/// [`SimulateError`] for meshes that are missing or cannot be used.
pub fn body_shapes(
    scene: &crate::Scene,
    meshes: &SceneMeshes,
) -> Result<Vec<Shape>, SimulateError> {
    let of_meshes = mesh_shapes(scene, meshes)?;
    let mut shapes = Vec::new();
    for (number, (body, of_mesh)) in scene.body.iter().zip(of_meshes).enumerate() {
        let shape = body.body_shape(number, of_mesh.as_ref())?;
        let free = body.motion == MotionChoice::Free;
        shapes.push(match shape.surface(number, free)? {
            Some(surface) => Shape::Mesh {
                points: surface.points,
                triangles: surface.triangles,
            },
            None => shape,
        });
    }
    Ok(shapes)
}
