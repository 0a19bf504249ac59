//! Cutting the rest of a mesh off the stretch of a stem that rods fill.

use super::attach::{Attachment, Wood as AttachedWood, attach_loose_shells};
use super::plane_cut::{CutLoop, CutPlane, cut_across_stem};
use super::sides::{sides_by_position, sides_of_loops};
use crate::prepared::unmirror;
use crate::rods::{Materials, Wood};
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::triangulate::triangulate;
use greenstick_geometry::{Attribute, Cancelled, Context, Mesh, Scene};
use std::collections::BTreeMap;

/// Material of cut faces among those of [`Remainder::meshes`]: the wood inside.
pub(super) const CUT_FACE_MATERIAL: u32 = u32::MAX - 1;
/// A real end of the stem that stands out of the rods no farther than this many radii is left out: the rods' own ends stand
/// for it.
const MAX_STUMP_LENGTH: f64 = 0.5;

/// The meshes that a stem was found in, and its place among them.
#[derive(Clone, Copy)]
pub struct StemMesh<'a> {
    /// The scene, in the stem's world, m.
    pub scene: &'a Scene,
    /// The node that the stem is part of.
    pub node: usize,
    /// The triangles of that node that bound the stem.
    pub shell: &'a [u32],
}

/// A part of one of the meshes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RemainderPart {
    pub mesh: usize,
    pub triangles: Vec<u32>,
    pub attachment: Attachment,
}

/// What rods do not fill of a scene, in the stem's world, m.
#[derive(Debug, Clone, Default)]
pub(super) struct Remainder {
    pub meshes: Vec<Mesh>,
    pub names: Vec<String>,
    pub parts: Vec<RemainderPart>,
    /// Volume of real ends that are left out, m³.
    pub left_out_volume: f64,
    /// What could not be done as it should, a sentence each.
    pub notes: Vec<String>,
}

/// The stem's own shell in its mesh: which triangles are of it, and beyond which end of the rods each is.
struct SplitShell {
    own: Vec<bool>,
    /// `Some(end)` beyond the rods' end, `Some(2 + end)` for a real end that is left out, `None` along the rods.
    side: Vec<Option<usize>>,
}

impl Remainder {
    /// Splits what rods do not fill off a scene.
    pub fn split_off(
        input: &StemMesh,
        wood: &Wood,
        materials: &Materials,
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let mut remainder = Remainder::default();
        for node in &input.scene.nodes {
            context.check()?;
            let mut node = node.clone();
            unmirror(&mut node);
            let mut mesh = node.mesh.transformed(&node.transform);
            mesh.materials.resize(mesh.triangles.len(), NO_MATERIAL);
            remainder.meshes.push(mesh);
            remainder.names.push(node.name);
        }
        let mesh = &mut remainder.meshes[input.node];
        add_stem_attributes(mesh, wood, materials);
        let mut own = vec![false; mesh.triangles.len()];
        input.shell.iter().for_each(|&t| own[t as usize] = true);
        let shell = remainder.cut_shell(input.node, own, wood, materials);
        context.check()?;
        remainder.attach(input.node, &shell, wood.stem.radius, context)?;
        Ok(remainder)
    }

    /// Cuts the stem's own shell where the rods end.
    fn cut_shell(
        &mut self,
        node: usize,
        mut own: Vec<bool>,
        wood: &Wood,
        materials: &Materials,
    ) -> SplitShell {
        let mesh = &mut self.meshes[node];
        let along = wood.along;
        let range = [
            along.iter().copied().fold(f64::INFINITY, f64::min),
            along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ];
        let planes = range.map(|s| cut_plane(wood, s));
        let cuts = [0, 1].map(|end| cut_across_stem(mesh, &mut own, &planes[end]));
        let split = match &cuts {
            [Some(a), Some(b)] => sides_of_loops(mesh, &own, [a, b], &planes),
            _ => None,
        };
        let Some(side) = split else {
            self.notes.push(
                "the mesh is not sound where the rods end, so that its rest begins at whole triangles and is open there"
                    .into(),
            );
            let side = sides_by_position(mesh, &own, wood.stem, range);
            return SplitShell { own, side };
        };
        let mut shell = SplitShell { own, side };
        for (end, cut) in cuts.iter().flatten().enumerate() {
            self.close_end(node, &mut shell, (end, cut), &planes[end], wood, materials);
        }
        shell
    }

    /// Closes what lies beyond an end of the rods where it was cut, or leaves it out where it is a stump.
    fn close_end(
        &mut self,
        node: usize,
        shell: &mut SplitShell,
        (end, cut): (usize, &CutLoop),
        plane: &CutPlane,
        wood: &Wood,
        materials: &Materials,
    ) {
        let mesh = &mut self.meshes[node];
        let SplitShell { own, side } = shell;
        let beyond = side.iter().enumerate().filter(|(_, s)| **s == Some(end));
        let outwards = [-1.0, 1.0][end];
        let length = beyond
            .flat_map(|(t, _)| mesh.corners(t))
            .map(|p| outwards * plane.height(p))
            .fold(0.0, f64::max);
        let stem = wood.stem;
        let real = [stem.ends.0, stem.ends.1][end];
        let is_stump = real && length < MAX_STUMP_LENGTH * plane.radius;
        let first = mesh.triangles.len();
        if !close_cut(mesh, cut, plane, end == 0, wood, materials) {
            self.notes.push(format!(
                "the rest {} the rods is left open where it was cut: the section there crosses itself",
                ["before", "behind"][end]
            ));
        }
        own.resize(mesh.triangles.len(), true);
        side.resize(mesh.triangles.len(), Some(end));
        if is_stump {
            let stump = (0..side.len()).filter(|&t| side[t] == Some(end));
            self.left_out_volume += mesh.submesh(stump).volume();
            // Nothing but what may hang on it is carried.
            mesh.triangles.truncate(first);
            mesh.materials.truncate(first);
            own.truncate(first);
            side.truncate(first);
            let stump = side.iter_mut().filter(|s| **s == Some(end));
            stump.for_each(|s| *s = Some(2 + end));
        }
    }

    /// Finds what every other shell hangs on, and lists the parts.
    fn attach(
        &mut self,
        node: usize,
        shell: &SplitShell,
        radius: f64,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let SplitShell { own, side } = shell;
        let stem: Vec<usize> = (0..own.len()).filter(|&t| own[t]).collect();
        for end in 0..2 {
            let beyond = stem.iter().filter(|&&t| side[t] == Some(end));
            let triangles: Vec<u32> = beyond.map(|&t| t as u32).collect();
            if !triangles.is_empty() {
                self.parts.push(RemainderPart {
                    mesh: node,
                    triangles,
                    attachment: Attachment::RodEnd(end),
                });
            }
        }
        let trunk = AttachedWood::new(
            self.meshes[node].submesh(stem.iter().copied()),
            stem.iter()
                .map(|&t| side[t].map(|s| Attachment::RodEnd(s % 2)))
                .collect(),
        );
        let mut loose: Vec<(usize, Vec<u32>)> = Vec::new();
        for (k, mesh) in self.meshes.iter().enumerate() {
            context.check()?;
            let shells = mesh.shells();
            let mut of_shell: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
            for (t, &shell) in shells.of_triangle.iter().enumerate() {
                if k != node || !own[t] {
                    of_shell.entry(shell).or_default().push(t as u32);
                }
            }
            loose.extend(of_shell.into_values().map(|triangles| (k, triangles)));
        }
        let attachments = attach_loose_shells(&self.meshes, &loose, trunk, radius, context)?;
        for ((mesh, triangles), attachment) in loose.into_iter().zip(attachments) {
            self.parts.push(RemainderPart {
                mesh,
                triangles,
                attachment,
            });
        }
        Ok(())
    }
}

/// Returns the plane across the stem at the length `s` along its axis, m.
fn cut_plane(wood: &Wood, s: f64) -> CutPlane {
    let distance = |length: f64| (length - s).abs();
    let nearest = (wood.stem.sections.iter())
        .min_by(|a, b| distance(a.length).total_cmp(&distance(b.length)));
    let (centroid, area) = nearest.map_or_else(Default::default, |n| (n.centroid, n.area));
    CutPlane {
        frame: wood.stem.grain.axis().frame(s),
        expected_centroid: centroid,
        expected_area: area,
        radius: (area / std::f64::consts::PI).sqrt(),
    }
}

/// Adds the stem's ring, zone and grain coordinates to a mesh that has none, and texture coordinates where it has none.
fn add_stem_attributes(mesh: &mut Mesh, wood: &Wood, materials: &Materials) {
    let stem = wood.stem;
    let count = mesh.positions.len();
    let (mut grain, mut coordinates) = (Vec::new(), Vec::new());
    for &p in &mesh.positions {
        let g = stem.grain.to_grain(p);
        grain.extend(g.as_vec3().to_array());
        let (rho, _) = stem.rings.address(g.truncate());
        let at = materials.square.side_grain(rho, 0.0, g.z);
        coordinates.extend(at.as_vec2().to_array());
    }
    let zone = f32::from((materials.zone)(1.0));
    for (name, width, data) in [
        ("TEXCOORD_0", 2, coordinates),
        ("_RING", 1, vec![1.0; count]),
        ("_ZONE", 1, vec![zone; count]),
        ("_GRAIN", 3, grain),
    ] {
        let attribute = Attribute { width, data };
        mesh.attributes.entry(name.into()).or_insert(attribute);
    }
}

/// Closes a cut: the section as wood inside, facing along the stem or against it. Returns false, and changes nothing, where
/// the section crosses itself.
fn close_cut(
    mesh: &mut Mesh,
    cut: &CutLoop,
    plane: &CutPlane,
    along: bool,
    wood: &Wood,
    materials: &Materials,
) -> bool {
    let mut triangles = Vec::new();
    if triangulate(&cut.section, &mut triangles).is_err() {
        return false;
    }
    let Materials { square, zone, .. } = materials;
    let stem = wood.stem;
    let first = mesh.positions.len() as u32;
    let sign = if along { 1.0 } else { -1.0 };
    let normal = plane.frame.tangent * sign;
    for &p in &cut.positions {
        let grain = stem.grain.to_grain(p);
        let flat = grain.truncate();
        let (ring, _) = stem.rings.address(flat);
        let on_texture = square.end_grain(flat);
        for (name, Attribute { width, data }) in &mut mesh.attributes {
            let x = plane.frame.x;
            let values: Vec<f64> = match (name.as_str(), *width) {
                ("NORMAL", 3) => normal.to_array().to_vec(),
                ("TANGENT", 4) => vec![x.x, x.y, x.z, sign],
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
    mesh.materials
        .resize(mesh.triangles.len(), CUT_FACE_MATERIAL);
    true
}
