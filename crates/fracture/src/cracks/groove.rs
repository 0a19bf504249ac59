//! Grooves: strips of the section along the cracks' courses, sunk into the heights of a surface.
//!
//! A strip's lines (both flanks, the bottom in the middle, lines across) are drawn into the surface's triangulation.
//! Then every node is lowered by the depth of the strip there. The depth depends on the place alone, so facets that
//! agreed on an edge still agree to the last bit, steps keep their heights, and the surface stays a height field: in
//! grain space no wall of a groove can cross anything. In the world the chords of a bent stem's facets stray from their
//! places there, so walls of narrow grooves may cross. Where grooves overlap, the deeper one counts at each node.

use super::end_face::EndFace;
use super::error::CrackError;
use super::plan::{CrackPlan, PlannedCrack};
use super::profile::{relative_depth, relative_opening};
use super::refine::Refined;
use crate::surface::{FractureSurface, SectionLayout};
use glam::DVec2;
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::rings::RingField;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The direction in which grooves run from the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// To smaller lengths: the piece below the face cracks.
    Down,
    /// To greater lengths: the piece above the face cracks.
    Up,
}

/// The stem that grooves are made in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrackSite {
    /// Radius of the stem, m.
    pub radius: f64,
    /// Lengths along the axis that grooves must keep within, m.
    pub usable: (f64, f64),
    /// Height (m) along the grain after which the walls of a groove are split, so that they can follow a bent stem;
    /// infinite for a straight one.
    pub level: f64,
}

/// A surface with grooves.
#[derive(Debug, Clone)]
pub struct GroovedSurface {
    /// The surface. Nodes of the surface it was made from keep their numbers; new ones follow them.
    pub surface: FractureSurface,
    /// Number of the first node that is new.
    pub first_node: usize,
    /// Cells from this number on are walls of grooves, two for each crack of the plan in its order: right of its
    /// course, then left of it.
    pub first_cell: u32,
    /// Number of cracks made.
    pub cracks: usize,
    /// Number of cracks that would not open visibly: without shrinkage, or too short.
    pub closed: usize,
    /// Number of cracks outside the section.
    pub outside: usize,
    /// Number of cracks left out because the face's facets are too thin or folded where they run.
    pub undrawn: usize,
    /// Number of corners of facets whose depth was limited to the usable length.
    pub limited: usize,
    /// Greatest depth below (or above) the face, m.
    pub deepest: f64,
    /// Widest opening at the face, m.
    pub widest: f64,
}

/// Lines closer than this part of the radius to a node run through it.
const SNAP_DISTANCE: f64 = 1e-7;
/// Rows of a strip narrower than this part of the radius are left out; only its tips are narrower.
const MIN_ROW_WIDTH: f64 = 2e-4;
/// Openings narrower than this part of the radius are not made.
const MIN_OPENING: f64 = 4e-4;
/// Greatest number of strips of a wall.
const MAX_WALL_STRIPS: usize = 12;
/// Parts of the way from the outline to the layout's border at which an open crack ends and has run out.
const END_BEYOND: [f64; 2] = [0.55, 0.85];
/// Share of the free length within which depths stay as they are.
const UNLIMITED_SHARE: f64 = 0.75;
/// Share of the free length that depths never exceed.
const MAX_SHARE: f64 = 0.97;

/// A strip: points across the groove, row by row along its course, with the depth of each.
struct Strip {
    rows: Vec<Vec<(DVec2, f64)>>,
    /// Low and high corner of the box around it, m.
    bounds: (DVec2, DVec2),
}

/// A crack whose lines are drawn into the surface.
struct DrawnCrack {
    /// Its number in the plan.
    number: usize,
    strip: Strip,
    /// Depth of the nodes on its lines, m.
    exact: FxHashMap<u32, f64>,
}

/// Sinks the cracks of `plan` into a break surface. For the piece below the face give [`Direction::Down`], for the one
/// above [`Direction::Up`], and cut once with each.
///
/// # Errors
/// [`CrackError`] where the stem makes no sense, or the caller cancelled.
pub fn grooves(
    plan: &CrackPlan,
    field: &RingField,
    surface: &FractureSurface,
    direction: Direction,
    site: &CrackSite,
    context: &Context,
) -> Result<GroovedSurface, CrackError> {
    sink(plan, field, surface, (direction, 0.0), site, context)
}

/// A surface that lies beyond the end of a stem but for the grooves of its cracks. Cutting along it leaves the stem
/// with cracks below it (above it for the near end), and chips to throw away on its other side.
///
/// # Errors
/// As [`grooves`].
pub fn end_grooves(
    plan: &CrackPlan,
    field: &RingField,
    layout: &Arc<SectionLayout>,
    end: &EndFace,
    site: &CrackSite,
    context: &Context,
) -> Result<GroovedSurface, CrackError> {
    let (direction, beyond) = if end.far {
        (Direction::Down, end.clearance)
    } else {
        (Direction::Up, -end.clearance)
    };
    let heights: Vec<f64> = layout.nodes.iter().map(|&p| end.at(p) + beyond).collect();
    let surface = FractureSurface {
        layout: layout.clone(),
        heights: layout
            .facets
            .iter()
            .map(|f| f.map(|n| heights[n as usize]))
            .collect(),
    };
    let clearance = end.clearance;
    sink(plan, field, &surface, (direction, clearance), site, context)
}

fn sink(
    plan: &CrackPlan,
    field: &RingField,
    surface: &FractureSurface,
    (direction, clearance): (Direction, f64),
    site: &CrackSite,
    context: &Context,
) -> Result<GroovedSurface, CrackError> {
    let (low, high) = site.usable;
    if !(site.radius > 0.0 && site.radius.is_finite() && low < high && site.level > 0.0) {
        return Err(CrackError::Stem {
            radius: site.radius,
            low,
            high,
        });
    }
    let mut grooved = GroovedSurface {
        surface: FractureSurface::default(),
        first_node: surface.layout.nodes.len(),
        first_cell: surface.layout.cells.iter().max().map_or(0, |c| c + 1),
        cracks: 0,
        closed: 0,
        outside: 0,
        undrawn: 0,
        limited: 0,
        deepest: 0.0,
        widest: 0.0,
    };
    let mut refined = Refined::new(surface, SNAP_DISTANCE * site.radius);
    let mut drawn: Vec<DrawnCrack> = Vec::new();
    for (number, crack) in plan.cracks.iter().enumerate() {
        context.check()?;
        let widest = widest(crack, field, site.radius);
        if widest < MIN_OPENING * site.radius || crack.depth <= 0.0 {
            grooved.closed += 1;
            continue;
        }
        let Some(strip) = strip(crack, field, site, clearance, &mut refined) else {
            grooved.outside += 1;
            continue;
        };
        let Some(exact) = draw(&strip, &mut refined) else {
            grooved.undrawn += 1;
            continue;
        };
        drawn.push(DrawnCrack {
            number,
            strip,
            exact,
        });
        grooved.cracks += 1;
        grooved.widest = grooved.widest.max(widest);
    }
    lower(&mut refined, &drawn, direction, site, &mut grooved, context)?;
    grooved.deepest = (grooved.deepest - clearance).max(0.0);
    grooved.surface = refined.finish();
    Ok(grooved)
}

fn widest(crack: &PlannedCrack, field: &RingField, radius: f64) -> f64 {
    crack
        .course
        .iter()
        .zip(&crack.fractions)
        .map(|(&(rho, phi), &t)| {
            let r = field.point(rho, phi).distance(field.pith()) / radius;
            crack.width(t, r) * radius
        })
        .fold(0.0, f64::max)
}

/// The strip of a crack; `None` where its place is beyond the layout.
fn strip(
    crack: &PlannedCrack,
    field: &RingField,
    site: &CrackSite,
    clearance: f64,
    refined: &mut Refined,
) -> Option<Strip> {
    let radius = site.radius;
    // Part of the course, point of it, and factor on opening and depth.
    let mut course: Vec<(f64, DVec2, f64)> = crack
        .course
        .iter()
        .zip(&crack.fractions)
        .map(|(&(rho, phi), &t)| (t, field.point(rho, phi), 1.0))
        .collect();
    let most = crack.depth * radius + clearance;
    let parts = ((most / site.level).ceil() as usize).clamp(1, MAX_WALL_STRIPS);
    let &(rho, phi) = crack.course.last()?;
    let mut reach = border(field, phi, rho, refined)? - rho;
    for _ in 0..8 {
        if crack.open_at_bark {
            course.truncate(crack.course.len());
            for (i, beyond) in END_BEYOND.iter().enumerate() {
                let p = field.point(rho + beyond * reach, phi);
                course.push((1.0, p, 1.0 - i as f64));
            }
        }
        let strip = rows(crack, field, &course, (radius, clearance, parts));
        if strip.rows.iter().flatten().all(|p| refined.holds(p.0)) {
            return Some(strip);
        }
        if !crack.open_at_bark {
            return None;
        }
        reach *= 0.9;
    }
    None
}

/// The greatest ring coordinate at an angle that the layout holds, from `rho` on.
fn border(field: &RingField, phi: f64, rho: f64, refined: &mut Refined) -> Option<f64> {
    let mut holds = |r: f64| refined.holds(field.point(r, phi));
    if !holds(rho) {
        return None;
    }
    let (mut inside, mut outside) = (rho, rho + 0.01);
    while holds(outside) {
        inside = outside;
        outside = rho + 2.0 * (outside - rho);
    }
    for _ in 0..30 {
        let middle = (inside + outside) / 2.0;
        if holds(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Some(inside)
}

fn rows(
    crack: &PlannedCrack,
    field: &RingField,
    course: &[(f64, DVec2, f64)],
    (radius, clearance, parts): (f64, f64, usize),
) -> Strip {
    let last = course.len() - 1;
    let mut bounds = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let rows = course
        .iter()
        .enumerate()
        .map(|(i, &(t, p, factor))| {
            let ahead = course[(i + 1).min(last)].1 - course[i.saturating_sub(1)].1;
            let left = ahead.perp().normalize_or_zero();
            let r = p.distance(field.pith()) / radius;
            let half = 0.5 * crack.width(t, r) * radius * factor;
            let face = crack.depth
                * radius
                * relative_depth(relative_opening(t, crack.open_at_bark))
                * factor;
            // Beyond an end face the walls go on as they are, so that the opening is right at the face.
            let (half, deep) = if face > 0.0 && half > 0.0 {
                (half * (face + clearance) / face, face + clearance)
            } else {
                (0.0, 0.0)
            };
            let n = parts as i64;
            (-n..=n)
                .map(|k| {
                    let off = k as f64 / parts as f64;
                    let point = p + left * (half * off);
                    bounds = (bounds.0.min(point), bounds.1.max(point));
                    (point, deep * (1.0 - off.abs()))
                })
                .collect()
        })
        .collect();
    let rows: Vec<Vec<(DVec2, f64)>> = rows;
    let wide = |i: usize, row: &[(DVec2, f64)]| {
        i == 0 || i == last || row[0].0.distance(row[parts].0) > MIN_ROW_WIDTH * radius
    };
    let rows = rows
        .into_iter()
        .enumerate()
        .filter(|(i, row)| wide(*i, row))
        .map(|(_, row)| row)
        .collect();
    Strip { rows, bounds }
}

/// Draws the strip's lines; the depths of the nodes on them. `None` where facets are folded or too thin for it.
fn draw(strip: &Strip, refined: &mut Refined) -> Option<FxHashMap<u32, f64>> {
    let mut ids: Vec<Vec<u32>> = Vec::with_capacity(strip.rows.len());
    for row in &strip.rows {
        let mut line = Vec::with_capacity(row.len());
        for &(p, _) in row {
            line.push(refined.point(p)?);
        }
        ids.push(line);
    }
    let mut exact: FxHashMap<u32, f64> = FxHashMap::default();
    let mut run = |refined: &mut Refined, from: (u32, f64), to: (u32, f64)| {
        if from.0 == to.0 {
            return Some(());
        }
        let path = refined.line(from.0, to.0)?;
        let (a, b) = (refined.nodes[from.0 as usize], refined.nodes[to.0 as usize]);
        for n in path {
            let t = (refined.nodes[n as usize] - a).dot(b - a) / (b - a).length_squared();
            let deep = from.1 + (to.1 - from.1) * t.clamp(0.0, 1.0);
            let known = exact.entry(n).or_insert(deep);
            *known = known.min(deep);
        }
        Some(())
    };
    let columns = strip.rows[0].len();
    // Flanks first: what they pass keeps the level of the face.
    let order = (0..columns).map(|k| {
        if k % 2 == 0 {
            k / 2
        } else {
            columns - 1 - k / 2
        }
    });
    for k in order {
        for i in 1..ids.len() {
            let end = |i: usize| (ids[i][k], strip.rows[i][k].1);
            run(refined, end(i - 1), end(i))?;
        }
    }
    for (line, row) in ids.iter().zip(&strip.rows) {
        for k in 1..columns {
            run(refined, (line[k - 1], row[k - 1].1), (line[k], row[k].1))?;
        }
    }
    Some(exact)
}

impl Strip {
    /// Depth at a point (m, 0 outside) and whether it is left of the course.
    fn depth(&self, p: DVec2) -> (f64, bool) {
        let mut best = (0.0, false);
        if p.cmplt(self.bounds.0).any() || p.cmpgt(self.bounds.1).any() {
            return best;
        }
        for pair in self.rows.windows(2) {
            let (low, high) = pair
                .iter()
                .flat_map(|row| [row[0].0, row[row.len() / 2].0, row[row.len() - 1].0])
                .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), q| {
                    (l.min(q), h.max(q))
                });
            if p.cmplt(low).any() || p.cmpgt(high).any() {
                continue;
            }
            for k in 1..pair[0].len() {
                let [a, b] = [pair[0][k - 1], pair[0][k]];
                let [c, d] = [pair[1][k - 1], pair[1][k]];
                for t in [[a, c, d], [a, d, b]] {
                    if let Some(deep) = within(t, p)
                        && deep > best.0
                    {
                        best = (deep, k > pair[0].len() / 2);
                    }
                }
            }
        }
        best
    }
}

fn within([a, b, c]: [(DVec2, f64); 3], p: DVec2) -> Option<f64> {
    let area = (b.0 - a.0).perp_dot(c.0 - a.0);
    let u = (b.0 - p).perp_dot(c.0 - p) / area;
    let v = (c.0 - p).perp_dot(a.0 - p) / area;
    let w = 1.0 - u - v;
    (u >= 0.0 && v >= 0.0 && w >= 0.0).then_some(a.1 * u + b.1 * v + c.1 * w)
}

/// Points in order of their first coordinate, to find those about a strip.
struct SortedPoints {
    /// Number and place of each.
    points: Vec<(u32, DVec2)>,
}

impl SortedPoints {
    fn new(points: impl Iterator<Item = (u32, DVec2)>) -> Self {
        let mut points: Vec<(u32, DVec2)> = points.collect();
        points.sort_unstable_by(|a, b| a.1.x.total_cmp(&b.1.x));
        SortedPoints { points }
    }

    /// Those that may lie in a strip.
    fn about(&self, strip: &Strip) -> &[(u32, DVec2)] {
        let from = self.points.partition_point(|p| p.1.x < strip.bounds.0.x);
        let to = self.points.partition_point(|p| p.1.x <= strip.bounds.1.x);
        self.points.get(from..to).unwrap_or_default()
    }
}

/// Depth of the deepest crack at every node, m.
fn depths(
    refined: &Refined,
    drawn: &[DrawnCrack],
    context: &Context,
) -> Result<Vec<f64>, Cancelled> {
    let mut depths = vec![0.0_f64; refined.nodes.len()];
    let nodes = SortedPoints::new((0..).zip(refined.nodes.iter().copied()));
    for crack in drawn {
        context.check()?;
        for (&n, &deep) in &crack.exact {
            let known = &mut depths[n as usize];
            *known = known.max(deep);
        }
        for &(n, p) in nodes.about(&crack.strip) {
            if !crack.exact.contains_key(&n) {
                let known = &mut depths[n as usize];
                *known = known.max(crack.strip.depth(p).0);
            }
        }
    }
    Ok(depths)
}

/// Lowers (or lifts) the corners of all facets.
fn lower(
    refined: &mut Refined,
    drawn: &[DrawnCrack],
    direction: Direction,
    site: &CrackSite,
    grooved: &mut GroovedSurface,
    context: &Context,
) -> Result<(), Cancelled> {
    let depths = depths(refined, drawn, context)?;
    let mut centres = Vec::new();
    for f in 0..refined.facets.len() {
        let facet = refined.facets[f];
        if facet.iter().all(|&n| depths[n as usize] == 0.0) {
            continue;
        }
        for (k, n) in facet.into_iter().enumerate() {
            let wanted = depths[n as usize];
            let h = refined.heights[f][k];
            let free = match direction {
                Direction::Down => h - site.usable.0,
                Direction::Up => site.usable.1 - h,
            }
            .max(0.0);
            let over = wanted - UNLIMITED_SHARE * free;
            let deep = if over > 0.0 {
                grooved.limited += 1;
                let clearance = (MAX_SHARE - UNLIMITED_SHARE) * free;
                UNLIMITED_SHARE * free + clearance * over / (over + clearance)
            } else {
                wanted
            };
            grooved.deepest = grooved.deepest.max(deep);
            refined.heights[f][k] = match direction {
                Direction::Down => h - deep,
                Direction::Up => h + deep,
            };
        }
        let corners = facet.map(|n| refined.nodes[n as usize]);
        centres.push((f as u32, corners.into_iter().sum::<DVec2>() / 3.0));
    }
    // Each facet in a crack belongs to the deepest one there.
    let centres = SortedPoints::new(centres.into_iter());
    let mut deepest = vec![0.0; refined.facets.len()];
    for crack in drawn {
        context.check()?;
        for &(f, centre) in centres.about(&crack.strip) {
            let (deep, left) = crack.strip.depth(centre);
            let known = &mut deepest[f as usize];
            if deep > 0.0 && deep >= *known {
                *known = deep;
                refined.cells[f as usize] =
                    grooved.first_cell + 2 * crack.number as u32 + u32::from(left);
            }
        }
    }
    Ok(())
}
