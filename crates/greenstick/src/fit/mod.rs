//! From a simulated break to the parameters of a drawn one (Yang 2019 §3), so that an artist can take over from
//! physics.
//!
//! Every rod that broke tells an address in the section, a height along the grain and whether it broke in tension or in
//! compression. From these come the ductile zone, the inclination, the layers, the thorns of both zones and the relief,
//! which is scaled until the drawn face is as high as the simulated one between the 5th and the 95th hundredth.

mod fans;
mod places;
mod report;
mod shape;
mod sheet;

pub use report::{FitReport, TissueBreaks};
pub use sheet::{FittedValue, Untold};

use crate::film::{FilmError, Run};
use crate::{Break, BreakRequest, BreakSession, Error};
use glam::DVec3;
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::{Cancelled, Context, Scene};
use greenstick_schema::{Parameters, Value};
use greenstick_skin::rods::{Parting, Wood};
use greenstick_wood::stem::{self, Stem, StemOptions};
use places::{Broke, Place, addressed, chosen, edge, spread};
use shape::{Known, Shape};
use sheet::Sheet;
use std::collections::BTreeMap;

/// Why nothing is fitted.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The run cannot be read.
    #[error(transparent)]
    Run(#[from] FilmError),
    /// Nothing broke.
    #[error(
        "no rod is broken at {time:.4} s, so that there is no break to take parameters from; take a later frame, or simulate longer or harder"
    )]
    NoBreak {
        /// Time of the frame, s.
        time: f64,
    },
    /// No break can be drawn where the rods broke.
    #[error("the rods broke at {at} of the stem, where no break can be drawn: {error}")]
    Place {
        /// The place.
        at: stem::StemLocation,
        /// Why.
        error: Box<Error>,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Parameters of a break as a run had it.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The recipe.
    pub recipe: Recipe,
    /// Where along the stem: a point where the run is of the limb at a point, else a fraction of the length.
    pub place: stem::StemLocation,
    /// What was fitted.
    pub report: FitReport,
}

/// What a break is fitted in.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The scene that the wood's stem was found in.
    pub scene: &'a Scene,
    /// Whether the stem is known by a point on it, and not as the main one.
    pub by_point: bool,
    /// Seed of the recipe.
    pub seed: u64,
    /// Time of the frame, s.
    pub time: f64,
}

/// Fits the break in frame `number` of a run.
///
/// # Errors
/// [`FitError`].
pub fn fit(run: &mut Run, number: usize, context: &Context) -> Result<Fit, FitError> {
    context.report(0.0)?;
    let (parting, time) = run.parting(number)?;
    let place = stem::StemLocation::parse(&run.scene.stem.at, 1.0);
    let ground = Ground {
        scene: run.input(),
        by_point: matches!(place, Ok(stem::StemLocation::Point(_))),
        seed: run.scene.seed,
        time,
    };
    fit_parting(&run.wood(), &parting, &ground, context)
}

/// Places along a stem are told so precisely: parts of its length.
const PLACE_PARTS: f64 = 1e4;

/// Fits the break of `parting`.
///
/// # Errors
/// [`FitError`].
pub fn fit_parting(
    wood: &Wood,
    parting: &Parting,
    ground: &Ground,
    context: &Context,
) -> Result<Fit, FitError> {
    let found = chosen(wood, parting);
    let broke = &found.broke;
    if broke.is_empty() {
        return Err(FitError::NoBreak { time: ground.time });
    }
    let edge = edge(wood);
    let beside = beside(wood, broke);
    let stem = wood.stem;
    let all: Vec<Broke> = broke.iter().chain(&found.whole).copied().collect();
    let known = |stem: &Stem, to_grain: &dyn Fn(DVec3) -> DVec3| {
        let at = |list: &[Broke]| {
            let area = list.iter().map(|b| b.area).sum();
            addressed(list, area, stem, wood.outline, to_grain)
        };
        let (places, section) = (at(broke), at(&all));
        let shape = Shape::of(&Known {
            places: &places,
            section: &section,
            beside: &beside,
            edge: edge / stem.radius,
            seed: ground.seed,
        });
        (places, section, shape)
    };
    // The middle layer is where the break is; known that, all is counted in the section that a break there has.
    let (_, _, rough) = known(stem, &|p| stem.grain.to_grain(p));
    context.report(0.3)?;
    let along = stem.location + rough.level * stem.radius;
    let place = if ground.by_point {
        stem::StemLocation::Point(stem.grain.axis().frame(along).origin)
    } else {
        let part = (along / stem.length * PLACE_PARTS).round() / PLACE_PARTS;
        stem::StemLocation::Fraction(part.clamp(0.0, 1.0))
    };
    let options = StemOptions {
        kind: Some(stem.kind),
        ..StemOptions::default()
    };
    let mut session = BreakSession::new(ground.scene.clone());
    let request = BreakRequest {
        stem: options,
        ..BreakRequest::single(Break {
            place,
            ..Break::default()
        })
    };
    let refused = |error| FitError::Place {
        at: place,
        error: Box::new(error),
    };
    let stem_there = session.stem(&request, &context.part(0.3, 0.6));
    let prepared = stem_there.map_err(refused)?.sound;
    context.report(0.6)?;
    let there = &prepared.found.stem;
    let (places, section, mut shape) = known(there, &|p| prepared.layers.to_grain(p));
    let mut report = FitReport::of(wood, &places, &shape, there, &place);
    // What is whole is drawn too, flat.
    report.relief_m = heights(&section, there.radius).1;
    report.edge_m = edge;
    (report.breaks_again, report.breaks_elsewhere) = (found.again, found.elsewhere);
    let mut relief_range = |face: &BreakParameters| {
        let mut request = request.clone();
        request.breaks[0].recipe.face = face.clone();
        session.relief_range(&request, &context.silenced())
    };
    report.face_m = matched(&mut shape, &mut relief_range, report.relief_m).map_err(refused)?;
    untold(&mut shape.sheet);
    report.values = shape.sheet.values;
    report.untold = shape.sheet.untold;
    let recipe = Recipe {
        face: shape.sheet.face,
        ..Recipe::default()
    };
    Ok(Fit {
        recipe,
        place,
        report,
    })
}

/// Pairs of broken rods, by their number among these, that were bonded.
fn beside(wood: &Wood, broke: &[Broke]) -> Vec<(usize, usize)> {
    let number: BTreeMap<u32, usize> = broke.iter().enumerate().map(|(i, b)| (b.rod, i)).collect();
    wood.bonded()
        .iter()
        .filter_map(|(a, b)| Some((*number.get(a)?, *number.get(b)?)))
        .collect()
}

/// What a relief may be scaled by: what is farther off is not for the relief to make up.
const LEAST: f64 = 0.25;
const MOST: f64 = 4.0;
/// Halvings of the factor's range.
const ROUNDS: usize = 10;

/// Scales the relief until the drawn face is as high as the simulated one, between the 5th and the 95th hundredth, as far
/// as it may be scaled; gives the drawn face's height, m.
fn matched(
    shape: &mut Shape,
    relief_range: &mut dyn FnMut(&BreakParameters) -> Result<f64, Error>,
    wanted: f64,
) -> Result<f64, Error> {
    let fibrous = shape.sheet.face.surface == SurfaceStyle::Fibrous;
    let scaled: Vec<FittedValue> = shape
        .sheet
        .values
        .iter()
        .filter(|v| match fibrous {
            true => v.key == "slab_height" || v.key == "sliver_height",
            false => v.key.ends_with("perlin_amplitude"),
        })
        .cloned()
        .collect();
    let face = |factor: f64| -> BreakParameters {
        let mut face = shape.sheet.face.clone();
        let table = BreakParameters::table();
        for told in &scaled {
            let most = table.iter().find(|p| p.key == told.key);
            let most = most.and_then(|p| p.max()).unwrap_or(f64::INFINITY);
            // A number in its range is never refused.
            let _ = face.set(told.key, &Value::Number((told.value * factor).min(most)));
        }
        face
    };
    let mut height = |factor: f64| relief_range(&face(factor));
    if scaled.is_empty() || !shape.relief {
        return height(1.0);
    }
    let (mut low, mut high) = (LEAST, MOST);
    for _ in 0..ROUNDS {
        let middle = 0.5 * (low + high);
        if height(middle)? < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    let factor = 0.5 * (low + high);
    for told in scaled {
        let basis = format!(
            "{}, × {factor:.3} for the height of the whole face",
            told.basis
        );
        shape
            .sheet
            .put(told.key, told.value * factor, told.breaks, basis);
    }
    relief_range(&shape.sheet.face)
}

/// What no run tells.
fn untold(sheet: &mut Sheet) {
    let never: [(&str, &str); 5] = [
        (
            "pith_proportion, heartwood_proportion, phloem_proportion, *.thorn_length and *.thorn_probability of tissues",
            "rods have no tissue; thorns are told of the ductile and the brittle zone",
        ),
        (
            "slab_count, sliver_count, bundle_aspect, fibre_height, step_height, thorn_shaft",
            "they are finer than rods",
        ),
        (
            "bark_offset, bark_height, bark_strips",
            "the bark breaks with the rods under it",
        ),
        ("split, hang, spiral_angle", "they are not looked for"),
        (
            "diameter, rings, sectors, *.white_noise_amplitude, *_octaves, *.perlin_frequency",
            "they say how a face is drawn",
        ),
    ];
    for (keys, why) in never {
        sheet.leave(keys, why);
    }
    sheet.leave(
        "species, moisture",
        "they would scale the heights; --species NAME adds them",
    );
}

/// The heights of a break as the report tells them: range and spread, m.
fn heights(places: &[Place], radius: f64) -> ([f64; 2], f64) {
    let all: Vec<(f64, f64)> = places
        .iter()
        .map(|p| (p.height * radius, p.weight))
        .collect();
    let least = all.iter().map(|h| h.0).fold(f64::INFINITY, f64::min);
    let most = all.iter().map(|h| h.0).fold(f64::NEG_INFINITY, f64::max);
    ([least, most], spread(&all))
}
