//! What of a stem's own shell does not belong to it: the other limb of a fork, branches that are welded to it.

use super::FoundStem;
use glam::{DMat3, DVec3};
use greenstick_geometry::{Cancelled, Context, Mesh, symmetric_eigen};
use rayon::prelude::*;
use std::fmt;

/// Ring coordinate beyond which the surface is another limb's: bark is at about 1.
const MAX_RING: f64 = 1.6;
/// Distance beyond the ends, in radii, from which on it is.
const END_RADII: f64 = 1.0;
/// Least share of the shell's volume that is reported.
const MIN_SHARE: f64 = 0.02;
/// Triangles between two checks for cancellation.
const BATCH: usize = 1 << 12;

/// A limb that grows from the stem, or the other limb of a fork.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limb {
    /// Where it meets the stem, m along it from the base.
    pub at_m: f64,
    /// The middle of its mouth, where it leaves the stem, m.
    pub mouth: DVec3,
    /// From its mouth to the middle of its surface (unit vector).
    pub direction: DVec3,
    /// Angle between this direction and the stem, rad.
    pub angle: f64,
    /// Diameter where it is free of the stem all round: of the circle with the area of its section, m.
    pub diameter_m: f64,
    /// How far it reaches from its mouth along its direction, m.
    pub length_m: f64,
    /// Volume, closed flat at its mouth, m³.
    pub volume_m3: f64,
    /// The middle of its surface, m.
    pub centre: DVec3,
}

/// Wood of the stem's shell that is not the stem's.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Its volume, closed flat where it meets the stem, m³.
    pub volume_m3: f64,
    /// Its share of the shell's volume, 0 to 1.
    pub share: f64,
    /// Its parts, the largest first; at least one.
    pub limbs: Vec<Limb>,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let several = self.limbs.len() != 1;
        write!(
            f,
            "{} beside the stem {} left out, about {:.6} m³ or {:.0} % of the mesh's volume",
            if several { "limbs" } else { "a limb" },
            if several { "were" } else { "was" },
            self.volume_m3,
            100.0 * self.share,
        )?;
        let Some(largest) = self.limbs.first() else {
            return Ok(());
        };
        let [x, y, z] = largest.centre.to_array();
        write!(
            f,
            ": the largest meets it at {:.3} m and has its middle at ({x:.3}, {y:.3}, {z:.3}) m",
            largest.at_m
        )
    }
}

/// Finds what of the stem's shell a round stem leaves out. `mesh` is the one that the stem was found in, in world metres.
///
/// # Errors
/// [`Cancelled`].
pub fn find_left_out(
    mesh: &Mesh,
    found: &FoundStem,
    context: &Context,
) -> Result<Option<LeftOut>, Cancelled> {
    if found.stem.kind.is_sawn() {
        return Ok(None);
    }
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
    let batches: Vec<Vec<u32>> = found
        .shell
        .par_chunks(BATCH)
        .map(|batch| {
            context.check()?;
            let is_off = |t: &u32| is_beside(found, corners(*t).iter().sum::<DVec3>() / 3.0);
            Ok(batch.iter().copied().filter(is_off).collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    let beside = batches.concat();
    let whole = volume(found.shell.iter().map(|t| corners(*t)), DVec3::ZERO);
    let mut limbs: Vec<Limb> = parts(mesh, &beside)
        .iter()
        .map(|part| limb(mesh, found, part))
        // Burrs are no limbs.
        .filter(|limb| limb.volume_m3 > 0.1 * MIN_SHARE * whole)
        .collect();
    limbs.sort_by(|a, b| b.volume_m3.total_cmp(&a.volume_m3));
    let sum: f64 = limbs.iter().map(|l| l.volume_m3).sum();
    let left_out = LeftOut {
        volume_m3: sum,
        share: sum / whole,
        limbs,
    };
    Ok((left_out.share > MIN_SHARE).then_some(left_out))
}

/// Measures a part of the surface as a limb.
fn limb(mesh: &Mesh, found: &FoundStem, part: &Part) -> Limb {
    let corners = |t: &u32| mesh.triangles[*t as usize].map(|v| mesh.positions[v as usize]);
    let middles = (part.triangles.iter()).map(|t| corners(t).iter().sum::<DVec3>() / 3.0);
    let centre = middles.sum::<DVec3>() / part.triangles.len() as f64;
    let at_m = found.stem.grain.to_grain(part.mouth).z;
    let at_m = at_m.clamp(0.0, found.stem.length);
    let stem = found.stem.grain.axis().frame(at_m).tangent;
    let direction = (centre - part.mouth).normalize_or(stem);
    let surface: Vec<[DVec3; 3]> = part.triangles.iter().map(corners).collect();
    let reach = part.triangles.iter().flat_map(corners);
    let reach = reach.map(|p| (p - part.mouth).dot(direction));
    Limb {
        at_m,
        mouth: part.mouth,
        direction,
        angle: direction.dot(stem).clamp(-1.0, 1.0).acos(),
        diameter_m: free_diameter(part, &surface, direction),
        length_m: reach.fold(0.0, f64::max),
        volume_m3: volume(part.triangles.iter().map(corners), part.mouth),
        centre,
    }
}

/// Returns the diameter of a limb where it is free of the stem all round, m; of a stub that never is, that of its mouth seen
/// along it. At a fork the mouth itself is several times as long as wide.
fn free_diameter(part: &Part, triangles: &[[DVec3; 3]], direction: DVec3) -> f64 {
    let widest = part.rim.iter().map(|edge| edge[0].distance(part.mouth));
    let widest = widest.fold(0.0, f64::max);
    let free = |axis: DVec3| {
        let along = part.rim.iter().map(|edge| edge[0].dot(axis));
        along.fold(f64::NEG_INFINITY, f64::max)
    };
    // The surface tells the limb's direction there, which bent limbs do not keep.
    let mut normals = DMat3::ZERO;
    let place = part.mouth + direction * (free(direction) - part.mouth.dot(direction));
    for [a, b, c] in triangles {
        if ((a + b + c) / 3.0).distance(place) < widest {
            let n = (b - a).cross(c - a);
            let unit = n.normalize_or_zero();
            normals += DMat3::from_cols(unit * n.x, unit * n.y, unit * n.z);
        }
    }
    let axis = symmetric_eigen(normals)[0].1;
    let axis = axis * axis.dot(direction).signum();
    let level = free(axis);
    let section = triangles.iter().filter_map(|t| cut(t, axis, level));
    let swept = |[a, b]: [DVec3; 2]| 0.5 * (a - part.mouth).cross(b - part.mouth).dot(axis);
    let mut area = section.map(swept).sum::<f64>().abs();
    if area == 0.0 {
        area = part.rim.iter().map(|edge| swept(*edge)).sum::<f64>().abs();
    }
    2.0 * (area / std::f64::consts::PI).sqrt()
}

/// Returns where a triangle meets the plane at `level` along `axis`, from where it rises through the plane to where it falls.
fn cut(triangle: &[DVec3; 3], axis: DVec3, level: f64) -> Option<[DVec3; 2]> {
    let height = triangle.map(|p| p.dot(axis) - level);
    let crossing = |from: usize| {
        let to = (from + 1) % 3;
        let part = height[from] / (height[from] - height[to]);
        triangle[from].lerp(triangle[to], part)
    };
    let rises = (0..3).find(|&k| height[k] < 0.0 && height[(k + 1) % 3] >= 0.0)?;
    let falls = (0..3).find(|&k| height[k] >= 0.0 && height[(k + 1) % 3] < 0.0)?;
    Some([crossing(rises), crossing(falls)])
}

/// Whether a point of the surface is not the stem's.
fn is_beside(found: &FoundStem, p: DVec3) -> bool {
    let stem = &found.stem;
    let q = stem.grain.to_grain(p);
    let beyond = END_RADII * stem.radius;
    !(-beyond..=stem.length + beyond).contains(&q.z)
        || stem.rings.address(q.truncate()).0 > MAX_RING
}

/// The volume of triangles, closed by a cone to a point.
fn volume(triangles: impl Iterator<Item = [DVec3; 3]>, apex: DVec3) -> f64 {
    let sum: f64 = triangles
        .map(|[a, b, c]| (a - apex).dot((b - apex).cross(c - apex)))
        .sum();
    (sum / 6.0).abs()
}

/// A connected part of the surface.
struct Part {
    triangles: Vec<u32>,
    /// Edges of its open rim.
    rim: Vec<[DVec3; 2]>,
    /// The middle of their ends; a point of the part where it has no rim.
    mouth: DVec3,
}

/// The connected parts of some triangles. Vertices at one position are one point.
fn parts(mesh: &Mesh, triangles: &[u32]) -> Vec<Part> {
    let key = |v: u32| mesh.positions[v as usize].to_array().map(f64::to_bits);
    let mut vertices: Vec<u32> = triangles
        .iter()
        .flat_map(|t| mesh.triangles[*t as usize])
        .collect();
    vertices.sort_by_key(|v| key(*v));
    vertices.dedup_by_key(|v| key(*v));
    let point = |v: u32| vertices.partition_point(|u| key(*u) < key(v));
    let corners: Vec<[usize; 3]> = triangles
        .iter()
        .map(|t| mesh.triangles[*t as usize].map(point))
        .collect();
    let mut parent: Vec<usize> = (0..vertices.len()).collect();
    for c in &corners {
        let roots = c.map(|p| root(&mut parent, p));
        let least = roots[0].min(roots[1]).min(roots[2]);
        roots.iter().for_each(|r| parent[*r] = least);
    }
    // Edges that occur in one direction only are the rim.
    let mut edges: Vec<(usize, usize)> = corners
        .iter()
        .flat_map(|c| [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])])
        .collect();
    edges.sort_unstable();
    let rim = edges
        .iter()
        .filter(|(a, b)| edges.binary_search(&(*b, *a)).is_err());
    let mut rims: Vec<Vec<[DVec3; 2]>> = vec![Vec::new(); vertices.len()];
    for (a, b) in rim {
        let ends = [*a, *b].map(|v| mesh.positions[vertices[v] as usize]);
        rims[root(&mut parent, *a)].push(ends);
    }
    let mut numbered: Vec<(usize, u32)> = corners
        .iter()
        .zip(triangles)
        .map(|(c, t)| (root(&mut parent, c[0]), *t))
        .collect();
    numbered.sort_unstable();
    let part = |group: &[(usize, u32)]| {
        let rim = rims[group[0].0].clone();
        let first = mesh.triangles[group[0].1 as usize][0];
        let middle = rim.iter().map(|edge| edge[0]).sum::<DVec3>() / rim.len().max(1) as f64;
        Part {
            triangles: group.iter().map(|g| g.1).collect(),
            mouth: if rim.is_empty() {
                mesh.positions[first as usize]
            } else {
                middle
            },
            rim,
        }
    };
    numbered.chunk_by(|a, b| a.0 == b.0).map(part).collect()
}

fn root(parent: &mut [usize], mut p: usize) -> usize {
    while parent[p] != p {
        parent[p] = parent[parent[p]];
        p = parent[p];
    }
    p
}
