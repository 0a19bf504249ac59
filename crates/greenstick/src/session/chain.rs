//! The chain of one break: stem → layout → heights → cut, each made from the one before and kept until something that it
//! depends on changes.

use super::notes::BreakNote;
use super::slot::{Found, Ids, Slot};
use crate::Error;
use crate::report::SpeciesReport;
use crate::request::{Break, BreakStage};
use greenstick_fracture::cracks::{CrackPlan, plan};
use greenstick_fracture::cut::CutWorkspace;
use greenstick_fracture::heights::{self, HeightCache, HeightSource, Heights};
use greenstick_fracture::parameters::{BreakParameters, CrackEnd, CrackParameters, Surface};
use greenstick_fracture::recipe::{CrackShrinkage, Recipe};
use greenstick_geometry::{Context, Mesh, Scene};
use greenstick_skin::broken::{
    BrokenFace, Cutter, FaceLayout, InnerWood, LayoutKey, height_setting, lacks_material,
};
use greenstick_skin::cracks::{CrackedFace, OpenedEnd, crack_faces, open_end};
use greenstick_skin::prepared::PreparedStem;
use greenstick_wood::moisture::{AIR_DRY_PERCENT, Fallback};
use greenstick_wood::species::{DEFAULT_BUNDLE_DIAMETER, HeightRule};
use greenstick_wood::stem::{StemKind, StemLocation, StemOptions};
use std::sync::Arc;

/// The stem of a break.
#[derive(Debug, Clone)]
pub struct StemStage {
    /// The stem as it was found, with the grain that the break asks for.
    pub sound: Arc<PreparedStem>,
    /// The same with cracks in its end, where the break asks for them there.
    pub opened: Option<Arc<OpenedEnd>>,
    /// Material of the wood inside.
    pub inner_material: u32,
    /// Number of the stem that is broken, which no other of the session has.
    id: u64,
}

impl StemStage {
    /// The stem that is broken.
    pub fn stem(&self) -> &PreparedStem {
        match &self.opened {
            Some(opened) => &opened.stem,
            None => &self.sound,
        }
    }
}

/// The heights of a break.
#[derive(Debug, Clone)]
pub struct HeightStage {
    /// The surface, and what was done to fit it in.
    pub heights: Heights,
    /// What the species did.
    pub relief: SpeciesRelief,
}

/// What a species does to the relief of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesRelief {
    /// Factor on the torn relief.
    pub factor: f64,
    /// Where the factor comes from, where a species is named and has the values.
    pub report: Option<SpeciesReport>,
    /// Why it is 1 although a species is named.
    pub note: Option<BreakNote>,
}

/// A stem cut along the surface of a break.
#[derive(Debug, Clone)]
pub struct CutStage {
    /// The broken face of both pieces, without cracks.
    pub face: BrokenFace,
    /// The faces of the lower and the upper piece with cracks, where the break asks for them there.
    pub cracked: Option<Box<[CrackedFace; 2]>>,
}

/// The cracks of a break, drawn for a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Cracks {
    /// The cracks.
    pub plan: CrackPlan,
    /// Whether they open at a sawn end instead of at the break.
    pub sawn: bool,
    /// The shrinkage that they open by.
    pub shrinkage: CrackShrinkage,
    /// How many tangential cracks were moved to a ring boundary.
    pub moved: usize,
}

impl Cracks {
    /// The cracks that a recipe asks for, if any.
    pub(super) fn plan(recipe: &Recipe) -> Result<Option<Cracks>, Error> {
        if recipe.cracks.is_empty() {
            return Ok(None);
        }
        let shrinkage = recipe.crack_shrinkage()?;
        let mut asked = recipe.cracks.clone();
        let moved = asked.follow_rings(recipe.face.rings);
        Ok(Some(Cracks {
            plan: plan(
                &asked,
                (shrinkage.tangential, shrinkage.radial),
                recipe.face.seed,
            ),
            sawn: recipe.cracks.settings.end == CrackEnd::Sawn,
            shrinkage,
            moved,
        }))
    }
}

/// What the cracks of a break are drawn from.
#[derive(Debug, Clone, PartialEq)]
struct CrackKey {
    cracks: CrackParameters,
    species: Option<String>,
    moisture: Option<f64>,
    rings: u32,
    seed: u64,
}

impl CrackKey {
    fn new(recipe: &Recipe) -> Self {
        CrackKey {
            cracks: recipe.cracks.clone(),
            species: recipe.species.clone(),
            moisture: recipe.moisture,
            rings: recipe.face.rings,
            seed: recipe.face.seed,
        }
    }
}

/// What an opened end is made from: the stem, the cracks, and what the wood in it shows.
#[derive(Debug, Clone, PartialEq)]
struct OpenedKey {
    stem: u64,
    cracks: CrackKey,
    proportions: greenstick_wood::tissue::Proportions,
    material: u32,
}

/// What heights are made from.
#[derive(Debug, Clone, PartialEq)]
struct HeightKey {
    layout: u64,
    parameters: BreakParameters,
    source: HeightSource,
    species: Option<String>,
    moisture: Option<f64>,
}

/// What a cut is made from.
#[derive(Debug, Clone, PartialEq)]
struct CutKey {
    heights: u64,
    cracks: Option<CrackKey>,
    material: u32,
}

/// The last value of each stage of a break.
#[derive(Debug, Default)]
pub(super) struct Chain {
    found: Slot<(u64, StemLocation, StemOptions), PreparedStem>,
    /// Layout and heights on the stem as it was found, where the break asks for another: spiral grain winds no farther
    /// than the break, and the relief that a species calls for is that of the sound stem.
    found_layout: Slot<(u64, LayoutKey), FaceLayout>,
    found_cache: HeightCache,
    spiral: Slot<(u64, f64, (f64, f64)), PreparedStem>,
    opened: Slot<OpenedKey, OpenedEnd>,
    layout: Slot<(u64, LayoutKey), FaceLayout>,
    heights: Slot<HeightKey, HeightStage>,
    cache: HeightCache,
    cut: Slot<CutKey, CutStage>,
    workspace: CutWorkspace,
}

impl Clone for Chain {
    /// The same values; what is only memory to work in is left behind.
    fn clone(&self) -> Self {
        Chain {
            found: self.found.clone(),
            found_layout: self.found_layout.clone(),
            found_cache: self.found_cache.clone(),
            spiral: self.spiral.clone(),
            opened: self.opened.clone(),
            layout: self.layout.clone(),
            heights: self.heights.clone(),
            cache: self.cache.clone(),
            cut: self.cut.clone(),
            workspace: CutWorkspace::default(),
        }
    }
}

/// All stages of one break up to the cut.
#[derive(Debug, Clone)]
pub struct BreakStages {
    /// The stem.
    pub stem: StemStage,
    /// The layout of its section.
    pub layout: Arc<FaceLayout>,
    /// The heights of its face.
    pub heights: Arc<HeightStage>,
    /// The cracks.
    pub cracks: Option<Cracks>,
    /// The stem cut along them.
    pub cut: Arc<CutStage>,
    /// Number of the cut, which no other of the session has.
    pub(super) cut_id: u64,
}

impl BreakStages {
    /// One piece of the break as a mesh of its own, without cracks and as it broke.
    pub fn piece(&self, p: &BreakParameters, upper: bool) -> Mesh {
        let inner = self.inner_wood(p);
        (self.cut.face).piece(&self.stem.stem().source(), &inner, upper)
    }

    /// What the broken face shows.
    pub fn inner_wood<'a>(&'a self, p: &BreakParameters) -> InnerWood<'a> {
        inner_wood(&self.stem, &self.layout, p)
    }
}

fn inner_wood<'a>(
    stage: &'a StemStage,
    layout: &'a FaceLayout,
    p: &BreakParameters,
) -> InnerWood<'a> {
    let stem = stage.stem();
    InnerWood {
        stem: &stem.found.stem,
        bundles: &layout.bundles,
        proportions: p.proportions(),
        material: stage.inner_material,
        square: stem.square,
        smooth: p.surface == Surface::Smooth,
    }
}

/// The scene that a break is made in.
pub(super) struct ChainInput<'a> {
    pub scene: &'a Scene,
    /// Number of the scene, which no other of the session has.
    pub id: u64,
    /// The most that a break may reach up, where another break is above it: a length along the stem, m.
    pub stem: &'a StemOptions,
}

/// Takes down the earliest stage that was made anew.
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
    /// Brings all stages up to the cut to what `asked` says.
    pub fn update(
        &mut self,
        input: &ChainInput,
        asked: &Break,
        ids: &mut Ids,
        changes: &mut Changes,
        context: &Context,
    ) -> Result<BreakStages, Error> {
        let [finding, laying, rising, cutting] = context.split([
            (super::STEM, 4.0),
            (super::LAYOUT, 1.0),
            (super::HEIGHTS, 1.0),
            (super::CUT, 6.0),
        ]);
        let recipe = &asked.recipe;
        let p = &recipe.face;
        let cracks = Cracks::plan(recipe)?;
        let (stem, relief) = self.stem(input, asked, cracks.as_ref(), ids, changes, &finding)?;
        laying.report(0.0)?;
        let key = LayoutKey::new(stem.stem(), p);
        let layout = layout(&mut self.layout, stem.stem(), (stem.id, key), ids)?;
        changes.note(BreakStage::Layout, layout.is_new);
        rising.report(0.0)?;
        let heights = self.heights(&stem, &layout, asked, relief, ids)?;
        changes.note(BreakStage::Heights, heights.is_new);
        cutting.report(0.0)?;
        let at_break = cracks.as_ref().filter(|c| !c.sawn);
        let key = CutKey {
            heights: heights.id,
            cracks: at_break.map(|_| CrackKey::new(recipe)),
            material: stem.inner_material,
        };
        let workspace = &mut self.workspace;
        let cut = self.cut.get(key, ids, |_| {
            let inner = inner_wood(&stem, &layout.value, p);
            let surface = &heights.value.heights.surface;
            cut_stage(&stem, &layout.value, surface, at_break, &inner, workspace)
        })?;
        changes.note(BreakStage::Cut, cut.is_new);
        cutting.report(1.0)?;
        Ok(BreakStages {
            stem,
            layout: layout.value,
            heights: heights.value,
            cracks,
            cut: cut.value,
            cut_id: cut.id,
        })
    }

    /// Brings the stem alone to what `asked` says.
    pub fn stem_only(
        &mut self,
        input: &ChainInput,
        asked: &Break,
        ids: &mut Ids,
        changes: &mut Changes,
        context: &Context,
    ) -> Result<StemStage, Error> {
        let cracks = Cracks::plan(&asked.recipe)?;
        let (stem, ..) = self.stem(input, asked, cracks.as_ref(), ids, changes, context)?;
        Ok(stem)
    }

    /// Height between the 5th and the 95th hundredth of the corners of a face, m, without what a species adds.
    pub fn relief_range(
        &mut self,
        stage: &StemStage,
        p: &BreakParameters,
        ids: &mut Ids,
    ) -> Result<f64, Error> {
        let stem = stage.stem();
        let key = (stage.id, LayoutKey::new(stem, p));
        let layout = layout(&mut self.layout, stem, key, ids)?;
        let setting = height_setting(stem, p, 1.0);
        let bundles = &layout.value.bundles;
        Ok(heights::relief_range(bundles, p, &setting, &mut self.cache))
    }

    /// The stem with the grain and the cracked end that a break asks for, and the relief of the species.
    fn stem(
        &mut self,
        input: &ChainInput,
        asked: &Break,
        cracks: Option<&Cracks>,
        ids: &mut Ids,
        changes: &mut Changes,
        context: &Context,
    ) -> Result<(StemStage, SpeciesRelief), Error> {
        context.report(0.0)?;
        let p = &asked.recipe.face;
        let key = (input.id, asked.place, *input.stem);
        let found = self.found.get(key, ids, |_| {
            PreparedStem::find(input.scene.clone(), &asked.place, input.stem, context)
        })?;
        changes.note(BreakStage::Stem, found.is_new);
        let spiral = is_spiral(&found.value, p);
        let sawn = cracks.filter(|c| c.sawn);
        let relief = self.relief(&found, asked, spiral || sawn.is_some(), ids)?;
        let sound = if spiral {
            let spiral = self.spiral(&found, asked, relief.factor, ids)?;
            changes.note(BreakStage::Stem, spiral.is_new);
            spiral
        } else {
            self.spiral.clear();
            found
        };
        let bare = |n: &greenstick_geometry::Node| lacks_material(&n.mesh);
        let scene = &sound.value.scene;
        let inner_material = scene.materials.len() as u32 + u32::from(scene.nodes.iter().any(bare));
        let mut stage = StemStage {
            sound: sound.value,
            opened: None,
            inner_material,
            id: sound.id,
        };
        match sawn {
            None => self.opened.clear(),
            Some(cracks) => {
                let key = OpenedKey {
                    stem: sound.id,
                    cracks: CrackKey::new(&asked.recipe),
                    proportions: p.proportions(),
                    material: inner_material,
                };
                let opened = self.opened.get(key, ids, |_| {
                    let silent = context.silenced();
                    open_end(&stage.sound, p, &cracks.plan, inner_material, &silent)
                })?;
                changes.note(BreakStage::Stem, opened.is_new);
                (stage.opened, stage.id) = (Some(opened.value), opened.id);
            }
        }
        Ok((stage, relief))
    }

    /// The layout of the stem as it was found: that of the break itself, unless its stem will be `another`.
    fn found_layout(
        &mut self,
        found: &Found<PreparedStem>,
        p: &BreakParameters,
        another: bool,
        ids: &mut Ids,
    ) -> Result<Found<FaceLayout>, Error> {
        let key = (found.id, LayoutKey::new(&found.value, p));
        let slot = if another {
            &mut self.found_layout
        } else {
            &mut self.layout
        };
        layout(slot, &found.value, key, ids)
    }

    /// The stem with grain that spirals about the break and no farther.
    fn spiral(
        &mut self,
        found: &Found<PreparedStem>,
        asked: &Break,
        relief: f64,
        ids: &mut Ids,
    ) -> Result<Found<PreparedStem>, Error> {
        let p = &asked.recipe.face;
        let layout = self.found_layout(found, p, true, ids)?;
        let setting = height_setting(&found.value, p, relief);
        let heights = heights::heights(
            &layout.value.bundles,
            p,
            &setting,
            &asked.heights,
            &mut self.found_cache,
        );
        let stem = &found.value.found.stem;
        let margin = SPIRAL_BEYOND * stem.radius;
        let (low, high) = heights.range;
        let between = (
            (stem.location + low - margin).max(stem.usable.0),
            (stem.location + high + margin).min(stem.usable.1),
        );
        let turn = p.spiral_angle.to_radians() / stem.radius;
        self.spiral.get((found.id, turn, between), ids, |_| {
            Ok(found.value.with_spiral_grain(turn, between))
        })
    }

    /// The factor that the species puts on the relief. The stem of the break will be `another` than the one found, or it.
    fn relief(
        &mut self,
        found: &Found<PreparedStem>,
        asked: &Break,
        another: bool,
        ids: &mut Ids,
    ) -> Result<SpeciesRelief, Error> {
        let recipe = &asked.recipe;
        let none = |note| SpeciesRelief {
            factor: 1.0,
            report: None,
            note,
        };
        let Some(species) = recipe.species()? else {
            return Ok(none(None));
        };
        let radius = found.value.found.stem.radius;
        let moisture = recipe.moisture.unwrap_or(AIR_DRY_PERCENT);
        let height = match species.fracture_height(
            radius,
            DEFAULT_BUNDLE_DIAMETER,
            moisture,
            Fallback::TwelvePercent,
        ) {
            Ok(height) => height,
            Err(error) => return Ok(none(Some(BreakNote::NoSpeciesHeight(error.to_string())))),
        };
        let factor = match height.rule {
            HeightRule::Eq9 => {
                let p = &recipe.face;
                let layout = self.found_layout(found, p, another, ids)?;
                let cache = if another {
                    &mut self.found_cache
                } else {
                    &mut self.cache
                };
                let setting = height_setting(&found.value, p, 1.0);
                let range = heights::relief_range(&layout.value.bundles, p, &setting, cache);
                height.ratio * radius / range.max(1e-9)
            }
            HeightRule::ShearLag => {
                height.ratio * radius / DEFAULT_BUNDLE_DIAMETER / TYPICAL_SLENDERNESS
            }
        };
        let report = SpeciesReport {
            name: species.name.clone(),
            scientific_name: species.scientific_name.clone(),
            moisture_percent: moisture,
            rule: height.rule.to_string(),
            basis: height.basis.to_string(),
            height_m: height.ratio * radius,
            relief: factor,
        };
        Ok(SpeciesRelief {
            factor,
            report: Some(report),
            note: None,
        })
    }

    fn heights(
        &mut self,
        stem: &StemStage,
        layout: &Found<FaceLayout>,
        asked: &Break,
        relief: SpeciesRelief,
        ids: &mut Ids,
    ) -> Result<Found<HeightStage>, Error> {
        let p = &asked.recipe.face;
        let key = HeightKey {
            layout: layout.id,
            parameters: p.clone(),
            source: asked.heights.clone(),
            species: asked.recipe.species.clone(),
            moisture: asked.recipe.moisture,
        };
        let cache = &mut self.cache;
        self.heights.get(key, ids, |_| {
            let setting = height_setting(stem.stem(), p, relief.factor);
            let bundles = &layout.value.bundles;
            Ok(HeightStage {
                heights: heights::heights(bundles, p, &setting, &asked.heights, cache),
                relief,
            })
        })
    }
}

/// How far beyond the break grain spirals, radii.
const SPIRAL_BEYOND: f64 = 0.5;

/// Median over the Wood Handbook's species of the shear-lag length over the bundle's width: the wood that the relief
/// of the parameters stands for.
const TYPICAL_SLENDERNESS: f64 = 2.87;

/// Whether a break asks for spiral grain and the stem can have it: a fibrous face of a round stem.
pub(super) fn is_spiral(stem: &PreparedStem, p: &BreakParameters) -> bool {
    let round = stem.found.stem.kind != StemKind::Board;
    p.spiral_angle != 0.0 && p.surface == Surface::Fibrous && round
}

fn layout(
    slot: &mut Slot<(u64, LayoutKey), FaceLayout>,
    stem: &PreparedStem,
    key: (u64, LayoutKey),
    ids: &mut Ids,
) -> Result<Found<FaceLayout>, Error> {
    let made = key.1.clone();
    slot.get(key, ids, |_| Ok(FaceLayout::new(stem, &made)))
}

fn cut_stage(
    stage: &StemStage,
    layout: &FaceLayout,
    surface: &greenstick_fracture::surface::Surface,
    cracks: Option<&Cracks>,
    inner: &InnerWood,
    workspace: &mut CutWorkspace,
) -> Result<CutStage, Error> {
    let stem = stage.stem();
    let cutter = Cutter {
        stem,
        skin: &stem.skin,
        ground: &layout.ground,
        absorb_chips: true,
    };
    let face = if stem.layers.has_spiral_grain() {
        cutter.break_spiral_grain(surface, inner, workspace)?
    } else {
        cutter.break_along(surface, inner, workspace)?
    };
    let cracked = match cracks {
        Some(cracks) => Some(Box::new(crack_faces(stem, surface, &cracks.plan, inner)?)),
        None => None,
    };
    Ok(CutStage { face, cracked })
}
