//! The parts that rods carry: their names, what carries them, and how they join a film.

use super::attach::Attachment;
use super::follower::Follower;
use super::split::{CUT_FACE_MATERIAL, Remainder, StemMesh};
use super::tangents::add_tangents;
use crate::rods::{Materials, RodPart, RodSkin, Wood};
use glam::{DAffine3, DVec3};
use greenstick_geometry::film::Extra;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{
    Binding, Cancelled, Context, Film, Joint, Mesh, Node, Pose, SkinnedMesh,
};
use std::collections::BTreeMap;

/// Rods whose joints are no farther than this many of their distances behind the nearest one carry what hangs there.
const CARRYING_DISTANCE: f64 = 1.5;

/// A part of the input that rods do not fill.
#[derive(Debug, Clone, PartialEq)]
pub struct CarriedPart {
    /// Its name: `rest_lower`, `rest_upper`, `twig_000` and so on, `standing_000` and so on.
    pub name: String,
    /// Name of the node that it is of.
    pub input: String,
    /// Its mesh, m, in the stem's world.
    pub mesh: Mesh,
    /// Index of what carries it, in [`CarriedParts::carriers`]; `None` for what hangs on nothing and stands still.
    pub carrier: Option<usize>,
}

/// Rods that carry parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Carrier {
    /// Joints of the skin.
    pub joints: Vec<u32>,
    /// The piece of the skin that they are of.
    pub piece: usize,
}

/// All parts that rods do not fill.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CarriedParts {
    /// The parts.
    pub parts: Vec<CarriedPart>,
    /// What carries them.
    pub carriers: Vec<Carrier>,
    /// Volume of the stem's real ends beyond the rods' ends, which is left out, m³.
    pub left_out_volume: f64,
    /// What could not be done as it should, a sentence each.
    pub notes: Vec<String>,
}

/// What parts hang on, in the order of their names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Group {
    LowerEnd,
    UpperEnd,
    /// The joint nearest to them.
    Rods(u32),
    Nothing,
}

/// The parts of one group: what carries them, and the triangles of each mesh.
type GroupParts = (Option<usize>, BTreeMap<usize, Vec<u32>>);

impl CarriedParts {
    /// Finds what rods do not fill of `input`, and the joints of `skin` that carry it.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn find(
        input: &StemMesh,
        wood: &Wood,
        skin: &RodSkin,
        materials: &Materials,
        context: &Context,
    ) -> Result<Self, Cancelled> {
        let remainder = Remainder::split_off(input, wood, materials, context)?;
        let mut carried = CarriedParts {
            left_out_volume: remainder.left_out_volume,
            notes: remainder.notes,
            ..CarriedParts::default()
        };
        let mut groups: BTreeMap<Group, GroupParts> = BTreeMap::new();
        for part in remainder.parts {
            context.check()?;
            let (group, carrier) = find_carrier(wood, skin, part.attachment);
            let (_, meshes) = groups.entry(group).or_insert_with(|| {
                let index = carrier.map(|carrier| {
                    carried.carriers.push(carrier);
                    carried.carriers.len() - 1
                });
                (index, BTreeMap::new())
            });
            meshes.entry(part.mesh).or_default().extend(part.triangles);
        }
        let (mut twigs, mut standing) = (0, 0);
        for (group, (carrier, meshes)) in groups {
            for (number, (mesh, triangles)) in meshes.into_iter().enumerate() {
                let name = match group {
                    Group::LowerEnd => "rest_lower".to_owned(),
                    Group::UpperEnd => "rest_upper".to_owned(),
                    Group::Rods(_) => format!("twig_{twigs:03}"),
                    Group::Nothing => format!("standing_{standing:03}"),
                };
                let is_first = number == 0 || carrier.is_none();
                let source = &remainder.meshes[mesh];
                let listed = input.scene.materials.len();
                carried.parts.push(CarriedPart {
                    name: if is_first {
                        name
                    } else {
                        format!("{name}_{number}")
                    },
                    input: remainder.names[mesh].clone(),
                    mesh: part_mesh(source, &triangles, listed, materials),
                    carrier,
                });
                standing += usize::from(carrier.is_none());
            }
            twigs += usize::from(matches!(group, Group::Rods(_)));
        }
        Ok(carried)
    }

    /// Adds the parts to a film whose first joints are those of the skin, with joints of their own behind all others.
    /// Returns how these move. `film_from_stem` maps the stem's world to the film's, and `lever` is the stem's radius, m.
    pub fn add_to_film(
        self,
        film: &mut Film,
        film_from_stem: &DAffine3,
        lever: f64,
    ) -> Vec<Follower> {
        let rest: Vec<Pose> = film.joints.iter().map(|j| j.rest).collect();
        let first = film.joints.len() as u32;
        let followers: Vec<Follower> = (self.carriers.into_iter())
            .map(|carrier| Follower::new(carrier.joints, &rest, lever))
            .collect();
        let joint = |(k, follower): (usize, &Follower)| Joint {
            name: format!("carrier_{k}"),
            rest: follower.at_rest(),
        };
        film.joints.extend(followers.iter().enumerate().map(joint));
        for part in self.parts {
            let mesh = part.mesh.transformed(film_from_stem);
            match part.carrier {
                None => {
                    (film.fixed).push(Node::new(part.name, DAffine3::IDENTITY, mesh));
                }
                Some(carrier) => film.pieces.push(SkinnedMesh {
                    binding: Binding::rigid(mesh.positions.len(), first + carrier as u32),
                    name: part.name,
                    mesh,
                    extras: BTreeMap::from([("input".into(), Extra::Text(part.input))]),
                    ..SkinnedMesh::default()
                }),
            }
        }
        followers
    }
}

/// Returns some triangles of a mesh with the materials of the film. The input lists `listed` materials.
fn part_mesh(mesh: &Mesh, triangles: &[u32], listed: usize, materials: &Materials) -> Mesh {
    let mut part = mesh.submesh(triangles.iter().map(|&t| t as usize));
    for material in &mut part.materials {
        *material = match *material {
            CUT_FACE_MATERIAL => materials.inner,
            m if m != NO_MATERIAL && (m as usize) < listed => materials.bark_mesh_offset + m,
            _ => materials.bark,
        };
    }
    add_tangents(&mut part);
    part
}

/// Returns the rods that carry what is attached there, and the group of all that hangs on the same.
fn find_carrier(wood: &Wood, skin: &RodSkin, attachment: Attachment) -> (Group, Option<Carrier>) {
    match attachment {
        Attachment::Nothing => (Group::Nothing, None),
        Attachment::RodEnd(end) => {
            let group = [Group::LowerEnd, Group::UpperEnd][end];
            (group, Some(end_carrier(wood, skin, end)))
        }
        Attachment::Rods(point) => {
            let (nearest, carrier) = nearest_carrier(wood, skin, point);
            (Group::Rods(nearest), Some(carrier))
        }
    }
}

/// Returns the last joints of the rods at an end, of that piece that has most rods there.
fn end_carrier(wood: &Wood, skin: &RodSkin, end: usize) -> Carrier {
    let mut last: Vec<RodPart> = vec![0; wood.bundle.rods()];
    for &(rod, part) in skin.parts.iter().flatten() {
        let known = &mut last[rod as usize];
        *known = part.max(*known);
    }
    let joints_at_end = |piece: &Vec<(u32, RodPart)>| -> Vec<u32> {
        let is_last = |&&(rod, part): &&(u32, RodPart)| part == [0, last[rod as usize]][end];
        let joint = |&(rod, part): &(u32, RodPart)| {
            let vertices = wood.bundle.rod(rod as usize);
            let s = wood.along[[vertices.start, vertices.end - 1][end]];
            heavier_joint(skin.joints.weights_at(rod, part, s))
        };
        piece.iter().filter(is_last).map(joint).collect()
    };
    let pieces = skin.parts.iter().map(joints_at_end).enumerate();
    let most = pieces.max_by_key(|(k, joints)| (joints.len(), usize::MAX - k));
    most.map_or_else(Carrier::default, |(piece, joints)| Carrier {
        joints,
        piece,
    })
}

/// Returns the joint nearest to a point on the stem, and those beside it in the same piece.
fn nearest_carrier(wood: &Wood, skin: &RodSkin, point: DVec3) -> (u32, Carrier) {
    let s = wood.stem.grain.axis().length_at(point);
    let point = wood.stem_to_rods.transform_point3(point);
    let distance = |joint: u32| (skin.joints.rest[joint as usize].translation).distance(point);
    let mut joints: Vec<(f64, usize, u32)> = Vec::new();
    for (piece, parts) in skin.parts.iter().enumerate() {
        for &(rod, part) in parts {
            let joint = heavier_joint(skin.joints.weights_at(rod, part, s));
            joints.push((distance(joint), piece, joint));
        }
    }
    let nearest = joints.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((least, piece, nearest)) = nearest else {
        return (0, Carrier::default());
    };
    let limit = least + CARRYING_DISTANCE * wood.spacing();
    let near = |&&(d, p, _): &&(f64, usize, u32)| p == piece && d <= limit;
    let joints = joints.iter().filter(near).map(|j| j.2).collect();
    (nearest, Carrier { joints, piece })
}

fn heavier_joint([a, b]: [(u32, f64); 2]) -> u32 {
    if a.1 > b.1 { a.0 } else { b.0 }
}
