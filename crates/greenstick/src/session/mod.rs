//! Breaking one scene repeatedly, with requests that change.
//!
//! A break is a chain of stages: input → stem → layout → heights → cut → finish. A [`BreakSession`] caches the last value
//! of each stage, and a request recomputes only the first stage that it changes and those after it. The chain has three
//! ends: what is drawn ([`BreakSession::stages`]), meshes ([`BreakSession::pieces`]) and the scene that files hold
//! ([`BreakSession::broken`]).

mod chain;
mod order;
mod progress;

pub use crate::Error;
use crate::request::{Break, BreakRequest, BreakStage};
use chain::{Chain, ChainCut, ChainInput, ChainStem, Changes};
use glam::DVec3;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::{Context, ErrorKind, Scene};
use greenstick_skin::cracks::EndOfStem;
use greenstick_skin::finish::{
    AssembledBreaks, BreakInput, FinishOptions, FinishedBreak, Separation, added_triangles,
    assemble, break_notes, break_report, finish, left_at_base, within_budget,
};
pub use greenstick_skin::finish::{BrokenWood, NodeRole, Piece, PieceRole, Pieces};
use greenstick_skin::materials::{self, BakedWood, TextureKey};
pub use greenstick_skin::report::BreakNote;
use greenstick_skin::report::BreakReport;
use greenstick_skin::stages::PlacesError;
pub use greenstick_skin::stages::{
    BreakStages, Cracks, CutStage, HeightStage, SpeciesRelief, StemStage,
};
use greenstick_skin::stages::{Ids, Neighbours, Slot};
use order::BreakOrder;
use progress::{CUT, FINISH, STEM, TEXTURES};
use std::sync::Arc;

/// The cached values of one break of a request.
#[derive(Debug, Clone, Default)]
struct CachedBreak {
    chain: Chain,
    pieces: Slot<(u64, Break), Pieces>,
    textures: Slot<TextureKey, BakedWood>,
    /// What is left of the scene at the base, where breaks nearer to it are made.
    remaining: Slot<u64, Scene>,
}

/// A scene that is broken repeatedly. Sessions share no mutable state, so that every thread can have its own; see
/// [`BreakSession::fork`].
///
/// ```
/// use greenstick::geometry::Context;
/// use greenstick::{BreakRequest, BreakSession, BreakStage, built_in_branch};
///
/// let mut session = BreakSession::new(built_in_branch());
/// let mut request = BreakRequest::default();
/// session.stages(&request, &Context::quiet())?;
/// request.breaks[0].recipe.face.inclination = 10.0;
/// session.stages(&request, &Context::quiet())?;
/// assert_eq!(session.started_at(), Some(BreakStage::Heights));
/// # Ok::<(), greenstick::Error>(())
/// ```
#[derive(Debug)]
pub struct BreakSession {
    input: Arc<BreakInput>,
    ids: Ids,
    order: BreakOrder,
    /// In the order in which they are made.
    breaks: Vec<CachedBreak>,
    /// What is said of places of the last request that were left out.
    left_out: Vec<BreakNote>,
    changes: Changes,
}

/// One break of a request, with its stages and pieces.
#[derive(Debug, Clone)]
pub struct BreakPieces {
    /// Its index in the request.
    pub number: usize,
    /// The break that was requested; if the request has several, its location is a point.
    pub requested: Break,
    /// Its stages up to the cut.
    pub stages: BreakStages,
    /// Its pieces.
    pub pieces: Arc<Pieces>,
}

impl BreakPieces {
    fn finished(&self) -> FinishedBreak<'_> {
        FinishedBreak {
            number: self.number,
            stages: &self.stages,
            pieces: &self.pieces,
        }
    }
}

/// Broken pieces.
#[derive(Debug, Clone)]
pub struct Broken {
    /// The pieces first: `lower`, `upper` and splinters, or, of several breaks, `piece_0` and so on from the base and
    /// splinters. Then what moves with them, then what was not touched.
    pub scene: Scene,
    /// What each node of the scene is.
    pub roles: Vec<NodeRole>,
    /// The report.
    pub report: BreakReport,
    /// The notes of the report, by kind.
    pub notes: Vec<BreakNote>,
    /// The wood inside each break, in the order of the request.
    pub woods: Vec<BrokenWood>,
    /// The direction of the hinge that the upper piece hangs on, if it does.
    pub hinge: Option<DVec3>,
    /// The sawn end that has cracks, if any.
    pub end: Option<EndOfStem>,
}

impl Broken {
    /// Adds a note of the caller's own.
    pub fn note(&mut self, text: String) {
        self.report.notes.push(text.clone());
        self.notes.push(BreakNote::Other(text));
    }
}

impl BreakSession {
    /// Starts a session that breaks `scene`.
    pub fn new(scene: Scene) -> Self {
        BreakSession {
            input: Arc::new(BreakInput::new(scene)),
            ids: Ids::default(),
            order: BreakOrder::default(),
            breaks: Vec::new(),
            left_out: Vec::new(),
            changes: Changes::default(),
        }
    }

    /// Returns an independent session with everything that this one has cached, for another thread.
    pub fn fork(&self) -> Self {
        BreakSession {
            input: self.input.clone(),
            ids: self.ids.clone(),
            order: self.order.clone(),
            breaks: self.breaks.clone(),
            left_out: self.left_out.clone(),
            changes: Changes::default(),
        }
    }

    /// The first stage that the last request recomputed; none if all of it was cached.
    pub fn started_at(&self) -> Option<BreakStage> {
        self.changes.first()
    }

    /// Returns the stem of the request's only break.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn stem(&mut self, request: &BreakRequest, context: &Context) -> Result<StemStage, Error> {
        self.chain_stem(request, context).map(|found| found.stage)
    }

    fn chain_stem(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<ChainStem, Error> {
        let requested = only(request)?;
        self.changes = Changes::default();
        self.breaks.resize_with(1, CachedBreak::default);
        let input = self.input.clone();
        let input = ChainInput {
            scene: &input.scene,
            id: 0,
            stem: &request.stem,
            rings: &request.rings,
            neighbours: Neighbours::default(),
            inner_wood_before: 0,
            whole: None,
            number: 0,
        };
        let chain = &mut self.breaks[0].chain;
        chain.stem_only(&input, requested, &mut self.ids, &mut self.changes, context)
    }

    /// Returns the range of heights from the 5th to the 95th percentile over the corners of the request's only face, before
    /// heights are limited and without the factor of a species, m.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn relief_range(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<f64, Error> {
        let stem = self.chain_stem(request, context)?;
        self.breaks[0].chain.relief_range(&stem, &mut self.ids)
    }

    /// Returns the stages of the request's only break up to the cut: what is drawn.
    ///
    /// # Errors
    /// [`Error`] if there is no stem at the location, the stem cannot be cut there, or the caller cancelled.
    pub fn stages(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<BreakStages, Error> {
        only(request)?;
        self.stages_of(request, 0, context)
    }

    /// The same of the break with an index among several. Breaks farther from the base are finished, those nearer to it not begun.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn stages_of(
        &mut self,
        request: &BreakRequest,
        number: usize,
        context: &Context,
    ) -> Result<BreakStages, Error> {
        let (made, cut) = self.made(request, Some(number), context)?;
        let found = made.into_iter().find(|m| m.number == number);
        Ok((cut.or(found.map(|m| m.stages))).ok_or(PlacesError::None)?)
    }

    /// Returns the pieces of the request's breaks as separate meshes, from the break farthest from the base to the nearest.
    /// Each break is made in what the one before left at the base.
    ///
    /// # Errors
    /// As [`BreakSession::stages`].
    pub fn pieces(
        &mut self,
        request: &BreakRequest,
        context: &Context,
    ) -> Result<Vec<BreakPieces>, Error> {
        Ok(self.made(request, None, context)?.0)
    }

    /// As [`BreakSession::pieces`], as far as the break `until`, of which only the stages are made if its triangles need not be counted.
    fn made(
        &mut self,
        request: &BreakRequest,
        until: Option<usize>,
        context: &Context,
    ) -> Result<(Vec<BreakPieces>, Option<BreakStages>), Error> {
        self.changes = Changes::default();
        let input = self.input.clone();
        let asked_for = request.breaks.len() as f64;
        let [locating, breaking] = context.split([(STEM, asked_for - 1.0), (CUT, 4.0 * asked_for)]);
        let (order, left_out) = self.order.resolve(&input.scene, request, &locating)?;
        (self.breaks).resize_with(order.len(), CachedBreak::default);
        self.left_out = left_out.into_iter().collect();
        let (mut finished, mut remaining) = (Vec::<BreakPieces>::new(), None::<(Arc<Scene>, u64)>);
        let count = order.len();
        for (at, placed) in order.into_iter().enumerate() {
            let [cutting, finishing] = breaking.item(at, count).split([(CUT, 3.0), (FINISH, 2.0)]);
            let one = &mut self.breaks[at];
            let (scene, id) = (remaining.as_ref()).map_or((&input.scene, 0), |r| (&*r.0, r.1));
            let above = finished.last().map(|m| m.stages.lowest_point());
            let input = ChainInput {
                id,
                stem: &request.stem,
                rings: &request.rings,
                neighbours: placed.neighbours.beyond(above),
                inner_wood_before: finished.len() as u32,
                whole: placed.whole,
                number: placed.number,
                scene,
            };
            let (ids, changes) = (&mut self.ids, &mut self.changes);
            let most = placed.requested.triangles;
            if until == Some(placed.number) && most.is_none() {
                let cut = (one.chain).update(&input, &placed.requested, ids, changes, &cutting)?;
                return Ok((finished, Some(cut.stages)));
            }
            let asked = &placed.requested.recipe.face;
            let make = |face: &BreakParameters| {
                let mut requested = placed.requested.clone();
                requested.recipe.face.clone_from(face);
                let ChainCut { stages, id } =
                    (one.chain).update(&input, &requested, ids, changes, &cutting)?;
                finishing.report(0.0)?;
                let pieces = one.pieces.get((id, requested.clone()), ids, |_| {
                    let options = finish_options(&requested, face, asked);
                    finish(&stages, &options, &finishing)
                })?;
                Ok::<_, Error>((stages, pieces, requested))
            };
            let made = within_budget(most, asked, make, |m| added_triangles(&m.0, &m.1.value));
            let has_others = at + 1 < count || !finished.is_empty();
            let (stages, pieces, requested) = match made {
                // Where all places at a distance were asked for, one that fails does not cost the others.
                Err(error)
                    if request.every.is_some()
                        && has_others
                        && error.kind() != ErrorKind::Cancelled =>
                {
                    (self.left_out).push(BreakNote::place_failed(placed.at_m, &error));
                    continue;
                }
                made => made?,
            };
            changes.note(BreakStage::Finish, pieces.is_new);
            if at + 1 < count {
                let found = one.remaining.get(pieces.id, ids, |_| {
                    Ok::<_, Error>(left_at_base(&stages, &pieces.value))
                })?;
                remaining = Some((found.value, found.id));
            }
            finished.push(BreakPieces {
                number: placed.number,
                requested,
                stages,
                pieces: pieces.value,
            });
        }
        Ok((finished, None))
    }

    /// Returns the broken scene with its materials and textures, as files hold it.
    ///
    /// # Errors
    /// As [`BreakSession::stages`], and if the textures cannot be made.
    pub fn broken(&mut self, request: &BreakRequest, context: &Context) -> Result<Broken, Error> {
        self.assemble(request, context, |_| ())
    }

    /// As [`BreakSession::broken`]; `made` is called once pieces are made, when the textures need only the stem of what is cached.
    fn assemble(
        &mut self,
        request: &BreakRequest,
        context: &Context,
        made: impl FnOnce(&mut Self),
    ) -> Result<Broken, Error> {
        let [breaking, baking] = context.split([(CUT, 1.0), (TEXTURES, 2.0)]);
        let breaks = self.pieces(request, &breaking)?;
        let finished: Vec<FinishedBreak> = breaks.iter().map(BreakPieces::finished).collect();
        let AssembledBreaks { scene, roles } = assemble(&finished);
        let report = break_report(&self.input, &finished, &scene, &self.left_out);
        let pieces = (breaks.iter().min_by_key(|m| m.number)).map(|m| &m.pieces);
        let hang = pieces.and_then(|p| p.hang.as_ref());
        let mut broken = Broken {
            roles,
            report: report.ok_or(PlacesError::None)?,
            scene,
            notes: break_notes(&finished, &self.left_out),
            woods: Vec::new(),
            hinge: hang.map(|h| DVec3::from_array(h.axis)),
            end: pieces.and_then(|p| p.end),
        };
        let stems = breaks.into_iter();
        let stems: Vec<_> = stems
            .map(|b| (b.number, b.requested, b.stages.stem))
            .collect();
        made(self);
        let bark = materials::add_missing_bark(&mut broken.scene);
        let (mut woods, count) = (Vec::new(), stems.len());
        for (at, (number, requested, stage)) in stems.iter().enumerate() {
            let (recipe, width) = (&requested.recipe, request.texture_width);
            let (wood, baked) = self.bake(at, stage, recipe, width, &baking.item(at, count))?;
            let (prepared, appearance) = (stage.stem(), &wood.appearance);
            // The numbers of the woods inside are taken: what the outside adds comes after them.
            let bark = bark.filter(|_| at + 1 == count);
            let baked = baked.as_deref();
            materials::add_wood(&mut broken.scene, bark, prepared, baked, appearance);
            woods.push((*number, wood));
        }
        woods.sort_by_key(|w| w.0);
        broken.woods = woods.into_iter().map(|w| w.1).collect();
        Ok(broken)
    }

    /// Bakes the textures of the wood inside a break, if there are to be any.
    fn bake(
        &mut self,
        at: usize,
        stage: &StemStage,
        recipe: &Recipe,
        width: u32,
        context: &Context,
    ) -> Result<(BrokenWood, Option<Arc<BakedWood>>), Error> {
        context.report(0.0)?;
        let prepared = stage.stem();
        let appearance = stage.appearance(recipe)?;
        let baked = if width > 0 {
            let key = TextureKey::new(prepared, &appearance, width);
            let slot = &mut self.breaks[at].textures;
            let baked = slot.get(key, &mut self.ids, |_| {
                materials::bake_stem(prepared, &appearance, width, context)
            })?;
            self.changes.note(BreakStage::Finish, baked.is_new);
            Some(baked.value)
        } else {
            None
        };
        Ok((BrokenWood::new(stage, appearance), baked))
    }
}

/// How a break is finished whose face asked for more than the `face` that its budget of triangles leaves.
fn finish_options<'a>(
    requested: &Break,
    face: &'a BreakParameters,
    asked: &'a BreakParameters,
) -> FinishOptions<'a> {
    FinishOptions {
        face,
        asked,
        fray: requested.fray,
        separation: Separation::new(requested.separation, requested.part_clear),
        most_triangles: requested.triangles,
    }
}

/// Returns the only break of a request.
fn only(request: &BreakRequest) -> Result<&Break, Error> {
    match (&request.breaks[..], request.every) {
        ([only], None) => Ok(only),
        (others, None) => Err(Error::Amount(format!(
            "{} breaks; expected 1",
            others.len()
        ))),
        (_, Some(every)) => Err(Error::Amount(format!(
            "a break every {every} m; expected 1 break"
        ))),
    }
}

/// Breaks a scene once. To break it repeatedly, use a [`BreakSession`].
///
/// # Errors
/// As [`BreakSession::broken`].
pub fn break_scene(
    scene: Scene,
    request: &BreakRequest,
    context: &Context,
) -> Result<Broken, Error> {
    // Nothing is asked again: what the pieces were made from goes before the textures, which would copy pieces that are shared.
    BreakSession::new(scene).assemble(request, context, |session| {
        session.breaks.fill(CachedBreak::default());
    })
}
