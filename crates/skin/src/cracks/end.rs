//! Cracks in an end of a stem. An end that is no cut face itself, as that of most scans, which is torn or slanted, and of
//! limbs, which is a tip, is sawn off straight first.

use super::face::{cut_along, fit_to_section};
use crate::broken::InnerWood;
use crate::error::BreakError;
use crate::prepared::PreparedStem;
use glam::{DVec2, DVec3};
use greenstick_fracture::cracks::{
    CrackError, CrackPlan, CrackSite, Direction, EndFace, GroovedSurface, end_grooves, grooves,
};
use greenstick_fracture::layout::{FibreBundle, FibreBundles};
use greenstick_fracture::parameters::BreakParameters;
use greenstick_fracture::surface::{FractureSurface, NONE, SectionLayout};
use greenstick_geometry::{Cancelled, Context, Mesh, mesh::NO_MATERIAL};
use greenstick_wood::noise;
use greenstick_wood::stem::{
    CarriedShell, CrossSection, StemError, StemLocation, StemOptions, find_stem,
};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::sync::Arc;

/// A stem with cracks in one of its ends.
#[derive(Debug, Clone)]
pub struct CrackedEnd {
    /// The stem, in the coordinates of the node.
    pub mesh: Mesh,
    /// The end that was found.
    pub end: EndFace,
    /// The surface that was cut along, what was made and what was limited.
    pub grooves: GroovedSurface,
    /// Volume of the cracks, in cubic units of the node's coordinates.
    pub void: f64,
}

/// Where a cracked end lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndOfStem {
    /// Its middle, m.
    pub middle: DVec3,
    /// The direction that it faces.
    pub outward: DVec3,
    /// Greatest distance of the section's outline from the middle, m.
    pub radius: f64,
}

/// Rings of triangles about the middle of a sawn end's layout. The end is level, so few are enough.
const END_RINGS: i32 = 6;
/// How much farther than the skin the layout reaches.
const END_MARGIN: f64 = 1.06;
/// Displacement of the layout's inner nodes, as a share of the distance between them.
const END_JITTER: f64 = 0.4;
/// How near the cracks of an end come to the break, as part of the way from there to the end: a break through cracked
/// wood would cross the walls of the cracks.
const CRACKS_REACH: f64 = 0.5;
/// Distance of the saw from the end of what can be cut, in radii.
const SAW_FROM_END: f64 = 0.25;
/// Wood that must remain between the break and the saw, in radii.
const MIN_REMAINING: f64 = 1.0;
/// Wood between the bottom of the deepest crack of an end and the highest point of a break, in radii: beside cracks the
/// wood is thin.
const BREAK_CLEARANCE: f64 = 0.05;
/// How far below the saw, and from the axis there, an end of a stem may still reach, in radii: buttresses of a stump do, the trunk that a
/// limb grows on goes on.
const OWN_END: f64 = 4.0;
/// Step by which the stem is looked for back from the saw, in radii.
const SEARCH_STEP: f64 = 0.25;

/// The layout of a sawn end, which is level: a hexagon of triangles with displaced corners. In the grid of rings and rays,
/// rays run along straight cracks at tiny angles, and leave slivers beside them.
fn end_layout(stem: &PreparedStem) -> FibreBundles {
    let rings = &stem.found.stem.rings;
    // The hexagon holds the circle about the skin.
    let across = 2.0 / 3f64.sqrt();
    let side = END_MARGIN * stem.extent.radius * across / f64::from(END_RINGS);
    let inside = |q: i32, r: i32| q.abs().max(r.abs()).max((q + r).abs()) <= END_RINGS;
    let (mut nodes, mut numbers) = (Vec::new(), BTreeMap::new());
    for q in -END_RINGS..=END_RINGS {
        for r in (-END_RINGS..=END_RINGS).filter(|&r| inside(q, r)) {
            let random = |k: u64| noise::unit(k, i64::from(q), i64::from(r), 0) - 0.5;
            let border = q.abs().max(r.abs()).max((q + r).abs()) == END_RINGS;
            let jitter = if border { 0.0 } else { END_JITTER };
            let off = DVec2::new(random(1), random(2)) * jitter;
            let at = DVec2::new(f64::from(q) + 0.5 * f64::from(r), f64::from(r) / across);
            numbers.insert((q, r), nodes.len() as u32);
            nodes.push(rings.pith() + (at + off) * side);
        }
    }
    let triangles = numbers.keys().flat_map(|&(q, r)| {
        [
            [(q, r), (q + 1, r), (q, r + 1)],
            [(q, r), (q, r + 1), (q - 1, r + 1)],
        ]
    });
    let facets: Vec<[u32; 3]> = triangles
        .filter(|t| t.iter().all(|&(q, r)| inside(q, r)))
        .map(|t| t.map(|corner| numbers[&corner]))
        .collect();
    let addresses: Vec<(f64, f64)> = nodes.iter().map(|&p| rings.address(p)).collect();
    let direction = |&(_, phi): &(f64, f64)| {
        let (sin, cos) = libm::sincos(phi);
        DVec2::new(cos, sin)
    };
    FibreBundles {
        directions: addresses.iter().map(direction).collect(),
        addresses,
        bundles: vec![FibreBundle {
            ring: 0,
            sector: 0,
            rho: 0.0,
            phi: 0.0,
            half_width: PI,
            bark: false,
        }],
        tips: vec![NONE],
        skin: None,
        layout: {
            let cells = vec![0; facets.len()];
            Arc::new(SectionLayout::new(nodes, facets, cells))
        },
    }
}

/// The wood that is seen in a sawn end.
fn end_wood<'a>(
    stem: &'a PreparedStem,
    p: &BreakParameters,
    bundles: &'a FibreBundles,
    material: u32,
) -> InnerWood<'a> {
    InnerWood {
        stem: &stem.found.stem,
        bundles,
        proportions: p.proportions(),
        material,
        square: stem.square,
        smooth: false,
    }
}

/// Cracks an end of the stem: the far one (greater lengths) or the near one. `material` is that of the wood inside.
///
/// # Errors
/// [`BreakError::Crack`] where the end is not found, [`BreakError::Cut`] where the mesh is open there, and
/// [`BreakError::Cancelled`].
pub fn crack_end(
    stem: &PreparedStem,
    p: &BreakParameters,
    plan: &CrackPlan,
    far: bool,
    material: u32,
    context: &Context,
) -> Result<CrackedEnd, BreakError> {
    let found = &stem.found.stem;
    let end = EndFace::fit(
        &stem.corners,
        &stem.found.limb,
        &stem.grain,
        far,
        found.radius,
    )?;
    let bundles = end_layout(stem);
    // The wood of the end itself may be cracked, though not broken.
    let beyond = end.at(found.rings.pith());
    let (low, high) = found.usable;
    let place = found.location;
    let usable = if far {
        let nearest = place + CRACKS_REACH * (beyond - place);
        (low.max(nearest), high.max(beyond + end.clearance))
    } else {
        let nearest = place - CRACKS_REACH * (place - beyond);
        (low.min(beyond - end.clearance), high.min(nearest))
    };
    let site = CrackSite {
        radius: found.radius,
        usable,
        level: f64::INFINITY,
    };
    let plan = fit_to_section(stem, plan);
    let (rings, layout) = (&found.rings, &bundles.layout);
    let made = end_grooves(&plan, rings, layout, &end, &site, context)?;
    let whole = shell_volume(stem);
    let inner = end_wood(stem, p, &bundles, material);
    // What is cut out of an end is nothing but chips.
    let cracked = cut_along((stem, &inner), made, false, context)?;
    let mesh = cracked.piece(stem, &inner, !far);
    let void = whole - mesh.volume();
    Ok(CrackedEnd {
        mesh,
        end,
        grooves: cracked.grooves,
        void,
    })
}

/// Saws an end, the far one or the near one, off straight, as near to it as the stem can be cut, and cracks the sawn face. What is sawn
/// off is discarded.
///
/// # Errors
/// [`BreakError::Crack`] where too little of the stem is left beyond the break, or where it grows out of other wood at its base,
/// [`BreakError::Cut`] where the mesh is open or not a manifold there, and [`BreakError::Cancelled`].
pub fn saw_and_crack_end(
    stem: &PreparedStem,
    p: &BreakParameters,
    (plan, far): (&CrackPlan, bool),
    material: u32,
    context: &Context,
) -> Result<CrackedEnd, BreakError> {
    let found = &stem.found.stem;
    let (low, high) = found.usable;
    let (sign, outmost) = if far { (1.0, high) } else { (-1.0, low) };
    let level = outmost - sign * SAW_FROM_END * found.radius;
    if sign * (level - found.location) < MIN_REMAINING * found.radius {
        return Err(CrackError::TooShort {
            which: if far { "far" } else { "near" },
            left: sign * (outmost - found.location),
            needed: (SAW_FROM_END + MIN_REMAINING) * found.radius,
        }
        .into());
    }
    if !far && grows_on(stem, level) {
        return Err(CrackError::GrowsOn.into());
    }
    let bundles = end_layout(stem);
    let flat = FractureSurface {
        heights: vec![[level; 3]; bundles.layout.facets.len()],
        layout: Arc::clone(&bundles.layout),
    };
    let nearest = found.location + CRACKS_REACH * (level - found.location);
    let (usable, direction) = match far {
        true => ((low.max(nearest), high), Direction::Down),
        false => ((low, high.min(nearest)), Direction::Up),
    };
    let site = CrackSite {
        radius: found.radius,
        usable,
        level: f64::INFINITY,
    };
    let plan = fit_to_section(stem, plan);
    let inner = end_wood(stem, p, &bundles, material);
    let kept = |plan: &CrackPlan| -> Result<(Mesh, GroovedSurface), BreakError> {
        let made = grooves(plan, &found.rings, &flat, direction, &site, context)?;
        let cracked = cut_along((stem, &inner), made, true, context)?;
        Ok((cracked.piece(stem, &inner, !far), cracked.grooves))
    };
    let (mesh, made) = kept(&plan)?;
    let (whole, _) = kept(&CrackPlan::default())?;
    Ok(CrackedEnd {
        void: whole.volume() - mesh.volume(),
        mesh,
        end: EndFace::level(far, level),
        grooves: made,
    })
}

/// Whether a stem goes on below a length along its axis (m) as wood that is no part of it, such as the trunk that a limb grows on: wood
/// that lies farther from its axis, or from that length, than its own end could.
fn grows_on(stem: &PreparedStem, level: f64) -> bool {
    let (found, mesh) = (&stem.found, stem.node());
    let reach = OWN_END * found.stem.radius;
    let axis = found.stem.grain.axis();
    let end = axis.frame(level);
    let is_beyond = |v: u32| {
        let place = mesh
            .transform
            .transform_point3(mesh.mesh.positions[v as usize]);
        let off = place - end.origin;
        let below = -off.dot(end.tangent);
        let aside = (off + end.tangent * below).length();
        below > 0.0 && (below > reach || aside > reach)
    };
    let limb: BTreeSet<u32> = found.limb.iter().copied().collect();
    let others = found.shell.iter().filter(|t| !limb.contains(t));
    let mut others = others.map(|&t| mesh.mesh.triangles[t as usize]);
    others.any(|corners| corners.iter().all(|&v| is_beyond(v)))
}

/// Volume of the stem's shell, in cubic units of the node's coordinates.
fn shell_volume(stem: &PreparedStem) -> f64 {
    let mesh = &stem.node().mesh;
    stem.found
        .shell
        .iter()
        .map(|&t| {
            let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// A stem whose end has been cracked.
#[derive(Debug)]
pub struct OpenedEnd {
    /// The stem with the cracks, which can be broken at the same place.
    pub stem: PreparedStem,
    /// Where the end lies.
    pub end: EndOfStem,
    /// What was made and what was limited.
    pub grooves: GroovedSurface,
    /// Volume of the cracks, m³.
    pub void: f64,
    /// Whether it is the far end (greater lengths).
    pub far: bool,
    /// Whether the end was sawn off straight first.
    pub sawn_off: bool,
    /// Triangles of other shells that fell with what was sawn off.
    pub fallen: usize,
}

/// Opens the cracks of a plan in an end of a stem, the far one or the near one, which is sawn off straight where it is no cut face.
///
/// # Errors
/// As [`crack_end`] and [`saw_and_crack_end`], or where the caller cancelled.
pub fn open_end(
    stem: &PreparedStem,
    p: &BreakParameters,
    (plan, far): (&CrackPlan, bool),
    material: u32,
    context: &Context,
) -> Result<OpenedEnd, BreakError> {
    let (made, sawn_off) = match crack_end(stem, p, plan, far, material, context) {
        Err(BreakError::Cut { .. } | BreakError::Crack(CrackError::NoEnd { .. })) => {
            let plan = (plan, far);
            (saw_and_crack_end(stem, p, plan, material, context)?, true)
        }
        made => (made?, false),
    };
    let found = &stem.found.stem;
    // The pith of a board may lie outside it.
    let height = made.end.at(found.rings.pith());
    let off = |s: &&CrossSection| (s.length - height).abs();
    let nearest = (found.sections.iter()).min_by(|a, b| off(a).total_cmp(&off(b)));
    let in_grain = |s: &CrossSection| found.grain.from_section(s.centroid, s.length);
    let middle = nearest.map_or(found.rings.pith(), in_grain);
    let end = EndOfStem {
        middle: stem.layers.to_world(middle.extend(made.end.at(middle))),
        outward: match far {
            true => found.grain.axis().frame(found.length).tangent,
            false => -found.grain.axis().frame(0.0).tangent,
        },
        radius: nearest.map_or(found.radius, |s| {
            let distance = |p: &DVec2| p.distance(s.centroid);
            s.contour.iter().map(distance).fold(0.0, f64::max)
        }),
    };
    let deep = made.grooves.deepest + BREAK_CLEARANCE * found.radius;
    // What hangs on the wood at the base stays where it is.
    let fallen = if sawn_off && far {
        fallen_shells(stem, height, context)?
    } else {
        Vec::new()
    };
    let mut cracked = replace_shell(stem, made.mesh, &fallen, context)?;
    let usable = &mut cracked.found.stem.usable;
    match far {
        true => usable.1 = usable.1.min(height - deep),
        false => usable.0 = usable.0.max(height + deep),
    }
    Ok(OpenedEnd {
        void: made.void * stem.volume_scale(),
        stem: cracked,
        end,
        grooves: made.grooves,
        far,
        sawn_off,
        fallen: fallen.iter().map(|shell| shell.triangles.len()).sum(),
    })
}

/// The prepared stem with `mesh` in place of its shell, and without the shells that have `fallen`.
fn replace_shell(
    stem: &PreparedStem,
    mut mesh: Mesh,
    fallen: &[CarriedShell],
    context: &Context,
) -> Result<PreparedStem, Cancelled> {
    let (mut scene, mut found) = (stem.scene.clone(), stem.found.clone());
    let node = found.node;
    let count = mesh.triangles.len() as u32;
    let mut removed: Vec<Vec<bool>> = (scene.nodes.iter())
        .map(|n| vec![false; n.mesh.triangles.len()])
        .collect();
    let own = CarriedShell {
        node,
        triangles: std::mem::take(&mut found.shell),
    };
    for shell in fallen.iter().chain([&own]) {
        for &t in &shell.triangles {
            removed[shell.node][t as usize] = true;
        }
    }
    found.carried.retain(|shell| !fallen.contains(shell));
    for CarriedShell { node: i, triangles } in &mut found.carried {
        // New numbers of the triangles that remain; in the stem's node they follow those of the stem.
        let mut next = if *i == node { count } else { 0 };
        let number = |removed: &bool| {
            next += u32::from(!removed);
            next.wrapping_sub(1)
        };
        let numbers: Vec<u32> = removed[*i].iter().map(number).collect();
        triangles.iter_mut().for_each(|t| *t = numbers[*t as usize]);
    }
    let on_limb = |t: &[u32; 3]| {
        let grain = mesh.attributes.get("_GRAIN");
        grain.is_some_and(|g| {
            t.iter()
                .all(|&v| g.at(v as usize).iter().any(|x| *x != 0.0))
        })
    };
    context.check()?;
    found.limb = (0..count)
        .filter(|&t| on_limb(&mesh.triangles[t as usize]))
        .collect();
    found.shell = (0..count).collect();
    for (i, removed) in removed.iter().enumerate() {
        let rest = (0..removed.len()).filter(|&t| !removed[t]);
        let other = &scene.nodes[i].mesh;
        if i == node {
            append(&mut mesh, &other.submesh(rest));
        } else if removed.contains(&true) {
            scene.nodes[i].mesh = other.submesh(rest).into();
        }
    }
    scene.nodes[node].mesh = mesh.into();
    PreparedStem::from_found(scene, found, stem.layers.clone(), context)
}

/// Shells that hang on the stem beyond a saw that cuts at the length `level`, m: (node, its triangles).
fn fallen_shells(
    stem: &PreparedStem,
    level: f64,
    context: &Context,
) -> Result<Vec<CarriedShell>, BreakError> {
    let meshes = stem.scene.world_meshes();
    let own = &stem.found;
    let options = StemOptions {
        kind: Some(own.stem.kind),
        ..StemOptions::default()
    };
    // Too near to the end or to other wood no stem is found; nothing hangs on the free wood before the saw.
    let mut back = 0.0;
    while level - back > own.stem.location {
        let point = own.stem.grain.axis().frame(level - back).origin;
        match find_stem(&meshes, &StemLocation::Point(point), &options, context) {
            Ok(found) if found.node == own.node && found.shell.first() == own.shell.first() => {
                return Ok(found.carried);
            }
            Err(error @ StemError::Cancelled(_)) => return Err(error.into()),
            _ => back += SEARCH_STEP * own.stem.radius,
        }
    }
    Ok(Vec::new())
}

/// Appends the triangles of `other` to `mesh`; attributes that only one of them has are filled with zeros.
fn append(mesh: &mut Mesh, other: &Mesh) {
    if other.triangles.is_empty() {
        return;
    }
    let (first, more) = (mesh.positions.len(), other.positions.len());
    mesh.positions.extend(&other.positions);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + first as u32)));
    let triangles = mesh.triangles.len();
    mesh.materials
        .resize(triangles - other.triangles.len(), NO_MATERIAL);
    mesh.materials.extend(&other.materials);
    mesh.materials.resize(triangles, NO_MATERIAL);
    for (name, attribute) in &mut mesh.attributes {
        match other
            .attributes
            .get(name)
            .filter(|o| o.width == attribute.width)
        {
            Some(o) => attribute.data.extend(&o.data),
            None => attribute.data.resize((first + more) * attribute.width, 0.0),
        }
    }
}
