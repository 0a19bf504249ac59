//! Poses of joints, and pieces in them. Stills and films have y up.

use super::placement::Placement;
use crate::rods::RodSkin;
use glam::{DAffine3, DVec3};
use greenstick_fibre::scene::Scene as Setting;
use greenstick_geometry::{Film, Joint, Node, Pose, SkinnedMesh};

/// Returns the corners of a box.
pub(super) fn corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let pick = |axis: usize| [low, high][k >> axis & 1][axis];
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// Returns the pieces of a film in a frame in which its joints have these poses.
pub(super) fn posed_pieces(film: &Film, frame: usize, poses: &[Pose]) -> Vec<Node> {
    let (mut maps, mut normals) = (Vec::new(), Vec::new());
    film.joint_maps(poses, &mut maps);
    let piece = |(number, piece): (usize, &SkinnedMesh)| {
        let mut mesh = piece.mesh.clone();
        film.deform_positions_at(frame, number, &maps, &mut mesh.positions);
        film.deform_normals_at(frame, number, &maps, &mut normals);
        if let Some(attribute) = mesh.attributes.get_mut("TANGENT") {
            let at_rest: Vec<[f32; 3]> = (attribute.data.as_chunks::<4>().0.iter())
                .map(|&[x, y, z, _]| [x, y, z])
                .collect();
            let mut turned = Vec::new();
            film.deform_directions_at(frame, number, &maps, &at_rest, &mut turned);
            for (to, t) in attribute.data.chunks_exact_mut(4).zip(turned) {
                to[..3].copy_from_slice(&t.as_vec3().to_array());
            }
        }
        if let Some(attribute) = mesh.attributes.get_mut("NORMAL") {
            attribute.data = normals
                .iter()
                .flat_map(|n| n.as_vec3().to_array())
                .collect();
        }
        Node {
            is_detail: piece.is_detail,
            ..Node::new(piece.name.clone(), DAffine3::IDENTITY, mesh)
        }
    };
    film.pieces.iter().enumerate().map(piece).collect()
}

/// Returns the pieces and joints of a skin as a film with y up, without materials and bodies.
pub(super) fn film_from_skin(skin: RodSkin, scene: &Setting, placement: &Placement) -> Film {
    let map = placement.map();
    let mut film = Film {
        frames_per_second: scene.frames_per_second,
        ..Film::default()
    };
    film.joints = (skin
        .joints
        .rest
        .iter()
        .zip(skin.joints.vertices())
        .enumerate())
    .map(|(joint, (&rest, vertex))| Joint {
        name: format!("vertex_{vertex}_{joint}"),
        rest: placement.pose(rest),
    })
    .collect();
    film.pieces = skin.pieces;
    for piece in &mut film.pieces {
        piece.mesh = piece.mesh.transformed(&map);
        let rest = &mut piece.earlier.rest;
        rest.iter_mut().for_each(|p| *p = map.transform_point3(*p));
    }
    film
}
