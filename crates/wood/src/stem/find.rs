//! Finding the stem at a place: which shell, which limb of it, and what moves with the upper piece.

use super::attach::{self, Hanging, Tube};
use super::build::{self, Body, MARGIN, Section, Stem, StemKind};
use super::course::{Course, Parts, at_point, main_stem, station_at, turned_over};
use super::error::StemError;
use super::free::{Zone, free_ranges, reaches_end};
use super::polygon;
use super::shells::{self, Points, Shell};
use super::surface::Surface;
use super::{GrainSpace, Place};
use crate::rings::{RingField, likely_pith};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Context, Mesh};

/// A pith that somebody knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PithChoice {
    /// A point in the world, m; taken along the grain to the section of the break.
    World(DVec3),
    /// In the section of the break, m, from the axis along the frame's x and y.
    Section(DVec2),
}

/// What may be said about the stem beforehand.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StemOptions {
    /// The pith; estimated where absent.
    pub pith: Option<PithChoice>,
    /// Log or board; judged by the section where absent.
    pub kind: Option<StemKind>,
}

/// A stem in meshes.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Index of the mesh.
    pub node: usize,
    /// Triangles of the connected part of that mesh that holds the place, ascending.
    pub shell: Vec<u32>,
    /// Those of them on the limb within the usable range and a little beyond, ascending: what a break may cut.
    pub limb: Vec<u32>,
    /// The stem.
    pub stem: Stem,
    /// Other shells that hang beyond the place and move with the upper piece: (mesh, its triangles, ascending).
    pub carried: Vec<(usize, Vec<u32>)>,
    /// What was assumed or repaired, a sentence each.
    pub notes: Vec<String>,
}

/// Shells that others may hang on: the largest ones. A tree with more limbs than this has leaves for the rest.
const CARRIERS: usize = 256;
/// Finds the stem at `place`. `meshes` are in world metres, one per node.
///
/// For a point the nearest shell is taken and the limb of it that is there; for a fraction or length the shell whose
/// stem has the largest volume, measured from its base: the end stuck in another shell, else the thicker end, else
/// the one with the lower y (then x, then z).
///
/// # Errors
/// [`StemError`] where there is no stem at the place, with the nearest place that works where there is one.
pub fn find(
    meshes: &[Mesh],
    place: &Place,
    options: &StemOptions,
    context: &Context,
) -> Result<Found, StemError> {
    for (node, mesh) in meshes.iter().enumerate() {
        let count = mesh.positions.len();
        if let Some(i) = mesh.positions.iter().position(|p| !p.is_finite()) {
            let found = format!(
                "vertex {i} is {}; coordinates must be finite",
                mesh.positions[i]
            );
            return Err(StemError::Invalid { node, found });
        }
        if let Some(t) = mesh
            .triangles
            .iter()
            .position(|t| t.iter().any(|&v| v as usize >= count))
        {
            let found = format!("triangle {t} names a vertex beyond the {count} that there are");
            return Err(StemError::Invalid { node, found });
        }
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in meshes.iter().flat_map(|m| &m.positions) {
        (low, high) = (low.min(*p), high.max(*p));
    }
    if meshes.iter().all(|m| m.triangles.is_empty()) {
        return Err(StemError::Empty);
    }
    let first = attempt(meshes, place, options, context, 0.0);
    if !matches!(
        first,
        Err(StemError::NoStem { .. } | StemError::NowhereFree { .. })
    ) {
        return first;
    }
    // Perhaps a soup whose triangles touch only nearly.
    for tolerance in [1e-6, 1e-5, 1e-4] {
        let tolerance = tolerance * low.distance(high);
        if let Ok(found) = attempt(meshes, place, options, context, tolerance) {
            return Ok(found);
        }
    }
    first
}

fn attempt(
    meshes: &[Mesh],
    place: &Place,
    options: &StemOptions,
    context: &Context,
    tolerance: f64,
) -> Result<Found, StemError> {
    context.report(0.0)?;
    let points: Vec<Points> = meshes
        .iter()
        .map(|m| shells::points(m, tolerance))
        .collect();
    let shells: Vec<Shell> = points
        .iter()
        .enumerate()
        .flat_map(|(node, p)| shells::shells(node, p))
        .collect();
    let mut order: Vec<usize> = (0..shells.len()).collect();
    order.sort_by(|&a, &b| {
        shells[b]
            .diagonal()
            .total_cmp(&shells[a].diagonal())
            .then(a.cmp(&b))
    });
    let parts = Parts {
        points,
        shells,
        order,
    };
    context.report(0.2)?;
    let (cut, mut followed, at) = match place {
        Place::Point(p) => at_point(&parts, *p, place, options.kind)?,
        _ => main_stem(&parts, options.kind, context)?,
    };
    context.report(0.5)?;
    let carriers: Vec<(usize, Surface)> = if parts.shells.len() == 1 {
        vec![(cut, parts.surface(cut))]
    } else {
        let mut chosen: Vec<usize> = parts.order.iter().copied().take(CARRIERS).collect();
        if !chosen.contains(&cut) {
            chosen.push(cut);
        }
        chosen.into_iter().map(|i| (i, parts.surface(i))).collect()
    };
    let tips = match &followed {
        Course::Log(trace) => trace.tips,
        Course::Board(plank) => [plank.end, plank.end + plank.direction * plank.size[0]],
    };
    let held = tips.map(|tip| {
        carriers
            .iter()
            .find(|(i, surface)| *i != cut && surface.holds(tip))
            .map(|(i, _)| *i)
    });
    let reversed = turned_over(&followed, tips, held);
    let held = if reversed { [held[1], held[0]] } else { held };
    match &mut followed {
        Course::Log(trace) if reversed => trace.reverse(),
        Course::Board(plank) if reversed => {
            plank.end = tips[1];
            plank.direction = -plank.direction;
        }
        _ => {}
    }
    let Some(surface) = carriers.iter().find(|(i, _)| *i == cut).map(|(_, s)| s) else {
        return Err(StemError::NoStem {
            shells: parts.shells.len(),
        });
    };
    let search = Search {
        parts: &parts,
        cut,
        surface,
        place,
        options,
    };
    let mut found = search.stem(&followed, at, held)?;
    context.report(0.8)?;
    found.carried = search.carried(&found, &carriers);
    let moved: usize = parts.points.iter().map(|p| p.moved).sum();
    if tolerance > 0.0 {
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

/// One search after shell and limb are known.
pub(super) struct Search<'a> {
    pub parts: &'a Parts,
    pub cut: usize,
    pub surface: &'a Surface<'a>,
    pub place: &'a Place,
    pub options: &'a StemOptions,
}

impl Search<'_> {
    fn stem(
        &self,
        course: &Course,
        at: Option<DVec3>,
        held: [Option<usize>; 2],
    ) -> Result<Found, StemError> {
        let body = match course {
            Course::Board(plank) => build::board_body(self.surface, plank),
            Course::Log(trace) => {
                build::body(self.surface, trace, station_at(trace, self.place, at))
            }
        };
        let body = body.ok_or(StemError::NoStem {
            shells: self.parts.shells.len(),
        })?;
        let length = body.axis.length();
        let asked = match (self.place, at) {
            (Place::Fraction(x), _) => x * length,
            (Place::Length(x), _) => *x,
            (Place::Point(p), _) => body.axis.length_at(at.unwrap_or(*p)),
        };
        let tube = Tube::new(&body);
        let zones = self.zones(&body, &tube, held);
        let free = free_ranges(&body, &zones);
        let inside = |r: &&(f64, f64)| asked >= r.0 && asked <= r.1;
        let Some(&usable) = free.iter().find(inside) else {
            return Err(self.refusal(&body, &zones, &free, asked));
        };
        let limit = 0.5 * body.radius(asked);
        let Some(section) = build::section_at(self.surface, &body.axis, asked, limit) else {
            return Err(self.refusal(&body, &zones, &free, asked));
        };
        let mut notes = Vec::new();
        let stem = self.assemble(&body, usable, &zones, section, &mut notes);
        let margin = 2.0 * MARGIN * stem.radius;
        for zone in &zones {
            let gap = (zone.range.0 - usable.1).max(usable.0 - zone.range.1);
            if gap < margin {
                let (a, b) = zone.range;
                notes.push(format!(
                    "the break stays clear of {a:.3} to {b:.3} m, where {}",
                    zone.why
                ));
            }
        }
        let frame = stem.grain.axis().frame(asked);
        let under = super::trace::section(self.surface, frame.origin, frame.tangent, limit)
            .map_or(Vec::new(), |c| c.triangles);
        let limb = tube.limb(self.surface, (usable.0 - margin, usable.1 + margin), &under);
        let shell = &self.parts.shells[self.cut];
        Ok(Found {
            node: shell.node,
            shell: shell.triangles.clone(),
            limb,
            stem,
            carried: Vec::new(),
            notes,
        })
    }

    fn assemble(
        &self,
        body: &Body,
        usable: (f64, f64),
        zones: &[Zone],
        section: Section,
        notes: &mut Vec<String>,
    ) -> Stem {
        let place = section.length;
        let length = body.axis.length();
        let radius = (section.area / std::f64::consts::PI).sqrt();
        let run = body
            .free()
            .into_iter()
            .find(|r| place >= r.0 && place <= r.1)
            .unwrap_or((0.0, length));
        let taper = build::taper(body, run, place, section.area);
        let grain = GrainSpace::new(body.axis.clone(), taper);
        let mut sections: Vec<Section> = body
            .stations
            .iter()
            .filter_map(|(_, s)| s.clone())
            .filter(|s| s.length != place)
            .collect();
        let pith = self.pith(body, &grain, &section, notes);
        let k = sections.partition_point(|s| s.length < place);
        sections.insert(k, section.clone());
        let reach = |s: &Section| {
            let scale = grain.scale(s.length);
            s.contour
                .iter()
                .map(|p| (*p / scale).distance(pith))
                .fold(0.0, f64::max)
        };
        let extent = sections
            .iter()
            .filter(|s| s.length >= usable.0 && s.length <= usable.1)
            .map(reach)
            .fold(0.0, f64::max)
            * 1.05;
        let holds = polygon::contains(&section.contour, pith);
        let rings = if body.kind == StemKind::Round && holds {
            RingField::round(&section.contour, pith, extent)
        } else {
            if body.kind == StemKind::Round {
                notes.push("the pith lies outside the section: rings are arcs about it".to_owned());
            }
            RingField::arcs(pith, reach(&section), extent)
        };
        let ends = (
            reaches_end(body, zones, usable.0, 0),
            reaches_end(body, zones, usable.1, 1),
        );
        Stem {
            grain,
            kind: body.kind,
            sections,
            place,
            usable,
            rings,
            radius,
            ends,
            length,
        }
    }

    /// The pith in the section of the break, m.
    fn pith(
        &self,
        body: &Body,
        grain: &GrainSpace,
        section: &Section,
        notes: &mut Vec<String>,
    ) -> DVec2 {
        match (self.options.pith, body.kind) {
            (Some(PithChoice::Section(p)), _) => p,
            (Some(PithChoice::World(p)), _) => grain.to_grain(p).truncate(),
            (None, StemKind::Round) => {
                let pith = likely_pith(&section.contour);
                let off = (pith - section.centroid).length() * 1e3;
                notes.push(format!(
                    "the pith was estimated, {off:.1} mm from the section's centroid"
                ));
                pith
            }
            (None, StemKind::Board) => {
                // Flat-sawn: the wide faces are tangential to the rings. x is the wide direction.
                let down = 0.75 * body.width;
                notes.push(format!(
                    "the pith was taken to lie {:.0} mm below the middle of the wide face (flat-sawn)",
                    down * 1e3
                ));
                DVec2::new(0.0, -down)
            }
        }
    }

    /// Shells that move with the upper piece.
    fn carried(&self, found: &Found, carriers: &[(usize, Surface)]) -> Vec<(usize, Vec<u32>)> {
        let shells = &self.parts.shells;
        if shells.len() < 2 {
            return Vec::new();
        }
        let hangings: Vec<Option<Hanging>> = (0..shells.len())
            .map(|i| {
                if i == self.cut {
                    return None;
                }
                attach::hangs_on(&self.parts.points[shells[i].node], shells, i, carriers)
            })
            .collect();
        let shell = &shells[self.cut];
        let points = &self.parts.points[shell.node];
        let frame = found.stem.grain.axis().frame(found.stem.place);
        let limit = found.stem.radius;
        let barrier = super::trace::section(self.surface, frame.origin, frame.tangent, limit)
            .map_or(Vec::new(), |c| c.triangles);
        let mut sides = attach::upper_side(points, shell, &barrier, frame.origin, frame.tangent);
        let mut beyond = |at: DVec3| {
            let high = (at - frame.origin).dot(frame.tangent) > 0.0;
            let (Some(sides), Some((t, _))) = (&mut sides, self.surface.nearest(at)) else {
                return high;
            };
            if barrier.contains(&t) {
                return high;
            }
            sides(points.triangles[t as usize][0])
        };
        let mut carried = Vec::new();
        for (i, shell) in shells.iter().enumerate() {
            // Follow what it hangs on down to the cut shell; a ring of shells holding each other ends the walk.
            let mut at = i;
            let mut moves = false;
            for _ in 0..shells.len() {
                let Some(hanging) = hangings[at] else { break };
                if hanging.on == self.cut {
                    moves = beyond(hanging.at);
                    break;
                }
                at = hanging.on;
            }
            if moves && i != self.cut {
                carried.push((shell.node, shell.triangles.clone()));
            }
        }
        carried
    }
}
