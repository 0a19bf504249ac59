//! Finding the stem at a location: which shell, which limb of it, and what moves with the upper piece.

use super::attach::{Attachment, Carrier, CutPlane, find_attachment, upper_side};
use super::body::Body;
use super::build::{board_body, body, section_at};
use super::choose::{Choice, Course, main_stem, station_at, stem_at_point};
use super::error::StemError;
use super::free::{Blocked, MARGIN_RADII, Obstruction, free_ranges, obstructions, reaches_end};
use super::model::{CrossSection, Stem, StemKind};
use super::options::{PithPosition, StemOptions};
use super::parts::Parts;
use super::section::section;
use super::surface::Surface;
use super::taper::taper;
use super::tube::Tube;
use super::valid::{long_borders, valid_size};
use super::{GrainSpace, SlopeOfGrain, StemIdentity, StemLocation};
use crate::polygon;
use crate::polygon::area_and_centroid;
use crate::rings::{PITH_OFFSET_RMS, RingField, estimate_pith};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Cancelled, Context, Mesh};
use std::f64::consts::PI;

/// A stem in meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundStem {
    /// Index of the mesh.
    pub node: usize,
    /// Triangles of the connected part of that mesh that holds the location, ascending.
    pub shell: Vec<u32>,
    /// Those of them on the limb within the usable range and a little beyond, ascending: what a break may cut.
    pub limb: Vec<u32>,
    /// The stem.
    pub stem: Stem,
    /// What tells it from other stems.
    pub identity: StemIdentity,
    /// Ranges of length (m) in which it can be broken, the one about the location among them.
    pub free: Vec<(f64, f64)>,
    /// Other shells that are attached beyond the location and move with the upper piece.
    pub carried: Vec<CarriedShell>,
    /// What was assumed or repaired, a sentence each.
    pub notes: Vec<String>,
}

/// A shell that moves with the upper piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CarriedShell {
    /// Index of the mesh.
    pub node: usize,
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
}

/// Most shells that others may be attached to, the largest ones. A tree with more limbs than this has leaves for the rest.
const MAX_CARRIERS: usize = 256;
/// Tolerances of welding, relative to the model's size, that are tried where the mesh is not connected.
const WELDING_TOLERANCES: [f64; 3] = [1e-6, 1e-5, 1e-4];
/// A board is taken for flat-sawn: its pith lies so far below the middle of its wide face, in widths.
const FLAT_SAWN_PITH_WIDTHS: f64 = 0.75;
/// A dowel is turned from a board well off the pith, which lies so many of its greatest diameters beside its middle.
const DOWEL_PITH_DIAMETERS: f64 = 2.0;
/// How much farther than the sections its rings reach, so that relief between sections is inside.
const EXTENT_MARGIN: f64 = 1.05;
/// Parts of the whole search after which shells are known, the stem is chosen, and it is built.
const SHELLS_KNOWN: f64 = 0.2;
const STEM_CHOSEN: f64 = 0.5;
const STEM_BUILT: f64 = 0.8;

/// Finds the stem at `location`. `meshes` are in world metres, one per node.
///
/// For a point the nearest shell is taken and the limb of it that is there; for a fraction or length the shell whose
/// stem has the largest volume, measured from its base: the end stuck in another shell, else the thicker end, else
/// the one with the lower y (then x, then z).
///
/// ```
/// use greenstick_geometry::Context;
/// use greenstick_wood::primitive;
/// use greenstick_wood::stem::{StemOptions, find_stem};
///
/// let pole = primitive::cylinder(0.05, 2.0, 24); // from the origin along +y, m
/// let found = find_stem(&[pole], &"50cm".parse()?, &StemOptions::default(), &Context::quiet())?;
/// assert!((found.stem.length - 2.0).abs() < 0.01);
///
/// // The address of a point: ring coordinate, angle about the pith, and length along the axis.
/// let grain = found.stem.grain.to_grain(glam::DVec3::new(0.025, 0.7, 0.0));
/// let (ring, _angle) = found.stem.rings.address(grain.truncate());
/// assert!((ring - 0.5).abs() < 0.02 && (grain.z - 0.7).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`StemError`] where there is no stem at the location, with the nearest location that works where there is one.
pub fn find_stem(
    meshes: &[Mesh],
    location: &StemLocation,
    options: &StemOptions,
    context: &Context,
) -> Result<FoundStem, StemError> {
    find_stem_along(meshes, location, options, None, context)
}

/// Finds the stem at `location` as [`find_stem`] does, but with its base where `along`, if given, comes from: a direction from
/// base to tip, as of a stem that part of this one was broken off.
///
/// # Errors
/// As [`find_stem`].
pub fn find_stem_along(
    meshes: &[Mesh],
    location: &StemLocation,
    options: &StemOptions,
    along: Option<DVec3>,
    context: &Context,
) -> Result<FoundStem, StemError> {
    let size = valid_size(meshes)?;
    let asked = (location, along);
    let search = |tolerance: f64| find_welded(meshes, asked, options, tolerance, context);
    let first = search(0.0);
    if !matches!(
        first,
        Err(StemError::NoStem { .. } | StemError::NowhereFree { .. })
    ) {
        return first;
    }
    // Perhaps a soup whose triangles touch only nearly.
    for tolerance in WELDING_TOLERANCES {
        match search(tolerance * size) {
            Err(StemError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(_) => {}
            found => return found,
        }
    }
    match long_borders(meshes, context)? {
        Some(borders) => Err(StemError::Open { borders }),
        None => first,
    }
}

/// Finds the stem with vertices welded within `tolerance` (m).
fn find_welded(
    meshes: &[Mesh],
    (location, along): (&StemLocation, Option<DVec3>),
    options: &StemOptions,
    tolerance: f64,
    context: &Context,
) -> Result<FoundStem, StemError> {
    context.report(0.0)?;
    let parts = Parts::new(meshes, tolerance, context)?;
    context.report(SHELLS_KNOWN)?;
    let choosing = context.part(SHELLS_KNOWN, STEM_CHOSEN);
    let mut choice = match location {
        StemLocation::Point(p) => stem_at_point(&parts, *p, options.kind, &choosing)?,
        _ => main_stem(&parts, options.kind, &choosing)?,
    };
    context.report(STEM_CHOSEN)?;
    let carriers = carriers(&parts, choice.shell, context)?;
    let held = orient(&mut choice, &carriers, along);
    let carrier = carriers.iter().find(|c| c.shell == choice.shell);
    let Some(Carrier { surface, .. }) = carrier else {
        return Err(StemError::NoStem {
            shells: parts.shells.len(),
        });
    };
    let search = Search {
        parts: &parts,
        choice: &choice,
        surface,
        location,
        options,
        context,
    };
    let mut found = search.stem(held)?;
    context.report(STEM_BUILT)?;
    found.carried = search.carried_shells(&found, &carriers)?;
    if tolerance > 0.0 {
        let moved = parts.moved_vertices();
        found.notes.insert(
            0,
            format!(
                "the mesh was not connected: {moved} vertices were welded within {tolerance:.2e} m"
            ),
        );
    }
    context.report(1.0)?;
    Ok(found)
}

/// The shells that others may be attached to, the chosen one among them.
fn carriers<'a>(
    parts: &'a Parts,
    chosen: usize,
    context: &Context,
) -> Result<Vec<Carrier<'a>>, Cancelled> {
    let mut shells: Vec<usize> = if parts.shells.len() == 1 {
        Vec::new()
    } else {
        let largest = parts.largest_first.iter().copied();
        largest.take(MAX_CARRIERS).collect()
    };
    if !shells.contains(&chosen) {
        shells.push(chosen);
    }
    shells
        .into_iter()
        .map(|shell| {
            let surface = parts.surface(shell, context)?;
            Ok(Carrier { shell, surface })
        })
        .collect()
}

/// Turns the stem so that it runs from its base to its tip, or along a direction; returns the shells that hold base and tip.
fn orient(choice: &mut Choice, carriers: &[Carrier], along: Option<DVec3>) -> [Option<usize>; 2] {
    let held = choice.course.tips().map(|tip| {
        carriers
            .iter()
            .find(|c| c.shell != choice.shell && c.surface.contains(tip))
            .map(|c| c.shell)
    });
    let backwards = match along {
        Some(along) => {
            let near = choice.surface_point.unwrap_or(choice.course.tips()[0]);
            choice.course.direction_near(near).dot(along) < 0.0
        }
        None => choice.course.runs_from_tip_to_base(held),
    };
    if backwards {
        choice.course.reverse();
        [held[1], held[0]]
    } else {
        held
    }
}

/// The rest of the search, once shell and limb are known.
struct Search<'a> {
    parts: &'a Parts,
    choice: &'a Choice,
    surface: &'a Surface<'a>,
    location: &'a StemLocation,
    options: &'a StemOptions,
    context: &'a Context,
}

impl Search<'_> {
    fn stem(&self, held: [Option<usize>; 2]) -> Result<FoundStem, StemError> {
        let body = self.body()?;
        let at = self.length_at_location(&body);
        let tube = Tube::new(&body);
        let (parts, cut) = (self.parts, self.choice.shell);
        let length = body.axis.length();
        let obstructions = obstructions(parts, cut, &tube, held, length, self.context)?;
        let free = free_ranges(&body, &obstructions);
        let refusal = || {
            let blocked = Blocked {
                body: &body,
                surface: self.surface,
                obstructions: &obstructions,
                free: &free,
                requested: *self.location,
                at,
            };
            blocked.refusal()
        };
        let contains = |r: &&(f64, f64)| at >= r.0 && at <= r.1;
        let usable = *free.iter().find(contains).ok_or_else(refusal)?;
        let limit = 0.5 * body.radius(at);
        let here = section_at(self.surface, &body.axis, at, limit)
            .ok_or_else(refusal)?
            .section;
        let mut notes = Vec::new();
        let stem = self.assemble(&body, usable, &obstructions, here, &mut notes);
        let margin = 2.0 * MARGIN_RADII * stem.radius;
        for obstruction in &obstructions {
            let (a, b) = obstruction.range;
            if (a - usable.1).max(usable.0 - b) < margin {
                notes.push(format!(
                    "the break stays clear of {a:.3} to {b:.3} m, where {}",
                    obstruction.reason
                ));
            }
        }
        let under = self.triangles_under(&stem, at, limit);
        let range = (usable.0 - margin, usable.1 + margin);
        let shell = &parts.shells[cut];
        Ok(FoundStem {
            node: shell.node,
            shell: shell.triangles.clone(),
            limb: tube.limb(self.surface, range, &under, self.context)?,
            stem,
            identity: self.choice.identity,
            free,
            carried: Vec::new(),
            notes,
        })
    }

    fn body(&self) -> Result<Body, StemError> {
        let mut body = match &self.choice.course {
            Course::Board(plank) => board_body(self.surface, plank, self.context)?,
            Course::Log(trace) => {
                let near = station_at(trace, self.location, self.choice.surface_point);
                body(self.surface, trace, near, self.context)?
            }
        };
        if let (Some(body), Course::Log(_), Some(kind)) =
            (&mut body, &self.choice.course, self.options.kind)
        {
            body.kind = kind;
        }
        body.ok_or(StemError::NoStem {
            shells: self.parts.shells.len(),
        })
    }

    /// The requested location as length along the axis, m.
    fn length_at_location(&self, body: &Body) -> f64 {
        match self.location {
            StemLocation::Fraction(x) => x * body.axis.length(),
            StemLocation::Length(x) => *x,
            StemLocation::Point(p) => {
                let point = self.choice.surface_point.unwrap_or(*p);
                body.axis.length_at(point)
            }
        }
    }

    /// Triangles under the section at `at` (m).
    fn triangles_under(&self, stem: &Stem, at: f64, limit: f64) -> Vec<u32> {
        let frame = stem.grain.axis().frame(at);
        section(self.surface, frame.origin, frame.tangent, limit)
            .map_or(Vec::new(), |c| c.triangles)
    }

    fn assemble(
        &self,
        body: &Body,
        usable: (f64, f64),
        obstructions: &[Obstruction],
        here: CrossSection,
        notes: &mut Vec<String>,
    ) -> Stem {
        let location = here.length;
        let length = body.axis.length();
        let radius = (here.area / PI).sqrt();
        let run = body
            .free_runs()
            .into_iter()
            .find(|r| location >= r.0 && location <= r.1)
            .unwrap_or((0.0, length));
        let grain = GrainSpace::new(body.axis.clone(), taper(body, run, location, here.area));
        let pith = self.pith(body, &grain, &here, notes);
        let slope = self.slope_of_grain(body, location, pith);
        let grain = grain.with_slope(slope);
        let pith = pith
            - match self.options.pith {
                Some(PithPosition::World(p)) => grain.offset(grain.axis().length_at(p)),
                // Half-way along the stem, so that rings are the same wherever it breaks.
                Some(PithPosition::Section(_)) | None => grain.offset(0.5 * length),
            };
        let mut sections: Vec<CrossSection> = body
            .stations
            .iter()
            .filter_map(|station| station.section.clone())
            .filter(|s| s.length != location)
            .collect();
        let k = sections.partition_point(|s| s.length < location);
        sections.insert(k, here.clone());
        let reach = |s: &CrossSection| {
            s.contour
                .iter()
                .map(|p| grain.from_section(*p, s.length).distance(pith))
                .fold(0.0, f64::max)
        };
        let extent = sections
            .iter()
            .filter(|s| s.length >= usable.0 && s.length <= usable.1)
            .map(reach)
            .fold(0.0, f64::max)
            * EXTENT_MARGIN;
        let round = !body.kind.is_sawn();
        let rings = if round && polygon::contains(&here.contour, pith) {
            RingField::round(&here.contour, pith, extent, self.options.eccentricity_onset)
        } else {
            if round {
                notes.push("the pith lies outside the section: rings are arcs about it".to_owned());
            }
            // Sawn wood has the rings of the log it was cut from, which are the same wherever it breaks.
            let all = if round { &[] } else { &sections[..] };
            let outer = all.iter().map(reach).fold(reach(&here), f64::max);
            RingField::arcs(pith, outer, extent)
        };
        let ends = (
            reaches_end(body, obstructions, usable.0, 0),
            reaches_end(body, obstructions, usable.1, 1),
        );
        Stem {
            grain,
            kind: body.kind,
            sections,
            location,
            usable,
            rings,
            radius,
            ends,
            length,
        }
    }

    /// How the grain of sawn wood slopes: away from the pith, so that wide faces cut through rings.
    fn slope_of_grain(&self, body: &Body, location: f64, pith: DVec2) -> Option<SlopeOfGrain> {
        let slope = self.options.slope_of_grain;
        (body.kind.is_sawn() && slope > 0.0).then(|| SlopeOfGrain {
            direction: (-pith).try_normalize().unwrap_or(DVec2::Y),
            slope,
            reference: location,
            seed: self.choice.identity.hash(),
        })
    }

    /// The pith in the section of the break, m, as if grain ran along the axis.
    fn pith(
        &self,
        body: &Body,
        grain: &GrainSpace,
        section: &CrossSection,
        notes: &mut Vec<String>,
    ) -> DVec2 {
        match (self.options.pith, body.kind) {
            (Some(PithPosition::Section(p)), _) => p,
            (Some(PithPosition::World(p)), _) => grain.to_grain(p).truncate(),
            (None, StemKind::Round | StemKind::Pole) => {
                let pith = estimate_pith(&section.contour);
                let (area, centroid) = area_and_centroid(&section.contour);
                let radius = (area.abs() / std::f64::consts::PI).sqrt();
                let place = if pith == centroid {
                    "at the section's centroid".to_owned()
                } else {
                    let off = (pith - centroid).length() * 1e3;
                    format!(
                        "{off:.1} mm from the section's centroid, which lies outside or close to the bark"
                    )
                };
                notes.push(format!(
                    "the pith was estimated, {place}; a pith is {:.0} % of the radius off the centroid on average, here {:.1} \
                     mm",
                    100.0 * PITH_OFFSET_RMS,
                    1e3 * PITH_OFFSET_RMS * radius
                ));
                pith
            }
            (None, StemKind::Dowel) => {
                // That of the board it was turned from, which does not depend on where it breaks or how thick it is there.
                let all = || body.stations.iter().filter_map(|s| s.section.as_ref());
                let centroids = all().fold(DVec2::ZERO, |sum, s| sum + s.centroid);
                let thickest = all().map(|s| s.area).fold(section.area, f64::max);
                let down = DOWEL_PITH_DIAMETERS * 2.0 * (thickest / PI).sqrt();
                notes.push(format!(
                    "the pith was taken to lie {:.0} mm beside the middle of the dowel",
                    down * 1e3
                ));
                centroids / all().count().max(1) as f64 - DVec2::new(0.0, down)
            }
            (None, StemKind::Board) => {
                // Flat-sawn: the wide faces are tangential to the rings. x is the wide direction.
                let down = FLAT_SAWN_PITH_WIDTHS * body.width;
                notes.push(format!(
                    "the pith was taken to lie {:.0} mm below the middle of the wide face (flat-sawn)",
                    down * 1e3
                ));
                DVec2::new(0.0, -down)
            }
        }
    }

    /// Shells that move with the upper piece.
    fn carried_shells(
        &self,
        found: &FoundStem,
        carriers: &[Carrier],
    ) -> Result<Vec<CarriedShell>, Cancelled> {
        let (shells, cut) = (&self.parts.shells, self.choice.shell);
        if shells.len() < 2 {
            return Ok(Vec::new());
        }
        let mut attachments: Vec<Option<Attachment>> = Vec::with_capacity(shells.len());
        for (i, shell) in shells.iter().enumerate() {
            self.context.check()?;
            let mesh = &self.parts.meshes[shell.node];
            attachments.push(if i == cut {
                None
            } else {
                find_attachment(mesh, shells, i, carriers)
            });
        }
        let mesh = &self.parts.meshes[shells[cut].node];
        let frame = found.stem.grain.axis().frame(found.stem.location);
        let plane = CutPlane {
            origin: frame.origin,
            along: frame.tangent,
        };
        let barrier = self.triangles_under(&found.stem, found.stem.location, found.stem.radius);
        let mut upper_points = upper_side(mesh, &shells[cut], &barrier, plane);
        let mut is_beyond = |at: DVec3| {
            let above = (at - plane.origin).dot(plane.along) > 0.0;
            let (Some(upper), Some((t, _))) = (&mut upper_points, self.surface.nearest(at)) else {
                return above;
            };
            if barrier.contains(&t) {
                return above;
            }
            upper(mesh.triangles[t as usize][0])
        };
        let mut carried = Vec::new();
        for (i, shell) in shells.iter().enumerate() {
            // Follow what carries it down to the cut shell; a ring of shells that hold each other ends the walk.
            let mut at = i;
            let mut moves = false;
            for _ in 0..shells.len() {
                let Some(attachment) = attachments[at] else {
                    break;
                };
                if attachment.carrier == cut {
                    moves = is_beyond(attachment.at);
                    break;
                }
                at = attachment.carrier;
            }
            if moves && i != cut {
                carried.push(CarriedShell {
                    node: shell.node,
                    triangles: shell.triangles.clone(),
                });
            }
        }
        Ok(carried)
    }
}
