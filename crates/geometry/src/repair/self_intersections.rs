//! Resolves self-intersections that appear because files store positions in `f32`.
//!
//! Where a crack closes, its walls approach each other to less than the spacing of `f32`, and once rounded they cross.
//! There the crack ends instead: the shortest edges of crossing triangles are collapsed, with longer ones allowed from
//! round to round, until nothing crosses. Triangles whose corners have come to lie on one line, and edges that have come
//! to lie on each other, are removed in the same way.

use super::bisection::{crossing_pairs, crossing_pairs_within};
use super::collapse::{CollapseTo, Collapsed, EdgeCollapser};
use super::snap::snap_with_topology;
use crate::components::Topology;
use crate::intersect::{collinear, contact_boxes};
use crate::{Cancelled, Context, Mesh};
use glam::DVec3;
use rustc_hash::FxHashSet;

/// Length of the longest edge collapsed in the first round, as a fraction of the extent of the mesh: about the spacing of `f32`
/// there.
const FIRST_LENGTH: f64 = 1e-7;
/// Most rounds; from one to the next, edges may be twice as long. In the last they may have 0.04 % of the extent, so that a
/// crack ends somewhat earlier; with fewer, walls of cracks that close slowly stay crossed.
const ROUNDS: i32 = 13;

/// Positions, rounded to `f32`, of points whose faults the input brought along and that are left as they are.
#[derive(Debug, Clone, Default)]
pub struct KnownPositions {
    positions: FxHashSet<(u64, u32)>,
    /// A bit for each of many groups of positions, whether any is in the set: most points asked about are new, and these bits stay in
    /// the cache (B. H. Bloom, *Space/time trade-offs in hash coding with allowable errors*, 1970, with one hash).
    groups: Vec<u64>,
}

impl KnownPositions {
    /// Returns the positions of a mesh.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let positions: FxHashSet<_> = mesh.positions.iter().map(|&p| position_key(p)).collect();
        let mut groups = vec![0; positions.len().div_ceil(8).next_power_of_two()];
        for &key in &positions {
            let (word, bit) = group(key, groups.len());
            groups[word] |= bit;
        }
        KnownPositions { positions, groups }
    }

    fn contains(&self, p: DVec3) -> bool {
        let key = position_key(p);
        let (word, bit) = group(key, self.groups.len());
        self.groups.get(word).is_some_and(|w| w & bit != 0) && self.positions.contains(&key)
    }
}

/// The word, of a number that is a power of two, and the bit in it of the group of a position.
fn group((xy, z): (u64, u32), words: usize) -> (usize, u64) {
    let mixed = (xy ^ u64::from(z).rotate_left(40)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ mixed >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    let word = (mixed >> 32) as usize & words.saturating_sub(1);
    (word, 1 << (mixed >> 26 & 63))
}

/// The bits of a position in `f32`; both zeros have the same. Two numbers are hashed sooner than an array.
fn position_key(p: DVec3) -> (u64, u32) {
    let [x, y, z] = (p.as_vec3() + 0.0).to_array().map(f32::to_bits);
    (u64::from(x) << 32 | u64::from(y), z)
}

/// Collapses short edges until no triangle crosses another, is degenerate or shares an edge with more than one other.
/// Triangles with all corners at `known` positions are left as they are. Snap positions to `f32` first
/// ([`super::snap_to_f32`]).
///
/// # Errors
/// [`Cancelled`] where the caller cancelled; the mesh is then as it was.
pub fn resolve_self_intersections(
    mesh: &mut Mesh,
    known: &KnownPositions,
    context: &Context,
) -> Result<Collapsed, Cancelled> {
    resolve(mesh, known, Topology::of(mesh), None, context).map(|done| done.0)
}

/// The triangles of a broken face in a mesh, ascending, and the pairs of them that cross, by their places in that list.
struct FaceCrossings<'a> {
    triangles: &'a [u32],
    crossing: &'a [[u32; 2]],
}

/// A mesh that was rounded to the precision of files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounded {
    /// How self-intersections were resolved.
    pub collapsed: Collapsed,
    /// Whether the outcome is closed.
    pub closed: bool,
    /// Its volume, if it is closed and oriented, in the unit of its positions cubed.
    pub volume: Option<f64>,
}

/// Snaps a mesh to `f32` ([`super::snap_to_f32`]), resolves its self-intersections ([`resolve_self_intersections`]) and
/// measures the outcome ([`Mesh::closed_volume`]), finding its points and edges once.
///
/// # Errors
/// [`Cancelled`] where the caller cancelled.
pub fn round_to_f32(
    mesh: &mut Mesh,
    inner: u32,
    known: &KnownPositions,
    context: &Context,
) -> Result<Rounded, Cancelled> {
    let topology = snap_with_topology(mesh, inner);
    resolved(mesh, known, topology, None, context)
}

/// As [`round_to_f32`] of each of the two halves of a break, at the same time. Mostly both have the same face, of material `inner`,
/// seen from either side: then the crossings in it are looked for once.
///
/// # Errors
/// [`Cancelled`] where the caller cancelled.
pub fn round_halves_to_f32(
    [one, other]: [&mut Mesh; 2],
    inner: u32,
    known: &KnownPositions,
    context: &Context,
) -> Result<[Rounded; 2], Cancelled> {
    let snapped = rayon::join(
        || snap_with_topology(one, inner),
        || snap_with_topology(other, inner),
    );
    let faces = [&*one, &*other].map(|mesh| {
        let face = 0..mesh.triangles.len() as u32;
        face.filter(|&t| mesh.material(t as usize) == inner)
            .collect()
    });
    let crossing = if is_same_face([one, other], &faces) {
        let corners = |&t: &u32| one.triangles[t as usize].map(|v| snapped.0.points[v as usize]);
        let triangles = faces[0].iter().map(corners).collect();
        let positions = snapped.0.positions(one);
        Some(crossing_among(positions, triangles, usize::MAX, context)?)
    } else {
        None
    };
    let crossings = faces.each_ref().map(|triangles| {
        let crossing = crossing.as_deref();
        crossing.map(|crossing| FaceCrossings {
            triangles,
            crossing,
        })
    });
    let [of_one, of_other] = crossings;
    let (one, other) = rayon::join(
        || resolved(one, known, snapped.0, of_one, context),
        || resolved(other, known, snapped.1, of_other, context),
    );
    Ok([one?, other?])
}

/// Whether two meshes have the same face, each seen from its own side: the same triangles at the same places, turned over.
fn is_same_face([one, other]: [&Mesh; 2], faces: &[Vec<u32>; 2]) -> bool {
    let [face, turned] = faces;
    face.len() == turned.len()
        && face.iter().zip(turned).all(|(&t, &u)| {
            let [a, b, c] = other.corners(u as usize);
            one.corners(t as usize) == [a, c, b]
        })
}

/// Resolves and measures a mesh that is snapped.
fn resolved(
    mesh: &mut Mesh,
    known: &KnownPositions,
    topology: Topology,
    face: Option<FaceCrossings>,
    context: &Context,
) -> Result<Rounded, Cancelled> {
    let (collapsed, topology) = resolve(mesh, known, topology, face, context)?;
    context.check()?;
    let topology = topology.unwrap_or_else(|| Topology::of(mesh));
    context.check()?;
    let (closed, volume) = mesh.closed_volume_with(&topology);
    Ok(Rounded {
        collapsed,
        closed,
        volume,
    })
}

/// Returns the topology again where nothing was collapsed. Otherwise it is dropped before the mesh is copied: of a large mesh it takes
/// as much memory.
fn resolve(
    mesh: &mut Mesh,
    known: &KnownPositions,
    topology: Topology,
    face: Option<FaceCrossings>,
    context: &Context,
) -> Result<(Collapsed, Option<Topology>), Cancelled> {
    let (low, high) = mesh
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| {
            (l.min(p), h.max(p))
        });
    let extent = (high - low).length();
    let positions = topology.positions(mesh);
    let is_known: Vec<bool> = positions.iter().map(|&p| known.contains(p)).collect();
    let is_known = |v: u32| is_known[topology.points[v as usize] as usize];
    let is_ours: Vec<bool> = (mesh.triangles.iter())
        .map(|t| !t.iter().all(|&v| is_known(v)))
        .collect();
    context.check()?;
    let faults = faults_among(mesh, &is_ours, (positions, &topology), face, context)?;
    let found = faults.len();
    if faults.is_empty() || !extent.is_finite() {
        let done = Collapsed {
            faults: found,
            remaining: found,
            ..Collapsed::default()
        };
        return Ok((done, Some(topology)));
    }
    drop(topology);
    let attempt = |end: CollapseTo| {
        context.check()?;
        let mut collapser = EdgeCollapser::from_mesh(mesh);
        collapser.collapse_to(end);
        let mut done = Collapsed {
            faults: found,
            ..Collapsed::default()
        };
        let ours = (&is_ours[..], extent);
        done.remaining = collapse_faults(&mut collapser, &faults, ours, &mut done, context)?;
        Ok::<_, Cancelled>((collapser, done))
    };
    let mut best = attempt(CollapseTo::First)?;
    if best.1.remaining > 0 {
        // Triangles that still cross with edges collapsed to one of their ends may not with edges collapsed to the other.
        let other = attempt(CollapseTo::Second)?;
        if other.1.remaining < best.1.remaining {
            best = other;
        }
    }
    let (collapser, done) = best;
    collapser.write_back(mesh);
    Ok((done, None))
}

/// Collapses edges of the `faults` of a mesh of this extent in rounds. Returns how many are left.
fn collapse_faults(
    collapser: &mut EdgeCollapser,
    faults: &[[u32; 2]],
    (is_ours, extent): (&[bool], f64),
    done: &mut Collapsed,
    context: &Context,
) -> Result<usize, Cancelled> {
    let is_faulty = |collapser: &EdgeCollapser, t: u32| {
        is_ours[t as usize] && (collapser.is_degenerate(t) || collapser.is_non_manifold(t))
    };
    let mut faults = faults.to_vec();
    for round in 0..ROUNDS {
        context.check()?;
        let longest = extent * FIRST_LENGTH * f64::from(1 << round);
        let changed = collapser.collapse_edges(&faults, longest, &|_| false, done, context)?;
        if changed.is_empty() {
            continue;
        }
        collapser.retain_unchanged(&mut faults, &changed);
        faults.extend(crossing_pairs(
            &collapser.positions,
            &collapser.triangles,
            Some(&changed),
            context,
        )?);
        faults.retain(|p| {
            p.iter().all(|&t| is_ours[t as usize]) && (p[0] != p[1] || is_faulty(collapser, p[0]))
        });
        faults.extend(
            changed
                .iter()
                .filter(|&&t| is_faulty(collapser, t))
                .map(|&t| [t, t]),
        );
        faults.sort_unstable();
        faults.dedup();
        if faults.is_empty() {
            break;
        }
    }
    Ok(faults.len())
}

/// Returns the faults of the triangles that are `chosen`: pairs that cross, then as pairs with themselves those without
/// area or at an edge with more than two triangles. `positions` are those of the points. Crossings in a `face` are known.
fn faults_among(
    mesh: &Mesh,
    chosen: &[bool],
    (positions, topology): (Vec<DVec3>, &Topology),
    face: Option<FaceCrossings>,
    context: &Context,
) -> Result<Vec<[u32; 2]>, Cancelled> {
    let mut is_faulty: Vec<bool> = (0..chosen.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            chosen[t] && collinear(a, b, c)
        })
        .collect();
    topology.edges.each(|_, uses| {
        if uses.len() > 2 {
            for used in uses {
                is_faulty[used.triangle()] |= chosen[used.triangle()];
            }
        }
    });
    // Those of the face come last.
    let face = face
        .as_ref()
        .map_or((&[][..], &[][..]), |face| (face.triangles, face.crossing));
    let is_chosen = |t: &u32| chosen[*t as usize];
    let mut in_face = face.0.iter().copied().peekable();
    let others = (0..chosen.len() as u32).filter(|t| in_face.next_if_eq(t).is_none());
    let mut ours: Vec<u32> = others.filter(is_chosen).collect();
    let unknown = ours.len();
    ours.extend(face.0.iter().copied().filter(is_chosen));
    let at_points = |t: &u32| mesh.triangles[*t as usize].map(|v| topology.points[v as usize]);
    let triangles = ours.iter().map(at_points).collect();
    context.check()?;
    let crossing = crossing_among(positions, triangles, unknown, context)?;
    let ascending = |[s, t]: [u32; 2]| [s.min(t), s.max(t)];
    let mut faults: Vec<[u32; 2]> = (crossing.into_iter())
        .map(|pair| ascending(pair.map(|i| ours[i as usize])))
        .collect();
    let known = face.1.iter().map(|pair| pair.map(|i| face.0[i as usize]));
    faults.extend(known.filter(|pair| pair.iter().all(is_chosen)));
    faults.sort_unstable();
    let alone = (0..chosen.len() as u32).filter(|&t| is_faulty[t as usize]);
    faults.extend(alone.map(|t| [t, t]));
    Ok(faults)
}

/// Returns the pairs of triangles on points that cross, of which at least one is among the first `count`, ascending.
fn crossing_among(
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    count: usize,
    context: &Context,
) -> Result<Vec<[u32; 2]>, Cancelled> {
    let part = Mesh {
        positions,
        triangles,
        ..Mesh::default()
    };
    crossing_pairs_within(
        &part.positions,
        &part.triangles,
        count,
        &contact_boxes(&part),
        context,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles strewn in a cube, repeatable: many of them cross.
    fn strewn(seed: u64, count: usize) -> Vec<[DVec3; 3]> {
        let mut state = seed;
        let mut next = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut point = || DVec3::new(next(), next(), next());
        (0..count)
            .map(|_| {
                let at = point();
                [(); 3].map(|()| at + point() * 0.5)
            })
            .collect()
    }

    /// A mesh of a skin, material 0, and of a face, material 1.
    fn half(skin: &[[DVec3; 3]], face: &[[DVec3; 3]]) -> Mesh {
        let all = || skin.iter().chain(face);
        Mesh {
            positions: all().flatten().copied().collect(),
            triangles: (0..all().count() as u32)
                .map(|t| [0, 1, 2].map(|k| 3 * t + k))
                .collect(),
            materials: all()
                .enumerate()
                .map(|(t, _)| u32::from(t >= skin.len()))
                .collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn halves_are_rounded_as_each_alone() {
        let face = strewn(1, 120);
        let turned: Vec<[DVec3; 3]> = face.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let mut other_face = turned.clone();
        other_face[60][0].x += 0.01;
        for (upper_face, is_same) in [(turned, true), (other_face, false)] {
            let mut halves = [
                half(&strewn(2, 40), &face),
                half(&strewn(3, 50), &upper_face),
            ];
            let known = KnownPositions::from_mesh(&halves[0].submesh([0, 1, 50, 51].into_iter()));
            let mut alone = halves.clone();
            let expected = alone
                .each_mut()
                .map(|mesh| round_to_f32(mesh, 1, &known, &Context::quiet()).unwrap());
            let faces = [40..160, 50..170].map(|face| face.collect());
            assert_eq!(is_same_face(halves.each_ref(), &faces), is_same);
            let rounded =
                round_halves_to_f32(halves.each_mut(), 1, &known, &Context::quiet()).unwrap();
            assert_eq!(rounded, expected);
            assert_eq!(halves, alone);
            assert!(rounded.iter().all(|half| half.collapsed.faults > 20));
        }
    }
}
