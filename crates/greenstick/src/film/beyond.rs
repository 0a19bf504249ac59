//! What the rods do not fill: the rest of the mesh that a stem was found in, cut where the rods end, and what each part of
//! it hangs on.

use super::clip::{Loop, Saw, saw};
use crate::simulate::FilledStem;
use glam::DVec3;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::triangulate::triangulate;
use greenstick_geometry::{Aabb, Attribute, Bvh, Mesh, Unions};
use greenstick_skin::prepared::unmirror;
use greenstick_skin::texture::SectionSquare;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// "Wood inside" among the materials of parts.
pub(super) const SAWN: u32 = u32::MAX - 1;
/// A real end that stands out of the rods no farther than this many radii is left out: the rods' own ends stand for it.
const STUMP: f64 = 0.5;
/// What comes this near to other wood, in radii, touches it; and what hangs in the air within as many is carried by it.
const TOUCH: f64 = 0.03;
const FLOAT: f64 = 2.0;
/// Corners of a part that are looked at, at most, to find what it hangs on.
const LOOKS: usize = 3000;
/// How far a place without a section may lie off the axis, over the radius, to be taken for the stem's.
const WIDE: f64 = 1.6;

/// What a part hangs on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Root {
    /// The rods' ends where the stem begins, or where it ends.
    End(usize),
    /// The rods at a place, m, in the stem's world.
    At(DVec3),
    /// Nothing that moves.
    Nothing,
}

/// A part of one of the scene's meshes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    pub mesh: usize,
    pub triangles: Vec<u32>,
    pub root: Root,
}

/// The rest of a scene, in the stem's world, m.
#[derive(Debug, Clone, Default)]
pub(super) struct Beyond {
    pub meshes: Vec<Mesh>,
    pub names: Vec<String>,
    pub parts: Vec<Part>,
    /// Volume of real ends that are left out, m³.
    pub left: f64,
    /// What could not be done as it should, a sentence each.
    pub notes: Vec<String>,
}

impl Beyond {
    /// Splits the scene of a stem off its rods. `square` is where the texture of the wood inside lies, `zone` the tissue
    /// zone at a ring coordinate.
    pub fn of(grown: &FilledStem, square: SectionSquare, zone: &dyn Fn(f64) -> u8) -> Self {
        let mut beyond = Beyond::default();
        for node in &grown.scene.nodes {
            let mut node = node.clone();
            unmirror(&mut node);
            let mut mesh = node.mesh.transformed(&node.transform);
            mesh.materials.resize(mesh.triangles.len(), NO_MATERIAL);
            beyond.meshes.push(mesh);
            beyond.names.push(node.name);
        }
        let (node, shell) = (grown.node, &grown.shell);
        address(&mut beyond.meshes[node], grown, square, zone);
        let mut own = vec![false; beyond.meshes[node].triangles.len()];
        shell.iter().for_each(|&t| own[t as usize] = true);
        let ends = beyond.split(grown, &mut own, square, zone);
        beyond.attach(grown, &own, ends);
        beyond
    }

    /// Cuts the stem's own shell where the rods end. Gives the root of each of its triangles, `None` for those of the
    /// stretch that the rods fill.
    fn split(
        &mut self,
        grown: &FilledStem,
        own: &mut Vec<bool>,
        square: SectionSquare,
        zone: &dyn Fn(f64) -> u8,
    ) -> Vec<Option<usize>> {
        let mesh = &mut self.meshes[grown.node];
        let stem = &grown.stem;
        let along = &grown.placed.along;
        let reach = [
            along.iter().copied().fold(f64::INFINITY, f64::min),
            along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ];
        let saws = reach.map(|s| {
            let near = (stem.sections.iter())
                .min_by(|a, b| (a.length - s).abs().total_cmp(&(b.length - s).abs()));
            let expected = near.map_or_else(Default::default, |n| (n.centroid, n.area));
            Saw {
                frame: stem.grain.axis().frame(s),
                radius: (expected.1 / std::f64::consts::PI).sqrt(),
                expected,
            }
        });
        let loops = [0, 1].map(|k| saw(mesh, own, &saws[k]));
        let side = |loops: &[Loop; 2]| sides(mesh, own, loops, &saws);
        let parted = match &loops {
            [Some(a), Some(b)] => side(&[a.clone(), b.clone()]),
            _ => None,
        };
        let Some(mut of) = parted else {
            self.notes.push(
                "the mesh is not sound where the rods end, so that its rest begins at whole triangles and is open there"
                    .into(),
            );
            return by_place(mesh, own, grown, reach);
        };
        for (k, cut) in loops.iter().flatten().enumerate() {
            let all = of.iter().enumerate().filter(|(_, s)| **s == Some(k));
            let stands = all.clone().flat_map(|(t, _)| mesh.corners(t));
            let out = [-1.0, 1.0][k];
            let farthest = stands
                .map(|p| out * (p - saws[k].frame.origin).dot(saws[k].frame.tangent))
                .fold(0.0, f64::max);
            let real = [stem.ends.0, stem.ends.1][k] && farthest < STUMP * saws[k].radius;
            let first = mesh.triangles.len();
            let made = cap(mesh, cut, &saws[k], k == 0, grown, square, zone);
            if made.is_none() {
                self.notes.push(format!(
                    "the rest {} the rods is left open where it was cut: the section there crosses itself",
                    ["before", "behind"][k]
                ));
            }
            own.resize(mesh.triangles.len(), true);
            of.resize(mesh.triangles.len(), Some(k));
            if real {
                let gone = (0..of.len()).filter(|&t| of[t] == Some(k));
                let gone: Vec<usize> = gone.collect();
                self.left += mesh.submesh(gone.iter().copied()).volume();
                // Nothing but what may hang on it is carried.
                mesh.triangles.truncate(first);
                mesh.materials.truncate(first);
                own.truncate(first);
                of.truncate(first);
                of.iter_mut()
                    .filter(|s| **s == Some(k))
                    .for_each(|s| *s = Some(2 + k));
            }
        }
        of
    }

    /// Finds what every other shell hangs on, and lists the parts.
    fn attach(&mut self, grown: &FilledStem, own: &[bool], of: Vec<Option<usize>>) {
        let node = grown.node;
        let stem: Vec<usize> = (0..own.len()).filter(|&t| own[t]).collect();
        for k in 0..2 {
            let here = stem.iter().filter(|&&t| of[t] == Some(k));
            let triangles: Vec<u32> = here.map(|&t| t as u32).collect();
            if !triangles.is_empty() {
                self.parts.push(Part {
                    mesh: node,
                    triangles,
                    root: Root::End(k),
                });
            }
        }
        let trunk = Standing::new(
            self.meshes[node].submesh(stem.iter().copied()),
            stem.iter()
                .map(|&t| of[t].map(|k| Root::End(k % 2)))
                .collect(),
        );
        let mut loose: Vec<(usize, Vec<u32>)> = Vec::new();
        for (k, mesh) in self.meshes.iter().enumerate() {
            let shells = mesh.shells();
            let mut of_shell: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
            for (t, &shell) in shells.of_triangle.iter().enumerate() {
                if k != node || !own[t] {
                    of_shell.entry(shell).or_default().push(t as u32);
                }
            }
            loose.extend(of_shell.into_values().map(|triangles| (k, triangles)));
        }
        let roots = hang(&self.meshes, &loose, trunk, grown.stem.radius);
        for ((mesh, triangles), root) in loose.into_iter().zip(roots) {
            self.parts.push(Part {
                mesh,
                triangles,
                root,
            });
        }
    }
}

/// Wood that others may hang on, with the root of each triangle; `None` for the rods themselves.
struct Standing {
    mesh: Mesh,
    tree: Bvh,
    roots: Vec<Option<Root>>,
}

impl Standing {
    fn new(mesh: Mesh, roots: Vec<Option<Root>>) -> Self {
        Standing {
            tree: Bvh::of_triangles(&mesh),
            mesh,
            roots,
        }
    }

    /// How far some triangles of a mesh are from it, and what they hang on if on it. Nothing beyond `limit`.
    fn nearest(&self, mesh: &Mesh, triangles: &[u32], limit: f64) -> Option<(f64, Root)> {
        let root = |t: usize, p: DVec3| self.roots[t].unwrap_or(Root::At(p));
        let step = triangles.len().div_ceil(LOOKS).max(1);
        let looked = || {
            triangles
                .iter()
                .step_by(step)
                .map(|&t| mesh.corners(t as usize))
        };
        for corners in looked() {
            if !Aabb::around(&corners).overlaps(&self.tree.bounds()) {
                continue;
            }
            for k in 0..3 {
                let (p, to) = (corners[k], corners[(k + 1) % 3] - corners[k]);
                if let Some((t, at)) = self.tree.first_triangle(&self.mesh, p, to, 1.0) {
                    return Some((0.0, root(t, p + to * at)));
                }
            }
        }
        let mut best: Option<(f64, Root)> = None;
        for p in looked().flatten() {
            let within = best.map_or(limit, |b| b.0);
            if let Some(near) = self.tree.nearest_on(&self.mesh, p, within)
                && best.is_none_or(|b| near.distance < b.0)
            {
                best = Some((near.distance, root(near.triangle, near.point)));
            }
        }
        best
    }
}

/// What each shell hangs on: first what touches the stem, then what touches that, and so on; what touches nothing hangs on
/// the nearest, where that is near.
fn hang(meshes: &[Mesh], loose: &[(usize, Vec<u32>)], trunk: Standing, radius: f64) -> Vec<Root> {
    let size = |(mesh, triangles): &(usize, Vec<u32>)| {
        let corners = triangles
            .iter()
            .flat_map(|&t| meshes[*mesh].corners(t as usize));
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = corners.fold(none, |(l, h), p| (l.min(p), h.max(p)));
        low.distance(high)
    };
    let reach = trunk
        .mesh
        .bounds()
        .map_or(0.0, |(low, high)| low.distance(high));
    let limits: Vec<f64> = (loose.iter())
        .map(|l| (FLOAT * radius).max(size(l).min(reach)))
        .collect();
    let mut best: Vec<Option<(f64, Root)>> = vec![None; loose.len()];
    let mut open: Vec<usize> = (0..loose.len()).collect();
    let mut standing = trunk;
    while !open.is_empty() {
        let found: Vec<_> = (open.par_iter())
            .map(|&i| {
                let within = best[i].map_or(limits[i], |b| b.0);
                standing.nearest(&meshes[loose[i].0], &loose[i].1, within)
            })
            .collect();
        for (&i, found) in open.iter().zip(found) {
            if let Some(found) = found.filter(|f| best[i].is_none_or(|b| f.0 < b.0)) {
                best[i] = Some(found);
            }
        }
        let touches = |i: usize| best[i].filter(|b| b.0 <= TOUCH * radius);
        let (now, later): (Vec<usize>, Vec<usize>) =
            open.iter().partition(|&&i| touches(i).is_some());
        if now.is_empty() {
            break;
        }
        let (mut mesh, mut roots) = (Mesh::default(), Vec::new());
        for i in now {
            let Some((_, root)) = touches(i) else {
                continue;
            };
            let source = &meshes[loose[i].0];
            for &t in &loose[i].1 {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(source.corners(t as usize));
                mesh.triangles.push([first, first + 1, first + 2]);
                roots.push(Some(root));
            }
        }
        standing = Standing::new(mesh, roots);
        open = later;
    }
    best.into_iter()
        .map(|b| b.map_or(Root::Nothing, |b| b.1))
        .collect()
}

/// Adds the address in the stem to a mesh that has none, and texture coordinates where it has none.
fn address(mesh: &mut Mesh, grown: &FilledStem, square: SectionSquare, zone: &dyn Fn(f64) -> u8) {
    let stem = &grown.stem;
    let pith = stem.rings.pith();
    let count = mesh.positions.len();
    let (mut grain, mut coordinates) = (Vec::new(), Vec::new());
    for &p in &mesh.positions {
        let g = stem.grain.to_grain(p);
        grain.extend(g.as_vec3().to_array());
        let off = square.side + g.truncate().distance(pith);
        coordinates.extend([off as f32, g.z as f32]);
    }
    for (name, width, data) in [
        ("TEXCOORD_0", 2, coordinates),
        ("_RING", 1, vec![1.0; count]),
        ("_ZONE", 1, vec![f32::from(zone(1.0)); count]),
        ("_GRAIN", 3, grain),
    ] {
        let own = Attribute { width, data };
        mesh.attributes.entry(name.into()).or_insert(own);
    }
}

/// For each triangle of the shell the end that it is beyond, `None` for those between the two loops. `None` where the
/// loops do not part the shell.
fn sides(
    mesh: &Mesh,
    own: &[bool],
    loops: &[Loop; 2],
    saws: &[Saw; 2],
) -> Option<Vec<Option<usize>>> {
    let (points, count) = mesh.points();
    let mut on = vec![0u8; count];
    for (k, cut) in loops.iter().enumerate() {
        for &v in &cut.vertices {
            on[points[v as usize] as usize] |= 1 << k;
        }
    }
    let mut unions = Unions::new(own.len());
    let mut first = vec![u32::MAX; count];
    let adjacency = mesh.adjacency();
    // Which loop each triangle lies at, and on which side.
    let mut seeds: [[Vec<u32>; 2]; 2] = Default::default();
    for (t, corners) in mesh.triangles.iter().enumerate().filter(|(t, _)| own[*t]) {
        let p = corners.map(|v| points[v as usize]);
        for (k, &point) in p.iter().enumerate() {
            let next = p[(k + 1) % 3];
            let both = on[point as usize] & on[next as usize];
            let other = adjacency.neighbours[t][k];
            if both == 0 && (other as usize) < own.len() {
                unions.join(t as u32, other);
            }
            for l in (0..2).filter(|l| both & (1 << l) != 0) {
                let third = mesh.positions[corners[(k + 2) % 3] as usize];
                let height = (third - saws[l].frame.origin).dot(saws[l].frame.tangent);
                let outside = usize::from((height > 0.0) == (l == 1));
                seeds[l][outside].push(t as u32);
            }
            if on[point as usize] == 0 {
                let known = &mut first[point as usize];
                if *known == u32::MAX {
                    *known = t as u32;
                }
                unions.join(*known, t as u32);
            }
        }
    }
    let mut root = |list: &[u32]| {
        let mut roots: Vec<u32> = list.iter().map(|&t| unions.root(t)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots
    };
    let inside = root(&seeds[0][0]);
    let beyond = [root(&seeds[0][1]), root(&seeds[1][1])];
    let mixed = beyond.iter().flatten().any(|r| inside.contains(r));
    if inside.len() != 1 || mixed || root(&seeds[1][0]) != inside {
        return None;
    }
    let side = |t: usize| {
        let root = unions.root(t as u32);
        (0..2).find(|&k| own[t] && beyond[k].contains(&root))
    };
    Some((0..own.len()).map(side).collect())
}

/// The same by where the triangles lie, for meshes that cannot be cut.
fn by_place(mesh: &Mesh, own: &[bool], grown: &FilledStem, reach: [f64; 2]) -> Vec<Option<usize>> {
    let stem = &grown.stem;
    let axis = stem.grain.axis();
    let middle = 0.5 * (reach[0] + reach[1]);
    (0..own.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            let p = (a + b + c) / 3.0;
            let s = axis.length_at(p);
            let far = axis.frame(s).origin.distance(p);
            let within = s >= reach[0] && s <= reach[1];
            let filled = within && far < WIDE * stem.radius * stem.grain.scale(s);
            (own[t] && !filled).then(|| usize::from(s > middle))
        })
        .collect()
}

/// Closes a cut: the section as wood inside, facing along the stem or, for what lies beyond its end, against it.
fn cap(
    mesh: &mut Mesh,
    cut: &Loop,
    saw: &Saw,
    along: bool,
    grown: &FilledStem,
    square: SectionSquare,
    zone: &dyn Fn(f64) -> u8,
) -> Option<()> {
    let mut triangles = Vec::new();
    triangulate(&cut.section, &mut triangles).ok()?;
    let rings = &grown.stem.rings;
    let first = mesh.positions.len() as u32;
    let normal = if along {
        saw.frame.tangent
    } else {
        -saw.frame.tangent
    };
    for &p in &cut.places {
        let grain = grown.stem.grain.to_grain(p);
        let flat = grain.truncate();
        let (ring, _) = rings.address(flat);
        let on_texture = flat - square.middle + 0.5 * square.side;
        for (name, Attribute { width, data }) in &mut mesh.attributes {
            let x = saw.frame.x;
            let tangent = [x.x, x.y, x.z, if along { 1.0 } else { -1.0 }];
            let values: Vec<f64> = match (name.as_str(), *width) {
                ("NORMAL", 3) => normal.to_array().to_vec(),
                ("TANGENT", 4) => tangent.to_vec(),
                ("TEXCOORD_0", 2) => on_texture.to_array().to_vec(),
                ("_RING", 1) => vec![ring],
                ("_ZONE", 1) => vec![f64::from(zone(ring))],
                ("_GRAIN", 3) => grain.to_array().to_vec(),
                (name, width) if name.starts_with("COLOR_") => vec![1.0; width],
                (_, width) => vec![0.0; width],
            };
            data.extend(values.into_iter().map(|v| v as f32));
        }
        mesh.positions.push(p);
    }
    mesh.triangles.extend(triangles.into_iter().map(|t| {
        let [a, b, c] = t.map(|v| v + first);
        if along { [a, b, c] } else { [a, c, b] }
    }));
    mesh.materials.resize(mesh.triangles.len(), SAWN);
    Some(())
}
