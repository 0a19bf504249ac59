//! What a close-up of a frame shows.

use crate::view;
use glam::DVec3;
use greenstick_geometry::{Node, Scene};

/// Distance of a piece's faces from the middle of all of them, over the radius that is shown, from which on the pieces are too far from
/// each other to be shown in one.
const APART: f64 = 0.7;
/// Pieces of less than this share of the wood are splinters, which may fly far.
const SPLINTER_SHARE: f64 = 0.01;

/// Returns centre and radius (m) of what a close-up of `diameters` diameters of a stem shows, as [`view::close_up`]; of pieces that have
/// come so far apart that it would show what is between them, the faces of the largest one.
pub fn close_up(scene: &Scene, inner: &[u32], diameters: f64) -> Option<(DVec3, f64)> {
    let (centre, radius) = view::close_up(scene, inner, diameters)?;
    let of_piece = |node: &Node| {
        let alone = Scene {
            nodes: vec![node.clone()],
            ..Scene::default()
        };
        view::close_up(&alone, inner, diameters)
    };
    let pieces = scene.nodes.iter().filter(|node| !node.is_detail);
    let pieces = pieces.filter_map(|node| Some((node.mesh.volume(), of_piece(node)?.0)));
    let pieces: Vec<(f64, DVec3)> = pieces.collect();
    let whole: f64 = pieces.iter().map(|piece| piece.0).sum();
    let is_far = |&(volume, at): &(f64, DVec3)| {
        volume > SPLINTER_SHARE * whole && at.distance(centre) > APART * radius
    };
    let largest = pieces.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let at = if pieces.iter().any(is_far) {
        largest.1
    } else {
        centre
    };
    Some((at, radius))
}
