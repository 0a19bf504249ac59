//! The rest of the input in a film: every part of it rigid, with the rods where it hangs on them.

use super::beyond::{Beyond, Root, SAWN};
use super::follow::Follower;
use super::{
    BARK_MATERIAL, FilmOptions, INNER_MATERIAL, OWN_MATERIALS, Run, SkinReport, turned, upright,
};
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fibre::scene::StemChoice;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::components::NONE;
use greenstick_geometry::film::Extra;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Binding, Film, Joint, Mesh, Node, Pose, Skinned};
use greenstick_skin::rods::{Part, RodSkin};
use greenstick_wood::stem::StemKind;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rods whose joints are no farther than this many of their distances behind the nearest one carry what hangs there.
const BESIDE: f64 = 1.5;

/// A part of the input that the rods do not fill.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CarriedPiece {
    /// Its name.
    pub name: String,
    /// The input's mesh that it is of.
    pub input: String,
    /// The piece of the skin whose rods carry it; none for what hangs on nothing and stands still.
    pub carried_by: Option<String>,
    /// Triangles.
    pub triangles: usize,
    /// Whether it is closed; what is open in the input stays open.
    pub closed: bool,
}

/// The rest of an input.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RestReport {
    /// Its parts.
    pub pieces: Vec<CarriedPiece>,
    /// Volume of the stem's real ends beyond the rods' ends, which is left out, m³.
    pub left_out_m3: f64,
    /// What could not be done as it should, a sentence each.
    pub notes: Vec<String>,
}

/// One part, in the stem's world.
pub(super) struct Carried {
    pub name: String,
    pub input: String,
    pub mesh: Mesh,
    /// Number of what carries it, among [`Rest::carriers`].
    pub by: Option<usize>,
}

/// All parts.
#[derive(Default)]
pub(super) struct Rest {
    pub parts: Vec<Carried>,
    /// Joints of the skin, and the piece of the skin that they are of.
    pub carriers: Vec<(Vec<u32>, usize)>,
    pub left: f64,
    pub notes: Vec<String>,
}

/// In the order of their names: those of the ends, those on the rods by the joint nearest to them, the others.
type Group = (usize, u32);
/// Triangles of each mesh.
type OfMeshes = BTreeMap<usize, Vec<u32>>;

impl Run {
    /// The rest of the input where `options` ask for it, told in the report.
    pub(super) fn rest_of(
        &self,
        skin: &RodSkin,
        options: &FilmOptions,
        report: &mut SkinReport,
    ) -> Rest {
        if !options.rest {
            return Rest::default();
        }
        let rest = self.rest(skin);
        let names: Vec<String> = report.pieces.iter().map(|p| p.name.clone()).collect();
        report.rest = rest.report(&names);
        rest
    }

    /// The rest of the input, where there is one.
    pub(super) fn rest(&self, skin: &RodSkin) -> Rest {
        if self.scene.stem.kind != StemChoice::Input {
            return Rest::default();
        }
        let proportions = BreakParameters::default().proportions();
        let zone = |rho: f64| proportions.zone_at(rho, 0.0).code();
        let beyond = Beyond::of(&self.grown, self.square, &zone);
        let mut rest = Rest {
            left: beyond.left,
            notes: beyond.notes,
            ..Rest::default()
        };
        let mut groups: BTreeMap<Group, (Option<usize>, OfMeshes)> = BTreeMap::new();
        for part in beyond.parts {
            let (group, joints) = self.carriers(skin, part.root);
            let (_, meshes) = groups.entry(group).or_insert_with(|| {
                let by = joints.map(|joints| {
                    rest.carriers.push(joints);
                    rest.carriers.len() - 1
                });
                (by, BTreeMap::new())
            });
            meshes.entry(part.mesh).or_default().extend(part.triangles);
        }
        let (mut twigs, mut still) = (0, 0);
        for ((kind, _), (by, meshes)) in groups {
            for (again, (mesh, triangles)) in meshes.into_iter().enumerate() {
                let name = match (kind, by) {
                    (0, _) => "rest_lower".to_owned(),
                    (1, _) => "rest_upper".to_owned(),
                    (_, Some(_)) => format!("twig_{twigs:03}"),
                    (_, None) => format!("standing_{still:03}"),
                };
                let own = again == 0 || by.is_none();
                let input = &beyond.meshes[mesh];
                rest.parts.push(Carried {
                    name: if own { name } else { format!("{name}_{again}") },
                    input: beyond.names[mesh].clone(),
                    mesh: self.part(input, &triangles),
                    by,
                });
                still += usize::from(by.is_none());
            }
            twigs += usize::from(kind == 2);
        }
        rest
    }

    /// The triangles of a mesh with the film's materials.
    fn part(&self, mesh: &Mesh, triangles: &[u32]) -> Mesh {
        let board = self.grown.stem.kind == StemKind::Board;
        let mut part = mesh.submesh(triangles.iter().map(|&t| t as usize));
        let listed = self.grown.scene.materials.len();
        for material in &mut part.materials {
            *material = match *material {
                SAWN => INNER_MATERIAL,
                m if m != NO_MATERIAL && (m as usize) < listed => OWN_MATERIALS + m,
                _ => u32::from(!board) * BARK_MATERIAL,
            };
        }
        add_tangents(&mut part);
        part
    }

    /// The joints that carry what hangs on a root, and the piece that they are of; with what hangs on the same.
    fn carriers(&self, skin: &RodSkin, root: Root) -> (Group, Option<(Vec<u32>, usize)>) {
        match root {
            Root::Nothing => ((3, 0), None),
            Root::End(k) => ((k, 0), Some(self.end(skin, k))),
            Root::At(point) => {
                let (nearest, joints) = self.beside(skin, point);
                ((2, nearest), Some(joints))
            }
        }
    }

    /// The last joints of the rods at an end, of that piece that has most rods there.
    fn end(&self, skin: &RodSkin, end: usize) -> (Vec<u32>, usize) {
        let along = &self.grown.placed.along;
        let mut last: Vec<Part> = vec![0; self.bundle.rods()];
        for &(rod, part) in skin.parts.iter().flatten() {
            let known = &mut last[rod as usize];
            *known = part.max(*known);
        }
        let at = |piece: &Vec<(u32, Part)>| -> Vec<u32> {
            let wanted = |&&(rod, part): &&(u32, Part)| part == [0, last[rod as usize]][end];
            let joint = |&(rod, part): &(u32, Part)| {
                let vertices = self.bundle.rod(rod as usize);
                let s = along[[vertices.start, vertices.end - 1][end]];
                heavier(skin.joints.at(rod, part, s))
            };
            piece.iter().filter(wanted).map(joint).collect()
        };
        let all = skin.parts.iter().map(at).enumerate();
        let most = all.max_by_key(|(k, joints)| (joints.len(), usize::MAX - k));
        most.map_or((Vec::new(), 0), |(piece, joints)| (joints, piece))
    }

    /// The joint nearest to a place on the stem, and those beside it in the same piece.
    fn beside(&self, skin: &RodSkin, point: DVec3) -> (u32, (Vec<u32>, usize)) {
        let s = self.grown.stem.grain.axis().length_at(point);
        let point = self.laid.transform_point3(point);
        let far = |joint: u32| skin.joints.rest[joint as usize].translation.distance(point);
        let mut joints: Vec<(f64, usize, u32)> = Vec::new();
        for (piece, parts) in skin.parts.iter().enumerate() {
            for &(rod, part) in parts {
                let joint = heavier(skin.joints.at(rod, part, s));
                joints.push((far(joint), piece, joint));
            }
        }
        let nearest = joints.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((least, piece, nearest)) = nearest else {
            return (0, (Vec::new(), 0));
        };
        let spacing = self.spacing();
        let near = |&&(d, p, _): &&(f64, usize, u32)| p == piece && d <= least + BESIDE * spacing;
        let near = joints.iter().filter(near).map(|j| j.2).collect();
        (nearest, (near, piece))
    }
}

/// Gives a mesh with normals and texture coordinates the tangents that normal maps want, as glTF has them, where it has
/// none.
fn add_tangents(mesh: &mut Mesh) {
    let of = |name: &str, width: usize| mesh.attributes.get(name).filter(|a| a.width == width);
    let (Some(normals), Some(coordinates)) = (of("NORMAL", 3), of("TEXCOORD_0", 2)) else {
        return;
    };
    if mesh.attributes.contains_key("TANGENT") {
        return;
    }
    let mut sums = vec![[DVec3::ZERO; 2]; mesh.positions.len()];
    let at = |v: u32| {
        let uv = coordinates.at(v as usize);
        DVec2::new(uv[0].into(), uv[1].into())
    };
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let [p, q, r] = mesh.corners(t);
        let (e, f, u, v) = (q - p, r - p, at(b) - at(a), at(c) - at(a));
        let sign = u.perp_dot(v).signum();
        for corner in [a, b, c] {
            let sum = &mut sums[corner as usize];
            sum[0] += (e * v.y - f * u.y) * sign;
            sum[1] += (f * u.x - e * v.x) * sign;
        }
    }
    let mut data = Vec::with_capacity(4 * sums.len());
    for (v, [along, other]) in sums.into_iter().enumerate() {
        let n = normals.at(v);
        let n = DVec3::new(n[0].into(), n[1].into(), n[2].into()).normalize_or(DVec3::Z);
        let t = along.reject_from_normalized(n).try_normalize();
        let t = t.unwrap_or_else(|| n.any_orthonormal_vector());
        let hand = if n.cross(t).dot(other) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let [x, y, z] = t.as_vec3().to_array();
        data.extend([x, y, z, hand]);
    }
    let tangents = Attribute { width: 4, data };
    mesh.attributes.insert("TANGENT".into(), tangents);
}

fn heavier([a, b]: [(u32, f64); 2]) -> u32 {
    if a.1 > b.1 { a.0 } else { b.0 }
}

/// Whether no edge of a mesh is open.
fn is_closed(mesh: &Mesh) -> bool {
    let adjacency = mesh.adjacency();
    adjacency.neighbours.iter().flatten().all(|&n| n != NONE)
}

impl Rest {
    /// What it is made of; `names` are those of the skin's pieces.
    pub fn report(&self, names: &[String]) -> RestReport {
        let piece = |part: &Carried| CarriedPiece {
            name: part.name.clone(),
            input: part.input.clone(),
            carried_by: (part.by).and_then(|by| names.get(self.carriers[by].1).cloned()),
            triangles: part.mesh.triangles.len(),
            closed: is_closed(&part.mesh),
        };
        RestReport {
            pieces: self.parts.iter().map(piece).collect(),
            left_out_m3: self.left,
            notes: self.notes.clone(),
        }
    }

    /// Adds it to a film of the skin whose first joints are the rods', with joints of its own behind all others; gives how
    /// those move. `lever` is the stem's radius.
    pub fn join(self, film: &mut Film, laid: &DAffine3, lever: f64) -> Vec<Follower> {
        let up = upright();
        let map = DAffine3::from_quat(up) * *laid;
        let rest: Vec<Pose> = film.joints.iter().map(|j| j.rest).collect();
        let first = film.joints.len() as u32;
        let followers: Vec<Follower> = (self.carriers.into_iter())
            .map(|(joints, _)| Follower::new(joints, &rest, lever))
            .collect();
        film.joints
            .extend(followers.iter().enumerate().map(|(k, f)| Joint {
                name: format!("carrier_{k}"),
                rest: f.at_rest(),
            }));
        for part in self.parts {
            let mesh = part.mesh.transformed(&map);
            let Some(by) = part.by else {
                film.fixed.push(Node {
                    name: part.name,
                    transform: DAffine3::IDENTITY,
                    mesh: mesh.into(),
                    parent: None,
                });
                continue;
            };
            film.pieces.push(Skinned {
                binding: Binding::rigid(mesh.positions.len(), first + by as u32),
                name: part.name,
                mesh,
                extras: BTreeMap::from([("input".into(), Extra::Text(part.input))]),
                ..Skinned::default()
            });
        }
        followers
    }
}

/// Poses of followers behind those of the joints that they follow.
pub(super) fn put(followers: &[Follower], poses: &mut [Pose]) {
    let (own, behind) = poses.split_at_mut(poses.len() - followers.len());
    for (to, follower) in behind.iter_mut().zip(followers) {
        *to = follower.pose(own);
    }
}

/// The movement of poses from the scene's axes to those of files.
pub(super) fn upright_poses(poses: Vec<Pose>) -> Vec<Pose> {
    let up = upright();
    poses.into_iter().map(|p| turned(p, up)).collect()
}
