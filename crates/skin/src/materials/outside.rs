//! The outside of a stem that came without a material: coordinates on its baked textures, and sawn wood at the ends.

use super::textured::{REPEATING, textured};
use crate::prepared::PreparedStem;
use crate::texture::{PlanedFaces, WoodTextures};
use glam::{DVec2, DVec3};
use greenstick_geometry::{Attribute, Material, Mesh, Scene};
use greenstick_wood::appearance::faces_pith;
use greenstick_wood::stem::StemKind;
use rustc_hash::FxHashMap;
use std::f64::consts::{PI, TAU};

/// Names of the materials of the outside of sawn wood and of poles, and of the ends and bores of stems.
const PLANED_NAME: &str = "planed_wood";
const WEATHERED_NAME: &str = "weathered_wood";
const SAWN_NAME: &str = "sawn_wood";
/// Cosine of the angle to the grain within which a face of the outside is a sawn end.
const SAWN_COSINE: f64 = 0.9;

/// What a triangle of the outside shows.
enum Outside {
    Skin([DVec2; 3]),
    Sawn([DVec2; 3]),
}

/// Gives the material `bark` its textures and the triangles that have it their coordinates. Ends get the wood inside, whose
/// material is the last of the scene.
pub(super) fn dress_outside(
    scene: &mut Scene,
    bark: u32,
    prepared: &PreparedStem,
    outside: &WoodTextures,
) {
    let name = match prepared.found.stem.kind {
        StemKind::Round => scene.materials[bark as usize].name.clone(),
        StemKind::Board | StemKind::Dowel => PLANED_NAME.into(),
        StemKind::Pole => WEATHERED_NAME.into(),
    };
    scene.materials[bark as usize] = repeating(scene, &name, outside);
    let sawn = scene.materials.len() as u32;
    let mut ends = scene.materials[sawn as usize - 1].clone();
    ends.name = SAWN_NAME.into();
    let mut has_ends = false;
    for node in &mut scene.nodes {
        if node.mesh.materials.contains(&bark) {
            let to_world = node.transform;
            has_ends |= dress(node.mesh_mut(), bark, sawn, |mesh, t| {
                on_stem(mesh, t, prepared).unwrap_or_else(|| {
                    let corners = mesh.corners(t).map(|p| to_world.transform_point3(p));
                    Outside::Skin(off_the_limb(corners, prepared.found.stem.radius))
                })
            });
        }
    }
    if has_ends {
        scene.materials.push(ends);
    }
}

/// A material of the outside, whose textures repeat along the stem and about it.
pub(super) fn repeating(scene: &mut Scene, name: &str, baked: &WoodTextures) -> Material {
    textured(scene, name, baked, REPEATING, None)
}

/// Returns what a triangle on the limb shows, `None` off it.
fn on_stem(mesh: &Mesh, t: usize, prepared: &PreparedStem) -> Option<Outside> {
    let (stem, square) = (&prepared.found.stem, &prepared.square);
    let attribute = mesh.attributes.get("_GRAIN").filter(|a| a.width == 3)?;
    let grain = mesh.triangles[t].map(|v| {
        let g = attribute.at(v as usize);
        DVec3::new(g[0].into(), g[1].into(), g[2].into())
    });
    // Vertices off the limb have no grain coordinates.
    if grain.contains(&DVec3::ZERO) {
        return None;
    }
    let normal = (grain[1] - grain[0]).cross(grain[2] - grain[0]);
    if normal.z * normal.z > SAWN_COSINE * SAWN_COSINE * normal.length_squared() {
        return Some(Outside::Sawn(grain.map(|g| square.end_grain(g.truncate()))));
    }
    let middle = (grain[0] + grain[1] + grain[2]) / 3.0;
    if !stem.kind.is_sawn() && faces_pith(stem, middle, normal) {
        let side = |g: DVec3| square.side_grain(stem.rings.address(g.truncate()).0, 0.0, g.z);
        return Some(Outside::Sawn(grain.map(side)));
    }
    let coordinates = match stem.kind {
        StemKind::Board | StemKind::Dowel | StemKind::Pole => {
            let faces = PlanedFaces::of_stem(stem, *square);
            grain.map(|g| faces.coordinates(g, normal.truncate()))
        }
        StemKind::Round => {
            let pith = stem.rings.pith();
            let angle = |g: DVec3| libm::atan2(g.y - pith.y, g.x - pith.x);
            let about = angle((grain[0] + grain[1] + grain[2]) / 3.0);
            let around = TAU * stem.radius;
            grain.map(|g| {
                // All corners lie on one side of the seam behind the pith, by whole turns.
                let turned = angle(g) - about;
                let turns = if turned > PI {
                    -1.0
                } else if turned < -PI {
                    1.0
                } else {
                    0.0
                };
                DVec2::new(angle(g) / TAU + turns, g.z / around)
            })
        }
    };
    Some(Outside::Skin(coordinates))
}

/// Coordinates off the limb, where no axis is known: the plane of the world that a triangle with these corners (m) faces most.
fn off_the_limb(corners: [DVec3; 3], radius: f64) -> [DVec2; 3] {
    let normal = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .abs();
    let around = TAU * radius;
    corners.map(|p| {
        let flat = if normal.y > normal.x.max(normal.z) {
            DVec2::new(p.x, p.z)
        } else if normal.x > normal.z {
            DVec2::new(p.z, p.y)
        } else {
            DVec2::new(p.x, p.y)
        };
        flat / around
    })
}

/// Gives the triangles of `bark` their coordinates, and those at ends the material `sawn`. Returns whether there are any of
/// the latter. Vertices that triangles use with different coordinates are doubled.
fn dress(mesh: &mut Mesh, bark: u32, sawn: u32, shown: impl Fn(&Mesh, usize) -> Outside) -> bool {
    // They would belong to other coordinates.
    mesh.attributes.remove("TANGENT");
    keep_own_coordinates(mesh, bark);
    let name = "TEXCOORD_0";
    let mut uv: Vec<[f32; 2]> = match mesh.attributes.get(name).filter(|a| a.width == 2) {
        Some(known) => known.data.chunks_exact(2).map(|c| [c[0], c[1]]).collect(),
        None => vec![[0.0; 2]; mesh.positions.len()],
    };
    let count = uv.len();
    let mut taken = vec![false; count];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        if mesh.materials[t] != bark {
            corners.iter().for_each(|&v| taken[v as usize] = true);
        }
    }
    let mut copies: FxHashMap<(u32, [u32; 2]), u32> = FxHashMap::default();
    let mut origin: Vec<u32> = (0..count as u32).collect();
    let mut has_ends = false;
    for t in 0..mesh.triangles.len() {
        if mesh.materials[t] != bark {
            continue;
        }
        let coordinates = match shown(mesh, t) {
            Outside::Skin(coordinates) => coordinates,
            Outside::Sawn(coordinates) => {
                mesh.materials[t] = sawn;
                has_ends = true;
                coordinates
            }
        };
        for (k, at) in coordinates.iter().enumerate() {
            let v = mesh.triangles[t][k];
            let at = at.as_vec2().to_array();
            if !taken[v as usize] {
                taken[v as usize] = true;
                uv[v as usize] = at;
            }
            if uv[v as usize] != at {
                let copy = copies.entry((v, at.map(f32::to_bits))).or_insert_with(|| {
                    origin.push(v);
                    uv.push(at);
                    origin.len() as u32 - 1
                });
                mesh.triangles[t][k] = *copy;
            }
        }
    }
    let added = &origin[count..];
    let positions: Vec<DVec3> = (added.iter().map(|&v| mesh.positions[v as usize])).collect();
    mesh.positions.extend(positions);
    for attribute in mesh.attributes.values_mut() {
        let width = attribute.width;
        for &v in added {
            let at = v as usize * width;
            attribute.data.extend_from_within(at..at + width);
        }
    }
    let coordinates = Attribute {
        width: 2,
        data: uv.into_flattened(),
    };
    mesh.attributes.insert(name.to_owned(), coordinates);
    has_ends
}

/// Keeps the coordinates that the input gave the triangles of `bark` as the next set of the mesh. Without any they are all 0.
fn keep_own_coordinates(mesh: &mut Mesh, bark: u32) {
    let Some(known) = mesh.attributes.get("TEXCOORD_0") else {
        return;
    };
    let of_bark = |t: &usize| mesh.material(*t) == bark;
    let mut corners = (0..mesh.triangles.len())
        .filter(of_bark)
        .flat_map(|t| mesh.triangles[t]);
    if !corners.any(|v| known.at(v as usize).iter().any(|c| *c != 0.0)) {
        return;
    }
    let own = known.clone();
    let names = (1..).map(|set| format!("TEXCOORD_{set}"));
    let mut free = names.filter(|name| !mesh.attributes.contains_key(name.as_str()));
    if let Some(name) = free.next() {
        mesh.attributes.insert(name, own);
    }
}
