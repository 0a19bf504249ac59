//! A recorded run: its wood, and what it shows of a frame.

use super::error::FilmError;
use super::material_numbers::{BARK_MATERIAL, INNER_MATERIAL, OWN_MATERIALS};
use super::placement::Placement;
use crate::rods::{FractureState, Materials, RodSkin, RodSkinOptions, Wood, rod_skin};
use crate::texture::SectionSquare;
use glam::{DAffine3, DMat3, DVec2};
use greenstick_fibre::bodies::Shape;
use greenstick_fibre::placement::{PlacedRods, WoodMaterial};
use greenstick_fibre::scene::Scene as Setting;
use greenstick_fibre::simulate::{
    PositionedBundle, SceneMeshes, SimulateError, body_shapes, fill_scene_stem, position_bundle,
};
use greenstick_fibre::store::{Frame, FrameTimes, RunSource};
use greenstick_fibre::{Cause, Event, EventKind, RodBundle};
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Bvh, Context, Mesh, Scene};
use greenstick_wood::appearance::{StemAppearance, WoodAppearance};
use greenstick_wood::rings::StemRings;
use greenstick_wood::stem::Stem;
use greenstick_wood::structure::TissueBoundaries;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Side of the texture's square over the width of the section.
const SQUARE_SIDE: f64 = 1.02;

/// The wood that a run is of: a stem, and the rods that fill it.
#[derive(Debug, Clone)]
pub struct RunWood {
    /// The stem.
    pub stem: Stem,
    /// The meshes that the stem was found in.
    pub input: Scene,
    /// The node that the stem is part of.
    pub node: usize,
    /// The triangles of that node that bound the stem.
    pub shell: Vec<u32>,
    /// The rods in the stem's world.
    pub placed: PlacedRods,
    /// The mean properties of its wood.
    pub material: WoodMaterial,
    /// What its wood looks like.
    pub appearance: WoodAppearance,
    /// Its annual rings.
    pub rings: StemRings,
    /// The unbroken rods in the scene's axes.
    pub bundle: RodBundle,
    /// Maps the stem's world to the scene's axes.
    pub scene_from_stem: DAffine3,
    /// What x, y and z of a level stem, whose z is the vertical, become in the scene: its columns.
    pub level: DMat3,
    /// The shapes of the bodies about the centres that frames hold.
    pub shapes: Vec<Shape>,
}

impl RunWood {
    /// Grows the wood of a recorded run again, from its scene and the meshes that the scene names.
    ///
    /// # Errors
    /// [`SimulateError`] as for the run itself.
    pub fn from_scene(
        scene: &Setting,
        meshes: &SceneMeshes,
        context: &Context,
    ) -> Result<RunWood, SimulateError> {
        let shapes = body_shapes(scene, meshes)?;
        let filled = fill_scene_stem(scene, meshes.input.as_ref(), context)?;
        let PositionedBundle {
            bundle,
            scene_from_stem,
            level,
        } = position_bundle(&filled, meshes, context)?;
        Ok(RunWood {
            stem: filled.stem,
            input: filled.scene,
            node: filled.node,
            shell: filled.shell,
            placed: filled.placed,
            material: filled.wood,
            appearance: filled.appearance,
            rings: filled.rings,
            bundle,
            scene_from_stem,
            level,
            shapes,
        })
    }
}

/// A run that was simulated.
pub struct Run {
    /// Its scene.
    pub scene: Setting,
    pub(super) wood: RunWood,
    pub(super) source: Arc<dyn RunSource>,
    pub(super) frames: FrameTimes,
    pub(super) causes: BTreeMap<u32, Cause>,
    pub(super) appearance: StemAppearance,
    pub(super) bark: Mesh,
    pub(super) tree: Bvh,
    pub(super) square: SectionSquare,
    pub(super) placement: Placement,
}

/// Returns why vertices of the unbroken rods broke.
fn break_causes(events: &[Event]) -> BTreeMap<u32, Cause> {
    let broken = events.iter().filter(|e| e.kind == EventKind::RodBroke);
    broken
        .map(|event| {
            let cause = match event.cause {
                Cause::Compression => Cause::Compression,
                _ => Cause::Tension,
            };
            (event.vertex, cause)
        })
        .collect()
}

/// Returns the square about the outline of a section.
fn square_about(outline: &[DVec2]) -> SectionSquare {
    let points = || outline.iter().copied();
    let low = points().fold(DVec2::INFINITY, DVec2::min);
    let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
    let side = SQUARE_SIDE * (high - low).max_element();
    SectionSquare::round(0.5 * (low + high), side)
}

/// Returns the mesh that bounds the stem.
fn bark_mesh(wood: &RunWood) -> Mesh {
    let node = &wood.input.nodes[wood.node];
    let shell = wood.shell.iter().map(|&t| t as usize);
    let mut bark = node.mesh.submesh(shell).transformed(&node.transform);
    // Built-in stems split their triangles by materials that no scene lists.
    let listed = wood.input.materials.len();
    let unlisted = bark.materials.iter_mut().filter(|m| **m as usize >= listed);
    unlisted.for_each(|m| *m = NO_MATERIAL);
    bark
}

impl Run {
    /// Takes a run that was recorded, and the wood that its frames are of.
    ///
    /// # Errors
    /// [`FilmError`] where the run cannot be read or has no frame.
    pub fn new(source: Arc<dyn RunSource>, wood: RunWood) -> Result<Run, FilmError> {
        let scene = source.scene()?;
        let frames = source.frames()?;
        if frames.count() == 0 {
            return Err(FilmError::NoFrames { run: source.name() });
        }
        let causes = break_causes(&source.events()?);
        let (inside, rings) = (wood.appearance.clone(), wood.rings.clone());
        let appearance = StemAppearance::new(&wood.stem, inside, rings);
        let placement = Placement::as_it_stands(&scene, wood.scene_from_stem, wood.level);
        let bark = bark_mesh(&wood);
        Ok(Run {
            scene,
            square: square_about(&wood.placed.outline),
            tree: Bvh::from_mesh(&bark),
            wood,
            source,
            frames,
            causes,
            appearance,
            bark,
            placement,
        })
    }

    /// Lays the stem along x in films and stills, as it lies in the scene, wherever it stands.
    pub fn along_x(mut self) -> Run {
        self.placement = Placement::along_x(self.wood.scene_from_stem);
        self
    }

    /// Returns the number of whole frames.
    pub fn frames(&self) -> usize {
        self.frames.count()
    }

    /// Returns the appearance of its wood and bark.
    pub fn appearance(&self) -> &StemAppearance {
        &self.appearance
    }

    /// Returns the stem that its rods fill.
    pub fn stem(&self) -> &Stem {
        &self.wood.stem
    }

    /// Returns the times (s) at which a film shows a range of frames: those of the run, or, in slow motion, at its frame rate.
    pub(super) fn film_times(&self, range: std::ops::Range<usize>) -> Vec<f64> {
        if self.scene.slow > 1.0 {
            let at = |number: usize| number as f64 / self.scene.frames_per_second;
            range.map(at).collect()
        } else {
            self.frames.times[range].to_vec()
        }
    }

    /// Returns frame `number`.
    ///
    /// # Errors
    /// [`FilmError`] where it cannot be read.
    pub fn frame(&self, number: usize) -> Result<Arc<Frame>, FilmError> {
        Ok(self.source.frame(number)?)
    }

    /// Returns the map from the stem's world, that of the mesh that was simulated, to that of stills and films.
    pub fn film_from_stem(&self) -> DAffine3 {
        self.placement.film_from_stem
    }

    /// Returns its wood, unbroken.
    pub fn wood(&self) -> Wood<'_> {
        let material = &self.wood.material;
        Wood {
            stem: &self.wood.stem,
            stem_to_rods: self.wood.scene_from_stem,
            bundle: &self.wood.bundle,
            along: &self.wood.placed.along,
            cells: &self.wood.placed.cells,
            outline: &self.wood.placed.outline,
            bark: Some((&self.bark, &self.tree)),
            pull_out: material.tension / (4.0 * material.shear),
        }
    }

    /// Returns the skin of what is broken in `frame`, at rest.
    pub(super) fn skin(
        &self,
        frame: &Frame,
        options: &RodSkinOptions,
    ) -> Result<RodSkin, FilmError> {
        let state = FractureState::from_frame(&self.wood(), frame, &self.causes)?;
        Ok(self.with_materials(|wood, materials| rod_skin(wood, &state, materials, options))?)
    }

    /// Calls `make` with the wood and the materials of stills and films.
    pub(super) fn with_materials<T, E>(
        &self,
        make: impl FnOnce(&Wood, &Materials) -> Result<T, E>,
    ) -> Result<T, E> {
        let tissues = TissueBoundaries::from(&self.wood.appearance);
        let barked = self.wood.stem.kind.has_bark();
        let materials = Materials {
            bark: u32::from(barked) * BARK_MATERIAL,
            bark_mesh_offset: OWN_MATERIALS,
            inner: INNER_MATERIAL,
            square: self.square,
            zone: &|rho| tissues.tissue(rho).code(),
        };
        make(&self.wood(), &materials)
    }
}
