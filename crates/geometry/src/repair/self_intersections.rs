//! Resolves self-intersections that appear because files store positions in `f32`.
//!
//! Where a crack closes, its walls approach each other to less than the spacing of `f32`, and once rounded they cross.
//! There the crack ends instead: the shortest edges of crossing triangles are collapsed, with longer ones allowed from
//! round to round, until nothing crosses. Triangles whose corners have come to lie on one line, and edges that have come
//! to lie on each other, are removed in the same way.

use super::bisection::crossing_pairs;
use super::collapse::{Collapsed, EdgeCollapser};
use super::snap::snap_with_topology;
use crate::Mesh;
use crate::components::Topology;
use crate::intersect::{Contact, TriangleContacts, collinear, contact_boxes, overlapping_pairs};
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
pub struct KnownPositions(FxHashSet<[u32; 3]>);

impl KnownPositions {
    /// Returns the positions of a mesh.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        KnownPositions(mesh.positions.iter().map(|&p| position_key(p)).collect())
    }

    fn contains(&self, p: DVec3) -> bool {
        self.0.contains(&position_key(p))
    }
}

/// The bits of a position in `f32`; both zeros have the same.
fn position_key(p: DVec3) -> [u32; 3] {
    (p.as_vec3() + 0.0).to_array().map(f32::to_bits)
}

/// Collapses short edges until no triangle crosses another, is degenerate or shares an edge with more than one other.
/// Triangles with all corners at `known` positions are left as they are. Snap positions to `f32` first
/// ([`super::snap_to_f32`]).
pub fn resolve_self_intersections(mesh: &mut Mesh, known: &KnownPositions) -> Collapsed {
    resolve(mesh, known, Topology::of(mesh)).0
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
pub fn round_to_f32(mesh: &mut Mesh, inner: u32, known: &KnownPositions) -> Rounded {
    let topology = snap_with_topology(mesh, inner);
    let (collapsed, topology) = resolve(mesh, known, topology);
    let topology = topology.unwrap_or_else(|| Topology::of(mesh));
    let (closed, volume) = mesh.closed_volume_with(&topology);
    Rounded {
        collapsed,
        closed,
        volume,
    }
}

/// Returns the topology again where nothing was collapsed. Otherwise it is dropped before the mesh is copied: of a large mesh it takes
/// as much memory.
fn resolve(
    mesh: &mut Mesh,
    known: &KnownPositions,
    topology: Topology,
) -> (Collapsed, Option<Topology>) {
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
    let mut faults = faults_among(mesh, &is_ours, positions, &topology);
    let mut done = Collapsed {
        faults: faults.len(),
        remaining: faults.len(),
        ..Collapsed::default()
    };
    if faults.is_empty() || !extent.is_finite() {
        return (done, Some(topology));
    }
    drop(topology);
    let mut collapser = EdgeCollapser::from_mesh(mesh);
    let is_faulty = |collapser: &EdgeCollapser, t: u32| {
        is_ours[t as usize] && (collapser.is_degenerate(t) || collapser.is_non_manifold(t))
    };
    for round in 0..ROUNDS {
        let longest = extent * FIRST_LENGTH * f64::from(1 << round);
        let changed = collapser.collapse_edges(&faults, longest, &|_| false, &mut done);
        if changed.is_empty() {
            continue;
        }
        collapser.retain_unchanged(&mut faults, &changed);
        faults.extend(crossing_pairs(
            &collapser.positions,
            &collapser.triangles,
            Some(&changed),
        ));
        faults.retain(|p| {
            p.iter().all(|&t| is_ours[t as usize]) && (p[0] != p[1] || is_faulty(&collapser, p[0]))
        });
        faults.extend(
            changed
                .iter()
                .filter(|&&t| is_faulty(&collapser, t))
                .map(|&t| [t, t]),
        );
        faults.sort_unstable();
        faults.dedup();
        if faults.is_empty() {
            break;
        }
    }
    collapser.write_back(mesh);
    done.remaining = faults.len();
    (done, None)
}

/// Returns the faults of the triangles that are `chosen`: pairs that cross, then as pairs with themselves those without
/// area or at an edge with more than two triangles. `positions` are those of the points.
fn faults_among(
    mesh: &Mesh,
    chosen: &[bool],
    positions: Vec<DVec3>,
    topology: &Topology,
) -> Vec<[u32; 2]> {
    let at_points = |t: usize| mesh.triangles[t].map(|v| topology.points[v as usize]);
    let ours: Vec<usize> = (0..chosen.len()).filter(|&t| chosen[t]).collect();
    let part = Mesh {
        positions,
        triangles: ours.iter().map(|&t| at_points(t)).collect(),
        ..Mesh::default()
    };
    let contacts = TriangleContacts::new(&part.positions, &part.triangles);
    let mut faults = Vec::new();
    overlapping_pairs(&contact_boxes(&part), |s, t| {
        if contacts.between(s, t) == Contact::Crossing {
            faults.push([ours[s] as u32, ours[t] as u32]);
        }
    });
    faults.sort_unstable();
    let mut is_faulty: Vec<bool> = vec![false; chosen.len()];
    for (t, &index) in ours.iter().enumerate() {
        let [a, b, c] = part.corners(t);
        is_faulty[index] = collinear(a, b, c);
    }
    topology.edges.each(|_, uses| {
        if uses.len() > 2 {
            for used in uses {
                is_faulty[used.triangle()] |= chosen[used.triangle()];
            }
        }
    });
    let alone = (0..chosen.len() as u32).filter(|&t| is_faulty[t as usize]);
    faults.extend(alone.map(|t| [t, t]));
    faults
}
