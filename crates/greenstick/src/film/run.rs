//! A recorded run: its wood, and what it shows of a frame.

use super::error::FilmError;
use super::material_numbers::{BARK_MATERIAL, INNER_MATERIAL, OWN_MATERIALS};
use super::poses::upright;
use crate::simulate::{
    FilledStem, PositionedBundle, SceneMeshes, body_shapes, fill_scene_stem, position_bundle,
};
use glam::{DAffine3, DVec2};
use greenstick_fibre::bodies::Shape;
use greenstick_fibre::scene::Scene as Setting;
use greenstick_fibre::store::{Frame, FrameTimes, RunSource};
use greenstick_fibre::{Cause, Event, EventKind, RodBundle};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Bvh, Context, Mesh, Scene};
use greenstick_picture::{Picture, PictureError, PictureOptions};
use greenstick_skin::rods::{FractureState, Materials, RodSkin, RodSkinOptions, Wood, rod_skin};
use greenstick_skin::texture::SectionSquare;
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemKind};
use greenstick_wood::tissue::BARK_START;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Side of the texture's square over the width of the section.
const SQUARE_SIDE: f64 = 1.02;

/// A run that was simulated.
pub struct Run {
    /// Its scene.
    pub scene: Setting,
    pub(super) grown: FilledStem,
    /// The unbroken bundle in the scene's axes.
    pub(super) bundle: RodBundle,
    /// The stem's world to the scene's.
    pub(super) laid: DAffine3,
    pub(super) shapes: Vec<Shape>,
    pub(super) source: Arc<dyn RunSource>,
    pub(super) frames: FrameTimes,
    pub(super) causes: BTreeMap<u32, Cause>,
    pub(super) appearance: StemAppearance,
    pub(super) bark: Mesh,
    pub(super) tree: Bvh,
    pub(super) square: SectionSquare,
}

/// Why vertices of the unbroken rods broke.
fn causes(events: &[Event]) -> BTreeMap<u32, Cause> {
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

impl Run {
    /// Opens a run that was recorded. `meshes` are those that its scene names.
    ///
    /// # Errors
    /// [`FilmError`] where there is no run, or where it is of other meshes.
    pub fn open(
        source: Arc<dyn RunSource>,
        meshes: &SceneMeshes,
        context: &Context,
    ) -> Result<Run, FilmError> {
        let scene = source.scene()?;
        let frames = source.frames()?;
        if frames.count() == 0 {
            return Err(FilmError::NoFrames { run: source.name() });
        }
        let shapes = body_shapes(&scene, meshes)?;
        let grown = fill_scene_stem(&scene, meshes.input.as_ref(), context)?;
        let PositionedBundle {
            bundle,
            scene_from_stem: laid,
        } = position_bundle(&grown, meshes, context)?;
        let causes = causes(&source.events()?);
        let species = Species::find(&scene.wood.species).ok();
        let tissues = BreakParameters::default().proportions();
        let appearance =
            StemAppearance::new(&grown.stem, &tissues, scene.seed, species, BARK_START);
        let node = &grown.scene.nodes[grown.node];
        let shell = grown.shell.iter().map(|&t| t as usize);
        let mut bark = node.mesh.submesh(shell).transformed(&node.transform);
        // Stems that come with the program part their triangles by materials that no scene lists.
        let listed = grown.scene.materials.len();
        let unlisted = bark.materials.iter_mut().filter(|m| **m as usize >= listed);
        unlisted.for_each(|m| *m = NO_MATERIAL);
        let tree = Bvh::from_mesh(&bark);
        let outline = &grown.placed.outline;
        let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = outline
            .iter()
            .copied()
            .fold(DVec2::NEG_INFINITY, DVec2::max);
        Ok(Run {
            square: SectionSquare {
                middle: 0.5 * (low + high),
                side: SQUARE_SIDE * (high - low).max_element(),
            },
            scene,
            grown,
            bundle,
            laid,
            shapes,
            source,
            frames,
            causes,
            appearance,
            bark,
            tree,
        })
    }

    /// Number of whole frames.
    pub fn frames(&self) -> usize {
        self.frames.count()
    }

    /// The appearance of its wood and bark.
    pub fn appearance(&self) -> &StemAppearance {
        &self.appearance
    }

    /// The stem that its rods fill.
    pub fn stem(&self) -> &Stem {
        &self.grown.stem
    }

    /// Returns a frame.
    pub(super) fn frame(&self, number: usize) -> Result<Arc<Frame>, FilmError> {
        Ok(self.source.frame(number)?)
    }

    /// Returns the map from the stem's world to that of stills and films.
    pub(super) fn film_from_stem(&self) -> DAffine3 {
        DAffine3::from_quat(upright()) * self.laid
    }

    /// Its wood, unbroken.
    pub fn wood(&self) -> Wood<'_> {
        let wood = &self.grown.wood;
        Wood {
            stem: &self.grown.stem,
            stem_to_rods: self.laid,
            bundle: &self.bundle,
            along: &self.grown.placed.along,
            cells: &self.grown.placed.cells,
            outline: &self.grown.placed.outline,
            bark: Some((&self.bark, &self.tree)),
            pull_out: wood.tension / (4.0 * wood.shear),
        }
    }

    /// The skin of what is broken in `frame`, at rest.
    pub(super) fn skin(
        &self,
        frame: &Frame,
        options: &RodSkinOptions,
    ) -> Result<RodSkin, FilmError> {
        let state = FractureState::from_frame(&self.wood(), frame, &self.causes)?;
        Ok(self.with_materials(|wood, materials| rod_skin(wood, &state, materials, options))?)
    }

    /// What is made of its wood with the materials that it has here.
    pub(super) fn with_materials<T, E>(
        &self,
        make: impl FnOnce(&Wood, &Materials) -> Result<T, E>,
    ) -> Result<T, E> {
        let proportions = BreakParameters::default().proportions();
        let board = self.grown.stem.kind == StemKind::Board;
        let materials = Materials {
            bark: u32::from(!board) * BARK_MATERIAL,
            bark_mesh_offset: OWN_MATERIALS,
            inner: INNER_MATERIAL,
            square: self.square,
            zone: &|rho| proportions.zone_at(rho, 0.0).code(),
        };
        make(&self.wood(), &materials)
    }

    /// A picture of a frame with its skin, whose wood inside has the material `inner`.
    ///
    /// # Errors
    /// As [`greenstick_picture::render`].
    pub fn picture(
        &self,
        scene: &Scene,
        inner: u32,
        options: &PictureOptions,
        context: &Context,
    ) -> Result<Picture, PictureError> {
        crate::picture_of_skin(
            scene,
            &self.grown.stem,
            &self.appearance,
            inner,
            options,
            context,
        )
    }
}
