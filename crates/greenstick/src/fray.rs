//! Frayed breaks: splinters come loose as pieces of their own, and thorns bend.

mod bend;
mod part;

use crate::model::Model;
use crate::{Error, Prepared};
use bend::Bend;
pub(crate) use bend::Bent;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use greenstick_fracture::cut::{Ground, cut_again};
use greenstick_fracture::parameters::{BreakParameters, Surface as SurfaceKind};
use greenstick_fracture::splinters::{Loosened, SplinterOptions, column, loosen};
use greenstick_fracture::surface::Surface;
use greenstick_geometry::Mesh;
use greenstick_skin::face::face;
use greenstick_skin::pieces::{self, InnerWood, Patch};
use greenstick_wood::noise;
use std::f64::consts::TAU;

/// Seeds of independent random numbers.
mod purpose {
    pub const CHOICE: u64 = 0xf4a1;
    pub const BEND: u64 = 0xf4a2;
    pub const THROW: u64 = 0xf4a3;
}

/// Most splinters that come loose.
const MOST: f64 = 12.0;
/// Least length of a splinter, radii.
const LEAST: f64 = 0.3;

/// A frayed break. Meshes are in the coordinates of the node that was cut.
#[derive(Debug, Clone)]
pub(crate) struct Frayed {
    /// The lower piece without its splinters, its thorns bent.
    pub lower: Mesh,
    /// The upper piece.
    pub upper: Mesh,
    /// The splinters where they stood in the wood, each with its motion in the world.
    pub splinters: Vec<(Mesh, DAffine3)>,
    /// How the lower and the upper piece were bent.
    pub bent: [Bent; 2],
}

/// Pieces and splinters at rest, with the cell of each splinter.
struct Rest {
    lower: Mesh,
    upper: Mesh,
    splinters: Vec<(Mesh, u32)>,
}

/// How much a break is frayed and how its pieces lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrayOptions {
    /// 0 (not at all) to 1.
    pub amount: f64,
    /// How far the pieces are moved apart, m.
    pub part: f64,
    /// Material of the wood inside.
    pub material: u32,
}

/// Frays the break of `model`, which was made with the parameters `p`.
///
/// # Errors
/// [`Error::Cut`] as for the break itself.
pub(crate) fn fray(
    prepared: &Prepared,
    model: &Model,
    p: &BreakParameters,
    options: &FrayOptions,
) -> Result<Frayed, Error> {
    let rest = at_rest(prepared, model, p, options)?;
    let seed = p.seed ^ purpose::BEND;
    let bend = |mesh: &Mesh, upper| {
        let bend = Bend::new(prepared, model, options.amount, seed, upper);
        let (bent, mut done) = bend.apply(mesh);
        done.change = bent.volume() / mesh.volume() - 1.0;
        (bent, done)
    };
    let ((lower, of_lower), (upper, of_upper)) =
        (bend(&rest.lower, false), bend(&rest.upper, true));
    // Around the stem in the order in which they stood, so that they do not fall on each other.
    let angle = |s: &(Mesh, u32)| model.bundles.bundles[s.1 as usize].phi.rem_euclid(TAU);
    let angles: Vec<f64> = rest.splinters.iter().map(angle).collect();
    let splinters = rest.splinters.iter().enumerate().map(|(i, s)| {
        let before = |&(j, a): &(usize, &f64)| *a < angles[i] || (*a == angles[i] && j < i);
        let rank = angles.iter().enumerate().filter(before).count();
        let side = (rank as f64 + 0.5) / angles.len() as f64;
        (
            s.0.clone(),
            throw(prepared, model, p.seed, options, side, s),
        )
    });
    Ok(Frayed {
        splinters: splinters.collect(),
        lower,
        upper,
        bent: [of_lower, of_upper],
    })
}

/// Takes splinters off both pieces.
fn at_rest(
    prepared: &Prepared,
    model: &Model,
    p: &BreakParameters,
    options: &FrayOptions,
) -> Result<Rest, Error> {
    let surface = &model.heights.surface;
    let (solid, skin) = (prepared.solid(), &prepared.kept.skin);
    let ground = Ground::new(skin, &surface.layout);
    let cut_along = |surface: &Surface| {
        let cut = cut_again(&solid, skin, &ground, surface);
        let mut cut = cut.map_err(|error| prepared.locate(error))?;
        cut.absorb_chips(&solid);
        cut.part_at(&prepared.grain, &prepared.kept.levels);
        Ok::<_, Error>(cut)
    };
    let whole = cut_along(surface)?;
    // A bundle is free that lies away from the skin and is part of the broken face.
    let mut shown = vec![false; model.bundles.bundles.len()];
    for face in whole.faces.iter().filter(|f| f.top) {
        shown[face.cell as usize] = true;
    }
    for (f, &cell) in surface.layout.cells.iter().enumerate() {
        if ground.is_near(f as u32) {
            shown[cell as usize] = false;
        }
    }
    let chosen = SplinterOptions {
        count: (options.amount.clamp(0.0, 1.0) * MOST).ceil() as usize,
        least: LEAST * prepared.found.stem.radius,
        seed: p.seed ^ purpose::CHOICE,
    };
    let Loosened {
        lower,
        upper,
        splinters,
    } = loosen(surface, &model.bundles, &|c| shown[c as usize], &chosen);
    let proportions = p.proportions();
    let zone = |rho: f64| proportions.zone_at(rho, 0.0).code();
    let inner = InnerWood {
        stem: &prepared.found.stem,
        bundles: &model.bundles,
        zone: &zone,
        material: options.material,
        square: model.square,
        smooth: p.surface == SurfaceKind::Smooth,
    };
    let source = prepared.source();
    let piece = |own: &Surface, side: bool, as_it_is: &Mesh| {
        if splinters.iter().all(|s| s.upper != side) {
            return Ok(as_it_is.clone());
        }
        let cut = cut_along(own)?;
        let face = face(&source, &cut, &inner);
        let patch = pieces::patch(&source, &cut, skin, &face.places);
        Ok::<_, Error>(pieces::piece(&source, &cut, &patch, &face, &inner, side))
    };
    let rest = Rest {
        lower: piece(&lower, false, &model.lower)?,
        upper: piece(&upper, true, &model.upper)?,
        splinters: splinters
            .iter()
            .map(|s| {
                let faces = if s.upper {
                    [surface, &upper]
                } else {
                    [&lower, surface]
                };
                let mut cut = column(&solid, skin, &whole, faces, s.cell);
                cut.part_at(&prepared.grain, &prepared.kept.levels);
                let face = face(&source, &cut, &inner);
                let no_skin = Patch {
                    first: source.mesh.positions.len() as u32,
                    ..Patch::default()
                };
                let mesh = pieces::piece(&source, &cut, &no_skin, &face, &inner, false);
                (mesh, s.cell)
            })
            .collect(),
    };
    Ok(rest)
}

/// Distance from the section's middle at which thrown splinters begin, as part of the section's reach, and how much farther they may
/// lie, radii.
const CLEAR: f64 = 1.12;
const SPREAD: f64 = 0.8;

/// How far the skin about the break (heights in m from its place) reaches from `middle` in a direction, m.
fn reach(prepared: &Prepared, middle: DVec2, direction: DVec2, (low, high): (f64, f64)) -> f64 {
    let stem = &prepared.found.stem;
    let near = (low - 4.0 * stem.radius)..(high + 4.0 * stem.radius);
    let points = prepared.grain.iter();
    points
        .filter(|p| near.contains(&(p.z - stem.location)))
        .map(|p| (p.truncate() - middle).dot(direction))
        .fold(stem.radius, f64::max)
}

/// Where a splinter falls: out of the break, on a side of the stem (0 to 1 around it), turned over in the air.
fn throw(
    prepared: &Prepared,
    model: &Model,
    seed: u64,
    options: &FrayOptions,
    side: f64,
    (mesh, cell): &(Mesh, u32),
) -> DAffine3 {
    let stem = &prepared.found.stem;
    let frame = stem.grain.axis().frame(stem.location);
    let random = |i: i64| noise::unit(seed ^ purpose::THROW, i64::from(*cell), i, 0);
    // An unparted break is shown with the upper piece set aside along x: no splinter falls there.
    let open = if options.part == 0.0 { TAU / 6.0 } else { 0.0 };
    let angle = open + (TAU - 2.0 * open) * (side + 0.04 * (random(0) - 0.5)).clamp(0.0, 1.0);
    let across = |angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        frame.x * cos + frame.y * sin
    };
    let (out, beside) = (across(angle), across(angle + TAU / 4.0));
    // Pointing up and outwards, between standing and lying, and rolled about itself.
    let lean = DQuat::from_axis_angle(beside, 0.35 + 0.9 * random(1));
    let swing = DQuat::from_axis_angle(out, 1.2 * (random(2) - 0.5));
    let roll = DQuat::from_axis_angle(frame.tangent, TAU * random(3));
    let turn = swing * lean * roll;
    let transform = prepared.transform();
    let places: Vec<DVec3> = (mesh.positions.iter())
        .map(|&p| transform.transform_point3(p))
        .collect();
    let (low, high) = places
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    let centre = (low + high) / 2.0;
    // So far out that all of it is clear of the stem; less far where the gap has room for it.
    let inmost = places
        .iter()
        .map(|&p| (turn * (p - centre)).dot(out))
        .fold(f64::INFINITY, f64::min);
    let middle = model.square.0;
    let (sin, cos) = libm::sincos(angle);
    let reach = reach(prepared, middle, DVec2::new(cos, sin), model.heights.range);
    let (bottom, top) = model.heights.range;
    let room = (options.part - (top - bottom)) / (2.0 * stem.radius);
    let aside = CLEAR * reach * (1.0 - 0.6 * room.clamp(0.0, 1.0))
        + SPREAD * stem.radius * random(4)
        - inmost;
    let along = (bottom + top + options.part) / 2.0 + (top - bottom) * 0.6 * (random(5) - 0.5);
    let to = frame.origin
        + frame.x * middle.x
        + frame.y * middle.y
        + out * aside
        + frame.tangent * along;
    DAffine3::from_translation(to) * DAffine3::from_quat(turn) * DAffine3::from_translation(-centre)
}

#[cfg(test)]
mod tests;
