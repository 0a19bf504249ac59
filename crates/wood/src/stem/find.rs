//! Finding the stem at a place: which shell, which limb of it, and what moves with the upper piece.

use super::attach::{self, Hanging, Tube};
use super::build::{self, Body, MARGIN, Section, Stem, StemKind, Stretch};
use super::error::StemError;
use super::polygon;
use super::rings::{RingField, likely_pith};
use super::seed::{self, Plank};
use super::shells::{self, Points, Shell};
use super::surface::Surface;
use super::trace::{Trace, trace};
use super::{GrainSpace, Place};
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
/// Shells tried as the main stem before giving up.
const TRIED: usize = 40;
/// Of those with a stem, so many are compared by volume.
const COMPARED: usize = 6;

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

/// The scene taken apart.
struct Parts {
    points: Vec<Points>,
    shells: Vec<Shell>,
    /// Indices of the shells, largest first.
    order: Vec<usize>,
}

impl Parts {
    fn surface(&self, shell: usize) -> Surface<'_> {
        Surface::new(&self.points[self.shells[shell].node], &self.shells[shell])
    }
}

fn attempt(
    meshes: &[Mesh],
    place: &Place,
    options: &StemOptions,
    context: &Context,
    tolerance: f64,
) -> Result<Found, StemError> {
    context.step("stem", 0.0)?;
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
    context.step("stem", 0.2)?;
    let (cut, mut followed, at) = match place {
        Place::Point(p) => at_point(&parts, *p, place, options.kind)?,
        _ => main_stem(&parts, options.kind, context)?,
    };
    context.step("stem", 0.5)?;
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
    context.step("stem", 0.8)?;
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
    context.step("stem", 1.0)?;
    Ok(found)
}

/// What a shell was followed as.
enum Course {
    Log(Trace),
    Board(Plank),
}

/// A shell's main stem: a board where it is one or is said to be one, else a log; with its volume, m³.
fn course(surface: &Surface, kind: Option<StemKind>) -> Option<(Course, f64)> {
    if kind != Some(StemKind::Round) {
        let plank = seed::plank(surface);
        let board = |p: &Plank| kind == Some(StemKind::Board) || seed::is_board(surface, p);
        if let Some(plank) = plank.filter(board) {
            return Some((Course::Board(plank), plank.size.iter().product()));
        }
    }
    let trace = seed::main_stem(surface)?;
    let volume = trace.volume();
    Some((Course::Log(trace), volume))
}

/// The shell with the thickest stem, its course, and no point.
fn main_stem(
    parts: &Parts,
    kind: Option<StemKind>,
    context: &Context,
) -> Result<(usize, Course, Option<DVec3>), StemError> {
    let mut best: Option<(f64, usize, Course)> = None;
    let mut compared = 0;
    for &i in parts.order.iter().take(TRIED) {
        context.step("stem", 0.2)?;
        if parts.shells[i].triangles.len() < 6 {
            continue;
        }
        let Some((course, volume)) = course(&parts.surface(i), kind) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| volume > b.0) {
            best = Some((volume, i, course));
        }
        compared += 1;
        if compared >= COMPARED {
            break;
        }
    }
    best.map(|(_, i, course)| (i, course, None))
        .ok_or(StemError::NoStem {
            shells: parts.shells.len(),
        })
}

/// The shell nearest to a point, the limb of it there, and the nearest point on it.
fn at_point(
    parts: &Parts,
    p: DVec3,
    place: &Place,
    kind: Option<StemKind>,
) -> Result<(usize, Course, Option<DVec3>), StemError> {
    let mut best: Option<(f64, usize, DVec3)> = None;
    for (i, shell) in parts.shells.iter().enumerate() {
        let bound = (shell.low - p)
            .max(p - shell.high)
            .max(DVec3::ZERO)
            .length();
        if best.is_some_and(|b| bound >= b.0) {
            continue;
        }
        let points = &parts.points[shell.node];
        for &t in &shell.triangles {
            let corners = points.triangles[t as usize].map(|c| points.positions[c as usize]);
            let q = super::surface::nearest_on_triangle(corners, p);
            let d = q.distance(p);
            if best.is_none_or(|b| d < b.0) {
                best = Some((d, i, q));
            }
        }
    }
    let Some((distance, i, q)) = best else {
        return Err(StemError::Empty);
    };
    let surface = parts.surface(i);
    let trace = match course(&surface, kind) {
        Some((Course::Board(plank), _)) => {
            let far = 1.5 * plank.size[1];
            if distance > far {
                let nearest = Place::Point(q);
                return Err(StemError::FarFromWood {
                    asked: *place,
                    distance,
                    nearest,
                });
            }
            return Ok((i, Course::Board(plank), Some(q)));
        }
        Some((Course::Log(trace), _)) if covers(&trace, q) => Some(trace),
        _ => seed::at_point(&surface, q).map(|cut| trace(&surface, cut, false)),
    };
    let Some(trace) = trace else {
        return Err(StemError::NowhereFree {
            asked: *place,
            found: "the nearest part of the model has no section that is one closed loop"
                .to_owned(),
        });
    };
    // Three radii of air around the wood are taken for a hand that was not quite steady.
    let radius = trace.cuts[nearest_station(&trace, q)].radius;
    let inside = surface.holds(p);
    if distance > 3.0 * radius && !inside {
        return Err(StemError::FarFromWood {
            asked: *place,
            distance,
            nearest: Place::Point(q),
        });
    }
    Ok((i, Course::Log(trace), Some(q)))
}

fn nearest_station(trace: &Trace, p: DVec3) -> usize {
    (0..trace.cuts.len())
        .min_by(|&a, &b| {
            let d = |i: usize| trace.cuts[i].centre.distance_squared(p);
            d(a).total_cmp(&d(b))
        })
        .unwrap_or(0)
}

/// The station of a trace that is about at the place.
fn station_at(trace: &Trace, place: &Place, point: Option<DVec3>) -> usize {
    let station = match (place, point) {
        (_, Some(p)) => nearest_station(trace, p),
        (Place::Point(p), None) => nearest_station(trace, *p),
        (Place::Fraction(x), _) => (x.clamp(0.0, 1.0) * trace.cuts.len() as f64) as usize,
        (Place::Length(x), _) => {
            let mut left = *x;
            let steps = trace
                .cuts
                .windows(2)
                .map(|w| w[0].centre.distance(w[1].centre));
            steps
                .take_while(|step| {
                    left -= step;
                    left > 0.0
                })
                .count()
        }
    };
    station.min(trace.cuts.len() - 1)
}

/// Whether a surface point belongs to the trace rather than to another limb of the shell.
fn covers(trace: &Trace, q: DVec3) -> bool {
    let cut = &trace.cuts[nearest_station(trace, q)];
    let d = q - cut.centre;
    let across = d.reject_from(cut.normal).length();
    across < 1.3 * cut.reach && d.dot(cut.normal).abs() < 1.2 * cut.reach
}

/// Whether the base is at the trace's last station.
fn turned_over(course: &Course, tips: [DVec3; 2], held: [Option<usize>; 2]) -> bool {
    match held {
        [Some(_), None] => return false,
        [None, Some(_)] => return true,
        _ => {}
    }
    if let Course::Log(trace) = course {
        let areas: Vec<f64> = (0..trace.cuts.len())
            .filter(|&i| trace.states[i] == super::trace::State::Good)
            .map(|i| trace.cuts[i].area)
            .collect();
        let part = (areas.len() / 5).max(1).min(areas.len());
        let mean = |a: &[f64]| a.iter().sum::<f64>() / a.len().max(1) as f64;
        let (first, last) = (mean(&areas[..part]), mean(&areas[areas.len() - part..]));
        // Closer than this the ends are equally thick: noise must not decide.
        if (first - last).abs() > 0.05 * (first + last) {
            return last > first;
        }
    }
    let [a, b] = tips;
    let length = a.distance(b);
    for k in [1, 0, 2] {
        if (a[k] - b[k]).abs() > 1e-6 * length {
            return b[k] < a[k];
        }
    }
    false
}

/// One search after shell and limb are known.
struct Search<'a> {
    parts: &'a Parts,
    cut: usize,
    surface: &'a Surface<'a>,
    place: &'a Place,
    options: &'a StemOptions,
}

/// Why part of the axis is not free.
struct Zone {
    range: (f64, f64),
    why: String,
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

    /// Where other shells come inside the stem.
    fn zones(&self, body: &Body, tube: &Tube, held: [Option<usize>; 2]) -> Vec<Zone> {
        let mut zones = Vec::new();
        for (i, shell) in self.parts.shells.iter().enumerate() {
            if i == self.cut {
                continue;
            }
            let mut ranges = tube.touched_by(&self.parts.points[shell.node], shell);
            // What lies deeper than where the stem comes out of the wood that holds it is hidden.
            if held[0] == Some(i)
                && let Some(first) = ranges.first_mut()
            {
                first.0 = 0.0;
            }
            if held[1] == Some(i)
                && let Some(last) = ranges.last_mut()
            {
                last.1 = body.axis.length();
            }
            for range in ranges {
                let why = if held.contains(&Some(i)) {
                    "it grows out of other wood".to_owned()
                } else {
                    format!(
                        "another part of {} triangles is stuck in it",
                        shell.triangles.len()
                    )
                };
                zones.push(Zone { range, why });
            }
        }
        zones.sort_by(|a, b| {
            a.range
                .0
                .total_cmp(&b.range.0)
                .then(a.range.1.total_cmp(&b.range.1))
        });
        zones
    }

    /// The refusal of the place at `asked` (m), with the nearest that works.
    fn refusal(&self, body: &Body, zones: &[Zone], free: &[(f64, f64)], asked: f64) -> StemError {
        let length = body.axis.length();
        let margin = MARGIN * body.radius(asked);
        let zone = zones
            .iter()
            .find(|z| asked >= z.range.0 - margin && asked <= z.range.1 + margin);
        let lengths = body.axis.lengths();
        let k = lengths
            .partition_point(|&l| l < asked)
            .min(lengths.len() - 1);
        let states = [body.stations[k.saturating_sub(1)].0, body.stations[k].0];
        let found = if let Some(zone) = zone {
            zone.why.clone()
        } else if states.contains(&Stretch::Fork) {
            "the stem forks".to_owned()
        } else if states.contains(&Stretch::Broken) {
            "the section is not one plain closed loop (a fork, a hole or a gap)".to_owned()
        } else {
            "the stem ends".to_owned()
        };
        let nearest = free
            .iter()
            .map(|r| {
                let inset = 0.05 * (r.1 - r.0);
                asked.clamp(r.0 + inset, r.1 - inset)
            })
            .min_by(|a, b| (a - asked).abs().total_cmp(&(b - asked).abs()));
        let Some(s) = nearest else {
            return StemError::NowhereFree {
                asked: *self.place,
                found,
            };
        };
        let nearest = match self.place {
            Place::Fraction(_) => Place::Fraction(s / length),
            Place::Length(_) => Place::Length(s),
            Place::Point(p) => {
                let frame = body.axis.frame(s);
                let outline = build::section_at(self.surface, &body.axis, s, f64::INFINITY);
                let world = |q: &DVec2| frame.origin + frame.x * q.x + frame.y * q.y;
                let points = outline.map_or(Vec::new(), |o| o.contour);
                let side = points
                    .iter()
                    .map(world)
                    .min_by(|a, b| a.distance_squared(*p).total_cmp(&b.distance_squared(*p)));
                Place::Point(side.unwrap_or(frame.origin))
            }
        };
        let point = matches!(self.place, Place::Point(_));
        if !point && (asked < 0.0 || asked > length * (1.0 + 1e-9)) {
            return StemError::OffStem {
                asked: *self.place,
                length,
                nearest,
            };
        }
        StemError::Unusable {
            asked: *self.place,
            found,
            nearest,
        }
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

/// Whether between the limit `s` (m) of the usable range and the axis's end on that side there is nothing but the
/// stem's own end.
fn reaches_end(body: &Body, zones: &[Zone], s: f64, side: usize) -> bool {
    let beyond = |at: f64| if side == 0 { at < s } else { at > s };
    let plain = |state: Stretch| matches!(state, Stretch::Free | Stretch::End);
    let lengths = body.axis.lengths();
    body.ends[side] == super::trace::End::Real
        && !zones.iter().any(|z| beyond(z.range.0) || beyond(z.range.1))
        && lengths
            .iter()
            .zip(&body.stations)
            .all(|(&l, (state, _))| !beyond(l) || plain(*state))
}

/// Ranges (m) free for a break: free stretches of the axis without the zones, less a margin.
fn free_ranges(body: &Body, zones: &[Zone]) -> Vec<(f64, f64)> {
    let mut free = Vec::new();
    let blocked = attach::merged(zones.iter().map(|z| z.range).collect(), 0.0);
    for run in body.free() {
        let mut start = run.0;
        for zone in blocked.iter().chain([&(run.1, run.1)]) {
            if zone.1 < start {
                continue;
            }
            let end = zone.0.min(run.1);
            let (a, b) = (
                start + MARGIN * body.radius(start),
                end - MARGIN * body.radius(end),
            );
            if b > a {
                free.push((a, b));
            }
            start = start.max(zone.1);
            if start >= run.1 {
                break;
            }
        }
    }
    free
}
