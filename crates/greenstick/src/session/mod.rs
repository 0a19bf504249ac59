//! Breaking a scene, again and again, with requests that change.
//!
//! A break is a chain of stages: input → stem → layout → heights → cut → finish. A [`BreakSession`] keeps the last value
//! of each, and a request makes anew only what follows the first stage that it changes. The chain has three ends: what is
//! drawn ([`BreakSession::stages`]), meshes ([`BreakSession::pieces`]) and the scene that files hold
//! ([`BreakSession::broken`]).

mod chain;
mod notes;
mod order;
mod pieces;
mod report;
mod scene;
mod slot;
mod stages;

pub use notes::BreakNote;
pub use pieces::{Piece, PieceRole, Pieces};
pub use scene::NodeRole;
pub use stages::{BreakStages, Cracks, CutStage, HeightStage, SpeciesRelief, StemStage};

use crate::Error;
use crate::report::BreakReport;
use crate::request::{Break, BreakRequest, BreakStage};
use chain::{Chain, ChainInput, Changes, LowestAbove};
use glam::DVec3;
use greenstick_geometry::{Context, Scene, Stage};
use greenstick_skin::cracks::EndOfStem;
use greenstick_skin::materials;
use greenstick_skin::prepared::volume_scale;
use greenstick_skin::texture::{SectionSquare, WoodTextures};
use greenstick_wood::appearance::StemAppearance;
use greenstick_wood::stem::Stem;
use order::BreakOrder;
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
    appearance: StemAppearance,
    width: u32,
}

/// The values of one break of a request.
#[derive(Debug, Clone, Default)]
struct OneBreak {
    chain: Chain,
    pieces: Slot<(u64, Break), Pieces>,
    textures: Slot<TextureKey, WoodTextures>,
    /// What is left of the scene to be broken further down.
    rest: Slot<u64, Scene>,
}

/// A scene that is broken again and again. Sessions share nothing that changes, so each thread can have its own:
/// [`BreakSession::fork`].
#[derive(Debug)]
pub struct BreakSession {
    input: Arc<Input>,
    ids: Ids,
    order: BreakOrder,
    /// In the order in which they are made.
    breaks: Vec<OneBreak>,
    changes: Changes,
}

/// One break of a request, with its pieces.
#[derive(Debug, Clone)]
pub struct PiecesOfBreak {
    /// Its number in the request.
    pub number: usize,
    /// The break as it was made.
    pub made: Break,
    /// Its stages up to the cut.
    pub stages: BreakStages,
    /// Its pieces.
    pub pieces: Arc<Pieces>,
}

/// The wood inside a break.
#[derive(Debug, Clone)]
pub struct BrokenWood {
    /// Its material.
    pub material: u32,
    /// The stem that was broken, placed at the break.
    pub stem: Stem,
    /// The appearance of its wood and bark.
    pub appearance: StemAppearance,
    /// Side of the square that holds the section, m.
    pub width: f64,
}

/// Broken pieces.
#[derive(Debug, Clone)]
pub struct Broken {
    /// The pieces first: `lower`, `upper` and splinters, or, of several breaks, `piece_0` and so on from the base and
    /// splinters. Then what moves with them, then what was not touched.
    pub scene: Scene,
    /// What each node of the scene is.
    pub roles: Vec<NodeRole>,
    /// What was done.
    pub report: BreakReport,
    /// The notes of the report by their kinds.
    pub notes: Vec<BreakNote>,
    /// The wood inside each break, in the order of the request.
    pub woods: Vec<BrokenWood>,
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
            order: BreakOrder::default(),
            breaks: Vec::new(),
            changes: Changes::default(),
        }
    }

    /// A session of its own with all that this one has found out, for another thread.
    pub fn fork(&self) -> Self {
        BreakSession {
            input: self.input.clone(),
            ids: self.ids.clone(),
            order: self.order.clone(),
            breaks: self.breaks.clone(),
            changes: Changes::default(),
        }
    }

    /// The first stage that the last request made anew; none where it found everything.
    pub fn started_at(&self) -> Option<BreakStage> {
        self.changes.first()
    }

    /// The stem of the request's only break.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn stem(&mut self, request: &BreakRequest, context: &Context) -> Result<StemStage, Error> {
        let asked = only(request)?;
        self.begin(request);
        let input = self.input.clone();
        let input = ChainInput::whole(&input.scene, &request.stem);
        let chain = &mut self.breaks[0].chain;
        chain.stem_only(&input, asked, &mut self.ids, &mut self.changes, context)
    }

    /// Height between the 5th and the 95th hundredth of the corners of the request's only face, before it is limited and
    /// without what a species adds to its relief, m.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn relief_range(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<f64, Error> {
        let stem = self.stem(request, context)?;
        let face = &only(request)?.recipe.face;
        self.breaks[0]
            .chain
            .relief_range(&stem, face, &mut self.ids)
    }

    /// The stages of the request's only break up to the cut, which is what is drawn.
    ///
    /// # Errors
    /// [`Error`] where there is no stem at the place, it cannot be cut there, or the caller cancelled.
    pub fn stages(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<BreakStages, Error> {
        let asked = only(request)?;
        self.begin(request);
        let input = self.input.clone();
        let input = ChainInput::whole(&input.scene, &request.stem);
        let chain = &mut self.breaks[0].chain;
        chain.update(&input, asked, &mut self.ids, &mut self.changes, context)
    }

    fn begin(&mut self, request: &BreakRequest) {
        self.changes = Changes::default();
        self.breaks
            .resize_with(request.breaks.len(), OneBreak::default);
    }

    /// The pieces of the request's breaks as meshes of their own, from the farthest break from the base to the nearest.
    /// Each breaks what the one before left at the base.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn pieces(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<Vec<PiecesOfBreak>, Error> {
        self.begin(request);
        let input = self.input.clone();
        let [locating, breaking] = context.split([
            (STEM, request.breaks.len() as f64 - 1.0),
            (CUT, 4.0 * request.breaks.len() as f64),
        ]);
        let order = self.order.of(&input.scene, request, &locating)?;
        let mut made: Vec<PiecesOfBreak> = Vec::new();
        let mut rest: Option<(Arc<Scene>, u64)> = None;
        for (at, placed) in order.iter().enumerate() {
            let [cutting, finishing] = breaking
                .item(at, order.len())
                .split([(CUT, 3.0), (FINISH, 2.0)]);
            let one = &mut self.breaks[at];
            let (scene, id) = match &rest {
                Some((scene, id)) => (&**scene, *id),
                None => (&input.scene, 0),
            };
            let above = made.last().map(|m| LowestAbove::new(&m.stages));
            let input = ChainInput {
                scene,
                id,
                stem: &request.stem,
                above,
                inner_wood_before: at as u32,
            };
            let (ids, changes) = (&mut self.ids, &mut self.changes);
            let stages = (one.chain).update(&input, &placed.asked, ids, changes, &cutting)?;
            finishing.report(0.0)?;
            let key = (stages.cut_id, placed.asked.clone());
            let pieces = one
                .pieces
                .get(key, ids, |_| pieces::finish(&stages, &placed.asked))?;
            changes.note(BreakStage::Finish, pieces.is_new);
            if at + 1 < order.len() {
                let found = one.rest.get(pieces.id, ids, |_| {
                    Ok::<_, Error>(scene::left_at_base(&stages, &pieces.value))
                })?;
                rest = Some((found.value, found.id));
            }
            made.push(PiecesOfBreak {
                number: placed.number,
                made: placed.asked.clone(),
                stages,
                pieces: pieces.value,
            });
        }
        Ok(made)
    }

    /// The broken scene with its materials and textures, as files hold it.
    ///
    /// # Errors
    /// As [`BreakSession::stages`], or where the textures cannot be made.
    pub fn broken(&mut self, request: &BreakRequest, context: &Context) -> Result<Broken, Error> {
        let [breaking, baking] = context.split([(CUT, 1.0), (TEXTURES, 2.0)]);
        let made = self.pieces(request, &breaking)?;
        let Assembled { mut scene, roles } = assemble(&made);
        materials::add_missing_bark(&mut scene);
        let mut woods = Vec::new();
        for (at, one) in made.iter().enumerate() {
            let width = request.texture_width;
            let wood = self.bake(at, one, width, &baking.item(at, made.len()))?;
            let square = one.stages.stem.stem().square;
            materials::add_inner_wood(&mut scene, square, &wood.1);
            woods.push((one.number, wood.0));
        }
        woods.sort_by_key(|w| w.0);
        let first = made.iter().min_by_key(|m| m.number);
        let pieces = first.map(|m| &m.pieces);
        let hang = pieces.and_then(|p| p.hang.as_ref());
        Ok(Broken {
            roles,
            report: report::report(&self.input, &made, &scene),
            scene,
            notes: report::notes(&made).into_iter().cloned().collect(),
            woods: woods.into_iter().map(|w| w.1).collect(),
            apart: (request.breaks.iter()).any(|b| b.separation != 0.0 || b.recipe.face.hang > 0.0),
            hinge: hang.map(|h| DVec3::from_array(h.axis)),
            end: pieces.and_then(|p| p.end),
        })
    }

    /// Bakes the textures of a break.
    fn bake(
        &mut self,
        at: usize,
        one: &PiecesOfBreak,
        width: u32,
        context: &Context,
    ) -> Result<(BrokenWood, Arc<WoodTextures>), Error> {
        context.report(0.0)?;
        let recipe = &one.made.recipe;
        let prepared = one.stages.stem.stem();
        let (stem, square) = (&prepared.found.stem, prepared.square);
        let face = &recipe.face;
        let (tissues, bark) = (face.proportions(), prepared.extent.bark);
        let appearance = StemAppearance::new(stem, &tissues, face.seed, recipe.species()?, bark);
        let key = TextureKey {
            stem: stem.clone(),
            square,
            appearance: appearance.clone(),
            width,
        };
        let slot = &mut self.breaks[at].textures;
        let baked = slot.get(key, &mut self.ids, |_| {
            materials::bake(stem, square, &appearance.wood, width, context)
        })?;
        self.changes.note(BreakStage::Finish, baked.is_new);
        let wood = BrokenWood {
            material: one.stages.stem.inner_material,
            stem: stem.clone(),
            appearance,
            width: square.side,
        };
        Ok((wood, baked.value))
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
