//! From a scene and a mesh to a world with bodies.

use super::{SimulateError, SimulateRequest};
use crate::files;
use glam::{DAffine3, DVec3};
use greenstick_fibre::RodBundle;
use greenstick_fibre::bodies::Shape;
use greenstick_fibre::placement::{
    Arrangement, EdgeLengths, PlacedRods, PlacementOptions, RodCount, WoodMaterial, fill_stem,
};
use greenstick_fibre::scene::{
    ArrangementChoice, AssembledScene, MotionChoice, Scene as Setting, ShapeChoice, StemChoice,
    TwistChoice, assemble,
};
use greenstick_fibre::store::checksum;
use greenstick_geometry::{Context, Scene, Stage};
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::{self, BranchOptions};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Place, Stem, StemOptions, find};
use std::path::Path;

/// The scene of the scene's stem, m, and where on it.
fn meshes(setting: &Setting, input: Option<&Scene>) -> Result<(Scene, Place), SimulateError> {
    let stem = &setting.stem;
    let mesh = match stem.kind {
        StemChoice::Branch => {
            let options = BranchOptions {
                length: stem.length.0,
                diameter: stem.diameter.0,
                ..BranchOptions::default()
            };
            return Ok((crate::branch::branch(&options), Place::parse("0.5", 1.0)?));
        }
        StemChoice::Cylinder => primitive::cylinder(0.5 * stem.diameter.0, stem.length.0, 48),
        StemChoice::Board => primitive::board(stem.length.0, stem.width.0, stem.thickness.0),
        StemChoice::Input => {
            let scene = input.ok_or(SimulateError::NoInput)?;
            return Ok((scene.clone(), Place::parse(&stem.at, 1.0)?));
        }
    };
    let node = greenstick_geometry::Node {
        name: "stem".into(),
        transform: DAffine3::IDENTITY,
        mesh: mesh.into(),
        parent: None,
    };
    let scene = Scene {
        nodes: vec![node],
        ..Scene::default()
    };
    Ok((scene, Place::parse("0.5", 1.0)?))
}

/// The wood of a scene: a stem filled with rods, before it is laid into the scene.
#[derive(Debug, Clone)]
pub struct Grown {
    /// The stem.
    pub stem: Stem,
    /// What the stem was found in.
    pub scene: Scene,
    /// Index of the node that the stem is part of, and its triangles.
    pub shell: (usize, Vec<u32>),
    /// The rods.
    pub placed: PlacedRods,
    /// The wood's numbers.
    pub wood: WoodMaterial,
    /// The scene with lengths for this stem.
    pub setting: Setting,
}

/// Fills the stem of a scene with rods.
///
/// # Errors
/// [`SimulateError`] for a scene or an input that cannot be used.
pub fn grow(
    setting: &Setting,
    input: Option<&Scene>,
    context: &Context,
) -> Result<Grown, SimulateError> {
    setting.check()?;
    let wood = wood(setting)?;
    let [stem, rods] = context.split([(Stage::new("stem"), 1.0), (Stage::new("rods"), 2.0)]);
    stem.report(0.0)?;
    let (scene, at) = meshes(setting, input)?;
    let found = find(
        &greenstick_skin::prepared::world_meshes(&scene),
        &at,
        &StemOptions::default(),
        &stem,
    )?;
    let (from, to) = found.stem.usable;
    let part = setting.stem.part.map(|p| from + p * (to - from));
    rods.report(0.0)?;
    let setting = setting.for_stem(match setting.stem.kind {
        StemChoice::Input => part[1] - part[0],
        // What is asked for: of a branch less may be of use.
        _ => setting.stem.length.0 * (setting.stem.part[1] - setting.stem.part[0]),
    });
    setting.check()?;
    let options = placement(&setting, (part[0], part[1]));
    let placed = fill_stem(&found.stem, &wood, &options, &rods)?;
    Ok(Grown {
        stem: found.stem,
        shell: (found.node, found.shell),
        scene,
        placed,
        wood,
        setting,
    })
}

/// The numbers of the scene's wood.
fn wood(setting: &Setting) -> Result<WoodMaterial, SimulateError> {
    let species = Species::find(&setting.wood.species)?;
    let mut wood =
        WoodMaterial::from_species(species, setting.wood.moisture, Fallback::TwelvePercent)?;
    for modulus in [
        &mut wood.longitudinal,
        &mut wood.radial,
        &mut wood.tangential,
        &mut wood.shear_radial,
        &mut wood.shear_tangential,
        // Strains at failure stay as they are, along the grain and across it; energies of fracture go with the square of
        // strength over the modulus.
        &mut wood.tension,
        &mut wood.compression,
        &mut wood.tension_across,
        &mut wood.shear,
        &mut wood.fracture_energy,
    ] {
        *modulus *= setting.wood.stiffness;
    }
    Ok(wood)
}

fn placement(setting: &Setting, range: (f64, f64)) -> PlacementOptions {
    let keys = &setting.rods;
    PlacementOptions {
        seed: setting.seed,
        arrangement: match keys.arrangement {
            ArrangementChoice::PoissonDisk => Arrangement::PoissonDisk,
            ArrangementChoice::Anatomy => Arrangement::Anatomy,
        },
        rods: match keys.spacing {
            Some(spacing) => RodCount::Spacing(spacing.0),
            None => RodCount::Number(keys.number),
        },
        edges: EdgeLengths {
            least: keys.edge[0].0,
            greatest: keys.edge[1].0,
        },
        range: Some(range),
        reach: keys.reach,
        twisting: match keys.twist {
            TwistChoice::Auto => None,
            TwistChoice::On => Some(true),
            TwistChoice::Off => Some(false),
        },
        weibull: keys.weibull.unwrap_or(f64::INFINITY),
        rings: keys.rings,
        rays: keys.rays,
        ring_strength: keys.ring_strength,
        ray_strength: keys.ray_strength,
    }
}

/// The scene as a world with bodies, with lengths for its stem, and the hash of what it depends on.
pub(super) fn prepare(
    request: &SimulateRequest,
    input: Option<&Scene>,
    context: &Context,
) -> Result<(AssembledScene, Setting, u64), SimulateError> {
    let Grown {
        placed, setting, ..
    } = grow(&request.scene, input, context)?;
    let shapes = body_files(request)?;
    let made = assemble(&setting, placed.bundle, &placed.along, &shapes, context)?;
    // The duration may grow when a run is resumed; everything else must be as it was.
    let lasting = Setting {
        duration: 0.0,
        ..setting.clone()
    };
    let mut all = lasting.to_toml().into_bytes();
    let position = &made.world.state.position;
    for part in [&position.x, &position.y, &position.z] {
        part.iter()
            .for_each(|v| all.extend(v.to_bits().to_le_bytes()));
    }
    Ok((made, setting, checksum(&all)))
}

/// The unbroken bundle of a scene in the scene's axes, and the movement from the stem's world to them.
///
/// # Errors
/// [`SimulateError`] as for a run.
pub(crate) fn lay(
    request: &SimulateRequest,
    grown: &Grown,
) -> Result<(RodBundle, DAffine3), SimulateError> {
    let shapes = body_files(request)?;
    let placed = &grown.placed;
    let made = assemble(
        &grown.setting,
        placed.bundle.clone(),
        &placed.along,
        &shapes,
        &Context::quiet(),
    )?;
    Ok((made.world.bundle, made.scene_from_stem))
}

/// The meshes that bodies name.
pub(super) fn body_files(request: &SimulateRequest) -> Result<Vec<Option<Shape>>, SimulateError> {
    let mut shapes = Vec::new();
    for body in &request.scene.body {
        if body.file.is_empty() {
            shapes.push(None);
            continue;
        }
        let scene = files::read(&request.origin.beside.join(&body.file), None)?;
        let mut numbers = std::collections::BTreeMap::new();
        let (mut points, mut triangles): (Vec<DVec3>, Vec<[u32; 3]>) = Default::default();
        for node in &scene.nodes {
            for t in 0..node.mesh.triangles.len() {
                triangles.push(node.mesh.corners(t).map(|p| {
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
        shapes.push(Some(match body.shape {
            ShapeChoice::Hull => Shape::Hull { points },
            _ => Shape::Mesh { points, triangles },
        }));
    }
    Ok(shapes)
}

/// The shapes of the scene's bodies as they are to be drawn about the centres that frames hold: those of mesh files as
/// meshes, hulls with their faces. The scene is that of a run ([`scene_of`]), whose lengths are for its stem.
///
/// # Errors
/// [`SimulateError`] for mesh files that cannot be used.
pub fn body_shapes(request: &SimulateRequest) -> Result<Vec<Shape>, SimulateError> {
    let files = body_files(request)?;
    let mut shapes = Vec::new();
    for (number, (body, file)) in request.scene.body.iter().zip(files).enumerate() {
        let shape = body.body_shape(number, file.as_ref())?;
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

/// The scene of the run in a folder, as it was run.
///
/// # Errors
/// [`SimulateError`] where there is none.
pub fn scene_of(folder: &Path) -> Result<Setting, SimulateError> {
    let path = folder.join("scene.toml");
    let text = std::fs::read_to_string(&path)
        .map_err(|source| files::FileError::Unreadable { path, source })?;
    Ok(Setting::read(&text)?)
}
