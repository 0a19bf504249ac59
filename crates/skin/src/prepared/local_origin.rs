//! The origin of a node near what is done to its mesh.

use glam::{DAffine3, DVec3};
use greenstick_geometry::Node;
use std::sync::Arc;

/// The bits of an `f32` that hold its exponent: those alone are the power of two that it is not less than.
const EXPONENT: u32 = 0x7f80_0000;

/// Moves the origin of a node to about `world` (m) without moving its mesh in the world: files hold positions in `f32`, which
/// lie the closer together the nearer they are to the origin. Positions of files about there stay positions of files.
pub fn move_origin(node: &mut Node, world: DVec3) {
    let at = node.transform.inverse().transform_point3(world);
    let farthest =
        (node.mesh.positions.iter()).fold(0.0, |most: f64, p| most.max(p.abs().max_element()));
    // A multiple of the widest spacing between positions: differences to it are multiples of their own spacings.
    let power = f32::from_bits((farthest as f32).to_bits() & EXPONENT);
    let spacing = f64::from(f32::EPSILON * power);
    if !(spacing.is_normal() && at.is_finite()) {
        return;
    }
    let origin = (at / spacing).round() * spacing;
    let mesh = Arc::make_mut(&mut node.mesh);
    for p in &mut mesh.positions {
        *p -= origin;
    }
    node.transform *= DAffine3::from_translation(origin);
}
