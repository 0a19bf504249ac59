//! Breaking a scene, again and again, with requests that change.
//!
//! A break is a chain of stages: input → stem → layout → heights → cut → finish. A [`BreakSession`] keeps the last value
//! of each, and a request makes anew only what follows the first stage that it changes. The chain has three ends: what is
//! drawn ([`BreakSession::stages`]), meshes ([`BreakSession::pieces`]) and the scene that files hold
//! ([`BreakSession::broken`]).

pub(crate) mod appearance;
mod chain;
pub(crate) mod materials;
mod notes;
mod pieces;
mod scene;
mod slot;

pub use appearance::Looks;
pub use chain::{BreakStages, Cracks, CutStage, HeightStage, SpeciesRelief, StemStage};
pub use notes::BreakNote;
pub use pieces::{Piece, PieceRole, Pieces};
pub use scene::NodeRole;

use crate::Error;
use crate::report::{BreakReport, FaceReport, InputReport, PlaceReport, closed_volume};
use crate::request::{Break, BreakRequest, BreakStage};
use appearance::looks;
use chain::{Chain, ChainInput, Changes};
use glam::DVec3;
use greenstick_fracture::parameters::Surface;
use greenstick_geometry::{Context, Scene, Stage};
use greenstick_skin::cracks::EndOfStem;
use greenstick_skin::prepared::{PreparedStem, volume_scale};
use greenstick_skin::texture::{SectionSquare, WoodTextures};
use greenstick_wood::stem::{Stem, StemKind};
use scene::{Assembled, assemble};
use slot::{Ids, Slot};
use std::sync::Arc;

const STEM: Stage = Stage::new("stem");
const LAYOUT: Stage = Stage::new("layout");
const HEIGHTS: Stage = Stage::new("heights");
const CUT: Stage = Stage::new("cut");
const FINISH: Stage = Stage::new("finish");
const TEXTURES: Stage = Stage::new("textures");

/// The scene that is broken.
#[derive(Debug)]
struct Input {
    scene: Scene,
    triangles: usize,
    area_m2: f64,
}

/// What the textures of the wood inside are made from beside the stem.
#[derive(Debug, Clone, PartialEq)]
struct TextureKey {
    stem: Stem,
    square: SectionSquare,
    looks: Looks,
    width: u32,
}

/// A scene that is broken again and again. Sessions share nothing that changes, so each thread can have its own:
/// [`BreakSession::fork`].
#[derive(Debug)]
pub struct BreakSession {
    input: Arc<Input>,
    ids: Ids,
    chain: Chain,
    pieces: Slot<(u64, Break), Pieces>,
    textures: Slot<TextureKey, WoodTextures>,
    changes: Changes,
}

/// Broken pieces.
#[derive(Debug, Clone)]
pub struct Broken {
    /// The pieces `lower`, `upper` and so on, then what was not touched.
    pub scene: Scene,
    /// What each node of the scene is.
    pub roles: Vec<NodeRole>,
    /// What was done.
    pub report: BreakReport,
    /// The notes of the report by their kinds.
    pub notes: Vec<BreakNote>,
    /// The stem that was broken.
    pub stem: Stem,
    /// What its wood and bark look like.
    pub looks: Looks,
    /// Material of the wood inside.
    pub inner_material: u32,
    /// Side of the square that holds the section, m.
    pub width: f64,
    /// Whether the pieces were moved apart, or one hangs on the other.
    pub apart: bool,
    /// Direction of the hinge that the upper piece hangs on, where it does.
    pub hinge: Option<DVec3>,
    /// The sawn end that was cracked.
    pub end: Option<EndOfStem>,
}

impl Broken {
    /// Adds a note that only the caller knows.
    pub fn note(&mut self, text: String) {
        self.report.notes.push(text.clone());
        self.notes.push(BreakNote::Other(text));
    }
}

impl BreakSession {
    /// A session that breaks `scene`.
    pub fn new(scene: Scene) -> Self {
        let triangles = scene.nodes.iter().map(|n| n.mesh.triangles.len()).sum();
        let area_m2 = scene
            .nodes
            .iter()
            .map(|n| n.mesh.area() * volume_scale(n).cbrt().powi(2))
            .sum();
        BreakSession {
            input: Arc::new(Input {
                scene,
                triangles,
                area_m2,
            }),
            ids: Ids::default(),
            chain: Chain::default(),
            pieces: Slot::default(),
            textures: Slot::default(),
            changes: Changes::default(),
        }
    }

    /// A session of its own with all that this one has found out, for another thread.
    pub fn fork(&self) -> Self {
        BreakSession {
            input: self.input.clone(),
            ids: self.ids.clone(),
            chain: self.chain.clone(),
            pieces: self.pieces.clone(),
            textures: self.textures.clone(),
            changes: Changes::default(),
        }
    }

    /// The first stage that the last request made anew; none where it found everything.
    pub fn started_at(&self) -> Option<BreakStage> {
        self.changes.first()
    }

    /// The stem of the request's break.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn stem(&mut self, request: &BreakRequest, context: &Context) -> Result<StemStage, Error> {
        self.changes = Changes::default();
        let input = self.input.clone();
        let input = ChainInput {
            scene: &input.scene,
            id: 0,
            stem: &request.stem,
        };
        let asked = only(request)?;
        self.chain
            .stem_only(&input, asked, &mut self.ids, &mut self.changes, context)
    }

    /// Height between the 5th and the 95th hundredth of the corners of the request's face, before it is limited and without
    /// what a species adds to its relief, m.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn relief_range(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<f64, Error> {
        let stem = self.stem(request, context)?;
        self.chain
            .relief_range(&stem, &only(request)?.recipe.face, &mut self.ids)
    }

    /// The stages of the request's break up to the cut, which is what is drawn.
    ///
    /// # Errors
    /// [`Error`] where there is no stem at the place, it cannot be cut there, or the caller cancelled.
    pub fn stages(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<BreakStages, Error> {
        self.changes = Changes::default();
        let input = self.input.clone();
        let input = ChainInput {
            scene: &input.scene,
            id: 0,
            stem: &request.stem,
        };
        let asked = only(request)?;
        self.chain
            .update(&input, asked, &mut self.ids, &mut self.changes, context)
    }

    /// The pieces of the request's break as meshes of their own.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn pieces(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<(BreakStages, Arc<Pieces>), Error> {
        let [cut, finishing] = context.split([(CUT, 3.0), (FINISH, 2.0)]);
        let stages = self.stages(request, &cut)?;
        finishing.report(0.0)?;
        let asked = only(request)?;
        let key = (stages.cut_id, asked.clone());
        let pieces = self
            .pieces
            .get(key, &mut self.ids, |_| pieces::finish(&stages, asked))?;
        self.changes.note(BreakStage::Finish, pieces.is_new);
        Ok((stages, pieces.value))
    }

    /// The broken scene with its materials and textures, as files hold it.
    ///
    /// # Errors
    /// As [`BreakSession::stages`], or where the textures cannot be made.
    pub fn broken(&mut self, request: &BreakRequest, context: &Context) -> Result<Broken, Error> {
        let [breaking, baking] = context.split([(CUT, 1.0), (TEXTURES, 2.0)]);
        let (stages, pieces) = self.pieces(request, &breaking)?;
        let asked = only(request)?;
        let p = &asked.recipe.face;
        let prepared = stages.stem.stem();
        let stem = &prepared.found.stem;
        let species = asked.recipe.species()?;
        let looks = looks(stem, p, species, prepared.extent.bark);
        baking.report(0.0)?;
        let key = TextureKey {
            stem: stem.clone(),
            square: prepared.square,
            looks: looks.clone(),
            width: request.texture_width,
        };
        let baked = self.textures.get(key, &mut self.ids, |_| {
            materials::bake(
                stem,
                prepared.square,
                &looks,
                request.texture_width,
                &baking,
            )
        })?;
        self.changes.note(BreakStage::Finish, baked.is_new);
        let Assembled { mut scene, roles } = assemble(&stages, &pieces);
        materials::add_missing_bark(&mut scene);
        materials::add_inner_wood(&mut scene, prepared.square, &baked.value);
        Ok(Broken {
            scene,
            roles,
            report: self.report(&stages, &pieces, asked),
            notes: pieces.notes.clone(),
            stem: stem.clone(),
            looks,
            inner_material: stages.stem.inner_material,
            width: prepared.square.side,
            apart: asked.separation != 0.0 || p.hang > 0.0,
            hinge: pieces.hang.as_ref().map(|h| DVec3::from_array(h.axis)),
            end: pieces.end,
        })
    }

    fn report(&self, stages: &BreakStages, pieces: &Pieces, asked: &Break) -> BreakReport {
        let heights = &stages.heights.heights;
        let p = &asked.recipe.face;
        BreakReport {
            scan: None,
            input: self.input_report(&stages.stem.sound),
            place: place_report(stages.stem.stem()),
            face: FaceReport {
                surface: match p.surface {
                    Surface::Smooth => "smooth".into(),
                    Surface::Fibrous => "fibrous".into(),
                },
                bundles: stages.layout.bundles.bundles.len(),
                thorns: heights.thorns.len(),
                range_m: [heights.range.0, heights.range.1],
                limited: heights.limited,
                wanted_m: [heights.wanted.0, heights.wanted.1],
            },
            species: stages.heights.relief.report.clone(),
            pieces: pieces.reports.clone(),
            hang: pieces.hang.clone(),
            crack_volume_m3: pieces.crack_volume_m3,
            notes: pieces.notes.iter().map(ToString::to_string).collect(),
        }
    }

    fn input_report(&self, stem: &PreparedStem) -> InputReport {
        let found = &stem.found;
        let mut repairs = self.input.scene.notes.clone();
        repairs.extend(found.notes.iter().cloned());
        if stem.split > 0 {
            repairs.push(format!(
                "{} triangles near the break were parted because the stem is bent there",
                stem.split
            ));
        }
        let shell = found.shell.iter().map(|&t| t as usize);
        let (closed, volume) = closed_volume(&stem.node().mesh.submesh(shell));
        InputReport {
            meshes: stem.scene.nodes.len(),
            triangles: self.input.triangles,
            area_m2: self.input.area_m2,
            volume_m3: volume.map(|v| v * stem.volume_scale()),
            closed,
            repairs,
        }
    }
}

/// The only break of a request.
fn only(request: &BreakRequest) -> Result<&Break, Error> {
    match &request.breaks[..] {
        [only] => Ok(only),
        others => Err(Error::Amount(format!(
            "{} breaks; expected 1",
            others.len()
        ))),
    }
}

fn place_report(prepared: &PreparedStem) -> PlaceReport {
    let stem = &prepared.found.stem;
    PlaceReport {
        mesh: prepared.node().name.clone(),
        kind: match stem.kind {
            StemKind::Round => "round".into(),
            StemKind::Board => "board".into(),
        },
        stem_length_m: stem.length,
        length_m: stem.location,
        point_m: stem.grain.axis().frame(stem.location).origin.to_array(),
        radius_m: stem.radius,
        pith_m: stem.rings.pith().to_array(),
        free_m: [stem.usable.0, stem.usable.1],
    }
}

/// Breaks a stem in a scene once.
///
/// # Errors
/// As [`BreakSession::broken`].
pub fn break_scene(
    scene: Scene,
    request: &BreakRequest,
    context: &Context,
) -> Result<Broken, Error> {
    BreakSession::new(scene).broken(request, context)
}
