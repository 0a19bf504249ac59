//! The chain of one break: stem → layout → heights → cut. Each value is computed from the one before and cached until
//! something that it depends on changes.

use super::progress::{CUT, HEIGHTS, LAYOUT, STEM};
use crate::Error;
use crate::request::{Break, BreakStage};
use greenstick_fracture::cut::CutWorkspace;
use greenstick_fracture::heights::{HeightCache, HeightSource};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::{Context, Scene};
use greenstick_skin::broken::{FaceLayout, LayoutKey};
use greenstick_skin::cracks::{OpenedEnd, open_end};
use greenstick_skin::materials::next_material;
use greenstick_skin::prepared::PreparedStem;
use greenstick_skin::stages::{
    BreakStages, CrackRequest, Cracks, CutStage, HeightStage, Neighbours, SpeciesRelief,
    SpiralGrain, StemStage, WholeStem, has_spiral_grain,
};
use greenstick_skin::stages::{Ids, Scratch, Slot, SlotValue};
use greenstick_wood::anatomy::BreakRingParameters;
use greenstick_wood::rings::StemRings;
use greenstick_wood::stem::{StemLocation, StemOptions};
use greenstick_wood::tissue::Proportions;

/// Everything that determines which stem is found.
#[derive(Debug, Clone, PartialEq)]
struct FoundKey {
    scene: u64,
    place: StemLocation,
    options: StemOptions,
    neighbours: Neighbours,
}

/// Everything that determines the annual rings.
#[derive(Debug, Clone, PartialEq)]
struct RingKey {
    stem: u64,
    parameters: BreakRingParameters,
    proportions: Proportions,
    seed: u64,
    species: Option<String>,
}

/// Everything that determines a cracked end: the stem, the cracks, and what the wood in it shows.
#[derive(Debug, Clone, PartialEq)]
struct OpenedKey {
    stem: u64,
    cracks: CrackRequest,
    proportions: Proportions,
    material: u32,
}

/// Everything that determines heights.
#[derive(Debug, Clone, PartialEq)]
struct HeightKey {
    layout: u64,
    parameters: BreakParameters,
    source: HeightSource,
    species: Option<String>,
    moisture: Option<f64>,
}

/// Everything that determines a cut.
#[derive(Debug, Clone, PartialEq)]
struct CutKey {
    heights: u64,
    cracks: Option<CrackRequest>,
    material: u32,
}

/// The last value of each stage of a break.
#[derive(Debug, Clone, Default)]
pub(super) struct Chain {
    found: Slot<FoundKey, PreparedStem>,
    rings: Slot<RingKey, StemRings>,
    /// Layout and heights on the stem as it was found, if the break needs another stem: spiral grain ends a little beyond
    /// the break, and the relief of a species is measured on the sound stem.
    found_layout: Slot<(u64, LayoutKey), FaceLayout>,
    found_cache: HeightCache,
    spiral: Slot<(u64, SpiralGrain), PreparedStem>,
    opened: Slot<OpenedKey, OpenedEnd>,
    layout: Slot<(u64, LayoutKey), FaceLayout>,
    heights: Slot<HeightKey, HeightStage>,
    cache: HeightCache,
    cut: Slot<CutKey, CutStage>,
    workspace: Scratch<CutWorkspace>,
}

/// The scene that a break is made in.
pub(super) struct ChainInput<'a> {
    pub scene: &'a Scene,
    /// Unique number of the scene in the session.
    pub id: u64,
    /// What is known of the stem.
    pub stem: &'a StemOptions,
    /// Its annual rings.
    pub rings: &'a BreakRingParameters,
    /// What the break must know of the others.
    pub neighbours: Neighbours,
    /// The number of breaks made before, each of which adds a material for its wood inside.
    pub inner_wood_before: u32,
    /// The stem before any break, if there are others, and the break's index in the request.
    pub whole: Option<WholeStem>,
    pub number: usize,
}

/// The stem of a break.
pub(super) struct ChainStem {
    pub stage: StemStage,
    /// Its unique number in the session.
    pub id: u64,
    /// The effect of the species on the relief.
    relief: SpeciesRelief,
}

/// The stages of a break up to the cut.
pub(super) struct ChainCut {
    pub stages: BreakStages,
    /// The unique number of the cut in the session.
    pub id: u64,
}

/// The earliest stage that was recomputed.
#[derive(Debug, Default)]
pub(super) struct Changes(Option<BreakStage>);

impl Changes {
    pub fn note(&mut self, stage: BreakStage, is_new: bool) {
        if is_new {
            self.0 = Some(self.0.map_or(stage, |known| known.min(stage)));
        }
    }

    pub fn first(&self) -> Option<BreakStage> {
        self.0
    }
}

impl Chain {
    /// Updates all stages up to the cut for a requested break.
    pub fn update(
        &mut self,
        input: &ChainInput,
        requested: &Break,
        ids: &mut Ids,
        changes: &mut Changes,
        context: &Context,
    ) -> Result<ChainCut, Error> {
        let [stem_context, layout_context, height_context, cut_context] =
            context.split([(STEM, 4.0), (LAYOUT, 1.0), (HEIGHTS, 1.0), (CUT, 6.0)]);
        let recipe = &requested.recipe;
        let cracks = Cracks::plan(recipe)?;
        let found = self.stem(
            input,
            requested,
            cracks.as_ref(),
            ids,
            changes,
            &stem_context,
        )?;
        let stem = found.stage;
        let p = &stem.face;
        layout_context.report(0.0)?;
        let key = LayoutKey::new(stem.stem(), p, &stem.rings);
        let layout = layout(&mut self.layout, stem.stem(), (found.id, key), ids)?;
        changes.note(BreakStage::Layout, layout.is_new);
        height_context.report(0.0)?;
        let heights = self.heights(&stem, &layout, requested, found.relief, ids)?;
        changes.note(BreakStage::Heights, heights.is_new);
        cut_context.report(0.0)?;
        let at_break = cracks.as_ref().filter(|c| !c.sawn);
        let key = CutKey {
            heights: heights.id,
            cracks: at_break.map(|_| CrackRequest::new(recipe)),
            material: stem.inner_material,
        };
        let means = (&mut self.workspace.0, &cut_context);
        let cut = self.cut.get(key, ids, |_| {
            let surface = &heights.value.heights.surface;
            CutStage::new((&stem, &layout.value, p), surface, at_break, means)
        })?;
        changes.note(BreakStage::Cut, cut.is_new);
        cut_context.report(1.0)?;
        let stages = BreakStages {
            stem,
            layout: layout.value,
            heights: heights.value,
            cracks,
            cut: cut.value,
        };
        Ok(ChainCut { stages, id: cut.id })
    }

    /// Updates the stem alone for a requested break.
    pub fn stem_only(
        &mut self,
        input: &ChainInput,
        requested: &Break,
        ids: &mut Ids,
        changes: &mut Changes,
        context: &Context,
    ) -> Result<ChainStem, Error> {
        let cracks = Cracks::plan(&requested.recipe)?;
        self.stem(input, requested, cracks.as_ref(), ids, changes, context)
    }

    /// Returns the range of heights from the 5th to the 95th percentile over the corners of a face, without the factor of a
    /// species, m.
    pub fn relief_range(&mut self, found: &ChainStem, ids: &mut Ids) -> Result<f64, Error> {
        let (stem, p) = (found.stage.stem(), &found.stage.face);
        let key = (found.id, LayoutKey::new(stem, p, &found.stage.rings));
        let layout = layout(&mut self.layout, stem, key, ids)?;
        Ok((layout.value).relief_range((stem, 1.0), p, &mut self.cache))
    }

    /// Returns the stem with the grain and the cracked end that a break requests, and the relief of the species.
    fn stem(
        &mut self,
        input: &ChainInput,
        requested: &Break,
        cracks: Option<&Cracks>,
        ids: &mut Ids,
        changes: &mut Changes,
        context: &Context,
    ) -> Result<ChainStem, Error> {
        context.report(0.0)?;
        let key = FoundKey {
            scene: input.id,
            place: requested.place,
            options: input.stem.clone(),
            neighbours: input.neighbours,
        };
        let found = self.found.get(key, ids, |_| {
            let scene = input.scene.clone();
            let (place, others) = (&requested.place, &input.neighbours);
            PreparedStem::find_between(scene, place, input.stem, others, context)
        })?;
        changes.note(BreakStage::Stem, found.is_new);
        let rings = self.rings(&found, input.rings, &requested.recipe, ids, context)?;
        let at = &found.value.found;
        let whole = input.whole.unwrap_or_else(|| WholeStem::new(at));
        let face = whole.face(&requested.recipe.face, input.number, at.stem.radius);
        let p = &face;
        let spiral = has_spiral_grain(&found.value, p);
        let sawn = cracks.filter(|c| c.sawn);
        let another = spiral || sawn.is_some();
        let relief = self.relief((&found, &rings, p), requested, another, ids)?;
        let sound = if spiral {
            let with = (requested, relief.factor, context);
            let spiral = self.spiral((&found, &rings, p), with, ids)?;
            changes.note(BreakStage::Stem, spiral.is_new);
            spiral
        } else {
            self.spiral.clear();
            found
        };
        let inner_material = next_material(&sound.value.scene) + input.inner_wood_before;
        let mut stage = StemStage {
            sound: sound.value,
            rings,
            opened: None,
            inner_material,
            whole,
            face,
        };
        let mut id = sound.id;
        match sawn {
            None => self.opened.clear(),
            Some(cracks) => {
                let key = OpenedKey {
                    stem: sound.id,
                    cracks: CrackRequest::new(&requested.recipe),
                    proportions: stage.face.proportions(),
                    material: inner_material,
                };
                let opened = self.opened.get(key, ids, |_| {
                    let silent = context.silenced();
                    let p = &requested.recipe.face;
                    open_end(&stage.sound, p, cracks.at_end(), inner_material, &silent)
                })?;
                changes.note(BreakStage::Stem, opened.is_new);
                (stage.opened, id) = (Some(opened.value), opened.id);
            }
        }
        Ok(ChainStem { stage, id, relief })
    }

    /// Returns the annual rings of the stem as it was found.
    fn rings(
        &mut self,
        found: &SlotValue<PreparedStem>,
        parameters: &BreakRingParameters,
        recipe: &Recipe,
        ids: &mut Ids,
        context: &Context,
    ) -> Result<StemRings, Error> {
        let (seed, proportions) = (recipe.face.seed, recipe.face.proportions());
        let key = RingKey {
            stem: found.id,
            parameters: parameters.clone(),
            proportions,
            seed,
            species: recipe.species.clone(),
        };
        let rings = self.rings.get(key, ids, |_| {
            let wood = found.value.wood_appearance(recipe)?;
            let stem = &found.value.found;
            let mesh = || found.value.scene.world_meshes().swap_remove(stem.node);
            let silent = context.silenced();
            Ok::<_, Error>(parameters.rings(stem, mesh, (&wood, proportions), &silent)?)
        })?;
        Ok((*rings.value).clone())
    }

    /// Returns the layout on the stem as it was found: that of the break itself, unless the break needs `another` stem.
    fn found_layout(
        &mut self,
        (found, rings): (&SlotValue<PreparedStem>, &StemRings),
        p: &BreakParameters,
        another: bool,
        ids: &mut Ids,
    ) -> Result<SlotValue<FaceLayout>, Error> {
        let key = (found.id, LayoutKey::new(&found.value, p, rings));
        let slot = if another {
            &mut self.found_layout
        } else {
            &mut self.layout
        };
        layout(slot, &found.value, key, ids)
    }

    /// Returns the stem with grain that spirals around the break and a little beyond.
    fn spiral(
        &mut self,
        (found, rings, p): (&SlotValue<PreparedStem>, &StemRings, &BreakParameters),
        (requested, relief, context): (&Break, f64, &Context),
        ids: &mut Ids,
    ) -> Result<SlotValue<PreparedStem>, Error> {
        let layout = self.found_layout((found, rings), p, true, ids)?;
        let (stem, cache) = ((&*found.value, relief), &mut self.found_cache);
        let heights = (layout.value).heights(stem, p, &requested.heights.source()?, cache);
        let grain = SpiralGrain::around(&found.value, p, heights.range);
        let (turn, between, per_level) = (grain.turn, grain.between, grain.per_level);
        self.spiral.get((found.id, grain), ids, |_| {
            Ok((found.value).with_spiral_grain(turn, between, per_level, context)?)
        })
    }

    /// Returns the factor of the species on the relief, measured on the stem as it was found; `another` says whether the
    /// break needs another stem.
    fn relief(
        &mut self,
        (found, rings, p): (&SlotValue<PreparedStem>, &StemRings, &BreakParameters),
        requested: &Break,
        another: bool,
        ids: &mut Ids,
    ) -> Result<SpeciesRelief, Error> {
        let recipe = &requested.recipe;
        if requested.heights.source()?.decides_relief() {
            recipe.species()?;
            return Ok(SpeciesRelief::decided_by_heights());
        }
        SpeciesRelief::from_recipe(recipe, found.value.found.stem.radius, |factor| {
            let layout = self.found_layout((found, rings), p, another, ids)?;
            let cache = if another {
                &mut self.found_cache
            } else {
                &mut self.cache
            };
            Ok((layout.value).relief_range((&found.value, factor), p, cache))
        })
    }

    fn heights(
        &mut self,
        stem: &StemStage,
        layout: &SlotValue<FaceLayout>,
        requested: &Break,
        relief: SpeciesRelief,
        ids: &mut Ids,
    ) -> Result<SlotValue<HeightStage>, Error> {
        let p = &stem.face;
        let source = requested.heights.source()?;
        let key = HeightKey {
            layout: layout.id,
            parameters: p.clone(),
            source: source.clone(),
            species: requested.recipe.species.clone(),
            moisture: requested.recipe.moisture,
        };
        let cache = &mut self.cache;
        self.heights.get(key, ids, |_| {
            let stem = (stem.stem(), relief.factor);
            Ok(HeightStage {
                heights: layout.value.heights(stem, p, &source, cache),
                relief,
            })
        })
    }
}

fn layout(
    slot: &mut Slot<(u64, LayoutKey), FaceLayout>,
    stem: &PreparedStem,
    key: (u64, LayoutKey),
    ids: &mut Ids,
) -> Result<SlotValue<FaceLayout>, Error> {
    let made = key.1.clone();
    slot.get(key, ids, |_| Ok(FaceLayout::new(stem, &made)))
}
