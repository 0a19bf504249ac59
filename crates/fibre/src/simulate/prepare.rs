//! From a scene and its meshes to a world with bodies.

use super::error::SimulateError;
use super::meshes::{SceneMeshes, StemScene, mesh_shapes, stem_scene};
use super::tissue_report::TissueReport;
use crate::placement::{
    Arrangement, EdgeLengths, FineEdges, Neighbours, PlacedRods, PlacementOptions, RodCount,
    WoodMaterial, fill_stem, fill_structured_stem,
};
use crate::rod_bundle::RodBundle;
use crate::scene::{
    ArrangementChoice, AssembledScene, NeighbourChoice, STEM_LENGTHS, StemChoice, TwistChoice,
    assemble,
};
use crate::store::checksum;
use glam::{DAffine3, DMat3, DVec3};
use greenstick_geometry::{Context, Scene, Stage};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::rings::StemRings;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{FoundStem, Stem, StemOptions, find_left_out, find_stem};
use greenstick_wood::structure::{TissueBoundaries, WoodStructure};
use greenstick_wood::tissue::{BARK_START, Proportions};

/// The wood of a scene: its stem filled with rods, before these are moved into the scene's axes.
#[derive(Debug, Clone)]
pub struct FilledStem {
    /// The stem.
    pub stem: Stem,
    /// The meshes that the stem was found in.
    pub scene: Scene,
    /// The node that the stem is part of.
    pub node: usize,
    /// The triangles of that node that bound the stem.
    pub shell: Vec<u32>,
    /// What of the input's mesh the rods do not fill, a sentence each.
    pub notes: Vec<String>,
    /// The rods.
    pub placed: PlacedRods,
    /// The mean properties of its wood.
    pub wood: WoodMaterial,
    /// What its wood looks like.
    pub appearance: WoodAppearance,
    /// Its annual rings.
    pub rings: StemRings,
    /// The scene with lengths for this stem.
    pub run_scene: crate::Scene,
}

/// Fills the stem of a scene with rods.
///
/// # Errors
/// [`SimulateError`] for a scene or an input that cannot be used.
pub fn fill_scene_stem(
    scene: &crate::Scene,
    input: Option<&Scene>,
    context: &Context,
) -> Result<FilledStem, SimulateError> {
    scene.check()?;
    let wood = wood_material(scene)?;
    let [finding, ringing, filling] = context.split([
        (Stage::new("stem"), 1.0),
        (Stage::new("rings"), 0.2),
        (Stage::new("rods"), 2.0),
    ]);
    finding.report(0.0)?;
    let of_stem = stem_scene(scene, input, &finding)?;
    let found = find_in_scene(scene, &of_stem, &finding)?;
    let (from, to) = found.stem.usable;
    let range = scene.stem.part.map(|p| from + p * (to - from));
    filling.report(0.0)?;
    let run_scene = scene.for_stem(simulated_length(scene, range)?);
    run_scene.check()?;
    let options = placement_options(&run_scene, (range[0], range[1]));
    let species = Species::find(&scene.wood.species)?;
    let proportions = Proportions::USUAL;
    let appearance = WoodAppearance::of_stem(
        &found.stem,
        &proportions,
        scene.seed,
        Some(species),
        BARK_START,
    );
    let mesh = || of_stem.scene.world_meshes().swap_remove(found.node);
    let rings = scene
        .rings
        .rings(&found, mesh, (&appearance, proportions), &ringing)?;
    let placed = if scene.wood.structure {
        let keys = &scene.wood;
        let boundaries = TissueBoundaries::from(&appearance);
        let structure = WoodStructure::new(species, keys.moisture, rings.clone(), boundaries)
            .with_planes(keys.ring_strength, keys.ray_strength)
            .with_grain(keys.grain());
        fill_structured_stem(&found.stem, &wood, &structure, &options, &filling)?
    } else {
        fill_stem(&found.stem, &wood, &options, &filling)?
    };
    let notes = match scene.stem.kind {
        StemChoice::Input => {
            let mut notes = of_stem.notes.clone();
            notes.extend(notes_on_rest(&of_stem, &found, range, context)?);
            notes.extend(note_on_inclination(&run_scene, &found, range));
            notes
        }
        _ => Vec::new(),
    };
    Ok(FilledStem {
        notes,
        stem: found.stem,
        node: found.node,
        shell: found.shell,
        scene: of_stem.scene,
        placed,
        wood,
        appearance,
        rings,
        run_scene,
    })
}

/// What of the mesh stays without rods: the stem beyond the part of it that is filled, and other limbs.
fn notes_on_rest(
    of_stem: &StemScene,
    found: &FoundStem,
    [from, to]: [f64; 2],
    context: &Context,
) -> Result<Vec<String>, SimulateError> {
    /// Share of the stem's length without rods that is reported.
    const MIN_REST: f64 = 0.05;
    let length = found.stem.length;
    let mut notes = Vec::new();
    if to - from < (1.0 - MIN_REST) * length {
        notes.push(format!(
            "rods fill {from:.3} to {to:.3} m of the stem's {length:.3} m, where it is free of forks and other parts and the \
             scene asks for rods"
        ));
    }
    let meshes = of_stem.scene.world_meshes();
    let left_out = find_left_out(&meshes[found.node], found, context)?;
    notes.extend(left_out.map(|l| l.to_string()));
    Ok(notes)
}

/// How the stem stands, where that decides how its loads act on it.
fn note_on_inclination(
    scene: &crate::Scene,
    found: &FoundStem,
    [from, to]: [f64; 2],
) -> Option<String> {
    let loads = &scene.loads;
    let loaded = loads.gravity != [0.0; 3] || loads.wind != [0.0; 3] || loads.snow > 0.0;
    if scene.stem.inclination.is_some() || !loaded {
        return None;
    }
    let up = scene.stem.up_of_input();
    let axis = found.stem.grain.axis();
    let along = axis.frame(to).origin - axis.frame(from).origin;
    let degrees = libm::asin(along.normalize_or_zero().dot(up)).to_degrees();
    Some(format!(
        "the stem stands as in the input, {degrees:.0}° above the horizontal from its base to its tip if {} is up, and gravity, \
         snow and wind act on it so; stem.up and stem.inclination say otherwise",
        if up == DVec3::Z { "z" } else { "y" }
    ))
}

fn find_in_scene(
    scene: &crate::Scene,
    of_stem: &StemScene,
    context: &Context,
) -> Result<FoundStem, SimulateError> {
    let meshes = of_stem.scene.world_meshes();
    let options = StemOptions {
        eccentricity_onset: scene.stem.eccentricity_onset,
        // Rods run along sawn wood, as in the straight-grained specimens of standard tests.
        slope_of_grain: 0.0,
        ..StemOptions::default()
    };
    Ok(find_stem(&meshes, &of_stem.location, &options, context)?)
}

/// Returns the properties of the scene's wood.
fn wood_material(scene: &crate::Scene) -> Result<WoodMaterial, SimulateError> {
    let species = Species::find(&scene.wood.species)?;
    let mut wood = WoodMaterial::from_species(species, scene.wood.moisture, Fallback::Estimate)?;
    for modulus in [
        &mut wood.longitudinal,
        &mut wood.radial,
        &mut wood.tangential,
        &mut wood.shear_radial,
        &mut wood.shear_tangential,
        // Strains at failure stay as they are, along the grain and across it. Fracture energies scale as strength squared
        // over the modulus.
        &mut wood.tension,
        &mut wood.compression,
        &mut wood.tension_across,
        &mut wood.compression_across,
        &mut wood.shear,
        &mut wood.fracture_energy,
    ] {
        *modulus *= scene.wood.stiffness;
    }
    // Decay has the least effect on shear (Wood Handbook, FPL-GTR-190, ch. 5).
    wood.tension *= 1.0 - scene.wood.brash;
    Ok(wood)
}

/// Length of the part of the stem that is simulated, m; `range` are its ends.
fn simulated_length(scene: &crate::Scene, range: [f64; 2]) -> Result<f64, SimulateError> {
    let (least, greatest) = STEM_LENGTHS;
    let length = match scene.stem.kind {
        StemChoice::Input => range[1] - range[0],
        // The length that the scene states: of a branch a little less may be usable.
        _ => scene.stem.length * (scene.stem.part[1] - scene.stem.part[0]),
    };
    if (least..=greatest).contains(&length) {
        return Ok(length);
    }
    Err(SimulateError::Length {
        length,
        least,
        greatest,
    })
}

fn placement_options(scene: &crate::Scene, range: (f64, f64)) -> PlacementOptions {
    let keys = &scene.rods;
    PlacementOptions {
        seed: scene.seed,
        arrangement: match keys.arrangement {
            ArrangementChoice::PoissonDisk => Arrangement::PoissonDisk,
            ArrangementChoice::Anatomy => Arrangement::Anatomy,
        },
        rods: match keys.spacing {
            Some(spacing) => RodCount::Spacing(spacing),
            None => RodCount::Number(keys.number),
        },
        edges: EdgeLengths {
            least: keys.edge[0],
            greatest: keys.edge[1],
        },
        fine: keys.fine.map(|part| {
            let [from, to] = part.map(|fraction| range.0 + fraction * (range.1 - range.0));
            FineEdges {
                range: (from, to),
                times: keys.fineness,
            }
        }),
        range: Some(range),
        clamp_ends: (scene.clamp.iter())
            .filter(|clamp| clamp.to > clamp.from)
            .flat_map(|clamp| [clamp.from, clamp.to])
            .filter(|fraction| *fraction > 0.0 && *fraction < 1.0)
            .map(|fraction| range.0 + fraction * (range.1 - range.0))
            .collect(),
        reach: keys.reach,
        neighbours: match keys.neighbours {
            NeighbourChoice::Facets => Neighbours::Facets,
            NeighbourChoice::WithinReach => Neighbours::WithinReach,
        },
        lloyd: keys.lloyd,
        twisting: match keys.twist {
            TwistChoice::Auto => None,
            TwistChoice::On => Some(true),
            TwistChoice::Off => Some(false),
        },
        weibull: keys.weibull.unwrap_or(f64::INFINITY),
    }
}

/// A scene that is ready to be moved by a solver.
pub(super) struct PreparedScene {
    /// The tissues that rods lie in.
    pub wood: Vec<TissueReport>,
    /// What of the input's mesh the rods do not fill, a sentence each.
    pub notes: Vec<String>,
    pub assembled: AssembledScene,
    /// The scene with lengths for its stem.
    pub scene: crate::Scene,
    /// Identifies the simulation: the same for all that ends in the same bytes.
    pub hash: u64,
}

/// Prepares a scene.
pub(super) fn prepare(
    scene: &crate::Scene,
    meshes: &SceneMeshes,
    context: &Context,
) -> Result<PreparedScene, SimulateError> {
    let shapes = mesh_shapes(scene, meshes)?;
    let FilledStem {
        placed,
        run_scene,
        notes,
        ..
    } = fill_scene_stem(scene, meshes.input.as_ref(), context)?;
    let wood = TissueReport::from_rods(&placed);
    let assembled = assemble(&run_scene, placed.bundle, &placed.along, &shapes, context)?;
    Ok(PreparedScene {
        wood,
        notes,
        hash: hash(&run_scene, &assembled),
        assembled,
        scene: run_scene,
    })
}

/// Returns what identifies a simulation: its scene, and where its rods begin. The duration may grow when a run is resumed.
pub(super) fn hash(scene: &crate::Scene, assembled: &AssembledScene) -> u64 {
    let without_duration = crate::Scene {
        duration: 0.0,
        ..scene.clone()
    };
    let mut content = without_duration.to_toml().into_bytes();
    let position = &assembled.world.state.position;
    for part in [&position.x, &position.y, &position.z] {
        part.iter()
            .for_each(|v| content.extend(v.to_bits().to_le_bytes()));
    }
    checksum(&content)
}

/// The unbroken rods in the scene's axes.
#[derive(Debug, Clone)]
pub struct PositionedBundle {
    /// The rods.
    pub bundle: RodBundle,
    /// Maps the stem's world to the scene's axes.
    pub scene_from_stem: DAffine3,
    /// What x, y and z of a level stem, whose z is the vertical, become in the scene: its columns.
    pub level: DMat3,
}

/// Moves the rods of a stem into the scene's axes.
///
/// # Errors
/// [`SimulateError`] as for a run.
pub fn position_bundle(
    filled: &FilledStem,
    meshes: &SceneMeshes,
    context: &Context,
) -> Result<PositionedBundle, SimulateError> {
    let scene = &filled.run_scene;
    let shapes = mesh_shapes(scene, meshes)?;
    let placed = &filled.placed;
    let assembled = assemble(
        scene,
        placed.bundle.clone(),
        &placed.along,
        &shapes,
        context,
    )?;
    Ok(PositionedBundle {
        bundle: assembled.world.bundle,
        scene_from_stem: assembled.scene_from_stem,
        level: assembled.level,
    })
}
